//! The onboard star catalogue: [`format`] defines and checks its bytes, [`lookup`] reads stars and pairs.
//!
//! In: the catalogue bytes, in flash or memory. Out: stars as fixed-point unit vectors (Q1.30, ICRS at the
//! mission epoch), and for a measured separation the range of star pairs that have it, in O(1).

pub mod format;
pub mod lookup;
#[cfg(test)]
pub(crate) mod sample;

pub use format::{Catalogue, CatalogueError, Pair, Star};
