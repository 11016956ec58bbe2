//! Local background and noise of a window, and what rises above it.
//!
//! In: raw pixels of a window, any resolution. Out, in place: residuals in scaled counts (`i16` bit patterns), and the
//! window's noise sigma. The background is a level for every row (row banding of CMOS readouts) plus a level for every
//! block of [`BLOCK`] columns (vignetting, amplifier glow):
//!
//! 1. row level: median and quartiles of [`SAMPLES`] evenly spaced pixels, then the mean of the row's pixels within
//!    [`CLIP_SIGMAS`] of that median, the sigma being that of the whole window;
//! 2. block level: mean over all rows of the block's residuals, clipped the same way;
//! 3. sigma: mean absolute residual of the clipped pixels, x 1.2533 (Gaussian), at least a third of a raw count;
//!    and the same of sums over 3 x 3 pixels, because interpolated colour and compression correlate neighbours.
//!
//! A star covers few pixels of a row, so the median ignores it whatever its brightness.

use super::FULL_SCALE;

/// Pixels sampled in a row for its median and quartiles; also the narrowest window.
pub const SAMPLES: usize = 16;
/// Columns that share a level.
pub const BLOCK: usize = 16;
/// Widest window, px.
pub const MAX_WIDTH: usize = 128;
/// Tallest window, px.
pub const MAX_HEIGHT: usize = 64;
/// Pixels farther than this from the level are no background.
pub const CLIP_SIGMAS: i32 = 3;

/// A window of residuals: pixel minus local background, scaled counts, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Residuals<'a> {
    pixels: &'a [u16],
    width: usize,
    /// Noise of a pixel, scaled counts, at least 1.
    pub sigma: i32,
    /// Noise of a sum over 3 x 3 pixels, scaled counts: three times that of a pixel, or more where neighbours go
    /// together.
    pub sum_sigma: i32,
    /// Residual from which on the raw value may have been full scale.
    pub saturation: i32,
}

impl<'a> Residuals<'a> {
    /// Columns of the window.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the window.
    pub fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// All rows, top to bottom, as bit patterns of `i16`.
    pub fn rows(&self) -> core::slice::ChunksExact<'a, u16> {
        self.pixels.chunks_exact(self.width)
    }

    /// Sum of the 3 x 3 pixels about (x, y); x and y at least 1.
    pub fn sum9(&self, x: usize, y: usize) -> i32 {
        let row = |y: usize| self.at(x - 1, y) + self.at(x, y) + self.at(x + 1, y);
        row(y - 1) + row(y) + row(y + 1)
    }

    /// Noise of the 3 x 3 sums, from every fourth one in both directions.
    fn measure_sum_sigma(&self) -> i32 {
        let clip = 4 * CLIP_SIGMAS * self.sigma;
        let (mut deviation, mut count) = (0, 0);
        for y in (1..self.height().saturating_sub(1)).step_by(4) {
            for x in (1..self.width.saturating_sub(1)).step_by(4) {
                let sum = self.sum9(x, y).abs();
                if sum <= clip {
                    deviation += sum;
                    count += 1;
                }
            }
        }
        gaussian_sigma(deviation, count).max(3 * self.sigma)
    }

    /// The residual at a position; 0 outside the window.
    pub fn at(&self, x: usize, y: usize) -> i32 {
        if x >= self.width {
            return 0;
        }
        self.pixels.get(y * self.width + x).map_or(0, |value| residual(*value))
    }
}

/// Reads a pixel of a conditioned window.
pub fn residual(bits: u16) -> i32 {
    i32::from(bits as i16)
}

/// Shift that brings a raw value of `bits` resolution to scaled counts: left for up to 14 bits, else right.
fn scaled(raw: u16, bits: u8) -> i32 {
    let value = i32::from(raw);
    if bits <= 14 { value << (14 - bits) } else { value >> (bits.min(16) - 14) }
}

/// Median and interquartile range of the sampled pixels of a row, by counting ranks: constant cost.
fn quartiles(samples: &[i32; SAMPLES]) -> (i32, i32) {
    let mut at_rank = [0; SAMPLES];
    for (i, value) in samples.iter().enumerate() {
        let rank = samples
            .iter()
            .enumerate()
            .filter(|(j, other)| *other < value || (*other == value && *j < i))
            .count();
        if let Some(slot) = at_rank.get_mut(rank) {
            *slot = *value;
        }
    }
    let [.., q1a, q1b, _, _, _, m1, m2, _, _, _, q3a, q3b, _, _, _] = at_rank;
    ((m1 + m2) / 2, (q3a + q3b - q1a - q1b) / 2)
}

