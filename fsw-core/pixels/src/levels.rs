//! The background of a window: a level for every row plus a level for every cell.
//!
//! In: raw pixels. Out: [`Levels`], scaled counts. A cell is [`BLOCK`] columns of `BAND` rows: small enough
//! that a limb, a glow or the vignetting that crosses a window moves the levels of the cells it crosses and
//! leaves those beside it. Rows have levels of their own because readouts band them (thesis §2.1).
//!
//! 1. rough levels: the median (`median`) of 15 pixels spread over the cell; then of 15 spread over the row,
//!    each less its cell's. Their spread gives a rough sigma;
//! 2. levels: the mean distance `d` from the rough levels of all pixels with `|d|` at most [`CLIP_SIGMAS`]
//!    rough sigmas (and half a raw count). In a table of rows and columns the least-squares levels are the
//!    row's mean plus the cell's mean less the mean of all, so one reading of a band gives both.
//!
//! The rows' levels are those of the quiet cells alone, where there are any: clouds have different pixels in
//! every row, and a row that took them for its level would carry them into the open sky beside the Earth.
//!
//! 3. once the noise is known, rows are drawn towards a line through their band as far as chance explains
//!    their scatter about it ([`Levels::calm_rows`]): where the readout does not band them their levels are
//!    known by the band's pixels, not by a row's.
//!
//! A star covers few pixels of a row or a cell, so the medians ignore it whatever its brightness. Error on
//! Gaussian noise, window of 120 x 62 px: 0.13 sigma for a row before the last step, 0.09 sigma for a cell;
//! window of 27 x 27 px: 0.20 sigma for a row before, 0.10 after. What slopes or bends within a cell stays in
//! the residuals.

use core::ops::Range;

use crate::median::{SAMPLES, least, middle_and_spread};
use crate::window::{BANDS, BLOCK, BLOCKS, Cells, MAX_HEIGHT, MAX_WIDTH, bands, rows_of};

/// Pixels farther than this from the level are no background.
pub const CLIP_SIGMAS: i32 = 3;
/// Of windows at least this wide half of the pixels serve the levels.
const WIDE: usize = 64;
/// A cell is quiet whose spread is at most so many times the mean of the [`FEW`] least of 15 cells spread
/// over the window, and four raw counts: of Gaussian noise that mean is half of the mean of all, and the
/// greatest of 32 is 2.4 times that.
const QUIET_FACTOR: i32 = 7;
const FEW: usize = 4;
/// The window has texture where it is not quiet in one cell of so many.
const TEXTURED_DIVISOR: usize = 6;

/// Size of the whole window and resolution of its values.
#[derive(Clone, Copy)]
pub struct Shape {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Raw value to scaled counts, bits to the left.
    pub shift: u32,
    /// Largest raw value.
    pub full_scale: i32,
}

/// Background levels.
#[derive(Clone, Copy, Debug)]
pub struct Levels {
    /// Of each row.
    pub rows: [i32; MAX_HEIGHT],
    /// Of each cell, to be added to the row's.
    pub cells: Cells<i32>,
    /// Pixels that a row's level rests on, the mean of all rows.
    row_pixels: i32,
    /// For each band a bit for each quiet cell, whose pixels the rows' levels rest on; for each of its cells
    /// where none is quiet.
    pub quiet: [u32; BANDS],
}

/// Background pixels of a row or a cell.
#[derive(Clone, Copy, Default)]
struct Tally {
    /// By how much they exceed the lower end of the clip about their rough levels, raw counts.
    sum: u32,
    count: u32,
}

impl Tally {
    /// From one word of [`tally`].
    fn unpacked(both: u32) -> Self {
        Self { sum: both % ONE, count: both / ONE }
    }

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

/// Sum and count in one word: of 64 pixels, each less than 2^15 above the clip's end, the sum needs 21 bits.
const ONE: u32 = 1 << 24;
const _: () = assert!(MAX_WIDTH / 2 <= 64 && WIDE <= 64);

/// Tallies the pixels of one block's row within `clip` of `level`, all raw counts: no pixel needs scaling.
/// The sum is that by which they exceed the clip's lower end, plus [`ONE`] for each.
#[inline(always)]
fn tally<'p>(pixels: impl IntoIterator<Item = &'p u16>, level: i32, clip: u32) -> u32 {
    let lowest = level.wrapping_sub(clip as i32) as u32;
    let mut both = 0_u32;
    for raw in pixels {
        let above = u32::from(*raw).wrapping_sub(lowest);
        both = both.wrapping_add(if above <= 2 * clip { above.wrapping_add(ONE) } else { 0 });
    }
    both
}

