use super::sample::{bytes, seal};
use super::*;
use proptest::prelude::*;
use std::vec::Vec;

const SIZE_PX: [u16; 2] = [20, 10];
/// Where the rows' index begins, and the pixels of a table of ten rows.
const INDEX: usize = HEADER_BYTES;
const PIXELS: usize = INDEX + 2 * 11;

/// Four bad pixels, two columns with offsets.
fn small() -> Vec<u8> {
    bytes(SIZE_PX, &[[3, 9], [7, 0], [2, 4], [19, 4]], &[(0, -5), (11, 300)])
}

fn refusal(bytes: &[u8]) -> DefectsError {
    Defects::open(bytes).map(|_| ()).unwrap_err()
}

/// The small table with a word changed and the checksum made right again.
fn with(offset: usize, word: u16) -> Vec<u8> {
    let mut bytes = small();
    bytes[offset..offset + 2].copy_from_slice(&word.to_le_bytes());
    seal(&mut bytes);
    bytes
}

#[test]
fn what_was_written_is_read() {
    let bytes = small();
    let defects = Defects::open(&bytes).unwrap();
    assert_eq!((defects.size_px(), defects.pixel_count()), (SIZE_PX, 4));
    let rows: Vec<Vec<u16>> = (0..10).map(|y| defects.row(y).collect()).collect();
    let mut expected = std::vec![Vec::new(); 10];
    (expected[0], expected[4], expected[9]) = (std::vec![7], std::vec![2, 19], std::vec![3]);
    assert_eq!(rows, expected);
    assert_eq!(defects.offsets().collect::<Vec<_>>(), [(0, -5), (11, 300)]);
    assert!(defects.is_bad(19, 4) && !defects.is_bad(18, 4) && !defects.is_bad(19, 5));
    assert!(!defects.is_bad(3, 10) && !defects.is_bad(u16::MAX, u16::MAX));
    assert_eq!(defects.crc(), u32::from_le_bytes(bytes[8..12].try_into().unwrap()));
}

#[test]
fn a_table_without_defects_is_a_table() {
    let bytes = bytes([1280, 1024], &[], &[]);
    let defects = Defects::open(&bytes).unwrap();
    assert_eq!((bytes.len(), defects.pixel_count(), defects.offsets().count()), (28 + 2 * 1025, 0, 0));
}

#[test]
fn the_stated_size_holds() {
    let bad: Vec<_> = (0..2000u16).map(|k| [k % 1280, k / 2]).collect();
    assert_eq!(bytes([1280, 1024], &bad, &[]).len(), 6_078);
}

#[test]
fn other_files_and_versions_are_refused() {
    for other in [&b""[..], b"SXD", b"SXCC\x01\x00", b"\x89PNG\r\n"] {
        assert_eq!(refusal(other), DefectsError::NotDefects);
    }
    for version in [0, 2, u16::MAX] {
        assert_eq!(refusal(&with(4, version)), DefectsError::Version(version));
    }
}

#[test]
fn every_truncation_and_any_appendix_is_refused_by_length() {
    let mut bytes = small();
    for length in MAGIC.len()..bytes.len() {
        assert_eq!(refusal(&bytes[..length]), DefectsError::Length, "{length} bytes");
    }
    bytes.push(0);
    assert_eq!(refusal(&bytes), DefectsError::Length);
}

#[test]
fn every_changed_bit_after_the_length_is_refused_by_the_checksum() {
    let bytes = small();
    for bit in 8 * 16..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(refusal(&damaged), DefectsError::Checksum, "bit {bit}");
    }
}

#[test]
fn counts_that_contradict_each_other_are_refused() {
    let structure = [
        with(6, 32),                   // the header's length
        with(18, 9),                   // fewer rows than the index has
        with(20, 3),                   // more offsets
        with(22, 3),                   // fewer pixels
        with(INDEX, 1),                // the first row does not begin with the first pixel
        with(INDEX + 2 * 3, 2),        // the index falls back
        with(INDEX + 2 * 10, 3),       // the last pixel belongs to no row
        with(INDEX + 2 * 2, u16::MAX), // the index leaves the list
    ];
    for (case, bytes) in structure.iter().enumerate() {
        assert_eq!(refusal(bytes), DefectsError::Structure, "case {case}");
    }
}

#[test]
fn pixels_and_columns_out_of_order_named_twice_or_outside_are_refused() {
    // Of row 4, [2, 19]: the second before the first, the same again, outside.
    assert_eq!(refusal(&with(PIXELS + 4, 1)), DefectsError::Unsorted);
    assert_eq!(refusal(&with(PIXELS + 4, 2)), DefectsError::Unsorted);
    assert_eq!(refusal(&with(PIXELS + 4, 20)), DefectsError::Outside);
    assert_eq!(refusal(&with(PIXELS, u16::MAX)), DefectsError::Outside);
    assert_eq!(refusal(&bytes(SIZE_PX, &[], &[(5, 1), (4, 1)])), DefectsError::Unsorted);
    assert_eq!(refusal(&bytes(SIZE_PX, &[], &[(5, 1), (5, 1)])), DefectsError::Unsorted);
    assert_eq!(refusal(&bytes(SIZE_PX, &[], &[(20, 1)])), DefectsError::Outside);
    assert_eq!(refusal(&with(16, 19)), DefectsError::Outside);
    assert_eq!(refusal(&bytes([0, 0], &[], &[(0, 1)])), DefectsError::Outside);
}

proptest! {
    #[test]
    fn any_words_under_a_right_checksum_are_refused_or_in_order(
        words in prop::collection::vec((0usize..60, any::<u16>()), 0..4),
        small_values: bool,
    ) {
        let mut bytes = small();
        for (place, word) in words {
            let word = if small_values { word % 24 } else { word };
            if let Some(two) = bytes.get_mut(16 + 2 * place..18 + 2 * place) {
                two.copy_from_slice(&word.to_le_bytes());
            }
        }
        seal(&mut bytes);
        if let Ok(defects) = Defects::open(&bytes) {
            let [width, height] = defects.size_px();
            let all: Vec<Vec<u16>> = (0..height).map(|y| defects.row(y).collect()).collect();
            prop_assert_eq!(all.concat().len(), defects.pixel_count());
            for row in all {
                prop_assert!(row.is_sorted_by(|a, b| a < b) && row.iter().all(|x| *x < width));
            }
        }
    }
}
