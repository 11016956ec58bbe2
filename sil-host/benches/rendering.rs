//! How long the synthetic world needs to draw: a whole frame of the reference camera, and the window of one tracked star.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fsw_hal::{Detector, Window};
use sil_host::star_scene;
use std::hint::black_box;
use std::time::Duration;

fn rendering(criterion: &mut Criterion) {
    let mut scene = star_scene::scene().expect("the rendered sky's settings are sound");
    scene.expose(star_scene::EXPOSURE_US).expect("a scene takes this exposure");
    let mut group = criterion.benchmark_group("rendering");
    let windows = [
        ("whole_frame", scene.geometry().whole()),
        ("star_window", Window { x: 600, y: 500, width: 25, height: 25 }),
    ];
    for (name, window) in windows {
        let mut pixels = vec![0; window.area()];
        group.throughput(Throughput::Elements(window.area() as u64));
        group.bench_function(name, |bencher| {
            bencher
                .iter(|| scene.read(black_box(window), &mut pixels).expect("the window is on the detector"));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(3));
    targets = rendering
}
criterion_main!(benches);
