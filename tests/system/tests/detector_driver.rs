//! The flight code behind the driver of a real detector: the CMV4000 on a simulated bus, its light a rendered
//! sky, 1024 of its 2048 rows in use.

use embedded_hal::delay::DelayNs;
use fsw_core::modes::Mode;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Workspace};
use fsw_core::telemetry::{self, DetectorFault, Report};
use fsw_drivers::cmv4000::simulated::Simulated;
use fsw_drivers::cmv4000::{Cmv4000, Outputs, Parts, SIZE_PX, Settings};
use fsw_hal::{
    Clock, ClockError, Detector, DetectorError, DetectorGeometry, ErrorType, Instant, LocalTime, Window,
};
use sil_host::flight;
use sil_host::formats::camera_file::CameraFile;
use sil_host::harness::star_scene;
use sil_host::judge::attitude_error;
use sil_host::world::motion::Motion;
use sil_host::world::scene::{Scene, SceneSettings};
use std::cell::Cell;
use std::path::Path;

/// CLK_IN of the board, Hz.
const CLOCK_HZ: u32 = 10_000_000;
/// The rows that the optics light: first and number.
const ROWS: (u16, u16) = (512, 1024);
const SECONDS: u64 = 6;
/// ICRS to sensor: the equator in Ophiuchus.
const ATTITUDE: [f64; 4] = [0.560, -0.430, 0.353, 0.613];

/// 2048 x 1024 px with the reference camera's focal length.
fn camera() -> CameraFile {
    let focal_length_px = CameraFile::reference().focal_length_px;
    let geometry = DetectorGeometry { width_px: SIZE_PX, height_px: ROWS.1, bits: 10 };
    CameraFile::undistorted(geometry, focal_length_px)
}

fn scene() -> Scene {
    let norm = ATTITUDE.iter().map(|part| part * part).sum::<f64>().sqrt();
    let motion = Motion::fixed(ATTITUDE.map(|part| part / norm));
    Scene::new(SceneSettings::new(camera(), motion, 1), &star_scene::sky_in_flight([0.0; 3])).unwrap()
}

/// The whole pixel array: the scene in the rows that the optics light, dark around.
struct Lit {
    scene: Scene,
    second: u64,
    exposures_us: Vec<u32>,
}

impl ErrorType for Lit {
    type Error = DetectorError;
}

impl Detector for Lit {
    fn geometry(&self) -> DetectorGeometry {
        DetectorGeometry { height_px: SIZE_PX, ..self.scene.geometry() }
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.exposures_us.push(exposure_us);
        self.scene.expose_cycle(self.second, exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let (first, count) = ROWS;
        if (first..first + count).contains(&window.y) {
            return self.scene.read(Window { y: window.y - first, ..window }, pixels);
        }
        pixels.fill(0);
        Ok(())
    }
}

/// The board's counter.
#[derive(Clone, Copy)]
struct Counter<'c>(&'c Cell<i64>);

impl ErrorType for Counter<'_> {
    type Error = ClockError;
}

impl Clock for Counter<'_> {
    fn local_time(&mut self) -> Result<LocalTime, ClockError> {
        Ok(LocalTime::from_us(self.0.get()))
    }

    fn terrestrial_us(&mut self, _: LocalTime) -> Result<i64, ClockError> {
        Err(ClockError::NotSynchronised)
    }
}

struct NoDelay;

impl DelayNs for NoDelay {
    fn delay_ns(&mut self, _: u32) {}
}

/// The scene without a driver: lengths and middles of the exposures are told beforehand, us.
struct Direct {
    scene: Scene,
    second: u64,
    exposures_us: Vec<u32>,
    middles_us: Vec<i64>,
}

impl ErrorType for Direct {
    type Error = DetectorError;
}

impl Detector for Direct {
    fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        self.scene.expose_cycle(self.second, self.exposures_us[self.second as usize])
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(LocalTime::from_us(self.middles_us[self.second as usize]))
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.scene.read(window, pixels)
    }
}

