//! Finds the stars of a window, and of a whole detector read tile by tile.
//!
//! In: a [`Detector`] and a buffer of [`TILE_PIXELS`]. Out: the brightest [`MAX_DETECTIONS`] star-like spots, brightest
//! first. Tiles are at most [`MAX_WIDTH`] x [`MAX_HEIGHT`] px and overlap by the margin a centroid needs, their cores
//! partition the detector, so each star is found once and the image is never held whole. A tile's threshold is that of
//! its own noise: 0.4 false stars a megapixel of Gaussian noise at the default (thesis §3.1.1 fixes 6 % of full scale).
//!
//! A window at full scale (`blinding`) is left at once. Where it shows texture instead of noise (clouds, a limb) its
//! threshold is `TEXTURE_FACTOR` times higher.
//!
//! Cost of the reference frame (1280 x 1024 px, 10 bit, 111 spots): 35.7 cycles a pixel, 46.8 million in all
//! (Cortex-M4 model, zero wait states, without the reading), of which a frame without anything takes 40.6 million; on the
//! host 1.0 ns a pixel. Structure costs more, up to [`bound_cycles`] = 74.6 million (`allowance`); the costliest frame that
//! was found, saturated spots 14 px apart, takes 71.2 million.

use super::allowance::{self, Allowance, Savings};
use super::blinding::blinded;
use super::centroid::{MARGIN, measure};
use super::condition::{MAX_HEIGHT, MAX_WIDTH, Residuals, condition};
pub use super::detections::{Detections, MAX_DETECTIONS};
use super::peaks::for_each_peak;
use super::{Detection, Method};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};

/// Length of the readout buffer, px.
pub const TILE_PIXELS: usize = MAX_WIDTH * MAX_HEIGHT;

/// The threshold is that many times higher where the window shows texture: it has no Gaussian's tails.
const TEXTURE_FACTOR: i32 = 3;

/// Calls `found` for every star of a conditioned window whose maximum lies in the core: `core` in window pixels, at
/// least [`MARGIN`] inside the window; `origin` is the window's first pixel on the detector. Returns whether all candidates were examined.
fn for_each_star(
    window: &Residuals,
    core: Window,
    (origin, method): ([u16; 2], &Method),
    allowance: &mut Allowance,
    mut found: impl FnMut(Detection),
) -> bool {
    let tenths = i32::from(method.parameters.threshold_sigma_tenths);
    let tenths = if window.textured() { tenths * TEXTURE_FACTOR } else { tenths };
    let threshold = window.sum_sigma * tenths / 10;
    for_each_peak(window, core, threshold, allowance, |x, y| {
        if let Some(spot) = measure(window, [x, y], origin, method) {
            found(spot);
        }
    })
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
pub fn read_stars<'m>(
    detector: &mut impl Detector,
    window: Window,
    buffer: &mut [u16; TILE_PIXELS],
    method: impl Into<Method<'m>>,
    detections: &mut Detections,
) -> Result<(), DetectorError> {
    let mut allowance = Allowance::of_a_window();
    read_stars_within(detector, window, buffer, &method.into(), detections, &mut allowance)
}

/// [`read_stars`] at the cost of `allowance`.
fn read_stars_within(
    detector: &mut impl Detector,
    window: Window,
    buffer: &mut [u16; TILE_PIXELS],
    method: &Method,
    detections: &mut Detections,
    allowance: &mut Allowance,
) -> Result<(), DetectorError> {
    let pixels = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
    detector.read(window, pixels)?;
    let bits = detector.geometry().bits;
    if blinded(pixels, bits) {
        return Ok(());
    }
    let residuals = condition(pixels, usize::from(window.width), bits).ok_or(DetectorError::BufferLength)?;
    let margin = MARGIN as u16;
    let core = Window {
        x: margin,
        y: margin,
        width: window.width.saturating_sub(2 * margin),
        height: window.height.saturating_sub(2 * margin),
    };
    let complete = for_each_star(&residuals, core, ([window.x, window.y], method), allowance, |mut spot| {
        spot.x_q16 += i32::from(window.x) << 16;
        spot.y_q16 += i32::from(window.y) << 16;
        detections.insert(spot);
    });
    if !complete {
        detections.note_crowded();
    }
    Ok(())
}

/// The most that a scan of the detector can cost, cycles of the Cortex-M4 model, the reading of the pixels not counted.
pub fn bound_cycles(geometry: &DetectorGeometry) -> u64 {
    let tiles = cores(geometry.width_px, MAX_WIDTH).count() * cores(geometry.height_px, MAX_HEIGHT).count();
    allowance::bound_cycles(tiles as u32)
}

/// Scans the whole detector, tile by tile, and leaves the brightest spots in `detections`, brightest first.
///
/// # Errors
/// Of the detector, at the first window that fails.
pub fn scan<'m>(
    detector: &mut impl Detector,
    buffer: &mut [u16; TILE_PIXELS],
    method: impl Into<Method<'m>>,
    detections: &mut Detections,
) -> Result<(), DetectorError> {
    let method = method.into();
    detections.clear();
    let geometry = detector.geometry();
    let margin = MARGIN as u16;
    let mut savings = Savings::new();
    for (y, height) in cores(geometry.height_px, MAX_HEIGHT) {
        for (x, width) in cores(geometry.width_px, MAX_WIDTH) {
            let window = Window {
                x: x - margin,
                y: y - margin,
                width: width + 2 * margin,
                height: height + 2 * margin,
            };
            let mut allowance = savings.next_tile();
            read_stars_within(detector, window, buffer, &method, detections, &mut allowance)?;
            savings.put_back(allowance);
        }
    }
    detections.sort();
    Ok(())
}

#[cfg(test)]
mod earth_tests;
#[cfg(test)]
mod tests;
