//! The C face of Sextant: `fsw_core::Sensor` and the instruments of `fsw-hal` for a flight program in C.
//!
//! `include/sextant.h` is made of this crate by cbindgen; the README beside it shows how to build and link
//! the library. The C program owns all memory, calls [`sextant_init`] once and [`sextant_cycle`] once a
//! second.
//!
//! | module | holds |
//! |---|---|
//! | [`status`] | what a call came to, in a code and in words |
//! | [`doors`] | what can be checked of a pointer |
//! | [`instruments`] | callbacks of C behind the traits of `fsw-hal` |
//! | [`results`] | the main results of a second as a plain struct |
//! | [`memory`] | the sensor and the link in the caller's memory |
//! | [`link`] | the command link: packets in, reports out |
//! | [`resuming`] | a second that takes up what was known before a restart |
//!
//! This is the one crate of the flight code that uses `unsafe`: it dereferences what C hands over after it
//! has checked what can be checked. No heap, no recursion, no panic: on a bare target `panic-never` makes a
//! reachable panic a link error of the C program. On a host the standard library stands behind it, and a
//! panic would end the process.
#![no_std]
#![deny(
    unsafe_op_in_unsafe_fn,
    clippy::undocumented_unsafe_blocks,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing
)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

// Brings the panic handler of a host.
#[cfg(not(target_os = "none"))]
extern crate std;
#[cfg(target_os = "none")]
use panic_never as _;

pub mod areas;
pub mod doors;
pub mod instruments;
pub mod link;
pub mod memory;
pub mod results;
pub mod resuming;
pub mod status;

mod calls;
#[cfg(test)]
mod tests;

pub use calls::*;
pub use link::*;
pub use resuming::*;
