//! Small matrices by loops: one copy of each step in the image for every size, f32 or f64.
//!
//! The matrices are nalgebra's (`SMatrix`, columns first). Its own operators are written out anew at every
//! place and for every size: a 3 x 3 product of f64 is 45 calls of software arithmetic, 770 bytes of flash.
//! Here the work is done on slices with the sizes as arguments, and never inlined. Sums run over the inner
//! index upwards from its first term, as nalgebra's do: the bits are the same.
//!
//! Cost on the target, about: a multiplication with its addition and the loop 15 cycles in f32, 300 in f64
//! (software).

use core::ops::{Add, Mul, Sub};
use nalgebra::{SMatrix, SVector, Scalar};

/// f32 or f64.
pub trait Real:
    Scalar + Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// 0.
    const ZERO: Self;
    /// 1/2.
    const HALF: Self;
    /// 1.
    const ONE: Self;
    /// Least pivot of [`Cholesky`] over the diagonal's element: what is less is rounding.
    const LEAST_PIVOT_SHARE: Self;
    /// Greatest pivot of [`Cholesky`]: what is made of it stays finite.
    const GREATEST_PIVOT: Self;
    /// `1 / sqrt(self)`.
    fn inverse_root(self) -> Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    const LEAST_PIVOT_SHARE: Self = 1e-6;
    const GREATEST_PIVOT: Self = 1e30;
    fn inverse_root(self) -> Self {
        1.0 / libm::sqrtf(self)
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    const LEAST_PIVOT_SHARE: Self = 1e-12;
    const GREATEST_PIVOT: Self = 1e30;
    fn inverse_root(self) -> Self {
        1.0 / libm::sqrt(self)
    }
}

/// Elements of a matrix, or of its transpose, by row and column.
#[derive(Clone, Copy)]
struct View<'a, T> {
    elements: &'a [T],
    row_stride: usize,
    column_stride: usize,
}

impl<'a, T: Real> View<'a, T> {
    fn of<const R: usize, const C: usize>(matrix: &'a SMatrix<T, R, C>) -> Self {
        Self { elements: matrix.as_slice(), row_stride: 1, column_stride: R }
    }

    fn transposed(self) -> Self {
        Self { row_stride: self.column_stride, column_stride: self.row_stride, ..self }
    }

    fn at(&self, row: usize, column: usize) -> T {
        element(self.elements, row * self.row_stride + column * self.column_stride)
    }
}

/// An element; the callers ask for none outside, where it would be 0.
fn element<T: Real>(elements: &[T], at: usize) -> T {
    elements.get(at).copied().unwrap_or(T::ZERO)
}

/// What becomes of the matrix that a product is written to.
#[derive(Clone, Copy)]
enum Store {
    Replaced,
    Increased,
}

/// `out = a b` or `out + a b`, where `out` has `rows` rows and `a` has `inner` columns.
#[inline(never)]
fn multiply<T: Real>(out: &mut [T], store: Store, rows: usize, inner: usize, a: View<T>, b: View<T>) {
    let (mut row, mut column) = (0, 0);
    for place in out {
        let mut sum = a.at(row, 0) * b.at(0, column);
        for k in 1..inner {
            sum = sum + a.at(row, k) * b.at(k, column);
        }
        *place = match store {
            Store::Replaced => sum,
            Store::Increased => *place + sum,
        };
        row += 1;
        if row == rows {
            (row, column) = (0, column + 1);
        }
    }
}

/// `a b`.
pub fn product<T: Real, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, K, C>,
) -> SMatrix<T, R, C> {
    let mut out = SMatrix::<T, R, C>::repeat(T::ZERO);
    multiply(out.as_mut_slice(), Store::Replaced, R, K, View::of(a), View::of(b));
    out
}

/// `aᵀ b`.
pub fn transposed_product<T: Real, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, K, R>,
    b: &SMatrix<T, K, C>,
) -> SMatrix<T, R, C> {
    let mut out = SMatrix::<T, R, C>::repeat(T::ZERO);
    multiply(out.as_mut_slice(), Store::Replaced, R, K, View::of(a).transposed(), View::of(b));
    out
}

/// `a bᵀ`; of two vectors, their outer product.
pub fn product_transposed<T: Real, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, C, K>,
) -> SMatrix<T, R, C> {
    let mut out = SMatrix::<T, R, C>::repeat(T::ZERO);
    multiply(out.as_mut_slice(), Store::Replaced, R, K, View::of(a), View::of(b).transposed());
    out
}

/// `out += a bᵀ`; of two vectors, an update of rank one.
pub fn add_product_transposed<T: Real, const R: usize, const K: usize, const C: usize>(
    out: &mut SMatrix<T, R, C>,
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, C, K>,
) {
    multiply(out.as_mut_slice(), Store::Increased, R, K, View::of(a), View::of(b).transposed());
}

/// `a p aᵀ`: a covariance carried by `a`, symmetric to the last bit where `p` is.
pub fn symmetric_product<T: Real, const R: usize, const K: usize>(
    a: &SMatrix<T, R, K>,
    p: &SMatrix<T, K, K>,
) -> SMatrix<T, R, R> {
    let mut carried = product_transposed(&product(a, p), a);
    symmetrise(&mut carried);
    carried
}

