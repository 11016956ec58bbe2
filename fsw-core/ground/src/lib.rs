//! The ground floor that more than one flight crate stands on: words and small mathematics.
//!
//! | module | gives |
//! |---|---|
//! | [`frames`] | directions and rotations typed by frame |
//! | [`matrix`] | loops over small matrices |
//! | [`trigonometry`] | sine and cosine |
//! | [`table`] | declaration and check of parameters |
//! | [`word_sum`] | sums of words, against upsets of memory |
//!
//! `fsw-core` gives them on under the same names.
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(test)]
extern crate std;

pub mod frames;
pub mod matrix;
#[cfg(test)]
#[allow(dead_code, reason = "shared with the tests of fsw-core and fsw-orbit")]
mod oracle;
pub mod table;
pub mod trigonometry;
pub mod word_sum;
