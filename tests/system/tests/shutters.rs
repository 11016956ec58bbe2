//! Shutters against the Sun, flown from pixels: the scenario's two hours and a half in GEO, in which the Sun
//! crosses the Earth path from second 1,468 to 2,398 and from 6,445 to 7,375 with the Earth dark in between.

use crate::flights::{self, scenario};
use fsw_core::shutting::{ShutterParameters, Shutters};
use fsw_core::telemetry::Outcome;
use fsw_hal::OpenPaths;
use sil_host::harness::faults::{Fault, FaultKind};
use sil_host::scenario::Scenario;
use sil_host::world::motion::slew::Slew;
use std::ops::Range;
use std::path::Path;

/// The Sun is in the Earth path.
const SUN_S: Range<u32> = 1468..2399;

/// A second that was flown.
struct Flown {
    cycle: u32,
    /// The Sun is in a path.
    sun: bool,
    star_path_shut: bool,
    earth_path_shut: bool,
    blinded: bool,
    /// The image of this second gave an attitude.
    measured: bool,
    /// Largest error of the attitude that is told, over its sigma.
    worst_sigma: f64,
    /// Sigma of its second best axis, arcsec; of the two axes across the Earth, where that holds it.
    second_best_arcsec: Option<f64>,
}

fn fly(name: &str, seconds: u32, change: impl FnOnce(&mut Scenario)) -> Vec<Flown> {
    let mut scenario = scenario(name, seconds);
    change(&mut scenario);
    let mut flown = Vec::new();
    flights::fly(&scenario, |second| {
        let report = second.report;
        flown.push(Flown {
            cycle: second.cycle,
            sun: second.truth.state.is_blinded(),
            star_path_shut: report.star_path_shut,
            earth_path_shut: report.earth_path_shut,
            blinded: report.outcome == Some(Outcome::Blinded),
            measured: matches!(report.outcome, Some(Outcome::Tracked | Outcome::Identified)),
            worst_sigma: second.judged.attitude_rad.map_or(0.0, |attitude| attitude.worst_sigma()),
            second_best_arcsec: second.judged.attitude_rad.map(|attitude| {
                let mut sigma = attitude.sigma;
                sigma.sort_by(f64::total_cmp);
                sigma[1].to_degrees() * 3600.0
            }),
        });
    });
    let worst = flown.iter().map(|second| second.worst_sigma).fold(0.0, f64::max);
    println!("{name}, {seconds} s: largest error of the attitude {worst:.1} sigma");
    assert!(worst < 6.0);
    flown
}

fn count(flown: &[Flown], seconds: Range<u32>, of: impl Fn(&Flown) -> bool) -> u32 {
    flown.iter().filter(|second| seconds.contains(&second.cycle) && of(second)).count() as u32
}

fn shutters(paths: Shutters) -> Option<ShutterParameters> {
    Some(ShutterParameters { paths, ..ShutterParameters::default() })
}

fn fault(kind: FaultKind, seconds: Range<u32>) -> Fault {
    Fault { kind, from_s: seconds.start, until_s: seconds.end }
}

#[test]
fn stars_are_tracked_in_every_second_while_the_sun_crosses_the_earth_path() {
    let flown = fly("geo-shutters", 2600, |_| {});
    assert_eq!(count(&flown, 10..2600, |second| !second.measured), 0);
    assert_eq!(count(&flown, SUN_S, |second| !second.earth_path_shut), 0);
    // Not for longer than the margin, half a degree of a quarter a minute on either side, asks for.
    let shut = count(&flown, 0..2600, |second| second.earth_path_shut);
    let sun = SUN_S.end - SUN_S.start;
    println!("Sun in the Earth path for {sun} s, the path shut for {shut} s");
    assert!((sun + 200..sun + 280).contains(&shut));
    // Without shutters it is an outage of the same length.
    let blind = fly("geo-shutters", 2600, |scenario| scenario.shutters = None);
    assert!(count(&blind, SUN_S, |second| second.blinded) >= sun - 2);
    let only_star = fly("geo-shutters", 1600, |scenario| scenario.shutters = shutters(Shutters::Star));
    assert!(count(&only_star, 1470..1600, |second| second.measured) == 0);
}

#[test]
fn a_restart_in_the_sun_finds_the_path_that_it_is_in() {
    let flown = fly("geo-shutters", 1700, |scenario| {
        scenario.faults = vec![fault(FaultKind::Restart(1.0), 1600..1601)]
    });
    let again =
        flown.iter().find(|second| second.cycle > 1600 && second.measured).expect("an attitude").cycle;
    println!("first attitude {} s after a restart with the Sun in the Earth path", again - 1600);
    // A blinded self-test, and an image with the Earth path shut.
    assert!(again <= 1603);
    assert_eq!(count(&flown, again + 5..1700, |second| !second.measured), 0);
}

