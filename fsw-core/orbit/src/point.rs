//! A position from one Earth vector and one attitude (thesis §5.1).
//!
//! In: the vector from the satellite to the Earth's centre in the Earth path (km, with covariance), the
//! attitude of the star path (with covariance) and the mounting of the paths; out: position and covariance,
//! km and km², ICRS axes. `r = -A_SIᵀ T_SE r_E` (eq. 5.4). Its covariance (eq. 5.9) has two parts, turned
//! into ICRS: that of the Earth vector, and that of the attitude, `[s×] P [s×]ᵀ` with `s` the Earth vector in
//! the star path: together eq. 5.12 for any attitude and axis. The term of the second order (eq. 5.13) is the
//! product of both errors, 1e-3 of these, and not in the fix. With it and without the covariance is within 5 %
//! of Monte Carlo (`point/tests.rs`).
//!
//! Rounding: f32 in the attitude costs up to 7e-7 of the distance (30 m in GEO), changing from second to
//! second.

use super::constants::LIGHT_KM_S;
use super::finite;
use fsw_ground::frames::{EarthPath, Icrs, Rotation, StarPath};
use fsw_ground::matrix::{
    add_scaled, add_to_diagonal, cross_matrix, dot, plus_scaled, product, product_transposed, scaled,
    symmetric_product, transposed_product,
};
use fsw_ground::trigonometry::sine_cosine;
use nalgebra::{Matrix3, Vector3};

/// A position measured at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionFix {
    /// From the Earth's centre to the satellite, km, ICRS axes.
    pub position_km: Vector3<f64>,
    /// Covariance of its noise, independent from fix to fix, km².
    pub covariance_km2: Matrix3<f64>,
    /// Covariance of the errors that successive fixes share, km².
    pub shared_km2: Matrix3<f64>,
    /// The position to which the covariance refers, km: `position_km`, or where the measurement was
    /// linearised.
    pub linearisation_km: Vector3<f64>,
}

impl PositionFix {
    /// From the Earth vector `earth_km` (to the Earth's centre, in the Earth path), the covariances of its
    /// noise and of what successive ones share, and the vector `linearisation_km` for which these were
    /// made, the rotation from the Earth path to ICRS ([`earth_to_icrs`]), the covariance of the attitude's
    /// rotation vector in the star path (rad²), and the mounting. `None` when anything is not finite.
    #[inline(never)]
    pub fn new(
        earth_km: &Vector3<f32>,
        [noise_km2, shared_km2]: [&Matrix3<f32>; 2],
        linearisation_km: &Vector3<f32>,
        to_icrs: &Matrix3<f64>,
        attitude_covariance_rad2: &Matrix3<f32>,
        mounting: &Rotation<EarthPath, StarPath>,
    ) -> Option<Self> {
        let linearisation_km = linearisation_km.map(f64::from);
        // In the Earth path: the attitude's covariance is rotated there, then the sum into ICRS.
        let mounting = mounting.matrix().map(f64::from);
        let lever = product_transposed(&cross_matrix(&linearisation_km), &mounting);
        let mut covariance_km2 = symmetric_product(&lever, &attitude_covariance_rad2.map(f64::from));
        add_scaled(&mut covariance_km2, 1.0, &noise_km2.map(f64::from));
        let to_satellite = scaled(to_icrs, -1.0);
        let fix = Self {
            position_km: product(&to_satellite, &earth_km.map(f64::from)),
            covariance_km2: symmetric_product(to_icrs, &covariance_km2),
            shared_km2: symmetric_product(to_icrs, &shared_km2.map(f64::from)),
            linearisation_km: product(&to_satellite, &linearisation_km),
        };
        (finite(&fix.position_km)
            && finite(&fix.linearisation_km)
            && fix.covariance_km2.iter().chain(fix.shared_km2.iter()).all(|x| x.is_finite()))
        .then_some(fix)
    }
}

impl PositionFix {
    /// The fix corrected for the aberration of the Earth's image: moving with `velocity_km_s`, the image is
    /// displaced by `v / c` along the velocity (5 arcsec in a low orbit), and the fix backwards (180 m).
    pub fn without_aberration(mut self, velocity_km_s: &Vector3<f64>) -> Self {
        let distance_km = libm::sqrt(dot(&self.linearisation_km, &self.linearisation_km));
        let up = scaled(&self.linearisation_km, 1.0 / distance_km.max(1.0));
        let across_km_s = plus_scaled(velocity_km_s, -dot(&up, velocity_km_s), &up);
        for position_km in [&mut self.position_km, &mut self.linearisation_km] {
            add_scaled(position_km, distance_km / LIGHT_KM_S, &across_km_s);
        }
        self
    }
}

/// The rotation from the Earth path to ICRS, f64, made orthogonal again after f32 by one step of Newton's
/// iteration `A (3 I - Aᵀ A) / 2`, so that it does not scale distances.
#[inline(never)]
pub fn earth_to_icrs(
    attitude: &Rotation<Icrs, StarPath>,
    mounting: &Rotation<EarthPath, StarPath>,
) -> Matrix3<f64> {
    let a = transposed_product(&attitude.matrix().map(f64::from), &mounting.matrix().map(f64::from));
    let mut factor = scaled(&transposed_product(&a, &a), -0.5);
    add_to_diagonal(&mut factor, 1.5);
    product(&a, &factor)
}

/// Distance from the Earth's centre at which a sphere of `radius_km` fills a cone of this half angle, km:
/// `R / sin ρ` (eq. 2.8). `None` outside 0 to 90 degrees.
pub fn distance_km(apparent_radius_rad: f32, radius_km: f32) -> Option<f32> {
    (apparent_radius_rad > 1e-4 && apparent_radius_rad < core::f32::consts::FRAC_PI_2 && radius_km > 0.0)
        .then(|| radius_km / sine_cosine(apparent_radius_rad).0)
}

#[cfg(test)]
mod tests;
