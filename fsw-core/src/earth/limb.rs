//! Limb point in a strip, a thin window across the expected limb (thesis §3.2.1 step 4, §3.7 tracking).
//!
//! In: the pixels of a [`Strip`] of [`BREADTH`] lines. Out: one [`LimbPoint`] with its sigma, or `None`.
//!
//! The lines are shifted onto the middle one by the limb's predicted slope and averaged, at each place
//! without the largest and the smallest of the nine, which removes a star or a hot pixel. The dark level is
//! the median of the outer end. The limb is the outermost place with the share `LimbModel::level` of the
//! brightness just inside it, a mean over a few pixels behind the end of the rise. The share, about one
//! half, is that of `limb_model` at the half-brightness height. Where the air fades more slowly than
//! modelled, the share is reached throughout it; then the limb is the outermost crossing of that share of
//! the ground's brightness. Vignetting scales both sides and is not corrected: a lens that loses half of
//! its light in the corner moves the limb by less than 0.05 px (test).
//!
//! The sigma is the root sum of squares of the scatter between the lines, the relative scatter of the
//! bright side, 10 % of its shading, the floor, and the scatter of the limb's height. Bias against the
//! half-brightness height in rendered strips: `limb/tests.rs`. Cost: 180 cycles a place as far inwards as
//! the edge needs, and 10,000 for the model; 1.43 M for 24 of nearly the longest (`cargo budget`, `limb` of
//! tracking).

use super::limb_model::LimbModel;
use super::view::ExpectedLimb;
use super::{EarthParameters, Ground, LimbPoint};
use fsw_hal::{DetectorGeometry, Window};
use fsw_pixels::lines::{LINES, RUN};

mod lines;
mod without_sun;
pub(super) use lines::{AveragedLine, END_MARGIN, Lines};
pub use without_sun::crossing_without_sun;

/// Lines of a strip.
pub const BREADTH: usize = LINES;
/// Longest strip, px.
pub const MAX_LENGTH: usize = 161;
/// Runs of places in which the longest one is averaged.
pub const MAX_RUNS: usize = MAX_LENGTH.div_ceil(RUN);

/// Middle line.
const MIDDLE: i32 = (BREADTH as i32 - 1) / 2;
/// Largest sum of falling steps within the rise, share of it: noise and clouds stay below, a star or an
/// occluder does not. Chosen.
const GREATEST_FALL: f32 = 0.15;
/// Factor on the bright side's relative scatter for clouds between it and the limb. Chosen.
const CLOUD_FACTOR: f32 = 2.0;
/// Largest sigma of a point, the larger of px and a share of the scale height: a worse point adds no
/// information to the prediction. Chosen.
pub(super) const GREATEST_SIGMA_PX: f32 = 1.0;
pub(super) const GREATEST_SIGMA_SHARE: f32 = 0.5;

/// Extent of a strip from the expected limb, px.
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
    /// The window to read.
    pub window: Window,
    /// The expected limb in it.
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

    /// The limb point `inward` places from the outer end of lines of `length` places.
    pub(super) fn point(&self, length: usize, inward: f32, sigma_px: f32) -> LimbPoint {
        let from_start = if self.space_beyond { length as f32 - 1.0 - inward } else { inward };
        let [x, y] = [f32::from(self.window.x), f32::from(self.window.y)];
        let middle = MIDDLE as f32;
        let centre_px =
            if self.along_x { [x + from_start, y + middle] } else { [x + middle, y + from_start] };
        LimbPoint::new(centre_px, sigma_px, self.expected.outward_px)
    }
}

/// The limb point of a strip and the brightness on both sides of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripPoint {
    /// The limb point.
    pub point: LimbPoint,
    /// Level of its dark side, counts.
    pub dark: f32,
    /// Brightness of its bright side over the dark one, counts.
    pub bright: f32,
}

/// A way to find the limb in a strip: that of [`crossing`], or one in [`comparison`](super::comparison).
pub trait Crossing:
    Fn(&[u16], &Strip, &DetectorGeometry, &EarthParameters) -> Option<StripPoint> + Copy
{
}

impl<F> Crossing for F where
    F: Fn(&[u16], &Strip, &DetectorGeometry, &EarthParameters) -> Option<StripPoint> + Copy
{
}

/// Where the averaged line crosses the limb.
#[derive(Clone, Copy)]
struct LimbEdge {
    place: usize,
    /// Part of the last place before it.
    part: f32,
    /// Brightness of the bright side over the dark one.
    bright: f32,
}

/// The averaged line of a strip with its dark level and the scale of the detector.
struct StripProfile<'a> {
    lines: &'a Lines<'a>,
    line: &'a mut AveragedLine<'a>,
    dark: f32,
    full_scale: f32,
    parameters: &'a EarthParameters,
}

