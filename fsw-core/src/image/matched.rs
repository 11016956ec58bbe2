//! The centre of a star whose image is known: its profile is fitted, then the correction table is applied.
//!
//! In: the pixels about a star above its floor, a first centre, where on the detector it stands, the
//! [`Calibration`]. Out: the centre and its standard deviation, px.
//!
//! The thesis takes the centre of intensity (§3.1.2), which weighs a pixel by its distance: far ones, in
//! which there is only noise, most. Here the light `N f(x - c) + b` of a star of flux `N` at `c` on a floor
//! `b` is fitted by two steps of Gauss and Newton, each pixel weighed with `q = 1 / (f + β)`; first `N` and
//! `b` by least squares, then
//!
//! `c += G⁻¹ Σ q g (s - N f - b) / N`, `g = -∇f`, `G = Σ q g gᵀ`.
//!
//! With the true variance for `f + β` no unbiased estimate has less scatter (Cramer-Rao). `β` is that of the
//! star, as the first step has it, but never below [`BETA`]: so the error without noise is the same for all
//! stars in which it shows, and one table corrects it. The profile is that of the nearest radius, turned to
//! the star's place in the field.
//!
//! Of a star that the sensor's turning is known to move by half a pixel and more in the exposure, the profile
//! is the mean of those at two to four places of its way, and the correction the mean along it. The profile
//! of a star at rest would be wrong by the pixel's phase: of a sharp lens by 0.025 px, rms, where the star
//! moves by 1 px, by 0.08 px at 2 to 3 px.
//!
//! What the fit leaves, over what noise alone would, also says whether anything else than a single star is
//! there: of faint stars better than moments do, in which noise feigns a shape.
//!
//! Variance an axis: `Σ q² g² (noise² + N f / e) / (N G)²`, `e` electrons a count, times what the fit leaves
//! over what noise would leave, where that is more (a proton, a hot pixel or another star is in it), and the
//! square of what the table leaves.

use super::calibration::Calibration;
pub use fsw_pixels::profile::{HALF, SIDE};
use fsw_pixels::profile::{Star, Sums, Way};

/// Half the side of the square that a Gauss-Newton step asks from the centre of intensity, px; of the last
/// one too where the star moves, which is asked in several places.
const NEAR: usize = 3;
/// The same of the steps of a star at rest.
const STEPS: [usize; 2] = [NEAR, HALF];
/// Least variance of a pixel over the flux, both in electrons: that of a star of V = 4 in the reference
/// camera. Of the brightest stars photon noise would have less, at the price of a table for every brightness.
pub const BETA: f32 = 0.08;
/// Most of it: fainter stars are lost in the noise.
const BETA_MOST: f32 = 0.4;
/// What a floor that slopes draws a fitted centre along by, over the slope and the flux, as `Σ dx²` over the
/// region does a centre of intensity: `8 π sigma⁴` of a Gaussian of 1.1 px.
pub const SPREAD: f32 = 40.0;
/// Error that a profile may have in a pixel, share of its light: pixels that are not sensitive throughout,
/// other colours.
const PROFILE_ERROR: f32 = 0.15;
/// The fit is bad where it leaves so many times what noise would: of 60 pixels chance does it once in 1,000.
const BAD_FIT: f32 = 1.6;
/// By how much more than its linear part says the variance of a faint star grows with itself, 1/px²: the
/// slopes are taken where the noise has moved the profile to. Measured on the reference lens: V = 5 and 6.
const FAINT_PER_PX2: f32 = 40.0;
/// A star that moves less is taken for one at rest, px.
pub const LEAST_WAY_PX: f32 = 0.5;
/// One that moves by less than this and one less is as if it stood in two or three places, else in four.
const LONG_WAYS_PX: [f32; 2] = [2.0, 3.0];
/// The way over the step between two of its places: the root of the square of their number less one.
const STEPS_OF: [f32; 3] = [1.732_050_8, 2.828_427, 3.872_983_5];
/// Error along its way of a bright star that moves, beyond what it has at rest, share of the way: of 9,000
/// stars in flights that turned at up to 5 deg/s.
const MOVED_SHARE: f32 = 0.02;
/// Points of a star's way at which the correction is looked up.
const CORRECTED_POINTS: u8 = 5;
/// Longest step, px.
const STEP_MAX_PX: f32 = 0.5;
/// Farthest from the first centre, px: else it was no single star.
const FARTHEST_PX: f32 = 1.0;
/// A spot to be centred.
#[derive(Clone, Copy, Debug)]
pub struct Spot<'p> {
    /// Pixels about it, above its floor, scaled counts.
    pub pixels: &'p [[f32; SIDE]; SIDE],
    /// Column and row of the middle pixel on the detector, px.
    pub middle_px: [f32; 2],
    /// Centre of intensity from the middle pixel, px.
    pub start_px: [f32; 2],
    /// Noise of a pixel, scaled counts.
    pub noise: f32,
    /// How far the star moves in the exposure, px.
    pub moved_px: [f32; 2],
}

