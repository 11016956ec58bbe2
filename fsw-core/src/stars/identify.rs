//! Star identification, lost in space (thesis §3.1.3).
//!
//! In: measured stars, brightest first where brightness is known, and the catalogue. Out: identified stars
//! and a verified attitude, or [`NotIdentified`]. The work is cut into measured base sides, so it can be
//! resumed from second to second ([`Identifier::advance`]).
//!
//! For every base side (i, j), in the order of the [search order](super::search_order):
//! 1. catalogue pairs of its separation, in both directions, within the tolerance;
//! 2. triangles with every further star k of the [`SEARCHED`] brightest, the likeliest to be in the
//!    catalogue first. so a true side finds its polygon among any false stars;
//! 3. only those with the measured sense of rotation;
//! 4. triangles that share the base side merge into polygons: every corner's separations to all other corners
//!    must fit too;
//! 5. polygons are ranked: most corners, then least mean square side error. The best [`PROPOSALS`] of the
//!    side go to [`confirm`](super::confirm); the first whose false-identification probability is below the
//!    limit wins. A polygon that has [`EARLY_CORNERS`] over the base side is proposed at once. Of a
//!    calibrated lens triangles are proposed too: stars on either side of the Earth's disc may be farther
//!    apart than the catalogue's range and form no larger polygon; the confirmation matches both groups.
//!
//! When all sides have been tried, the search starts over with the next, wider tolerance. The best polygons
//! so far stay readable ([`Identifier::polygons`]).
//!
//! Bounds: [`MAX_SIDES`] sides, each at most `SEARCHED` passes over the pairs of one separation and
//! `PROPOSALS + SEARCHED` confirmations; sides with more catalogue pairs than the workspace holds are left
//! out. Work is counted in catalogue pairs looked at, which is what the allowance of a call limits, to the
//! star k; base sides, triangles and confirmations count in proportion to what they cost.

use super::StarField;
use super::confirm::{Confirmed, confirm, widen};
use super::parameters::Side;
pub use super::parameters::{IdentificationParameters, TOLERANCES};
use super::polygon::{Candidates, MAX_POLYGON, Polygon};
use super::search_order::{MAX_SIDES, SEARCHED, SearchOrder, StarPair};
use super::triangles::{Corner, Triangles, triple_product};
use crate::attitude::{VectorPair, wahba};
use crate::frames::{Icrs, Rotation, StarPath};
use heapless::Vec;

/// Polygons of one base side that are handed to confirmation.
pub const PROPOSALS: usize = 3;
/// Corners over the base side with which a polygon is proposed before all stars k were examined.
pub const EARLY_CORNERS: u8 = 3;
// Cost model of the allowance; unit: a catalogue pair read for a star k, 47 cycles on the target.
/// A catalogue pair of a base side: 330 cycles.
const BASE_PAIR_PAIRS: usize = 7;
/// A triangle tested because a pair shares a star with a base side: 240 cycles, few of them more.
const TRIANGLE_PAIRS: usize = 6;
/// A confirmation: 0.33 million cycles with the reference catalogue.
const CONFIRMATION_PAIRS: usize = 7000;
/// Size of that catalogue: the confirmation reads every star. Each further star counts as one pair, more
/// than it costs.
const CONFIRMATION_STARS: usize = 3328;

/// Why a field was not identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum NotIdentified {
    /// Fewer than three stars were measured.
    TooFewStars,
    /// No separation lies in the catalogue's range.
    NoSides,
    /// No polygon passed confirmation.
    NoMatch,
}

/// State of the search after a call of [`Identifier::advance`].
#[expect(clippy::large_enum_variant, reason = "there is no heap to box the result on")]
#[derive(Clone, Debug)]
pub enum Progress {
    /// Sides remain to be tried.
    Searching,
    /// Found; the logarithm is that of the false-identification probability over all hypotheses tried.
    Identified(Confirmed, f32),
    /// All sides were tried.
    NotIdentified(NotIdentified),
}

/// The resumable search. `CHAINS` is a power of two, best near the number of base sides; `SIDES` bounds the
/// directed catalogue pairs of one separation, `HITS` the triangles over one base side.
#[derive(Clone, Debug)]
pub struct Identifier<const CHAINS: usize, const SIDES: usize, const HITS: usize> {
    triangles: Triangles<CHAINS, SIDES, HITS>,
    candidates: Candidates,
    order: SearchOrder,
    /// The base side that the allowance left unfinished.
    open: OpenSide,
    hypotheses: f32,
    /// The attitude least likely by chance of those that were not accepted, and the common logarithm of that
    /// chance.
    likeliest: Option<Rotation<Icrs, StarPath>>,
    log10_chance: f32,
}

