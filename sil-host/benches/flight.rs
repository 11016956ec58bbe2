//! How long a simulated second takes: the world drawn, the flight code run, the second judged, on one core.
//!
//! Tracking reads windows only; acquisition reads the whole detector. Elements a second are times real time.
//! Tracking is timed in one flight that goes on from sample to sample, once the orbit is known well enough
//! for narrow strips across the limb; acquisition in the two images it takes after the self-test of a flight
//! of its own. The first of these also draws the Earth's map as far as it is seen, which later images find
//! there.

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use fsw_core::modes::Mode;
use fsw_core::sensor::Workspace;
use sil_host::flight;
use sil_host::harness::{Flight, Second};
use sil_host::scenario::Scenario;
use std::path::Path;
use std::time::{Duration, Instant};

/// Scenarios, and the seconds after which their orbit is known to some tens of kilometres; the low satellite's
/// in its second day.
const SETTLING_S: [(&str, u32); 2] = [("geo-eclipse", 1000), ("sso-noon-midnight", 3950)];
/// Images of an acquisition.
const ACQUIRED_S: u32 = 2;
/// Seconds of tracking timed at once; 130 times as many go by before the low satellite's night comes.
const TRACKED_S: u32 = 20;

/// Flies `skipped` seconds of a scenario, then hands `timed` a stopwatch of further ones in the given mode.
fn fly(scenario: &Scenario, skipped: u32, mode: Mode, timed: impl FnOnce(&mut dyn FnMut(u32) -> Duration)) {
    let camera = flight::camera(&scenario.believed_camera(), &scenario.file).expect("an embedded scenario");
    let catalogue = flight::flight_catalogue(&camera, &scenario.file).expect("a catalogue");
    let calibration = scenario.calibration().expect("an embedded calibration");
    let mut scene = scenario.scene().expect("an embedded scenario");
    let mut workspace = Box::new(Workspace::new());
    let mut flight = Flight::new(scenario, &mut scene, catalogue, calibration.as_ref(), &mut workspace)
        .expect("an embedded scenario");
    for _ in 0..skipped {
        flight.second(|_| Ok(())).expect("a second");
    }
    timed(&mut |seconds| {
        let began = Instant::now();
        for _ in 0..seconds {
            let check = |second: Second<'_>| {
                assert_eq!(second.report.mode, mode);
                Ok(())
            };
            flight.second(check).expect("a second");
        }
        began.elapsed()
    });
}

fn seconds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("flight");
    group.sampling_mode(SamplingMode::Flat);
    for (name, settling_s) in SETTLING_S {
        let scenario = Scenario::load(Path::new(name)).expect("an embedded scenario");
        group.throughput(Throughput::Elements(TRACKED_S.into()));
        fly(&scenario, settling_s, Mode::Tracking, |stopwatch| {
            group.bench_function(format!("{name}_tracking"), |bencher| {
                bencher.iter_custom(|iterations| (0..iterations).map(|_| stopwatch(TRACKED_S)).sum());
            });
        });
        group.throughput(Throughput::Elements(ACQUIRED_S.into()));
        group.bench_function(format!("{name}_acquisition"), |bencher| {
            bencher.iter_custom(|iterations| {
                let mut elapsed = Duration::ZERO;
                for _ in 0..iterations {
                    fly(&scenario, 1, Mode::Acquisition, |stopwatch| {
                        elapsed += stopwatch(ACQUIRED_S);
                    });
                }
                elapsed
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_secs(1));
    targets = seconds
}
criterion_main!(benches);
