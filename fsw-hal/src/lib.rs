//! The door between the flight software and its instruments.
//!
//! `fsw-core` sees the spacecraft only through the traits of this crate; a simulator, a recorded picture and
//! a real detector driver look alike to it. Drivers of real parts are in `fsw-drivers`, beside this crate.
//!
//! | module | instrument | first used by |
//! |---|---|---|
//! | [`detector`] | active-pixel detector with windowed readout | acquisition and tracking |
//! | [`clock`] | local time since power-on, and Terrestrial Time | every second |
//! | [`meter`] | marks between which a cycle's stages are measured | every second |
//! | [`rate_sensor`] | angular rate of the body | every second, where there is one |
//! | [`shutter`] | shutters of the two paths | every second, where there is one |
//! | [`magnetometer`] | magnetic field in body axes | every second, where there is one |
//! | [`store`] | record that outlives a restart | who calls the second; not by the flight code |
//! | [`area`] | files that serve from the next start on | the command link, where there is one |
//! | [`error`] | what the errors of all of them have in common | - |
//!
//! Conventions: pixels count x right and y down, the centre of the first pixel read is (0, 0); raw values are
//! right-aligned in a `u16`.
//!
//! Each instrument follows the idiom of `embedded-hal` 1.0: a driver has an [`ErrorType`] whose [`Error`]
//! gives its kind, and each trait is also that of `&mut` of whatever has it. A driver keeps its own error
//! type; the flight code looks at the kind alone.
//!
//! The traits block. The flight code is one function call a second without interrupts, threads or an
//! executor, and its cost is bounded by counting cycles; futures would put state machines of unknown size on
//! that stack. Whoever wants to wait elsewhere (DMA, an executor) calls [`Detector::start_exposure`] of his
//! own driver early and lets [`Detector::finish_exposure`] return what is ready.
#![no_std]
#![forbid(unsafe_code)]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::float_arithmetic
)]

pub mod area;
pub mod clock;
pub mod detector;
pub mod error;
pub mod magnetometer;
pub mod meter;
pub mod rate_sensor;
pub mod shutter;
pub mod store;

pub use area::{Area, AreaStore, ErrorKind as AreaError};
pub use clock::{Clock, ErrorKind as ClockError, Instant, LocalTime};
pub use detector::{Detector, DetectorGeometry, ErrorKind as DetectorError, Window};
pub use error::{Error, ErrorType, ReadingError};
pub use magnetometer::{MagneticField, Magnetometer};
pub use meter::{Stage, StageMeter};
pub use rate_sensor::{AngularRate, RateSensor};
pub use shutter::{ErrorKind as ShutterError, OpenPaths, Shutter};
pub use store::{ErrorKind as StoreError, StateStore};
