//! State of the orbit filter, and its two steps: propagation and measurement update.

mod growth;
mod looking;

use super::{MAX_GAP_US, MAX_SPANS, ResetReason, SeenTurn};
use crate::OrbitState;
use crate::beginning::FirstOrbit;
use crate::body::CentralBody;
use crate::constants::MICROSECONDS;
use crate::curvilinear::correct_state;
use crate::dynamics::{MAX_SPAN_US, PropagationError, plausible};
use crate::ephemeris::pole_axis;
use crate::factor::{Factor, MISALIGNMENT, MOTION, POSITION, Row, STATES, VELOCITY};
use crate::horizon::{self, LimbGeometry, WAVES};
use crate::look::Look;
use crate::parameters::{Misalignment, OrbitParameters};
use fsw_ground::matrix::{Cholesky, add_scaled_long, dot, dot_long, plus_scaled, product};
use fsw_ground::word_sum;
use looking::Taking;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Noise is added to the covariance once in this time, s.
const NOISE_EVERY_S: f64 = 10.0;
/// Most rows of an observation.
const MAX_ROWS: usize = WAVES;
/// A row of a look tests the state where the state's own variance is at least this; the noise's is 1. What is
/// left over the nine waves of a short arc is finer than the edges' patches, and its noise less than 1.
const LEAST_TEST: f32 = 0.1;
/// NIS of a gross contradiction over that of the gate: it is twice as many sigmas off.
const GROSS: f32 = 4.0;
/// A row of a fix always does, unless it is empty.
const NOT_EMPTY: f32 = 1e-20;

/// Greatest misalignment of a valid estimate: five of the greatest sigma.
const GREATEST_MISALIGNMENT_RAD: f32 = 0.1;

/// Rows of an observation of unit variance: sensitivities, and measured less predicted values.
pub(super) struct Rows {
    /// Least variance by the state of a row that tests it.
    least_test: f32,
    pub(super) sensitivities: [Row; MAX_ROWS],
    pub(super) innovations: [f32; MAX_ROWS],
}

impl Rows {
    /// Empty ones for a look.
    fn of_look() -> Self {
        Self {
            least_test: LEAST_TEST,
            sensitivities: [[0.0; STATES]; MAX_ROWS],
            innovations: [0.0; MAX_ROWS],
        }
    }

    /// Allows for an error that nobody foresaw, of covariance `share v v'` along the innovations `v`; the rows
    /// are of unit variance again. Those that do not test the state are left out. With `1/g - 1/q` the NIS
    /// falls from `q` to `g` (Sherman and Morrison).
    fn widen(&mut self, tests: &[bool; MAX_ROWS], share: f32) {
        let mut along = [0.0; STATES];
        let mut square = 0.0;
        let places = self.sensitivities.iter_mut().zip(&mut self.innovations);
        for ((row, innovation), test) in places.zip(tests) {
            if *test {
                add_scaled_long(&mut along, *innovation, row);
                square += *innovation * *innovation;
            } else {
                (*row, *innovation) = ([0.0; STATES], 0.0);
            }
        }
        // (1 + share v v')^-1/2 = 1 - (1 - left) v v' / (v' v).
        let left = 1.0 / libm::sqrtf(1.0 + share * square);
        let less = (1.0 - left) / square.max(1e-20);
        for (row, innovation) in self.sensitivities.iter_mut().zip(&mut self.innovations) {
            add_scaled_long(row, -less * *innovation, &along);
            *innovation *= left;
        }
    }

    /// Empty ones for a fix.
    pub(super) fn of_fix() -> Self {
        Self { least_test: NOT_EMPTY, ..Self::of_look() }
    }
}

/// Normalised innovation squared of an observation, and its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nis {
    /// The square.
    pub square: f32,
    /// Its expectation.
    pub freedom: u8,
}

impl Nis {
    /// The greatest within the gate.
    fn gate(self, gate_sigma: f32) -> f32 {
        let freedom = f32::from(self.freedom);
        freedom + gate_sigma * libm::sqrtf(2.0 * freedom)
    }

