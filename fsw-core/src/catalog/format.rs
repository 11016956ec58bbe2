//! Layout of the onboard catalogue, version 1, little-endian, and the door at which it is checked.
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic `SXTC` |
//! | 4 | u16 | version |
//! | 6 | u16 | header length in bytes, 64 |
//! | 8 | u32 | CRC-32 (ISO-HDLC) of every byte from offset 12 on |
//! | 12 | u32 | total length in bytes |
//! | 16 | u32 | number of stars S |
//! | 20 | u32 | number of pairs P |
//! | 24 | u32 | number of bins B |
//! | 28 | u32 | bin shift: bin of a chord = chord (Q2.30) >> shift |
//! | 32 | u32 | largest chord of a pair, Q2.30 |
//! | 36 | u32 | epoch of the directions, thousandths of a Julian year |
//! | 40 | i16 | faintest V in hundredths of a magnitude |
//! | 42 | u16 | zero |
//! | 44 | u32 | field for which it was thinned, thousandths of a degree (the longer side) |
//! | 48 | u32 | CRC-32 of the star source it was built from |
//! | 52 | `[u8; 12]` | zero |
//! | 64 | S x 20 | stars, brightest first: x, y, z (i32, Q1.30), id (u32: low 24 bits Hipparcos number, top 8 bits flags, bit 24 = proximity), V (i16, hundredths), B-V (i16, hundredths) |
//! | | (B + 1) x 4 | u32: index of the first pair of each bin; the last entry is P |
//! | | P x 4 | pairs (u16, u16) of star indices, first < second, by rising chord |
//!
//! A chord is `|r_i - r_j| = 2 sin(separation / 2)` of the fixed-point vectors: it needs no arc cosine and loses no
//! digits at small separations.

use crate::checksum::crc32;
use crate::frames::{Direction, Icrs};
use nalgebra::Vector3;

/// First bytes of every catalogue.
pub const MAGIC: [u8; 4] = *b"SXTC";
/// The layout this code reads.
pub const VERSION: u16 = 1;
/// Length of the header in bytes.
pub const HEADER_BYTES: usize = 64;
/// Length of a star record in bytes.
pub const STAR_BYTES: usize = 20;
/// Length of a pair record and of a bin entry in bytes.
pub const PAIR_BYTES: usize = 4;
/// Where the CRC-protected part begins.
pub const CRC_FROM: usize = 12;
/// Flag of a star with a neighbour too close to be told apart on the detector (thesis §3.1.1).
pub const FLAG_PROXIMITY: u32 = 1 << 24;
/// Mask of the Hipparcos number within the id word.
pub const HIP_MASK: u32 = (1 << 24) - 1;

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

/// A catalogue star.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Star {
    /// Unit vector, ICRS at the catalogue's epoch, Q1.30.
    pub unit_q30: [i32; 3],
    /// Hipparcos number.
    pub hip: u32,
    /// A neighbour stands too close for an undisturbed centroid.
    pub proximity: bool,
    /// Visual magnitude V, hundredths.
    pub magnitude_centi: i16,
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

/// A checked catalogue; borrows its bytes.
#[derive(Clone, Copy, Debug)]
pub struct Catalogue<'a> {
    pub(super) stars: &'a [[u8; STAR_BYTES]],
    pub(super) bins: &'a [[u8; PAIR_BYTES]],
    pub(super) pairs: &'a [[u8; PAIR_BYTES]],
    pub(super) bin_shift: u32,
    max_chord_q30: u32,
    epoch_milliyear: u32,
    faintest_centi: i16,
    field_millideg: u32,
    source_crc: u32,
    /// Velocity of the observer over that of light, ICRS.
    pub(super) velocity: Vector3<f32>,
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    bytes.get(offset..)?.first_chunk::<4>().map(|word| u32::from_le_bytes(*word))
}

fn u16_at(bytes: &[u8], offset: usize) -> Option<u16> {
    bytes.get(offset..)?.first_chunk::<2>().map(|word| u16::from_le_bytes(*word))
}

/// By so much the square of a star's vector may differ from one: rounding is below 1e-8.
const UNIT_SQUARE: f32 = 1e-5;

