//! Star identification, lost in space (thesis §3.1.3).
//!
//! In: measured stars, brightest first where brightness is known, and the catalogue. Out: names and an attitude that
//! stood confirmation, or "not identified" with the reason. The work is cut into measured base sides, so it can be
//! resumed from second to second ([`Identifier::advance`]).
//!
//! For every base side (i, j), first those of the brightest stars ([`BLOCKS`]), the ones with the fewest catalogue pairs
//! leading:
//! 1. catalogue pairs of its separation, in both directions, within the tolerance;
//! 2. triangles with up to [`CORNERS`] further stars k;
//! 3. only those with the measured sense of rotation;
//! 4. triangles that share the base side merge into polygons: every corner's separations to all other corners must fit
//!    too;
//! 5. polygons are ranked: most corners, then least mean square side error. The best [`PROPOSALS`] of the side go to
//!    [`confirm`](super::confirm); the first whose false-identification probability is below the limit wins. A polygon
//!    that has [`EARLY_CORNERS`] over the base side is proposed at once.
//!
//! When all sides have been tried, the search starts over with the next, wider tolerance. All polygons ranked best so
//! far stay readable ([`Identifier::polygons`]).
//!
//! Bounds: [`MAX_SIDES`] sides a tolerance, each at most `CORNERS` passes over the pairs of one separation and
//! `PROPOSALS + CORNERS` confirmations; sides with more catalogue pairs than the workspace holds are left out. Work is
//! counted in catalogue pairs looked at, which is what the allowance of a call limits, to the side.

use super::confirm::{Confirmed, confirm};
use super::triangles::{Corner, Side, Triangles, triple_product};
use super::{Field, Measured};
use crate::attitude::{VectorPair, wahba};
use crate::camera::Camera;
use crate::order::settle_last;
use heapless::Vec;

/// Tolerances tried one after the other.
pub const TOLERANCES: usize = 3;
/// Stars k examined for a base side.
pub const CORNERS: usize = 10;
/// Most stars of a polygon.
pub const MAX_POLYGON: usize = CORNERS + 2;
/// Polygons of one base side that are handed to confirmation.
pub const PROPOSALS: usize = 3;
/// Corners over the base side with which a polygon is proposed before all stars k were examined.
pub const EARLY_CORNERS: u8 = 3;
/// Base sides are taken among so many of the brightest stars, block after block.
pub const BLOCKS: [usize; 3] = [8, 12, 16];
/// Most base sides tried with one tolerance: all pairs of the last block.
pub const MAX_SIDES: usize = 16 * 15 / 2;
/// Polygons kept for inspection.
pub const KEPT_POLYGONS: usize = 8;

/// Parameters of star identification.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct IdentificationParameters {
    /// Centroid errors to assume, px per axis (1 sigma), tried in this order (default 0.35, 1, 2). The tolerance of a
    /// separation is three sigmas of the difference of two stars, `3 sqrt(2)` times as much (thesis §4.1.1).
    pub centroid_sigma_px: [f32; TOLERANCES],
    /// Relative uncertainty of the focal length, added to the tolerance as this share of the separation (default
    /// 2e-4, 0 to 0.01).
    pub scale_uncertainty: f32,
    /// Largest accepted common logarithm of the false-identification probability (default -9).
    pub log10_false_limit: f32,
}

impl Default for IdentificationParameters {
    fn default() -> Self {
        Self { centroid_sigma_px: [0.35, 1.0, 2.0], scale_uncertainty: 2e-4, log10_false_limit: -9.0 }
    }
}