    /// How much of a contradiction one beyond the gate is, 1 for a gross one.
    fn contradicts(self, gate: f32) -> f32 {
        let share = self.square / (GROSS * gate);
        if share < 1.0 { share } else { 1.0 }
    }
}

/// State, covariance and history of the filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// What is flown about.
    pub(super) body: CentralBody,
    pub(super) state: OrbitState,
    /// The horizon model's states; 0 for the others.
    pub(super) horizon: Row,
    /// Misalignment of the paths, rad: a rotation vector in the Earth path, which is turned by its opposite
    /// when limb points are taken.
    pub(super) misalignment: Vector3<f32>,
    /// Whether misalignment and its sigmas go on into the next orbit; where not, it is 0.
    mounting_known: bool,
    pub(super) factor: Factor,
    /// What was seen last of the Earth path's turn and is not sure: against the parameters' mounting.
    unsure: Option<SeenTurn>,
    /// Time since noise was added, s.
    noise_s: f64,
    /// The look at the limb under way.
    look: Option<Look>,
    /// A look that is over and is taken in, a step a second.
    taking: Option<Taking>,
    /// Spans that the second's propagation took.
    spans: u32,
    /// Whether the second went to a look that was taken in.
    pub(super) busy: bool,
    /// From the Earth path to ICRS in its last second.
    to_icrs: Matrix3<f32>,
    /// When the next one may begin.
    next_look_us: i64,
    pub(super) settled: bool,
    /// Observations in a row that contradict the state, by [`Nis::contradicts`].
    pub(super) contradicted: f32,
}

impl Estimate {
    /// One of no orbit, to be begun.
    pub(super) const fn new() -> Self {
        let nothing = Vector3::new(0.0, 0.0, 0.0);
        Self {
            body: CentralBody::Earth,
            state: OrbitState { time_us: 0, position_km: nothing, velocity_km_s: nothing },
            horizon: [0.0; STATES],
            misalignment: Vector3::new(0.0, 0.0, 0.0),
            mounting_known: false,
            factor: Factor::new(),
            unsure: None,
            noise_s: 0.0,
            look: None,
            taking: None,
            spans: 0,
            busy: false,
            to_icrs: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            next_look_us: 0,
            settled: false,
            contradicted: 0.0,
        }
    }

    /// Begins with a state and the covariance of position and velocity. `false`, and no change, where the
    /// state is impossible or spans no plane; `false` too where the covariance is none.
    #[inline(never)]
    pub(super) fn begin(&mut self, first: &FirstOrbit, parameters: &OrbitParameters) -> bool {
        let FirstOrbit { state, root, misaligned } = first;
        let body = parameters.body;
        if !plausible(body, &state.position_km, &state.velocity_km_s) {
            return false;
        }
        let pole = pole_axis(body, state.time_us);
        let Some(geometry) = LimbGeometry::of(body, state, &pole, body.facts().radius_km as f32) else {
            return false;
        };
        self.body = body;
        let (horizon, mut sigmas) = horizon::prior(&geometry, parameters);
        if self.mounting_known {
            for (state, sigma) in sigmas.iter_mut().enumerate().skip(MISALIGNMENT) {
                *sigma = self.factor.sigma(state);
            }
        }
        self.factor.begin(&sigmas);
        for (column, elements) in root.data.0.iter().enumerate() {
            for (row, element) in elements.iter().enumerate() {
                self.factor.set(row, column, *element as f32);
            }
        }
        // The fixes have taken the misalignment for a part of the position: against it.
        for (axis, elements) in misaligned.data.0.iter().enumerate() {
            let column = MISALIGNMENT + axis;
            let sigma = sigmas.get(column).copied().unwrap_or(0.0);
            for (row, element) in elements.iter().enumerate() {
                self.factor.set(row, column, -sigma * *element as f32);
            }
        }
        (self.state, self.horizon) = (*state, horizon);
        (self.noise_s, self.look, self.taking, self.next_look_us) = (0.0, None, None, state.time_us);
        (self.settled, self.contradicted) = (false, 0.0);
        self.check_settled(parameters);
        let valid = self.is_valid();
        if valid {
            self.mounting_known = true;
        } else {
            self.forget_mounting();
        }
        valid
    }

