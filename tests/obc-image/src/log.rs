//! Where defmt's frames go: a file of the host, named on the command line; without one they are dropped.
//!
//! In: encoded bytes from defmt. Out: the same bytes in the file, for `defmt-print -e IMAGE`. Standard output
//! stays free for the figures.
//!
//! Written here because `defmt-semihosting` 0.4 checks its lock by `panic!` and writes to standard output;
//! this logger has no panic path. A frame is gathered and written at once: a semihosting call a frame, not
//! one a byte.

use crate::host::File;
use core::cell::UnsafeCell;
use critical_section::RestoreState;
use heapless::Vec;

/// Longest frame that is written whole; a longer one is written in parts.
const FRAME_BYTES: usize = 128;

#[defmt::global_logger]
struct Logger;

struct State {
    restore: RestoreState,
    encoder: defmt::Encoder,
    file: Option<File>,
    frame: Vec<u8, FRAME_BYTES>,
}

struct Shared(UnsafeCell<State>);

// SAFETY: the state is touched only between `acquire` and `release`, within a critical section on a single
// core.
unsafe impl Sync for Shared {}

static STATE: Shared = Shared(UnsafeCell::new(State {
    restore: RestoreState::invalid(),
    encoder: defmt::Encoder::new(),
    file: None,
    frame: Vec::new(),
}));

/// Sends all further frames to `file`.
pub fn to(file: File) {
    critical_section::with(|_| {
        // SAFETY: within a critical section on a single core, and no defmt frame is open here.
        unsafe { (*STATE.0.get()).file = Some(file) };
    });
}

impl State {
    /// Writes what was gathered; the log has nobody to tell a failure to.
    fn flush(&mut self) {
        if let Some(file) = &mut self.file {
            let _ = file.write(&self.frame);
        }
        self.frame.clear();
    }
}

/// Adds encoded bytes to the frame, flushing when it is full.
fn gather(file: &mut Option<File>, frame: &mut Vec<u8, FRAME_BYTES>, bytes: &[u8]) {
    for byte in bytes {
        if frame.is_full() {
            if let Some(file) = file {
                let _ = file.write(frame);
            }
            frame.clear();
        }
        let _ = frame.push(*byte);
    }
}

// SAFETY: `acquire` opens a critical section that `release` closes, so frames never interleave; defmt pairs
// the calls.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: paired with `release`; the state is ours from here on.
        unsafe {
            let restore = critical_section::acquire();
            let state = &mut *STATE.0.get();
            state.restore = restore;
            let State { encoder, file, frame, .. } = state;
            encoder.start_frame(|bytes| gather(file, frame, bytes));
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: called after `acquire` only, so the state is ours until the critical section is left.
        unsafe {
            let state = &mut *STATE.0.get();
            let State { encoder, file, frame, .. } = state;
            encoder.end_frame(|bytes| gather(file, frame, bytes));
            state.flush();
            critical_section::release(state.restore);
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: called between `acquire` and `release` only.
        let State { encoder, file, frame, .. } = unsafe { &mut *STATE.0.get() };
        encoder.write(bytes, |encoded| gather(file, frame, encoded));
    }
}
