//! How long the flight code needs to find the stars of a frame: the reference camera's 1280 x 1024 px,
//! rendered and copied beforehand, so that neither drawing nor decoding is measured. The throughput counts
//! pixels: its inverse is the time a megapixel.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fsw_core::image::DetectionParameters;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_hal::Detector;
use sil_host::formats::picture::Picture;
use sil_host::harness::star_scene;
use std::hint::black_box;
use std::time::Duration;

/// The first frame of the rendered sky.
fn reference_frame() -> Picture {
    let mut scene = star_scene::scene().expect("the rendered sky's settings are sound");
    let geometry = scene.geometry();
    let mut pixels = vec![0; geometry.whole().area()];
    scene.expose(star_scene::EXPOSURE_US).expect("a scene takes this exposure");
    scene.read(geometry.whole(), &mut pixels).expect("the whole frame can be read");
    Picture::from_pixels(geometry, pixels).expect("as many pixels as the geometry says")
}

fn detection(criterion: &mut Criterion) {
    let mut frame = reference_frame();
    frame.expose(star_scene::EXPOSURE_US).expect("a picture takes any exposure");
    let mut buffer = Box::new([0; TILE_PIXELS]);
    let mut detections = Detections::new();
    let parameters = DetectionParameters::default();
    let mut group = criterion.benchmark_group("detection");
    group.throughput(Throughput::Elements(frame.geometry().whole().area() as u64));
    group.bench_function("reference_frame", |bencher| {
        bencher.iter(|| {
            scan(black_box(&mut frame), &mut buffer, &parameters, &mut detections)
                .expect("the frame is there");
            black_box(detections.spots().len())
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(30)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(5));
    targets = detection
}
criterion_main!(benches);
