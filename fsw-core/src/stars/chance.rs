//! False-identification probability of an attitude hypothesis.
//!
//! In: matches, stars measured and expected. Out: the probability of as many and as good matches by chance.
//!
//! Were the hypothesis wrong, a star of the shorter list (of L stars, measured or projected) would find one
//! of the longer (of M) inside the capture radius `ρ` with probability `p = M π ρ² / A` on a detector of area
//! A. Of them n matched; the two that defined the hypothesis are excluded, so the probability of a chance
//! match is the binomial tail `P(X >= n - 2 | L - 2, (M - 2) π ρ² / A)`, times the number of hypotheses that
//! were tried and of the tests made (see [`BRIGHTEST`] and [`RADII`]). `ρ` is twice the radius inside which
//! matches are counted, so that its area covers the whole region in which polygon and matching would have
//! accepted a star.

use super::predict::MAX_FIELD_STARS;
use super::{Match, StarField};

/// The chance test uses this many of the brightest stars of either list; the best result counts, so that
/// many faint false stars do not hide a few true ones.
pub const BRIGHTEST: [usize; 4] = [8, 16, 32, 64];
/// Radii of the chance test, shares of the tolerance: centroids better than the tolerance add evidence. The
/// last is for calibrated lenses only, because every further test weakens the others.
pub const RADII: [f32; 4] = [1.0, 0.5, 0.25, 0.125];

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

/// Common logarithm of the probability that so many stars match so well by chance: the best of the tests with
/// the [`BRIGHTEST`] and [`RADII`], times the number of different ones.
pub(super) fn log10_chance(matches: &[Match], expected: usize, tolerance_px: f32, field: &StarField) -> f32 {
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

#[cfg(test)]
mod tests;
