//! The limb in a strip: a thin window across the place where it is expected (thesis §3.2.1 step 4, §3.7
//! tracking).
//!
//! In: the pixels of a [`Strip`] of [`BREADTH`] lines. Out: one [`LimbPoint`] and its sigma, or nothing.
//!
//! The lines are shifted onto the middle one by the limb's known slope and joined, at each place without the
//! greatest and the least of the nine, so that a star or a hot pixel in a line does not count. Dark is the
//! median of the outer end. The limb is the outermost place that reaches the share `LimbModel::level` of the
//! brightness which stands just inside *it*, a mean over a few pixels behind the end of the rise, in to which
//! clouds and the terminator hardly reach. The share, near one half, is that of a limb in `limb_model`'s model at
//! its half-brightness height. Where the air fades more slowly than in the model, the share may be reached
//! anywhere in it: then the limb is where the brightness of the ground has its share. Vignetting dims both
//! alike and is not taken off: a lens that loses half of its light in the corner moves the limb by less than
//! a twentieth of a pixel.
//!
//! The sigma joins the scatter between the lines, the relative scatter of the bright side, a share of its
//! shading, the floor, and the scatter of the limb's height. Bias against the half-brightness height in
//! rendered strips: `limb/tests.rs`. Cost: 340 cycles a pixel of length, and some exponentials of the model;
//! 2.31 M for 24 of nearly the longest (`cargo budget`, `limb` of the clock jump).

use super::limb_model::LimbModel;
use super::view::ExpectedLimb;
use super::{EarthParameters, LimbPoint};
use fsw_hal::{DetectorGeometry, Window};

mod lines;
mod without_sun;
pub(super) use lines::{END_MARGIN, Lines, dark_of};
pub use without_sun::crossing_without_sun;

/// Lines of a strip.
pub const BREADTH: usize = 9;
/// Longest strip, px.
pub const MAX_LENGTH: usize = 161;

/// Middle line.
const MIDDLE: i32 = (BREADTH as i32 - 1) / 2;
/// Steps against the rise may take back this share of it: noise and clouds do, a star or an occluder takes
/// more. Chosen.
const GREATEST_FALL: f32 = 0.15;
/// Clouds between the limb and the bright side change brightness this much more than within it. Chosen.
const CLOUD_FACTOR: f32 = 2.0;
/// Greatest sigma of a point, the greater of px and a share of the rise's length: a worse one says nothing
/// that the prediction does not. Chosen.
pub(super) const GREATEST_SIGMA_PX: f32 = 1.0;
pub(super) const GREATEST_SIGMA_SHARE: f32 = 0.5;

/// How far a strip reaches from where the limb is expected, px.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reach {
    /// Towards space.
    pub outward_px: u16,
    /// Towards the bright side.
    pub inward_px: u16,
}

/// A window across the expected limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// What to read.
    pub window: Window,
    /// Where the limb is expected in it.
    expected: ExpectedLimb,
    /// Whether the strip's lines run along x.
    along_x: bool,
    /// Whether space is where the coordinate along the lines is greater.
    space_beyond: bool,
}

/// The strip about an expected limb, along the detector's axis nearest to the limb's normal; `None` where it
/// leaves the detector or is longer than [`MAX_LENGTH`].
pub fn strip(expected: &ExpectedLimb, reach: Reach, geometry: &DetectorGeometry) -> Option<Strip> {
    let [nx, ny] = expected.outward_px;
    let along_x = libm::fabsf(nx) >= libm::fabsf(ny);
    let space_beyond = if along_x { nx > 0.0 } else { ny > 0.0 };
    let (outward, inward) = (i32::from(reach.outward_px), i32::from(reach.inward_px));
    let (before, length) = (if space_beyond { inward } else { outward }, outward + inward + 1);
    if length > MAX_LENGTH as i32 {
        return None;
    }
    let (left, above) = if along_x { (before, MIDDLE) } else { (MIDDLE, before) };
    let (width, height) = if along_x { (length, BREADTH as i32) } else { (BREADTH as i32, length) };
    let [x, y] = expected.at_px.map(|at| libm::floorf(at + 0.5) as i32);
    let window = Window {
        x: u16::try_from(x.saturating_sub(left)).ok()?,
        y: u16::try_from(y.saturating_sub(above)).ok()?,
        width: width as u16,
        height: height as u16,
    };
    window.fits(geometry).then_some(Strip { window, expected: *expected, along_x, space_beyond })
}

