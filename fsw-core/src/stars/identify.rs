//! Star identification, lost in space (thesis §3.1.3).
//!
//! In: measured stars, brightest first where brightness is known, and the catalogue. Out: names and an attitude that
//! stood confirmation, or "not identified" with the reason. The work is cut into measured base sides, so it can be
//! resumed from second to second ([`Identifier::advance`]).
//!
//! For every base side (i, j), in the order of the [agenda](super::agenda):
//! 1. catalogue pairs of its separation, in both directions, within the tolerance;
//! 2. triangles with every further star k of the [`SEARCHED`] brightest, the likeliest to be in the catalogue first. A true
//!    side so finds its polygon whatever stands beside it;
//! 3. only those with the measured sense of rotation;
//! 4. triangles that share the base side merge into polygons: every corner's separations to all other corners must fit
//!    too;
//! 5. polygons are ranked: most corners, then least mean square side error. The best [`PROPOSALS`] of the side go to
//!    [`confirm`](super::confirm); the first whose false-identification probability is below the limit wins. A polygon
//!    that has [`EARLY_CORNERS`] over the base side is proposed at once. Of a calibrated lens triangles are proposed too: of stars on
//!    either side of the Earth's disc, farther apart than the catalogue's range, there may be no more, and confirmation sees both
//!    groups.
//!
//! When all sides have been tried, the search starts over with the next, wider tolerance. All polygons ranked best so
//! far stay readable ([`Identifier::polygons`]).
//!
//! Bounds: [`MAX_SIDES`] sides, each at most `SEARCHED` passes over the pairs of one separation and
//! `PROPOSALS + SEARCHED` confirmations; sides with more catalogue pairs than the workspace holds are left out. Work is
//! counted in catalogue pairs looked at, which is what the allowance of a call limits, to the star k; a confirmation counts as
//! `CONFIRMATION_PAIRS`.

use super::agenda::{Agenda, MAX_SIDES, SEARCHED, Task};
use super::confirm::{Confirmed, confirm, widen};
use super::polygon::{Candidates, MAX_POLYGON, Polygon};
use super::triangles::{Corner, Side, Triangles, triple_product};
use super::{Field, Measured};
use crate::attitude::{VectorPair, wahba};
use crate::camera::Camera;
use crate::parameters::table::parameter_group;
use heapless::Vec;

/// Tolerances tried one after the other.
pub const TOLERANCES: usize = 3;
/// Polygons of one base side that are handed to confirmation.
pub const PROPOSALS: usize = 3;
/// Corners over the base side with which a polygon is proposed before all stars k were examined.
pub const EARLY_CORNERS: u8 = 3;
/// What a confirmation counts for in an allowance, catalogue pairs: 0.4 million cycles on the target, where a pair costs 130 with
/// all that goes with it.
const CONFIRMATION_PAIRS: usize = 3000;

parameter_group! {
    /// Star identification.
    pub struct IdentificationParameters in "identification" {
        /// Centroid errors to assume per axis, 1 sigma, tried in this order. The tolerance of a separation is three sigmas
        /// of the difference of two stars, `3 sqrt(2)` times as much (thesis 4.1.1).
        centroid_sigma_px: [f32; TOLERANCES] = [0.35, 1.0, 2.0], 0.05..=3.0, "px",
            "lenses without a calibration; with one 0.2, 0.6, 2";
        /// Relative uncertainty of the focal length, added to the tolerance as this share of the separation.
        scale_uncertainty: f32 = 2e-4, 0.0..=0.01, "", "chosen: 0.2 px over 1000 px";
        /// Largest accepted common logarithm of the false-identification probability.
        log10_false_limit: f32 = -9.0, -30.0..=-2.0, "", "one wrong sky in thirty years of an image a second";
        /// Catalogue pairs that may be looked at in one second, confirmations counted in proportion.
        pairs_per_cycle: u32 = 560_000, 10_000..=4_000_000, "", "130 cycles a pair on the target: 73 M cycles";
    }
}

