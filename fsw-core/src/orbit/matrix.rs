//! Small steps with 3 x 3 matrices of f64.
//!
//! Each is once in the image: a product is 45 calls of software arithmetic, 700 bytes of flash wherever it is written out.

use nalgebra::{Matrix3, Vector3};

/// `a b`.
#[inline(never)]
pub(super) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    a * b
}

/// `t m tᵀ`: a covariance in other axes.
#[inline(never)]
pub(super) fn turned(t: &Matrix3<f64>, m: &Matrix3<f64>) -> Matrix3<f64> {
    product(&product(t, m), &t.transpose())
}

/// The mean of a matrix and its transpose.
#[inline(never)]
pub(super) fn symmetric(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// `[v×]`.
pub(super) fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}
