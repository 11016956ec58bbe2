//! The orbit filter: beginning, propagation and measurement update, once a second.
//!
//! In: limb points as heights about the predicted limb ([`OrbitFilter::observe_limb`]), or position fixes
//! (thesis tab. 5.1); out: position, velocity and the horizon's states with their covariance.
//!
//! - Unknown: fixes go into [`super::beginning`], least squares over the first arc. Nothing is told before
//!   its orbit has passed every test there; [`OrbitFilter::initialise`] takes a state of the ground instead.
//! - Known: a Kalman-Schmidt filter with the covariance as a square root ([`super::factor`]). Limb points
//!   of some seconds make one observation of nine rows ([`super::look`], [`super::horizon`]). The next one
//!   begins when the errors of the edges are others, so that observations are independent and their
//!   innovations test the filter.
//! - An observation whose normalised innovation squared (NIS) is beyond the gate contradicts the orbit. It is
//!   taken with as much more error along its innovation as brings it to the gate: high clouds lie under
//!   several looks, and a filter that learns nothing of them from the first contradicts them all. The further
//!   off it is, the less it moves the state. [`OrbitParameters::patience`] gross ones in a row, or more of
//!   lesser ones, are a divergence: the filter begins anew.
//!
//! The misalignment of the paths is considered (Schmidt), so that the covariance is never smaller than it
//! allows, or estimated ([`Misalignment`](super::parameters::Misalignment)): then limb points and fixes are
//! those of the Earth path turned by [`OrbitFilter::misalignment_rad`]. A gap is crossed in spans of at most
//! 150 s, [`MAX_SPANS`] of them.

mod estimate;

use super::OrbitState;
use super::beginning::{Beginning, CALLS_OF_A_TRIAL, FirstOrbit, is_orbit};
use super::body::CentralBody;
use super::constants::MICROSECONDS;
use super::dynamics::MAX_SPAN_US;
use super::factor::{EDGE, Factor, HEIGHT, MISALIGNMENT, POSITION, VELOCITY};
use super::motion::MotionCovariance;
use super::observation::{FixError, check, rows_of};
use super::parameters::{Observation, OrbitParameters};
use super::point::PositionFix;
pub use estimate::Nis;
use estimate::{Estimate, Rows};
use fsw_ground::frames::LimbHeight;
use fsw_ground::matrix::dot;
use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector3, Vector6};

/// Most spans in one call of [`OrbitFilter::advance`].
pub const MAX_SPANS: u32 = 48;
/// Most spans in one call of [`OrbitFilter::approach`]: 0.6 M cycles each, of 2 M that a second has for the
/// orbit.
pub const SPANS_A_SECOND: u32 = 3;
/// Longest gap that is crossed, microseconds: two hours.
pub const MAX_GAP_US: i64 = MAX_SPANS as i64 * MAX_SPAN_US;
/// Greatest sigma of a position that is told, share of its length.
const TOLD_SHARE: f64 = 0.1;
const FOUR_PI_SQUARED: f64 = core::f64::consts::TAU * core::f64::consts::TAU;

/// What stars say of the turn of a path against where it was taken to be, a rotation vector in it: values of
/// unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenTurn {
    /// A value in each row: its derivatives by the turn, 1/rad. A row of zeros says nothing.
    pub sensitivity: Matrix3<f32>,
    /// The values measured.
    pub measured: Vector3<f32>,
}

/// Result of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Update {
    /// The orbit is not known yet: it went to the beginning.
    Collected,
    /// The orbit has passed its tests: its state is told after the next [`OrbitFilter::approach`], as it is
    /// one of the time at which these began.
    Started,
    /// It was added to the look under way, or nothing was due.
    Gathered,
    /// An observation was used.
    Accepted(Nis),
    /// An observation contradicts the orbit and counted for less.
    Downweighted(Nis),
    /// [`OrbitParameters::patience`] observations in a row contradicted the orbit: it is forgotten and begins
    /// anew.
    Diverged(Nis),
    /// A fix is not a valid position; the filter was propagated only.
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
#[derive(Clone, Debug)]
pub struct OrbitFilter {
    estimate: Estimate,
    /// Whether the estimate holds an orbit. No `Option`: it is 4 KB long and would pass over the stack.
    known: bool,
    /// Whether it is still on its way across a gap.
    behind: bool,
    beginning: Beginning,
}

impl Default for OrbitFilter {
    fn default() -> Self {
        Self::new()
    }
}

impl OrbitFilter {
    /// A filter without a state.
    pub const fn new() -> Self {
        Self { estimate: Estimate::new(), known: false, behind: false, beginning: Beginning::new() }
    }

