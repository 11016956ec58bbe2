//! Finds the stars of a whole detector, read tile by tile.
//!
//! In: a [`Detector`] and a buffer of [`TILE_PIXELS`]. Out: the brightest [`MAX_DETECTIONS`] star-like spots,
//! brightest first.
//!
//! A scan looks at every pixel once, in tiles of at most [`TILE_WIDTH`] x [`TILE_HEIGHT`] px that overlap by
//! what a local maximum needs (`coarse`): the candidates are the local maxima of 3 x 3 sums above a threshold
//! of the tile's own noise. Their cores partition the detector, so each star is found once and the image is
//! never held whole. A window of `SIDE` px about each candidate is then read, conditioned and searched at
//! the candidate's place, by the same steps that find a tracked star in its window (`search`). 0.5 false stars
//! a megapixel of Gaussian noise at the default threshold (thesis §3.1.1 fixes 6 % of full scale).
//!
//! A tile or window that the detector does not deliver is counted and left out: no star is known there, nor
//! that there is none. Of more than one in `UNREAD_SHARE` tiles the scan ends with the detector's error.
//!
//! A tile at full scale (`blinding`) is left at once. Where there is texture (clouds, a limb) a candidate's
//! window has `TEXTURED_SIDES` px, in which the noise of cells is known, and serves the other candidates that
//! have room in it.
//!
//! Cost of the reference detector (1280 x 1024 px, 10 bit; Cortex-M4 model, zero wait states, without the
//! reading), by `cargo budget`: 23 cycles a pixel with 63 spots, 30 with 132 beside a crescent, 36 with 200
//! false stars, 1,000 hot pixels and 300 hits; at most [`bound_cycles`] (`allowance`).

use super::DetectionMethod;
pub use super::allowance::windows_bound_cycles;
use super::allowance::{self, Allowance, Savings, TEXTURED_READING_CYCLES, WINDOW_READING_CYCLES};
use super::blinding::blinded;
pub use super::detections::{Detections, MAX_DETECTIONS};
use super::search::{Conditioned, Criteria, QUIET, read, texture, thresholds};
pub use super::search::{TILE_PIXELS, read_stars};
pub use super::smear::{MAX_STREAK_PLACES, Smear};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use fsw_pixels::coarse::{BAND, CoarseTile, EDGE, Peak, SEGMENT, TILE_HEIGHT, TILE_WIDTH};
use fsw_pixels::condition::condition;
use fsw_pixels::light::is_single_pixel;
use fsw_pixels::patch::MARGIN;
use heapless::Vec;

/// Pixels around a candidate that its window must have: a patch's, and 6 by which that may move.
const ROOM: u16 = MARGIN as u16 + 6;
/// Side of the window in which a candidate is measured, px.
const SIDE: u16 = 2 * ROOM + 1;
/// Sides of that of a candidate among noisy cells: such a window knows the noise of its own, as far around as
/// texture is looked for.
const TEXTURED_SIDES: [u16; 2] = [80, 64];
/// Share of the threshold that a place must exceed in its tile to be a candidate, percent. With
/// [`WINDOW_PERCENT`] a star at the threshold is found as often as by the threshold alone: measured on white
/// noise, 2,000 stars of 4 to 9 sigma, PSF of 0.6 to 1.5 px.
const COARSE_PERCENT: i32 = 97;
/// Share that it must exceed in its window, percent, where its own light adds to the noise.
const WINDOW_PERCENT: i32 = 80;
/// Candidates of a tile that are looked at, the brightest.
const MAX_CANDIDATES: usize = 48;
/// As many windows as one in so many tiles may fail: of the 300 to 400 that a scan of the reference detector
/// reads 24. Each may cost the time that its driver waits.
const UNREAD_SHARE: usize = 8;
/// Columns and rows of the places at which a scan first learns how noisy quiet sky is, and the side of each,
/// px.
const SURVEY: [u16; 2] = [8, 6];
const SURVEY_PX: u16 = 16;
/// Of these places the share that is surely quiet: a limb, a Moon or clouds may take the others.
const QUIET_SHARE: usize = 6;

