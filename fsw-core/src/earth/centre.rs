//! The Earth's centre from limb points (thesis §3.2.2; Christian and Robinson 2016), LEO to GEO.
//!
//! In: limb points, the camera, the [`Body`] (shape, pole, Sun). Out: an [`EarthFix`] or a [`FitError`].
//!
//! After [`consensus`](super::consensus) the limb cone (axis `w`, half angle `θ`) is fitted to the
//! residuals across the limb by [`STEPS`] Gauss-Newton steps with Tukey's weights. For a small turn of the
//! axis by `(a1, a2)` along `e1, e2` and a cone narrower by `a3`, a ray at azimuth `φ` changes its residual
//! by `-a1 cos φ - a2 sin φ + a3`. With `e1` in the middle of the arc and `r = a3 - a1` that is `α (1 - cos
//! φ) - a2 sin φ + r`: the three columns stay independent for any arc, and `1 - cos φ = |t - e1|² / 2` has
//! no cancellation, so normal equations in f32 suffice. Derivatives are taken on the fitted limb, not at
//! the noisy points, so noise causes no bias. Then `C = w / sin θ`, `centre = radius S⁻¹ C`, and the
//! covariance follows by the same derivatives.
//!
//! With a [`CentrePrior`] (of the orbit or of a search) its information is added to the normal equations of
//! the steps, but not to the result: without it the steps of a short arc diverge along the direction in
//! which distance and direction trade off. The limb is then linearised about the combined estimate, and the
//! fix is the linear least-squares solution of the points alone.
//!
//! The covariance is scaled by the residuals' mean square where that exceeds `1 + 2 sqrt(2 / freedom)`. The
//! covariance of errors that neighbouring points share (`shared_heights`), which the residuals do not show,
//! is added. Direction, rms in the tests, 200 points of 100 urad from GEO: see `centre/tests.rs`.

use super::consensus::find_consensus;
use super::rays::{self, Cone, Departure, Departures, Rays};
use super::shape::{Body, normal_basis, unit};
use super::shared_heights::{FitResponse, SharedHeights};
use super::{EarthFix, EarthParameters, FitCriteria, FitError, LimbPoint, MAX_SEARCH_POINTS};
use crate::camera::Camera;
use crate::matrix::{inverse, symmetric_product};
use crate::order;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Gauss-Newton steps.
pub const STEPS: usize = 5;
/// Reweighting rounds of a linear fix; each reduces the remaining error to a sixth.
const LINEAR_ROUNDS: usize = 2;
/// Tukey's constant: 95 % efficiency for Gaussian noise.
const TUKEY: f32 = 4.685;
/// Sigma of Gaussian noise over the median of its absolute value.
const SIGMA_PER_MEDIAN: f32 = 1.4826;
/// Root mean square of a uniform distribution from -1 to 1: `1 / sqrt(3)`.
const UNIFORM_RMS_SHARE: f32 = 0.577_35;
/// Largest step of an angle, rad: the polynomials of `stepped` have an error of 1e-9 there.
const LONGEST_STEP_RAD: f32 = 0.1;
/// Least determinant of the normal equations when their diagonal is brought to one: f32 leaves an error of
/// 1e-3 in such an inverse.
const LEAST_DETERMINANT: f32 = 1e-4;

/// Buffer for the rays of a second and their departures from a cone, 8 KiB.
#[derive(Debug)]
pub struct RayBuffer {
    rays: Rays,
    departures: Departures,
}

impl RayBuffer {
    /// An empty buffer.
    pub const fn new() -> Self {
        Self { rays: Vec::new(), departures: Vec::new() }
    }

    /// Those of the points that the last centre was fitted to.
    pub(super) fn rays(&self) -> &Rays {
        &self.rays
    }
}

impl Default for RayBuffer {
    fn default() -> Self {
        Self::new()
    }
}

/// A priori estimate of the centre, from an orbit or a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentrePrior {
    /// From the camera to the Earth's centre, Earth path's frame, km.
    pub centre_km: Vector3<f32>,
    /// Inverse of its covariance, 1 / km².
    pub information: Matrix3<f32>,
}

impl CentrePrior {
    /// From a centre and its covariance (km, km²); `None` where that has no inverse.
    pub fn new(centre_km: Vector3<f32>, covariance_km2: &Matrix3<f64>) -> Option<Self> {
        let information = inverse(covariance_km2)?.map(|element| element as f32);
        Some(Self { centre_km, information })
    }

    /// From a rough fix; `None` where its covariance has no inverse.
    pub fn from_fix(rough: &EarthFix) -> Option<Self> {
        Self::new(rough.centre_km, &rough.covariance_km2.map(f64::from))
    }
}

