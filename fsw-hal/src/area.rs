//! Non-volatile memory of files that serve from one start to the next: catalogue, calibration, bad pixels.
//!
//! Of each area there are two copies. One serves: the sensor borrows it from its start on, and nothing writes
//! it. The spare one takes a new file, part by part; once it is whole and marked so, it serves from the next
//! start on. The memory is mapped into the address space, as the sensor borrows what is in it.

use crate::error::{self, Error, ErrorType};

/// What an area holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Area {
    /// The star catalogue.
    Catalogue,
    /// The lens calibration.
    Calibration,
    /// The detector's bad pixels and offsets of columns.
    BadPixels,
}

/// Why an area was not written or read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The part begins where no word of the memory begins.
    Alignment,
    /// It goes beyond the room of the area.
    Length,
    /// The memory did not answer in time.
    Timeout,
    /// The link to the memory reported an error, or what was written is not what is read.
    Bus,
}

impl error::ErrorKind for ErrorKind {}

/// The spare copies of the areas.
pub trait AreaStore: ErrorType<Error: Error<ErrorKind>> {
    /// The longest file that the area holds, bytes; 0 where there is no such area on board.
    fn room(&self, area: Area) -> usize;

    /// Writes a part of a file, `offset` bytes from its beginning. Parts come one behind the other; with that
    /// at 0 a new file begins, and whatever the spare copy held is lost.
    ///
    /// # Errors
    /// [`ErrorKind::Alignment`] and [`ErrorKind::Length`], and nothing was written; [`ErrorKind::Timeout`] or
    /// [`ErrorKind::Bus`] when the hardware fails, and the file is to begin anew.
    fn write(&mut self, area: Area, offset: usize, part: &[u8]) -> Result<(), Self::Error>;

    /// The first `length` bytes of the spare copy, as the memory holds them.
    ///
    /// # Errors
    /// [`ErrorKind::Length`]; [`ErrorKind::Timeout`] or [`ErrorKind::Bus`] when the hardware fails.
    fn written(&self, area: Area, length: usize) -> Result<&[u8], Self::Error>;

    /// Marks the spare copy, whose first `length` bytes have the CRC-32 (ISO-HDLC) `crc`, as whole: it serves
    /// from the next start on. Where power is lost before this returns, either copy serves then.
    ///
    /// # Errors
    /// [`ErrorKind::Length`]; [`ErrorKind::Timeout`] or [`ErrorKind::Bus`] when the hardware fails. The copy
    /// that serves goes on to do so.
    fn mark_whole(&mut self, area: Area, length: usize, crc: u32) -> Result<(), Self::Error>;
}

impl<S: AreaStore + ?Sized> AreaStore for &mut S {
    fn room(&self, area: Area) -> usize {
        S::room(self, area)
    }

    fn write(&mut self, area: Area, offset: usize, part: &[u8]) -> Result<(), Self::Error> {
        S::write(self, area, offset, part)
    }

    fn written(&self, area: Area, length: usize) -> Result<&[u8], Self::Error> {
        S::written(self, area, length)
    }

    fn mark_whole(&mut self, area: Area, length: usize, crc: u32) -> Result<(), Self::Error> {
        S::mark_whole(self, area, length, crc)
    }
}

/// None on board: no area has room.
impl AreaStore for () {
    fn room(&self, _: Area) -> usize {
        0
    }

    fn write(&mut self, _: Area, _: usize, _: &[u8]) -> Result<(), Self::Error> {
        Ok(())
    }

    fn written(&self, _: Area, _: usize) -> Result<&[u8], Self::Error> {
        Ok(&[])
    }

    fn mark_whole(&mut self, _: Area, _: usize, _: u32) -> Result<(), Self::Error> {
        Ok(())
    }
}
