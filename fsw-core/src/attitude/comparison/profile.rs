//! The attitude profile matrix `B = Σ a b rᵀ` and Davenport's K (thesis eq. 3.9), in frames that keep their
//! digits.
//!
//! In a narrow field the largest singular value of `B` is near one and the others, which carry the roll, are
//! `(field radius)²`: summed as it stands, `B` in f32 has lost them to 6e-8 / 1e-2, and a root of the
//! characteristic polynomial, which divides by the same gap once more, is worse still. Both sets of
//! directions are therefore turned to *axis frames* first, whose z is the mean direction. There the small
//! singular values are sums of small numbers, and what is near one is only `B33`, whose shortfall `1 - B33`
//! is again a sum of small numbers.
//!
//! In: pairs. Out: `B`, the shortfall, `K - I` (weights sum to one, so the eigenvalue looked for is near
//! zero), and the way back. Directions opposite to the first are turned over for the mean, so that two stars
//! on opposite sides are as good as two side by side.

use crate::attitude::WeightedPair;
use crate::attitude::wahba::{WahbaError, check};
use crate::frames::{Direction, Icrs, Rotation, StarPath};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Smallest ratio of the singular values that carry the roll to the largest: two directions 0.1 deg apart.
pub const MIN_SPREAD: f32 = 1e-6;

/// Half turns of the reference about x, y, z (Shuster's sequential rotations): how the components of the
/// quaternion change places, `q = P q'`, and so `K' = Pᵀ K P`. No turn leaves them where they are.
#[rustfmt::skip]
const HALF_TURNS: [Matrix4<f32>; 3] = [
    Matrix4::new(
        0.0, 0.0, 0.0, 1.0,
        0.0, 0.0, -1.0, 0.0,
        0.0, 1.0, 0.0, 0.0,
        -1.0, 0.0, 0.0, 0.0,
    ),
    Matrix4::new(
        0.0, 0.0, 1.0, 0.0,
        0.0, 0.0, 0.0, 1.0,
        -1.0, 0.0, 0.0, 0.0,
        0.0, -1.0, 0.0, 0.0,
    ),
    Matrix4::new(
        0.0, -1.0, 0.0, 0.0,
        1.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 1.0,
        0.0, 0.0, -1.0, 0.0,
    ),
];

/// Sums over the pairs in the axis frames.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    /// `B`, weights summing to one.
    pub b: Matrix3<f32>,
    /// `1 - B33`, without the loss of digits.
    pub shortfall: f32,
    /// Mean squares of the distance of measured directions and of references from their axis.
    spread: [f32; 2],
    /// From the star path to its axis frame.
    pub measured_frame: Matrix3<f32>,
    /// From ICRS to its axis frame.
    pub reference_frame: Matrix3<f32>,
}

/// A rotation that takes `axis` to z.
fn axis_frame(axis: &Vector3<f32>) -> Matrix3<f32> {
    // The shortest way to z; from the lower half of the sphere to -z, and on by a half turn about x.
    let sign = if axis.z < 0.0 { -1.0 } else { 1.0 };
    let (x, y, z) = (axis.x * sign, axis.y * sign, axis.z * sign);
    let scale = 1.0 / (1.0 + z);
    Matrix3::new(
        1.0 - x * x * scale,
        -x * y * scale,
        -x,
        -x * y * scale * sign,
        (1.0 - y * y * scale) * sign,
        -y * sign,
        x * sign,
        y * sign,
        z * sign,
    )
}

/// `1 - b3 r3` for unit vectors, by their distances from z where both are near it.
fn shortfall(b: &Vector3<f32>, r: &Vector3<f32>) -> f32 {
    let product = b.z * r.z;
    if product <= 0.0 {
        return 1.0 - product;
    }
    let below = |v: &Vector3<f32>| (v.x * v.x + v.y * v.y) / (1.0 + libm::fabsf(v.z));
    below(b) + libm::fabsf(b.z) * below(r)
}

impl Profile {
    /// Sums the pairs.
    ///
    /// # Errors
    /// Too few pairs, or weights that are none.
    pub fn of<O: WeightedPair>(pairs: &[O]) -> Result<Self, WahbaError> {
        check(pairs)?;
        let first = pairs.first().ok_or(WahbaError::TooFew)?.pair().measured;
        let zero = (0.0, Vector3::zeros(), Vector3::zeros());
        let (total, measured, reference) = pairs.iter().map(O::pair).fold(zero, |(total, b, r), pair| {
            let weight = pair.weight();
            let signed = if pair.measured.dot(&first) < 0.0 { -weight } else { weight };
            (total + weight, b + pair.measured.vector() * signed, r + pair.reference.vector() * signed)
        });
        // References that cancel out belong to pairs that agree in nothing; any axis will do.
        let axis = |sum: Vector3<f32>| {
            Direction::<StarPath>::new(sum / total).map_or(Vector3::z(), |direction| *direction.vector())
        };
        let (measured_frame, reference_frame) = (axis_frame(&axis(measured)), axis_frame(&axis(reference)));
        let mut profile =
            Self { b: Matrix3::zeros(), shortfall: 0.0, spread: [0.0; 2], measured_frame, reference_frame };
        for pair in pairs.iter().map(O::pair) {
            let (b, r) = (measured_frame * pair.measured.vector(), reference_frame * pair.reference.vector());
            profile.add(&b, &r, pair.weight() / total);
        }
        Ok(profile)
    }

