//! Limb points as rays in sphere space, and the limb cone with its residuals.
//!
//! The residual of a ray is the sine of its angle beyond the cone, `|w × s| cos θ - (w · s) sin θ`, where
//! `w` is the unit vector to the centre and `θ` the cone's half angle. Both terms are small where the cone
//! is narrow, so f32 resolves 3e-4 px at any distance; `n · s - 1` would not. Relation to the vector `n` of
//! Christian and Robinson: `n = w / cos θ`, `|n| > 1`.

use super::shape::{Body, unit};
use super::{LimbPoint, MAX_SEARCH_POINTS};
use crate::camera::Camera;
use heapless::Vec;
use nalgebra::Vector3;

/// A limb point in sphere space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Unit vector.
    pub(super) unit: Vector3<f32>,
    /// Its derivative by a pixel outward along the line of measurement.
    pub(super) outward: Vector3<f32>,
    /// Angle of a pixel there, rad, mean of its two sides.
    pub(super) rad_per_px: f32,
    /// Standard deviation along the line of measurement, px.
    pub(super) sigma_px: f32,
    /// Index of the limb point.
    pub(super) index: u8,
}

/// Half of the distance over which slopes on the sky are taken, px: f32 leaves an error of 3e-5 of them.
const SLOPE_BASE_PX: f32 = 4.0;

/// All rays of a second.
pub(super) type Rays = Vec<Ray, MAX_SEARCH_POINTS>;

/// A ray as it departs from a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departure {
    /// Residual, rad.
    pub(super) residual: f32,
    /// Unit vector across the axis.
    pub(super) radial: Vector3<f32>,
    /// Residual over its standard deviation and that, rad; `None` of a line of measurement nearly along the
    /// limb, which has no information.
    pub(super) normalised: Option<(f32, f32)>,
}

/// Those of all rays of a second, in their order.
pub(super) type Departures = Vec<Departure, MAX_SEARCH_POINTS>;

/// Fills the list with the points that are finite and within the camera's field.
pub(super) fn fill(rays: &mut Rays, points: &[LimbPoint], camera: &Camera, body: &Body) {
    rays.clear();
    for (index, point) in points.iter().enumerate().take(MAX_SEARCH_POINTS) {
        if let Some(ray) = Ray::new(point, index as u8, camera, body) {
            // The list holds MAX_SEARCH_POINTS.
            let _ = rays.push(ray);
        }
    }
}

impl Ray {
    pub(super) fn new(point: &LimbPoint, index: u8, camera: &Camera, body: &Body) -> Option<Self> {
        let LimbPoint { centre_px: [x, y], sigma_px, outward_px: [nx, ny], .. } = *point;
        let norm = nx * nx + ny * ny;
        if !(sigma_px > 1e-4 && sigma_px < 1e3 && norm > 0.9 && norm < 1.1) {
            return None;
        }
        let at = |x: f32, y: f32| {
            let seen = camera.earth_direction([x, y])?;
            Some(unit(&body.in_sphere_space(seen.vector()), seen.vector()))
        };
        let centre = at(x, y)?;
        let base = SLOPE_BASE_PX;
        let slope = |dx: f32, dy: f32| {
            Some((at(x + base * dx, y + base * dy)? - at(x - base * dx, y - base * dy)?) * (0.5 / base))
        };
        let (outward, aside) = (slope(nx, ny)?, slope(-ny, nx)?);
        let area = outward.cross(&aside);
        let rad_per_px = libm::sqrtf(libm::sqrtf(area.dot(&area)));
        (rad_per_px > 1e-8).then_some(Self { unit: centre, outward, rad_per_px, sigma_px, index })
    }

    /// Standard deviation of the residual, rad, where the bright side faces the centre; `radial` is the ray's
    /// unit vector across the axis.
    pub(super) fn sigma_rad(&self, cone: &Cone, radial: &Vector3<f32>) -> Option<f32> {
        let slope = self.outward.dot(&(radial * cone.cosine - cone.axis * cone.sine));
        // A line of measurement nearly along the limb has no information.
        (slope > LEAST_STEEPNESS * self.rad_per_px).then_some(slope * self.sigma_px)
    }
}

/// Least cosine between the line of measurement and the limb's normal: 75 deg, where a pixel's error counts
/// four times.
const LEAST_STEEPNESS: f32 = 0.25;

/// The limb as a cone in sphere space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// Unit vector to the centre.
    pub(super) axis: Vector3<f32>,
    /// Sine and cosine of the half angle; both positive.
    pub(super) sine: f32,
    pub(super) cosine: f32,
}

/// Nearest and farthest centre, radii: 20 km above the Earth and a million km from it.
const LEAST_RADII: f32 = 1.003;
const MOST_RADII: f32 = 157.0;

impl Cone {
    /// From the plane `normal · s = offset` through the tips of its unit vectors, `normal` of any length;
    /// `None` outside [`LEAST_RADII`] to [`MOST_RADII`].
    pub(super) fn from_plane(normal: &Vector3<f32>, offset: f32) -> Option<Self> {
        let square = normal.dot(normal);
        if !(square > 1e-30 && square < 1e30) {
            return None;
        }
        let scale = if offset < 0.0 { -1.0 } else { 1.0 } / libm::sqrtf(square);
        let (axis, cosine) = (normal * scale, offset * scale);
        Self::from_parts(axis, libm::sqrtf((1.0 - cosine * cosine).max(0.0)), cosine)
    }

    /// From its parts; `None` outside the limits, or not finite.
    pub(super) fn from_parts(axis: Vector3<f32>, sine: f32, cosine: f32) -> Option<Self> {
        let possible = sine > 1.0 / MOST_RADII && sine < 1.0 / LEAST_RADII && cosine > 0.0;
        possible.then_some(Self { axis, sine, cosine })
    }

    /// The limb cone about a centre, from the vector to it, km; `None` where the centre cannot be: see
    /// [`Body::limb_cone`].
    pub(super) fn about(centre_km: &Vector3<f32>, body: &Body) -> Option<Self> {
        let (centre, sine, cosine) = body.limb_cone(centre_km)?;
        Self::from_parts(centre * sine, sine, cosine)
    }

    /// Residual of a ray, rad, and its unit vector across the axis.
    pub(super) fn residual(&self, ray: &Ray) -> (f32, Vector3<f32>) {
        let turned = self.axis.cross(&ray.unit);
        let off = libm::sqrtf(turned.dot(&turned));
        let residual = off * self.cosine - self.axis.dot(&ray.unit) * self.sine;
        // Across the axis without the loss of `s - w (w · s)`.
        (residual, unit(&turned.cross(&self.axis), &turned))
    }

    /// How a ray departs from it.
    pub(super) fn departure(&self, ray: &Ray) -> Departure {
        let (residual, radial) = self.residual(ray);
        let normalised = ray.sigma_rad(self, &radial).map(|sigma| (residual / sigma, sigma));
        Departure { residual, radial, normalised }
    }

    /// Vector from the centre to the limb point at a radial vector, radii.
    pub(super) fn surface(&self, radial: &Vector3<f32>) -> Vector3<f32> {
        radial * self.cosine - self.axis * self.sine
    }
}
