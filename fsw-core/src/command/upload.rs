//! A parameter table on its way up: parts are collected until the table is whole.
//!
//! In: parts, each where the last one ended. Out: the bytes, once their number and their CRC-32 are those
//! that the command to load them names.

use super::refusal::Refusal;
use crate::checksum::crc32;
use crate::parameters::MAX_TABLE_BYTES;

/// The parts so far.
#[derive(Clone, Debug)]
pub(super) struct Upload {
    buffer: [u8; MAX_TABLE_BYTES],
    length: usize,
}

impl Upload {
    pub(super) const fn new() -> Self {
        Self { buffer: [0; MAX_TABLE_BYTES], length: 0 }
    }

    /// Takes a part.
    ///
    /// # Errors
    /// [`Refusal::Part`]: the parts so far stay.
    pub(super) fn add(&mut self, offset: u16, bytes: &[u8]) -> Result<(), Refusal> {
        let offset = usize::from(offset);
        if bytes.is_empty() || (offset != 0 && offset != self.length) {
            return Err(Refusal::Part);
        }
        let end = offset.saturating_add(bytes.len());
        self.buffer.get_mut(offset..end).ok_or(Refusal::Part)?.copy_from_slice(bytes);
        self.length = end;
        Ok(())
    }

    /// Checks that the parts are the whole table.
    ///
    /// # Errors
    /// [`Refusal::Incomplete`], [`Refusal::TableChecksum`].
    pub(super) fn check(&self, length: u16, crc: u32) -> Result<(), Refusal> {
        if self.length != usize::from(length) {
            return Err(Refusal::Incomplete);
        }
        if crc32(self.bytes()) != crc {
            return Err(Refusal::TableChecksum);
        }
        Ok(())
    }

    /// The parts so far.
    pub(super) fn bytes(&self) -> &[u8] {
        self.buffer.get(..self.length).unwrap_or(&[])
    }
}
