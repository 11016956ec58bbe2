//! The magnetometer beside the camera, flown from pixels in a low orbit that the ground has given: its zero,
//! what it adds to an attitude without stars, and that it costs nothing where it is missing, silent or lies.

use crate::flights::scenario;
use fsw_core::sensor::Workspace;
use fsw_core::shutting::ShutterParameters;
use fsw_core::telemetry::{Event, ReadingFault, Report};
use fsw_hal::OpenPaths;
use sil_host::harness::faults::{Fault, FaultKind};
use sil_host::harness::{self, Flight, Second};
use sil_host::scenario::Scenario;
use sil_host::scenario::orbit_filter::GroundStart;
use sil_host::world::instruments::magnetometer::MagnetometerModel;
use sil_host::world::motion::slew::Slew;
use std::ops::Range;

/// The spacecraft's own field, uT.
const OWN_FIELD_UT: [f64; 3] = [1.2, -2.4, 3.1];

const GROUND: GroundStart = GroundStart {
    position_sigma_km: 1.0,
    velocity_sigma_m_s: 1.0,
    position_error_km: [0.4, -0.8, 0.4],
    velocity_error_m_s: [0.3, -0.3, 0.3],
    drawn: false,
};

/// A second that was flown.
struct Flown {
    cycle: u32,
    report: Report,
    /// Largest error of the attitude that is told, over its sigma; its largest error and its largest sigma,
    /// deg.
    attitude: Option<[f64; 3]>,
}

/// So many seconds of the low orbit.
fn low_orbit(seconds: u32) -> Scenario {
    let mut scenario = scenario("leo-oblique", seconds);
    scenario.orbit_filter.start = Some(GROUND);
    scenario.magnetometer =
        Some(MagnetometerModel { hard_iron_ut: OWN_FIELD_UT, ..MagnetometerModel::default() });
    scenario
}

/// The same flown.
fn fly(seconds: u32, change: impl FnOnce(&mut Scenario)) -> Vec<Flown> {
    let mut scenario = low_orbit(seconds);
    change(&mut scenario);
    fly_believing(&scenario, &scenario)
}

/// A scenario flown by flight code that is told what another one says.
fn fly_believing(scenario: &Scenario, believed: &Scenario) -> Vec<Flown> {
    let mut scene = scenario.scene().unwrap();
    let (catalogue, calibration) = harness::tables(believed).unwrap();
    let mut workspace = Box::new(Workspace::new());
    let sensor = harness::sensor(believed, catalogue, calibration.as_ref(), &mut workspace).unwrap();
    let mut flight = Flight::of(scenario, &mut scene, sensor);
    let mut flown = Vec::new();
    let mut look = |second: Second<'_>| {
        let attitude = second.judged.attitude_rad.map(|attitude| {
            let most =
                |axes: [f64; 3]| axes.iter().fold(0.0_f64, |most, axis| most.max(axis.abs())).to_degrees();
            [attitude.worst_sigma(), most(attitude.error), most(attitude.sigma)]
        });
        flown.push(Flown { cycle: second.cycle, report: second.report.clone(), attitude });
        Ok(())
    };
    for _ in 0..scenario.duration_s {
        flight.second(&mut look).unwrap();
    }
    flown
}

fn fault(kind: FaultKind, seconds: Range<u32>) -> Fault {
    Fault { kind, from_s: seconds.start, until_s: seconds.end }
}

fn worst_sigma(flown: &[Flown]) -> f64 {
    flown.iter().filter_map(|second| second.attitude).map(|[sigmas, ..]| sigmas).fold(0.0, f64::max)
}

#[test]
fn its_zero_is_learned_from_stars_and_orbit() {
    let flown = fly(900, |_| {});
    let last = flown.last().and_then(|second| second.report.magnetometer).expect("a reading");
    println!("zero {:?} of {OWN_FIELD_UT:?} uT, sigma {}", last.zero_ut, last.zero_sigma_ut);
    // The zero walks, by 0.08 uT in 900 s.
    assert!(last.zero_sigma_ut < 0.15);
    for (found, own) in last.zero_ut.iter().zip(OWN_FIELD_UT) {
        assert!((f64::from(*found) - own).abs() < 4.0 * f64::from(last.zero_sigma_ut).hypot(0.08));
    }
    assert!(flown.iter().all(|second| second.report.faults.magnetometer.is_none()));
}

