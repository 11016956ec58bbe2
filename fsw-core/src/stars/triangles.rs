//! Catalogue triangles for measured triangles that share one side (thesis §3.1.3, steps 1 to 3).
//!
//! In: a measured base side (i, j), then one measured star k after another. Out: hits, each saying that
//! catalogue star r may be k if the base side is the catalogue pair (p, q).
//!
//! The catalogue pairs of the base side are kept in both directions (a pair may lie either way round), one
//! beside the other: the entry of (q, p) is that of (p, q) with its last bit changed. Entries whose first
//! stars agree modulo `CHAINS` are chained. For a star k, every catalogue pair (p, r) that fits the side (i,
//! k) is looked up in the chain of p; each q found there proposes the triangle (p, q, r), which stays when
//! |qr| fits the side (j, k) and its sense of rotation is that of the measured triangle. Where fewer pairs
//! fit the side (j, k), or (i, k) is beyond the catalogue's range, the pairs (q, r) are looked up instead.
//! Work per star k: one pass over the pairs of one side.

use super::parameters::Side;
use crate::catalog::{Catalogue, Pair};
use heapless::Vec;
use nalgebra::Vector3;

/// Marks the end of a chain.
const NONE: u16 = u16::MAX;
/// In place of the last k: no corner yet.
const NO_CORNER: u8 = u8::MAX;
/// In place of the last k: proposed and rejected, takes no more corners.
const REJECTED: u8 = u8::MAX - 1;

/// A catalogue pair taken as the base side, in one of its two directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct BaseSide {
    /// Catalogue star for the measured star i; that for j is the `p` of the entry beside.
    p: u16,
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
    /// Catalogue star for k.
    pub r: u16,
    /// Index of the measured star k.
    pub k: u8,
}

/// The base sides in `CHAINS` chains and the hits upon them; `SIDES` bounds the directed pairs of a base
/// side. A catalogue may hold any number of stars: with more than `CHAINS` some share a chain.
#[derive(Clone, Debug)]
pub(super) struct Triangles<const CHAINS: usize, const SIDES: usize, const HITS: usize> {
    /// First base side of each chain.
    heads: [u16; CHAINS],
    pub sides: Vec<BaseSide, SIDES>,
    pub hits: Vec<Hit, HITS>,
    /// Triangles that were looked at for the star k added last.
    pub tried: u32,
}

/// A measured star k with its sides to the base stars i and j.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub k: u8,
    pub to_i: Side,
    pub to_j: Side,
    /// Whether its catalogue stars are looked up by the side to j instead of that to i.
    pub by_j: bool,
    /// Sense of rotation of (i, j, k): +1, -1, or 0 when the triangle is too flat.
    pub sense: f32,
}

impl Corner {
    /// Whether three catalogue stars have the sense of rotation of (i, j, k).
    fn turns_like(&self, catalogue: &Catalogue, stars: [u16; 3]) -> bool {
        match stars.map(|star| catalogue.unit(star)) {
            [Some(p), Some(q), Some(r)] => self.sense * triple_product(&p, &q, &r) >= 0.0,
            _ => false,
        }
    }
}

/// Six times the volume spanned by three directions, from differences so that small triangles keep their
/// digits.
pub(super) fn triple_product(a: &Vector3<f32>, b: &Vector3<f32>, c: &Vector3<f32>) -> f32 {
    (b - a).cross(&(c - a)).dot(a)
}

impl<const CHAINS: usize, const SIDES: usize, const HITS: usize> Triangles<CHAINS, SIDES, HITS> {
    pub const fn new() -> Self {
        const { assert!(CHAINS.is_power_of_two(), "the chain of a star is the low bits of its index") };
        const { assert!(SIDES.is_multiple_of(2), "the two directions of a pair stand side by side") };
        Self { heads: [NONE; CHAINS], sides: Vec::new(), hits: Vec::new(), tried: 0 }
    }

    /// Takes the catalogue pairs that fit `side` as the base.
    pub fn begin(&mut self, catalogue: &Catalogue, side: &Side) {
        self.heads = [NONE; CHAINS];
        self.sides.clear();
        self.hits.clear();
        catalogue.pairs_between(side.low(), side.high()).for_each(|Pair { first, second }| {
            if side.fit_between(catalogue, first, second).is_none() {
                return;
            }
            // Both directions or none: the number of entries is even.
            for p in [first, second] {
                let Some(head) = self.heads.get_mut(usize::from(p) % CHAINS) else { continue };
                let entry = BaseSide { p, next: *head, corners: 0, last_k: NO_CORNER };
                if self.sides.push(entry).is_ok() {
                    *head = (self.sides.len() - 1) as u16;
                }
            }
        });
    }

