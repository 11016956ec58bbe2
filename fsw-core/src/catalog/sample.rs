//! Artificial catalogues for the tests, written from the layout's description and in integers alone.

use crate::checksum::crc32;
use crate::oracle::Generator;
use nalgebra::Vector3;
use std::vec::Vec;

pub struct SampleStar {
    /// Low 7 bits zero: the file has 24.
    pub unit_q30: [i32; 3],
    pub hip: u32,
    pub proximity: bool,
    pub colour_centi: i16,
}

/// Chord of two stars, Q2.30, rounded down.
pub fn chord_q30(one: &SampleStar, other: &SampleStar) -> u32 {
    let square = one.unit_q30.iter().zip(other.unit_q30).map(|(a, b)| {
        let difference = i64::from(*a) - i64::from(b);
        (difference * difference) as u64
    });
    square.sum::<u64>().isqrt() as u32
}

/// A star in this direction; the Hipparcos number says which it is.
pub fn star(direction: &Vector3<f64>, hip: u32) -> SampleStar {
    let q23 = |x: f64| ((x * (1u32 << 23) as f64).round() as i32).clamp(-(1 << 23), (1 << 23) - 1);
    let unit_q30 = [direction.x, direction.y, direction.z].map(|x| q23(x) << 7);
    SampleStar { unit_q30, hip, proximity: false, colour_centi: 50 }
}

/// Stars evenly over the sky, numbered from 1.
pub fn sky(generator: &mut Generator, count: u32) -> Vec<SampleStar> {
    (1..=count).map(|hip| star(&generator.unit(), hip)).collect()
}

/// Writes the checksum again after a change.
pub fn seal(bytes: &mut [u8]) {
    let crc = crc32(&bytes[12..]);
    bytes[8..12].copy_from_slice(&crc.to_le_bytes());
}

/// The bytes of a catalogue with every pair up to `max_chord_q30`.
pub fn bytes(stars: &[SampleStar], shift: u32, max_chord_q30: u32) -> Vec<u8> {
    let mut pairs = Vec::new();
    for (second, star) in stars.iter().enumerate() {
        for (first, brighter) in stars.iter().enumerate().take(second) {
            let chord = chord_q30(brighter, star);
            if chord <= max_chord_q30 {
                pairs.push((chord >> shift, first as u32, second as u32));
            }
        }
    }
    pairs.sort_unstable();
    let bins = (max_chord_q30 >> shift) + 1;
    // By bin: the step of the first star, and the second star.
    let mut entries = Vec::new();
    let mut last = (0, 0);
    for (bin, first, second) in pairs {
        let mut step = first - if last.0 == bin { last.1 } else { 0 };
        while step >= 511 {
            entries.push((bin, 511, 0));
            step -= 511;
        }
        entries.push((bin, step, second));
        last = (bin, first);
    }
    let bin_bytes = if entries.len() < 65_536 { 2 } else { 4 };
    let entry_bits = if stars.len() <= 4096 { 21 } else { 25 };
    let entries_bytes = (entries.len() * entry_bits).div_ceil(8) + 3;
    let length = 64 + 13 * stars.len() + bin_bytes * (bins as usize + 1) + entries_bytes;

    let mut bytes = b"SXTC\x03\x00\x40\x00".to_vec();
    let count = |items: usize| items as u32;
    let counts = [0, count(length), count(stars.len()), count(entries.len()), bins, shift, max_chord_q30];
    counts.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    // Epoch J2026.5, V = -1.46 to 6.00, field 24.1 deg, checksum of the source.
    [2_026_500u32, 600 | (-146i16 as u16 as u32) << 16, 24_100, 0xDEAD_BEEF]
        .iter()
        .for_each(|word| bytes.extend(word.to_le_bytes()));
    bytes.resize(64, 0);
    for star in stars {
        star.unit_q30.iter().for_each(|x| bytes.extend(&(x >> 7).to_le_bytes()[..3]));
        let colour = (star.colour_centi + 512) as u32;
        bytes.extend((star.hip | u32::from(star.proximity) << 20 | colour << 21).to_le_bytes());
    }
    for bin in 0..=bins {
        let before = entries.iter().filter(|(of, ..)| *of < bin).count();
        bytes.extend(&before.to_le_bytes()[..bin_bytes]);
    }
    let begin = bytes.len();
    bytes.resize(length, 0);
    for (place, (_, step, second)) in entries.iter().enumerate() {
        for bit in (0..entry_bits).filter(|bit| (step | second << 9) >> bit & 1 != 0) {
            let at = place * entry_bits + bit;
            bytes[begin + at / 8] |= 1 << (at % 8);
        }
    }
    seal(&mut bytes);
    bytes
}
