//! Attitude by QUEST (thesis §3.1.4; Shuster and Oh 1981): the Gibbs vector `y = [(lambda + tr B) I - S]⁻¹
//! z`, lambda the largest root of the characteristic polynomial (`characteristic.rs`).
//!
//! The Gibbs vector is infinite at half turns, so the reference is turned by 180 deg about the axis that
//! makes the scalar component large (sequential rotation): the one with the greatest element on the diagonal
//! of K, which is `tr B` of each choice. A half turn only permutes K, so none of its digits are lost.
//! Adjugate and determinant instead of the inverse, no division. Rounding error: see [`super`].

use super::characteristic::root;
use super::profile::{Profile, cofactors, half_turn, partition};
use crate::attitude::WeightedPair;
use crate::attitude::wahba::WahbaError;
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::Vector4;

/// Solves Wahba's problem for two or more pairs.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(pairs: &[O]) -> Result<Rotation<Icrs, StarPath>, WahbaError> {
    let profile = Profile::of(pairs)?;
    let loss = root(&profile)?.loss;
    let k = profile.shifted_k();
    let turn = half_turn(&k, |trace, best| trace > best);
    let (m, z) = partition(&(turn.transpose() * k * turn), loss);
    let adjugate = cofactors(&m);
    let vector = adjugate * z;
    let determinant = m.m31 * adjugate.m31 + m.m32 * adjugate.m32 + m.m33 * adjugate.m33;
    let quaternion = turn * Vector4::new(vector.x, vector.y, vector.z, determinant);
    profile.attitude(&quaternion).ok_or(profile.fault())
}
