//! The orbit in the sensor's second: how it begins, and what faults, commands and gaps do to it.

use super::world::{World, fly, has, modes, quietly};
use fsw_core::earth::FitError;
use fsw_core::modes::{Guard, Mode};
use fsw_core::sensor::{Command, INSTANTS_US};
use fsw_core::telemetry::{
    Activity, ClockFault, ClockState, DetectorFault, EarthStatus, Event, Outcome, Report,
};
use sil_host::judge::attitude_error;
use sil_host::world::motion::trajectory;

/// Angle between unit vectors, rad.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let chord = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    2.0 * (0.5 * chord).asin()
}

/// Distance of the reported from the true position and its sigma, km.
pub(super) fn orbit_error_km(report: &Report, truth: &trajectory::Truth) -> (f64, f64) {
    let orbit = report.orbit.as_ref().expect("the orbit is known");
    let square = |parts: [f64; 3]| parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    let error = [0, 1, 2].map(|axis| orbit.position_km[axis] - truth.position_km[axis]);
    (square(error), square(orbit.sigma_position_km.map(f64::from)))
}

/// Seconds of a clip by which stars, Earth and orbit are at hand.
const SETTLED_S: usize = 12;

/// Insists on an attitude within five sigma of the truth in every axis.
fn check_attitude(name: &str, second: usize, report: &Report, truth: &trajectory::Truth) {
    let attitude = report.attitude.as_ref().expect("an attitude every second");
    for (error, sigma) in attitude_error(attitude.quaternion, truth.quaternion).iter().zip(attitude.sigma_rad)
    {
        assert!(error.abs() < 5.0 * f64::from(sigma), "{name} {second}: attitude off by {error} of {sigma}");
    }
}

#[test]
fn a_clip_of_every_kind_of_orbit_leads_to_attitude_earth_and_orbit_with_honest_sigmas() {
    for name in ["geo-eclipse", "leo-oblique"] {
        let mut world = World::clip_with_orbit(name);
        let reports = quietly(&mut world, 40);
        assert_eq!(modes(&reports[..3]), [Mode::SelfTest, Mode::Acquisition, Mode::Acquisition], "{name}");
        assert!(modes(&reports[3..]).iter().all(|mode| *mode == Mode::Tracking), "{name}");
        let mut found = 0;
        for (second, report) in reports.iter().enumerate().skip(1) {
            let truth = world.truth(second);
            check_attitude(name, second, report, &truth);
            let (error, sigma) = orbit_error_km(report, &truth);
            assert!(error < 5.0 * sigma, "{name} {second}: off by {error} km of {sigma}");
            if let Some(earth) = &report.earth {
                assert_eq!(report.earth_status, EarthStatus::Found);
                found += 1;
                let distance = truth.position_km.iter().map(|part| part * part).sum::<f64>().sqrt();
                let down = truth.position_km.map(|part| -part / distance);
                let seen = truth.earth_path.map(|row| row.iter().zip(&down).map(|(a, b)| a * b).sum());
                let off = angle(earth.direction.map(f64::from), seen);
                // Clouds and the slant of the light are not in this sigma.
                assert!(
                    off < 5.0 * 3.2 * f64::from(earth.sigma_rad),
                    "{name} {second}: {off} of {}",
                    earth.sigma_rad
                );
            }
        }
        println!("{name}: Earth found in {found} of 40");
        assert!(found >= 39, "{name}: {found}");
    }
}

#[test]
fn an_orbit_begins_with_the_images_alone_and_is_not_told_before_it_is_known() {
    // The arc must be long enough for the velocity: about ten minutes in a low orbit, half an hour in GEO.
    for (name, longest_s) in [("leo-oblique", 900), ("geo-eclipse", 2_400)] {
        let mut world = World::clip(name);
        let reports = quietly(&mut world, longest_s);
        let started = reports.iter().position(|report| has(report, Event::OrbitStarted)).expect("it begins");
        println!("{name}: orbit started in second {started}");
        assert!(reports[..started].iter().all(|report| report.orbit.is_none()), "{name}");
        // It is brought to the present in the next second.
        for (second, report) in reports.iter().enumerate().skip(started + 1) {
            assert!(!has(report, Event::OrbitStarted), "{name} {second}");
            let (error, sigma) = orbit_error_km(report, &world.truth(second));
            assert!(error < 5.0 * sigma, "{name} {second}: off by {error} km of {sigma}");
        }
    }
}

