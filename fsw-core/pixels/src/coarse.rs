//! Where in a tile a star may stand: a first look at every pixel of the detector, two pixels to a word.
//!
//! In: raw pixels of a tile. Out: [`CoarseTile`], the tile's background and noise, cell by cell; then, on
//! request, the places whose 3 x 3 sum is a local maximum above a threshold ([`CoarseTile::peaks`]). What
//! stands there is decided on a window about the place, with a background of its own (`condition`).
//!
//! Two columns are summed side by side in the halves of a 32-bit word, so raw values keep at most
//! [`COARSE_BITS`] bits.
//!
//! 1. Background. Segments of 16 columns and two rows are summed; a cell is `PAIRS` segments high, a band
//!    [`SEGMENTS`] cells wide. A cell's level is the median of its segments, the level of two rows the median
//!    of what their segments exceed their cells by (one sweep of Tukey's median polish, Exploratory Data
//!    Analysis, 1977): three segments of seven may hold stars or clouds. Rows are then drawn towards a line
//!    through their band (`calm`).
//! 2. Noise. Of the seven segments of a cell the distances from the level, and those of their halves from
//!    each other: the mean of the twelve least. Cells that look alike share what the quieter half shows
//!    ([`noise`](crate::noise)).
//!
//! Error on Gaussian noise: 0.08 sigma of a pixel for a cell; the noise of a tile within 10 % (95 % of
//! tiles). Noise below half a count of [`COARSE_BITS`] is lost in rounding: of a converter of 14 bits or more
//! with as little the faintest stars are. Cost: 12 cycles a pixel of the tile without candidates (Cortex-M4
//! model, zero wait states).

mod peaks;
#[cfg(test)]
mod tests;

pub use peaks::{BOX_CYCLES, MAXIMUM_CYCLES, Peak, Search};

use crate::levels::{calm, step_across};
use crate::noise::{Scatter, cells_around, leave_stars_out, noise_of, noise_where_noisy, of_most, sigmas_of};
use crate::window::KEPT_BITS;

/// Columns of a segment and of a cell, px.
pub const SEGMENT: usize = 16;
/// Segments of a tile's row, at most.
pub const SEGMENTS: usize = 7;
/// Pairs of rows of a band of cells.
const PAIRS: usize = 7;
/// Rows of a band, px.
pub const BAND: usize = 2 * PAIRS;
/// Bands of a tile, at most.
pub const BANDS: usize = 5;
/// Widest tile, px.
pub const TILE_WIDTH: usize = SEGMENTS * SEGMENT;
/// Tallest tile, px.
pub const TILE_HEIGHT: usize = BANDS * BAND;
/// Pixels at the sides of a tile in which no peak is told: what a 5 x 5 neighbourhood of 3 x 3 sums needs.
pub const EDGE: usize = 3;
/// Resolution that is kept of a pixel: the sum of eight of them and a sign fill half a word.
pub const COARSE_BITS: u8 = 12;
/// Pairs of rows of a tile.
const ALL_PAIRS: usize = BANDS * PAIRS;
/// Mean of the twelve least of fourteen absolute Gaussian deviates of a segment to the standard deviation of
/// a 3 x 3 sum, 256ths.
const TRIMMED_TO_SIGMA: u32 = 253;
/// The sums at the sides of a cell that slopes are held to be so many sigmas.
const LEAN_SIGMAS: i32 = 5;

/// Noisy cells within two of a place that may be more than a star's: bright ones make four.
const FEW_NOISY: usize = 3;

/// A value for every cell of a tile.
pub type CoarseCells<T> = [[T; SEGMENTS]; BANDS];

/// A tile above its background.
#[derive(Clone, Copy, Debug)]
pub struct CoarseTile<'a> {
    pixels: &'a [u16],
    width: usize,
    height: usize,
    /// Raw value to scaled counts, bits to the left.
    shift: u32,
    /// Levels of the cells: of a segment's sum, raw counts.
    cells: CoarseCells<i32>,
    /// Levels of the pairs of rows, to be added.
    pairs: [i32; ALL_PAIRS],
    /// Greatest box of 2 x 2 px of each pair of rows in the halves of each segment, raw counts.
    boxes: [[u32; SEGMENTS]; ALL_PAIRS],
    /// Noise of a 3 x 3 sum in each cell, scaled counts.
    pub noise: CoarseCells<i32>,
    /// What every cell shows, stars that make it noisy not left out, scaled counts.
    shown: CoarseCells<Option<i32>>,
    /// Noise of a pixel, scaled counts.
    pub sigma: i32,
}

