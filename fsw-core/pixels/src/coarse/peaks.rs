//! The places of a tile at which a star may stand.
//!
//! In: a tile above its background, thresholds of its cells. Out: places whose 3 x 3 sum is a local maximum
//! above its threshold.
//!
//! 1. Gate. The greatest sums of 2 x 2 pixels of half a segment, kept from the same reading, bound its sums
//!    over 2 x 4 pixels (boxes two pixels apart in both directions), which are held against a part of the
//!    threshold, `GATE_128THS`. A Gaussian star of 0.5 to 1.5 px sigma leaves in the best of these boxes,
//!    wherever it stands, 0.70 of its greatest 3 x 3 sum or more.
//! 2. Look. Of a box that passes, the eight 3 x 3 sums centred in it; the greatest is held against its
//!    neighbours, then against the threshold, above a level to which the segments that a star there shines on
//!    do not count.

use super::{
    ALL_PAIRS, BAND, BANDS, BOTH, CoarseCells, CoarseTile, EDGE, PAIRS, SEGMENT, SEGMENTS, half_sums,
    median7, word,
};

/// Share of its threshold that a box must exceed for its 3 x 3 sums to be looked at, 128ths: 0.6.
const GATE_128THS: i32 = 77;
/// What a box that is looked at costs, cycles of the Cortex-M4 model: measured 500 to 600.
pub const BOX_CYCLES: u32 = 600;
/// What half a segment in which a star stands costs at the mean.
const HALF_CYCLES: u32 = 3_500;
/// Where more halves pass than can be paid for those are looked at first that pass a gate doubled so often at
/// most.
const MOST_DOUBLINGS: u32 = 6;
/// What a sum compared with its neighbours and with the level beside it costs: measured 2,000 at most.
pub const MAXIMUM_CYCLES: u32 = 2_200;
/// The greatest number in half a word that has a sign.
const MOST: i32 = 0x7FFF;
/// The signs of both halves.
const SIGNS: u32 = 0x8000 * BOTH;

/// A local maximum.
#[derive(Clone, Copy, Debug, Default)]
pub struct Peak {
    /// Column and row in the tile.
    pub at: [u16; 2],
    /// By how much its 3 x 3 sum exceeds its threshold, scaled counts.
    pub excess: i32,
}

/// What came of a search for peaks.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Peaks that were left.
    pub count: usize,
    /// Whether they are all there are.
    pub all: bool,
    /// What it cost.
    pub cycles: u32,
}

/// The brightest peaks so far.
struct Found<'p> {
    peaks: &'p mut [Peak],
    count: usize,
    all: bool,
    /// What may still be spent.
    cycles: u32,
}

impl Found<'_> {
    /// Pays for a step; where that cannot be paid not all is found.
    fn pay(&mut self, cycles: u32) -> bool {
        let left = self.cycles.checked_sub(cycles);
        self.cycles = left.unwrap_or(self.cycles);
        self.all &= left.is_some();
        left.is_some()
    }

    /// Keeps a peak, once; in place of the faintest when full.
    fn insert(&mut self, peak: Peak) {
        let kept = self.peaks.get_mut(..self.count).unwrap_or(&mut []);
        if kept.iter().any(|other| other.at == peak.at) {
            return;
        }
        if let Some(slot) = self.peaks.get_mut(self.count) {
            *slot = peak;
            self.count += 1;
            return;
        }
        self.all = false;
        if let Some(faintest) = self.peaks.iter_mut().min_by_key(|kept| kept.excess)
            && faintest.excess < peak.excess
        {
            *faintest = peak;
        }
    }
}

