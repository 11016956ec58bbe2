//! Attitude by ESOQ (Mortari 1997): the quaternion is orthogonal to every row of `K - lambda I`, so it is the
//! four-dimensional vector product of three of them, lambda the largest root of the characteristic polynomial
//! (`characteristic.rs`).
//!
//! All four choices of three rows are formed and the longest product is taken; no rotation of the reference
//! is needed. Rounding error: see [`super`].

use super::characteristic::root;
use super::profile::Profile;
use crate::attitude::WeightedPair;
use crate::attitude::wahba::WahbaError;
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::{Vector3, Vector4};

/// The vector orthogonal to three others: cofactors of the 4 x 4 matrix that they are the first rows of.
fn product(a: &Vector4<f32>, b: &Vector4<f32>, c: &Vector4<f32>) -> Vector4<f32> {
    let minor = |pick: fn(&Vector4<f32>) -> Vector3<f32>| pick(a).dot(&pick(b).cross(&pick(c)));
    Vector4::new(
        -minor(|v| Vector3::new(v.y, v.z, v.w)),
        minor(|v| Vector3::new(v.x, v.z, v.w)),
        -minor(|v| Vector3::new(v.x, v.y, v.w)),
        minor(|v| Vector3::new(v.x, v.y, v.z)),
    )
}

/// Solves Wahba's problem for two or more pairs.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(pairs: &[O]) -> Result<Rotation<Icrs, StarPath>, WahbaError> {
    let profile = Profile::of(pairs)?;
    let loss = root(&profile)?.loss;
    let k = profile.shifted_k();
    let first = Vector4::new(k.m11 + loss, k.m12, k.m13, k.m14);
    let second = Vector4::new(k.m21, k.m22 + loss, k.m23, k.m24);
    let third = Vector4::new(k.m31, k.m32, k.m33 + loss, k.m34);
    let fourth = Vector4::new(k.m41, k.m42, k.m43, k.m44 + loss);
    let mut best = product(&first, &second, &third);
    for (a, b, c) in [(first, second, fourth), (first, third, fourth), (second, third, fourth)] {
        let other = product(&a, &b, &c);
        if other.dot(&other) > best.dot(&best) {
            best = other;
        }
    }
    profile.attitude(&best).ok_or(profile.fault())
}
