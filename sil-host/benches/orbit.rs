//! What the truth orbit costs: a day set up, a place asked for, and what a simulated second asks of the sky.

use criterion::{Criterion, criterion_group, criterion_main};
use fsw_core::orbit::body::CentralBody;
use sil_host::world::orbit::{TruthOrbit, state_of_elements};
use sil_host::world::time::ephemeris;
use std::hint::black_box;

/// The equinox of 2026-09-23 0:05 UTC.
const START_US: i64 = 843_393_969_184_000;
const DAY_S: u32 = 86_400;

fn orbit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("orbit");
    group.sample_size(10);
    for (name, a_km, e) in [("day_geo", 42_164.17, 0.0002), ("day_leo", 6828.0, 0.001)] {
        let (r, v) = state_of_elements(CentralBody::Earth, [a_km, e, 51.6, 40.0, 10.0, 75.0])
            .expect("the orbit clears the Earth");
        group.bench_function(name, |bencher| {
            bencher.iter(|| TruthOrbit::new(START_US, black_box(r), v, DAY_S));
        });
        let orbit = TruthOrbit::new(START_US, r, v, DAY_S).expect("the orbit clears the Earth");
        let mut t_s = 0.0;
        group.bench_function(format!("{name}/at"), |bencher| {
            bencher.iter(|| {
                t_s = if t_s < 80_000.0 { t_s + 1234.5 } else { t_s - 80_000.0 };
                orbit.at(black_box(t_s))
            });
        });
    }
    group.finish();
}

fn sky(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("sky");
    let mut time_us = START_US;
    let mut next = || {
        time_us += 1_000_000;
        black_box(time_us)
    };
    group.bench_function("sun_km", |bencher| bencher.iter(|| ephemeris::sun_km(next())));
    group.bench_function("moon_km", |bencher| bencher.iter(|| ephemeris::moon_km(next())));
    group.bench_function("icrs_to_equator", |bencher| bencher.iter(|| ephemeris::icrs_to_equator(next())));
    group.bench_function("sidereal_angle", |bencher| bencher.iter(|| ephemeris::sidereal_angle(next())));
    group.bench_function("earth_velocity_km_s", |bencher| {
        bencher.iter(|| ephemeris::earth_velocity_km_s(next()));
    });
    group.finish();
}

criterion_group!(benches, orbit, sky);
criterion_main!(benches);