    /// The catalogue stars p and q of a base side.
    pub fn stars_of(&self, side: u16) -> Option<(u16, u16)> {
        let star = |side: u16| self.sides.get(usize::from(side)).map(|base| base.p);
        Some((star(side)?, star(side ^ 1)?))
    }

    /// Adds the triangles that the measured star `corner.k` closes, and gives the most corners that any base
    /// side has now.
    pub fn add(&mut self, catalogue: &Catalogue, corner: &Corner) -> u8 {
        let mut most = 0;
        self.tried = 0;
        let reach = if corner.by_j { &corner.to_j } else { &corner.to_i };
        // Most pairs have no star of a base side: this loop is what a pair costs.
        catalogue.pairs_between(reach.low(), reach.high()).for_each(|Pair { first, second }| {
            let head = |star: u16| self.heads.get(usize::from(star) % CHAINS).copied().unwrap_or(NONE);
            let (of_first, of_second) = (head(first), head(second));
            if of_first != NONE {
                most = most.max(self.close_chain(catalogue, corner, of_first, (first, second)));
            }
            if of_second != NONE {
                most = most.max(self.close_chain(catalogue, corner, of_second, (second, first)));
            }
        });
        most
    }

    /// Closes the triangles of `r` over every base side of p in the chain that begins with `side`; gives the
    /// most corners that any of these has then.
    #[inline(never)]
    fn close_chain(
        &mut self,
        catalogue: &Catalogue,
        corner: &Corner,
        mut side: u16,
        (p, r): (u16, u16),
    ) -> u8 {
        let mut most = 0;
        // A chain is no longer than the list of sides.
        for _ in 0..SIDES {
            let Some(base) = self.sides.get(usize::from(side)) else { break };
            let next = base.next;
            if base.p == p {
                // Looked up by its q: the base side in the opposite direction.
                let meant = if corner.by_j { side ^ 1 } else { side };
                self.tried += 1;
                if self.may_close(catalogue, corner, meant, r) {
                    most = most.max(self.close(catalogue, corner, meant, r));
                }
            }
            side = next;
        }
        most
    }

    /// Whether the triangle of a base side and `r` may fit by its side that was not looked up, and the base
    /// side takes corners. Few do.
    fn may_close(&self, catalogue: &Catalogue, corner: &Corner, side: u16, r: u16) -> bool {
        let rejected = self.sides.get(usize::from(side)).is_none_or(|base| base.last_k == REJECTED);
        let Some((p, q)) = self.stars_of(side) else { return false };
        // With stars closer than the tolerance the third may be one of the two.
        if p == r || q == r || rejected {
            return false;
        }
        if corner.by_j { corner.to_i.may_fit(catalogue, p, r) } else { corner.to_j.may_fit(catalogue, q, r) }
    }

    /// Records the triangle of a base side and `r` if it fits; gives the corners of the base side then, else
    /// 0.
    #[inline(never)]
    fn close(&mut self, catalogue: &Catalogue, corner: &Corner, side: u16, r: u16) -> u8 {
        let Some((p, q)) = self.stars_of(side) else { return 0 };
        let Some(base) = self.sides.get_mut(usize::from(side)) else { return 0 };
        if corner.to_j.fit_between(catalogue, q, r).is_none()
            || corner.to_i.fit_between(catalogue, p, r).is_none()
            || !corner.turns_like(catalogue, [p, q, r])
        {
            return 0;
        }
        if self.hits.push(Hit { side, k: corner.k, r }).is_ok() && base.last_k != corner.k {
            base.last_k = corner.k;
            base.corners = base.corners.saturating_add(1);
        }
        base.corners
    }

    /// The base side with the most corners, the first of equals, if it has `least`.
    #[inline(never)]
    pub fn best(&self, least: u8) -> Option<u16> {
        let mut best: Option<(u16, u8)> = None;
        for (index, side) in (0u16..).zip(&self.sides) {
            if side.corners >= least && best.is_none_or(|(_, corners)| side.corners > corners) {
                best = Some((index, side.corners));
            }
        }
        best.map(|(index, _)| index)
    }

    /// Takes a base side out of the ranking for good.
    pub fn reject(&mut self, side: u16) {
        if let Some(side) = self.sides.get_mut(usize::from(side)) {
            side.corners = 0;
            side.last_k = REJECTED;
        }
    }
}

#[cfg(test)]
mod tests;
