//! The instruments beside the camera: gyro and magnetometer, and the field that the latter feels.

pub mod geomagnetism;
pub mod gyro;
pub mod magnetometer;

/// `value` to whole steps of `resolution`; as it is where there are none.
fn rounded(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { libm::rint(value / resolution) * resolution } else { value }
}
