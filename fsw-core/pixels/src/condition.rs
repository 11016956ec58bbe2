//! Local background and noise of a window, and what rises above it.
//!
//! In: raw pixels of a window, any resolution. Out: [`Residuals`], the same pixels seen above a background in
//! scaled counts, and the window's noise. The background is a level for every row plus a level for every cell
//! ([`levels`](crate::levels)). The noise is the mean absolute residual, x 1.2533 (Gaussian), of sampled
//! pixels, at least a third of a raw count; and the same of sums over 3 x 3 pixels, because interpolated
//! colour and compression correlate neighbours. Of tall windows every cell's noise is known by itself
//! ([`noise`](crate::noise)).
//!
//! The pixels are not rewritten: a reading less on the target is worth more than the subtraction done again
//! for the few that matter. For the same reason what is looked at is held against the level of one cell, that
//! of its middle ([`Residuals::about`]): the pixels around a place have no steps in them that the levels
//! made.
//!
//! Error of the noise on Gaussian noise, window of 120 x 62 px: sigma comes out 2 % low and the noise of sums
//! 2 % high. Source: thesis §2.1 (row and column offsets); in its §3.1.1 the threshold is fixed and no
//! background is taken off.
//!
//! Cost: 19 cycles a pixel of the window (119 x 62 px, 10 bit; Cortex-M4 model, zero wait states). More than
//! 14 bits cost one more reading and writing of the pixels.

use crate::levels::{Levels, Shape, step_across};
use crate::median::least;
use crate::noise::{
    Scatter, TRIMMED_TO_SIGMA, cells_around, noise_of, noise_where_noisy, of_most, sigmas_of,
};
use crate::window::{
    BAND, BANDS, BLOCK, BLOCKS, Cells, FULL_SCALE, KEPT_BITS, MAX_HEIGHT, MAX_WIDTH, MIN_WIDTH, bands,
    rows_of, saturation,
};

/// The sums at the sides of a cell that slopes are held to be so many sigmas: no threshold is lower than that
/// many.
const LEAN_SIGMAS: i32 = 5;
/// Windows at least this tall are sampled for their noise in every [`NOISE_ROW_STEP`]th row, lower ones in
/// all.
const TALL: usize = 48;
const NOISE_ROW_STEP: usize = 4;

