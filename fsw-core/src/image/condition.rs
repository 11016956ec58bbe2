//! Local background and noise of a window, and what rises above it.
//!
//! In: raw pixels of a window, any resolution. Out: [`Residuals`], the same pixels seen above a background in scaled
//! counts, and the window's noise. The background is a level for every row (row banding of CMOS readouts) plus a level
//! for every block of [`BLOCK`] columns (vignetting, amplifier glow):
//!
//! 1. rough levels: the median (`median`) of 15 pixels spread over the row, then of as many spread over
//!    the block, the row's level taken off. Their spread gives a rough sigma;
//! 2. levels: the mean distance `d` from the rough levels of all pixels with `|d|` at most [`CLIP_SIGMAS`] rough sigmas
//!    (and half a raw count). In a table of rows and columns the least-squares levels are the row's mean plus the
//!    block's mean less the mean of all, so one reading of the window gives both;
//! 3. noise: mean absolute residual, x 1.2533 (Gaussian), of sampled pixels, at least a third of a raw count; and the
//!    same of sums over 3 x 3 pixels, because interpolated colour and compression correlate neighbours.
//!
//! A star covers few pixels of a row or a block, so the medians ignore it whatever its brightness. The pixels are not
//! rewritten: a reading less on the target is worth more than the subtraction done again for the few that matter.
//!
//! Error of a level on Gaussian noise, window of 120 x 62 px: 0.13 sigma for a row, 0.04 sigma for a block; sigma comes
//! out 2 % low and the noise of sums 2 % high. Assumes that rows and blocks differ by levels only: what slopes or bends
//! within [`BLOCK`] columns stays in the residuals and widens the noise. Source: thesis §2.1 (row and column offsets);
//! in its §3.1.1 the threshold is fixed and no background is taken off.
//!
//! Cost: 12.4 cycles a pixel of the window (119 x 62 px, 10 bit; Cortex-M4 model, zero wait states). More than 14 bits
//! cost one more reading and writing of the pixels.

use super::FULL_SCALE;
use super::blinding::saturation;
use super::median::{SAMPLES, middle_and_spread};

/// Columns that share a level.
pub const BLOCK: usize = 16;
/// Blocks of the widest window.
pub const BLOCKS: usize = MAX_WIDTH / BLOCK;
/// Narrowest window, px.
pub const MIN_WIDTH: usize = 16;
/// Widest window, px.
pub const MAX_WIDTH: usize = 128;
/// Tallest window, px.
pub const MAX_HEIGHT: usize = 64;
/// Pixels farther than this from the level are no background.
pub const CLIP_SIGMAS: i32 = 3;
/// Resolution that is kept of a pixel: a scaled count is one of a converter of so many bits.
const KEPT_BITS: u8 = FULL_SCALE.ilog2() as u8;
/// Of windows at least this wide half of the pixels serve the levels.
const WIDE: usize = 64;
/// Windows at least this tall are sampled for their noise in every [`NOISE_ROW_STEP`]th row, lower ones in all.
const TALL: usize = 48;
const NOISE_ROW_STEP: usize = 6;

/// A window above its background: pixel minus row level minus block level, scaled counts.
#[derive(Clone, Copy, Debug)]
pub struct Residuals<'a> {
    /// Raw values of at most [`KEPT_BITS`] bits.
    pixels: &'a [u16],
    width: usize,
    height: usize,
    /// Raw value to scaled counts, bits to the left.
    shift: u32,
    row_levels: [i32; MAX_HEIGHT],
    column_levels: [i32; MAX_WIDTH],
    /// Raw value from which on a pixel may have been full scale.
    saturation: u16,
    /// Noise of a pixel, scaled counts, at least 1.
    pub sigma: i32,
    /// Noise of a sum over 3 x 3 pixels, scaled counts: three times that of a pixel, or more where neighbours go
    /// together.
    pub sum_sigma: i32,
}

impl<'a> Residuals<'a> {
    /// Columns of the window.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the window.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Raw value to scaled counts, bits to the left.
    pub fn shift(&self) -> u32 {
        self.shift
    }

    /// Whether the window shows texture (clouds, a limb, glare) rather than noise: strong, and neighbours go together.
    /// Of white noise a 3 x 3 sum has 3 sigmas of a pixel, of real skies after interpolation and compression up to 5.
    pub fn textured(&self) -> bool {
        self.sigma >= FULL_SCALE / 64 && 2 * self.sum_sigma > 11 * self.sigma
    }