#[test]
fn without_time_the_sun_is_told_by_the_image_and_looked_for_again() {
    let flown = fly("geo-shutters", 2500, |scenario| {
        scenario.faults = vec![fault(FaultKind::ClockInvalid, 0..2500)];
        scenario.orbit_filter.start = None;
    });
    let sun = SUN_S.end - SUN_S.start;
    let blinded = count(&flown, SUN_S, |second| second.blinded);
    let measured = count(&flown, SUN_S, |second| second.measured);
    println!("clock not synchronised: {blinded} blinded seconds of {sun}, stars in {measured}");
    assert!((sun / 40..=sun / 25).contains(&blinded));
    assert!(measured > sun * 9 / 10);
    assert_eq!(count(&flown, SUN_S.end + 35..2500, |second| second.earth_path_shut || !second.measured), 0);
}

#[test]
fn a_shutter_that_is_stuck_costs_the_outage_and_nothing_wrong_is_told() {
    // Stuck open before the Sun comes; stuck shut when it has gone.
    for seconds in [1300..2300, 2000..2600] {
        let stuck = seconds.clone();
        let flown = fly("geo-shutters", 2700, move |scenario| {
            scenario.faults = vec![fault(FaultKind::ShutterStuck, stuck)];
        });
        let without = count(&flown, 10..2700, |second| !second.measured);
        println!("stuck from {} to {} s: {without} s without stars", seconds.start, seconds.end);
        let blind = seconds.end.min(SUN_S.end).saturating_sub(SUN_S.start.max(seconds.start));
        assert!(without <= if seconds.start < SUN_S.start { blind + 40 } else { 0 });
    }
}

#[test]
fn a_sun_in_the_star_path_shuts_it_and_stars_come_back_when_it_has_gone() {
    let flown = fly("sun-crossing", 8400, |scenario| scenario.shutters = shutters(Shutters::Both));
    let first = flown.iter().find(|second| second.star_path_shut).expect("it is shut").cycle;
    let last = flown.iter().rfind(|second| second.star_path_shut).expect("it is shut").cycle;
    let looks = count(&flown, first..last, |second| second.blinded);
    let again = flown.iter().find(|second| second.cycle > last && second.measured).expect("stars").cycle;
    println!("star path shut from {first} to {last} s, {looks} looks, stars {} s after", again - last);
    // The margin, half a degree, is two minutes.
    let entered = flown.iter().find(|second| second.sun).expect("it comes").cycle;
    let gone = flown.iter().rfind(|second| second.sun).expect("it goes").cycle;
    assert!((100..140).contains(&(entered - first)) && (100..170).contains(&(last - gone)));
    // A look each half minute, as the attitude is only carried on.
    assert!((last - first) / 33 <= looks + 1 && looks <= (last - first) / 30 + 1);
    assert!(again - last <= 10);
    assert_eq!(count(&flown, 10..first, |second| !second.measured), 0);
}

/// The Sun crosses the star path, both paths have shutters, the orbit is known from the ground.
fn fly_without_stars(seconds: u32, change: impl FnOnce(&mut Scenario)) -> Vec<Flown> {
    let known = Scenario::load(Path::new("geo-shutters")).unwrap().orbit_filter;
    fly("sun-crossing", seconds, |scenario| {
        (scenario.shutters, scenario.orbit_filter) = (shutters(Shutters::Both), known);
        change(scenario);
    })
}

#[test]
fn while_the_star_path_is_shut_the_earth_holds_two_axes_of_the_attitude() {
    let flown = fly_without_stars(6300, |_| {});
    let shut: Vec<&Flown> = flown.iter().filter(|second| second.star_path_shut && !second.blinded).collect();
    let worst = |at: &[&Flown]| {
        at.iter().map(|second| second.second_best_arcsec.unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
    };
    println!("two axes held to {:.0} arcsec for {} s", worst(&shut), shut.len());
    assert!(shut.len() > 5300 && worst(&shut) < 60.0);
}

#[test]
fn with_the_star_path_held_shut_from_the_start_the_earth_and_its_terminator_give_an_attitude() {
    let flown = fly_without_stars(120, |scenario| scenario.held_open = Some(OpenPaths::Earth));
    let told = count(&flown, 1..120, |second| second.second_best_arcsec.is_some());
    let worst = flown.iter().filter_map(|second| second.second_best_arcsec).fold(0.0, f64::max);
    println!("told in {told} s of 119, two axes known to {worst:.0} arcsec");
    assert!(told >= 115 && worst < 360.0);
    assert_eq!(count(&flown, 0..120, |second| second.measured), 0);
}

#[test]
fn a_turn_while_the_star_path_is_shut_is_seen_by_the_earth() {
    let flown = fly_without_stars(2600, |scenario| {
        let axis = [0.6, 0.8, 0.0];
        let turn = Slew { start_s: 2000.0, duration_s: 60.0, axis, angle_rad: 1.5_f64.to_radians() };
        scenario.pointing.slews.push(turn);
    });
    // What is told in the turn and after it is right (`fly`): the stars come back in an hour and a half only.
    let told = count(&flown, 2030..2600, |second| second.second_best_arcsec.is_some());
    println!("told in {told} s of 570 after the turn");
    assert!(count(&flown, 1900..2000, |second| second.second_best_arcsec.is_some()) > 90);
}