    /// Whether it holds how the paths are mounted, for the next orbit too.
    pub(super) fn mounting_is_known(&self) -> bool {
        self.mounting_known
    }

    /// The next orbit begins with this misalignment. `false`, and no change, where it is out of bounds.
    pub(super) fn begin_mounting(&mut self, misalignment: Vector3<f32>, sigma_rad: [f32; 3]) -> bool {
        let sound = |angle: &f32| libm::fabsf(*angle) < GREATEST_MISALIGNMENT_RAD;
        let spread = |sigma: &f32| *sigma > 0.0 && sound(sigma);
        if !misalignment.iter().all(sound) || !sigma_rad.iter().all(spread) {
            return false;
        }
        let mut sigmas = [0.0; STATES];
        for (place, sigma) in sigmas.iter_mut().skip(MISALIGNMENT).zip(sigma_rad) {
            *place = sigma;
        }
        self.factor.begin(&sigmas);
        (self.mounting_known, self.misalignment, self.unsure) = (true, misalignment, None);
        true
    }

    /// The next orbit begins with the mounting of the parameters.
    pub(super) fn forget_mounting(&mut self) {
        (self.mounting_known, self.misalignment, self.unsure) = (false, Vector3::zeros(), None);
    }

    /// Sets `settled` once the sigmas of position and velocity are below `settled_share` of their length.
    pub(super) fn check_settled(&mut self, parameters: &OrbitParameters) {
        let share = f64::from(parameters.settled_share);
        let OrbitState { position_km, velocity_km_s, .. } = &self.state;
        let known = |first: usize, vector: &Vector3<f64>| {
            f64::from(self.factor.trace(first)) < share * share * dot(vector, vector)
        };
        self.settled |= known(POSITION, position_km) && known(VELOCITY, velocity_km_s);
    }

    /// Whether state and covariance are within their bounds.
    pub(super) fn is_valid(&self) -> bool {
        plausible(self.body, &self.state.position_km, &self.state.velocity_km_s)
            && self.horizon.iter().all(|value| libm::fabsf(*value) < 1e4)
            && self.misalignment.iter().all(|angle| libm::fabsf(*angle) < GREATEST_MISALIGNMENT_RAD)
            && self.factor.is_valid()
    }

    /// Sum of the words of what is told: state and covariance, and when noise and the next look are due.
    pub(super) fn word_sum(&self) -> u32 {
        let OrbitState { time_us, position_km, velocity_km_s } = &self.state;
        let doubles = [position_km, velocity_km_s].map(|vector| word_sum::of_doubles(vector.as_slice()));
        let singles = [&self.horizon[..], self.misalignment.as_slice()].map(word_sum::of_singles);
        let longs =
            [*time_us as u64, self.next_look_us as u64, self.noise_s.to_bits()].map(word_sum::of_long);
        let parts = doubles.into_iter().chain(singles).chain(longs).chain([self.body as u32]);
        parts.fold(self.factor.word_sum(), u32::wrapping_add)
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
        self.spans = 0;
        for _ in 0..MAX_SPANS {
            let span = to_us.saturating_sub(self.state.time_us).min(MAX_SPAN_US);
            if span > 0 {
                self.spans += 1;
                self.propagate_span(span, parameters)?;
            }
        }
        Ok(())
    }