    /// The raw values of row `y`, none outside the window.
    pub fn raw_row(&self, y: usize) -> &'a [u16] {
        let start = y.saturating_mul(self.width);
        self.pixels.get(start..start.saturating_add(self.width)).unwrap_or(&[])
    }

    /// Background of row `y`, scaled counts.
    pub fn row_level(&self, y: usize) -> i32 {
        self.row_levels.get(y).copied().unwrap_or(0)
    }

    /// Background of the pixel, scaled counts.
    pub fn level(&self, x: usize, y: usize) -> i32 {
        self.row_level(y) + self.column_levels.get(x).copied().unwrap_or(0)
    }

    /// Background of each column, to be added to that of the row, scaled counts.
    pub fn column_levels(&self) -> &[i32; MAX_WIDTH] {
        &self.column_levels
    }

    /// Whether the pixel may have been at full scale: a twentieth is left to the converter's last counts, to compression and
    /// to colours of which only some were full.
    pub fn saturated(&self, x: usize, y: usize) -> bool {
        self.raw_row(y).get(x).is_some_and(|raw| *raw >= self.saturation)
    }

    /// Residuals of the `N` pixels of row `y` from column `x` on, `None` where they leave the window.
    pub fn run<const N: usize>(&self, x: usize, y: usize) -> Option<[i32; N]> {
        let raw = self.raw_row(y).get(x..)?.first_chunk::<N>()?;
        let levels = self.column_levels.get(x..)?.first_chunk::<N>()?;
        let level = self.row_level(y);
        let mut run = [0; N];
        for ((residual, raw), column) in run.iter_mut().zip(raw).zip(levels) {
            *residual = (i32::from(*raw).min(FULL_SCALE >> self.shift) << self.shift) - level - column;
        }
        Some(run)
    }

    /// The sums of the residuals at (x + i, y - 1), (x + i, y) and (x + i, y + 1), 0 outside the window.
    pub fn column_sums<const N: usize>(&self, x: usize, y: usize) -> [i32; N] {
        let mut sums = [0; N];
        let above = y.wrapping_sub(1);
        let level = self.row_level(above) + self.row_level(y) + self.row_level(y + 1);
        let rows = [above, y, y + 1].map(|y| self.raw_row(y).get(x..).unwrap_or(&[]));
        let columns = self.column_levels.get(x..).unwrap_or(&[]);
        let whole = (rows.map(|row| row.first_chunk::<N>()), columns.first_chunk::<N>());
        // The same twice: where the length is known to the compiler it is twice as fast on the target.
        if let ([Some(a), Some(b), Some(c)], Some(columns)) = whole {
            add_columns(&mut sums, [a, b, c], columns, (level, self.shift));
        } else {
            add_columns(&mut sums, rows, columns, (level, self.shift));
        }
        sums
    }

    /// Noise of pixels and of 3 x 3 sums, from three places in each whole block of the sampled rows; what is farther
    /// than `clip` (a sum: four times) is no background.
    fn measure_noise(&mut self, clip: i32, floor: i32) {
        let (mut pixels, mut sums) = (Deviation::default(), Deviation::default());
        let step = if self.height >= TALL { NOISE_ROW_STEP } else { 1 };
        for y in (1..self.height.saturating_sub(1)).step_by(step) {
            let level = self.row_level(y);
            let level3 = self.row_level(y - 1) + level + self.row_level(y + 1);
            let [above, here, below] = [y - 1, y, y + 1].map(|y| self.raw_row(y).as_chunks::<BLOCK>().0);
            let columns = self.column_levels.as_chunks::<BLOCK>().0;
            for (((a, b), c), [column, ..]) in above.iter().zip(here).zip(below).zip(columns) {
                for (sum, middle) in triples(a, b, c) {
                    sums.add((sum << self.shift).wrapping_sub(3 * level3 + 9 * column), 4 * clip);
                    pixels.add((middle << self.shift) - level - column, clip);
                }
            }
        }
        self.sigma = pixels.sigma().max(floor);
        self.sum_sigma = sums.sigma().max(3 * self.sigma);
    }
}

/// Sums three rows column by column, scaled, less the rows' level together and three times the column's.
#[inline(always)]
fn add_columns(sums: &mut [i32], [a, b, c]: [&[u16]; 3], columns: &[i32], (level, shift): (i32, u32)) {
    for ((sum, ((a, b), c)), column) in sums.iter_mut().zip(a.iter().zip(b).zip(c)).zip(columns) {
        *sum = ((i32::from(*a) + i32::from(*b) + i32::from(*c)) << shift).wrapping_sub(level + 3 * column);
    }
}

