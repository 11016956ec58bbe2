//! Attitude from pairs of directions.
//!
//! [`wahba`] finds the rotation, [`covariance`] says how well it is known, [`motion`] carries it to the next second.

pub mod covariance;
pub mod motion;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_is_the_inverse_square_of_the_sigma_in_milliradians() {
        for (sigma_rad, weight) in [(1e-3, 1.0), (2e-3, 0.25), (1e-5, 1e4), (1e-1, 1e-4)] {
            let pair = VectorPair { measured: Direction::z(), reference: Direction::z(), sigma_rad };
            assert!((pair.weight() / weight - 1.0).abs() < 1e-6, "{sigma_rad} rad: {}", pair.weight());
        }
    }
}
