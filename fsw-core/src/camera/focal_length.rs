//! The focal length as the stars show it.
//!
//! In: the focal length that suits an image's stars best, with its standard deviation and instant, and so on
//! from image to image. Out: the focal length over that of the parameters.
//!
//! A lens calibrated on the ground has another temperature in orbit, or was calibrated ill: 0.5 % move a star
//! at the edge by 3 px, more than the search tolerates. A Kalman filter of one state that walks: from the
//! share that the parameters allow (`scale_uncertainty`) it follows the images, a Kelvin a minute with them.

use fsw_hal::LocalTime;

/// Walk of the focal length, share, in a second: an aluminium barrel that warms by 1 K a minute grows by 4e-7
/// a second; the filter is then 5e-5 late, 0.04 px in the corner. At rest it errs by 1.1e-5.
const WALK: f32 = 1e-6;
/// Farthest from the parameters' focal length, share: beyond it is another lens.
const FARTHEST: f32 = 0.02;

/// Estimate of the focal length over that of the parameters.
#[derive(Clone, Copy, Debug)]
pub struct FocalLength {
    ratio: f32,
    variance: f32,
    /// Greatest variance, that of the start.
    prior: f32,
    instant: Option<LocalTime>,
}

impl FocalLength {
    /// That of the parameters, known to the share `sigma`.
    pub fn new(sigma: f32) -> Self {
        let prior = sigma * sigma;
        Self { ratio: 1.0, variance: prior, prior, instant: None }
    }

    /// The focal length over that of the parameters.
    pub fn ratio(&self) -> f32 {
        self.ratio
    }

    /// Takes in the `ratio` that an image of the instant shows, with its standard deviation; what is not
    /// finite, has no error or is more than 2 % off changes nothing.
    pub fn update(&mut self, ratio: f32, sigma: f32, instant: LocalTime) {
        let usable = (ratio - 1.0).abs() < FARTHEST && sigma > 1e-7 && sigma < FARTHEST;
        if !usable {
            return;
        }
        let elapsed_us = self.instant.map_or(0, |before| instant.us_since(before).max(0));
        let walked = WALK * WALK * (elapsed_us as f32 * 1e-6);
        let variance = (self.variance + walked).min(self.prior);
        let gain = variance / (variance + sigma * sigma);
        self.ratio += gain * (ratio - self.ratio);
        self.variance = variance * (1.0 - gain);
        self.instant = Some(instant);
    }
}

#[cfg(test)]
mod tests;