#[test]
fn before_the_orbit_is_known_the_earth_is_followed_in_strips_about_the_last_fix() {
    // In a low orbit the place after a second is less sure, in some seconds too unsure for strips.
    for (name, searches) in [("leo-oblique", 6), ("geo-eclipse", 0)] {
        let before = |second: u32, world: &mut World| {
            world.strips_covered = (20..25).contains(&second);
            Command::Continue
        };
        let mut searched = Vec::new();
        let reports = fly(&mut World::clip(name), 60, before, |_, world| searched.push(world.searched));
        assert!(reports.iter().all(|report| report.orbit.is_none()), "{name}");
        // Some are known too badly to be told; the next second looks about them all the same.
        let found = |second: usize| {
            let status = reports[second].earth_status;
            status == EarthStatus::Found || status == EarthStatus::Refused(FitError::Uncertain)
        };
        let first = (0..20).position(found).unwrap();
        assert!(searched[first] && first < 5, "{name}: {first}");
        let quiet = || (first + 1..20).chain(28..60);
        let count = quiet().filter(|second| searched[*second]).count();
        println!("{name}: searched in {count} seconds of {}", quiet().count());
        assert!(quiet().all(found) && count <= searches, "{name}: {searched:?}");
        // After three misses the whole detector is searched, at once.
        let after = (20..25).position(|second| searched[second]).unwrap();
        assert!(after == 3 || name == "leo-oblique" && after < 3, "{name}: {searched:?}");
    }
}

#[test]
fn a_search_for_the_earth_that_finds_nothing_for_a_minute_is_made_in_one_of_eight_seconds() {
    let mut world = World::clip("geo-eclipse");
    // No limb anywhere, but all stars.
    world.limb_covered = true;
    let mut searched = Vec::new();
    let reports = fly(&mut world, 120, |_, _| Command::Continue, |_, world| searched.push(world.searched));
    let looked = reports.iter().position(|report| report.earth_status != EarthStatus::NotLooked).unwrap();
    assert!(searched[looked..looked + 60].iter().all(|searched| *searched));
    assert_eq!(searched[looked + 60..looked + 60 + 48].iter().filter(|searched| **searched).count(), 6);
}

#[test]
fn a_clock_out_of_its_mind_is_a_fault_that_loses_nothing() {
    for wrong in [i64::MIN, INSTANTS_US.0 - 1, INSTANTS_US.1 + 1, i64::MAX] {
        let mut world = World::clip_with_orbit("geo-eclipse");
        let start_us = world.instant_us;
        let before = |second: u32, world: &mut World| {
            world.instant_us = if second == 12 { wrong } else { start_us + i64::from(second) * 1_000_000 };
            Command::Continue
        };
        let reports = fly(&mut world, 14, before, |_, _| {});
        // Terrestrial Time goes on by the counter.
        assert_eq!(reports[12].faults.clock, Some(ClockFault::Implausible), "{wrong}");
        assert_eq!(reports[12].instant_us, Some(start_us + 12_000_000));
        assert_eq!((reports[12].clock, reports[13].clock), (ClockState::Holdover, ClockState::Synchronised));
        for report in &reports[12..] {
            assert_eq!((report.mode, report.outcome), (Mode::Tracking, Some(Outcome::Tracked)));
            assert!(report.orbit.is_some() && !has(report, Event::OrbitStarted));
            assert!(!has(report, Event::ClockJump));
        }
    }
}

#[test]
fn a_step_of_the_clock_is_reported_and_moves_neither_attitude_nor_orbit() {
    for step_s in [3, -3, 600, -600, 3_600, -3_600] {
        let mut world = World::clip_with_orbit("geo-eclipse");
        let before = |second: u32, world: &mut World| {
            if second == 12 {
                // The world goes on as it did; its clock does not.
                world.instant_us += step_s * 1_000_000;
            }
            Command::Continue
        };
        let reports = fly(&mut world, 16, before, |_, _| {});
        for (second, report) in reports.iter().enumerate().skip(SETTLED_S) {
            assert_eq!(has(report, Event::ClockJump), second == 12, "{step_s}");
            assert_eq!((report.mode, report.outcome), (Mode::Tracking, Some(Outcome::Tracked)), "{step_s}");
            assert!(!has(report, Event::OrbitForgotten) && !has(report, Event::OrbitStarted), "{step_s}");
            let (error, sigma) = orbit_error_km(report, &world.truth(second));
            assert!(error < 5.0 * sigma, "{step_s}, {second}: off by {error} km of {sigma}");
            let attitude = report.attitude.as_ref().expect("tracked");
            let error = attitude_error(attitude.quaternion, world.truth(second).quaternion);
            let sigmas = (0..3).map(|axis| (error[axis] / f64::from(attitude.sigma_rad[axis])).abs());
            assert!(sigmas.fold(0.0, f64::max) < 5.0, "{step_s}, {second}: {error:?}");
        }
    }
}

