//! Attitude by ESOQ2 (Mortari 1997): the Euler axis `e` is the null vector of `M = (lambda - tr B) [(lambda +
//! tr B) I - S] - z zᵀ`, found as the longest product of two of its rows, and `q = [(lambda - tr B) e, z·e]`,
//! lambda the largest root of the characteristic polynomial (`characteristic.rs`).
//!
//! `M` vanishes with the angle of rotation, so the reference is turned by 180 deg about the axis that leaves
//! the
//! *largest* angle: the one with the least element on the diagonal of K. Rounding error: see [`super`].

use super::characteristic::root;
use super::profile::{Profile, half_turn, partition};
use crate::attitude::WeightedPair;
use crate::attitude::wahba::WahbaError;
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::{Vector3, Vector4};

/// Solves Wahba's problem for two or more pairs.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(pairs: &[O]) -> Result<Rotation<Icrs, StarPath>, WahbaError> {
    let profile = Profile::of(pairs)?;
    let loss = root(&profile)?.loss;
    let k = profile.shifted_k();
    let turn = half_turn(&k, |trace, best| trace < best);
    let turned = turn.transpose() * k * turn;
    let (sum, z) = partition(&turned, loss);
    let less_trace = -turned.m44 - loss;
    let m = sum * less_trace - z * z.transpose();
    let first = Vector3::new(m.m11, m.m12, m.m13);
    let second = Vector3::new(m.m21, m.m22, m.m23);
    let third = Vector3::new(m.m31, m.m32, m.m33);
    let mut axis = first.cross(&second);
    for other in [first.cross(&third), second.cross(&third)] {
        if other.dot(&other) > axis.dot(&axis) {
            axis = other;
        }
    }
    let vector = axis * less_trace;
    let quaternion = turn * Vector4::new(vector.x, vector.y, vector.z, z.dot(&axis));
    profile.attitude(&quaternion).ok_or(profile.fault())
}
