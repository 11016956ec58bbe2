//! How long each method of attitude needs for one set of the reference field's brightest stars, 4/16 px of
//! noise: 100 sets of 3, 5 and 10 stars; covariance and loss included. The throughput counts solutions.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fsw_core::attitude::comparison::{self, WahbaMethod};
use sil_host::commands::attitude::methods::name;
use sil_host::commands::attitude::table::Sky;
use std::hint::black_box;
use std::time::Duration;

const SETS: u32 = 100;

fn attitude(criterion: &mut Criterion) {
    let sky = Sky::new().expect("the reference camera");
    let mut group = criterion.benchmark_group("attitude");
    group.throughput(Throughput::Elements(u64::from(SETS)));
    for count in [3, 5, 10] {
        let sets: Vec<_> = (0..SETS).filter_map(|direction| sky.set(direction, count, 4, 1.0)).collect();
        for method in WahbaMethod::ALL {
            group.bench_function(BenchmarkId::new(name(method), count), |bencher| {
                bencher.iter(|| {
                    for set in &sets {
                        let _ = black_box(comparison::solve(method, black_box(&set.pairs)));
                    }
                });
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    targets = attitude
}
criterion_main!(benches);
