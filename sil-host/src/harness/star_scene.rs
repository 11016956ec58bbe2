//! The star path alone: the reference camera turning under a rendered sky, without an Earth.
//!
//! What benchmarks, and tests of the star path, look at.

use crate::error::HostError;
use crate::flight;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{Vector, dot, normalised};
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::protons::Protons;
use crate::world::motion::Motion;
use crate::world::scene::{Scene, SceneSettings, WorldStar};
use crate::world::sky::in_year;
use crate::world::time::ephemeris;
use catalog_gen::parameters::DEFAULT_EPOCH_YEAR;
use fsw_core::parameters::Parameters;

/// Exposure time: long enough for V = 6 on this aperture, µs.
pub const EXPOSURE_US: u32 = 400_000;
/// Attitude at the start: the equator in Ophiuchus.
const START: [f64; 4] = [0.560, -0.430, 0.353, 0.613];
/// Rate in sensor axes, rad/s: 70 arcsec/s, a low orbit's pointing at the Earth.
const RATE_RAD_S: [f64; 3] = [3.0e-4, 1.5e-4, -0.5e-4];
const SEED: u64 = 1;

/// Every star of the embedded source as the world sees it, at the catalogue's epoch.
pub fn sky() -> Vec<WorldStar> {
    in_year(DEFAULT_EPOCH_YEAR)
}

/// An instant in the year of that sky: Terrestrial Time, microseconds since J2000.0.
pub fn epoch_us() -> i64 {
    ((DEFAULT_EPOCH_YEAR - 2000.0) * 365.25 * 86_400e6) as i64
}

/// The same sky as it is seen then in flight with this velocity about the Earth, km/s, ICRS axes.
pub fn sky_in_flight(about_earth_km_s: Vector) -> Vec<WorldStar> {
    let about_sun = ephemeris::earth_velocity_km_s(epoch_us());
    let mut sky = sky();
    for star in &mut sky {
        for axis in 0..3 {
            star.direction[axis] += (about_sun[axis] + about_earth_km_s[axis]) / ephemeris::LIGHT_KM_S;
        }
        let norm = dot(star.direction, star.direction).sqrt();
        star.direction = star.direction.map(|part| part / norm);
    }
    sky
}

/// The reference camera over the sky, with some hot pixels, protons and false stars.
///
/// # Errors
/// Never for these settings.
pub fn scene() -> Result<Scene, HostError> {
    let quaternion = normalised(START).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let mut settings =
        SceneSettings::new(CameraFile::reference(), Motion::turning(quaternion, RATE_RAD_S), SEED);
    settings.disturbances = Disturbances {
        false_stars: 5,
        hot_pixels: 200,
        protons: Protons::Fixed(20),
        ..Disturbances::default()
    };
    Scene::new(settings, &sky()).map_err(|error| HostError::usage(error.to_string(), "report this"))
}

/// The flight parameters for it.
pub fn parameters() -> Parameters {
    let camera = flight::camera_parameters(&CameraFile::reference());
    let mut parameters = Parameters::for_camera(camera);
    parameters.imaging.exposure_us = EXPOSURE_US;
    parameters
}
