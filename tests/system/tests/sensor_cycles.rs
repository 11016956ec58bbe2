//! The sensor's second, whole: rendered sky in, reports out, with faults in between.

use fsw_core::modes::Mode;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Instruments, Sensor, Workspace};
use fsw_core::telemetry::{self, Fault, Report, Status};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use sil_host::camera_file::CameraFile;
use sil_host::judge::attitude_error;
use sil_host::world::attitude::uniform;
use sil_host::world::motion::Motion;
use sil_host::world::noise::{Noise, Stream};
use sil_host::world::scene::{Scene, SceneSettings};
use sil_host::{flight, star_scene};

/// Flies `seconds` seconds; `faults` may spoil a second before it begins.
fn fly<D: Detector>(
    detector: &mut D,
    seconds: u32,
    mut before: impl FnMut(u32, &mut D) -> Command,
    mut after: impl FnMut(&Report, &D),
) -> Vec<Report> {
    let catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
    let mut workspace = Box::new(Workspace::new());
    let mut sensor = Sensor::new(catalogue, star_scene::parameters(), &mut workspace).unwrap();
    (0..seconds)
        .map(|second| {
            let command = before(second, detector);
            let report = sensor.cycle(&mut Instruments { detector, meter: &mut () }, command);
            after(&report, detector);
            report
        })
        .collect()
}

fn quietly(scene: &mut Scene, seconds: u32) -> Vec<Report> {
    fly(scene, seconds, |_, _| Command::Continue, |_, _| {})
}

/// A detector that can be told to fail.
struct Faulty {
    scene: Scene,
    fault: Option<DetectorError>,
    covered: bool,
    geometry: Option<DetectorGeometry>,
}

impl Faulty {
    fn new() -> Self {
        Self { scene: star_scene::scene().unwrap(), fault: None, covered: false, geometry: None }
    }
}

impl Detector for Faulty {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry.unwrap_or(self.scene.geometry())
    }
    fn expose(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.scene.expose(exposure_us)
    }
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.scene.read(window, pixels)?;
        if self.covered {
            pixels.fill(30);
        }
        self.fault.map_or(Ok(()), Err)
    }
}

#[test]
fn two_identified_images_lead_to_tracking_and_the_rate_is_known() {
    let mut scene = star_scene::scene().unwrap();
    let reports = quietly(&mut scene, 4);
    let modes: Vec<Mode> = reports.iter().map(|report| report.mode).collect();
    assert_eq!(modes, [Mode::Acquisition, Mode::Acquisition, Mode::Tracking, Mode::Tracking]);
    assert!(reports[0].rate_rad_s.is_none());
    let truth = scene.rate_rad_s();
    for report in &reports[1..] {
        let rate = report.rate_rad_s.expect("two attitudes in a row");
        for (axis, limit_arcsec_s) in [(0, 10.0), (1, 10.0), (2, 60.0)] {
            let error = (f64::from(rate[axis]) - truth[axis]).to_degrees() * 3600.0;
            assert!(error.abs() < limit_arcsec_s, "axis {axis}: {error} arcsec/s");
        }
    }
}

#[test]
fn names_are_those_of_the_true_stars() {
    let mut scene = star_scene::scene().unwrap();
    let (mut right, mut blends) = (0, 0);
    let count = |report: &Report, scene: &Scene| {
        for star in &report.stars {
            let near = |seen: &&sil_host::world::scene::VisibleStar| {
                (seen.x_px - f64::from(star.centre_px[0])).hypot(seen.y_px - f64::from(star.centre_px[1]))
                    < 1.5
            };
            let truth: Vec<u32> = scene.visible_stars().iter().filter(near).map(|seen| seen.hip).collect();
            assert!(truth.contains(&star.hip), "HIP {} is not where it was reported", star.hip);
            right += 1;
            blends += usize::from(truth.len() > 1);
        }
    };
    fly(&mut scene, 10, |_, _| Command::Continue, count);
    println!("{right} names, {blends} of them blends");
    assert!(right > 200);
}

#[test]
fn sigmas_are_honest_on_random_skies() {
    // Normalised error squared over 40 skies, three axes: chi-square with 120 degrees of freedom. The reported sigma may
    // be cautious by a third, not optimistic: 95 % band of the ratio, widened on the cautious side.
    let noise = Noise::new(20_261_121, 0, Stream::Attitude);
    let sky = star_scene::sky();
    let (mut sum, mut count, mut unsolved) = (0.0, 0.0, 0);
    for index in 0..40 {
        let motion = Motion::fixed(uniform(&noise, index));
        let mut scene =
            Scene::new(SceneSettings::new(CameraFile::reference(), motion, u64::from(index)), &sky).unwrap();
        let reports = quietly(&mut scene, 1);
        let Some(attitude) = reports[0].attitude.as_ref() else {
            unsolved += 1;
            continue;
        };
        let error = attitude_error(attitude.quaternion, scene.quaternion());
        for (error, sigma) in error.iter().zip(attitude.sigma_rad) {
            let ratio = error / f64::from(sigma);
            assert!(ratio.abs() < 5.0, "sky {index}: {ratio:.1} sigma");
            sum += ratio * ratio;
            count += 1.0;
        }
    }
    println!("{unsolved} of 40 skies unsolved; mean squared error over sigma squared {:.2}", sum / count);
    assert_eq!(unsolved, 0);
    assert!((0.45..1.27).contains(&(sum / count)));
}

