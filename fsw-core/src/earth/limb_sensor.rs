//! Measurement of the Earth in an exposed image: a search of the whole detector, and strips across an
//! expected limb.
//!
//! In: an exposed detector, the camera, the [`Body`], buffers. Out: limb points and their centre. The
//! centre of a search is only accurate enough to place strips; the centre of the strips is the measurement.
//! The flight cycle calls the steps one by one, because an orbit may replace the search; [`acquire`] calls
//! all of them, for an image without any prior.

use super::centre::{self, CentrePrior};
use super::limb::StripPoint;
use super::reach::{MAX_LIMB_STRIPS, STRIP_MARGIN_PX, limb_reach};
use super::shape::bilinear;
use super::view::{ExpectedLimb, PHASES, View};
use super::{Body, EarthFix, EarthParameters, FitCriteria, LimbPoint, MAX_LIMB_POINTS};
use super::{FitError, Strips, limb, search};
use crate::camera::Camera;
use crate::image::turn::Turn;
use crate::order::two_least;
use fsw_hal::{Detector, DetectorError};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Sigma of the limb's position after a search, px: twice the floor of its points, because the limb is
/// extrapolated beyond them. Chosen.
pub const SEARCH_SIGMA_PX: f32 = 3.0;
/// The same after strips. Strips are read twice: with a smaller sigma they are shorter, and more of them
/// fit onto the detector (the second search along the rim, thesis §3.2.1).
const STRIPS_SIGMA_PX: f32 = 0.5;
/// Where the Sun is not known, the limb within this many search steps of a point of the search counts as
/// lit. Chosen.
const LIT_STEPS: f32 = 6.0;
/// A strip's dark side is space if it is brighter than the others' by no more than this share of its own
/// brightness: a dark sea before clouds is not. Chosen; along a true limb it was a hundredth of it.
const SPACE_SHARE: f32 = 0.25;

/// Working buffers; their content is overwritten.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// Raw pixels: the longer side of the detector, and a strip ([`limb::BREADTH`] by [`limb::MAX_LENGTH`]).
    pub buffer: &'a mut [u16],
    /// The limb points.
    pub points: &'a mut search::Points,
    /// Their rays.
    pub rays: &'a mut centre::RayBuffer,
}

/// What a measurement needs besides the image: camera, body and parameters.
#[derive(Clone, Copy, Debug)]
pub struct LimbSensor<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The body in the Earth path's frame.
    pub body: &'a Body,
    /// Parameters of the Earth and its limb.
    pub parameters: &'a EarthParameters,
    /// How the Earth path turns during the exposure; `None`: it rests, or that is not known.
    pub turn: Option<Turn>,
}