/// Work of a call and its allowance, catalogue pairs.
#[derive(Clone, Copy, Debug)]
struct WorkAllowance {
    done: u32,
    allowance: u32,
}

impl WorkAllowance {
    fn add(&mut self, pairs: usize) {
        self.done = self.done.saturating_add(pairs as u32);
    }

    fn is_done(&self) -> bool {
        self.done >= self.allowance
    }
}

/// A base side in progress, and a bit for each star that is excluded or was tried as its corner; its own
/// two are always set.
#[derive(Clone, Copy, Debug)]
struct OpenSide {
    pair: StarPair,
    tried: u32,
}

impl OpenSide {
    /// No side. All bits zero, so that a static of it lies in `.bss`.
    const NONE: Self = Self { pair: StarPair { i: 0, j: 0, side: Side::NONE }, tried: 0 };

    fn is_none(&self) -> bool {
        self.tried == 0
    }
}

impl<const CHAINS: usize, const SIDES: usize, const HITS: usize> Default for Identifier<CHAINS, SIDES, HITS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const CHAINS: usize, const SIDES: usize, const HITS: usize> Identifier<CHAINS, SIDES, HITS> {
    /// An idle search.
    pub const fn new() -> Self {
        Self {
            triangles: Triangles::new(),
            candidates: Candidates::new(),
            order: SearchOrder::new(),
            open: OpenSide::NONE,
            hypotheses: 0.0,
            likeliest: None,
            log10_chance: 0.0,
        }
    }

    /// Resets the search for a new set of stars. `hypotheses` were tried on the same stars before, with
    /// another camera or other parameters (0 in flight): they count in the false-identification
    /// probability.
    pub fn restart(&mut self, hypotheses: f32) {
        self.candidates = Candidates::new();
        self.order = SearchOrder::new();
        self.open = OpenSide::NONE;
        self.hypotheses = hypotheses;
        (self.likeliest, self.log10_chance) = (None, 0.0);
    }

    /// The best polygons found so far, best first.
    pub fn polygons(&self) -> &[Polygon] {
        self.candidates.polygons()
    }

    /// The likeliest attitude of those that matched too few stars to be accepted: a hypothesis for the next
    /// image's stars.
    pub fn likeliest(&self) -> Option<&Rotation<Icrs, StarPath>> {
        self.likeliest.as_ref()
    }

    /// Number of catalogue hypotheses tried so far.
    pub fn hypotheses(&self) -> f32 {
        self.hypotheses
    }

    /// Tries base sides until `allowance` catalogue pairs have been looked at, with the same measured stars
    /// as the calls before.
    pub fn advance(
        &mut self,
        field: &StarField,
        parameters: &IdentificationParameters,
        allowance: u32,
    ) -> Progress {
        if field.measured().len() < 3 {
            return Progress::NotIdentified(NotIdentified::TooFewStars);
        }
        let mut work = WorkAllowance { done: 0, allowance };
        for _ in 0..=MAX_SIDES {
            if work.is_done() {
                return Progress::Searching;
            }
            if self.open.is_none() && !self.begin_side(field, parameters, &mut work) {
                break;
            }
            if let Some((mut confirmed, log10_false)) = self.try_side(field, parameters, &mut work) {
                // Called here, where the lists of the search are off the stack.
                widen(&mut confirmed, field, parameters.tolerance_px(self.order.step()));
                return Progress::Identified(confirmed, log10_false);
            }
        }
        let reason = if self.order.any_side { NotIdentified::NoMatch } else { NotIdentified::NoSides };
        Progress::NotIdentified(reason)
    }

    /// Opens the next base side with its catalogue pairs; `false` when all have been tried.
    #[inline(never)]
    fn begin_side(
        &mut self,
        field: &StarField,
        parameters: &IdentificationParameters,
        work: &mut WorkAllowance,
    ) -> bool {
        let Some(pair) = self.order.next(field, parameters, SIDES) else { return false };
        self.triangles.begin(field.catalogue, &pair.side);
        let directed = self.triangles.sides.len();
        self.hypotheses += directed as f32;
        let pairs = field.catalogue.count_between(pair.side.low(), pair.side.high());
        work.add(BASE_PAIR_PAIRS * pairs);
        self.open = OpenSide { pair, tried: bit(pair.i) | bit(pair.j) };
        true
    }

