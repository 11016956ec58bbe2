//! Search for limb points on the whole detector, without prediction (thesis §3.2.1 steps 1 to 4).
//!
//! In: a [`Detector`] and a buffer as long as its longer side. Out: up to [`MAX_SEARCH_POINTS`] limb points.
//!
//! Every sixteenth row and column is read as a window of one line and walked both ways, from dark to
//! bright. The dark level follows the pixels, downwards fast and upwards slowly. Where a pixel leaves it
//! after [`LEAST_DARK_PX`] dark ones, the line is followed to the first plateau: 8 px after which the next
//! 8 are brighter by less than an eighth. The limb is where the line passes half of that plateau, going
//! outward from it. Stars and hot pixels have no plateau, the terminator none within the longest rise. A
//! dark sea among clouds is rejected because the dark side of a limb is as dark as the sky, whose level is
//! measured on a few lines beforehand. Remaining outliers are left to [`consensus`](super::consensus).
//!
//! The thresholds of rise and plateau scale with the line's noise, measured in its darkest block.
//!
//! Where there are more points than the list holds, every second one is dropped, then only every second one
//! is taken.
//!
//! Cost: of a line without contrast only the extremes are computed. On others a pixel is read once each
//! way, and at most three times more along a rise: the bound depends on the number of lines alone.

use super::{EarthParameters, LimbPoint, MAX_SEARCH_POINTS};
use dark_level::{block_mean, darkest_block};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use heapless::Vec;

mod dark_level;
pub(super) use dark_level::sky_level;

/// Dark pixels before a rise.
pub const LEAST_DARK_PX: usize = 8;
/// Half of the length over which brightness is averaged, px.
const BLOCK: usize = 4;
/// Levels are in 64ths of a count.
pub(super) const FINE_SHIFT: u32 = 6;
/// The dark level rises by this share of what a pixel is above it, up to four counts: 2^-6.
const RISE_SHIFT: u32 = 6;
/// It falls by this share: 2^-2.
const FALL_SHIFT: u32 = 2;
/// A rise begins at this share of the least contrast: 2^-2.
const BEGIN_SHIFT: u32 = 2;
/// A plateau's next pixels are brighter by less than a share of 2^-3.
const PLATEAU_SHIFT: u32 = 3;
/// The dark side is brighter than the sky by less than a share of 2^-3 of the plateau.
const SKY_SHIFT: u32 = 3;
/// A rise begins at this many sigmas of the line's noise: the dark level is up to two sigmas below the
/// mean.
const BEGIN_SIGMAS: i32 = 4;
/// Least plateau in units of that threshold: half of it then still exceeds it.
const LEAST_BEGINS: i32 = 2;
/// Sigma of a point as a share of its rise's length: the plateau's height is known to an eighth, half of it
/// to a sixteenth.
const SIGMA_SHARE: f32 = 0.05;

/// Limb points of a search.
pub type Points = Vec<LimbPoint, MAX_SEARCH_POINTS>;

/// Thresholds as counts.
#[derive(Clone, Copy)]
struct Thresholds {
    /// Least contrast, fine counts.
    contrast: i32,
    /// What a rise begins with, fine counts.
    begin: i32,
    /// Brightest dark side, fine counts.
    dark: i32,
    /// The darkest sky, fine counts.
    sky: i32,
    /// Largest excess of a dark side over the sky, fine counts.
    max_above_sky: i32,
    /// Least length of the bright side, px.
    run: usize,
    /// Longest rise, px.
    rise: usize,
    floor_px: f32,
}

/// A line seen from one of its ends.
#[derive(Clone, Copy)]
struct Line<'a> {
    pixels: &'a [u16],
    backwards: bool,
}

impl Line<'_> {
    /// Fine counts of a pixel.
    fn at(&self, place: usize) -> Option<i32> {
        let index = if self.backwards { self.pixels.len().checked_sub(place + 1)? } else { place };
        self.pixels.get(index).map(|raw| i32::from(*raw) << FINE_SHIFT)
    }

    /// Sum of a block, fine counts above `dark` (at most 2^24).
    fn block(&self, place: usize, dark: i32) -> Option<i32> {
        let mut sum = 0;
        for offset in 0..BLOCK {
            sum += self.at(place + offset)? - dark;
        }
        Some(sum)
    }
}

