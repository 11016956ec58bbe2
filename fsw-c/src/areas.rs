//! Memory of the files that are sent up, as C lends it: where the spare copies lie, and callbacks that write
//! them, behind the trait of `fsw-hal`.

use crate::doors::{Bytes, Extent, check, check_length};
use crate::instruments::Reply;
use crate::status::Status;
use core::ffi::c_void;
use fsw_hal::{Area as HalArea, AreaError, AreaStore};

/// What an area holds.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Area {
    /// The star catalogue.
    Catalogue = 0,
    /// The lens calibration.
    Calibration = 1,
    /// The detector's bad pixels and offsets of columns.
    BadPixels = 2,
}

/// Non-volatile memory of catalogue, calibration and bad pixels that are sent up by telecommand. Of each
/// there are two copies: the one that serves, which nothing writes, and a spare one, which serves from the
/// next start on once it was marked as whole. Those that serve are given to `sextant_init`. All zero where
/// there is none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Areas {
    /// Handed to both callbacks; may be null.
    pub context: *mut c_void,
    /// The spare copy of the catalogue, mapped into the address space; its length is the longest file.
    /// Length 0: no catalogue is taken.
    pub catalogue: Bytes,
    /// The same of the calibration.
    pub calibration: Bytes,
    /// The same of the bad pixels.
    pub bad_pixels: Bytes,
    /// Writes `length` bytes of a file to the spare copy of `area` (a `sextant_area`), `offset` bytes from
    /// its beginning. Parts come one behind the other; with that at 0 a new file begins and the mark of the
    /// one before is gone. Answers `OK`, `ALIGNMENT` where a part cannot begin there, `TIMEOUT` or `BUS`.
    pub write: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            area: u32,
            offset: usize,
            part: *const u8,
            length: usize,
        ) -> u32,
    >,
    /// Marks the spare copy of `area`, whose first `length` bytes have the CRC-32 (ISO-HDLC) `crc`, as whole.
    /// Answers `OK`, `TIMEOUT` or `BUS`.
    pub mark_whole:
        Option<unsafe extern "C" fn(context: *mut c_void, area: u32, length: usize, crc: u32) -> u32>,
}

impl Areas {
    fn copies(&self) -> [Bytes; 3] {
        [self.catalogue, self.calibration, self.bad_pixels]
    }

    /// The memory behind the trait of `fsw-hal`.
    ///
    /// # Errors
    /// [`Status::Null`], [`Status::Size`], and [`Status::Overlap`] where a copy lies in `used`.
    ///
    /// # Safety
    /// The copies are memory of these lengths and the callbacks are what their types and their documentation
    /// say, for as long as what is given is used.
    pub(crate) unsafe fn lend(self, used: Extent) -> Result<CAreas, Status> {
        for copy in self.copies().iter().filter(|copy| copy.length > 0) {
            check(copy.data)?;
            check_length(copy.data.addr(), copy.length)?;
            used.check_apart(Extent::of_bytes(copy.data, copy.length))?;
            if self.write.is_none() || self.mark_whole.is_none() {
                return Err(Status::Null);
            }
        }
        Ok(CAreas(self))
    }
}

/// The number of an area for C.
fn number(area: HalArea) -> u32 {
    let area = match area {
        HalArea::Catalogue => Area::Catalogue,
        HalArea::Calibration => Area::Calibration,
        HalArea::BadPixels => Area::BadPixels,
    };
    area as u32
}

/// What a callback's answer means.
fn area_reply(reply: u32) -> Result<(), AreaError> {
    const OK: u32 = Reply::Ok as u32;
    const TIMEOUT: u32 = Reply::Timeout as u32;
    const ALIGNMENT: u32 = Reply::Alignment as u32;
    match reply {
        OK => Ok(()),
        TIMEOUT => Err(AreaError::Timeout),
        ALIGNMENT => Err(AreaError::Alignment),
        _ => Err(AreaError::Bus),
    }
}

/// The memory that [`Areas::lend`] was told of.
pub(crate) struct CAreas(Areas);

impl CAreas {
    fn copy(&self, area: HalArea) -> Bytes {
        match area {
            HalArea::Catalogue => self.0.catalogue,
            HalArea::Calibration => self.0.calibration,
            HalArea::BadPixels => self.0.bad_pixels,
        }
    }
}

impl fsw_hal::ErrorType for CAreas {
    type Error = AreaError;
}

impl AreaStore for CAreas {
    fn room(&self, area: HalArea) -> usize {
        self.copy(area).length
    }

    fn write(&mut self, area: HalArea, offset: usize, part: &[u8]) -> Result<(), AreaError> {
        if offset.saturating_add(part.len()) > self.room(area) {
            return Err(AreaError::Length);
        }
        let write = self.0.write.ok_or(AreaError::Bus)?;
        // SAFETY: `lend` was told that the callbacks are what their types say; the part is read alone.
        area_reply(unsafe { write(self.0.context, number(area), offset, part.as_ptr(), part.len()) })
    }

    fn written(&self, area: HalArea, length: usize) -> Result<&[u8], AreaError> {
        let Bytes { data, length: room } = self.copy(area);
        let bytes = Bytes { data, length: (length <= room).then_some(length).ok_or(AreaError::Length)? };
        // SAFETY: `lend` was told that memory of the whole room is there; it changes in a callback alone,
        // none of which is called while the slice is borrowed.
        unsafe { bytes.slice() }.map_err(|_| AreaError::Length)
    }

    fn mark_whole(&mut self, area: HalArea, length: usize, crc: u32) -> Result<(), AreaError> {
        let mark_whole = self.0.mark_whole.ok_or(AreaError::Bus)?;
        // SAFETY: as in `write`.
        area_reply(unsafe { mark_whole(self.0.context, number(area), length, crc) })
    }
}
