//! Rate from moving directions: a streak from end to end, a star from one image to the next (thesis §3.1.5,
//! LARM and HARM).
//!
//! In: [`Arc`]s, directions in the star path's frame before and after a time. Out: the [`RateFit`] of the
//! star path against the stars, in its own frame, and its covariance. A fixed direction's components change
//! as `db/dt = -ω × b`; over a turn by θ = |ω| τ about a fixed axis its chord is exactly `c - a = -g × (a +
//! c)`, `g = ω/|ω| tan(θ/2)` (Cayley). Along and across each chord that is one equation; least squares over
//! all of them give `g`. A streak cut by the border has only the equation across.
//!
//! Outliers are rejected by consensus: every two arcs propose a rate, and the one of least cost is refined. The
//! cost is the sum of the arcs' misfits, an outlier's counted as an inlier's may be at most (MSAC, Torr and
//! Zisserman 2000). By the number of inliers, five short arcs that agree badly, each of which may run either
//! way, would outdo four that agree well. One arc alone leaves the component about its direction undetermined
//! and gives no rate.
//!
//! Sense. One image does not determine which end of a streak was first; [`undirected`](Arc::directed) arcs
//! are oriented to fit the proposal, and the rate is one of two opposite ones.

use crate::attitude::covariance::Information;
use crate::trigonometry::hypotenuse;
use nalgebra::{Matrix3, Vector3};

/// Largest number of arcs.
pub const MAX_ARCS: usize = 24;
/// Largest squared distance of an inlier from a rate, sigmas² of both axes.
const INLIER_SQUARE: f32 = 12.0;

/// Additional variance factor over the redundant equations: with few arcs an outlier may be undetected.
const FEW_ARCS_INFLATION: f32 = 6.0;

/// A direction before and after.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// Unit vectors, star path.
    pub ends: [Vector3<f32>; 2],
    /// Standard deviation of the displacement, along and across it, rad.
    pub sigma_rad: [f32; 2],
    /// From the first end to the second, and from the second to the first were it the earlier one, s: rows of
    /// a rolling shutter begin one after the other.
    pub duration_s: [f32; 2],
    /// Whether the first end is known to be the earlier one.
    pub directed: bool,
    /// Whether its length is known.
    pub whole: bool,
}

/// A rate from arcs.
#[derive(Clone, Copy, Debug)]
pub struct RateFit {
    /// Of the star path against the stars, in its own frame, rad/s.
    pub rad_s: Vector3<f32>,
    /// Its covariance, (rad/s)².
    pub covariance: Matrix3<f32>,
    /// Inliers, a bit per arc.
    pub arcs: u32,
}

/// Whether the bit of an arc is set.
pub(super) fn is_set(arcs: u32, index: usize) -> bool {
    (arcs >> index) & 1 == 1
}

impl RateFit {
    /// Number of inliers.
    pub fn count(&self) -> u32 {
        self.arcs.count_ones()
    }

    /// Standard deviations about x, y, z, rad/s.
    pub fn sigma_rad_s(&self) -> Vector3<f32> {
        self.covariance.diagonal().map(|variance| libm::sqrtf(variance.max(0.0)))
    }
}

/// Equation of an arc: `row · ω = right`, both over its sigma.
struct Equation {
    row: Vector3<f32>,
    right: f32,
}

/// The equations along and across of an arc, taken from its second end to its first where `reversed`;
/// `None` where its ends coincide. `g` is linear in ω but for the tangent, which is that of the rate
/// `about`.
#[inline(never)]
fn equations(arc: &Arc, about: &Vector3<f32>) -> Option<[Option<Equation>; 2]> {
    let [a, c] = arc.ends;
    let [forth_s, back_s] = arc.duration_s;
    let (a, c, duration_s) = if is_reversed(arc, about) { (c, a, back_s) } else { (a, c, forth_s) };
    let (chord, sum) = (c - a, a + c);
    let along = chord.try_normalize(1e-7)?;
    let across = sum.cross(&along).try_normalize(1e-7)?;
    let half_s = half_tangent_s(about, duration_s);
    // e · (c - a) = -e · (g × (a + c)) = -g · ((a + c) × e)
    let of = |axis: &Vector3<f32>, right: f32, sigma: f32| Equation {
        row: sum.cross(axis) * (-half_s / sigma),
        right: right / sigma,
    };
    let [sigma_along, sigma_across] = arc.sigma_rad;
    let lengthwise = arc.whole.then(|| of(&along, chord.dot(&along), sigma_along));
    Some([lengthwise, Some(of(&across, 0.0, sigma_across))])
}

/// Whether an undirected arc must be reversed to fit a rate.
fn is_reversed(arc: &Arc, h: &Vector3<f32>) -> bool {
    let [a, c] = arc.ends;
    !arc.directed && (c - a).dot(&h.cross(&(a + c))) > 0.0
}

