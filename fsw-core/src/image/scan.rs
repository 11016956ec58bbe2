//! Finds the stars of a window, and of a whole detector read tile by tile.
//!
//! In: a [`Detector`] and a buffer of [`TILE_PIXELS`]. Out: the brightest [`MAX_DETECTIONS`] star-like spots, brightest
//! first. Tiles are [`MAX_WIDTH`] x [`MAX_HEIGHT`] px and overlap by the margin a centroid needs, their cores partition
//! the detector, so each star is found once and the image is never held whole.
//!
//! A candidate is a local maximum (in 5 x 5) of the sum over 3 x 3 pixels that exceeds the threshold; the sum, rather
//! than the pixel, is what noise of single pixels and the star's phase disturb least.

use super::centroid::{MARGIN, measure};
use super::condition::{MAX_HEIGHT, MAX_WIDTH, Residuals, condition, residual};
use super::{Detection, DetectionParameters};
use fsw_hal::{Detector, DetectorError, Window};
use heapless::Vec;

/// Length of the readout buffer, px.
pub const TILE_PIXELS: usize = MAX_WIDTH * MAX_HEIGHT;
/// Spots kept of an image.
pub const MAX_DETECTIONS: usize = 96;
/// Candidates examined in one tile: bounds the cost of a tile full of noise or structure.
pub const MAX_CANDIDATES: usize = 64;

/// Star-like spots, kept by brightness.
#[derive(Clone, Debug, Default)]
pub struct Detections {
    spots: Vec<Detection, MAX_DETECTIONS>,
    found: u32,
    crowded_tiles: u32,
}

impl Detections {
    /// The spots kept; [`scan`] leaves them brightest first.
    pub fn spots(&self) -> &[Detection] {
        &self.spots
    }

    /// How many spots were found in all, kept or not.
    pub fn found(&self) -> u32 {
        self.found
    }

    /// Tiles that held more than [`MAX_CANDIDATES`] candidates, the rest of which was not examined.
    pub fn crowded_tiles(&self) -> u32 {
        self.crowded_tiles
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.spots.clear();
        self.found = 0;
        self.crowded_tiles = 0;
    }

    /// No spots.
    pub const fn new() -> Self {
        Self { spots: Vec::new(), found: 0, crowded_tiles: 0 }
    }

    /// Keeps the spot, in place of the faintest when full. A spot that two overlapping windows show is kept once.
    fn insert(&mut self, spot: Detection) {
        const ONE_PX: u32 = 1 << 16;
        let same = |kept: &Detection| {
            kept.x_q16.abs_diff(spot.x_q16) < ONE_PX && kept.y_q16.abs_diff(spot.y_q16) < ONE_PX
        };
        if self.spots.iter().any(same) {
            return;
        }
        self.found = self.found.saturating_add(1);
        if let Err(spot) = self.spots.push(spot)
            && let Some(faintest) = self.spots.iter_mut().max_by_key(|kept| kept.rank())
            && spot.rank() < faintest.rank()
        {
            *faintest = spot;
        }
    }

    /// Sorts by brightness.
    pub(crate) fn sort(&mut self) {
        // Insertion sort: no panic path, and the list is short.
        for end in 1..self.spots.len() {
            for at in (1..=end).rev() {
                match self.spots.get_mut(at - 1..=at) {
                    Some([before, after]) if after.rank() < before.rank() => core::mem::swap(before, after),
                    _ => break,
                }
            }
        }
    }
}

/// Whether no 3 x 3 sum within two pixels is larger; of equal sums the first in reading order wins.
fn is_local_maximum(window: &Residuals, x: usize, y: usize, value: i32) -> bool {
    for ny in y - 2..=y + 2 {
        for nx in x - 2..=x + 2 {
            let other = window.sum9(nx, ny);
            let earlier = (ny, nx) < (y, x);
            if other > value || (earlier && other == value) {
                return false;
            }
        }
    }
    true
}

