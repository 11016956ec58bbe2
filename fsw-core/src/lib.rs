#![doc = include_str!("overview.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(test)]
extern crate std;

pub mod attitude;
pub mod camera;
pub mod catalog;
pub mod checksum;
pub mod command;
pub mod earth;
mod file;
pub mod image;
pub mod magnetism;
pub mod modes;
#[cfg(test)]
mod oracle;
mod order;
pub mod outages;
pub mod packet;
pub mod parameters;
pub mod plan;
pub mod rate;
pub mod sensor;
pub mod shutting;
pub mod stars;
pub mod telemetry;

pub use fsw_ground::{frames, matrix, trigonometry, word_sum};
/// The orbit, a crate of its own so that it is built for size.
pub use fsw_orbit as orbit;
