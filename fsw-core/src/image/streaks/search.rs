//! Finds pieces of lines in the whole image: a fast discrete Radon transform of binned blocks.
//!
//! In: a detector whose image is exposed, and the readout buffer. Out: the strongest [`MAX_PIECES`] pieces, the strongest
//! first, at most one a block of [`BLOCK_PX`] px.
//!
//! A block becomes 16 x 16 sums of 4 x 4 px, each in units of the block's own noise above its own median, cut at
//! `CLIP`, 3 sigmas: a hot pixel or a hit lifts a line by a sigma, no more. The scatter of what remains is the unit. Brady's recursion (A fast discrete approximation
//! algorithm for the Radon transform, SIAM J. Comput. 27, 1998) then sums all lines of 64 directions, and those of
//! half a block's width: lines of 2^k columns that rise by t are two of half the length that rise by t / 2. A line counts if it rises `THRESHOLD_SIGMAS` above the
//! noise, and the parallel lines 20 px to either side do not: a limb is an edge, not a line. Blocks that are bright or noisy
//! in many places are left.
//!
//! What is seen: 4.5 sigma of 64 px with 0.6 of the light in the line of bins, 870 electrons at V = 3 and 1 deg/s shared
//! out with the rate: V = 5.6 at 1 deg/s (if the streak were that long; one of 21 px reaches 4.4), 4.5 at 4, 3.5 at
//! 10 and 3.1 at 15 deg/s in every block, and half a magnitude fainter in one of the several blocks of a long streak. A
//! matched filter of the whole streak would reach V = 4.3 at 15 deg/s, the sums of 3 x 3 px of a star scan reach 1.8.

use super::{Piece, scaled};
use crate::image::scan::TILE_PIXELS;
use fsw_hal::{Detector, DetectorError, Window};
use heapless::Vec;

/// Side of a block, px.
pub const BLOCK_PX: u16 = 64;
/// Most pieces kept.
pub const MAX_PIECES: usize = 48;
/// The pieces of an image.
pub type Pieces = Vec<Piece, MAX_PIECES>;
/// Side of a bin, px.
const BIN: usize = 4;
/// Bins along a block's side; the transform needs a power of two.
const SIDE: usize = 16;
const STEPS: u32 = SIDE.ilog2();
/// Rows in which a line may begin: those of the block and as many above it.
const ROWS: usize = 2 * SIDE;
/// A sigma of a bin in the transform's units.
const SIGMA: i32 = 16;
/// A bin counts for so many sigmas at most.
const CLIP: i32 = 3 * SIGMA;
/// A line must rise so many sixteenths of a sigma above the noise: 4.25 sigma. Of 100,000 independent lines of an image one does so
/// by chance.
const THRESHOLD_SIGMAS: i32 = 68;
/// Fewest bins of a line.
const FEWEST_BINS: usize = 6;
/// Rows, in bins, from a line to those that must be dark.
const BESIDE: usize = 5;
/// Most bins of a block above two sigmas.
const MOST_BRIGHT: usize = 72;
/// What is so many times as noisy as blocks usually are shows an object.
const NOISY: i32 = 4;
/// 1024 times the root of [`FEWEST_BINS`].
const PER_ROOT_FEWEST: i32 = 2508;
/// 1024 over the root of the number.
const PER_ROOT: [i32; SIDE + 1] =
    [0, 1024, 724, 591, 512, 458, 418, 387, 362, 341, 324, 309, 296, 284, 274, 264, 256];

type Bins = [[i16; SIDE]; SIDE];
/// Lines by (strip, rise) and row of their beginning.
type Lines = [[i16; ROWS]; SIDE];

/// A line of a block: how strong, where it begins and ends, bins.
#[derive(Clone, Copy)]
struct Line {
    strength: i32,
    from: [f32; 2],
    to: [f32; 2],
}

/// Median, and sigma by the spread of the middle half, of some values.
fn median_and_sigma(values: &mut [i32]) -> (i32, i32) {
    crate::order::sort(values, |a, b| a < b);
    let at = |quarter: usize| values.get(quarter * values.len() / 4).copied().unwrap_or(0);
    (at(2), (at(3) - at(1)) * 3 / 4)
}

