//! Wahba's problem (thesis §3.1.4, eq. 3.4): the rotation `A` that minimises `½ Σ a |b - A r|²`.
//!
//! [`svd`] solves it in flight. The other methods of the thesis stand in [`super::comparison`], with the same
//! errors and [`Solution`].

pub mod svd;

use super::WeightedPair;
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::Matrix3;

/// Why a set of pairs gives no attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WahbaError {
    /// Fewer than two pairs.
    TooFew,
    /// All measured directions, or all references, lie so close to one line that the rotation about it is
    /// undetermined.
    Parallel,
    /// All directions lie on one great circle, which is not sufficient for the unconstrained method.
    Collinear,
    /// Two different attitudes fit the pairs equally well.
    Ambiguous,
    /// A sigma or a covariance is not finite.
    NotFinite,
    /// A sigma is not between 1e-9 and 1 rad, or a covariance is not positive definite.
    Weight,
}

/// An attitude with covariance and loss.
#[derive(Clone, Copy, Debug)]
pub struct Solution {
    /// The rotation.
    pub attitude: Rotation<Icrs, StarPath>,
    /// Covariance of its rotation vector in the star path's frame, rad²: eq. 3.27 for the methods that solve
    /// Wahba's problem, their own for unconstrained least squares and error ellipses.
    pub covariance_rad2: Matrix3<f32>,
    /// What the method minimised, `½ Σ |b - A r|² / sigma²`, with error ellipses `½ Σ (b - A r)ᵀ W (b - A
    /// r)`: half of a chi-square with two degrees of freedom a star, less three.
    pub loss: f32,
}

/// Refuses fewer than two pairs, and sigmas that are not finite or not between 1e-9 and 1 rad.
pub(super) fn check<O: WeightedPair>(pairs: &[O]) -> Result<(), WahbaError> {
    if pairs.len() < 2 {
        return Err(WahbaError::TooFew);
    }
    pairs.iter().map(|item| item.pair().sigma_rad).try_fold((), |(), sigma_rad| {
        if !sigma_rad.is_finite() {
            Err(WahbaError::NotFinite)
        } else if sigma_rad > 1e-9 && sigma_rad < 1.0 {
            Ok(())
        } else {
            Err(WahbaError::Weight)
        }
    })
}

/// `½ Σ |b - A r|² / sigma²`.
pub(super) fn loss<O: WeightedPair>(pairs: &[O], attitude: &Rotation<Icrs, StarPath>) -> f32 {
    let square = pairs.iter().map(O::pair).fold(0.0, |sum, pair| {
        let off = pair.measured.vector() - attitude.apply(&pair.reference).vector();
        sum + off.dot(&off) * pair.weight()
    });
    0.5e6 * square
}
