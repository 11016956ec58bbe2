//! Measurement model of a fix: sensitivity, noise at the predicted position, innovation.
//!
//! In: a [`PositionFix`], the predicted position and limb height, the rotation from the Earth path to ICRS;
//! out: an [`Innovation`], km.
//!
//! A fix is modelled as `z = r (1 - h/a) + r × (R m) + b + noise`. A limb higher by `h` enlarges the
//! Earth's image by the same factor at every point of the limb, so the distance appears shorter, `a` being
//! the equatorial radius. `m` is the misalignment of the two paths, a rotation vector in the Earth path: `R
//! (I + [m×])` is the true rotation to ICRS. `b` is the bias from clouds and the slant of the light on the
//! limb: its covariance is that of the fix times a constant, and it changes slowly.
//!
//! The covariance of a fix refers to the point at which the fit was linearised
//! ([`PositionFix::linearisation_km`]). It is elongated along the line to the Earth and scales with the
//! distance, so a covariance at the measured position is correlated with the error of the fix and would
//! bias the estimate by about `sigma² / r`. It is therefore rotated and scaled to the predicted position
//! first.

use super::constants::EARTH_RADIUS_KM;
use super::covariance::{BIAS, LIMB_HEIGHT, MISALIGNMENT, POSITION, Sensitivity, is_covariance};
use super::curvilinear::CurvilinearDifference;
use super::dynamics::plausible;
use super::point::PositionFix;
use crate::matrix::{
    add_product, add_scaled, add_to_diagonal, cross_matrix, dot, identity, plus_scaled, product,
    product_transposed, scaled, symmetric_product,
};
use nalgebra::{Matrix3, Vector3};

/// An element of a rotation is at most 1; 10 % for rounding.
const GREATEST_ELEMENT: f64 = 1.1;

/// Why a fix is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FixError {
    /// A value is not finite, or the position is outside 5,000 to 600,000 km.
    Impossible,
    /// Its covariance is not positive definite.
    Covariance,
}

/// A measured less a predicted position.
#[derive(Clone, Copy, Debug)]
pub struct Innovation {
    /// Sensitivity of the measured position to the states.
    pub sensitivity: Sensitivity,
    /// Covariance of its noise, km².
    pub noise_km2: Matrix3<f64>,
    /// The difference, km.
    pub innovation_km: Vector3<f64>,
}

impl Innovation {
    /// Of a fix against a predicted position and limb height; `unit`: its direction alone (eq. 5.25).
    pub fn of(
        fix: &PositionFix,
        position_km: &Vector3<f64>,
        limb_height_km: f64,
        earth_to_icrs: &Matrix3<f64>,
        unit: bool,
    ) -> Self {
        let mut sensitivity = sensitivity(position_km, limb_height_km, earth_to_icrs);
        let predicted = scaled(position_km, range_scale(limb_height_km));
        let TransportedFix { mut noise_km2, mut innovation_km } = TransportedFix::of(fix, &predicted)
            .unwrap_or_else(|| TransportedFix::cartesian(fix, &predicted, unit));
        if unit {
            // Only the components across the line. The one along the line gets sensitivity 0, innovation 0
            // and variance 1 km², so that S stays regular.
            let along =
                product_transposed(&scaled(&predicted, 1.0 / dot(&predicted, &predicted)), &predicted);
            let mut across = identity();
            add_scaled(&mut across, -1.0, &along);
            innovation_km = product(&across, &innovation_km);
            noise_km2 = symmetric_product(&across, &noise_km2);
            add_scaled(&mut noise_km2, 1.0, &along);
            set_columns(&mut sensitivity, POSITION, &scaled(&across, range_scale(limb_height_km)));
            set_columns(&mut sensitivity, BIAS, &across);
            if let Some(column) = sensitivity.data.0.get_mut(LIMB_HEIGHT) {
                *column = [0.0; 3];
            }
        }
        Self { sensitivity, noise_km2, innovation_km }
    }
}

