//! Verification of an attitude hypothesis by re-projection.
//!
//! In: the attitude of a polygon, the measured stars, the catalogue. The brightest catalogue stars of the
//! field are projected onto the detector and matched, brightest first, with the one measured star inside a
//! radius that shrinks over [`ROUNDS`]; after each round the attitude is solved anew from all matches. Out:
//! matches, attitude, and the probability of as many matches by chance.
//!
//! False-identification probability: were the hypothesis wrong, a star of the shorter list (of L stars,
//! measured or projected) would find one of the longer (of M) inside the capture radius `ρ` with
//! probability `p = M π ρ² / A` on a detector of area A. Of them n matched; the two that defined the
//! hypothesis are excluded, so the probability of a chance match is the binomial tail `P(X >= n - 2 | L -
//! 2, (M - 2) π ρ² / A)`, times the number of hypotheses that were tried and of the tests made (see
//! [`BRIGHTEST`] and [`RADII`]). `ρ` is twice the radius inside which matches are counted, so that its area
//! covers the whole region in which polygon and matching would have accepted a star.

use super::focal_ratio::{FocalRatio, focal_ratio};
use super::predict::{MAX_FIELD_STARS, Predicted, field_stars};
use super::{MAX_MEASURED, MeasuredStar, StarField};
use crate::attitude::covariance::{Information, sigmas_rad};
use crate::attitude::{VectorPair, wahba};
use crate::catalog::Star;
use crate::frames::{Icrs, Rotation, StarPath};
use heapless::Vec;
use nalgebra::Matrix3;

/// Rounds of matching and solving; the radius shrinks from 2 tolerances to 1.
pub const ROUNDS: usize = 3;

/// The chance test uses this many of the brightest stars of either list; the best result counts, so that
/// many faint false stars do not hide a few true ones.
pub const BRIGHTEST: [usize; 4] = [8, 16, 32, 64];
/// Radii of the chance test, shares of the tolerance: centroids better than the tolerance add evidence. The
/// last is for calibrated lenses only, because every further test weakens the others.
pub const RADII: [f32; 4] = [1.0, 0.5, 0.25, 0.125];

/// Most stars of [`match_predicted_stars`].
pub const MAX_FEW_STARS: usize = 8;

/// A measured star matched with a catalogue star.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// Index of the measured star.
    pub measured: u8,
    /// Index of the catalogue star.
    pub star: u16,
    /// Rank of the catalogue star among those predicted, by brightness.
    pub rank: u8,
    /// Measured less projected position, px.
    pub residual_px: [f32; 2],
}

/// An attitude hypothesis verified with the whole field.
#[derive(Clone, Debug)]
pub struct Confirmed {
    /// Attitude from all matches but the proximity-flagged.
    pub attitude: Rotation<Icrs, StarPath>,
    /// Standard deviations of the attitude about x, y, z of the star path, rad: by the centroids' sigmas
    /// (eq. 3.27), times the scale of the residuals.
    pub sigma_rad: [f32; 3],
    /// Matched stars, brightest catalogue star first.
    pub matches: Vec<Match, MAX_FIELD_STARS>,
    /// Number of catalogue stars predicted on the detector.
    pub expected: u16,
    /// Root mean square residual per axis, px.
    pub rms_px: f32,
    /// Best focal length over the camera's, from the matched stars.
    pub focal_ratio: FocalRatio,
    /// Common logarithm of the probability that so many stars match by chance, one hypothesis.
    pub log10_chance: f32,
}

/// Common logarithms of the whole numbers up to [`MAX_FIELD_STARS`]: the tests of one field ask for them
/// hundreds of times.
#[derive(Debug)]
pub struct WholeLogs([f32; MAX_FIELD_STARS + 1]);

impl Default for WholeLogs {
    fn default() -> Self {
        Self(core::array::from_fn(|number| libm::log10f(number as f32)))
    }
}

impl WholeLogs {
    fn of(&self, number: u32) -> f32 {
        self.0.get(number as usize).copied().unwrap_or_else(|| libm::log10f(number as f32))
    }
}

