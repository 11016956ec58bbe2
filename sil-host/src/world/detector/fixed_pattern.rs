//! Fixed patterns: what differs from pixel to pixel and stays.
//!
//! In: standard deviations, a seed, the detector's size. Out: gain and share of the dark current of each
//! pixel, an offset of each column; all Gaussian and pure functions of (seed, x, y). Rows have an offset that
//! is new in each cycle: the reset and supply noise that all pixels of a row share when they are read
//! (banding).
//!
//! Levels of the reference: gains within 1 % (PRNU of star tracker APS: about 1 %), dark currents within 10 %
//! about the mean beside the hot pixels, columns 4 e- (in an APS the pattern of the columns stands above that
//! of the pixels, J. Aerosp. Technol. Manag. 5, 2013), rows 3 e-, both a fraction of the readout's 20 e-.

use crate::world::noise::{Noise, Stream};
use crate::world::normal::QuickInverse;
use fsw_hal::{DetectorGeometry, Window};
use std::sync::{Arc, Mutex, PoisonError};

/// How many patterns are kept, of 2.6 MB for the reference detector.
const KEPT: usize = 4;

type Made = (PatternModel, u64, DetectorGeometry, Arc<FixedPattern>);

static LAST: Mutex<Vec<Made>> = Mutex::new(Vec::new());

/// Steps in a standard deviation of gain and dark current: bytes reach to 5.3 of them, where one pixel in 10
/// million lies.
const STEPS: f64 = 24.0;

/// How much pixels, columns and rows differ; standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatternModel {
    /// Gain of pixels, share (PRNU).
    pub prnu: f64,
    /// Dark current of pixels, share of the mean (DSNU).
    pub dsnu: f64,
    /// Offset of columns, e-.
    pub column_offset_e: f64,
    /// Offset of rows, new in each cycle, e-.
    pub row_noise_e: f64,
}

impl PatternModel {
    /// A detector whose pixels are all alike.
    pub const NONE: Self = Self { prnu: 0.0, dsnu: 0.0, column_offset_e: 0.0, row_noise_e: 0.0 };
    /// The reference detector.
    pub const REFERENCE: Self = Self { prnu: 0.01, dsnu: 0.1, column_offset_e: 4.0, row_noise_e: 3.0 };

    /// Whether all values make physical sense.
    pub fn is_sound(&self) -> bool {
        [self.prnu, self.dsnu].iter().all(|v| (0.0..=0.3).contains(v))
            && [self.column_offset_e, self.row_noise_e].iter().all(|v| (0.0..=1e4).contains(v))
    }
}

/// The patterns of a detector.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedPattern {
    width: usize,
    /// How far gain and dark current of a pixel are from the mean, in steps of their deviation; empty where
    /// all are alike. As bytes, because a window's rows lie far apart in memory.
    pixels: Vec<[i8; 2]>,
    /// The gain for each of the steps that a pixel may be off, by the byte's bits.
    gains: [f64; 256],
    /// A step of the dark current as a share of the mean.
    per_dark: f64,
    columns_e: Vec<f64>,
    row_noise_e: f64,
    seed: u64,
}

/// Dark current of the pixels in an exposure.
#[derive(Debug, Clone, PartialEq)]
pub struct Darks {
    mean_e: f64,
    /// By the bits of the byte that says how far off a pixel is.
    steps_e: [f64; 256],
}

/// How far the pixels of a row are off by `noise`, in whole steps, into place `of` of each.
fn steps(noise: &Noise, y: u32, row: &mut [[i8; 2]], of: usize) {
    let quick = QuickInverse::table();
    for (pixel, x) in row.iter_mut().zip(0..) {
        // Added and taken away, 1.5 * 2^52 rounds to a whole number, as `rint` does.
        const ROUNDER: f64 = 6_755_399_441_055_744.0;
        pixel[of] = (STEPS * quick.at(noise.bits(x, y)) + ROUNDER - ROUNDER) as i8;
    }
}

impl FixedPattern {
    /// Of the detector that `seed` makes. The last few are kept: flights with one seed and another belief ask
    /// for the same.
    pub fn shared(model: &PatternModel, seed: u64, geometry: DetectorGeometry) -> Arc<Self> {
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |(of, by, at, _): &&Made| (of, *by, *at) == (model, seed, geometry);
        if let Some((.., pattern)) = last.iter().find(same) {
            return Arc::clone(pattern);
        }
        let pattern = Arc::new(Self::new(model, seed, geometry));
        if last.len() == KEPT {
            last.remove(0);
        }
        last.push((*model, seed, geometry, Arc::clone(&pattern)));
        pattern
    }

    /// Of the detector that `seed` makes.
    pub fn new(model: &PatternModel, seed: u64, geometry: DetectorGeometry) -> Self {
        let [gain, dark, column] =
            [Stream::Gain, Stream::Dark, Stream::Column].map(|stream| Noise::new(seed, 0, stream));
        let (width, height) = (u32::from(geometry.width_px), u32::from(geometry.height_px));
        let even = model.prnu == 0.0 && model.dsnu == 0.0;
        let mut pixels = vec![[0; 2]; if even { 0 } else { width as usize * height as usize }];
        for (row, y) in pixels.chunks_exact_mut(width.max(1) as usize).zip(0..) {
            steps(&gain, y, row, 0);
            steps(&dark, y, row, 1);
        }
        Self {
            width: usize::from(geometry.width_px),
            pixels,
            gains: std::array::from_fn(|index| 1.0 + model.prnu / STEPS * f64::from(index as u8 as i8)),
            per_dark: model.dsnu / STEPS,
            columns_e: (0..width).map(|x| model.column_offset_e * column.gaussian(x, 0)).collect(),
            row_noise_e: model.row_noise_e,
            seed,
        }
    }