/// Symmetric normal equations of three unknowns.
#[derive(Default)]
struct NormalEquations {
    matrix: Matrix3<f32>,
    right: Vector3<f32>,
    /// Sums of weighted squares and of weights.
    squares: f32,
    weights: f32,
}

impl NormalEquations {
    fn add(&mut self, row: &Vector3<f32>, residual: f32, weight: f32) {
        self.matrix += row * row.transpose() * weight;
        self.right -= row * (residual * weight);
    }

    /// Adds a prior: `columns` are the derivatives of the centre `centre_km` by the unknowns.
    fn add_prior(&mut self, prior: &CentrePrior, centre_km: &Vector3<f32>, columns: &Matrix3<f32>) {
        let weighted = columns.transpose() * prior.information;
        self.matrix += weighted * columns;
        self.right += weighted * (prior.centre_km - centre_km);
    }

    /// The inverse matrix, by cofactors of the matrix scaled to a unit diagonal.
    fn inverse(&self) -> Option<Matrix3<f32>> {
        let m = &self.matrix;
        let diagonal = Vector3::new(m.m11, m.m22, m.m33);
        if !diagonal.iter().all(|value| *value > 1e-20 && *value < 1e30) {
            return None;
        }
        let scale = diagonal.map(|value| 1.0 / libm::sqrtf(value));
        let (a, b, c) = (m.m12 * scale.x * scale.y, m.m13 * scale.x * scale.z, m.m23 * scale.y * scale.z);
        let determinant = 1.0 - a * a - b * b - c * c + 2.0 * a * b * c;
        if determinant.is_nan() || determinant <= LEAST_DETERMINANT {
            return None;
        }
        let (ab, ac, bc) = (b * c - a, a * c - b, a * b - c);
        let cofactors =
            Matrix3::new(1.0 - c * c, ab, ac, ab, 1.0 - b * b, bc, ac, bc, 1.0 - a * a) * (1.0 / determinant);
        let scale = Matrix3::new(scale.x, 0.0, 0.0, 0.0, scale.y, 0.0, 0.0, 0.0, scale.z);
        Some(scale * cofactors * scale)
    }
}

/// All rays as they depart from a cone: every sum of a step runs over the same.
struct Departing<'a> {
    departures: &'a [Departure],
    cone: &'a Cone,
    /// Scale of the normalised residuals.
    scale: f32,
}

impl<'a> Departing<'a> {
    /// `departures` is overwritten.
    #[inline(never)]
    fn new(departures: &'a mut Departures, rays: &Rays, cone: &'a Cone) -> Self {
        departures.clear();
        order::fill(departures, rays.iter().map(|ray| cone.departure(ray)));
        let scale = residual_scale(departures);
        Self { departures, cone, scale }
    }

    /// Residual over its sigma, the sigma, rad, and the unit vector across the axis of those that have
    /// information.
    fn normalised(&self) -> impl Iterator<Item = (f32, f32, &Vector3<f32>)> {
        self.departures.iter().filter_map(|Departure { normalised, radial, .. }| {
            normalised.map(|(ratio, sigma)| (ratio, sigma, radial))
        })
    }
}

/// Scale of the normalised residuals, at least one: 1.4826 times the median, robust against outliers.
fn residual_scale(departures: &[Departure]) -> f32 {
    let mut sizes = [0.0; MAX_SEARCH_POINTS];
    let mut count = 0;
    let ratios = departures.iter().filter_map(|departure| departure.normalised);
    for (size, (ratio, _)) in sizes.iter_mut().zip(ratios) {
        *size = libm::fabsf(ratio);
        count += 1;
    }
    let sizes = sizes.get_mut(..count).unwrap_or(&mut []);
    order::sort_numbers(sizes);
    (SIGMA_PER_MEDIAN * sizes.get(count / 2).copied().unwrap_or(0.0)).max(1.0)
}

/// Tukey's weight of a residual in units of its scale.
fn tukey(ratio: f32) -> f32 {
    let share = 1.0 - (ratio / TUKEY) * (ratio / TUKEY);
    if share > 0.0 { share * share } else { 0.0 }
}

/// Axes across the cone's, the first in the middle of the arc.
fn arc_axes(rays: &Departing) -> [Vector3<f32>; 2] {
    let (sum, cone) = (rays.departures.iter().fold(Vector3::zeros(), |sum, ray| sum + ray.radial), rays.cone);
    let sum: Vector3<f32> = sum - cone.axis * cone.axis.dot(&sum);
    // Points around the whole limb: no middle of the arc, any axis.
    let first = if sum.dot(&sum) > 1e-4 { unit(&sum, &sum) } else { normal_basis(&cone.axis).0 };
    [first, cone.axis.cross(&first)]
}

