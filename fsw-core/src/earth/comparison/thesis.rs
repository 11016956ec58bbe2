//! The thesis's method for the Earth's centre (§3.2.1 and §3.2.2), for comparison: local criteria, a circle
//! through three points, Gander's algebraic circle on circularised points. Not flown: it is limited to
//! whole discs and uses no camera model.
//!
//! In: a [`Detector`], or limb points; the direction of the Earth's pole on the detector. Out: a [`Circle`],
//! px, or why there is none. Constants are the thesis's for a scale of 255, scaled to the converter's.
//!
//! Two deviations were necessary: the thesis's least distance of 10 px between the dark and the bright
//! centre cannot occur in a region of 13 x 13 px (`LEAST_APART_PX`), and of all triplets [`MAX_TRIPLETS`]
//! are tried. Of the pixels of a line above the threshold those next to one below it are looked at; any
//! other region has no dark side.

use crate::earth::search::{Decimator, Points, for_each_line};
use crate::earth::{FitError, LimbPoint, MAX_SEARCH_POINTS};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use nalgebra::{Matrix4, Vector4};

/// Distance of the grid's lines, px.
const GRID_PX: u16 = 10;
/// Threshold, and bounds of the mean of the dark and of the bright pixels, parts of 255.
const THRESHOLD: f32 = 30.0 / 255.0;
const DARK_MEAN: f32 = 15.0 / 255.0;
const BRIGHT_MEAN: f32 = 45.0 / 255.0;
/// Side of a region, px.
const SIDE: usize = 13;
const AREA: usize = SIDE * SIDE;
/// Fewest dark, and fewest bright pixels.
const FEWEST: usize = 27;
/// Least distance of the dark from the bright centre, px: a straight limb through the middle has 6.5.
const LEAST_APART_PX: f32 = 4.0;
/// Farthest that a point may lie from the circle, px.
const TOLERANCE_PX: f32 = 4.0;
/// Shares of agreeing points: enough, and least.
const ENOUGH_SHARE: f32 = 0.95;
const LEAST_SHARE: f32 = 0.5;
/// Most triplets tried.
pub const MAX_TRIPLETS: u32 = 512;
/// The Earth's eccentricity, which is also that of its image from afar over the equator.
pub const ECCENTRICITY: f32 = 0.081;
/// Rounds of the fit; each is linear, and the second changes what the rounding of the first left.
const ROUNDS: usize = 4;
/// Steps of the inverse iteration; each shrinks the error by the ratio of the two least singular values
/// squared.
const STEPS: usize = 6;

/// A circle found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Its centre, px.
    pub centre_px: [f32; 2],
    /// Its radius along the equator, px.
    pub radius_px: f32,
    /// The points on which it rests.
    pub inliers: usize,
}

/// Looks for limb points on the grid. `buffer` must hold the detector's longer side and a region of 13 x 13
/// px.
///
/// # Errors
/// Of the detector; [`DetectorError::BufferLength`] for a short buffer.
pub fn limb_points(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16],
    points: &mut Points,
) -> Result<(), DetectorError> {
    points.clear();
    let geometry = detector.geometry();
    let full_scale = f32::from(geometry.full_scale());
    let threshold = (THRESHOLD * full_scale) as u16;
    let (region, line) = buffer.split_at_mut_checked(AREA).ok_or(DetectorError::BufferLength)?;
    let mut thinned = Decimator::new(points);
    for_each_line(detector, line, [0, GRID_PX], |detector, along_x, across, pixels| {
        for (place, pair) in pixels.windows(2).enumerate() {
            let [one, next] = [pair.first() > Some(&threshold), pair.get(1) > Some(&threshold)];
            if one == next {
                continue;
            }
            let bright = place + usize::from(next);
            let [x, y] = if along_x { [bright, across.into()] } else { [across.into(), bright] };
            if let Some(point) = limb_point([x, y], detector, &geometry, region, full_scale)? {
                thinned.add(point);
            }
        }
        Ok(())
    })
}

/// The crossing in the region about a pixel, after the region has been moved there once.
fn limb_point(
    middle: [usize; 2],
    detector: &mut impl Detector<Error = DetectorError>,
    geometry: &DetectorGeometry,
    region: &mut [u16],
    full_scale: f32,
) -> Result<Option<LimbPoint>, DetectorError> {
    let mut middle = middle;
    let mut point = None;
    for _ in 0..2 {
        let corner = middle.map(|at| at.checked_sub(SIDE / 2).and_then(|at| u16::try_from(at).ok()));
        let [Some(x), Some(y)] = corner else { return Ok(None) };
        let window = Window { x, y, width: SIDE as u16, height: SIDE as u16 };
        if !window.fits(geometry) {
            return Ok(None);
        }
        detector.read(window, region)?;
        let Some((crossing, outward_px)) = crossing(region, full_scale) else { return Ok(None) };
        let centre_px = [f32::from(x) + crossing[0], f32::from(y) + crossing[1]];
        middle = centre_px.map(|at| libm::floorf(at + 0.5) as usize);
        point = Some(LimbPoint::new(centre_px, 1.0, outward_px));
    }
    Ok(point)
}

