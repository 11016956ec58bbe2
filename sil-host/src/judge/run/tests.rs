use super::*;
use crate::judge::Limit;
use crate::judge::Verdict;
use crate::judge::second::{Axes, Correlated, OrbitError, TurningError};
use crate::judge::table;
use crate::world::scene::SensorState;
use fsw_core::modes::Mode;

/// A second whose position is wrong by `error_km` on the first axis, with a sigma of 2 km.
fn second(cycle: u32, error_km: f64, settled: bool) -> Judged {
    let axes = |error| Correlated {
        axes: Axes { error: [error, 0.0, 0.0], sigma: [2.0; 3] },
        correlation: [0.0; 3],
        deviates: [0.5 * error, 0.0, 0.0],
    };
    let orbit = OrbitError {
        position_km: axes(error_km),
        velocity_km_s: axes(0.003),
        limb_height_km: [0.0, 1.0],
        nis: None,
        settled,
        since_fix_s: 7,
    };
    Judged {
        cycle,
        mode: Mode::Tracking,
        state: SensorState::Full,
        told_state: Some(fsw_core::outages::SensorState::Full),
        lit_limb_deg: 180.0,
        rate_deg_s: 0.06,
        attitude_rad: (cycle > 3).then_some(Axes { error: [1e-6, 0.0, 4e-6], sigma: [1e-6; 3] }),
        filtered_rad: (cycle > 4).then_some(Axes { error: [1e-6, 2e-6, -1e-6], sigma: [1e-6; 3] }),
        turning: (cycle <= 3).then_some(TurningError {
            rad_s: Axes { error: [1e-6, 0.0, 4e-6], sigma: [2e-6; 3] },
            size: -0.01 * f64::from(cycle),
            axis_deg: 0.25,
            either_sense: false,
        }),
        orbit: Some(orbit),
        mounting_rad: Some(Axes { error: [1e-5, 0.0, -1e-5], sigma: [2e-5; 3] }),
        stars: 5,
        detections: 5,
        ..Judged::default()
    }
}

#[test]
fn figures_are_those_counted_by_hand() {
    let mut judge = Judge::new(20, 8.0);
    for cycle in 0..20 {
        // Half a sigma, unsettled for five seconds, and a jump to 7 km in second 15.
        let error_km = if cycle < 15 { 1.0 } else { 7.0 };
        judge.add(&second(cycle, error_km, cycle >= 5));
        judge.add_position_bound(cycle, (cycle >= 10).then_some([1.0, 2.0, 2.0]));
    }
    let figures = judge.finish();
    assert_eq!((figures.seconds, figures.first_attitude_s), (20, Some(5)));
    assert_eq!(figures.attitude_valid_share, Some(0.8));
    // 4 sigma about z in every second.
    assert_eq!(figures.within_3_sigma_share, Some(0.0));
    let filtered = &figures.filtered;
    assert_eq!((filtered.within_3_sigma_share, filtered.normalised_square), (Some(1.0), Some(2.0)));
    assert!((filtered.rms_arcsec.unwrap()[1] / 0.412_53 - 1.0).abs() < 1e-5);
    let orbit = &figures.orbit;
    assert_eq!((orbit.settled_s, orbit.longest_without_fix_s), (Some(6), 7));
    assert_eq!((orbit.position_jump_sigma, orbit.position_jump_at_s), (Some(3.0), Some(15)));
    // Fifteen seconds at half a sigma, five at 3.5.
    assert_eq!(orbit.position_within_3_sigma_share, Some(0.75));
    let square = (15.0 * 0.25 + 5.0 * 12.25) / 60.0;
    assert!((orbit.position_normalised_square.unwrap() - square).abs() < 1e-12);
    // The last orbit: seconds 12 to 19.
    let rms = ((3.0 + 5.0 * 49.0) / 8.0f64).sqrt();
    assert!((orbit.last_orbit_position_km.unwrap() - rms).abs() < 1e-12);
    // Orbits end in seconds 7 and 15; the bound was 3 km.
    assert_eq!(orbit.orbit_bounds_rac_km, [None, Some([1.0, 2.0, 2.0])]);
    assert_eq!(orbit.last_orbit_bound_km, Some(3.0));
    let bounds = table::figure("last_orbit_position_bounds").unwrap();
    assert!(((bounds.of)(&figures).unwrap() - rms / 3.0).abs() < 1e-12);
    assert!((orbit.last_orbit_velocity_m_s.unwrap() - 3.0).abs() < 1e-12);
    assert_eq!(orbit.final_position_km, Some(7.0));
}

#[test]
fn every_limit_has_a_figure_and_one_without_a_figure_is_missed() {
    let figures = Figures::default();
    for of in table::figures().filter(|of| of.key != "not_finite") {
        let value = of.range.1;
        let verdict = Verdict::new(&Limit { of, value }, &figures);
        // Of what was never told nothing was wrong.
        let none_wrong =
            ["_worst_sigma", "_beyond_4_sigma_share"].iter().any(|end| of.key.ends_with(end)).then_some(0.0);
        assert_eq!((verdict.kept, verdict.reached), (none_wrong.is_some(), none_wrong), "{}", of.key);
    }
    let mut judge = Judge::new(20, 8.0);
    (0..20).for_each(|cycle| {
        judge.add(&second(cycle, 1.0, true));
        judge.add_position_bound(cycle, Some([1.0; 3]));
    });
    let figures = judge.finish();
    let without = ["earth_", "sun_", "dark_", "next_", "nis_", "mode_latest", "rate_95", "rate_sigma"];
    let absent = |key: &str| without.iter().any(|start| key.starts_with(start));
    for of in table::figures().filter(|of| !absent(of.key)) {
        assert!((of.of)(&figures).is_some(), "{}", of.key);
    }
}

#[test]
fn changes_of_the_mode_are_counted_within_ten_seconds() {
    let mut judge = Judge::new(60, 8.0);
    // Three changes in seconds 20 to 22, a fourth in second 29, a fifth in second 30.
    for cycle in 0..60 {
        let tracking = [21, 29].contains(&cycle) || !(20..40).contains(&cycle);
        judge.add(&Judged {
            mode: if tracking { Mode::Tracking } else { Mode::Acquisition },
            ..second(cycle, 1.0, true)
        });
    }
    assert_eq!(judge.finish().mode_changes_10_s, Some(4));
}

#[test]
fn a_change_of_the_mode_by_command_is_not_the_sensors() {
    let mut judge = Judge::new(60, 8.0);
    // Two changes of its own in seconds 20 and 21; restarted in second 23, then out of the self-test, and two
    // more: the first attitude, and one into a self-test without a command.
    for cycle in 0..60 {
        let mode = match cycle {
            20 | 24 => Mode::Acquisition,
            23 | 28 => Mode::SelfTest,
            _ => Mode::Tracking,
        };
        judge.add(&Judged { mode, commanded: cycle == 23, ..second(cycle, 1.0, true) });
    }
    assert_eq!(judge.finish().mode_changes_10_s, Some(2));
}

#[test]
fn orbit_axes_are_up_ahead_and_along_the_normal() {
    let axes = crate::judge::second::orbit_axes([7000.0, 0.0, 0.0], [1.0, 0.0, 7.0]).unwrap();
    assert_eq!(axes, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
    assert!(crate::judge::second::orbit_axes([0.0; 3], [1.0, 0.0, 0.0]).is_none());
}
