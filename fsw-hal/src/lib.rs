//! The door between the flight software and its instruments.
//!
//! `fsw-core` sees the spacecraft only through the traits of this crate; a simulator, a recorded picture and a
//! real detector driver look alike to it.
//!
//! | module | instrument | first used by |
//! |---|---|---|
//! | [`detector`] | active-pixel detector with windowed readout | acquisition and tracking |
//! | [`clock`] | the instant of a second | every second |
//! | [`meter`] | marks between which a cycle's stages are measured | every second |
//! | [`rate_sensor`] | angular rate of the body | not yet |
//! | [`magnetometer`] | magnetic field in body axes | not yet |
//!
//! Conventions: pixels count x right and y down, the centre of the first pixel read is (0, 0); raw values are
//! right-aligned in a `u16`.
#![no_std]
#![forbid(unsafe_code)]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::float_arithmetic
)]

pub mod clock;
pub mod detector;
pub mod magnetometer;
pub mod meter;
pub mod rate_sensor;

pub use clock::{Clock, Instant};
pub use detector::{Detector, DetectorError, DetectorGeometry, Window};
pub use magnetometer::{MagneticField, Magnetometer, MagnetometerError};
pub use meter::{Stage, StageMeter};
pub use rate_sensor::{AngularRate, RateSensor, RateSensorError};
