//! The Kalman-Schmidt filter of the orbit (thesis tab. 5.1), once a second.
//!
//! In: a [`PositionFix`] with its time, and the rotation from the Earth path to ICRS; out: position, velocity
//! and limb height with their covariance.
//!
//! Initialisation: the first fix sets the position, with velocity 0 and a sigma of the circular orbit's
//! speed. State and covariance are valid after a second fix within 60 s passes the gate (NIS). A second fix
//! that fails it replaces the first.
//!
//! The misalignment of the paths and the bias of the fixes are considered, not estimated (Schmidt), so the
//! covariance is never smaller than they allow. Corrections follow the arc of the orbit (`curvilinear`);
//! the measurement model is in [`super::observation`].
//!
//! Cost on the target (model cycles, `cargo budget`): a second with a fix 0.87 M, without one 0.33 M,
//! ephemeris and frames included. A gap is crossed in spans of at most 150 s, [`MAX_SPANS`] of them, 0.43 M
//! each.

mod estimate;

use super::OrbitState;
use super::constants::{MICROSECONDS, MU_EARTH_KM3_S2};
use super::covariance::{Covariance, LIMB_HEIGHT, POSITION, VELOCITY};
use super::dynamics::{MAX_SPAN_US, plausible};
use super::observation::{FixError, check};
use super::parameters::{Observation, OrbitParameters};
use super::point::PositionFix;
use crate::matrix::dot;
use estimate::Estimate;
use nalgebra::Matrix3;

/// Most spans in one call of [`OrbitFilter::advance`].
pub const MAX_SPANS: u32 = 48;
/// Longest gap that is crossed, microseconds: two hours.
pub const MAX_GAP_US: i64 = MAX_SPANS as i64 * MAX_SPAN_US;

/// Longest time between the first fix and one that agrees with it, microseconds. After 60 s at up to 11
/// km/s any position within 660 km passes the gate, so that passing is no evidence.
const AGREEMENT_US: i64 = 60_000_000;

const FOUR_PI_SQUARED: f64 = core::f64::consts::TAU * core::f64::consts::TAU;

/// Result of a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Update {
    /// It initialised the filter, as the first fix or in place of one that it disagrees with.
    Begun,
    /// It agrees with the first fix: from now on the state is valid.
    Started,
    /// It was used.
    Accepted {
        /// Its normalised innovation squared (3 degrees of freedom, or 2 for a direction).
        nis: f32,
    },
    /// It disagrees with the orbit and was not used.
    Rejected {
        /// Its normalised innovation squared.
        nis: f32,
    },
    /// [`OrbitParameters::patience`] fixes in a row were rejected: the filter was reinitialised with this
    /// one.
    Restarted,
    /// It is not a valid position; the filter was propagated only.
    Refused(FixError),
}

/// Why the filter was reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetReason {
    /// The clock went backwards.
    Backwards,
    /// The gap is longer than [`MAX_GAP_US`].
    TooLong,
    /// The propagated state or covariance left its bounds.
    Diverged,
}

/// The filter; see the module.
#[derive(Clone, Copy, Debug)]
pub struct OrbitFilter {
    estimate: Option<Estimate>,
}

impl Default for OrbitFilter {
    fn default() -> Self {
        Self::new()
    }
}

impl OrbitFilter {
    /// A filter without a state.
    pub const fn new() -> Self {
        Self { estimate: None }
    }

    /// Initialises the filter with a state of another source (the ground), with one sigma for all
    /// directions. `false`, and no change, when the state or a sigma is out of bounds.
    pub fn initialise(
        &mut self,
        state: OrbitState,
        position_sigma_km: f64,
        velocity_sigma_km_s: f64,
        parameters: &OrbitParameters,
    ) -> bool {
        let sound = |sigma: f64| sigma > 0.0 && sigma < 1e7;
        if !plausible(&state.position_km, &state.velocity_km_s)
            || !sound(position_sigma_km)
            || !sound(velocity_sigma_km_s)
        {
            return false;
        }
        let variances = [position_sigma_km, velocity_sigma_km_s].map(|sigma| sigma * sigma);
        self.estimate = Some(Estimate::from_state(state, variances, parameters));
        true
    }

    /// Resets the filter.
    pub fn reset(&mut self) {
        self.estimate = None;
    }