impl LimbSensor<'_> {
    /// The centre of the points in the buffers.
    ///
    /// # Errors
    /// As [`centre::centre`].
    pub fn fit(
        &self,
        criteria: &FitCriteria,
        prior: Option<&CentrePrior>,
        buffers: &mut Buffers,
    ) -> Result<EarthFix, FitError> {
        centre::centre(buffers.points, self.camera, self.body, criteria, prior, self.parameters, buffers.rays)
    }

    /// Coarse centre by a search of the whole detector.
    ///
    /// # Errors
    /// Of the detector. The inner error: why there is no centre.
    #[inline(never)]
    pub fn search(
        &self,
        detector: &mut impl Detector<Error = DetectorError>,
        buffers: &mut Buffers,
    ) -> Result<Result<(EarthFix, View), FitError>, DetectorError> {
        search::search(detector, buffers.buffer, self.parameters, buffers.points)?;
        let criteria = self.parameters.search_criteria(buffers.points.len());
        Ok(self.fit(&criteria, None, buffers).and_then(|rough| {
            let view = View::new(&rough.centre_km, self.body).ok_or(FitError::Degenerate)?;
            Ok((rough, view))
        }))
    }

    /// Height that a pixel spans at the limb, km.
    pub fn km_per_px(&self, view: &View) -> f32 {
        view.limb_distance_km() * self.camera.rad_per_px()
    }

    /// Variance of the limb's height where a smooth limb is known to `sigma_px`, the shared heights
    /// (`earth.horizon.sigma_km`) included.
    pub fn height_variance(&self, view: &View, sigma_px: f32) -> HeightVariance {
        let (sigma_km, uneven_km) = (sigma_px * self.km_per_px(view), self.parameters.horizon.sigma_km);
        let everywhere_km2 = sigma_km * sigma_km + uneven_km * uneven_km;
        HeightVariance { everywhere_km2, centre_km2: Matrix3::zeros() }
    }

    /// Measures limb points in strips across the expected limb, its height known to `variance`, at the
    /// places of `selection`; they replace the points in the buffers.
    ///
    /// # Errors
    /// Of the detector; [`DetectorError::BufferLength`] for a short buffer.
    #[inline(never)]
    pub fn read_strips(
        &self,
        detector: &mut impl Detector<Error = DetectorError>,
        view: &View,
        variance: &HeightVariance,
        selection: &StripSelection,
        buffers: &mut Buffers,
    ) -> Result<Strips, DetectorError> {
        self.read_strips_with(detector, view, variance, selection, buffers, limb::crossing)
    }

    /// As [`Self::read_strips`] with another [`limb::Crossing`] than the flown one.
    #[inline]
    fn read_strips_with(
        &self,
        detector: &mut impl Detector<Error = DetectorError>,
        view: &View,
        variance: &HeightVariance,
        selection: &StripSelection,
        buffers: &mut Buffers,
        crossing: impl limb::Crossing,
    ) -> Result<Strips, DetectorError> {
        let Self { camera, parameters, turn, .. } = *self;
        let geometry = detector.geometry();
        buffers.points.clear();
        let mut sides = SidesOfStrips::new();
        let mut strips = Strips { km_per_px: self.km_per_px(view), ..Strips::default() };
        for expected in
            &view.limb(camera, STRIP_MARGIN_PX, (selection.most, selection.phase), parameters).points
        {
            if !selection.includes(expected.at_px) {
                continue;
            }
            let sigma_km = libm::sqrtf(variance.along_km2(&expected.normal).max(0.0));
            let drawn_px = turn.as_ref().map_or(0.0, |turn| across_px(turn, expected));
            let Some(reach) = limb_reach(expected.km_per_px, sigma_km, drawn_px, parameters) else {
                strips.skipped += 1;
                continue;
            };
            let expected = ExpectedLimb { drawn_px, ..*expected };
            let Some(strip) = limb::strip(&expected, reach, &geometry) else { continue };
            let pixels = buffers.buffer.get_mut(..strip.window.area()).ok_or(DetectorError::BufferLength)?;
            detector.read(strip.window, pixels)?;
            strips.read += 1;
            if let Some(StripPoint { point, dark, bright }) = crossing(pixels, &strip, &geometry, parameters)
            {
                // There are at most as many strips as the lists hold points.
                let _ = buffers.points.push(point);
                let _ = sides.push((dark, bright));
            }
        }
        keep_before_space(buffers.points, &sides);
        Ok(strips)
    }
}

/// How far a turn moves a limb across itself, px.
fn across_px(turn: &Turn, expected: &ExpectedLimb) -> f32 {
    let ([x, y], [nx, ny]) = (turn.moved_px(expected.at_px), expected.outward_px);
    libm::fabsf(x * nx + y * ny)
}

/// Dark level and brightness of the points of strips, counts.
type SidesOfStrips = Vec<(f32, f32), MAX_LIMB_POINTS>;

/// Drops the points of which the dark side is not as dark as space: as the second darkest, so that one
/// defective strip does no harm.
#[inline(never)]
fn keep_before_space(points: &mut search::Points, sides: &SidesOfStrips) {
    let [_, space] = sides.iter().fold([f32::INFINITY; 2], |least, (dark, _)| two_least(least, *dark));
    let mut sides = sides.iter();
    points.retain(|_| sides.next().is_some_and(|(dark, bright)| dark - space <= SPACE_SHARE * bright));
}

/// Uncertainty of the expected limb's height.
#[derive(Clone, Copy, Debug)]
pub struct HeightVariance {
    /// The same along the whole limb, km².
    pub everywhere_km2: f32,
    /// Covariance of the centre, km², projected on the limb's normal.
    pub centre_km2: Matrix3<f32>,
}

impl HeightVariance {
    /// Variance at the limb point of this normal, km².
    pub fn along_km2(&self, normal: &Vector3<f32>) -> f32 {
        self.everywhere_km2 + bilinear(normal, &self.centre_km2, normal)
    }
}

