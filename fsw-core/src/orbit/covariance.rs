//! The covariance of the orbit filter's thirteen states: seven that are estimated, six that are only
//! considered.
//!
//! | states | from | unit | |
//! |---|---|---|---|
//! | position | [`POSITION`] | km | estimated |
//! | velocity | [`VELOCITY`] | km/s | estimated |
//! | limb height | [`LIMB_HEIGHT`] | km | estimated |
//! | misalignment of the paths | [`MISALIGNMENT`] | rad | considered |
//! | bias of the fixes | [`BIAS`] | km | considered |
//!
//! Propagation is `Φ P Φᵀ + Q`, where only position and velocity have a transition matrix and the others
//! decay. The update is that of Schmidt: with `S = L Lᵀ` the covariance of the innovation and `W = L⁻¹ H
//! P`, the matrix loses `Wᵀ W`, except among the considered states, which no measurement betters. In f64
//! the cancellation in the difference is acceptable: variances fall by 1e12 at most (test: every campaign
//! of the filter ends with a Cholesky factor of all states).
//!
//! Kept is the lower left half, 728 bytes. A propagation takes 600 multiplications with additions, an
//! update 700.

use super::dynamics::Transition;
use super::noise::ProcessNoise;
use crate::matrix::{Cholesky, add_scaled, dot, dot_slices, product_transposed, symmetrise};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// First state of the position.
pub const POSITION: usize = 0;
/// First state of the velocity.
pub const VELOCITY: usize = 3;
/// The limb height.
pub const LIMB_HEIGHT: usize = 6;
/// First state of the misalignment.
pub const MISALIGNMENT: usize = 7;
/// First state of the bias.
pub const BIAS: usize = 10;
/// Number of states.
pub const STATES: usize = 13;
/// Number of the states of position and velocity, the first.
const MOTION: usize = 6;
/// Number of the estimated states, the first.
const ESTIMATED: usize = 7;
/// Number of the states that decay, the last.
const SLOW: usize = STATES - MOTION;
/// Elements of the lower left half.
const ELEMENTS: usize = STATES * (STATES + 1) / 2;

/// Largest valid variance: products of it stay finite.
const GREATEST_VARIANCE: f64 = 1e30;

/// Derivative of a measured position (rows, km): a column for each state.
pub type Sensitivity = SMatrix<f64, 3, STATES>;

/// Symmetric matrix of all states.
#[derive(Clone, Copy, Debug)]
pub struct Covariance {
    /// Rows of the lower left half, one after the other.
    elements: [f64; ELEMENTS],
}

/// A correction of the estimate, and the innovation's NIS.
#[derive(Clone, Copy, Debug)]
pub struct Correction {
    /// Of the position, km.
    pub position_km: Vector3<f64>,
    /// Of the velocity, km/s.
    pub velocity_km_s: Vector3<f64>,
    /// Of the limb height, km.
    pub limb_height_km: f64,
    /// Normalised innovation squared, `νᵀ S⁻¹ ν`.
    pub nis: f64,
}

/// Place of an element of either half.
fn place(row: usize, column: usize) -> usize {
    let (below, above) = if row < column { (column, row) } else { (row, column) };
    below * (below + 1) / 2 + above
}

/// Whether a factor is 0 or -0, tested as an integer: its product of software floating point is skipped.
fn is_zero(factor: f64) -> bool {
    factor.to_bits() << 1 == 0
}

impl Covariance {
    /// All elements 0.
    pub const ZERO: Self = Self { elements: [0.0; ELEMENTS] };