#[test]
fn an_orbit_is_propagated_over_a_gap_of_two_hours_and_forgotten_after_a_longer_one() {
    for (gap_s, forgets) in [(7_100, false), (7_300, true)] {
        let mut world = World::clip_with_orbit("geo-eclipse");
        let before = |second: u32, world: &mut World| {
            if second == 12 {
                world.second += gap_s;
                world.instant_us += gap_s as i64 * 1_000_000;
            }
            Command::Continue
        };
        let reports = fly(&mut world, 40, before, |_, _| {});
        assert!(reports[11].orbit.is_some() && !has(&reports[12], Event::ClockJump), "{gap_s}");
        assert_eq!(has(&reports[12], Event::OrbitForgotten), forgets, "{gap_s}");
        // It is crossed in spans, some a second; meanwhile no orbit is told.
        assert!(reports[12].orbit.is_none());
        let back = reports.iter().skip(12).position(|report| report.orbit.is_some());
        assert_eq!(back.is_none(), forgets, "{gap_s}");
        for (second, report) in reports.iter().enumerate().skip(12 + back.unwrap_or(reports.len())) {
            let (error, sigma) = orbit_error_km(report, &world.truth(second + gap_s as usize));
            assert!(error < 5.0 * sigma, "{gap_s}, {second}: off by {error} km of {sigma}");
        }
    }
}

/// Modes that were commanded, and in which seconds.
fn commanded(reports: &[Report]) -> Vec<(usize, Mode)> {
    let modes = |report: &Report| {
        let commanded = report.events.iter().filter_map(|event| match event {
            Event::Mode(mode, Guard::Commanded) => Some(*mode),
            _ => None,
        });
        commanded.collect::<Vec<_>>()
    };
    let reported = reports
        .iter()
        .enumerate()
        .flat_map(|(second, report)| modes(report).into_iter().map(move |mode| (second, mode)));
    reported.collect()
}

#[test]
fn a_command_to_reacquire_forgets_the_attitude_and_keeps_the_orbit() {
    let before =
        |second: u32, _: &mut World| if second == 12 { Command::Reacquire } else { Command::Continue };
    let reports = fly(&mut World::clip_with_orbit("geo-eclipse"), 18, before, |_, _| {});
    assert_eq!(reports[11].mode, Mode::Tracking);
    assert_eq!(reports[12].mode, Mode::Acquisition);
    // The scan leaves little of its second to identification, which may need the next one too.
    assert!(reports[12..14].iter().any(|report| report.outcome == Some(Outcome::Identified)));
    assert!(reports[12].rate_rad_s.is_none(), "the rate belongs to the attitude");
    assert_eq!(commanded(&reports), [(12, Mode::Acquisition)]);
    assert!(reports[12].orbit.is_some());
    assert_eq!(reports[17].mode, Mode::Tracking);
    assert!(reports[12..].iter().all(|report| !has(report, Event::OrbitStarted)));
}

#[test]
fn a_command_to_restart_forgets_attitude_and_orbit_and_begins_with_the_self_test() {
    let before = |second: u32, _: &mut World| if second == 12 { Command::Restart } else { Command::Continue };
    let reports = fly(&mut World::clip_with_orbit("geo-eclipse"), 24, before, |_, _| {});
    assert!(reports[11].orbit.is_some());
    assert_eq!((reports[12].mode, reports[12].outcome), (Mode::SelfTest, Some(Outcome::SelfTestPassed)));
    assert_eq!(commanded(&reports), [(12, Mode::SelfTest)]);
    assert!(reports[12].attitude.is_none() && reports[12].orbit.is_none());
    assert_eq!(reports[13].mode, Mode::Acquisition);
    assert!(reports[13..15].iter().any(|report| report.outcome == Some(Outcome::Identified)));
    // What the ground told is forgotten too: the orbit begins anew with the images, which takes longer.
    assert!(reports[12..].iter().all(|report| report.orbit.is_none()));
}

