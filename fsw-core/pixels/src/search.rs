//! Where something may rise from the background: local maxima of the sums over 3 x 3 pixels.
//!
//! In: conditioned pixels, the part of the window to search, a threshold for each cell. Out: [`Views`], the
//! rows of blocks that may hold a sum above its cell's threshold, by octave of how far it may rise; then, on
//! request, the sums of such a row.
//!
//! Nearly all of the sky is empty, so every pixel is only asked a question that many share: with `h(x, y)`
//! the sum of three neighbours in a row, a 3 x 3 sum is `h(x, y-1) + h(x, y) + h(x, y+1)`, hence at most the
//! sum of the three rows' greatest `h` in the same block of columns. Where even that stays below the
//! threshold, no pixel of the block's row is looked at again. On noise the bound lies 4 sigma below the
//! default threshold. Nothing is lost: the bound is never smaller than a sum.

use crate::condition::Residuals;
use crate::window::{BANDS, BLOCK, BLOCKS, Cells, MAX_HEIGHT};

/// Pixels next to the searched part that the sums of a 5 x 5 neighbourhood need.
pub const REACH: usize = 3;
/// Columns whose sums are looked at together: a block and two on either side.
pub const SPAN: usize = BLOCK + 4;
/// Classes of brightness in which the rows of blocks are looked at, each twice the one before.
const OCTAVES: usize = 8;

/// The lowest octave is what exceeds the threshold by less than this part of it, nearly all of it noise; the
/// highest begins at 17 thresholds.
const LEAST_EXCESS_DIVISOR: i32 = 8;

/// Which rows of blocks are to be looked at, by octave of what they may hold: a bit for each row that has
/// any, and for each row a bit a block.
#[derive(Debug)]
pub struct Views {
    rows: [u64; OCTAVES],
    blocks: [[u8; MAX_HEIGHT]; OCTAVES],
}

const _: () = assert!(BLOCKS <= u8::BITS as usize && MAX_HEIGHT <= u64::BITS as usize);

/// The numbers of the bits that are set, least first.
fn bits(mut set: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let least = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        least
    })
}

impl Views {
    /// None. They are marked where they stay: to move them costs 800 cycles.
    pub const NONE: Self = Self { rows: [0; OCTAVES], blocks: [[0; MAX_HEIGHT]; OCTAVES] };

    /// Reads the window once and marks what is to be looked at. `core` has room around it.
    #[inline(never)]
    pub fn mark_all(&mut self, window: &Residuals, core: &Searched, thresholds: &Cells<i32>) {
        let mut blocks = [Block::default(); BLOCKS];
        let blocks = blocks.get_mut(..core.columns.end.div_ceil(BLOCK)).unwrap_or(&mut []);
        let top = core.rows.start;
        let first_block = core.columns.start / BLOCK;
        // A bright star rises from its own noise; it is still the first to be looked at.
        let lowest =
            thresholds.as_flattened().iter().fold(i32::MAX, |least, threshold| least.min(*threshold));
        let least = (lowest / LEAST_EXCESS_DIVISOR).max(1) as u32;
        let mut band = BANDS;
        for y in top - 1..=core.rows.end {
            // The sums are those of the row before, whose cells they are held against.
            let band_before = window.band(y - 1);
            if band != band_before {
                band = band_before;
                let thresholds = thresholds.get(band).into_iter().flatten();
                for ((block, level), threshold) in
                    blocks.iter_mut().zip(window.cell_levels(band)).zip(thresholds)
                {
                    block.enough = threshold.saturating_add(9 * level);
                }
            }
            let level = 3 * window.row_level(y);
            next_row(window.raw_row(y), level, window.shift(), blocks, |block, excess| {
                // Those of the first two rows read are not whole.
                if y > top && block >= first_block {
                    self.mark(y - 1 - top, block, excess, least);
                }
            });
        }
    }

    /// Marks the block's row `row`, whose sums may exceed the threshold by `excess`. The octaves count from
    /// `least`.
    fn mark(&mut self, row: usize, block: usize, excess: u32, least: u32) {
        let octave = least.leading_zeros().saturating_sub(excess.leading_zeros()) as usize;
        let octave = octave.min(OCTAVES - 1);
        let blocks = self.blocks.get_mut(octave).and_then(|blocks| blocks.get_mut(row));
        if let (Some(rows), Some(blocks)) = (self.rows.get_mut(octave), blocks) {
            *rows |= 1 << row;
            *blocks |= 1 << block;
        }
    }

    /// Rows and blocks, the octave of the brightest first, in reading order within an octave.
    pub fn brightest_first(&self) -> impl Iterator<Item = (usize, usize)> {
        let octaves = self.rows.iter().zip(&self.blocks).rev();
        octaves.flat_map(|(rows, blocks)| {
            bits(*rows).flat_map(|row| {
                let of_row = blocks.get(row).copied().unwrap_or(0);
                bits(of_row.into()).map(move |block| (row, block))
            })
        })
    }
}