/// The unknowns' derivatives of a residual: of (α, a2, r).
fn jacobian_row(radial: &Vector3<f32>, [first, second]: &[Vector3<f32>; 2]) -> Vector3<f32> {
    let from_middle = radial - first;
    Vector3::new(0.5 * from_middle.dot(&from_middle), -second.dot(radial), 1.0)
}

/// The normal equations about a cone, their weights those after a step of (α, a2, r).
fn normal_equations(rays: &Departing, axes: &[Vector3<f32>; 2], step: &Vector3<f32>) -> NormalEquations {
    let mut normal = NormalEquations::default();
    for (ratio, sigma, radial) in rays.normalised() {
        let row = jacobian_row(radial, axes) * (1.0 / sigma);
        let left = ratio + row.dot(step);
        let weight = tukey(left / rays.scale);
        normal.add(&row, ratio, weight);
        normal.squares += weight * left * left;
        normal.weights += weight;
    }
    normal
}

/// Covariance of the unknowns by the heights that neighbouring points share, propagated through the
/// least-squares solution with these weights (after a step of (α, a2, r)) and this inverse matrix.
fn shared_covariance(
    rays: &Departing,
    axes: &[Vector3<f32>; 2],
    step: &Vector3<f32>,
    inverse: &Matrix3<f32>,
    heights: &SharedHeights,
) -> Matrix3<f32> {
    let [first, second] = axes;
    let mut response = FitResponse::default();
    for (ratio, sigma, radial) in rays.normalised() {
        let row = jacobian_row(radial, axes);
        let weight = tukey((ratio + row.dot(step) / sigma) / rays.scale);
        response.add([first.dot(radial), second.dot(radial)], &(inverse * row * (weight / (sigma * sigma))));
    }
    response.covariance(heights)
}

/// The cone after a step of (α, a2, r).
fn stepped(cone: &Cone, [first, second]: &[Vector3<f32>; 2], step: &Vector3<f32>) -> Option<Cone> {
    let held = |angle: f32| angle.clamp(-LONGEST_STEP_RAD, LONGEST_STEP_RAD);
    let (turn, aside, narrower) = (held(step.x), held(step.y), held(step.x + step.z));
    let axis = cone.axis + first * turn + second * aside;
    // Of an angle up to 0.1 rad: error 1e-9.
    let square = narrower * narrower;
    let sine = narrower * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)));
    let cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0));
    Cone::from_parts(
        unit(&axis, &cone.axis),
        cone.sine * cosine - cone.cosine * sine,
        cone.cosine * cosine + cone.sine * sine,
    )
}

/// Azimuth that the rays span, rad: 2π less the widest gap.
fn arc_rad(rays: &[Departure], [first, second]: &[Vector3<f32>; 2]) -> f32 {
    let mut azimuths = [0.0; MAX_SEARCH_POINTS];
    for (azimuth, Departure { radial, .. }) in azimuths.iter_mut().zip(rays) {
        *azimuth = libm::atan2f(second.dot(radial), first.dot(radial));
    }
    let azimuths = azimuths.get_mut(..rays.len()).unwrap_or(&mut []);
    order::sort_numbers(azimuths);
    let (Some(least), Some(greatest)) = (azimuths.first(), azimuths.last()) else { return 0.0 };
    let turn = core::f32::consts::TAU;
    let across_back = turn - (greatest - least);
    let widest = azimuths.windows(2).fold(across_back, |widest, pair| match pair {
        [one, next] if next - one > widest => next - one,
        _ => widest,
    });
    turn - widest
}

/// The centre of a cone, km, and its derivatives by the unknowns.
fn centre_and_derivatives(
    cone: &Cone,
    [first, second]: &[Vector3<f32>; 2],
    body: &Body,
) -> (Vector3<f32>, Matrix3<f32>) {
    let range = body.radius_km() / cone.sine;
    let deeper = cone.cosine / cone.sine;
    let columns = Matrix3::from_columns(&[
        body.in_space(&(first + cone.axis * deeper)) * range,
        body.in_space(second) * range,
        body.in_space(&cone.axis) * (range * deeper),
    ]);
    (body.in_space(&cone.axis) * range, columns)
}

