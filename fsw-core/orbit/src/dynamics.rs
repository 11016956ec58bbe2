//! Orbit dynamics: acceleration, propagation, and the state transition matrix.
//!
//! In: [`OrbitState`] and a span; out: the state at its end. [`Forces`] says what acts. In f64: the body's
//! point mass and its bulge (J2 about the pole of date). In f32: what `perturbations` has, taken once a
//! step, in its middle, and constant over it. The integrator is Nyström's method of the fifth order for
//! `r'' = a(r)` (Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I*, II.14), which
//! takes as many accelerations a step as the classical Runge-Kutta method of the fourth. Steps are fixed:
//! [`STEP_S`] or shorter up to 100 s, 37.5 s in the longest span allowed.
//!
//! Errors: integration 1 m after a day in a low orbit at 25 s steps, 7 m at 37.5 s. Against GMAT with the
//! same forces ([`Forces::J2`]): LEO 1 m after two hours, 10 m after a day, GEO 12 m after a day. Against
//! the host's world with all its forces, degrees 9 to 36 among them: 70 m after a revolution at 450 km, 79
//! m at 800 km, 9 m in GTO, 11 m in GEO (test `dynamics::each_force_moves_an_orbit_as_the_worlds_does` of
//! the system tests). The real Jason-2 (1336 km): at worst 29 m after 35 minutes, 79 m after an orbit. What
//! is left out, the degrees above 8 and the density of the air above all, is covered by the filter's
//! process noise.
//!
//! The transition of errors is eq. 5.23. There the gravity gradient `G` is constant over the span; here it is
//! taken at both ends and in the middle and integrated by Simpson's rule, to the second order in `G`, in f32:
//! what it adds to the unit matrix is small. Error relative to the numerical derivative of the propagation:
//! 2e-6 over 60 s, 1e-4 over 150 s (test `the_transition_is_the_derivative_of_the_propagation`).

use super::body::CentralBody;
use super::constants::MICROSECONDS;
use super::ephemeris::{Bodies, pole_axis};
use super::forces::Forces;
use super::perturbations::Perturbations;
use super::{OrbitState, finite};
use fsw_ground::matrix::{add_scaled, dot, plus_scaled};
use nalgebra::{Matrix3, Vector3};

/// Longest step as long as [`MAX_STEPS`] allow it, s.
pub const STEP_S: f64 = 25.0;
/// Most steps in one call.
pub const MAX_STEPS: u32 = 4;
/// Longest span of one call, microseconds: steps of 37.5 s.
pub const MAX_SPAN_US: i64 = 150_000_000;
/// Largest accepted speed, km/s: the estimate after initialisation with velocity 0 may exceed twice the
/// escape velocity for seconds.
pub const FASTEST_KM_S: f64 = 30.0;

/// Why a state cannot be propagated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropagationError {
    /// The span is longer than [`MAX_SPAN_US`], forwards or backwards.
    TooLong,
    /// Position or velocity is not finite or out of bounds.
    Impossible,
}

