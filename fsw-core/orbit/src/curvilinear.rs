//! Corrections of position and velocity along the orbit, as changes of its elements.
//!
//! After an eclipse in the first revolution the orbit's covariance is hundreds of km long and a few thick.
//! A correction along the tangent leaves it: 200 km ahead on a low orbit is 3 km below the tangent, and the
//! energy, on which the next revolution hangs, is no longer the one that was measured. Errors in
//! equinoctial elements stay Gaussian ([`super::elements`]). So a correction `δx` is taken as the change `E
//! δx` of the elements (`E`: their derivative by the state), and the covariance's root goes with the state
//! by the derivative `T` of that move.
//!
//! On the first arc it is the other way round: position and velocity are what is measured and the shape of
//! the orbit is what is unknown. A correction is taken in elements where most of it is along the orbit,
//! else it is added in Cartesian coordinates, as are those below [`SMALLEST`].

use super::elements::{Change, Equinoctial};
use fsw_ground::matrix::{dot, plus_scaled};
use nalgebra::Vector3;

/// Smaller corrections are treated as straight, share of position or velocity: 4 cm of height in LEO.
const SMALLEST: f64 = 1e-4;
/// Larger ones are no errors of a known orbit and are added as they are.
const LARGEST: f64 = 0.5;
/// Steps of the central differences, share of position or velocity: relative error 1e-8.
const STEP: f64 = 1e-4;
/// Step of the forward differences, likewise: relative error 1e-6.
const FORWARD_STEP: f64 = 1e-6;

/// Position, km, and velocity, km/s.
type Motion = (Vector3<f64>, Vector3<f64>);
/// Derivative of position and velocity by those before the move, row by row.
pub(super) type Turn = [[f64; 6]; 6];

#[inline(never)]
fn plus(motion: &Motion, factor: f64, by: &Motion) -> Motion {
    (plus_scaled(&motion.0, factor, &by.0), plus_scaled(&motion.1, factor, &by.1))
}

fn elements(mu_km3_s2: f64, (position_km, velocity_km_s): &Motion) -> Option<Equinoctial> {
    Equinoctial::of(mu_km3_s2, position_km, velocity_km_s)
}

/// Square of the first's length over the second's.
fn square_share(of: &Vector3<f64>, whole: &Vector3<f64>) -> f64 {
    dot(of, of) / dot(whole, whole).max(1e-6)
}

/// Moves position and velocity about a body of this gravitational parameter (km³/s²) by a correction and
/// gives the matrix `T` for the covariance's root; `None` where the correction was added in Cartesian
/// coordinates.
#[inline(never)]
pub(super) fn correct_state(
    mu_km3_s2: f64,
    position_km: &mut Vector3<f64>,
    velocity_km_s: &mut Vector3<f64>,
    by: &Motion,
) -> Option<Turn> {
    let before = (*position_km, *velocity_km_s);
    let (after, turn) = match along_orbit(mu_km3_s2, &before, by) {
        Some((after, turn)) => (after, Some(turn)),
        None => (plus(&before, 1.0, by), None),
    };
    (*position_km, *velocity_km_s) = after;
    turn
}

/// A correction that is mostly along the orbit, and what it does to small errors; `None` for others.
fn along_orbit(mu_km3_s2: f64, before: &Motion, by: &Motion) -> Option<(Motion, Turn)> {
    let square = square_share(&by.0, &before.0).max(square_share(&by.1, &before.1));
    // NaN is refused too.
    if !(square > SMALLEST * SMALLEST && square < LARGEST * LARGEST) {
        return None;
    }
    let here = elements(mu_km3_s2, before)?;
    let change = change(mu_km3_s2, before, by, STEP / libm::sqrt(square))?;
    let [motion, h, k, ..] = change;
    let motion = motion / here.mean_motion_rad_s;
    let mostly_along = 2.0 * (motion * motion + h * h + k * k) < square;
    if mostly_along { turned(mu_km3_s2, before, &change) } else { None }
}

/// `E δx`, by a central difference along `δx` times `scale`.
fn change(mu_km3_s2: f64, before: &Motion, by: &Motion, scale: f64) -> Option<Change> {
    let forth = elements(mu_km3_s2, &plus(before, scale, by))?;
    let back = elements(mu_km3_s2, &plus(before, -scale, by))?;
    Some(forth.minus(&back)?.map(|element| element * (0.5 / scale)))
}

/// Where a change of the elements leads.
#[inline(never)]
fn moved(mu_km3_s2: f64, from: &Motion, by: &Change) -> Option<Motion> {
    elements(mu_km3_s2, from)?.plus(by).state(mu_km3_s2)
}

/// Where the change of the elements leads, and the derivative of that by the state.
fn turned(mu_km3_s2: f64, before: &Motion, by: &Change) -> Option<(Motion, Turn)> {
    let after = moved(mu_km3_s2, before, by)?;
    let [far, fast] = [&before.0, &before.1].map(|whole| FORWARD_STEP * libm::sqrt(dot(whole, whole)));
    let mut turn = [[0.0; 6]; 6];
    for column in 0..6 {
        let mut shift = (Vector3::zeros(), Vector3::zeros());
        let (vector, step) = if column < 3 { (&mut shift.0, far) } else { (&mut shift.1, fast) };
        *vector.get_mut(column % 3)? = step;
        let slope = plus(&moved(mu_km3_s2, &plus(before, 1.0, &shift), by)?, -1.0, &after);
        for (row, element) in turn.iter_mut().zip(slope.0.iter().chain(slope.1.iter())) {
            *row.get_mut(column)? = element / step;
        }
    }
    Some((after, turn))
}

#[cfg(test)]
mod tests;