impl Strip {
    /// Components of the limb's normal along the lines and from one to the next.
    fn normal_components(&self) -> (f32, f32) {
        let [nx, ny] = self.expected.outward_px;
        if self.along_x { (nx, ny) } else { (ny, nx) }
    }

    /// Cosine between the lines and the limb's normal.
    pub(super) fn normal_cosine(&self) -> f32 {
        libm::fabsf(self.normal_components().0)
    }

    /// Where the limb is expected.
    pub(super) fn expected(&self) -> &ExpectedLimb {
        &self.expected
    }

    /// The limb point so many places inward from the outer end of lines of this length.
    pub(super) fn point(&self, length: usize, inward: f32, sigma_px: f32) -> LimbPoint {
        let from_start = if self.space_beyond { length as f32 - 1.0 - inward } else { inward };
        let [x, y] = [f32::from(self.window.x), f32::from(self.window.y)];
        let middle = MIDDLE as f32;
        let centre_px =
            if self.along_x { [x + from_start, y + middle] } else { [x + middle, y + from_start] };
        LimbPoint { centre_px, sigma_px, outward_px: self.expected.outward_px }
    }
}

/// A way to find the limb in a strip: that of [`crossing`], or one in [`comparison`](super::comparison).
pub trait Crossing:
    Fn(&[u16], &Strip, &DetectorGeometry, &EarthParameters) -> Option<LimbPoint> + Copy
{
}

impl<F> Crossing for F where
    F: Fn(&[u16], &Strip, &DetectorGeometry, &EarthParameters) -> Option<LimbPoint> + Copy
{
}

/// Where a joined line passes the limb.
#[derive(Clone, Copy)]
struct LimbEdge {
    place: usize,
    /// Part of the last place before it.
    part: f32,
    /// Brightness of the bright side over the dark one.
    bright: f32,
}

/// A strip's joined line, and what it is held against.
struct StripProfile<'a> {
    lines: &'a Lines<'a>,
    /// Without the inner end.
    profile: &'a [f32],
    dark: f32,
    full_scale: f32,
    parameters: &'a EarthParameters,
}

impl<'a> StripProfile<'a> {
    /// `None` where the outer side is bright.
    fn new(
        lines: &'a Lines,
        profile: &'a [f32],
        geometry: &DetectorGeometry,
        parameters: &'a EarthParameters,
    ) -> Option<Self> {
        let full_scale = f32::from(geometry.full_scale());
        let dark = dark_of(profile, lines.length);
        let profile = profile.get(..lines.length.checked_sub(END_MARGIN)?)?;
        let is_dark = dark <= parameters.strips.dark_share * full_scale;
        is_dark.then_some(Self { lines, profile, dark, full_scale, parameters })
    }

    /// The outermost place that has its share of the brightness behind it.
    fn find_edge(&self, model: &LimbModel) -> Option<LimbEdge> {
        let Self { profile, dark, full_scale, parameters, .. } = *self;
        let least = parameters.strips.contrast_share * full_scale;
        // What a place's brightness has beyond its share of the brightness behind it.
        let excess = |place: usize| {
            let value = profile.get(place)? - dark;
            model.bright(profile, place, dark).map(|bright| (value - model.level * bright, bright))
        };
        let outer = END_MARGIN + (self.lines.length / 8).max(5);
        let first = outer.checked_sub(1)?;
        let mut before = excess(first)?.0;
        let mut found = None;
        for place in outer..profile.len() {
            // At the inner end of the strip there is no bright side left.
            let (now, bright) = excess(place)?;
            if now >= 0.0 && bright > least && model.is_ground(profile, place, dark, bright) {
                found = if before < 0.0 {
                    Some(LimbEdge { place, part: before / (before - now), bright })
                } else {
                    self.outward(model, place, first, bright)
                };
                break;
            }
            before = now;
        }
        let LimbEdge { place, bright, .. } = found?;
        let saturated = bright + dark > parameters.strips.saturated_share * full_scale;
        found.filter(|_| !saturated && is_rise(profile, place, model, bright))
    }

