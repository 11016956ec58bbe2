//! Differences of position that bend with the orbit.
//!
//! A satellite that is farther along its orbit by 300 km stands 6 km below the tangent. What one fix after a long outage
//! says of so long a difference is right along the arc, not along the tangent, and the covariance, which knows straight lines
//! only, would take the 6 km for a sure height. So differences of position are counted as height and as arc from the
//! predicted place, and a correction moves the state along the arc and turns velocity and covariance with it. For small
//! differences this is the plain filter.

use super::matrix::{applied, cross_matrix, product, scaled, sum};
use crate::trigonometry::sine_cosine_f64;
use nalgebra::{Matrix3, Vector3};

/// Arcs shorter than this are straight lines, rad: 4 cm in a low orbit.
const STRAIGHT_RAD: f64 = 1e-4;

/// Arcs longer than this are not believed, rad.
const FARTHEST_RAD: f64 = core::f64::consts::FRAC_PI_3;

/// A position as seen from another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bent {
    /// Height and arc between them, km, as a vector at the first.
    pub(super) difference_km: Vector3<f64>,
    /// The turn that brings the first one's direction to the other's.
    pub(super) turn: Matrix3<f64>,
    /// Distance of the other from the Earth's centre over that of the first.
    pub(super) scale: f64,
}

impl Bent {
    /// `None` beyond 60 degrees, and when a position is zero or not finite.
    pub(super) fn between(first: &Vector3<f64>, other: &Vector3<f64>) -> Option<Self> {
        let (near, far) = (libm::sqrt(first.dot(first)), libm::sqrt(other.dot(other)));
        let (u, d) = (first / near, other / far);
        let cosine = u.dot(&d);
        // Also refuses what is no number.
        if !(near > 0.0 && far > 0.0 && cosine > 0.5) {
            return None;
        }
        let axis = u.cross(&d);
        let sine = libm::sqrt(axis.dot(&axis));
        let stretch = if sine < STRAIGHT_RAD { 1.0 } else { libm::atan2(sine, cosine) / sine };
        let arc = (d - u * cosine) * (stretch * near);
        Some(Self { difference_km: arc + u * (far - near), turn: turn(&axis, cosine), scale: far / near })
    }
}

/// Moves position and velocity by a correction, along the arc, and gives the turn that the covariance makes with them; none
/// where the correction is straight.
pub(super) fn correct_state(
    position_km: &mut Vector3<f64>,
    velocity_km_s: &mut Vector3<f64>,
    by_km: &Vector3<f64>,
    by_km_s: &Vector3<f64>,
) -> Option<Matrix3<f64>> {
    let distance = libm::sqrt(position_km.dot(position_km));
    let u = *position_km / distance;
    let height = u.dot(by_km);
    let across = (by_km - u * height) / distance;
    let angle = libm::sqrt(across.dot(&across));
    // Also what is no number is straight.
    let bends = angle > STRAIGHT_RAD && angle < FARTHEST_RAD;
    if !bends {
        *position_km += by_km;
        *velocity_km_s += by_km_s;
        return None;
    }
    let (sine, cosine) = sine_cosine_f64(angle);
    let rate = u.cross(&across);
    let turn = turn(&(rate * (sine / angle)), cosine);
    *velocity_km_s = applied(&turn, &(*velocity_km_s + by_km_s - rate.cross(velocity_km_s)));
    *position_km = applied(&turn, &u) * (distance + height);
    Some(turn)
}

/// The turn about an axis whose length is the sine.
#[inline(never)]
fn turn(axis: &Vector3<f64>, cosine: f64) -> Matrix3<f64> {
    let cross = cross_matrix(axis);
    sum(&sum(&Matrix3::identity(), &cross), &scaled(&product(&cross, &cross), 1.0 / (1.0 + cosine)))
}

#[cfg(test)]
mod tests;
