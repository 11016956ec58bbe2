//! A rate sensor carries the attitude through a manoeuvre in which no star is seen.

use fsw_core::attitude::filter::RateSensorNoise;
use fsw_core::frames::{Icrs, Rotation, StarPath};
use fsw_core::modes::Mode;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Instruments, Workspace};
use fsw_core::telemetry::{Event, Outcome, ReadingFault, Report};
use fsw_hal::{
    AngularRate, Detector, DetectorError, DetectorGeometry, Instant, LocalTime, RateSensor, ReadingError,
    Window,
};
use sil_host::flight;
use sil_host::formats::camera_file::CameraFile;
use sil_host::harness::star_scene;
use sil_host::judge::{arcsec, attitude_error};
use sil_host::world::attitude::{normalised, uniform};
use sil_host::world::motion::Motion;
use sil_host::world::noise::{Noise, Stream};
use sil_host::world::scene::{Scene, SceneSettings};

/// Seconds flown, those in which something bright hides all stars, and those of them in which the body turns.
const SECONDS: u32 = 150;
const BLIND: std::ops::Range<u32> = 60..120;
const SLEW: std::ops::Range<u32> = 80..100;
/// How fast it turns then, rad/s: 0.3 deg/s about an axis across the line of sight, 0.2 about the line of
/// sight.
const SLEW_RAD_S: [f64; 3] = [5.2e-3, 0.0, 3.5e-3];
/// A fibre-optic gyro: 2 arcsec in a second, a bias of 0.01 deg/s that walks by 0.02 arcsec/s in a second.
const NOISE: RateSensorNoise = RateSensorNoise { white_rad: 1e-5, walk_rad_s: 1e-7, bias_rad_s: 1.75e-4 };
const BIAS_RAD_S: [f64; 3] = [1.5e-4, -2.0e-4, 0.7e-4];

/// A detector whose every pixel is full where something blinds it.
struct Sky {
    scene: Scene,
    second: u32,
}

impl fsw_hal::ErrorType for Sky {
    type Error = DetectorError;
}

impl Detector for Sky {
    fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }
    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.scene.expose_cycle(self.second.into(), exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        self.scene.finish_exposure()
    }
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.scene.read(window, pixels)?;
        if BLIND.contains(&self.second) {
            pixels.fill(self.geometry().full_scale());
        }
        Ok(())
    }
}

/// The gyro in a second.
struct Gyro {
    reading: Result<Option<AngularRate>, ReadingError>,
}

impl fsw_hal::ErrorType for Gyro {
    type Error = ReadingError;
}

impl RateSensor for Gyro {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, ReadingError> {
        self.reading
    }
}

/// Rate in the second before this one, rad/s.
fn rate_rad_s(second: u32) -> [f64; 3] {
    if SLEW.contains(&second) { SLEW_RAD_S } else { [0.0; 3] }
}

/// A sky that rests in this attitude.
fn resting(attitude: &Rotation<Icrs, StarPath>) -> Scene {
    let quaternion = normalised(attitude.quaternion().map(f64::from)).unwrap();
    let settings = SceneSettings::new(CameraFile::reference(), Motion::turning(quaternion, [0.0; 3]), 3);
    Scene::new(settings, &star_scene::sky_in_flight([0.0; 3])).unwrap()
}

/// What was seen of a second.
struct Second {
    report: Report,
    /// Largest error of the attitude reported, sigmas, and about x and y, arcsec.
    error: Option<(f64, f64)>,
}

/// Flies the manoeuvre; `answers` says what the gyro does in a second, if there is one.
fn fly(
    rate_sensor: Option<RateSensorNoise>,
    answers: impl Fn(u32, AngularRate) -> Option<Result<Option<AngularRate>, ReadingError>>,
) -> Vec<Second> {
    let noise = Noise::new(0x47_59_52_4f, 0, Stream::RateSensor);
    let start = uniform(&Noise::new(77, 0, Stream::Attitude), 0).map(|part| part as f32);
    let mut attitude = Rotation::<Icrs, StarPath>::from_quaternion(start).unwrap();
    let mut sky = Sky { scene: resting(&attitude), second: 0 };
    let parameters = Parameters { rate_sensor, ..star_scene::parameters() };
    let catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
    let mut workspace = Box::new(Workspace::new());
    let mut sensor = flight::sensor(catalogue, None, parameters, &mut workspace).unwrap();
    let mut seconds = Vec::new();
    for second in 0..SECONDS {
        let rate = rate_rad_s(second);
        if rate != [0.0; 3] {
            attitude = attitude.turned(&rate.map(|axis| axis as f32).into());
            sky.scene = resting(&attitude);
        }
        sky.second = second;
        let local = LocalTime::from_us(i64::from(second) * 1_000_000);
        let white = [0, 1, 2].map(|axis| f64::from(NOISE.white_rad) * noise.gaussian(second, axis));
        let rad_s = [0, 1, 2].map(|axis| (rate[axis] + BIAS_RAD_S[axis] + white[axis]) as f32);
        let reading = AngularRate { instant: local.plus_us(-500_000), rad_s };
        // One that is not on board answers as a silent one does.
        let mut gyro = Gyro { reading: answers(second, reading).unwrap_or(Ok(None)) };
        let mut instruments = Instruments {
            detector: &mut sky,
            clock: &mut Instant::new(local, star_scene::epoch_us() + local.as_us()),
            meter: &mut (),
            rate_sensor: &mut gyro,
            magnetometer: &mut (),
            shutter: &mut (),
        };
        let report = sensor.cycle(&mut instruments, Command::Continue);
        let truth = attitude.quaternion().map(f64::from);
        let error = report.attitude.as_ref().map(|attitude| {
            let error = attitude_error(attitude.quaternion, truth);
            let sigmas = (0..3).map(|axis| (error[axis] / f64::from(attitude.sigma_rad[axis])).abs());
            (sigmas.fold(0.0, f64::max), arcsec(error[0].hypot(error[1])))
        });
        seconds.push(Second { report, error });
    }
    seconds
}