    /// Where the line has its share of a brightness last, going outward from `place` to `outermost`: air that
    /// fades more slowly than the model's has its share all the way out. The outer end itself must be dark; a
    /// rise ends at least half way up.
    fn outward(&self, model: &LimbModel, place: usize, outermost: usize, bright: f32) -> Option<LimbEdge> {
        let excess = |place: usize| Some(self.profile.get(place)? - self.dark - model.level * bright);
        let mut inner = excess(place)?;
        for place in (outermost + 1..=place).rev() {
            let outer = excess(place - 1)?;
            if outer < 0.0 {
                return Some(LimbEdge { place, part: outer / (outer - inner), bright });
            }
            inner = outer;
        }
        None
    }

    /// The limb point of a passage, with its sigma.
    fn point(&self, edge: &LimbEdge, model: &LimbModel, strip: &Strip) -> Option<LimbPoint> {
        let Self { profile, parameters, .. } = *self;
        let LimbEdge { place, part, bright } = *edge;
        let smooth = model.scatter(profile, place, self.dark)?;
        let half = ((0.5 * model.scale) as usize).clamp(1, END_MARGIN);
        let scatter = self.lines.scatter_px(profile, place, half)?;
        let gradient = (profile.get(place)? - profile.get(place.checked_sub(1)?)?).max(1e-3);
        // Clouds, and the shading by Lambert's law, which holds so far.
        let (seen, unseen) = (CLOUD_FACTOR * smooth, parameters.limb.cloud_share);
        let relative_sigma = libm::sqrtf(seen * seen + unseen * unseen + model.shading * model.shading);
        let level = model.level * bright * relative_sigma / gradient;
        let height = parameters.limb.scatter_km / strip.expected.km_per_px.max(1e-3);
        let floor = parameters.strips.floor_px;
        let normal_cosine = strip.normal_cosine();
        // Along the lines, then across the limb.
        let sigma = libm::sqrtf(
            (scatter * scatter + level * level) * normal_cosine * normal_cosine
                + floor * floor
                + height * height,
        );
        let greatest = GREATEST_SIGMA_PX.max(GREATEST_SIGMA_SHARE * model.scale);
        if sigma.is_nan() || sigma >= greatest {
            return None;
        }
        Some(strip.point(self.lines.length, place as f32 - 1.0 + part, sigma))
    }
}

/// The limb in a strip. `pixels` are the window's, of a converter with this full scale. `None` where the rise
/// is too weak, not a rise, saturated, at the strip's end, or where the outer side is bright.
pub fn crossing(
    pixels: &[u16],
    strip: &Strip,
    geometry: &DetectorGeometry,
    parameters: &EarthParameters,
) -> Option<LimbPoint> {
    let lines = Lines::of(pixels, strip)?;
    let profile = lines.profile()?;
    let strip_profile = StripProfile::new(&lines, &profile, geometry, parameters)?;
    let model = LimbModel::new(&strip.expected, strip.normal_cosine(), parameters)?;
    strip_profile.point(&strip_profile.find_edge(&model)?, &model, strip)
}

/// Whether the profile rises from three scale heights and spreads outside the place to the bright side.
fn is_rise(profile: &[f32], place: usize, model: &LimbModel, bright: f32) -> bool {
    let out = (3.0 * (model.scale + model.spread)) as usize;
    let from = place.saturating_sub(out.max(3)).max(END_MARGIN);
    let fall = profile.get(from..place + model.begin).map_or(f32::INFINITY, |rise| {
        rise.windows(2).fold(0.0, |fall, pair| match pair {
            [outer, inner] if inner < outer => fall + (outer - inner),
            _ => fall,
        })
    });
    fall < GREATEST_FALL * bright
}

#[cfg(test)]
mod tests;
