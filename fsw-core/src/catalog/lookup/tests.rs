use super::*;
use crate::catalog::sample::{self, SampleStar, chord_q30};
use crate::oracle::Generator;
use proptest::prelude::*;
use std::sync::LazyLock;
use std::vec::Vec;

const SHIFT: u32 = 20;
const BIN: f64 = (1u32 << SHIFT) as f64 / (1u32 << 30) as f64;

/// 250 stars with all their 31,125 pairs, and the chords of these.
struct Sky {
    bytes: Vec<u8>,
    /// By first and second star, with the exact chord of the fixed-point vectors.
    pairs: Vec<(Pair, f64)>,
    stars: Vec<SampleStar>,
}

static SKY: LazyLock<Sky> = LazyLock::new(|| {
    let stars = sample::sky(&mut Generator::new(2), 250);
    let mut pairs = Vec::new();
    for second in 0..stars.len() {
        for first in 0..second {
            let square = stars[first].unit_q30.iter().zip(stars[second].unit_q30).map(|(a, b)| {
                let difference = (f64::from(*a) - f64::from(b)) / f64::from(1u32 << 30);
                difference * difference
            });
            pairs.push((Pair { first: first as u16, second: second as u16 }, square.sum::<f64>().sqrt()));
        }
    }
    Sky { bytes: sample::bytes(&stars, SHIFT, 1 << 31), pairs, stars }
});

fn catalogue() -> Catalogue<'static> {
    Catalogue::open(&SKY.bytes).unwrap()
}

/// Whether the answer holds every pair in the range and none beyond the bins at its ends.
fn is_complete(low: f32, high: f32) -> Result<(), std::string::String> {
    let mut given = std::vec![false; 250 * 250];
    for pair in catalogue().pairs_between(low, high) {
        let place = &mut given[usize::from(pair.second) * 250 + usize::from(pair.first)];
        if *place {
            return Err(std::format!("{pair:?} twice"));
        }
        *place = true;
    }
    for (pair, chord) in &SKY.pairs {
        let inside = *chord >= low.into() && *chord <= high.into();
        let near = *chord >= f64::from(low) - BIN && *chord <= f64::from(high) + BIN;
        let given = given[usize::from(pair.second) * 250 + usize::from(pair.first)];
        if (inside && !given) || (given && !near) {
            return Err(std::format!("{pair:?}, chord {chord}, in {low}..{high}: {given}"));
        }
    }
    Ok(())
}

#[test]
fn a_coarse_chord_errs_by_less_than_it_says() {
    let catalogue = catalogue();
    let unit = 0.5f64.powi(30);
    for (Pair { first, second }, chord) in &SKY.pairs {
        let coarse = (f64::from(catalogue.coarse_square(*first, *second)) * unit).sqrt();
        // Squares of nearly opposite stars pass 2^32.
        assert!(*chord > 1.999 || (coarse - chord).abs() < COARSE_CHORD_ERROR.into(), "{coarse} for {chord}");
    }
    assert_eq!(catalogue.coarse_square(0, u16::MAX), 0);
}

#[test]
fn a_range_gives_every_pair_inside_and_no_other_to_the_bin() {
    let mut generator = Generator::new(3);
    for _ in 0..300 {
        let low = generator.between(-0.1, 2.0);
        let width = 10f64.powf(generator.between(-6.0, 0.0));
        is_complete(low as f32, (low + width) as f32).unwrap();
    }
    is_complete(0.0, 2.0).unwrap();
    assert_eq!(catalogue().count_between(0.0, 2.0), SKY.pairs.len());
}

#[test]
fn a_range_of_one_chord_gives_its_pair() {
    for (pair, chord) in SKY.pairs.iter().step_by(97) {
        // The nearest f32 may lie on either side.
        let at = *chord as f32;
        let (low, high) = if f64::from(at) > *chord { (at.next_down(), at) } else { (at, at.next_up()) };
        assert!(catalogue().pairs_between(low, high).any(|given| given == *pair), "{chord}");
    }
}

#[test]
fn pairs_come_by_rising_bin() {
    let chord = |pair: Pair| {
        chord_q30(&SKY.stars[usize::from(pair.first)], &SKY.stars[usize::from(pair.second)]) >> SHIFT
    };
    assert!(catalogue().pairs_between(0.3, 0.9).map(chord).is_sorted());
}

#[test]
fn ranges_without_meaning_or_beyond_the_table_are_empty() {
    let nan = f32::NAN;
    let empty = [
        (nan, 1.0),
        (0.0, nan),
        (nan, nan),
        (1.0, 0.5),
        (-2.0, -1.0),
        (2.1, 3.0),
        (f32::INFINITY, f32::INFINITY),
        (f32::NEG_INFINITY, -1e-30),
    ];
    for (low, high) in empty {
        assert_eq!(catalogue().count_between(low, high), 0, "{low}..{high}");
        assert_eq!(catalogue().pairs_between(low, high).next(), None, "{low}..{high}");
    }
    // A table of short pairs knows nothing of long ones.
    let bytes = sample::bytes(&SKY.stars, 16, 1 << 28);
    let short = Catalogue::open(&bytes).unwrap();
    assert_eq!(short.count_between(0.2501, 2.0), 0);
    assert_eq!(short.count_between(0.0, 2.0), short.pair_count());
}

#[test]
fn a_star_is_found_by_its_index() {
    for (index, expected) in SKY.stars.iter().enumerate() {
        let star = catalogue().star(index as u16).unwrap();
        assert_eq!((star.hip, star.unit_q30), (expected.hip, expected.unit_q30));
        assert_eq!(catalogue().unit(index as u16).unwrap(), *star.direction().vector());
    }
    assert_eq!(catalogue().star(250), None);
    assert_eq!(catalogue().unit(u16::MAX), None);
}

proptest! {
    #[test]
    fn no_range_panics_and_the_count_is_that_of_the_pairs(low in any::<f32>(), high in any::<f32>()) {
        for (low, high) in [(low, high), (low.abs() % 2.5, high.abs() % 2.5)] {
            // Of 250 stars no step is beyond an entry.
            prop_assert_eq!(catalogue().pairs_between(low, high).count(), catalogue().count_between(low, high));
        }
    }

    #[test]
    fn any_range_of_chords_is_complete(low in -0.5f32..2.5, width in 0.0f32..0.2) {
        is_complete(low, low + width).map_err(TestCaseError::fail)?;
    }
}