/// Mean place and brightness of pixels.
#[derive(Clone, Copy, Default)]
struct PixelSums {
    count: usize,
    x: f32,
    y: f32,
    value: f32,
}

impl PixelSums {
    fn add(&mut self, x: usize, y: usize, value: f32) {
        self.count += 1;
        self.x += x as f32;
        self.y += y as f32;
        self.value += value;
    }

    /// Mean place and value; `None` where there are too few.
    fn mean(&self) -> Option<([f32; 2], f32)> {
        let count = self.count as f32;
        (self.count >= FEWEST).then(|| ([self.x / count, self.y / count], self.value / count))
    }
}

/// Where a region passes half of its range, from its first pixel, and the unit vector to the dark side.
fn crossing(region: &[u16], full_scale: f32) -> Option<([f32; 2], [f32; 2])> {
    let threshold = THRESHOLD * full_scale;
    let (mut dark, mut bright) = (PixelSums::default(), PixelSums::default());
    let (mut least, mut most) = (f32::INFINITY, 0.0);
    for (index, raw) in region.iter().enumerate().take(AREA) {
        let value = f32::from(*raw);
        let heap = if value < threshold { &mut dark } else { &mut bright };
        heap.add(index % SIDE, index / SIDE, value);
        least = if value < least { value } else { least };
        most = if value > most { value } else { most };
    }
    let ([dark_x, dark_y], dark_mean) = dark.mean()?;
    let ([bright_x, bright_y], bright_mean) = bright.mean()?;
    let [dx, dy] = [bright_x - dark_x, bright_y - dark_y];
    let apart = libm::sqrtf(dx * dx + dy * dy);
    if dark_mean >= DARK_MEAN * full_scale
        || bright_mean <= BRIGHT_MEAN * full_scale
        || apart < LEAST_APART_PX
    {
        return None;
    }
    let (half, step) = (0.5 * (least + most), [dx / apart, dy / apart]);
    let value = |along: f32| {
        let (x, y) = (dark_x + along * step[0], dark_y + along * step[1]);
        let [column, row] = [x, y].map(|at| libm::floorf(at + 0.5) as usize);
        region.get(row * SIDE + column).filter(|_| column < SIDE).map(|raw| f32::from(*raw))
    };
    let mut outer = value(0.0)?;
    for pixel in 1..SIDE {
        let inner = value(pixel as f32)?;
        if inner > half {
            let part = if inner > outer { (half - outer) / (inner - outer) } else { 1.0 };
            let along = pixel as f32 - 1.0 + part.clamp(0.0, 1.0);
            let at = [dark_x + along * step[0], dark_y + along * step[1]];
            return Some((at, [-step[0], -step[1]]));
        }
        outer = inner;
    }
    None
}