impl IdentificationParameters {
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

/// Measured and catalogue stars that agree in all their separations.
#[derive(Clone, Debug)]
pub struct Polygon {
    /// Pairs of (measured index, catalogue index).
    pub corners: Vec<(u8, u16), MAX_POLYGON>,
    /// Mean square error of its sides, squared tolerances.
    pub mean_square_error: f32,
}

impl Polygon {
    /// The thesis's criterion: more corners, then less error.
    fn better_than(&self, other: &Polygon) -> bool {
        let (ours, theirs) = (self.corners.len(), other.corners.len());
        ours > theirs || (ours == theirs && self.mean_square_error < other.mean_square_error)
    }
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

/// A base side to try.
#[derive(Clone, Copy, Debug)]
struct Task {
    i: u8,
    j: u8,
    side: Side,
    /// Block of the brightest, then catalogue pairs: the order of the agenda.
    cost: (u8, u16),
}

/// The resumable search. `STARS` bounds the catalogue, `SIDES` the directed catalogue pairs of one separation, `HITS`
/// the triangles over one base side.
#[derive(Clone, Debug)]
pub struct Identifier<const STARS: usize, const SIDES: usize, const HITS: usize> {
    triangles: Triangles<STARS, SIDES, HITS>,
    polygons: Vec<Polygon, KEPT_POLYGONS>,
    /// Base sides at the present tolerance, in the order in which they are tried.
    agenda: Vec<Task, MAX_SIDES>,
    /// The next of them.
    next: usize,
    /// The next tolerance to make an agenda for.
    step: usize,
    any_side: bool,
    hypotheses: f32,
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
            polygons: Vec::new(),
            agenda: Vec::new(),
            next: 0,
            step: 0,
            any_side: false,
            hypotheses: 0.0,
        }
    }

    /// Forgets the search, for a new set of stars. `hypotheses` were tried on the same stars before, with another camera
    /// or other parameters (0 in flight): they count in the false-identification probability.
    pub fn restart(&mut self, hypotheses: f32) {
        self.polygons.clear();
        self.agenda.clear();
        (self.next, self.step, self.any_side, self.hypotheses) = (0, 0, false, hypotheses);
    }

