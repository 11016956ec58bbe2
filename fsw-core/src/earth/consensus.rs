//! Outlier rejection: which limb points lie on one limb cone (thesis §3.2.1 step 5, global criterion).
//!
//! Three rays fix a limb cone: their unit vectors end in its plane. Up to [`MAX_TRIPLETS`] triplets are
//! tried in a fixed order, fewer where most rays agree. The rays are sorted along the detector axis of
//! their larger extent, and a triplet takes one ray of each third, so that its rays are apart. A ray is an
//! inlier when it lies within the tolerance of the cone, its bright side faces the centre, and the Sun
//! lights the limb there. The cone with most inliers is refitted to them twice.

use super::plane;
use super::rays::{Cone, Ray, Rays};
use super::shape::Body;
use super::{EarthParameters, FitCriteria, FitError};
use crate::order;

/// Largest number of triplets: with half of the points outliers, the probability that none is free of them
/// is 2e-4.
pub const MAX_TRIPLETS: u32 = 64;
/// No more triplets are tried when so many without an outlier were to be expected: the probability that there
/// was none is `exp(-6.9)`, 1e-3.
const EXPECTED_GOOD: f32 = 6.9;
/// Refits to the inliers; the second includes inliers gained by the first.
pub const ROUNDS: usize = 2;
/// Least sine of the Sun's elevation at a limb point: the air a scale height and more above the ground is
/// lit after sunset.
const LEAST_SUN_SINE: f32 = -0.05;
/// Additive recurrence of low discrepancy in three dimensions (powers of the root of x⁴ = x + 1, Roberts
/// 2018), 2^-32.
pub(super) const FRACTIONS: [u32; 3] = [0xD1B5_4A33, 0xABC9_8389, 0x8CB9_2BA7];

/// Whether a ray is an inlier of a cone.
fn is_inlier(ray: &Ray, cone: &Cone, body: &Body, tolerance_px: f32) -> bool {
    let (residual, radial) = cone.residual(ray);
    libm::fabsf(residual) < tolerance_px * ray.rad_per_px
        && ray.sigma_rad(cone, &radial).is_some()
        && body.sun_sine(&cone.surface(&radial)).is_none_or(|sine| sine > LEAST_SUN_SINE)
}

/// The inliers of a cone: bit i is that of ray i.
#[inline(never)]
fn inliers_of(rays: &Rays, cone: &Cone, body: &Body, tolerance_px: f32) -> u128 {
    let bit = |ray| u128::from(is_inlier(ray, cone, body, tolerance_px));
    rays.iter().rev().fold(0, |bits, ray| (bits << 1) | bit(ray))
}

/// The cone through one ray of each third.
fn hypothesis(rays: &Rays, number: u32) -> Option<Cone> {
    let length = rays.len();
    let pick = |third: usize, fraction: u32| {
        let (start, end) = (third * length / 3, (third + 1) * length / 3);
        let chance = number.wrapping_add(1).wrapping_mul(fraction);
        let offset = ((u64::from(chance) * (end - start) as u64) >> 32) as usize;
        rays.get(start + offset).map(|ray| ray.unit)
    };
    let [f0, f1, f2] = FRACTIONS;
    let (a, b, c) = (pick(0, f0)?, pick(1, f1)?, pick(2, f2)?);
    let normal = (b - a).cross(&(c - a));
    Cone::from_plane(&normal, normal.dot(&a))
}

/// Finds the cone with most inliers and keeps only these in the list.
pub(super) fn find_consensus(
    rays: &mut Rays,
    body: &Body,
    criteria: &FitCriteria,
    parameters: &EarthParameters,
) -> Result<Cone, FitError> {
    let tolerance_px = criteria.tolerance_px;
    let all = rays.len();
    if all < criteria.min_inliers.max(3) {
        return Err(FitError::TooFewPoints);
    }
    let range = |part: fn(&Ray) -> f32| {
        let (low, high) = rays.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), ray| {
            let value = part(ray);
            (if value < low { value } else { low }, if value > high { value } else { high })
        });
        high - low
    };
    let along_x = range(|ray| ray.unit.x) > range(|ray| ray.unit.y);
    let place = |ray: &Ray| if along_x { ray.unit.x } else { ray.unit.y };
    order::sort(rays, |one, other| place(one) < place(other));

    let mut best: Option<(u128, Cone)> = None;
    for number in 0..MAX_TRIPLETS {
        let Some(cone) = hypothesis(rays, number) else { continue };
        let with_it = inliers_of(rays, &cone, body, tolerance_px);
        if best.is_none_or(|(most, _)| with_it.count_ones() > most.count_ones()) {
            best = Some((with_it, cone));
        }
        let share = best.map_or(0.0, |(most, _)| most.count_ones() as f32 / all as f32);
        let good = (number + 1) as f32 * share * share * share;
        if share >= parameters.fit.enough_share || good > EXPECTED_GOOD {
            break;
        }
    }
    let (mut inliers, mut cone) = best.ok_or(FitError::Degenerate)?;
    for _ in 0..ROUNDS {
        let Some(fitted) = plane::fit(rays, inliers) else { break };
        let with_fitted = inliers_of(rays, &fitted, body, tolerance_px);
        if with_fitted.count_ones() < inliers.count_ones() {
            break;
        }
        (inliers, cone) = (with_fitted, fitted);
    }
    if (inliers.count_ones() as usize) < criteria.min_inliers {
        return Err(FitError::NoConsensus);
    }
    rays.retain(|_| {
        let chosen = inliers & 1 != 0;
        inliers >>= 1;
        chosen
    });
    Ok(cone)
}

#[cfg(test)]
mod tests;
