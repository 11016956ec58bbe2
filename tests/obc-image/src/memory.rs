//! What the image takes of the on-board computer's memory.
//!
//! In: the linker's symbols and the stack as cortex-m-rt painted it before `main` (feature `paint-stack`).
//! Out: bytes of flash, of static RAM and of stack. Blind spot: a stack slot reserved but never written
//! leaves its paint on, so the mark is what was touched; the analysis of the machine code
//! (`tests/stack-depth`) covers what was not.

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _ram_start: u32;
    static _stack_end: u32;
    static _stack_start: u32;
    static __sdata: u32;
    static __edata: u32;
    static __sidata: u32;
    static _store_start: u8;
    static _store_end: u8;
}

/// The flash for what is sent up (`memory.x`).
pub fn store() -> &'static [u8] {
    let (start, end) = (&raw const _store_start, &raw const _store_end);
    // SAFETY: the linker's ends of memory that nothing writes while the image runs.
    unsafe { core::slice::from_raw_parts(start, (end as usize).wrapping_sub(start as usize)) }
}

/// Memory figures in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Flash: vectors, code, constants with the catalogue, and the initial values of `.data`.
    pub flash_bytes: u32,
    /// RAM that is taken from power-on: `.data`, `.bss` and `.uninit`.
    pub static_ram_bytes: u32,
    /// Deepest the stack has been since power-on.
    pub stack_bytes: u32,
    /// What the linker left for the stack.
    pub stack_room_bytes: u32,
}

/// Measures; the stack is what has been used up to now.
pub fn measure() -> Memory {
    let bottom = &raw const _stack_end;
    let top = &raw const _stack_start;
    let data_bytes = distance(&raw const __sdata, &raw const __edata);
    Memory {
        // Flash begins at address 0 and `.data` is the last thing in it (memory.x, link.x).
        flash_bytes: (&raw const __sidata as u32).wrapping_add(data_bytes),
        static_ram_bytes: distance(&raw const _ram_start, bottom),
        stack_bytes: distance(deepest(bottom, top), top),
        stack_room_bytes: distance(bottom, top),
    }
}

/// Bytes from one address up to another.
fn distance(from: *const u32, to: *const u32) -> u32 {
    (to as u32).wrapping_sub(from as u32)
}

/// The lowest word that no longer holds the paint.
fn deepest(bottom: *const u32, top: *const u32) -> *const u32 {
    let mut word = bottom;
    // SAFETY: every word read lies between the linker's ends of the stack, which are aligned and in RAM; the
    // read is volatile because the words below the stack pointer belong to no object the compiler knows.
    while word < top && unsafe { word.read_volatile() } == STACK_PAINT_VALUE {
        word = word.wrapping_add(1);
    }
    word
}