/// Mean of the values within `clip` of `about`, or `about` where there is none.
fn clipped_mean(values: impl Iterator<Item = i32>, about: i32, clip: i32) -> i32 {
    let (sum, count) = values.fold((0i32, 0i32), |(sum, count), value| {
        let offset = value - about;
        if offset.abs() <= clip { (sum + offset, count + 1) } else { (sum, count) }
    });
    about + if count > 0 { sum / count } else { 0 }
}

/// Conditions a window in place. `pixels` holds whole rows of `width` raw values of `bits` resolution.
///
/// `None` when the window is narrower than [`SAMPLES`], wider than [`MAX_WIDTH`], taller than [`MAX_HEIGHT`] or not
/// whole rows.
pub fn condition(pixels: &mut [u16], width: usize, bits: u8) -> Option<Residuals<'_>> {
    let height = pixels.len().checked_div(width)?;
    if !(SAMPLES..=MAX_WIDTH).contains(&width) || !(1..=MAX_HEIGHT).contains(&height) {
        return None;
    }
    if pixels.len() != width * height {
        return None;
    }
    let stride = width / SAMPLES;
    let mut medians = [0i32; MAX_HEIGHT];
    let mut spread = 0;
    for (row, median) in pixels.chunks_exact(width).zip(&mut medians) {
        let mut samples = [0; SAMPLES];
        for (sample, raw) in samples.iter_mut().zip(row.iter().skip(stride / 2).step_by(stride)) {
            *sample = scaled(*raw, bits);
        }
        let (middle, range) = quartiles(&samples);
        *median = middle;
        spread += range;
    }
    // Quartiles of a Gaussian stand 1.349 sigma apart; a third of a raw count is quantisation alone.
    let floor = (scaled(1, bits.min(14)) / 3).max(1);
    let rough_sigma = (spread * 3 / (4 * height as i32)).max(floor);
    let clip = CLIP_SIGMAS * rough_sigma + scaled(1, bits.min(14)) / 2;

    let mut lowest_level = FULL_SCALE;
    for (row, median) in pixels.chunks_exact_mut(width).zip(&medians) {
        let level = clipped_mean(row.iter().map(|raw| scaled(*raw, bits)), *median, clip);
        lowest_level = lowest_level.min(level);
        for pixel in row {
            *pixel = (scaled(*pixel, bits) - level) as i16 as u16;
        }
    }

    let mut block_levels = [0i32; MAX_WIDTH / BLOCK];
    for (index, level) in block_levels.iter_mut().enumerate() {
        let rows = pixels.chunks_exact(width);
        let block = rows.flat_map(|row| row.iter().skip(index * BLOCK).take(BLOCK));
        *level = clipped_mean(block.map(|bits| residual(*bits)), 0, clip);
    }
    let (mut deviation, mut count) = (0i32, 0i32);
    for row in pixels.chunks_exact_mut(width) {
        for (block, level) in row.chunks_mut(BLOCK).zip(&block_levels) {
            for pixel in block {
                let value = residual(*pixel) - level;
                *pixel = value as i16 as u16;
                if value.abs() <= clip {
                    deviation += value.abs();
                    count += 1;
                }
            }
        }
    }
    let highest_block = block_levels.iter().copied().max().unwrap_or(0);
    let mut residuals = Residuals {
        pixels,
        width,
        sigma: gaussian_sigma(deviation, count).max(floor),
        sum_sigma: 0,
        // Full scale less a percent for the converter's last counts, seen from the lowest background of the window.
        saturation: FULL_SCALE - FULL_SCALE / 100 - lowest_level - highest_block,
    };
    residuals.sum_sigma = residuals.measure_sum_sigma();
    Some(residuals)
}

/// Standard deviation of a Gaussian whose absolute values sum to `deviation` over `count` values.
fn gaussian_sigma(deviation: i32, count: i32) -> i32 {
    deviation / count.max(1) * 5 / 4
}