    /// Propagates to `time_us` and updates with a fix of that time; `earth_to_icrs` is the rotation from
    /// the Earth path. If the propagation resets the filter, the fix initialises it.
    pub fn update(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Update {
        // A reset here is no error: the fix initialises the filter again, and the caller gets `Begun`.
        let _ = self.advance(time_us, parameters);
        if let Err(refusal) = check(fix, earth_to_icrs) {
            return Update::Refused(refusal);
        }
        let Some(mut updated) = self.estimate else {
            self.begin(time_us, fix, earth_to_icrs, parameters);
            return Update::Begun;
        };
        let unit = match parameters.observation {
            Observation::Position => false,
            Observation::UnitVector => true,
            Observation::Combined => updated.settled,
        };
        let Some(nis) = updated.measurement_update(fix, earth_to_icrs, unit, parameters) else {
            return Update::Refused(FixError::Covariance);
        };
        let second = updated.first_fix_us.take().is_some();
        if nis <= f64::from(parameters.gate_nis) && updated.is_valid() {
            updated.check_settled(parameters);
            self.estimate = Some(updated);
            return if second { Update::Started } else { Update::Accepted { nis: nis as f32 } };
        }
        if let Some(estimate) = self.estimate.as_mut().filter(|_| !second) {
            estimate.rejections = estimate.rejections.saturating_add(1);
            if estimate.rejections < parameters.patience {
                return Update::Rejected { nis: nis as f32 };
            }
        }
        self.begin(time_us, fix, earth_to_icrs, parameters);
        if second { Update::Begun } else { Update::Restarted }
    }

    /// Initialises the filter with a single fix.
    fn begin(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) {
        self.estimate = Some(Estimate::from_fix(time_us, fix, earth_to_icrs, parameters));
    }

    /// Propagates state and covariance to `to_us`; without a state nothing happens. A first fix that is not
    /// confirmed within 60 s is dropped.
    ///
    /// # Errors
    /// Why the filter was reset.
    pub fn advance(&mut self, to_us: i64, parameters: &OrbitParameters) -> Result<(), ResetReason> {
        let Some(estimate) = &mut self.estimate else { return Ok(()) };
        if estimate.first_fix_us.is_some_and(|first_fix_us| to_us.saturating_sub(first_fix_us) > AGREEMENT_US)
        {
            self.reset();
            return Ok(());
        }
        let propagated = estimate.propagate(to_us, parameters);
        if propagated.is_err() {
            self.reset();
        }
        propagated
    }

    /// The estimate once a second fix has agreed with the first.
    fn confirmed(&self) -> Option<&Estimate> {
        self.estimate.as_ref().filter(|estimate| estimate.first_fix_us.is_none())
    }

    /// Time, position and velocity; `None`, as for all that follows, until a second fix has agreed with the
    /// first.
    pub fn state(&self) -> Option<&OrbitState> {
        self.confirmed().map(|estimate| &estimate.state)
    }

    /// Height of the true limb above the assumed one, km.
    pub fn limb_height_km(&self) -> Option<f64> {
        self.confirmed().map(|estimate| estimate.limb_height_km)
    }

    /// Sigma of [`OrbitFilter::limb_height_km`].
    pub fn limb_height_sigma_km(&self) -> Option<f64> {
        self.confirmed().map(|estimate| libm::sqrt(estimate.covariance.at(LIMB_HEIGHT, LIMB_HEIGHT)))
    }

    /// The covariance of all states.
    pub fn covariance(&self) -> Option<&Covariance> {
        self.confirmed().map(|estimate| &estimate.covariance)
    }

    /// Covariance of the position, km², ICRS axes.
    pub fn position_covariance_km2(&self) -> Option<Matrix3<f64>> {
        self.covariance().map(|covariance| covariance.block(POSITION, POSITION))
    }

    /// Sigmas of the position along the ICRS axes, km.
    pub fn position_sigma_km(&self) -> Option<[f64; 3]> {
        self.covariance().map(|covariance| covariance.sigmas(POSITION))
    }

    /// Sigmas of the velocity along the ICRS axes, km/s.
    pub fn velocity_sigma_km_s(&self) -> Option<[f64; 3]> {
        self.covariance().map(|covariance| covariance.sigmas(VELOCITY))
    }

    /// Whether position and velocity have been known to [`OrbitParameters::settled_share`] of their length
    /// since the start.
    pub fn settled(&self) -> bool {
        self.confirmed().is_some_and(|estimate| estimate.settled)
    }

    /// Moves the epoch by a step of the clock: the same state under another time.
    pub fn shift_epoch(&mut self, step_us: i64) {
        let Some(estimate) = &mut self.estimate else { return };
        estimate.state.time_us = estimate.state.time_us.saturating_add(step_us);
        estimate.first_fix_us =
            estimate.first_fix_us.map(|first_fix_us| first_fix_us.saturating_add(step_us));
    }

    /// Whether an orbit that never settled has made one revolution since its last accepted fix, `since_us`
    /// microseconds ago. With a correct orbit at least one fix a revolution is accepted.
    pub fn is_stale(&self, since_us: i64) -> bool {
        let Some(estimate) = self.confirmed().filter(|estimate| !estimate.settled) else {
            return false;
        };
        let position_km = &estimate.state.position_km;
        let since_s = since_us as f64 / MICROSECONDS;
        let square_km2 = dot(position_km, position_km);
        // 4 pi² r³ / mu is the square of a circle's period.
        let period_s2 = FOUR_PI_SQUARED * square_km2 * libm::sqrt(square_km2) / MU_EARTH_KM3_S2;
        since_s > 0.0 && since_s * since_s > period_s2
    }

    /// Fixes rejected in a row.
    pub fn rejections(&self) -> u16 {
        self.confirmed().map_or(0, |estimate| estimate.rejections)
    }
}

#[cfg(test)]
mod campaign;
#[cfg(test)]
mod tests;
