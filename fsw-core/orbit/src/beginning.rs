//! Initial orbit determination: from the first positions to an orbit that has been tested.
//!
//! In: position fixes. Out: state and covariance, once they are good enough to be told.
//!
//! A ring keeps [`FIXES`] fixes, thinned: when it is full every second one is dropped and the least time
//! between two is doubled, up to `LONGEST_SPACING_US`; then the oldest one goes. Least squares over the
//! ring, with the latest fix where it is not full, [`FIXES_A_CALL`] fixes of an iteration a call, whether
//! there is a new fix or not: the first iteration on Lagrange's series `r = f r0 + g v0`, which is linear,
//! the others by propagation and its transition (differential correction). A fix that disagrees by `x²` has
//! the weight `1 / (1 + x² / 12)` (Cauchy), from the fourth iteration on none beyond `GATE`.
//!
//! The errors that neighbouring limb points share last from fix to fix. Their covariance is multiplied by the
//! number of fixes within that time, so that these count as one.
//!
//! The misalignment of the paths is in every fix alike. It is considered: its derivatives go along with the
//! orbit, whose error and the misalignment are therefore correlated.
//!
//! Tests before anything is told: three quarters of the fixes agree, their mean square error is no more than
//! twice what was stated, position and velocity are known to `KNOWN_SHARE` of their length, and the orbit
//! is bound, above the ground and no farther than a satellite.

use super::OrbitState;
use super::body::CentralBody;
use super::constants::MICROSECONDS;
use super::dynamics::{MAX_SPAN_US, Transition, plausible};
use super::forces::Forces;
use super::parameters::OrbitParameters;
use super::point::PositionFix;
use fsw_ground::matrix::{
    Cholesky, add_scaled, add_to_diagonal, cross, cross_matrix, dot, identity, inverse, plus_scaled, product,
    transposed_product,
};
use nalgebra::{ArrayStorage, Matrix3, Matrix3x6, Matrix6, Matrix6x3, Vector3, Vector6};

/// Fixes in the ring.
pub const FIXES: usize = 12;
/// Fewest with which an orbit is tried.
const FEWEST: usize = 8;
/// Least time between two at first, and at most, us.
const FIRST_SPACING_US: i64 = 5_000_000;
const LONGEST_SPACING_US: i64 = 160_000_000;
/// Spans of propagation between two fixes at most; a longer gap begins the ring anew, us.
const SPANS: usize = 2;
const LONGEST_GAP_US: i64 = SPANS as i64 * MAX_SPAN_US;
/// Iterations of a trial.
const ITERATIONS: u8 = 7;
/// Fixes of an iteration that a call sums up, so that it costs 0.7 M cycles.
pub const FIXES_A_CALL: usize = 2;
/// Calls of [`Beginning::proceed`] that a trial takes at most: the last one tests.
pub const CALLS_OF_A_TRIAL: usize = ITERATIONS as usize * (FIXES + 1).div_ceil(FIXES_A_CALL) + 1;
/// Normalised square, three degrees of freedom, beyond which a fix is an outlier: 0.1 % of good ones are.
const GATE: f64 = 16.3;
/// Position and velocity must be known to this share of their length.
const KNOWN_SHARE: f64 = 0.03;

/// A fix in the ring.
#[derive(Clone, Copy, Debug)]
struct Kept {
    time_us: i64,
    position_km: Vector3<f64>,
    noise_km2: Matrix3<f32>,
    shared_km2: Matrix3<f32>,
    /// What a misalignment of one radian about each axis of the Earth path adds to the position, km.
    misaligned_km: Matrix3<f32>,
}

/// A trial under way: the orbit tried, and the normal equations of six unknowns about it.
#[derive(Clone, Debug)]
struct Trial {
    /// What is flown about.
    body: CentralBody,
    /// Its fixes: those of the ring when it began, and the latest.
    of: heapless::Vec<Kept, { FIXES + 1 }>,
    /// How many of them share their slow errors.
    sharing: f64,
    /// The orbit tried, at the last fix.
    state: OrbitState,
    iteration: u8,
    /// Fixes summed up, from the last one back in time.
    fixes: usize,
    /// Where the orbit tried was at the last of these, and the transition to it.
    here: OrbitState,
    moved: Matrix6<f64>,
    matrix: Matrix6<f64>,
    right: Vector6<f64>,
    /// What the misalignment adds to the right side.
    misaligned: Matrix6x3<f64>,
    /// Sum of the normalised squares of those within the gate, and their number.
    squares: f64,
    inliers: usize,
}

/// The ring, and the trial of its orbit.
#[derive(Clone, Debug)]
pub struct Beginning {
    kept: heapless::Vec<Kept, FIXES>,
    spacing_us: i64,
    /// The last fix, kept or not.
    last: Option<Kept>,
    trial: Trial,
    trying: bool,
}

