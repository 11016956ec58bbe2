//! Frames that turn: orientation and rate kept together, so that the rate stays the exact derivative.
//!
//! `matrix` takes components in the frame it is counted from (ICRS, or another frame) to components in this
//! one; `rate` is that of this frame against the other, in its own axes: `dA/dt = -[ω×] A`. Of two in a row,
//! `A = B C`: `ω = ω_B + B ω_C`.

use crate::world::attitude::{Turning, Vector, apply, dot, matrix};
use crate::world::vector::{cross, plus, product, times};

/// Angle below which the coefficients of [`MovingFrame::turned_by`] come from their series, rad.
const SMALL_RAD: f64 = 1e-3;

/// A frame and its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingFrame {
    /// From components in the frame it is counted from to components in this one.
    pub matrix: [Vector; 3],
    /// Rate against that frame, in the axes of this one, rad/s.
    pub rate_rad_s: Vector,
}

impl MovingFrame {
    /// A frame that does not turn.
    pub const fn fixed(matrix: [Vector; 3]) -> Self {
        Self { matrix, rate_rad_s: [0.0; 3] }
    }

    /// A frame turned by the rotation vector `vector_rad` that changes by `change_rad_s`: `A = exp(-[φ×])`,
    /// and the rate `φ' - (1 - cos φ)/φ² φ × φ' + (φ - sin φ)/φ³ φ × (φ × φ')`.
    pub fn turned_by(vector_rad: Vector, change_rad_s: Vector) -> Self {
        let turning = Turning { quaternion: [0.0, 0.0, 0.0, 1.0], rate_rad_s: vector_rad };
        let square = dot(vector_rad, vector_rad);
        let angle = square.sqrt();
        // The series' next terms are φ⁴/720 and φ⁴/5040: below 2e-15.
        let (first, second) = if angle < SMALL_RAD {
            (0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0)
        } else {
            let (sine, cosine) = libm::sincos(angle);
            ((1.0 - cosine) / square, (angle - sine) / (square * angle))
        };
        let once = cross(vector_rad, change_rad_s);
        let rate = plus(plus(change_rad_s, -first, once), second, cross(vector_rad, once));
        Self { matrix: matrix(turning.at(1.0)), rate_rad_s: rate }
    }

    /// A frame that `next` counts from this one, counted from where this one is.
    pub fn then(&self, next: &Self) -> Self {
        Self {
            matrix: product(&next.matrix, &self.matrix),
            rate_rad_s: plus(next.rate_rad_s, 1.0, apply(&next.matrix, self.rate_rad_s)),
        }
    }
}

/// The matrix that takes components to a frame turned by `angle_rad` about the unit vector `axis`.
pub fn turned_about(axis: Vector, angle_rad: f64) -> [Vector; 3] {
    MovingFrame::turned_by(times(angle_rad, axis), [0.0; 3]).matrix
}

/// Largest component of the rate's difference to the derivative of the matrix at `t_s`, rad/s: for tests.
#[cfg(test)]
pub(crate) fn rate_error(frame: impl Fn(f64) -> MovingFrame, t_s: f64, step_s: f64) -> f64 {
    use crate::world::vector::{minus, transposed};
    // Central differences over one and two steps, combined so that the error is of the fourth order.
    let difference = |step_s: f64| {
        let turn = product(&frame(t_s + step_s).matrix, &transposed(&frame(t_s - step_s).matrix));
        let sines = [turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]];
        let sine = 0.5 * dot(sines, sines).sqrt();
        let scale = if sine > 0.0 { libm::asin(sine) / sine } else { 1.0 };
        times(0.25 * scale / step_s, sines)
    };
    let numeric = plus(times(4.0 / 3.0, difference(step_s)), -1.0 / 3.0, difference(2.0 * step_s));
    let error = minus(numeric, frame(t_s).rate_rad_s);
    error.iter().fold(0.0, |largest: f64, part| largest.max(part.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_rate_of_a_changing_rotation_vector_is_the_derivative(
            at in prop::array::uniform3(-1.0..1.0f64), change in prop::array::uniform3(-1.0..1.0f64), small: bool,
        ) {
            let scale = if small { 1e-4 } else { 1.0 };
            let frame = |t: f64| MovingFrame::turned_by(plus(times(scale, at), t, change), change);
            prop_assert!(rate_error(frame, 0.0, 1e-3) < 1e-9);
        }

        #[test]
        fn the_rate_of_frames_in_a_row_is_the_derivative(
            a in prop::array::uniform3(-1.0..1.0f64), b in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let first = |t: f64| MovingFrame::turned_by(times(1.0 + t, a), a);
            let both = |t: f64| first(t).then(&MovingFrame::turned_by(times(t * t - 0.5, b), times(2.0 * t, b)));
            prop_assert!(rate_error(both, 0.3, 1e-3) < 1e-9);
        }
    }

    #[test]
    fn turning_about_y_carries_the_line_of_sight_to_x() {
        let [_, _, z] = turned_about([0.0, 1.0, 0.0], 0.5);
        assert!((z[0] - 0.5f64.sin()).abs() < 1e-15 && (z[2] - 0.5f64.cos()).abs() < 1e-15);
    }
}