/// A place in a tile at which a star may stand.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// On the detector, px.
    at: [u16; 2],
    /// By how much its 3 x 3 sum exceeds the threshold, scaled counts.
    excess: i32,
    /// Whether cells around it are noisy: clouds, a limb, bright stars.
    textured: bool,
    /// Noise around it, scaled counts; 0 where that is quiet.
    around: i32,
    /// Whether it was measured.
    done: bool,
}

/// A tile's place along one side of the detector.
#[derive(Clone, Copy, Debug)]
struct Span {
    /// First pixel and length, px.
    start: u16,
    length: u16,
    /// First pixel and length of what is searched, px: the spans' cores do not overlap.
    core: u16,
    core_length: u16,
}

/// The tiles along one side of the detector, equally long in whole `step`s, as few as cover all places at
/// which a star can be measured; none where the detector is too short for one.
fn spans(length: u16, longest: usize, step: usize) -> impl Iterator<Item = Span> {
    let edge = EDGE as u32;
    let first = MARGIN as u32 - edge;
    let all = u32::from(length).saturating_sub(2 * first);
    let tile = (all.min(longest as u32) / step as u32) * step as u32;
    let (rest, stride) = (all - tile, tile.saturating_sub(2 * edge).max(1));
    let last = if tile == 0 { 0 } else { rest.div_ceil(stride) };
    let start = move |index: u32| first + (rest * index).checked_div(last).unwrap_or(0);
    let core = move |index: u32| if index > last { start(last) + tile - edge } else { start(index) + edge };
    (0..last + u32::from(tile > 0)).map(move |index| Span {
        start: start(index) as u16,
        length: tile as u16,
        core: core(index) as u16,
        core_length: (core(index + 1) - core(index)) as u16,
    })
}

impl Candidate {
    /// The window about it.
    fn window(&self, geometry: &DetectorGeometry) -> Window {
        let [width, height] = if self.textured { TEXTURED_SIDES } else { [SIDE; 2] };
        let along = |at: u16, side: u16, length: u16| {
            let side = side.min(length);
            (at.saturating_sub(side / 2).min(length - side), side)
        };
        let [x, y] = self.at;
        let ((x, width), (y, height)) =
            (along(x, width, geometry.width_px), along(y, height, geometry.height_px));
        Window { x, y, width, height }
    }

    /// Whether it has [`ROOM`] in a window.
    fn has_room(&self, window: &Window) -> bool {
        let along = |at: u16, start: u16, side: u16| (start + ROOM..start + side - ROOM).contains(&at);
        let [x, y] = self.at;
        along(x, window.x, window.width) && along(y, window.y, window.height)
    }

    /// The pixels of a window at which its maximum may stand.
    fn core(&self, window: &Window) -> Window {
        let along = |at: u16, start: u16, side: u16| {
            let first = (at - start).saturating_sub(1).max(MARGIN as u16);
            let end = (at - start + 2).min(side.saturating_sub(MARGIN as u16));
            (first, end.saturating_sub(first))
        };
        let [x, y] = self.at;
        let ((x, width), (y, height)) = (along(x, window.x, window.width), along(y, window.y, window.height));
        Window { x, y, width, height }
    }
}

