//! A detector that breaks: the sensor says so, gives no wrong attitude, and finds itself again.
//!
//! Every fault of the scenario `geo-faults` in turn, flown through the traits.

use crate::flights::member;
use fsw_core::modes::Mode;
use fsw_core::telemetry::ImageFault;
use sil_host::harness;
use sil_host::harness::faults::{Fault, FaultKind};
use sil_host::scenario::Scenario;
use sil_host::world::motion::slew::Slew;
use std::path::Path;

/// Seconds allowed from the end of a fault to the next attitude.
const RECOVERY_S: u32 = 10;

/// What is kept of a second.
struct Flown {
    attitude_sigmas: Option<f64>,
    detector_fault: bool,
    image_fault: Option<ImageFault>,
    mode: Mode,
}

fn fly(scenario: &Scenario) -> Vec<Flown> {
    let mut scene = scenario.scene().expect("an embedded scenario");
    let mut flown = Vec::new();
    harness::fly(scenario, &mut scene, |second| {
        flown.push(Flown {
            attitude_sigmas: second.judged.attitude_rad.map(|attitude| attitude.worst_sigma()),
            detector_fault: second.report.faults.detector.is_some(),
            image_fault: second.report.faults.image,
            mode: second.report.mode,
        });
        Ok(())
    })
    .expect("an embedded scenario flies");
    flown
}

/// The largest error of an attitude over its sigma.
fn worst_sigmas(flown: &[Flown]) -> f64 {
    flown.iter().filter_map(|second| second.attitude_sigmas).fold(0.0, f64::max)
}

#[test]
fn every_fault_is_reported_or_borne_and_the_sensor_recovers() {
    let scenario = Scenario::load(Path::new("geo-faults")).unwrap();
    let flown = fly(&scenario);
    for fault in &scenario.faults {
        let (from, until) = (fault.from_s as usize, fault.until_s as usize);
        let during = &flown[from..until];
        let reported = during.iter().filter(|second| second.detector_fault).count();
        let valid = during.iter().filter(|second| second.attitude_sigmas.is_some()).count();
        let recovered = flown[until..].iter().position(|second| second.attitude_sigmas.is_some());
        let word = fault.kind.word();
        println!(
            "{word}: {} s, reported in {reported}, attitude in {valid}, next after {recovered:?} s",
            during.len()
        );
        assert!(recovered.is_some_and(|after| after < RECOVERY_S as usize), "{word}: {recovered:?}");
        match fault.kind {
            FaultKind::TimeOut(_) | FaultKind::WrongGeometry(_) => {
                assert!(
                    during.iter().all(|second| second.detector_fault || second.mode == Mode::Safe),
                    "{word}"
                );
                assert_eq!(valid, 0, "{word}");
            }
            FaultKind::DroppedWindow(_) => assert!(reported > 0 && valid > 0, "{word}"),
            // What touches few pixels costs nothing.
            FaultKind::StuckRow(_) | FaultKind::BitFlips(_) => assert_eq!(valid, during.len(), "{word}"),
            // An old image sold as new is known by its noise, and costs its second alone.
            FaultKind::LateFrame(_) => {
                let late = during.iter().filter(|second| second.image_fault.is_some()).count();
                println!("{word}: {late} images refused");
                assert!(
                    during.iter().all(|second| {
                        second.image_fault.is_none_or(|fault| fault == ImageFault::Repeated)
                    })
                );
                assert!((20..50).contains(&late) && valid + late >= during.len(), "{word}: {late} {valid}");
            }
            // Of the clock and the image's instant: `clock_faults.rs`; not in this scenario.
            _ => {}
        }
    }
    let worst = worst_sigmas(&flown);
    println!("largest attitude error: {worst:.2} sigma");
    // Of 6,000 axes one lies beyond 4.5 sigma in 25 runs of an honest sensor.
    assert!(worst < 4.5, "{worst}");
}

/// Faults of two kinds, each with the seconds in which it is there.
type Both = [(FaultKind, [u32; 2]); 2];

#[test]
fn an_old_image_that_is_disturbed_on_its_way_is_no_attitude() {
    let (late, bits) = (FaultKind::LateFrame, FaultKind::BitFlips);
    let cases: [(&str, Both); 5] = [
        ("bits turned over", [(late(1.0), [24, 44]), (bits(0.01), [20, 60])]),
        ("noise, tracking", [(late(0.5), [24, 44]), (FaultKind::NoiseBurst(4.0), [20, 60])]),
        ("noise that ends first", [(late(1.0), [24, 44]), (FaultKind::NoiseBurst(4.0), [15, 32])]),
        ("noise that loses the stars", [(late(1.0), [24, 44]), (FaultKind::NoiseBurst(20.0), [15, 32])]),
        (
            "an instant that drifts",
            [(FaultKind::DoubledImage(0.5), [24, 44]), (FaultKind::Blinded, [28, 40])],
        ),
    ];
    for (name, faults) in cases {
        for scenario in ["sso-noon-midnight", "geo-faults"] {
            let mut scenario = Scenario::load(Path::new(scenario)).unwrap();
            scenario.duration_s = 90;
            scenario.faults =
                faults.map(|(kind, [from_s, until_s])| Fault { kind, from_s, until_s }).to_vec();
            let flown = fly(&scenario);
            let worst = worst_sigmas(&flown);
            let refused = flown.iter().filter(|second| second.image_fault.is_some()).count();
            let again = flown[60..].iter().position(|second| second.attitude_sigmas.is_some());
            println!(
                "{name}, {}: {worst:.1} sigma at worst, {refused} images refused, again after {again:?} s",
                scenario.name
            );
            assert!(worst < 6.0 && refused > 0 && again.is_some_and(|after| after <= RECOVERY_S as usize));
        }
    }
}

