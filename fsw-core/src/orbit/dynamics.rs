//! How the satellite moves: acceleration, propagation, and the transition of small errors.
//!
//! In: [`OrbitState`] and a span; out: the state at its end. Acceleration is that of a point mass, of the Earth's bulge
//! (J2 about the pole of date), and of Sun and Moon, whose pull is taken once a call and held. The integrator is the
//! classical Runge-Kutta method of the fourth order with fixed steps: [`STEP_S`] or shorter up to 100 s, 30 s in the
//! longest span allowed. Left out: the tesserals and higher zonals, drag, radiation pressure (the filter's process noise
//! stands for them).
//!
//! Errors: integration 0.3 m after one LEO orbit at 20 s steps, 1.5 m at 30 s. Against GMAT with the same forces and the
//! second degree's tesserals besides: LEO 0.3 km after two hours, 1.0 km after a day; GEO 1 m, 0.23 km. The real Jason-2
//! (1336 km): at worst 0.4 km after 35 minutes, 1.3 km after an orbit.
//!
//! The transition of errors is eq. 5.23 by 3 x 3 blocks. There the gravity gradient `G` is held, here it is taken at both ends
//! and in the middle and integrated by Simpson's rule, which carries the same blocks through minutes of LEO: first
//! iterate `∫ G`, second `G²`. What is left is the bulge's gradient (test
//! `the_transition_is_the_derivative_of_the_propagation`).

use super::constants::{EARTH_RADIUS_KM, J2, MICROSECONDS, MU_EARTH_KM3_S2, MU_MOON_KM3_S2, MU_SUN_KM3_S2};
use super::ephemeris::Bodies;
use super::matrix::{product, scaled, sum};
use super::{OrbitState, finite};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Longest step as long as [`MAX_STEPS`] allow it, s.
pub const STEP_S: f64 = 20.0;
/// Most steps in one call.
pub const MAX_STEPS: u32 = 5;
/// Longest span of one call, microseconds: steps of 30 s.
pub const MAX_SPAN_US: i64 = 150_000_000;
/// No satellite is nearer to the Earth's centre, km. The bound keeps the divisions finite.
pub const LOWEST_KM: f64 = 5_000.0;
/// ... nor farther, km (half again the Moon's distance).
pub const HIGHEST_KM: f64 = 600_000.0;
/// ... nor faster, km/s (a start from rest may reach twice the speed of escape for a few seconds).
pub const FASTEST_KM_S: f64 = 30.0;

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
    /// Position or velocity is not finite or no satellite's.
    Impossible,
}

/// Whether a satellite can be there and move so.
pub fn plausible(position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> bool {
    let square = position_km.dot(position_km);
    finite(position_km)
        && finite(velocity_km_s)
        && square > LOWEST_KM * LOWEST_KM
        && square < HIGHEST_KM * HIGHEST_KM
        && velocity_km_s.dot(velocity_km_s) < FASTEST_KM_S * FASTEST_KM_S
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
                let tide = tide(&bodies.sun_km, MU_SUN_KM3_S2, &state.position_km)
                    + tide(&bodies.moon_km, MU_MOON_KM3_S2, &state.position_km);
                Self { pole: Some(bodies.pole), tide }
            }
        }
    }

    #[inline(never)]
    fn acceleration(&self, r: &Vector3<f64>) -> Vector3<f64> {
        let inverse = 1.0 / libm::sqrt(r.dot(r));
        let square = inverse * inverse;
        let mass = MU_EARTH_KM3_S2 * square * inverse;
        let point = self.tide - r * mass;
        match self.pole {
            None => point,
            Some(pole) => {
                let height = pole.dot(r);
                let bulge = 1.5 * J2 * EARTH_RADIUS_KM * EARTH_RADIUS_KM * square * mass;
                point - (r * (1.0 - 5.0 * height * height * square) + pole * (2.0 * height)) * bulge
            }
        }
    }
}

/// Pull of a body at `body` on a satellite at `r`, less its pull on the Earth, km/s².
fn tide(body: &Vector3<f64>, mu: f64, r: &Vector3<f64>) -> Vector3<f64> {
    let apart = body - r;
    // A satellite at the Moon's place is refused by the bounds on the state only nearly; half a radius keeps it finite.
    let near = apart.dot(&apart).max(1e6);
    let far = body.dot(body).max(1e6);
    apart * (mu / (near * libm::sqrt(near))) - body * (mu / (far * libm::sqrt(far)))
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
        let middle = r + v * half;
        let a1 = self.acceleration(r);
        let a2 = self.acceleration(&middle);
        let a3 = self.acceleration(&(middle + a1 * (half * half)));
        let a4 = self.acceleration(&(r + v * h + a2 * (half * h)));
        let inner = a2 + a3;
        (r + v * h + (a1 + inner) * (h * h / 6.0), v + (a1 + inner * 2.0 + a4) * (h / 6.0))
    }
}

/// How a small error of position and velocity moves over a span (eq. 5.23): `δr' = rr δr + rv δv`, `δv' = vr δr + vv δv`.
/// All blocks are symmetric.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// Position to position.
    pub rr: Matrix3<f64>,
    /// Velocity to position, s.
    pub rv: Matrix3<f64>,
    /// Position to velocity, 1/s.
    pub vr: Matrix3<f64>,
    /// Velocity to velocity.
    pub vv: Matrix3<f64>,
}

impl Transition {
    /// Over the span between two states of one orbit.
    pub fn between(before: &OrbitState, after: &OrbitState) -> Self {
        let dt = after.time_us.saturating_sub(before.time_us) as f64 / MICROSECONDS;
        // Hermite's cubic through both ends.
        let middle = (before.position_km + after.position_km) * 0.5
            + (before.velocity_km_s - after.velocity_km_s) * (0.125 * dt);
        let (g0, gm, g1) = (
            scaled(&gravity_gradient(&before.position_km), 1.0 / 6.0),
            gravity_gradient(&middle),
            scaled(&gravity_gradient(&after.position_km), 1.0 / 6.0),
        );
        let third = scaled(&gm, 1.0 / 3.0);
        let square = scaled(&product(&gm, &gm), dt * dt / 6.0);
        let quarter = scaled(&square, 0.25);
        let one = Matrix3::identity();
        // rr = 1 + (g0 + third + quarter) dt², rv = dt + (third / 2 + square / 20) dt³,
        // vr = (g0 + 2 third + g1 + square) dt, vv = 1 + (third + g1 + quarter) dt².
        let rr = sum(&sum(&g0, &third), &quarter);
        let rv = sum(&scaled(&third, 0.5), &scaled(&square, 0.05));
        let vr = sum(&sum(&sum(&g0, &scaled(&third, 2.0)), &g1), &square);
        let vv = sum(&sum(&third, &g1), &quarter);
        Self {
            rr: sum(&one, &scaled(&rr, dt * dt)),
            rv: sum(&scaled(&one, dt), &scaled(&rv, dt * dt * dt)),
            vr: scaled(&vr, dt),
            vv: sum(&one, &scaled(&vv, dt * dt)),
        }
    }
}

/// `G = mu / r³ (3 u uᵀ - I)` (eq. 5.18), 1/s². The bulge's part, 0.3 % in LEO, is left out.
#[inline(never)]
fn gravity_gradient(r: &Vector3<f64>) -> Matrix3<f64> {
    let square = r.dot(r).max(1.0);
    let mass = MU_EARTH_KM3_S2 / (square * libm::sqrt(square));
    r * r.transpose() * (3.0 * mass / square) - Matrix3::identity() * mass
}

#[cfg(test)]
mod tests;