/// Centre and radius of the circle through three points.
fn circle_through([a, b, c]: [[f32; 2]; 3]) -> Option<([f32; 2], f32)> {
    let ([bx, by], [cx, cy]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let twice = 2.0 * (bx * cy - by * cx);
    let (bb, cc) = (bx * bx + by * by, cx * cx + cy * cy);
    let [x, y] = [(cy * bb - by * cc) / twice, (bx * cc - cx * bb) / twice];
    let radius = libm::sqrtf(x * x + y * y);
    // NaN is refused too.
    (radius < 1e6).then_some(([a[0] + x, a[1] + y], radius))
}

/// The circle that most points agree on, circularised along the pole's direction on the detector, and fitted.
///
/// # Errors
/// The first [`FitError`] that holds.
pub fn circle(points: &[LimbPoint], pole_px: [f32; 2], eccentricity: f32) -> Result<Circle, FitError> {
    let points = points.get(..points.len().min(MAX_SEARCH_POINTS)).unwrap_or(points);
    if points.len() < 4 {
        return Err(FitError::TooFewPoints);
    }
    let agrees = |point: &LimbPoint, [x, y]: [f32; 2], radius: f32| {
        let [dx, dy] = [point.centre_px[0] - x, point.centre_px[1] - y];
        libm::fabsf(libm::sqrtf(dx * dx + dy * dy) - radius) < TOLERANCE_PX
    };
    let mut best: Option<(usize, [f32; 2], f32)> = None;
    for number in 0..MAX_TRIPLETS {
        let Some((centre, radius)) = triplet(points, number).and_then(circle_through) else { continue };
        let count = points.iter().filter(|point| agrees(point, centre, radius)).count();
        if best.is_none_or(|(most, ..)| count > most) {
            best = Some((count, centre, radius));
        }
        if count as f32 >= ENOUGH_SHARE * points.len() as f32 {
            break;
        }
    }
    let (inliers, first, first_radius) = best.ok_or(FitError::Degenerate)?;
    if (inliers as f32) < LEAST_SHARE * points.len() as f32 {
        return Err(FitError::NoConsensus);
    }
    let (mut centre, mut radius) = (first, first_radius);
    let axes = Axes::new(pole_px, eccentricity);
    for _ in 0..ROUNDS {
        let kept = points.iter().filter(|point| agrees(point, first, first_radius));
        let shifted = kept.map(|point| {
            let [u, v] = axes.circular([point.centre_px[0] - centre[0], point.centre_px[1] - centre[1]]);
            // In radii, so that the columns are of one size.
            [u / radius, v / radius]
        });
        let (at, share) = gander(shifted).ok_or(FitError::Degenerate)?;
        let [dx, dy] = axes.elliptical([at[0] * radius, at[1] * radius]);
        (centre, radius) = ([centre[0] + dx, centre[1] + dy], radius * share);
    }
    Ok(Circle { centre_px: centre, radius_px: radius, inliers })
}

/// Three different points, in an order that fills the choices evenly.
fn triplet(points: &[LimbPoint], number: u32) -> Option<[[f32; 2]; 3]> {
    let length = points.len();
    let pick = |third: usize, fraction: u32| {
        let (start, end) = (third * length / 3, (third + 1) * length / 3);
        let chance = number.wrapping_add(1).wrapping_mul(fraction);
        let offset = ((u64::from(chance) * (end - start) as u64) >> 32) as usize;
        points.get(start + offset).map(|point| point.centre_px)
    };
    let [f0, f1, f2] = crate::earth::consensus::FRACTIONS;
    Some([pick(0, f0)?, pick(1, f1)?, pick(2, f2)?])
}

/// The axes of the Earth's image, and its stretch along the pole.
struct Axes {
    pole: [f32; 2],
    stretch: f32,
}

impl Axes {
    fn new([x, y]: [f32; 2], eccentricity: f32) -> Self {
        let length = libm::sqrtf(x * x + y * y).max(1e-6);
        let square = (1.0 - eccentricity * eccentricity).clamp(0.1, 1.0);
        Self { pole: [x / length, y / length], stretch: 1.0 / libm::sqrtf(square) }
    }

    /// Along the equator and the pole, made circular.
    fn circular(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [px, py] = self.pole;
        [py * x - px * y, (px * x + py * y) * self.stretch]
    }

    fn elliptical(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let ([px, py], v) = (self.pole, v / self.stretch);
        [py * u + px * v, py * v - px * u]
    }
}

/// Gander's algebraic circle: the least singular vector of the rows `x² + y², x, y, 1`, by inverse iteration
/// on their normal matrix.
fn gander(points: impl Iterator<Item = [f32; 2]>) -> Option<([f32; 2], f32)> {
    let mut normal = Matrix4::zeros();
    let mut count = 0.0;
    for [x, y] in points {
        let row = Vector4::new(x * x + y * y, x, y, 1.0);
        normal += row * row.transpose();
        count += 1.0;
    }
    // Exact points leave the matrix singular.
    const EASED: f32 = 1e-6;
    let inverse = (normal * (1.0 / f32::max(count, 1.0)) + Matrix4::identity() * EASED).try_inverse()?;
    let mut least = Vector4::new(1.0, 0.0, 0.0, -1.0);
    for _ in 0..STEPS {
        least = inverse * least;
        let length = libm::sqrtf(least.dot(&least));
        if !(length > 1e-12 && length < 1e12) {
            return None;
        }
        least *= 1.0 / length;
    }
    let [a, b, c, d] = [least.x, least.y, least.z, least.w];
    let centre = [-0.5 * b / a, -0.5 * c / a];
    let square = centre[0] * centre[0] + centre[1] * centre[1] - d / a;
    (square > 1e-6 && square < 1e6).then(|| (centre, libm::sqrtf(square)))
}

#[cfg(test)]
mod tests;