/// Flies a detector; `before` each second.
fn fly<D: Detector>(detector: &mut D, mut before: impl FnMut(u64, &mut D)) -> Vec<Report> {
    let camera_parameters = flight::camera_parameters(&camera());
    let camera = flight::camera(&camera(), Path::new("cmv4000")).unwrap();
    let catalogue = flight::flight_catalogue(&camera, Path::new("cmv4000")).unwrap();
    let mut parameters = Parameters::for_camera(camera_parameters);
    parameters.imaging.exposure_us = star_scene::EXPOSURE_US;
    let mut workspace = Box::new(Workspace::new());
    let mut sensor = flight::sensor(catalogue, None, parameters, &mut workspace).unwrap();
    (0..SECONDS)
        .map(|second| {
            before(second, detector);
            let us = second as i64 * 1_000_000;
            let mut clock = Instant::new(LocalTime::from_us(us), star_scene::epoch_us() + us);
            flight::second(&mut sensor, detector, &mut clock, Command::Continue)
        })
        .collect()
}

fn frames(reports: &[Report]) -> Vec<Vec<u8>> {
    let mut buffer = [0; telemetry::MAX_FRAME_BYTES];
    reports.iter().map(|report| telemetry::encode(report, &mut buffer).unwrap().to_vec()).collect()
}

/// Flies behind the driver; `upset` may turn bits in the detector before a second.
fn fly_driver(upset: impl Fn(u64, &Simulated<Lit>)) -> (Vec<Report>, Vec<u32>) {
    let light = Lit { scene: scene(), second: 0, exposures_us: Vec::new() };
    let part = Simulated::new(light, CLOCK_HZ);
    let counter = Cell::new(0);
    let mut memory = vec![0; usize::from(SIZE_PX) * usize::from(ROWS.1)];
    let parts = Parts {
        spi: part.spi(),
        reset_n: part.reset_n(),
        frame_request: part.frame_request(),
        delay: NoDelay,
        clock: Counter(&counter),
        port: part.port(&mut memory),
    };
    let settings = Settings { clock_hz: CLOCK_HZ, outputs: Outputs::Four, rows: ROWS, analogue: &[] };
    let mut detector = Cmv4000::new(parts, settings).unwrap();
    let reports = fly(&mut detector, |second, _| {
        // The request comes half an exposure before the middle of the second.
        counter.set(second as i64 * 1_000_000 - i64::from(star_scene::EXPOSURE_US) / 2);
        part.with_source(|light| light.second = second);
        upset(second, &part);
    });
    (reports, part.with_source(|light| light.exposures_us.clone()))
}

#[test]
fn windows_read_through_the_driver_give_the_telemetry_of_the_light_itself() {
    let (reports, exposures_us) = fly_driver(|_, _| ());
    assert_eq!(exposures_us.len() as u64, SECONDS);
    assert!(exposures_us.iter().all(|us| us.abs_diff(star_scene::EXPOSURE_US) <= 7), "{exposures_us:?}");
    let middles_us: Vec<_> = reports.iter().map(|report| report.local_us).collect();
    for (second, us) in middles_us.iter().enumerate() {
        assert!((us - second as i64 * 1_000_000).abs() <= 4, "second {second}: {us}");
    }
    let mut direct = Direct { scene: scene(), second: 0, exposures_us, middles_us };
    let expected = fly(&mut direct, |second, direct| direct.second = second);
    assert_eq!(frames(&reports), frames(&expected));
    let last = reports.last().unwrap();
    assert_eq!(last.mode, Mode::Tracking);
    assert!(last.stars.len() >= 10, "{} stars", last.stars.len());
    let attitude = last.attitude.unwrap();
    let error = attitude_error(attitude.quaternion, scene().quaternion());
    for (error, sigma) in error.iter().zip(attitude.sigma_rad) {
        assert!(error.abs() < 5.0 * f64::from(sigma), "{error} rad, sigma {sigma}");
    }
}

#[test]
fn an_upset_in_the_detector_costs_the_images_of_one_second() {
    // The sequencer is told to wait for an exposure from outside.
    let (reports, _) = fly_driver(|second, part| {
        if second == 4 {
            part.upset(41, 1);
        }
    });
    let faults: Vec<_> = reports.iter().map(|report| report.faults.detector).collect();
    assert_eq!(faults[4], Some(DetectorFault::Hardware), "{faults:?}");
    assert!(faults.iter().enumerate().all(|(second, fault)| fault.is_none() || second == 4), "{faults:?}");
    assert!(reports[5].attitude.is_some_and(|attitude| attitude.age_s == 0), "{:?}", reports[5]);
}
