//! Adds up the blocks that run, cycle by cycle and stage by stage.
//!
//! In: blocks in the order they run, and the stage numbers the stage marks read. Out: what ran before the
//! first cycle, and a [`Cycle`] for every cycle that ended.
//!
//! What runs in a pause is counted in `image_instructions` alone: the emulated detector's reading is not the
//! processor's work.
//!
//! What runs inside a mark's function is not counted, nor the refills of entering and leaving it: all a mark
//! adds to what it measures is its call, one instruction and one cycle (and for a stage what it takes to load
//! the number).

use crate::{
    block::{Block, Work, in_one_line},
    calls::{CallCounter, Calls},
    image::Mark,
};
use std::collections::BTreeMap;

/// A stage within a cycle; stages may nest, the outer one then contains the inner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stage {
    /// How often it ran.
    pub calls: u64,
    /// What all runs together took.
    pub work: Work,
}

/// A cycle that ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cycle {
    /// What it took.
    pub work: Work,
    /// Its stages by number.
    pub stages: BTreeMap<u64, Stage>,
    /// Calls of counted functions, by stage and the function's number.
    pub calls: BTreeMap<(u64, usize), Calls>,
}

/// A cycle that runs.
#[derive(Debug, Default)]
struct Running {
    cycle: Cycle,
    begun: BTreeMap<u64, Work>,
    calls: CallCounter,
}

/// The sums.
#[derive(Debug)]
pub struct Counter {
    refill_cycles: u64,
    start: Work,
    running: Option<Running>,
    paused: bool,
    previous: Option<Block>,
    cycles: Vec<Cycle>,
    image_instructions: u64,
    unfinished: u64,
    unknown_blocks: u64,
}

impl Counter {
    /// Nothing counted yet; a taken branch costs `refill_cycles` beyond its own.
    pub fn new(refill_cycles: u64) -> Self {
        Self {
            refill_cycles,
            start: Work::default(),
            running: None,
            paused: false,
            previous: None,
            cycles: Vec::new(),
            image_instructions: 0,
            unfinished: 0,
            unknown_blocks: 0,
        }
    }

    /// `block` runs.
    pub fn enter(&mut self, block: &Block) {
        self.image_instructions += block.work.instructions;
        match block.mark {
            Some((Mark::CycleBegin, true)) => self.begin(),
            Some((Mark::CycleEnd, true)) => self.end(),
            Some((Mark::PauseBegin, _)) => self.paused = true,
            Some((Mark::PauseEnd, _)) => self.paused = false,
            Some(_) => {}
            None if self.paused => {}
            None => {
                let joint = self.joint(block);
                // Straight on in a line that the block before has fetched already.
                let goes_on = self.previous.is_some_and(|previous| {
                    previous.mark.is_none()
                        && previous.next == block.start
                        && in_one_line(previous.next - 1, block.start)
                });
                let sum = match &mut self.running {
                    Some(running) => {
                        let stages: Vec<_> = running.begun.keys().copied().collect();
                        running.calls.enter(block, self.previous.as_ref(), &stages, running.cycle.work);
                        Some(&mut running.cycle.work)
                    }
                    None if self.cycles.is_empty() => Some(&mut self.start),
                    None => None,
                };
                if let Some(sum) = sum {
                    *sum = sum.plus(block.work);
                    sum.cycles += joint;
                    sum.waits -= u64::from(goes_on);
                }
            }
        }
        self.previous = Some(*block);
    }

    /// A block that is not in the image runs: its cost is unknown, and the report says so.
    pub fn enter_unknown(&mut self) {
        self.unknown_blocks += 1;
        self.previous = None;
    }

    /// Stage `stage` begins.
    pub fn stage_begin(&mut self, stage: u64) {
        if let Some(running) = &mut self.running {
            running.begun.insert(stage, running.cycle.work);
        }
    }

    /// Stage `stage` ends; an end without a beginning is no stage.
    pub fn stage_end(&mut self, stage: u64) {
        if let Some(running) = &mut self.running
            && let Some(begun) = running.begun.remove(&stage)
        {
            let total = running.cycle.stages.entry(stage).or_default();
            total.calls += 1;
            total.work = total.work.plus(running.cycle.work.since(begun));
        }
    }

    /// What ran before the first cycle began.
    pub fn start(&self) -> Work {
        self.start
    }

    /// Cycles that ended, in order.
    pub fn cycles(&self) -> &[Cycle] {
        &self.cycles
    }

    /// Number of the cycle that took most model cycles; the first of equals.
    pub fn worst(&self) -> Option<usize> {
        (0..self.cycles.len()).max_by_key(|index| (self.cycles[*index].work.cycles, usize::MAX - index))
    }

    /// Refill of a taken branch, cycles.
    pub fn refill_cycles(&self) -> u64 {
        self.refill_cycles
    }

