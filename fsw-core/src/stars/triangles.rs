//! Catalogue triangles for measured triangles that share one side (thesis §3.1.3, steps 1 to 3).
//!
//! In: a measured base side (i, j), then one measured star k after another. Out: hits, each saying that catalogue star
//! r may be k if the base side is the catalogue pair (p, q).
//!
//! The catalogue pairs of the base side are kept as chained lists by their first star p, in both directions (a pair
//! may lie either way round). For a star k, every catalogue pair (p, r) that fits the side (i, k) is looked up in the
//! chain of p; each q found there proposes the triangle (p, q, r), which stays when |qr| fits the side (j, k) and its
//! sense of rotation is that of the measured triangle. Where fewer pairs fit the side (j, k), or (i, k) is beyond the
//! catalogue's range, the pairs (q, r) are looked up instead: the chain of q holds the base sides turned round. Work per star k:
//! one pass over the pairs of one side.

use crate::catalog::Catalogue;
use heapless::Vec;
use nalgebra::Vector3;

/// End of a chain.
const NONE: u16 = u16::MAX;
/// In place of the last k: no corner yet, and: out of the ranking, where later corners shall not bring it back.
const NO_CORNER: u8 = u8::MAX;
const DISCARDED: u8 = u8::MAX - 1;

/// A catalogue pair taken as the base side, in one of its two directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct BaseSide {
    /// Catalogue star for the measured star i.
    pub p: u16,
    /// Catalogue star for the measured star j.
    pub q: u16,
    /// Squared difference of the separations, in squared tolerances.
    pub square_error: f32,
    next: u16,
    /// Measured stars k for which a triangle was found.
    pub corners: u8,
    last_k: u8,
}

/// A triangle (p, q, r) over the base side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Index of the base side.
    pub side: u16,
    /// Index of the measured star k.
    pub k: u8,
    /// Catalogue star for k.
    pub r: u16,
    /// Squared differences of the two sides at r, summed, in squared tolerances.
    pub square_error: f32,
}

/// Chained lists of base sides and the hits upon them; `STARS` bounds the catalogue, `SIDES` the directed pairs of a
/// base side.
#[derive(Clone, Debug)]
pub(super) struct Triangles<const STARS: usize, const SIDES: usize, const HITS: usize> {
    /// First base side of each catalogue star.
    heads: Vec<u16, STARS>,
    pub sides: Vec<BaseSide, SIDES>,
    pub hits: Vec<Hit, HITS>,
}

/// A measured side: its chord and the half width of the band in which catalogue chords fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub chord: f32,
    pub tolerance: f32,
}

impl Side {
    pub fn low(&self) -> f32 {
        self.chord - self.tolerance
    }
    pub fn high(&self) -> f32 {
        self.chord + self.tolerance
    }
    /// Squared error in tolerances, if it fits.
    pub fn fit(&self, chord: f32) -> Option<f32> {
        let error = (chord - self.chord) / self.tolerance;
        let square = error * error;
        if square <= 1.0 { Some(square) } else { None }
    }
}

/// A measured star k with its sides to the base stars i and j.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub k: u8,
    pub to_i: Side,
    pub to_j: Side,
    /// Whether its catalogue stars are looked up by the side to j instead of that to i.
    pub by_j: bool,
    /// Sense of rotation of (i, j, k): +1, -1, or 0 when the triangle is too flat to tell.
    pub sense: f32,
}

/// Six times the volume spanned by three directions, from differences so that small triangles keep their digits.
pub(super) fn triple_product(a: &Vector3<f32>, b: &Vector3<f32>, c: &Vector3<f32>) -> f32 {
    (b - a).cross(&(c - a)).dot(a)
}

impl<const STARS: usize, const SIDES: usize, const HITS: usize> Triangles<STARS, SIDES, HITS> {
    pub const fn new() -> Self {
        const { assert!(SIDES.is_multiple_of(2), "the two directions of a pair stand side by side") };
        Self { heads: Vec::new(), sides: Vec::new(), hits: Vec::new() }
    }

