//! The limb cone in closed form: the plane through the tips of the rays' unit vectors.
//!
//! Christian and Robinson (2016) solve `H n = 1` with a ray `s` a row: the tips of a cone's unit vectors
//! lie in a plane. Here the plane is fitted about the rays' mean, `z = z0 + g · (x, y)` with z along the
//! mean ray, so that f32 suffices for an arc of 20 deg, for which `H' H` has a condition number of 1e6.
//!
//! Noise of the rays is noise of x and y too, an errors-in-variables bias that flattens the fitted plane:
//! for 20 deg of limb from GEO the distance is 2 % too large. A second pass therefore subtracts the noise's
//! covariance from the scatter matrix.

use super::rays::{Cone, Ray};
use super::shape::normal_basis;
use nalgebra::Vector3;

/// Least share of the scatter's determinant that must remain after subtraction of the noise; else the first
/// pass is the result. Chosen.
const LEAST_LEFT: f32 = 0.2;

/// Sums of second moments about the mean ray, in its frame.
#[derive(Clone, Copy, Default)]
struct Scatter {
    xx: f32,
    xy: f32,
    yy: f32,
    xz: f32,
    yz: f32,
}

impl Scatter {
    fn add(&mut self, v: &Vector3<f32>, weight: f32) {
        self.xx += weight * v.x * v.x;
        self.xy += weight * v.x * v.y;
        self.yy += weight * v.y * v.y;
        self.xz += weight * v.x * v.z;
        self.yz += weight * v.y * v.z;
    }

    fn determinant(&self) -> f32 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// The plane's slopes along x and y.
    fn slopes(&self) -> Option<(f32, f32)> {
        let determinant = self.determinant();
        if !(determinant > 1e-6 * self.xx * self.yy && determinant > 0.0) {
            return None;
        }
        let scale = 1.0 / determinant;
        Some((
            (self.xz * self.yy - self.yz * self.xy) * scale,
            (self.yz * self.xx - self.xz * self.xy) * scale,
        ))
    }
}

/// The cone through the rays whose bits are `chosen`, least squares; `None` for fewer than three or those
/// that fix none.
pub(super) fn fit(rays: &[Ray], chosen: u128) -> Option<Cone> {
    let mut bits = chosen;
    let rays = rays.iter().filter(move |_| {
        let is_chosen = bits & 1 != 0;
        bits >>= 1;
        is_chosen
    });
    let first = rays.clone().next()?.unit;
    // Weights against the first pixel's, so that sums stay near one.
    let weight = |ray: &Ray| 1.0 / (ray.sigma_px * ray.sigma_px);
    let (mut sum, mut total) = (Vector3::zeros(), 0.0);
    for ray in rays.clone() {
        sum += (ray.unit - first) * weight(ray);
        total += weight(ray);
    }
    let mean = first + sum * (1.0 / total);
    let square = mean.dot(&mean);
    // The mean of directions around the whole sky has no direction; no body is as large.
    if square.is_nan() || square <= 1e-4 {
        return None;
    }
    let z = mean * (1.0 / libm::sqrtf(square));
    let (x, y) = normal_basis(&z);
    let in_frame = |v: &Vector3<f32>| Vector3::new(x.dot(v), y.dot(v), z.dot(v));
    let mut scatter = Scatter::default();
    for ray in rays.clone() {
        scatter.add(&in_frame(&(ray.unit - mean)), weight(ray) / total);
    }
    let cone_of = |scatter: &Scatter| {
        let (along_x, along_y) = scatter.slopes()?;
        let normal = z - x * along_x - y * along_y;
        Cone::from_plane(&normal, normal.dot(&mean))
    };
    let cone = cone_of(&scatter)?;

    let mut left = scatter;
    for ray in rays {
        let (_, radial) = cone.residual(ray);
        // Noise displaces the ray on the sphere, across the limb.
        let outward = radial * cone.cosine - cone.axis * cone.sine;
        let noise_rad = ray.sigma_px * ray.rad_per_px;
        left.add(&in_frame(&outward), -noise_rad * noise_rad * weight(ray) / total);
    }
    if left.determinant() < LEAST_LEFT * scatter.determinant() {
        return Some(cone);
    }
    cone_of(&left).or(Some(cone))
}

#[cfg(test)]
mod tests;