/// By how much an arc is off a rate, rad/s, along and across itself, sigmas; along a cut one by nothing.
/// `None` where its ends coincide.
#[inline(never)]
pub fn misfits(arc: &Arc, rate: &Vector3<f32>) -> Option<[f32; 2]> {
    let off =
        |equation: Option<Equation>| equation.map_or(0.0, |equation| equation.row.dot(rate) - equation.right);
    equations(arc, rate).map(|equations| equations.map(off))
}

/// Squared distance of an arc from a rate, sigmas.
fn misfit(arc: &Arc, h: &Vector3<f32>) -> f32 {
    misfits(arc, h).map_or(f32::MAX, |[along, across]| along * along + across * across)
}

/// Information is counted in 1/mrad².
const SCALE: f32 = 1e-6;

/// Normal equations of the arcs whose bits are set, oriented to fit `about`: information, 1/mrad², and its
/// product with the rate.
#[inline(never)]
fn normal_equations(arcs: &[Arc], bits: u32, about: &Vector3<f32>) -> Option<(Matrix3<f32>, Vector3<f32>)> {
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (index, arc) in arcs.iter().enumerate() {
        if !is_set(bits, index) {
            continue;
        }
        for equation in equations(arc, about)?.iter().flatten() {
            let row = equation.row;
            matrix += Matrix3::from_columns(&[row * row.x, row * row.y, row * row.z]) * SCALE;
            right += equation.row * (equation.right * SCALE);
        }
    }
    Some((matrix, right))
}

/// Not inlined, to save flash.
#[inline(never)]
fn inverse(matrix: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    matrix.try_inverse()
}

/// A rate updated by independent information, 1/mrad², given with its product with the rate.
#[inline(never)]
fn updated(
    (rate, covariance): (Vector3<f32>, Matrix3<f32>),
    information: &Matrix3<f32>,
    right: &Vector3<f32>,
) -> Option<(Vector3<f32>, Matrix3<f32>)> {
    let before = inverse(&(covariance * (1.0 / SCALE)))?;
    let covariance = inverse(&(before + information))?;
    Some((covariance * (before * rate + right), covariance * SCALE))
}

/// Least squares over the arcs whose bits are set, oriented to fit `about`.
#[inline(never)]
fn least_squares(arcs: &[Arc], bits: u32, about: &Vector3<f32>) -> Option<(Vector3<f32>, Matrix3<f32>)> {
    let (matrix, right) = normal_equations(arcs, bits, about)?;
    let information = Information::from_sum(matrix);
    Some((information.solve(&right)?, information.covariance_rad2()?))
}

/// A rate updated by directed arcs, which may be too few for a solution of their own; their mean rate may
/// differ from it by `off` about every axis, rad/s. `None` where an arc does not agree with the result.
#[inline(never)]
pub fn corrected(
    (rate, covariance): (Vector3<f32>, Matrix3<f32>),
    arcs: &[Arc],
    off: f32,
) -> Option<(Vector3<f32>, Matrix3<f32>)> {
    let (matrix, right) = normal_equations(arcs, u32::MAX, &rate)?;
    // With the common error: (M⁻¹ + off²)⁻¹, without inverting M.
    let shared = inverse(&(Matrix3::identity() + matrix * (off * off / SCALE)))?;
    let (rate, covariance) = updated((rate, covariance), &(shared * matrix), &(shared * right))?;
    let agrees = |arc: &Arc| {
        let share = off * arc.duration_s[0];
        let looser = arc.sigma_rad.map(|sigma| hypotenuse(sigma, share));
        misfit(&Arc { sigma_rad: looser, ..*arc }, &rate) < INLIER_SQUARE
    };
    arcs.iter().all(agrees).then_some((rate, covariance))
}

/// The inliers of a rate, and its cost.
#[inline(never)]
fn inliers_of(arcs: &[Arc], h: &Vector3<f32>) -> (u32, f32) {
    arcs.iter().enumerate().fold((0, 0.0), |(bits, cost), (index, arc)| {
        let misfit = misfit(arc, h);
        if misfit < INLIER_SQUARE { (bits | 1 << index, cost + misfit) } else { (bits, cost + INLIER_SQUARE) }
    })
}

