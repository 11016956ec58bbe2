//! Process noise: white acceleration, and two slow errors (limb height, bias) as Gauss-Markov processes.
//!
//! In: position, span and parameters. Out: [`ProcessNoise`], and the steady variances of the slow errors.

use super::constants::{EARTH_RADIUS_KM, EARTH_RATE_RAD_S, MU_EARTH_KM3_S2};
use super::parameters::OrbitParameters;
use crate::matrix::dot;
use nalgebra::Vector3;

/// Process noise of one span.
#[derive(Clone, Copy, Debug)]
pub struct ProcessNoise {
    /// Spectral density of the acceleration, km²/s³.
    pub acceleration: f64,
    /// Decay factor of the limb height over the span.
    pub height_decay: f64,
    /// Variance added to the limb height over the span, km².
    pub height_variance_added: f64,
    /// Decay factor of the bias over the span.
    pub bias_decay: f64,
}

impl ProcessNoise {
    /// Over `dt` seconds at a position.
    pub(super) fn over(position_km: &Vector3<f64>, dt: f64, parameters: &OrbitParameters) -> Self {
        let square_km2 = dot(position_km, position_km).max(1.0);
        let nearness = EARTH_RADIUS_KM * EARTH_RADIUS_KM / square_km2;
        // Square of the time per radian on a circular orbit.
        let radian_s2 = square_km2 * libm::sqrt(square_km2) / MU_EARTH_KM3_S2;
        let height_s = f64::from(parameters.limb_height_time_share) * libm::sqrt(radian_s2);
        let bias_s = f64::from(parameters.bias_time_share) * EARTH_RATE_RAD_S * radian_s2;
        let gravity = f64::from(parameters.gravity_noise_km_s15) * nearness * nearness;
        let force = f64::from(parameters.force_noise_km_s15);
        let height_decay = decay(dt, height_s);
        Self {
            acceleration: gravity * gravity + force * force,
            height_decay,
            height_variance_added: height_variance_km2(position_km, parameters)
                * (1.0 - height_decay * height_decay),
            bias_decay: decay(dt, bias_s),
        }
    }
}

/// Variance of the bias over that of the fix.
pub(super) fn bias_share(parameters: &OrbitParameters) -> f64 {
    square(parameters.bias_over_noise)
}

/// Variance of the limb height as seen from a place, km².
pub(super) fn height_variance_km2(position_km: &Vector3<f64>, parameters: &OrbitParameters) -> f64 {
    let to_limb_km2 = (dot(position_km, position_km) - EARTH_RADIUS_KM * EARTH_RADIUS_KM).max(0.0);
    square(parameters.limb_height_sigma_km) + square(parameters.limb_height_sigma_rad) * to_limb_km2
}

/// Decay factor of a Gauss-Markov process of time constant `lasting` over `dt`: e^-x to 1 % up to x = 0.5,
/// tending to 0 beyond.
fn decay(dt: f64, lasting: f64) -> f64 {
    let spans = dt / lasting.max(1e-3);
    1.0 / (1.0 + spans * (1.0 + 0.5 * spans))
}

/// The square of a sigma or of a ratio.
pub(super) fn square(sigma: f32) -> f64 {
    f64::from(sigma) * f64::from(sigma)
}