/// Calls `found` for every star of a conditioned window whose maximum lies in the core: `core` in window pixels, at
/// least [`MARGIN`] inside the window. Returns whether all candidates were examined.
fn for_each_star(
    window: &Residuals,
    core: Window,
    parameters: &DetectionParameters,
    mut found: impl FnMut(Detection),
) -> bool {
    let threshold = window.sum_sigma * i32::from(parameters.threshold_sigma_tenths) / 10;
    let mut candidates = 0;
    let mut rows = window.rows().skip(usize::from(core.y).saturating_sub(1));
    let (Some(mut above), Some(mut here)) = (rows.next(), rows.next()) else { return true };
    let columns = usize::from(core.x)..usize::from(core.x) + usize::from(core.width);
    for (y, below) in (usize::from(core.y)..).zip(rows.take(usize::from(core.height))) {
        let first = columns.start.saturating_sub(1);
        let columns3 = above.iter().zip(here).zip(below).skip(first);
        let mut columns3 = columns3.map(|((a, b), c)| residual(*a) + residual(*b) + residual(*c));
        let (mut left, mut middle) = (columns3.next().unwrap_or(0), columns3.next().unwrap_or(0));
        for (x, right) in columns.clone().zip(columns3) {
            let sum = left + middle + right;
            (left, middle) = (middle, right);
            if sum <= threshold || !is_local_maximum(window, x, y, sum) {
                continue;
            }
            candidates += 1;
            if candidates > MAX_CANDIDATES {
                return false;
            }
            if let Some(spot) = measure(window, x, y, parameters) {
                found(spot);
            }
        }
        (above, here) = (here, below);
    }
    true
}

/// Starts and lengths of the tiles' cores along one side of the detector: as few as fit, all about equally long.
fn cores(length: u16, tile: usize) -> impl Iterator<Item = (u16, u16)> {
    let margin = MARGIN as u32;
    let searched = u32::from(length).saturating_sub(2 * margin);
    let count = searched.div_ceil(tile as u32 - 2 * margin);
    (0..count).map(move |index| {
        let (start, end) = (index * searched / count, (index + 1) * searched / count);
        ((margin + start) as u16, (end - start) as u16)
    })
}

/// Reads a window and adds its stars to `detections`, in detector coordinates. The margin of the window is not searched.
///
/// # Errors
/// Of the detector; a window that [`condition`] cannot serve gives [`DetectorError::BufferLength`].
pub fn read_stars(
    detector: &mut impl Detector,
    window: Window,
    buffer: &mut [u16; TILE_PIXELS],
    parameters: &DetectionParameters,
    detections: &mut Detections,
) -> Result<(), DetectorError> {
    let pixels = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
    detector.read(window, pixels)?;
    let bits = detector.geometry().bits;
    let residuals = condition(pixels, usize::from(window.width), bits).ok_or(DetectorError::BufferLength)?;
    let margin = MARGIN as u16;
    let core = Window {
        x: margin,
        y: margin,
        width: window.width.saturating_sub(2 * margin),
        height: window.height.saturating_sub(2 * margin),
    };
    let complete = for_each_star(&residuals, core, parameters, |mut spot| {
        spot.x_q16 += i32::from(window.x) << 16;
        spot.y_q16 += i32::from(window.y) << 16;
        detections.insert(spot);
    });
    if !complete {
        detections.crowded_tiles = detections.crowded_tiles.saturating_add(1);
    }
    Ok(())
}

/// Scans the whole detector, tile by tile, and leaves the brightest spots in `detections`, brightest first.
///
/// # Errors
/// Of the detector, at the first window that fails.
pub fn scan(
    detector: &mut impl Detector,
    buffer: &mut [u16; TILE_PIXELS],
    parameters: &DetectionParameters,
    detections: &mut Detections,
) -> Result<(), DetectorError> {
    detections.clear();
    let geometry = detector.geometry();
    let margin = MARGIN as u16;
    for (y, height) in cores(geometry.height_px, MAX_HEIGHT) {
        for (x, width) in cores(geometry.width_px, MAX_WIDTH) {
            let window = Window {
                x: x - margin,
                y: y - margin,
                width: width + 2 * margin,
                height: height + 2 * margin,
            };
            read_stars(detector, window, buffer, parameters, detections)?;
        }
    }
    detections.sort();
    Ok(())
}
