//! Finds the stars of a window, and of a whole detector read tile by tile.
//!
//! In: a [`Detector`] and a buffer of [`TILE_PIXELS`]. Out: the brightest [`MAX_DETECTIONS`] star-like spots,
//! brightest first.
//!
//! A scan looks at every pixel once, in tiles of at most [`TILE_WIDTH`] x [`TILE_HEIGHT`] px that overlap by
//! what a local maximum needs (`coarse`): the candidates are the local maxima of 3 x 3 sums above a threshold
//! of the tile's own noise. Their cores partition the detector, so each star is found once and the image is
//! never held whole. A window of `SIDE` px about each candidate is then read, conditioned and searched at
//! the candidate's place, by the same steps that find a tracked star in its window. 0.4 false stars a
//! megapixel of Gaussian noise at the default threshold (thesis §3.1.1 fixes 6 % of full scale).
//!
//! A tile at full scale (`blinding`) is left at once. Where there is texture instead of noise (clouds, a
//! limb) the threshold is `TEXTURE_FACTOR` times higher, and a candidate's window has `TEXTURED_SIDES` px,
//! in which the noise of cells is known.
//!
//! Cost of the reference detector (1280 x 1024 px, 10 bit; Cortex-M4 model, zero wait states, without the
//! reading): at most 55.5 million cycles in the seconds that `cargo budget` flies, those of a search for lines
//! (`streaks`) among them; of a scan at most [`bound_cycles`] (`allowance`).

use super::allowance::{
    self, Allowance, CANDIDATE_CYCLES, FIT_CYCLES, SECOND_LOOK_CYCLES, Savings, TEXTURED_READING_CYCLES,
    WINDOW_READING_CYCLES,
};
use super::blinding::{blinded, is_washed};
use super::centroid::{MeasuredSpot, measure};
pub use super::detections::{Detections, MAX_DETECTIONS, MAX_STREAK_PLACES};
use super::peaks::for_each_peak;
use super::shape::{Shape, is_streak, shape};
use super::{Detection, DetectionMethod, FULL_SCALE};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use fsw_pixels::coarse::{BAND, CoarseTile, EDGE, Peak, SEGMENT, TILE_HEIGHT, TILE_WIDTH};
use fsw_pixels::condition::{Place, Residuals, condition};
use fsw_pixels::light::is_single_pixel;
use fsw_pixels::patch::{MARGIN, Patch};
use fsw_pixels::window::{Cells, MAX_HEIGHT, MAX_WIDTH};
use heapless::Vec;

/// Length of the readout buffer, px.
pub const TILE_PIXELS: usize = MAX_WIDTH * MAX_HEIGHT;

/// Texture is what is more than so many times as noisy as quiet sky ...
const NOISY: i32 = 2;
/// ... and where neighbours go together. Of white noise a 3 x 3 sum has 3 sigmas of a pixel, of real skies
/// after interpolation and compression up to 5; in halves.
const CORRELATED_HALVES: i32 = 11;
/// In texture the threshold is that many times higher: it has no Gaussian's tails.
const TEXTURE_FACTOR: i32 = 3;
/// What rises so many times the noise around it above its own is no hill of a texture.
const HILL_FACTOR: i32 = 8;
/// Of a star with less light than so many noises of a pixel noise feigns a shape, one in a hundred: where the
/// lens's profile leaves nothing of it, it is a single star.
const FAINT_SIGMAS: i32 = 200;
/// Largest threshold: whatever is around it, a saturated star exceeds it.
const MAX_THRESHOLD: i32 = 4 * FULL_SCALE;
/// Where quiet sky is not known it is taken for this: texture begins at a sixty-fourth of full scale in a
/// pixel.
const QUIET: i32 = FULL_SCALE / 64 * CORRELATED_HALVES / (2 * NOISY);
/// Side of the window in which a candidate is measured, px: room for a patch that moves by 6 px.
const SIDE: u16 = 27;
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
/// Columns and rows of the places at which a scan first learns how noisy quiet sky is, and the side of each,
/// px.
const SURVEY: [u16; 2] = [8, 6];
const SURVEY_PX: u16 = 16;
/// Of these places the share that is surely quiet: a limb, a Moon or clouds may take the others.
const QUIET_SHARE: usize = 6;

