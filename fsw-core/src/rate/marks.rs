//! Stars and streaks of one image in another: where they must be at a rate, and the rate from where they are.
//!
//! In: the [`Mark`]s of two images, the seconds between them, and a rate that is to be tried or none. Out:
//! arcs for [`arcs::solve`], or the mean rate between the two images itself.
//!
//! A rate says where each mark must be in the other image ([`match_at_rate`]); without one the marks are matched
//! by their separations ([`match_by_separation`], thesis §3.1.5, LARM): every two of one image that are as far apart as
//! two of the other propose a rate, and that on which most marks agree counts.

use super::arcs::{self, Arc, MAX_ARCS, RateFit};
use crate::trigonometry::sine_cosine;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Stars and streaks of an image remembered for the next.
pub const MAX_MARKS: usize = 12;
/// A free body's rate changes by this times its square a second: Euler's equations with moments of inertia
/// that differ by a fifth, one sigma.
pub const FREE_BODY_CHANGE: f32 = 0.2;
/// Rates beyond this are none of a spacecraft, rad/s.
pub const FASTEST_RAD_S: f32 = 0.35;
/// Fewest stars of two images that make a rate.
const FEWEST_MATCHES: u32 = 4;
/// Farthest from its predicted place that a streak may go on, px.
const FARTHEST_PX: f32 = 60.0;

/// What is known of the camera: radians a pixel at the optical centre, and pixels of the detector.
#[derive(Clone, Copy, Debug)]
pub struct DetectorScale {
    /// Angle of a pixel, rad.
    pub rad_per_px: f32,
    /// Pixels of the detector.
    pub area_px: f32,
}

/// A star, or a streak's middle.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    /// Unit vector, star path.
    pub direction: Vector3<f32>,
    /// Along the motion and across it, rad.
    pub sigma_rad: [f32; 2],
    /// Later than the middle of the frame, s.
    pub late_s: f32,
}

/// Where a mark is after a time at a rate.
#[inline(never)]
pub fn rotated(mark: &Mark, rate: &Vector3<f32>, elapsed_s: f32) -> Vector3<f32> {
    // b' = -ω × b, by the exact rotation about a fixed axis.
    let angle = libm::sqrtf(rate.dot(rate)) * elapsed_s;
    let Some(axis) = rate.try_normalize(1e-9) else { return mark.direction };
    let (sine, cosine) = sine_cosine(angle);
    let b = mark.direction;
    b * cosine - axis.cross(&b) * sine + axis * (axis.dot(&b) * (1.0 - cosine))
}

/// How far a mark may lie from where a rate carries it, three sigma, rad: the rate's error across its
/// direction, with what else is not known of the rate (`off`, one sigma, rad/s), and the errors of two marks.
#[inline(never)]
fn search_radius(
    mark: &Mark,
    there: &Vector3<f32>,
    covariance: &Matrix3<f32>,
    off: f32,
    elapsed_s: f32,
) -> f32 {
    let spread = covariance.trace() - there.dot(&(covariance * there));
    let [along, across] = mark.sigma_rad;
    let variance =
        (spread.max(0.0) + off * off) * elapsed_s * elapsed_s + 2.0 * (along * along + across * across);
    3.0 * libm::sqrtf(variance)
}

/// The way of a star from a mark of one image to that of the next.
#[inline(never)]
fn arc_between(from: &Mark, to: &Mark, elapsed_s: f32) -> Arc {
    let both = |a: f32, b: f32| libm::sqrtf(a * a + b * b);
    let ([a, b], [c, d]) = (from.sigma_rad, to.sigma_rad);
    Arc {
        ends: [from.direction, to.direction],
        sigma_rad: [both(a, c), both(b, d)],
        duration_s: [elapsed_s + to.late_s - from.late_s; 2],
        directed: true,
        whole: true,
    }
}

/// Finds the marks that go on in the next image at a rate, and gives the expected number that would by
/// chance.
#[inline(never)]
pub fn match_at_rate(
    arcs: &mut Vec<Arc, MAX_ARCS>,
    (before, now): (&[Mark], &[Mark]),
    (rate, covariance): (&Vector3<f32>, &Matrix3<f32>),
    elapsed_s: f32,
    field: DetectorScale,
) -> f32 {
    arcs.clear();
    let mut chance = 0.0;
    let farthest = FARTHEST_PX * field.rad_per_px;
    // The rate's change since.
    let change = 0.5 * FREE_BODY_CHANGE * rate.dot(rate) * elapsed_s;
    for mark in before {
        let there = rotated(mark, rate, elapsed_s);
        let reach = search_radius(mark, &there, covariance, change, elapsed_s);
        if reach.is_nan() || reach > farthest {
            continue;
        }
        let per_px = reach / field.rad_per_px;
        chance += now.len() as f32 * core::f32::consts::PI * per_px * per_px / field.area_px;
        let distance = |mark: &&Mark| (mark.direction - there).norm_squared();
        let nearest = now.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(found) = nearest.filter(|found| distance(found) < reach * reach) {
            let _ = arcs.push(arc_between(mark, found, elapsed_s));
        }
    }
    chance
}

/// The rate between two images from the marks of both, matched by their separations.
#[inline(never)]
pub fn match_by_separation(before: &[Mark], now: &[Mark], elapsed_s: f32) -> Option<RateFit> {
    let mut best: Option<RateFit> = None;
    let sigma = |mark: &Mark| mark.sigma_rad[0].max(mark.sigma_rad[1]);
    for (index, a) in before.iter().enumerate() {
        for b in before.iter().skip(index + 1) {
            let separation = (a.direction - b.direction).norm();
            for (other, c) in now.iter().enumerate() {
                for d in now.iter().skip(other + 1) {
                    let off = ((c.direction - d.direction).norm() - separation).abs();
                    if off > 4.0 * (sigma(a) + sigma(b)).max(sigma(c) + sigma(d)) {
                        continue;
                    }
                    for (c, d) in [(c, d), (d, c)] {
                        let proposed =
                            arcs::solve(&[arc_between(a, c, elapsed_s), arc_between(b, d, elapsed_s)]);
                        let Some(rate) = proposed.filter(|rate| rate.rad_s.norm() < FASTEST_RAD_S) else {
                            continue;
                        };
                        let most = best.as_ref().map_or(FEWEST_MATCHES - 1, RateFit::count);
                        if let Some(rate) =
                            refined_by_marks(before, now, &rate, elapsed_s).filter(|rate| rate.count() > most)
                        {
                            best = Some(rate);
                        }
                    }
                }
            }
        }
    }
    best
}

/// The rate from all marks that are where a proposed rate carries them.
#[inline(never)]
fn refined_by_marks(before: &[Mark], now: &[Mark], rate: &RateFit, elapsed_s: f32) -> Option<RateFit> {
    let mut arcs: Vec<Arc, MAX_MARKS> = Vec::new();
    for mark in before {
        let there = rotated(mark, &rate.rad_s, elapsed_s);
        let reach = search_radius(mark, &there, &rate.covariance, 0.0, elapsed_s);
        if let Some(found) = now.iter().find(|found| (found.direction - there).norm_squared() < reach * reach)
        {
            let _ = arcs.push(arc_between(mark, found, elapsed_s));
        }
    }
    if (arcs.len() as u32) < FEWEST_MATCHES {
        return None;
    }
    arcs::solve(&arcs)
}