/// Tallies row `y`, each block into its own and the quiet ones, whose mask is all ones, into the row's tally.
/// `level` and `levels` are the rough ones of the row and the cells, raw counts.
fn tally_row(
    (y, row): (usize, &[u16]),
    level: i32,
    (levels, masks): (&[i32; BLOCKS], &[u32; BLOCKS]),
    clip: u32,
    blocks: &mut [Tally; BLOCKS],
) -> Tally {
    let mut of_row = 0_u32;
    let mut add = |block: &mut Tally, both: u32, mask: u32| {
        block.add(Tally::unpacked(both));
        of_row = of_row.wrapping_add(both & mask);
    };
    let of_blocks = levels.iter().zip(masks).zip(blocks);
    if row.len() < WIDE {
        let (whole, rest) = row.as_chunks::<BLOCK>();
        let mut of_blocks = of_blocks;
        for (pixels, ((rough, mask), block)) in whole.iter().zip(of_blocks.by_ref()) {
            add(block, tally(pixels, level + rough, clip), *mask);
        }
        if let Some(((rough, mask), block)) = of_blocks.next() {
            add(block, tally(rest, level + rough, clip), *mask);
        }
    } else {
        // The left half of each block, then in the next row the right one: 60 pixels settle a level.
        let halves = row.as_chunks::<{ BLOCK / 2 }>().0.iter().skip(y % 2).step_by(2);
        for (pixels, ((rough, mask), block)) in halves.zip(of_blocks) {
            add(block, tally(pixels, level + rough, clip), *mask);
        }
    }
    Tally::unpacked(of_row)
}

/// The spread up to which a cell is quiet, and the sum of the spreads of 15 cells that lie all over the
/// window, none counted for more than twice their middle: an object does not move it.
fn quiet_spread(spreads: &[i32]) -> (i32, i32) {
    let mut some = [0; SAMPLES];
    for (index, sample) in some.iter_mut().enumerate() {
        let cell = (index * 7 + 3).checked_rem(spreads.len()).unwrap_or(0);
        *sample = spreads.get(cell).copied().unwrap_or(0);
    }
    let lesser_half: [i32; SAMPLES / 2 + 1] = least(some.into_iter());
    let limit = QUIET_FACTOR * lesser_half.iter().take(FEW).sum::<i32>() / FEW as i32 + 4;
    let [.., middle] = lesser_half;
    let most = 2 * middle + 2;
    (limit, some.iter().fold(0, |sum, spread| sum + spread.min(&most)))
}

/// [`Levels::quiet`] of a window with `used` blocks, from the spreads of all cells.
fn quiet_cells(spreads: &[i32], used: usize, limit: i32) -> [u32; BANDS] {
    let mut quiet = [u32::MAX; BANDS];
    // A star alone makes no texture.
    let textured = spreads.iter().filter(|spread| **spread > limit).count();
    if textured * TEXTURED_DIVISOR < spreads.len() {
        return quiet;
    }
    for (quiet, spreads) in quiet.iter_mut().zip(spreads.chunks(used.max(1))) {
        let bits = spreads.iter().rev().fold(0, |bits, spread| 2 * bits + u32::from(*spread <= limit));
        if bits != 0 {
            *quiet = bits;
        }
    }
    quiet
}

/// Columns of [`SAMPLES`] pixels spread over the quiet blocks of a window `width` px wide.
fn quiet_columns(quiet: u32, width: usize) -> [usize; SAMPLES] {
    let mut starts = [0; BLOCKS];
    let mut slots = starts.iter_mut();
    let mut columns = 0;
    for start in (0..width).step_by(BLOCK).filter(|start| (quiet >> (start / BLOCK)) & 1 == 1) {
        columns += BLOCK.min(width - start);
        if let Some(slot) = slots.next() {
            *slot = start;
        }
    }
    let stride = (columns / SAMPLES).max(1);
    core::array::from_fn(|index| {
        // A narrow last block alone has fewer columns than samples.
        let place = (stride / 2 + index * stride).checked_rem(columns).unwrap_or(0);
        starts.get(place / BLOCK).copied().unwrap_or(0) + place % BLOCK
    })
}

/// The rough levels of a band's rows from the pixels in some columns, less the rough levels of their cells;
/// gives the sum of their spreads. A function of its own: inside the larger one its numbers would not stay in
/// registers.
#[inline(never)]
fn rough_rows(
    pixels: &[u16],
    (width, full_scale): (usize, i32),
    (columns, beneath): (&[usize; SAMPLES], &[i32; SAMPLES]),
    levels: &mut [i32],
) -> i32 {
    let mut spreads = 0;
    for (row, level) in pixels.chunks_exact(width.max(1)).zip(levels) {
        let mut samples = [0; SAMPLES];
        for (sample, (x, level)) in samples.iter_mut().zip(columns.iter().zip(beneath)) {
            *sample = row.get(*x).map_or(0, |raw| i32::from(*raw) - level);
        }
        let (middle, spread) = middle_and_spread(&samples);
        *level = middle.max(-full_scale).min(full_scale);
        spreads += spread;
    }
    spreads
}

