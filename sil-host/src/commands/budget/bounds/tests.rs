//! Bounds of made-up flights of a single second.

use super::super::flown::{Calls, ImageFigures, StackDepth, Work};
use super::super::{CROWDED_FIELD, WIDEST_LIMB};
use super::*;
use crate::commands::record::Instrument;
use crate::commands::record::mission::MISSION;
use fsw_core::stars::predict::MAX_FIELD_STARS;
use fsw_core::telemetry::AttitudeReport;

fn work(cycles: u64) -> Work {
    Work { cycles, ..Work::default() }
}

/// Calls of a function: how many, all together, the dearest.
fn calls((function, calls, all, most): (&str, u64, u64, u64)) -> (String, Calls) {
    (function.to_owned(), Calls { calls, work: work(all), most: work(most) })
}

/// A flight of a second that has one stage.
fn flown(name: &'static str, stage: Stage, cycles: u64, counted: &[(&str, u64, u64, u64)]) -> Flown {
    let counted = counted.iter().copied().map(calls).collect();
    let stages = BTreeMap::from([(stage as u8, MeteredStage { work: work(cycles), counted })]);
    let Instrument { geometry, parameters, .. } = MISSION.instrument().unwrap();
    Flown {
        name,
        camera: parameters.camera,
        geometry,
        disturbed: false,
        figures: ImageFigures { stack_bytes: 0, static_ram_bytes: 0, flash_bytes: 0 },
        depth: StackDepth { stack_bytes: 0 },
        start: Work::default(),
        seconds: vec![(MeteredCycle { work: work(cycles), stages }, Report::default())],
        telemetry_identical: true,
    }
}

/// A centre by as many points as there may be, and two triplets of 66.
const CENTRE: [(&str, u64, u64, u64); 3] = [
    ("Ray::new::{{closure}}", 48, 0, 0),
    ("consensus::inliers_of", 2, 3_000, 2_000),
    ("Departing::new", 6, 0, 0),
];

#[test]
fn passes_that_no_flight_has_are_added_as_dear_as_the_dearest() {
    let flights = [flown(WIDEST_LIMB, Stage::Centre, 100_000, &CENTRE)];
    let bounds = Bounds::new(&flights).unwrap();
    let centre = &bounds.stages()["centre"];
    assert_eq!(centre.bound_cycles, 100_000 - 3_000 + 66 * 2_000);
    assert_eq!((centre.worst_cycles, centre.kept()), (100_000, true));
    // The second itself at its caps.
    assert_eq!(bounds.of_second(&flights[0].seconds[0].0), centre.bound_cycles);
}

#[test]
fn a_stage_that_costs_more_than_its_bound_in_any_flight_is_told() {
    let cost = |cycles| {
        let other = flown("gyro", Stage::Centre, cycles, &[]);
        Bounds::new(&[flown(WIDEST_LIMB, Stage::Centre, 100_000, &CENTRE), other]).unwrap()
    };
    assert!(cost(229_000).stages()["centre"].kept());
    let dearer = cost(229_001);
    assert!(!dearer.stages()["centre"].kept() && dearer.stages()["centre"].short_of_caps().next().is_none());
}

#[test]
fn a_cap_that_is_neither_reached_nor_reckoned_is_told() {
    let [_, triplets, steps] = CENTRE;
    let fewer = [("Ray::new::{{closure}}", 46, 0, 0), triplets, steps];
    let bounds = Bounds::new(&[flown(WIDEST_LIMB, Stage::Centre, 100_000, &fewer)]).unwrap();
    let centre = &bounds.stages()["centre"];
    assert_eq!(centre.short_of_caps().collect::<Vec<_>>(), [("slopes of points", 46, 48)]);
    assert!(!centre.kept());
}

#[test]
fn what_goes_with_the_stars_of_the_field_is_reckoned_up_to_as_many_as_there_may_be() {
    let mut one = flown(CROWDED_FIELD, Stage::Predict, 100_000, &[]);
    let quaternion = [0.0, 0.0, 0.0, 1.0];
    one.seconds[0].1.attitude =
        Some(AttitudeReport { quaternion, sigma_rad: [1e-5; 3], log10_false: 0.0, age_s: 0 });
    let catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
    let attitude = Rotation::from_quaternion(quaternion).unwrap();
    let stars = field_stars(&catalogue, &Camera::new(one.camera).unwrap(), &attitude).unwrap().len() as u64;
    assert!((3..MAX_FIELD_STARS as u64).contains(&stars));
    let bounds = Bounds::new(&[one]).unwrap();
    let expected = (100_000 * MAX_FIELD_STARS as u64).div_ceil(stars);
    assert_eq!(bounds.stages()["predict"].bound_cycles, expected);
}