/// Whether a fix is finite, possible and has a covariance.
pub(super) fn check(fix: &PositionFix, earth_to_icrs: &Matrix3<f64>) -> Result<(), FixError> {
    let at_rest = Vector3::zeros();
    if !plausible(&fix.position_km, &at_rest)
        || !plausible(&fix.linearisation_km, &at_rest)
        // NaN is refused too.
        || !earth_to_icrs.iter().all(|x| libm::fabs(*x) < GREATEST_ELEMENT)
    {
        return Err(FixError::Impossible);
    }
    if is_covariance(&fix.covariance_km2) { Ok(()) } else { Err(FixError::Covariance) }
}

/// Factor by which a limb higher than assumed shortens the apparent distance.
fn range_scale(limb_height_km: f64) -> f64 {
    1.0 - limb_height_km / EARTH_RADIUS_KM
}

/// Sets three columns, from that of the state `first` on.
fn set_columns(sensitivity: &mut Sensitivity, first: usize, block: &Matrix3<f64>) {
    for (to, from) in sensitivity.data.0.iter_mut().skip(first).zip(&block.data.0) {
        *to = *from;
    }
}

/// Sensitivity of a fix at `position_km`.
#[inline(never)]
pub(super) fn sensitivity(
    position_km: &Vector3<f64>,
    limb_height_km: f64,
    earth_to_icrs: &Matrix3<f64>,
) -> Sensitivity {
    let range_scale = range_scale(limb_height_km);
    let lever = cross_matrix(&scaled(position_km, range_scale));
    let height = scaled(position_km, -1.0 / EARTH_RADIUS_KM);
    let mut sensitivity = Sensitivity::zeros();
    set_columns(&mut sensitivity, POSITION, &scaled(&identity(), range_scale));
    set_columns(&mut sensitivity, MISALIGNMENT, &product(&lever, earth_to_icrs));
    set_columns(&mut sensitivity, BIAS, &identity());
    if let Some(column) = sensitivity.data.0.get_mut(LIMB_HEIGHT) {
        *column = height.into();
    }
    sensitivity
}

/// A fix transformed to the predicted position.
struct TransportedFix {
    noise_km2: Matrix3<f64>,
    innovation_km: Vector3<f64>,
}

impl TransportedFix {
    /// The difference as height and arc; the covariance rotated from one line to the other, scaled with the
    /// distance across the line and with its square along it (the distance is measured as an angle). `None`
    /// if the two are more than 60 degrees apart, or one is twice as far as the other.
    fn of(fix: &PositionFix, predicted: &Vector3<f64>) -> Option<Self> {
        let bent = CurvilinearDifference::between(predicted, &fix.linearisation_km)?;
        let scale = 1.0 / bent.scale;
        if !(scale > 0.5 && scale < 2.0) {
            return None;
        }
        let up = scaled(predicted, 1.0 / libm::sqrt(dot(predicted, predicted)));
        let mut stretch = product_transposed(&scaled(&up, scale * scale - scale), &up);
        add_to_diagonal(&mut stretch, scale);
        let carry = product_transposed(&stretch, &bent.rotation);
        let off_place = plus_scaled(&fix.position_km, -1.0, &fix.linearisation_km);
        let mut innovation_km = bent.difference_km;
        add_product(&mut innovation_km, &carry, &off_place);
        Some(Self { noise_km2: symmetric_product(&carry, &fix.covariance_km2), innovation_km })
    }

    /// The Cartesian difference, where [`TransportedFix::of`] gives `None`. A direction alone is scaled to
    /// the predicted distance.
    fn cartesian(fix: &PositionFix, predicted: &Vector3<f64>, unit: bool) -> Self {
        let square_ratio = dot(predicted, predicted) / dot(&fix.position_km, &fix.position_km);
        let scale = if unit { libm::sqrt(square_ratio) } else { 1.0 };
        Self {
            noise_km2: scaled(&fix.covariance_km2, scale * scale),
            innovation_km: plus_scaled(&scaled(&fix.position_km, scale), -1.0, predicted),
        }
    }
}
