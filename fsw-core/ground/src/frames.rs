//! Directions and rotations typed by their frame, and words that several rooms use.
//!
//! A quaternion is `[x, y, z, w]`, scalar last (thesis eq. 3.3). Its matrix (eq. 2.4) is
//! `A(q) = (w² - |v|²) I + 2 v vᵀ - 2 w [v×]`; it takes components in the `From` frame to components in the
//! `To` frame, `b = A r` (eq. 2.2). Frames are empty types, so that a direction on the sky cannot be fed
//! where one on the detector is meant.
//!
//! Rounding (greatest over 20,000 random rotations): an element of the matrix of a quaternion 7e-7, a
//! quaternion through its matrix and back 5e-7, half turns included.

use core::marker::PhantomData;
use nalgebra::{Matrix3, Vector3};

/// International Celestial Reference System, epoch of the mission catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Icrs;

/// The sensor's star path: x along +x px (along -x px where a mirror turns the image over), y along +y px, z
/// out along the line of sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StarPath;

/// The sensor's Earth path: x along +x px, y along +y px, z out along its line of sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EarthPath;

/// Local vertical, local horizontal: z down to the Earth's centre, y against the orbit's normal, x along the
/// flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lvlh;

/// Arcseconds in a radian.
pub const ARCSEC_PER_RAD: f32 = 206_264.8;

/// A unit vector with components in the frame `F`, f32 (rounding 0.012 arcsec).
#[derive(Debug)]
pub struct Direction<F> {
    unit: Vector3<f32>,
    frame: PhantomData<F>,
}

impl<F> Clone for Direction<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Direction<F> {}

impl<F> Direction<F> {
    /// Normalises `vector`; `None` when it is not finite or shorter than 1e-6.
    pub fn new(vector: Vector3<f32>) -> Option<Self> {
        let square = vector.dot(&vector);
        // The comparison also refuses NaN; the upper bound refuses overflow to infinity.
        if square > 1e-12 && square < 1e30 {
            Some(Self { unit: vector * (1.0 / libm::sqrtf(square)), frame: PhantomData })
        } else {
            None
        }
    }

    /// From fixed-point components, Q1.30, already of unit length (catalogue).
    pub fn from_q30(components: [i32; 3]) -> Self {
        const SCALE: f32 = 1.0 / (1u32 << 30) as f32;
        let [x, y, z] = components;
        Self { unit: Vector3::new(x as f32, y as f32, z as f32) * SCALE, frame: PhantomData }
    }

    /// From a vector that the caller knows to be of unit length.
    pub fn from_unit(unit: Vector3<f32>) -> Self {
        Self { unit, frame: PhantomData }
    }

    /// The line of sight, (0, 0, 1).
    pub fn z() -> Self {
        Self { unit: Vector3::new(0.0, 0.0, 1.0), frame: PhantomData }
    }

    /// The components.
    pub fn vector(&self) -> &Vector3<f32> {
        &self.unit
    }

    /// Cosine of the angle to `other`.
    pub fn dot(&self, other: &Self) -> f32 {
        self.unit.dot(&other.unit)
    }

    /// Chord to `other`, `2 sin(angle / 2)`: the separation without a loss of digits at small angles.
    pub fn chord(&self, other: &Self) -> f32 {
        let difference = self.unit - other.unit;
        libm::sqrtf(difference.dot(&difference))
    }
}

/// A rotation that takes components in `From` to components in `To`.
#[derive(Debug)]
pub struct Rotation<From, To> {
    matrix: Matrix3<f32>,
    frames: PhantomData<(From, To)>,
}

impl<From, To> Clone for Rotation<From, To> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<From, To> Copy for Rotation<From, To> {}

impl<From, To> Rotation<From, To> {
    /// From a direction cosine matrix that the caller knows to be orthogonal with determinant +1.
    pub fn from_orthogonal(matrix: Matrix3<f32>) -> Self {
        Self { matrix, frames: PhantomData }
    }

