//! The bytes against their reader: complete, sorted, found again, and refused when damaged.

use catalog_gen::coverage::SplitMix64;
use catalog_gen::source;
use catalog_gen::{BuildError, BuildParameters, CatalogueStar, TableParameters, assemble, build};
use fsw_core::catalog::{Catalogue, CatalogueError};
use proptest::prelude::*;

const TABLES: TableParameters = TableParameters {
    max_separation_deg: 40.0,
    epoch_year: 2026.5,
    field_deg: 20.0,
    source_crc: 0x1234_5678,
};

fn random_stars(seed: u64, count: u32) -> Vec<CatalogueStar> {
    let mut random = SplitMix64::new(seed);
    (1..=count)
        .map(|hip| CatalogueStar {
            direction: random.direction(),
            hip,
            v: 3.0 + 3.0 * random.symmetric(),
            b_v: random.symmetric(),
            proximity: hip % 7 == 0,
        })
        .collect()
}

/// Chord of two stars of the catalogue, from their integers.
fn chord(catalogue: &Catalogue, first: u16, second: u16) -> f64 {
    let (a, b) = (catalogue.star(first).unwrap().unit_q30, catalogue.star(second).unwrap().unit_q30);
    let square: f64 = a.iter().zip(b).map(|(x, y)| (f64::from(*x) - f64::from(y)).powi(2)).sum();
    square.sqrt() / f64::from(1 << 30)
}

/// Every pair of the catalogue to its largest chord, by looking at all.
fn all_pairs(catalogue: &Catalogue, max_chord: f64) -> Vec<(u16, u16)> {
    let count = catalogue.star_count() as u16;
    let pairs = (0..count).flat_map(|first| (first + 1..count).map(move |second| (first, second)));
    pairs.filter(|&(first, second)| chord(catalogue, first, second) <= max_chord).collect()
}

fn listed(catalogue: &Catalogue, low: f32, high: f32) -> Vec<(u16, u16)> {
    catalogue.pairs_between(low, high).map(|pair| (pair.first, pair.second)).collect()
}

#[test]
fn what_goes_in_comes_out() {
    let stars = random_stars(1, 60);
    let bytes = assemble(&stars, &TABLES).unwrap();
    let catalogue = Catalogue::open(&bytes).unwrap();
    assert_eq!(catalogue.star_count(), 60);
    assert_eq!(catalogue.field_millideg(), 20_000);
    assert!((catalogue.epoch_year() - 2026.5).abs() < 0.001);
    assert_eq!(catalogue.source_crc(), TABLES.source_crc);
    for star in catalogue.stars() {
        let original = stars[star.hip as usize - 1];
        let error = star
            .unit_q30
            .iter()
            .zip(original.direction)
            .map(|(q, x)| (f64::from(*q) / 128.0 - x * 2f64.powi(23)).abs());
        assert!(error.fold(0.0, f64::max) <= 0.5);
        assert_eq!(star.proximity, original.proximity);
        assert!((f64::from(star.colour_centi) - original.b_v * 100.0).abs() <= 0.5 + 1e-9);
    }
}

#[test]
fn the_pair_table_is_complete_and_sorted() {
    let max_chord = 2.0 * (TABLES.max_separation_deg.to_radians() / 2.0).sin();
    for (seed, count) in [(2, 2), (3, 50), (4, 300)] {
        let bytes = assemble(&random_stars(seed, count), &TABLES).unwrap();
        let catalogue = Catalogue::open(&bytes).unwrap();
        let mut pairs = listed(&catalogue, 0.0, 2.0);
        // Chords of 40 deg in at most 2048 bins.
        let bin = 2f64.powi(-11);
        let chords: Vec<f64> =
            pairs.iter().map(|&(first, second)| chord(&catalogue, first, second)).collect();
        assert!(chords.windows(2).all(|pair| pair[1] > pair[0] - bin));
        pairs.sort_unstable();
        assert_eq!(pairs, all_pairs(&catalogue, max_chord));
    }
}

#[test]
fn a_built_catalogue_has_every_pair_of_a_real_sky() {
    let few = BuildParameters { magnitude: 3.5, max_separation_deg: 25.0, ..BuildParameters::reference() };
    let bytes = build(&source::stars(), &few).unwrap();
    let catalogue = Catalogue::open(&bytes).unwrap();
    let mut pairs = listed(&catalogue, 0.0, 2.0);
    pairs.sort_unstable();
    assert!(pairs.len() > 1000);
    assert_eq!(pairs, all_pairs(&catalogue, 2.0 * 12.5f64.to_radians().sin()));
}