    #[inline(never)]
    fn propagate_span(&mut self, span_us: i64, parameters: &OrbitParameters) -> Result<(), ResetReason> {
        let after = parameters.forces().propagate(&self.state, span_us).map_err(|error| match error {
            PropagationError::TooLong => ResetReason::TooLong,
            PropagationError::Impossible => ResetReason::Diverged,
        })?;
        let transition = parameters.forces().transition(&self.state, &after);
        let transition = transition.map(|row| row.map(|element| element as f32));
        self.factor.propagate(&transition);
        self.state = after;
        self.noise_s += span_us as f64 / MICROSECONDS;
        if self.noise_s >= NOISE_EVERY_S {
            self.add_noise(parameters);
        }
        if self.is_valid() { Ok(()) } else { Err(ResetReason::Diverged) }
    }

    fn geometry(&self) -> Option<LimbGeometry> {
        let radius_km = self.body.facts().radius_km as f32;
        LimbGeometry::of(self.body, &self.state, &pole_axis(self.body, self.state.time_us), radius_km)
    }

    /// As [`Self::update`] by the rows of a fix, the noise of the time until now added.
    pub(super) fn update_by_fix(&mut self, rows: Rows, parameters: &OrbitParameters) -> (Nis, bool) {
        self.add_noise(parameters);
        self.update(rows, parameters)
    }

    /// As [`Self::update`] by what is seen of the Earth path's turn. The misalignment is estimated, whatever is
    /// done by the limb. What is beyond the gate does not contradict the orbit. What is not `sure` may be no
    /// star: it waits for the next, and both must agree within the gate.
    #[inline(never)]
    pub(super) fn update_by_mounting(&mut self, seen: &SeenTurn, sure: bool, parameters: &OrbitParameters) {
        // The path is turned by the misalignment's opposite.
        let SeenTurn { sensitivity, measured } = seen;
        let by_known = product(sensitivity, &self.misalignment);
        let now = SeenTurn { measured: plus_scaled(measured, -1.0, &by_known), ..*seen };
        let before = self.unsure.take().filter(|_| !sure);
        let mut rows = Rows::of_fix();
        let mut places = rows.sensitivities.iter_mut().zip(&mut rows.innovations);
        for SeenTurn { sensitivity, measured } in [Some(now), before].iter().flatten() {
            let innovations = plus_scaled(measured, 1.0, &product(sensitivity, &self.misalignment));
            for ((row, value), (place, innovation)) in
                sensitivity.row_iter().zip(&innovations).zip(&mut places)
            {
                *innovation = *value;
                for (place, element) in place.iter_mut().skip(MISALIGNMENT).zip(&row) {
                    *place = -element;
                }
            }
        }
        if !sure {
            let (nis, _) = self.nis(&rows);
            // False for what is no number, too.
            let agree = nis.square <= nis.gate(parameters.gate_sigma);
            if before.is_none() || !agree {
                self.unsure = Some(now);
                return;
            }
        }
        let contradicted = self.contradicted;
        self.update(rows, &OrbitParameters { misalignment: Misalignment::Estimated, ..*parameters });
        self.contradicted = contradicted;
    }

    /// Distance of the limb, km.
    pub(super) fn limb_distance_km(&self) -> f32 {
        let OrbitState { time_us, position_km, .. } = &self.state;
        let (pole, radius_km) = (pole_axis(self.body, *time_us), self.body.facts().radius_km as f32);
        horizon::limb_distance_km(self.body, position_km, &pole, radius_km).unwrap_or(0.0)
    }

    /// The second order of a fix by the position's sigma, km.
    pub(super) fn bend_km(&self) -> f64 {
        let position_km = &self.state.position_km;
        f64::from(self.factor.trace(POSITION)) / (2.0 * libm::sqrt(dot(position_km, position_km)))
    }

    /// Number of fixes, a second apart, that share their slow errors.
    pub(super) fn sharing(&self, parameters: &OrbitParameters) -> f64 {
        let lasting_s = self.geometry().map_or(1.0, |geometry| geometry.field_lasts_s(parameters));
        f64::from(lasting_s.min(parameters.edge_longest_s).max(1.0))
    }

