//! A body that nothing holds: free turning by Euler's equations.
//!
//! In: attitude and rate at the start, ratios of the principal moments of inertia about the body axes. Out:
//! attitude (ICRS to body) and rate (body axes, rad/s) at any time of the run, a pure function. `I dω/dt = -ω
//! × I ω` and `dq/dt = 1/2 [ω, 0] ⊗ q` by Runge and Kutta's fourth order with steps of [`STEP_S`] from the
//! last whole second, whose states are kept; so attitude and rate between two steps belong together as well.
//! With equal moments the rate is constant.
//!
//! Over an hour at 15 deg/s about no principal axis, moments 1 : 2 : 2.5, momentum in ICRS axes and energy
//! stay within 3e-9 of themselves.

use super::moving_frame::MovingFrame;
use crate::world::attitude::{Vector, compose, matrix, normalised};
use crate::world::vector::plus;
use std::sync::Arc;

/// Step of the integration, s.
pub const STEP_S: f64 = 1.0 / 32.0;
/// Steps from a kept state to the next, one second later.
const STEPS: u32 = 32;

#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    quaternion: [f64; 4],
    rate_rad_s: Vector,
}

/// A free body; a copy is cheap.
#[derive(Debug, Clone, PartialEq)]
pub struct Tumble {
    inertia: Vector,
    /// A state a second; the first is that of a second before the start.
    states: Arc<[State]>,
}

impl Tumble {
    /// A body that turns freely for `seconds` from the attitude `quaternion` (ICRS to body) with `rate_rad_s`
    /// in body axes. Of the moments of `inertia` only the ratios count; they are positive.
    pub fn new(quaternion: [f64; 4], rate_rad_s: Vector, inertia: Vector, seconds: u32) -> Self {
        let start = State { quaternion, rate_rad_s };
        let second =
            |state: State, step_s: f64| (0..STEPS).fold(state, |state, _| step(state, inertia, step_s));
        let mut states = vec![second(start, -STEP_S), start];
        let mut state = start;
        for _ in 0..=seconds {
            state = second(state, STEP_S);
            states.push(state);
        }
        Self { inertia, states: states.into() }
    }

    /// ICRS to body `t_s` seconds after the start; outside the run the body is held as at its end.
    pub fn at(&self, t_s: f64) -> MovingFrame {
        let place = (t_s + 1.0).clamp(0.0, (self.states.len() - 1) as f64);
        let mut state = self.states[place as usize];
        let since_s = place - (place as usize) as f64;
        let whole = (since_s / STEP_S) as u32;
        for _ in 0..whole {
            state = step(state, self.inertia, STEP_S);
        }
        state = step(state, self.inertia, since_s - f64::from(whole) * STEP_S);
        MovingFrame { matrix: matrix(state.quaternion), rate_rad_s: state.rate_rad_s }
    }
}

/// How a state changes.
fn derivative(state: State, [a, b, c]: Vector) -> State {
    let [x, y, z] = state.rate_rad_s;
    let quaternion = compose([x, y, z, 0.0], state.quaternion).map(|part| 0.5 * part);
    State { quaternion, rate_rad_s: [(b - c) / a * y * z, (c - a) / b * z * x, (a - b) / c * x * y] }
}

/// `state + h change`.
fn along(state: State, h: f64, change: State) -> State {
    let mut quaternion = state.quaternion;
    quaternion.iter_mut().zip(change.quaternion).for_each(|(part, change)| *part += h * change);
    State { quaternion, rate_rad_s: plus(state.rate_rad_s, h, change.rate_rad_s) }
}

/// A step of Runge and Kutta.
fn step(state: State, inertia: Vector, h: f64) -> State {
    let first = derivative(state, inertia);
    let second = derivative(along(state, 0.5 * h, first), inertia);
    let third = derivative(along(state, 0.5 * h, second), inertia);
    let fourth = derivative(along(state, h, third), inertia);
    let mut next = state;
    for (weight, change) in [(1.0, first), (2.0, second), (2.0, third), (1.0, fourth)] {
        next = along(next, h * weight / 6.0, change);
    }
    State { quaternion: normalised(next.quaternion).unwrap_or(state.quaternion), ..next }
}

