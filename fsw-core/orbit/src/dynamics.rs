//! Orbit dynamics: acceleration, propagation, and the state transition matrix.
//!
//! In: [`OrbitState`] and a span; out: the state at its end. Acceleration is that of a point mass, of the
//! Earth's bulge (J2 about the pole of date), and of Sun and Moon, whose pull is constant over one call
//! (150 s at most). The integrator is the classical Runge-Kutta method of the fourth order with fixed
//! steps: [`STEP_S`] or shorter up to 100 s, 30 s in the longest span allowed. Not modelled: tesserals and
//! higher zonals, drag, radiation pressure (covered by the filter's process noise).
//!
//! Errors: integration 0.3 m after one LEO orbit at 20 s steps, 1.5 m at 30 s. Against GMAT with the same
//! forces and the second degree's tesserals besides: LEO 0.3 km after two hours, 1.0 km after a day; GEO 1 m,
//! 0.23 km. The real Jason-2 (1336 km): at worst 0.4 km after 35 minutes, 1.3 km after an orbit.
//!
//! The transition of errors is eq. 5.23. There the gravity gradient `G` is constant over the span; here it is
//! taken at both ends and in the middle and integrated by Simpson's rule, to the second order in `G`. Error
//! relative to the numerical derivative of the propagation: 2e-6 over 60 s, 1e-4 over 150 s (test
//! `the_transition_is_the_derivative_of_the_propagation`).

use super::constants::{EARTH_RADIUS_KM, J2, MICROSECONDS, MU_EARTH_KM3_S2, MU_MOON_KM3_S2, MU_SUN_KM3_S2};
use super::ephemeris::{Bodies, pole_axis};
use super::{OrbitState, finite};
use fsw_ground::matrix::{
    add_scaled, add_to_diagonal, dot, plus_scaled, product, product_transposed, scaled,
};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Longest step as long as [`MAX_STEPS`] allow it, s.
pub const STEP_S: f64 = 20.0;
/// Most steps in one call.
pub const MAX_STEPS: u32 = 5;
/// Longest span of one call, microseconds: steps of 30 s.
pub const MAX_SPAN_US: i64 = 150_000_000;
/// Least accepted distance from the Earth's centre, km: below any orbit; keeps divisions finite.
pub const LOWEST_KM: f64 = 5_000.0;
/// Largest accepted distance, km: 1.5 times the Moon's.
pub const HIGHEST_KM: f64 = 600_000.0;
/// Largest accepted speed, km/s: the estimate after initialisation with velocity 0 may exceed twice the
/// escape velocity for seconds.
pub const FASTEST_KM_S: f64 = 30.0;

/// Pull of the Earth's bulge over that of its mass, times the square of the distance.
const BULGE_KM2: f64 = 1.5 * J2 * EARTH_RADIUS_KM * EARTH_RADIUS_KM;

/// Which forces act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Dynamics {
    /// The Earth as a point.
    Kepler,
    /// The Earth with its bulge, Sun and Moon.
    Full,
}

/// Why a state cannot be propagated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropagationError {
    /// The span is longer than [`MAX_SPAN_US`], forwards or backwards.
    TooLong,
    /// Position or velocity is not finite or out of bounds.
    Impossible,
}

