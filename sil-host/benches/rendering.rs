//! How long the synthetic world needs to draw.
//!
//! A whole frame of the reference camera and the window of one tracked star under the stars alone, plain and
//! with all that lens and detector do, and one star through the lens; then from a geostationary and a low
//! orbit: the whole frame with the Earth, an exposure, and what a second of tracking reads, 25 windows of 25
//! x 25 px of the sky and 24 strips across the limb; last the Earth's light alone, without noise, in whole
//! frames and strips of 80 x 9 px.

use criterion::{
    BatchSize, BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use fsw_core::orbit::body::CentralBody;
use fsw_hal::{Detector, Window};
use sil_host::formats::camera_file::CameraFile;
use sil_host::harness::star_scene;
use sil_host::world::detector::imaging::ImagingModel;
use sil_host::world::earth::EarthModel;
use sil_host::world::lens::spots::{Brush, Spot};
use sil_host::world::motion::Motion;
use sil_host::world::motion::pointing::{Mount, Pointing};
use sil_host::world::motion::trajectory::{Look, Trajectory};
use sil_host::world::orbit::{TruthOrbit, state_of_elements};
use sil_host::world::scene::{Scene, SceneSettings};
use sil_host::world::sky::stars::DetectorModel;
use std::hint::black_box;
use std::time::Duration;

/// The equinox of 2026-09-23 0:05 UTC.
const START_US: i64 = 843_393_969_184_000;

/// Of the Earth's light.
const EXPOSURE_S: f64 = 0.4;

fn trajectory(radius_km: f64, inclination_deg: f64, true_anomaly_deg: f64, off_nadir_deg: f64) -> Scene {
    let (r, v) =
        state_of_elements(CentralBody::Earth, [radius_km, 0.0, inclination_deg, 0.0, 0.0, true_anomaly_deg])
            .expect("the orbit clears the Earth");
    let trajectory = Trajectory {
        orbit: TruthOrbit::new(START_US, r, v, 600).expect("the orbit clears the Earth"),
        pointing: Pointing::nadir(off_nadir_deg, 0.0),
        mount: Mount { star_path_deg: [90.0, 0.0, 0.0] },
        earth: EarthModel::default(),
    };
    let settings = SceneSettings::new(CameraFile::reference(), Motion::orbiting(trajectory), 1);
    Scene::new(settings, &star_scene::sky()).expect("the settings are sound")
}

/// Draws all `windows` of the scene's exposure.
fn draw(group: &mut BenchmarkGroup<WallTime>, name: &str, scene: &Scene, windows: &[Window]) {
    let mut pixels: Vec<Vec<u16>> = windows.iter().map(|window| vec![0; window.area()]).collect();
    let area: usize = windows.iter().map(Window::area).sum();
    group.throughput(Throughput::Elements(area as u64));
    group.bench_function(name, |bencher| {
        // A scene keeps what it has drawn: each draws in one of its own.
        let draw = |scene: &mut Scene| {
            for (window, pixels) in windows.iter().zip(&mut pixels) {
                scene.read(black_box(*window), pixels).expect("the window is on the detector");
            }
        };
        bencher.iter_batched_ref(|| scene.clone(), draw, BatchSize::SmallInput);
    });
}

/// Adds up the Earth's light of all `windows`.
fn light(group: &mut BenchmarkGroup<WallTime>, name: &str, scene: &Scene, windows: &[Window]) {
    let settings = scene.settings();
    let trajectory = settings.motion.trajectory().expect("it is a trajectory");
    let truth = scene.truth().expect("it has been exposed");
    let look = Look {
        seed: settings.seed,
        psf_sigma_px: 0.9,
        exposure_s: EXPOSURE_S,
        row_time_s: 0.0,
        transmission: 1.0,
    };
    let image = trajectory.earth_image(&truth, scene.optics(), &look);
    let mut cell_buffer = sil_host::world::earth::image::CellBuffer::EMPTY;
    let mut electrons: Vec<Vec<f64>> = windows.iter().map(|window| vec![0.0; window.area()]).collect();
    group.throughput(Throughput::Elements(windows.iter().map(Window::area).sum::<usize>() as u64));
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for (window, electrons) in windows.iter().zip(&mut electrons) {
                image.add_to(black_box(*window), electrons, &mut cell_buffer);
            }
        });
    });
}

