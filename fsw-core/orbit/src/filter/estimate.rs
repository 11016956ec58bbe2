//! State of the orbit filter, and its two steps: propagation and measurement update.

use super::{MAX_GAP_US, MAX_SPANS, ResetReason};
use crate::OrbitState;
use crate::beginning::FirstOrbit;
use crate::body::CentralBody;
use crate::constants::{LIGHT_KM_S, MICROSECONDS};
use crate::curvilinear::correct_state;
use crate::dynamics::{MAX_SPAN_US, PropagationError, plausible};
use crate::ephemeris::pole_axis;
use crate::factor::{FIELD, Factor, HEIGHT, MISALIGNMENT, MOTION, POSITION, Row, STATES, VELOCITY};
use crate::horizon::{self, LimbGeometry, WAVES};
use crate::look::{LimbHeight, Look};
use crate::noise::acceleration;
use crate::parameters::OrbitParameters;
use fsw_ground::matrix::{Cholesky, dot, dot_long, dot_slices, plus_scaled, scaled};
use fsw_ground::word_sum;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Noise is added to the covariance once in this time, s.
const NOISE_EVERY_S: f64 = 10.0;
/// Most rows of an observation.
const MAX_ROWS: usize = WAVES;
/// Where the second order of a height by the position's sigma is greater than this, km, a look is taken in
/// gradually: in shares of its information, about the state that the one before left (recursive update,
/// Zanetti 2012).
const GREATEST_BEND_KM: f32 = 0.2;
const GRADUAL: [f32; 3] = [0.01, 0.09, 0.9];
/// In one share.
const AT_ONCE: [f32; 1] = [1.0];
/// A row of a look tests the state where the state's own variance is at least this; the noise's is 1. What is
/// left over the nine waves of a short arc is finer than the edges' patches, and its noise less than 1.
const LEAST_TEST: f32 = 0.1;
/// A row of a fix always does, unless it is empty.
const NOT_EMPTY: f32 = 1e-20;

/// 15/8 of √3; see [`Estimate::add_bend`].
const SECOND_ORDER: f64 = 3.248;

/// Greatest misalignment of a valid estimate: five of the greatest sigma.
const GREATEST_MISALIGNMENT_RAD: f32 = 0.1;
/// Most spans from the end of a look back to the mean of its points: the longest look is 300 s, and the mean
/// is at its begin where the limb was lost at once.
const LOOK_SPANS: u32 = 2;

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

    /// Empty ones for a fix.
    pub(super) fn of_fix() -> Self {
        Self { least_test: NOT_EMPTY, ..Self::of_look() }
    }
}

