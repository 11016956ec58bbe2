//! From Earth vectors to position, velocity and the frame of the orbit (thesis chapter 5).
//!
//! In: the vector to the Earth's centre in the Earth path, the star attitude of the same second, the time.
//! Out: position and velocity with their covariance, km and km/s along the ICRS axes, f64 throughout. Time
//! is TT in microseconds since J2000.0 (2000-01-01 12:00 TT), `time_us`.
//!
//! | file | idea |
//! |---|---|
//! | [`body`] | what the satellite flies about: Earth, Moon or Mars |
//! | [`point`] | one Earth vector and one attitude make a position (eq. 5.4, 5.9, 5.12, 5.13) |
//! | [`ephemeris`] | where the Sun, a neighbour and the pole are, how far the body has turned |
//! | [`forces`] | which forces act |
//! | [`dynamics`] | how position and velocity move, and how their errors do (eq. 5.23) |
//! | `perturbations` | the small forces: field beyond J2, drag, light |
//! | [`gravity`] | the bodies' fields beyond J2 |
//! | [`geomagnetism`] | the Earth's magnetic field |
//! | `harmonics` | fields that are gradients of spherical harmonics |
//! | `atmosphere` | density of the upper air |
//! | [`elements`] | equinoctial elements and back |
//! | [`beginning`] | the first orbit, by least squares over the first fixes |
//! | [`horizon`] | how high the limb stands, and what its height says |
//! | [`look`] | the limb points of some seconds, compressed |
//! | [`observation`] | what a fix says (tab. 5.1) |
//! | `curvilinear` | corrections as changes of the elements |
//! | `noise` | process noise |
//! | [`factor`] | the filter's covariance as a square root |
//! | [`filter`] | the Kalman-Schmidt filter |
//! | [`motion`] | covariance of position and velocity as it is told |
//! | [`keplerian`] | Kepler's elements, for reports |
//! | [`lvlh`] | local vertical, local horizontal, and Hill's axes |
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(test)]
extern crate std;

mod atmosphere;
pub mod beginning;
pub mod body;
pub mod constants;
mod curvilinear;
pub mod dynamics;
pub mod elements;
pub mod ephemeris;
pub mod factor;
pub mod filter;
pub mod forces;
pub mod geomagnetism;
pub mod gravity;
mod harmonics;
pub mod horizon;
pub mod keplerian;
pub mod look;
pub mod lvlh;
pub mod motion;
mod noise;
pub mod observation;
#[cfg(test)]
#[path = "../../ground/src/oracle.rs"]
#[allow(dead_code, reason = "shared with the tests of fsw-core and fsw-ground")]
mod oracle;
pub mod parameters;
mod perturbations;
pub mod point;
#[cfg(test)]
mod reference;

use nalgebra::Vector3;

/// Position and velocity of the satellite about the centre of its central body, ICRS axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitState {
    /// TT, microseconds since J2000.0.
    pub time_us: i64,
    /// Position, km.
    pub position_km: Vector3<f64>,
    /// Velocity, km/s.
    pub velocity_km_s: Vector3<f64>,
}

/// Whether every component is finite.
fn finite(vector: &Vector3<f64>) -> bool {
    vector.x.is_finite() && vector.y.is_finite() && vector.z.is_finite()
}