    /// Moves all times by a step of the clock.
    pub(super) fn shift_epoch(&mut self, step_us: i64) {
        for time_us in [&mut self.state.time_us, &mut self.next_look_us] {
            *time_us = time_us.saturating_add(step_us);
        }
        if let Some(look) = &mut self.look {
            look.begun_us = look.begun_us.saturating_add(step_us);
        }
        if let Some(Taking { look, seen, .. }) = &mut self.taking {
            look.begun_us = look.begun_us.saturating_add(step_us);
            seen.time_us = seen.time_us.saturating_add(step_us);
        }
    }

    /// Measurement update by an observation; gives its NIS and whether it is within the gate. One beyond it
    /// counts for less ([`Rows::widen`]), what is no number for nothing.
    #[inline(never)]
    pub(super) fn update(&mut self, mut rows: Rows, parameters: &OrbitParameters) -> (Nis, bool) {
        let (nis, tests) = self.nis(&rows);
        let gate = nis.gate(parameters.gate_sigma);
        // Also false of what is no number.
        let within = nis.square <= gate;
        self.contradicted = if within { 0.0 } else { self.contradicted + nis.contradicts(gate) };
        if !within {
            if !nis.square.is_finite() {
                return (nis, false);
            }
            rows.widen(&tests, 1.0 / gate - 1.0 / nis.square);
        }
        let mut correction = [0.0; STATES];
        for (sensitivity, innovation) in rows.sensitivities.iter().zip(&rows.innovations) {
            let gain = self.factor.update(sensitivity, parameters.misalignment);
            let left = innovation - sensitivity.iter().zip(&correction).fold(0.0, |sum, (h, x)| sum + h * x);
            for (sum, gain) in correction.iter_mut().zip(&gain) {
                *sum += gain * left;
            }
        }
        let [x, y, z, vx, vy, vz, ..] = correction.map(f64::from);
        let by = (Vector3::new(x, y, z), Vector3::new(vx, vy, vz));
        let OrbitState { position_km, velocity_km_s, .. } = &mut self.state;
        if let Some(turn) = correct_state(self.body.facts().mu_km3_s2, position_km, velocity_km_s, &by) {
            self.factor.propagate(&turn.map(|row| row.map(|element| element as f32)));
        }
        self.factor.settle();
        for (value, by) in self.horizon.iter_mut().zip(&correction).take(MISALIGNMENT).skip(MOTION) {
            *value += by;
        }
        for (value, by) in self.misalignment.iter_mut().zip(correction.iter().skip(MISALIGNMENT)) {
            *value += by;
        }
        self.check_settled(parameters);
        (nis, within)
    }

    /// Normalised innovation squared of the rows that test the state, and which do.
    #[inline(never)]
    fn nis(&self, rows: &Rows) -> (Nis, [bool; MAX_ROWS]) {
        let carried = rows.sensitivities.each_ref().map(|row| self.factor.carried(row));
        let mut matrix = SMatrix::<f32, MAX_ROWS, MAX_ROWS>::identity();
        let mut innovation = SVector::<f32, MAX_ROWS>::zeros();
        let tests = carried.each_ref().map(|row| dot_long(row, row) >= rows.least_test);
        let mut freedom = 0;
        for (i, (one, test)) in carried.iter().zip(&tests).enumerate() {
            if !test {
                continue;
            }
            freedom += 1;
            if let (Some(place), Some(value)) = (innovation.get_mut(i), rows.innovations.get(i)) {
                *place = *value;
            }
            for (j, (other, test)) in carried.iter().zip(&tests).enumerate().take(i + 1) {
                if let Some(place) = matrix.get_mut((i, j)).filter(|_| *test) {
                    *place += dot_long(one, other);
                }
            }
        }
        let square = Cholesky::of(&matrix).map_or(f32::NAN, |factor| {
            let white = factor.whitened(&innovation);
            dot(&white, &white)
        });
        (Nis { square, freedom }, tests)
    }
}

#[cfg(test)]
mod tests;
