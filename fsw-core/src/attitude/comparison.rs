//! Attitude methods besides the flown one, for comparison on the ground (thesis §3.1.4, appendix A). Not
//! linked into the flight image.
//!
//! | method | how | source |
//! |---|---|---|
//! | [`svd`] | singular vectors of `B = Σ a b rᵀ`; flies | Markley 1988 |
//! | [`davenport`] | eigenvector of the 4 x 4 matrix K, by Jacobi | eq. 3.9, 3.13 |
//! | [`quest`] | largest root of K's characteristic polynomial, Gibbs vector | Shuster and Oh 1981 |
//! | [`foam`] | the same root, matrix from B by cofactors | Markley 1993 |
//! | [`esoq`] | the same root, four-dimensional vector product | Mortari 1997 |
//! | [`esoq2`] | the same root, Euler axis | Mortari 1997 |
//! | [`least_squares`] | unconstrained, then made orthogonal; not optimal | eq. 3.5, 3.6 |
//! | [`anisotropic`] | error ellipses instead of circles, numerically on the manifold | eq. A.2 |
//!
//! [`solve`] calls all of them: stars in, [`Solution`] out, in the same frames and units. All but the SVD and
//! error ellipses sum their matrices in the axis frames of [`profile`], because plain sums in f32 lose the
//! roll: QUEST then misses the optimum by 39 arcsec in half of all 6 deg fields and by degrees in one of a
//! hundred (reference field 0.7 and 120 arcsec; test `without_axis_frames_f32_is_not_enough_...`).
//!
//! Greatest distance from the optimum in f64 over 20,000 random fields of 3 to 12 stars each (test
//! `every_optimal_method_finds_the_optimum`), any of the seven optimal methods: in a 6 deg field 0.05 arcsec
//! across the line of sight and 0.8 about it, in the reference field 0.06 and 0.2.

pub mod anisotropic;
mod characteristic;
pub mod davenport;
pub mod esoq;
pub mod esoq2;
pub mod foam;
pub mod least_squares;
pub mod profile;
pub mod quest;

use super::WeightedPair;
use super::covariance::Information;
use super::wahba::{Solution, WahbaError, loss, svd};

/// Solution method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WahbaMethod {
    /// Singular value decomposition.
    Svd,
    /// Davenport's q.
    Davenport,
    /// QUEST.
    Quest,
    /// FOAM.
    Foam,
    /// ESOQ.
    Esoq,
    /// ESOQ2.
    Esoq2,
    /// Unconstrained least squares, orthogonalised.
    LeastSquares,
    /// The extended problem with anisotropic weights.
    Anisotropic,
}

impl WahbaMethod {
    /// Every method, the flown one first.
    pub const ALL: [Self; 8] = [
        Self::Svd,
        Self::Davenport,
        Self::Quest,
        Self::Foam,
        Self::Esoq,
        Self::Esoq2,
        Self::LeastSquares,
        Self::Anisotropic,
    ];
}

/// Solves with the given method.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(method: WahbaMethod, pairs: &[O]) -> Result<Solution, WahbaError> {
    let attitude = match method {
        WahbaMethod::Svd => svd::solve(pairs),
        WahbaMethod::Davenport => davenport::solve(pairs),
        WahbaMethod::Quest => quest::solve(pairs),
        WahbaMethod::Foam => foam::solve(pairs),
        WahbaMethod::Esoq => esoq::solve(pairs),
        WahbaMethod::Esoq2 => esoq2::solve(pairs),
        WahbaMethod::LeastSquares => return least_squares::solve(pairs),
        WahbaMethod::Anisotropic => return anisotropic::solve(pairs),
    }?;
    let covariance_rad2 = Information::of(pairs).covariance_rad2().ok_or(WahbaError::Parallel)?;
    Ok(Solution { attitude, covariance_rad2, loss: loss(pairs, &attitude) })
}

#[cfg(test)]
pub(super) mod tests;
