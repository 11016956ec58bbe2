//! Layout of the onboard catalogue, version 3, little-endian, and its check.
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic `SXTC` |
//! | 4 | u16 | version |
//! | 6 | u16 | header length in bytes, 64 |
//! | 8 | u32 | CRC-32 (ISO-HDLC) of every byte from offset 12 on |
//! | 12 | u32 | total length in bytes |
//! | 16 | u32 | number of stars S, at most 65,535 |
//! | 20 | u32 | number of pair entries E |
//! | 24 | u32 | number of bins B |
//! | 28 | u32 | bin shift: bin of a chord = chord (Q2.30) >> shift |
//! | 32 | u32 | largest chord of a pair, Q2.30 |
//! | 36 | u32 | epoch of the directions, thousandths of a Julian year |
//! | 40 | i16 | faintest V in hundredths of a magnitude |
//! | 42 | i16 | brightest V in hundredths of a magnitude |
//! | 44 | u32 | field for which it was thinned, thousandths of a degree (the longer side) |
//! | 48 | u32 | CRC-32 of the star source it was built from |
//! | 52 | `[u8; 12]` | zero |
//! | 64 | S x 13 | stars, brightest first, see below |
//! | | (B + 1) x 2 or 4 | index of the first entry of each bin, the last is E: u16 where E < 65,536, else u32 |
//! | | ceil(E x W / 8) + 3 | pair entries of W bits, see below; then three bytes, so that each lies in a word |
//!
//! The pairs of a bin, first star < second, stand by rising first star, then by second. Entry k begins at bit
//! W k, lowest bit first: 9 bits the step of the first star from the entry before (from 0 at the begin of a
//! bin), then the index of the second star, 12 bits where S <= 4096, else 16. A step of 511 goes on by 511
//! and gives no pair. Of the reference catalogue's entries 2.8 % are such; its pairs take 100,000 bytes, with
//! two whole indices of 12 bits they would take 111,000.
//!
//! A star: x, y, z (three i24, Q1.23), then a u32: low 20 bits Hipparcos number, bit 20 proximity flag, top
//! 11 bits B-V in hundredths of a magnitude plus 512. Rounding to Q1.23 turns a direction by at most 0.021
//! arcsec (a unit of it is 0.025). Brightness is given only by the order of the file. Directions of 16 bits
//! a component would be 9,600 bytes less of the reference catalogue's 144,000, and wrong by up to 5 arcsec.
//!
//! A chord is `|r_i - r_j| = 2 sin(separation / 2)` of the fixed-point vectors: it needs no arc cosine and
//! loses no digits at small separations.

pub use crate::file::CRC_FROM;
use crate::file::{self, Refusal, u16_at, u32_at};
use crate::frames::{Direction, Icrs};
use core::fmt;
use core::ops::Range;
use nalgebra::Vector3;

/// First bytes of every catalogue.
pub const MAGIC: [u8; 4] = *b"SXTC";
/// The layout this code reads.
pub const VERSION: u16 = 3;
/// Length of the header in bytes.
pub const HEADER_BYTES: usize = 64;
/// Length of a star record in bytes.
pub const STAR_BYTES: usize = 13;
/// Least number of pair entries for which a bin's takes 4 bytes instead of 2.
pub const LONG_BINS: usize = 1 << 16;
/// Bits of a step within a pair's entry.
pub const STEP_BITS: u32 = 9;
/// Step of an entry without a pair: the largest.
pub const SKIP: u16 = (1 << STEP_BITS) - 1;
/// Bytes behind the last entry.
pub const ENTRIES_PADDING: usize = 3;
/// Unused low bits of a component in Q1.30: the file has 24 bits of it.
pub const UNUSED_BITS: u32 = 7;
/// Mask of the Hipparcos number within a star's last word.
pub const HIP_MASK: u32 = (1 << 20) - 1;
/// Flag of a star with a neighbour too close to be told apart on the detector (thesis §3.1.1).
pub const FLAG_PROXIMITY: u32 = 1 << 20;
/// Bit position of B-V in that word.
pub const COLOUR_SHIFT: u32 = 21;
/// Offset added to the hundredths of B-V there.
pub const COLOUR_OFFSET: i16 = 512;

