//! Is it a star, and where is its centre? (thesis §3.1.1, steps 2 and 3)
//!
//! In: conditioned pixels and the position of a local maximum. Out: a [`Detection`], or `None`.
//!
//! The region is square about the maximum, 5 x 5 to 13 x 13: it grows until the ring around it falls below a
//! share of the maximum, so sharp, blunt and saturated stars are all taken whole; what never falls off is an
//! extended object (Moon, Earth's rim, comet) and refused. The thesis's ratios are then taken between the
//! maximum, the region, the inner ring (half way) and the outer ring (edge); for the 5 x 5 region they are
//! its 3 x 3 and 5 x 5 rings.
//!
//! The maximum of a saturated star is the first corner of its plateau, so the region is first moved to the
//! middle of the light.
//!
//! What stands on something else is no star: around a cloud's hill, on a limb or a terminator the four sides
//! of the ring outside differ, a hill fills the region instead of its middle, and the ring may not be
//! brighter than half of full scale.
//!
//! Centre of intensity: `c = Σ (s - floor) x / Σ (s - floor)` over the region, floor = mean of the ring just
//! outside. Its variance from background noise is `sigma² Σ dx² / flux²`, to which the parameter
//! `centroid_floor_millipx` adds what photon noise and pixel phase leave, and what a floor that slopes may
//! have drawn the centre along.
//!
//! Error of a bright star (Gaussian PSF, any phase): 0.02 px for a PSF sigma of 0.7 px, 0.03 px for 0.9 px,
//! 0.07 px for 1.2 px, 0.11 px for 1.5 px, whose wings the floor cuts. Of faint stars the squared error is
//! 1.0 reported variances on average, and 1 % lie beyond 3 sigma. Cost: about 8,000 cycles a candidate,
//! 14,000 when saturated (Cortex-M4 model, zero wait states).

use super::calibration::Calibration;
use super::matched::{self, Centre};
use super::turn::Turn;
use super::{Detection, DetectionParameters, FULL_SCALE};
use crate::trigonometry::hypotenuse;
use fsw_pixels::condition::Place;
use fsw_pixels::patch::Patch;

/// Half the region's side, smallest to largest.
pub const HALF_SIDES: [usize; 4] = [2, 3, 4, 6];
/// The sides of the ring around a star may differ by this share of its maximum, percent; around what stands
/// on the Earth, on its limb or on a terminator they differ by more.
const UNEVEN_FLOOR_PERCENT: i32 = 25;
/// The 3 x 3 px about the maximum hold at least this share of a star's flux, percent: a Gaussian PSF of 2.0
/// px sigma does. Clouds and hills that fill the largest region hold less.
const CORE_SHARE_PERCENT: i64 = 30;
/// Of a side of n pixels (7 to 15) the sum may differ from another's by (n + 5) / 3 noises of a 3 x 3 sum: of
/// four sides of a flat floor the greatest difference stays within 4.4 sqrt(n) / 3, in 999 of 1000 places.
const SIDE_NOISE_ADDEND: i32 = 5;
/// A star that is told to move by so much, px, and whose image fits that is drawn out.
const LEAST_DRAWN_PX: f32 = 4.0;

/// A spot and what it stands on.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredSpot {
    /// The spot, counted from the window's first pixel.
    pub spot: Detection,
    /// Its floor, scaled counts above the window's levels.
    floor: f32,
    /// How steeply the floor slopes over the spot's flux, 1/px³.
    slope_per_flux: f32,
}

