//! State of the orbit filter, and its two steps: propagation and measurement update.

use super::{MAX_GAP_US, MAX_SPANS, ResetReason};
use crate::matrix::{add_scaled, add_to_diagonal, dot, identity, product_transposed, scaled};
use crate::orbit::OrbitState;
use crate::orbit::constants::{EARTH_RADIUS_KM, MICROSECONDS, MU_EARTH_KM3_S2};
use crate::orbit::covariance::{BIAS, Covariance, LIMB_HEIGHT, MISALIGNMENT, POSITION, VELOCITY};
use crate::orbit::curvilinear::correct_state;
use crate::orbit::dynamics::{MAX_SPAN_US, PropagationError, plausible, transition};
use crate::orbit::noise::{ProcessNoise, bias_share, height_variance_km2, square};
use crate::orbit::observation::{Innovation, sensitivity};
use crate::orbit::parameters::OrbitParameters;
use crate::orbit::point::PositionFix;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// The covariance is inflated when the velocity's sigma falls below these shares of the velocity, once each:
/// the trajectory from the start (velocity 0) until then is not a solution of the dynamics, and a covariance
/// propagated along it is too small.
const INFLATION_SHARES: [f64; 2] = [0.15, 0.01];
/// Factor on the variances of position and velocity there; their correlations become 0.
const INFLATION: f64 = 16.0;

/// State, covariance and history of the filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) state: OrbitState,
    pub(super) limb_height_km: f64,
    pub(super) covariance: Covariance,
    /// Decay of the bias since the last fix, 1 at the fix.
    bias_decay: f64,
    /// Number of inflations since the start.
    inflations: u8,
    /// Time of the first fix until a second one confirms it.
    pub(super) first_fix_us: Option<i64>,
    pub(super) settled: bool,
    /// Fixes rejected in a row.
    pub(super) rejections: u16,
}

/// Covariance of limb height and misalignment at their steady-state values; all others 0.
fn slow_states(position_km: &Vector3<f64>, parameters: &OrbitParameters) -> Covariance {
    let mut covariance = Covariance::ZERO;
    covariance.set(LIMB_HEIGHT, LIMB_HEIGHT, height_variance_km2(position_km, parameters));
    let variance = square(parameters.misalignment_sigma_rad);
    covariance.set_block(MISALIGNMENT, MISALIGNMENT, &scaled(&identity(), variance));
    covariance
}

impl Estimate {
    /// From a state and the variances of position (km²) and velocity (km²/s²) along every axis.
    pub(super) fn from_state(state: OrbitState, variances: [f64; 2], parameters: &OrbitParameters) -> Self {
        let mut covariance = slow_states(&state.position_km, parameters);
        for (first, variance) in [POSITION, VELOCITY].into_iter().zip(variances) {
            covariance.set_block(first, first, &scaled(&identity(), variance));
        }
        let mut estimate = Self {
            state,
            limb_height_km: 0.0,
            covariance,
            bias_decay: 1.0,
            inflations: INFLATION_SHARES.len() as u8,
            first_fix_us: None,
            settled: false,
            rejections: 0,
        };
        estimate.check_settled(parameters);
        estimate
    }