/// Greatest error of some seconds, sigmas and arcsec, and how many had an attitude.
fn worst(seconds: &[Second]) -> (f64, f64, usize) {
    let errors = seconds.iter().filter_map(|second| second.error);
    errors.fold((0.0, 0.0, 0), |(sigmas, arcsec, count), error| {
        (error.0.max(sigmas), error.1.max(arcsec), count + 1)
    })
}

#[test]
fn the_attitude_goes_on_through_a_blind_slew_and_tracking_after_it() {
    let seconds = fly(Some(NOISE), |_, reading| Some(Ok(Some(reading))));
    let (sigmas, arcsec, count) = worst(&seconds[BLIND.start as usize..BLIND.end as usize]);
    println!(
        "blind for {} s: attitude in {count}, off by {arcsec:.1} arcsec, {sigmas:.2} sigma at most",
        BLIND.len()
    );
    // Of 180 angles one lies beyond 4 sigma in 90 runs of an honest filter.
    assert!(count == BLIND.len() && sigmas < 4.0 && arcsec < 60.0);
    let after = &seconds[BLIND.end as usize + 2..];
    assert!(after.iter().all(|second| second.report.mode == Mode::Tracking), "it acquired anew");
    let (sigmas, arcsec, count) = worst(after);
    assert!(count == after.len() && sigmas < 4.0 && arcsec < 20.0, "{sigmas} {arcsec}");
}

#[test]
fn without_a_rate_sensor_the_slew_is_found_out_when_stars_are_seen_again() {
    let seconds = fly(None, |_, reading| Some(Ok(Some(reading))));
    // Nobody can know; but no star stands where it was expected, and the sky is searched.
    let after = &seconds[BLIND.end as usize..];
    let first = after.iter().find(|second| second.error.is_some()).unwrap();
    assert!(first.report.outcome == Some(Outcome::Identified) && first.error.unwrap().0 < 4.0);
}

#[test]
fn a_silent_or_mad_rate_sensor_is_none() {
    let mad = |second: u32, reading: AngularRate| match second % 40 {
        10..14 => Ok(None),
        14..18 => Err(ReadingError::Bus),
        18..22 => Ok(Some(AngularRate { rad_s: [f32::NAN; 3], ..reading })),
        22..26 => Ok(Some(AngularRate { instant: reading.instant.plus_us(-5_000_000), ..reading })),
        26..30 => Ok(Some(AngularRate { instant: LocalTime::from_us(i64::MIN), ..reading })),
        _ => Ok(Some(reading)),
    };
    let seconds = fly(Some(NOISE), |second, reading| Some(mad(second, reading)));
    let before = &seconds[3..BLIND.start as usize];
    assert!(before.iter().all(|second| second.report.mode == Mode::Tracking));
    let (sigmas, arcsec, count) = worst(before);
    println!("silent now and then: {arcsec:.1} arcsec, {sigmas:.2} sigma at most");
    assert!(count == before.len() && sigmas < 4.5);
    let gone = fly(Some(NOISE), |_, _| None);
    assert!(gone[3..BLIND.start as usize].iter().all(|second| second.report.mode == Mode::Tracking));
}

/// Seconds without an attitude of those given.
fn without_attitude(seconds: &[Second]) -> usize {
    seconds.iter().filter(|second| second.error.is_none()).count()
}

#[test]
fn a_gyro_that_lies_is_shut_out_and_costs_a_few_seconds() {
    for lie_rad_s in [2e-3, 0.02, -0.1] {
        let lying = |second, mut reading: AngularRate| {
            if second >= 20 {
                reading.rad_s = reading.rad_s.map(|axis| axis + lie_rad_s);
            }
            Some(Ok(Some(reading)))
        };
        let seconds = fly(Some(NOISE), lying);
        let shut_out = |second: &Second| second.report.events.contains(&Event::RateSensorShutOut);
        let when = seconds.iter().position(shut_out).expect("it is shut out");
        println!(
            "{lie_rad_s} rad/s: shut out in second {when}, {} s lost",
            without_attitude(&seconds[20..60])
        );
        assert!((20..40).contains(&when) && seconds.iter().filter(|second| shut_out(second)).count() == 1);
        let told = |second: &Second| second.report.faults.rate_sensor == Some(ReadingFault::ShutOut);
        assert!(seconds[when + 1..].iter().all(told) && !seconds[..=when].iter().any(told));
        // Before the blind slew, of which nobody can know then.
        let (sigmas, ..) = worst(&seconds[..BLIND.start as usize]);
        assert!(sigmas < 6.0, "{sigmas}");
        assert!(without_attitude(&seconds[20..60]) <= 10);
    }
}