impl IdentificationParameters {
    /// The defaults for a lens whose [`Calibration`](crate::image::calibration::Calibration) is known: its centroids are
    /// better, and the nearer a match must be, the more it proves.
    pub fn of_calibrated_lens() -> Self {
        Self { centroid_sigma_px: [0.2, 0.6, 2.0], ..Self::default() }
    }

    /// The measured side between two stars with the tolerance number `step`.
    pub(super) fn side(&self, step: usize, a: &Measured, b: &Measured, camera: &Camera) -> Side {
        let chord = a.direction.chord(&b.direction);
        let tolerance = self.tolerance_px(step) * camera.rad_per_px();
        Side { chord, tolerance: tolerance + self.scale_uncertainty * chord }
    }

    /// Tolerance of a separation of two stars near each other, px.
    pub fn tolerance_px(&self, step: usize) -> f32 {
        const THREE_SIGMA_OF_DIFFERENCE: f32 = 4.242_640_7;
        self.centroid_sigma_px.get(step).copied().unwrap_or(0.0) * THREE_SIGMA_OF_DIFFERENCE
    }
}

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

/// Where the search stands after a call of [`Identifier::advance`].
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

/// The resumable search. `STARS` bounds the catalogue, `SIDES` the directed catalogue pairs of one separation, `HITS`
/// the triangles over one base side.
#[derive(Clone, Debug)]
pub struct Identifier<const STARS: usize, const SIDES: usize, const HITS: usize> {
    triangles: Triangles<STARS, SIDES, HITS>,
    candidates: Candidates,
    agenda: Agenda,
    /// The base side that the allowance left unfinished.
    open: OpenSide,
    hypotheses: f32,
}

/// What a call may do, in catalogue pairs, and what it did.
#[derive(Clone, Copy, Debug)]
struct Work {
    done: u32,
    allowance: u32,
}

impl Work {
    fn add(&mut self, pairs: usize) {
        self.done = self.done.saturating_add(pairs as u32);
    }

    fn is_done(&self) -> bool {
        self.done >= self.allowance
    }
}

/// A base side, and the stars that cannot be corners of it or were tried, a bit each: its own two at the least.
#[derive(Clone, Copy, Debug)]
struct OpenSide {
    task: Task,
    tried: u32,
}

impl OpenSide {
    /// No side. All zero, as what is to be made in a static must be.
    const NONE: Self =
        Self { task: Task { i: 0, j: 0, side: Side { chord: 0.0, tolerance: 0.0 } }, tried: 0 };

    fn is_none(&self) -> bool {
        self.tried == 0
    }
}

impl<const STARS: usize, const SIDES: usize, const HITS: usize> Default for Identifier<STARS, SIDES, HITS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const STARS: usize, const SIDES: usize, const HITS: usize> Identifier<STARS, SIDES, HITS> {
    /// An idle search.
    pub const fn new() -> Self {
        Self {
            triangles: Triangles::new(),
            candidates: Candidates::new(),
            agenda: Agenda::new(),
            open: OpenSide::NONE,
            hypotheses: 0.0,
        }
    }

    /// Forgets the search, for a new set of stars. `hypotheses` were tried on the same stars before, with another camera
    /// or other parameters (0 in flight): they count in the false-identification probability.
    pub fn restart(&mut self, hypotheses: f32) {
        self.candidates = Candidates::new();
        self.agenda = Agenda::new();
        self.open = OpenSide::NONE;
        self.hypotheses = hypotheses;
    }

    /// The best polygons found so far, best first.
    pub fn polygons(&self) -> &[Polygon] {
        self.candidates.polygons()
    }

    /// Number of catalogue hypotheses tried so far.
    pub fn hypotheses(&self) -> f32 {
        self.hypotheses
    }

