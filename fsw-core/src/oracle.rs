//! What the tests hold the flight code against: the mathematics of the ground floor's oracle, and a camera
//! written apart from the flight code.

use crate::camera::{CameraParameters, Distortion, Projection};
pub use mathematics::*;
use nalgebra::Vector3;

#[path = "../ground/src/oracle.rs"]
mod mathematics;

/// Where a direction falls (thesis eq. 3.2 and Brown's model), from angles rather than components.
pub fn project(camera: &CameraParameters, direction: &Vector3<f64>) -> [f64; 2] {
    let off_axis = direction.x.hypot(direction.y).atan2(direction.z);
    let azimuth = direction.y.atan2(direction.x);
    let radius = match camera.projection {
        Projection::Rectilinear => off_axis.tan(),
        Projection::Equiangular => off_axis,
    };
    let (x, y) = (radius * azimuth.cos(), radius * azimuth.sin());
    let Distortion { k1, k2, k3, p1, p2 } = camera.distortion;
    let [k1, k2, k3, p1, p2] = [k1, k2, k3, p1, p2].map(f64::from);
    let radial = 1.0 + k1 * radius.powi(2) + k2 * radius.powi(4) + k3 * radius.powi(6);
    let seen_x = x * radial + 2.0 * p1 * x * y + p2 * (radius * radius + 2.0 * x * x);
    let seen_y = y * radial + p1 * (radius * radius + 2.0 * y * y) + 2.0 * p2 * x * y;
    let [cx, cy] = camera.optical_centre_px.map(f64::from);
    let f = f64::from(camera.focal_length_px);
    [cx + f * seen_x, cy + f * seen_y]
}

/// The reference camera without distortion.
pub fn reference_camera() -> CameraParameters {
    CameraParameters {
        width_px: 1280,
        height_px: 1024,
        focal_length_px: 3000.0,
        optical_centre_px: [639.5, 511.5],
        projection: Projection::Rectilinear,
        distortion: Distortion::default(),
        corner_loss: 0.15,
        mirrored: false,
    }
}
