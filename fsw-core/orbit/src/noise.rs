//! Process noise: white acceleration, and the decay of slow errors (Gauss-Markov processes).

use super::constants::EARTH_RADIUS_KM;
use super::parameters::OrbitParameters;
use fsw_ground::matrix::dot;
use nalgebra::Vector3;

/// Spectral density of the acceleration at a position, km²/s³.
pub(super) fn acceleration(position_km: &Vector3<f64>, parameters: &OrbitParameters) -> f64 {
    let nearness = EARTH_RADIUS_KM * EARTH_RADIUS_KM / dot(position_km, position_km).max(1.0);
    let gravity = f64::from(parameters.gravity_noise_km_s15) * nearness * nearness;
    gravity * gravity + square(parameters.force_noise_km_s15)
}

/// Decay factor of a Gauss-Markov process of time constant `lasting` over `dt`: e^-x to 1 % up to x = 0.5,
/// tending to 0 beyond.
pub(super) fn decay(dt: f64, lasting: f64) -> f64 {
    let spans = dt / lasting.max(1e-3);
    1.0 / (1.0 + spans * (1.0 + 0.5 * spans))
}

/// The square of a sigma or of a ratio.
pub(super) fn square(sigma: f32) -> f64 {
    f64::from(sigma) * f64::from(sigma)
}
