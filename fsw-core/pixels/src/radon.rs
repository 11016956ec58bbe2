//! Sums along all lines of a block of bins: Brady's fast discrete Radon transform (A fast discrete
//! approximation algorithm for the Radon transform, SIAM J. Comput. 27, 1998).
//!
//! In: 16 x 16 bins in units of their noise. Out: the strongest [`Line`]. The recursion sums all lines of 64
//! directions, and those of half a block's width: lines of 2^k columns that rise by t are two of half the
//! length that rise by t / 2. Lines that rise and lines that fall are summed at once, in the halves of a
//! word.

use core::cell::Cell;

/// Side of a bin, px.
pub const BIN: usize = 4;
/// Bins along a block's side; the transform needs a power of two.
pub const SIDE: usize = 16;
const STEPS: u32 = SIDE.ilog2();
/// Rows in which a line may begin: those of the block and as many above it.
const ROWS: usize = 2 * SIDE;
/// A sigma of a bin in the transform's units.
pub const SIGMA: i32 = 16;
/// A bin counts for so many sigmas at most.
pub const CLIP: i32 = 3 * SIGMA;
/// A line must rise so many sixteenths of a sigma above the noise: 4.25 sigma. Of 100,000 independent lines
/// of an image one does so by chance.
pub const THRESHOLD_SIGMAS: i32 = 68;
/// Fewest bins of a line.
const FEWEST_BINS: usize = 6;
/// Rows, in bins, from a line to those that must be dark.
const BESIDE: usize = 5;
/// 1024 times the root of [`FEWEST_BINS`].
const PER_ROOT_FEWEST: i32 = 2508;
/// 1024 over the root of the number.
const PER_ROOT: [i32; SIDE + 1] =
    [0, 1024, 724, 591, 512, 458, 418, 387, 362, 341, 324, 309, 296, 284, 274, 264, 256];

/// Bins of a block in units of their noise, by row and column.
pub type Bins = [[i16; SIDE]; SIDE];
/// Lines by strip, rise ([`rise_of`]) and row of their beginning + 16: the sum along the line that rises, and
/// 2^16 times that of its mirror image in a block upside down.
type Lines = [[u32; ROWS]; SIDE];

/// A line of a block: how strong, where it begins and ends, bins.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// How far its sum rises from the noise, sixteenths of a sigma.
    pub strength: i32,
    /// Where it begins: column and row, bins.
    pub from: [f32; 2],
    /// Where it ends.
    pub to: [f32; 2],
}

/// Sums of [`BIN`] x [`BIN`] px of a block's raw pixels.
#[inline(never)]
pub fn bin_sums(pixels: &[u16]) -> [[i32; SIDE]; SIDE] {
    let mut sums = [[0i32; SIDE]; SIDE];
    for (sums, rows) in sums.iter_mut().zip(pixels.chunks_exact(SIDE * BIN * BIN)) {
        for row in rows.chunks_exact(SIDE * BIN) {
            for (sum, four) in sums.iter_mut().zip(row.as_chunks::<BIN>().0) {
                *sum += four.iter().fold(0, |sum, raw| sum + i32::from(*raw));
            }
        }
    }
    sums
}

