//! Finds the stars of a window: those whose maxima lie in its core.
//!
//! In: a conditioned window, how stars are told ([`Criteria`]), the cores in which they are sought. Out: star-like
//! spots in [`Detections`].
//! A maximum that exceeds the threshold of its cell is measured (`centroid`), told from streaks and hits by
//! its shape (`shape`) and, where the lens's profile is known, centred by it (`matched`). Each step is paid
//! from an [`Allowance`]. Where there is texture instead of noise (clouds, a limb) the threshold is
//! `TEXTURE_FACTOR` times higher.

use super::allowance::{Allowance, CANDIDATE_CYCLES, FIT_CYCLES, SECOND_LOOK_CYCLES};
use super::blinding::{blinded, is_washed};
use super::centroid::{MeasuredSpot, measure};
use super::detections::Detections;
use super::matched::Centre;
use super::peaks::for_each_peak;
use super::shape::{Shape, is_streak, shape};
use super::{Detection, DetectionMethod, FULL_SCALE};
use fsw_hal::{Detector, DetectorError, Window};
use fsw_pixels::condition::{Place, Residuals, condition};
use fsw_pixels::patch::{MARGIN, Patch};
use fsw_pixels::window::{Cells, MAX_HEIGHT, MAX_WIDTH};

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
/// Of one with more light than so many its shape shows whether it is drawn out.
const CLEAR_SIGMAS: i32 = 50;
/// Largest threshold: whatever is around it, a saturated star exceeds it.
const MAX_THRESHOLD: i32 = 4 * FULL_SCALE;
/// Where quiet sky is not known it is taken for this: texture begins at a sixty-fourth of full scale in a
/// pixel.
pub(super) const QUIET: i32 = FULL_SCALE / 64 * CORRELATED_HALVES / (2 * NOISY);
/// Noise of 3 x 3 sums beyond which there is texture, from that of quiet sky and that of a pixel, scaled
/// counts.
pub(super) fn texture(quiet: i32, sigma: i32) -> i32 {
    (NOISY * quiet).max(CORRELATED_HALVES * sigma / 2)
}

/// What a 3 x 3 sum must exceed in each cell, from the noise of its sums and that from which on it is texture,
/// scaled counts: so many tenths of a sigma, and of that so many percent.
pub(super) fn thresholds<const S: usize, const B: usize>(
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

/// How stars are told in a window.
pub(super) struct Criteria<'m> {
    pub(super) method: &'m DetectionMethod<'m>,
    /// Share of the threshold that a peak must exceed, percent.
    pub(super) threshold_percent: i32,
    /// Noise of 3 x 3 sums of quiet sky, scaled counts.
    pub(super) quiet: i32,
    /// Whether the noise of its cells says where the window has texture; else it has none.
    pub(super) textured: bool,
}

/// A conditioned window whose stars are searched.
pub(super) struct Conditioned<'w> {
    residuals: &'w Residuals<'w>,
    /// The window's first pixel on the detector.
    origin: [u16; 2],
    criteria: &'w Criteria<'w>,
    /// What a 3 x 3 sum must exceed in each cell, scaled counts.
    thresholds: Cells<i32>,
}

impl<'w> Conditioned<'w> {
    /// The window whose first pixel has this place on the detector.
    pub(super) fn new(residuals: &'w Residuals<'w>, origin: [u16; 2], criteria: &'w Criteria<'w>) -> Self {
        let Criteria { method, threshold_percent, quiet, textured } = *criteria;
        let texture = if textured { texture(quiet, residuals.sigma) } else { i32::MAX };
        let share = (method.parameters.threshold_sigma_tenths, threshold_percent);
        Self { residuals, origin, criteria, thresholds: thresholds(residuals.noise(), texture, share) }
    }

    /// Adds every spot whose maximum lies in `core`, counted in window pixels and at least [`MARGIN`] inside
    /// the window. `around` is the noise that is known from elsewhere to be around them, scaled counts; 0
    /// where that is quiet. Whether the allowance sufficed.
    #[inline(never)]
    pub(super) fn search(
        &self,
        core: Window,
        around: i32,
        allowance: &mut Allowance,
        detections: &mut Detections,
    ) -> bool {
        for_each_peak(self.residuals, core, &self.thresholds, allowance, |x, y, allowance| {
            self.judge([x, y], around, allowance, detections)
        })
    }