/// Noise of 3 x 3 sums beyond which there is texture, from that of quiet sky and that of a pixel, scaled
/// counts.
fn texture(quiet: i32, sigma: i32) -> i32 {
    (NOISY * quiet).max(CORRELATED_HALVES * sigma / 2)
}

/// What a 3 x 3 sum must exceed in each cell, from the noise of its sums and that from which on it is texture,
/// scaled counts: so many tenths of a sigma, and of that so many percent.
fn thresholds<const S: usize, const B: usize>(
    noise: &[[i32; S]; B],
    texture: i32,
    (tenths, percent): (u16, i32),
) -> [[i32; S]; B] {
    let mut thresholds = [[0; S]; B];
    // Most cells are as noisy as the one before.
    let mut last = (0, 0);
    for (threshold, noise) in thresholds.as_flattened_mut().iter_mut().zip(noise.as_flattened()) {
        if *noise != last.0 {
            let factor = if *noise > texture { TEXTURE_FACTOR } else { 1 };
            let whole = (noise * i32::from(tenths) * factor / 10).min(MAX_THRESHOLD);
            last = (*noise, whole * percent / 100);
        }
        *threshold = last.1;
    }
    thresholds
}

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
}

/// How stars are told in a window.
struct Criteria<'m> {
    method: &'m DetectionMethod<'m>,
    /// Share of the threshold that a peak must exceed, percent.
    threshold_percent: i32,
    /// Noise of 3 x 3 sums of quiet sky, scaled counts.
    quiet: i32,
    /// Whether the noise of its cells says where the window has texture; else it has none.
    textured: bool,
    /// Noise around the place that the tile showed, scaled counts; 0 where that was quiet.
    around: i32,
}

/// A conditioned window whose stars are searched.
struct Conditioned<'w> {
    residuals: &'w Residuals<'w>,
    /// The window's first pixel on the detector.
    origin: [u16; 2],
    criteria: &'w Criteria<'w>,
}

impl Conditioned<'_> {
    /// What a 3 x 3 sum must exceed in each cell, scaled counts.
    fn thresholds(&self) -> Cells<i32> {
        let Criteria { method, threshold_percent, quiet, textured, .. } = *self.criteria;
        let texture = if textured { texture(quiet, self.residuals.sigma) } else { i32::MAX };
        let share = (method.parameters.threshold_sigma_tenths, threshold_percent);
        thresholds(self.residuals.noise(), texture, share)
    }

    /// Adds every spot whose maximum lies in `core`, counted in window pixels and at least [`MARGIN`] inside
    /// the window. Whether the allowance sufficed.
    fn search(&self, core: Window, allowance: &mut Allowance, detections: &mut Detections) -> bool {
        for_each_peak(self.residuals, core, &self.thresholds(), allowance, |x, y, allowance| {
            self.judge([x, y], allowance, detections)
        })
    }

    /// Judges a maximum and adds what it is; whether the allowance sufficed.
    fn judge(&self, [x, y]: [usize; 2], allowance: &mut Allowance, detections: &mut Detections) -> bool {
        if !allowance.spend(CANDIDATE_CYCLES + SECOND_LOOK_CYCLES) {
            return false;
        }
        let Criteria { method, quiet, around, .. } = *self.criteria;
        let around = around.max(self.residuals.noise_around(x, y, quiet * 5 / 2));
        let window = self.residuals.about(x, y);
        let mut patch = Patch::EMPTY;
        let mut look = |at: [usize; 2]| Some((at, measure(&window, at, method.parameters, &mut patch)?));
        let at_once = look([x, y]);
        let again = at_once.is_none();
        // An image that is not round has its brightest pixel beside the middle of its brightest nine.
        let seen = at_once.or_else(|| look(window.brightest_near(x, y)));
        let Some((at, measured)) = seen else {
            if around == 0 && is_streak(&window, x, y) {
                detections.note_streak(self.on_detector([x, y]));
            }
            return true;
        };
        let extended = measured.spot.core_flux < HILL_FACTOR * around;
        let shape = shape(&window, &mut patch, &Detection { extended, ..measured.spot });
        if !again && matches!(shape, Shape::Star(Detection { drawn_px: 0, .. })) {
            allowance.give_back(SECOND_LOOK_CYCLES);
        }
        match shape {
            // What is drawn out among clouds is a cloud's, and none of a star.
            Shape::Streak if !extended => detections.note_streak(self.on_detector(at)),
            Shape::Star(star) => {
                // Its centre matters to none where it is too faint to be kept.
                let kept = detections.keeps(&star);
                let star = if kept { self.fitted(&window, star, &measured, allowance) } else { star };
                let [x, y] = self.origin.map(|at| i32::from(at) << 16);
                detections.insert(Detection { x_q16: star.x_q16 + x, y_q16: star.y_q16 + y, ..star });
            }
            Shape::Streak | Shape::Hit => {}
        }
        true
    }

    /// The star with its centre by the lens's profile, where that is known, fits and can be paid for.
    fn fitted(
        &self,
        window: &Place,
        star: Detection,
        measured: &MeasuredSpot,
        allowance: &mut Allowance,
    ) -> Detection {
        let single = star.is_single();
        let feigned = !star.extended && star.flux < FAINT_SIGMAS * window.sigma;
        self.criteria
            .method
            .calibration
            .filter(|_| (single || feigned) && allowance.spend(FIT_CYCLES))
            .and_then(|calibration| measured.fitted(window, self.origin, calibration))
            .filter(|(_, all_is_star)| single || *all_is_star)
            .map_or(star, |(star, _)| star)
    }

    /// A window's pixel counted on the detector.
    fn on_detector(&self, [x, y]: [usize; 2]) -> [u16; 2] {
        let [left, top] = self.origin;
        [left + x as u16, top + y as u16]
    }
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