/// A window above its background: pixel minus row level minus cell level, scaled counts.
#[derive(Clone, Copy, Debug)]
pub struct Residuals<'a> {
    /// Raw values of at most [`KEPT_BITS`] bits.
    pixels: &'a [u16],
    width: usize,
    height: usize,
    /// Raw value to scaled counts, bits to the left.
    shift: u32,
    levels: Levels,
    /// Noise of sums in each cell.
    noise: Cells<i32>,
    /// Raw value from which on a pixel may have been full scale.
    saturation: u16,
    /// Noise of a pixel, scaled counts, at least 1.
    pub sigma: i32,
    /// Noise of a sum over 3 x 3 pixels, scaled counts: three times that of a pixel, or more where neighbours
    /// go together.
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

    /// The raw values of row `y`, none outside the window.
    pub fn raw_row(&self, y: usize) -> &'a [u16] {
        // Of a row before the first the start wraps beyond all pixels.
        let start = y.wrapping_mul(self.width);
        self.pixels.get(start..start.wrapping_add(self.width)).unwrap_or(&[])
    }

    /// Background of row `y`, without its cells', scaled counts.
    pub fn row_level(&self, y: usize) -> i32 {
        self.levels.rows.get(y).copied().unwrap_or(0)
    }

    /// The band of cells to which row `y` belongs.
    pub fn band(&self, y: usize) -> usize {
        (y / BAND).min(bands(self.height) - 1)
    }

    /// Background of the cells of a band, to be added to that of the row, scaled counts.
    pub fn cell_levels(&self, band: usize) -> &[i32; BLOCKS] {
        const NONE: &[i32; BLOCKS] = &[0; BLOCKS];
        self.levels.cells.get(band).unwrap_or(NONE)
    }

    /// Noise of sums over 3 x 3 pixels in every cell, scaled counts.
    pub fn noise(&self) -> &Cells<i32> {
        &self.noise
    }

    /// [`noise_where_noisy`] about a place: clouds are told by what is around them.
    pub fn noise_around(&self, x: usize, y: usize, noise: i32) -> i32 {
        let used = [self.width.div_ceil(BLOCK), bands(self.height)];
        noise_where_noisy(cells_around(&self.noise, used, [x / BLOCK, self.band(y)]), noise)
    }

    /// Background of the pixel, scaled counts.
    pub fn level(&self, x: usize, y: usize) -> i32 {
        self.row_level(y) + self.cell_levels(self.band(y)).get(x / BLOCK).copied().unwrap_or(0)
    }

    /// The window as it is to be looked at about a place: against the level of its cell, with the noise of
    /// its cell.
    pub fn about(&self, x: usize, y: usize) -> Place<'_> {
        let noise = self.noise.get(self.band(y)).and_then(|band| band.get(x / BLOCK));
        let sum_sigma = noise.copied().unwrap_or(self.sum_sigma);
        Place { window: self, cell_level: self.level(x, y) - self.row_level(y), sum_sigma }
    }

    /// Whether the pixel may have been at full scale: a twentieth is left to the converter's last counts, to
    /// compression and to colours of which only some were full.
    pub fn saturated(&self, [x, y]: [usize; 2]) -> bool {
        self.raw_row(y).get(x).is_some_and(|raw| *raw >= self.saturation)
    }

    /// The sums of the pixels at (x + i, y - 1), (x + i, y) and (x + i, y + 1) above the rows' levels, 0
    /// outside the window.
    pub fn column_sums<const N: usize>(&self, x: usize, y: usize) -> [i32; N] {
        let above = y.wrapping_sub(1);
        let level = self.row_level(above) + self.row_level(y) + self.row_level(y + 1);
        let rows = [above, y, y + 1].map(|y| self.raw_row(y).get(x..).unwrap_or(&[]));
        // The same twice: where the length is known to the compiler it is twice as fast on the target.
        if let [Some(a), Some(b), Some(c)] = rows.map(|row| row.first_chunk::<N>()) {
            let mut sums = a.map(i32::from);
            add_columns(&mut sums, [b, c], (level, self.shift));
            return sums;
        }
        let [a, b, c] = rows;
        let mut sums = [0; N];
        sums.iter_mut().zip(a).for_each(|(sum, raw)| *sum = i32::from(*raw));
        add_columns(&mut sums, [b, c], (level, self.shift));
        sums
    }

    /// By how much the background rises across each cell of a band, along the rows and down beyond what the
    /// rows' levels do: the lesser of the steps to its neighbours on either side where both go the same way.
    /// A glow slopes so; a limb is a step on one side.
    fn slopes(&self, band: usize) -> [[i32; 2]; BLOCKS] {
        let cells = self.cell_levels(band);
        let last = (self.width.div_ceil(BLOCK)).min(BLOCKS).saturating_sub(1);
        let last_band = bands(self.height) - 1;
        let [above, below] =
            [band.saturating_sub(1), (band + 1).min(last_band)].map(|band| self.cell_levels(band));
        let mut slopes = core::array::from_fn(|block| {
            let of = |cells: &[i32; BLOCKS], block: usize| cells.get(block).copied().unwrap_or(0);
            let here = of(cells, block);
            let (left, right) = (of(cells, block.saturating_sub(1)), of(cells, (block + 1).min(last)));
            let along = step_across(block, last, here - left, right - here);
            let down = step_across(band, last_band, here - of(above, block), of(below, block) - here);
            [along, down]
        });
        // The rows' levels have taken what the quiet cells have in common: the middle, for of a cell at the
        // edge a cloud beside it speaks.
        let quiet = self.levels.quiet.get(band).copied().unwrap_or(0);
        let of_quiet =
            slopes.iter().take(last + 1).enumerate().filter(|(block, _)| (quiet >> block) & 1 == 1);
        let of_quiet = of_quiet.map(|(_, [_, down])| *down);
        let middle = of_quiet.clone().count() / 2;
        let lesser_half: [i32; BLOCKS / 2 + 1] = least(of_quiet);
        let common = lesser_half.get(middle).copied().unwrap_or(0);
        slopes.iter_mut().for_each(|[_, down]| *down -= common);
        slopes
    }

    /// Takes the noise of a band's sampled rows, from three places in each whole block of them; `slopes` are
    /// those of its cells.
    #[inline(always)]
    fn sample(
        &self,
        band: usize,
        slopes: &[[i32; 2]; BLOCKS],
        scatters: &mut [Scatter; BLOCKS],
        sampled: &mut Sampled,
    ) {
        let rows = rows_of(band, self.height);
        let cells = self.cell_levels(band);
        let middle = (rows.start + rows.end) as i32 / 2;
        let step = if sampled.tall { NOISE_ROW_STEP } else { 1 };
        for y in (rows.start + 1..rows.end.saturating_sub(1)).step_by(step) {
            let level = self.row_level(y);
            let level3 = self.row_level(y - 1) + level + self.row_level(y + 1);
            let three = self.pixels.get((y - 1) * self.width..).unwrap_or(&[]);
            let [above, here, below] = [0, 1, 2].map(|row| {
                let pixels = three.get(row * self.width..(row + 1) * self.width);
                pixels.unwrap_or(&[]).as_chunks::<BLOCK>().0
            });
            let from_middle = y as i32 - middle;
            let columns = cells.iter().zip(slopes.iter()).zip(scatters.iter_mut());
            let blocks = above.iter().zip(here).zip(below).zip(columns);
            for (((a, b), c), ((cell, [along, down]), scatter)) in blocks {
                let (squares, middles) = triples(a, b, c);
                let distances = squares.map(|sum| (sum << self.shift).wrapping_sub(3 * level3 + 9 * cell));
                for raw in middles {
                    sampled.pixels.add((raw << self.shift) - level - cell, sampled.clip);
                }
                if sampled.tall {
                    // The middles of the squares stand 5.5, 0.5 and -4.5 px before that of the block.
                    let lean = 9 * down * from_middle / BAND as i32;
                    let [left, centre, right] = distances;
                    let leans = [lean - 25 * along / 8, lean - along / 4, lean + 5 * along / 2];
                    let [first, second, third] = leans;
                    scatter.add(
                        [left.wrapping_sub(first), centre.wrapping_sub(second), right.wrapping_sub(third)]
                            .map(i32::unsigned_abs),
                    );
                } else {
                    distances.into_iter().for_each(|distance| sampled.sums.add(distance, 4 * sampled.clip));
                }
            }
        }
    }

    /// Noise of pixels and of 3 x 3 sums; what is farther than `clip` (a sum: four times) is no background.
    fn measure_noise(&mut self, clip: i32, floor: i32) {
        let tall = self.height >= TALL;
        let mut sampled = Sampled { tall, clip, pixels: Deviation::default(), sums: Deviation::default() };
        let mut scatters = [[Scatter::default(); BLOCKS]; BANDS];
        let mut slopes = [[[0; 2]; BLOCKS]; BANDS];
        for (band, (slopes, scatters)) in
            slopes.iter_mut().zip(&mut scatters).enumerate().take(bands(self.height))
        {
            if tall {
                *slopes = self.slopes(band);
            }
            self.sample(band, slopes, scatters, &mut sampled);
        }
        let Sampled { pixels, sums, .. } = sampled;
        self.sigma = pixels.sigma().max(floor);
        let least = 3 * self.sigma;
        if !tall {
            self.sum_sigma = sums.sigma().max(least);
            self.noise = [[self.sum_sigma; BLOCKS]; BANDS];
            return;
        }
        let mut sigmas = [[None; BLOCKS]; BANDS];
        sigmas_of(&scatters, 0, TRIMMED_TO_SIGMA, &mut sigmas);
        let most = of_most(&sigmas);
        noise_of(&sigmas, most, &mut self.noise);
        self.sum_sigma = most.max(least);
        for (sigma, [along, down]) in self.noise.as_flattened_mut().iter_mut().zip(slopes.as_flattened()) {
            // At the sides of a cell that slopes the sums stand as much above its level as the slope makes
            // them; what the levels' own errors feign is not counted.
            let lean = (along.abs() + down.abs() - self.sigma / 2).max(0);
            *sigma = (*sigma).max(3 * floor) + 9 * lean / (2 * LEAN_SIGMAS);
        }
    }
}

