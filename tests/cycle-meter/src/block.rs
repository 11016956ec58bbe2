//! A block of straight code, as the emulator translates it: what it costs each time it runs.
//!
//! In: the addresses of its instructions. Out: their sum, and what is needed to join the block to its
//! neighbours.

use crate::{
    decode::Instruction,
    image::{Image, Mark},
};

/// An amount of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Instructions executed, conditional ones that did nothing included.
    pub instructions: u64,
    /// Cycles of the model.
    pub cycles: u64,
}

impl Work {
    /// Both together.
    pub fn plus(self, other: Self) -> Self {
        Self { instructions: self.instructions + other.instructions, cycles: self.cycles + other.cycles }
    }

    /// What was added since `earlier`.
    pub fn since(self, earlier: Self) -> Self {
        Self { instructions: self.instructions - earlier.instructions, cycles: self.cycles - earlier.cycles }
    }
}

/// Straight code: entered at its first instruction only, left after its last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Address of the first instruction.
    pub start: u64,
    /// Address of what follows the last one in memory.
    pub next: u64,
    /// First instruction.
    pub first: Instruction,
    /// Last instruction.
    pub last: Instruction,
    /// Cost of one pass, without a branch's refill.
    pub work: Work,
    /// The mark it belongs to, and whether it begins it.
    pub mark: Option<(Mark, bool)>,
}

impl Block {
    /// Sums the instructions at `addresses`; `None` when there are none or one is not in the image.
    pub fn new(image: &Image, addresses: impl IntoIterator<Item = u64>) -> Option<Self> {
        let mut addresses = addresses.into_iter();
        let start = addresses.next()?;
        let first = image.instruction(start)?;
        let mut work = Work { instructions: 1, cycles: u64::from(first.cycles()) };
        let (mut last, mut next) = (first, start + u64::from(first.length()));
        for address in addresses {
            let instruction = image.instruction(address)?;
            work.instructions += 1;
            work.cycles += u64::from(instruction.cycles() + instruction.wait_for(last));
            (last, next) = (instruction, address + u64::from(instruction.length()));
        }
        Some(Self { start, next, first, last, work, mark: image.mark(start) })
    }
}
