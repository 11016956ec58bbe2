//! Initial orbit determination: from the first positions to an orbit that has been tested.
//!
//! In: position fixes. Out: state and covariance, once they are good enough to be told.
//!
//! A ring keeps [`FIXES`] fixes, thinned: when it is full every second one is dropped and the least time
//! between two is doubled, up to `LONGEST_SPACING_US`; then the oldest one goes. Least squares over the ring,
//! one iteration a call: the first on Lagrange's series `r = f r0 + g v0`, which is linear, the others by
//! propagation and its transition (differential correction). A fix that disagrees by `x²` has the weight
//! `1 / (1 + x² / 12)` (Cauchy), from the fourth iteration on none beyond `GATE`.
//!
//! The errors that neighbouring limb points share last from fix to fix. Their covariance is multiplied by the
//! number of fixes within that time, so that these count as one.
//!
//! Tests before anything is told: three quarters of the fixes agree, their mean square error is no more than
//! twice what was stated, position and velocity are known to `KNOWN_SHARE` of their length, and the orbit
//! is bound, above the ground and no farther than a satellite.

use super::OrbitState;
use super::constants::{EARTH_RADIUS_KM, EARTH_RATE_RAD_S, MICROSECONDS, MU_EARTH_KM3_S2};
use super::dynamics::{Dynamics, HIGHEST_KM, MAX_SPAN_US, Transition, plausible, transition};
use super::parameters::OrbitParameters;
use super::point::PositionFix;
use fsw_ground::matrix::{
    Cholesky, add_scaled, cross, dot, identity, inverse, plus_scaled, product, transposed_product,
};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

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
}

/// A trial under way.
#[derive(Clone, Copy, Debug)]
struct Trial {
    state: OrbitState,
    iteration: u8,
}

/// The ring, and the trial of its orbit.
#[derive(Clone, Debug)]
pub struct Beginning {
    kept: heapless::Vec<Kept, FIXES>,
    spacing_us: i64,
    trial: Option<Trial>,
}

/// An orbit that has been tested.
#[derive(Clone, Copy, Debug)]
pub struct FirstOrbit {
    /// At the time of the last fix.
    pub state: OrbitState,
    /// A square root of the covariance of position (km) and velocity (km/s).
    pub root: Matrix6<f64>,
}

/// Normal equations of six unknowns.
struct Sums {
    matrix: Matrix6<f64>,
    right: Vector6<f64>,
    /// Sum of the normalised squares of those within the gate, and their number.
    squares: f64,
    inliers: usize,
}

impl Default for Beginning {
    fn default() -> Self {
        Self::new()
    }
}

impl Beginning {
    /// An empty ring.
    pub const fn new() -> Self {
        Self { kept: heapless::Vec::new(), spacing_us: FIRST_SPACING_US, trial: None }
    }

    /// Takes a fix, and goes on with the trial of an orbit; gives the orbit when it has passed every test.
    #[inline(never)]
    pub fn add(
        &mut self,
        time_us: i64,
        fix: &PositionFix,
        parameters: &OrbitParameters,
    ) -> Option<FirstOrbit> {
        if self.trial.is_some() {
            return self.iterate(parameters);
        }
        if let Some(last) = self.kept.last() {
            let since_us = time_us.saturating_sub(last.time_us);
            if !(0..=LONGEST_GAP_US).contains(&since_us) {
                *self = Self::new();
            } else if since_us < self.spacing_us {
                return None;
            }
        }
        if self.kept.is_full() {
            self.thin();
        }
        let kept = Kept {
            time_us,
            position_km: fix.position_km,
            noise_km2: fix.covariance_km2.map(|element| element as f32),
            shared_km2: fix.shared_km2.map(|element| element as f32),
        };
        let _ = self.kept.push(kept);
        if self.kept.len() >= FEWEST {
            let state = OrbitState { time_us, position_km: fix.position_km, velocity_km_s: Vector3::zeros() };
            self.trial = Some(Trial { state, iteration: 0 });
        }
        None
    }

    /// Moves all times by a step of the clock.
    pub fn shift_epoch(&mut self, step_us: i64) {
        for kept in &mut self.kept {
            kept.time_us = kept.time_us.saturating_add(step_us);
        }
        if let Some(trial) = &mut self.trial {
            trial.state.time_us = trial.state.time_us.saturating_add(step_us);
        }
    }

    /// Makes room: every second fix goes, or the oldest.
    fn thin(&mut self) {
        let every_second = self.spacing_us < LONGEST_SPACING_US;
        let mut kept = heapless::Vec::new();
        for (at, fix) in self.kept.iter().enumerate() {
            let stays = if every_second { at % 2 == 1 } else { at > 0 };
            if stays {
                let _ = kept.push(*fix);
            }
        }
        self.kept = kept;
        if every_second {
            self.spacing_us *= 2;
        }
    }