/// Limb crossing on a line.
struct LimbOnLine {
    /// Place of the limb, px from the line's end.
    place: f32,
    sigma_px: f32,
}

/// Follows a rise that begins at `start` to its plateau. `Err`: the place from which the search continues.
fn trace_rise(line: &Line, start: usize, dark: i32, thresholds: &Thresholds) -> Result<LimbOnLine, usize> {
    let begin = thresholds.begin;
    let block = |place: usize| line.block(place, dark).ok_or(place);
    let mut plateau = start;
    let mut blocks =
        [block(start)?, block(start + BLOCK)?, block(start + 2 * BLOCK)?, block(start + 3 * BLOCK)?];
    let mut bright = None;
    for _ in 0..=thresholds.rise / BLOCK {
        let [first, second, third, fourth] = blocks;
        if first < begin * BLOCK as i32 {
            return Err(plateau + BLOCK);
        }
        let (near, far) = (first + second, third + fourth);
        if far < near / 2 {
            return Err(plateau + 2 * BLOCK);
        }
        if near >= thresholds.contrast * 2 * BLOCK as i32 && far <= near + (near >> PLATEAU_SHIFT) {
            bright = Some(first / BLOCK as i32);
            break;
        }
        plateau += BLOCK;
        blocks = [second, third, fourth, block(plateau + 3 * BLOCK)?];
    }
    let bright = bright.ok_or(plateau)?;
    if dark - thresholds.sky > thresholds.max_above_sky.max(bright >> SKY_SHIFT) {
        return Err(plateau + 2 * BLOCK);
    }
    let half = dark + bright / 2;
    for step in 0..thresholds.run / BLOCK {
        if block(plateau + BLOCK + step * BLOCK)? < bright / 2 * BLOCK as i32 {
            return Err(plateau + 2 * BLOCK);
        }
    }
    // Outward from the plateau; `start` itself is a quarter of the contrast above dark, or less than half a
    // plateau.
    let mut inner = line.at(plateau + 2 * BLOCK).ok_or(plateau)?;
    for back in 1..=thresholds.rise + 4 * BLOCK {
        let Some(place) = (plateau + 2 * BLOCK).checked_sub(back) else { break };
        let outer = line.at(place).ok_or(plateau)?;
        if outer < half {
            if inner <= outer {
                break;
            }
            let part = (half - outer) as f32 / (inner - outer) as f32;
            let length = (plateau - start) as f32;
            let sigma = libm::sqrtf(
                thresholds.floor_px * thresholds.floor_px + SIGMA_SHARE * SIGMA_SHARE * length * length,
            );
            return Ok(LimbOnLine { place: place as f32 + part.clamp(0.0, 1.0), sigma_px: sigma });
        }
        inner = outer;
    }
    Err(plateau)
}

/// The first passage from dark to bright along a line.
fn first_crossing(line: &Line, thresholds: &Thresholds) -> Option<LimbOnLine> {
    let mut dark = line.at(0)?;
    let (mut dark_run, mut resume) = (0, 0);
    for place in 0..line.pixels.len() {
        let value = line.at(place)?;
        let above = value - dark;
        if above < 0 {
            dark += above >> FALL_SHIFT;
        } else {
            dark += above.min(4 << FINE_SHIFT) >> RISE_SHIFT;
        }
        if above < thresholds.begin {
            dark_run += 1;
            continue;
        }
        if dark_run >= LEAST_DARK_PX && place >= resume && dark <= thresholds.dark {
            match trace_rise(line, place, dark, thresholds) {
                Ok(limb) => return Some(limb),
                Err(end) => resume = end,
            }
        }
        dark_run = 0;
    }
    None
}

/// Adds points to a list; when it is full, keeps every second one.
pub(super) struct Decimator<'a> {
    points: &'a mut Points,
    seen: u32,
    stride: u32,
}

impl<'a> Decimator<'a> {
    /// None seen yet; the list is empty.
    pub(super) fn new(points: &'a mut Points) -> Self {
        Self { points, seen: 0, stride: 1 }
    }

