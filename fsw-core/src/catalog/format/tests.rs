use super::*;
use crate::catalog::sample::{self, SampleStar, seal};
use crate::oracle::Generator;
use proptest::prelude::*;
use std::vec::Vec;

/// Eight stars, all 28 pairs, 33 bins.
fn small() -> Vec<u8> {
    sample::bytes(&sample::sky(&mut Generator::new(1), 8), 26, 1 << 31)
}

fn refusal(bytes: &[u8]) -> CatalogueError {
    Catalogue::open(bytes).map(|_| ()).unwrap_err()
}

/// The small catalogue with one header word changed and the checksum made right again.
fn with_word(offset: usize, word: u32) -> Vec<u8> {
    let mut bytes = small();
    bytes[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
    seal(&mut bytes);
    bytes
}

#[test]
fn a_header_says_what_was_written() {
    let bytes = small();
    let catalogue = Catalogue::open(&bytes).unwrap();
    assert_eq!((catalogue.star_count(), catalogue.pair_count()), (8, 28));
    assert_eq!(catalogue.max_chord(), 2.0);
    assert!((catalogue.epoch_year() - 2026.5).abs() < 1e-3);
    assert_eq!(catalogue.magnitudes_centi(), [-146, 600]);
    assert_eq!(catalogue.field_millideg(), 24_100);
    assert_eq!(catalogue.source_crc(), 0xDEAD_BEEF);
}

#[test]
fn a_star_is_read_with_its_number_flag_signs_and_colours() {
    let one = SampleStar { unit_q30: [-(1 << 30), 0, 0], hip: 120_404, proximity: true, colour_centi: -512 };
    let two = SampleStar {
        unit_q30: [0, 858_993_459 & !127, -644_245_094 & !127],
        hip: 7,
        proximity: false,
        colour_centi: 201,
    };
    let bytes = sample::bytes(&[one, two], 26, 1 << 31);
    let stars: Vec<Star> = Catalogue::open(&bytes).unwrap().stars().collect();
    let expected = Star { unit_q30: [-(1 << 30), 0, 0], hip: 120_404, proximity: true, colour_centi: -512 };
    assert_eq!(stars[0], expected);
    assert_eq!((stars[1].hip, stars[1].proximity, stars[1].colour_centi), (7, false, 201));
    let direction = *stars[1].direction().vector();
    assert!((direction - nalgebra::Vector3::new(0.0, 0.8, -0.6)).norm() < 2e-7);
}

#[test]
fn an_empty_catalogue_is_a_catalogue() {
    let bytes = sample::bytes(&[], 26, 0);
    let catalogue = Catalogue::open(&bytes).unwrap();
    assert_eq!((catalogue.star_count(), catalogue.pair_count()), (0, 0));
    assert_eq!(catalogue.star(0), None);
    assert_eq!(catalogue.count_between(0.0, 2.0), 0);
}

#[test]
fn other_files_are_refused_by_their_magic() {
    let mut bytes = small();
    bytes[3] = b'D';
    for other in [&b""[..], b"SXT", b"\x89PNG\r\n", &bytes] {
        assert_eq!(refusal(other), CatalogueError::NotACatalogue);
    }
}

#[test]
fn another_version_is_refused_and_named() {
    for version in [0u16, 2, 4, 0xFFFF] {
        let mut bytes = small();
        bytes[4..6].copy_from_slice(&version.to_le_bytes());
        assert_eq!(refusal(&bytes), CatalogueError::Version(version));
    }
}

#[test]
fn every_truncation_and_any_appendix_is_refused_by_length() {
    let mut bytes = small();
    for length in MAGIC.len()..bytes.len() {
        assert_eq!(refusal(&bytes[..length]), CatalogueError::Length, "{length} bytes");
    }
    bytes.push(0);
    assert_eq!(refusal(&bytes), CatalogueError::Length);
    assert_eq!(refusal(&with_word(12, 0)), CatalogueError::Length);
    assert_eq!(refusal(&with_word(12, u32::MAX)), CatalogueError::Length);
}

#[test]
fn any_flipped_bit_is_refused() {
    let good = small();
    for place in 0..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[place] ^= 1 << bit;
            let error = refusal(&bytes);
            // Before the protected part stand magic, version, header length (checked as structure) and the
            // CRC itself.
            let expected = match place {
                0..4 => error == CatalogueError::NotACatalogue,
                4..6 => matches!(error, CatalogueError::Version(_)),
                6..8 => error == CatalogueError::Structure,
                12..16 => error == CatalogueError::Length,
                _ => error == CatalogueError::Checksum,
            };
            assert!(expected, "byte {place}, bit {bit}: {error:?}");
        }
    }
}