/// Two pixels side by side.
#[inline(always)]
fn word([left, right]: [u16; 2]) -> u32 {
    u32::from(left) | u32::from(right) << 16
}

/// One in both halves of a word.
const BOTH: u32 = 0x1_0001;
/// Sums of the left and the right half of a segment's two rows, and the greatest box of 2 x 2 px of each
/// half, the left one's in the lower half of a word.
#[inline(always)]
fn half_sums(above: &[u16; SEGMENT], below: &[u16; SEGMENT]) -> ([i32; 2], u32) {
    const HALF: usize = SEGMENT / 2;
    let half = |above: &[u16; HALF], below: &[u16; HALF]| {
        let (mut sum, mut greatest) = (0_u32, 0);
        for (above, below) in above.as_chunks().0.iter().zip(below.as_chunks().0) {
            let columns = word(*above).wrapping_add(word(*below));
            // Both together in the upper half; the lower halves of four never carry.
            let four = columns.wrapping_add(columns << 16);
            sum = sum.wrapping_add(four);
            greatest = four.max(greatest);
        }
        ((sum >> 16) as i32, greatest)
    };
    match (above.as_chunks(), below.as_chunks()) {
        (([left, right], _), ([left_below, right_below], _)) => {
            let ((left, most_left), (right, most_right)) = (half(left, left_below), half(right, right_below));
            ([left, right], most_left >> 16 | most_right & !0xFFFF)
        }
        _ => ([0; 2], 0),
    }
}

/// Median of seven.
#[inline(never)]
fn median7(values: &[i32; 7]) -> i32 {
    let [mut a, mut b, mut c, mut d, mut e, mut f, mut g] = *values;
    let order = |low: &mut i32, high: &mut i32| (*low, *high) = ((*low).min(*high), (*low).max(*high));
    // The network of N. Devillard, Fast median search (1998).
    order(&mut a, &mut f);
    order(&mut a, &mut d);
    order(&mut b, &mut g);
    order(&mut c, &mut e);
    order(&mut a, &mut b);
    order(&mut d, &mut f);
    order(&mut c, &mut g);
    order(&mut c, &mut d);
    order(&mut d, &mut g);
    order(&mut e, &mut f);
    order(&mut b, &mut e);
    order(&mut b, &mut d);
    order(&mut d, &mut e);
    d
}

/// By how much the level of a segment's sum rises along each cell of a band.
fn along(cells: &[i32; SEGMENTS], segments: usize) -> [i32; SEGMENTS] {
    let last = segments.saturating_sub(1);
    let at = |segment: usize| cells.get(segment.min(last)).copied().unwrap_or(0);
    core::array::from_fn(|segment| {
        let here = at(segment);
        step_across(segment, last, here - at(segment.saturating_sub(1)), at(segment + 1) - here)
    })
}

impl<'a> CoarseTile<'a> {
    /// Nothing. A tile is looked at where it stays: to move it costs 2,500 cycles.
    #[inline(always)]
    pub const fn none() -> Self {
        Self {
            pixels: &[],
            width: 0,
            height: 0,
            shift: 0,
            cells: [[0; SEGMENTS]; BANDS],
            pairs: [0; ALL_PAIRS],
            boxes: [[0; SEGMENTS]; ALL_PAIRS],
            noise: [[0; SEGMENTS]; BANDS],
            shown: [[None; SEGMENTS]; BANDS],
            sigma: 0,
        }
    }

    /// Makes [`Self::none`] the tile whose whole rows of `width` raw values of `bits` resolution are in
    /// `pixels`, none beyond it; values of more than [`COARSE_BITS`] bits lose their last ones in place.
    /// Whether it can be one: the width must be a multiple of a segment, the height of a band, neither larger
    /// than a tile.
    pub fn look_at(&mut self, pixels: &'a mut [u16], width: usize, bits: u8) -> bool {
        let height = pixels.len().checked_div(width).unwrap_or(0);
        let whole = width.is_multiple_of(SEGMENT) && height.is_multiple_of(BAND) && height > 0;
        if !whole || width > TILE_WIDTH || height > TILE_HEIGHT || pixels.len() != width * height {
            return false;
        }
        let bits = bits.clamp(1, 16);
        if bits > COARSE_BITS {
            let surplus = bits - COARSE_BITS;
            pixels.iter_mut().for_each(|raw| *raw >>= surplus);
        }
        (self.pixels, self.width, self.height) = (pixels, width, height);
        self.shift = u32::from(KEPT_BITS - bits.min(COARSE_BITS));
        let mut scatters = [[Scatter::default(); SEGMENTS]; BANDS];
        let mut distances = [[0; SEGMENTS]; BANDS];
        self.take_levels(&mut scatters, &mut distances);
        self.measure_noise(&scatters, &distances);
        // The median of seven segments has a variance of 1.57 / 7 of theirs, and the segment has 32 pixels.
        let noise = self.sigma as f32 / (1 << self.shift) as f32;
        let bands: [_; BANDS] = core::array::from_fn(|band| band * PAIRS..(band + 1) * PAIRS);
        calm(&mut self.pairs, bands.get(..height / BAND).unwrap_or(&[]), 7.2 * noise * noise);
        true
    }