fn rendering(criterion: &mut Criterion) {
    let mut scene = star_scene::scene().expect("the settings are sound");
    scene.expose(star_scene::EXPOSURE_US).expect("a scene takes this exposure");
    let mut group = criterion.benchmark_group("rendering");
    let whole = scene.geometry().whole();
    draw(&mut group, "whole_frame", &scene, &[whole]);
    draw(&mut group, "star_window", &scene, &[Window { x: 600, y: 500, width: 25, height: 25 }]);

    let mut settings = scene.settings().clone();
    settings.imaging = ImagingModel::REFERENCE;
    settings.detector = DetectorModel::reference();
    let mut scene = Scene::new(settings, &star_scene::sky()).expect("the settings are sound");
    group.throughput(Throughput::Elements(1));
    group.bench_function("reference_exposure", |bencher| {
        bencher.iter(|| scene.expose_cycle(black_box(100), star_scene::EXPOSURE_US));
    });
    draw(&mut group, "reference_whole_frame", &scene, &[whole]);
    draw(&mut group, "reference_star_window", &scene, &[Window { x: 600, y: 500, width: 25, height: 25 }]);
    star(&mut group, &scene);

    // Noon: the Earth full in the middle, its limb 455 px from the centre. The low orbit sees the limb
    // upright.
    let geo = trajectory(42_164.17, 0.0, 180.0, 0.0);
    let low = trajectory(6828.0, 51.6, 160.0, 69.1);
    for (orbit, mut scene) in [("geo", geo), ("low", low)] {
        scene.expose_cycle(100, star_scene::EXPOSURE_US).expect("a scene takes this exposure");
        group.throughput(Throughput::Elements(1));
        group.bench_function(format!("{orbit}_exposure"), |bencher| {
            bencher.iter(|| scene.expose_cycle(black_box(100), star_scene::EXPOSURE_US));
        });
        draw(&mut group, &format!("{orbit}_whole_frame"), &scene, &[whole]);
        let stars: Vec<Window> = (0..25u16)
            .map(|k| Window { x: 1100 + 30 * (k % 5), y: 40 + 40 * (k / 5), width: 25, height: 25 })
            .collect();
        draw(&mut group, &format!("{orbit}_25_star_windows"), &scene, &stars);
        let strips = limb_strips(&mut scene, 25);
        draw(&mut group, &format!("{orbit}_24_limb_strips_25x9"), &scene, &strips);
        let strips = limb_strips(&mut scene, 65);
        draw(&mut group, &format!("{orbit}_24_limb_strips_65x9"), &scene, &strips);
        light(&mut group, &format!("{orbit}_light_whole_frame"), &scene, &[whole]);
        let strips = limb_strips(&mut scene, 80);
        light(&mut group, &format!("{orbit}_light_24_limb_strips_80x9"), &scene, &strips);
    }
    group.finish();
}

/// Draws one star of `scene`, off the axis, in a window that holds it whole.
fn star(group: &mut BenchmarkGroup<WallTime>, scene: &Scene) {
    let settings = scene.settings();
    let psf = settings.imaging.psf(scene.optics()).expect("the lens can be made");
    let window = Window { x: 900, y: 800, width: 25, height: 25 };
    let spot = Spot { x_px: 912.3, y_px: 811.8, electrons: [1000.0; 3] };
    let (mut brush, mut light) = (Brush::default(), vec![0.0; window.area()]);
    group.throughput(Throughput::Elements(1));
    group.bench_function("reference_star", |bencher| {
        bencher.iter(|| brush.draw(&psf, settings.detector.response, black_box(&spot), window, &mut light));
    });
}

/// 24 strips of `width` x 9 px across the right edge of the Earth.
fn limb_strips(scene: &mut Scene, width: u16) -> Vec<Window> {
    let strip = |k: u16| {
        let y = 300 + 17 * k;
        let mut row = vec![0; 1280];
        scene.read(Window { x: 0, y, width: 1280, height: 1 }, &mut row).expect("the row is on the detector");
        let edge = row.iter().rposition(|value| *value > 60).unwrap_or(640) as u16;
        Window { x: edge.saturating_sub(width / 2).min(1280 - width), y, width, height: 9 }
    };
    (0..24).map(strip).collect()
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
