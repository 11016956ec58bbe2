//! How long the flight code needs to identify a field it knows nothing of: 200 seeded fields, 15 deg square,
//! V <= 6, centroid noise 0.3 px: of 24 to 26 stars, and of all numbers of stars with 0, 5 and 10 false ones.
//! Criterion's figure is the mean over all fields of a setting, the throughput counts fields; the median of
//! single fields is printed beside it, because few hard fields weigh much in a mean. Goal: the median of
//! fields of 25 stars is at most 100 us.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fsw_core::catalog::Catalogue;
use sil_host::commands::identify::{FieldInput, answer};
use sil_host::flight::lost_in_space::Solver;
use sil_host::flight::{self, Density};
use sil_host::formats::camera_file::CameraFile;
use sil_host::harness::star_scene;
use sil_host::world::fields::{FieldGenerator, FieldSettings};
use std::hint::black_box;
use std::ops::RangeInclusive;
use std::path::Path;
use std::time::Duration;

const FIELDS: u64 = 200;
const FALSE_STARS: [u32; 3] = [0, 5, 10];
/// Stars in the fields of "25 stars".
const AROUND_25: RangeInclusive<usize> = 24..=26;
const SEED: u64 = 20_261_121;
/// Each field is timed so often for its median.
const REPEATS: usize = 5;

/// The first fields of a setting with so many centroids, as a user would give them.
fn fields(camera: &CameraFile, false_stars: u32, centroids: RangeInclusive<usize>) -> Vec<FieldInput> {
    let settings = FieldSettings {
        camera: camera.clone(),
        limit_v: 6.0,
        noise_px: 0.3,
        false_stars,
        brightness: false,
        seed: SEED,
    };
    let sky = star_scene::sky();
    let generator = FieldGenerator::new(settings, &sky).expect("the settings are sound");
    (0..)
        .map(|index| generator.field(index))
        .filter(|field| centroids.contains(&field.stars.len()))
        .map(|field| serde_json::from_str(&field.input_line()).expect("a field reads back"))
        .take(FIELDS as usize)
        .collect()
}

/// The middle of some numbers.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn identification(criterion: &mut Criterion) {
    let file = CameraFile::from_fov(1024, 1024, 10, 15.0).expect("a possible camera");
    let camera = flight::camera(&file, Path::new("15 deg")).expect("a possible camera");
    let bytes = flight::catalogue_bytes(&camera, Density::Full).expect("a catalogue for this field");
    let catalogue = Catalogue::open(&bytes).expect("what was built can be opened");
    let mut solver = Solver::default();
    let mut group = criterion.benchmark_group("identification");
    group.throughput(Throughput::Elements(FIELDS));
    let all = FALSE_STARS.map(|count| (format!("{count} false stars"), fields(&file, count, 0..=usize::MAX)));
    let around_25 = ("25 stars".to_string(), fields(&file, 0, AROUND_25));
    for (name, fields) in std::iter::once(around_25).chain(all) {
        let mut typical = |field: &FieldInput| {
            median((0..REPEATS).map(|_| answer(&mut solver, field, &camera, &catalogue).us).collect())
        };
        let times: Vec<f64> = fields.iter().map(&mut typical).collect();
        println!("identification/{name}: median of a single field {:.1} us", median(times));
        group.bench_function(&name, |bencher| {
            bencher.iter(|| {
                for field in &fields {
                    black_box(answer(&mut solver, black_box(field), &camera, &catalogue));
                }
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(4));
    targets = identification
}
criterion_main!(benches);
