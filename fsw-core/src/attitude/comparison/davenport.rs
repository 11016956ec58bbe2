//! Attitude by Davenport's q-method (thesis §3.1.4, eq. 3.9-3.13): the quaternion is the eigenvector of the
//! symmetric 4 x 4 matrix K with the largest eigenvalue.
//!
//! `I - K` has no negative eigenvalue, so its singular vectors are its eigenvectors, and the one looked for
//! belongs to the smallest. They come from one-sided Jacobi with [`SWEEPS`] sweeps: constant cost, no
//! convergence test, and small eigenvalues as exact as large ones. Rounding error: see [`super`].

use super::profile::{MIN_SPREAD, Profile};
use crate::attitude::WeightedPair;
use crate::attitude::wahba::WahbaError;
use crate::attitude::wahba::svd::orthogonalise;
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::Vector4;

/// Jacobi sweeps.
pub const SWEEPS: usize = 6;

/// Solves Wahba's problem for two or more pairs.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(pairs: &[O]) -> Result<Rotation<Icrs, StarPath>, WahbaError> {
    let profile = Profile::of(pairs)?;
    let k = -profile.shifted_k();
    // The columns of I - K, each with what has been done to it.
    let mut first = [Vector4::new(k.m11, k.m21, k.m31, k.m41), Vector4::x()];
    let mut second = [Vector4::new(k.m12, k.m22, k.m32, k.m42), Vector4::y()];
    let mut third = [Vector4::new(k.m13, k.m23, k.m33, k.m43), Vector4::z()];
    let mut fourth = [Vector4::new(k.m14, k.m24, k.m34, k.m44), Vector4::w()];
    for _ in 0..SWEEPS {
        orthogonalise(&mut first, &mut second);
        orthogonalise(&mut first, &mut third);
        orthogonalise(&mut first, &mut fourth);
        orthogonalise(&mut second, &mut third);
        orthogonalise(&mut second, &mut fourth);
        orthogonalise(&mut third, &mut fourth);
    }
    let square = |column: &[Vector4<f32>; 2]| column[0].dot(&column[0]);
    let (mut least, mut next) = (first, second);
    if square(&next) < square(&least) {
        (least, next) = (next, least);
    }
    for column in [third, fourth] {
        if square(&column) < square(&least) {
            (least, next) = (column, least);
        } else if square(&column) < square(&next) {
            next = column;
        }
    }
    // Twice the sum of the two singular values of B that carry the roll.
    let gap = libm::sqrtf(square(&next)) - libm::sqrtf(square(&least));
    let quaternion = if gap > 2.0 * MIN_SPREAD { profile.attitude(&least[1]) } else { None };
    quaternion.ok_or(profile.fault())
}