/// Whether position and velocity are finite and within the bounds of a satellite of `body`.
#[inline(never)]
pub fn plausible(body: CentralBody, position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> bool {
    let [lowest_km, highest_km] = body.facts().bounds_km;
    let square = dot(position_km, position_km);
    finite(position_km)
        && finite(velocity_km_s)
        && square > lowest_km * lowest_km
        && square < highest_km * highest_km
        && dot(velocity_km_s, velocity_km_s) < FASTEST_KM_S * FASTEST_KM_S
}

/// The forces during one call.
struct Field {
    mu_km3_s2: f64,
    /// Factor of the bulge's pull, km².
    bulge_km2: f64,
    pole: Vector3<f64>,
    perturbations: Option<Perturbations>,
}

impl Field {
    fn at(forces: &Forces, time_us: i64) -> Self {
        let mu_km3_s2 = forces.body.facts().mu_km3_s2;
        if *forces == Forces::KEPLER.about(forces.body) {
            return Self { mu_km3_s2, bulge_km2: 0.0, pole: Vector3::zeros(), perturbations: None };
        }
        let bodies = Bodies::at(forces.body, time_us);
        let perturbations = Some(Perturbations::at(*forces, time_us, &bodies));
        Self { mu_km3_s2, bulge_km2: forces.bulge_km2(), pole: bodies.pole, perturbations }
    }

    /// Pull of the body's mass and bulge, and what is `small`.
    #[inline(never)]
    fn acceleration(&self, r: &Vector3<f64>, small: &Vector3<f64>) -> Vector3<f64> {
        let inverse = 1.0 / libm::sqrt(dot(r, r));
        let square = inverse * inverse;
        let mass = self.mu_km3_s2 * square * inverse;
        if self.bulge_km2 == 0.0 {
            return plus_scaled(small, -mass, r);
        }
        let height = dot(&self.pole, r);
        let bulge = self.bulge_km2 * square * mass;
        let along = mass + bulge * (1.0 - 5.0 * height * height * square);
        plus_scaled(&plus_scaled(small, -along, r), -2.0 * height * bulge, &self.pole)
    }

    /// One step of Nyström's method of the fifth order, from `since_s` after the start.
    fn step(&self, r: &Vector3<f64>, v: &Vector3<f64>, since_s: f64, h: f64) -> (Vector3<f64>, Vector3<f64>) {
        let square = h * h;
        let mut small = Vector3::zeros();
        let mut a1 = self.acceleration(r, &small);
        if let Some(perturbations) = &self.perturbations {
            let half = 0.5 * h;
            let there = moved(r, (half, v), &[(0.125 * square, &a1)]);
            let speed = plus_scaled(v, half, &a1);
            small = perturbations.acceleration(&there, &speed, (since_s + half) as f32);
            add_scaled(&mut a1, 1.0, &small);
        }
        let pull = |place: Vector3<f64>| self.acceleration(&place, &small);
        let a2 = pull(moved(r, (0.2 * h, v), &[(square * (1.0 / 50.0), &a1)]));
        let a3 = pull(moved(
            r,
            (h * (2.0 / 3.0), v),
            &[(square * (-1.0 / 27.0), &a1), (square * (7.0 / 27.0), &a2)],
        ));
        let straight = plus_scaled(r, h, v);
        let a4 = pull(moved(
            &straight,
            (square * 0.3, &a1),
            &[(square * (-2.0 / 35.0), &a2), (square * (9.0 / 35.0), &a3)],
        ));
        let [one, two, three, four] =
            [14.0 / 336.0, 125.0 / 336.0, 162.0 / 336.0, 35.0 / 336.0].map(|weight| h * weight);
        (
            moved(
                &straight,
                (h * one, &a1),
                &[(square * (100.0 / 336.0), &a2), (square * (54.0 / 336.0), &a3)],
            ),
            moved(v, (one, &a1), &[(two, &a2), (three, &a3), (four, &a4)]),
        )
    }
}

/// `from` and multiples of vectors.
fn moved(
    from: &Vector3<f64>,
    (factor, by): (f64, &Vector3<f64>),
    more: &[(f64, &Vector3<f64>)],
) -> Vector3<f64> {
    let mut sum = plus_scaled(from, factor, by);
    for (factor, by) in more {
        add_scaled(&mut sum, *factor, by);
    }
    sum
}

impl Forces {
    /// The state `span_us` later (or earlier).
    ///
    /// # Errors
    /// See [`PropagationError`]; the state's last position is checked too.
    pub fn propagate(&self, state: &OrbitState, span_us: i64) -> Result<OrbitState, PropagationError> {
        if !(-MAX_SPAN_US..=MAX_SPAN_US).contains(&span_us) {
            return Err(PropagationError::TooLong);
        }
        let time_us = state.time_us.checked_add(span_us).ok_or(PropagationError::TooLong)?;
        if !plausible(self.body, &state.position_km, &state.velocity_km_s) {
            return Err(PropagationError::Impossible);
        }
        let field = Field::at(self, state.time_us);
        let span_s = span_us as f64 / MICROSECONDS;
        let wanted = libm::ceil(libm::fabs(span_s) / STEP_S).clamp(1.0, f64::from(MAX_STEPS));
        let step_s = span_s / wanted;
        let mut r = state.position_km;
        let mut v = state.velocity_km_s;
        for step in 0..MAX_STEPS {
            if f64::from(step) < wanted {
                (r, v) = field.step(&r, &v, f64::from(step) * step_s, step_s);
            }
        }
        if plausible(self.body, &r, &v) {
            Ok(OrbitState { time_us, position_km: r, velocity_km_s: v })
        } else {
            Err(PropagationError::Impossible)
        }
    }
}

/// State transition matrix of position (km) and velocity (km/s) over a span, row by row.
pub type Transition = [[f64; 6]; 6];

impl Forces {
    /// The transition of errors over the span between two states of one orbit (eq. 5.23).
    #[inline(never)]
    pub fn transition(&self, before: &OrbitState, after: &OrbitState) -> Transition {
        let dt = after.time_us.saturating_sub(before.time_us) as f64 / MICROSECONDS;
        let single = |vector: &Vector3<f64>| vector.map(|axis| axis as f32);
        let [first, last] = [before, after].map(|state| single(&state.position_km));
        let change = single(&before.velocity_km_s) - single(&after.velocity_km_s);
        // Hermite's cubic through both ends.
        let middle = (first + last) * 0.5 + change * (0.125 * dt as f32);
        let bulge = self.bulge_km2();
        let pole =
            if bulge == 0.0 { Vector3::zeros() } else { single(&pole_axis(self.body, before.time_us)) };
        let pull = (self.body.facts().mu_km3_s2 as f32, bulge as f32);
        let [first, middle, last] =
            [first, middle, last].map(|position_km| gravity_gradient(&position_km, pull, &pole));
        let square = middle * middle;
        let (dt2, dt1) = ((dt * dt) as f32, dt as f32);
        let mut rows = [[0.0; 6]; 6];
        let mut set = |i: usize, j: usize, value: f64| {
            if let Some(element) = rows.get_mut(i).and_then(|row| row.get_mut(j)) {
                *element = value;
            }
        };
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let of = |matrix: &Matrix3<f32>| matrix.get((i, j)).copied().unwrap_or(0.0);
            // Simpson's weights 1/6, 4/6, 1/6; the middle one is shared by the first half and the second.
            let (first, third, last) =
                (of(&first) * (1.0 / 6.0), of(&middle) * (1.0 / 3.0), of(&last) * (1.0 / 6.0));
            let square = of(&square) * (dt2 * (1.0 / 6.0));
            let one = if i == j { 1.0 } else { 0.0 };
            set(i, j, one + f64::from((first + third + 0.25 * square) * dt2));
            set(i, j + 3, (one + f64::from((0.5 * third + 0.05 * square) * dt2)) * dt);
            set(i + 3, j, f64::from((first + 2.0 * third + last + square) * dt1));
            set(i + 3, j + 3, one + f64::from((third + last + 0.25 * square) * dt2));
        }
        rows
    }
}

