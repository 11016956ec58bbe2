//! Model of the brightness across a limb: extent of the bright side, and the share of its brightness at the
//! limb.
//!
//! Model: above the surface the brightness falls as exp(-h / H) (thesis eq. 4.1-4.2, thin air); below the
//! limb by a depth `d` of a sphere of radius `R` the normal is turned by `sqrt(2 d / R)` towards the
//! camera, so that by Lambert's law the brightness is `1 - d / R + sqrt(2 d / R) facing / sine`, with the
//! sine of the Sun's elevation and the cosine `facing` of its angle from the camera at the limb; a share of
//! the light follows the law of Lommel and Seeliger instead, with a brighter limb. The lens blurs this by a
//! Gaussian, to whose variance a turn that draws the limb out by `s` px across itself adds `s² / 12`; the
//! bright side then begins behind the drawn edge. The model gives the share of the bright side's mean at the
//! half-brightness height; it is one half without blur and shading, and goes from 0.3 to 0.8 where the Sun is
//! low.

use super::EarthParameters;
use super::view::ExpectedLimb;

/// The bright side begins this many spreads inside the surface: there the blurred edge is at 70 %, and the
/// model accounts for the rest.
const SPREADS_INSIDE: f32 = 0.5;
/// Length of the bright side, the longer of px and scale heights: two pixels to average noise, only half a
/// scale height to limit the influence of clouds and terminator. Chosen.
const LEAST_BRIGHT_PX: f32 = 2.0;
const BRIGHT_SCALES: f32 = 0.5;
/// Largest length of the bright side, px: noise falls to a fifth (sqrt 24), more only costs cycles.
const MOST_BRIGHT_PX: f32 = 24.0;
/// Longest rise and bright side together, px: what a strip of 161 px holds inside its dark end and its
/// margin.
const LONGEST_PX: f32 = 120.0;
/// Variance of a pixel's own width, a twelfth, and of the joined lines' shifts between pixels, a sixth, px².
const PIXEL_VARIANCE: f32 = 1.0 / 12.0 + 1.0 / 6.0;
/// Added to the cosine of the view as squares: haze blurs the surface's last 30 km (0.1² R / 2).
const HAZE: f32 = 0.1;
/// Limits of the ground's brightness over that of its limb: beyond, the reflectance laws do not hold.
/// Chosen.
const LEAST_SHADE: f32 = 0.3;
const GREATEST_SHADE: f32 = 4.0;
/// Relative error of the shading model: ground is no ideal diffuse surface. Chosen.
const SHADING_ERROR: f32 = 0.1;
/// Gaussian weights of a spread's thirds, from the middle outwards to 3 1/3 spreads; their sum, both sides,
/// is one.
const WEIGHTS: [f32; 11] = [
    0.133_039,
    0.125_849_5,
    0.106_529_3,
    0.080_692_2,
    0.054_694,
    0.033_173_6,
    0.018_004_9,
    0.008_744_5,
    0.003_800_3,
    0.001_477_9,
    0.000_514_3,
];
/// Least scale height, px: below, the lens alone forms the profile.
const LEAST_SCALE_PX: f32 = 0.1;
/// Largest brightening over a scale height that counts as ground: between air, 2.7, and ground, about 1.
const GREATEST_RISE: f32 = 1.7;
/// Samples of the model over the bright side; compared with a fine mean in `limb_model/tests.rs`.
const SAMPLES: usize = 3;

/// Profile of a limb, in places along the lines.
pub(super) struct LimbModel {
    /// Places behind the half-brightness place at which the bright side begins and ends.
    pub(super) begin: usize,
    pub(super) end: usize,
    /// Places of the bright side.
    pub(super) count: f32,
    /// Share of the bright side's mean at the half-brightness height.
    pub(super) level: f32,
    /// Mean brightness of the bright side were the ground white, that of a Sun in the zenith being 1.
    pub(super) white: f32,
    /// Relative error of the brightness by the shading model.
    pub(super) shading: f32,
    /// Scale height: the air's brightness falls to 1 / e.
    pub(super) scale: f32,
    /// Spread of the picture, pixel's own width included.
    pub(super) spread: f32,
}

