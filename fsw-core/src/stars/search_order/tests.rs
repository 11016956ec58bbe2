use super::*;
use crate::catalog::Catalogue;
use crate::oracle::Generator;
use crate::stars::MeasuredStar;
use crate::stars::artificial::{Picture, SKY, camera, camera_parameters, false_star};
use std::collections::BTreeSet;
use std::vec::Vec;

/// Tolerance, i, j.
type Given = (usize, u8, u8);
type Sides = BTreeSet<(u8, u8)>;

/// All sides that the search order gives, with the number of the tolerance; afterwards it gives none.
fn all_given(measured: &[MeasuredStar], catalogue: &Catalogue, capacity: usize) -> Vec<Given> {
    let camera = camera();
    let field = StarField::whole(measured, catalogue, &camera);
    let parameters = IdentificationParameters::default();
    let mut order = SearchOrder::new();
    assert!(!order.any_side);
    let mut given = Vec::new();
    while let Some(pair) = order.next(&field, &parameters, capacity) {
        given.push((order.step(), pair.i, pair.j));
        order.update_after_failure(&pair);
        assert!(given.len() <= MAX_SIDES);
    }
    assert_eq!(order.any_side, !given.is_empty());
    for _ in 0..100 {
        assert!(order.next(&field, &parameters, capacity).is_none());
        assert_eq!(order.step(), TOLERANCES - 1);
    }
    given
}

/// The sides to be given for one tolerance, by their chords in f64; and those too near a limit to tell.
fn expected_sides(
    measured: &[MeasuredStar],
    catalogue: &Catalogue,
    capacity: usize,
    sigma_px: f64,
) -> (Sides, Sides) {
    let (mut clear, mut doubtful) = (BTreeSet::new(), BTreeSet::new());
    for j in 0..measured.len().min(32) {
        for i in 0..j {
            let [a, b] = [i, j].map(|index| measured[index].direction.vector().map(f64::from));
            let chord = (a - b).norm();
            let tolerance = 3.0 * 2f64.sqrt() * sigma_px / 3889.0 + 2e-4 * chord;
            let room = (f64::from(catalogue.max_chord()) - chord - tolerance).min(chord - 10.0 * tolerance);
            let pairs = catalogue.count_between((chord - tolerance) as f32, (chord + tolerance) as f32);
            // Near the end of a bin the last digits of f32 decide on a whole bin.
            let wider = 3e-7;
            let [least, most] = [-wider, wider].map(|by| {
                catalogue.count_between((chord - tolerance - by) as f32, (chord + tolerance + by) as f32)
            });
            if room.abs() < 1e-6 || least != most {
                doubtful.insert((i as u8, j as u8));
            } else if room > 0.0 && pairs > 0 && 2 * pairs <= capacity {
                clear.insert((i as u8, j as u8));
            }
        }
    }
    (clear, doubtful)
}

/// Fields of few, many and too many stars, true and false.
fn fields() -> impl Iterator<Item = Vec<MeasuredStar>> {
    let mut generator = Generator::new(40);
    [0, 1, 2, 3, 8, 9, 13, 31, 32, 33, 64, 80].into_iter().cycle().take(48).map(move |count| {
        let look = generator.rotation();
        let mut picture = Picture::of(&SKY, &camera_parameters(), look);
        picture.spots.resize_with(count, || false_star(&mut generator));
        picture.measured(&camera(), 0.3)
    })
}

#[test]
fn every_side_worth_trying_is_given_once_for_every_tolerance() {
    let catalogue = SKY.catalogue();
    let (mut expected, mut left_out) = (0, 0);
    for measured in fields() {
        for capacity in [100, 1500, usize::MAX] {
            let given = all_given(&measured, &catalogue, capacity);
            for (step, sigma_px) in [0.35, 1.0, 2.0].into_iter().enumerate() {
                let of_step: Vec<(u8, u8)> =
                    given.iter().filter(|pair| pair.0 == step).map(|pair| (pair.1, pair.2)).collect();
                let once: Sides = of_step.iter().copied().collect();
                assert_eq!(of_step.len(), once.len(), "a side was given twice");
                let (clear, doubtful) = expected_sides(&measured, &catalogue, capacity, sigma_px);
                let stars = measured.len().min(32);
                expected += clear.len();
                left_out += stars * stars.saturating_sub(1) / 2 - clear.len() - doubtful.len();
                let surely: Sides = once.difference(&doubtful).copied().collect();
                assert_eq!(surely, clear, "{} stars, tolerance {step}, {capacity}", measured.len());
            }
        }
    }
    assert!(expected > 10_000 && left_out > 10_000, "{expected} sides, {left_out} left out");
}

#[test]
fn tolerances_widen_only_when_every_side_was_given() {
    for measured in fields() {
        let given = all_given(&measured, &SKY.catalogue(), usize::MAX);
        assert!(given.is_sorted_by_key(|pair| pair.0));
    }
}

