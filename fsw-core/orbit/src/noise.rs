//! Process noise: white acceleration, and the decay of slow errors (Gauss-Markov processes).

use super::OrbitState;
use super::parameters::OrbitParameters;
use super::perturbations::mean_drag_km_s2;
use fsw_ground::matrix::dot;

/// Spectral density of the acceleration at a state, km²/s³.
pub(super) fn acceleration(state: &OrbitState, parameters: &OrbitParameters) -> f64 {
    let square_km2 = dot(&state.position_km, &state.position_km);
    let facts = parameters.body.facts();
    let nearness = ((facts.radius_km * facts.radius_km) / square_km2.max(1.0)) as f32;
    // The twelfth power of the radius.
    let cube = nearness * nearness * nearness;
    let gravity = parameters.gravity_noise_km_s15 * cube * cube;
    let drag = if facts.air {
        parameters.drag_noise_s05 * mean_drag_km_s2(state, parameters.drag_m2_kg)
    } else {
        0.0
    };
    square(gravity) + square(drag) + square(parameters.force_noise_km_s15)
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
