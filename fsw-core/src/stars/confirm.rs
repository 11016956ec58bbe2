//! Accepts or refuses an attitude hypothesis by re-projection.
//!
//! In: an attitude that a few stars suggested, the measured stars, the catalogue. The brightest catalogue
//! stars of the field are projected onto the detector and matched, brightest first, with the one measured
//! star inside a radius that shrinks over [`ROUNDS`]; after each round the attitude is solved anew from all
//! matches. Out: matches, attitude, and the odds that as many agree by chance.
//!
//! False-identification probability: were the hypothesis wrong, a star of the shorter list (of L stars,
//! measured or projected) would find one of the longer (of M) inside the capture radius `ρ` with probability
//! `p = M π ρ² / A` on a detector of area A. Of them n matched; the two that fixed the hypothesis are no
//! evidence for it, so the chance of this hypothesis is the binomial tail `P(X >= n - 2 | L - 2, (M - 2) π ρ²
//! / A)`, times the number of hypotheses that were tried and of the tests made (see [`BRIGHTEST`] and
//! [`RADII`]). `ρ` is twice the radius inside which matches are counted, so that its area covers the whole
//! region in which polygon and matching would have accepted a star.

use super::predict::{MAX_FIELD_STARS, Predicted, field_stars};
use super::{MAX_MEASURED, MeasuredStar, StarField};
use crate::attitude::covariance::{Information, sigmas_rad};
use crate::attitude::{VectorPair, wahba};
use crate::frames::{Icrs, Rotation, StarPath};
use heapless::Vec;

/// Matching and solving are repeated this often, the radius shrinking from 2 to 1 tolerances.
pub const ROUNDS: usize = 3;

/// The test for chance is made with so many of the brightest on either side, and the best is taken: where
/// brightness is known, faint noise does not drown the few stars there are.
pub const BRIGHTEST: [usize; 4] = [8, 16, 32, 64];
/// ... and with the matches inside these shares of the tolerance: where centroids are better than the
/// tolerance allows, that is evidence too. The last is for calibrated lenses: each test that cannot help
/// costs the others.
pub const RADII: [f32; 4] = [1.0, 0.5, 0.25, 0.125];

/// Most stars of [`match_predicted_stars`].
pub const MAX_FEW_STARS: usize = 8;

/// A measured star with its name.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// Index of the measured star.
    pub measured: u8,
    /// Index of the catalogue star.
    pub star: u16,
    /// Place of the catalogue star among those expected, by brightness.
    pub rank: u8,
    /// Measured less projected position, px.
    pub residual_px: [f32; 2],
}

/// An attitude hypothesis that was checked against the whole field.
#[derive(Clone, Debug)]
pub struct Confirmed {
    /// Attitude from all matches but the proximity-flagged.
    pub attitude: Rotation<Icrs, StarPath>,
    /// Standard deviations of the attitude about x, y, z of the star path, rad: those that the centroids' own
    /// sigmas give (eq. 3.27), scaled by what the residuals say of these sigmas.
    pub sigma_rad: [f32; 3],
    /// Measured stars with their names, brightest catalogue star first.
    pub matches: Vec<Match, MAX_FIELD_STARS>,
    /// Catalogue stars that should be seen on the detector.
    pub expected: u16,
    /// Root mean square residual per axis, px.
    pub rms_px: f32,
    /// Best focal length over the camera's, from the matched stars.
    pub focal_ratio: f32,
    /// Common logarithm of the probability that so many stars match by chance, one hypothesis.
    pub log10_chance: f32,
}