/// A window as it is looked at about a place: against the level of one cell, with that cell's noise.
#[derive(Clone, Copy, Debug)]
pub struct Place<'w> {
    window: &'w Residuals<'w>,
    /// Level of the cell, to be added to the rows', scaled counts.
    cell_level: i32,
    /// Noise of a sum over 3 x 3 pixels in the cell, scaled counts.
    pub sum_sigma: i32,
}

impl<'w> core::ops::Deref for Place<'w> {
    type Target = Residuals<'w>;

    fn deref(&self) -> &Self::Target {
        self.window
    }
}

impl Place<'_> {
    /// The brightest of the 3 x 3 pixels about (x, y), the first of equal ones.
    pub fn brightest_near(&self, x: usize, y: usize) -> [usize; 2] {
        let left = x.saturating_sub(1);
        let rows = (y.saturating_sub(1)..).take(3).filter_map(|y| Some((y, self.run::<3>(left, y)?)));
        let pixels = rows.flat_map(|(y, run)| (left..).zip(run).map(move |(x, value)| (value, [x, y])));
        let (_, place) =
            pixels.fold((i32::MIN, [x, y]), |most, pixel| if pixel.0 > most.0 { pixel } else { most });
        place
    }

    /// Residuals of the 5 x 5 pixels about (x, y); `None` where they leave the window.
    pub fn five_by_five(&self, x: usize, y: usize) -> Option<[[i32; 5]; 5]> {
        let (left, top) = (x.checked_sub(2)?, y.checked_sub(2)?);
        let mut pixels = [[0; 5]; 5];
        for (row, y) in pixels.iter_mut().zip(top..) {
            row.iter_mut().zip(self.run::<5>(left, y)?).for_each(|(pixel, value)| *pixel = value);
        }
        Some(pixels)
    }

    /// Residuals of the `N` pixels of row `y` from column `x` on, above the rows' levels and the one cell's
    /// that is looked at; `None` where they leave the window.
    #[inline(always)]
    pub fn run<const N: usize>(&self, x: usize, y: usize) -> Option<impl Iterator<Item = i32>> {
        let raw = self.raw_row(y).get(x..)?.first_chunk::<N>()?;
        let level = self.row_level(y) + self.cell_level;
        let shift = self.shift;
        // One instruction on the target.
        let within_scale = move |raw: &u16| (i32::from(*raw) << shift).clamp(0, FULL_SCALE - 1);
        Some(raw.iter().map(move |raw| within_scale(raw) - level))
    }
}

