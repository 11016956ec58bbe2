//! How the star path's attitude goes with time.
//!
//! Either a turning with constant rate, for tests of single parts, or a [`Trajectory`] about the Earth.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`moving_frame`] | rotations in a row | frame and rate, the one the derivative of the other |
//! | [`pointing`] | time, orbit, law, slews | frames of the two paths |
//! | [`tumble`] | attitude, rate, inertia, time | free turning of a body |
//! | [`slew`] | axis, angle, time | a smooth turn |
//! | [`jitter`] | deviation, frequencies, seed, time | pointing errors |
//! | [`trajectory`] | orbit, pointing, mounting | the truth of a second |

pub mod jitter;
pub mod moving_frame;
pub mod pointing;
pub mod slew;
pub mod trajectory;
pub mod tumble;

use crate::world::attitude::{Turning, Vector};
use crate::world::motion::trajectory::Trajectory;

/// Attitude over time.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// A constant rate under the stars; there is no Earth.
    Turning(Turning),
    /// An orbit about the Earth.
    Orbiting(Box<Trajectory>),
}

impl Motion {
    /// No motion.
    pub const fn fixed(quaternion: [f64; 4]) -> Self {
        Self::turning(quaternion, [0.0; 3])
    }

    /// A constant rate, rad/s in sensor axes, from an attitude at time 0, ICRS to sensor.
    pub const fn turning(quaternion: [f64; 4], rate_rad_s: Vector) -> Self {
        Self::Turning(Turning { quaternion, rate_rad_s })
    }

    /// A trajectory about the Earth.
    pub fn orbiting(trajectory: Trajectory) -> Self {
        Self::Orbiting(Box::new(trajectory))
    }

    /// The trajectory, if it is one.
    pub fn trajectory(&self) -> Option<&Trajectory> {
        match self {
            Self::Turning(_) => None,
            Self::Orbiting(trajectory) => Some(trajectory),
        }
    }

    /// Attitude of the star path `t_s` seconds after time 0.
    pub fn at(&self, t_s: f64) -> [f64; 4] {
        match self {
            Self::Turning(turning) => turning.at(t_s),
            Self::Orbiting(trajectory) => trajectory.quaternion(t_s),
        }
    }

    /// Rate of the star path in its own axes `t_s` seconds after time 0, rad/s.
    pub fn rate_rad_s(&self, t_s: f64) -> Vector {
        match self {
            Self::Turning(turning) => turning.rate_rad_s,
            Self::Orbiting(trajectory) => trajectory.rate_rad_s(t_s),
        }
    }

    /// What the velocity through space adds to every unit vector to a star, before it is normalised: `v / c`.
    pub fn aberration(&self, t_s: f64) -> Vector {
        self.trajectory().map_or([0.0; 3], |trajectory| trajectory.aberration(t_s))
    }
}
