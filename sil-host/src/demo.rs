//! What `sil-host` does without a subcommand: a minute of the reference camera over a rendered sky.
//!
//! The synthetic world renders frames, the flight code's [`Sensor::cycle`] acquires and then tracks through the
//! detector trait, and truth stands beside the estimate. Ends with status 1 when the sensor did not keep its limits.

use crate::bound;
use crate::camera_file::CameraFile;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::flight;
use crate::judge::{Errors, attitude_error};
use crate::world::disturbances::Disturbances;
use crate::world::motion::Motion;
use crate::world::scene::{Scene, SceneSettings, VisibleStar, WorldStar};
use catalog_gen::parameters::DEFAULT_EPOCH_YEAR;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Instruments, Sensor, Workspace};
use fsw_core::telemetry::{Report, Status};
use fsw_hal::Instant;
use std::process::ExitCode;

/// Seconds flown.
const SECONDS: u32 = 60;
/// Exposure time: long enough for V = 6 on this aperture, µs.
pub const EXPOSURE_US: u32 = 400_000;
/// Attitude at the start: the equator in Ophiuchus.
const START: [f64; 4] = [0.560, -0.430, 0.353, 0.613];
/// Rate in sensor axes, rad/s: 70 arcsec/s, a low orbit's pointing at the Earth.
const RATE_RAD_S: [f64; 3] = [3.0e-4, 1.5e-4, -0.5e-4];
const SEED: u64 = 1;

/// Every star of the embedded source as the world sees it, at the catalogue's epoch.
pub fn sky() -> Vec<WorldStar> {
    let stars = catalog_gen::source::stars();
    let star = |star: &catalog_gen::SourceStar| WorldStar {
        hip: star.hip,
        direction: star.direction_at(DEFAULT_EPOCH_YEAR),
        v: star.v,
    };
    stars.iter().map(star).collect()
}

/// The reference camera over the sky, with some hot pixels, protons and false stars.
///
/// # Errors
/// Never for these settings.
pub fn scene() -> Result<Scene, HostError> {
    let quaternion = crate::world::attitude::normalised(START).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let mut settings =
        SceneSettings::new(CameraFile::reference(), Motion::turning(quaternion, RATE_RAD_S), SEED);
    settings.disturbances =
        Disturbances { false_stars: 5, hot_pixels: 200, proton_hits: 20, ..Disturbances::default() };
    Scene::new(settings, &sky()).map_err(|error| HostError::usage(error.to_string(), "report this"))
}

/// The flight parameters of the demonstration.
pub fn parameters() -> Parameters {
    let camera = flight::camera_parameters(&CameraFile::reference());
    Parameters { exposure_us: EXPOSURE_US, ..Parameters::for_camera(camera) }
}

/// What came of a second, in a word.
fn status_word(status: Status) -> &'static str {
    match status {
        Status::Identified => "identified",
        Status::Searching => "searching",
        Status::NotIdentified(_) => "not identified",
        Status::Tracked => "tracked",
        Status::Lost => "lost",
        Status::Blinded => "blinded",
        Status::Proved => "proved",
        Status::Waiting => "waiting",
        Status::DetectorFault(_) => "detector fault",
    }
}

/// Flies the minute and prints truth against estimate.
///
/// # Errors
/// Never for the embedded settings.
pub fn run() -> Result<ExitCode, HostError> {
    let mut scene = scene()?;
    let catalogue = flight::open(catalog_gen::REFERENCE)?;
    let mut workspace = Box::new(Workspace::new());
    let mut sensor = Sensor::new(catalogue, parameters(), &mut workspace).map_err(|error| {
        HostError::usage(format!("the flight code refuses its parameters ({error:?})"), "report this")
    })?;
    println!("Reference camera (24.1 x 19.4 deg), rate 70 arcsec/s, stars to V 8, {SECONDS} s.");
    println!("Errors are estimate less truth about x, y (across) and z (along the line of sight), arcsec.");
    println!();
    println!(
        "  s  mode         status        stars  true RA    Dec    error x     y      z   sigma x     y      z"
    );
    let mut errors = Errors::default();
    for second in 0..SECONDS {
        let report = sensor.cycle(
            &mut Instruments {
                detector: &mut scene,
                clock: &mut Instant(i64::from(second) * 1_000_000),
                meter: &mut (),
            },
            Command::Continue,
        );
        let truth = scene.quaternion();
        let found = report
            .attitude
            .as_ref()
            .map(|attitude| (attitude_error(attitude.quaternion, truth), attitude.sigma_rad));
        if let Some((error_rad, sigma_rad)) = found {
            let used = stars_used(&report, &scene);
            let bound_rad = bound::attitude_rad(&scene, &used, EXPOSURE_US).unwrap_or_default();
            errors.add(second, error_rad, sigma_rad.map(f64::from), bound_rad);
        }
        if second < 5 || second % 10 == 9 {
            print_row(&report, truth, found);
        }
    }
    println!();
    let kept = errors.print(SECONDS);
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

/// The true stars behind the names of a report.
fn stars_used(report: &Report, scene: &Scene) -> Vec<VisibleStar> {
    let named = |seen: &&VisibleStar| report.stars.iter().any(|star| star.hip == seen.hip);
    scene.visible_stars().iter().filter(named).copied().collect()
}

/// A row of the table.
fn print_row(report: &Report, truth: [f64; 4], found: Option<([f64; 3], [f32; 3])>) {
    let [x, y, z] = crate::world::attitude::matrix(truth)[2];
    let (ra, dec) = (y.atan2(x).to_degrees().rem_euclid(360.0), z.asin().to_degrees());
    print!(
        "{:3}  {:11}  {:13} {:5} {ra:8.3} {dec:+7.3}",
        report.cycle,
        format!("{:?}", report.mode).to_lowercase(),
        status_word(report.status),
        report.stars.len()
    );
    match found {
        Some((error_rad, sigma_rad)) => {
            let [ex, ey, ez] = error_rad.map(crate::judge::arcsec);
            let [sx, sy, sz] = sigma_rad.map(|sigma| crate::judge::arcsec(sigma.into()));
            println!("  {ex:+7.2} {ey:+6.2} {ez:+6.1}   {sx:7.2} {sy:5.2} {sz:6.1}");
        }
        None => println!("        -      -      -         -     -      -"),
    }
}