/// Noise of 3 x 3 sums of the image's quietest parts, scaled counts, from small windows all over the
/// detector. Of these at most `most_unread` may fail; none is searched.
fn quiet_noise(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16; TILE_PIXELS],
    most_unread: usize,
    detections: &mut Detections,
) -> Result<i32, DetectorError> {
    let geometry = detector.geometry();
    let [columns, rows] = SURVEY;
    let mut noise: Vec<i32, { SURVEY[0] as usize * SURVEY[1] as usize }> = Vec::new();
    let (width, height) = (SURVEY_PX.min(geometry.width_px), SURVEY_PX.min(geometry.height_px));
    let place = |length: u16, side: u16, index: u16, count: u16| {
        ((2 * u32::from(index) + 1) * u32::from(length - side) / (2 * u32::from(count))) as u16
    };
    for row in 0..rows {
        for column in 0..columns {
            let x = place(geometry.width_px, width, column, columns);
            let window = Window { x, y: place(geometry.height_px, height, row, rows), width, height };
            match read(detector, window, buffer) {
                Ok(pixels) => {
                    if let Some(residuals) = condition(pixels, usize::from(width), geometry.bits) {
                        // There are no more places than the list holds.
                        let _ = noise.push(residuals.sum_sigma);
                    }
                }
                Err(error) => detections.note_unread(error, 0, most_unread)?,
            }
        }
    }
    crate::order::sort_numbers(&mut noise);
    Ok(noise.get(noise.len() / QUIET_SHARE).copied().unwrap_or(QUIET))
}

/// The tiles along the detector's rows.
fn columns(geometry: &DetectorGeometry) -> impl Iterator<Item = Span> {
    spans(geometry.width_px, TILE_WIDTH, SEGMENT)
}

/// The tiles along its columns.
fn rows(geometry: &DetectorGeometry) -> impl Iterator<Item = Span> {
    spans(geometry.height_px, TILE_HEIGHT, BAND)
}

/// Number of tiles.
fn tiles(geometry: &DetectorGeometry) -> usize {
    columns(geometry).count() * rows(geometry).count()
}

/// The most that a scan of the detector can cost, cycles of the Cortex-M4 model, the reading of the pixels
/// not counted.
pub fn bound_cycles(geometry: &DetectorGeometry) -> u64 {
    allowance::bound_cycles(tiles(geometry) as u32)
}

/// A tile of a scan.
struct Tile<'m> {
    /// Its place across and down the detector.
    across: Span,
    down: Span,
    method: &'m DetectionMethod<'m>,
    /// Noise of 3 x 3 sums of the image's quiet sky, scaled counts.
    quiet: i32,
    /// Windows of the image that may fail.
    most_unread: usize,
}

