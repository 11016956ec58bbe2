//! Slews: the satellite turns by an angle about an axis of its body within a time, smoothly.
//!
//! The angle goes as `10 τ³ - 15 τ⁴ + 6 τ⁵` of the whole, `τ` from 0 to 1: rate and acceleration are zero at
//! both ends, the greatest rate is [`PEAK`] times the mean.

use super::moving_frame::MovingFrame;
use crate::world::attitude::Vector;
use crate::world::vector::times;

/// Greatest rate over the mean rate.
pub const PEAK: f64 = 1.875;

/// Greatest angular acceleration over that of the angle in the square of the time: at a fifth of it.
const PEAK_ACCELERATION: f64 = 5.773_503;

/// A slew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slew {
    /// When it begins, s after the start of the run.
    pub start_s: f64,
    /// How long it lasts, s; positive.
    pub duration_s: f64,
    /// The axis in the body, a unit vector.
    pub axis: Vector,
    /// The angle, rad.
    pub angle_rad: f64,
}

impl Slew {
    /// The body from where it would be without the slew.
    pub fn at(&self, t_s: f64) -> MovingFrame {
        let tau = ((t_s - self.start_s) / self.duration_s).clamp(0.0, 1.0);
        let share = tau * tau * tau * (10.0 + tau * (6.0 * tau - 15.0));
        let change = 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau) / self.duration_s;
        MovingFrame::turned_by(
            times(share * self.angle_rad, self.axis),
            times(change * self.angle_rad, self.axis),
        )
    }

    /// When it is over, s.
    pub fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    /// Greatest rate, rad/s.
    pub fn peak_rad_s(&self) -> f64 {
        PEAK * self.angle_rad.abs() / self.duration_s
    }

    /// Greatest angular acceleration, rad/s².
    pub fn peak_rad_s2(&self) -> f64 {
        PEAK_ACCELERATION * self.angle_rad.abs() / (self.duration_s * self.duration_s)
    }
}

#[cfg(test)]
mod tests {
    use super::super::moving_frame::{rate_error, turned_about};
    use super::*;
    use crate::world::vector::{length, minus};

    const SLEW: Slew = Slew { start_s: 10.0, duration_s: 20.0, axis: [0.6, 0.0, 0.8], angle_rad: 1.5 };

    #[test]
    fn a_slew_begins_and_ends_at_rest_and_turns_by_its_angle() {
        for (t, angle) in [(-5.0, 0.0), (10.0, 0.0), (20.0, 0.75), (30.0, 1.5), (1e4, 1.5)] {
            let frame = SLEW.at(t);
            for (a, b) in frame.matrix.iter().zip(turned_about(SLEW.axis, angle)) {
                assert!(length(minus(*a, b)) < 1e-12, "{t}");
            }
            let rate = if t == 20.0 { SLEW.peak_rad_s() } else { 0.0 };
            assert!((length(frame.rate_rad_s) - rate).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn its_rate_is_the_derivative_and_never_above_the_peak() {
        for k in 0..300 {
            let t = 5.0 + 0.1 * f64::from(k) + 0.037;
            assert!(rate_error(|t| SLEW.at(t), t, 1e-3) < 1e-9, "{t}");
            assert!(length(SLEW.at(t).rate_rad_s) <= SLEW.peak_rad_s() + 1e-15);
        }
    }

    #[test]
    fn its_acceleration_reaches_the_peak_and_is_never_above() {
        let speed = |t: f64| length(SLEW.at(t).rate_rad_s);
        let slope = |k: u32| {
            let t = 10.0 + 0.01 * f64::from(k);
            (speed(t + 1e-4) - speed(t - 1e-4)).abs() / 2e-4
        };
        let most = (1..2_000).map(slope).fold(0.0, f64::max);
        assert!((most / SLEW.peak_rad_s2() - 1.0).abs() < 1e-4, "{most}");
    }
}
