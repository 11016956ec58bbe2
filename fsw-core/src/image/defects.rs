//! What is known of a detector's defects: bad pixels and offsets of columns, version 1, little-endian, and
//! the door at which the table is checked. [`super::bad_pixels`] applies it.
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic `SXDF` |
//! | 4 | u16 | version |
//! | 6 | u16 | header length in bytes, 28 |
//! | 8 | u32 | CRC-32 (ISO-HDLC) of every byte from offset 12 on |
//! | 12 | u32 | total length in bytes |
//! | 16 | u16, u16 | columns and rows R of the detector, px |
//! | 20 | u16 | number of columns with an offset C |
//! | 22 | u16 | number of bad pixels P |
//! | 24 | u32 | zero |
//! | 28 | (R + 1) x 2 | u16: index of the first bad pixel of each row; the last entry is P |
//! | | P x 2 | u16: columns of the bad pixels, row by row, rising within a row |
//! | | C x 4 | (u16, i16): column, and what its pixels read too much, digital numbers; columns rising |
//!
//! Of 2,000 bad pixels on the reference detector the table has 6,078 bytes. The rows' index is shorter than a
//! row number with every bad pixel where there are more of them than rows, and a window costs no search
//! through the whole list.
//!
//! Offsets are the converter's own numbers, because they are taken off before the pixels are scaled: a scaled
//! count is less than a digital number of 10 bits and more than one of 16. Columns without an offset are not
//! listed and cost nothing. Rows have no offsets here: in an active-pixel detector those are new in every
//! readout (reset and supply noise), which no table knows; the local background follows them.

use crate::file::{self, Refusal, u16_at};
pub use crate::file::{CRC_FROM, LENGTH_FROM};
use fsw_hal::Window;

/// First bytes of every file.
pub const MAGIC: [u8; 4] = *b"SXDF";
/// The layout this code reads.
pub const VERSION: u16 = 1;
/// Length of the header in bytes.
pub const HEADER_BYTES: usize = 28;

/// Why bytes were refused, or a table for a detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefectsError {
    /// Does not begin with the magic: no such file.
    NotDefects,
    /// A layout this code does not read (the version found).
    Version(u16),
    /// Shorter or longer than its header says.
    Length,
    /// The checksum does not match: bytes were damaged.
    Checksum,
    /// The counts contradict each other.
    Structure,
    /// Pixels or columns are not in rising order, or named twice.
    Unsorted,
    /// A pixel or column lies outside the detector.
    Outside,
    /// The table is sound but of a detector of another size.
    OtherDetector,
}

impl From<Refusal> for DefectsError {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Magic => Self::NotDefects,
            Refusal::Version(found) => Self::Version(found),
            Refusal::Length => Self::Length,
            Refusal::Checksum => Self::Checksum,
            Refusal::Header => Self::Structure,
        }
    }
}

/// A number of the table.
type Word = [u8; 2];

/// A checked table; borrows its bytes.
#[derive(Clone, Copy, Debug)]
pub struct Defects<'a> {
    crc: u32,
    size_px: [u16; 2],
    row_starts: &'a [Word],
    pixels: &'a [Word],
    offsets: &'a [[u8; 4]],
}

/// Column and offset of an entry.
fn offset_of(&[a, b, c, d]: &[u8; 4]) -> (u16, i16) {
    (u16::from_le_bytes([a, b]), i16::from_le_bytes([c, d]))
}

/// Whether numbers rise from each to the next, and the last is below `end`.
fn check_rising(mut numbers: impl Iterator<Item = u16>, end: u16) -> Result<(), DefectsError> {
    let mut least = 0;
    numbers.try_for_each(|number| {
        if u32::from(number) < least {
            return Err(DefectsError::Unsorted);
        }
        least = u32::from(number) + 1;
        if number < end { Ok(()) } else { Err(DefectsError::Outside) }
    })
}

/// Columns from `x` on of those of a row.
fn from_column(words: &[Word], x: u16) -> impl Iterator<Item = u16> + use<'_> {
    let first = words.partition_point(|column| u16::from_le_bytes(*column) < x);
    words.get(first..).unwrap_or(&[]).iter().map(|column| u16::from_le_bytes(*column))
}

impl<'a> Defects<'a> {
    /// Of a detector without any.
    pub const fn none(size_px: [u16; 2]) -> Self {
        Self { crc: 0, size_px, row_starts: &[], pixels: &[], offsets: &[] }
    }

    /// Checks magic, version, length, checksum, structure, order and places, in this order.
    ///
    /// # Errors
    /// The first check that fails, see [`DefectsError`].
    pub fn open(bytes: &'a [u8]) -> Result<Self, DefectsError> {
        let (_, crc) = file::check(bytes, MAGIC, VERSION, HEADER_BYTES)?;
        let table = Self::split(bytes, crc).ok_or(DefectsError::Structure)?;
        table.check()?;
        Ok(table)
    }

