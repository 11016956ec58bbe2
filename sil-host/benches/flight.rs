//! How long a simulated second takes: the world drawn, the flight code run, the second judged, on one core.
//!
//! Tracking reads windows only; acquisition reads the whole detector. Elements a second are times real time. Tracking is timed in the
//! first ten minutes of the low and the geostationary scenario in the light, acquisition in the first image after the self-test.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fsw_core::modes::Mode;
use fsw_core::sensor::Workspace;
use sil_host::flight::{self, Density};
use sil_host::run::harness::Flight;
use sil_host::scenario::Scenario;
use std::path::Path;
use std::time::{Duration, Instant};

/// Seconds after which a sensor tracks stars and limb with a settled orbit's windows.
const SETTLING_S: u32 = 120;
/// Seconds of tracking timed in one flight.
const TRACKED_S: u32 = 240;

/// Time of `seconds` of the mode, after the first `skipped` of a flight.
fn timed(scenario: &Scenario, catalogue: &[u8], skipped: u32, seconds: u32, mode: Mode) -> Duration {
    let mut scene = scenario.scene().expect("an embedded scenario");
    let mut workspace = Box::new(Workspace::new());
    let catalogue = flight::open(catalogue).expect("a catalogue");
    let mut flight =
        Flight::new(scenario, &mut scene, catalogue, &mut workspace).expect("an embedded scenario");
    for _ in 0..skipped {
        flight.second(|_| Ok(())).expect("a second");
    }
    let began = Instant::now();
    for _ in 0..seconds {
        flight
            .second(|second| {
                assert_eq!(second.report.mode, mode);
                Ok(())
            })
            .expect("a second");
    }
    began.elapsed()
}

fn seconds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("flight");
    for name in ["geo-eclipse", "leo-oblique"] {
        let scenario = Scenario::load(Path::new(name)).expect("an embedded scenario");
        let camera = flight::camera(&scenario.camera, &scenario.file).expect("an embedded scenario");
        let catalogue = flight::catalogue_bytes(&camera, Density::Brightest).expect("a catalogue");
        let mut bench = |what: &str, skipped: u32, seconds: u32, mode: Mode| {
            group.throughput(Throughput::Elements(seconds.into()));
            group.bench_function(format!("{name}_{what}"), |bencher| {
                bencher.iter_custom(|iterations| {
                    (0..iterations).map(|_| timed(&scenario, &catalogue, skipped, seconds, mode)).sum()
                });
            });
        };
        bench("tracking", SETTLING_S, TRACKED_S, Mode::Tracking);
        bench("acquisition", 1, 1, Mode::Acquisition);
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(5));
    targets = seconds
}
criterion_main!(benches);
