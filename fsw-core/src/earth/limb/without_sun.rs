//! Limb point in a strip where the Sun's direction is not known.

use super::{LimbEdge, Lines, Strip, StripPoint, StripProfile};
use crate::earth::EarthParameters;
use crate::earth::limb_model::{self, LimbModel};
use crate::earth::view::ExpectedLimb;
use fsw_hal::DetectorGeometry;

/// Depth behind the limb at which the surface must be bright, km: below a layer of airglow 12 km thick.
const DEPTH_KM: f32 = 25.0;
/// Places averaged there, px.
const BEHIND: usize = 3;
/// Least brightness there, share of that at the limb: between a layer of airglow, 0.4 (`surface_continues`),
/// and ground, about 1.
const LEAST_BEHIND: f32 = 0.6;
/// Largest and least number of places behind the bright side from which the Sun's slant is estimated.
const FAR_PX: usize = 12;
const LEAST_BEHIND_PX: usize = 4;
/// Brightening, in sigmas of the clouds, above which a slant is estimated.
const SLANT_SIGMAS: f32 = 2.0;
/// Bisection steps: the slant is found to 0.01.
const SLANT_STEPS: usize = 10;
/// Greatest slant, cotangent of the Sun's elevation: 5 deg, about the least elevation where the Sun is known.
const GREATEST_SLANT: f32 = 11.0;
/// Factor on the error of the shading against that with a known Sun: 50 % of it. Chosen.
const SHADING_FACTOR: f32 = 5.0;

/// [`crossing`](super::crossing) where the Sun is not known: its slant is estimated from the line itself,
/// and the surface must continue behind the limb.
///
/// Below the limb by a depth `d` the ground is lit `1 + sqrt(2 d / R) w` times as well as at the limb, with
/// `w` the cotangent of the Sun's elevation, whatever its albedo; the mean brightness of two sections gives
/// `w`. Where it brightens by less than two sigmas of the clouds, `w = 0`. Not flown: in flight the
/// attitude gives the Sun's direction.
pub fn crossing_without_sun(
    pixels: &[u16],
    strip: &Strip,
    geometry: &DetectorGeometry,
    parameters: &EarthParameters,
) -> Option<StripPoint> {
    let lines = Lines::of(pixels, strip)?;
    let mut line = lines.averaged()?;
    line.extend(lines.length)?;
    let mut strip_profile = StripProfile::new(&lines, &mut line, geometry, parameters)?;
    let overhead = ExpectedLimb { sun_sine: 1.0, sun_facing: 0.0, ..strip.expected };
    let model = LimbModel::new(&overhead, strip.normal_cosine(), parameters)?;
    let edge = strip_profile.find_edge(&model)?;
    let km_per_place = strip.expected.km_per_px * strip.normal_cosine();
    if !surface_continues(
        strip_profile.line.known(),
        edge.place,
        &model,
        km_per_place,
        [strip_profile.dark, edge.bright],
    ) {
        return None;
    }
    let slant = slant(&strip_profile, &edge, &model, km_per_place);
    let (sun_sine, sun_facing) = limb_model::elevation(slant);
    let slanted = ExpectedLimb { sun_sine, sun_facing, ..strip.expected };
    let model = LimbModel::new(&slanted, strip.normal_cosine(), parameters)?;
    let model = LimbModel { shading: SHADING_FACTOR * model.shading, ..model };
    let edge = strip_profile.find_edge(&model)?;
    strip_profile.point(&edge, &model, strip)
}

/// Cotangent of the Sun's elevation at the limb; zero where clouds could cause the brightening.
fn slant(strip_profile: &StripProfile, edge: &LimbEdge, model: &LimbModel, km_per_place: f32) -> f32 {
    let Some(behind) = strip_profile.line.known().get(edge.place + model.end..) else { return 0.0 };
    let behind = behind.get(..behind.len().min(FAR_PX)).unwrap_or(behind);
    if behind.len() < LEAST_BEHIND_PX {
        return 0.0;
    }
    let far = behind.iter().sum::<f32>() / behind.len() as f32 - strip_profile.dark;
    let ratio = far / edge.bright.max(1.0);
    // Squares of the cosine of the view at the middles of both stretches; the surface lies where half of its
    // light is passed.
    let square = |places: f32| {
        let depth_km = (places - model.scale * core::f32::consts::LN_2).max(0.0) * km_per_place;
        2.0 * depth_km / strip_profile.parameters.ellipsoid.equatorial_km.max(1.0)
    };
    let near = square(0.5 * (model.begin + model.end) as f32);
    let squares = [near, square(model.end as f32 + 0.5 * behind.len() as f32)];
    let brightness_ratio =
        |slant: f32| limb_model::brightness_ratio(slant, squares, strip_profile.parameters);
    let cloud_limit =
        (1.0 + SLANT_SIGMAS * strip_profile.parameters.limb.cloud_share) * brightness_ratio(0.0);
    // In LEO a strip covers too little ground: even the greatest slant would stay below the limit.
    if ratio < cloud_limit
        || brightness_ratio(GREATEST_SLANT) < cloud_limit * (1.0 + strip_profile.parameters.limb.cloud_share)
    {
        return 0.0;
    }
    // The ratio is monotonic in the slant: bisection.
    let (mut low, mut high) = (0.0, GREATEST_SLANT);
    for _ in 0..SLANT_STEPS {
        let middle = 0.5 * (low + high);
        (low, high) = if brightness_ratio(middle) < ratio { (middle, high) } else { (low, middle) };
    }
    high
}

/// Whether the surface continues behind the limb. A layer of airglow fails: edge-on, 12 km of it are 2.5
/// times as bright as 25 km below.
fn surface_continues(
    profile: &[f32],
    place: usize,
    model: &LimbModel,
    km_per_place: f32,
    [dark, bright]: [f32; 2],
) -> bool {
    let depth = (DEPTH_KM / km_per_place.max(1e-3)) as usize;
    let end = (place + depth.max(model.end)).min(profile.len());
    let behind = profile.get(end.saturating_sub(BEHIND)..end).unwrap_or(&[]);
    behind.iter().sum::<f32>() > (dark + LEAST_BEHIND * bright) * behind.len() as f32
}