    /// Tries base sides until `allowance` catalogue pairs have been looked at, with the same measured stars as the calls
    /// before.
    pub fn advance(
        &mut self,
        field: &Field,
        parameters: &IdentificationParameters,
        allowance: u32,
    ) -> Progress {
        if field.measured().len() < 3 {
            return Progress::NotIdentified(NotIdentified::TooFewStars);
        }
        let mut work = Work { done: 0, allowance };
        for _ in 0..=MAX_SIDES {
            if work.is_done() {
                return Progress::Searching;
            }
            if self.open.is_none() && !self.begin_side(field, parameters, &mut work) {
                break;
            }
            if let Some((confirmed, log10_false)) = self.try_side(field, parameters, &mut work) {
                // Here, where the lists of the search are off the stack.
                let tolerance_px = parameters.tolerance_px(self.agenda.step());
                return Progress::Identified(widen(confirmed, field, tolerance_px), log10_false);
            }
        }
        let reason = if self.agenda.any { NotIdentified::NoMatch } else { NotIdentified::NoSides };
        Progress::NotIdentified(reason)
    }

    /// Opens the next base side with its catalogue pairs; `false` when all have been tried.
    #[inline(never)]
    fn begin_side(&mut self, field: &Field, parameters: &IdentificationParameters, work: &mut Work) -> bool {
        let Some(task) = self.agenda.next(field, parameters, SIDES) else { return false };
        self.triangles.begin(field.catalogue, &task.side);
        let directed = self.triangles.sides.len();
        self.hypotheses += directed as f32;
        work.add(directed);
        self.open = OpenSide { task, tried: bit(task.i) | bit(task.j) };
        true
    }

    /// Builds the polygons over the open base side and confirms the best; leaves it open where the allowance ends.
    #[inline(never)]
    fn try_side(
        &mut self,
        field: &Field,
        parameters: &IdentificationParameters,
        work: &mut Work,
    ) -> Option<(Confirmed, f32)> {
        let Field { catalogue, camera, .. } = *field;
        let OpenSide { task, mut tried } = core::mem::replace(&mut self.open, OpenSide::NONE);
        let Task { i, j, side: base } = task;
        let (star_i, star_j) = (field.measured().get(usize::from(i))?, field.measured().get(usize::from(j))?);
        for _ in 0..SEARCHED {
            let Some(k) = self.agenda.likeliest(field.measured().len(), tried) else { break };
            if work.is_done() {
                self.open = OpenSide { task, tried };
                return None;
            }
            tried |= bit(k);
            let star_k = field.measured().get(usize::from(k))?;
            let to_i = parameters.side(self.agenda.step(), star_i, star_k, camera);
            let to_j = parameters.side(self.agenda.step(), star_j, star_k, camera);
            let pairs = |side: &Side| {
                let in_range = side.high() <= catalogue.max_chord();
                in_range.then(|| catalogue.count_between(side.low(), side.high()))
            };
            let (by_j, pairs) = match (pairs(&to_i), pairs(&to_j)) {
                (Some(of_i), Some(of_j)) => (of_j < of_i, of_i.min(of_j)),
                (Some(of_i), None) => (false, of_i),
                (None, Some(of_j)) => (true, of_j),
                (None, None) => continue,
            };
            work.add(pairs);
            let [a, b, c] = [star_i, star_j, star_k].map(|star| star.direction.vector());
            let volume = triple_product(a, b, c);
            // The height of the triangle over its base must exceed what noise can turn round.
            let flat = libm::fabsf(volume) < 2.0 * base.tolerance * base.chord;
            let sense = if flat { 0.0 } else { volume };
            if self.triangles.add(catalogue, &Corner { k, to_i, to_j, by_j, sense }) >= EARLY_CORNERS
                && let Some(found) = self.propose_best(field, parameters, (i, j), EARLY_CORNERS, work)
            {
                self.keep_rest(field, parameters, (i, j));
                return Some(found);
            }
        }
        // With three stars in all, three must do. Else a polygon of four is the least that chance seldom builds, or that bad
        // centroids let pass by luck, unless it is known how good they are.
        let least = if field.measured().len() > 3 && !field.is_calibrated() { 2 } else { 1 };
        let found = (0..PROPOSALS).find_map(|_| self.propose_best(field, parameters, (i, j), least, work));
        self.keep_rest(field, parameters, (i, j));
        if found.is_none() {
            self.agenda.failed(&task);
        }
        found
    }