impl MeasuredSpot {
    /// The spot with the centre and the sigma of the lens's profile fitted to it, and the fit itself, which says
    /// whether a single star is seen; `origin` is the window's first pixel on the detector, `turn` draws the
    /// star out. `None` where there is no such centre.
    pub fn fitted(
        &self,
        window: &Place,
        origin: [u16; 2],
        calibration: &Calibration,
        turn: Option<&Turn>,
    ) -> Option<(Detection, Centre)> {
        const ONE_PX: f32 = 65_536.0;
        let centre_q16 = [self.spot.x_q16, self.spot.y_q16];
        let [x, y] = centre_q16.map(|at| (at + (1 << 15)) >> 16);
        let (left, top) = (x.checked_sub(matched::HALF as i32)?, y.checked_sub(matched::HALF as i32)?);
        let (left, top) = (usize::try_from(left).ok()?, usize::try_from(top).ok()?);
        let mut pixels = [[0.0; matched::SIDE]; matched::SIDE];
        for (row, y) in pixels.iter_mut().zip(top..) {
            let run = window.run::<{ matched::SIDE }>(left, y)?;
            row.iter_mut().zip(run).for_each(|(pixel, value)| *pixel = value as f32 - self.floor);
        }
        let [dx, dy] = [self.spot.x_q16 - (x << 16), self.spot.y_q16 - (y << 16)];
        let middle_px = [f32::from(origin[0]) + x as f32, f32::from(origin[1]) + y as f32];
        let moved_px = turn.map_or([0.0; 2], |turn| turn.moved_px(middle_px));
        let spot = matched::Spot {
            pixels: &pixels,
            middle_px,
            moved_px,
            start_px: [dx, dy].map(|offset| offset as f32 / ONE_PX),
            noise: window.sum_sigma as f32 / 3.0,
        };
        let centre = matched::centre(&spot, calibration)?;
        let drawn = self.slope_per_flux * matched::SPREAD;
        let [dx, dy] = centre.at_px.map(|px| libm::rintf(px * ONE_PX) as i32);
        let sigma_px = hypotenuse(centre.sigma_px, drawn);
        let (x_q16, y_q16) = ((x << 16) + dx, (y << 16) + dy);
        let way_px = hypotenuse(moved_px[0], moved_px[1]);
        let drawn_px = if way_px >= LEAST_DRAWN_PX && !centre.misfits { way_px as u8 } else { 0 };
        let backdrop = if centre.all_is_star { 0 } else { window.level(x as usize, y as usize) as u16 };
        let sigma_q16 = (sigma_px * ONE_PX) as i32;
        let spot = Detection { x_q16, y_q16, sigma_q16, drawn_px, backdrop, ..self.spot };
        Some((spot, centre))
    }
}

/// Judges the local maximum at a pixel of the window and centres it. The position returned counts from the
/// window's first pixel. Leaves the pixels about the maximum in `patch`; of a saturated star those about its
/// light.
pub fn measure(
    window: &Place,
    at: [usize; 2],
    parameters: &DetectionParameters,
    patch: &mut Patch,
) -> Option<MeasuredSpot> {
    if !patch.take(window, at) {
        return None;
    }
    let saturated = window.saturated(at);
    if saturated
        && let Some(middle) = patch.middle_of_light()
        && middle != at
    {
        // Where the window ends the patch stays about the maximum.
        let _ = patch.take(window, middle);
    }
    let region = Region::about(window, patch, saturated, parameters)?;
    let slope = region.slope(window, patch)?;
    let Light { flux, core, offset_q16: [offset_x, offset_y] } = region.light(patch, parameters)?;
    let [x, y] = patch.at.map(|at| (at as i32) << 16);
    let Region { floor_sum, floor_count, .. } = region;
    let counts = (flux.min(i64::from(i32::MAX)) as i32).checked_div(floor_count).unwrap_or(0).max(1);
    let spread = region.spread();
    // Where neighbours go together the noise of a region is larger than its pixels' noise says.
    let noise = window.sum_sigma as f32 / 3.0 * libm::sqrtf(spread as f32) / counts as f32;
    let phase_error = f32::from(parameters.centroid_floor_millipx) * 1e-3;
    // A floor that slopes draws the centre along: by its slope times the spread, over the flux.
    let slope_per_flux = slope as f32 / (region.run() as f32 * counts as f32);
    let drawn = slope_per_flux * spread as f32;
    let spot = Detection {
        core_flux: if saturated { i32::MAX } else { core },
        x_q16: x + offset_x,
        y_q16: y + offset_y,
        flux: counts,
        sigma_q16: (libm::sqrtf(noise * noise + phase_error * phase_error + drawn * drawn) * 65_536.0) as i32,
        saturated,
        extended: false,
        drawn_px: 0,
        blended: false,
        repeated: false,
        number: 0,
        backdrop: 0,
    };
    Some(MeasuredSpot { spot, floor: floor_sum as f32 / floor_count as f32, slope_per_flux })
}

/// The square of pixels that holds a maximum's light, and the floor that the ring around it shows.
struct Region {
    /// Half its side less the middle pixel.
    half: usize,
    /// Sum and number of the ring's pixels, and their mean.
    floor_sum: i32,
    floor_count: i32,
    floor: i32,
    /// The middle pixel above the floor.
    maximum: i32,
    /// What a skirt may hold, without the noise.
    skirt: i32,
    saturated: bool,
}

/// The light of a region above its floor.
struct Light {
    /// In units of 1 / `floor_count`.
    flux: i64,
    /// Of the middle 3 x 3 pixels.
    core: i32,
    /// Its centre from the middle pixel.
    offset_q16: [i32; 2],
}

