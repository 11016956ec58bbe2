//! Attitude by unconstrained least squares (thesis eq. 3.5): `M = Σ a b rᵀ [Σ a r rᵀ]⁻¹`, nine free elements,
//! made a rotation afterwards, `A = M (MᵀM)^(-1/2)` (eq. 3.6). Two stars get a third, their vector product.
//!
//! Not optimal: the constraint comes too late, and stars near one great circle leave `M` open across it
//! however well they fix a rotation. The covariance is therefore the method's own, not eq. 3.27: to first
//! order the rotation vector is `½ Σ a (δb × c)` with `c = M [Σ a r rᵀ]⁻¹ r`.

use super::profile::Profile;
use crate::attitude::WeightedPair;
use crate::attitude::wahba::svd::decompose;
use crate::attitude::wahba::{Solution, WahbaError, loss};
use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::{Matrix3, Vector3, Vector4};

/// Least ratio of the spread (square) across the great circle that fits best to that along it: 1 to 100.
const MIN_WIDTH: f32 = 1e-4;
/// Least sine of the angle between two stars, 0.1 deg.
const MIN_SINE: f32 = 1.7e-3;

/// The inverse of a symmetric positive matrix, z eliminated first, so that the small sums of x and y keep
/// their digits; `None` when what is left of these is nearly singular.
fn inverse(m: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    let (u, v) = (m.m13 / m.m33, m.m23 / m.m33);
    let (xx, xy, yy) = (m.m11 - u * m.m13, m.m12 - u * m.m23, m.m22 - v * m.m23);
    let (determinant, trace) = (xx * yy - xy * xy, xx + yy);
    if determinant.is_nan() || determinant <= MIN_WIDTH * trace * trace {
        return None;
    }
    let (xx, xy, yy) = (yy / determinant, -xy / determinant, xx / determinant);
    let (xz, yz) = (-(xx * u + xy * v), -(xy * u + yy * v));
    Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, 1.0 / m.m33 - xz * u - yz * v))
}

/// The third direction of two stars.
struct Third {
    measured: Vector3<f32>,
    reference: Vector3<f32>,
    /// Sine of the angle between the two as measured.
    sine: f32,
    /// As much as the spread along the great circle has; of three directions any weight gives the same `M`.
    weight: f32,
    /// The two it is the product of.
    of: [Vector3<f32>; 2],
}

/// A star in the axis frames: measured, reference, share of the weights.
type Star = (Vector3<f32>, Vector3<f32>, f32);

impl Third {
    fn of((b1, r1, a1): Star, (b2, r2, a2): Star) -> Option<Self> {
        let [(measured, sine), (reference, sine_r)] = [b1.cross(&b2), r1.cross(&r2)].map(|product| {
            let sine = libm::sqrtf(product.dot(&product));
            (product / sine, sine)
        });
        let weight = a1 * a2 * sine * sine;
        (sine > MIN_SINE && sine_r > MIN_SINE).then_some(Self {
            measured,
            reference,
            sine,
            weight,
            of: [b1, b2],
        })
    }

    /// What an error of either star does to twice the rotation vector by way of the third direction, whose
    /// `c` this is.
    fn maps(&self, c: &Vector3<f32>) -> [Matrix3<f32>; 2] {
        let across = Matrix3::identity() - self.measured * self.measured.transpose();
        let map = c.cross_matrix() * across * (self.weight / self.sine);
        let [b1, b2] = self.of;
        [map * b2.cross_matrix(), -map * b1.cross_matrix()]
    }
}

/// Solves the problem for two or more pairs; three or more must not lie on a great circle.
///
/// # Errors
/// [`WahbaError`].
pub fn solve<O: WeightedPair>(pairs: &[O]) -> Result<Solution, WahbaError> {
    let profile = Profile::of(pairs)?;
    if !profile.is_wide() {
        return Err(WahbaError::Parallel);
    }
    let total = pairs.iter().map(O::pair).fold(0.0, |sum, pair| sum + pair.weight());
    let star = |item: &O| -> Star {
        let pair = item.pair();
        let b = profile.measured_frame * pair.measured.vector();
        (b, profile.reference_frame * pair.reference.vector(), pair.weight() / total)
    };
    let mut moments =
        pairs.iter().map(star).fold(Matrix3::zeros(), |sum, (_, r, a)| sum + r * r.transpose() * a);
    let mut b_sum = profile.b;
    let mut third = None;
    if let [one, other] = pairs {
        let product = Third::of(star(one), star(other)).ok_or(WahbaError::Parallel)?;
        moments += product.reference * product.reference.transpose() * product.weight;
        b_sum += product.measured * product.reference.transpose() * product.weight;
        third = Some(product);
    }
    let inverse = inverse(&moments).ok_or(WahbaError::Collinear)?;
    let free = b_sum * inverse;
    let matrix = decompose(&free).ok_or(WahbaError::Collinear)?;
    let [x, y, z, w] = Rotation::<Icrs, StarPath>::from_orthogonal(matrix).quaternion();
    let attitude = profile.attitude(&Vector4::new(x, y, z, w)).ok_or(WahbaError::Collinear)?;

    let reach = free * inverse;
    let by_third = third.map(|third| third.maps(&(reach * third.reference)));
    let by_third = by_third.into_iter().flatten().chain(core::iter::repeat(Matrix3::zeros()));
    let covariance = pairs.iter().zip(by_third).fold(Matrix3::zeros(), |sum, (item, by_third)| {
        let (b, r, a) = star(item);
        let map = by_third - (reach * r).cross_matrix() * a;
        // Errors lie across the line of sight.
        let along = map * b;
        let sigma_rad = item.pair().sigma_rad;
        sum + (map * map.transpose() - along * along.transpose()) * (0.25 * sigma_rad * sigma_rad)
    });
    let covariance_rad2 = profile.measured_frame.transpose() * covariance * profile.measured_frame;
    Ok(Solution { attitude, covariance_rad2, loss: loss(pairs, &attitude) })
}