/// Which of the expected limb points are measured.
#[derive(Clone, Copy, Debug)]
pub struct StripSelection<'a> {
    /// Number of points, spread evenly over the limb that is predicted to be lit.
    pub most: usize,
    /// Their phase along it, 0 to 7 eighths of their distance. In GEO the error of an edge stays with its
    /// place on the Earth, so that strips at the same places do not average it.
    pub phase: u8,
    /// Of these, only those within this distance, px, of one of these points; `None`: all.
    pub near: Option<(&'a [LimbPoint], f32)>,
}

/// [`MAX_LIMB_STRIPS`] strips evenly along the lit limb.
pub const EVEN_STRIPS: StripSelection = StripSelection { most: MAX_LIMB_STRIPS, phase: 4, near: None };

impl StripSelection<'_> {
    /// [`EVEN_STRIPS`] moved along the limb from cycle to cycle; after eight they have been everywhere.
    /// Half as many in a second that is `busy` with other work.
    pub fn dithered(cycle: u32, busy: bool) -> Self {
        let phase = (cycle.wrapping_mul(3) % u32::from(PHASES)) as u8;
        Self { most: if busy { MAX_LIMB_STRIPS / 2 } else { MAX_LIMB_STRIPS }, phase, near: None }
    }

    fn includes(&self, [x, y]: [f32; 2]) -> bool {
        self.near.is_none_or(|(points, px)| {
            points.iter().any(|point| {
                let (dx, dy) = (point.centre_px[0] - x, point.centre_px[1] - y);
                dx * dx + dy * dy < px * px
            })
        })
    }
}

/// Result of [`acquire`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Number of limb points of the search.
    pub searched: usize,
    /// Number of strips read after it.
    pub strips: usize,
    /// The centre, or why there is none. The buffers hold the points of the last step: of the strips where
    /// any was read.
    pub fix: Result<EarthFix, FitError>,
}

/// Measures the Earth without a prior: search, strips across the limb found, centre of their points.
///
/// Where the Sun is not known, the lit part of the limb is not known either: strips are read only near
/// points of the search, because strips across the night side would count as missed.
///
/// # Errors
/// Of the detector.
pub fn acquire(
    limb_sensor: &LimbSensor,
    detector: &mut impl Detector<Error = DetectorError>,
    buffers: &mut Buffers,
) -> Result<Found, DetectorError> {
    if limb_sensor.body.has_sun() {
        acquire_with(limb_sensor, detector, buffers, limb::crossing)
    } else {
        acquire_with(limb_sensor, detector, buffers, limb::crossing_without_sun)
    }
}

/// As [`acquire`] with another [`limb::Crossing`] than the flown one.
///
/// # Errors
/// Of the detector.
pub fn acquire_with(
    limb_sensor: &LimbSensor,
    detector: &mut impl Detector<Error = DetectorError>,
    buffers: &mut Buffers,
    crossing: impl limb::Crossing,
) -> Result<Found, DetectorError> {
    let searched = limb_sensor.search(detector, buffers)?;
    let points = buffers.points.len();
    let refused = |refusal| Found { searched: points, strips: 0, fix: Err(refusal) };
    let (rough, view) = match searched {
        Ok(found) => found,
        Err(refusal) => return Ok(refused(refusal)),
    };
    let mut lit = search::Points::new();
    for (index, point) in buffers.points.iter().enumerate() {
        if rough.is_inlier(index) {
            let _ = lit.push(*point);
        }
    }
    let near_px = LIT_STEPS * f32::from(limb_sensor.parameters.search.step_px);
    let selection = if limb_sensor.body.has_sun() {
        EVEN_STRIPS
    } else {
        StripSelection { most: MAX_LIMB_POINTS, phase: 4, near: Some((&lit, near_px)) }
    };
    let mut found = refused(FitError::TooFewPoints);
    let (mut about, mut view) = (rough, view);
    for sigma_px in [SEARCH_SIGMA_PX, STRIPS_SIGMA_PX] {
        let variance = limb_sensor.height_variance(&view, sigma_px);
        let strips =
            limb_sensor.read_strips_with(detector, &view, &variance, &selection, buffers, crossing)?;
        found.strips = strips.read;
        let criteria = limb_sensor.parameters.strip_criteria(&strips, true);
        found.fix = limb_sensor.fit(&criteria, CentrePrior::from_fix(&about).as_ref(), buffers);
        match found.fix.map(|fix| (fix, View::new(&fix.centre_km, limb_sensor.body))) {
            Ok((fix, Some(seen))) => (about, view) = (fix, seen),
            _ => break,
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