/// An orbit that has been tested.
#[derive(Clone, Copy, Debug)]
pub struct FirstOrbit {
    /// At the time of the last fix.
    pub state: OrbitState,
    /// A square root of the covariance of position (km) and velocity (km/s).
    pub root: Matrix6<f64>,
    /// Derivatives of position and velocity by the misalignment, a rotation vector in the Earth path (km and
    /// km/s a radian): the error that all fixes share.
    pub misaligned: Matrix6x3<f64>,
}

impl Default for Beginning {
    fn default() -> Self {
        Self::new()
    }
}

impl Beginning {
    /// An empty ring.
    pub const fn new() -> Self {
        Self {
            kept: heapless::Vec::new(),
            spacing_us: FIRST_SPACING_US,
            last: None,
            trial: Trial::NONE,
            trying: false,
        }
    }

    /// Forgets every fix.
    pub fn forget(&mut self) {
        self.kept.clear();
        (self.spacing_us, self.last, self.trying) = (FIRST_SPACING_US, None, false);
    }

    /// Takes a fix; with enough of them a trial begins. `to_icrs`: the rotation from the Earth path.
    #[inline(never)]
    pub fn add(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        to_icrs: &Matrix3<f64>,
        parameters: &OrbitParameters,
    ) {
        let misaligned_km = product(&cross_matrix(&fix.position_km), to_icrs);
        let kept = Kept {
            time_us,
            position_km: fix.position_km,
            noise_km2: fix.covariance_km2.map(|element| element as f32),
            shared_km2: fix.shared_km2.map(|element| element as f32),
            misaligned_km: misaligned_km.map(|element| element as f32),
        };
        let since_us = self.kept.last().map_or(i64::MAX, |last| time_us.saturating_sub(last.time_us));
        let same_arc = (0..=LONGEST_GAP_US).contains(&since_us);
        if !same_arc {
            self.forget();
        }
        self.last = Some(kept);
        let due = since_us >= self.spacing_us;
        // A trial waits for half of the spacing only: the arc may end before the whole.
        let apart = since_us >= self.spacing_us / 2;
        if due && self.kept.is_full() {
            self.thin();
        }
        if due {
            let _ = self.kept.push(kept);
        }
        if !self.trying && apart && self.kept.len() >= FEWEST {
            self.trial.of.clear();
            let latest = Some(&kept).filter(|_| !due);
            for fix in self.kept.iter().chain(latest) {
                let _ = self.trial.of.push(*fix);
            }
            self.trial.body = parameters.body;
            self.trial.sharing = self.sharing(parameters);
            self.trial.state =
                OrbitState { time_us, position_km: fix.position_km, velocity_km_s: Vector3::zeros() };
            self.trial.begin(0);
            self.trying = true;
        }
    }