    /// Instructions of the whole run, in cycles and outside them.
    pub fn image_instructions(&self) -> u64 {
        self.image_instructions
    }

    /// Cycles that began and did not end.
    pub fn unfinished(&self) -> u64 {
        self.unfinished + u64::from(self.running.is_some())
    }

    /// Passes through code that is not in the image.
    pub fn unknown_blocks(&self) -> u64 {
        self.unknown_blocks
    }

    /// What lies between the block before and `block`: a refill, a wait for a late result, or nothing.
    fn joint(&self, block: &Block) -> u64 {
        match &self.previous {
            Some(previous) if previous.mark.is_some() => 0,
            Some(previous) if previous.next == block.start => u64::from(block.first.wait_for(previous.last)),
            _ => self.refill_cycles,
        }
    }

    fn begin(&mut self) {
        let left_open = self.running.replace(Running::default());
        self.unfinished += u64::from(left_open.is_some());
    }

    fn end(&mut self) {
        if let Some(running) = self.running.take() {
            self.cycles.push(Cycle { calls: running.calls.finish(), ..running.cycle });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::Instruction;

    fn block(start: u64, instructions: u64, mark: Option<Mark>) -> Block {
        let nop = Instruction::new(0xbf00, 0);
        let work = Work { instructions, cycles: instructions, waits: 1 };
        Block {
            start,
            next: start + 2 * instructions,
            first: nop,
            last: nop,
            work,
            mark: mark.map(|mark| (mark, true)),
            counted: None,
        }
    }

    #[test]
    fn a_cycle_is_what_runs_between_its_marks() {
        let mut counter = Counter::new(2);
        let (before, body) = (block(0, 5, None), block(10, 3, None));
        counter.enter(&before);
        counter.enter(&block(100, 4, Some(Mark::CycleBegin)));
        counter.enter(&body);
        // A loop: 3 instructions and a refill each time.
        counter.enter(&body);
        counter.enter(&body);
        counter.enter(&block(16, 1, None));
        counter.enter(&block(200, 4, Some(Mark::CycleEnd)));
        counter.enter(&before);
        assert_eq!(counter.cycles().len(), 1);
        assert_eq!(counter.cycles()[0].work, Work { instructions: 10, cycles: 10 + 2 * 2, waits: 4 });
        // A refill after reset; what runs after the cycle is no start.
        assert_eq!(counter.start(), Work { instructions: 5, cycles: 5 + 2, waits: 1 });
        assert_eq!((counter.worst(), counter.unfinished(), counter.image_instructions()), (Some(0), 0, 28));
    }

    #[test]
    fn a_stage_sums_its_runs_and_leaves_its_marks_out() {
        let mut counter = Counter::new(2);
        let (begin, end) = (block(300, 9, Some(Mark::StageBegin)), block(400, 9, Some(Mark::StageEnd)));
        counter.enter(&block(100, 4, Some(Mark::CycleBegin)));
        for _ in 0..2 {
            counter.enter(&begin);
            counter.stage_begin(7);
            counter.enter(&block(10, 3, None));
            counter.enter(&end);
            counter.stage_end(7);
        }
        counter.stage_end(8);
        counter.enter(&block(200, 4, Some(Mark::CycleEnd)));
        let expected = Stage { calls: 2, work: Work { instructions: 6, cycles: 6, waits: 2 } };
        assert_eq!(counter.cycles()[0].stages, BTreeMap::from([(7, expected)]));
    }

    #[test]
    fn a_pause_counts_for_neither_cycle_nor_stage() {
        let mut counter = Counter::new(2);
        let body = block(10, 3, None);
        counter.enter(&block(100, 4, Some(Mark::CycleBegin)));
        counter.enter(&block(300, 9, Some(Mark::StageBegin)));
        counter.stage_begin(5);
        counter.enter(&body);
        counter.enter(&block(500, 2, Some(Mark::PauseBegin)));
        counter.enter(&body);
        counter.enter(&body);
        counter.enter(&block(600, 2, Some(Mark::PauseEnd)));
        counter.enter(&block(16, 1, None));
        counter.enter(&block(400, 9, Some(Mark::StageEnd)));
        counter.stage_end(5);
        counter.enter(&block(200, 4, Some(Mark::CycleEnd)));
        let cycle = &counter.cycles()[0];
        assert_eq!(cycle.work, Work { instructions: 4, cycles: 4, waits: 2 });
        assert_eq!(cycle.stages[&5].work, cycle.work);
    }

    #[test]
    fn a_cycle_left_open_is_reported_and_not_counted() {
        let mut counter = Counter::new(2);
        counter.enter(&block(100, 4, Some(Mark::CycleBegin)));
        counter.enter(&block(100, 4, Some(Mark::CycleBegin)));
        assert_eq!((counter.cycles().len(), counter.unfinished(), counter.worst()), (0, 2, None));
    }
}