impl Region {
    /// The smallest one with no skirt around it; `None` where it does not rise as a star does.
    #[inline(always)]
    fn about(
        window: &Place,
        patch: &Patch,
        saturated: bool,
        parameters: &DetectionParameters,
    ) -> Option<Self> {
        let peak = patch.square(0).max(1);
        let share = peak * i32::from(parameters.skirt_share_percent) / 100;
        // Noise of a ring's mean must not pass for a skirt.
        let skirt = share.max(window.sigma);
        let half = HALF_SIDES.into_iter().find(|half| {
            let (sum, count) = patch.ring(half + 1);
            sum <= skirt * count
        })?;
        let (floor_sum, floor_count) = patch.ring(half + 1);
        // Never zero; the checked division is for the linker, which wants proof.
        let floor = floor_sum.checked_div(floor_count).unwrap_or(0);
        let mean = |radius: usize| {
            let (sum, count) = patch.ring(radius);
            sum.checked_div(count).unwrap_or(0) - floor
        };
        let [x, y] = patch.at;
        if floor + window.level(x, y) > FULL_SCALE / 2 {
            return None;
        }
        let (inner, outer) = (mean(half / 2), mean(half));
        let maximum = peak - floor;
        let exceeds = |value: i32, percent: u16, other: i32| value * 100 > i32::from(percent) * other;
        let rises = exceeds(inner, parameters.inner_to_outer_percent, outer)
            && inner * 100 >= i32::from(parameters.inner_share_percent) * maximum
            && (saturated || exceeds(maximum, parameters.peak_to_inner_percent, inner));
        rises.then_some(Self { half, floor_sum, floor_count, floor, maximum, skirt: share, saturated })
    }

    /// Pixels of each of the four sides of the ring.
    fn side_count(&self) -> i32 {
        2 * self.half as i32 + 3
    }

    /// By how much the floor rises from a side to the one across beyond noise, a side's sum; `None` where it
    /// is too uneven for a star's.
    #[inline(always)]
    fn slope(&self, window: &Place, patch: &Patch) -> Option<i32> {
        let [left, right, top, bottom] = patch.sides(self.half);
        let uneven = left.max(right).max(top).max(bottom) - left.min(right).min(top).min(bottom);
        let noise = window.sum_sigma * (self.side_count() + SIDE_NOISE_ADDEND) / 3;
        if uneven > noise && uneven * 100 > UNEVEN_FLOOR_PERCENT * self.maximum * self.side_count() {
            return None;
        }
        Some(((left - right).abs().max((top - bottom).abs()) - noise / 2).max(0))
    }

    /// Pixels of a side times those from one to the one across.
    fn run(&self) -> i32 {
        self.side_count() * (2 * self.half as i32 + 2)
    }

    /// Σ dx² over the region = side · reach (reach + 1) side / 3.
    fn spread(&self) -> i32 {
        let reach = self.half as i32;
        let side = 2 * reach + 1;
        side * side * reach * (reach + 1) / 3
    }

    /// Its light; `None` where that is not gathered about its middle.
    #[inline(always)]
    fn light(&self, patch: &Patch, parameters: &DetectionParameters) -> Option<Light> {
        let Self { half, floor_sum, floor_count, floor, maximum, skirt, saturated } = *self;
        // Sums in units of 1 / floor_count, so that the floor is exact; about the middle it has no moment.
        let reach = half as i32;
        let side = 2 * reach + 1;
        let area = i64::from(side * side);
        let [sum, moment_x, moment_y] =
            patch.moments(half).map(|sum| i64::from(sum) * i64::from(floor_count));
        let flux = sum - i64::from(floor_sum) * area;
        let peaked = i64::from(maximum) * 100 * area * i64::from(floor_count)
            > flux * i64::from(parameters.peak_to_region_percent);
        // A saturated plateau has no peak; a dark ring about a region below the largest tells that it is
        // small.
        let small_plateau = saturated && floor <= skirt && HALF_SIDES.last() != Some(&half);
        let core = (patch.square(1) * floor_count - 9 * floor_sum).checked_div(floor_count).unwrap_or(0);
        let compact = i64::from(core) * 100 * i64::from(floor_count) >= flux * CORE_SHARE_PERCENT;
        if flux <= 0 || !(peaked && (compact || saturated) || small_plateau) {
            return None;
        }
        // Single precision resolves a millionth of a pixel here and needs a hundredth of a long division's
        // time.
        let per_pixel = 65_536.0 / flux as f32;
        let offset_q16 = [moment_x, moment_y].map(|moment| (moment as f32 * per_pixel) as i32);
        // A centre far from its maximum is two stars or an edge.
        let limit = reach << 15;
        offset_q16.iter().all(|offset| offset.abs() <= limit).then_some(Light { flux, core, offset_q16 })
    }
}
