//! Which base sides are tried, and in what order.
//!
//! In: measured stars, brightest first where brightness is known. Out: one base side after another, for one tolerance
//! after another. Sides come in blocks: those among the 8 brightest first, then those that the next four stars bring,
//! and so on to [`BLOCKS`]' end; within a block the side with the fewest catalogue pairs leads, because it is the
//! cheapest and tells most. Left out are sides beyond the catalogue's range, sides too short to have a direction, and
//! those with more pairs than the workspace holds.

use super::Field;
use super::identify::{IdentificationParameters, TOLERANCES};
use super::triangles::Side;
use crate::order::settle_last;
use heapless::Vec;

/// Numbers of brightest stars after which blocks end.
pub const BLOCKS: [usize; 7] = [8, 12, 16, 20, 24, 28, 32];
/// Most base sides of one block: each of its last four stars with all before it.
pub const MAX_TASKS: usize = 28 + 29 + 30 + 31;
/// Most base sides of a whole search: all pairs of the last block's stars, for every tolerance.
pub const MAX_SIDES: usize = TOLERANCES * (32 * 31 / 2);

/// A base side to try.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Its stars, i before j.
    pub i: u8,
    pub j: u8,
    pub side: Side,
    /// Catalogue pairs of its separation.
    pairs: u16,
}

/// The order of work, one block ahead.
#[derive(Clone, Debug)]
pub(super) struct Agenda {
    tasks: Vec<Task, MAX_TASKS>,
    next: usize,
    /// The next block to list, and the tolerance of the tasks listed.
    block: usize,
    step: usize,
    /// Whether there ever was a side worth trying.
    pub any: bool,
}

impl Agenda {
    pub const fn new() -> Self {
        Self { tasks: Vec::new(), next: 0, block: 0, step: 0, any: false }
    }

    /// Number of the tolerance in force.
    pub fn step(&self) -> usize {
        self.step
    }

    /// The next base side, or `None` when all have been given. `capacity` bounds the directed catalogue pairs of a side.
    pub fn next(
        &mut self,
        field: &Field,
        parameters: &IdentificationParameters,
        capacity: usize,
    ) -> Option<Task> {
        // Every block of every tolerance may turn out empty.
        for _ in 0..=TOLERANCES * BLOCKS.len() {
            if let Some(task) = self.tasks.get(self.next) {
                self.next += 1;
                self.any = true;
                return Some(*task);
            }
            if self.block >= BLOCKS.len() {
                (self.block, self.step) = (0, self.step + 1);
            }
            if self.step >= TOLERANCES {
                // The step stays that of the last tolerance for those who ask.
                (self.block, self.step) = (BLOCKS.len(), TOLERANCES - 1);
                return None;
            }
            self.list(field, parameters, capacity);
            self.block += 1;
        }
        None
    }

    /// Lists the base sides of the present block.
    fn list(&mut self, field: &Field, parameters: &IdentificationParameters, capacity: usize) {
        let end_of = |block: usize| BLOCKS.get(block).copied().unwrap_or(0);
        let first = if self.block == 0 { 1 } else { end_of(self.block - 1) };
        self.tasks.clear();
        self.next = 0;
        for (j, b) in (0u8..).zip(field.measured()).take(end_of(self.block)).skip(first) {
            for (i, a) in (0u8..).zip(field.measured()).take(usize::from(j)) {
                let side = parameters.side(self.step, a, b, field.camera);
                let pairs = field.catalogue.count_between(side.low(), side.high());
                let has_direction = side.chord >= 10.0 * side.tolerance;
                if side.high() > field.catalogue.max_chord()
                    || !has_direction
                    || pairs == 0
                    || 2 * pairs > capacity
                {
                    continue;
                }
                // A block brings no more pairs of stars than there are places.
                let _ = self.tasks.push(Task { i, j, side, pairs: pairs as u16 });
                settle_last(&mut self.tasks, |a, b| a.pairs < b.pairs);
            }
        }
    }
}

#[cfg(test)]
mod tests;
