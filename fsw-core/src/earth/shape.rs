//! The body's shape: transformation between space and sphere space.
//!
//! `S v = v + (a / b - 1) p (p · v)` with the pole `p` and the half axes `a`, `b`, limb height included,
//! turns the ellipsoid into a sphere of radius `a`. Up to a rotation `S / a` is the matrix B of Christian and
//! Robinson ("Noniterative horizon-based optical navigation by Cholesky factorization", J. Guidance 39,
//! 2016), but it is symmetric and needs no axes on the equator. Lengths in sphere space are in units of `a`.
//! A surface at constant height over the ellipsoid is taken for an ellipsoid: error 0.0002 of the height for
//! the Earth.

use super::{EarthParameters, Ellipsoid};
use crate::frames::{Direction, EarthPath};
use nalgebra::{Matrix3, Vector3};

/// The body in the Earth path's frame: shape with limb height, pole and Sun.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Half axis on the equator, limb height included, km.
    radius_km: f32,
    /// `a / b - 1`.
    stretch: f32,
    /// `b / a - 1`.
    shrink: f32,
    pole: Vector3<f32>,
    sun: Option<Vector3<f32>>,
}

impl Body {
    /// From the directions of pole and Sun; without the Sun every limb counts as lit.
    pub fn new(
        pole: &Direction<EarthPath>,
        sun: Option<&Direction<EarthPath>>,
        parameters: &EarthParameters,
    ) -> Self {
        Self::at_height(pole, sun, &parameters.ellipsoid, parameters.limb.height_km)
    }

    /// The same whose limb is `height_km` above the ellipsoid; 0: the solid body.
    pub fn at_height(
        pole: &Direction<EarthPath>,
        sun: Option<&Direction<EarthPath>>,
        ellipsoid: &Ellipsoid,
        height_km: f32,
    ) -> Self {
        let (a, b) = (ellipsoid.equatorial_km + height_km, ellipsoid.polar_km + height_km);
        Self {
            radius_km: a,
            stretch: (a - b) / b,
            shrink: (b - a) / a,
            pole: *pole.vector(),
            sun: sun.map(|sun| *sun.vector()),
        }
    }

    /// The same with the Sun not known.
    #[cfg(test)]
    pub(super) fn without_sun(&self) -> Self {
        Self { sun: None, ..*self }
    }

    /// Whether the Sun's direction is known.
    pub(super) fn has_sun(&self) -> bool {
        self.sun.is_some()
    }

    /// Half axis on the equator, limb height included, km: the unit of length of sphere space.
    pub(crate) fn radius_km(&self) -> f32 {
        self.radius_km
    }

    /// Into sphere space (of a vector in units of the radius).
    pub(super) fn in_sphere_space(&self, vector: &Vector3<f32>) -> Vector3<f32> {
        vector + self.pole * (self.stretch * self.pole.dot(vector))
    }

    /// Out of sphere space.
    pub(super) fn in_space(&self, vector: &Vector3<f32>) -> Vector3<f32> {
        vector + self.pole * (self.shrink * self.pole.dot(vector))
    }

    /// The centre in sphere space, radii, and sine and cosine of the limb cone's half angle, from the vector
    /// to the centre, km. `None` when that is not finite, inside the body, or more than a thousand radii
    /// away.
    pub(super) fn limb_cone(&self, centre_km: &Vector3<f32>) -> Option<(Vector3<f32>, f32, f32)> {
        let centre = self.in_sphere_space(&(centre_km * (1.0 / self.radius_km)));
        let square = centre.dot(&centre);
        // Also refuses NaN.
        if !(square > 1.0 + 1e-4 && square < 1e6) {
            return None;
        }
        let sine = 1.0 / libm::sqrtf(square);
        Some((centre, sine, libm::sqrtf(square - 1.0) * sine))
    }

    /// Upward normal, of any length, at the surface point whose vector from the centre is `point` in sphere
    /// space.
    pub(super) fn upward(&self, point: &Vector3<f32>) -> Vector3<f32> {
        // The gradient of x² + y² + (a z / b)² is S S x, and S x is the point of sphere space.
        self.in_sphere_space(point)
    }

    /// Sine of the Sun's elevation at the surface point whose vector from the centre is `point` in sphere
    /// space; `None` where the Sun is not known.
    pub(super) fn sun_sine(&self, point: &Vector3<f32>) -> Option<f32> {
        let normal = self.upward(point);
        self.sun.map(|sun| normal.dot(&sun) / libm::sqrtf(normal.dot(&normal).max(1e-12)))
    }

    /// Cosine of the angle between a direction and the Sun's.
    pub(super) fn sun_cosine(&self, direction: &Direction<EarthPath>) -> Option<f32> {
        self.sun.map(|sun| sun.dot(direction.vector()))
    }
}

/// Unit vector along `vector`; its first argument where it is too short to have one.
pub(super) fn unit(vector: &Vector3<f32>, otherwise: &Vector3<f32>) -> Vector3<f32> {
    let square = vector.dot(vector);
    if square > 1e-20 { vector * (1.0 / libm::sqrtf(square)) } else { *otherwise }
}

/// `one · (matrix other)`.
#[inline(never)]
pub(super) fn bilinear(one: &Vector3<f32>, matrix: &Matrix3<f32>, other: &Vector3<f32>) -> f32 {
    one.dot(&(matrix * other))
}

/// Two unit vectors across a unit vector, right-handed with it.
pub(super) fn normal_basis(axis: &Vector3<f32>) -> (Vector3<f32>, Vector3<f32>) {
    let aside = if axis.x * axis.x < 0.5 { Vector3::new(1.0, 0.0, 0.0) } else { Vector3::new(0.0, 1.0, 0.0) };
    let first = unit(&(aside - axis * axis.dot(&aside)), &aside);
    (first, axis.cross(&first))
}

#[cfg(test)]
mod tests;