/// The greatest sum of three neighbours among 18 pixels. Raw values have at most 14 bits, so the sums fit.
#[inline(always)]
fn greatest_triple(pixels: &[u16; BLOCK + 2]) -> u32 {
    // Two sums at a time: a + b + c and b + c + d differ by their ends only.
    let (pairs, _) = pixels.as_chunks::<2>();
    let mut greatest = 0;
    for ([a, b], [c, d]) in pairs.iter().zip(pairs.iter().skip(1)) {
        greatest = (u32::from(*b) + u32::from(*c) + u32::from(*a.max(d))).max(greatest);
    }
    greatest
}

/// What is known of a block of columns while the rows go by.
#[derive(Clone, Copy, Default)]
struct Block {
    /// Bounds of `h` in the two rows read last, above the rows' levels.
    bounds: [i32; 2],
    /// A sum of three bounds must exceed this for the middle row to be looked at: its cell's threshold and
    /// background.
    enough: i32,
}

/// Takes in the next row and calls `exceeds` with the blocks whose row before it may hold a peak, and by how
/// much. `level` is three times the row's, scaled counts.
#[inline(always)]
fn next_row(row: &[u16], level: i32, shift: u32, blocks: &mut [Block], mut exceeds: impl FnMut(usize, u32)) {
    let last = row.len().saturating_sub(BLOCK + 2);
    let mut start = 0usize;
    for (index, block) in blocks.iter_mut().enumerate() {
        // At the window's edges the nearest 18 pixels within it serve.
        let pixels = row.get(start.saturating_sub(1).min(last)..).and_then(<[u16]>::first_chunk);
        let greatest = pixels.map_or(i32::from(u16::MAX), |pixels| greatest_triple(pixels) as i32);
        let bound = (greatest << shift) - level;
        let [above, here] = block.bounds;
        // Wraps only where raw values have more bits than they should.
        let sum = above.wrapping_add(here).wrapping_add(bound);
        if sum > block.enough {
            exceeds(index, sum.wrapping_sub(block.enough) as u32);
        }
        block.bounds = [here, bound];
        start += BLOCK;
    }
}

/// The sums over 3 x 3 pixels centred at `sums.len()` places from (x, y) to the right.
fn sums9<const COLUMNS: usize, const SUMS: usize>(window: &Residuals, x: usize, y: usize) -> [i32; SUMS] {
    const { assert!(COLUMNS == SUMS + 2) };
    let columns = window.column_sums::<COLUMNS>(x - 1, y);
    let mut sums = [0i32; SUMS];
    let shifted = columns.iter().zip(columns.iter().skip(1)).zip(columns.iter().skip(2));
    for (sum, ((a, b), c)) in sums.iter_mut().zip(shifted) {
        *sum = a.wrapping_add(*b).wrapping_add(*c);
    }
    sums
}

/// The part of a window in which peaks are looked for, counted from its first pixel.
#[derive(Clone, Debug)]
pub struct Searched {
    /// Columns.
    pub columns: core::ops::Range<usize>,
    /// Rows.
    pub rows: core::ops::Range<usize>,
    /// What a sum outside must exceed one inside by to be the greater. The neighbouring tile sees the same
    /// pixels above slightly other levels: without this each of two tiles could leave a star on their seam to
    /// the other.
    pub tolerance: i32,
}

impl Searched {
    /// The 3 x 3 sums above the rows' levels centred at `SUMS` places from (x, y) to the right, those outside
    /// less the tolerance.
    #[inline(always)]
    fn sums<const COLUMNS: usize, const SUMS: usize>(
        &self,
        window: &Residuals,
        x: usize,
        y: usize,
    ) -> [i32; SUMS] {
        let mut sums = sums9::<COLUMNS, SUMS>(window, x, y);
        let outside = |sums: &mut [i32]| {
            sums.iter_mut().for_each(|sum| *sum = sum.saturating_sub(self.tolerance));
        };
        let [first, end] = [self.columns.start, self.columns.end].map(|at| at.saturating_sub(x).min(SUMS));
        if !self.rows.contains(&y) {
            outside(&mut sums);
        } else {
            outside(sums.get_mut(..first).unwrap_or(&mut []));
            outside(sums.get_mut(end..).unwrap_or(&mut []));
        }
        sums
    }

    /// The sums centred at the places of a block's row, two more on either side, from `x` on.
    #[inline]
    pub fn block_sums(&self, window: &Residuals, x: usize, y: usize) -> [i32; SPAN] {
        self.sums::<{ SPAN + 2 }, SPAN>(window, x, y)
    }

    /// Whether no sum of the two rows above and below and within two columns is larger; an equal one above is
    /// first.
    #[inline]
    pub fn tops_its_rows(&self, window: &Residuals, x: usize, y: usize, sum: i32) -> bool {
        let row = |y: usize| self.sums::<7, 5>(window, x - 2, y);
        row(y - 1).iter().all(|other| *other < sum)
            && row(y + 1).iter().all(|other| *other <= sum)
            && row(y - 2).iter().all(|other| *other < sum)
            && row(y + 2).iter().all(|other| *other <= sum)
    }
}
