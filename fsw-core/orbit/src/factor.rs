//! The covariance of the orbit filter's states as a square root, `P = S Sᵀ`.
//!
//! | states | from | unit | |
//! |---|---|---|---|
//! | position | [`POSITION`] | km | estimated |
//! | velocity | [`VELOCITY`] | km/s | estimated |
//! | limb height, the same everywhere | [`HEIGHT`] | km | estimated |
//! | error of the edges, an angle | [`EDGE`] | rad | estimated |
//! | limb height over latitude, odd and even | [`SUMMER`], [`TROPICS`] | km | estimated |
//! | limb height around the limb | [`FIELD`] | km | estimated |
//! | misalignment of the paths | [`MISALIGNMENT`] | rad | considered or estimated |
//!
//! A product `S Sᵀ` is symmetric and not negative whatever the rounding, so that f32 suffices: a sigma is
//! known to 1e-6 of itself where a variance in f32 would be lost. The columns of `S` are those of a lower
//! triangle, and [`SPARE`] more to which noise is appended; [`Factor::settle`] makes a triangle of them
//! again by Householder's reflections (Bierman, *Factorization methods for discrete sequential estimation*,
//! 1977). The update is that of Potter for one observation of unit variance; for the considered states
//! Schmidt's: what the optimal gain would have taken from them is given back as a column of its own.
//!
//! Cost in f32: a propagation 800 multiplications with additions, an update 3,000, to settle 30,000.

use super::parameters::Misalignment;
use fsw_ground::matrix::{add_scaled_long, dot_long as dot};
use fsw_ground::word_sum;
use nalgebra::Matrix3;

/// First state of the position.
pub const POSITION: usize = 0;
/// First state of the velocity.
pub const VELOCITY: usize = 3;
/// Height of the limb above that of the parameters.
pub const HEIGHT: usize = 6;
/// The edges' own error, times the limb's distance.
pub const EDGE: usize = 7;
/// Factor of the sine of latitude.
pub const SUMMER: usize = 8;
/// Factor of 1/3 less the square of that sine.
pub const TROPICS: usize = 9;
/// First of the Fourier coefficients of the limb's height.
pub const FIELD: usize = 10;
/// First state of the misalignment, a rotation vector in the Earth path.
pub const MISALIGNMENT: usize = 19;
/// Number of states.
pub const STATES: usize = 22;
/// Number of the states of position and velocity, the first.
pub const MOTION: usize = 6;
/// Columns beside the triangle: six of the motion's noise, four of the constants', nine of the field's. An
/// update needs one for each row, nine at most.
pub const SPARE: usize = 19;
const COLUMNS: usize = STATES + SPARE;

/// A value for each state.
pub type Row = [f32; STATES];
/// A value for each column.
pub type Columns = [f32; COLUMNS];

/// A square root of the covariance of all states.
#[derive(Clone, Copy, Debug)]
pub struct Factor {
    rows: [Columns; STATES],
    /// Spare columns in use.
    used: usize,
    /// Whether a triangle is all there is, but for the full block of position and velocity.
    settled: bool,
}

impl Default for Factor {
    fn default() -> Self {
        Self::new()
    }
}

impl Factor {
    /// Of states that are all known.
    pub const fn new() -> Self {
        Self { rows: [[0.0; COLUMNS]; STATES], used: 0, settled: false }
    }

    /// Makes it that of states that are independent, with these sigmas.
    pub fn begin(&mut self, sigmas: &Row) {
        (self.used, self.settled) = (0, true);
        for ((state, row), sigma) in self.rows.iter_mut().enumerate().zip(sigmas) {
            row.fill(0.0);
            if let Some(place) = row.get_mut(state) {
                *place = *sigma;
            }
        }
    }

    /// Sets an element of the factor.
    pub fn set(&mut self, state: usize, column: usize, value: f32) {
        self.settled &= column <= state || column < MOTION;
        if let Some(place) = self.rows.get_mut(state).and_then(|row| row.get_mut(column)) {
            *place = value;
        }
    }

    /// An element of the covariance.
    pub fn covariance(&self, one: usize, other: usize) -> f32 {
        let length = if self.settled { (one.min(other) + 1).max(MOTION) } else { COLUMNS };
        let row = |state| self.rows.get(state).and_then(|row: &Columns| row.get(..length));
        row(one).zip(row(other)).map_or(0.0, |(one, other)| dot(one, other))
    }

    /// The block of three states from each of these on.
    #[inline(never)]
    pub fn block(&self, row: usize, column: usize) -> Matrix3<f64> {
        let mut block = Matrix3::zeros();
        for (j, elements) in block.data.0.iter_mut().enumerate() {
            for (i, element) in elements.iter_mut().enumerate() {
                *element = f64::from(self.covariance(row + i, column + j));
            }
        }
        block
    }

