//! Small steps with 3 x 3 matrices of f64.
//!
//! Each is once in the image: a product is 45 calls of software arithmetic, 700 bytes of flash wherever it is written out.

use nalgebra::{Matrix3, Vector3};

/// `a b`.
#[inline(never)]
pub(super) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    a * b
}

/// `a x + b y`.
#[inline(never)]
pub(super) fn products(
    (a, x): (&Matrix3<f64>, &Matrix3<f64>),
    (b, y): (&Matrix3<f64>, &Matrix3<f64>),
) -> Matrix3<f64> {
    product(a, x) + product(b, y)
}

/// `a v`.
#[inline(never)]
pub(super) fn applied(a: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    a * v
}

/// `a bᵀ`.
#[inline(never)]
pub(super) fn outer(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    a * b.transpose()
}

/// Takes `a b` from `m`.
#[inline(never)]
pub(super) fn take_product(m: &mut Matrix3<f64>, a: &Matrix3<f64>, b: &Matrix3<f64>) {
    *m -= product(a, b);
}

/// `a + b`.
#[inline(never)]
pub(super) fn sum(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    a + b
}

/// `m` times a number.
#[inline(never)]
pub(super) fn scaled(m: &Matrix3<f64>, factor: f64) -> Matrix3<f64> {
    m * factor
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