impl Tile<'_> {
    /// Reads the tile and adds its stars to `detections`. Whether `allowance` sufficed for all candidates.
    fn add_stars(
        &self,
        detector: &mut impl Detector<Error = DetectorError>,
        buffer: &mut [u16; TILE_PIXELS],
        allowance: &mut Allowance,
        detections: &mut Detections,
    ) -> Result<bool, DetectorError> {
        let geometry = detector.geometry();
        let Self { across, down, .. } = self;
        let window = Window { x: across.start, y: down.start, width: across.length, height: down.length };
        let pixels = match read(detector, window, buffer) {
            Ok(pixels) => pixels,
            Err(error) => {
                let searched_px = usize::from(across.core_length) * usize::from(down.core_length);
                detections.note_unread(error, searched_px, self.most_unread)?;
                return Ok(true);
            }
        };
        let mut candidates = Vec::new();
        let complete = self.candidates((pixels, geometry.bits), allowance, &mut candidates);
        for index in 0..candidates.len() {
            let candidates = candidates.get_mut(index..).unwrap_or(&mut []);
            let Some(first) = candidates.first().filter(|first| !first.done) else { continue };
            if !allowance.spend(if first.textured { TEXTURED_READING_CYCLES } else { WINDOW_READING_CYCLES })
            {
                return Ok(false);
            }
            let window = first.window(&geometry);
            match read(detector, window, buffer) {
                Ok(pixels) => {
                    let pixels = (pixels, geometry.bits);
                    if !self.measure(candidates, (pixels, window), allowance, detections)? {
                        return Ok(false);
                    }
                }
                Err(error) => {
                    let searched_px = first.core(&window).area();
                    detections.note_unread(error, searched_px, self.most_unread)?;
                }
            }
        }
        Ok(complete)
    }

    /// Measures the first of some candidates in the window about it, and in the same window those after it
    /// that have room there: along a limb and among clouds candidates stand close together, and conditioning
    /// such a window costs more than measuring a star. Whether `allowance` sufficed.
    #[inline(never)]
    fn measure(
        &self,
        candidates: &mut [Candidate],
        ((pixels, bits), window): ((&mut [u16], u8), Window),
        allowance: &mut Allowance,
        detections: &mut Detections,
    ) -> Result<bool, DetectorError> {
        let Self { method, quiet, .. } = *self;
        let residuals = &condition(pixels, window.width.into(), bits).ok_or(DetectorError::BufferLength)?;
        let textured = candidates.first().is_some_and(|first| first.textured);
        let criteria = Criteria { method, threshold_percent: WINDOW_PERCENT, quiet, textured };
        let conditioned = Conditioned::new(residuals, [window.x, window.y], &criteria);
        for (index, candidate) in candidates.iter_mut().enumerate() {
            let here = index == 0 || candidate.textured == textured && candidate.has_room(&window);
            if !here || candidate.done {
                continue;
            }
            candidate.done = true;
            if !conditioned.search(candidate.core(&window), candidate.around, allowance, detections) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The candidates of the tile that was read, the brightest [`MAX_CANDIDATES`] of them first; none of one
    /// at full scale. Whether there was room for all.
    #[inline(never)]
    fn candidates(
        &self,
        (pixels, bits): (&mut [u16], u8),
        allowance: &mut Allowance,
        candidates: &mut Vec<Candidate, MAX_CANDIDATES>,
    ) -> bool {
        if blinded(pixels, bits) {
            return true;
        }
        let Self { across, down, method, quiet, .. } = *self;
        let mut tile = CoarseTile::none();
        if !tile.look_at(pixels, across.length.into(), bits) {
            return true;
        }
        let share = (method.parameters.threshold_sigma_tenths, COARSE_PERCENT);
        let thresholds = thresholds(&tile.noise, texture(quiet, tile.sigma), share);
        let mut peaks = [Peak::default(); MAX_CANDIDATES];
        let search = tile.peaks(&thresholds, allowance.for_boxes(), &mut peaks);
        let paid = allowance.spend(search.cycles);
        for Peak { at, excess } in peaks.iter().take(search.count) {
            let place = at.map(usize::from);
            let [x, y] = *at;
            let at = [across.start + x, down.start + y];
            let within = |at: u16, span: Span| (span.core..span.core + span.core_length).contains(&at);
            if within(at[0], across) && within(at[1], down) && !is_single_pixel(&tile.around(place)) {
                let textured = tile.is_noisy_around(place, quiet * 5 / 2);
                let around = tile.noise_around(place, quiet * 5 / 2);
                // As many as there are peaks.
                let _ = candidates.push(Candidate { at, excess: *excess, textured, around, done: false });
            }
        }
        crate::order::sort(candidates, |a, b| a.excess > b.excess);
        search.all && paid
    }
}

/// Scans the whole detector, tile by tile, and leaves the brightest spots in `detections`, brightest first.
///
/// # Errors
/// Of the detector, where too many windows fail, or one for what was asked.
pub fn scan<'m>(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16; TILE_PIXELS],
    method: impl Into<DetectionMethod<'m>>,
    detections: &mut Detections,
) -> Result<(), DetectorError> {
    let method = &method.into();
    detections.clear();
    let geometry = detector.geometry();
    let most_unread = tiles(&geometry) / UNREAD_SHARE;
    let quiet = quiet_noise(detector, buffer, most_unread, detections)?;
    let mut savings = Savings::new();
    for down in rows(&geometry) {
        for across in columns(&geometry) {
            let tile = Tile { across, down, method, quiet, most_unread };
            let mut allowance = savings.next_tile();
            if !tile.add_stars(detector, buffer, &mut allowance, detections)? {
                detections.note_crowded();
            }
            savings.put_back(allowance);
        }
    }
    detections.settle();
    Ok(())
}

#[cfg(test)]
mod earth_tests;
#[cfg(test)]
mod smear_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod unread_tests;