    /// From a fix: its position, velocity 0. With `r = -H_c c + noise`, where `c` are the slow states and
    /// `H_c` their columns of the sensitivity, the position's covariance is `H_c C H_cᵀ + N` and that with
    /// the slow states `-H_c C`.
    #[inline(never)]
    pub(super) fn from_fix(
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Self {
        let mut covariance = slow_states(&fix.position_km, parameters);
        let bias = scaled(&fix.covariance_km2, bias_share(parameters));
        covariance.set_block(BIAS, BIAS, &bias);
        covariance.set_block(POSITION, BIAS, &scaled(&bias, -1.0));
        let sensitivity = sensitivity(&fix.position_km, 0.0, earth_to_icrs);
        let mut position = fix.covariance_km2;
        add_scaled(&mut position, 1.0, &bias);
        for state in LIMB_HEIGHT..BIAS {
            let Some(column) = sensitivity.data.0.get(state) else { continue };
            let column = SMatrix::<f64, 3, 1>::from(*column);
            let variance = covariance.at(state, state);
            let with_position = scaled(&column, -variance);
            add_scaled(&mut position, -1.0, &product_transposed(&with_position, &column));
            for (axis, element) in with_position.iter().enumerate() {
                covariance.set(POSITION + axis, state, *element);
            }
        }
        covariance.set_block(POSITION, POSITION, &position);
        let distance_km = libm::sqrt(dot(&fix.position_km, &fix.position_km)).max(1.0);
        let mut velocity = Matrix3::zeros();
        add_to_diagonal(&mut velocity, square(parameters.start_speed_share) * MU_EARTH_KM3_S2 / distance_km);
        covariance.set_block(VELOCITY, VELOCITY, &velocity);
        Self {
            state: OrbitState { time_us, position_km: fix.position_km, velocity_km_s: Vector3::zeros() },
            limb_height_km: 0.0,
            covariance,
            bias_decay: 1.0,
            inflations: 0,
            first_fix_us: Some(time_us),
            settled: false,
            rejections: 0,
        }
    }

    /// Measurement update by a fix; returns its normalised innovation squared. `None`, with the estimate
    /// invalid, when the innovation's covariance is not positive definite.
    #[inline(never)]
    pub(super) fn measurement_update(
        &mut self,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        unit: bool,
        parameters: &OrbitParameters,
    ) -> Option<f64> {
        let Innovation { sensitivity, noise_km2, innovation_km } =
            Innovation::of(fix, &self.state.position_km, self.limb_height_km, earth_to_icrs, unit);
        // The decayed part of the bias is replaced by a new one with the shape of this fix's noise.
        let renewed = bias_share(parameters) * (1.0 - self.bias_decay * self.bias_decay);
        let mut bias = self.covariance.block(BIAS, BIAS);
        add_scaled(&mut bias, renewed, &noise_km2);
        self.covariance.set_block(BIAS, BIAS, &bias);
        let correction = self.covariance.correct(&sensitivity, &noise_km2, &innovation_km)?;
        let OrbitState { position_km, velocity_km_s, .. } = &mut self.state;
        let rotation =
            correct_state(position_km, velocity_km_s, &correction.position_km, &correction.velocity_km_s);
        if let Some(rotation) = rotation {
            self.covariance.rotate(&rotation);
        }
        self.limb_height_km += correction.limb_height_km;
        self.bias_decay = 1.0;
        self.rejections = 0;
        self.inflate_after_start();
        Some(correction.nis)
    }

    /// Inflates the covariance at each of [`INFLATION_SHARES`].
    fn inflate_after_start(&mut self) {
        let Some(share) = INFLATION_SHARES.get(usize::from(self.inflations)) else { return };
        if self.velocity_is_known_to(*share) {
            self.covariance.inflate_motion(INFLATION);
            self.inflations = self.inflations.saturating_add(1);
        }
    }

    fn velocity_is_known_to(&self, share: f64) -> bool {
        let velocity = &self.state.velocity_km_s;
        self.covariance.trace(VELOCITY) < share * share * dot(velocity, velocity)
    }

    /// Sets `settled` once the sigmas of position and velocity are below `settled_share` of their length.
    pub(super) fn check_settled(&mut self, parameters: &OrbitParameters) {
        let share = f64::from(parameters.settled_share);
        let position = &self.state.position_km;
        let known = self.covariance.trace(POSITION) < share * share * dot(position, position);
        self.settled |= known && self.velocity_is_known_to(share);
    }

    /// Whether state and covariance are within their bounds.
    pub(super) fn is_valid(&self) -> bool {
        plausible(&self.state.position_km, &self.state.velocity_km_s)
            && libm::fabs(self.limb_height_km) < 0.5 * EARTH_RADIUS_KM
            && self.covariance.is_valid()
    }

    /// Propagates to a time in spans of at most [`MAX_SPAN_US`]. After an error the estimate is invalid.
    pub(super) fn propagate(&mut self, to_us: i64, parameters: &OrbitParameters) -> Result<(), ResetReason> {
        let gap = to_us.checked_sub(self.state.time_us).ok_or(ResetReason::TooLong)?;
        if gap < 0 {
            return Err(ResetReason::Backwards);
        }
        if gap > MAX_GAP_US {
            return Err(ResetReason::TooLong);
        }
        for _ in 0..MAX_SPANS {
            let span = to_us.saturating_sub(self.state.time_us).min(MAX_SPAN_US);
            if span > 0 {
                self.propagate_span(span, parameters)?;
            }
        }
        Ok(())
    }

    #[inline(never)]
    fn propagate_span(&mut self, span_us: i64, parameters: &OrbitParameters) -> Result<(), ResetReason> {
        let after = parameters.dynamics.propagate(&self.state, span_us).map_err(|error| match error {
            PropagationError::TooLong => ResetReason::TooLong,
            PropagationError::Impossible => ResetReason::Diverged,
        })?;
        let dt = span_us as f64 / MICROSECONDS;
        let noise = ProcessNoise::over(&after.position_km, dt, parameters);
        self.covariance.propagate(&transition(&self.state, &after), &noise, dt);
        self.bias_decay *= noise.bias_decay;
        self.limb_height_km *= noise.height_decay;
        self.state = after;
        if self.covariance.is_valid() { Ok(()) } else { Err(ResetReason::Diverged) }
    }
}
