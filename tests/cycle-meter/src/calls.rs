//! Calls of counted functions: how many, what they took, and the dearest.
//!
//! In: blocks in the order they run, and the work so far. Out: [`Calls`] of each function in each stage that
//! ran. A call ends where its caller goes on, so what the function calls is in it. One that is jumped to,
//! from the end of another function, is counted and not timed.

use crate::block::{Block, Work};
use std::collections::BTreeMap;

/// Calls of a function within a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calls {
    /// How many.
    pub calls: u64,
    /// What all together took.
    pub work: Work,
    /// What the dearest took.
    pub most: Work,
}

/// A call that runs.
#[derive(Clone, Copy, Debug)]
struct OpenCall {
    function: usize,
    /// Where its caller goes on.
    returns_to: u64,
    begun: Work,
}

/// The calls of a cycle that runs.
#[derive(Debug, Default)]
pub struct CallCounter {
    open: Vec<OpenCall>,
    counted: BTreeMap<(u64, usize), Calls>,
}

impl CallCounter {
    /// `block` is about to run after `previous`, within `stages`: a call may end, and one begin.
    pub fn enter(&mut self, block: &Block, previous: Option<&Block>, stages: &[u64], now: Work) {
        if let Some(call) = self.open.pop_if(|call| call.returns_to == block.start) {
            let took = now.since(call.begun);
            for stage in stages {
                let calls = self.counted.entry((*stage, call.function)).or_default();
                calls.work = calls.work.plus(took);
                if took.cycles > calls.most.cycles {
                    calls.most = took;
                }
            }
        }
        let Some(function) = block.counted else { return };
        for stage in stages {
            self.counted.entry((*stage, function)).or_default().calls += 1;
        }
        if let Some(caller) = previous.filter(|previous| previous.last.is_call()) {
            self.open.push(OpenCall { function, returns_to: caller.next, begun: now });
        }
    }

    /// All calls, by stage and the function's number.
    pub fn finish(self) -> BTreeMap<(u64, usize), Calls> {
        self.counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::Instruction;

    const NOP: Instruction = Instruction::new(0xbf00, 0);
    const CALL: Instruction = Instruction::new(0xf000, 0xf800);

    fn block(start: u64, last: Instruction, counted: Option<usize>) -> Block {
        Block { start, next: start + 4, first: NOP, last, work: Work::default(), mark: None, counted }
    }

    #[test]
    fn a_call_lasts_until_its_caller_goes_on_with_all_that_it_calls() {
        let (caller, function) = (block(0, CALL, None), block(100, CALL, Some(1)));
        let (inner, goes_on) = (block(200, NOP, Some(2)), block(104, NOP, None));
        let (after, jump) = (block(4, NOP, None), block(300, NOP, None));
        let mut counter = CallCounter::default();
        let mut previous = None;
        let run = [(&caller, 0), (&function, 1), (&inner, 3), (&goes_on, 10), (&after, 12)];
        let again = [(&caller, 20), (&function, 20), (&inner, 21), (&goes_on, 22), (&after, 40)];
        // A jump to it is no call that could be timed.
        let jumped = [(&jump, 50), (&inner, 51), (&after, 90)];
        for (block, cycles) in run.into_iter().chain(again).chain(jumped) {
            counter.enter(block, previous, &[7], Work { cycles, ..Work::default() });
            previous = Some(block);
        }
        let calls = |calls, sum, most| Calls {
            calls,
            work: Work { cycles: sum, ..Work::default() },
            most: Work { cycles: most, ..Work::default() },
        };
        let expected = [((7, 1), calls(2, 11 + 20, 20)), ((7, 2), calls(3, 7 + 1, 7))];
        assert_eq!(counter.finish(), BTreeMap::from(expected));
    }
}
