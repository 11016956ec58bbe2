use super::*;
use crate::catalog::Catalogue;
use crate::oracle::Generator;
use crate::stars::Measured;
use crate::stars::artificial::{Picture, SKY, camera, camera_parameters, false_star};
use std::collections::BTreeSet;
use std::vec::Vec;

/// Tolerance, i, j and the number of catalogue pairs.
type Given = (usize, u8, u8, u16);
type Sides = BTreeSet<(u8, u8)>;

/// Everything an agenda gives, with the number of the tolerance, then its silence.
fn all_given(measured: &[Measured], catalogue: &Catalogue, capacity: usize) -> Vec<Given> {
    let camera = camera();
    let field = Field::whole(measured, catalogue, &camera);
    let parameters = IdentificationParameters::default();
    let mut agenda = Agenda::new();
    assert!(!agenda.any);
    let mut given = Vec::new();
    while let Some(task) = agenda.next(&field, &parameters, capacity) {
        given.push((agenda.step(), task.i, task.j, task.pairs));
        assert!(given.len() <= MAX_SIDES && agenda.tasks.len() <= MAX_TASKS);
    }
    assert_eq!(agenda.any, !given.is_empty());
    for _ in 0..100 {
        assert!(agenda.next(&field, &parameters, capacity).is_none());
        assert_eq!(agenda.step(), TOLERANCES - 1);
    }
    given
}

/// The sides to be given for one tolerance, by their chords in f64; and those too near a limit to tell.
fn worth_trying(
    measured: &[Measured],
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
fn fields() -> impl Iterator<Item = Vec<Measured>> {
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
                    given.iter().filter(|task| task.0 == step).map(|task| (task.1, task.2)).collect();
                let once: Sides = of_step.iter().copied().collect();
                assert_eq!(of_step.len(), once.len(), "a side was given twice");
                let (clear, doubtful) = worth_trying(&measured, &catalogue, capacity, sigma_px);
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
fn tolerances_widen_only_when_every_block_was_given() {
    for measured in fields() {
        let given = all_given(&measured, &SKY.catalogue(), usize::MAX);
        assert!(given.is_sorted_by_key(|task| task.0));
    }
}

#[test]
fn the_sides_among_the_eight_brightest_come_before_any_other_and_then_each_four_more_stars() {
    let mut whole_first_blocks = 0;
    for measured in fields() {
        let given = all_given(&measured, &SKY.catalogue(), usize::MAX);
        for step in 0..TOLERANCES {
            let of_step: Vec<&Given> = given.iter().filter(|task| task.0 == step).collect();
            // Stars 0 to 7 are the first block, 8 to 11 the second, and so on.
            assert!(of_step.is_sorted_by_key(|task| (task.2 / 4).max(1)));
            whole_first_blocks += usize::from(of_step.iter().filter(|task| task.2 < 8).count() == 28);
        }
        assert!(given.iter().all(|task| task.1 < task.2 && task.2 < 32));
    }
    assert!(whole_first_blocks > 0);
}

#[test]
fn within_a_block_the_side_with_the_fewest_catalogue_pairs_leads() {
    let mut falls_between_blocks = false;
    for measured in fields() {
        let given = all_given(&measured, &SKY.catalogue(), usize::MAX);
        for pair in given.windows(2) {
            let block = |task: &Given| (task.0, (task.2 / 4).max(1));
            if block(&pair[0]) == block(&pair[1]) {
                assert!(pair[0].3 <= pair[1].3);
            }
            falls_between_blocks |= pair[0].3 > pair[1].3;
        }
    }
    assert!(falls_between_blocks);
}

#[test]
fn a_full_field_with_every_side_usable_needs_no_more_room_than_there_is() {
    // Within 4 deg no side is too long; half a degree apart none is too short.
    let camera = camera();
    let grid = (0..6).flat_map(|row| (0..6).map(move |column| (row, column)));
    let measured: Vec<Measured> = grid
        .map(|(row, column)| {
            let centre_px = [300.0 + 77.0 * row as f32, 310.0 + 79.0 * column as f32];
            Measured::new(&camera, centre_px, 0.3).unwrap()
        })
        .collect();
    let catalogue = SKY.catalogue();
    let parameters = IdentificationParameters { centroid_sigma_px: [1.0; 3], ..Default::default() };
    let field = Field::whole(&measured, &catalogue, &camera);
    let mut agenda = Agenda::new();
    let given = std::iter::from_fn(|| agenda.next(&field, &parameters, usize::MAX)).count();
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