    pub(super) fn add(&mut self, point: LimbPoint) {
        let number = self.seen;
        self.seen = self.seen.wrapping_add(1);
        if number & (self.stride - 1) != 0 {
            return;
        }
        if self.points.is_full() {
            for kept in 0..MAX_SEARCH_POINTS / 2 {
                if let Ok([kept, moved]) = self.points.get_disjoint_mut([kept, 2 * kept]) {
                    core::mem::swap(kept, moved);
                }
            }
            while self.points.len() > MAX_SEARCH_POINTS / 2 {
                self.points.pop();
            }
            // No more doublings than lines have pixels.
            self.stride = self.stride.wrapping_mul(2).max(1);
        }
        let _ = self.points.push(point);
    }
}

/// Reads rows and then columns, from the `first` on every `step`-th, and calls `visit` with the detector,
/// whether it is a row, its number and its pixels.
pub(super) fn for_each_line<D: Detector<Error = DetectorError>>(
    detector: &mut D,
    buffer: &mut [u16],
    [first, step]: [u16; 2],
    mut visit: impl FnMut(&mut D, bool, u16, &[u16]) -> Result<(), DetectorError>,
) -> Result<(), DetectorError> {
    let DetectorGeometry { width_px, height_px, .. } = detector.geometry();
    for (along_x, length, lines) in [(true, width_px, height_px), (false, height_px, width_px)] {
        let pixels = buffer.get_mut(..usize::from(length)).ok_or(DetectorError::BufferLength)?;
        for line in (first..lines).step_by(usize::from(step.max(1))) {
            let window = if along_x {
                Window { x: 0, y: line, width: length, height: 1 }
            } else {
                Window { x: line, y: 0, width: 1, height: length }
            };
            detector.read(window, pixels)?;
            visit(detector, along_x, line, pixels)?;
        }
    }
    Ok(())
}

/// Searches the whole detector. `buffer` must hold its longer side.
///
/// # Errors
/// Of the detector, at the first line that fails; [`DetectorError::BufferLength`] for a short buffer.
pub fn search(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16],
    parameters: &EarthParameters,
    points: &mut Points,
) -> Result<(), DetectorError> {
    points.clear();
    let full_scale = f32::from(detector.geometry().full_scale());
    let fine = |share: f32| (share * full_scale * (1 << FINE_SHIFT) as f32) as i32;
    let step = parameters.search.step_px;
    let sky = sky_level(detector, buffer, step)?;
    let contrast = fine(parameters.search.contrast_share).max(1 << FINE_SHIFT);
    let begin = contrast >> BEGIN_SHIFT;
    let quiet = Thresholds {
        contrast,
        begin,
        // Relative to the sky, because a camera's dark level may be high; but bounded, because an image
        // without sky has no limb.
        dark: (sky + fine(parameters.search.dark_share)).min(fine(parameters.strips.dark_share)),
        sky,
        max_above_sky: begin,
        run: parameters.search.run_px.into(),
        rise: usize::from(parameters.search.rise_px).min(256),
        floor_px: parameters.search.floor_px,
    };
    let mut thinned = Decimator::new(points);
    for_each_line(detector, buffer, [step / 2, step], |_, along_x, line, pixels| {
        let (dark, sigma) = darkest_block(pixels);
        let begin = quiet.begin.max(BEGIN_SIGMAS * sigma);
        let thresholds = Thresholds { begin, contrast: quiet.contrast.max(LEAST_BEGINS * begin), ..quiet };
        let brightest = pixels.iter().fold(0, |high, raw| high.max(*raw));
        if (i32::from(brightest) << FINE_SHIFT) - block_mean(dark) < thresholds.contrast {
            return Ok(());
        }
        for backwards in [false, true] {
            let Some(limb) = first_crossing(&Line { pixels, backwards }, &thresholds) else { continue };
            let (place, outward) =
                if backwards { (pixels.len() as f32 - 1.0 - limb.place, 1.0) } else { (limb.place, -1.0) };
            let across = f32::from(line);
            let (centre_px, outward_px) =
                if along_x { ([place, across], [outward, 0.0]) } else { ([across, place], [0.0, outward]) };
            thinned.add(LimbPoint::new(centre_px, limb.sigma_px, outward_px));
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests;
