//! Artificial tables for the tests, written from the layout's description.

use crate::checksum::crc32;
use std::vec::Vec;

/// Writes the checksum again after a change.
pub fn seal(bytes: &mut [u8]) {
    let crc = crc32(&bytes[12..]);
    bytes[8..12].copy_from_slice(&crc.to_le_bytes());
}

/// A table of bad pixels (column, row) in any order, and of columns' offsets, which are written as they are
/// given.
pub fn bytes([width, height]: [u16; 2], bad: &[[u16; 2]], offsets: &[(u16, i16)]) -> Vec<u8> {
    let mut bad: Vec<[u16; 2]> = bad.iter().map(|[x, y]| [*y, *x]).collect();
    bad.sort();
    bad.dedup();
    let mut words = std::vec![width, height, offsets.len() as u16, bad.len() as u16, 0, 0];
    words.extend((0..=height).map(|row| bad.iter().filter(|[y, _]| *y < row).count() as u16));
    words.extend(bad.iter().map(|[_, x]| *x));
    words.extend(offsets.iter().flat_map(|(x, offset)| [*x, *offset as u16]));
    let mut bytes = b"SXDF\x01\x00\x1c\x00\0\0\0\0".to_vec();
    bytes.extend((16 + 2 * words.len() as u32).to_le_bytes());
    bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    seal(&mut bytes);
    bytes
}
