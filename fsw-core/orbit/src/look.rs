//! A look at the limb: the heights of its points over some seconds, compressed.
//!
//! In: heights of limb points above the limb that the orbit predicts, each with azimuth and sigma. Out: nine
//! rows of unit variance, combinations of the waves of [`super::horizon`].
//!
//! Each point is one row of least squares, `h = Σ c_i w_i(φ)` over its sigma; Givens rotations keep the
//! triangle `R` and `Rᵀ`-side of all rows so far, which holds their information without loss.

use super::horizon::{WAVES, waves};
use fsw_ground::matrix::rotate_into;

/// A row of the triangle: its coefficients, then the right side.
type LookRow = [f32; WAVES + 1];

/// Heights of limb points, compressed.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    rows: [LookRow; WAVES],
    /// When it began, us.
    pub begun_us: i64,
    /// Radius of the limb's sphere in sphere space, km.
    pub radius_km: f32,
    /// How long it lasts, s.
    pub lasts_s: f32,
    /// Sum of the points' times since then, s.
    sum_s: f32,
    /// Their number.
    count: f32,
}

impl Look {
    /// One that begins at this time and lasts so long, of the heights above such a sphere.
    pub const fn new(begun_us: i64, lasts_s: f32, radius_km: f32) -> Self {
        Self { rows: [[0.0; WAVES + 1]; WAVES], begun_us, radius_km, lasts_s, sum_s: 0.0, count: 0.0 }
    }

    /// Time since it began, s.
    pub fn age_s(&self, now_us: i64) -> f32 {
        now_us.saturating_sub(self.begun_us) as f32 * 1e-6
    }

    /// Adds a point's height, seen `since_s` after the begin.
    #[inline(never)]
    pub fn add(&mut self, [cosine, sine]: [f32; 2], height_km: f32, sigma_km: f32, since_s: f32) {
        let weight = 1.0 / sigma_km;
        let mut new = [height_km; WAVES + 1];
        for (place, wave) in new.iter_mut().zip(waves(cosine, sine)) {
            *place = wave;
        }
        for element in &mut new {
            *element *= weight;
        }
        self.sum_s += since_s;
        self.count += 1.0;
        rotate_into(&mut self.rows, &mut new);
    }

    /// The rows: coefficients of the waves, and what was measured of their combination.
    pub fn rows(&self) -> impl Iterator<Item = (&[f32], f32)> {
        self.rows.iter().map(|row| {
            let [waves @ .., height] = row;
            (waves.as_slice(), *height)
        })
    }

    /// Mean time of the points since the begin, s.
    pub fn mean_s(&self) -> f32 {
        self.sum_s / self.count.max(1.0)
    }
}

#[cfg(test)]
mod tests;
