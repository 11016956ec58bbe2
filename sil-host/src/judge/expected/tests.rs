use super::super::second::{Axes, Correlated, OrbitError};
use super::*;

/// An orbit without error.
fn orbit() -> OrbitError {
    let axes = Axes { error: [0.0; 3], sigma: [1.0; 3] };
    let axes = Correlated { axes, correlation: [0.0; 3], deviates: [0.0; 3] };
    OrbitError {
        position_km: axes,
        velocity_km_s: axes,
        limb_height_km: [0.0, 1.0],
        nis: None,
        settled: true,
        since_fix_s: 0,
    }
}

fn second(cycle: u32, mode: Mode, state: SensorState) -> Judged {
    Judged {
        cycle,
        mode,
        state,
        lit_limb_deg: if state == SensorState::Full { 180.0 } else { 0.0 },
        rate_deg_s: 0.06,
        orbit: Some(orbit()),
        ..Judged::default()
    }
}

/// Judges stretches of (seconds, mode, state) in a row.
fn judged(stretches: &[(u32, Mode, SensorState)]) -> ModeJudge {
    let mut judge = ModeJudge::default();
    let mut cycle = 0;
    for (seconds, mode, state) in stretches {
        for _ in 0..*seconds {
            judge.add(&second(cycle, *mode, *state));
            cycle += 1;
        }
    }
    judge
}

use Mode::{Acquisition, Eclipse, Safe, SelfTest, SunOutage, Tracking};
use SensorState::{Eclipse as Dark, Full, SunInEarthPath, SunInStarPath};

#[test]
fn a_run_that_follows_the_geometry_within_the_grace_is_all_right() {
    let judge = judged(&[
        (1, SelfTest, Full),
        (3, Acquisition, Full),
        (100, Tracking, Full),
        (1, Tracking, SunInEarthPath),
        (99, SunOutage, SunInEarthPath),
        (1, SunOutage, Dark),
        (4, Tracking, Dark),
        (95, Eclipse, Dark),
        (1, Eclipse, SunInStarPath),
        (50, SunOutage, SunInStarPath),
        (1, SunOutage, Full),
        (5, Acquisition, Full),
        (60, Tracking, Full),
    ]);
    assert_eq!(judge.share(), Some(1.0));
    assert!(judge.disagreements().is_empty());
}

#[test]
fn a_mode_that_stays_behind_is_wrong_after_the_grace() {
    let judge = judged(&[(100, Tracking, Full), (30, Tracking, Dark), (70, Eclipse, Dark)]);
    assert_eq!(judge.share(), Some(180.0 / 200.0));
    let stretch = Disagreement { from_s: 110, seconds: 20, mode: "tracking", expected: "eclipse" };
    assert_eq!(judge.disagreements(), [stretch]);
}

#[test]
fn a_lost_attitude_without_a_change_of_the_geometry_is_wrong_at_once() {
    let judge =
        judged(&[(100, Tracking, Full), (7, Acquisition, Full), (2, Safe, Full), (91, Tracking, Full)]);
    assert_eq!(judge.share(), Some(191.0 / 200.0));
    assert_eq!(judge.disagreements()[0].seconds, 9);
}

#[test]
fn the_self_test_belongs_to_the_start_only_and_safe_to_nowhere() {
    let judge = judged(&[(100, Tracking, Full), (5, SelfTest, Dark), (5, Safe, Dark)]);
    assert_eq!(judge.share(), Some(100.0 / 110.0));
}

#[test]
fn a_faint_arc_may_be_called_light_or_dark_but_nothing_else() {
    let mut judge = ModeJudge::default();
    for cycle in 0..60 {
        let mode = [Tracking, Eclipse, SunOutage][cycle as usize % 3];
        let faint = Judged { lit_limb_deg: 4.0, ..second(cycle, mode, Full) };
        let right = judge.add(&faint);
        assert_eq!(right, mode != SunOutage, "{cycle}");
    }
    assert_eq!(judge.faint_s(), 60);
}

#[test]
fn an_earth_in_the_star_path_may_be_taken_for_the_sun() {
    let mut judge = ModeJudge::default();
    let run = |judge: &mut ModeJudge, cycles: std::ops::Range<u32>, flooded: bool| {
        cycles
            .filter(|cycle| {
                let outage = second(*cycle, Mode::SunOutage, Full);
                judge.add(&Judged { earth_in_star_path: flooded, ..outage })
            })
            .count()
    };
    assert_eq!(run(&mut judge, 100..200, true), 100);
    assert_eq!(run(&mut judge, 200..300, false), 0);
}

#[test]
fn while_the_sensor_turns_too_fast_only_a_claim_of_the_sun_is_wrong() {
    let mut judge = ModeJudge::default();
    let fast = |cycle, mode, rate_deg_s| Judged { rate_deg_s, ..second(cycle, mode, Full) };
    let modes = [SelfTest, Acquisition, Tracking, Eclipse, Safe];
    for cycle in 0..50 {
        assert!(judge.add(&fast(cycle, modes[cycle as usize % 5], 2.0 * TRACKABLE_DEG_S)), "{cycle}");
    }
    assert!(!judge.add(&fast(50, SunOutage, 4.0)));
    // At rest again: the grace, then the geometry.
    assert!(judge.add(&fast(51, Acquisition, 0.5 * TRACKABLE_DEG_S)));
    assert!(judge.add(&fast(60, Acquisition, 0.0)));
    assert!(!judge.add(&fast(61, Acquisition, 0.0)));
    assert!(judge.add(&fast(62, Tracking, 0.0)));
    assert_eq!(judge.fast_s(), 51);
}

#[test]
fn without_an_orbit_a_sensor_may_go_on_searching_where_there_is_no_limb() {
    let (mut knowing, mut blind) = (ModeJudge::default(), ModeJudge::default());
    for cycle in 0..100 {
        let tracking = second(cycle, Tracking, Dark);
        knowing.add(&tracking);
        assert!(blind.add(&Judged { orbit: None, ..tracking }));
    }
    assert_eq!(knowing.share(), Some(0.1));
}

#[test]
fn the_sun_is_expected_however_fast_the_sensor_turns() {
    let mut judge = judged(&[(100, Tracking, Full)]);
    for cycle in 100..130 {
        let fast = Judged { rate_deg_s: 5.0, ..second(cycle, SunOutage, SunInEarthPath) };
        assert!(judge.add(&fast));
    }
    assert_eq!(judge.fast_s(), 0);
}

#[test]
fn only_the_longest_disagreements_are_kept() {
    let mut stretches = vec![(50, Tracking, Full)];
    for length in 1..=30 {
        stretches.extend([(length, Safe, Full), (5, Tracking, Full)]);
    }
    let kept = judged(&stretches).disagreements();
    assert_eq!(kept.len(), KEPT);
    assert_eq!((kept[0].seconds, kept[KEPT - 1].seconds), (30, 30 - KEPT as u32 + 1));
}