/// The rate of least cost; `None` where no two arcs determine all three components. With undirected arcs the
/// opposite rate fits equally well.
#[inline(never)]
pub fn solve(arcs: &[Arc]) -> Option<RateFit> {
    let arcs = arcs.get(..MAX_ARCS).unwrap_or(arcs);
    let mut best: Option<(Vector3<f32>, u32, f32)> = None;
    for (first, one) in arcs.iter().enumerate() {
        for (second, other) in arcs.iter().enumerate().skip(first + 1) {
            if !(one.whole || other.whole) {
                continue;
            }
            for flipped in [false, true] {
                let [a, c] = other.ends;
                let [forth_s, back_s] = other.duration_s;
                let (ends, duration_s) =
                    if flipped { ([c, a], [back_s, forth_s]) } else { ([a, c], [forth_s, back_s]) };
                let second_arc = Arc { ends, duration_s, directed: true, ..*other };
                let pair = [Arc { directed: true, ..*one }, second_arc];
                let proposed = least_squares(&pair, 3, &Vector3::zeros());
                // Second iteration, with the tangent of the first result.
                let proposed = proposed.and_then(|(rate, _)| least_squares(&pair, 3, &rate));
                if let Some((h, _)) = proposed.filter(|_| !(flipped && other.directed)) {
                    let (bits, cost) = inliers_of(arcs, &h);
                    let both = (1 << first) | (1 << second);
                    if bits & both == both && best.is_none_or(|(_, _, least)| cost < least) {
                        best = Some((h, bits, cost));
                    }
                }
            }
        }
    }
    let (rate, bits, _) = best?;
    refined(arcs, rate, bits)
}

/// The rate of the opposite sense that explains undirected arcs as well.
#[inline(never)]
pub fn opposite(arcs: &[Arc], rate: &RateFit) -> Option<RateFit> {
    refined(arcs.get(..MAX_ARCS).unwrap_or(arcs), -rate.rad_s, rate.arcs)
}

/// Least squares from a first estimate and the arcs that agree with it.
#[inline(never)]
fn refined(arcs: &[Arc], rate: Vector3<f32>, bits: u32) -> Option<RateFit> {
    let (mut rate, mut bits) = (rate, bits);
    let mut covariance = Matrix3::zeros();
    for _ in 0..3 {
        (rate, covariance) = least_squares(arcs, bits, &rate)?;
        bits = inliers_of(arcs, &rate).0;
    }
    if bits.count_ones() < 2 {
        return None;
    }
    // Redundant equations scale the covariance by their mean square.
    let (count, misfit) = arcs
        .iter()
        .enumerate()
        .filter(|(index, _)| is_set(bits, *index))
        .fold((0.0, 0.0), |(n, sum), (_, arc)| {
            (n + if arc.whole { 2.0 } else { 1.0 }, sum + misfit(arc, &rate))
        });
    let free: f32 = count - 3.0;
    if free >= 1.0 {
        covariance *= (misfit / free).max(1.0) * (1.0 + FEW_ARCS_INFLATION / free);
    }
    Some(RateFit { rad_s: rate, covariance, arcs: bits })
}

/// A rate's covariance enlarged by the same independent sigma about every axis, rad/s.
pub fn inflated(covariance: Matrix3<f32>, by_rad_s: f32) -> Matrix3<f32> {
    enlarged(covariance, &Vector3::repeat(by_rad_s))
}

/// The same by a sigma for each axis.
pub fn enlarged(covariance: Matrix3<f32>, by_rad_s: &Vector3<f32>) -> Matrix3<f32> {
    covariance + Matrix3::from_diagonal(&by_rad_s.component_mul(by_rad_s))
}

/// Fuses two independent estimates of a rate.
#[inline(never)]
pub fn fused(
    a: (Vector3<f32>, Matrix3<f32>),
    b: (Vector3<f32>, Matrix3<f32>),
) -> Option<(Vector3<f32>, Matrix3<f32>)> {
    let information = inverse(&(b.1 * (1.0 / SCALE)))?;
    updated(a, &information, &(information * b.0))
}

/// Whether two rates agree within 4 sigma, allowing a change of `change` about every axis, rad/s; `None`
/// where the variance exceeds a tenth of the squared rate, so that the test has no power.
#[inline(never)]
pub fn are_consistent(a: &RateFit, b: &RateFit, change: f32) -> Option<bool> {
    let difference = (a.rad_s - b.rad_s) * libm::sqrtf(1.0 / SCALE);
    let covariance = inflated(a.covariance + b.covariance, change) * (1.0 / SCALE);
    let sizes = (a.rad_s.norm_squared(), b.rad_s.norm_squared());
    if covariance.trace() >= 0.1 / SCALE * sizes.0.max(sizes.1) {
        return None;
    }
    let weight = inverse(&covariance)?;
    Some(difference.dot(&(weight * difference)) < 16.0)
}

/// `tan(|ω| τ / 2) / |ω|`: half of τ for a small angle.
fn half_tangent_s(rate: &Vector3<f32>, duration_s: f32) -> f32 {
    let half_s = 0.5 * duration_s;
    let square = (half_s * half_s * rate.dot(rate)).min(1.0);
    // tan(x) / x by its continued fraction, 3e-7 up to x = 1.
    half_s * (945.0 - square * (105.0 - square)) / (945.0 - square * (420.0 - 15.0 * square))
}

#[cfg(test)]
pub(super) mod tests;
