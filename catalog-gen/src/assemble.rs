//! Chosen stars in, the bytes of an onboard catalogue out: the writer to the reader `fsw_core::catalog`.
//!
//! Directions are rounded to Q1.23 first and the chords computed from the rounded integers, exactly as the
//! reader defines them: `chord = floor(sqrt(dx^2 + dy^2 + dz^2))` in Q2.30. Pairs are sorted by bin of the
//! chord, then by the stars' indices. The bin table has the finest power of two that gives at most 2048 bins
//! (25 arcsec for 12 degrees).

use crate::blend::centi;
use crate::grid::CellGrid;
use crate::parameters::{BuildError, MAX_PAIRS, chord};
use fsw_core::catalog::format::{
    COLOUR_OFFSET, COLOUR_SHIFT, CRC_FROM, FLAG_PROXIMITY, HEADER_BYTES, HIP_MASK, LONG_BINS, MAGIC, SKIP,
    STAR_BYTES, STEP_BITS, UNUSED_BITS, VERSION, entries_bytes, entry_bits,
};
use fsw_core::checksum::crc32;

/// 1.0 in Q2.30.
const ONE_Q30: f64 = (1u32 << 30) as f64;
/// 1.0 in Q1.23, one more than fits.
const ONE_Q23: f64 = (1u32 << (30 - UNUSED_BITS)) as f64;
/// Most bins in the table: 4 KB of flash where there are fewer than 65,536 entries. Half as many pairs a bin
/// would save the flight code next to nothing.
const MAX_BINS: u32 = 2048;

/// A star to be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueStar {
    /// Unit vector, ICRS at the catalogue's epoch.
    pub direction: [f64; 3],
    /// Hipparcos number (any number below 2^20).
    pub hip: u32,
    /// Visual magnitude V.
    pub v: f64,
    /// Colour index B-V.
    pub b_v: f64,
    /// A neighbour stands too close for an undisturbed centroid.
    pub proximity: bool,
}

/// What a catalogue says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableParameters {
    /// Longest separation in the pair table, degrees.
    pub max_separation_deg: f64,
    /// Epoch of the directions, Julian year.
    pub epoch_year: f64,
    /// Longer side of the field it is meant for, degrees.
    pub field_deg: f64,
    /// CRC-32 of the star source.
    pub source_crc: u32,
}

/// Writes a catalogue; the stars are sorted by V in hundredths, then by number.
///
/// # Errors
/// When there are too many stars or pairs, a direction is not a unit vector (to 1e-6) or a number has over 20
/// bits.
pub fn assemble(stars: &[CatalogueStar], tables: &TableParameters) -> Result<Vec<u8>, BuildError> {
    let max_chord =
        (0.0..=180.0).contains(&tables.max_separation_deg).then(|| chord(tables.max_separation_deg));
    let max_chord = max_chord.ok_or(BuildError::Parameter {
        name: "largest separation",
        value: tables.max_separation_deg,
        low: 0.0,
        high: 180.0,
    })?;
    let mut stars = stars.to_vec();
    stars.sort_by_key(|star| (centi(star.v), star.hip));
    check(&stars, max_chord)?;
    let units: Vec<[i32; 3]> =
        stars.iter().map(|star| star.direction.map(|x| q23(x) << UNUSED_BITS)).collect();
    let max_chord_q30 = (max_chord * ONE_Q30) as u32;
    let shift = bin_shift(max_chord_q30);
    let bins = (max_chord_q30 >> shift) + 1;
    let entries = entries(&sorted_pairs(&stars, &units, max_chord, shift));

    let bin_bytes = if entries.len() < LONG_BINS { 2 } else { 4 };
    let too_many = BuildError::TooManyPairs(entries.len() as f64 / 1e6);
    let entries_bytes = entries_bytes(entries.len(), stars.len()).ok_or(too_many)?;
    let length = HEADER_BYTES + stars.len() * STAR_BYTES + (bins as usize + 1) * bin_bytes + entries_bytes;
    let mut bytes = Vec::with_capacity(length);
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(HEADER_BYTES as u16).to_le_bytes());
    let [faintest, brightest] =
        [stars.last(), stars.first()].map(|star| star.map_or(0, |star| centi(star.v)) as i16 as u16);
    let words = [
        0, // the checksum, once the rest is known
        length as u32,
        stars.len() as u32,
        entries.len() as u32,
        bins,
        shift,
        max_chord_q30,
        thousandths(tables.epoch_year),
        u32::from(faintest) | u32::from(brightest) << 16,
        thousandths(tables.field_deg),
        tables.source_crc,
    ];
    words.iter().for_each(|word| bytes.extend_from_slice(&word.to_le_bytes()));
    bytes.resize(HEADER_BYTES, 0);
    for (star, unit) in stars.iter().zip(&units) {
        unit.iter().for_each(|x| bytes.extend_from_slice(&(x >> UNUSED_BITS).to_le_bytes()[..3]));
        let flags = if star.proximity { FLAG_PROXIMITY } else { 0 };
        let colour = (centi(star.b_v) + i32::from(COLOUR_OFFSET)).clamp(0, (1 << (32 - COLOUR_SHIFT)) - 1);
        bytes.extend_from_slice(&(star.hip | flags | (colour as u32) << COLOUR_SHIFT).to_le_bytes());
    }
    for bin in 0..=bins {
        let first = entries.partition_point(|entry| entry.bin < bin);
        bytes.extend_from_slice(&first.to_le_bytes()[..bin_bytes]);
    }
    let width = entry_bits(stars.len());
    // What is not yet a whole byte, lowest bit first.
    let (mut open, mut open_bits) = (0u64, 0);
    for Entry { step, second, .. } in entries {
        open |= u64::from(u32::from(step) | u32::from(second) << STEP_BITS) << open_bits;
        open_bits += width;
        while open_bits >= 8 {
            bytes.push(open as u8);
            (open, open_bits) = (open >> 8, open_bits - 8);
        }
    }
    bytes.push(open as u8);
    bytes.resize(length, 0);
    let checksum = crc32(&bytes[CRC_FROM..]);
    bytes[CRC_FROM - 4..CRC_FROM].copy_from_slice(&checksum.to_le_bytes());
    Ok(bytes)
}