    /// Judges a maximum and adds what it is; whether the allowance sufficed.
    fn judge(
        &self,
        [x, y]: [usize; 2],
        around: i32,
        allowance: &mut Allowance,
        detections: &mut Detections,
    ) -> bool {
        if !allowance.spend(CANDIDATE_CYCLES + SECOND_LOOK_CYCLES) {
            return false;
        }
        let Criteria { method, quiet, .. } = *self.criteria;
        let around = around.max(self.residuals.noise_around(x, y, quiet * 5 / 2));
        let window = self.residuals.about(x, y);
        let mut patch = Patch::EMPTY;
        let mut look = |at: [usize; 2]| Some((at, measure(&window, at, method.parameters, &mut patch)?));
        let at_once = look([x, y]);
        let again = at_once.is_none();
        // An image that is not round has its brightest pixel beside the middle of its brightest nine.
        let seen = at_once.or_else(|| look(window.brightest_near(x, y)));
        let Some((at, mut measured)) = seen else {
            if around == 0 && is_streak(&window, x, y) {
                detections.evidence().note_streak(self.on_detector([x, y]), self.residuals.level(x, y));
            }
            return true;
        };
        let extended = measured.spot.core_flux < HILL_FACTOR * around;
        measured.spot.extended = extended;
        let shape = shape(&window, &mut patch, &measured.spot);
        if !again && matches!(shape, Shape::Star(Detection { drawn_px: 0, .. })) {
            allowance.give_back(SECOND_LOOK_CYCLES);
        }
        match shape {
            // What is drawn out among clouds is a cloud's, and none of a star.
            Shape::Streak if !extended => {
                detections.evidence().note_streak(self.on_detector(at), self.residuals.level(x, y));
            }
            Shape::Star(star) => {
                // Its centre matters to none where it is too faint to be kept.
                let kept = detections.keeps(&star);
                let fitted = if kept { self.fitted(&window, star, &measured, allowance) } else { None };
                let misfits = fitted.as_ref().is_some_and(|(_, centre)| centre.misfits);
                // A faint one counts where its shape and its fit say the same.
                let looks_drawn = star.drawn_px > 0;
                let mut star = fitted.map_or(star, |(star, _)| star);
                let [x, y] = self.origin.map(|at| i32::from(at) << 16);
                let clear = star.flux > CLEAR_SIGMAS * window.sigma || looks_drawn && star.drawn_px > 0;
                star.x_q16 += x;
                star.y_q16 += y;
                if detections.insert(star) {
                    let background = self.residuals.level(at[0], at[1]);
                    detections.evidence().note_spot(&star, background, clear, misfits);
                }
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
    ) -> Option<(Detection, Centre)> {
        let Detection { extended, drawn_px, flux, .. } = star;
        let single = star.is_single();
        let feigned = flux < FAINT_SIGMAS * window.sigma;
        let told = drawn_px > 0 && self.criteria.method.turn.is_some();
        self.criteria
            .method
            .calibration
            .filter(|_| (single || !extended && (feigned || told)) && allowance.spend(FIT_CYCLES))
            .and_then(|calibration| {
                measured.fitted(window, self.origin, calibration, self.criteria.method.turn.as_ref())
            })
            .filter(|(spot, centre)| single || centre.all_is_star || spot.drawn_px > 0)
    }

    /// A window's pixel counted on the detector.
    fn on_detector(&self, [x, y]: [usize; 2]) -> [u16; 2] {
        let [left, top] = self.origin;
        [left + x as u16, top + y as u16]
    }
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
    if !blinded(pixels, bits) && !add_stars((pixels, bits), window, &method.into(), detections)? {
        detections.note_crowded();
    }
    Ok(washed)
}

/// The pixels of a window.
pub(super) fn read<'b>(
    detector: &mut impl Detector<Error = DetectorError>,
    window: Window,
    buffer: &'b mut [u16; TILE_PIXELS],
) -> Result<&'b mut [u16], DetectorError> {
    let pixels = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
    detector.read(window, pixels)?;
    Ok(pixels)
}

/// Adds the stars of a window that was read, its margin left out; whether the allowance sufficed.
#[inline(never)]
fn add_stars(
    (pixels, bits): (&mut [u16], u8),
    window: Window,
    method: &DetectionMethod,
    detections: &mut Detections,
) -> Result<bool, DetectorError> {
    let residuals = &condition(pixels, window.width.into(), bits).ok_or(DetectorError::BufferLength)?;
    let criteria = Criteria { method, threshold_percent: 100, quiet: QUIET, textured: true };
    let margin = MARGIN as u16;
    let core = Window {
        x: margin,
        y: margin,
        width: window.width.saturating_sub(2 * margin),
        height: window.height.saturating_sub(2 * margin),
    };
    let window = Conditioned::new(residuals, [window.x, window.y], &criteria);
    Ok(window.search(core, 0, &mut Allowance::of_a_window(), detections))
}
