//! What a fix says of the state: its model, its noise at the predicted place, its innovation.
//!
//! In: a [`PositionFix`], the predicted position and limb height, the rotation from the Earth path to ICRS; out: an
//! [`Innovation`], km.
//!
//! A fix is modelled as `z = r (1 - h/a) + r × (R m) + b + noise`. A limb that stands higher by `h` makes the Earth look larger by
//! the same factor at every point of the limb, hence nearer, `a` being the equatorial radius. `m` is the misalignment of the
//! two paths, a rotation vector in the Earth path: `R (I + [m×])` is the true rotation to ICRS. `b` is what clouds and the
//! slant of the light do to the limb: it has the shape of the fix's own covariance and changes slowly.
//!
//! The covariance of a fix is found by whoever measured it, at the *measured* place: it is long along the measured line and
//! scales with the measured distance, so its weights are correlated with its errors and would pull the estimate by about
//! `sigma² / r` of the single fix. It is therefore turned and scaled to the predicted place first.

use super::constants::EARTH_RADIUS_KM;
use super::covariance::{Sensitivity, is_covariance};
use super::dynamics::plausible;
use super::finite;
use super::point::{PositionFix, cross_matrix, symmetric};
use nalgebra::{Matrix3, Vector3};

/// Why a fix was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Something in it is not finite, or no satellite can be there.
    Impossible,
    /// Its covariance is not positive definite.
    Covariance,
}

/// A measured less a predicted position.
#[derive(Clone, Copy, Debug)]
pub struct Innovation {
    /// What it depends on.
    pub sensitivity: Sensitivity,
    /// Covariance of its noise, km².
    pub noise_km2: Matrix3<f64>,
    /// The difference, km.
    pub innovation_km: Vector3<f64>,
}

impl Innovation {
    /// Of a fix against a predicted position and limb height; `unit` takes its direction alone (eq. 5.25).
    pub fn of(
        fix: &PositionFix,
        position_km: &Vector3<f64>,
        limb_height_km: f64,
        earth_to_icrs: &Matrix3<f64>,
        unit: bool,
    ) -> Self {
        let mut sensitivity = sensitivity(position_km, limb_height_km, earth_to_icrs);
        let predicted = sensitivity.position * position_km;
        let mut noise_km2 = carried(fix, &predicted);
        let mut innovation_km = fix.position_km - predicted;
        if unit {
            // Only what lies across the line: measured direction times predicted distance. The component along the line
            // is made a measurement of nothing, with unit variance and no innovation.
            let square = predicted.dot(&predicted);
            let along = predicted * predicted.transpose() / square;
            let across = Matrix3::identity() - along;
            let measured = libm::sqrt(fix.position_km.dot(&fix.position_km));
            innovation_km = across * fix.position_km * (libm::sqrt(square) / measured);
            noise_km2 = symmetric(&(across * noise_km2 * across)) + along;
            sensitivity.position = across * sensitivity.position;
            sensitivity.limb_height = Vector3::zeros();
            sensitivity.bias = across;
        }
        Self { sensitivity, noise_km2, innovation_km }
    }
}

/// Whether this can be a fix.
pub(super) fn check(fix: &PositionFix, earth_to_icrs: &Matrix3<f64>) -> Result<(), Refusal> {
    if !plausible(&fix.position_km, &Vector3::zeros()) || !earth_to_icrs.iter().all(|x| x.is_finite()) {
        return Err(Refusal::Impossible);
    }
    if is_covariance(&fix.covariance_km2) { Ok(()) } else { Err(Refusal::Covariance) }
}

/// What a fix at `position_km` depends on.
pub(super) fn sensitivity(
    position_km: &Vector3<f64>,
    limb_height_km: f64,
    earth_to_icrs: &Matrix3<f64>,
) -> Sensitivity {
    let shrink = 1.0 - limb_height_km / EARTH_RADIUS_KM;
    Sensitivity {
        position: Matrix3::identity() * shrink,
        limb_height: position_km * (-1.0 / EARTH_RADIUS_KM),
        misalignment: cross_matrix(&(position_km * shrink)) * earth_to_icrs,
        bias: Matrix3::identity(),
    }
}

/// The covariance of the fix as it would be had it been measured at the predicted place: turned from the one line to the
/// other, scaled with the distance across and with its square along (a distance is found from an angle). Where prediction
/// and fix are so far apart that this means nothing, it is left as it is.
fn carried(fix: &PositionFix, predicted: &Vector3<f64>) -> Matrix3<f64> {
    let z = &fix.position_km;
    let (measured, expected) = (libm::sqrt(z.dot(z)), libm::sqrt(predicted.dot(predicted)));
    let (d, u) = (z / measured, predicted / expected);
    let (scale, cosine) = (expected / measured, d.dot(&u));
    if !(finite(&d) && finite(&u) && scale > 0.5 && scale < 2.0 && cosine > 0.5) {
        return fix.covariance_km2;
    }
    let turn = cross_matrix(&d.cross(&u));
    let rotation = Matrix3::identity() + turn + turn * turn / (1.0 + cosine);
    let along = d * d.transpose() * (scale * scale - scale);
    let carry = rotation * (Matrix3::identity() * scale + along);
    symmetric(&(carry * fix.covariance_km2 * carry.transpose()))
}