#[test]
fn a_star_whose_vector_is_not_of_unit_length_is_refused_by_structure() {
    let mut bytes = small();
    // The first star's x, y and z.
    bytes[HEADER_BYTES..HEADER_BYTES + 9].fill(0);
    seal(&mut bytes);
    assert_eq!(refusal(&bytes), CatalogueError::Structure);
}

#[test]
fn counts_that_contradict_each_other_are_refused_by_structure() {
    let cases = [
        ("stars", 16, [7, 9, 0, 65_536, u32::MAX]),
        ("pair entries", 20, [27, 29, 0, 65_536, u32::MAX]),
        ("bins", 24, [32, 34, 0, 65_536, u32::MAX]),
        ("shift", 28, [32, 33, 64, 65_536, u32::MAX]),
    ];
    for (name, offset, words) in cases {
        for word in words {
            assert_eq!(refusal(&with_word(offset, word)), CatalogueError::Structure, "{name} = {word}");
        }
    }
    // Counts that trade two stars for thirteen entries of the next table have the right length but the wrong
    // tables.
    let mut bytes = with_word(16, 6);
    bytes[24..28].copy_from_slice(&45u32.to_le_bytes());
    seal(&mut bytes);
    assert_eq!(refusal(&bytes), CatalogueError::Structure);
}

#[test]
fn a_bin_table_that_goes_back_or_ends_before_the_last_pair_is_refused() {
    let bins_at = HEADER_BYTES + 8 * STAR_BYTES;
    let last = bins_at + 33 * 2;
    for (offset, entry) in [(last, 27u16), (last, 29), (bins_at + 4, 29), (bins_at + 40, 0)] {
        let mut bytes = small();
        bytes[offset..offset + 2].copy_from_slice(&entry.to_le_bytes());
        seal(&mut bytes);
        assert_eq!(refusal(&bytes), CatalogueError::Structure, "byte {offset}");
    }
}

#[test]
fn a_catalogue_of_many_stars_and_pairs_is_read_by_its_wider_entries() {
    // About 500 and 70,000 pairs.
    for (stars, max_chord) in [(4096, 1 << 24), (4097, 1 << 24), (4096, 3 << 26), (4097, 3 << 26)] {
        let stars = sample::sky(&mut Generator::new(4), stars);
        let bytes = sample::bytes(&stars, 18, max_chord);
        let catalogue = Catalogue::open(&bytes).unwrap();
        assert_eq!(catalogue.pair_count() >= LONG_BINS, max_chord == 3 << 26);
        assert!(catalogue.count_between(0.0, 2.0) > catalogue.pair_count(), "no step beyond an entry");
        let chord =
            |pair: Pair| sample::chord_q30(&stars[usize::from(pair.first)], &stars[usize::from(pair.second)]);
        let pairs: Vec<Pair> = catalogue.pairs_between(0.0, 2.0).collect();
        assert_eq!(pairs.len(), catalogue.pair_count());
        assert!(pairs.iter().map(|pair| (chord(*pair) >> 18, pair.first, pair.second)).is_sorted());
        assert!(pairs.iter().all(|pair| pair.first < pair.second && chord(*pair) <= max_chord));
    }
}

proptest! {
    /// Bytes with a right header and checksum but any counts and content: opened or refused, and safe to ask.
    #[test]
    fn no_bytes_panic_at_the_door_or_behind_it(
        content in prop::collection::vec(any::<u8>(), 0..400),
        counts in prop::array::uniform5(0u32..40),
        index in any::<u16>(),
        low in any::<f32>(),
        high in any::<f32>(),
    ) {
        let _ = Catalogue::open(&content);
        let mut bytes = small();
        bytes.truncate(HEADER_BYTES);
        bytes.extend(&content);
        let length = bytes.len() as u32;
        bytes[12..16].copy_from_slice(&length.to_le_bytes());
        for (place, count) in counts.iter().enumerate() {
            bytes[16 + 4 * place..20 + 4 * place].copy_from_slice(&count.to_le_bytes());
        }
        seal(&mut bytes);
        if let Ok(catalogue) = Catalogue::open(&bytes) {
            let _ = (catalogue.star(index), catalogue.unit(index), catalogue.stars().count());
            prop_assert!(catalogue.pairs_between(low, high).count() <= catalogue.count_between(low, high));
        }
    }
}