    /// Takes the catalogue pairs that fit `side` as the base.
    pub fn begin(&mut self, catalogue: &Catalogue, side: &Side) {
        self.heads.clear();
        // Not beyond the capacity: this cannot fail.
        let _ = self.heads.resize(catalogue.star_count().min(STARS), NONE);
        self.sides.clear();
        self.hits.clear();
        for pair in catalogue.pairs_between(side.low(), side.high()) {
            let (Some(first), Some(second)) = (catalogue.unit(pair.first), catalogue.unit(pair.second))
            else {
                continue;
            };
            let Some(square_error) = side.fit((first - second).norm()) else { continue };
            // Both directions or none, so that they stand side by side.
            if usize::from(pair.first.max(pair.second)) >= STARS {
                continue;
            }
            for (p, q) in [(pair.first, pair.second), (pair.second, pair.first)] {
                let Some(head) = self.heads.get_mut(usize::from(p)) else { continue };
                let entry = BaseSide { p, q, square_error, next: *head, corners: 0, last_k: NO_CORNER };
                if self.sides.push(entry).is_ok() {
                    *head = (self.sides.len() - 1) as u16;
                }
            }
        }
    }

    /// Adds the triangles that the measured star `corner.k` closes, and gives the most corners that any base side has now.
    pub fn add(&mut self, catalogue: &Catalogue, corner: &Corner) -> u8 {
        let mut most = 0;
        let reach = if corner.by_j { &corner.to_j } else { &corner.to_i };
        for pair in catalogue.pairs_between(reach.low(), reach.high()) {
            for (p, r) in [(pair.first, pair.second), (pair.second, pair.first)] {
                let mut side = self.heads.get(usize::from(p)).copied().unwrap_or(NONE);
                if side == NONE {
                    continue;
                }
                let Some(unit_r) = catalogue.unit(r) else { continue };
                // A chain is no longer than the list of sides.
                for _ in 0..SIDES {
                    let Some(next) = self.sides.get(usize::from(side)).map(|base| base.next) else { break };
                    // The same pair turned round stands beside it.
                    let meant = if corner.by_j { side ^ 1 } else { side };
                    most = most.max(self.close(catalogue, corner, meant, (r, &unit_r)));
                    side = next;
                }
            }
        }
        most
    }

    /// Records the triangle of a base side and `r` if it fits; gives the corners of the base side then, else 0.
    fn close(
        &mut self,
        catalogue: &Catalogue,
        corner: &Corner,
        side: u16,
        (r, unit_r): (u16, &Vector3<f32>),
    ) -> u8 {
        let Some(base) = self.sides.get_mut(usize::from(side)) else { return 0 };
        // Where stars stand nearer than the tolerance the third could be one of the two.
        if base.p == r || base.q == r || base.last_k == DISCARDED {
            return 0;
        }
        let Some(unit_q) = catalogue.unit(base.q) else { return 0 };
        let Some(error_j) = corner.to_j.fit((unit_q - unit_r).norm()) else { return 0 };
        let Some(unit_p) = catalogue.unit(base.p) else { return 0 };
        let Some(error_i) = corner.to_i.fit((unit_p - unit_r).norm()) else { return 0 };
        if corner.sense * triple_product(&unit_p, &unit_q, unit_r) < 0.0 {
            return 0;
        }
        let hit = Hit { side, k: corner.k, r, square_error: error_i + error_j };
        if self.hits.push(hit).is_ok() && base.last_k != corner.k {
            base.last_k = corner.k;
            base.corners = base.corners.saturating_add(1);
        }
        base.corners
    }

    /// The base side with the most corners, the first of equals, if it has `least`.
    pub fn best(&self, least: u8) -> Option<u16> {
        let mut best: Option<(u16, u8)> = None;
        for (index, side) in (0u16..).zip(&self.sides) {
            if side.corners >= least && best.is_none_or(|(_, corners)| side.corners > corners) {
                best = Some((index, side.corners));
            }
        }
        best.map(|(index, _)| index)
    }

    /// Takes a base side out of the ranking.
    pub fn discard(&mut self, side: u16) {
        if let Some(side) = self.sides.get_mut(usize::from(side)) {
            side.corners = 0;
            side.last_k = DISCARDED;
        }
    }
}

#[cfg(test)]
mod tests;