/// Reads a window and adds its stars to `detections`, in detector coordinates. The margin of the window is
/// not searched. Gives whether the window is [washed out](is_washed).
///
/// # Errors
/// Of the detector; a window that [`condition`] cannot serve gives [`DetectorError::BufferLength`].
pub fn read_stars<'m>(
    detector: &mut impl Detector<Error = DetectorError>,
    window: Window,
    buffer: &mut [u16; TILE_PIXELS],
    method: impl Into<DetectionMethod<'m>>,
    detections: &mut Detections,
) -> Result<bool, DetectorError> {
    let bits = detector.geometry().bits;
    let pixels = read(detector, window, buffer)?;
    // Before they are conditioned: values of more than 14 bits lose their last ones then.
    let washed = is_washed(pixels, bits);
    let method = &method.into();
    let criteria = Criteria { method, threshold_percent: 100, quiet: QUIET, textured: true, around: 0 };
    let margin = MARGIN as u16;
    let core = Window {
        x: margin,
        y: margin,
        width: window.width.saturating_sub(2 * margin),
        height: window.height.saturating_sub(2 * margin),
    };
    if !blinded(pixels, bits) {
        let allowance = &mut Allowance::of_a_window();
        if !add_stars((pixels, bits), (window, core), &criteria, allowance, detections)? {
            detections.note_crowded();
        }
    }
    Ok(washed)
}

/// The pixels of a window.
fn read<'b>(
    detector: &mut impl Detector<Error = DetectorError>,
    window: Window,
    buffer: &'b mut [u16; TILE_PIXELS],
) -> Result<&'b mut [u16], DetectorError> {
    let pixels = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
    detector.read(window, pixels)?;
    Ok(pixels)
}

/// Adds the stars whose maxima lie in `core`, counted from the window's first pixel, of a window that was
/// read, at the cost of `allowance`; whether that sufficed.
#[inline(never)]
fn add_stars(
    (pixels, bits): (&mut [u16], u8),
    (window, core): (Window, Window),
    criteria: &Criteria,
    allowance: &mut Allowance,
    detections: &mut Detections,
) -> Result<bool, DetectorError> {
    let Some(residuals) = &condition(pixels, usize::from(window.width), bits) else {
        return Err(DetectorError::BufferLength);
    };
    Ok(Conditioned { residuals, origin: [window.x, window.y], criteria }.search(core, allowance, detections))
}