/// Why catalogue bytes were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CatalogueError {
    /// Does not begin with the magic: not a Sextant catalogue.
    NotACatalogue,
    /// A layout this code does not read (the version found).
    Version(u16),
    /// Shorter or longer than its header says.
    Length,
    /// The checksum does not match: bytes were damaged.
    Checksum,
    /// The counts contradict each other or the bin table, or a star's direction is no unit vector.
    Structure,
}

impl fmt::Display for CatalogueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotACatalogue => {
                f.write_str("is not a Sextant catalogue; write one with `catalog-gen build`")
            }
            Self::Version(found) => write!(
                f,
                "has layout version {found}, this program reads {VERSION}; build it again with this program"
            ),
            Self::Length => f.write_str(
                "was cut or extended: its length is not the one it states; copy or build it again",
            ),
            Self::Checksum => f.write_str("is damaged: its checksum does not match; copy or build it again"),
            Self::Structure => {
                f.write_str("contradicts itself: its counts do not fit its length; build it again")
            }
        }
    }
}

impl core::error::Error for CatalogueError {}

impl From<Refusal> for CatalogueError {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Magic => Self::NotACatalogue,
            Refusal::Version(found) => Self::Version(found),
            Refusal::Length => Self::Length,
            Refusal::Checksum => Self::Checksum,
            Refusal::Header => Self::Structure,
        }
    }
}

/// A catalogue star.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Star {
    /// Unit vector, ICRS at the catalogue's epoch, Q1.30; its low [`UNUSED_BITS`] are zero.
    pub unit_q30: [i32; 3],
    /// Hipparcos number.
    pub hip: u32,
    /// A neighbour stands too close for an undisturbed centroid.
    pub proximity: bool,
    /// Colour index B-V, hundredths.
    pub colour_centi: i16,
}

impl Star {
    /// The direction without aberration, f32.
    pub fn direction(&self) -> Direction<Icrs> {
        Direction::from_q30(self.unit_q30)
    }
}

/// A pair of star indices, first < second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Index of the brighter star.
    pub first: u16,
    /// Index of the fainter star.
    pub second: u16,
}

/// Bits of a pair's entry in a catalogue of so many stars: the step and the second star's index.
pub const fn entry_bits(stars: usize) -> u32 {
    STEP_BITS + if stars <= 1 << 12 { 12 } else { 16 }
}

/// Bytes of so many pair entries, in a catalogue of so many stars; `None` where that is no number.
pub fn entries_bytes(entries: usize, stars: usize) -> Option<usize> {
    let bits = entries.checked_mul(entry_bits(stars) as usize)?;
    bits.div_ceil(8).checked_add(ENTRIES_PADDING)
}

/// Index of the first pair entry of each bin, in one of two widths; the other slice is empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bins<'a> {
    short: &'a [[u8; 2]],
    long: &'a [[u8; 4]],
}

impl<'a> Bins<'a> {
    /// The first `count` of `bytes`, short or long, and what follows them.
    fn split(bytes: &'a [u8], count: usize, short: bool) -> Option<(Self, &'a [u8])> {
        let width = if short { 2 } else { 4 };
        let (bins, rest) = bytes.split_at_checked(count.checked_mul(width)?)?;
        let (shorts, longs) = if short { (bins, &[][..]) } else { (&[][..], bins) };
        Some((Self { short: shorts.as_chunks().0, long: longs.as_chunks().0 }, rest))
    }

    pub fn len(&self) -> usize {
        self.short.len() + self.long.len()
    }

    pub fn first_of(&self, bin: usize) -> Option<usize> {
        let short = || self.short.get(bin).map(|entry| usize::from(u16::from_le_bytes(*entry)));
        short().or_else(|| self.long.get(bin).map(|entry| u32::from_le_bytes(*entry) as usize))
    }

    /// The pair entries of some bins.
    pub fn entries_of(&self, bins: Range<usize>) -> Range<usize> {
        let first_of = |bin| self.first_of(bin).unwrap_or(0);
        first_of(bins.start)..first_of(bins.end)
    }
}

