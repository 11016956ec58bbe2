//! What the board's instrument is: lens, detector, gyro, magnetometer, and the catalogue that serves its field.

use fsw_core::attitude::filter::RateSensorNoise;
use fsw_core::camera::{CameraParameters, Distortion, Projection};
use fsw_core::magnetism::MagnetometerErrors;
use fsw_core::parameters::Parameters;
use fsw_drivers::cmv4000::SIZE_PX;

/// The onboard catalogue, built and checked by `catalog-gen`.
pub static CATALOGUE: &[u8] = include_bytes!("../../../catalog-gen/data/reference.cat");
/// Rows that the optics light: first and number.
pub const ROWS: (u16, u16) = (512, 1024);
/// Focal length: 24 deg over 2048 px, the field of the reference catalogue.
const FOCAL_LENGTH_PX: f32 = 4817.0;
/// White noise of 2.8 mdeg/s/sqrt(Hz), a bias of 1 deg/s and a guess of its walk: a board has what was
/// measured on its own part.
const GYRO: RateSensorNoise = RateSensorNoise { white_rad: 5e-5, walk_rad_s: 1e-6, bias_rad_s: 1.75e-2 };
/// Noise of 0.3 uT and a zero of 6 uT by the part's data sheet; the spacecraft's own field comes to that.
const MAGNETOMETER: MagnetometerErrors =
    MagnetometerErrors { noise_ut: 0.3, zero_ut: 10.0, walk_ut: 2.5e-3, field_ut: 0.15 };

/// The parameter table.
pub fn parameters() -> Parameters {
    let (width_px, height_px) = (SIZE_PX, ROWS.1);
    let optical_centre_px = [width_px, height_px].map(|side| 0.5 * (f32::from(side) - 1.0));
    let defaults = Parameters::for_camera(CameraParameters {
        width_px,
        height_px,
        focal_length_px: FOCAL_LENGTH_PX,
        optical_centre_px,
        projection: Projection::Rectilinear,
        distortion: Distortion::default(),
        corner_loss: 0.15,
        mirrored: false,
    });
    Parameters { rate_sensor: Some(GYRO), magnetometer: Some(MAGNETOMETER), ..defaults }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::catalog::Catalogue;
    use fsw_core::sensor::{Sensor, Workspace};

    #[test]
    fn the_sensor_takes_the_parameters_and_the_catalogue() {
        let catalogue = Catalogue::open(CATALOGUE).expect("sound");
        let mut workspace = Box::new(Workspace::new());
        let sensor = Sensor::new(catalogue, parameters(), &mut workspace).expect("accepted");
        assert_eq!(sensor.parameters().rate_sensor, Some(GYRO));
    }
}