    /// An element; 0 outside.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.elements.get(place(row, column)).copied().unwrap_or(0.0)
    }

    /// Sets an element, and with it the one across the diagonal.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        if let Some(element) = self.elements.get_mut(place(row, column)) {
            *element = value;
        }
    }

    /// Adds to an element.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.set(row, column, self.at(row, column) + value);
    }

    /// The 3 x 3 block from this row and column on.
    #[inline(never)]
    pub fn block(&self, row: usize, column: usize) -> Matrix3<f64> {
        let mut block = Matrix3::zeros();
        for (j, elements) in block.data.0.iter_mut().enumerate() {
            for (i, element) in elements.iter_mut().enumerate() {
                *element = self.at(row + i, column + j);
            }
        }
        block
    }

    /// Sets the 3 x 3 block from this row and column on; of one on the diagonal the last columns count.
    #[inline(never)]
    pub fn set_block(&mut self, row: usize, column: usize, block: &Matrix3<f64>) {
        for (j, elements) in block.data.0.iter().enumerate() {
            for (i, element) in elements.iter().enumerate() {
                self.set(row + i, column + j, *element);
            }
        }
    }

    /// Sum of the three variances from this state on.
    pub fn trace(&self, first: usize) -> f64 {
        (first..first + 3).fold(0.0, |sum, state| sum + self.at(state, state))
    }

    /// Standard deviations of the three states from this one on.
    #[inline(never)]
    pub fn sigmas(&self, first: usize) -> [f64; 3] {
        [first, first + 1, first + 2].map(|state| libm::sqrt(self.at(state, state)))
    }

    /// Correlations of position and velocity: the lower left half without its diagonal, row by row; 0 where a
    /// variance is not positive.
    #[inline(never)]
    pub fn motion_correlations(&self) -> [f32; MOTION * (MOTION - 1) / 2] {
        let weights: [f64; MOTION] = core::array::from_fn(|state| {
            let variance = self.at(state, state);
            if variance > 0.0 { 1.0 / libm::sqrt(variance) } else { 0.0 }
        });
        let mut correlations = [0.0; MOTION * (MOTION - 1) / 2];
        let mut places = correlations.iter_mut();
        for (row, one) in weights.iter().enumerate() {
            for ((column, other), place) in weights.iter().enumerate().take(row).zip(&mut places) {
                *place = (self.at(row, column) * one * other).clamp(-1.0, 1.0) as f32;
            }
        }
        correlations
    }

    /// `Φ P Φᵀ + Q` over `dt` seconds.
    pub fn propagate(&mut self, transition: &Transition, noise: &ProcessNoise, dt: f64) {
        let (height, bias) = (noise.height_decay, noise.bias_decay);
        self.transform(transition, &[height, 1.0, 1.0, 1.0, bias, bias, bias]);
        // White acceleration, integrated.
        let velocity = noise.acceleration * dt;
        let (both, position) = (velocity * dt * 0.5, velocity * dt * dt / 3.0);
        for axis in 0..3 {
            self.add(POSITION + axis, POSITION + axis, position);
            self.add(VELOCITY + axis, POSITION + axis, both);
            self.add(VELOCITY + axis, VELOCITY + axis, velocity);
        }
        self.add(LIMB_HEIGHT, LIMB_HEIGHT, noise.height_variance_added);
    }

    /// Rotates position and velocity.
    pub fn rotate(&mut self, rotation: &Matrix3<f64>) {
        let mut both = [[0.0; MOTION]; MOTION];
        for (row, elements) in both.iter_mut().enumerate() {
            for (column, element) in elements.iter_mut().enumerate() {
                if row / 3 == column / 3 {
                    *element = rotation.get((row % 3, column % 3)).copied().unwrap_or(0.0);
                }
            }
        }
        self.transform(&both, &[1.0; SLOW]);
    }

    /// `T P Tᵀ` where `T` is `motion` for position and velocity and `kept` on the diagonal for the other
    /// states.
    #[inline(never)]
    fn transform(&mut self, motion: &Transition, kept: &[f64; SLOW]) {
        let mut rows = [[0.0; STATES]; MOTION];
        for k in 0..MOTION {
            let line: [f64; STATES] = core::array::from_fn(|column| self.at(k, column));
            for (row, factors) in rows.iter_mut().zip(motion) {
                let Some(factor) = factors.get(k).filter(|factor| !is_zero(**factor)) else { continue };
                for (sum, element) in row.iter_mut().zip(&line) {
                    *sum += factor * element;
                }
            }
        }
        for (i, (row, factors)) in rows.iter().zip(motion).enumerate() {
            for (j, above) in rows.iter().enumerate().take(i + 1) {
                let nonzero = above.iter().zip(factors).filter(|(_, factor)| !is_zero(**factor));
                self.set(i, j, nonzero.fold(0.0, |sum, (above, factor)| sum + above * factor));
            }
            for (state, element) in row.iter().enumerate().skip(MOTION) {
                self.set(state, i, *element);
            }
        }
        for (state, kept) in (MOTION..STATES).zip(kept).rev().filter(|(_, kept)| **kept != 1.0) {
            for other in 0..STATES {
                self.set(state, other, self.at(state, other) * kept);
            }
            self.set(state, state, self.at(state, state) * kept);
        }
    }

    /// Measurement update by an innovation with noise covariance `noise_km2`; returns the correction.
    /// `None`, and no change, when the innovation's covariance is not positive definite.
    #[inline(never)]
    pub fn correct(
        &mut self,
        sensitivity: &Sensitivity,
        noise_km2: &Matrix3<f64>,
        innovation_km: &Vector3<f64>,
    ) -> Option<Correction> {
        // H P, a column for each state.
        let mut carried = Sensitivity::zeros();
        for (state, sums) in carried.data.0.iter_mut().enumerate() {
            for (other, factors) in sensitivity.data.0.iter().enumerate() {
                let element = self.at(other, state);
                for (sum, factor) in sums.iter_mut().zip(factors).filter(|(_, factor)| !is_zero(**factor)) {
                    *sum += factor * element;
                }
            }
        }
        let mut s = product_transposed(&carried, sensitivity);
        add_scaled(&mut s, 1.0, noise_km2);
        symmetrise(&mut s);
        let factor = Cholesky::of(&s)?;
        let white = factor.whitened(&carried).data.0;
        for (i, row) in white.iter().enumerate() {
            for (j, column) in white.iter().enumerate().take(ESTIMATED.min(i + 1)) {
                self.add(i, j, -dot_slices(row, column));
            }
        }
        let y = factor.whitened(innovation_km);
        let mut correction = white.iter().map(|row| dot_slices(row, y.as_slice()));
        let mut next = || correction.next().unwrap_or(0.0);
        Some(Correction {
            position_km: Vector3::new(next(), next(), next()),
            velocity_km_s: Vector3::new(next(), next(), next()),
            limb_height_km: next(),
            nis: dot(&y, &y),
        })
    }

    /// Multiplies the variances of position and velocity and sets all their correlations to 0.
    #[inline(never)]
    pub fn inflate_motion(&mut self, factor: f64) {
        for row in 0..STATES {
            for column in 0..=row.min(MOTION - 1) {
                let same = row / 3 == column / 3;
                self.set(row, column, if same { self.at(row, column) * factor } else { 0.0 });
            }
        }
    }

    /// Whether the variances of position and velocity are positive, that of the limb height is not negative,
    /// and all are finite.
    #[inline(never)]
    pub fn is_valid(&self) -> bool {
        let height = self.at(LIMB_HEIGHT, LIMB_HEIGHT);
        (0..MOTION).all(|state| {
            let variance = self.at(state, state);
            variance > 0.0 && variance < GREATEST_VARIANCE
        }) && (0.0..GREATEST_VARIANCE).contains(&height)
    }
}

/// Whether a covariance is positive definite. Its factor reads one half of it only; in the other no element
/// may be greater than the trace, as none of a covariance is.
pub fn is_covariance(m: &Matrix3<f64>) -> bool {
    let trace = m.trace();
    trace < GREATEST_VARIANCE && m.iter().all(|x| libm::fabs(*x) <= trace) && Cholesky::of(m).is_some()
}

#[cfg(test)]
mod tests;
