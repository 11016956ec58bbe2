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
//! The covariance of a fix is found by whoever measured it, at some place: that measured, or one that was expected. It is long
//! along the line to that place and scales with its distance, so the weights of a measured place are correlated with its errors
//! and would pull the estimate by about `sigma² / r` of the single fix. It is therefore turned and scaled to the predicted place
//! first.

use super::bend::Bent;
use super::constants::EARTH_RADIUS_KM;
use super::covariance::{Sensitivity, is_covariance};
use super::dynamics::plausible;
use super::matrix::{applied, cross_matrix, outer, product, scaled, symmetric, turned};
use super::point::PositionFix;
use nalgebra::{Matrix3, Vector3};

/// No element of a rotation is greater than one.
const GREATEST_ELEMENT: f64 = 1.1;

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
        let predicted = applied(&sensitivity.position, position_km);
        let Carried { mut noise_km2, mut innovation_km } =
            Carried::of(fix, &predicted).unwrap_or_else(|| Carried::far(fix, &predicted, unit));
        if unit {
            // Only what lies across the line. The component along the line is made a measurement of nothing, with unit variance
            // and no innovation.
            let along = outer(&predicted, &predicted) / predicted.dot(&predicted);
            let across = Matrix3::identity() - along;
            innovation_km = applied(&across, &innovation_km);
            noise_km2 = symmetric(&turned(&across, &noise_km2)) + along;
            sensitivity.position = product(&across, &sensitivity.position);
            sensitivity.limb_height = Vector3::zeros();
            sensitivity.bias = across;
        }
        Self { sensitivity, noise_km2, innovation_km }
    }
}

/// Whether this can be a fix.
pub(super) fn check(fix: &PositionFix, earth_to_icrs: &Matrix3<f64>) -> Result<(), Refusal> {
    let at_rest = Vector3::zeros();
    if !plausible(&fix.position_km, &at_rest)
        || !plausible(&fix.place_km, &at_rest)
        // Also refuses what is no number.
        || !earth_to_icrs.iter().all(|x| libm::fabs(*x) < GREATEST_ELEMENT)
    {
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
        misalignment: product(&cross_matrix(&(position_km * shrink)), earth_to_icrs),
        bias: Matrix3::identity(),
    }
}

/// A fix as seen from the predicted place.
struct Carried {
    noise_km2: Matrix3<f64>,
    innovation_km: Vector3<f64>,
}

impl Carried {
    /// The difference as height and arc; the covariance as it would be had it been made at the predicted place: turned from
    /// the one line to the other, scaled with the distance across and with its square along (a distance is found from an
    /// angle). `None` where prediction and fix are so far apart that this means nothing.
    fn of(fix: &PositionFix, predicted: &Vector3<f64>) -> Option<Self> {
        let bent = Bent::between(predicted, &fix.place_km)?;
        let scale = 1.0 / bent.scale;
        if !(scale > 0.5 && scale < 2.0) {
            return None;
        }
        let up = predicted / libm::sqrt(predicted.dot(predicted));
        let stretch = Matrix3::identity() * scale + scaled(&outer(&up, &up), scale * scale - scale);
        let carry = product(&stretch, &bent.turn.transpose());
        Some(Self {
            noise_km2: symmetric(&turned(&carry, &fix.covariance_km2)),
            innovation_km: bent.difference_km + applied(&carry, &(fix.position_km - fix.place_km)),
        })
    }

    /// The plain difference where the two are too far apart to be carried. A direction alone says nothing of the distance: the
    /// fix then counts as one at the predicted distance.
    fn far(fix: &PositionFix, predicted: &Vector3<f64>, unit: bool) -> Self {
        let distance_ratio = predicted.dot(predicted) / fix.position_km.dot(&fix.position_km);
        let scale = if unit { libm::sqrt(distance_ratio) } else { 1.0 };
        Self {
            noise_km2: fix.covariance_km2 * (scale * scale),
            innovation_km: fix.position_km * scale - predicted,
        }
    }
}