#[test]
fn with_stars_nothing_rests_on_it_be_it_missing_silent_or_lying() {
    let attitudes = |flown: &[Flown]| -> Vec<_> {
        flown
            .iter()
            .map(|second| (second.report.attitude, second.report.filtered, second.report.orbit))
            .collect()
    };
    let without = fly(120, |scenario| scenario.magnetometer = None);
    assert!(without.iter().all(|second| second.report.magnetometer.is_none()));
    let silent = fly(120, |scenario| scenario.faults = vec![fault(FaultKind::MagnetometerSilent, 40..80)]);
    let lying =
        fly(120, |scenario| scenario.faults = vec![fault(FaultKind::MagnetometerOffset(30.0), 60..120)]);
    let whole = fly(120, |_| {});
    for flown in [&silent, &lying, &whole] {
        assert!(attitudes(flown) == attitudes(&without));
    }
    for Flown { cycle, report, .. } in &silent {
        let fault = (40..80).contains(cycle).then_some(ReadingFault::Silent);
        assert_eq!(
            (report.faults.magnetometer, report.magnetometer.is_none()),
            (fault, fault.is_some()),
            "{cycle}"
        );
    }
    // Three contradictions, then it is not asked any more.
    let shut_out = |second: &Flown| second.report.events.contains(&Event::MagnetometerShutOut);
    assert_eq!(lying.iter().position(shut_out), Some(62));
    let lost = |second: &Flown| second.report.faults.magnetometer == Some(ReadingFault::ShutOut);
    assert_eq!(lying.iter().filter(|second| lost(second)).count(), 120 - 63);
}

#[test]
fn an_attitude_that_is_carried_on_is_no_worse_with_it() {
    let blinded = |magnetometer: bool| {
        fly(900, |scenario| {
            scenario.faults = vec![fault(FaultKind::Blinded, 400..900)];
            if !magnetometer {
                scenario.magnetometer = None;
            }
        })
    };
    let [with, without] = [true, false].map(blinded);
    for (name, flown) in [("with", &with), ("without", &without)] {
        let told: Vec<_> =
            flown.iter().filter(|second| second.cycle >= 402).filter_map(|second| second.attitude).collect();
        let [_, error, sigma] = told.last().copied().unwrap_or([f64::NAN; 3]);
        println!("{name}: told for {} s, at last {error:.3} deg off, sigma {sigma:.3} deg", told.len());
        assert!(worst_sigma(flown) < 6.0, "{}", worst_sigma(flown));
    }
    let used =
        with.iter().filter(|second| second.report.magnetometer.is_some_and(|report| report.used)).count();
    println!("used in {used} s");
    assert!(used > 400);
}

#[test]
fn a_turn_that_nobody_measured_is_within_the_sigma_or_seen_by_the_field() {
    // A turn of 34 deg in 40 s while the detector is blinded. `told`: the flight code is told of such turns.
    let turned = |magnetometer: bool, told: bool| {
        let axis = [0.6, 0.0, 0.8];
        let turn = Slew { start_s: 410.0, duration_s: 40.0, axis, angle_rad: 0.6 };
        let mut scenario = low_orbit(520);
        scenario.faults = vec![fault(FaultKind::Blinded, 400..520)];
        scenario.magnetometer = scenario.magnetometer.filter(|_| magnetometer);
        let quiet = scenario.clone();
        scenario.pointing.slews.push(turn);
        let flown = fly_believing(&scenario, if told { &scenario } else { &quiet });
        let attitudes =
            flown.iter().filter(|second| second.cycle >= 400).filter_map(|second| second.attitude);
        let of = attitudes.fold((0, [0.0_f64; 2]), |(seconds, [sigmas, error]), attitude| {
            (seconds + 1, [sigmas.max(attitude[0]), error.max(attitude[1])])
        });
        println!("magnetometer {magnetometer}, told of turns {told}: {of:?} s, sigmas, deg");
        of
    };
    let (seconds, [sigmas, _]) = turned(false, true);
    assert!(seconds < 10 && sigmas < 6.0);
    let [(seconds_with, [_, error_with]), (seconds, [_, error])] =
        [true, false].map(|with| turned(with, false));
    assert!(seconds_with < 35 && error_with < 10.0, "the field sees it");
    assert!(seconds == 120 && error > 25.0, "nothing else does");
}

#[test]
fn beside_the_earth_alone_it_gives_the_third_axis() {
    let flown = fly(120, |scenario| {
        scenario.shutters = Some(ShutterParameters::default());
        scenario.held_open = Some(OpenPaths::Earth);
        let own_field = MagnetometerModel {
            hard_iron_ut: [0.5, -0.3, 0.4],
            zero_sigma_ut: 0.5,
            ..MagnetometerModel::default()
        };
        scenario.magnetometer = Some(own_field);
    });
    let told: Vec<_> = flown.iter().filter_map(|second| second.attitude).collect();
    let used =
        flown.iter().filter(|second| second.report.magnetometer.is_some_and(|report| report.used)).count();
    let most = |of: usize| told.iter().map(|attitude| attitude[of]).fold(0.0, f64::max);
    println!(
        "told in {} s of 120, used in {used}; {:.2} deg off at most, sigma {:.2}; {:.1} sigma",
        told.len(),
        most(1),
        most(2),
        most(0)
    );
    assert!(told.len() > 100 && used == told.len());
    assert!(most(0) < 6.0 && most(2) < 4.0);
}