    /// Position about `body` and covariance (km, km²) at a time by the last fix alone: since then it has
    /// moved with at most the speed of escape, in a direction that is not known.
    pub fn place(&self, body: CentralBody, time_us: i64) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let Kept { time_us: then_us, position_km, noise_km2, shared_km2, .. } = self.last.as_ref()?;
        let since_s = time_us.saturating_sub(*then_us) as f64 / MICROSECONDS;
        let distance_km = libm::sqrt(dot(position_km, position_km)).max(1.0);
        let axis_km2 = 2.0 / 3.0 * body.facts().mu_km3_s2 / distance_km * since_s * since_s;
        let mut covariance_km2 = noise_km2.map(f64::from);
        add_scaled(&mut covariance_km2, 1.0, &shared_km2.map(f64::from));
        add_to_diagonal(&mut covariance_km2, axis_km2);
        Some((*position_km, covariance_km2))
    }

    /// Moves all times by a step of the clock.
    pub fn shift_epoch(&mut self, step_us: i64) {
        for kept in self.kept.iter_mut().chain(&mut self.trial.of).chain(&mut self.last) {
            kept.time_us = kept.time_us.saturating_add(step_us);
        }
        for state in [&mut self.trial.state, &mut self.trial.here] {
            state.time_us = state.time_us.saturating_add(step_us);
        }
    }

    /// Makes room: every second fix goes, or the oldest.
    fn thin(&mut self) {
        let every_second = self.spacing_us < LONGEST_SPACING_US;
        let mut kept = 0;
        for at in 0..self.kept.len() {
            let stays = if every_second { at % 2 == 1 } else { at > 0 };
            if stays {
                if let Ok([place, fix]) = self.kept.get_disjoint_mut([kept, at]) {
                    core::mem::swap(place, fix);
                }
                kept += 1;
            }
        }
        self.kept.truncate(kept);
        if every_second {
            self.spacing_us *= 2;
        }
    }

    /// Number of fixes that share their slow errors.
    fn sharing(&self, parameters: &OrbitParameters) -> f64 {
        let Some(last) = self.kept.last() else { return 1.0 };
        let square_km2 = dot(&last.position_km, &last.position_km).max(1.0);
        let facts = parameters.body.facts();
        let turn = libm::sqrt(facts.mu_km3_s2 / (square_km2 * libm::sqrt(square_km2)));
        let ground_km_s = libm::fabs(turn - facts.rate_rad_s).max(1e-9) * facts.radius_km;
        let lasting_s = 2.0 * f64::from(parameters.field_length_km) / ground_km_s;
        let spacing_s = self.spacing_us as f64 / MICROSECONDS;
        (lasting_s / spacing_s).clamp(1.0, FIXES as f64)
    }

    /// Whether a trial is under way.
    pub fn is_trying(&self) -> bool {
        self.trying
    }

    /// A part of the trial's iteration, after the last one the tests: gives the orbit when it has passed
    /// every one.
    #[inline(never)]
    pub fn proceed(&mut self) -> Option<FirstOrbit> {
        // A trial that fails, or has been made, is over.
        if !core::mem::take(&mut self.trying) {
            return None;
        }
        if self.trial.iteration == ITERATIONS {
            return self.tested();
        }
        for _ in 0..FIXES_A_CALL {
            if self.trial.fixes < self.trial.of.len() {
                self.trial.add()?;
            }
        }
        let Trial { fixes, iteration, .. } = self.trial;
        if fixes == self.trial.of.len() {
            self.trial.step()?;
            if iteration + 1 < ITERATIONS {
                self.trial.begin(iteration + 1);
            } else {
                self.trial.iteration = ITERATIONS;
            }
        }
        self.trying = true;
        None
    }

    /// The orbit tried, if it passes the tests.
    fn tested(&self) -> Option<FirstOrbit> {
        let Trial { squares, inliers, .. } = self.trial;
        let factor = Cholesky::of(&self.trial.matrix)?;
        let root = factor.whitened(&identity()).transpose();
        let misaligned = product(&root, &factor.whitened(&self.trial.misaligned));
        let first = FirstOrbit { state: self.trial.state, root, misaligned };
        let agreed = 4 * inliers >= 3 * self.trial.of.len() && squares <= 2.0 * (3.0 * inliers as f64 - 6.0);
        (agreed && is_known(&first) && is_orbit(self.trial.body, &first.state)).then_some(first)
    }
}

impl Trial {
    const NONE: Self = {
        let nothing = Vector3::new(0.0, 0.0, 0.0);
        let state = OrbitState { time_us: 0, position_km: nothing, velocity_km_s: nothing };
        let zeros = Matrix6::from_array_storage(ArrayStorage([[0.0; 6]; 6]));
        let right = Vector6::from_array_storage(ArrayStorage([[0.0; 6]]));
        Self {
            body: CentralBody::Earth,
            of: heapless::Vec::new(),
            sharing: 0.0,
            state,
            iteration: 0,
            fixes: 0,
            here: state,
            moved: zeros,
            matrix: zeros,
            right,
            misaligned: Matrix6x3::from_array_storage(ArrayStorage([[0.0; 6]; 3])),
            squares: 0.0,
            inliers: 0,
        }
    };

    /// Begins an iteration about the orbit tried.
    fn begin(&mut self, iteration: u8) {
        (self.iteration, self.fixes, self.here) = (iteration, 0, self.state);
        for (at, column) in self.moved.data.0.iter_mut().enumerate() {
            for (row, element) in column.iter_mut().enumerate() {
                *element = f64::from(u8::from(row == at));
            }
        }
        self.matrix.fill(0.0);
        self.right.fill(0.0);
        self.misaligned.fill(0.0);
        (self.squares, self.inliers) = (0.0, 0);
    }

    /// Adds the next fix back in time to the normal equations about the orbit tried. In the first iteration
    /// about nothing, by Lagrange's series.
    #[inline(never)]
    fn add(&mut self) -> Option<()> {
        let kept = *self.of.iter().rev().nth(self.fixes)?;
        let (predicted, partials) = if self.iteration == 0 {
            (
                Vector3::zeros(),
                lagrange(self.body, &self.state.position_km, kept.time_us.saturating_sub(self.state.time_us)),
            )
        } else {
            let point = Forces::KEPLER.about(self.body);
            for _ in 0..SPANS {
                let span_us = kept.time_us.saturating_sub(self.here.time_us).max(-MAX_SPAN_US);
                if span_us < 0 {
                    let there = point.propagate(&self.here, span_us).ok()?;
                    self.moved = product(&matrix_of(&point.transition(&self.here, &there)), &self.moved);
                    self.here = there;
                }
            }
            (self.here.position_km, upper_rows(&self.moved))
        };
        let mut covariance = kept.noise_km2.map(f64::from);
        add_scaled(&mut covariance, self.sharing, &kept.shared_km2.map(f64::from));
        let information = inverse(&covariance)?;
        let off = plus_scaled(&kept.position_km, -1.0, &predicted);
        let weighted = transposed_product(&partials, &information);
        let square = dot(&off, &product(&information, &off));
        let inlier = square < GATE;
        let weight = match self.iteration {
            0 => 1.0,
            1..=3 => 1.0 / (1.0 + square / 12.0),
            _ => f64::from(u8::from(inlier)),
        };
        add_scaled(&mut self.matrix, weight, &product(&weighted, &partials));
        add_scaled(&mut self.right, weight, &product(&weighted, &off));
        add_scaled(&mut self.misaligned, weight, &product(&weighted, &kept.misaligned_km.map(f64::from)));
        if inlier {
            self.squares += square;
            self.inliers += 1;
        }
        self.fixes += 1;
        Some(())
    }

