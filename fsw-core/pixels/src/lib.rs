//! The loops over pixels, in a crate of their own.
//!
//! In: slices of raw pixels. Out: background levels, noise, marked places, sums, fits' normal equations. What
//! these mean for a star, a limb or a streak is decided by `fsw-core`, which is the only user.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`window`] | - | size of windows and of their cells; full scale |
//! | [`median`] | a few samples | their middle and spread |
//! | [`levels`] | raw pixels | background of every row and cell |
//! | [`noise`] | distances from the background | noise of every cell |
//! | [`coarse`] | raw pixels of a tile | the places at which a star may stand |
//! | [`condition`] | raw pixels | a window above its background |
//! | [`search`] | a conditioned window, thresholds | which parts of its rows hold a 3 x 3 sum above them |
//! | [`patch`] | a place in a window | the pixels about it and their sums |
//! | [`light`] | a patch | second moments of the light |
//! | [`profile`] | a star's image and its profile | sums of a least-squares fit |
//! | [`lines`] | a strip of pixels | the mean of its lines without the extremes |
//! | [`radon`] | a block of pixels | sums along all its lines |
//!
//! Arrows point up that table only. The functions that other crates call are not generic.
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(test)]
extern crate std;

pub mod coarse;
pub mod condition;
pub mod levels;
pub mod light;
pub mod lines;
pub mod median;
pub mod noise;
pub mod patch;
pub mod profile;
pub mod radon;
pub mod search;
#[cfg(test)]
#[path = "../../src/image/test_sky.rs"]
#[allow(dead_code, reason = "shared with the tests of fsw-core")]
mod test_sky;
pub mod window;
