//! How the star path's attitude goes with time.
//!
//! Either a turning with constant rate, for tests of single parts, or a [`Journey`] about the Earth.

use super::attitude::{Turning, Vector};
use super::journey::Journey;

/// Attitude over time.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// A constant rate under the stars; there is no Earth.
    Turning(Turning),
    /// An orbit about the Earth.
    Orbiting(Box<Journey>),
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

    /// A journey about the Earth.
    pub fn orbiting(journey: Journey) -> Self {
        Self::Orbiting(Box::new(journey))
    }

    /// The journey, if it is one.
    pub fn journey(&self) -> Option<&Journey> {
        match self {
            Self::Turning(_) => None,
            Self::Orbiting(journey) => Some(journey),
        }
    }

    /// Attitude of the star path `t_s` seconds after time 0.
    pub fn at(&self, t_s: f64) -> [f64; 4] {
        match self {
            Self::Turning(turning) => turning.at(t_s),
            Self::Orbiting(journey) => journey.quaternion(t_s),
        }
    }

    /// Rate of the star path in its own axes `t_s` seconds after time 0, rad/s.
    pub fn rate_rad_s(&self, t_s: f64) -> Vector {
        match self {
            Self::Turning(turning) => turning.rate_rad_s,
            Self::Orbiting(journey) => journey.rate_rad_s(t_s),
        }
    }

    /// What the velocity through space adds to every unit vector to a star, before it is normalised: `v / c`.
    pub fn aberration(&self, t_s: f64) -> Vector {
        self.journey().map_or([0.0; 3], |journey| journey.aberration(t_s))
    }
}