    fn add(&mut self, b: &Vector3<f32>, r: &Vector3<f32>, weight: f32) {
        self.b += b * r.transpose() * weight;
        self.shortfall += shortfall(b, r) * weight;
        let [measured, reference] = &mut self.spread;
        *measured += (b.x * b.x + b.y * b.y) * weight;
        *reference += (r.x * r.x + r.y * r.y) * weight;
    }

    /// Whether measured directions and references each spread over more than about 0.1 deg.
    pub fn is_wide(&self) -> bool {
        self.spread.iter().all(|spread| *spread > 2.0 * MIN_SPREAD)
    }

    /// The error of pairs whose two best attitudes fit equally well.
    pub fn fault(&self) -> WahbaError {
        if self.is_wide() { WahbaError::Ambiguous } else { WahbaError::Parallel }
    }

    /// `K - I` in the axis frames.
    pub fn shifted_k(&self) -> Matrix4<f32> {
        let b = &self.b;
        let (sum, difference) = (b.m11 + b.m22, b.m11 - b.m22);
        let (xy, xz, yz) = (b.m12 + b.m21, b.m13 + b.m31, b.m23 + b.m32);
        let (zx, zy, zz) = (b.m23 - b.m32, b.m31 - b.m13, b.m12 - b.m21);
        let low = self.shortfall - 2.0;
        Matrix4::new(
            difference + low,
            xy,
            xz,
            zx,
            xy,
            low - difference,
            yz,
            zy,
            xz,
            yz,
            -self.shortfall - sum,
            zz,
            zx,
            zy,
            zz,
            sum - self.shortfall,
        )
    }

    /// The attitude from that in the axis frames; `None` where the quaternion vanishes.
    pub fn attitude(&self, quaternion: &Vector4<f32>) -> Option<Rotation<Icrs, StarPath>> {
        let largest = quaternion.amax();
        if !(largest > 0.0 && largest < 1e30) {
            return None;
        }
        let scaled = quaternion / largest;
        let [x, y, z, w] = [scaled.x, scaled.y, scaled.z, scaled.w];
        let turn = Rotation::<Icrs, StarPath>::from_quaternion([x, y, z, w])?;
        let matrix = self.measured_frame.transpose() * turn.matrix() * self.reference_frame;
        Some(Rotation::from_orthogonal(matrix))
    }
}

/// The turn of the reference (a half turn or none) that puts the best element of K's diagonal last: `P`.
pub(super) fn half_turn(k: &Matrix4<f32>, better: impl Fn(f32, f32) -> bool) -> Matrix4<f32> {
    let mut best = (k.m44, Matrix4::identity());
    for (trace, turn) in [k.m11, k.m22, k.m33].into_iter().zip(HALF_TURNS) {
        if better(trace, best.0) {
            best = (trace, turn);
        }
    }
    best.1
}

/// The upper left 3 x 3 part of `-(K - I) - x I` and the last column of K: `[(lambda + tr B) I - S]` and `z`
/// of QUEST.
pub(super) fn partition(k: &Matrix4<f32>, loss: f32) -> (Matrix3<f32>, Vector3<f32>) {
    let m = Matrix3::new(
        -k.m11 - loss,
        -k.m12,
        -k.m13,
        -k.m21,
        -k.m22 - loss,
        -k.m23,
        -k.m31,
        -k.m32,
        -k.m33 - loss,
    );
    (m, Vector3::new(k.m14, k.m24, k.m34))
}

/// The matrix of cofactors, whose transpose is the adjugate.
pub(super) fn cofactors(m: &Matrix3<f32>) -> Matrix3<f32> {
    Matrix3::new(
        m.m22 * m.m33 - m.m23 * m.m32,
        m.m23 * m.m31 - m.m21 * m.m33,
        m.m21 * m.m32 - m.m22 * m.m31,
        m.m13 * m.m32 - m.m12 * m.m33,
        m.m11 * m.m33 - m.m13 * m.m31,
        m.m12 * m.m31 - m.m11 * m.m32,
        m.m12 * m.m23 - m.m13 * m.m22,
        m.m13 * m.m21 - m.m11 * m.m23,
        m.m11 * m.m22 - m.m12 * m.m21,
    )
}
