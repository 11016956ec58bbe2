//! NOR flash for tests: it obeys its rules and loses power where it is told to.

use crate::flash_areas::MappedFlash;
use embedded_storage::nor_flash::{
    self, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use std::vec::Vec;

pub(crate) const SECTOR: usize = 256;
pub(crate) const WORD: usize = 8;

/// The flash, and how many bytes it still erases or writes.
#[derive(Clone, Debug)]
pub(crate) struct Flash {
    pub(crate) bytes: Vec<u8>,
    /// Whether a byte was written since it was erased.
    pub(crate) written: Vec<bool>,
    /// Bytes that are still erased or written; then all fails.
    pub(crate) power: usize,
    /// What the byte is spoilt with at which power is lost.
    pub(crate) spoilt: u8,
}

impl Flash {
    /// As it comes from the maker: not erased.
    pub(crate) fn new(bytes: usize) -> Self {
        Self { bytes: std::vec![0x5A; bytes], written: std::vec![true; bytes], power: usize::MAX, spoilt: 0 }
    }

    fn change(&mut self, at: usize, value: u8, written: bool) -> Result<(), NorFlashErrorKind> {
        if self.power == 0 {
            return Err(NorFlashErrorKind::Other);
        }
        self.power -= 1;
        self.bytes[at] = if self.power == 0 { self.bytes[at] & self.spoilt } else { value };
        self.written[at] = written;
        Ok(())
    }

    /// Power is back.
    pub(crate) fn again(mut self) -> Self {
        self.power = usize::MAX;
        self
    }
}

impl nor_flash::ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        (from as usize..to as usize).try_for_each(|at| self.change(at, 0xFF, false))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        for (at, byte) in (offset as usize..).zip(bytes) {
            assert!(!self.written[at], "byte {at} is written twice");
            self.change(at, *byte, true)?;
        }
        Ok(())
    }
}

impl MappedFlash for Flash {
    fn mapped(&self) -> &[u8] {
        &self.bytes
    }
}
