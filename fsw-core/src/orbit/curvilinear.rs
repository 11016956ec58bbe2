//! Corrections of position and velocity along the orbit, as changes of its elements.
//!
//! After the first arc the orbit's covariance is hundreds of km long and a few thick. A correction along the
//! tangent leaves it: 200 km ahead on a low orbit is 3 km below the tangent, and the energy, to which the
//! next revolution is sensitive, is no longer the one that was measured. In equinoctial elements errors stay
//! Gaussian, so a correction `δx` with the covariance `S Sᵀ` is taken as the change `E δx` of the elements
//! (`E`: their derivative by the state). The state is that of the changed elements, and `S` goes with it by
//! the derivative `T` of that map. Below [`SMALLEST`] the correction is added in Cartesian coordinates.

use super::elements::Equinoctial;
use crate::matrix::{dot, plus_scaled, scaled};
use nalgebra::Vector3;

/// Smaller corrections are treated as straight, share of position and velocity: 4 cm of height in LEO.
const SMALLEST: f64 = 1e-4;
/// Larger ones are no errors of a known orbit, and are added as they are.
const LARGEST: f64 = 0.5;
/// Steps of the central differences, share of position and velocity: relative error 1e-8.
const STEP: f64 = 1e-4;

/// Position and velocity.
type Motion = (Vector3<f64>, Vector3<f64>);
/// Derivatives of position and velocity, row by row.
pub(super) type Turn = [[f64; 6]; 6];

fn plus(motion: &Motion, factor: f64, by: &Motion) -> Motion {
    (plus_scaled(&motion.0, factor, &by.0), plus_scaled(&motion.1, factor, &by.1))
}

/// The change of the elements by a small move there and back.
fn change(motion: &Motion, by: &Motion, scale: f64) -> Option<[f64; 6]> {
    let [after, before] = [1.0, -1.0].map(|sign| plus(motion, sign * scale, by));
    let after = Equinoctial::of(&after.0, &after.1)?;
    let before = Equinoctial::of(&before.0, &before.1)?;
    let mut change = after.minus(&before)?;
    for element in &mut change {
        *element *= 0.5 / scale;
    }
    Some(change)
}

/// Moves position and velocity by a correction and gives the matrix `T` by which the covariance's root is
/// multiplied; `None` where the correction was added in Cartesian coordinates.
#[inline(never)]
pub(super) fn correct_state(
    position_km: &mut Vector3<f64>,
    velocity_km_s: &mut Vector3<f64>,
    by_km: &Vector3<f64>,
    by_km_s: &Vector3<f64>,
) -> Option<Turn> {
    let before = (*position_km, *velocity_km_s);
    let by = (*by_km, *by_km_s);
    let straight = plus(&before, 1.0, &by);
    (*position_km, *velocity_km_s) = straight;
    let square = |of: &Vector3<f64>, whole: &Vector3<f64>| dot(of, of) / dot(whole, whole).max(1e-6);
    let size = libm::sqrt(square(&by.0, &before.0).max(square(&by.1, &before.1)));
    // NaN counts as straight.
    if !(size > SMALLEST && size < LARGEST) {
        return None;
    }
    let changes = change(&before, &by, STEP / size)?;
    let moved = |from: &Motion| Equinoctial::of(&from.0, &from.1)?.changed(&changes).state();
    let after = moved(&before)?;
    let steps = [&before.0, &before.1].map(|whole| STEP * libm::sqrt(dot(whole, whole)));
    let mut turn = [[0.0; 6]; 6];
    for column in 0..6 {
        let step = steps.get(column / 3).copied()?;
        let mut unit = (Vector3::zeros(), Vector3::zeros());
        let part = if column < 3 { &mut unit.0 } else { &mut unit.1 };
        *part.get_mut(column % 3)? = step;
        let (forth, back) = (moved(&plus(&before, 1.0, &unit))?, moved(&plus(&before, -1.0, &unit))?);
        let slope = plus(&forth, -1.0, &back);
        let slope = scaled(&slope.0, 0.5 / step).into_iter().chain(&scaled(&slope.1, 0.5 / step)).copied().collect::<heapless::Vec<f64,6>>();
        for (row, element) in turn.iter_mut().zip(&slope) {
            *row.get_mut(column)? = *element;
        }
    }
    (*position_km, *velocity_km_s) = after;
    Some(turn)
}

#[cfg(test)]
mod tests;