    /// Builds the polygons over the open base side and confirms the best; leaves it open where the allowance
    /// ends.
    #[inline(never)]
    fn try_side(
        &mut self,
        field: &StarField,
        parameters: &IdentificationParameters,
        work: &mut WorkAllowance,
    ) -> Option<(Confirmed, f32)> {
        let OpenSide { pair, mut tried } = core::mem::replace(&mut self.open, OpenSide::NONE);
        let StarPair { i, j, .. } = pair;
        for _ in 0..SEARCHED {
            let Some(k) = self.order.likeliest(field.measured().len(), tried) else { break };
            if work.is_done() {
                self.open = OpenSide { pair, tried };
                return None;
            }
            tried |= bit(k);
            let Some((corner, pairs)) = self.corner(field, parameters, &pair, k) else { continue };
            let most_corners = self.triangles.add(field.catalogue, &corner);
            work.add(pairs + TRIANGLE_PAIRS * self.triangles.tried as usize);
            if most_corners >= EARLY_CORNERS
                && let Some(found) = self.propose_best(field, parameters, (i, j), EARLY_CORNERS, work)
            {
                self.keep_rest(field, parameters, (i, j));
                return Some(found);
            }
        }
        // With three stars in all, triangles are proposed. Else four corners are required, because
        // triangles often occur by chance, unless a calibration gives the centroids' sigmas.
        let least = if field.measured().len() > 3 && !field.is_calibrated() { 2 } else { 1 };
        let found = (0..PROPOSALS).find_map(|_| self.propose_best(field, parameters, (i, j), least, work));
        self.keep_rest(field, parameters, (i, j));
        if found.is_none() {
            self.order.update_after_failure(&pair);
        }
        found
    }

    /// The measured star k as a corner over a base side, and the catalogue pairs of the side by which it is
    /// looked up: the one of the two that has fewer. `None` where both are beyond the catalogue's range.
    fn corner(
        &self,
        field: &StarField,
        parameters: &IdentificationParameters,
        pair: &StarPair,
        k: u8,
    ) -> Option<(Corner, usize)> {
        let StarField { catalogue, camera, .. } = *field;
        let star = |index: u8| field.measured().get(usize::from(index));
        let (star_i, star_j, star_k) = (star(pair.i)?, star(pair.j)?, star(k)?);
        let to_i = parameters.side(self.order.step(), star_i, star_k, camera);
        let to_j = parameters.side(self.order.step(), star_j, star_k, camera);
        let pairs = |side: &Side| {
            let in_range = side.high() <= catalogue.max_chord();
            in_range.then(|| catalogue.count_between(side.low(), side.high()))
        };
        let (by_j, pairs) = match (pairs(&to_i), pairs(&to_j)) {
            (Some(of_i), Some(of_j)) => (of_j < of_i, of_i.min(of_j)),
            (Some(of_i), None) => (false, of_i),
            (None, Some(of_j)) => (true, of_j),
            (None, None) => return None,
        };
        let [a, b, c] = [star_i, star_j, star_k].map(|star| star.direction.vector());
        let volume = triple_product(a, b, c);
        // The sense counts only where the triangle's height over its base exceeds the noise: two
        // tolerances.
        let flat = libm::fabsf(volume) < 2.0 * pair.side.tolerance * pair.side.chord;
        let sense = if flat { 0.0 } else { volume };
        Some((Corner { k, to_i, to_j, by_j, sense }, pairs))
    }

    /// Keeps what remains of the base side's polygons, unconfirmed.
    #[inline(never)]
    fn keep_rest(&mut self, field: &StarField, parameters: &IdentificationParameters, (i, j): (u8, u8)) {
        for _ in 0..PROPOSALS {
            let Some(side) = self.triangles.best(1) else { return };
            let polygon = self.merge(field, parameters, (i, j, side));
            self.triangles.reject(side);
            if let Some(polygon) = polygon {
                self.candidates.keep(polygon);
            }
        }
    }

