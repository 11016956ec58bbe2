//! The noise of each cell of a window: what stands there besides stars.
//!
//! In: sums over 3 x 3 pixels, sampled over a cell. Out: their standard deviation from the cell's background.
//! Clouds, a limb or glare widen it where they are and nowhere else, so that the threshold can rise there
//! alone.
//!
//! Of the sums of a cell the `TRIMMED` farthest from the background are left out, because a star, a hot
//! pixel or a hit must not hide itself; the mean distance of the others, x 1.64 (Gaussian, 12 sums), is the
//! deviation. Its error is 25 % for a single cell, which is why cells that look alike share what the quieter
//! half of the window shows.

/// Sums of a cell that are left out.
const TRIMMED: usize = 2;
/// A mean of the 10 least of 12 absolute Gaussian deviates is 1 / 1.642, and the least noisy cells make the
/// mean of those alike 4 % too small; in 256ths.
pub const TRIMMED_TO_SIGMA: u32 = 436;
/// More than a sum over 3 x 3 pixels can be.
const LARGEST: u32 = 1 << 18;

/// Distances from the background in one cell.
#[derive(Clone, Copy, Default)]
pub struct Scatter {
    sum: u32,
    count: u32,
    largest: [u32; TRIMMED],
}

impl Scatter {
    /// Takes in distances. Values with more bits than promised may wrap; none of the sums they make is a
    /// star.
    #[inline(always)]
    pub fn add<const N: usize>(&mut self, sizes: [u32; N]) {
        let [mut first, mut second] = self.largest;
        for size in sizes {
            second = size.min(first).max(second);
            first = size.max(first);
            self.sum = self.sum.wrapping_add(size);
        }
        self.largest = [first, second];
        self.count += sizes.len() as u32;
    }

    /// Standard deviation of what is no outlier, scaled counts: `trimmed_to_sigma` 256ths of its mean
    /// distance, which is `shift` bits to the right; `None` of too few.
    fn sigma(&self, shift: u32, trimmed_to_sigma: u32) -> Option<i32> {
        let count = self.count.checked_sub(TRIMMED as u32)?;
        let kept = self.largest.iter().fold(self.sum, |sum, size| sum.wrapping_sub(*size));
        let scaled = (kept.min((LARGEST >> shift) * count) << shift) * trimmed_to_sigma;
        Some((scaled + 128 * count).checked_div(256 * count)? as i32)
    }
}

/// A cell is as noisy as the others unless it departs from them by more than this factor, quarters.
const ALIKE_QUARTERS: i32 = 7;
/// Times, at most, that the cells that stand out are left out of the mean of the others.
const ROUNDS: usize = 10;

/// Mean of the cells of a window that look alike, the quieter ones where they differ.
pub fn of_most<const S: usize, const B: usize>(sigmas: &[[Option<i32>; S]; B]) -> i32 {
    let mut most = i32::MAX / ALIKE_QUARTERS;
    for _ in 0..ROUNDS {
        let limit = most * ALIKE_QUARTERS / 4;
        let alike = sigmas.as_flattened().iter().flatten().filter(|sigma| **sigma <= limit);
        let (sum, count) = alike.fold((0, 0), |(sum, count), sigma| (sum + sigma, count + 1));
        let of_alike = ((sum + count / 2) / count.max(1)).max(1);
        if of_alike == most {
            break;
        }
        most = of_alike;
    }
    most
}

/// What the sums of each cell show, scaled counts: `trimmed_to_sigma` 256ths of their mean distance, which is
/// `shift` bits to the right; `None` of too few.
pub fn sigmas_of<const S: usize, const B: usize>(
    scatters: &[[Scatter; S]; B],
    shift: u32,
    trimmed_to_sigma: u32,
    sigmas: &mut [[Option<i32>; S]; B],
) {
    for (sigma, scatter) in sigmas.as_flattened_mut().iter_mut().zip(scatters.as_flattened()) {
        *sigma = scatter.sigma(shift, trimmed_to_sigma);
    }
}

/// What every cell is taken for: as noisy as `most` where it and those around it are about that, else what
/// they show.
///
/// Clouds end beside a cell as well as within it, so a cell's neighbours count, a quarter more than their
/// mean, but none for more than three times the cell itself.
pub fn noise_of<const S: usize, const B: usize>(
    sigmas: &[[Option<i32>; S]; B],
    most: i32,
    noise: &mut [[i32; S]; B],
) {
    // With a quarter more than their mean cells up to this are not noisy together.
    let calm = !sigmas.as_flattened().iter().flatten().any(|sigma| 5 * sigma > ALIKE_QUARTERS * most);
    for (band, (row, sigmas_of_row)) in noise.iter_mut().zip(sigmas).enumerate() {
        for (block, (noise, sigma)) in row.iter_mut().zip(sigmas_of_row).enumerate() {
            *noise = most;
            let own = sigma.unwrap_or(0);
            if calm && ALIKE_QUARTERS * own >= 4 * most {
                continue;
            }
            let shown = own.max(around(sigmas, [block, band], own.max(most))).max(1);
            if is_noisy(shown, most) || ALIKE_QUARTERS * shown < 4 * most {
                *noise = shown;
            }
        }
    }
}