    /// From a quaternion `[x, y, z, w]`, normalised here; `None` when it is not finite or zero.
    pub fn from_quaternion(quaternion: [f32; 4]) -> Option<Self> {
        let [x, y, z, w] = quaternion;
        let square = x * x + y * y + z * z + w * w;
        if !(square > 1e-12 && square < 1e30) {
            return None;
        }
        let scale = 1.0 / libm::sqrtf(square);
        let (x, y, z, w) = (x * scale, y * scale, z * scale, w * scale);
        Some(Self::from_orthogonal(Matrix3::new(
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + z * w),
            2.0 * (x * z - y * w),
            2.0 * (x * y - z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + x * w),
            2.0 * (x * z + y * w),
            2.0 * (y * z - x * w),
            1.0 - 2.0 * (x * x + y * y),
        )))
    }

    /// The quaternion `[x, y, z, w]` with `w >= 0`, by the largest of the four squared components (no loss of
    /// digits near 180 degrees).
    pub fn quaternion(&self) -> [f32; 4] {
        let m = &self.matrix;
        let squares = [
            1.0 + m.m11 - m.m22 - m.m33,
            1.0 - m.m11 + m.m22 - m.m33,
            1.0 - m.m11 - m.m22 + m.m33,
            1.0 + m.m11 + m.m22 + m.m33,
        ];
        let (dx, dy, dz) = (m.m23 - m.m32, m.m31 - m.m13, m.m12 - m.m21);
        let (sxy, sxz, syz) = (m.m12 + m.m21, m.m13 + m.m31, m.m23 + m.m32);
        let q = if squares[3] >= 1.0 {
            [dx, dy, dz, squares[3]]
        } else if squares[0] >= squares[1] && squares[0] >= squares[2] {
            [squares[0], sxy, sxz, dx]
        } else if squares[1] >= squares[2] {
            [sxy, squares[1], syz, dy]
        } else {
            [sxz, syz, squares[2], dz]
        };
        let norm = libm::sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        let scale = if q[3] < 0.0 { -1.0 / norm } else { 1.0 / norm };
        q.map(|component| component * scale)
    }

    /// The direction cosine matrix.
    pub fn matrix(&self) -> &Matrix3<f32> {
        &self.matrix
    }

    /// The direction in the `To` frame.
    pub fn apply(&self, direction: &Direction<From>) -> Direction<To> {
        Direction { unit: self.matrix * direction.unit, frame: PhantomData }
    }

    /// The rotation back.
    pub fn inverse(&self) -> Rotation<To, From> {
        Rotation::from_orthogonal(self.matrix.transpose())
    }

    /// First this rotation, then `next`.
    pub fn then<Next>(&self, next: &Rotation<To, Next>) -> Rotation<From, Next> {
        Rotation::from_orthogonal(next.matrix * self.matrix)
    }

    /// Follows this rotation by the rotation of the `To` frame about `angle_rad` (a rotation vector of up to
    /// 180 degrees): `A' = exp(-[θ×]) A`. A vector that is not finite turns nothing.
    ///
    /// No sine: `tan(x) / x` of half the angle is `(945 - 105 x² + x⁴) / (945 - 420 x² + 15 x⁴)`, whose
    /// numerator and denominator make a quaternion. Error 3e-7 rad (rounding) up to 109 degrees, 2e-5 rad at
    /// 180 degrees. Orthogonality drifts by 2e-6 in a thousand turns.
    pub fn turned(&self, angle_rad: &Vector3<f32>) -> Self {
        let half = angle_rad * 0.5;
        let square = half.dot(&half);
        let sine = half * (945.0 - square * (105.0 - square));
        let cosine = 945.0 - square * (420.0 - 15.0 * square);
        match Rotation::<To, To>::from_quaternion([sine.x, sine.y, sine.z, cosine]) {
            Some(step) => self.then(&step),
            None => *self,
        }
    }

    /// The rotation vector, rad, that turns `before` into this rotation: `before.turned(&v)` is this one.
    /// Angles up to 180 degrees, axis in the `To` frame.
    pub fn angle_from(&self, before: &Self) -> Vector3<f32> {
        let [x, y, z, w] = before.inverse().then(self).quaternion();
        let sine = libm::sqrtf(x * x + y * y + z * z);
        let scale = if sine > 1e-6 { 2.0 * libm::atan2f(sine, w) / sine } else { 2.0 };
        Vector3::new(x * scale, y * scale, z * scale)
    }
}

/// Height of the limb at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbHeight {
    /// Unit vector to the point, across the direction to the centre, Earth path's frame, sphere space.
    pub radial: Vector3<f32>,
    /// Above the limb predicted, km of sphere space: the sine of the angle beyond it times its distance.
    pub height_km: f32,
    /// Standard deviation by the point's own sigma, km.
    pub sigma_km: f32,
}

#[cfg(test)]
mod tests;
