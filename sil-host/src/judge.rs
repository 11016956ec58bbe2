//! Holds the flight code's estimates against the truth, in f64 and apart from it.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`second`] | a report and the truth of that second | the errors of that second, each with its sigma |
//! | [`expected`] | the truth's geometry, second by second | the mode the sensor should be in |
//! | [`quantities`] | the errors of a second | each quantity that has a sigma, declared once |
//! | [`foreseen`] | the next change of state as it is foreseen, second by second | how far that comes true |
//! | [`series`] | a quantity through the run | its errors and how far its sigmas are right |
//! | [`chi_square`] | a mean square of normalised errors | how probable it is |
//! | [`sums`] | numbers | root mean squares, shares, medians |
//! | [`run`] | the errors of all seconds | what the run comes to |
//! | [`figures`] | - | what a run comes to |
//! | [`table`] | what a run comes to | every figure that can be limited, declared once |
//! | [`verdict`] | figures and limits | whether these are kept |
//!
//! Attitude errors are rotation vectors in star path axes; position and velocity errors are estimate less
//! truth, along the true radial (up), along (flight) and cross (orbit normal).

pub mod chi_square;
pub mod expected;
pub mod figures;
pub mod foreseen;
pub mod quantities;
pub mod run;
pub mod second;
pub mod series;
pub mod sums;
pub mod table;
pub mod verdict;

pub use figures::Figures;
pub use run::Judge;
pub use second::Judged;
pub use verdict::{Limit, Verdict};

use crate::world::attitude::small_turn;

/// Radians in arcseconds.
pub fn arcsec(rad: f64) -> f64 {
    rad.to_degrees() * 3600.0
}

/// Rotation vector, sensor axes, that turns the true attitude into the estimate; small angles.
pub fn attitude_error(estimate: [f32; 4], truth: [f64; 4]) -> [f64; 3] {
    small_turn(estimate.map(f64::from), truth)
}

#[cfg(test)]
mod mutation_tests;
