//! Finds pieces of lines in the whole image: a fast discrete Radon transform of binned blocks.
//!
//! In: a detector whose image is exposed, and the readout buffer. Out: the strongest [`MAX_PIECES`] pieces, the strongest
//! first, at most one a block of [`BLOCK_PX`] px.
//!
//! A block becomes 16 x 16 sums of 4 x 4 px, each in units of the block's own noise above its own median, cut at
//! `CLIP`, 3 sigmas: a hot pixel or a hit lifts a line by a sigma, no more. The scatter of what remains is the unit. Brady's
//! recursion (A fast discrete approximation algorithm for the Radon transform, SIAM J. Comput. 27, 1998) then sums all lines
//! of 64 directions, and those of half a block's width: lines of 2^k columns that rise by t are two of half the length that
//! rise by t / 2. Lines that rise and lines that fall are summed at once, in the halves of a word. A line counts if it rises
//! `THRESHOLD_SIGMAS` above the noise, and the parallel lines 20 px to either side do not: a limb is an edge, not a line.
//! Blocks that are bright or noisy in many places are left.
//!
//! What is seen: 4.5 sigma of 64 px with 0.6 of the light in the line of bins, 870 electrons at V = 3 and 1 deg/s shared
//! out with the rate: V = 5.6 at 1 deg/s (if the streak were that long; one of 21 px reaches 4.4), 4.5 at 4, 3.5 at
//! 10 and 3.1 at 15 deg/s in every block, and half a magnitude fainter in one of the several blocks of a long streak. A
//! matched filter of the whole streak would reach V = 4.3 at 15 deg/s, the sums of 3 x 3 px of a star scan reach 1.8.

use super::{Piece, scaled};
use crate::image::scan::TILE_PIXELS;
use core::cell::Cell;
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
/// A line must rise so many sixteenths of a sigma above the noise: 4.25 sigma. Of 100,000 independent lines of an image one
/// does so by chance.
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
/// Lines by strip, rise ([`rise_of`]) and row of their beginning + 16: in the lower half of a word the sum along the line that
/// rises, in the upper half that of its mirror image in a block upside down. A bin adds its value + [`CLIP`], one outside the
/// block `CLIP`, so that no half is ever negative and none carries into the other.
type Lines = [[u32; ROWS]; SIDE];
/// One in both halves.
const BOTH: u32 = 0x1_0001;

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
/// far, sixteenths, 0 before the first: the spread of a few bins may come out too small by chance, and then everything seems
/// to rise.
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

/// The strongest line of a block, of half its width or all of it, that rises by 0 to 15 rows, and the strongest that falls;
/// `steep`: with columns for rows.
#[inline(never)]
fn strongest_of_both(bins: &Bins, steep: bool) -> [Option<Line>; 2] {
    const NOTHING: u32 = CLIP as u32 * BOTH;
    // At first a strip is a column.
    let mut lines: Lines = [[NOTHING; ROWS]; SIDE];
    for (column, line) in lines.iter_mut().enumerate() {
        for (row, slot) in line.iter_mut().skip(SIDE).enumerate() {
            let half = |row: usize| {
                let (x, y) = if steep { (row, column) } else { (column, row) };
                let bin = bins.get(y).and_then(|row| row.get(x)).copied().unwrap_or(0);
                (i32::from(bin) + CLIP) as u32
            };
            *slot = half(row) | half(SIDE - 1 - row) << 16;
        }
    }
    let mut best = [None; 2];
    for step in 0..STEPS {
        double(&mut lines, step);
        if step + 2 >= STEPS {
            strongest(&lines, step + 1, &mut best);
        }
    }
    best
}

/// Lines of twice the width, 2^step before, in place: those of two strips that rise by t become those of both together that
/// rise by 2 t and 2 t + 1.
#[inline(never)]
fn double(lines: &mut Lines, step: u32) {
    let half = 1usize << step;
    let beyond = half as u32 * CLIP as u32 * BOTH;
    for strips in lines.chunks_exact_mut(2 * half) {
        let Some((left, right)) = strips.split_at_mut_checked(half) else { continue };
        for (index, (left, right)) in left.iter_mut().zip(right).enumerate() {
            let rise = rise_of(index, step);
            let right = Cell::from_mut(&mut right[..]).as_slice_of_cells();
            let later = right.get(rise + 1..).unwrap_or(&[]);
            let mut near = right.get(rise).map_or(beyond, Cell::get);
            for ((left, right), later) in left.iter_mut().zip(right).zip(later) {
                let (sum, far) = (*left, later.get());
                (*left, near) = (sum + near, far);
                right.set(sum + far);
            }
            for (left, right) in left.iter_mut().zip(right).skip(later.len()) {
                let sum = *left;
                (*left, near) = (sum + near, beyond);
                right.set(sum + beyond);
            }
        }
    }
}

