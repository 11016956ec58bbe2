//! Corrections of position and velocity along the arc of the orbit.
//!
//! A satellite 200 km ahead on a low orbit is 3 km below the tangent, and its velocity is turned by 0.03 rad. The
//! orbit's covariance after its first arc is as long as that and a kilometre thick: a correction along the
//! tangent leaves it, and the filter believes what it then sees. So a correction is height and arc: it moves
//! the state along the arc, and turns velocity and covariance with it. Below [`MIN_ARC_RAD`] the plain
//! Cartesian correction is used.

use crate::matrix::{add_scaled, add_to_diagonal, cross_matrix, dot, plus_scaled, product, scaled};
use crate::trigonometry::sine_cosine_f64;
use nalgebra::{Matrix3, Vector3};

/// Shorter arcs are treated as straight, rad: 4 cm of height in LEO.
const MIN_ARC_RAD: f64 = 1e-4;

/// Longest arc that is treated as curved, rad: 60 deg.
const MAX_ARC_RAD: f64 = core::f64::consts::FRAC_PI_3;

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