    /// Keeps what remains of the base side's polygons, unconfirmed.
    fn keep_rest(&mut self, field: &Field, parameters: &IdentificationParameters, (i, j): (u8, u8)) {
        for _ in 0..PROPOSALS {
            let Some(side) = self.triangles.best(1) else { return };
            let polygon = self.merge(field, parameters, (i, j, side));
            self.triangles.discard(side);
            if let Some(polygon) = polygon {
                self.candidates.keep(polygon);
            }
        }
    }

    /// Merges the polygon over the base side with the most corners, if it has `least`, keeps it and confirms it. The
    /// base side leaves the ranking.
    fn propose_best(
        &mut self,
        field: &Field,
        parameters: &IdentificationParameters,
        (i, j): (u8, u8),
        least: u8,
        work: &mut Work,
    ) -> Option<(Confirmed, f32)> {
        let side = self.triangles.best(least)?;
        let polygon = self.merge(field, parameters, (i, j, side));
        self.triangles.discard(side);
        let polygon = polygon?;
        let large_enough = polygon.corners.len() >= usize::from(least) + 2;
        let found = if large_enough {
            work.add(CONFIRMATION_PAIRS);
            self.propose(&polygon, field, parameters)
        } else {
            None
        };
        self.candidates.keep(polygon);
        found
    }

    /// Merges the triangles over one base side into a polygon: triangles in the order in which they were found, each corner
    /// checked against all corners taken before.
    fn merge(
        &self,
        field: &Field,
        parameters: &IdentificationParameters,
        (i, j, side): (u8, u8, u16),
    ) -> Option<Polygon> {
        let Field { catalogue, camera, .. } = *field;
        let measured = field.measured();
        let base = self.triangles.sides.get(usize::from(side))?;
        let mut corners: Vec<(u8, u16), MAX_POLYGON> = Vec::new();
        corners.push((i, base.p)).ok()?;
        corners.push((j, base.q)).ok()?;
        let (mut sum, mut count) = (base.square_error, 1.0f32);
        for hit in self.triangles.hits.iter().filter(|hit| hit.side == side) {
            let (Some(star), Some(unit)) = (measured.get(usize::from(hit.k)), catalogue.unit(hit.r)) else {
                continue;
            };
            let mut square_error = hit.square_error;
            let fits = corners.iter().enumerate().all(|(at, (other, name))| {
                if *other == hit.k || *name == hit.r {
                    return false;
                }
                // The sides to the base stars are in the hit already.
                if at < 2 {
                    return true;
                }
                let (Some(seen), Some(named)) = (measured.get(usize::from(*other)), catalogue.unit(*name))
                else {
                    return false;
                };
                let error =
                    parameters.side(self.agenda.step(), star, seen, camera).fit((unit - named).norm());
                square_error += error.unwrap_or(0.0);
                error.is_some()
            });
            if fits && corners.push((hit.k, hit.r)).is_ok() {
                sum += square_error;
                count += corners.len() as f32 - 1.0;
            }
        }
        Some(Polygon { corners, mean_square_error: sum / count })
    }

    /// Solves the attitude of a polygon and confirms it.
    fn propose(
        &self,
        polygon: &Polygon,
        field: &Field,
        parameters: &IdentificationParameters,
    ) -> Option<(Confirmed, f32)> {
        let mut pairs: Vec<VectorPair, MAX_POLYGON> = Vec::new();
        for (seen, name) in &polygon.corners {
            let (seen, star) = (field.measured().get(usize::from(*seen))?, field.catalogue.star(*name)?);
            pairs.push(seen.paired_with(field.catalogue.seen(&star), field.camera)).ok()?;
        }
        let attitude = wahba::svd::solve(&pairs).ok()?;
        let tolerance_px = parameters.tolerance_px(self.agenda.step());
        let confirmed = confirm(&attitude, field, tolerance_px)?;
        let log10_false = (confirmed.log10_chance + libm::log10f(self.hypotheses.max(1.0))).min(0.0);
        if log10_false > parameters.log10_false_limit {
            return None;
        }
        Some((confirmed, log10_false))
    }
}

/// The bit of a star among the [`SEARCHED`].
fn bit(star: u8) -> u32 {
    1u32.wrapping_shl(star.into())
}

#[cfg(test)]
mod tests;
