//! Matching of stars and streaks between two images, with or without a rate hypothesis.
//!
//! In: the [`Mark`]s of two images, the seconds between them, and optionally a rate to test. Out: arcs for
//! [`arcs::solve`], or the mean rate between the two images itself.
//!
//! With a rate the position of each mark in the other image is predicted ([`match_at_rate`]); without one
//! the marks are matched by their separations ([`match_by_separation`], thesis §3.1.5, LARM): two pairs of
//! equal separation propose a rate, and the rate with most matches is taken.

use super::arcs::{self, Arc, MAX_ARCS, RateFit};
use crate::attitude::filter::free_body_change;
use crate::trigonometry::{hypotenuse, sine_cosine};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Largest number of stars and streaks kept for the next image.
pub const MAX_MARKS: usize = 12;
/// Largest plausible rate of a spacecraft, rad/s.
pub const FASTEST_RAD_S: f32 = 0.35;
/// Least number of matched stars for a rate. Two fix it; that others agree by chance is rare, but of four
/// spots in the Sun's glare, whose structure hardly moves, some did.
const FEWEST_MATCHES: u32 = 6;
/// Largest search radius about a predicted position, px.
const FARTHEST_PX: f32 = 60.0;

/// Scale of the camera: angle of a pixel at the optical centre, and detector area.
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
    /// Time after that of the middle row, s.
    pub late_s: f32,
}

/// Direction of a mark after `elapsed_s` at a constant rate.
#[inline(never)]
pub fn rotated(mark: &Mark, rate: &Vector3<f32>, elapsed_s: f32) -> Vector3<f32> {
    // b' = -ω × b, by the exact rotation about a fixed axis.
    let angle = libm::sqrtf(rate.dot(rate)) * elapsed_s;
    let Some(axis) = rate.try_normalize(1e-9) else { return mark.direction };
    let (sine, cosine) = sine_cosine(angle);
    let b = mark.direction;
    b * cosine - axis.cross(&b) * sine + axis * (axis.dot(&b) * (1.0 - cosine))
}

/// Search radius about a predicted mark, three sigma, rad: the rate's error across its direction, an
/// additional error of the rate (`off`, one sigma, rad/s), and the errors of two marks.
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

/// The arc from a mark of one image to that of the next.
#[inline(never)]
fn arc_between(from: &Mark, to: &Mark, elapsed_s: f32) -> Arc {
    let ([a, b], [c, d]) = (from.sigma_rad, to.sigma_rad);
    Arc {
        ends: [from.direction, to.direction],
        sigma_rad: [hypotenuse(a, c), hypotenuse(b, d)],
        duration_s: [elapsed_s + to.late_s - from.late_s; 2],
        directed: true,
        whole: true,
    }
}

/// Area of the field over which marks lie, rad²: the rectangle about them, made larger by as much as that of
/// so many random points falls short of their region.
#[inline(never)]
fn area_of(marks: &[Mark]) -> f32 {
    let count = marks.len() as f32;
    let side = |axis: fn(&Vector3<f32>) -> f32| {
        let places = marks.iter().map(|mark| axis(&mark.direction) / mark.direction.z);
        let (least, most) =
            places.fold((f32::MAX, f32::MIN), |(least, most), place| (least.min(place), most.max(place)));
        (most - least).max(0.0) * (count + 1.0) / (count - 1.0).max(1.0)
    };
    side(|direction| direction.x) * side(|direction| direction.y)
}

/// Finds the arcs of the marks that are matched in the next image at a rate; returns the expected number of
/// chance matches: marks that lie together, as in the Sun's glare, are matched by chance more often.
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
    let area_px = (area_of(now) / (field.rad_per_px * field.rad_per_px)).max(1.0).min(field.area_px);
    // The possible change of the rate.
    let change = 0.5 * free_body_change(rate) * elapsed_s;
    for mark in before {
        let there = rotated(mark, rate, elapsed_s);
        let reach = search_radius(mark, &there, covariance, change, elapsed_s);
        if reach.is_nan() || reach > farthest {
            continue;
        }
        let per_px = reach / field.rad_per_px;
        chance += now.len() as f32 * core::f32::consts::PI * per_px * per_px / area_px;
        let distance = |mark: &&Mark| (mark.direction - there).norm_squared();
        let nearest = now.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(found) = nearest.filter(|found| distance(found) < reach * reach) {
            let _ = arcs.push(arc_between(mark, found, elapsed_s));
        }
    }
    chance
}

/// The rate between two images from the marks of both, matched by their separations. Two thirds of the marks
/// of the image that has fewer must agree: structure of the Earth moves otherwise than the stars, hits move
/// alike by chance, and so do spots in the Sun's glare, which lie close together (7 of 12).
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
    best.filter(|rate| 3 * rate.count() as usize >= 2 * before.len().min(now.len()))
}

/// The rate from all marks matched at a proposed rate.
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
