//! The reference camera that turns evenly under the stars, without an Earth, and the whole sensor in it.
//!
//! In: an axis of rotation by a seed, a rate. Out: the scene, or the sensor's reports with the true attitude.

use crate::error::HostError;
use crate::flight::{self, StarCalibration};
use crate::formats::camera_file::CameraFile;
use crate::harness::{ThisSecond, star_scene};
use crate::world::attitude::{Vector, uniform};
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::imaging::ImagingModel;
use crate::world::motion::Motion;
use crate::world::noise::{Noise, Stream};
use crate::world::scene::{Scene, SceneSettings, WorldStar};
use crate::world::sky::stars::DetectorModel;
use fsw_core::image::calibration::Calibration;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Workspace};
use fsw_core::telemetry::Report;
use fsw_hal::{Instant, LocalTime};

/// Hot pixels of the scene.
const HOT_PIXELS: u32 = 200;
/// Counter of the first second, us.
const POWERED_US: i64 = 10_000_000;

/// The stars as the moving Earth sees them.
pub fn sky() -> Vec<WorldStar> {
    star_scene::sky_in_flight([0.0; 3])
}

/// Where a seed begins, ICRS to sensor, and a direction of rotation across the line of sight.
fn drawn(seed: u64) -> ([f64; 4], Vector) {
    let noise = Noise::new(seed, 0, Stream::Attitude);
    let (sine, cosine) = libm::sincos(std::f64::consts::TAU * noise.uniform(1, 0));
    (uniform(&noise, 0), [cosine, sine, 0.0])
}

/// The scene of a seed, turning about an axis across its line of sight.
///
/// # Errors
/// Never for these settings.
pub fn scene(seed: u64, rate_deg_s: f64, sky: &[WorldStar]) -> Result<Scene, HostError> {
    let (quaternion, axis) = drawn(seed);
    let rate_rad_s = axis.map(|part| part * rate_deg_s.to_radians());
    let mut settings =
        SceneSettings::new(CameraFile::reference(), Motion::turning(quaternion, rate_rad_s), seed);
    settings.imaging = ImagingModel::REFERENCE;
    settings.detector = DetectorModel::reference();
    settings.disturbances = Disturbances { hot_pixels: HOT_PIXELS, ..Disturbances::default() };
    Scene::new(settings, sky).map_err(|error| HostError::usage(error.to_string(), "report this"))
}

/// The calibration of the camera.
///
/// # Errors
/// Never for the reference.
pub fn calibration() -> Result<Option<StarCalibration>, HostError> {
    flight::calibration(&CameraFile::reference(), &ImagingModel::REFERENCE, &DetectorModel::reference())
}

/// Flies the sensor in a scene for some seconds; `listen` gets each report with the true attitude of its
/// second.
///
/// # Errors
/// Never for the reference camera.
pub fn fly(
    scene: &mut Scene,
    exposure_us: u32,
    seconds: u32,
    mut listen: impl FnMut(&Report, [f64; 4]),
) -> Result<(), HostError> {
    let calibration = calibration()?;
    let calibration = calibration.as_ref().and_then(StarCalibration::open);
    let camera = flight::calibrated_camera(&CameraFile::reference());
    let mut parameters = Parameters::for_camera(flight::camera_parameters(&camera));
    parameters.imaging.exposure_us = exposure_us;
    parameters.imaging.calibration_crc = calibration.as_ref().map_or(0, Calibration::crc);
    let mut workspace = Box::new(Workspace::new());
    let catalogue = flight::open(catalog_gen::REFERENCE)?;
    let mut sensor = flight::sensor(catalogue, calibration, parameters, &mut workspace).map_err(|error| {
        HostError::usage(format!("the flight code refuses the reference ({error:?})"), "report this")
    })?;
    for second in 0..seconds {
        let local = LocalTime::from_us(POWERED_US + i64::from(second) * 1_000_000);
        let mut clock = Instant::new(local, star_scene::epoch_us() + i64::from(second) * 1_000_000);
        let mut detector = ThisSecond { scene, cycle: second.into(), instant: local };
        let report = flight::second(&mut sensor, &mut detector, &mut clock, Command::Continue);
        listen(&report, scene.settings().motion.at(second.into()));
    }
    Ok(())
}