#[test]
fn a_side_without_success_lowers_the_chances_of_its_stars_by_bayes_and_no_others() {
    let mut order = SearchOrder::new();
    let field = fields().find(|measured| measured.len() == 32).unwrap();
    let (camera, catalogue) = (camera(), SKY.catalogue());
    let field = StarField::whole(&field, &catalogue, &camera);
    let mut tried = 0;
    while let Some(pair) = order.next(&field, &IdentificationParameters::default(), usize::MAX) {
        let before = order.probabilities;
        order.update_after_failure(&pair);
        let [i, j] = [pair.i, pair.j].map(usize::from);
        let [a, b] = [i, j].map(|star| f64::from(before[star]));
        // All four cases: both true but missed, one, the other, none.
        let (both, first, second, none) = (0.1 * a * b, a * (1.0 - b), b * (1.0 - a), (1.0 - a) * (1.0 - b));
        let all = both + first + second + none;
        for (star, expected) in [(i, (both + first) / all), (j, (both + second) / all)] {
            assert!((f64::from(order.probabilities[star]) - expected).abs() < 1e-6);
            assert!(order.probabilities[star] > 0.0 && order.probabilities[star] < before[star]);
        }
        assert!(
            (0..SEARCHED).all(|star| star == i || star == j || order.probabilities[star] == before[star])
        );
        tried += 1;
    }
    assert!(tried > 400, "{tried}");
}

#[test]
fn true_stars_meet_after_about_the_squared_ratio_of_all_to_them() {
    let (camera, catalogue) = (camera(), SKY.catalogue());
    let mut generator = Generator::new(41);
    // A field of 4 deg: every side is usable.
    let place = |at: f64| 300.0 + 460.0 * at as f32;
    for (all, truly) in [(32, 16), (32, 8), (24, 6), (16, 4)] {
        let (mut sum, mut most, tries) = (0, 0, 400);
        for _ in 0..tries {
            let spots: Vec<MeasuredStar> = (0..all)
                .map(|_| {
                    let at = [0, 1].map(|_| place(generator.between(0.0, 1.0)));
                    MeasuredStar::new(&camera, at, 0.3).unwrap()
                })
                .collect();
            let mut stars = BTreeSet::new();
            while stars.len() < truly {
                stars.insert(generator.between(0.0, f64::from(all)) as u8);
            }
            let field = StarField::whole(&spots, &catalogue, &camera);
            let mut order = SearchOrder::new();
            let mut sides = 0;
            while let Some(pair) = order.next(&field, &IdentificationParameters::default(), usize::MAX) {
                sides += 1;
                if stars.contains(&pair.i) && stars.contains(&pair.j) {
                    break;
                }
                order.update_after_failure(&pair);
            }
            sum += sides;
            most = most.max(sides);
        }
        let (mean, ratio) = (f64::from(sum) / f64::from(tries), f64::from(all) / truly as f64);
        std::println!("{truly} of {all}: mean {mean:.1}, most {most}");
        assert!(mean < 1.5 * ratio * ratio && f64::from(most) < 9.0 * ratio * ratio, "{mean}, {most}");
    }
}

#[test]
fn the_likeliest_untried_star_is_the_next_corner() {
    let mut order = SearchOrder::new();
    for (rank, chance) in order.probabilities.iter_mut().enumerate() {
        *chance = [0.3, 0.5, 0.2, 0.5][rank % 4];
    }
    for count in 0..=40usize {
        let (mut tried, mut given) = (0b10, Vec::new());
        while let Some(k) = order.likeliest(count, tried) {
            given.push(k);
            tried |= 1 << k;
        }
        let mut expected: Vec<u8> = (0..count.min(SEARCHED) as u8).filter(|k| *k != 1).collect();
        expected.sort_by_key(|k| [1, 0, 2, 0][usize::from(*k) % 4]);
        assert_eq!(given, expected);
    }
}

#[test]
fn a_full_field_with_every_side_usable_needs_no_more_room_than_there_is() {
    // Within 4 deg no side is too long; half a degree apart none is too short.
    let camera = camera();
    let grid = (0..6).flat_map(|row| (0..6).map(move |column| (row, column)));
    let measured: Vec<MeasuredStar> = grid
        .map(|(row, column)| {
            let centre_px = [300.0 + 77.0 * row as f32, 310.0 + 79.0 * column as f32];
            MeasuredStar::new(&camera, centre_px, 0.3).unwrap()
        })
        .collect();
    let catalogue = SKY.catalogue();
    let parameters = IdentificationParameters { centroid_sigma_px: [1.0; 3], ..Default::default() };
    let field = StarField::whole(&measured, &catalogue, &camera);
    let mut order = SearchOrder::new();
    let given = std::iter::from_fn(|| order.next(&field, &parameters, usize::MAX)).count();
    assert_eq!(given, 3 * 32 * 31 / 2);
    assert_eq!(given, MAX_SIDES);
}

#[test]
fn a_catalogue_without_pairs_gives_no_side() {
    let bytes = crate::catalog::sample::bytes(&[], 17, 1 << 28);
    for measured in fields() {
        assert!(all_given(&measured, &Catalogue::open(&bytes).unwrap(), usize::MAX).is_empty());
    }
}