#[test]
fn a_command_to_safe_mode_forgets_the_attitude_propagates_the_orbit_and_holds_until_the_next_command() {
    let mut world = World::clip_with_orbit("geo-eclipse");
    world.parameters.modes.healthy_s = 2;
    let before = |second: u32, _: &mut World| match second {
        12 => Command::Safe,
        17 => Command::Reacquire,
        _ => Command::Continue,
    };
    let reports = fly(&mut world, 22, before, |_, _| {});
    for (second, report) in reports.iter().enumerate().take(17).skip(12) {
        assert_eq!((report.mode, report.activity), (Mode::CommandedSafe, Activity::Waiting), "{second}");
        assert!(report.attitude.is_none() && report.earth.is_none());
        let orbit = report.orbit.as_ref().expect("the orbit is propagated");
        let before = reports[second - 1].orbit.as_ref().expect("as in every second");
        assert_eq!(orbit.since_fix_s, before.since_fix_s + 1);
    }
    assert_eq!(commanded(&reports), [(12, Mode::CommandedSafe), (17, Mode::Acquisition)]);
    assert_eq!(reports[21].mode, Mode::Tracking);
    assert!(reports[12..].iter().all(|report| !has(report, Event::OrbitStarted)), "the orbit was kept");
}

/// Whether an observation was taken into the orbit in this second.
fn observed(report: &Report) -> bool {
    report.orbit.as_ref().is_some_and(|orbit| orbit.nis.is_some() && orbit.since_fix_s == 0)
}

#[test]
fn a_second_without_a_limb_loses_neither_attitude_nor_orbit() {
    let before = |second: u32, world: &mut World| {
        world.strips_covered = second == 50;
        Command::Continue
    };
    // In a low orbit an observation is made of some seconds.
    let mut world = World::clip_with_orbit("leo-oblique");
    let reports = fly(&mut world, 90, before, |_, _| {});
    assert_eq!(reports[49].earth_status, EarthStatus::Found);
    assert!(matches!(reports[50].earth_status, EarthStatus::Refused(_)), "{:?}", reports[50].earth_status);
    assert_eq!((reports[50].outcome, reports[50].mode), (Some(Outcome::Tracked), Mode::Tracking));
    assert!(reports[50].orbit.is_some());
    assert_eq!(reports[51].earth_status, EarthStatus::Found);
    assert!(reports[..50].iter().any(observed) && reports[51..].iter().any(observed));
}

#[test]
fn a_detector_that_fails_at_the_limb_alone_is_reported_and_the_attitude_stays() {
    let before = |second: u32, world: &mut World| {
        world.strips_fail = second == 14;
        Command::Continue
    };
    let reports = fly(&mut World::clip_with_orbit("geo-eclipse"), 16, before, |_, _| {});
    assert_eq!(reports[14].faults.detector, Some(DetectorFault::Hardware));
    assert!(reports[14].attitude.is_some() && reports[14].orbit.is_some() && reports[14].earth.is_none());
    assert_eq!((reports[15].mode, reports[15].outcome), (Mode::Tracking, Some(Outcome::Tracked)));
    assert_eq!(reports[15].earth_status, EarthStatus::Found);
}

#[test]
fn an_earth_in_a_wrong_place_does_not_lead_the_orbit_astray() {
    // Every strip shows what stands so many px beside it: 25 are half a degree.
    for (name, shift_px) in [("geo-eclipse", 25), ("leo-oblique", 25), ("leo-oblique", 5)] {
        let before = |second: u32, world: &mut World| {
            world.strips_shifted_px = if (40..60).contains(&second) { shift_px } else { 0 };
            Command::Continue
        };
        let mut world = World::clip_with_orbit(name);
        let reports = fly(&mut world, 120, before, |_, _| {});
        for (second, report) in reports.iter().enumerate().skip(SETTLED_S) {
            assert_eq!(report.outcome, Some(Outcome::Tracked));
            let (error, sigma) = orbit_error_km(report, &world.truth(second));
            if observed(report) {
                let nis = report.orbit.as_ref().and_then(|orbit| orbit.nis);
                println!(
                    "{name}, {shift_px} px, second {second}: off by {error:.1} km, sigma {sigma:.1}, {nis:?}"
                );
            }
            assert!(error < 5.0 * sigma, "{name} {second}: {error} of {sigma}");
            assert!(!has(report, Event::OrbitStarted) && !has(report, Event::OrbitRestarted));
        }
        assert_eq!(reports[119].earth_status, EarthStatus::Found);
    }
}