/// A component of a direction; +1 becomes the number before it, which lengthens the vector and does not turn
/// it.
fn q23(x: f64) -> i32 {
    (x * ONE_Q23).round().clamp(-ONE_Q23, ONE_Q23 - 1.0) as i32
}

fn thousandths(value: f64) -> u32 {
    (value * 1000.0).round() as u32
}

fn check(stars: &[CatalogueStar], max_chord: f64) -> Result<(), BuildError> {
    if stars.len() > usize::from(u16::MAX) {
        return Err(BuildError::TooManyStars(stars.len()));
    }
    for star in stars {
        let length: f64 = star.direction.iter().map(|x| x * x).sum();
        if !((length - 1.0).abs() < 1e-6 && star.hip <= HIP_MASK) {
            return Err(BuildError::Star { hip: star.hip });
        }
    }
    // The cap within a chord c covers c^2 / 4 of the sphere: the number of pairs, were the stars spread
    // evenly.
    let pairs = stars.len() as f64 * stars.len() as f64 / 2.0 * max_chord * max_chord / 4.0;
    if pairs > MAX_PAIRS {
        return Err(BuildError::TooManyPairs(pairs / 1e6));
    }
    Ok(())
}

/// Every pair within the chord as `bin << 32 | first << 16 | second`, sorted: one integer to compare.
fn sorted_pairs(stars: &[CatalogueStar], units: &[[i32; 3]], max_chord: f64, shift: u32) -> Vec<u64> {
    let max_square = (max_chord * ONE_Q30) * (max_chord * ONE_Q30);
    let points: Vec<[f64; 3]> = stars.iter().map(|star| star.direction).collect();
    // The grid sorts exact directions, the chords are those of rounded ones: a little wider.
    let grid = CellGrid::new(&points, max_chord + 1e-8);
    // Together with their index and in the grid's order, the stars of a cube are read in one stream.
    let near: Vec<([i32; 3], u16)> =
        grid.order().iter().map(|&index| (units[index as usize], index as u16)).collect();
    let mut keys = Vec::new();
    grid.candidate_pairs(|a, b| {
        let (([ax, ay, az], i), ([bx, by, bz], j)) = (near[a], near[b]);
        let square = |p: i32, q: i32| (i64::from(p) - i64::from(q)).pow(2);
        let square = (square(ax, bx) + square(ay, by) + square(az, bz)) as f64;
        if square <= max_square {
            let pair = u64::from(i.min(j)) << 16 | u64::from(i.max(j));
            keys.push((square.sqrt() as u64 >> shift) << 32 | pair);
        }
    });
    keys.sort_unstable();
    keys
}

/// An entry of the pair table; the bits of what is not a step are the second star's index.
struct Entry {
    bin: u32,
    step: u16,
    second: u16,
}

/// The entries of sorted pairs.
fn entries(keys: &[u64]) -> Vec<Entry> {
    let mut entries = Vec::with_capacity(keys.len() + keys.len() / 16);
    let mut last = (0, 0);
    for key in keys {
        let (bin, first, second) = ((key >> 32) as u32, (key >> 16) as u16, *key as u16);
        let mut step = first - if last.0 == bin { last.1 } else { 0 };
        while step >= SKIP {
            entries.push(Entry { bin, step: SKIP, second: 0 });
            step -= SKIP;
        }
        entries.push(Entry { bin, step, second });
        last = (bin, first);
    }
    entries
}

fn bin_shift(max_chord_q30: u32) -> u32 {
    (0..32).find(|shift| (max_chord_q30 >> shift) < MAX_BINS).unwrap_or(31)
}