/// A star's centre.
#[derive(Clone, Copy, Debug)]
pub struct Centre {
    /// From the middle pixel, px.
    pub at_px: [f32; 2],
    /// Standard deviation an axis, px.
    pub sigma_px: f32,
    /// Whether what the fit leaves is no more than noise alone would leave: that it is a single star that moves
    /// as is told, and nothing beside it.
    pub all_is_star: bool,
    /// Whether it leaves more than noise and an inexact profile would: it moves otherwise than is told, or
    /// something else is in it.
    pub misfits: bool,
}

/// A step of the fit.
struct Step {
    /// Along and across the field's radius, px.
    along_across: [f32; 2],
    /// Of the centre an axis, px².
    variance: f32,
    /// Mean square of what the fit leaves, over what noise and an inexact profile would leave.
    misfit: f32,
    /// The same over what noise alone would leave.
    beyond_noise: f32,
    /// Light of the star, scaled counts.
    flux: f32,
}

/// The centre; `None` where there is none near the first one.
pub fn centre(spot: &Spot, calibration: &Calibration) -> Option<Centre> {
    let [middle_x, middle_y] = spot.middle_px;
    let [start_x, start_y] = spot.start_px;
    let [centre_x, centre_y] = calibration.centre_px();
    let (field_x, field_y) = (middle_x + start_x - centre_x, middle_y + start_y - centre_y);
    let radius_px = libm::sqrtf(field_x * field_x + field_y * field_y);
    let (cos, sin) = if radius_px > 0.5 { (field_x / radius_px, field_y / radius_px) } else { (1.0, 0.0) };
    let profile = calibration.profile(radius_px)?;

    let way = way_of(spot.moved_px, [cos, sin]);
    let (mut x, mut y) = (start_x, start_y);
    let (mut variance, mut misfit, mut beyond_noise, mut beta) = (0.0, 1.0, 1.0, BETA);
    for half in STEPS {
        let star = Star { at_px: [x, y], radius: [cos, sin], beta };
        // The first step only has to come near; on a long way the star may stand anywhere.
        let sums = match way.as_ref().filter(|way| half == HALF || way.places > 2) {
            None => Sums::of(spot.pixels, half, &star, &profile),
            Some(way) => Sums::of_moving(spot.pixels, NEAR, &star, (&profile, way)),
        };
        let step = Step::of(&sums, beta, spot.noise, calibration.electrons_per_count())?;
        let [along, across] = step.along_across;
        let limited = |step: f32| step.clamp(-STEP_MAX_PX, STEP_MAX_PX);
        let (along, across) = (limited(along), limited(across));
        (x, y) = (x + along * cos - across * sin, y + along * sin + across * cos);
        (variance, misfit, beyond_noise) = (step.variance, step.misfit, step.beyond_noise);
        beta =
            (spot.noise * spot.noise * calibration.electrons_per_count() / step.flux).clamp(BETA, BETA_MOST);
    }
    let (moved_x, moved_y) = (x - start_x, y - start_y);
    // Written so that NaN is refused as well.
    let near = moved_x * moved_x + moved_y * moved_y <= FARTHEST_PX * FARTHEST_PX;
    if !near || !variance.is_finite() {
        return None;
    }
    variance *= 1.0 + FAINT_PER_PX2 * variance;
    if misfit > BAD_FIT {
        variance *= misfit;
    }
    let at_px = [middle_x + x, middle_y + y];
    let [dx, dy] = match way {
        None => calibration.correction_px(at_px),
        Some(_) => correction_of_way(calibration, at_px, spot.moved_px),
    };
    let residual_px = calibration.residual_px();
    let [moved_x, moved_y] = spot.moved_px.map(|moved| MOVED_SHARE * moved);
    variance += residual_px * residual_px + moved_x * moved_x + moved_y * moved_y;
    Some(Centre {
        at_px: [x + dx, y + dy],
        sigma_px: libm::sqrtf(variance),
        all_is_star: beyond_noise <= BAD_FIT,
        misfits: misfit > BAD_FIT,
    })
}