/// By how many rows the line at a place within its strip of 2^steps rises: the bits of the place the other way round.
fn rise_of(index: usize, steps: u32) -> usize {
    (index << (usize::BITS - 1 - steps)).reverse_bits() >> 1 & ((1 << steps) - 1)
}

/// Bins of the block on a line `width` wide that begins at `row` (16: the first of the block) and rises by `rise`.
fn bins_on(width: usize, row: usize, rise: usize) -> usize {
    let (from, to) = (row.max(SIDE), (row + rise).min(2 * SIDE - 1));
    (width * (to + 1).saturating_sub(from)).checked_div(rise + 1).unwrap_or(0)
}

/// How far a line rises from the noise, sixteenths of a sigma; 0 of lines that are too short. `half` says which.
fn strength(lines: &Lines, half: usize, (steps, index, row): (u32, usize, usize)) -> i32 {
    let width = 1usize << steps;
    let word = lines.get(index).and_then(|line| line.get(row)).copied().unwrap_or(0);
    let count = bins_on(width, row, rise_of(index & (width - 1), steps));
    if count < FEWEST_BINS {
        return 0;
    }
    let sum = ((word >> (16 * half)) & 0xffff) as i32 - width as i32 * CLIP;
    (sum * PER_ROOT.get(count).copied().unwrap_or(0)) >> 10
}

/// Puts the strongest lines of a transform in place of weaker ones, if they stand alone.
#[inline(never)]
fn strongest(lines: &Lines, steps: u32, best: &mut [Option<Line>; 2]) {
    const SIGNS: u32 = 0x8000 * BOTH;
    let width = 1usize << steps;
    let mut most = best.map(|line| line.map_or(THRESHOLD_SIGMAS - 1, |line| line.strength));
    let mut found = [None; 2];
    // A line of the fewest bins must have a greater sum than this, one of more bins a still greater: what is added makes
    // such a half negative.
    let least = |most: i32| 0x7fff - (width as i32 * CLIP + ((most * PER_ROOT_FEWEST) >> 10)) as u32;
    let mut added = least(most[0]) | least(most[1]) << 16;
    for (index, line) in lines.iter().enumerate() {
        for (row, word) in line.iter().enumerate() {
            if (word + added) & SIGNS == 0 {
                continue;
            }
            for (half, (most, found)) in most.iter_mut().zip(&mut found).enumerate() {
                let strength = strength(lines, half, (steps, index, row));
                if strength > *most {
                    (*most, *found) = (strength, Some((index, row)));
                }
            }
            added = least(most[0]) | least(most[1]) << 16;
        }
    }
    for (half, (best, (most, found))) in best.iter_mut().zip(most.into_iter().zip(found)).enumerate() {
        let Some((index, row)) = found else { continue };
        let dark = |row: usize| 2 * strength(lines, half, (steps, index, row)) < most;
        if dark(row + BESIDE) && row.checked_sub(BESIDE).is_none_or(dark) {
            *best = Some(line_of((steps, index, row), most));
        }
    }
}

/// The part of a line inside the block.
fn line_of((steps, index, row): (u32, usize, usize), strength: i32) -> Line {
    let width = 1usize << steps;
    let (strip, rise) = (index >> steps, rise_of(index & (width - 1), steps));
    let last = (width - 1) as f32;
    let place = |column: f32| {
        [(strip * width) as f32 + column, row as f32 - SIDE as f32 + column * rise as f32 / last]
    };
    let column = |bins: f32| if rise > 0 { bins * last / rise as f32 } else { 0.0 };
    let from = column(SIDE as f32 - row as f32).max(0.0);
    let to = if rise > 0 { column((2 * SIDE - 1) as f32 - row as f32).min(last) } else { last };
    Line { strength, from: place(from), to: place(to) }
}

/// The strongest line of a block among those of all directions.
#[inline(never)]
fn best_line(bins: &Bins) -> Option<Line> {
    let flip = |[x, y]: [f32; 2]| [x, (SIDE - 1) as f32 - y];
    let turn = |[x, y]: [f32; 2]| [y, x];
    let mut best: Option<Line> = None;
    for steep in [false, true] {
        for (falls, line) in strongest_of_both(bins, steep).into_iter().enumerate() {
            let Some(line) = line.filter(|line| best.is_none_or(|best| line.strength > best.strength)) else {
                continue;
            };
            let [from, to] = [line.from, line.to].map(|end| {
                let end = if falls == 1 { flip(end) } else { end };
                if steep { turn(end) } else { end }
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
        crate::order::insert_last(pieces, |a, b| a.strength > b.strength);
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
