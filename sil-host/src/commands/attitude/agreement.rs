//! Whether the directions of a set agree with each other within their sigmas.
//!
//! In: a set's pairs. Out: whether their loss at the optimum is one that right sigmas would give. Twice the
//! loss is a chi-square with two degrees of freedom a star, less three; a set is refused where so large a one
//! comes with a probability below [`FALSE_ALARM`]. The optimum is the flown method's, by the error ellipses
//! where the set has them, so that the answer is the same for all methods, those that are not optimal too.

use crate::judge::chi_square::upper_tail_odd;
use fsw_core::attitude::WeightedPair;
use fsw_core::attitude::comparison::{self, WahbaMethod};
use fsw_core::attitude::wahba::WahbaError;

/// Probability at which a set with right sigmas is refused.
pub const FALSE_ALARM: f64 = 1e-6;
/// What rounding to single precision leaves of a direction, rad; counts beside a sigma, which may be as small
/// as 1e-9.
const ROUNDING_RAD: f64 = 3e-7;

/// Refuses a set whose directions contradict each other. What else is wrong with it the methods say.
///
/// # Errors
/// [`WahbaError::Ambiguous`].
pub fn check<O: WeightedPair>(method: WahbaMethod, pairs: &[O]) -> Result<(), WahbaError> {
    let loss = match comparison::solve(method, pairs) {
        Ok(solution) => f64::from(solution.loss),
        Err(WahbaError::Ambiguous) => return Err(WahbaError::Ambiguous),
        Err(_) => return Ok(()),
    };
    // The largest weight, of a sigma of 1 mrad 1.
    let weights = pairs.iter().flat_map(|pair| pair.information().diagonal().data.0[0]);
    let rounded = 1.0 + f64::from(weights.fold(0.0, f32::max)) * (1e3 * ROUNDING_RAD).powi(2);
    let freedom = 2 * pairs.len() - 3;
    if upper_tail_odd(2.0 * loss / rounded, freedom) < FALSE_ALARM {
        return Err(WahbaError::Ambiguous);
    }
    Ok(())
}
