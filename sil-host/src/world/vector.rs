//! Arithmetic of three components, for readers who would rather see a formula than loops.

use crate::world::attitude::{Vector, dot};

/// `a + k b`.
#[inline]
pub fn plus(a: Vector, k: f64, b: Vector) -> Vector {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

/// `k a`.
#[inline]
pub fn times(k: f64, a: Vector) -> Vector {
    [k * a[0], k * a[1], k * a[2]]
}

/// `a - b`.
#[inline]
pub fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Cross product.
#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length.
#[inline]
pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector divided by its length.
#[inline]
pub fn unit(a: Vector) -> Vector {
    times(length(a).recip(), a)
}

/// Angle between two vectors, rad, exact for small angles as well.
pub fn angle(a: Vector, b: Vector) -> f64 {
    libm::atan2(length(cross(a, b)), dot(a, b))
}

/// The transposed matrix; the inverse of a rotation.
pub fn transposed(m: &[Vector; 3]) -> [Vector; 3] {
    [0, 1, 2].map(|k| [m[0][k], m[1][k], m[2][k]])
}

/// The product `a b`, rows of which are those of `a` seen through `b`.
pub fn product(a: &[Vector; 3], b: &[Vector; 3]) -> [Vector; 3] {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}
