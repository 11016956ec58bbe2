//! Verification of an attitude hypothesis by re-projection.
//!
//! In: the attitude of a polygon, the measured stars, the catalogue. The brightest catalogue stars of the
//! field are projected onto the detector and matched, brightest first, with the one measured star inside a
//! radius that shrinks over [`ROUNDS`]; after each round the attitude is solved anew from all matches. Out:
//! matches, their attitude, and the probability of as many by chance ([`chance`](super::chance)).

use super::chance::log10_chance;
use super::focal_ratio::{FocalRatio, focal_ratio};
use super::predict::{MAX_FIELD_STARS, Predicted, field_stars};
use super::weighing::{sigma_scale, solve};
use super::{MAX_MEASURED, Match, MeasuredStar, StarField};
use crate::attitude::VectorPair;
use crate::frames::{Icrs, Rotation, StarPath};
use heapless::Vec;

/// Rounds of matching and solving; the radius shrinks from 2 tolerances to 1.
pub const ROUNDS: usize = 3;

/// Most stars of [`match_predicted_stars`].
pub const MAX_FEW_STARS: usize = 8;

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