#[test]
fn the_bin_table_stays_small_and_ends_at_the_last_entry() {
    for separation in [0.1, 1.0, 5.6, 12.0, 60.0] {
        let tables = TableParameters { max_separation_deg: separation, ..TABLES };
        let bytes = assemble(&random_stars(5, 80), &tables).unwrap();
        let word = |offset: usize| u32::from_le_bytes(*bytes[offset..].first_chunk().unwrap());
        let (stars, entries, bins) = (word(16) as usize, word(20), word(24));
        assert!((1024..=2048).contains(&bins), "{bins}");
        assert!(entries < 65_536);
        let last = 64 + 13 * stars + 2 * bins as usize;
        assert_eq!(u32::from(u16::from_le_bytes([bytes[last], bytes[last + 1]])), entries);
    }
    // The reference catalogue's bins are 25 arcsec wide.
    let tables = TableParameters { max_separation_deg: 12.0, ..TABLES };
    assert_eq!(assemble(&[], &tables).unwrap()[28], 17);
}

#[test]
fn a_damaged_catalogue_is_refused_whatever_the_byte() {
    let tables = TableParameters { max_separation_deg: 5.0, ..TABLES };
    let mut bytes = assemble(&random_stars(6, 60), &tables).unwrap();
    for offset in 0..bytes.len() {
        for flip in [0x01, 0x80] {
            bytes[offset] ^= flip;
            assert!(Catalogue::open(&bytes).is_err(), "byte {offset}");
            bytes[offset] ^= flip;
        }
    }
    assert!(Catalogue::open(&bytes).is_ok());
    for length in [0, 3, 63, 64, bytes.len() - 4, bytes.len() - 1] {
        assert!(Catalogue::open(&bytes[..length]).is_err(), "length {length}");
    }
    bytes.push(0);
    assert_eq!(Catalogue::open(&bytes).unwrap_err(), CatalogueError::Length);
}

#[test]
fn stars_that_cannot_be_written_are_refused() {
    let good = random_stars(7, 1)[0];
    let refused = [
        CatalogueStar { hip: 1 << 20, ..good },
        CatalogueStar { direction: [1.0, 0.1, 0.0], ..good },
        CatalogueStar { direction: [f64::NAN, 0.0, 0.0], ..good },
    ];
    for star in refused {
        assert_eq!(assemble(&[star], &TABLES), Err(BuildError::Star { hip: star.hip }));
    }
    assert!(matches!(assemble(&random_stars(8, 65_536), &TABLES), Err(BuildError::TooManyStars(65_536))));
    assert!(matches!(assemble(&random_stars(8, 30_000), &TABLES), Err(BuildError::TooManyPairs(_))));
    let endless = TableParameters { max_separation_deg: f64::NAN, ..TABLES };
    assert!(matches!(assemble(&[good], &endless), Err(BuildError::Parameter { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_range_of_chords_returns_every_pair_in_it(seed in 0u64..1000, low in 0.0f32..0.7, width in 0.0f32..0.2) {
        let bytes = assemble(&random_stars(seed, 120), &TABLES).unwrap();
        let catalogue = Catalogue::open(&bytes).unwrap();
        let high = low + width;
        let found: std::collections::HashSet<_> = listed(&catalogue, low, high).into_iter().collect();
        prop_assert_eq!(found.len(), catalogue.count_between(low, high));
        let max_chord = 2.0 * 20f64.to_radians().sin();
        for (first, second) in all_pairs(&catalogue, max_chord) {
            let chord = chord(&catalogue, first, second);
            if (f64::from(low)..=f64::from(high)).contains(&chord) {
                prop_assert!(found.contains(&(first, second)));
            }
        }
        // And at most a bin (0.34 mrad here) more on either side.
        for (first, second) in found {
            let chord = chord(&catalogue, first, second);
            prop_assert!(chord > f64::from(low) - 5e-4 && chord < f64::from(high) + 5e-4);
        }
    }

    #[test]
    fn the_order_of_the_stars_does_not_matter(seed in 0u64..1000, turn in 0usize..40) {
        let mut stars = random_stars(seed, 40);
        let bytes = assemble(&stars, &TABLES).unwrap();
        stars.rotate_left(turn);
        prop_assert_eq!(assemble(&stars, &TABLES).unwrap(), bytes);
    }
}
