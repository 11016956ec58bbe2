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
    /// Lines of code entered and words loaded: each costs as many cycles more as the flash has wait states.
    pub waits: u64,
}

impl Work {
    /// Both together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            cycles: self.cycles + other.cycles,
            waits: self.waits + other.waits,
        }
    }

    /// What was added since `earlier`.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            instructions: self.instructions - earlier.instructions,
            cycles: self.cycles - earlier.cycles,
            waits: self.waits - earlier.waits,
        }
    }
}

/// Bytes of a line of flash.
const LINE: u64 = 16;

/// Whether code at two addresses lies in one line of flash.
pub fn in_one_line(one: u64, other: u64) -> bool {
    one / LINE == other / LINE
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
    /// The counted function that it begins.
    pub counted: Option<usize>,
}

impl Block {
    /// Sums the instructions at `addresses`; `None` when there are none or one is not in the image.
    pub fn new(image: &Image, addresses: impl IntoIterator<Item = u64>) -> Option<Self> {
        let mut addresses = addresses.into_iter();
        let start = addresses.next()?;
        let first = image.instruction(start)?;
        let mut work =
            Work { instructions: 1, cycles: u64::from(first.cycles()), waits: u64::from(first.loads()) };
        let (mut last, mut next) = (first, start + u64::from(first.length()));
        for address in addresses {
            let instruction = image.instruction(address)?;
            work.instructions += 1;
            work.cycles += u64::from(instruction.cycles() + instruction.wait_for(last));
            work.waits += u64::from(instruction.loads());
            (last, next) = (instruction, address + u64::from(instruction.length()));
        }
        work.waits += (next - 1) / LINE - start / LINE + 1;
        let (mark, counted) = (image.mark(start), image.counted(start));
        Some(Self { start, next, first, last, work, mark, counted })
    }
}