/// The strongest line of a block, of half its width or all of it, that rises by 0 to 15 rows, and the
/// strongest that falls.
#[inline(never)]
fn strongest_of_both(bins: &Bins) -> [Option<Line>; 2] {
    // At first a strip is a column.
    let mut lines: Lines = [[0; ROWS]; SIDE];
    for (column, line) in lines.iter_mut().enumerate() {
        for (row, slot) in line.iter_mut().skip(SIDE).enumerate() {
            let bin = |row: usize| {
                let bin = bins.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0);
                i32::from(bin) as u32
            };
            *slot = bin(row).wrapping_add(bin(SIDE - 1 - row) << 16);
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

/// Lines of twice the width, 2^step before, in place: those of two strips that rise by t become those of both
/// together that rise by 2 t and 2 t + 1.
#[inline(never)]
fn double(lines: &mut Lines, step: u32) {
    let half = 1usize << step;
    let first = first_row(2 * half);
    let mut rest = &mut lines[..];
    for _ in 0..SIDE / 2 {
        // Without a panic path, which chunks of a length that is no constant would have.
        let Some((strips, others)) = core::mem::take(&mut rest).split_at_mut_checked(2 * half) else {
            return;
        };
        rest = others;
        let Some((left, right)) = strips.split_at_mut_checked(half) else { return };
        for (index, (left, right)) in left.iter_mut().zip(right).enumerate() {
            let rise = rise_of(index, step);
            let right = Cell::from_mut(&mut right[..]).as_slice_of_cells();
            let later = right.get(first + rise + 1..).unwrap_or(&[]);
            let mut near = right.get(first + rise).map_or(0, Cell::get);
            let left = left.get_mut(first..).unwrap_or(&mut []);
            let right = right.get(first..).unwrap_or(&[]);
            for ((left, right), later) in left.iter_mut().zip(right).zip(later) {
                let (sum, far) = (*left, later.get());
                (*left, near) = (sum.wrapping_add(near), far);
                right.set(sum.wrapping_add(far));
            }
            // Below the block there is nothing.
            for (left, right) in left.iter_mut().zip(right).skip(later.len()) {
                let sum = *left;
                (*left, near) = (sum.wrapping_add(near), 0);
                right.set(sum);
            }
        }
    }
}

/// The first row in which a line so wide may begin and still touch the block.
fn first_row(width: usize) -> usize {
    (SIDE + 1).saturating_sub(width)
}

/// By how many rows the line at a place within its strip of 2^steps rises: the bits of the place the other
/// way round.
fn rise_of(index: usize, steps: u32) -> usize {
    (index << (usize::BITS - 1 - steps)).reverse_bits() >> 1 & ((1 << steps) - 1)
}

/// Bins of the block on a line `width` wide that begins at `row` (16: the first of the block) and rises by
/// `rise`.
fn bins_on(width: usize, row: usize, rise: usize) -> usize {
    let (from, to) = (row.max(SIDE), (row + rise).min(2 * SIDE - 1));
    (width * (to + 1).saturating_sub(from)).checked_div(rise + 1).unwrap_or(0)
}

/// How far a line rises from the noise, sixteenths of a sigma; 0 of lines that are too short. `half` says
/// which.
fn strength(lines: &Lines, half: usize, (steps, index, row): (u32, usize, usize)) -> i32 {
    let width = 1usize << steps;
    let word = lines.get(index).and_then(|line| line.get(row)).copied().unwrap_or(0);
    let count = bins_on(width, row, rise_of(index & (width - 1), steps));
    if count < FEWEST_BINS {
        return 0;
    }
    let rising = word as i16;
    let sum = if half == 0 { rising } else { (word.wrapping_sub(i32::from(rising) as u32) >> 16) as i16 };
    (i32::from(sum) * PER_ROOT.get(count).copied().unwrap_or(0)) >> 10
}

/// Puts the strongest lines of a transform in place of weaker ones, if they stand alone.
#[inline(never)]
fn strongest(lines: &Lines, steps: u32, best: &mut [Option<Line>; 2]) {
    const SIGNS: u32 = 0x8000_8000;
    let width = 1usize << steps;
    let mut most = best.map(|line| line.map_or(THRESHOLD_SIGMAS - 1, |line| line.strength));
    let mut found = [None; 2];
    // A line of the fewest bins must have a greater sum than this, one of more bins a still greater: what is
    // added makes such a half negative.
    let least = |most: i32| 0x7fff - ((most * PER_ROOT_FEWEST) >> 10) as u32;
    let mut added = least(most[0]) | least(most[1]) << 16;
    for (index, line) in lines.iter().enumerate() {
        if line.iter().fold(0, |over, word| over | word.wrapping_add(added)) & SIGNS == 0 {
            continue;
        }
        for (row, word) in line.iter().enumerate().skip(first_row(width)) {
            if word.wrapping_add(added) & SIGNS == 0 {
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

/// Columns for rows.
fn transposed(bins: &Bins) -> Bins {
    let at = |row: usize, column: usize| bins.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0);
    core::array::from_fn(|row| core::array::from_fn(|column| at(column, row)))
}

/// The strongest line of a block among those of all directions.
#[inline(never)]
pub fn best_line(bins: &Bins) -> Option<Line> {
    let flip = |[x, y]: [f32; 2]| [x, (SIDE - 1) as f32 - y];
    let turn = |[x, y]: [f32; 2]| [y, x];
    let mut best: Option<Line> = None;
    let turned = transposed(bins);
    for (steep, bins) in [(false, bins), (true, &turned)] {
        for (falls, line) in strongest_of_both(bins).into_iter().enumerate() {
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
