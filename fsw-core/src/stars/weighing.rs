//! Attitude of matched stars, each weighed by what its residual says of it.
//!
//! In: matches, the measured stars, the catalogue. Out: the attitude by least squares with Huber's weights,
//! and by how much the residuals of the image scale its sigmas.

use super::predict::MAX_FIELD_STARS;
use super::{Match, MeasuredStar, StarField};
use crate::attitude::covariance::{Information, sigmas_rad};
use crate::attitude::{VectorPair, wahba};
use crate::catalog::Star;
use crate::frames::{Icrs, Rotation, StarPath};
use heapless::Vec;
use nalgebra::Matrix3;

/// Huber threshold of the solution, sigmas of the residual: larger ones come from a proton, a hot pixel or a
/// neighbour in the star's image. A residual's sigma is that of the centroid times `sqrt(1 - h)` (Schweppe's
/// form; Huber 1981, ch. 7): a bright star at the border draws the roll along, so that its own residual hides
/// the share `h` of its error.
const HUBER_SIGMAS: f32 = 2.0;
/// Least of what a star leaves of its residual, `1 - h`: less is rounding and noise.
const LEAST_LEFT: f32 = 0.1;
/// Huber threshold of the sigma scale, sigmas: 1 in 3,000 good residuals is larger.
const OUTLIER_SIGMAS: f32 = 4.0;

/// Huber's sigma: that of the centroid, or its residual over `sigmas` where that is larger, which bounds
/// the weight of an outlier.
fn robust_sigma_px(found: &Match, seen: &MeasuredStar, sigmas: f32) -> f32 {
    let [dx, dy] = found.residual_px;
    seen.sigma_px.max(libm::sqrtf(dx * dx + dy * dy) / sigmas)
}

/// The share of its error by which a star that is `paired` draws an attitude of this covariance along, both
/// axes together.
fn leverage(paired: &VectorPair, covariance_rad2: &Matrix3<f32>) -> f32 {
    let v = paired.measured.vector();
    let moved_rad2 = covariance_rad2.trace() - v.dot(&(covariance_rad2 * v));
    moved_rad2 / (paired.sigma_rad * paired.sigma_rad)
}

/// The catalogue star of a match that takes part in a solution: none that is proximity-flagged unless `all`
/// is set.
fn used(found: &Match, field: &StarField, all: bool) -> Option<Star> {
    field.catalogue.star(found.star).filter(|star| all || !star.proximity)
}

/// Vector pairs of the matches that take part.
fn vector_pairs(matches: &[Match], field: &StarField, all: bool) -> Vec<VectorPair, MAX_FIELD_STARS> {
    let mut pairs = Vec::new();
    for found in matches {
        let seen = field.measured().get(usize::from(found.measured));
        if let Some((seen, star)) = seen.zip(used(found, field, all)) {
            let doubted = MeasuredStar { sigma_px: robust_sigma_px(found, seen, HUBER_SIGMAS), ..*seen };
            let seen = field.colour_corrected(&doubted, &star);
            // There are no more matches than the list holds.
            let _ = pairs.push(seen.paired_with(field.catalogue.apparent_direction(&star), field.camera));
        }
    }
    pairs
}

/// Weighs the residual of each of these pairs, of the matches that take part, against what its star leaves of
/// it. Where the image's residuals are larger than their sigmas all alike, none is doubted for that.
fn doubt_drawn(pairs: &mut [VectorPair], matches: &[Match], field: &StarField, all: bool) -> Option<()> {
    let covariance_rad2 = Information::of(pairs).covariance_rad2()?;
    let taken = || matches.iter().filter(|found| used(found, field, all).is_some());
    let (chi_square, freedom) = chi_square(taken(), field);
    let scale = (chi_square / freedom).max(1.0);
    for (pair, Match { residual_px: [dx, dy], .. }) in pairs.iter_mut().zip(taken()) {
        let left = (1.0 - leverage(pair, &covariance_rad2)).max(LEAST_LEFT);
        let sigmas = HUBER_SIGMAS * libm::sqrtf((scale * left).min(1.0));
        let doubted_px = libm::sqrtf(dx * dx + dy * dy) / sigmas;
        pair.sigma_rad = pair.sigma_rad.max(doubted_px * field.camera.rad_per_px());
    }
    Some(())
}

/// Attitude and covariance sigmas of a set of matches: without the proximity-flagged stars where the others
/// suffice. Not inlined: keeps its list off the stack of the matching.
#[inline(never)]
pub(super) fn solve(matches: &[Match], field: &StarField) -> Option<(Rotation<Icrs, StarPath>, [f32; 3])> {
    [false, true].into_iter().find_map(|all| {
        let mut pairs = vector_pairs(matches, field, all);
        if pairs.len() < 3 && !all {
            return None;
        }
        doubt_drawn(&mut pairs, matches, field, all)?;
        let attitude = wahba::svd::solve(&pairs).ok()?;
        Some((attitude, sigmas_rad(&Information::of(&pairs).covariance_rad2()?)))
    })
}

/// Weight of the centroids' own sigmas against the residuals of the image, as a number of residuals.
const PRIOR_RESIDUALS: f32 = 10.0;

/// Chi-square of the residuals of matches and its degrees of freedom: two residuals a star, less the three
/// angles that were fitted.
fn chi_square<'a>(matches: impl Iterator<Item = &'a Match>, field: &StarField) -> (f32, f32) {
    let (sum, count) = matches.fold((0.0, 0), |(sum, count), found| {
        let seen = field.measured().get(usize::from(found.measured));
        let sigma = seen.map_or(1.0, |seen| robust_sigma_px(found, seen, OUTLIER_SIGMAS));
        let [dx, dy] = found.residual_px;
        (sum + (dx * dx + dy * dy) / (sigma * sigma), count + 1)
    });
    (sum, 2.0 * count as f32 - 3.0)
}

/// Scale of the centroids' sigmas by the residuals: `sqrt(chi² / freedom)` where that exceeds 1. Below 1 a
/// prior of weight [`PRIOR_RESIDUALS`] limits it, because few residuals may be small by chance; with a
/// calibrated lens, whose sigmas are known, it is 1.
pub(super) fn sigma_scale(matches: &[Match], field: &StarField) -> f32 {
    let (chi_square, freedom) = chi_square(matches.iter(), field);
    let ratio = chi_square / freedom;
    if ratio > 1.0 {
        return libm::sqrtf(ratio);
    }
    let weighted = (chi_square + PRIOR_RESIDUALS) / (freedom + PRIOR_RESIDUALS);
    if field.is_calibrated() { 1.0 } else { libm::sqrtf(weighted) }
}