/// The block's bins in units of its noise; `None` where it shows an object. `usual` is the noise of a bin in the blocks so
/// far, sixteenths, 0 before the first: the spread of a few bins may come out too small by chance, and then everything seems to rise.
#[inline(never)]
fn bins_of(pixels: &[u16], bits: u8, usual: &mut i32) -> Option<(Bins, f32)> {
    let mut sums = [[0i32; SIDE]; SIDE];
    for (row, pixels) in pixels.chunks_exact(usize::from(BLOCK_PX)).enumerate() {
        let sums = sums.get_mut(row / BIN)?;
        for (sum, four) in sums.iter_mut().zip(pixels.as_chunks::<BIN>().0) {
            *sum += four.iter().fold(0, |sum, raw| sum + i32::from(*raw));
        }
    }
    // A quarter of the bins, in columns that change from row to row.
    let mut sample = [0; SIDE * SIDE / 4];
    for (index, slot) in sample.iter_mut().enumerate() {
        let row = index / (SIDE / 4);
        *slot =
            sums.get(row).and_then(|sums| sums.get((index % 4) * 4 + (row * 3) % 4)).copied().unwrap_or(0);
    }
    let (median, sigma) = median_and_sigma(&mut sample);
    let sigma = sigma.max(2);
    if *usual == 0 {
        *usual = 16 * sigma;
    }
    // Up by a sixteenth of the difference at most, down by a quarter of it.
    let difference = 16 * sigma - *usual;
    *usual += if difference > 0 { difference.min(*usual) / 16 } else { difference / 4 };
    let usual = *usual / 16;
    let level = scaled((median / (BIN * BIN) as i32).clamp(0, i32::from(u16::MAX)) as u16, bits);
    if sigma > NOISY * usual || level > crate::image::FULL_SCALE / 2 {
        return None;
    }
    let sigma = sigma.max(usual);
    let mut bins = [[0i16; SIDE]; SIDE];
    let (mut bright, mut square) = (0, 0);
    for (bin, sum) in bins.as_flattened_mut().iter_mut().zip(sums.as_flattened()) {
        let value = ((sum - median) * SIGMA).checked_div(sigma).unwrap_or(0).clamp(-CLIP, CLIP);
        bright += usize::from(value > 2 * SIGMA);
        square += value * value;
        *bin = value as i16;
    }
    // What hits and faint stars add to the scatter, lines have too.
    let scatter = libm::sqrtf(square as f32 / ((SIDE * SIDE) as i32 * SIGMA * SIGMA) as f32);
    (bright <= MOST_BRIGHT).then_some((bins, scatter.max(1.0)))
}

/// The strongest line of a block, of half its width or all of it, that rises by 0 to 15 rows.
#[inline(never)]
fn strongest_rising(bins: &Bins) -> Option<Line> {
    // By (strip, rise) and row of their beginning + 16; at first a strip is a column.
    let mut lines: Lines = [[0; ROWS]; SIDE];
    for (row, values) in bins.iter().enumerate() {
        for (line, value) in lines.iter_mut().zip(values) {
            if let Some(slot) = line.get_mut(SIDE + row) {
                *slot = *value;
            }
        }
    }
    let mut best: Option<Line> = None;
    for step in 0..STEPS {
        lines = doubled(&lines, step);
        if step + 2 >= STEPS {
            let most = best.map_or(0, |best| best.strength);
            best = strongest(&lines, step + 1, most).or(best);
        }
    }
    best
}

/// Lines of twice the width, 2^step before.
#[inline(never)]
fn doubled(lines: &Lines, step: u32) -> Lines {
    let half = 1usize << step;
    let mut next: Lines = [[0; ROWS]; SIDE];
    for (index, sums) in next.iter_mut().enumerate() {
        let (strip, rise) = (index >> (step + 1), index & (2 * half - 1));
        let first = lines.get(2 * strip * half + rise / 2);
        let second = lines.get((2 * strip + 1) * half + rise / 2);
        if let (Some(first), Some(second)) = (first, second) {
            *sums = *first;
            let later = second.get(rise.div_ceil(2)..).unwrap_or(&[]);
            for (sum, later) in sums.iter_mut().zip(later) {
                *sum = sum.wrapping_add(*later);
            }
        }
    }
    next
}

/// Bins of the block on a line `width` wide that begins at `row` (16: the first of the block) and rises by `rise`.
fn bins_on(width: usize, row: usize, rise: usize) -> usize {
    let (from, to) = (row.max(SIDE), (row + rise).min(2 * SIDE - 1));
    (width * (to + 1).saturating_sub(from)).checked_div(rise + 1).unwrap_or(0)
}

/// How far a line rises from the noise, sixteenths of a sigma; 0 of lines that are too short.
fn strength(lines: &Lines, (steps, index, row): (u32, usize, usize)) -> i32 {
    let width = 1usize << steps;
    let sum = lines.get(index).and_then(|line| line.get(row)).copied().unwrap_or(0);
    let count = bins_on(width, row, index & (width - 1));
    if count < FEWEST_BINS {
        return 0;
    }
    (i32::from(sum) * PER_ROOT.get(count).copied().unwrap_or(0)) >> 10
}

