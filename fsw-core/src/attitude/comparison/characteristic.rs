//! The largest root of Davenport's characteristic polynomial, which QUEST, FOAM, ESOQ and ESOQ2 share.
//!
//! `psi(lambda) = (lambda² - |B|²)² - 8 lambda det B - 4 |adj B|²` (Markley 1993), weights summing to one.
//! The root is one less the loss: what is solved for is the loss `x = 1 - lambda` itself, by [`NEWTON_STEPS`]
//! of Newton from `x = 0`, which is at or above every root. With `t = 1 - B33` and `n` the sum of squares of
//! the other elements, `lambda² - |B|² = (t - x)(2 - x - t) - n` loses no digits in the axis frames.

use super::profile::{MIN_SPREAD, Profile, cofactors};
use crate::attitude::wahba::WahbaError;
use nalgebra::Matrix3;

/// Steps of Newton; one is enough for a star sensor's noise, a degree of noise takes four.
pub const NEWTON_STEPS: usize = 12;
/// A root is found when the last step was shorter than this share of `zeta`, the distance from a double root.
const LAST_STEP: f32 = 1e-3;

/// The root and what comes with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    /// `1 - lambda`.
    pub loss: f32,
    /// `kappa = ½ (lambda² - |B|²)`.
    pub kappa: f32,
    /// `zeta = kappa lambda - det B`, an eighth of the polynomial's slope: the product of the sums of two
    /// singular values.
    pub zeta: f32,
    /// The cofactors of `B`.
    pub cofactors: Matrix3<f32>,
}

/// Finds it.
///
/// # Errors
/// [`Profile::fault`] where it is a double root.
pub(super) fn root(profile: &Profile) -> Result<Root, WahbaError> {
    let (b, t) = (&profile.b, profile.shortfall);
    let cofactors = cofactors(b);
    let determinant = b.m31 * cofactors.m31 + b.m32 * cofactors.m32 + (1.0 - t) * cofactors.m33;
    let adjugate = cofactors.dot(&cofactors);
    let others = b.m11 * b.m11
        + b.m12 * b.m12
        + b.m13 * b.m13
        + b.m21 * b.m21
        + b.m22 * b.m22
        + b.m23 * b.m23
        + b.m31 * b.m31
        + b.m32 * b.m32;
    let (mut loss, mut step) = (0.0, 0.0);
    for _ in 0..NEWTON_STEPS {
        let lambda = 1.0 - loss;
        let kappa2 = (t - loss) * (2.0 - loss - t) - others;
        let value = kappa2 * kappa2 - 8.0 * lambda * determinant - 4.0 * adjugate;
        let slope = 4.0 * lambda * kappa2 - 8.0 * determinant;
        if slope.is_nan() || slope <= MIN_SPREAD {
            return Err(profile.fault());
        }
        step = value / slope;
        loss += step;
    }
    let kappa = 0.5 * ((t - loss) * (2.0 - loss - t) - others);
    let zeta = kappa * (1.0 - loss) - determinant;
    // Towards a double root Newton creeps.
    if zeta > MIN_SPREAD && libm::fabsf(step) < LAST_STEP * zeta {
        Ok(Root { loss, kappa, zeta, cofactors })
    } else {
        Err(profile.fault())
    }
}
