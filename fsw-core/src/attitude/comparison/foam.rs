//! Attitude by FOAM (Markley 1993): `A = [(kappa + |B|²) B + lambda adj Bᵀ - B Bᵀ B] / zeta`, lambda the
//! largest root of the characteristic polynomial (`characteristic.rs`).
//!
//! `|B|² B - B Bᵀ B` is formed as `(|B|² I - B Bᵀ) B`, whose diagonal is a sum of the squares of the *other*
//! rows: the square of the element near one never has to cancel. Rounding error: see [`super`].

use super::characteristic::root;
use super::profile::Profile;
use crate::attitude::WeightedPair;
use crate::attitude::wahba::WahbaError;
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::{Matrix3, Vector3, Vector4};

/// Solves Wahba's problem for two or more pairs.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(pairs: &[O]) -> Result<Rotation<Icrs, StarPath>, WahbaError> {
    let profile = Profile::of(pairs)?;
    let root = root(&profile)?;
    let b = &profile.b;
    let first = Vector3::new(b.m11, b.m12, b.m13);
    let second = Vector3::new(b.m21, b.m22, b.m23);
    let third = Vector3::new(b.m31, b.m32, b.m33);
    let (xx, yy, zz) = (first.dot(&first), second.dot(&second), third.dot(&third));
    let (xy, xz, yz) = (-first.dot(&second), -first.dot(&third), -second.dot(&third));
    let rest = Matrix3::new(yy + zz, xy, xz, xy, xx + zz, yz, xz, yz, xx + yy);
    let matrix = (b * root.kappa + rest * b + root.cofactors * (1.0 - root.loss)) / root.zeta;
    // The quaternion makes it orthogonal to the last digit.
    let [x, y, z, w] = Rotation::<Icrs, StarPath>::from_orthogonal(matrix).quaternion();
    profile.attitude(&Vector4::new(x, y, z, w)).ok_or(profile.fault())
}