    /// Moves the orbit tried to the minimum of the sums.
    fn step(&mut self) -> Option<()> {
        let [[x, y, z, vx, vy, vz]] = Cholesky::of(&self.matrix)?.solve(&self.right).data.0;
        if self.iteration == 0 {
            self.state.position_km = Vector3::zeros();
        }
        add_scaled(&mut self.state.position_km, 1.0, &Vector3::new(x, y, z));
        add_scaled(&mut self.state.velocity_km_s, 1.0, &Vector3::new(vx, vy, vz));
        plausible(self.body, &self.state.position_km, &self.state.velocity_km_s).then_some(())
    }
}

fn matrix_of(transition: &Transition) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    for (i, row) in transition.iter().enumerate() {
        for (column, element) in matrix.data.0.iter_mut().zip(row) {
            if let Some(place) = column.get_mut(i) {
                *place = *element;
            }
        }
    }
    matrix
}

/// The first three rows: of the position.
fn upper_rows(matrix: &Matrix6<f64>) -> Matrix3x6<f64> {
    let mut rows = Matrix3x6::zeros();
    for (to, from) in rows.data.0.iter_mut().zip(&matrix.data.0) {
        for (place, element) in to.iter_mut().zip(from) {
            *place = *element;
        }
    }
    rows
}

/// `[f I, g I]` of Lagrange's series to the third order, `span_us` from a place at this distance.
fn lagrange(body: CentralBody, position_km: &Vector3<f64>, span_us: i64) -> Matrix3x6<f64> {
    let t = span_us as f64 / MICROSECONDS;
    let square_km2 = dot(position_km, position_km).max(1.0);
    let falling = body.facts().mu_km3_s2 / (square_km2 * libm::sqrt(square_km2)) * t * t;
    let (f, g) = (1.0 - 0.5 * falling, t * (1.0 - falling / 6.0));
    let mut partials = Matrix3x6::zeros();
    for (at, column) in partials.data.0.iter_mut().enumerate() {
        if let Some(place) = column.get_mut(at % 3) {
            *place = if at < 3 { f } else { g };
        }
    }
    partials
}

/// Whether position and velocity are known well enough.
fn is_known(first: &FirstOrbit) -> bool {
    let FirstOrbit { state, root, .. } = first;
    let mut variances = Vector6::<f64>::zeros();
    for column in &root.data.0 {
        for (sum, element) in variances.iter_mut().zip(column) {
            *sum += element * element;
        }
    }
    let [[x, y, z, vx, vy, vz]] = variances.data.0;
    let share = KNOWN_SHARE * KNOWN_SHARE;
    x + y + z < share * dot(&state.position_km, &state.position_km)
        && vx + vy + vz < share * dot(&state.velocity_km_s, &state.velocity_km_s)
}

/// Whether a state is on a closed orbit above the ground of `body` and below the greatest of its bounds; by 3
/// % of its radius, as it may be off.
pub fn is_orbit(body: CentralBody, state: &OrbitState) -> bool {
    let facts = body.facts();
    let [_, highest_km] = facts.bounds_km;
    let OrbitState { position_km, velocity_km_s, .. } = state;
    let radius = libm::sqrt(dot(position_km, position_km));
    let energy = 0.5 * dot(velocity_km_s, velocity_km_s) - facts.mu_km3_s2 / radius;
    let axis_km = -0.5 * facts.mu_km3_s2 / energy;
    let momentum = cross(position_km, velocity_km_s);
    let shape = 1.0 - dot(&momentum, &momentum) / (facts.mu_km3_s2 * axis_km);
    let eccentricity = libm::sqrt(shape.max(0.0));
    energy < 0.0
        && axis_km * (1.0 - eccentricity) > (1.0 - KNOWN_SHARE) * facts.radius_km
        && axis_km * (1.0 + eccentricity) < highest_km
}

#[cfg(test)]
mod tests;
