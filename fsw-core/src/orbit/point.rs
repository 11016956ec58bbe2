//! One Earth vector and one attitude make a position (thesis §5.1).
//!
//! In: the vector from the satellite to the Earth's centre in the Earth path (km, with covariance), the attitude of the
//! star path (with covariance) and the mounting of the paths; out: position and covariance, km and km², ICRS axes.
//! `r = -A_SIᵀ T_SE r_E` (eq. 5.4). Its covariance (eq. 5.9) has two parts, turned into ICRS: that of the Earth vector, and
//! that of the attitude, `[s×] P [s×]ᵀ` with `s` the Earth vector in the star path: together eq. 5.12 for any attitude and axis. The
//! term of the second order ([`second_order_km2`], eq. 5.13) is the product of both errors, 1e-3 of these, and not in the fix. Both
//! are within 5 % of Monte Carlo (`point/tests.rs`).
//!
//! Rounding: f32 in the attitude costs up to 7e-7 of the distance (30 m in GEO), changing from second to second.

use super::constants::LIGHT_KM_S;
use super::finite;
use super::matrix::{cross_matrix, product, symmetric, turned};
use crate::frames::{EarthPath, Icrs, Rotation, StarPath};
use crate::trigonometry::sine_cosine;
use nalgebra::{Matrix3, Vector3};

/// A position as seen at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionFix {
    /// From the Earth's centre to the satellite, km, ICRS axes.
    pub position_km: Vector3<f64>,
    /// Its covariance, km².
    pub covariance_km2: Matrix3<f64>,
    /// The position at which that covariance was made, km: `position_km`, or where the measurement was made linear.
    pub place_km: Vector3<f64>,
}

impl PositionFix {
    /// From the Earth vector `earth_km` (to the Earth's centre, in the Earth path), its covariance and the vector
    /// `place_km` for which that was made, the attitude with the covariance of its rotation vector in the star path (rad²), and
    /// the mounting. `None` when anything is not finite.
    pub fn new(
        earth_km: &Vector3<f32>,
        earth_covariance_km2: &Matrix3<f32>,
        place_km: &Vector3<f32>,
        attitude: &Rotation<Icrs, StarPath>,
        attitude_covariance_rad2: &Matrix3<f32>,
        mounting: &Rotation<EarthPath, StarPath>,
    ) -> Option<Self> {
        let to_icrs = earth_to_icrs(attitude, mounting);
        let place_km = place_km.map(f64::from);
        // In the Earth path throughout: the attitude's covariance is turned there, then all at once into ICRS.
        let mounting = mounting.matrix().map(f64::from);
        let attitude_part = turned(&mounting.transpose(), &attitude_covariance_rad2.map(f64::from));
        let lever = cross_matrix(&place_km);
        let covariance = earth_covariance_km2.map(f64::from) + turned(&lever, &attitude_part);
        let fix = Self {
            position_km: -(to_icrs * earth_km.map(f64::from)),
            covariance_km2: symmetric(&turned(&to_icrs, &covariance)),
            place_km: -(to_icrs * place_km),
        };
        (finite(&fix.position_km)
            && finite(&fix.place_km)
            && fix.covariance_km2.iter().all(|x| x.is_finite()))
        .then_some(fix)
    }
}

impl PositionFix {
    /// The fix without the aberration of the Earth's image: a satellite that moves with `velocity_km_s` about the Earth sees
    /// it displaced by `v / c` along its flight (5 arcsec in a low orbit, 180 m), hence itself displaced backwards.
    pub fn without_aberration(mut self, velocity_km_s: &Vector3<f64>) -> Self {
        let distance_km = libm::sqrt(self.place_km.dot(&self.place_km));
        let up = self.place_km / distance_km.max(1.0);
        let shift_km = (velocity_km_s - up * up.dot(velocity_km_s)) * (distance_km / LIGHT_KM_S);
        self.position_km += shift_km;
        self.place_km += shift_km;
        self
    }
}

/// The term of the second order in the covariance of a position (eq. 5.13), km², ICRS axes: that of `ψ × δ`, the attitude's error
/// times the Earth vector's, which are independent, `Σ P_ij [e_i×] C [e_j×]ᵀ`. In flight it is left out.
pub fn second_order_km2(
    earth_covariance_km2: &Matrix3<f32>,
    attitude: &Rotation<Icrs, StarPath>,
    attitude_covariance_rad2: &Matrix3<f32>,
    mounting: &Rotation<EarthPath, StarPath>,
) -> Matrix3<f64> {
    let to_star = mounting.matrix().map(f64::from);
    let earth = to_star * earth_covariance_km2.map(f64::from) * to_star.transpose();
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| cross_matrix(&axis));
    let p = attitude_covariance_rad2.map(f64::from);
    let own = |axis: &Matrix3<f64>, variance: f64| axis * earth * axis.transpose() * variance;
    let mixed = |one: &Matrix3<f64>, other: &Matrix3<f64>, covariance: f64| {
        symmetric(&(one * earth * other.transpose())) * (2.0 * covariance)
    };
    let in_star = own(&x, p.m11)
        + own(&y, p.m22)
        + own(&z, p.m33)
        + mixed(&x, &y, p.m12)
        + mixed(&x, &z, p.m13)
        + mixed(&y, &z, p.m23);
    let to_icrs = attitude.matrix().map(f64::from).transpose();
    symmetric(&(to_icrs * in_star * to_icrs.transpose()))
}

/// The rotation from the Earth path to ICRS, f64, made orthogonal again after f32 by one step of Newton's iteration
/// `A (3 I - Aᵀ A) / 2`, so that it does not scale distances.
pub fn earth_to_icrs(
    attitude: &Rotation<Icrs, StarPath>,
    mounting: &Rotation<EarthPath, StarPath>,
) -> Matrix3<f64> {
    let a = product(&attitude.matrix().map(f64::from).transpose(), &mounting.matrix().map(f64::from));
    product(&a, &(Matrix3::identity() * 3.0 - product(&a.transpose(), &a))) * 0.5
}

/// Distance from the Earth's centre at which a sphere of `radius_km` fills a cone of this half angle, km:
/// `R / sin ρ` (eq. 2.8). `None` outside 0 to 90 degrees.
pub fn distance_km(apparent_radius_rad: f32, radius_km: f32) -> Option<f32> {
    (apparent_radius_rad > 1e-4 && apparent_radius_rad < core::f32::consts::FRAC_PI_2 && radius_km > 0.0)
        .then(|| radius_km / sine_cosine(apparent_radius_rad).0)
}

#[cfg(test)]
mod tests;