#[test]
fn equal_flights_give_equal_telemetry() {
    let stream = || {
        let mut bytes = Vec::new();
        let mut buffer = [0; telemetry::MAX_FRAME_BYTES];
        for report in quietly(&mut star_scene::scene().unwrap(), 5) {
            bytes.extend_from_slice(telemetry::encode_next(&report, &mut buffer).unwrap());
        }
        bytes
    };
    assert!(stream() == stream());
}

#[test]
fn a_covered_sky_is_lost_then_reacquired_by_itself() {
    let before = |second: u32, detector: &mut Faulty| {
        detector.covered = (5..12).contains(&second);
        Command::Continue
    };
    let reports = fly(&mut Faulty::new(), 16, before, |_, _| {});
    assert_eq!(reports[4].status, Status::Tracked);
    assert!(
        reports[5..12].iter().all(|report| report.attitude.is_none()),
        "nothing is claimed of a dark image"
    );
    assert_eq!(reports[7].mode, Mode::Tracking);
    assert_eq!(reports[8].mode, Mode::Acquisition, "after three seconds without an attitude");
    assert_eq!(reports[12].status, Status::Identified);
    assert_eq!(reports[15].status, Status::Tracked);
}

#[test]
fn a_short_outage_is_bridged_by_the_last_rate() {
    let before = |second: u32, detector: &mut Faulty| {
        detector.covered = (6..8).contains(&second);
        Command::Continue
    };
    let reports = fly(&mut Faulty::new(), 10, before, |_, _| {});
    assert!(reports[6].attitude.is_none() && reports[7].attitude.is_none());
    assert_eq!((reports[8].mode, reports[8].status), (Mode::Tracking, Status::Tracked));
}

#[test]
fn a_failing_detector_is_reported_and_survived() {
    for (error, fault) in [
        (DetectorError::Bus, Fault::Hardware),
        (DetectorError::Timeout, Fault::Hardware),
        (DetectorError::OutsideDetector, Fault::Request),
    ] {
        let before = |second: u32, detector: &mut Faulty| {
            detector.fault = [0, 4].contains(&second).then_some(error);
            Command::Continue
        };
        let reports = fly(&mut Faulty::new(), 7, before, |_, _| {});
        for second in [0, 4] {
            assert_eq!(reports[second].status, Status::DetectorFault(fault));
            assert!(reports[second].attitude.is_none());
        }
        assert_eq!(reports[1].status, Status::Identified);
        assert_eq!(reports[5].status, Status::Tracked);
    }
}

#[test]
fn a_detector_of_another_size_is_refused_every_second() {
    let mut detector = Faulty::new();
    detector.geometry = Some(DetectorGeometry { width_px: 640, ..detector.scene.geometry() });
    let reports = fly(&mut detector, 3, |_, _| Command::Continue, |_, _| {});
    assert!(reports.iter().all(|report| report.status == Status::DetectorFault(Fault::Geometry)));
}

#[test]
fn a_command_to_reacquire_is_obeyed_at_once() {
    let before =
        |second: u32, _: &mut Scene| if second == 4 { Command::Reacquire } else { Command::Continue };
    let reports = fly(&mut star_scene::scene().unwrap(), 7, before, |_, _| {});
    assert_eq!(reports[3].mode, Mode::Tracking);
    assert_eq!((reports[4].mode, reports[4].status), (Mode::Acquisition, Status::Identified));
    assert_eq!(reports[6].mode, Mode::Tracking);
}

#[test]
fn a_search_longer_than_a_second_goes_on_with_the_same_image() {
    let catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
    let mut workspace = Box::new(Workspace::new());
    // Noise alone: no side is ever confirmed, and the work of a second is a small part of the search.
    let parameters = Parameters { pairs_per_cycle: 10_000, ..star_scene::parameters() };
    let mut scene = star_scene::scene().unwrap();
    let mut settings = scene.settings().clone();
    settings.disturbances.false_stars = 60;
    settings.disturbances.false_star_v = (2.0, 4.0);
    scene = Scene::new(settings, &[]).unwrap();
    let mut sensor = Sensor::new(catalogue, parameters, &mut workspace).unwrap();
    let mut cycles = Vec::new();
    for _ in 0..60 {
        let report =
            sensor.cycle(&mut Instruments { detector: &mut scene, meter: &mut () }, Command::Continue);
        assert!(report.attitude.is_none());
        cycles.push(scene.cycle());
        if matches!(report.status, Status::NotIdentified(_)) {
            break;
        }
        assert_eq!(report.status, Status::Searching);
    }
    assert!(cycles.len() > 2, "the search took {} seconds", cycles.len());
    assert!(cycles.iter().all(|cycle| *cycle == cycles[0]), "one image was taken for the whole search");
}
