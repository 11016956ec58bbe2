use super::*;
use crate::image::detections::tests::SPOT;

const DARK: i32 = 300;
const LIT: i32 = DARK + 3 * SAME_SKY;

/// A round star, or one that is drawn out.
fn spot(drawn_px: u8) -> Detection {
    Detection { drawn_px, ..SPOT }
}

/// Adds round stars, drawn ones and streaks against one background.
fn add(evidence: &mut Evidence, background: i32, [round, drawn, streaks]: [u16; 3]) {
    for _ in 0..round {
        evidence.note_spot(&spot(0), background, true, false);
    }
    for _ in 0..drawn {
        evidence.note_spot(&spot(5), background, true, false);
    }
    for index in 0..streaks {
        evidence.note_streak([40 * index, 7], background);
    }
}

/// What the sky says, with clouds found before it, after it, or between its spots.
fn with_clouds(sky: [u16; 3], clouds: [u16; 3]) -> [Smear; 3] {
    let mut evidence = [const { Evidence::new() }; 3];
    let [before, after, between] = &mut evidence;
    add(before, LIT, clouds);
    add(before, DARK, sky);
    add(after, DARK, sky);
    add(after, LIT, clouds);
    for part in 0..3 {
        let only = |all: [u16; 3]| core::array::from_fn(|kind| if kind == part { all[kind] } else { 0 });
        add(between, LIT, only(clouds));
        add(between, DARK + part as i32, only(sky));
    }
    evidence.map(|evidence| evidence.smear(2))
}

#[test]
fn clouds_do_not_say_how_the_sensor_turns_whatever_is_found_first() {
    for clouds in [[0, 3, 9], [0, 9, 2], [20, 0, 0], [4, 4, 4]] {
        assert_eq!(with_clouds([6, 0, 0], clouds), [Smear::Points; 3], "{clouds:?}");
        assert_eq!(with_clouds([1, 5, 1], clouds), [Smear::Drawn; 3], "{clouds:?}");
        assert_eq!(with_clouds([1, 1, 5], clouds), [Smear::Streaks; 3], "{clouds:?}");
    }
}

#[test]
fn the_places_of_clouds_are_no_streaks_to_be_measured() {
    let mut evidence = Evidence::new();
    evidence.note_streak([900, 900], LIT);
    evidence.note_streak([100, 100], DARK);
    evidence.note_streak([500, 500], LIT);
    assert_eq!(evidence.streak_places(), [[100, 100]]);
    assert_eq!(evidence.streaks(), 1);
}

#[test]
fn where_no_sky_is_dark_what_is_there_is_counted() {
    let mut evidence = Evidence::new();
    add(&mut evidence, FULL_SCALE / 2, [1, 1, 5]);
    assert_eq!(evidence.smear(2), Smear::Streaks);
}