/// Gradient of the acceleration by the position, 1/s²: `mu / r³ (3 u uᵀ - I)` (eq. 5.18) of a point, and
/// that of the bulge about the pole, `bulge` being [`Forces::bulge_km2`]. Without the bulge's part, 0.3 %
/// in LEO, sigmas would stop growing after some orbits.
#[inline(never)]
fn gravity_gradient(r: &Vector3<f32>, (mu_km3_s2, bulge): (f32, f32), pole: &Vector3<f32>) -> Matrix3<f32> {
    let per_square = 1.0 / r.dot(r).max(1.0);
    let mass = mu_km3_s2 * per_square * libm::sqrtf(per_square);
    let bulge = bulge * per_square * mass;
    let height = pole.dot(r);
    let share = height * height * per_square;
    // With `h` the height over the equator, `m` mass and `b` bulge: (3 m + 5 b - 35 b h² / r²) r rᵀ / r²
    // + 10 b h (r pᵀ + p rᵀ) / r² - 2 b p pᵀ - (m + b - 5 b h² / r²) I.
    let lean = 10.0 * bulge * height * per_square;
    let radial = (3.0 * mass + bulge * (5.0 - 35.0 * share)) * per_square;
    let by_radius = r * radial + pole * lean;
    let by_pole = r * lean - pole * (2.0 * bulge);
    let around = mass + bulge * (1.0 - 5.0 * share);
    by_radius * r.transpose() + by_pole * pole.transpose() - Matrix3::from_diagonal_element(around)
}

#[cfg(test)]
mod tests;
