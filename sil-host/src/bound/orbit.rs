//! The information of an orbit and what it comes to.
//!
//! In: the information `J` about position (km) and velocity (km/s) along the ICRS axes. Out: the covariance
//! `J⁻¹`, and sigmas along Hill's axes.

use fsw_core::orbit::OrbitState;
use fsw_core::orbit::lvlh::hill;
use nalgebra::{Matrix3, Matrix6};

/// Scale of velocities against positions, s: with it the elements of `J` are alike.
const SCALE_S: f64 = 1e3;
/// Least share of a diagonal element that the rest of `J` may leave of it: below, a direction is not known
/// yet to the digits of f64.
const LEAST_PIVOT: f64 = 1e-12;

/// The covariance whose information is `J`; `None` where that leaves a direction unknown.
pub fn covariance(information: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    let scale = Matrix6::from_diagonal(&[1.0, 1.0, 1.0, 1.0 / SCALE_S, 1.0 / SCALE_S, 1.0 / SCALE_S].into());
    let scaled = scale * information * scale;
    let factor = scaled.cholesky()?;
    let known = factor.l_dirty().diagonal();
    let left = known.component_mul(&known).component_div(&scaled.diagonal());
    (left.min() > LEAST_PIVOT).then(|| scale * factor.inverse() * scale)
}

/// Radial, along and cross sigmas of a position's covariance along the ICRS axes.
pub fn radial_along_cross(state: &OrbitState, covariance_km2: &Matrix3<f64>) -> Option<[f64; 3]> {
    let axes = hill(&state.position_km, &state.velocity_km_s)?;
    let turned = axes * covariance_km2 * axes.transpose();
    Some([0, 1, 2].map(|axis| turned[(axis, axis)].max(0.0).sqrt()))
}