impl CoarseTile<'_> {
    /// Leaves in `peaks` the places of the local maxima of the 3 x 3 sums that exceed their cells'
    /// thresholds, none within [`EDGE`] of the sides; of more than there is room for the brightest. As many
    /// boxes are looked at as `cycles` pay for, the brightest first in a crowd.
    #[inline(never)]
    pub fn peaks(&self, thresholds: &CoarseCells<i32>, cycles: u32, peaks: &mut [Peak]) -> Search {
        let mut found = Found { peaks, count: 0, all: true, cycles };
        let gates = self.gates(thresholds, 0);
        let all = self.passing(&gates);
        let mut brightest = all;
        for doublings in 1..=MOST_DOUBLINGS {
            if brightest.iter().fold(0, |count, bits| count + bits.count_ones()) * HALF_CYCLES <= cycles {
                break;
            }
            brightest = self.passing(&self.gates(thresholds, doublings));
        }
        for others in [false, true] {
            for (pair, (all, brightest)) in all.iter().zip(&brightest).enumerate() {
                let mut passed = if others { all & !brightest } else { *brightest };
                while passed != 0 {
                    let half = passed.trailing_zeros() as usize;
                    passed &= passed - 1;
                    let half = 2 * (half % 16) + half / 16;
                    self.look_at_half([half, pair], &gates, thresholds, &mut found);
                }
            }
        }
        Search { count: found.count, all: found.all, cycles: cycles - found.cycles }
    }

    /// What the boxes of each cell must exceed, above the levels of their rows, for their 3 x 3 sums to be
    /// looked at, where that part of the threshold is so many times doubled.
    #[inline(never)]
    fn gates(&self, thresholds: &CoarseCells<i32>, doublings: u32) -> CoarseCells<i32> {
        let mut gates = [[0; SEGMENTS]; BANDS];
        let cells = self.cells.as_flattened().iter().zip(thresholds.as_flattened());
        for (gate, (cell, threshold)) in gates.as_flattened_mut().iter_mut().zip(cells) {
            *gate = ((((threshold >> self.shift) * GATE_128THS) >> 7) << doublings) + ((2 * cell) >> 3);
        }
        gates
    }

    /// By how much boxes that begin with a pair of rows may exceed the gates of their cells for their rows'
    /// sake.
    fn rows_level(&self, pair: usize) -> i32 {
        let level = |pair: usize| self.pairs.get(pair).copied().unwrap_or(0);
        (level(pair) + level(pair + 1)) >> 3
    }

    /// Tells of each pair of rows and the next in which segments a box of 2 x 4 px may exceed its limit: a bit
    /// for each in whose left half it may, and 16 bits up for each in whose right half.
    #[inline(never)]
    fn passing(&self, gates: &CoarseCells<i32>) -> [u32; ALL_PAIRS] {
        let mut passing = [0; ALL_PAIRS];
        let boxes = self.boxes.array_windows().take(self.height / 2 - 1);
        for (pair, (passing, [above, below])) in passing.iter_mut().zip(boxes).enumerate() {
            let rows = self.rows_level(pair);
            let gates = gates.get(pair / PAIRS).into_iter().flatten();
            for (segment, ((above, below), gate)) in above.iter().zip(below).zip(gates).enumerate() {
                // A half that exceeds the limit takes its sign away.
                let limit = (gate + rows).clamp(0, MOST) as u32;
                let kept = (SIGNS | (limit * BOTH)).wrapping_sub(above.wrapping_add(*below));
                *passing |= (!kept & SIGNS) >> 15 << segment;
            }
        }
        passing
    }

    /// Looks at the boxes of half a segment that begin with a pair of rows and exceed their limit.
    #[inline(never)]
    fn look_at_half(
        &self,
        [half, pair]: [usize; 2],
        gates: &CoarseCells<i32>,
        thresholds: &CoarseCells<i32>,
        found: &mut Found,
    ) {
        let gate = gates.get(pair / PAIRS).and_then(|gates| gates.get(half / 2)).copied().unwrap_or(MOST);
        let limit = gate + self.rows_level(pair);
        let of_row = |row: usize| self.row(2 * pair + row).as_chunks::<{ SEGMENT / 2 }>().0.get(half);
        let [Some(a), Some(b), Some(c), Some(d)] = [0, 1, 2, 3].map(of_row) else { return };
        let [a, b, c, d] = [a, b, c, d].map(|row| row.as_chunks::<2>().0);
        for (index, (((a, b), c), d)) in a.iter().zip(b).zip(c).zip(d).enumerate() {
            let columns = [b, c, d].into_iter().fold(word(*a), |sum, row| sum.wrapping_add(word(*row)));
            // Both together, in the upper half.
            if (columns.wrapping_add(columns << 16) >> 16) as i32 <= limit {
                continue;
            }
            if !found.pay(BOX_CYCLES) {
                return;
            }
            let place = self.look([half * (SEGMENT / 2) + 2 * index, 2 * pair], thresholds);
            if let Some((at, sum, threshold)) = place
                && found.pay(MAXIMUM_CYCLES)
                && let Some(peak) = self.peak(at, sum, threshold)
            {
                found.insert(peak);
            }
        }
    }

    /// The place of the greatest 3 x 3 sum centred in a box, the sum and the threshold, where it may exceed
    /// that.
    #[inline(never)]
    fn look(&self, [x, y]: [usize; 2], thresholds: &CoarseCells<i32>) -> Option<([usize; 2], i32, i32)> {
        let (left, top) = (x.checked_sub(1)?, y.checked_sub(1)?);
        let mut rows = [[0i32; 2]; 6];
        for (sums, y) in rows.iter_mut().zip(top..) {
            let [a, b, c, d] = self.row(y).get(left..)?.first_chunk::<4>()?.map(i32::from);
            *sums = [a + b + c, b + c + d];
        }
        let mut greatest = (0, [0; 2]);
        for (([above, here], below), y) in rows.array_windows::<3>().map(|[a, b, c]| ([a, b], c)).zip(y..) {
            for (((above, here), below), x) in above.iter().zip(here).zip(below).zip(x..) {
                let sum = above + here + below;
                if sum > greatest.0 {
                    greatest = (sum, [x, y]);
                }
            }
        }
        let (sum, [x, y]) = greatest;
        let inside = |at: usize, length: usize| (EDGE..length - EDGE).contains(&at);
        if !inside(x, self.width) || !inside(y, self.height) {
            return None;
        }
        let of_cell =
            |cells: &CoarseCells<i32>| cells.get(y / BAND).and_then(|cells| cells.get(x / SEGMENT)).copied();
        let (cell, threshold) = of_cell(&self.cells).zip(of_cell(thresholds))?;
        // A star's own light draws the level of its cell by up to an eighth of the threshold.
        (self.above([x, y], sum, cell) >= threshold - threshold / 8).then_some(([x, y], sum, threshold))
    }

    /// A 3 x 3 sum above the level of its rows and a cell, scaled counts.
    fn above(&self, [_, y]: [usize; 2], sum: i32, cell: i32) -> i32 {
        let pair = |y: usize| self.pairs.get(y / 2).copied().unwrap_or(0);
        let rows = pair(y - 1) + pair(y) + pair(y + 1);
        (sum << self.shift) - ((9 * cell + 3 * rows) << self.shift) / 32
    }

    /// The peak at a place, if its sum is a local maximum and exceeds the threshold.
    #[inline(never)]
    fn peak(&self, at: [usize; 2], sum: i32, threshold: i32) -> Option<Peak> {
        if !self.tops(at, sum) {
            return None;
        }
        let excess = self.above(at, sum, self.level_beside(at)) - threshold;
        (excess > 0).then_some(Peak { at: at.map(|at| at as u16), excess })
    }

    /// The level of a place's cell without the three segments that a star there shines on.
    fn level_beside(&self, [x, y]: [usize; 2]) -> i32 {
        let first = y / BAND * PAIRS;
        let mut beside = [0; PAIRS];
        let clear = (first..first + PAIRS).filter(|pair| pair.abs_diff(y / 2) > 1);
        let levels = clear.map(|pair| {
            let of_row = |y: usize| self.row(y).as_chunks().0.get(x / SEGMENT).unwrap_or(&[0; SEGMENT]);
            let ([left, right], _) = half_sums(of_row(2 * pair), of_row(2 * pair + 1));
            left + right - self.pairs.get(pair).copied().unwrap_or(0)
        });
        let mut slots = beside.iter_mut();
        let mut count = 0;
        for (slot, level) in slots.by_ref().zip(levels) {
            *slot = level;
            count += 1;
        }
        // Four to six are left: some count twice.
        for index in count..PAIRS {
            let again = beside.get(index - count).copied().unwrap_or(0);
            if let Some(slot) = beside.get_mut(index) {
                *slot = again;
            }
        }
        median7(&beside)
    }

    /// Whether no 3 x 3 sum within two pixels is greater; of equal ones the first.
    fn tops(&self, [x, y]: [usize; 2], sum: i32) -> bool {
        let mut triples = [[0; 5]; 7];
        for (triples, y) in triples.iter_mut().zip(y - 3..) {
            let Some(pixels) = self.row(y).get(x - 3..).and_then(<[u16]>::first_chunk::<7>) else {
                return false;
            };
            let [a, b, c, d, e, f, g] = pixels.map(i32::from);
            *triples = [a + b + c, b + c + d, c + d + e, d + e + f, e + f + g];
        }
        let squares = triples.array_windows().flat_map(|[above, here, below]| {
            above.iter().zip(here).zip(below).map(|((above, here), below)| above + here + below)
        });
        const MIDDLE: usize = 12;
        squares.enumerate().all(|(index, other)| other < sum || other == sum && index >= MIDDLE)
    }
}
