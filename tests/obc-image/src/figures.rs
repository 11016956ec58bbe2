//! The figures of a run, one JSON object on one line of standard output.
//!
//! In: names and whole numbers. Out: `{"name":number,...}`. Digits are made here because `core::fmt` brings
//! panic paths and some kilobytes of flash that the flight image does not need.

use crate::host::{File, HostError, Mode};
use heapless::Vec;

/// Longest line, bytes.
const LINE_BYTES: usize = 512;
/// Digits of the largest u32.
const DIGITS: usize = 10;

/// A line under construction; what does not fit is left out whole.
#[derive(Debug, Default)]
pub struct Figures {
    line: Vec<u8, LINE_BYTES>,
}

impl Figures {
    /// Adds `"name":number`.
    pub fn number(mut self, name: &str, number: u32) -> Self {
        let opening: &[u8] = if self.line.is_empty() { b"{\"" } else { b",\"" };
        let mut digits = Vec::<u8, DIGITS>::new();
        let mut rest = number;
        loop {
            let _ = digits.push(b'0' + (rest % 10) as u8);
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        digits.reverse();
        let pieces = [opening, name.as_bytes(), b"\":", &digits];
        // Two bytes stay free for the end of the line.
        if self.line.len() + pieces.iter().map(|piece| piece.len()).sum::<usize>() + 2 <= LINE_BYTES {
            for piece in pieces {
                let _ = self.line.extend_from_slice(piece);
            }
        }
        self
    }

    /// Writes the line to standard output.
    ///
    /// # Errors
    /// [`HostError`] when the host refuses.
    pub fn print(mut self) -> Result<(), HostError> {
        let _ = self.line.extend_from_slice(b"}\n");
        File::open(b":tt", Mode::Write)?.write(&self.line)
    }
}