/// Brightness along a line.
struct BrightnessModel {
    scale: f32,
    /// Place of the surface.
    surface: f32,
    /// Twice the curvature over the steepness, 1 / px.
    turning: f32,
    /// Sine of the Sun's elevation at the limb, and the cosine of its angle from the camera.
    sine: f32,
    facing: f32,
    /// Share of the law of Lommel and Seeliger.
    share: f32,
    /// One over the brightness of the limb.
    scaling: f32,
}

/// How the lens spreads the limb: a third of the spread, and the factors of the air's brightness over it.
#[derive(Clone, Copy)]
struct Blur {
    step: f32,
    inward: f32,
    outward: f32,
}

impl BrightnessModel {
    /// Unblurred brightness over that of the limb at a place inward of the half-brightness height; `air` is
    /// the air's there.
    #[inline(always)]
    fn clear(&self, place: f32, air: f32) -> f32 {
        if place < self.surface {
            return air;
        }
        let square = self.turning * (place - self.surface);
        let sunlight = self.sine * (1.0 - 0.5 * square) + fast_sqrt(square) * self.facing;
        let sunlight = if sunlight > 0.0 { sunlight } else { 0.0 };
        (self.scaling * reflectance(self.share, sunlight, square)).clamp(LEAST_SHADE, GREATEST_SHADE)
    }

    /// The same, blurred by the lens: weighted places `step` apart, a step inward makes the air brighter by
    /// the factor `inward`, one outward by `outward`.
    fn blurred(&self, place: f32, Blur { step, inward, outward }: Blur) -> f32 {
        let (mut inner, mut outer) = (place, place);
        // Inside the surface the air's brightness is not used, however large it grows.
        let mut inner_air = 0.5 * libm::expf(place / self.scale);
        let mut outer_air = inner_air;
        let [middle, sides @ ..] = WEIGHTS;
        let mut sum = middle * self.clear(place, inner_air);
        for weight in sides {
            (inner, outer) = (inner + step, outer - step);
            (inner_air, outer_air) = (inner_air * inward, outer_air * outward);
            sum += weight * (self.clear(inner, inner_air) + self.clear(outer, outer_air));
        }
        sum
    }
}

/// Square root of a number from 0 to 1e30, to 5e-6 of it: initial value by halving the exponent, two Newton
/// steps for the reciprocal root. A strip's model takes 200 of them; libm's exact root costs 63 cycles,
/// this one 25.
fn fast_sqrt(square: f32) -> f32 {
    let half = 0.5 * square;
    let first = f32::from_bits(0x5F37_59DF_u32.wrapping_sub(square.to_bits() >> 1));
    let second = first * (1.5 - half * first * first);
    square * (second * (1.5 - half * second * second))
}

/// Brightness under a Sun of this sine of elevation, seen at an angle of this square of the cosine; `share`
/// of it is Lommel's and Seeliger's.
fn reflectance(share: f32, sunlight: f32, square: f32) -> f32 {
    let view = fast_sqrt(square + HAZE * HAZE);
    sunlight * (share * 2.0 / (sunlight + view) + 1.0 - share)
}

/// Sine and cosine of the Sun's elevation at the limb, whose cotangent `slant` is.
pub(super) fn elevation(slant: f32) -> (f32, f32) {
    let sine = 1.0 / libm::sqrtf(1.0 + slant * slant);
    (sine, slant * sine)
}

/// Brightness of ground at a greater depth below the limb over that at a lesser one, both given by the
/// square of the cosine of the view, for sunlight of this slant.
pub(super) fn brightness_ratio(slant: f32, [near, far]: [f32; 2], parameters: &EarthParameters) -> f32 {
    let (sine, facing) = elevation(slant);
    let at =
        |square: f32| reflectance(parameters.limb.lommel_share, sine + libm::sqrtf(square) * facing, square);
    at(far) / at(near)
}

