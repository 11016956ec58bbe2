//! The Kalman-Schmidt filter of the orbit (thesis tab. 5.1), once a second.
//!
//! In: a [`PositionFix`] with its time, and the rotation from the Earth path to ICRS; out: position, velocity and limb
//! height with their covariance. It knows nothing at first: a fix begins it, at rest with a speed's worth of doubt. Nothing is handed
//! out before a second one agrees: a wrong one would pass for an orbit until others contradict it, and none may follow for long.
//!
//! What a fix says of the state is [`super::observation`]'s; the misalignment of the paths is considered, not estimated
//! (Schmidt), so the covariance never promises more than the alignment allows.
//!
//! The start: a fix tells nothing of the velocity, and a covariance carried along a trajectory that is none promises too much.
//! So it is made anew, wider and without correlations, when the velocity is known to a share of itself, twice. Corrections
//! follow the arc of the orbit (`bend`).
//!
//! Cost on the target (model cycles, `cargo budget`): a second with a fix 0.95 M, without one 0.47 M, ephemeris and frames
//! included. A gap is crossed in spans of at most 150 s, [`MAX_SPANS`] of them: 11.3 M for 51 minutes at once.

use super::OrbitState;
use super::bend::correct_state;
use super::constants::{EARTH_RADIUS_KM, MICROSECONDS, MU_EARTH_KM3_S2};
use super::covariance::{Covariance, Sensitivity};
use super::dynamics::{MAX_SPAN_US, PropagationError, Transition, plausible};
use super::matrix::{outer, product, scaled, symmetric};
use super::noise::{ProcessNoise, bias_share, height_variance_km2, square};
use super::observation::{Innovation, Refusal, check, sensitivity};
use super::parameters::{Observation, OrbitParameters};
use super::point::PositionFix;
use nalgebra::{Matrix3, Vector3};

/// Most spans in one call of [`OrbitFilter::advance`].
pub const MAX_SPANS: u32 = 48;
/// Longest gap that is crossed, microseconds: two hours.
pub const MAX_GAP_US: i64 = MAX_SPANS as i64 * MAX_SPAN_US;

/// Longest time between the first fix and one that agrees with it, microseconds: later a body at any speed would.
const AGREEMENT_US: i64 = 60_000_000;

const FOUR_PI_SQUARED: f64 = core::f64::consts::TAU * core::f64::consts::TAU;

/// Sigmas of the velocity, over the velocity, below which the covariance of a new orbit is made anew.
const RENEWALS: [f64; 2] = [0.15, 0.01];
/// What its variances are then multiplied with.
const RENEWAL_VARIANCE: f64 = 16.0;

/// What became of a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Update {
    /// It began the filter, alone or instead of one that it disagrees with.
    Begun,
    /// It agrees with the one that began the filter: from now on the orbit is known.
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
    /// Too many disagreed: the filter forgot all and began anew with this one.
    Restarted,
    /// It is no position; the filter is as it was, propagated.
    Refused(Refusal),
}

/// Why the filter forgot the orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lost {
    /// The clock went backwards.
    Backwards,
    /// The gap is longer than [`MAX_GAP_US`].
    TooLong,
    /// The orbit led into the Earth or out of bounds.
    Diverged,
}

#[derive(Clone, Copy, Debug)]
struct Estimate {
    state: OrbitState,
    limb_height_km: f64,
    covariance: Covariance,
    /// Share of the bias at the last fix that is kept.
    bias_kept: f64,
    /// How often the covariance has been made anew since the start.
    renewals: u8,
    /// Time of the fix that began it while no other has agreed.
    begun_us: Option<i64>,
    settled: bool,
    rejections: u16,
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
    /// A filter that knows nothing.
    pub const fn new() -> Self {
        Self { estimate: None }
    }