/// Whether position and velocity are finite and within the bounds of a satellite.
#[inline(never)]
pub fn plausible(position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> bool {
    let square = dot(position_km, position_km);
    finite(position_km)
        && finite(velocity_km_s)
        && square > LOWEST_KM * LOWEST_KM
        && square < HIGHEST_KM * HIGHEST_KM
        && dot(velocity_km_s, velocity_km_s) < FASTEST_KM_S * FASTEST_KM_S
}

/// The forces during one call.
struct Forces {
    /// Pole of the bulge; `None` for a point mass.
    pole: Option<Vector3<f64>>,
    /// Pull of Sun and Moon less their pull at the Earth's centre, km/s².
    tide: Vector3<f64>,
}

impl Forces {
    fn at(dynamics: Dynamics, state: &OrbitState) -> Self {
        match dynamics {
            Dynamics::Kepler => Self { pole: None, tide: Vector3::zeros() },
            Dynamics::Full => {
                let bodies = Bodies::at(state.time_us);
                let mut pull = Vector3::zeros();
                add_tide(&mut pull, &bodies.sun_km, MU_SUN_KM3_S2, &state.position_km);
                add_tide(&mut pull, &bodies.moon_km, MU_MOON_KM3_S2, &state.position_km);
                Self { pole: Some(bodies.pole), tide: pull }
            }
        }
    }

    #[inline(never)]
    fn acceleration(&self, r: &Vector3<f64>) -> Vector3<f64> {
        let inverse = 1.0 / libm::sqrt(dot(r, r));
        let square = inverse * inverse;
        let mass = MU_EARTH_KM3_S2 * square * inverse;
        let Some(pole) = &self.pole else {
            return plus_scaled(&self.tide, -mass, r);
        };
        let height = dot(pole, r);
        let bulge = BULGE_KM2 * square * mass;
        let along = mass + bulge * (1.0 - 5.0 * height * height * square);
        plus_scaled(&plus_scaled(&self.tide, -along, r), -2.0 * height * bulge, pole)
    }
}

/// Adds the pull of a body at `body` on a satellite at `r`, less its pull on the Earth, km/s².
#[inline(never)]
fn add_tide(sum: &mut Vector3<f64>, body: &Vector3<f64>, mu: f64, r: &Vector3<f64>) {
    let apart = plus_scaled(body, -1.0, r);
    // The bounds of the state include the Moon's position; at least 1,000 km, about half the Moon's radius,
    // keep the pull finite.
    let near = dot(&apart, &apart).max(1e6);
    let far = dot(body, body).max(1e6);
    add_scaled(sum, mu / (near * libm::sqrt(near)), &apart);
    add_scaled(sum, -mu / (far * libm::sqrt(far)), body);
}

impl Dynamics {
    /// The state `span_us` later (or earlier).
    ///
    /// # Errors
    /// See [`PropagationError`]; the state's last position is checked too.
    pub fn propagate(self, state: &OrbitState, span_us: i64) -> Result<OrbitState, PropagationError> {
        if !(-MAX_SPAN_US..=MAX_SPAN_US).contains(&span_us) {
            return Err(PropagationError::TooLong);
        }
        let time_us = state.time_us.checked_add(span_us).ok_or(PropagationError::TooLong)?;
        if !plausible(&state.position_km, &state.velocity_km_s) {
            return Err(PropagationError::Impossible);
        }
        let forces = Forces::at(self, state);
        let span_s = span_us as f64 / MICROSECONDS;
        let wanted = libm::ceil(libm::fabs(span_s) / STEP_S).clamp(1.0, f64::from(MAX_STEPS));
        let step_s = span_s / wanted;
        let mut r = state.position_km;
        let mut v = state.velocity_km_s;
        for step in 0..MAX_STEPS {
            if f64::from(step) < wanted {
                (r, v) = forces.step(&r, &v, step_s);
            }
        }
        if plausible(&r, &v) {
            Ok(OrbitState { time_us, position_km: r, velocity_km_s: v })
        } else {
            Err(PropagationError::Impossible)
        }
    }
}

impl Forces {
    /// One Runge-Kutta step of the second-order equation `r'' = a(r)`: the slopes of `r` are written out.
    fn step(&self, r: &Vector3<f64>, v: &Vector3<f64>, h: f64) -> (Vector3<f64>, Vector3<f64>) {
        let half = 0.5 * h;
        let a1 = self.acceleration(r);
        let middle = plus_scaled(r, half, v);
        let a2 = self.acceleration(&middle);
        let a3 = self.acceleration(&plus_scaled(&middle, half * half, &a1));
        let straight = plus_scaled(r, h, v);
        let a4 = self.acceleration(&plus_scaled(&straight, half * h, &a2));
        let inner = plus_scaled(&a2, 1.0, &a3);
        let outer = plus_scaled(&a1, 1.0, &a4);
        (
            plus_scaled(&straight, h * h / 6.0, &plus_scaled(&a1, 1.0, &inner)),
            plus_scaled(v, h / 6.0, &plus_scaled(&outer, 2.0, &inner)),
        )
    }
}

/// State transition matrix of position (km) and velocity (km/s) over a span, row by row.
pub type Transition = [[f64; 6]; 6];

impl Dynamics {
    /// The transition of errors over the span between two states of one orbit (eq. 5.23).
    #[inline(never)]
    pub fn transition(self, before: &OrbitState, after: &OrbitState) -> Transition {
        let dt = after.time_us.saturating_sub(before.time_us) as f64 / MICROSECONDS;
        // Hermite's cubic through both ends.
        let mean = scaled(&plus_scaled(&before.position_km, 1.0, &after.position_km), 0.5);
        let change = plus_scaled(&before.velocity_km_s, -1.0, &after.velocity_km_s);
        let middle = plus_scaled(&mean, 0.125 * dt, &change);
        let (bulge, pole) = match self {
            Self::Kepler => (0.0, Vector3::zeros()),
            Self::Full => (BULGE_KM2, pole_axis(before.time_us)),
        };
        let gradients = [&before.position_km, &middle, &after.position_km]
            .map(|position_km| gravity_gradient(position_km, bulge, &pole));
        let [first, middle, last] = &gradients;
        let square = product(middle, middle);
        let mut rows = [[0.0; 6]; 6];
        let mut set = |i: usize, j: usize, value: f64| {
            if let Some(element) = rows.get_mut(i).and_then(|row| row.get_mut(j)) {
                *element = value;
            }
        };
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let of = |matrix: &Matrix3<f64>| matrix.get((i, j)).copied().unwrap_or(0.0);
            // Simpson's weights 1/6, 4/6, 1/6; the middle one is shared by the first half and the second.
            let (first, third, last) = (of(first) / 6.0, of(middle) / 3.0, of(last) / 6.0);
            let square = of(&square) * (dt * dt / 6.0);
            let one = if i == j { 1.0 } else { 0.0 };
            set(i, j, one + (first + third + 0.25 * square) * dt * dt);
            set(i, j + 3, (one + (0.5 * third + 0.05 * square) * dt * dt) * dt);
            set(i + 3, j, (first + 2.0 * third + last + square) * dt);
            set(i + 3, j + 3, one + (third + last + 0.25 * square) * dt * dt);
        }
        rows
    }
}

