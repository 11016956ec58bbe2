//! Counts the flight image's instructions and cycles, cycle by cycle, from outside the emulated processor.
//!
//! A plugin for QEMU 7.2 (TCG plugin interface, version 1), loaded by `-plugin
//! libcycle_meter.so,elf=IMAGE,out=FILE[,refill=P][,count=NAME+NAME]`. In: the image, for its code and the
//! addresses of the marks `cycle_begin`, `cycle_end`, `stage_begin`, `stage_end`, `STAGE_MARKS`,
//! `pause_begin` and `pause_end`, and of the functions to be counted, a name being `room::function`. Out: one
//! JSON file at exit ([`report`]): what every cycle, every stage and in it the counted functions took, pauses
//! left out, in instructions and in cycles of a model.
//!
//! # The model
//!
//! A Cortex-M4F with zero wait states, no interrupts and no caches, timed by Arm's Technical Reference Manual
//! (100166, table 3-1 and the FPU's table 7-1), see [`decode`] for the classes. Where the manual gives a
//! range or lets neighbours overlap, the slower is taken, but for the pipeline refill:
//!
//! - single loads and stores do not overlap with their neighbours: 2 cycles each, 1 + N for N registers;
//! - divisions take their longest, 12 cycles; an IT instruction is never folded;
//! - floating-point arithmetic whose result the next instruction wants takes one cycle longer;
//! - a branch that is taken refills the pipeline, P = 2 cycles. The manual says 1 to 3: 1 where the target is
//!   known early (immediate branches, most of all loops), 3 where a 32-bit target is unaligned as well. 2 is
//!   the middle; `refill=3` gives the bound. Taken means: what ran next was not what follows in memory.
//!
//! What a flash with wait states would add is counted beside the cycles, as `waits`: each line of 16 bytes of
//! code that is entered from another place, and each word that is loaded, as if it lay in flash. Cycles at W
//! wait states are at most `cycles + W waits`, without cache and prefetch, and whatever the lines' length
//! from 16 bytes on.
//!
//! # What it cannot see
//!
//! A taken branch to the very next instruction looks not taken. Work of the host (semihosting) takes no
//! target time. A branch out of a cycle other than through `cycle_end` leaves the cycle open; the report
//! counts such cycles.
//!
//! # Rooms
//!
//! [`decode`] knows what an instruction costs, [`image`] finds instructions and marks in the ELF, [`block`]
//! sums a block of straight code, [`count`] adds blocks up between marks, [`calls`] counts and times calls,
//! [`report`] writes the JSON, and `plugin` is the door to QEMU, which holds all `unsafe`.
#![deny(unsafe_code)]

pub mod block;
pub mod calls;
pub mod count;
pub mod decode;
pub mod image;
// The interface's functions exist in the emulator only: a test binary could not be linked with them.
#[cfg(not(test))]
pub mod plugin;
pub mod report;