    /// Standard deviation of a state.
    pub fn sigma(&self, state: usize) -> f32 {
        libm::sqrtf(self.covariance(state, state))
    }

    /// Sum of the variances of three states.
    pub fn trace(&self, first: usize) -> f32 {
        (first..first + 3).fold(0.0, |sum, state| sum + self.covariance(state, state))
    }

    /// Sum of all words.
    pub fn word_sum(&self) -> u32 {
        let rows = word_sum::of_singles(self.rows.as_flattened());
        rows.wrapping_add(self.used as u32).wrapping_add(u32::from(self.settled) << 16)
    }

    /// Whether every element is finite and below 1e12.
    pub fn is_valid(&self) -> bool {
        self.rows.iter().flatten().all(|element| libm::fabsf(*element) < 1e12)
    }

    /// `Φ S` for position and velocity.
    #[inline(never)]
    pub fn propagate(&mut self, transition: &[[f32; MOTION]; MOTION]) {
        for column in 0..if self.settled { MOTION } else { COLUMNS } {
            let old: [f32; MOTION] = core::array::from_fn(|k| {
                self.rows.get(k).and_then(|row| row.get(column)).copied().unwrap_or(0.0)
            });
            for (row, factors) in self.rows.iter_mut().zip(transition) {
                if let Some(element) = row.get_mut(column) {
                    *element = dot(factors, &old);
                }
            }
        }
    }

    /// Multiplies a state.
    pub fn scale(&mut self, state: usize, factor: f32) {
        if let Some(row) = self.rows.get_mut(state) {
            for element in row {
                *element *= factor;
            }
        }
    }

    /// Appends independent noise: its share in each of these states. Without room nothing is added, which
    /// [`SPARE`] excludes.
    pub fn append(&mut self, shares: &[(usize, f32)]) {
        let column = STATES + self.used;
        for (state, share) in shares {
            self.set(*state, column, *share);
        }
        self.used = (self.used + 1).min(SPARE);
    }

    /// Makes a lower triangle of all columns; the spare ones are free again.
    #[inline(never)]
    pub fn settle(&mut self) {
        for state in 0..STATES {
            let Some((this, below)) = self.rows.get_mut(state..).and_then(<[Columns]>::split_first_mut)
            else {
                break;
            };
            let Some(tail) = this.get_mut(state..) else { break };
            let Some((first, rest)) = tail.split_first_mut() else { break };
            let rest = dot(rest, rest);
            // Only what is exactly zero may stay: a spare column is used again without being cleared.
            if rest == 0.0 {
                continue;
            }
            // The reflection along v = tail + sign |tail| e takes the tail to its first column.
            let length = libm::copysignf(libm::sqrtf(*first * *first + rest), *first);
            *first += length;
            let scale = 1.0 / (length * *first);
            for row in below {
                let Some(row) = row.get_mut(state..) else { break };
                let along = dot(row, tail) * scale;
                add_scaled_long(row, -along, tail);
            }
            for (at, element) in tail.iter_mut().enumerate() {
                *element = if at == 0 { -length } else { 0.0 };
            }
        }
        (self.used, self.settled) = (0, true);
    }

    /// `Sᵀ h`.
    #[inline(never)]
    pub fn carried(&self, sensitivity: &Row) -> Columns {
        let mut carried = [0.0; COLUMNS];
        for (row, factor) in self.rows.iter().zip(sensitivity) {
            if *factor != 0.0 {
                add_scaled_long(&mut carried, *factor, row);
            }
        }
        carried
    }

    /// Update by an observation of unit variance; gives the gain, which is zero for a considered misalignment.
    #[inline(never)]
    pub fn update(&mut self, sensitivity: &Row, misalignment: Misalignment) -> Row {
        self.settled = false;
        let carried = self.carried(sensitivity);
        let variance = dot(&carried, &carried) + 1.0;
        let root = libm::sqrtf(variance);
        let share = 1.0 / (1.0 + 1.0 / root);
        let mut gain = [0.0; STATES];
        for (row, gain) in self.rows.iter_mut().zip(&mut gain) {
            *gain = dot(row, &carried) / variance;
            add_scaled_long(row, -share * *gain, &carried);
        }
        if misalignment == Misalignment::Considered {
            let mut given_back = [(0, 0.0); STATES - MISALIGNMENT];
            for ((state, gain), back) in gain.iter_mut().enumerate().skip(MISALIGNMENT).zip(&mut given_back) {
                *back = (state, *gain * root);
                *gain = 0.0;
            }
            self.append(&given_back);
        }
        gain
    }
}

#[cfg(test)]
mod tests;