/// A checked catalogue; borrows its bytes.
#[derive(Clone, Copy, Debug)]
pub struct Catalogue<'a> {
    pub(super) stars: &'a [[u8; STAR_BYTES]],
    pub(super) bins: Bins<'a>,
    /// Pair entries, and bits of each.
    pub(super) entries: (&'a [u8], u32),
    pub(super) bin_shift: u32,
    max_chord_q30: u32,
    epoch_milliyear: u32,
    magnitudes_centi: [i16; 2],
    field_millideg: u32,
    source_crc: u32,
    /// The bytes under the checksum, and it.
    protected: (&'a [u8], u32),
    /// Velocity of the observer over that of light, ICRS.
    pub(super) velocity: Vector3<f32>,
}

/// Largest deviation of the square of a star's vector from one: rounding is below 2e-7.
const UNIT_SQUARE: f32 = 1e-5;

impl<'a> Catalogue<'a> {
    /// Checks magic, version, length, checksum and structure, in this order.
    ///
    /// Cost: one pass over the bytes (CRC-32, table of 256 words); done once at power-on.
    ///
    /// # Errors
    /// The first check that fails, see [`CatalogueError`].
    pub fn open(bytes: &'a [u8]) -> Result<Self, CatalogueError> {
        let protected = file::check(bytes, MAGIC, VERSION, HEADER_BYTES)?;
        Self::parse(bytes, protected).ok_or(CatalogueError::Structure)
    }

    /// Splits checked bytes into their tables; `None` when the counts do not fit.
    fn parse(bytes: &'a [u8], protected: (&'a [u8], u32)) -> Option<Self> {
        let [stars, entries, bins] = [16, 20, 24].map(|offset| u32_at(bytes, offset));
        let (stars, entries, bins) = (stars? as usize, entries? as usize, bins? as usize);
        if stars > u16::MAX as usize {
            return None;
        }
        let rest = bytes.get(HEADER_BYTES..)?;
        let (star_bytes, rest) = rest.split_at_checked(stars.checked_mul(STAR_BYTES)?)?;
        let (bins, rest) = Bins::split(rest, bins.checked_add(1)?, entries < LONG_BINS)?;
        // A bin table that decreases or ends elsewhere would silently hide pairs.
        let firsts = || (0..bins.len()).map(|bin| bins.first_of(bin));
        let whole = rest.len() == entries_bytes(entries, stars)? && firsts().next_back()?? == entries;
        if !whole || !firsts().is_sorted() {
            return None;
        }
        let catalogue = Self {
            stars: star_bytes.as_chunks::<STAR_BYTES>().0,
            bins,
            entries: (rest, entry_bits(stars)),
            bin_shift: u32_at(bytes, 28).filter(|shift| *shift < 32)?,
            max_chord_q30: u32_at(bytes, 32)?,
            epoch_milliyear: u32_at(bytes, 36)?,
            magnitudes_centi: [u16_at(bytes, 42)? as i16, u16_at(bytes, 40)? as i16],
            field_millideg: u32_at(bytes, 44)?,
            source_crc: u32_at(bytes, 48)?,
            protected,
            velocity: Vector3::new(0.0, 0.0, 0.0),
        };
        let is_unit = |star: Star| (star.direction().vector().norm_squared() - 1.0).abs() < UNIT_SQUARE;
        catalogue.stars().all(is_unit).then_some(catalogue)
    }

    /// Number of stars.
    pub fn star_count(&self) -> usize {
        self.stars.len()
    }

    /// Largest chord `2 sin(separation / 2)` in the pair table.
    pub fn max_chord(&self) -> f32 {
        self.max_chord_q30 as f32 * (1.0 / (1u32 << 30) as f32)
    }

    /// Epoch of the directions, Julian year.
    pub fn epoch_year(&self) -> f32 {
        self.epoch_milliyear as f32 * 1e-3
    }

    /// V of the brightest and of the faintest star, hundredths of a magnitude.
    pub fn magnitudes_centi(&self) -> [i16; 2] {
        self.magnitudes_centi
    }

    /// Longer side of the field the catalogue was thinned for, thousandths of a degree.
    pub fn field_millideg(&self) -> u32 {
        self.field_millideg
    }

    /// CRC-32 of the star source the catalogue was built from.
    pub fn source_crc(&self) -> u32 {
        self.source_crc
    }

    /// The bytes under the checksum, and it.
    pub fn protected(&self) -> (&'a [u8], u32) {
        self.protected
    }
}

#[cfg(test)]
mod tests;