/// The fix of a fitted cone; `linear`: the linear solution of the points about that cone (fit with a
/// prior).
fn fix(
    rays: &Rays,
    departing: &Departing,
    body: &Body,
    linear: bool,
    parameters: &EarthParameters,
) -> Result<EarthFix, FitError> {
    let (axes, cone) = (arc_axes(departing), departing.cone);
    let mut about = normal_equations(departing, &axes, &Vector3::zeros());
    let mut inverse = about.inverse().ok_or(FitError::Degenerate)?;
    let mut step = Vector3::zeros();
    // Without reweighting the fix would stay at the linearisation by a sixth of the way.
    for _ in 0..if linear { LINEAR_ROUNDS } else { 0 } {
        step = inverse * about.right;
        about = normal_equations(departing, &axes, &step);
        inverse = about.inverse().ok_or(FitError::Degenerate)?;
    }
    let normal = about;
    let freedom = (normal.weights - 3.0).max(1.0);
    // The mean square of the residuals scatters by sqrt(2 / freedom); two sigma are tolerated.
    let chance = 1.0 + 2.0 * libm::sqrtf(2.0 / freedom);
    let mean_square = normal.squares / freedom;
    let enlarged = if mean_square > chance { mean_square } else { 1.0 };

    let (linearisation_km, columns) = centre_and_derivatives(cone, &axes, body);
    if linear {
        step = inverse * normal.right;
    }
    let shift_km = columns * step;
    // The scale of any point; it varies little over a limb.
    let rad_per_px = rays.first().map_or(0.0, |ray| ray.rad_per_px);
    let heights = SharedHeights::new(cone, body, rad_per_px, parameters);
    let shared = shared_covariance(departing, &axes, &step, &inverse, &heights);
    let noise = inverse * enlarged;
    let (mut squares, mut inliers, mut count) = (0.0, 0u128, 0.0);
    for (ray, Departure { residual, .. }) in rays.iter().zip(departing.departures) {
        squares += (residual / ray.rad_per_px) * (residual / ray.rad_per_px);
        inliers |= 1u128.wrapping_shl(u32::from(ray.index));
        count += 1.0;
    }
    Ok(EarthFix {
        centre_km: linearisation_km + shift_km,
        linearisation_km,
        covariance_km2: symmetric_product(&columns, &(noise + shared)),
        noise_km2: symmetric_product(&columns, &noise),
        arc_rad: arc_rad(departing.departures, &axes),
        rms_px: libm::sqrtf(squares / f32::max(count, 1.0)),
        inliers,
    })
}

/// The Earth's centre from up to [`MAX_SEARCH_POINTS`] limb points under `criteria`. With a `prior` the fit
/// is linear about the combined estimate of points and prior.
///
/// # Errors
/// The first [`FitError`] that applies.
pub fn centre(
    points: &[LimbPoint],
    camera: &Camera,
    body: &Body,
    criteria: &FitCriteria,
    prior: Option<&CentrePrior>,
    parameters: &EarthParameters,
    workspace: &mut RayBuffer,
) -> Result<EarthFix, FitError> {
    let RayBuffer { rays, departures } = workspace;
    rays::fill(rays, points, camera, body);
    let agreed = find_consensus(rays, body, criteria, parameters)?;
    let start = prior.and_then(|prior| Some((prior, Cone::about(&prior.centre_km, body)?)));
    let mut cone = start.map_or(agreed, |(_, cone)| cone);
    for _ in 0..STEPS {
        let departing = Departing::new(departures, rays, &cone);
        let axes = arc_axes(&departing);
        let mut normal = normal_equations(&departing, &axes, &Vector3::zeros());
        if let Some((prior, _)) = start {
            let (centre_km, columns) = centre_and_derivatives(&cone, &axes, body);
            normal.add_prior(prior, &centre_km, &columns);
        }
        let step = normal.inverse().ok_or(FitError::Degenerate)? * normal.right;
        cone = stepped(&cone, &axes, &step).ok_or(FitError::Degenerate)?;
    }
    let departing = Departing::new(departures, rays, &cone);
    let fix = fix(rays, &departing, body, start.is_some(), parameters)?;
    // Rejects a consensus that contradicts the prior, where the linearisation does not hold. Without a
    // prior also chance agreement, whose residuals are uniform over the tolerance.
    let greatest_px =
        if criteria.standalone { UNIFORM_RMS_SHARE * criteria.tolerance_px } else { criteria.tolerance_px };
    if fix.rms_px.is_nan() || fix.rms_px > greatest_px {
        return Err(FitError::NoConsensus);
    }
    if fix.arc_rad < parameters.fit.least_arc_deg.to_radians() {
        return Err(FitError::ShortArc);
    }
    // With a prior of the orbit a weakly determined direction is only weighted less.
    if !criteria.standalone {
        return Ok(fix);
    }
    let (direction_rad, range_km) = fix.sigmas();
    let distance_km = fix.distance_km();
    if distance_km > parameters.plausible.distance_km {
        return Err(FitError::Degenerate);
    }
    let known = direction_rad <= parameters.plausible.sigma_deg.to_radians()
        && range_km <= parameters.plausible.range_share * distance_km;
    if known { Ok(fix) } else { Err(FitError::Uncertain) }
}

#[cfg(test)]
mod tests;