/// The angular momentum in ICRS axes over that of a unit moment, and twice the energy likewise: for tests.
#[cfg(test)]
fn momentum_and_energy(frame: &MovingFrame, inertia: Vector) -> (Vector, f64) {
    use crate::world::attitude::{apply, dot};
    use crate::world::vector::transposed;
    let rate = frame.rate_rad_s;
    let momentum = [inertia[0] * rate[0], inertia[1] * rate[1], inertia[2] * rate[2]];
    (apply(&transposed(&frame.matrix), momentum), dot(rate, momentum))
}

#[cfg(test)]
mod tests {
    use super::super::moving_frame::rate_error;
    use super::*;
    use crate::world::attitude::Turning;
    use crate::world::vector::{length, minus, times};

    const START: [f64; 4] = [0.1, -0.5, 0.3, 0.8];

    fn start() -> [f64; 4] {
        normalised(START).unwrap()
    }

    /// 15 deg/s, near the axis of the middle moment, about which a free body turns over.
    fn body(seconds: u32) -> (Tumble, Vector) {
        let inertia = [1.0, 2.0, 2.5];
        let rate = times(15f64.to_radians() / length([0.2, 1.0, 0.1]), [0.2, 1.0, 0.1]);
        (Tumble::new(start(), rate, inertia, seconds), inertia)
    }

    #[test]
    fn momentum_and_energy_are_kept() {
        let (tumble, inertia) = body(3600);
        let (momentum, energy) = momentum_and_energy(&tumble.at(0.0), inertia);
        let mut turned_over = false;
        let mut worst: f64 = 0.0;
        for k in 0..7200 {
            let frame = tumble.at(0.5 * f64::from(k) + 0.1234);
            let (m, e) = momentum_and_energy(&frame, inertia);
            worst = worst.max(length(minus(m, momentum)) / length(momentum)).max((e / energy - 1.0).abs());
            turned_over |= frame.rate_rad_s[1] < 0.0;
        }
        println!("largest relative change {worst:.1e}");
        assert!(worst < 3e-9, "{worst}");
        assert!(turned_over, "near the middle axis the body turns over");
    }

    #[test]
    fn a_body_of_equal_moments_turns_at_a_constant_rate() {
        let rate_rad_s = [0.1, -0.15, 0.12];
        let tumble = Tumble::new(start(), rate_rad_s, [3.0; 3], 600);
        let turning = Turning { quaternion: start(), rate_rad_s };
        for t in [-0.5, 0.0, 0.01, 77.77, 600.4] {
            let (expected, frame) = (matrix(turning.at(t)), tumble.at(t));
            assert_eq!(frame.rate_rad_s, rate_rad_s);
            for (a, b) in frame.matrix.iter().zip(expected) {
                assert!(length(minus(*a, b)) < 1e-8, "{t}");
            }
        }
    }

    #[test]
    fn a_body_with_an_axis_of_symmetry_nutates_as_the_closed_form_says() {
        // Moments A, A, C: about z the rate is constant, across it it turns with (C - A) / A of it.
        let tumble = Tumble::new(start(), [0.05, 0.0, 0.2], [1.0, 1.0, 1.6], 200);
        for t in [0.0, 13.3, 150.0] {
            let [x, y, z] = tumble.at(t).rate_rad_s;
            let (sine, cosine) = libm::sincos(0.6 * 0.2 * t);
            assert!(
                (x - 0.05 * cosine).abs() < 1e-9 && (y - 0.05 * sine).abs() < 1e-9 && (z - 0.2).abs() < 1e-15
            );
        }
    }

    #[test]
    fn the_rate_is_the_derivative_of_the_attitude_also_across_whole_seconds() {
        let (tumble, _) = body(60);
        for t in [0.0, 0.003, 7.0, 17.49, 59.999] {
            assert!(rate_error(|t| tumble.at(t), t, 2e-3) < 1e-9, "{t}");
        }
    }
}
