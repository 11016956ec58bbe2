//! Attitude from pairs of directions.
//!
//! [`wahba`] finds the rotation, [`covariance`] says how well it is known.

pub mod covariance;
pub mod wahba;

use crate::frames::{Direction, Icrs, StarPath};

/// One star seen: where it was measured, where the catalogue has it, and how well it was measured.
#[derive(Clone, Copy, Debug)]
pub struct VectorPair {
    /// Measured direction `b`.
    pub measured: Direction<StarPath>,
    /// Catalogue direction `r`.
    pub reference: Direction<Icrs>,
    /// Standard deviation of `b` per axis across the line of sight, rad.
    pub sigma_rad: f32,
}

impl VectorPair {
    /// The weight `a = 1 / sigma²` relative to a sigma of 1 mrad, so that sums stay near one in f32.
    pub(crate) fn weight(&self) -> f32 {
        let ratio = 1e-3 / self.sigma_rad;
        ratio * ratio
    }
}
