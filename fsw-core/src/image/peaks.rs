//! Local maxima of the sums over 3 x 3 pixels, the brightest first.
//!
//! In: conditioned pixels, the part of the window to search, a threshold for each cell. Out: the positions of
//! the pixels whose 3 x 3 sum exceeds its cell's threshold and is a local maximum in 5 x 5; of equal sums the
//! first in reading order. The sum, rather than the pixel, is what noise of single pixels and the star's
//! phase disturb least (thesis §3.1.1, step 1, where the pixel itself is compared).
//!
//! [`search`](fsw_pixels::search) marks what is to be looked at, in octaves of how far a sum may exceed the
//! threshold. It is looked at from the highest octave down as long as the allowance lasts: of a crowded
//! window the faintest is left out.
//!
//! Exact: integers, and a test compares with the plain search. Cost on the reference frame: 12 cycles a pixel
//! of the detector, of which the bounds take 11 (Cortex-M4 model, zero wait states); every further block's
//! row looked at costs up to 1,700 cycles, every maximum of a row up to 1,000 (`allowance`).

use super::allowance::{Allowance, GLANCE_CYCLES, LOOK_CYCLES, ROW_MAXIMUM_CYCLES};
use fsw_hal::Window;
use fsw_pixels::condition::Residuals;
use fsw_pixels::light::is_single_pixel;
use fsw_pixels::search::{REACH, SPAN, Searched, Views};
use fsw_pixels::window::{BLOCK, BLOCKS, Cells};

/// Calls `found` with every peak in `core` that is no single pixel, those in the brightest neighbourhood
/// first, as long as the allowance lasts; it pays for what it does and says whether to go on. Gives whether
/// all was searched. `core` counts from the window's first pixel and stays [`REACH`] inside the window.
pub fn for_each_peak(
    window: &Residuals,
    core: Window,
    thresholds: &Cells<i32>,
    allowance: &mut Allowance,
    mut found: impl FnMut(usize, usize, &mut Allowance) -> bool,
) -> bool {
    let (left, top) = (usize::from(core.x), usize::from(core.y));
    let (right, bottom) = (left + usize::from(core.width), top + usize::from(core.height));
    if left.min(top) < REACH || right + REACH > window.width() || bottom + REACH > window.height() {
        return left >= right || top >= bottom;
    }
    let searched = Searched { columns: left..right, rows: top..bottom, tolerance: window.sum_sigma };
    let (mut sums, mut place) = ([0; SPAN], [0; 2]);
    let mut views = Views::NONE;
    views.mark_all(window, &searched, thresholds);
    for (row, block) in views.brightest_first() {
        if !allowance.spend(LOOK_CYCLES) {
            return false;
        }
        let y = top + row;
        let first = left.max(block * BLOCK);
        let end = right.min((block + 1) * BLOCK);
        let band = window.band(y);
        let of_cell = |cells: Option<&[i32; BLOCKS]>| cells.and_then(|cells| cells.get(block)).copied();
        let threshold = of_cell(thresholds.get(band)).unwrap_or(i32::MAX);
        let level = 9 * of_cell(Some(window.cell_levels(band))).unwrap_or(0);
        // Near the right edge the last columns that fit: a whole span costs half of one that is cut off.
        let start = (first - 2).min(window.width().saturating_sub(SPAN + 1)).max(1);
        // In a narrow window two blocks of a row share them.
        if place != [start, y] {
            place = [start, y];
            sums = searched.block_sums(window, start, y);
        }
        for (x, around) in (first..end).zip(sums.array_windows().skip(first - 2 - start)) {
            let [second_left, first_left, sum, first_right, second_right] = *around;
            if sum - level <= threshold
                || first_left.max(second_left) >= sum
                || first_right.max(second_right) > sum
            {
                continue;
            }
            if !allowance.spend(ROW_MAXIMUM_CYCLES) {
                return false;
            }
            if !searched.tops_its_rows(window, x, y, sum) {
                continue;
            }
            if !allowance.spend(GLANCE_CYCLES) {
                return false;
            }
            if window.about(x, y).five_by_five(x, y).is_some_and(|pixels| is_single_pixel(&pixels)) {
                continue;
            }
            if !found(x, y, allowance) {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests;