/// Most bands of a window or a tile.
const MAX_LINES: usize = if BANDS > crate::coarse::BANDS { BANDS } else { crate::coarse::BANDS };

/// A straight line through the levels of a band's rows.
#[derive(Clone, Copy, Default)]
struct Line {
    /// Level of the first row.
    first: f32,
    /// From a row to the next.
    step: f32,
    /// Sum of the squared distances of the levels from it.
    scatter: f32,
    /// How many of these are free.
    freedom: f32,
}

impl Line {
    fn through(levels: &[i32]) -> Self {
        let Some(origin) = levels.first() else { return Self::default() };
        let count = levels.len() as f32;
        let middle = 0.5 * (count - 1.0);
        let (mut sum, mut lever, mut squares) = (0.0, 0.0, 0.0);
        let mut from_middle = -middle;
        for level in levels {
            // From the first: their squares are not small.
            let above = (level - origin) as f32;
            (sum, lever, squares) = (sum + above, lever + from_middle * above, squares + above * above);
            from_middle += 1.0;
        }
        let mean = sum / count;
        let step = lever / (count * (count * count - 1.0) / 12.0).max(1.0);
        Self {
            first: *origin as f32 + mean - step * middle,
            step,
            scatter: (squares - mean * sum - step * lever).max(0.0),
            freedom: (count - 2.0).max(0.0),
        }
    }
}

impl Levels {
    /// Those of nothing. Levels are filled in where they stay: they are too large to be handed on.
    pub const NONE: Self =
        Self { rows: [0; MAX_HEIGHT], cells: [[0; BLOCKS]; BANDS], row_pixels: 0, quiet: [u32::MAX; BANDS] };

    /// Takes the rough levels, raw counts; gives a rough sigma in sixteenths of them.
    fn take_rough(&mut self, pixels: &[u16], shape: &Shape) -> i32 {
        let Shape { width, height, full_scale, .. } = *shape;
        let used = width.div_ceil(BLOCK);
        let mut spreads = [0; BLOCKS * BANDS];
        let mut spread_slots = spreads.iter_mut();
        for (band, cells) in self.cells.iter_mut().enumerate().take(bands(height)) {
            let rows = rows_of(band, height);
            // From top to bottom, in columns that do not follow a pattern of the detector.
            let places: [[usize; 2]; SAMPLES] = core::array::from_fn(|index| {
                let y = rows.start + (2 * index + 1) * rows.len() / (2 * SAMPLES);
                [(index * 7 + 3) % BLOCK, y * width]
            });
            for (block, level) in cells.iter_mut().enumerate().take(used) {
                let last = width.saturating_sub(block * BLOCK + 1);
                let columns = pixels.get(block * BLOCK..).unwrap_or(&[]);
                let samples =
                    places.map(|[x, row]| columns.get(row + x.min(last)).map_or(0, |raw| i32::from(*raw)));
                let (middle, spread) = middle_and_spread(&samples);
                // A value of more bits than promised must not lead to a sum that overflows.
                *level = middle.min(full_scale);
                if let Some(slot) = spread_slots.next() {
                    *slot = spread;
                }
            }
        }
        let spreads = spreads.get(..bands(height) * used).unwrap_or(&[]);
        let (limit, in_some) = quiet_spread(spreads);
        self.quiet = quiet_cells(spreads, used, limit);
        let mut row_spreads = 0;
        let (mut chosen, mut columns) = (0, [0; SAMPLES]);
        for (band, (cells, quiet)) in self.cells.iter().zip(&self.quiet).enumerate().take(bands(height)) {
            // Most often the cells of all bands are quiet.
            if *quiet != chosen {
                (chosen, columns) = (*quiet, quiet_columns(*quiet, width));
            }
            let beneath = columns.map(|x| cells.get(x / BLOCK).copied().unwrap_or(0));
            let rows = rows_of(band, height);
            let of_band = pixels.get(rows.start * width..).unwrap_or(&[]);
            let levels = self.rows.get_mut(rows).unwrap_or(&mut []);
            row_spreads += rough_rows(of_band, (width, full_scale), (&columns, &beneath), levels);
        }
        // The spread of a Gaussian is 0.66 sigma (see `median`). What the cells leave widens the rows'
        // spread; the cells' does not see it, but rests on fewer samples, so half of its size is left to
        // chance.
        let in_rows = 24 * row_spreads / (height as i32).max(1);
        let in_cells = 36 * in_some / SAMPLES as i32;
        in_rows.min(in_cells)
    }

