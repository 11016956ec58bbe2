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

use crate::window::{BANDS, BLOCKS, Cells};

/// Sums of a cell that are left out.
const TRIMMED: usize = 2;
/// A mean of the 10 least of 12 absolute Gaussian deviates is 1 / 1.642, and the least noisy cells make the
/// mean of those alike 4 % too small; in 256ths.
const TRIMMED_TO_SIGMA: u32 = 436;
/// More than a sum over 3 x 3 pixels can be.
const LARGEST: u32 = 1 << 20;

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
    pub fn add(&mut self, sizes: [u32; 3]) {
        let [mut first, mut second] = self.largest;
        for size in sizes {
            second = size.min(first).max(second);
            first = size.max(first);
            self.sum = self.sum.wrapping_add(size);
        }
        self.largest = [first, second];
        self.count += sizes.len() as u32;
    }

    /// Standard deviation of what is no outlier; `None` of too few.
    fn sigma(&self) -> Option<i32> {
        let count = self.count.checked_sub(TRIMMED as u32)?;
        let kept = self.largest.iter().fold(self.sum, |sum, size| sum.wrapping_sub(*size));
        let mean = kept.checked_div(count)?;
        Some((mean.min(LARGEST).saturating_mul(TRIMMED_TO_SIGMA) / 256) as i32)
    }
}

/// A cell is as noisy as the others unless it departs from them by more than this factor, quarters.
const ALIKE_QUARTERS: i32 = 7;
/// Times, at most, that the cells that stand out are left out of the mean of the others.
const ROUNDS: usize = 10;

/// Mean of the cells of a window that look alike, the quieter ones where they differ.
fn of_most(sigmas: &Cells<Option<i32>>) -> i32 {
    let mut most = i32::MAX / ALIKE_QUARTERS;
    for _ in 0..ROUNDS {
        let limit = most * ALIKE_QUARTERS / 4;
        let alike = sigmas.as_flattened().iter().flatten().filter(|sigma| **sigma <= limit);
        let (sum, count) = alike.fold((0, 0), |(sum, count), sigma| (sum + sigma, count + 1));
        let of_alike = (sum / count.max(1)).max(1);
        if of_alike == most {
            break;
        }
        most = of_alike;
    }
    most
}

/// What every cell is taken for: as noisy as most where it and those around it are about that, else what they
/// show; and what most are.
///
/// Clouds end beside a cell as well as within it, so a cell's neighbours count, a quarter more than their
/// mean, but none for more than twice the cell itself.
pub fn noise_of(scatters: &Cells<Scatter>) -> (Cells<i32>, i32) {
    let mut sigmas: Cells<Option<i32>> = [[None; BLOCKS]; BANDS];
    for (sigma, scatter) in sigmas.as_flattened_mut().iter_mut().zip(scatters.as_flattened()) {
        *sigma = scatter.sigma();
    }
    let most = of_most(&sigmas);
    let mut noise = [[most; BLOCKS]; BANDS];
    for (band, row) in noise.iter_mut().enumerate() {
        for (block, noise) in row.iter_mut().enumerate() {
            let bands = sigmas.iter().skip(band.saturating_sub(1)).take(if band == 0 { 2 } else { 3 });
            let blocks = bands.flat_map(|row| {
                row.iter().skip(block.saturating_sub(1)).take(if block == 0 { 2 } else { 3 })
            });
            let own = sigmas.get(band).and_then(|row| *row.get(block)?).unwrap_or(0);
            // A limb beside a quiet cell says less than many cells that are a little noisier.
            let most_of_one = 3 * own.max(most);
            let sum_of = |(sum, count), sigma: &i32| (sum + sigma.min(&most_of_one), count + 1);
            let (sum, count) = blocks.flatten().fold((0, 0), sum_of);
            let around = (5 * sum).checked_div(4 * count).unwrap_or(0);
            let shown = own.max(around).max(1);
            if 4 * shown > ALIKE_QUARTERS * most || ALIKE_QUARTERS * shown < 4 * most {
                *noise = shown;
            }
        }
    }
    (noise, most)
}
