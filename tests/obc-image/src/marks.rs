//! The marks between which an outside meter counts: the cycle, its stages, and pauses in which it does not
//! count.
//!
//! In: a stage's number, 0 to 31. Out: nothing; the marks exist to be seen from outside at their addresses,
//! so they are never inlined, never renamed and never merged, and their clobbers keep memory accesses from
//! moving across them.
//!
//! Two things make them visible to any meter. Each holds a debug hint of its own number (`dbg`, a
//! no-operation on this core), so no two bodies are alike and a linker that folds identical functions cannot
//! make one address of them. And because a QEMU plugin of version 1 sees addresses but no registers, a stage
//! mark reads the byte of [`STAGE_MARKS`] at the stage's number: the address it reads is the number.
//!
//! Cost: 5 instructions a cycle mark with its call, 10 a stage mark; the cycle meter counts only the call of
//! them.

use core::arch::asm;

/// Number of stages that can be told apart.
pub const STAGES: usize = 32;

/// Read by the stage marks, one byte a stage; the content means nothing, the address does.
#[unsafe(no_mangle)]
#[used]
pub static STAGE_MARKS: [u8; STAGES] = [0; STAGES];

/// Runs one cycle between its marks.
pub fn cycle<Report>(second: impl FnOnce() -> Report) -> Report {
    cycle_begin();
    let report = second();
    cycle_end();
    report
}

/// The cycle begins when this is entered.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn cycle_begin() {
    // SAFETY: a debug hint changes nothing.
    unsafe { asm!("dbg #0", options(nostack, preserves_flags)) };
}

/// The cycle ends when this is entered.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn cycle_end() {
    // SAFETY: a debug hint changes nothing.
    unsafe { asm!("dbg #1", options(nostack, preserves_flags)) };
}

/// Stage `stage` begins when this is entered; the number is in r0.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn stage_begin(stage: u32) {
    // SAFETY: a debug hint, and a byte read within `STAGE_MARKS`.
    unsafe {
        asm!("dbg #2", "ldrb {mark}, [{marks}, {stage}]", mark = out(reg) _, marks = in(reg) STAGE_MARKS.as_ptr(),
            stage = in(reg) stage % STAGES as u32, options(nostack, preserves_flags));
    }
}

/// Stage `stage` ends when this is entered; the number is in r0.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn stage_end(stage: u32) {
    // SAFETY: a debug hint, and a byte read within `STAGE_MARKS`.
    unsafe {
        asm!("dbg #3", "ldrb {mark}, [{marks}, {stage}]", mark = out(reg) _, marks = in(reg) STAGE_MARKS.as_ptr(),
            stage = in(reg) stage % STAGES as u32, options(nostack, preserves_flags));
    }
}

/// What follows is not the processor's work: the emulated detector, which a camera's direct memory access
/// replaces.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn pause_begin() {
    // SAFETY: a debug hint changes nothing.
    unsafe { asm!("dbg #4", options(nostack, preserves_flags)) };
}

/// The pause ends.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn pause_end() {
    // SAFETY: a debug hint changes nothing.
    unsafe { asm!("dbg #5", options(nostack, preserves_flags)) };
}