    /// The three lists, which fill the file.
    fn split(bytes: &'a [u8], crc: u32) -> Option<Self> {
        let half = |offset| u16_at(bytes, offset);
        let size_px @ [_, rows] = [half(16)?, half(18)?];
        let (offsets, bad) = (half(20)?, half(22)?);
        let rest = bytes.get(HEADER_BYTES..)?;
        let (row_starts, rest) = rest.split_at_checked(2 * (usize::from(rows) + 1))?;
        let (pixels, rest) = rest.split_at_checked(2 * usize::from(bad))?;
        if rest.len() != 4 * usize::from(offsets) {
            return None;
        }
        let (row_starts, pixels) = (row_starts.as_chunks().0, pixels.as_chunks().0);
        Some(Self { crc, size_px, row_starts, pixels, offsets: rest.as_chunks().0 })
    }

    /// Whether the index covers all pixels, and everything is in order and on the detector.
    fn check(&self) -> Result<(), DefectsError> {
        let mut end = 0;
        for start in self.row_starts.iter().map(|start| u16::from_le_bytes(*start)) {
            if start < end {
                return Err(DefectsError::Structure);
            }
            end = start;
        }
        if self.row_starts.first() != Some(&[0; 2]) || usize::from(end) != self.pixels.len() {
            return Err(DefectsError::Structure);
        }
        let [columns, rows] = self.size_px;
        (0..rows).try_for_each(|y| check_rising(self.row(y), columns))?;
        check_rising(self.offsets.iter().map(|entry| offset_of(entry).0), columns)
    }

    /// CRC-32 of the file, by which it can be named.
    pub fn crc(&self) -> u32 {
        self.crc
    }

    /// Columns and rows of the detector it is for, px.
    pub fn size_px(&self) -> [u16; 2] {
        self.size_px
    }

    /// Number of bad pixels.
    pub fn pixel_count(&self) -> usize {
        self.pixels.len()
    }

    /// Columns with an offset, and that offset, digital numbers, from the left.
    pub fn offsets(&self) -> impl Iterator<Item = (u16, i16)> + use<'a> {
        self.offsets.iter().map(offset_of)
    }

    /// Columns of the bad pixels of a row, from the left.
    pub fn row(&self, y: u16) -> impl Iterator<Item = u16> + use<'a> {
        self.row_words(y).iter().map(|column| u16::from_le_bytes(*column))
    }

    fn row_words(&self, y: u16) -> &'a [Word] {
        let start =
            |y: usize| self.row_starts.get(y).map_or(0, |start| usize::from(u16::from_le_bytes(*start)));
        let (from, to) = (start(y.into()), start(usize::from(y) + 1));
        self.pixels.get(from..to).unwrap_or(&[])
    }

    /// Columns of the bad pixels of a row from column `x` on.
    pub(super) fn row_from(&self, x: u16, y: u16) -> impl Iterator<Item = u16> + use<'a> {
        from_column(self.row_words(y), x)
    }

    /// Where the bad pixels of a window's rows begin, and where those of its last end.
    fn starts(&self, window: Window) -> &'a [Word] {
        let from = usize::from(window.y);
        self.row_starts.get(from..=from + usize::from(window.height)).unwrap_or(&[])
    }

    /// Whether the rows of a window have no bad pixel, and no column an offset.
    pub(super) fn are_apart(&self, window: Window) -> bool {
        let starts = self.starts(window);
        self.offsets.is_empty() && starts.first() == starts.last()
    }

    /// The bad pixels of a window (column, row), row by row. A row without any costs a comparison.
    pub(super) fn within(&self, window: Window) -> impl Iterator<Item = [u16; 2]> + use<'a> {
        let (starts, pixels) = (self.starts(window), self.pixels);
        let rows = (window.y..).zip(starts.iter().zip(starts.get(1..).unwrap_or(&[])));
        rows.filter(|(_, (start, end))| start != end).flat_map(move |(y, (start, end))| {
            let place = |word: &Word| usize::from(u16::from_le_bytes(*word));
            let row = from_column(pixels.get(place(start)..place(end)).unwrap_or(&[]), window.x);
            let right = window.x.saturating_add(window.width);
            row.take_while(move |x| *x < right).map(move |x| [x, y])
        })
    }

    /// Columns with an offset from column `x` on.
    pub(super) fn offsets_from(&self, x: u16) -> impl Iterator<Item = (u16, i16)> + use<'a> {
        let first = self.offsets.partition_point(|entry| offset_of(entry).0 < x);
        self.offsets.get(first..).unwrap_or(&[]).iter().map(offset_of)
    }

    /// Whether a pixel is bad.
    pub fn is_bad(&self, x: u16, y: u16) -> bool {
        self.row_from(x, y).next() == Some(x)
    }
}

#[cfg(test)]
pub(crate) mod sample;
#[cfg(test)]
mod tests;
