//! Finds pieces of lines in the whole image: a fast discrete Radon transform of binned blocks.
//!
//! In: a detector whose image is exposed, and the readout buffer. Out: the strongest [`MAX_PIECES`] pieces,
//! the strongest first, at most one a block of [`BLOCK_PX`] px.
//!
//! A block becomes 16 x 16 sums of 4 x 4 px, each in units of the block's own noise above its own median, cut
//! at `CLIP`, 3 sigmas: a hot pixel or a hit lifts a line by a sigma, no more. The scatter of what remains is
//! the unit. Brady's recursion (A fast discrete approximation algorithm for the Radon transform, SIAM J.
//! Comput. 27, 1998) then sums all lines of 64 directions, and those of half a block's width: lines of 2^k
//! columns that rise by t are two of half the length that rise by t / 2. Lines that rise and lines that fall
//! are summed at once, in the halves of a word. A line counts if it rises `THRESHOLD_SIGMAS` above the noise,
//! and the parallel lines 20 px to either side do not: a limb is an edge, not a line. Blocks that are bright
//! or noisy in many places are left, and lines before a sky that is brighter than the darkest: they are the
//! Earth's clouds.
//!
//! What is seen: 4.5 sigma of 64 px with 0.6 of the light in the line of bins, 870 electrons at V = 3 and 1
//! deg/s shared out with the rate: V = 5.6 at 1 deg/s (if the streak were that long; one of 21 px reaches
//! 4.4), 4.5 at 4, 3.5 at 10 and 3.1 at 15 deg/s in every block, and half a magnitude fainter in one of the
//! several blocks of a long streak. A matched filter of the whole streak would reach V = 4.3 at 15 deg/s, the
//! sums of 3 x 3 px of a star scan reach 1.8.

use super::{Piece, scaled};
use crate::image::FULL_SCALE;
use crate::image::scan::TILE_PIXELS;
use crate::image::smear::SAME_SKY;
use fsw_hal::{Detector, DetectorError, Window};
use fsw_pixels::radon::{BIN, Bins, CLIP, SIDE, SIGMA, THRESHOLD_SIGMAS, best_line, bin_sums};
use heapless::Vec;

/// Side of a block, px.
pub const BLOCK_PX: u16 = 64;
/// Most pieces kept.
pub const MAX_PIECES: usize = 48;
/// The pieces of an image.
pub type Pieces = Vec<Piece, MAX_PIECES>;
/// Most bins of a block above two sigmas.
const MOST_BRIGHT: usize = 72;
/// What is so many times as noisy as blocks usually are shows an object.
const NOISY: i32 = 4;

/// Median, and sigma by the spread of the middle half, of some values.
fn median_and_sigma(values: &mut [i32]) -> (i32, i32) {
    crate::order::sort_numbers(values);
    let at = |quarter: usize| values.get(quarter * values.len() / 4).copied().unwrap_or(0);
    (at(2), (at(3) - at(1)) * 3 / 4)
}

/// The block's bins in units of its noise, their scatter, and its level; `None` where it shows an object. `usual` is the noise of a bin in
/// the blocks so far, sixteenths, 0 before the first: the spread of a few bins may come out too small by
/// chance, and then everything seems to rise.
#[inline(never)]
fn bins_of(pixels: &[u16], bits: u8, usual: &mut i32) -> Option<(Bins, f32, i32)> {
    let sums = bin_sums(pixels);
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
    if sigma > NOISY * usual || level > FULL_SCALE / 2 {
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
    (bright <= MOST_BRIGHT).then_some((bins, scatter.max(1.0), level))
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
    detector: &mut impl Detector<Error = DetectorError>,
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
    let (mut usual, mut darkest) = (0, FULL_SCALE);
    for y in starts(geometry.height_px) {
        for x in starts(geometry.width_px) {
            let window = Window { x, y, width: BLOCK_PX, height: BLOCK_PX };
            let pixels = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
            detector.read(window, pixels)?;
            let Some((bins, scatter, background)) = bins_of(pixels, geometry.bits, &mut usual) else {
                continue;
            };
            darkest = darkest.min(background);
            let Some(line) = best_line(&bins) else { continue };
            let strength = (line.strength as f32 / scatter) as i32;
            if strength < THRESHOLD_SIGMAS || background > darkest + SAME_SKY {
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
                keep(pieces, Piece { at_px, along: [dx / length, dy / length], strength, background });
            }
        }
    }
    // Those kept before the darkest block was read, too.
    pieces.retain(|piece| piece.background <= darkest + SAME_SKY);
    Ok(())
}