impl<'a> Catalogue<'a> {
    /// Checks magic, version, length, checksum and structure, in this order.
    ///
    /// Cost: one pass over the bytes (CRC-32, table of 256 words); done once at power-on.
    ///
    /// # Errors
    /// The first check that fails, see [`CatalogueError`].
    pub fn open(bytes: &'a [u8]) -> Result<Self, CatalogueError> {
        if !bytes.starts_with(&MAGIC) {
            return Err(CatalogueError::NotACatalogue);
        }
        let version = u16_at(bytes, 4).ok_or(CatalogueError::Length)?;
        if version != VERSION {
            return Err(CatalogueError::Version(version));
        }
        let word = |offset| u32_at(bytes, offset).ok_or(CatalogueError::Length);
        if bytes.len() < HEADER_BYTES || word(12)? as usize != bytes.len() {
            return Err(CatalogueError::Length);
        }
        let protected = bytes.get(CRC_FROM..).ok_or(CatalogueError::Length)?;
        if crc32(protected) != word(8)? {
            return Err(CatalogueError::Checksum);
        }
        Self::parse(bytes).ok_or(CatalogueError::Structure)
    }

    /// Splits checked bytes into their tables; `None` when the counts do not fit.
    fn parse(bytes: &'a [u8]) -> Option<Self> {
        let [stars, pairs, bins] = [16, 20, 24].map(|offset| u32_at(bytes, offset));
        let (stars, pairs, bins) = (stars? as usize, pairs? as usize, bins? as usize);
        if stars > u16::MAX as usize || u16_at(bytes, 6)? as usize != HEADER_BYTES {
            return None;
        }
        let rest = bytes.get(HEADER_BYTES..)?;
        let (star_bytes, rest) = rest.split_at_checked(stars.checked_mul(STAR_BYTES)?)?;
        let (bin_bytes, pair_bytes) = rest.split_at_checked(bins.checked_add(1)?.checked_mul(PAIR_BYTES)?)?;
        if pair_bytes.len() != pairs.checked_mul(PAIR_BYTES)? {
            return None;
        }
        let bins = bin_bytes.as_chunks::<PAIR_BYTES>().0;
        // A bin table that goes back or ends elsewhere would hide pairs without a word.
        let firsts = bins.iter().map(|entry| u32::from_le_bytes(*entry));
        let last = firsts.clone().next_back()?;
        if last as usize != pairs || !firsts.is_sorted() {
            return None;
        }
        let catalogue = Self {
            stars: star_bytes.as_chunks::<STAR_BYTES>().0,
            bins,
            pairs: pair_bytes.as_chunks::<PAIR_BYTES>().0,
            bin_shift: u32_at(bytes, 28).filter(|shift| *shift < 32)?,
            max_chord_q30: u32_at(bytes, 32)?,
            epoch_milliyear: u32_at(bytes, 36)?,
            faintest_centi: u16_at(bytes, 40)? as i16,
            field_millideg: u32_at(bytes, 44)?,
            source_crc: u32_at(bytes, 48)?,
            velocity: Vector3::new(0.0, 0.0, 0.0),
        };
        let is_unit = |star: Star| (star.direction().vector().norm_squared() - 1.0).abs() < UNIT_SQUARE;
        catalogue.stars().all(is_unit).then_some(catalogue)
    }

    /// Number of stars.
    pub fn star_count(&self) -> usize {
        self.stars.len()
    }

    /// Number of pairs.
    pub fn pair_count(&self) -> usize {
        self.pairs.len()
    }

    /// Largest chord `2 sin(separation / 2)` in the pair table.
    pub fn max_chord(&self) -> f32 {
        self.max_chord_q30 as f32 * (1.0 / (1u32 << 30) as f32)
    }

    /// Epoch of the directions, Julian year.
    pub fn epoch_year(&self) -> f32 {
        self.epoch_milliyear as f32 * 1e-3
    }

    /// Faintest V kept, hundredths of a magnitude.
    pub fn faintest_centi(&self) -> i16 {
        self.faintest_centi
    }

    /// Longer side of the field the catalogue was thinned for, thousandths of a degree.
    pub fn field_millideg(&self) -> u32 {
        self.field_millideg
    }

    /// CRC-32 of the star source the catalogue was built from.
    pub fn source_crc(&self) -> u32 {
        self.source_crc
    }
}

#[cfg(test)]
mod tests;
