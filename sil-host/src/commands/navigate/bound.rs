//! The information bound of a list of measurements: what no filter can do better than.
//!
//! In: the last state that a filter came to, the forces, times, directions and ranges with their sigmas. Out:
//! the covariance of position and velocity at each measurement from all until then, `J⁻¹`. Along the orbit
//! through the last state `J` is carried from one to the next, `Φ⁻ᵀ J Φ⁻¹`, and each adds
//! `(I - u uᵀ) / (ρ σ)² + u uᵀ / σ_ρ²` to the position's block. Nothing is known before the first one, and no
//! force is unknown. In f64, the transition that of the flight code (eq. 5.23).

use super::Measurement;
use crate::bound::orbit::covariance;
use crate::commands::propagate::carried;
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::dynamics::MAX_SPAN_US;
use fsw_core::orbit::forces::Forces;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// `Φ` between two states of one orbit, and the last of them, in spans that the flight code takes.
fn carry(from: &OrbitState, to: &OrbitState, forces: &Forces) -> Option<Matrix6<f64>> {
    let (mut all, mut before) = (Matrix6::identity(), *from);
    while before.time_us < to.time_us {
        let next_us = to.time_us.min(before.time_us + MAX_SPAN_US);
        let after = carried(&before, next_us, forces).ok()?;
        let rows = forces.transition(&before, &after);
        all = Matrix6::from_fn(|row, column| rows[row][column]) * all;
        before = after;
    }
    Some(all)
}

/// The bound at each measurement, of an orbit through `last`, a state at the last one's time or after; `None`
/// where they do not fix the orbit yet, and everywhere where the orbit cannot be carried back. `ranges`:
/// whether these count.
pub fn bounds(
    last: &OrbitState,
    forces: &Forces,
    measurements: &[Measurement],
    ranges: bool,
) -> Vec<Option<Matrix6<f64>>> {
    let mut states = Vec::with_capacity(measurements.len());
    let mut state = *last;
    for measurement in measurements.iter().rev() {
        let Ok(before) = carried(&state, measurement.time_us, forces) else {
            return vec![None; measurements.len()];
        };
        state = before;
        states.push(state);
    }
    states.reverse();
    let mut information = Matrix6::zeros();
    let mut before = states.first().copied();
    let mut bounds = Vec::with_capacity(states.len());
    for (state, measurement) in states.iter().zip(measurements) {
        let inverse = before.and_then(|before| carry(&before, state, forces)?.try_inverse());
        let Some(inverse) = inverse else {
            bounds.resize(measurements.len(), None);
            return bounds;
        };
        information = inverse.transpose() * information * inverse;
        if let Some(seen) = &measurement.seen {
            let distance_km = state.position_km.norm();
            let up: Vector3<f64> = state.position_km / distance_km;
            let along = up * up.transpose();
            let mut added = (Matrix3::identity() - along) / (distance_km * seen.sigma_rad).powi(2);
            if let Some([_, sigma_km]) = seen.range_km.filter(|_| ranges) {
                added += along / sigma_km.powi(2);
            }
            let mut block = information.fixed_view_mut::<3, 3>(0, 0);
            block += added;
        }
        bounds.push(covariance(&information));
        before = Some(*state);
    }
    bounds
}
