//! Pictures for the tests of this room: Gaussian spots of known centre on a background, drawn in f64.

use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use std::vec::Vec;

/// Numbers that look like chance and are the same in every run (SplitMix64).
pub struct Chance(pub u64);

impl Chance {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly from 0 to 1.
    pub fn even(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Gaussian of unit width, by Box and Muller.
    pub fn gaussian(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.even()).ln()).sqrt();
        radius * (core::f64::consts::TAU * self.even()).cos()
    }
}

/// A picture under construction: real values, cut to the detector's range when it is taken.
#[derive(Clone)]
pub struct Sky {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

impl Sky {
    /// An even background.
    pub fn new(width: usize, height: usize, level: f64) -> Self {
        Self { width, height, values: std::vec![level; width * height] }
    }

    /// Adds to every pixel what the function gives for (x, y).
    pub fn add(mut self, mut function: impl FnMut(f64, f64) -> f64) -> Self {
        let width = self.width;
        for (index, value) in self.values.iter_mut().enumerate() {
            *value += function((index % width) as f64, (index / width) as f64);
        }
        self
    }

    /// Adds Gaussian noise.
    pub fn noise(self, sigma: f64, seed: u64) -> Self {
        let mut chance = Chance(seed);
        self.add(|_, _| sigma * chance.gaussian())
    }

    /// Adds a Gaussian spot, integrated over each pixel.
    pub fn star(mut self, [x, y]: [f64; 2], sigma_px: f64, flux: f64) -> Self {
        let share = |from: f64| {
            let edge = |at: f64| libm::erf(at / (sigma_px * core::f64::consts::SQRT_2));
            0.5 * (edge(from + 0.5) - edge(from - 0.5))
        };
        let near = |at: f64, length: usize| {
            (at - 9.0).max(0.0) as usize..((at + 10.0).max(0.0) as usize).min(length)
        };
        for row in near(y, self.height) {
            for column in near(x, self.width) {
                self.values[row * self.width + column] +=
                    flux * share(column as f64 - x) * share(row as f64 - y);
            }
        }
        self
    }

    /// Adds a star drawn out from end to end, of this light a pixel's length.
    pub fn streak(self, [from, to]: [[f64; 2]; 2], sigma_px: f64, light: f64) -> Self {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy);
        let count = (8.0 * length) as usize;
        (0..count).fold(self, |sky, index| {
            let share = (index as f64 + 0.5) / count as f64;
            sky.star([from[0] + share * dx, from[1] + share * dy], sigma_px, light * length / count as f64)
        })
    }

    /// What a detector of this resolution makes of it.
    pub fn expose(&self, bits: u8) -> Frame {
        let geometry = DetectorGeometry { width_px: self.width as u16, height_px: self.height as u16, bits };
        let full_scale = f64::from(geometry.full_scale());
        let pixels = self.values.iter().map(|value| value.round().clamp(0.0, full_scale) as u16).collect();
        Frame { geometry, pixels }
    }
}

/// A picture taken.
#[derive(Clone)]
pub struct Frame {
    pub geometry: DetectorGeometry,
    pub pixels: Vec<u16>,
}

impl fsw_hal::ErrorType for Frame {
    type Error = DetectorError;
}

impl Detector for Frame {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        if !window.fits(&self.geometry) {
            return Err(DetectorError::OutsideDetector);
        }
        let width = usize::from(self.geometry.width_px);
        for (row, target) in pixels.chunks_exact_mut(usize::from(window.width).max(1)).enumerate() {
            let start = (usize::from(window.y) + row) * width + usize::from(window.x);
            target.copy_from_slice(&self.pixels[start..start + usize::from(window.width)]);
        }
        Ok(())
    }
}