    /// Starts from a state known otherwise (from the ground), equally well in all directions. Gives false, and changes
    /// nothing, when the state or a sigma is impossible.
    pub fn start(
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
        let mut covariance = unknown(&state.position_km, parameters);
        covariance.rr = Matrix3::identity() * (position_sigma_km * position_sigma_km);
        covariance.vv = Matrix3::identity() * (velocity_sigma_km_s * velocity_sigma_km_s);
        self.estimate = Some(Estimate {
            state,
            limb_height_km: 0.0,
            covariance,
            bias_kept: 1.0,
            renewals: RENEWALS.len() as u8,
            begun_us: None,
            settled: false,
            rejections: 0,
        });
        self.settle(parameters);
        true
    }

    /// Forgets the orbit.
    pub fn forget(&mut self) {
        self.estimate = None;
    }

    /// Takes a fix of the time `time_us`; `earth_to_icrs` is the rotation from the Earth path at that time.
    /// Propagates there first; if the orbit is lost over it, the fix begins the filter.
    pub fn update(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Update {
        // The orbit lost on the way is no error here: the fix begins it anew and the caller sees `Begun`.
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
        let Some(nis) = updated.take(fix, earth_to_icrs, unit, parameters) else {
            return Update::Refused(Refusal::Covariance);
        };
        let second = updated.begun_us.take().is_some();
        if nis <= f64::from(parameters.gate_nis) && updated.is_sound() {
            self.estimate = Some(updated);
            self.settle(parameters);
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

    /// Begins, or begins anew, with a fix alone.
    fn begin(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) {
        self.estimate = Some(Estimate::from_fix(time_us, fix, earth_to_icrs, parameters));
    }

    /// Propagates state and covariance to `to_us`; without an orbit nothing happens. A fix with which none has agreed in time
    /// is forgotten.
    ///
    /// # Errors
    /// The orbit is forgotten, and why.
    pub fn advance(&mut self, to_us: i64, parameters: &OrbitParameters) -> Result<(), Lost> {
        let Some(estimate) = self.estimate else { return Ok(()) };
        if estimate.begun_us.is_some_and(|begun_us| to_us.saturating_sub(begun_us) > AGREEMENT_US) {
            self.forget();
            return Ok(());
        }
        match estimate.advanced(to_us, parameters) {
            Ok(advanced) => {
                self.estimate = Some(advanced);
                Ok(())
            }
            Err(lost) => {
                self.forget();
                Err(lost)
            }
        }
    }

    /// Notes once that the filter has settled.
    fn settle(&mut self, parameters: &OrbitParameters) {
        let Some(estimate) = &mut self.estimate else { return };
        let share = f64::from(parameters.settled_share);
        let known = |variances: &Matrix3<f64>, vector: &Vector3<f64>| {
            variances.trace() < share * share * vector.dot(vector)
        };
        let Estimate { state, covariance, .. } = estimate;
        if known(&covariance.rr, &state.position_km) && known(&covariance.vv, &state.velocity_km_s) {
            estimate.settled = true;
        }
    }

    /// What may be handed out.
    fn known(&self) -> Option<&Estimate> {
        self.estimate.as_ref().filter(|estimate| estimate.begun_us.is_none())
    }

    /// Time, position and velocity, as all that follows `None` while the orbit is not known.
    pub fn state(&self) -> Option<&OrbitState> {
        self.known().map(|estimate| &estimate.state)
    }

    /// Height of the true limb above that assumed, km.
    pub fn limb_height_km(&self) -> Option<f64> {
        self.known().map(|estimate| estimate.limb_height_km)
    }

    /// Sigma of [`OrbitFilter::limb_height_km`].
    pub fn limb_height_sigma_km(&self) -> Option<f64> {
        self.known().map(|estimate| libm::sqrt(estimate.covariance.hh))
    }

    /// The covariance, misalignment included.
    pub fn covariance(&self) -> Option<&Covariance> {
        self.known().map(|estimate| &estimate.covariance)
    }

    /// Covariance of the position, km², ICRS axes.
    pub fn position_covariance_km2(&self) -> Option<Matrix3<f64>> {
        self.covariance().map(|covariance| covariance.rr)
    }

    /// Sigmas of the position along the ICRS axes, km.
    pub fn position_sigma_km(&self) -> Option<[f64; 3]> {
        self.covariance().map(|covariance| sigmas(&covariance.rr))
    }

    /// Sigmas of the velocity along the ICRS axes, km/s.
    pub fn velocity_sigma_km_s(&self) -> Option<[f64; 3]> {
        self.covariance().map(|covariance| sigmas(&covariance.vv))
    }

    /// Whether the orbit has settled since the filter started.
    pub fn settled(&self) -> bool {
        self.known().is_some_and(|estimate| estimate.settled)
    }

    /// Moves the epoch by a step of the clock: the satellite is where it was, only the name of the instant is another.
    pub fn shift_epoch(&mut self, step_us: i64) {
        let Some(estimate) = &mut self.estimate else { return };
        estimate.state.time_us = estimate.state.time_us.saturating_add(step_us);
        estimate.begun_us = estimate.begun_us.map(|begun_us| begun_us.saturating_add(step_us));
    }

    /// Whether an orbit that never settled has gone round once since the last fix that it accepted, `since_us` microseconds ago: had
    /// it been right, there would have been another.
    pub fn is_stale(&self, since_us: i64) -> bool {
        let Some(estimate) = self.known().filter(|estimate| !estimate.settled) else {
            return false;
        };
        let OrbitState { position_km, .. } = &estimate.state;
        let since_s = since_us as f64 / MICROSECONDS;
        let square_km2 = position_km.dot(position_km);
        // 4 pi² r³ / mu is the square of a circle's period.
        let period_s2 = FOUR_PI_SQUARED * square_km2 * libm::sqrt(square_km2) / MU_EARTH_KM3_S2;
        since_s > 0.0 && since_s * since_s > period_s2
    }

    /// Fixes rejected in a row.
    pub fn rejections(&self) -> u16 {
        self.known().map_or(0, |estimate| estimate.rejections)
    }
}

fn sigmas(m: &Matrix3<f64>) -> [f64; 3] {
    [m.m11, m.m22, m.m33].map(libm::sqrt)
}

/// The covariance of a filter that has seen nothing; position and velocity are left to the caller.
fn unknown(position_km: &Vector3<f64>, parameters: &OrbitParameters) -> Covariance {
    Covariance {
        rr: Matrix3::zeros(),
        rv: Matrix3::zeros(),
        vv: Matrix3::zeros(),
        rh: Vector3::zeros(),
        vh: Vector3::zeros(),
        hh: height_variance_km2(position_km, parameters),
        rm: Matrix3::zeros(),
        vm: Matrix3::zeros(),
        hm: Vector3::zeros(),
        mm: square(parameters.misalignment_sigma_rad),
        rb: Matrix3::zeros(),
        vb: Matrix3::zeros(),
        hb: Vector3::zeros(),
        bb: Matrix3::zeros(),
    }
}

impl Estimate {
    /// The position of the fix, at rest: its errors are the fix's own and, in proportion, limb height and misalignment.
    fn from_fix(
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Self {
        let blank = unknown(&fix.position_km, parameters);
        let bias = scaled(&fix.covariance_km2, bias_share(parameters));
        let distance_km = libm::sqrt(fix.position_km.dot(&fix.position_km)).max(1.0);
        let Sensitivity { limb_height, misalignment, .. } = sensitivity(&fix.position_km, 0.0, earth_to_icrs);
        let covariance = Covariance {
            rr: symmetric(
                &(fix.covariance_km2
                    + bias
                    + scaled(&outer(&limb_height, &limb_height), blank.hh)
                    + scaled(&product(&misalignment, &misalignment.transpose()), blank.mm)),
            ),
            vv: Matrix3::identity() * (square(parameters.start_speed_share) * MU_EARTH_KM3_S2 / distance_km),
            rh: -limb_height * blank.hh,
            rm: scaled(&misalignment, -blank.mm),
            rb: -bias,
            bb: bias,
            ..blank
        };
        Self {
            state: OrbitState { time_us, position_km: fix.position_km, velocity_km_s: Vector3::zeros() },
            limb_height_km: 0.0,
            covariance,
            bias_kept: 1.0,
            renewals: 0,
            begun_us: Some(time_us),
            settled: false,
            rejections: 0,
        }
    }

    /// Takes the fix in and gives its normalised innovation squared; `None`, and an estimate not to be used, when the
    /// innovation's covariance is none. In place, and not inlined: an estimate is 0.8 KiB of stack.
    #[inline(never)]
    fn take(
        &mut self,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        unit: bool,
        parameters: &OrbitParameters,
    ) -> Option<f64> {
        let Innovation { sensitivity, noise_km2, innovation_km } =
            Innovation::of(fix, &self.state.position_km, self.limb_height_km, earth_to_icrs, unit);
        // What the bias has lost since the last fix is new now, in the shape that the fix has now.
        let renewed = bias_share(parameters) * (1.0 - self.bias_kept * self.bias_kept);
        self.covariance.bb += scaled(&noise_km2, renewed);
        let correction = self.covariance.correct(&sensitivity, &noise_km2, &innovation_km)?;
        let OrbitState { position_km, velocity_km_s, .. } = &mut self.state;
        let turn =
            correct_state(position_km, velocity_km_s, &correction.position_km, &correction.velocity_km_s);
        if let Some(turn) = turn {
            self.covariance.turn(&turn);
        }
        self.limb_height_km += correction.limb_height_km;
        self.bias_kept = 1.0;
        self.rejections = 0;
        self.renew();
        Some(correction.nis)
    }

    /// Makes the covariance anew once the velocity is known well enough: until then it has been carried along a trajectory
    /// that was none, and promises more than it can hold.
    fn renew(&mut self) {
        let Some(share) = RENEWALS.get(usize::from(self.renewals)) else { return };
        let velocity = &self.state.velocity_km_s;
        if self.covariance.vv.trace() < share * share * velocity.dot(velocity) {
            self.covariance.loosen(RENEWAL_VARIANCE);
            self.renewals = self.renewals.saturating_add(1);
        }
    }

    fn is_sound(&self) -> bool {
        plausible(&self.state.position_km, &self.state.velocity_km_s)
            && libm::fabs(self.limb_height_km) < 0.5 * EARTH_RADIUS_KM
            && self.covariance.is_sound()
    }

    fn advanced(mut self, to_us: i64, parameters: &OrbitParameters) -> Result<Self, Lost> {
        let gap = to_us.checked_sub(self.state.time_us).ok_or(Lost::TooLong)?;
        if gap < 0 {
            return Err(Lost::Backwards);
        }
        if gap > MAX_GAP_US {
            return Err(Lost::TooLong);
        }
        for _ in 0..MAX_SPANS {
            let span = to_us.saturating_sub(self.state.time_us).min(MAX_SPAN_US);
            if span > 0 {
                self = self.crossed(span, parameters)?;
            }
        }
        Ok(self)
    }

    /// One span of at most [`MAX_SPAN_US`].
    fn crossed(mut self, span_us: i64, parameters: &OrbitParameters) -> Result<Self, Lost> {
        let after = parameters.dynamics.propagate(&self.state, span_us).map_err(|error| match error {
            PropagationError::TooLong => Lost::TooLong,
            PropagationError::Impossible => Lost::Diverged,
        })?;
        let transition = Transition::between(&self.state, &after);
        let dt = span_us as f64 / MICROSECONDS;
        let noise = ProcessNoise::over(&after.position_km, dt, parameters);
        self.covariance = self.covariance.propagated(&transition, &noise, dt);
        self.bias_kept *= noise.bias_kept;
        self.limb_height_km *= noise.height_kept;
        self.state = after;
        if self.covariance.is_sound() { Ok(self) } else { Err(Lost::Diverged) }
    }
}

#[cfg(test)]
mod campaign;
#[cfg(test)]
mod tests;