    /// Segments of a row.
    fn segments(&self) -> usize {
        self.width / SEGMENT
    }

    /// Bands of the tile.
    fn bands(&self) -> usize {
        self.height / BAND
    }

    /// Row `y`; none outside.
    #[inline(always)]
    fn row(&self, y: usize) -> &'a [u16] {
        self.pixels.get(y * self.width..).and_then(|rest| rest.get(..self.width)).unwrap_or(&[])
    }

    /// Background: median of the segments of a cell, then of what a pair of rows exceeds its cells by. Gives
    /// how far the segments and their halves are from that, and the distances of pixels from others of their
    /// rows.
    #[inline(never)]
    fn take_levels(&mut self, scatters: &mut CoarseCells<Scatter>, pixels: &mut CoarseCells<u32>) {
        let segments = self.segments();
        let bands = self.pixels.chunks_exact((BAND * self.width).max(1));
        let (pairs, boxes) = (self.pairs.as_chunks_mut::<PAIRS>().0, self.boxes.as_chunks_mut::<PAIRS>().0);
        let mut sums = [[Sums::default(); SEGMENTS]; PAIRS];
        let levels = self.cells.iter_mut().zip(pairs.iter_mut().zip(boxes));
        for ((rows, (cells, (pairs, boxes))), (scatters, pixels)) in
            bands.zip(levels).zip(scatters.iter_mut().zip(pixels))
        {
            sum_band(rows, self.width, &mut sums, boxes, pixels);
            repeat(&mut sums, segments);
            for (segment, cell) in cells.iter_mut().enumerate() {
                let mut of_cell = [0; PAIRS];
                for (slot, sums) in of_cell.iter_mut().zip(of_segment(&sums, segment)) {
                    *slot = sums.all;
                }
                *cell = median7(&of_cell);
            }
            for (sums, level) in sums.iter().zip(pairs.iter_mut()) {
                let mut above = [0; SEGMENTS];
                for (above, (sums, cell)) in above.iter_mut().zip(sums.iter().zip(cells.iter())) {
                    *above = sums.all - cell;
                }
                *level = median7(&above);
            }
            let along = along(cells, segments);
            let of_cells = cells.iter().zip(&along).zip(scatters).take(segments);
            for (segment, ((cell, along), scatter)) in of_cells.enumerate() {
                let slope = along / 4;
                // Taken apart from where it is kept, which would be written for each segment.
                let mut of_cell = Scatter::default();
                for (sums, pair) in of_segment(&sums, segment).zip(pairs.iter()) {
                    let (step, apart) = (sums.step - slope, sums.all - cell - pair);
                    of_cell.add([step, apart].map(i32::unsigned_abs));
                }
                *scatter = of_cell;
            }
        }
    }

    /// By how much the level of a segment's sum rises down each cell of a band beyond what all cells have in
    /// common.
    fn down(&self, band: usize) -> [i32; SEGMENTS] {
        let last = self.bands().saturating_sub(1);
        let of = |band: usize| self.cells.get(band.min(last)).unwrap_or(&[0; SEGMENTS]);
        let (above, here, below) = (of(band.saturating_sub(1)), of(band), of(band + 1));
        let mut down = [0; SEGMENTS];
        for (down, ((above, here), below)) in down.iter_mut().zip(above.iter().zip(here).zip(below)) {
            *down = step_across(band, last, here - above, below - here);
        }
        let common = median7(&down);
        down.map(|down| down - common)
    }

    /// Noise of pixels and of 3 x 3 sums.
    #[inline(never)]
    fn measure_noise(&mut self, scatters: &CoarseCells<Scatter>, pixels: &CoarseCells<u32>) {
        sigmas_of(scatters, self.shift, TRIMMED_TO_SIGMA, &mut self.shown);
        let mut sigmas = self.shown;
        let most = of_most(&sigmas);
        leave_stars_out(&mut sigmas, most);
        noise_of(&sigmas, most, &mut self.noise);
        let floor = ((1 << self.shift) / 3).max(1);
        // The pixels of the cells that are as noisy as most. The mean distance of two is 1.128 sigma.
        let cells = self.noise.as_flattened().iter().zip(pixels.as_flattened());
        let alike = cells.take(self.bands() * SEGMENTS).filter(|(noise, _)| **noise == most);
        let (sum, count) = alike.fold((0, 0), |(sum, count), (_, pixel)| (sum + pixel, count + PAIRS as u32));
        self.sigma = (((sum << self.shift) * 7).checked_div(8 * count).unwrap_or(0) as i32).max(floor);
        for band in 0..self.bands() {
            let down = self.down(band);
            let (Some(noise), Some(cells)) = (self.noise.get_mut(band), self.cells.get(band)) else {
                continue;
            };
            let along = along(cells, self.width / SEGMENT);
            for (noise, (along, down)) in noise.iter_mut().zip(along.iter().zip(down)) {
                let lean = (((along.abs() + down.abs()) << self.shift) / 32 - self.sigma / 2).max(0);
                *noise = (*noise).max(3 * floor) + 9 * lean / (2 * LEAN_SIGMAS);
            }
        }
    }

    /// The values of the cells within two of that of a place.
    fn cells_around<'c, T>(
        &self,
        cells: &'c CoarseCells<T>,
        [x, y]: [usize; 2],
    ) -> impl Iterator<Item = &'c T> + use<'c, T> {
        cells_around(cells, [self.segments(), self.bands()], [x / SEGMENT, y / BAND])
    }

    /// [`noise_where_noisy`] about a place.
    pub fn noise_around(&self, at: [usize; 2], noise: i32) -> i32 {
        noise_where_noisy(self.cells_around(&self.noise, at), noise)
    }

    /// Whether some of the cells within two of that of a place show more noise than `noise`, be it of stars.
    pub fn is_noisy_around(&self, at: [usize; 2], noise: i32) -> bool {
        let shown = self.cells_around(&self.shown, at).flatten();
        shown.filter(|cell| **cell > noise).count() >= FEW_NOISY
    }

    /// The 5 x 5 pixels about a place, raw counts; zeros beyond the tile.
    pub fn around(&self, [x, y]: [usize; 2]) -> [[i32; 5]; 5] {
        core::array::from_fn(|row| {
            let row = self.row((y + row).saturating_sub(2));
            let five = row.get(x.saturating_sub(2)..).and_then(<[u16]>::first_chunk::<5>);
            five.map_or([0; 5], |five| five.map(i32::from))
        })
    }
}