/// Common logarithm of the binomial tail `P(X >= hits | trials, p)`; 0 (certainty) when p is no probability.
///
/// Error below 1.5e-4 (9e-6 of the logarithm) for every number of trials up to [`MAX_FIELD_STARS`]` - 2`, p
/// from 1e-9 to 0.999 (test `the_chance_of_a_match_is_the_exact_binomial_tail`); of more trials not all terms
/// are summed.
pub fn log10_binomial_tail(hits: u32, trials: u32, p: f32) -> f32 {
    if hits == 0 || !(p > 0.0 && p < 1.0) {
        return 0.0;
    }
    if hits > trials {
        return f32::NEG_INFINITY;
    }
    let (log_p, log_q) = (libm::log10f(p), libm::log10f(1.0 - p));
    // First term C(n, k) p^k q^(n - k) in logarithms, the rest as a series of ratios.
    let first = (0..hits).fold((trials - hits) as f32 * log_q, |sum, i| {
        sum + log_p + libm::log10f((trials - i) as f32) - libm::log10f((i + 1) as f32)
    });
    let (mut series, mut term) = (1.0f32, 1.0f32);
    for k in hits..trials.min(hits + MAX_FIELD_STARS as u32) {
        term *= (trials - k) as f32 / (k + 1) as f32 * (p / (1.0 - p));
        series += term;
    }
    (first + libm::log10f(series)).min(0.0)
}

/// Columns in which measured stars are looked up.
const COLUMNS: usize = 32;
/// By so much a star's columns reach beyond its radius, px: more than positions round.
const COLUMN_MARGIN_PX: f32 = 0.01;

/// Which measured stars may be near a position: a bit each, by columns of the detector.
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

    /// The column of a position; what is beside the detector counts to its edge.
    fn column(&self, x: f32) -> usize {
        ((x * self.per_px) as usize).min(COLUMNS - 1)
    }

    /// The one measured star within `radius_px` of a position, no more than that of [`Columns::new`], with
    /// its offset; `None` when there is none, or more than one: which of two close stars carries the name
    /// would be a guess.
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

/// Matches projected stars with measured ones within `radius_px`, each measured star with the brightest that
/// claims it.
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

/// Residuals beyond so many sigmas are taken for what they are: a proton, a hot pixel or a neighbour in the
/// star's image.
const HUBER_SIGMAS: f32 = 2.0;
/// ... and those beyond so many say nothing of the others' sigmas; of good ones chance brings 1 in 3,000
/// there.
const OUTLIER_SIGMAS: f32 = 4.0;

/// Sigma of a centroid, or what its residual says of it where that is beyond `sigmas` of it: the weight of an
/// outlier is bounded.
fn robust_sigma_px(found: &Match, seen: &MeasuredStar, sigmas: f32) -> f32 {
    let [dx, dy] = found.residual_px;
    seen.sigma_px.max(libm::sqrtf(dx * dx + dy * dy) / sigmas)
}

/// Vector pairs of the matches; proximity-flagged stars take no part unless `all` is set.
fn vector_pairs(matches: &[Match], field: &StarField, all: bool) -> Vec<VectorPair, MAX_FIELD_STARS> {
    let mut pairs = Vec::new();
    for found in matches {
        let star = field.catalogue.star(found.star).filter(|star| all || !star.proximity);
        if let (Some(seen), Some(star)) = (field.measured().get(usize::from(found.measured)), star) {
            // There are no more matches than the list holds.
            let doubted = MeasuredStar { sigma_px: robust_sigma_px(found, seen, HUBER_SIGMAS), ..*seen };
            let seen = field.colour_corrected(&doubted, &star);
            let _ = pairs.push(seen.paired_with(field.catalogue.apparent_direction(&star), field.camera));
        }
    }
    pairs
}

/// The brightest stars, at most [`MAX_FEW`], that are measured where an attitude expects them, within
/// `radius_px`, and what each says: where too few are seen for an attitude of their own.
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
/// suffice. Not inlined: its list is not to lie on the stack under the matching.
#[inline(never)]
fn solve(matches: &[Match], field: &StarField) -> Option<(Rotation<Icrs, StarPath>, [f32; 3])> {
    [false, true].into_iter().find_map(|all| {
        let pairs = vector_pairs(matches, field, all);
        if pairs.len() < 3 && !all {
            return None;
        }
        let attitude = wahba::svd::solve(&pairs).ok()?;
        Some((attitude, sigmas_rad(&Information::of(&pairs).covariance_rad2()?)))
    })
}