/// Replaces a matrix by the mean of itself and its transpose.
pub fn symmetrise<T: Real, const N: usize>(matrix: &mut SMatrix<T, N, N>) {
    symmetrise_slice(matrix.as_mut_slice(), N);
}

#[inline(never)]
fn symmetrise_slice<T: Real>(elements: &mut [T], size: usize) {
    for row in 0..size {
        for column in 0..row {
            let (below, above) = (row + column * size, column + row * size);
            let mean = (element(elements, below) + element(elements, above)) * T::HALF;
            for at in [below, above] {
                if let Some(place) = elements.get_mut(at) {
                    *place = mean;
                }
            }
        }
    }
}

/// `out += factor a`.
pub fn add_scaled<T: Real, const R: usize, const C: usize>(
    out: &mut SMatrix<T, R, C>,
    factor: T,
    a: &SMatrix<T, R, C>,
) {
    add_scaled_slice(out.as_mut_slice(), factor, a.as_slice());
}

#[inline(never)]
fn add_scaled_slice<T: Real>(out: &mut [T], factor: T, a: &[T]) {
    for (place, element) in out.iter_mut().zip(a) {
        *place = *place + *element * factor;
    }
}

/// `factor a`.
pub fn scaled<T: Real, const R: usize, const C: usize>(a: &SMatrix<T, R, C>, factor: T) -> SMatrix<T, R, C> {
    let mut out = *a;
    scale_slice(out.as_mut_slice(), factor);
    out
}

#[inline(never)]
fn scale_slice<T: Real>(elements: &mut [T], factor: T) {
    for element in elements {
        *element = *element * factor;
    }
}

/// `a + factor b`.
pub fn plus_scaled<T: Real, const R: usize, const C: usize>(
    a: &SMatrix<T, R, C>,
    factor: T,
    b: &SMatrix<T, R, C>,
) -> SMatrix<T, R, C> {
    let mut out = *a;
    add_scaled(&mut out, factor, b);
    out
}

/// `aᵀ b` of two vectors.
pub fn dot<T: Real, const N: usize>(a: &SVector<T, N>, b: &SVector<T, N>) -> T {
    dot_slices(a.as_slice(), b.as_slice())
}

/// The same of two slices of one length.
#[inline(never)]
pub fn dot_slices<T: Real>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// Numbers that [`dot_long`] and [`add_scaled_long`] take at a time.
const AT_A_TIME: usize = 4;

/// `aᵀ b` of two slices of one length, for long ones: four sums that are added in the end, half the cycles.
#[inline(never)]
pub fn dot_long(a: &[f32], b: &[f32]) -> f32 {
    let (fours, rest) = a.as_chunks::<AT_A_TIME>();
    let (other_fours, other_rest) = b.as_chunks::<AT_A_TIME>();
    let [mut first, mut second, mut third, mut fourth] = [0.0; AT_A_TIME];
    for ([a, b, c, d], [e, f, g, h]) in fours.iter().zip(other_fours) {
        first += a * e;
        second += b * f;
        third += c * g;
        fourth += d * h;
    }
    let rest = rest.iter().zip(other_rest).fold(0.0, |sum, (a, b)| sum + a * b);
    (first + second) + (third + fourth) + rest
}

/// `out += factor a` of two slices of one length, for long ones.
#[inline(never)]
pub fn add_scaled_long(out: &mut [f32], factor: f32, a: &[f32]) {
    let (fours, rest) = out.as_chunks_mut::<AT_A_TIME>();
    let (other_fours, other_rest) = a.as_chunks::<AT_A_TIME>();
    for ([a, b, c, d], [e, f, g, h]) in fours.iter_mut().zip(other_fours) {
        *a += factor * e;
        *b += factor * f;
        *c += factor * g;
        *d += factor * h;
    }
    for (place, element) in rest.iter_mut().zip(other_rest) {
        *place += factor * element;
    }
}

/// Takes an equation, its coefficients and then its right side, into the triangle of a least squares problem
/// by Givens rotations. What is left of its right side is what no solution explains: the squares of that are
/// those of the residuals.
#[inline(never)]
pub fn rotate_into<const C: usize>(triangle: &mut [[f32; C]], equation: &mut [f32; C]) {
    for (at, row) in triangle.iter_mut().enumerate() {
        let (Some(mine), Some(other)) = (row.get_mut(at..), equation.get_mut(at..)) else { return };
        let (Some(&a), Some(&b)) = (mine.first(), other.first()) else { return };
        if b == 0.0 {
            continue;
        }
        let scale = 1.0 / libm::sqrtf(a * a + b * b);
        let (c, s) = (a * scale, b * scale);
        for (mine, other) in mine.iter_mut().zip(other) {
            (*mine, *other) = (c * *mine + s * *other, c * *other - s * *mine);
        }
    }
}