/// The strongest line of a transform, if it is stronger than `most` and stands alone.
#[inline(never)]
fn strongest(lines: &Lines, steps: u32, most: i32) -> Option<Line> {
    let width = 1usize << steps;
    let mut best: Option<(usize, usize)> = None;
    let mut most = most.max(THRESHOLD_SIGMAS - 1);
    for (index, line) in lines.iter().enumerate() {
        for (row, sum) in line.iter().enumerate() {
            // Of the fewest bins a line must have this sum, of more a greater one.
            if i32::from(*sum) * 1024 > most * PER_ROOT_FEWEST {
                let strength = strength(lines, (steps, index, row));
                if strength > most {
                    (most, best) = (strength, Some((index, row)));
                }
            }
        }
    }
    let (index, row) = best?;
    let dark = |row: usize| 2 * strength(lines, (steps, index, row)) < most;
    let alone = dark(row + BESIDE) && row.checked_sub(BESIDE).is_none_or(dark);
    // The part inside the block.
    let (strip, rise) = (index >> steps, index & (width - 1));
    let last = (width - 1) as f32;
    let place = |column: f32| {
        [(strip * width) as f32 + column, row as f32 - SIDE as f32 + column * rise as f32 / last]
    };
    let column = |bins: f32| if rise > 0 { bins * last / rise as f32 } else { 0.0 };
    let from = column(SIDE as f32 - row as f32).max(0.0);
    let to = if rise > 0 { column((2 * SIDE - 1) as f32 - row as f32).min(last) } else { last };
    alone.then_some(Line { strength: most, from: place(from), to: place(to) })
}

/// The strongest line of a block among those of all directions.
#[inline(never)]
fn best_line(bins: &Bins) -> Option<Line> {
    let flip = |[x, y]: [f32; 2]| [x, (SIDE - 1) as f32 - y];
    let turn = |[x, y]: [f32; 2]| [y, x];
    let mut best: Option<Line> = None;
    for family in 0..4 {
        // Families 2 and 3 with columns for rows, 1 and 3 upside down.
        let mut seen = [[0; SIDE]; SIDE];
        for (y, row) in seen.iter_mut().enumerate() {
            let y = if family & 1 == 1 { SIDE - 1 - y } else { y };
            for (x, bin) in row.iter_mut().enumerate() {
                let [x, y] = if family & 2 == 2 { [y, x] } else { [x, y] };
                *bin = bins.get(y).and_then(|row| row.get(x)).copied().unwrap_or(0);
            }
        }
        let Some(line) = strongest_rising(&seen) else { continue };
        if best.is_none_or(|best| line.strength > best.strength) {
            let [from, to] = [line.from, line.to].map(|end| match family {
                0 => end,
                1 => flip(end),
                2 => turn(end),
                _ => turn(flip(end)),
            });
            best = Some(Line { from, to, ..line });
        }
    }
    best
}

/// Adds a piece in its place; of too many the weakest is dropped.
fn keep(pieces: &mut Pieces, piece: Piece) {
    if pieces.is_full() && pieces.last().is_some_and(|last| last.strength < piece.strength) {
        let _ = pieces.pop();
    }
    if pieces.push(piece).is_ok() {
        crate::order::settle_last(pieces, |a, b| a.strength > b.strength);
    }
}

/// Searches the whole image.
///
/// # Errors
/// Of the detector, at the first window that fails.
#[inline(never)]
pub fn search(
    detector: &mut impl Detector,
    buffer: &mut [u16; TILE_PIXELS],
    pieces: &mut Pieces,
) -> Result<(), DetectorError> {
    pieces.clear();
    let geometry = detector.geometry();
    let starts = |length: u16| {
        let count = u32::from(length.div_ceil(BLOCK_PX));
        let last = u32::from(length.saturating_sub(BLOCK_PX));
        (0..count).map(move |index| (index * last).checked_div(count - 1).unwrap_or(0) as u16)
    };
    if geometry.width_px < BLOCK_PX || geometry.height_px < BLOCK_PX {
        return Ok(());
    }
    let mut usual = 0;
    for y in starts(geometry.height_px) {
        for x in starts(geometry.width_px) {
            let window = Window { x, y, width: BLOCK_PX, height: BLOCK_PX };
            let pixels = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
            detector.read(window, pixels)?;
            let Some((bins, scatter)) = bins_of(pixels, geometry.bits, &mut usual) else { continue };
            let Some(line) = best_line(&bins) else { continue };
            let strength = (line.strength as f32 / scatter) as i32;
            if strength < THRESHOLD_SIGMAS {
                continue;
            }
            let [from, to] = [line.from, line.to].map(|[column, row]| {
                let px = |bin: f32| bin * BIN as f32 + 0.5 * (BIN - 1) as f32;
                [f32::from(x) + px(column), f32::from(y) + px(row)]
            });
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::sqrtf(dx * dx + dy * dy);
            if length > 1.0 {
                let at_px = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
                keep(pieces, Piece { at_px, along: [dx / length, dy / length], strength });
            }
        }
    }
    Ok(())
}