/// Common logarithm of the binomial tail `P(X >= hits | trials, p)`; 0 (certainty) when p is no probability.
///
/// Error below 1.5e-4 (9e-6 of the logarithm) for every number of trials up to [`MAX_FIELD_STARS`]` - 2`, p
/// from 1e-9 to 0.999 (test `the_chance_of_a_match_is_the_exact_binomial_tail`); of more trials not all terms
/// are summed.
pub fn log10_binomial_tail(hits: u32, trials: u32, p: f32, logs: &WholeLogs) -> f32 {
    if hits == 0 || !(p > 0.0 && p < 1.0) {
        return 0.0;
    }
    if hits > trials {
        return f32::NEG_INFINITY;
    }
    let (log_p, log_q) = (libm::log10f(p), libm::log10f(1.0 - p));
    // First term C(n, k) p^k q^(n - k) in logarithms, the rest as a series of ratios.
    let first = (0..hits)
        .fold((trials - hits) as f32 * log_q, |sum, i| sum + log_p + logs.of(trials - i) - logs.of(i + 1));
    let (mut series, mut term) = (1.0f32, 1.0f32);
    for k in hits..trials.min(hits + MAX_FIELD_STARS as u32) {
        term *= (trials - k) as f32 / (k + 1) as f32 * (p / (1.0 - p));
        series += term;
    }
    (first + libm::log10f(series)).min(0.0)
}

/// Number of detector columns of the index.
const COLUMNS: usize = 32;
/// Margin of a star's columns beyond its radius, px: more than the rounding of positions.
const COLUMN_MARGIN_PX: f32 = 0.01;

/// Index of the measured stars by detector column: a bit for each star within the radius of the column.
struct ColumnIndex<'a> {
    measured: &'a [MeasuredStar],
    stars: [u64; COLUMNS],
    per_px: f32,
}

impl<'a> ColumnIndex<'a> {
    fn new(field: &StarField<'a>, radius_px: f32) -> Self {
        let width_px = f32::from(field.camera.parameters().width_px);
        let measured = field.measured();
        let mut columns = Self { measured, stars: [0; COLUMNS], per_px: COLUMNS as f32 / width_px };
        let reach_px = radius_px + COLUMN_MARGIN_PX;
        for (index, seen) in measured.iter().enumerate() {
            let x = seen.centre_px[0];
            let (first, last) = (columns.column(x - reach_px), columns.column(x + reach_px));
            for stars in columns.stars.get_mut(first..=last).unwrap_or(&mut []) {
                *stars |= 1u64.wrapping_shl(index as u32);
            }
        }
        columns
    }

    /// The column of a position; positions outside the detector belong to the edge columns.
    fn column(&self, x: f32) -> usize {
        ((x * self.per_px) as usize).min(COLUMNS - 1)
    }

    /// The one measured star within `radius_px` of a position, no more than that of [`Columns::new`], with
    /// its offset; `None` when there is none, or more than one (ambiguous).
    fn only_star_near(&self, [x, y]: [f32; 2], radius_px: f32) -> Option<(u8, [f32; 2])> {
        let mut stars = self.stars.get(self.column(x)).copied().unwrap_or(0);
        let mut only = None;
        for _ in 0..MAX_MEASURED {
            let index = stars.trailing_zeros();
            let Some(seen) = self.measured.get(index as usize) else { break };
            stars &= stars.wrapping_sub(1);
            let [dx, dy] = [seen.centre_px[0] - x, seen.centre_px[1] - y];
            if dx * dx + dy * dy < radius_px * radius_px && only.replace((index as u8, [dx, dy])).is_some() {
                return None;
            }
        }
        only
    }
}

const _: () = assert!(MAX_MEASURED <= u64::BITS as usize);

/// Matches projected stars with measured ones within `radius_px`; a measured star goes to the brightest
/// projected star near it.
fn match_stars(
    expected: &[Predicted],
    field: &StarField,
    attitude: &Rotation<Icrs, StarPath>,
    radius_px: f32,
) -> Vec<Match, MAX_FIELD_STARS> {
    let columns = ColumnIndex::new(field, radius_px);
    let mut taken = [false; MAX_MEASURED];
    let mut matches = Vec::new();
    for (rank, star) in (0u8..).zip(expected) {
        let named = field.catalogue.star(star.star);
        let near = named
            .and_then(|named| {
                let [x, y] =
                    field.camera.project(&attitude.apply(&field.catalogue.apparent_direction(&named)))?;
                let [dx, dy] = field.colour_shift_px([x, y], &named);
                Some([x + dx, y + dy])
            })
            .and_then(|at| columns.only_star_near(at, radius_px));
        let Some((index, residual_px)) = near else { continue };
        if let Some(taken @ false) = taken.get_mut(usize::from(index)) {
            *taken = true;
            // The field holds no more stars than the list does.
            let _ = matches.push(Match { measured: index, star: star.star, rank, residual_px });
        }
    }
    matches
}

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

