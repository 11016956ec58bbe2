//! Position differences in curvilinear coordinates: height and arc.
//!
//! A satellite 300 km ahead on a low orbit is 6 km below the tangent. With Cartesian differences the Kalman
//! filter would treat these 6 km, after a long outage, as a height error, although the height is known to
//! metres. So a position difference is expressed as height and arc from the predicted position, and a
//! correction moves the state along the arc and rotates velocity and covariance with it. Below
//! [`MIN_ARC_RAD`] the plain Cartesian correction is used.

use crate::matrix::{add_scaled, add_to_diagonal, cross_matrix, dot, plus_scaled, product, scaled};
use crate::trigonometry::sine_cosine_f64;
use nalgebra::{Matrix3, Vector3};

/// Shorter arcs are treated as straight, rad: 4 cm of height in LEO.
const MIN_ARC_RAD: f64 = 1e-4;

/// Longest arc that is treated as curved, rad: 60 deg.
const MAX_ARC_RAD: f64 = core::f64::consts::FRAC_PI_3;

/// Difference of two positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurvilinearDifference {
    /// Height and arc between them, km, as a vector at the first.
    pub(super) difference_km: Vector3<f64>,
    /// The rotation that brings the first one's direction to the other's.
    pub(super) rotation: Matrix3<f64>,
    /// Distance of the other from the Earth's centre over that of the first.
    pub(super) scale: f64,
}

impl CurvilinearDifference {
    /// `None` beyond 60 degrees, and when a position is zero or not finite.
    #[inline(never)]
    pub(super) fn between(first: &Vector3<f64>, other: &Vector3<f64>) -> Option<Self> {
        let (near, far) = (libm::sqrt(dot(first, first)), libm::sqrt(dot(other, other)));
        let (u, d) = (scaled(first, 1.0 / near), scaled(other, 1.0 / far));
        let cosine = dot(&u, &d);
        // NaN is refused too.
        if !(near > 0.0 && far > 0.0 && cosine > 0.5) {
            return None;
        }
        let axis = product(&cross_matrix(&u), &d);
        let sine = libm::sqrt(dot(&axis, &axis));
        let stretch = if sine < MIN_ARC_RAD { 1.0 } else { libm::atan2(sine, cosine) / sine };
        let arc = scaled(&plus_scaled(&d, -cosine, &u), stretch * near);
        Some(Self {
            difference_km: plus_scaled(&arc, far - near, &u),
            rotation: rotation(&axis, cosine),
            scale: far / near,
        })
    }
}

/// Moves position and velocity by a correction, along the arc, and gives the rotation that the covariance
/// makes with them; `None` where the arc is shorter than [`MIN_ARC_RAD`] or longer than [`MAX_ARC_RAD`]:
/// then the correction is added in Cartesian coordinates.
#[inline(never)]
pub(super) fn correct_state(
    position_km: &mut Vector3<f64>,
    velocity_km_s: &mut Vector3<f64>,
    by_km: &Vector3<f64>,
    by_km_s: &Vector3<f64>,
) -> Option<Matrix3<f64>> {
    let distance = libm::sqrt(dot(position_km, position_km));
    let u = scaled(position_km, 1.0 / distance);
    let height = dot(&u, by_km);
    let across = scaled(&plus_scaled(by_km, -height, &u), 1.0 / distance);
    let angle = libm::sqrt(dot(&across, &across));
    // NaN counts as straight.
    let bends = angle > MIN_ARC_RAD && angle < MAX_ARC_RAD;
    if !bends {
        add_scaled(position_km, 1.0, by_km);
        add_scaled(velocity_km_s, 1.0, by_km_s);
        return None;
    }
    let (sine, cosine) = sine_cosine_f64(angle);
    let turn = product(&cross_matrix(&u), &across);
    let rotation = rotation(&scaled(&turn, sine / angle), cosine);
    // The velocity correction refers to inertial axes: subtract the change by the rotation.
    let turned = product(&cross_matrix(&turn), velocity_km_s);
    add_scaled(velocity_km_s, 1.0, by_km_s);
    add_scaled(velocity_km_s, -1.0, &turned);
    *velocity_km_s = product(&rotation, velocity_km_s);
    *position_km = scaled(&product(&rotation, &u), distance + height);
    Some(rotation)
}

/// The rotation about an axis whose length is the sine.
#[inline(never)]
fn rotation(axis: &Vector3<f64>, cosine: f64) -> Matrix3<f64> {
    let cross = cross_matrix(axis);
    let mut rotation = scaled(&product(&cross, &cross), 1.0 / (1.0 + cosine));
    add_scaled(&mut rotation, 1.0, &cross);
    add_to_diagonal(&mut rotation, 1.0);
    rotation
}

#[cfg(test)]
mod tests;
