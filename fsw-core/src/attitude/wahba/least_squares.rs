//! Attitude by unconstrained least squares (thesis eq. 3.5): `M = Σ a b rᵀ [Σ a r rᵀ]⁻¹`, nine free elements, made a
//! rotation afterwards, `A = M (MᵀM)^(-1/2)` (eq. 3.6). Two stars get a third, their vector product.
//!
//! Not optimal: the constraint comes too late, and stars near one great circle leave `M` open across it however well
//! they fix a rotation. The covariance is therefore the method's own, not eq. 3.27: to first order the rotation vector is
//! `½ Σ a (δb × c)` with `c = M [Σ a r rᵀ]⁻¹ r`.

use super::super::Observation;
use super::profile::Profile;
use super::svd::decompose;
use super::{Solution, WahbaError, loss};
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::{Matrix3, Vector3, Vector4};

/// Least ratio of the spread (square) across the great circle that fits best to that along it: 1 to 100.
const MIN_WIDTH: f32 = 1e-4;
/// Least sine of the angle between two stars, 0.1 deg.
const MIN_SINE: f32 = 1.7e-3;

/// The inverse of a symmetric positive matrix, z eliminated first, so that the small sums of x and y keep their digits;
/// `None` when what is left of these is nearly singular.
fn inverse(m: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    let (u, v) = (m.m13 / m.m33, m.m23 / m.m33);
    let (xx, xy, yy) = (m.m11 - u * m.m13, m.m12 - u * m.m23, m.m22 - v * m.m23);
    let (determinant, trace) = (xx * yy - xy * xy, xx + yy);
    // Written so that NaN is refused too.
    if !(determinant > MIN_WIDTH * trace * trace) {
        return None;
    }
    let (xx, xy, yy) = (yy / determinant, -xy / determinant, xx / determinant);
    let (xz, yz) = (-(xx * u + xy * v), -(xy * u + yy * v));
    Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, 1.0 / m.m33 - xz * u - yz * v))
}

/// The third direction of two stars, measured and in the catalogue, and the sine of the angle between the measured.
fn third(b: &[Vector3<f32>; 2], r: &[Vector3<f32>; 2]) -> Option<(Vector3<f32>, Vector3<f32>, f32)> {
    let [(b, sine), (r, sine_r)] = [b, r].map(|[one, other]| {
        let product = one.cross(other);
        let sine = libm::sqrtf(product.dot(&product));
        (product / sine, sine)
    });
    (sine > MIN_SINE && sine_r > MIN_SINE).then_some((b, r, sine))
}

/// Solves the problem for two or more pairs; three or more must not lie on a great circle.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: Observation>(pairs: &[O]) -> Result<Solution, WahbaError> {
    let profile = Profile::of(pairs)?;
    if !profile.is_wide() {
        return Err(WahbaError::Parallel);
    }
    let total = pairs.iter().map(O::pair).fold(0.0, |sum, pair| sum + pair.weight());
    let turned = |item: &O| {
        let pair = item.pair();
        let b = profile.measured_frame * pair.measured.vector();
        (b, profile.reference_frame * pair.reference.vector(), pair.weight() / total)
    };
    let add = |sum, (_, r, a): (_, Vector3<f32>, f32)| sum + r * r.transpose() * a;
    let mut moments = pairs.iter().map(turned).fold(Matrix3::zeros(), add);
    let mut b_sum = profile.b;
    let mut product = None;
    if let [one, other] = pairs {
        let ((b1, r1, a1), (b2, r2, a2)) = (turned(one), turned(other));
        let (b, r, sine) = third(&[b1, b2], &[r1, r2]).ok_or(WahbaError::Parallel)?;
        // As much weight as the spread along the great circle has; with three directions the result is the same.
        let weight = a1 * a2 * sine * sine;
        moments += r * r.transpose() * weight;
        b_sum += b * r.transpose() * weight;
        product = Some((b, r, weight / sine, [b1, b2]));
    }
    let inverse = inverse(&moments).ok_or(WahbaError::Collinear)?;
    let free = b_sum * inverse;
    let matrix = decompose(&free).ok_or(WahbaError::Collinear)?;
    let [x, y, z, w] = Rotation::<Icrs, StarPath>::from_orthogonal(matrix).quaternion();
    let attitude = profile.attitude(&Vector4::new(x, y, z, w)).ok_or(WahbaError::Collinear)?;

    // What the errors of the stars do in the third direction, as maps from error to twice the rotation vector.
    let reach = free * inverse;
    let through_product = product.map(|(b, r, scale, [b1, b2])| {
        let across = Matrix3::identity() - b * b.transpose();
        let map = (reach * r).cross_matrix() * across * scale;
        [map * b2.cross_matrix(), -map * b1.cross_matrix()]
    });
    let through_product = through_product.into_iter().flatten().chain(core::iter::repeat(Matrix3::zeros()));
    let covariance = pairs.iter().zip(through_product).fold(Matrix3::zeros(), |sum, (item, extra)| {
        let (b, r, a) = turned(item);
        let map = extra - (reach * r).cross_matrix() * a;
        let along = map * b;
        let sigma_rad = item.pair().sigma_rad;
        sum + (map * map.transpose() - along * along.transpose()) * (0.25 * sigma_rad * sigma_rad)
    });
    let covariance_rad2 = profile.measured_frame.transpose() * covariance * profile.measured_frame;
    Ok(Solution { attitude, covariance_rad2, loss: loss(pairs, &attitude) })
}