/// The brightest stars, at most [`MAX_FEW_STARS`], that are measured within `radius_px` of their position
/// predicted by an attitude, with their vector pairs; for updates by single stars, when there are too few
/// for an attitude.
pub fn match_predicted_stars(
    attitude: &Rotation<Icrs, StarPath>,
    field: &StarField,
    radius_px: f32,
) -> Vec<(Match, VectorPair), MAX_FEW_STARS> {
    let Some(expected) = field_stars(field.catalogue, field.camera, attitude) else { return Vec::new() };
    let matches = match_stars(&expected, field, attitude, radius_px);
    matches
        .iter()
        .filter_map(|found| {
            let star = field.catalogue.star(found.star)?;
            let seen = field.colour_corrected(field.measured().get(usize::from(found.measured))?, &star);
            Some((*found, seen.paired_with(field.catalogue.apparent_direction(&star), field.camera)))
        })
        .take(MAX_FEW_STARS)
        .collect()
}

/// Attitude and covariance sigmas of a set of matches: without the proximity-flagged stars where the others
/// suffice. Not inlined: keeps its list off the stack of the matching.
#[inline(never)]
fn solve(matches: &[Match], field: &StarField) -> Option<(Rotation<Icrs, StarPath>, [f32; 3])> {
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
fn sigma_scale(matches: &[Match], field: &StarField) -> f32 {
    let (chi_square, freedom) = chi_square(matches.iter(), field);
    let ratio = chi_square / freedom;
    if ratio > 1.0 {
        return libm::sqrtf(ratio);
    }
    let weighted = (chi_square + PRIOR_RESIDUALS) / (freedom + PRIOR_RESIDUALS);
    if field.is_calibrated() { 1.0 } else { libm::sqrtf(weighted) }
}

/// Common logarithm of the probability that so many stars match so well by chance: the best of the tests with
/// the [`BRIGHTEST`] and [`RADII`], times the number of different ones.
fn log10_chance(matches: &[Match], expected: usize, tolerance_px: f32, field: &StarField) -> f32 {
    let radii = RADII.get(..RADII.len() - usize::from(!field.is_calibrated())).unwrap_or(&RADII);
    let measured = field.measured().len();
    let beyond_two = |count: usize| count.saturating_sub(2);
    let (logs, mut best) = (WholeLogs::default(), 0.0f32);
    for radius in radii {
        let within_px = tolerance_px * radius;
        let capture_share = core::f32::consts::PI * (2.0 * within_px) * (2.0 * within_px) / field.searched_px;
        for brightest in BRIGHTEST {
            let hits = matches.iter().filter(|found| {
                let [dx, dy] = found.residual_px;
                usize::from(found.rank) < brightest
                    && usize::from(found.measured) < brightest
                    && dx * dx + dy * dy < within_px * within_px
            });
            let hits = beyond_two(hits.count()) as u32;
            // Each star of the shorter list may meet any of the longer: the exact tail either way, less loose
            // this way.
            let (ours, theirs) = (beyond_two(expected.min(brightest)), beyond_two(measured.min(brightest)));
            let chance = capture_share * ours.max(theirs) as f32;
            best = best.min(log10_binomial_tail(hits, ours.min(theirs) as u32, chance, &logs));
        }
    }
    // Tests with more of the brightest than there are stars are identical.
    let distinct = BRIGHTEST.iter().filter(|brightest| **brightest < measured.max(expected)).count() + 1;
    (best + libm::log10f((radii.len() * distinct.min(BRIGHTEST.len())) as f32)).min(0.0)
}

/// Checks a hypothesis against the whole field; `tolerance_px` is that of the separations. `None` when fewer
/// than three stars match or the matches fix no attitude.
pub fn confirm(
    hypothesis: &Rotation<Icrs, StarPath>,
    field: &StarField,
    tolerance_px: f32,
) -> Option<Confirmed> {
    // Not moved out of its option: avoids a copy on the stack.
    let expected = field_stars(field.catalogue, field.camera, hypothesis);
    confirm_among(expected.as_ref()?, hypothesis, field, tolerance_px)
}

/// The same with the predicted catalogue stars given, brightest first; their positions are not used.
pub fn confirm_among(
    expected: &[Predicted],
    hypothesis: &Rotation<Icrs, StarPath>,
    field: &StarField,
    tolerance_px: f32,
) -> Option<Confirmed> {
    let measured = field.measured();
    let (mut attitude, mut sigma_rad) = (*hypothesis, [0.0; 3]);
    for round in 0..ROUNDS {
        let radius = tolerance_px * (2.0 - round as f32 / (ROUNDS as f32 - 1.0));
        let matches = match_stars(expected, field, &attitude, radius);
        if matches.len() < 3 {
            return None;
        }
        (attitude, sigma_rad) = solve(&matches, field)?;
    }
    let matches = match_stars(expected, field, &attitude, tolerance_px);
    if matches.len() < 3 {
        return None;
    }
    let square = matches.iter().fold(0.0, |sum, found| {
        let [dx, dy] = found.residual_px;
        sum + dx * dx + dy * dy
    });
    let positions = || {
        matches.iter().filter_map(|found| {
            let [x, y] = measured.get(usize::from(found.measured))?.centre_px;
            let [dx, dy] = found.residual_px;
            Some(([x, y], [x - dx, y - dy]))
        })
    };
    let scale = sigma_scale(&matches, field);
    Some(Confirmed {
        attitude,
        sigma_rad: sigma_rad.map(|sigma| sigma * scale),
        expected: expected.len() as u16,
        rms_px: libm::sqrtf(square / (2.0 * matches.len() as f32)),
        focal_ratio: focal_ratio(matches.len(), positions),
        log10_chance: log10_chance(&matches, expected.len(), tolerance_px, field),
        matches,
    })
}

/// Doublings of the radius in [`widen`].
pub const WIDENINGS: usize = 3;
/// Least gain of matches by a wider radius, above those expected by chance.
const FEWEST_GAINED: usize = 2;

/// Number of expected stars that have a measured one within `radius_px`.
fn stars_near(expected: &[Predicted], measured: &[MeasuredStar], radius_px: f32) -> usize {
    let near = |[x, y]: [f32; 2]| {
        measured.iter().any(|seen| {
            let [dx, dy] = [seen.centre_px[0] - x, seen.centre_px[1] - y];
            dx * dx + dy * dy < radius_px * radius_px
        })
    };
    expected.iter().filter(|star| near(star.centre_px)).count()
}

/// Matches again with 2, 4 and 8 times the tolerance; a wider result is kept if it gains at least 2 stars
/// plus three times the number expected by chance.
///
/// Where centroids are worse than the tolerance assumes, the narrow match selects the stars with small
/// errors: the attitude is biased and its sigmas are too small.
#[inline(never)]
pub fn widen(best: &mut Confirmed, field: &StarField, tolerance_px: f32) {
    let expected = field_stars(field.catalogue, field.camera, &best.attitude);
    let Some(expected) = &expected else { return };
    let widest_px = tolerance_px * (1 << WIDENINGS) as f32;
    if stars_near(expected, field.measured(), widest_px) < best.matches.len() + FEWEST_GAINED {
        return;
    }
    let mut radius_px = tolerance_px;
    for _ in 0..WIDENINGS {
        radius_px *= 2.0;
        let missing = usize::from(best.expected).saturating_sub(best.matches.len());
        if missing < FEWEST_GAINED {
            break;
        }
        let Some(wider) = confirm_among(expected, &best.attitude, field, radius_px) else { break };
        let area = core::f32::consts::PI * radius_px * radius_px / field.searched_px;
        let by_chance = missing as f32 * field.measured().len() as f32 * area;
        let gained = wider.matches.len() as f32 - best.matches.len() as f32;
        if gained >= FEWEST_GAINED as f32 + 3.0 * by_chance {
            // The chance probability remains that of the narrow match, which was tested.
            *best = Confirmed { log10_chance: best.log10_chance, ..wider };
        }
    }
}

#[cfg(test)]
mod tests;