/// 1 on the diagonal.
pub fn identity<T: Real, const N: usize>() -> SMatrix<T, N, N> {
    let mut out = SMatrix::<T, N, N>::repeat(T::ZERO);
    add_to_diagonal(&mut out, T::ONE);
    out
}

/// `a × b`.
#[inline(never)]
pub fn cross<T: Real>(a: &SVector<T, 3>, b: &SVector<T, 3>) -> SVector<T, 3> {
    let ([[ax, ay, az]], [[bx, by, bz]]) = (a.data.0, b.data.0);
    SVector::from([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
}

/// `[v×]`, so that `[v×] w` is the vector product of v and w.
pub fn cross_matrix<T: Real>(v: &SVector<T, 3>) -> SMatrix<T, 3, 3> {
    let [[x, y, z]] = v.data.0;
    let minus = |value: T| T::ZERO - value;
    SMatrix::from([[T::ZERO, z, minus(y)], [minus(z), T::ZERO, x], [y, minus(x), T::ZERO]])
}

/// Adds a number to every element of the diagonal.
pub fn add_to_diagonal<T: Real, const N: usize>(matrix: &mut SMatrix<T, N, N>, value: T) {
    for (at, column) in matrix.data.0.iter_mut().enumerate() {
        if let Some(element) = column.get_mut(at) {
            *element = *element + value;
        }
    }
}

/// The lower Cholesky factor `L` of a symmetric positive definite matrix, `L Lᵀ = M`.
#[derive(Clone, Copy, Debug)]
pub struct Cholesky<T, const N: usize> {
    /// `L` below the diagonal, the reciprocals of its diagonal on it; above it the matrix as it was.
    factor: SMatrix<T, N, N>,
}

impl<T: Real, const N: usize> Cholesky<T, N> {
    /// Of a matrix, of which the lower left half is read. `None` where a pivot is not finite or not greater
    /// than [`Real::LEAST_PIVOT_SHARE`] (1e-6 in f32, 1e-12 in f64) of the diagonal's element.
    pub fn of(matrix: &SMatrix<T, N, N>) -> Option<Self> {
        let mut factor = *matrix;
        factorise(factor.as_mut_slice(), N).then_some(Self { factor })
    }

    /// `L⁻¹ b`.
    pub fn whitened<const C: usize>(&self, b: &SMatrix<T, N, C>) -> SMatrix<T, N, C> {
        let mut out = *b;
        for column in &mut out.data.0 {
            solve_lower(self.factor.as_slice(), column);
        }
        out
    }

    /// `M⁻¹ b`.
    pub fn solve(&self, b: &SVector<T, N>) -> SVector<T, N> {
        let mut out = *b;
        solve_lower(self.factor.as_slice(), out.as_mut_slice());
        solve_upper(self.factor.as_slice(), out.as_mut_slice());
        out
    }

    /// `M⁻¹`.
    pub fn inverse(&self) -> SMatrix<T, N, N> {
        let mut out = identity();
        for column in &mut out.data.0 {
            solve_lower(self.factor.as_slice(), column);
            solve_upper(self.factor.as_slice(), column);
        }
        symmetrise(&mut out);
        out
    }
}

/// The inverse of a symmetric positive definite matrix; `None` as for [`Cholesky::of`].
pub fn inverse<T: Real, const N: usize>(matrix: &SMatrix<T, N, N>) -> Option<SMatrix<T, N, N>> {
    Cholesky::of(matrix).map(|factor| factor.inverse())
}

/// Cholesky's factor in place, column by column.
#[inline(never)]
fn factorise<T: Real>(elements: &mut [T], size: usize) -> bool {
    for column in 0..size {
        for row in column..size {
            let at = row + column * size;
            let given = element(elements, at);
            let mut rest = given;
            for k in 0..column {
                rest = rest - element(elements, row + k * size) * element(elements, column + k * size);
            }
            let value = if row == column {
                // Also refuses what is no number.
                if !(rest > T::LEAST_PIVOT_SHARE * given && rest > T::ZERO && rest < T::GREATEST_PIVOT) {
                    return false;
                }
                rest.inverse_root()
            } else {
                rest * element(elements, column + column * size)
            };
            if let Some(place) = elements.get_mut(at) {
                *place = value;
            }
        }
    }
    true
}

/// `L⁻¹ b` in place.
#[inline(never)]
fn solve_lower<T: Real>(factor: &[T], b: &mut [T]) {
    let size = b.len();
    for row in 0..size {
        let mut rest = element(b, row);
        for k in 0..row {
            rest = rest - element(factor, row + k * size) * element(b, k);
        }
        if let Some(place) = b.get_mut(row) {
            *place = rest * element(factor, row + row * size);
        }
    }
}

/// `L⁻ᵀ b` in place.
#[inline(never)]
fn solve_upper<T: Real>(factor: &[T], b: &mut [T]) {
    let size = b.len();
    for row in (0..size).rev() {
        let mut rest = element(b, row);
        for k in row + 1..size {
            rest = rest - element(factor, k + row * size) * element(b, k);
        }
        if let Some(place) = b.get_mut(row) {
            *place = rest * element(factor, row + row * size);
        }
    }
}

#[cfg(test)]
mod tests;