impl LimbModel {
    /// `steepness` is the cosine between the lines and the limb's normal. `None` where the rise is longer
    /// than a strip.
    pub(super) fn new(
        expected: &ExpectedLimb,
        normal_cosine: f32,
        parameters: &EarthParameters,
    ) -> Option<Self> {
        let km_per_px = (expected.km_per_px * normal_cosine).max(1e-3);
        let scale = (parameters.limb.scale_height_km / km_per_px).max(LEAST_SCALE_PX);
        let psf = parameters.limb.psf_sigma_px;
        let still = psf * psf + PIXEL_VARIANCE;
        let drawn = expected.drawn_px;
        let spread = libm::sqrtf(still + drawn * drawn * (1.0 / 12.0)) / normal_cosine;
        let surface = scale * core::f32::consts::LN_2;
        // All of a drawn edge is passed: it ends there, where a Gaussian one of the same variance goes on.
        let inside = (SPREADS_INSIDE * libm::sqrtf(still) + 0.5 * drawn) / normal_cosine;
        let begin = libm::floorf(surface + inside + 0.5);
        let length = (BRIGHT_SCALES * scale).max(LEAST_BRIGHT_PX / normal_cosine).min(MOST_BRIGHT_PX);
        let length = libm::floorf(length + 0.5);
        if (begin + length).is_nan() || begin + length >= LONGEST_PX {
            return None;
        }
        let model = BrightnessModel {
            scale,
            surface,
            turning: 2.0 * km_per_px / parameters.ellipsoid.equatorial_km.max(1.0),
            sine: expected.sun_sine.max(0.01),
            facing: expected.sun_facing,
            share: parameters.limb.lommel_share,
            scaling: 1.0,
        };
        let model = BrightnessModel { scaling: 1.0 / reflectance(model.share, model.sine, 0.0), ..model };
        let step = spread * (1.0 / 3.0);
        let blur = Blur { step, inward: libm::expf(step / scale), outward: libm::expf(-step / scale) };
        let mut bright = 0.0;
        for sample in 0..SAMPLES {
            let inside = (sample as f32 + 0.5) * (length - 1.0) / SAMPLES as f32;
            bright += model.blurred(begin + inside, blur) * (1.0 / SAMPLES as f32);
        }
        Some(Self {
            begin: begin as usize,
            end: (begin + length) as usize,
            count: length,
            white: bright / model.scaling,
            level: model.blurred(0.0, blur) / bright.max(LEAST_SHADE),
            shading: SHADING_ERROR * libm::fabsf(bright - 1.0),
            scale,
            spread,
        })
    }

    /// Places from a place to the end of what [`Self::is_ground`] asks of it.
    pub(super) fn depth(&self) -> usize {
        self.scale as usize + self.end
    }

    /// Mean brightness over the dark side behind `place`.
    pub(super) fn bright(&self, profile: &[f32], place: usize, dark: f32) -> Option<f32> {
        let inside = profile.get(place + self.begin..place + self.end)?;
        Some(inside.iter().sum::<f32>() / self.count - dark)
    }

    /// Whether the bright side behind `place` is ground, not air: a scale height farther in it brightens by
    /// less than 1.7. `true` where the line ends before.
    pub(super) fn is_ground(&self, profile: &[f32], place: usize, dark: f32, bright: f32) -> bool {
        let farther = self.bright(profile, place + self.scale as usize, dark);
        farther.is_none_or(|farther| farther < GREATEST_RISE * bright)
    }

    /// Relative scatter of the bright side.
    pub(super) fn scatter(&self, profile: &[f32], place: usize, dark: f32) -> Option<f32> {
        let inside = profile.get(place + self.begin..place + self.end)?;
        let count = inside.len().max(1) as f32;
        let mean = inside.iter().sum::<f32>() / count;
        let squares = inside.iter().fold(0.0, |sum, value| sum + (value - mean) * (value - mean));
        Some(libm::sqrtf(squares / count) / (mean - dark).max(1.0))
    }
}

#[cfg(test)]
mod tests;