    /// Dark current of an exposure whose mean is `dark_e`, for each of the steps that a pixel may be off.
    pub fn darks(&self, dark_e: f64) -> Darks {
        let per_dark = dark_e * self.per_dark;
        let of = |index: usize| (dark_e + per_dark * f64::from(index as u8 as i8)).max(0.0);
        Darks { mean_e: dark_e, steps_e: std::array::from_fn(of) }
    }

    /// Turns `light`, the pixels of `window`, into mean electrons: times the gains, plus the dark current.
    pub fn charge(&self, window: Window, darks: &Darks, light: &mut [f64]) {
        if self.pixels.is_empty() {
            light.iter_mut().for_each(|pixel| *pixel += darks.mean_e);
            return;
        }
        for (line, y) in light.chunks_exact_mut(usize::from(window.width)).zip(usize::from(window.y)..) {
            let start = y * self.width + usize::from(window.x);
            for (pixel, [gain, dark]) in line.iter_mut().zip(&self.pixels[start..]) {
                *pixel =
                    *pixel * self.gains[usize::from(*gain as u8)] + darks.steps_e[usize::from(*dark as u8)];
            }
        }
    }

    /// Offsets of all columns, e-.
    #[inline]
    pub fn columns_e(&self) -> &[f64] {
        &self.columns_e
    }

    /// Offsets of the rows in a cycle, e-.
    pub fn rows_e(&self, cycle: u64) -> impl Fn(u16) -> f64 {
        let (noise, row_noise_e) = (Noise::new(self.seed, cycle, Stream::Row), self.row_noise_e);
        move |y| if row_noise_e == 0.0 { 0.0 } else { row_noise_e * noise.quick_gaussian(0, u32::from(y)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 200, height_px: 150, bits: 10 };

    #[test]
    fn patterns_have_their_widths_and_windows_their_part() {
        let pattern = FixedPattern::new(&PatternModel::REFERENCE, 7, GEOMETRY);
        let whole = GEOMETRY.whole();
        let values = |dark: f64, light: f64, window: Window| {
            let mut pixels = vec![light; window.area()];
            pattern.charge(window, &pattern.darks(dark), &mut pixels);
            pixels
        };
        let spread = |values: &[f64]| {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
        };
        // 30,000 pixels: 4 sigma of a standard deviation are 1.6 %.
        let (mean, sigma) = spread(&values(0.0, 1.0, whole));
        assert!(
            (mean - 1.0).abs() < 4.0 * 0.01 / 173.0 && (sigma / 0.01 - 1.0).abs() < 0.0164,
            "{mean} {sigma}"
        );
        let (mean, sigma) = spread(&values(1.0, 0.0, whole));
        assert!(
            (mean - 1.0).abs() < 4.0 * 0.1 / 173.0 && (sigma / 0.1 - 1.0).abs() < 0.0164,
            "{mean} {sigma}"
        );
        let columns: Vec<f64> = (0..200).map(|x| pattern.columns_e()[x]).collect();
        assert!((spread(&columns).1 / 4.0 - 1.0).abs() < 0.2);
        let rows: Vec<f64> = (0..150).map(|y| pattern.rows_e(3)(y)).collect();
        assert!((spread(&rows).1 / 3.0 - 1.0).abs() < 0.24);
        assert_ne!(rows[4], pattern.rows_e(4)(4));
        let window = Window { x: 17, y: 40, width: 3, height: 2 };
        let part = values(5.0, 2.0, window);
        let all = values(5.0, 2.0, whole);
        assert_eq!(part[4], all[41 * 200 + 18]);
    }

    #[test]
    fn pixels_are_off_by_the_nearest_step_of_their_deviates() {
        let pattern = FixedPattern::new(&PatternModel::REFERENCE, 7, GEOMETRY);
        let gain = Noise::new(7, 0, Stream::Gain);
        for (place, [step, _]) in (0..).zip(&pattern.pixels) {
            let deviate = gain.quick_gaussian(place % 200, place / 200);
            assert_eq!(f64::from(*step), libm::rint(STEPS * deviate));
        }
    }

    #[test]
    fn a_shared_pattern_is_that_of_its_seed() {
        let shared = |seed| FixedPattern::shared(&PatternModel::REFERENCE, seed, GEOMETRY);
        let first = shared(1);
        assert_eq!(*first, FixedPattern::new(&PatternModel::REFERENCE, 1, GEOMETRY));
        assert!(Arc::ptr_eq(&first, &shared(1)) && *first != *shared(2));
        // Others in between, more than are kept.
        (3..10).for_each(|seed| drop(shared(seed)));
        assert_eq!(first, shared(1));
    }

    #[test]
    fn an_even_detector_adds_its_dark_current_only() {
        let even = FixedPattern::new(&PatternModel::NONE, 7, GEOMETRY);
        let mut pixels = [3.0; 4];
        even.charge(Window { x: 0, y: 0, width: 2, height: 2 }, &even.darks(5.0), &mut pixels);
        assert_eq!(pixels, [8.0; 4]);
        assert_eq!((even.columns_e()[3], even.rows_e(1)(1)), (0.0, 0.0));
    }
}