/// Whether a cell is noisier than most.
fn is_noisy(sigma: i32, most: i32) -> bool {
    4 * sigma > ALIKE_QUARTERS * most
}

/// More cells than a star alone makes noisy, which stands where four of them meet.
const OF_A_STAR: u32 = 4;
/// Of the cells within two of a cell more than one in so many must be noisier than most, and more than a star
/// makes so, for it to have noise of its own: limb and clouds make many.
const NOISY_DIVISOR: u32 = 5;

/// Takes cells that a star alone makes noisy for no noisier than `most`.
pub fn leave_stars_out<const S: usize, const B: usize>(sigmas: &mut [[Option<i32>; S]; B], most: i32) {
    // A bit for each noisy cell of a band, two places up: there are none beyond the sides.
    let mut noisy = [0; B];
    for (noisy, row) in noisy.iter_mut().zip(sigmas.iter()) {
        let bit = |sigma: Option<i32>| u32::from(sigma.is_some_and(|sigma| is_noisy(sigma, most)));
        *noisy = row.iter().rev().fold(0, |bits, sigma| 2 * bits + bit(*sigma)) << 2;
    }
    for (band, row) in sigmas.iter_mut().enumerate() {
        let near = noisy.get(band.saturating_sub(2)..(band + 3).min(B)).unwrap_or(&[]);
        if near.iter().all(|noisy| *noisy == 0) {
            row.iter_mut().flatten().for_each(|sigma| *sigma = most.min(*sigma));
            continue;
        }
        for (block, sigma) in row.iter_mut().enumerate() {
            let around_it = near.iter().fold(0u32, |bits, row| bits << 5 | (row >> block & 0b11111));
            let columns = (block + 3).min(S) - block.saturating_sub(2);
            let count = around_it.count_ones();
            let textured = count > OF_A_STAR && NOISY_DIVISOR * count > (columns * near.len()) as u32;
            if !textured {
                *sigma = sigma.map(|sigma| sigma.min(most));
            }
        }
    }
}

/// Mean of a cell and its neighbours and a quarter more; a limb beside a quiet cell says less than many cells
/// that are a little noisier, so none counts for more than three times `own`.
fn around<const S: usize, const B: usize>(
    sigmas: &[[Option<i32>; S]; B],
    [block, band]: [usize; 2],
    own: i32,
) -> i32 {
    let bands = sigmas.iter().skip(band.saturating_sub(1)).take(if band == 0 { 2 } else { 3 });
    let blocks =
        bands.flat_map(|row| row.iter().skip(block.saturating_sub(1)).take(if block == 0 { 2 } else { 3 }));
    let sum_of = |(sum, count), sigma: &i32| (sum + sigma.min(&(3 * own)), count + 1);
    let (sum, count) = blocks.flatten().fold((0, 0), sum_of);
    (5 * sum).checked_div(4 * count).unwrap_or(0)
}

/// The values of the cells within two of one; of the cells in a row and of the bands only `used` are.
pub fn cells_around<T, const S: usize, const B: usize>(
    cells: &[[T; S]; B],
    used: [usize; 2],
    [block, band]: [usize; 2],
) -> impl Iterator<Item = &T> {
    let near = |middle: usize, used: usize| middle.saturating_sub(2)..(middle + 3).min(used);
    let (blocks, bands) = (near(block, used[0]), near(band, used[1]));
    let rows = cells.get(bands).unwrap_or(&[]);
    rows.iter().flat_map(move |row| row.get(blocks.clone()).unwrap_or(&[]))
}

/// The greatest of some cells' noise where more than an eighth of them are noisier than `noise`, else 0.
pub fn noise_where_noisy<'c>(cells: impl Iterator<Item = &'c i32>, noise: i32) -> i32 {
    let (noisy, all, greatest) = cells.fold((0, 0, 0), |(noisy, all, greatest), cell| {
        (noisy + i32::from(*cell > noise), all + 1, greatest.max(*cell))
    });
    if 8 * noisy > all { greatest } else { 0 }
}