    /// Merges the polygon over the base side with the most corners, if it has `least`, keeps it and confirms
    /// it. The base side leaves the ranking.
    #[inline(never)]
    fn propose_best(
        &mut self,
        field: &StarField,
        parameters: &IdentificationParameters,
        (i, j): (u8, u8),
        least: u8,
        work: &mut WorkAllowance,
    ) -> Option<(Confirmed, f32)> {
        let side = self.triangles.best(least)?;
        let polygon = self.merge(field, parameters, (i, j, side));
        self.triangles.reject(side);
        let polygon = polygon?;
        let large_enough = polygon.corners.len() >= usize::from(least) + 2;
        let found = if large_enough {
            work.add(CONFIRMATION_PAIRS + field.catalogue.star_count().saturating_sub(CONFIRMATION_STARS));
            self.propose(&polygon, field, parameters)
        } else {
            None
        };
        self.candidates.keep(polygon);
        found
    }

    /// Merges the triangles over one base side into a polygon: triangles in the order in which they were
    /// found, each corner checked against all corners taken before.
    #[inline(never)]
    fn merge(
        &self,
        field: &StarField,
        parameters: &IdentificationParameters,
        (i, j, side): (u8, u8, u16),
    ) -> Option<Polygon> {
        let (p, q) = self.triangles.stars_of(side)?;
        let mut polygon = Polygon { corners: Vec::new(), mean_square_error: 0.0 };
        polygon.corners.push((i, p)).ok()?;
        let (mut sum, mut count) = (0.0, 0.0f32);
        let of_base = self.triangles.hits.iter().filter(|hit| hit.side == side);
        for corner in core::iter::once((j, q)).chain(of_base.map(|hit| (hit.k, hit.r))) {
            let error = self.square_error_to(&polygon.corners, corner, field, parameters);
            if let Some(error) = error
                && polygon.corners.push(corner).is_ok()
            {
                sum += error;
                count += polygon.corners.len() as f32 - 1.0;
            }
        }
        polygon.mean_square_error = sum / count.max(1.0);
        Some(polygon)
    }

    /// Sum of the squared errors of the sides from a corner to others, squared tolerances; `None` where one
    /// does not fit, or the corner has the measured or catalogue star of another.
    fn square_error_to(
        &self,
        others: &[(u8, u16)],
        (k, r): (u8, u16),
        field: &StarField,
        parameters: &IdentificationParameters,
    ) -> Option<f32> {
        let seen = field.measured().get(usize::from(k))?;
        others.iter().try_fold(0.0, |sum, (other, name)| {
            if *other == k || *name == r {
                return None;
            }
            let side = parameters.side(
                self.order.step(),
                seen,
                field.measured().get(usize::from(*other))?,
                field.camera,
            );
            Some(sum + side.fit_between(field.catalogue, r, *name)?)
        })
    }

    /// Confirms a polygon.
    fn propose(
        &mut self,
        polygon: &Polygon,
        field: &StarField,
        parameters: &IdentificationParameters,
    ) -> Option<(Confirmed, f32)> {
        let attitude = attitude_of(polygon, field)?;
        let tolerance_px = parameters.tolerance_px(self.order.step());
        let confirmed = confirm(&attitude, field, tolerance_px)?;
        let log10_false = (confirmed.log10_chance + libm::log10f(self.hypotheses.max(1.0))).min(0.0);
        if log10_false > parameters.log10_false_limit {
            if confirmed.log10_chance < self.log10_chance {
                (self.likeliest, self.log10_chance) = (Some(confirmed.attitude), confirmed.log10_chance);
            }
            return None;
        }
        Some((confirmed, log10_false))
    }
}

/// The attitude that a polygon's stars have. Not inlined: keeps its list off the stack of the confirmation.
#[inline(never)]
fn attitude_of(polygon: &Polygon, field: &StarField) -> Option<Rotation<Icrs, StarPath>> {
    let mut pairs: Vec<VectorPair, MAX_POLYGON> = Vec::new();
    for (seen, name) in &polygon.corners {
        let (seen, star) = (field.measured().get(usize::from(*seen))?, field.catalogue.star(*name)?);
        pairs.push(seen.paired_with(field.catalogue.apparent_direction(&star), field.camera)).ok()?;
    }
    wahba::svd::solve(&pairs).ok()
}

/// The bit of a star among the [`SEARCHED`].
fn bit(star: u8) -> u32 {
    1u32.wrapping_shl(star.into())
}

#[cfg(test)]
mod tests;