impl<'a> StripProfile<'a> {
    /// `None` where the outer end is brighter than `earth.strips.dark_share`.
    fn new(
        lines: &'a Lines,
        line: &'a mut AveragedLine<'a>,
        geometry: &DetectorGeometry,
        parameters: &'a EarthParameters,
    ) -> Option<Self> {
        let full_scale = f32::from(geometry.full_scale());
        let dark = line.dark()?;
        let is_dark = dark <= parameters.strips.dark_share * full_scale;
        is_dark.then_some(Self { lines, line, dark, full_scale, parameters })
    }

    /// Brightness at a place above the model's share of the brightness behind it, and that brightness; `None`
    /// where the bright side would leave the line.
    fn excess(&self, model: &LimbModel, place: usize) -> Option<(f32, f32)> {
        let counts = self.line.known();
        let value = counts.get(place)? - self.dark;
        model.bright(counts, place, self.dark).map(|bright| (value - model.level * bright, bright))
    }

    /// The outermost place with the model's share of the brightness behind it.
    fn find_edge(&mut self, model: &LimbModel) -> Option<LimbEdge> {
        let least = self.parameters.strips.contrast_share * self.full_scale;
        // A bright side of the least contrast has at least this at its limb.
        let least_value = model.level * least;
        let outer = END_MARGIN + (self.lines.length / 8).max(5);
        let first = outer.checked_sub(1)?;
        let (mut found, mut from) = (None, outer);
        while let Some(place) = self.line.next_bright(from, self.dark, least_value) {
            from = place + 1;
            self.line.extend(place + model.depth())?;
            // `None` where the bright side would leave the strip.
            let (now, bright) = self.excess(model, place)?;
            if now >= 0.0 && bright > least && model.is_ground(self.line.known(), place, self.dark, bright) {
                let before = self.excess(model, place - 1)?.0;
                found = if before < 0.0 {
                    Some(LimbEdge { place, part: before / (before - now), bright })
                } else {
                    self.outward(model, place, first, bright)
                };
                break;
            }
        }
        let LimbEdge { place, bright, .. } = found?;
        let saturated = bright + self.dark > self.parameters.strips.saturated_share * self.full_scale;
        found.filter(|_| !saturated && is_rise(self.line.known(), place, model, bright))
    }

    /// Outermost crossing of the share of `bright` between `place` and `outermost`, for air that fades more
    /// slowly than modelled. `None` where the outer end is not below the share.
    fn outward(&self, model: &LimbModel, place: usize, outermost: usize, bright: f32) -> Option<LimbEdge> {
        let counts = self.line.known();
        let excess = |place: usize| Some(counts.get(place)? - self.dark - model.level * bright);
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
    fn point(&self, edge: &LimbEdge, model: &LimbModel, strip: &Strip) -> Option<StripPoint> {
        let (profile, parameters) = (self.line.known(), self.parameters);
        let LimbEdge { place, part, bright } = *edge;
        let smooth = model.scatter(profile, place, self.dark)?;
        let half = ((0.5 * model.scale) as usize).clamp(1, END_MARGIN);
        let scatter = self.lines.scatter_px(profile, place, half)?;
        let gradient = (profile.get(place)? - profile.get(place.checked_sub(1)?)?).max(1e-3);
        // Clouds seen in the bright side, clouds unseen, and the error of the shading model.
        let (seen, unseen) = (CLOUD_FACTOR * smooth, parameters.limb.cloud_share);
        let relative_sigma = libm::sqrtf(seen * seen + unseen * unseen + model.shading * model.shading);
        let lever = model.level * bright / gradient;
        let level = lever * relative_sigma;
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
        let ground = Ground { brightness: bright / model.white, lever_px: lever * normal_cosine };
        let point = LimbPoint { ground, ..strip.point(self.lines.length, place as f32 - 1.0 + part, sigma) };
        Some(StripPoint { point, dark: self.dark, bright })
    }
}

/// The limb in a strip. `pixels` are the window's, of a converter with this full scale. `None` where the rise
/// is too weak, not a rise, saturated, at the strip's end, or where the outer side is bright.
pub fn crossing(
    pixels: &[u16],
    strip: &Strip,
    geometry: &DetectorGeometry,
    parameters: &EarthParameters,
) -> Option<StripPoint> {
    let lines = Lines::of(pixels, strip)?;
    let mut line = lines.averaged()?;
    let mut strip_profile = StripProfile::new(&lines, &mut line, geometry, parameters)?;
    let model = LimbModel::new(&strip.expected, strip.normal_cosine(), parameters)?;
    let edge = strip_profile.find_edge(&model)?;
    strip_profile.point(&edge, &model, strip)
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