/// Sum and middle pixel of three 3 x 3 squares that do not touch.
fn triples(above: &[u16; BLOCK], here: &[u16; BLOCK], below: &[u16; BLOCK]) -> [(i32, i32); 3] {
    let sums = |row: &[u16; BLOCK]| {
        let [_, a, b, c, _, _, d, e, f, _, _, g, h, i, ..] = row.map(i32::from);
        ([a + b + c, d + e + f, g + h + i], [b, e, h])
    };
    let (([a, b, c], _), ([d, e, f], [x, y, z]), ([g, h, i], _)) = (sums(above), sums(here), sums(below));
    [(a + d + g, x), (b + e + h, y), (c + f + i, z)]
}

/// Mean absolute deviation of what lies within a clip.
#[derive(Default)]
struct Deviation {
    sum: u32,
    count: u32,
}

impl Deviation {
    fn add(&mut self, value: i32, clip: i32) {
        let size = value.unsigned_abs();
        if size <= clip.unsigned_abs() {
            self.sum += size;
            self.count += 1;
        }
    }

    /// Standard deviation of a Gaussian of that mean deviation (x 1.2533).
    fn sigma(&self) -> i32 {
        (self.sum * 5 / (4 * self.count).max(1)) as i32
    }
}

/// Background pixels of a row or a block.
#[derive(Clone, Copy, Default)]
struct Tally {
    /// By how much they exceed the lower end of the clip about their rough levels, raw counts.
    sum: u32,
    count: u32,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    /// Mean distance from the rough levels, scaled counts rounded down; 0 of nothing.
    fn mean(&self, clip: u32, shift: u32) -> i32 {
        let above = (self.sum << shift).checked_div(self.count);
        above.map_or(0, |above| above as i32 - (clip << shift) as i32)
    }
}

/// Tallies the pixels of one block's row within `clip` of `level`, all raw counts: no pixel needs scaling.
#[inline(always)]
fn tally<'p>(pixels: impl IntoIterator<Item = &'p u16>, level: i32, clip: u32) -> Tally {
    let lowest = level.wrapping_sub(clip as i32) as u32;
    let mut tally = Tally::default();
    for raw in pixels {
        let above = u32::from(*raw).wrapping_sub(lowest);
        let inside = above <= 2 * clip;
        tally.sum += if inside { above } else { 0 };
        tally.count += u32::from(inside);
    }
    tally
}

/// Tallies row `y`, each block into its own and into the row's tally. `level` and `levels` are the rough ones of the
/// row and the blocks, raw counts.
fn tally_row(
    (y, row): (usize, &[u16]),
    level: i32,
    levels: &[i32; BLOCKS],
    clip: u32,
    blocks: &mut [Tally; BLOCKS],
) -> Tally {
    let mut all = Tally::default();
    let mut add = |block: &mut Tally, tally: Tally| {
        all.add(tally);
        block.add(tally);
    };
    if row.len() < WIDE {
        for ((pixels, rough), block) in row.chunks(BLOCK).zip(levels).zip(blocks) {
            add(block, tally(pixels, level + rough, clip));
        }
    } else {
        // The left half of each block, then in the next row the right one: 60 pixels settle a level.
        let halves = row.as_chunks::<{ BLOCK / 2 }>().0.iter().skip(y % 2).step_by(2);
        for ((pixels, rough), block) in halves.zip(levels).zip(blocks) {
            add(block, tally(pixels, level + rough, clip));
        }
    }
    all
}