/// The places of a star that moves so far, along and across a field's radius: their mean square distance from
/// the middle is the line's. `None` of one that stays in its place.
fn way_of([moved_x, moved_y]: [f32; 2], [cos, sin]: [f32; 2]) -> Option<Way> {
    let square = moved_x * moved_x + moved_y * moved_y;
    if square < LEAST_WAY_PX * LEAST_WAY_PX {
        return None;
    }
    // Of n places a step apart it is (n² - 1) / 12 of the step's square, of the line a twelfth of its own.
    let long = LONG_WAYS_PX.iter().filter(|px| square >= *px * *px).count();
    let steps = STEPS_OF.get(long)?;
    let step_px = [moved_x * cos + moved_y * sin, moved_y * cos - moved_x * sin].map(|px| px / steps);
    Some(Way { places: long as u8 + 2, step_px })
}

/// The mean of the corrections along the way that a star moves in the exposure.
#[inline(never)]
fn correction_of_way(calibration: &Calibration, [x, y]: [f32; 2], [moved_x, moved_y]: [f32; 2]) -> [f32; 2] {
    let share = 1.0 / f32::from(CORRECTED_POINTS);
    (0..CORRECTED_POINTS).fold([0.0; 2], |[sum_x, sum_y], point| {
        let along = (f32::from(point) + 0.5) * share - 0.5;
        let [dx, dy] = calibration.correction_px([x + along * moved_x, y + along * moved_y]);
        [sum_x + share * dx, sum_y + share * dy]
    })
}

impl Step {
    /// The step, and how good the fit is after it; `None` where there is no star.
    fn of(sums: &Sums, beta: f32, noise: f32, electrons_per_count: f32) -> Option<Self> {
        let ([pixels, light], [bare, s, ss], one) = (sums.even, sums.seen, sums.weight);
        // q f = 1 - β q.
        let (fs, f) = (bare - beta * s, pixels - beta * one);
        let ff = light - beta * f;
        let spread = one * ff - f * f;
        let (flux, floor) = ((one * fs - f * s) / spread, (ff * s - f * fs) / spread);
        let [uu, uv, vv] = sums.slope;
        let determinant = uu * vv - uv * uv;
        let usable = spread > 1e-9 && flux > 1.0 && determinant > 1e-9;
        if !usable {
            return None;
        }
        let [u, v] = sums.pull.map(|[seen, light, even]| (seen - floor * even) / flux - light);
        let of_axis = |noise_sum: f32, photon_sum: f32, slope: f32| {
            (noise_sum * noise * noise + photon_sum * flux / electrons_per_count)
                / (flux * slope * flux * slope)
        };
        let [along, across] = sums.noise;
        let variance = of_axis(along, uu - beta * along, uu) + of_axis(across, vv - beta * across, vv);
        let along_across = [(vv * u - uv * v) / determinant, (uu * v - uv * u) / determinant];
        // What flux, floor and step leave of the squares, over what noise and an inexact profile would.
        let [along, across] = along_across;
        let left = ss - flux * fs - floor * s - flux * flux * (u * along + v * across);
        let doubt = PROFILE_ERROR * flux;
        let by_noise = noise * noise * one + flux / electrons_per_count * f;
        Some(Self {
            along_across,
            variance: 0.5 * variance,
            misfit: left / (by_noise + doubt * doubt * ff),
            beyond_noise: left / by_noise,
            flux,
        })
    }
}

#[cfg(test)]
mod tests;