    /// Number of fixes that share their slow errors.
    fn sharing(&self, parameters: &OrbitParameters) -> f64 {
        let Some(last) = self.kept.last() else { return 1.0 };
        let square_km2 = dot(&last.position_km, &last.position_km).max(1.0);
        let turn = libm::sqrt(MU_EARTH_KM3_S2 / (square_km2 * libm::sqrt(square_km2)));
        let ground_km_s = libm::fabs(turn - EARTH_RATE_RAD_S).max(1e-9) * EARTH_RADIUS_KM;
        let lasting_s = 2.0 * f64::from(parameters.field_length_km) / ground_km_s;
        let spacing_s = self.spacing_us as f64 / MICROSECONDS;
        (lasting_s / spacing_s).clamp(1.0, FIXES as f64)
    }

    /// One iteration of the trial.
    fn iterate(&mut self, parameters: &OrbitParameters) -> Option<FirstOrbit> {
        let Trial { mut state, iteration } = self.trial.take()?;
        let sums = self.sums(&state, iteration, parameters)?;
        let factor = Cholesky::of(&sums.matrix)?;
        let step = factor.solve(&sums.right);
        let [[x, y, z, vx, vy, vz]] = step.data.0;
        if iteration == 0 {
            state.position_km = Vector3::zeros();
        }
        add_scaled(&mut state.position_km, 1.0, &Vector3::new(x, y, z));
        add_scaled(&mut state.velocity_km_s, 1.0, &Vector3::new(vx, vy, vz));
        if !plausible(&state.position_km, &state.velocity_km_s) {
            return None;
        }
        if iteration + 1 < ITERATIONS {
            self.trial = Some(Trial { state, iteration: iteration + 1 });
            return None;
        }
        let first = FirstOrbit { state, root: factor.whitened(&identity()).transpose() };
        let agreed = 4 * sums.inliers >= 3 * self.kept.len()
            && sums.squares <= 2.0 * (3.0 * sums.inliers as f64 - 6.0);
        (agreed && is_known(&first) && is_orbit(&state)).then_some(first)
    }

    /// Normal equations about a state at the last fix, going back from fix to fix. In the first iteration
    /// about nothing, by Lagrange's series.
    #[inline(never)]
    fn sums(&self, state: &OrbitState, iteration: u8, parameters: &OrbitParameters) -> Option<Sums> {
        let sharing = self.sharing(parameters);
        let mut sums = Sums { matrix: Matrix6::zeros(), right: Vector6::zeros(), squares: 0.0, inliers: 0 };
        let mut here = *state;
        let mut moved = identity::<f64, 6>();
        for kept in self.kept.iter().rev() {
            let (predicted, partials) = if iteration == 0 {
                (Vector3::zeros(), lagrange(&state.position_km, kept.time_us.saturating_sub(state.time_us)))
            } else {
                for _ in 0..SPANS {
                    let span_us = kept.time_us.saturating_sub(here.time_us).max(-MAX_SPAN_US);
                    if span_us < 0 {
                        let there = Dynamics::Kepler.propagate(&here, span_us).ok()?;
                        moved = product(&matrix_of(&transition(&here, &there)), &moved);
                        here = there;
                    }
                }
                (here.position_km, upper_rows(&moved))
            };
            let mut covariance = kept.noise_km2.map(f64::from);
            add_scaled(&mut covariance, sharing, &kept.shared_km2.map(f64::from));
            let information = inverse(&covariance)?;
            let off = plus_scaled(&kept.position_km, -1.0, &predicted);
            let weighted = transposed_product(&partials, &information);
            let square = dot(&off, &product(&information, &off));
            let inlier = square < GATE;
            let weight = match iteration {
                0 => 1.0,
                1..=3 => 1.0 / (1.0 + square / 12.0),
                _ => f64::from(u8::from(inlier)),
            };
            add_scaled(&mut sums.matrix, weight, &product(&weighted, &partials));
            add_scaled(&mut sums.right, weight, &product(&weighted, &off));
            if inlier {
                sums.squares += square;
                sums.inliers += 1;
            }
        }
        Some(sums)
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
fn lagrange(position_km: &Vector3<f64>, span_us: i64) -> Matrix3x6<f64> {
    let t = span_us as f64 / MICROSECONDS;
    let square_km2 = dot(position_km, position_km).max(1.0);
    let falling = MU_EARTH_KM3_S2 / (square_km2 * libm::sqrt(square_km2)) * t * t;
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
    let FirstOrbit { state, root } = first;
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

/// Whether a state is on a closed orbit above the ground and below [`HIGHEST_KM`]; by 3 % of the Earth's
/// radius, as it may be off.
pub fn is_orbit(state: &OrbitState) -> bool {
    let OrbitState { position_km, velocity_km_s, .. } = state;
    let radius = libm::sqrt(dot(position_km, position_km));
    let energy = 0.5 * dot(velocity_km_s, velocity_km_s) - MU_EARTH_KM3_S2 / radius;
    let axis_km = -0.5 * MU_EARTH_KM3_S2 / energy;
    let momentum = cross(position_km, velocity_km_s);
    let shape = 1.0 - dot(&momentum, &momentum) / (MU_EARTH_KM3_S2 * axis_km);
    let eccentricity = libm::sqrt(shape.max(0.0));
    energy < 0.0
        && axis_km * (1.0 - eccentricity) > (1.0 - KNOWN_SHARE) * EARTH_RADIUS_KM
        && axis_km * (1.0 + eccentricity) < HIGHEST_KM
}

#[cfg(test)]
mod tests;