/// Gradient of the acceleration by the position, 1/s²: `mu / r³ (3 u uᵀ - I)` (eq. 5.18) of a point, and that
/// of the bulge about the pole, `bulge` being [`BULGE_KM2`]. Without the bulge's part, 0.3 % in LEO, sigmas
/// would stop growing after some orbits.
#[inline(never)]
fn gravity_gradient(r: &Vector3<f64>, bulge: f64, pole: &Vector3<f64>) -> Matrix3<f64> {
    let per_square = 1.0 / dot(r, r).max(1.0);
    let mass = MU_EARTH_KM3_S2 * per_square * libm::sqrt(per_square);
    let bulge = bulge * per_square * mass;
    let height = dot(pole, r);
    let share = height * height * per_square;
    // With `h` the height over the equator, `m` mass and `b` bulge: (3 m + 5 b - 35 b h² / r²) r rᵀ / r²
    // + 10 b h (r pᵀ + p rᵀ) / r² - 2 b p pᵀ - (m + b - 5 b h² / r²) I.
    let lean = 10.0 * bulge * height * per_square;
    let radial = (3.0 * mass + bulge * (5.0 - 35.0 * share)) * per_square;
    let by_radius = plus_scaled(&scaled(r, radial), lean, pole);
    let by_pole = plus_scaled(&scaled(r, lean), -2.0 * bulge, pole);
    let mut gradient = product_transposed(&by_radius, r);
    add_scaled(&mut gradient, 1.0, &product_transposed(&by_pole, pole));
    add_to_diagonal(&mut gradient, -mass - bulge * (1.0 - 5.0 * share));
    gradient
}

#[cfg(test)]
mod tests;
