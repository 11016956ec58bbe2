//! What the covariance gains with time.

use super::Estimate;
use crate::factor::{FIELD, HEIGHT, MISALIGNMENT, MOTION, POSITION, STATES, VELOCITY};
use crate::horizon;
use crate::motion::axis_share;
use crate::noise::acceleration;
use crate::parameters::OrbitParameters;
use fsw_ground::matrix::dot_long;

/// 15/8 of √3; see [`Estimate::add_bend`].
const SECOND_ORDER: f64 = 3.248;

impl Estimate {
    /// Adds the noise of the time since it was last added: white acceleration, integrated, and what the
    /// horizon's states gain while they decay.
    #[inline(never)]
    pub(super) fn add_noise(&mut self, parameters: &OrbitParameters) {
        let dt = core::mem::replace(&mut self.noise_s, 0.0);
        let Some(geometry) = self.geometry().filter(|_| dt > 0.0) else { return };
        let strength = libm::sqrt(acceleration(&self.state, parameters) * dt);
        // Of q [dt³/3, dt²/2; dt²/2, dt] the Cholesky factor.
        let (bound, free) = (strength * libm::sqrt(0.75), strength * 0.5);
        for axis in 0..3 {
            let along = (POSITION + axis, (strength * dt * libm::sqrt(1.0 / 3.0)) as f32);
            self.factor.append(&[along, (VELOCITY + axis, bound as f32)]);
            self.factor.append(&[(VELOCITY + axis, free as f32)]);
        }
        let constant = horizon::constants_decay(dt);
        for (state, [mean, sigma]) in (HEIGHT..FIELD).zip(horizon::constants(parameters)) {
            self.renew(state, constant, mean, sigma * sigma);
        }
        let waves = geometry.variations(parameters).map(|wave| (wave.decay(dt), wave.variance_km2));
        for (state, (decay, variance_km2)) in (FIELD..MISALIGNMENT).zip(horizon::of_waves(waves)) {
            self.renew(state, decay, 0.0, variance_km2);
        }
        self.factor.settle();
    }

    /// Lets a state decay towards its mean, and adds what keeps its steady variance.
    fn renew(&mut self, state: usize, decay: f32, mean: f32, variance: f32) {
        if let Some(value) = self.horizon.get_mut(state) {
            *value = mean + decay * (*value - mean);
        }
        self.factor.scale(state, decay);
        self.factor.append(&[(state, libm::sqrtf(variance * (1.0 - decay * decay).max(0.0)))]);
    }

    /// Adds what the linear covariance lacks after a time in which nothing was seen: the mean motion changes
    /// by -3/2 x + 15/8 x² where the semi-major axis is off by the share x, so that the satellite is that
    /// second order early. The rms of x² is √3 times the variance of x.
    #[inline(never)]
    pub(super) fn add_bend(&mut self, blind_s: f64) {
        let (share, gravity_km_s2) = axis_share(self.body, &self.state);
        let mut row = [0.0; STATES];
        for (place, element) in row.iter_mut().zip(share) {
            *place = element;
        }
        let carried = self.factor.carried(&row);
        let early_s = SECOND_ORDER * blind_s * f64::from(dot_long(&carried, &carried));
        let mut column = [(0, 0.0); MOTION];
        let moved =
            self.state.velocity_km_s.iter().copied().chain(gravity_km_s2.iter().map(|element| -element));
        for ((state, place), element) in column.iter_mut().enumerate().zip(moved) {
            *place = (state, (early_s * element) as f32);
        }
        self.factor.append(&column);
    }
}
