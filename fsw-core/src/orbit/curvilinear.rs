//! Corrections of position and velocity along the orbit, as changes of its elements.
//!
//! After the first arc the orbit's covariance is hundreds of km long and a few thick. A correction along the
//! tangent leaves it: 200 km ahead on a low orbit is 3 km below the tangent, and the energy, on which the
//! next revolution hangs, is no longer the one that was measured. Errors in equinoctial elements stay Gaussian
//! ([`super::elements`]). So a correction `δx` is taken as the change `E δx` of the elements (`E`: their
//! derivative by the state), and the covariance's root goes with the state by the derivative `T` of that move.
//! Below [`SMALLEST`] the correction is added in Cartesian coordinates.

use super::elements::{Change, Equinoctial};
use crate::matrix::{dot, plus_scaled, scaled};
use nalgebra::Vector3;

/// Smaller corrections are treated as straight, share of position or velocity: 4 cm of height in LEO.
const SMALLEST: f64 = 1e-4;
/// Larger ones are no errors of a known orbit and are added as they are.
const LARGEST: f64 = 0.5;
/// Steps of the central differences, share of position or velocity: relative error 1e-8.
const STEP: f64 = 1e-4;

/// Position, km, and velocity, km/s.
type Motion = (Vector3<f64>, Vector3<f64>);
/// Derivative of position and velocity by those before the move, row by row.
pub(super) type Turn = [[f64; 6]; 6];

fn plus(motion: &Motion, factor: f64, by: &Motion) -> Motion {
    (plus_scaled(&motion.0, factor, &by.0), plus_scaled(&motion.1, factor, &by.1))
}

fn elements((position_km, velocity_km_s): &Motion) -> Option<Equinoctial> {
    Equinoctial::of(position_km, velocity_km_s)
}

/// Length of the first as a share of the second's.
fn share(of: &Vector3<f64>, whole: &Vector3<f64>) -> f64 {
    libm::sqrt(dot(of, of) / dot(whole, whole).max(1e-6))
}

/// Moves position and velocity by a correction and gives the matrix `T` for the covariance's root; `None`
/// where the correction was added in Cartesian coordinates: too small or large, or no closed orbit.
#[inline(never)]
pub(super) fn correct_state(
    position_km: &mut Vector3<f64>,
    velocity_km_s: &mut Vector3<f64>,
    by: &Motion,
) -> Option<Turn> {
    let before = (*position_km, *velocity_km_s);
    let size = share(&by.0, &before.0).max(share(&by.1, &before.1));
    // NaN counts as straight.
    let bends = size > SMALLEST && size < LARGEST;
    let curved =
        if bends { change(&before, by, STEP / size).and_then(|by| turned(&before, &by)) } else { None };
    let (after, turn) = match curved {
        Some((after, turn)) => (after, Some(turn)),
        None => (plus(&before, 1.0, by), None),
    };
    (*position_km, *velocity_km_s) = after;
    turn
}

/// `E δx`, by a central difference along `δx` times `scale`.
fn change(before: &Motion, by: &Motion, scale: f64) -> Option<Change> {
    let forth = elements(&plus(before, scale, by))?;
    let back = elements(&plus(before, -scale, by))?;
    Some(forth.minus(&back)?.map(|element| element * (0.5 / scale)))
}

/// Where the change of the elements leads, and the derivative of that by the state.
fn turned(before: &Motion, by: &Change) -> Option<(Motion, Turn)> {
    let moved = |from: &Motion| elements(from)?.plus(by).state();
    let after = moved(before)?;
    let [far, fast] = [&before.0, &before.1].map(|whole| STEP * libm::sqrt(dot(whole, whole)));
    let mut turn = [[0.0; 6]; 6];
    for axis in 0..3 {
        let mut along = Vector3::zeros();
        *along.get_mut(axis)? = 1.0;
        let steps = [
            (far, (scaled(&along, far), Vector3::zeros())),
            (fast, (Vector3::zeros(), scaled(&along, fast))),
        ];
        for (column, (step, shift)) in [axis, axis + 3].into_iter().zip(&steps) {
            let slope = plus(&moved(&plus(before, 1.0, shift))?, -1.0, &moved(&plus(before, -1.0, shift))?);
            let slope = slope.0.iter().chain(slope.1.iter());
            for (row, element) in turn.iter_mut().zip(slope) {
                *row.get_mut(column)? = element * (0.5 / step);
            }
        }
    }
    Some((after, turn))
}

#[cfg(test)]
mod tests;