    /// Initialises the filter with a state of another source (the ground), with one sigma for all
    /// directions. `false`, and no change, when it is no orbit about the body or a sigma is out of bounds.
    pub fn initialise(
        &mut self,
        state: OrbitState,
        position_sigma_km: f64,
        velocity_sigma_km_s: f64,
        parameters: &OrbitParameters,
    ) -> bool {
        let sound = |sigma: f64| sigma > 0.0 && sigma < 1e6;
        if !is_orbit(parameters.body, &state) || !sound(position_sigma_km) || !sound(velocity_sigma_km_s) {
            return false;
        }
        let [r, v] = [position_sigma_km, velocity_sigma_km_s];
        let root = Matrix6::from_diagonal(&Vector6::new(r, r, r, v, v, v));
        let taken =
            self.estimate.begin(&FirstOrbit { state, root, misaligned: Matrix6x3::zeros() }, parameters);
        self.known |= taken;
        self.behind &= !taken;
        taken
    }

    /// The orbit is of the past, as after a restart: it is told once [`Self::approach`] has brought it to the
    /// present.
    pub fn hold_back(&mut self) {
        self.behind = self.known;
    }

    /// Takes how the Earth path is turned against the mounting of the parameters, and its sigmas, rad, as they
    /// were told before a restart: for the orbit that begins next. `false`, and no change, where an orbit is
    /// known or they are out of bounds.
    pub fn initialise_mounting(&mut self, misalignment_rad: [f32; 3], sigma_rad: [f32; 3]) -> bool {
        !self.known && self.estimate.begin_mounting(-Vector3::from(misalignment_rad), sigma_rad)
    }

    fn estimate(&self) -> Option<&Estimate> {
        (self.known && !self.behind).then_some(&self.estimate)
    }

    fn estimate_mut(&mut self) -> Option<&mut Estimate> {
        (self.known && !self.behind).then_some(&mut self.estimate)
    }

    /// Resets the filter.
    pub fn reset(&mut self) {
        self.lose();
        self.estimate.forget_mounting();
    }

    /// Forgets the orbit, not how the paths are mounted: for where nothing has contradicted it.
    pub fn lose(&mut self) {
        (self.known, self.behind) = (false, false);
        self.beginning.forget();
    }