/// Adds two rows column by column to a third, scales the sums and takes the rows' level together off.
#[inline(always)]
fn add_columns(sums: &mut [i32], [b, c]: [&[u16]; 2], (level, shift): (i32, u32)) {
    for (sum, (b, c)) in sums.iter_mut().zip(b.iter().zip(c)) {
        *sum = ((*sum + i32::from(*b) + i32::from(*c)) << shift).wrapping_sub(level);
    }
}

/// Sums and middle pixels of three 3 x 3 squares that do not touch.
fn triples(above: &[u16; BLOCK], here: &[u16; BLOCK], below: &[u16; BLOCK]) -> ([i32; 3], [i32; 3]) {
    let sums = |row: &[u16; BLOCK]| {
        let [_, a, b, c, _, _, d, e, f, _, _, g, h, i, ..] = row.map(i32::from);
        ([a + b + c, d + e + f, g + h + i], [b, e, h])
    };
    let (([a, b, c], _), ([d, e, f], middles), ([g, h, i], _)) = (sums(above), sums(here), sums(below));
    ([a + d + g, b + e + h, c + f + i], middles)
}

/// What is sampled of a window for its noise.
struct Sampled {
    /// Whether every cell's noise is taken by itself.
    tall: bool,
    /// What is farther from the levels is no background; a sum: four times.
    clip: i32,
    pixels: Deviation,
    sums: Deviation,
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

/// Conditions a window. `pixels` holds whole rows of `width` raw values of `bits` resolution; values of more
/// than 14 bits lose their last ones in place.
///
/// `None` when the window is narrower than [`MIN_WIDTH`], wider than [`MAX_WIDTH`], taller than
/// [`MAX_HEIGHT`] or not whole rows.
#[inline(never)]
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
    Some(conditioned(pixels, (width, height), bits.min(KEPT_BITS)))
}

/// [`condition`]s a window that can be.
fn conditioned(pixels: &[u16], (width, height): (usize, usize), bits: u8) -> Residuals<'_> {
    let shift = u32::from(KEPT_BITS - bits);
    // A third of a count is the sigma of quantisation alone.
    let floor = ((1 << shift) / 3).max(1);
    let mut residuals = Residuals {
        pixels,
        width,
        height,
        shift,
        levels: Levels::NONE,
        noise: [[3 * floor; BLOCKS]; BANDS],
        saturation: saturation(bits),
        sigma: floor,
        sum_sigma: 3 * floor,
    };
    let clip = residuals.levels.take(pixels, &Shape { width, height, shift, full_scale: (1 << bits) - 1 });
    // The levels are finer than the counts: half a count more.
    residuals.measure_noise(((2 * clip + 1) << shift) as i32 / 2, floor);
    residuals.levels.calm_rows(height, residuals.sigma);
    residuals
}

#[cfg(test)]
mod tests;