/// A look that is taken in.
#[derive(Clone, Copy, Debug)]
struct Taking {
    look: Look,
    /// The state at the mean time of its points, before any of it was taken.
    seen: OrbitState,
    /// The misalignment then.
    misalignment: Vector3<f32>,
    /// Shares that are left.
    shares: &'static [f32],
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
    /// Whether it is within the gate.
    fn is_within(self, gate_sigma: f32) -> bool {
        let freedom = f32::from(self.freedom);
        self.square <= freedom + gate_sigma * libm::sqrtf(2.0 * freedom)
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
    pub(super) factor: Factor,
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
    /// Observations rejected in a row.
    pub(super) rejections: u16,
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
            factor: Factor::new(),
            noise_s: 0.0,
            look: None,
            taking: None,
            spans: 0,
            busy: false,
            to_icrs: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            next_look_us: 0,
            settled: false,
            rejections: 0,
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
        let Some(geometry) = LimbGeometry::of(body, state, &pole, body.facts().radius_km as f32) else { return false };
        self.body = body;
        let (horizon, sigmas) = horizon::prior(&geometry, parameters);
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
        (self.settled, self.rejections, self.misalignment) = (false, 0, Vector3::zeros());
        self.check_settled(parameters);
        self.is_valid()
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

    /// Adds the noise of the time since it was last added: white acceleration, integrated, and what the
    /// horizon's states gain while they decay.
    #[inline(never)]
    fn add_noise(&mut self, parameters: &OrbitParameters) {
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
        let field = geometry.field_decay(dt, parameters);
        for (state, variance) in (FIELD..MISALIGNMENT).zip(geometry.field_variances(parameters)) {
            self.renew(state, field, 0.0, variance);
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

    fn geometry(&self) -> Option<LimbGeometry> {
        let radius_km = self.body.facts().radius_km as f32;
        LimbGeometry::of(self.body, &self.state, &pole_axis(self.body, self.state.time_us), radius_km)
    }

    /// Takes the limb points of a second into the look under way, or into a new one where it is time.
    #[inline(never)]
    pub(super) fn add_to_look(
        &mut self,
        heights: &[LimbHeight],
        radius_km: f32,
        to_icrs: &Matrix3<f64>,
        attitude_rad2: &Matrix3<f32>,
        parameters: &OrbitParameters,
    ) {
        let now_us = self.state.time_us;
        let due = now_us >= self.next_look_us && self.taking.is_none();
        let Some(geometry) = self.geometry().filter(|_| due) else { return };
        let look = self.look.get_or_insert(Look::new(now_us, radius_km));
        self.to_icrs = to_icrs.map(|element| element as f32);
        let since_s = (now_us.saturating_sub(look.begun_us)) as f32 * 1e-6;
        // x, y, z of LVLH in the Earth path.
        let axes = (geometry.axes * self.to_icrs).transpose();
        let velocity = self.state.velocity_km_s.map(|axis| axis as f32);
        let velocity = geometry.axes * velocity * (geometry.distance_km / LIGHT_KM_S as f32);
        let count = heights.len() as f32;
        let look_s = look_s(&geometry, parameters);
        let arc_km = arc_rad(heights.iter().map(|point| axes.tr_mul(&point.radial))) * geometry.circle_km();
        let patches = 1.0 + arc_km / geometry.patch_km(parameters);
        let crowding = (count * look_s / patches).max(1.0);
        let common_km2 = geometry.edge_km2(parameters) * crowding;
        for point in heights {
            let radial = axes.tr_mul(&point.radial);
            let length = libm::hypotf(radial.x, radial.y).max(1e-3);
            let azimuth = [radial.x / length, radial.y / length];
            let [cosine, sine] = azimuth;
            // Aberration lifts the limb by D (n · v) / c.
            let lifted =
                geometry.cosine * (velocity.x * cosine + velocity.y * sine) - geometry.sine * velocity.z;
            // The attitude's error is common to the second's points: each has the variance of all.
            let turn = (axes * Vector3::new(-sine, cosine, 0.0)) * geometry.distance_km;
            let turned_km2 = turn.dot(&(attitude_rad2 * turn)) * count;
            let variance = common_km2 + point.sigma_km * point.sigma_km + turned_km2;
            look.add(azimuth, point.height_km - lifted, libm::sqrtf(variance), since_s);
        }
    }

    /// Takes in the look under way when its time is over, in steps of a second each: first noise is added,
    /// then the look's shares follow. Gives what came of a share. After a gap it waits, as the gap took the
    /// second.
    #[inline(never)]
    pub(super) fn finish_look(&mut self, parameters: &OrbitParameters) -> Option<(Nis, bool)> {
        self.busy = false;
        if self.spans > 1 {
            return None;
        }
        let Some(taking) = self.taking else {
            self.end_look(parameters);
            self.busy = self.taking.is_some();
            return None;
        };
        self.busy = true;
        let Some(rows) = self.rows_of_look(&taking, parameters) else {
            self.taking = None;
            return None;
        };
        let (nis, taken) = self.update(&rows, parameters);
        let next = Taking { shares: taking.shares.get(1..).unwrap_or(&[]), ..taking };
        self.taking = Some(next).filter(|next| taken && !next.shares.is_empty());
        Some((nis, taken))
    }

    /// Ends the look under way when its time is over.
    fn end_look(&mut self, parameters: &OrbitParameters) {
        let Some((look, geometry)) = self.look.zip(self.geometry()) else { return };
        let lasts_s = look_s(&geometry, parameters);
        if (self.state.time_us.saturating_sub(look.begun_us) as f32 * 1e-6) < lasts_s {
            return;
        }
        self.look = None;
        let every_us = (geometry.edge_lasts_s(parameters).max(lasts_s) * 1e6) as i64;
        let blind_us = look.begun_us.saturating_sub(self.next_look_us);
        self.next_look_us = look.begun_us.saturating_add(every_us).max(self.state.time_us);
        self.add_noise(parameters);
        self.add_bend(blind_us as f64 / MICROSECONDS);
        let bent_km = self.factor.trace(POSITION) / (2.0 * geometry.distance_km);
        let shares = if bent_km > GREATEST_BEND_KM { &GRADUAL[..] } else { &AT_ONCE };
        let misalignment = self.misalignment;
        self.taking = self.seen(&look, parameters).map(|seen| Taking { look, seen, misalignment, shares });
    }

    /// Adds what the linear covariance lacks after a time in which nothing was seen: the mean motion changes by
    /// -3/2 x + 15/8 x² where the semi-major axis is off by the share x, so that the satellite is that second
    /// order early. The rms of x² is √3 times the variance of x.
    #[inline(never)]
    fn add_bend(&mut self, blind_s: f64) {
        let mu = self.body.facts().mu_km3_s2;
        let OrbitState { position_km, velocity_km_s, .. } = &self.state;
        let square_km2 = dot(position_km, position_km);
        let length_km = libm::sqrt(square_km2);
        // x = 2 a (r · dr / r³ + v · dv / mu), of a = 1 / (2 / r - v² / mu).
        let axis_km = 1.0 / (2.0 / length_km - dot(velocity_km_s, velocity_km_s) / mu);
        let gravity = scaled(position_km, mu / (square_km2 * length_km));
        let by_velocity = scaled(velocity_km_s, 2.0 * axis_km / mu);
        let by_position = scaled(&gravity, 2.0 * axis_km / mu);
        let mut row = [0.0; STATES];
        for (place, element) in row.iter_mut().zip(by_position.iter().chain(&by_velocity)) {
            *place = *element as f32;
        }
        let carried = self.factor.carried(&row);
        let early_s = SECOND_ORDER * blind_s * f64::from(dot_long(&carried, &carried));
        let moved = scaled(velocity_km_s, early_s);
        let turned = scaled(&gravity, -early_s);
        let mut column = [(0, 0.0); MOTION];
        for ((state, place), element) in column.iter_mut().enumerate().zip(moved.iter().chain(&turned)) {
            *place = (state, *element as f32);
        }
        self.factor.append(&column);
    }

    /// The state at the mean time of a look's points: the axes turn, those of that time count. `None` where
    /// that is more than [`LOOK_SPANS`] back.
    fn seen(&self, look: &Look, parameters: &OrbitParameters) -> Option<OrbitState> {
        let mut seen = self.state;
        let mut left_us = (f64::from(self.lag_s(look)) * MICROSECONDS) as i64;
        for _ in 0..LOOK_SPANS {
            let span_us = left_us.clamp(0, MAX_SPAN_US);
            if span_us > 0 {
                seen = parameters.forces().propagate(&seen, -span_us).ok()?;
            }
            left_us = left_us.saturating_sub(span_us);
        }
        (left_us <= 0).then_some(seen)
    }

    /// Time since the mean of a look's points, s.
    fn lag_s(&self, look: &Look) -> f32 {
        self.state.time_us.saturating_sub(look.begun_us) as f32 * 1e-6 - look.mean_s()
    }

    /// Rows of the next share of a look, about the state that the shares before it left.
    #[inline(never)]
    fn rows_of_look(
        &self,
        Taking { look, seen, misalignment, shares }: &Taking,
        parameters: &OrbitParameters,
    ) -> Option<Rows> {
        let geometry =
            LimbGeometry::of(self.body, seen, &pole_axis(self.body, seen.time_us), look.radius_km)?;
        let pole = pole_axis(self.body, self.state.time_us).map(|axis| axis as f32);
        let path = self.to_icrs.transpose();
        let lag_s = self.lag_s(look);
        let now_seen = self.seen(look, parameters)?;
        let moved_km = plus_scaled(&now_seen.position_km, -1.0, &seen.position_km).map(|axis| axis as f32);
        let limb = geometry.moved(&(geometry.moves * moved_km));
        let turned = self.misalignment - misalignment;
        let weight = libm::sqrtf(*shares.first()?);
        let mut rows = Rows::of_look();
        let places = rows.sensitivities.iter_mut().zip(&mut rows.innovations);
        for ((sensitivity, innovation), (waves, height)) in places.zip(look.rows()) {
            let row = geometry.sensitivity(waves, &limb, (&pole, &path), lag_s);
            let by_turn = row.get(MISALIGNMENT..).map_or(0.0, |row| dot_slices(row, turned.as_slice()));
            let expected = dot_slices(waves, &limb.height_km) + dot_slices(&row, &self.horizon) + by_turn;
            let left = height - expected;
            (*sensitivity, *innovation) = (row.map(|element| weight * element), weight * left);
        }
        Some(rows)
    }

    /// As [`Self::update`] by the rows of a fix, the noise of the time until now added.
    pub(super) fn update_by_fix(&mut self, rows: &Rows, parameters: &OrbitParameters) -> (Nis, bool) {
        self.add_noise(parameters);
        self.update(rows, parameters)
    }

    /// Distance of the limb, km.
    pub(super) fn limb_distance_km(&self) -> f32 {
        self.geometry().map_or(0.0, |geometry| geometry.distance_km)
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

    /// Measurement update by an observation, if it passes the gate; gives its NIS and whether it did.
    #[inline(never)]
    pub(super) fn update(&mut self, rows: &Rows, parameters: &OrbitParameters) -> (Nis, bool) {
        let nis = self.nis(rows);
        // Not within: also what is no number.
        if !nis.is_within(parameters.gate_sigma) {
            self.rejections = self.rejections.saturating_add(1);
            return (nis, false);
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
        self.rejections = 0;
        self.check_settled(parameters);
        (nis, true)
    }

    /// Normalised innovation squared of the rows that test the state.
    #[inline(never)]
    fn nis(&self, rows: &Rows) -> Nis {
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
        Nis { square, freedom }
    }
}

/// How long a look lasts, s.
fn look_s(geometry: &LimbGeometry, parameters: &OrbitParameters) -> f32 {
    geometry.edge_lasts_s(parameters).min(parameters.look_s)
}

/// Azimuth that directions span about the third axis, rad: the sum of the widest two sides about their mean.
fn arc_rad(directions: impl Iterator<Item = Vector3<f32>> + Clone) -> f32 {
    let mean = directions.clone().fold(Vector3::zeros(), |sum: Vector3<f32>, direction| sum + direction);
    let (mut low, mut high) = (0.0, 0.0);
    for direction in directions {
        let across = mean.x * direction.y - mean.y * direction.x;
        let along = mean.x * direction.x + mean.y * direction.y;
        let angle = libm::atan2f(across, along);
        (low, high) = (if angle < low { angle } else { low }, if angle > high { angle } else { high });
    }
    high - low
}
