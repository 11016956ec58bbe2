//! Attitude from pairs of directions.
//!
//! [`wahba`] solves for the rotation, [`covariance`] gives its covariance, [`filter`] estimates attitude
//! and rate over time. [`VectorPair`] is a star with one sigma, [`ExtendedPair`] one with an error ellipse;
//! [`WeightedPair`] is the interface of both.

pub mod comparison;
pub mod covariance;
pub mod filter;
pub mod wahba;

use crate::frames::{Direction, Icrs, StarPath};
use nalgebra::Matrix3;
use wahba::WahbaError;

/// A star with its measured direction, its catalogue direction and the sigma of the measurement.
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

/// A measured and a catalogue direction with their weight, as the methods of [`wahba`] and [`comparison`]
/// take them.
pub trait WeightedPair {
    /// The two directions, and one sigma for all axes across the line of sight.
    fn pair(&self) -> &VectorPair;

    /// Weight matrix `W = DᵀD` of `b - A r` (thesis eq. A.3), star path axes, relative to a sigma of 1 mrad.
    fn information(&self) -> Matrix3<f32>;
}

impl WeightedPair for VectorPair {
    fn pair(&self) -> &VectorPair {
        self
    }

    /// `a I`, which makes the extended problem Wahba's own.
    fn information(&self) -> Matrix3<f32> {
        Matrix3::from_diagonal_element(self.weight())
    }
}

/// Least z of a direction whose error is given by its x and y: 87 deg off the line of sight, the limit of a
/// camera's field.
const LEAST_FORWARD: f32 = 0.05;

/// A star whose error differs from one axis to the other: smeared by a rate, or seen through a lens off its
/// axis.
#[derive(Clone, Copy, Debug)]
pub struct ExtendedPair {
    pair: VectorPair,
    /// Inverse of the covariance of x and y, `[xx, xy, yy]`, 1 / mrad².
    information: [f32; 3],
}

impl ExtendedPair {
    /// A pair (its sigma is used by methods without weight matrices) and the covariance `[xx, xy, yy]`,
    /// rad², of the x and y of its measured direction; z follows from them, as the vector is of unit
    /// length.
    ///
    /// # Errors
    /// [`WahbaError::NotFinite`], or [`WahbaError::Weight`] where the covariance is not positive definite or
    /// the direction lies more than 87 deg off the line of sight.
    pub fn new(pair: VectorPair, covariance_rad2: [f32; 3]) -> Result<Self, WahbaError> {
        let [xx, xy, yy] = covariance_rad2.map(|value| value * 1e6);
        if !(xx.is_finite() && xy.is_finite() && yy.is_finite()) {
            return Err(WahbaError::NotFinite);
        }
        let determinant = xx * yy - xy * xy;
        let in_range = |variance: f32| variance > 1e-12 && variance < 1e6;
        // f32 resolves ellipses up to 1 : 1000.
        if !(in_range(xx) && in_range(yy) && determinant > 1e-6 * xx * yy)
            || pair.measured.vector().z < LEAST_FORWARD
        {
            return Err(WahbaError::Weight);
        }
        let scale = 1.0 / determinant;
        Ok(Self { pair, information: [yy * scale, -xy * scale, xx * scale] })
    }
}

impl WeightedPair for ExtendedPair {
    fn pair(&self) -> &VectorPair {
        &self.pair
    }

    fn information(&self) -> Matrix3<f32> {
        let [xx, xy, yy] = self.information;
        Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0)
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
