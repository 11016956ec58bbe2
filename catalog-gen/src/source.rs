//! The star source: every Hipparcos star to V 8.0 in 20 bytes, and where such a star stands in a given year.
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic `SXTS` |
//! | 4 | u16 | version 1 |
//! | 6 | u16 | bytes a star, 20 |
//! | 8 | u32 | number of stars |
//! | 12 | u32 | CRC-32 (ISO-HDLC) of every byte from offset 16 on |
//! | 16 | n x 20 | stars by rising Hipparcos number, little-endian: Hipparcos number (u32), right ascension (u32) and declination (i32) in 2^-32 of a turn, proper motion in right ascension (times the cosine of the declination) and in declination (i16, 0.25 mas a year), V and B-V (i16, thousandths of a magnitude) |
//!
//! Frame ICRS, epoch J1991.25. Rounding: 0.15 mas in position, 0.125 mas a year in motion (4.4 mas in 35
//! years), far below the 0.1 arcsec that matters to a 4 arcsec sensor.

use fsw_core::checksum::crc32;
use thiserror::Error;

/// Epoch of the positions, Julian year.
pub const EPOCH_YEAR: f64 = 1991.25;
/// Faintest V in the source.
pub const FAINTEST_V: f64 = 8.0;
/// CRC-32 of the embedded source (of its star records), as stored in every catalogue built from it.
pub const EMBEDDED_CRC: u32 = 0xd140_2113;

const MAGIC: [u8; 4] = *b"SXTS";
const VERSION: u16 = 1;
const HEADER_BYTES: usize = 16;
const STAR_BYTES: usize = 20;
/// Degrees in the unit of the positions: 360 / 2^32, exact in f64.
const TURN_UNIT_DEG: f64 = 360.0 / 4_294_967_296.0;
const MOTION_UNIT_MAS_YR: f64 = 0.25;
const MAGNITUDE_UNIT: f64 = 1000.0;
const MAS_PER_RAD: f64 = 648_000_000.0 / core::f64::consts::PI;

static EMBEDDED: &[u8] = include_bytes!("../data/hipparcos-v8.bin");

/// Why a star source was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SourceError {
    /// Magic, version or record length are not those of a star source.
    #[error("not a star source of version 1; write it with `catalog-gen source`")]
    NotASource,
    /// The length does not fit the number of stars.
    #[error("its length does not fit its number of stars; it was cut or extended, write it again")]
    Length,
    /// The checksum does not match.
    #[error("its checksum does not match; bytes were damaged, write it again")]
    Checksum,
}

/// A star of the source: ICRS at J1991.25.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceStar {
    /// Hipparcos number.
    pub hip: u32,
    /// Right ascension, degrees, 0 to 360.
    pub ra_deg: f64,
    /// Declination, degrees.
    pub dec_deg: f64,
    /// Proper motion in right ascension times the cosine of the declination, mas a year.
    pub pm_ra_mas_yr: f64,
    /// Proper motion in declination, mas a year.
    pub pm_dec_mas_yr: f64,
    /// Visual magnitude V.
    pub v: f64,
    /// Colour index B-V.
    pub b_v: f64,
}

impl SourceStar {
    /// The unit vector in ICRS, seen from the Sun, at `epoch_year` (Julian year).
    ///
    /// The star moves on a straight line in space, `r(t) = r0 + t (mu_alpha p + mu_delta q)`, normalised,
    /// where p and q point to growing right ascension and declination (Hipparcos, vol. 1, §1.5.5, without the
    /// terms of parallax and radial velocity). What is left out: parallax (0.3 arcsec for the nearest star
    /// below V 8) and perspective acceleration (below 0.1 arcsec in 50 years for all but a handful of stars).
    pub fn direction_at(&self, epoch_year: f64) -> [f64; 3] {
        let (sin_ra, cos_ra) = libm::sincos(self.ra_deg.to_radians());
        let (sin_dec, cos_dec) = libm::sincos(self.dec_deg.to_radians());
        let years = epoch_year - EPOCH_YEAR;
        let along_ra = self.pm_ra_mas_yr * years / MAS_PER_RAD;
        let along_dec = self.pm_dec_mas_yr * years / MAS_PER_RAD;
        normalised([
            cos_dec * cos_ra - along_ra * sin_ra - along_dec * sin_dec * cos_ra,
            cos_dec * sin_ra + along_ra * cos_ra - along_dec * sin_dec * sin_ra,
            sin_dec + along_dec * cos_dec,
        ])
    }

