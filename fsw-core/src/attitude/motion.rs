//! The last attitude and the rate: where the sensor points in the next second, and how well that is known.
//!
//! In: attitudes with their sigmas, each of a cycle (second). Out: the attitude of a later cycle by constant rate in the
//! star path's frame, `A(t) = exp(-[ω×] t) A(0)`, and its sigmas. The rate is the mean of the rates between attitudes,
//! each new one weighted by [`GAIN`], so that a nadir-pointing sensor carries its attitude through minutes of blindness:
//!
//! - noise of the mean rate: that of one difference x sqrt(GAIN / (2 - GAIN)) = 0.26 (an upper bound: successive
//!   differences of white attitude errors go against each other);
//! - lag behind a changing rate: `(1 / GAIN - 1)` seconds of change.
//!
//! Assumption: the sensor turns at a constant rate between attitudes; a slew shows as a lag, which the star gate bears up
//! to 40 arcsec/s².

use crate::frames::{Icrs, Rotation, StarPath};
use nalgebra::Vector3;

/// Weight of the newest rate.
pub const GAIN: f32 = 0.125;
/// `sqrt(GAIN / (2 - GAIN))`.
const NOISE_SHARE: f32 = 0.258_198_9;
/// Attitudes farther apart than this give no rate, s: the rotation between them must be the short way round.
pub const MAX_RATE_BASE_S: u32 = 10;
/// Largest angle over which an attitude is carried in one step, rad.
const MAX_ANGLE_RAD: f32 = 1.5;

/// The mean rate.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// Of the star path against the stars, in its own frame, rad/s.
    pub rad_s: Vector3<f32>,
    /// Standard deviations, rad/s.
    pub sigma_rad_s: Vector3<f32>,
}

/// An attitude, when it was observed, and the rate.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    attitude: Rotation<Icrs, StarPath>,
    /// Cycle to which the attitude has been carried.
    cycle: u32,
    /// Cycle in which it was observed.
    observed: u32,
    /// Standard deviations when it was observed, rad.
    sigma_rad: Vector3<f32>,
    rate: Option<Rate>,
}

/// Root of the sum of squares, component by component.
fn hypot(a: &Vector3<f32>, b: &Vector3<f32>) -> Vector3<f32> {
    a.zip_map(b, |a, b| libm::sqrtf(a * a + b * b))
}

impl Motion {
    /// A first attitude; the rate is not known.
    pub fn begin(attitude: Rotation<Icrs, StarPath>, sigma_rad: [f32; 3], cycle: u32) -> Self {
        Self { attitude, cycle, observed: cycle, sigma_rad: sigma_rad.into(), rate: None }
    }

    /// Cycles since the attitude was observed.
    pub fn age(&self, cycle: u32) -> u32 {
        cycle.wrapping_sub(self.observed)
    }

    /// The mean rate, once two attitudes at most [`MAX_RATE_BASE_S`] apart have been observed.
    pub fn rate(&self) -> Option<&Rate> {
        self.rate.as_ref()
    }

    /// Takes in the attitude of a later cycle.
    pub fn observe(&mut self, attitude: Rotation<Icrs, StarPath>, sigma_rad: [f32; 3], cycle: u32) {
        let elapsed = cycle.wrapping_sub(self.observed);
        let sigma_rad = Vector3::from(sigma_rad);
        // After a longer gap the old mean is as good as any rate over that gap.
        if (1..=MAX_RATE_BASE_S).contains(&elapsed) && self.cycle == self.observed {
            let per_second = 1.0 / elapsed as f32;
            let newest = attitude.angle_from(&self.attitude) * per_second;
            let noise = hypot(&sigma_rad, &self.sigma_rad) * per_second;
            self.rate = Some(match self.rate {
                Some(mean) => Rate {
                    rad_s: mean.rad_s + (newest - mean.rad_s) * GAIN,
                    // From a single difference to the mean of many, in as many seconds as the mean takes to form.
                    sigma_rad_s: (mean.sigma_rad_s * (1.0 - GAIN) + noise * (GAIN * NOISE_SHARE)),
                },
                None => Rate { rad_s: newest, sigma_rad_s: noise },
            });
        }
        *self =
            Self { rate: self.rate, ..Self::begin(attitude, [sigma_rad.x, sigma_rad.y, sigma_rad.z], cycle) };
    }

    /// Attitude and standard deviations in `cycle`; `None` without a rate, or when it would have to be carried too far.
    pub fn at(&self, cycle: u32) -> Option<(Rotation<Icrs, StarPath>, [f32; 3])> {
        let rate = self.rate?;
        let angle = rate.rad_s * cycle.wrapping_sub(self.cycle) as f32;
        let square = angle.dot(&angle);
        if square.is_nan() || square >= MAX_ANGLE_RAD * MAX_ANGLE_RAD {
            return None;
        }
        let drift = rate.sigma_rad_s * cycle.wrapping_sub(self.observed) as f32;
        let sigma_rad = hypot(&self.sigma_rad, &drift);
        Some((self.attitude.turned(&angle), [sigma_rad.x, sigma_rad.y, sigma_rad.z]))
    }

    /// Carries the attitude to `cycle`, so that the step to the next stays small however long nothing is observed.
    pub fn carry(&mut self, cycle: u32) {
        if let Some((attitude, _)) = self.at(cycle) {
            (self.attitude, self.cycle) = (attitude, cycle);
        }
    }
}

#[cfg(test)]
mod tests;