    /// Takes the levels of a window into [`Self::NONE`]; gives the clip about them, raw counts, within which
    /// pixels were taken for background.
    pub fn take(&mut self, pixels: &[u16], shape: &Shape) -> u32 {
        let Shape { width, height, shift, full_scale } = *shape;
        let rough_sigma = self.take_rough(pixels, shape);
        // Three sigmas and half a count.
        let clip = (((CLIP_SIGMAS * rough_sigma).max(16) + 8) / 16).min(full_scale).max(1) as u32;
        let mut row_pixels = 0;
        for (band, (cells, quiet)) in self.cells.iter_mut().zip(self.quiet).enumerate().take(bands(height)) {
            let mut tallies = [Tally::default(); BLOCKS];
            let mut all = Tally::default();
            let is_quiet = |block: usize| (quiet >> block) & 1 == 1;
            let masks = core::array::from_fn(|block| if is_quiet(block) { u32::MAX } else { 0 });
            let rows = rows_of(band, height);
            let of_band = pixels.chunks_exact(width.max(1)).enumerate().skip(rows.start);
            for (row, level) in of_band.zip(self.rows.iter_mut().skip(rows.start)).take(rows.len()) {
                let tally = tally_row(row, *level, (cells, &masks), clip, &mut tallies);
                all.add(tally);
                *level = (*level << shift) + tally.mean(clip, shift);
            }
            let used = width.div_ceil(BLOCK);
            let mean = all.mean(clip, shift);
            for (cell, tally) in cells.iter_mut().zip(&tallies).take(used) {
                *cell = (*cell << shift) + tally.mean(clip, shift) - mean;
            }
            // What the quiet cells of a band have in common belongs to its rows, so that rows of two bands
            // compare.
            let pixels = |tally: &Tally| tally.count as i32;
            let of_quiet =
                cells.iter().zip(&tallies).enumerate().take(used).filter(|(block, _)| is_quiet(*block));
            let sum = of_quiet.fold(0, |sum, (_, (cell, tally))| sum + cell * pixels(tally));
            let common = sum.checked_div(pixels(&all)).unwrap_or(0);
            cells.iter_mut().take(used).for_each(|cell| *cell -= common);
            let of_band = self.rows.iter_mut().skip(rows.start).take(rows.len());
            of_band.for_each(|level| *level += common);
            row_pixels += pixels(&all);
        }
        self.row_pixels = row_pixels / (height as i32).max(1);
        clip
    }

    /// [`calm`]s the rows' levels of each band; `sigma` is the noise of a pixel, scaled counts.
    pub fn calm_rows(&mut self, height: usize, sigma: i32) {
        let noise = sigma as f32;
        let by_chance = noise * noise / self.row_pixels.max(1) as f32;
        let rows: [_; BANDS] = core::array::from_fn(|band| rows_of(band, height));
        calm(&mut self.rows, rows.get(..bands(height)).unwrap_or(&[]), by_chance);
    }
}

/// The lesser of two steps where both go the same way, else none: a glow slopes so, a limb is a step on one
/// side.
fn lesser(before: i32, after: i32) -> i32 {
    if before.signum() == after.signum() { before.signum() * before.abs().min(after.abs()) } else { 0 }
}

/// The step of a level across a cell, the `index`th up to the `last`, from those to its neighbours. At the
/// window's edge the one neighbour speaks for both sides.
pub fn step_across(index: usize, last: usize, before: i32, after: i32) -> i32 {
    match index {
        0 => after,
        index if index >= last => before,
        _ => lesser(before, after),
    }
}

/// Draws the levels of rows towards a straight line through each band, by that part of their scatter about
/// the lines that chance would leave (James and Stein 1961); `by_chance` is the variance of a level. Where
/// the readout bands its rows that part is small; where it does not it is all, and would move centroids
/// across the rows.
#[inline(never)]
pub fn calm(levels: &mut [i32], bands: &[Range<usize>], by_chance: f32) {
    let mut lines = [Line::default(); MAX_LINES];
    let (mut scatter, mut freedom) = (0.0, 0.0);
    for (rows, line) in bands.iter().zip(&mut lines) {
        *line = Line::through(levels.get(rows.clone()).unwrap_or(&[]));
        scatter += line.scatter;
        freedom += line.freedom;
    }
    let kept = 1.0 - (freedom * by_chance / scatter.max(1.0)).min(1.0);
    for (rows, line) in bands.iter().zip(&lines) {
        let mut on_line = line.first;
        for level in levels.get_mut(rows.clone()).unwrap_or(&mut []) {
            *level = libm::rintf(on_line + kept * (*level as f32 - on_line)) as i32;
            on_line += line.step;
        }
    }
}