/// What is summed over a segment of two rows.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Its sum.
    all: i32,
    /// By how much its right half exceeds the left one.
    step: i32,
}

/// The sums of a cell's segments.
#[inline(always)]
fn of_segment(sums: &[[Sums; SEGMENTS]; PAIRS], segment: usize) -> impl Iterator<Item = &Sums> {
    sums.iter().filter_map(move |pair| pair.get(segment))
}

/// Reads the rows of a band `width` wide: sums of its segments, greatest boxes of 2 x 2 px in their halves,
/// distances of pixels from others of their rows.
#[inline(never)]
fn sum_band(
    rows: &[u16],
    width: usize,
    sums: &mut [[Sums; SEGMENTS]; PAIRS],
    boxes: &mut [[u32; SEGMENTS]; PAIRS],
    pixels: &mut [u32; SEGMENTS],
) {
    for ((rows, sums), boxes) in rows.chunks_exact((2 * width).max(1)).zip(sums).zip(boxes) {
        let (above, below) = rows.split_at(width.min(rows.len()));
        let blocks = above.as_chunks::<SEGMENT>().0.iter().zip(below.as_chunks::<SEGMENT>().0);
        let cells = sums.iter_mut().zip(boxes).zip(pixels.iter_mut());
        for ((above, below), ((sums, greatest), pixels)) in blocks.zip(cells) {
            let [left, right];
            ([left, right], *greatest) = half_sums(above, below);
            *sums = Sums { all: left + right, step: right - left };
            let [_, _, _, _, one, _, _, _, _, _, _, other, ..] = *above;
            *pixels += u32::from(one.abs_diff(other));
        }
    }
}

/// Lets the segments of a narrow tile count more than once.
fn repeat(sums: &mut [[Sums; SEGMENTS]; PAIRS], segments: usize) {
    for sums in sums {
        for segment in segments..SEGMENTS {
            let again = sums.get(segment - segments).copied().unwrap_or_default();
            if let Some(sums) = sums.get_mut(segment) {
                *sums = again;
            }
        }
    }
}