    /// Takes in a fix of this time while the orbit is not known, for [`Self::proceed`]; `earth_to_icrs` is
    /// the rotation from the Earth path.
    pub fn begin(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Update {
        if let Err(refusal) = check(parameters.body, fix, earth_to_icrs) {
            return Update::Refused(refusal);
        }
        self.beginning.add(time_us, fix, earth_to_icrs, parameters);
        Update::Collected
    }

    /// Goes on with what takes several seconds, to be called once a second after [`Self::approach`]: the
    /// trial of a first orbit; the look at the limb that is taken into the state when its time is over.
    pub fn proceed(&mut self, parameters: &OrbitParameters) -> Update {
        if !self.known {
            let Some(first) = self.beginning.proceed() else { return Update::Gathered };
            self.beginning.forget();
            self.known = self.estimate.begin(&first, parameters);
            self.behind = self.known;
            return if self.known { Update::Started } else { Update::Gathered };
        }
        let Some(estimate) = self.estimate_mut() else { return Update::Gathered };
        match estimate.finish_look(parameters) {
            Some(result) => self.judged(result, parameters),
            None => Update::Gathered,
        }
    }

    /// Sum of the words of what is known of orbit and mounting, 0 where nothing is. Another at the begin of a
    /// second than at the end of the last tells of an upset.
    pub fn word_sum(&self) -> u32 {
        let told = [self.known, self.behind].map(u32::from);
        if self.known || self.estimate.mounting_is_known() {
            told.into_iter().fold(self.estimate.word_sum(), u32::wrapping_add)
        } else {
            0
        }
    }

    /// Whether it is still on its way across a gap.
    pub fn is_behind(&self) -> bool {
        self.behind
    }

    /// Whether [`Self::proceed`] had much to do: it took a part of a look in, and points of this second would
    /// not be taken in, or it tries a first orbit.
    pub fn is_busy(&self) -> bool {
        if self.known { self.estimate.busy } else { self.beginning.is_trying() }
    }

    /// Takes in the limb's heights of this time about the limb that the state predicts, a sphere of
    /// `radius_km` in sphere space. `attitude_rad2`: covariance of the attitude's rotation vector in the Earth
    /// path.
    pub fn observe_limb(
        &mut self,
        heights: &[LimbHeight],
        radius_km: f32,
        earth_to_icrs: &Matrix3<f64>,
        attitude_rad2: &Matrix3<f32>,
        parameters: &OrbitParameters,
    ) {
        if let Some(estimate) = self.estimate_mut() {
            estimate.add_to_look(heights, radius_km, earth_to_icrs, attitude_rad2, parameters);
        }
    }

    /// Takes in how the Earth path was seen to be turned against where [`Self::misalignment_rad`] has it: by
    /// stars, which say nothing of the place. It moves the place by what both have in common. What is not
    /// `sure` is taken in together with the next that agrees with it and with what was known.
    pub fn observe_mounting(&mut self, seen: &SeenTurn, sure: bool, parameters: &OrbitParameters) {
        if let Some(estimate) = self.estimate_mut() {
            estimate.update_by_mounting(seen, sure, parameters);
        }
    }

    /// Propagates to `time_us` and updates with a fix of that time; before the orbit is known it goes to the
    /// beginning, whose trial is made at once. For where a call may take long.
    pub fn update(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Update {
        // A reset here is no error: the filter begins anew.
        let _ = self.advance(time_us, parameters);
        if self.known {
            return self.update_by_fix(fix, earth_to_icrs, parameters);
        }
        let collected = self.begin(time_us, fix, earth_to_icrs, parameters);
        for _ in 0..CALLS_OF_A_TRIAL {
            if self.proceed(parameters) == Update::Started && self.advance(time_us, parameters).is_ok() {
                return Update::Started;
            }
        }
        collected
    }

    /// Updates with a fix of the time of the state.
    pub fn update_by_fix(
        &mut self,
        fix: &PositionFix,
        earth_to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) -> Update {
        if let Err(refusal) = check(parameters.body, fix, earth_to_icrs) {
            return Update::Refused(refusal);
        }
        let Some(estimate) = self.estimate_mut() else { return Update::Collected };
        let unit = match parameters.observation {
            Observation::LimbHeights | Observation::Position => false,
            Observation::UnitVector => true,
            Observation::Combined => estimate.settled,
        };
        let sharing = estimate.sharing(parameters);
        let bend_km = estimate.bend_km();
        let body = parameters.body;
        let Some(of_fix) = rows_of(body, fix, &estimate.state, earth_to_icrs, (unit, sharing, bend_km))
        else {
            return Update::Refused(FixError::Covariance);
        };
        let mut rows = Rows::of_fix();
        let places = rows.sensitivities.iter_mut().zip(&mut rows.innovations);
        for ((sensitivity, innovation), (row, value)) in places.zip(&of_fix) {
            let height = row.iter().zip(&estimate.horizon).fold(0.0, |sum, (h, x)| sum + h * x);
            (*sensitivity, *innovation) = (*row, value - height);
        }
        let result = estimate.update_by_fix(rows, parameters);
        self.judged(result, parameters)
    }

    /// What an observation came to; after too many that contradict it the orbit is forgotten.
    fn judged(&mut self, (nis, within): (Nis, bool), parameters: &OrbitParameters) -> Update {
        let Some(estimate) = self.estimate() else { return Update::Gathered };
        if estimate.is_valid() && estimate.contradicted < f32::from(parameters.patience) {
            return if within { Update::Accepted(nis) } else { Update::Downweighted(nis) };
        }
        self.reset();
        Update::Diverged(nis)
    }

    /// Propagates state and covariance to `to_us`; without a state nothing happens.
    ///
    /// # Errors
    /// Why the filter was reset.
    pub fn advance(&mut self, to_us: i64, parameters: &OrbitParameters) -> Result<(), ResetReason> {
        if !self.known {
            return Ok(());
        }
        self.behind = false;
        let propagated = self.estimate.propagate(to_us, parameters);
        match propagated {
            Ok(()) => {}
            Err(ResetReason::Backwards | ResetReason::TooLong) => self.lose(),
            Err(ResetReason::Diverged) => self.reset(),
        }
        propagated
    }

    /// As [`Self::advance`], by [`SPANS_A_SECOND`] at most: a longer gap is crossed over several seconds,
    /// in which no orbit is told.
    ///
    /// # Errors
    /// Why the filter was reset.
    pub fn approach(&mut self, to_us: i64, parameters: &OrbitParameters) -> Result<(), ResetReason> {
        let from_us = self.estimate.state.time_us;
        let reach_us = from_us.saturating_add(i64::from(SPANS_A_SECOND) * MAX_SPAN_US);
        let too_long = to_us.saturating_sub(from_us) > MAX_GAP_US;
        let goal_us = if too_long { to_us } else { to_us.min(reach_us) };
        let propagated = self.advance(goal_us, parameters);
        self.behind = self.known && goal_us < to_us;
        propagated
    }

    /// Time, position and velocity; `None`, as for all that follows, until the orbit is known.
    pub fn state(&self) -> Option<&OrbitState> {
        self.estimate().map(|estimate| &estimate.state)
    }

    /// Height of the limb's mean above that of the parameters, km, with its sigma.
    pub fn limb_height_km(&self) -> Option<[f32; 2]> {
        let estimate = self.estimate()?;
        let [height, edge] = [HEIGHT, EDGE].map(|state| estimate.horizon.get(state).copied().unwrap_or(0.0));
        let distance_km = estimate.limb_distance_km();
        let covariance = |one, other| estimate.factor.covariance(one, other);
        let variance = covariance(HEIGHT, HEIGHT)
            + distance_km * (2.0 * covariance(HEIGHT, EDGE) + distance_km * covariance(EDGE, EDGE));
        Some([height + distance_km * edge, libm::sqrtf(variance.max(0.0))])
    }

    /// By what the Earth path is turned against the mounting of the parameters, rad: a rotation vector in the
    /// Earth path, learned by this orbit or one before it.
    pub fn misalignment_rad(&self) -> Vector3<f32> {
        // Not the negative: that of zero has a sign.
        Vector3::zeros() - self.estimate.misalignment
    }

    /// Sigmas of the same, rad; none until the orbit is known.
    pub fn misalignment_sigma_rad(&self) -> Option<[f32; 3]> {
        self.factor().map(|factor| [0, 1, 2].map(|axis| factor.sigma(MISALIGNMENT + axis)))
    }

    /// Covariance of the same, rad²; none until the orbit is known.
    pub fn misalignment_covariance_rad2(&self) -> Option<Matrix3<f64>> {
        self.factor().map(|factor| factor.block(MISALIGNMENT, MISALIGNMENT))
    }

    /// The covariance of all states.
    pub fn factor(&self) -> Option<&Factor> {
        self.estimate().map(|estimate| &estimate.factor)
    }

    /// Covariance of position and velocity.
    pub fn motion_covariance(&self) -> Option<MotionCovariance> {
        self.estimate().map(|estimate| MotionCovariance::of(&estimate.factor, &estimate.state))
    }

    /// Trace of the position's covariance, km², linear: without what a long error along the orbit bends.
    pub fn position_trace_km2(&self) -> Option<f32> {
        self.factor().map(|factor| factor.trace(POSITION))
    }

    /// Trace of the velocity's covariance, km²/s², linear.
    pub fn velocity_trace_km2_s2(&self) -> Option<f32> {
        self.factor().map(|factor| factor.trace(VELOCITY))
    }

    /// Position about `body` and its covariance (km, km², ICRS axes) at a time for which it was propagated;
    /// while the orbit is not known, those of the last fix with what it may have moved since.
    pub fn place(&self, body: CentralBody, time_us: i64) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        if self.known {
            return Some((self.state()?.position_km, self.motion_covariance()?.position_km2()));
        }
        self.beginning.place(body, time_us)
    }

    /// Whether position and velocity have been known to [`OrbitParameters::settled_share`] of their length
    /// since the start.
    pub fn settled(&self) -> bool {
        self.estimate().is_some_and(|estimate| estimate.settled)
    }

    /// Moves the epoch by a step of the clock: the same state under another time.
    pub fn shift_epoch(&mut self, step_us: i64) {
        self.beginning.shift_epoch(step_us);
        self.estimate.shift_epoch(step_us);
    }

    /// Whether the orbit is no longer known: its position to worse than a tenth of its length, or it never
    /// settled and has made one revolution since its last accepted observation, `since_us` microseconds ago.
    pub fn is_stale(&self, since_us: i64) -> bool {
        let Some(estimate) = self.estimate() else { return false };
        let position_km = &estimate.state.position_km;
        let square_km2 = dot(position_km, position_km);
        let told = f64::from(estimate.factor.trace(POSITION)) < TOLD_SHARE * TOLD_SHARE * square_km2;
        let since_s = since_us as f64 / MICROSECONDS;
        // 4 pi² r³ / mu is the square of a circle's period.
        let period_s2 =
            FOUR_PI_SQUARED * square_km2 * libm::sqrt(square_km2) / estimate.body.facts().mu_km3_s2;
        !told || (!estimate.settled && since_s > 0.0 && since_s * since_s > period_s2)
    }

    /// Whether the last observation contradicts the orbit.
    pub fn is_contradicted(&self) -> bool {
        self.estimate().is_some_and(|estimate| estimate.contradicted > 0.0)
    }
}

#[cfg(test)]
mod campaign;
#[cfg(test)]
mod tests;