    fn to_record(self) -> [u8; STAR_BYTES] {
        let turn = |degrees: f64| (degrees / TURN_UNIT_DEG).round() as i64;
        let small = |value: f64, unit: f64| (value * unit).round() as i16;
        let mut record = [0; STAR_BYTES];
        record[0..4].copy_from_slice(&self.hip.to_le_bytes());
        // A right ascension that rounds up to a full turn wraps to zero, as it should.
        record[4..8].copy_from_slice(&(turn(self.ra_deg) as u32).to_le_bytes());
        record[8..12].copy_from_slice(&(turn(self.dec_deg) as i32).to_le_bytes());
        let motion = |mas_yr| small(mas_yr, 1.0 / MOTION_UNIT_MAS_YR);
        record[12..14].copy_from_slice(&motion(self.pm_ra_mas_yr).to_le_bytes());
        record[14..16].copy_from_slice(&motion(self.pm_dec_mas_yr).to_le_bytes());
        record[16..18].copy_from_slice(&small(self.v, MAGNITUDE_UNIT).to_le_bytes());
        record[18..20].copy_from_slice(&small(self.b_v, MAGNITUDE_UNIT).to_le_bytes());
        record
    }

    fn from_record(record: &[u8; STAR_BYTES]) -> Self {
        let [h0, h1, h2, h3, r0, r1, r2, r3, d0, d1, d2, d3, a0, a1, e0, e1, v0, v1, c0, c1] = *record;
        let small = |low, high| f64::from(i16::from_le_bytes([low, high]));
        Self {
            hip: u32::from_le_bytes([h0, h1, h2, h3]),
            ra_deg: f64::from(u32::from_le_bytes([r0, r1, r2, r3])) * TURN_UNIT_DEG,
            dec_deg: f64::from(i32::from_le_bytes([d0, d1, d2, d3])) * TURN_UNIT_DEG,
            pm_ra_mas_yr: small(a0, a1) * MOTION_UNIT_MAS_YR,
            pm_dec_mas_yr: small(e0, e1) * MOTION_UNIT_MAS_YR,
            v: small(v0, v1) / MAGNITUDE_UNIT,
            b_v: small(c0, c1) / MAGNITUDE_UNIT,
        }
    }
}

/// The vector divided by its length.
pub(crate) fn normalised([x, y, z]: [f64; 3]) -> [f64; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// The stars of the embedded source, by rising Hipparcos number.
///
/// # Panics
/// Never: the embedded bytes are checked by this crate's tests.
pub fn stars() -> Vec<SourceStar> {
    decode(EMBEDDED).expect("the embedded star source is intact")
}

/// The embedded source as it lies in `data/`.
pub fn embedded() -> &'static [u8] {
    EMBEDDED
}

/// Reads a star source.
///
/// # Errors
/// When it is no star source, or damaged.
pub fn decode(bytes: &[u8]) -> Result<Vec<SourceStar>, SourceError> {
    let head = bytes.first_chunk::<HEADER_BYTES>().ok_or(SourceError::NotASource)?;
    let [m0, m1, m2, m3, v0, v1, l0, l1, n0, n1, n2, n3, c0, c1, c2, c3] = *head;
    let layout = (u16::from_le_bytes([v0, v1]), usize::from(u16::from_le_bytes([l0, l1])));
    if [m0, m1, m2, m3] != MAGIC || layout != (VERSION, STAR_BYTES) {
        return Err(SourceError::NotASource);
    }
    let (records, rest) = bytes[HEADER_BYTES..].as_chunks::<STAR_BYTES>();
    if records.len() != u32::from_le_bytes([n0, n1, n2, n3]) as usize || !rest.is_empty() {
        return Err(SourceError::Length);
    }
    if crc32(&bytes[HEADER_BYTES..]) != u32::from_le_bytes([c0, c1, c2, c3]) {
        return Err(SourceError::Checksum);
    }
    Ok(records.iter().map(SourceStar::from_record).collect())
}

/// Writes a star source; decoding it gives the same stars, rounded to the units above.
pub fn encode(stars: &[SourceStar]) -> Vec<u8> {
    let records = records(stars);
    let mut bytes = Vec::with_capacity(HEADER_BYTES + records.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(STAR_BYTES as u16).to_le_bytes());
    bytes.extend_from_slice(&(stars.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&crc32(&records).to_le_bytes());
    bytes.extend_from_slice(&records);
    bytes
}

/// CRC-32 of the stars as they would be written; a catalogue carries it to say what it was made from.
pub fn checksum(stars: &[SourceStar]) -> u32 {
    crc32(&records(stars))
}

fn records(stars: &[SourceStar]) -> Vec<u8> {
    stars.iter().flat_map(|star| star.to_record()).collect()
}