#[test]
fn an_old_image_of_which_other_probes_break_off_than_of_the_one_before_is_no_attitude() {
    // 60 % of the readouts break off, and half of the images are the last one again. Before such images were
    // suspected one gave an attitude 27 sigma off.
    let flown = fly(&member("any.toml", "any-faults-at-once.toml", 7701, 29));
    let worst = worst_sigmas(&flown);
    println!("{worst:.1} sigma at worst");
    assert!(worst > 0.0 && worst < 6.0);
}

#[test]
fn an_old_image_that_nobody_read_is_no_attitude() {
    // Exposed in the last second in which every readout broke off, handed out in the next one as new.
    for scenario in ["sso-noon-midnight", "geo-faults"] {
        for from_s in [30, 41, 52, 63] {
            let mut scenario = Scenario::load(Path::new(scenario)).unwrap();
            scenario.duration_s = 90;
            scenario.faults = vec![
                Fault { kind: FaultKind::DroppedWindow(1.0), from_s: from_s - 5, until_s: from_s },
                Fault { kind: FaultKind::LateFrame(1.0), from_s, until_s: from_s + 1 },
            ];
            let flown = fly(&scenario);
            let (worst, second) = (worst_sigmas(&flown), &flown[from_s as usize]);
            let again = flown[from_s as usize + 1..].iter().position(|of| of.attitude_sigmas.is_some());
            println!("{}, {from_s}: {worst:.1} sigma at worst, {:?}", scenario.name, second.image_fault);
            assert!(worst < 6.0 && again.is_some_and(|after| after <= RECOVERY_S as usize));
            assert_eq!(second.image_fault, Some(ImageFault::Repeated));
        }
    }
}

#[test]
fn an_attitude_that_a_turn_moved_while_it_was_blinded_is_told_once_the_next_image_confirms_it() {
    for angle_rad in [0.02, 0.05, 0.2] {
        let mut scenario = Scenario::load(Path::new("geo-faults")).unwrap();
        scenario.duration_s = 90;
        scenario.faults = vec![Fault { kind: FaultKind::Blinded, from_s: 30, until_s: 40 }];
        scenario.pointing.slews =
            vec![Slew { start_s: 31.0, duration_s: 7.0, axis: [1.0, 0.0, 0.0], angle_rad }];
        let flown = fly(&scenario);
        let worst = worst_sigmas(&flown);
        let unexpected = |second: &Flown| second.image_fault == Some(ImageFault::Unexpected);
        let first = flown[40..].iter().position(unexpected);
        let again = flown[40..].iter().position(|second| second.attitude_sigmas.is_some());
        println!("{angle_rad} rad: not expected after {first:?} s, told after {again:?} s, {worst:.1} sigma");
        assert!(flown.iter().filter(|second| unexpected(second)).count() == 1 && worst < 6.0);
        assert!(first < again && again.is_some_and(|after| after <= RECOVERY_S as usize));
    }
}

#[test]
fn an_attitude_lost_in_noise_above_an_earth_at_twilight_is_known_again_once_the_noise_ends() {
    // Clouds fill the image: a scan takes nearly all stars for texture. Before windows were read where the lost
    // filter predicts stars, flights 0 and 27 had no attitude for more than half a minute.
    for run in [0, 27, 45] {
        let mut scenario = member("any.toml", "any-faults.toml", 8802, run);
        scenario.faults.retain(|fault| matches!(fault.kind, FaultKind::NoiseBurst(_)));
        let [Fault { from_s, until_s, .. }] = scenario.faults[..] else { panic!("one burst of noise") };
        scenario.duration_s = until_s + 2 * RECOVERY_S;
        let flown = fly(&scenario);
        let told = |seconds: &[Flown]| seconds.iter().filter(|of| of.attitude_sigmas.is_some()).count();
        let recovered = flown[until_s as usize..].iter().position(|of| of.attitude_sigmas.is_some());
        let worst = worst_sigmas(&flown);
        println!("flight {run}: again after {recovered:?} s; {worst:.1} sigma at worst");
        assert!(told(&flown[from_s as usize..until_s as usize]) < 5, "the noise loses the stars");
        assert!(recovered.is_some_and(|after| after < RECOVERY_S as usize) && worst < 5.0);
    }
}

#[test]
fn a_detector_with_ten_thousand_hot_pixels_serves_where_most_of_them_are_known() {
    let valid = |surveyed| {
        let mut scenario = Scenario::load(Path::new("geo-eclipse")).unwrap();
        scenario.duration_s = 60;
        (scenario.disturbances.hot_pixels, scenario.disturbances.surveyed) = (10_000, surveyed);
        fly(&scenario)
            .iter()
            .filter(|second| second.attitude_sigmas.is_some_and(|sigmas| sigmas < 4.0))
            .count()
    };
    let [unknown, known] = [0.0, 0.95].map(valid);
    println!("attitude in {known} of 60 s, without the table in {unknown}");
    assert!(known >= 58 && unknown < known, "{known} {unknown}");
}