/// The candidates of a tile that was read, the brightest [`MAX_CANDIDATES`] of them first; none of one at
/// full scale. Whether there was room for all.
#[inline(never)]
fn candidates(
    (pixels, bits): (&mut [u16], u8),
    [across, down]: [Span; 2],
    (method, quiet): (&DetectionMethod, i32),
    allowance: &mut Allowance,
    candidates: &mut Vec<Candidate, MAX_CANDIDATES>,
) -> bool {
    candidates.clear();
    if blinded(pixels, bits) {
        return true;
    }
    let Some(tile) = &CoarseTile::of(pixels, usize::from(across.length), bits) else { return true };
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
            let _ = candidates.push(Candidate { at, excess: *excess, textured, around });
        }
    }
    crate::order::sort(candidates, |a, b| a.excess > b.excess);
    search.all && paid
}

/// The window about a candidate, and within it the pixels at which the maximum may stand.
fn window_about(candidate: &Candidate, geometry: &DetectorGeometry) -> (Window, Window) {
    let [sides_x, sides_y] = if candidate.textured { TEXTURED_SIDES } else { [SIDE; 2] };
    let [x, y] = candidate.at;
    let along = |at: u16, side: u16, length: u16| {
        let side = side.min(length);
        let start = at.saturating_sub(side / 2).min(length - side);
        let first = (at - start).saturating_sub(1).max(MARGIN as u16);
        let end = (at - start + 2).min(side.saturating_sub(MARGIN as u16));
        (start, side, first, end.saturating_sub(first))
    };
    let ((x, width, first_x, core_width), (y, height, first_y, core_height)) =
        (along(x, sides_x, geometry.width_px), along(y, sides_y, geometry.height_px));
    (
        Window { x, y, width, height },
        Window { x: first_x, y: first_y, width: core_width, height: core_height },
    )
}

/// Noise of 3 x 3 sums of the image's quietest parts, scaled counts, from small windows all over the
/// detector.
fn quiet_noise(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16; TILE_PIXELS],
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
            let pixels = read(detector, window, buffer)?;
            if let Some(residuals) = condition(pixels, usize::from(width), geometry.bits) {
                // There are no more places than the list holds.
                let _ = noise.push(residuals.sum_sigma);
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

/// The most that a scan of the detector can cost, cycles of the Cortex-M4 model, the reading of the pixels
/// not counted.
pub fn bound_cycles(geometry: &DetectorGeometry) -> u64 {
    let tiles = columns(geometry).count() * rows(geometry).count();
    allowance::bound_cycles(tiles as u32)
}

/// Scans the whole detector, tile by tile, and leaves the brightest spots in `detections`, brightest first.
///
/// # Errors
/// Of the detector, at the first window that fails.
pub fn scan<'m>(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16; TILE_PIXELS],
    method: impl Into<DetectionMethod<'m>>,
    detections: &mut Detections,
) -> Result<(), DetectorError> {
    let method = method.into();
    detections.clear();
    let geometry = detector.geometry();
    let quiet = quiet_noise(detector, buffer)?;
    let mut savings = Savings::new();
    let mut found = Vec::new();
    for down in rows(&geometry) {
        for across in columns(&geometry) {
            let mut allowance = savings.next_tile();
            let window = Window { x: across.start, y: down.start, width: across.length, height: down.length };
            let pixels = read(detector, window, buffer)?;
            let mut complete = candidates(
                (pixels, geometry.bits),
                [across, down],
                (&method, quiet),
                &mut allowance,
                &mut found,
            );
            for candidate in &found {
                let price = if candidate.textured { TEXTURED_READING_CYCLES } else { WINDOW_READING_CYCLES };
                if !allowance.spend(price) {
                    complete = false;
                    break;
                }
                let (window, core) = window_about(candidate, &geometry);
                let pixels = read(detector, window, buffer)?;
                let criteria = Criteria {
                    method: &method,
                    threshold_percent: WINDOW_PERCENT,
                    quiet,
                    textured: candidate.textured,
                    around: candidate.around,
                };
                let image = (pixels, geometry.bits);
                if !add_stars(image, (window, core), &criteria, &mut allowance, detections)? {
                    complete = false;
                    break;
                }
            }
            if !complete {
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
mod tests;