/// Ratio of the measured to the projected distances from their means: the focal length the field asks for.
fn focal_ratio(matches: &[Match], measured: &[MeasuredStar]) -> f32 {
    let count = (matches.len() as f32).max(1.0);
    let positions = || {
        matches.iter().filter_map(|found| {
            let [x, y] = measured.get(usize::from(found.measured))?.centre_px;
            let [dx, dy] = found.residual_px;
            Some(([x, y], [x - dx, y - dy]))
        })
    };
    let ([sx, sy], [px, py]) =
        positions().fold(([0.0f32; 2], [0.0f32; 2]), |([sx, sy], [px, py]), (seen, projected)| {
            ([sx + seen[0], sy + seen[1]], [px + projected[0], py + projected[1]])
        });
    let (product, square) = positions().fold((0.0f32, 0.0f32), |(product, square), (seen, projected)| {
        let (ux, uy) = (seen[0] - sx / count, seen[1] - sy / count);
        let (vx, vy) = (projected[0] - px / count, projected[1] - py / count);
        (product + ux * vx + uy * vy, square + vx * vx + vy * vy)
    });
    if square > 1.0 { product / square } else { 1.0 }
}

/// Weight of the centroids' own sigmas against the residuals of the image, as a number of residuals.
const PRIOR_RESIDUALS: f32 = 10.0;

/// Scale that the residuals ask of the centroids' sigmas. Residuals larger than the sigmas are believed at
/// once; smaller ones only as far as there are many, because few are small by luck, and not of a calibrated
/// lens, whose sigmas are known.
fn sigma_scale(matches: &[Match], field: &StarField) -> f32 {
    let chi_square = matches.iter().fold(0.0, |sum, found| {
        let seen = field.measured().get(usize::from(found.measured));
        let sigma = seen.map_or(1.0, |seen| robust_sigma_px(found, seen, OUTLIER_SIGMAS));
        let [dx, dy] = found.residual_px;
        sum + (dx * dx + dy * dy) / (sigma * sigma)
    });
    // Two residuals a star, less the three angles that were fitted.
    let freedom = 2.0 * matches.len() as f32 - 3.0;
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
    let mut best = 0.0f32;
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
            best = best.min(log10_binomial_tail(hits, ours.min(theirs) as u32, chance));
        }
    }
    // With more of the brightest than there are the test is the same again.
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
    // Not moved out of its option: a copy would lie on the stack under all that follows.
    let expected = field_stars(field.catalogue, field.camera, hypothesis);
    confirm_among(expected.as_ref()?, hypothesis, field, tolerance_px)
}

/// The same where the catalogue stars that are to be expected are known already, brightest first; only their
/// names count.
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
    let scale = sigma_scale(&matches, field);
    Some(Confirmed {
        attitude,
        sigma_rad: sigma_rad.map(|sigma| sigma * scale),
        expected: expected.len() as u16,
        rms_px: libm::sqrtf(square / (2.0 * matches.len() as f32)),
        focal_ratio: focal_ratio(&matches, measured),
        log10_chance: log10_chance(&matches, expected.len(), tolerance_px, field),
        matches,
    })
}

/// Times that [`widen`] doubles the radius.
pub const WIDENINGS: usize = 3;
/// Stars that a wider radius must bring beyond what chance does.
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

/// Matches again with twice, four and eight times the tolerance, and keeps what brings clearly more stars
/// than chance does.
///
/// Centroids worse than the tolerance assumed would otherwise leave only the stars whose errors happen to be
/// small, with a biased attitude and sigmas that believe it.
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
            // The evidence stays that of the narrow match: it is what was tested.
            *best = Confirmed { log10_chance: best.log10_chance, ..wider };
        }
    }
}

#[cfg(test)]
mod tests;
