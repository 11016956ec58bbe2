//! Order in which base sides are tried.
//!
//! In: measured stars, brightest first where brightness is known; the sides that failed. Out: one base side
//! after another, for one tolerance after another. Every side among the [`SEARCHED`] brightest is given
//! once, except those beyond the catalogue's range, those shorter than ten tolerances, and those with more
//! pairs than the workspace holds.
//!
//! Brightness alone does not separate catalogue stars from false ones: hits and edges of clouds are among
//! the brightest spots. So every star has a probability `p` to be in the catalogue, initially
//! `prior_probability` of its rank. A side of two catalogue stars is identified with probability `f`,
//! `IDENTIFICATION_PROBABILITY`, because all others are tried as its corners. After a side (i, j) has
//! failed, Bayes' rule gives
//!
//! `p_i <- p_i (1 - f p_j) / (1 - f p_i p_j)`, and the same of j.
//!
//! The next side is that of the largest `p_i p_j` over its cost. A bright false star is so tried in two or
//! three sides only, and of N stars, K of them true, about `N² / K²` sides are tried.

use super::StarField;
use super::parameters::{IdentificationParameters, Side, TOLERANCES};

/// Brightest stars whose sides are tried.
pub const SEARCHED: usize = 32;
/// Sides among them.
const SIDES: usize = SEARCHED * (SEARCHED - 1) / 2;
/// Largest number of base sides of a whole search: all pairs of stars, for every tolerance.
pub const MAX_SIDES: usize = TOLERANCES * SIDES;

/// Probability that a side of two catalogue stars is identified: one in ten is lost to a centroid beyond
/// three sigmas of a separation or to fewer than two other stars of the catalogue around. Below 1, so that
/// no star's probability becomes 0.
const IDENTIFICATION_PROBABILITY: f32 = 0.9;
/// Unit of a side's cost, catalogue pairs: a byte then holds up to 2,040, more than a side of the onboard
/// identifier may have.
const PAIRS_PER_COST: usize = 8;
/// Cost of the corners of a side, in that unit: one for each of up to 30 other stars. A side with the usual
/// 150 pairs then costs 1.6 times as much as one with almost none: the likelihood dominates, the cost
/// breaks near ties.
const CORNERS_COST: f32 = 30.0;

/// Probability that the star of a rank is in the catalogue: on rendered frames with false stars half of the
/// first eight are, six tenths of the next twelve, three tenths of the last four.
fn prior_probability(rank: u8) -> f32 {
    0.6 - 0.01 * f32::from(rank)
}

/// A base side to try.
#[derive(Clone, Copy, Debug)]
pub(super) struct StarPair {
    /// Its stars, i before j.
    pub i: u8,
    pub j: u8,
    pub side: Side,
}

/// The remaining base sides.
#[derive(Clone, Debug)]
pub(super) struct SearchOrder {
    /// Cost of each side, those of star 1 first, then those of star 2 with 0 and 1, and so on; 0: not to be
    /// tried.
    costs: [u8; SIDES],
    /// Probability of each star to be in the catalogue.
    probabilities: [f32; SEARCHED],
    /// The tolerance in force, and whether its sides are listed.
    step: usize,
    listed: bool,
    /// Whether any side could be tried.
    pub any_side: bool,
}

impl SearchOrder {
    pub const fn new() -> Self {
        Self { costs: [0; SIDES], probabilities: [0.0; SEARCHED], step: 0, listed: false, any_side: false }
    }

    /// Number of the tolerance in force; of the last one when all is done.
    pub fn step(&self) -> usize {
        self.step.min(TOLERANCES - 1)
    }

    /// The next base side, or `None` when all have been given. `capacity` bounds the directed catalogue pairs
    /// of a side.
    pub fn next(
        &mut self,
        field: &StarField,
        parameters: &IdentificationParameters,
        capacity: usize,
    ) -> Option<StarPair> {
        for _ in self.step..TOLERANCES {
            if !self.listed {
                self.list_sides(field, parameters, capacity);
                self.listed = true;
            }
            if let Some((i, j)) = self.take_best() {
                let star = |index: u8| field.measured().get(usize::from(index));
                self.any_side = true;
                return Some(StarPair {
                    i,
                    j,
                    side: parameters.side(self.step(), star(i)?, star(j)?, field.camera),
                });
            }
            self.step += 1;
            self.listed = false;
        }
        None
    }

    /// The untried side with the largest probability over cost, the first of equals; it is not given again.
    fn take_best(&mut self) -> Option<(u8, u8)> {
        let (mut best, mut most) = (None, 0.0);
        let mut costs = self.costs.iter_mut();
        for (j, b) in (0u8..).zip(&self.probabilities) {
            let before = (0u8..).zip(&self.probabilities).take(usize::from(j));
            for ((i, a), cost) in before.zip(&mut costs) {
                let worth = a * b / (CORNERS_COST + f32::from(*cost));
                if *cost > 0 && worth > most {
                    most = worth;
                    best = Some((i, j, cost));
                }
            }
        }
        best.map(|(i, j, cost)| {
            *cost = 0;
            (i, j)
        })
    }

    /// Updates the probabilities after a side has failed.
    pub fn update_after_failure(&mut self, pair: &StarPair) {
        let [i, j] = [pair.i, pair.j].map(usize::from);
        let (Some(a), Some(b)) = (self.probabilities.get(i).copied(), self.probabilities.get(j).copied())
        else {
            return;
        };
        // Never zero: no probability exceeds that of rank 0, 0.6.
        let rest = 1.0 - IDENTIFICATION_PROBABILITY * a * b;
        for (at, own, other) in [(i, a, b), (j, b, a)] {
            if let Some(chance) = self.probabilities.get_mut(at) {
                *chance = own * (1.0 - IDENTIFICATION_PROBABILITY * other) / rest;
            }
        }
    }

    /// The likeliest of the first `count` stars that `tried` has no bit of, the first of equals.
    pub fn likeliest(&self, count: usize, tried: u32) -> Option<u8> {
        let open = (0u8..).zip(&self.probabilities).take(count).filter(|(k, _)| (tried >> k) & 1 == 0);
        let best = open.fold(None, |best: Option<(u8, f32)>, (k, chance)| match best {
            Some((_, most)) if most >= *chance => best,
            _ => Some((k, *chance)),
        });
        best.map(|(k, _)| k)
    }

    /// Lists the base sides for the tolerance in force.
    fn list_sides(&mut self, field: &StarField, parameters: &IdentificationParameters, capacity: usize) {
        for (rank, chance) in (0u8..).zip(&mut self.probabilities) {
            *chance = prior_probability(rank);
        }
        self.costs = [0; SIDES];
        let mut costs = self.costs.iter_mut();
        for (j, b) in field.measured().iter().enumerate().take(SEARCHED) {
            for (a, cost) in field.measured().iter().take(j).zip(&mut costs) {
                let side = parameters.side(self.step.min(TOLERANCES - 1), a, b, field.camera);
                let pairs = field.catalogue.count_between(side.low(), side.high());
                let has_direction = side.chord >= 10.0 * side.tolerance;
                let usable = side.high() <= field.catalogue.max_chord()
                    && has_direction
                    && pairs > 0
                    && 2 * pairs <= capacity;
                if usable {
                    *cost = (pairs / PAIRS_PER_COST + 1).min(usize::from(u8::MAX)) as u8;
                }
            }
        }
    }
}

const _: () = assert!(SEARCHED <= u32::BITS as usize);

#[cfg(test)]
mod tests;