    /// The best polygons found so far, best first.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
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
        let mut work = 0;
        // Every side of every tolerance, and the making of each agenda.
        for _ in 0..TOLERANCES * (MAX_SIDES + 1) {
            let Some(task) = self.agenda.get(self.next).copied() else {
                if self.step >= TOLERANCES {
                    let reason = if self.any_side { NotIdentified::NoMatch } else { NotIdentified::NoSides };
                    return Progress::NotIdentified(reason);
                }
                self.make_agenda(field, parameters);
                continue;
            };
            if work >= allowance {
                return Progress::Searching;
            }
            self.next += 1;
            let found = self.try_side(field, parameters, &task, &mut work);
            if let Some((confirmed, log10_false)) = found {
                return Progress::Identified(confirmed, log10_false);
            }
        }
        Progress::Searching
    }

    /// Tolerance of the agenda in force, px.
    fn tolerance_px(&self, parameters: &IdentificationParameters) -> f32 {
        parameters.tolerance_px(self.step.saturating_sub(1))
    }

    /// The measured side between two stars at the present tolerance.
    fn side(
        &self,
        a: &Measured,
        b: &Measured,
        camera: &Camera,
        parameters: &IdentificationParameters,
    ) -> Side {
        let chord = a.direction.chord(&b.direction);
        let tolerance = self.tolerance_px(parameters) * camera.rad_per_px();
        Side { chord, tolerance: tolerance + parameters.scale_uncertainty * chord }
    }

    /// Lists the base sides of the next tolerance: block by block, within a block by rising number of catalogue pairs.
    /// Left out are sides beyond the catalogue's range, sides too short to have a direction, and those with more pairs
    /// than the workspace holds.
    fn make_agenda(&mut self, field: &Field, parameters: &IdentificationParameters) {
        self.step += 1;
        self.next = 0;
        self.agenda.clear();
        let mut first = 1;
        for (block, stars) in (0u8..).zip(BLOCKS) {
            for (j, b) in (0u8..).zip(field.measured()).take(stars).skip(first) {
                for (i, a) in (0u8..).zip(field.measured()).take(usize::from(j)) {
                    let side = self.side(a, b, field.camera, parameters);
                    let pairs = field.catalogue.count_between(side.low(), side.high());
                    let in_range =
                        side.high() <= field.catalogue.max_chord() && side.chord >= 10.0 * side.tolerance;
                    if in_range && pairs > 0 && 2 * pairs <= SIDES {
                        // There are no more pairs of stars than places.
                        let _ = self.agenda.push(Task { i, j, side, cost: (block, pairs as u16) });
                        settle_last(&mut self.agenda, |a, b| a.cost < b.cost);
                    }
                }
            }
            first = stars;
        }
        self.any_side |= !self.agenda.is_empty();
    }

    /// Builds the polygons over one base side and confirms the best; counts the catalogue pairs it looks at.
    fn try_side(
        &mut self,
        field: &Field,
        parameters: &IdentificationParameters,
        task: &Task,
        work: &mut u32,
    ) -> Option<(Confirmed, f32)> {
        let Field { catalogue, camera, .. } = *field;
        let Task { i, j, side: base, .. } = *task;
        let (star_i, star_j) = (field.measured().get(usize::from(i))?, field.measured().get(usize::from(j))?);
        self.triangles.begin(catalogue, &base);
        let directed = self.triangles.sides.len();
        self.hypotheses += directed as f32;
        *work = work.saturating_add(directed as u32);
        // A polygon of four is the least that chance seldom builds; with three stars in all, three must do.
        let least = if field.measured().len() > 3 { 2 } else { 1 };
        let mut corners = 0;
        for (k, star_k) in (0u8..).zip(field.measured()) {
            if k == i || k == j || corners >= CORNERS {
                continue;
            }
            let to_i = self.side(star_i, star_k, camera, parameters);
            let to_j = self.side(star_j, star_k, camera, parameters);
            if to_i.high() > catalogue.max_chord() {
                continue;
            }
            corners += 1;
            *work = work.saturating_add(catalogue.count_between(to_i.low(), to_i.high()) as u32);
            let [a, b, c] = [star_i, star_j, star_k].map(|star| star.direction.vector());
            let volume = triple_product(a, b, c);
            // The height of the triangle over its base must exceed what noise can turn round.
            let flat = libm::fabsf(volume) < 2.0 * base.tolerance * base.chord;
            let sense = if flat { 0.0 } else { volume };
            if self.triangles.add(catalogue, &Corner { k, to_i, to_j, sense }) >= EARLY_CORNERS
                && let Some(found) = self.propose_best(field, parameters, (i, j), EARLY_CORNERS)
            {
                return Some(found);
            }
        }
        (0..PROPOSALS).find_map(|_| self.propose_best(field, parameters, (i, j), least))
    }

    /// Merges the polygon over the base side with the most corners, if it has `least`, keeps it and confirms it. The
    /// base side leaves the ranking.
    fn propose_best(
        &mut self,
        field: &Field,
        parameters: &IdentificationParameters,
        (i, j): (u8, u8),
        least: u8,
    ) -> Option<(Confirmed, f32)> {
        let side = self.triangles.best(least)?;
        let polygon = self.merge(field, parameters, (i, j, side));
        self.triangles.discard(side);
        let polygon = polygon?;
        let large_enough = polygon.corners.len() >= usize::from(least) + 2;
        let found = if large_enough { self.propose(&polygon, field, parameters) } else { None };
        self.keep(polygon);
        found
    }

    /// Merges the triangles over one base side into a polygon: triangles in order of their error, each corner checked
    /// against all corners taken before.
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
                let error = self.side(star, seen, camera, parameters).fit((unit - named).norm());
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

    /// Keeps a polygon among the best for inspection.
    fn keep(&mut self, polygon: Polygon) {
        if polygon.corners.len() < 3 {
            return;
        }
        if self.polygons.is_full() && self.polygons.last().is_some_and(|worst| polygon.better_than(worst)) {
            self.polygons.pop();
        }
        if self.polygons.push(polygon).is_ok() {
            settle_last(&mut self.polygons, Polygon::better_than);
        }
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
            pairs.push(seen.paired_with(&star, field.camera)).ok()?;
        }
        let attitude = wahba::svd::solve(&pairs).ok()?;
        let confirmed = confirm(&attitude, field, self.tolerance_px(parameters))?;
        let log10_false = (confirmed.log10_chance + libm::log10f(self.hypotheses.max(1.0))).min(0.0);
        if log10_false <= parameters.log10_false_limit { Some((confirmed, log10_false)) } else { None }
    }
}