/// Rough levels of the rows and the blocks and a rough sigma, raw counts; the sigma in sixteenths.
fn rough_levels(
    pixels: &[u16],
    width: usize,
    height: usize,
    full_scale: i32,
) -> ([i32; MAX_HEIGHT], [i32; BLOCKS], i32) {
    let mut rows = [0; MAX_HEIGHT];
    let mut row_spreads = 0;
    let stride = (width / SAMPLES).max(1);
    for (row, level) in pixels.chunks_exact(width.max(1)).zip(&mut rows) {
        let mut samples = [0; SAMPLES];
        for (sample, raw) in samples.iter_mut().zip(row.iter().skip(stride / 2).step_by(stride)) {
            *sample = i32::from(*raw);
        }
        let (middle, spread) = middle_and_spread(&samples);
        // A value of more bits than promised must not lead to a sum that overflows.
        *level = middle.min(full_scale);
        row_spreads += spread;
    }
    let mut samples = [[0; SAMPLES]; BLOCKS];
    for index in 0..SAMPLES {
        // From top to bottom, in columns that do not follow a pattern of the detector.
        let y = (2 * index + 1) * height / (2 * SAMPLES);
        let level = rows.get(y).copied().unwrap_or(0);
        let row = pixels.get(y * width..).unwrap_or(&[]);
        for (block, samples) in samples.iter_mut().enumerate() {
            let x = (block * BLOCK + (index * 7 + 3) % BLOCK).min(width.saturating_sub(1));
            if let (Some(sample), Some(raw)) = (samples.get_mut(index), row.get(x)) {
                *sample = i32::from(*raw) - level;
            }
        }
    }
    let mut blocks = [0; BLOCKS];
    let mut block_spreads = 0;
    let used = width.div_ceil(BLOCK);
    for (samples, level) in samples.iter().zip(&mut blocks).take(used) {
        let (middle, spread) = middle_and_spread(samples);
        *level = middle.min(full_scale);
        block_spreads += spread;
    }
    // The spread of a Gaussian is 0.66 sigma (see `median`). A slope along the rows widens the rows' spread; the blocks'
    // does not see it, but rests on fewer samples, so half of its size is
    // left to chance.
    let mean = |sum: i32, count: usize| 24 * sum / (count as i32).max(1);
    let (along_rows, in_blocks) = (mean(row_spreads, height), mean(block_spreads, used));
    (rows, blocks, along_rows.min(in_blocks * 3 / 2))
}

/// Conditions a window. `pixels` holds whole rows of `width` raw values of `bits` resolution; values of more than 14
/// bits lose their last ones in place.
///
/// `None` when the window is narrower than [`MIN_WIDTH`], wider than [`MAX_WIDTH`], taller than [`MAX_HEIGHT`] or not
/// whole rows.
pub fn condition(pixels: &mut [u16], width: usize, bits: u8) -> Option<Residuals<'_>> {
    let height = pixels.len().checked_div(width)?;
    if !(MIN_WIDTH..=MAX_WIDTH).contains(&width) || !(1..=MAX_HEIGHT).contains(&height) {
        return None;
    }
    if pixels.len() != width * height {
        return None;
    }
    let bits = bits.clamp(1, 16);
    if bits > KEPT_BITS {
        let surplus = bits - KEPT_BITS;
        pixels.iter_mut().for_each(|raw| *raw >>= surplus);
    }
    let kept_bits = bits.min(KEPT_BITS);
    let shift = u32::from(KEPT_BITS - kept_bits);
    let full_scale = (1u16 << kept_bits) - 1;
    let pixels = &*pixels;

    let (mut row_levels, rough_blocks, rough_sigma) =
        rough_levels(pixels, width, height, i32::from(full_scale));
    // Three sigmas and half a count. A third of a count is the sigma of quantisation alone.
    let clip = (((CLIP_SIGMAS * rough_sigma).max(16) + 8) / 16).min(i32::from(full_scale)).max(1) as u32;
    let floor = ((1 << shift) / 3).max(1);

    let mut block_tallies = [Tally::default(); BLOCKS];
    let mut all = Tally::default();
    for (row, level) in pixels.chunks_exact(width).enumerate().zip(&mut row_levels) {
        let row_tally = tally_row(row, *level, &rough_blocks, clip, &mut block_tallies);
        all.add(row_tally);
        *level = (*level << shift) + row_tally.mean(clip, shift);
    }
    let mut column_levels = [0; MAX_WIDTH];
    let blocks = column_levels.as_chunks_mut::<BLOCK>().0;
    for ((columns, rough), tally) in blocks.iter_mut().zip(&rough_blocks).zip(&block_tallies) {
        *columns = [(rough << shift) + tally.mean(clip, shift) - all.mean(clip, shift); BLOCK];
    }
    let mut residuals = Residuals {
        pixels,
        width,
        height,
        shift,
        row_levels,
        column_levels,
        saturation: saturation(kept_bits),
        sigma: floor,
        sum_sigma: 3 * floor,
    };
    // The levels are finer than the counts: half a count more.
    residuals.measure_noise(((2 * clip + 1) << shift) as i32 / 2, floor);
    Some(residuals)
}

#[cfg(test)]
mod tests;
