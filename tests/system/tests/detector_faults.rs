//! A detector that breaks: the sensor says so, gives no wrong attitude, and finds itself again.
//!
//! Every fault of the scenario `geo-faults` in turn, flown through the traits. Late frames are the exception,
//! stated here: a detector that hands out an old image as a new one is believed.

use fsw_core::modes::Mode;
use sil_host::harness;
use sil_host::harness::faults::FaultKind;
use sil_host::scenario::Scenario;
use std::path::Path;

/// Seconds allowed from the end of a fault to the next attitude: safe mode's pause of a minute, and
/// acquisition.
const RECOVERY_S: u32 = 75;

/// What is kept of a second.
struct Flown {
    attitude_sigmas: Option<f64>,
    detector_fault: bool,
    mode: Mode,
}

fn fly(scenario: &Scenario) -> Vec<Flown> {
    let mut scene = scenario.scene().expect("an embedded scenario");
    let mut flown = Vec::new();
    harness::fly(scenario, &mut scene, |second| {
        flown.push(Flown {
            attitude_sigmas: second.judged.attitude_rad.map(|attitude| attitude.worst_sigma()),
            detector_fault: second.report.faults.detector.is_some(),
            mode: second.report.mode,
        });
        Ok(())
    })
    .expect("an embedded scenario flies");
    flown
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
            FaultKind::LateFrame(_) => assert_eq!(reported, 0, "{word}"),
            // Of the clock and the image's instant: `clock_faults.rs`; not in this scenario.
            _ => {}
        }
    }
    let late = |cycle: usize| {
        let acts = |fault: &sil_host::harness::faults::Fault| {
            matches!(fault.kind, FaultKind::LateFrame(_)) && fault.acts_in(cycle as u32)
        };
        scenario.faults.iter().any(acts)
    };
    let worst = flown.iter().enumerate().filter(|(cycle, _)| !late(*cycle));
    let worst = worst.filter_map(|(_, second)| second.attitude_sigmas).fold(0.0, f64::max);
    println!("largest attitude error outside late frames: {worst:.2} sigma");
    // Of 6,000 axes one lies beyond 4.5 sigma in 25 runs of an honest sensor.
    assert!(worst < 4.5, "{worst}");
}
