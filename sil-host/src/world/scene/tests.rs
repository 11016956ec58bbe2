//! Tests of the scene: windows against whole frames, what each effect shows, wrong requests.

use super::*;
use crate::formats::camera_file::CameraFile;
use crate::scenario::Scenario;
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::imaging::ImagingModel;
use crate::world::detector::protons::Protons;
use crate::world::detector::shutter::Shutter;
use crate::world::lens::psf::{LensModel, PsfModel};
use crate::world::sky::stars::DetectorModel;
use proptest::prelude::*;

pub(super) const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

pub(super) fn small_camera() -> CameraFile {
    CameraFile {
        width_px: 96,
        height_px: 80,
        focal_length_px: 300.0,
        optical_centre_px: [47.5, 39.5],
        ..CameraFile::reference()
    }
}

/// A star that an unrotated small camera sees at `pixel`.
pub(super) fn star_at(pixel: [f64; 2], v: f64) -> WorldStar {
    let direction = Optics::new(&small_camera()).unwrap().unproject(pixel).unwrap();
    WorldStar { hip: 1, direction, v, b_v: 0.0 }
}

pub(super) fn read(scene: &mut Scene, window: Window) -> Vec<u16> {
    let mut pixels = vec![0; window.area()];
    scene.read(window, &mut pixels).unwrap();
    pixels
}

/// A star list all over the sky, denser towards faint stars as the real one.
fn sky(count: u32) -> Vec<WorldStar> {
    let noise = Noise::new(77, 0, Stream::Attitude);
    let star = |index| WorldStar {
        hip: index + 1,
        direction: attitude::matrix(attitude::uniform(&noise, index))[2],
        v: 6.5 + 2.0 * libm::log10(noise.uniform(index, 9)),
        b_v: 2.0 * noise.uniform(index, 10) - 0.3,
    };
    (0..count).map(star).collect()
}

fn busy_settings(rate_rad_s: Vector, seed: u64) -> SceneSettings {
    let motion = Motion::turning([0.3, -0.2, 0.5, 0.7], rate_rad_s);
    let mut settings = SceneSettings::new(small_camera(), motion, seed);
    settings.disturbances = Disturbances {
        false_stars: 20,
        hot_pixels: 30,
        dead_low: 10,
        dead_high: 10,
        protons: Protons::Fixed(15),
        ..Disturbances::default()
    };
    settings
}

fn busy_scene(rate_rad_s: Vector, seed: u64) -> Scene {
    Scene::new(busy_settings(rate_rad_s, seed), &sky(9000)).unwrap()
}

/// The same with everything that lens and detector do.
fn full_scene(rate_rad_s: Vector, seed: u64, shutter: Shutter) -> Scene {
    let mut settings = busy_settings(rate_rad_s, seed);
    // Pixels ten times as wide give the small camera the reference's lens; defocused as much in pixels.
    let psf = PsfModel::Lens(LensModel { aperture_mm: 10.0, defocus_mm: -0.6 });
    settings.imaging = ImagingModel { pixel_pitch_um: 75.0, shutter, psf, ..ImagingModel::REFERENCE };
    settings.detector = DetectorModel::reference();
    settings.disturbances.protons = Protons::Orbit;
    Scene::new(settings, &sky(9000)).unwrap()
}

/// The part of a whole frame that `window` shows.
fn crop(whole: &[u16], scene: &Scene, window: Window) -> Vec<u16> {
    let mut part = vec![0; window.area()];
    crate::formats::picture::copy_window(whole, &scene.geometry(), window, &mut part);
    part
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn any_window_equals_the_crop_of_the_whole_frame(
        x in 0u16..96, y in 0u16..80, w in 1u16..96, h in 1u16..80, seed: u64,
        rate in prop::array::uniform3(-0.05..0.05f64), exposure_us in 2_000u32..500_000,
    ) {
        let window = Window { x, y, width: w.min(96 - x), height: h.min(80 - y) };
        let mut scene = busy_scene(rate, seed);
        scene.expose(exposure_us).unwrap();
        scene.expose(exposure_us).unwrap();
        let part = read(&mut scene, window);
        let geometry = scene.geometry();
        let whole = read(&mut scene, geometry.whole());
        prop_assert_eq!(&part, &crop(&whole, &scene, window));
        // And the same cycle drawn without the one before it.
        let mut alone = busy_scene(rate, seed);
        alone.expose_cycle(1, exposure_us).unwrap();
        prop_assert_eq!(read(&mut alone, window), part);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn windows_in_any_order_equal_the_whole_frame_with_every_effect(
        places in prop::collection::vec((0u16..96, 0u16..80, 1u16..60, 1u16..60), 1..6), seed: u64,
        rate in prop::array::uniform3(-0.05..0.05f64), exposure_us in 2_000u32..500_000,
        row_time_s in prop::option::of(0.0..5e-4f64),
    ) {
        let shutter = row_time_s.map_or(Shutter::Global, |row_time_s| Shutter::Rolling { row_time_s });
        let mut scene = full_scene(rate, seed, shutter);
        scene.expose_cycle(3, exposure_us).unwrap();
        let window = |(x, y, w, h): (u16, u16, u16, u16)| {
            Window { x, y, width: w.min(96 - x), height: h.min(80 - y) }
        };
        let parts: Vec<_> = places.iter().map(|place| read(&mut scene, window(*place))).collect();
        // The whole frame by another scene, after another cycle; the windows once more, backwards.
        let mut other = full_scene(rate, seed, shutter);
        other.expose_cycle(8, exposure_us).unwrap();
        other.expose_cycle(3, exposure_us).unwrap();
        let geometry = other.geometry();
        let whole = read(&mut other, geometry.whole());
        for (place, part) in places.iter().zip(&parts).rev() {
            prop_assert_eq!(part, &crop(&whole, &other, window(*place)));
            prop_assert_eq!(part, &read(&mut scene, window(*place)));
        }
    }
}

#[test]
fn windows_of_a_flight_equal_its_whole_frame() {
    let scenario = Scenario::load(std::path::Path::new("leo-oblique")).unwrap();
    let mut scene = scenario.scene().unwrap();
    scene.expose_cycle(900, scenario.exposure_us).unwrap();
    let geometry = scene.geometry();
    // By another one: windows of this one are drawn alone.
    let whole = read(&mut scene.clone(), geometry.whole());
    let noise = Noise::new(12, 0, Stream::Shuffle);
    for k in 0..60 {
        let pick = |n, side: u16| (noise.uniform(k, n) * f64::from(side)) as u16;
        let (x, y) = (pick(0, 1280), pick(1, 1024));
        let window =
            Window { x, y, width: 1 + pick(2, 80).min(1279 - x), height: 1 + pick(3, 80).min(1023 - y) };
        assert_eq!(read(&mut scene, window), crop(&whole, &scene, window), "{window:?}");
    }
}

#[test]
fn closed_paths_show_nothing_and_edges_less() {
    let light = |change: &dyn Fn(&mut ImagingModel), pixel: [f64; 2]| {
        let mut settings = SceneSettings::new(small_camera(), Motion::fixed(IDENTITY), 5);
        change(&mut settings.imaging);
        (settings.detector.dark_e_s, settings.detector.read_noise_e) = (0.0, 0.0);
        (settings.detector.pedestal, settings.camera.bits) = (0.0, 16);
        let mut scene = Scene::new(settings, &[star_at(pixel, 2.0)]).unwrap();
        scene.expose(100_000).unwrap();
        let whole = scene.geometry().whole();
        read(&mut scene, whole).iter().map(|v| f64::from(*v)).sum::<f64>()
    };
    let (middle, corner) = ([47.5, 39.5], [8.0, 8.0]);
    let plain = light(&|_| {}, middle);
    assert_eq!(light(&|imaging| imaging.star_path_transmission = 0.0, middle), 0.0);
    assert!((light(&|imaging| imaging.star_path_transmission = 0.5, middle) / plain - 0.5).abs() < 0.02);
    let loss = |imaging: &mut ImagingModel| imaging.vignetting.corner_loss = 0.5;
    // 50.5 of 62.9 px from the centre: 0.5 (50.5 / 62.9)² of the light is lost.
    assert!((light(&loss, corner) / light(&|_| {}, corner) - 0.678).abs() < 0.02);
    assert!((light(&loss, middle) / plain - 1.0).abs() < 0.02);
}

#[test]
fn a_rolling_shutter_shears_the_sky_of_a_turning_camera() {
    // Turning about the column axis moves stars along rows: 300 px x 0.2 rad/s = 60 px/s.
    let stars = [star_at([48.0, 4.0], 1.0), star_at([48.0, 76.0], 1.0)];
    let place = |shutter| {
        let mut settings = SceneSettings::new(small_camera(), Motion::turning(IDENTITY, [0.0, 0.2, 0.0]), 3);
        settings.imaging.shutter = shutter;
        let mut scene = Scene::new(settings, &stars).unwrap();
        scene.expose(20_000).unwrap();
        let whole = scene.geometry().whole();
        let frame = read(&mut scene, whole);
        let centre = |rows: std::ops::Range<usize>| {
            let value = |k: usize| (f64::from(frame[k]) - 36.0).max(0.0);
            let sum: f64 = (rows.start * 96..rows.end * 96).map(value).sum();
            (rows.start * 96..rows.end * 96).map(|k| (k % 96) as f64 * value(k)).sum::<f64>() / sum
        };
        let truth = scene.visible_stars().to_vec();
        ((centre(0..12), centre(68..80)), (truth[0].x_px, truth[1].x_px))
    };
    let ((top, bottom), _) = place(Shutter::Global);
    assert!((top - bottom).abs() < 0.3, "{top} {bottom}");
    let ((top, bottom), truth) = place(Shutter::Rolling { row_time_s: 5e-4 });
    // 72 rows, 0.5 ms each.
    assert!(((top - bottom) - 72.0 * 5e-4 * 60.0).abs() < 0.4, "{top} {bottom}");
    assert!((top - truth.0).abs() < 0.3 && (bottom - truth.1).abs() < 0.3);
}

#[test]
fn frames_of_two_cycles_have_independent_noise_but_the_same_hot_pixels() {
    let mut settings = SceneSettings::new(small_camera(), Motion::fixed(IDENTITY), 3);
    settings.disturbances =
        Disturbances { hot_pixels: 10, hot_pixel_e_s: (6e4, 1e5), ..Disturbances::default() };
    let mut scene = Scene::new(settings, &[]).unwrap();
    let whole = scene.geometry().whole();
    let bright = |frame: &[u16]| -> Vec<usize> { (0..frame.len()).filter(|i| frame[*i] > 500).collect() };
    scene.expose(500_000).unwrap();
    let first = read(&mut scene, whole);
    assert_eq!(first, read(&mut scene, whole));
    scene.expose(500_000).unwrap();
    let second = read(&mut scene, whole);
    assert_ne!(first, second);
    assert_eq!(bright(&first), bright(&second));
    assert!((8..=10).contains(&bright(&first).len()));
}

#[test]
fn a_bright_star_saturates_and_stays_within_the_bits() {
    let mut scene = Scene::new(
        SceneSettings::new(small_camera(), Motion::fixed(IDENTITY), 3),
        &[star_at([50.0, 50.0], -1.4)],
    )
    .unwrap();
    scene.expose(1_000_000).unwrap();
    let whole = scene.geometry().whole();
    let frame = read(&mut scene, whole);
    assert_eq!(frame[50 * 96 + 50], 1023);
    assert!(frame.iter().all(|v| *v <= 1023));
}

#[test]
fn a_turning_sensor_smears_a_star_about_its_true_place() {
    let rate_rad_s = [0.0, 0.2, 0.0];
    let star = star_at([48.0, 40.0], 2.0);
    let motion = Motion::turning(IDENTITY, rate_rad_s);
    let mut settings = SceneSettings::new(small_camera(), motion, 3);
    settings.detector.dark_e_s = 0.0;
    settings.detector.read_noise_e = 0.0;
    settings.detector.pedestal = 0.0;
    let mut scene = Scene::new(settings, &[star]).unwrap();
    scene.expose(500_000).unwrap();
    let whole = scene.geometry().whole();
    let frame = read(&mut scene, whole);
    let sum: f64 = frame.iter().map(|v| f64::from(*v)).sum();
    let moment = |place: fn(usize) -> f64| {
        frame.iter().enumerate().map(|(i, v)| place(i) * f64::from(*v)).sum::<f64>() / sum
    };
    let truth = scene.visible_stars()[0];
    assert!((truth.x_px - 48.0).abs() < 1e-9 && (truth.y_px - 40.0).abs() < 1e-9);
    assert!((moment(|i| (i % 96) as f64) - 48.0).abs() < 0.1);
    assert!((moment(|i| (i / 96) as f64) - 40.0).abs() < 0.1);
    // 0.2 rad/s * 0.5 s * 300 px = 30 px of streak.
    let lit = (0..96).filter(|x| frame[40 * 96 + x] > 10).count();
    assert!((28..=34).contains(&lit), "{lit}");
    // A second later the star has gone to the left by tan(0.2 rad).
    scene.expose(500_000).unwrap();
    let expected = 47.5 - 300.0 * (0.2f64 - (0.5f64 / 300.0).atan()).tan();
    let truth = scene.visible_stars().first().map(|s| s.x_px);
    assert!(expected < -0.5 && truth.is_none() || truth.is_some_and(|x| (x - expected).abs() < 1e-6));
}

#[test]
fn wrong_requests_and_settings_are_refused() {
    let mut scene = busy_scene([0.0; 3], 1);
    let window = Window { x: 0, y: 0, width: 4, height: 4 };
    let mut pixels = [0; 16];
    assert_eq!(scene.read(window, &mut pixels), Err(DetectorError::NotExposed));
    assert_eq!(scene.expose(0), Err(DetectorError::Exposure));
    scene.expose(1000).unwrap();
    assert_eq!(scene.read(Window { x: 93, ..window }, &mut pixels), Err(DetectorError::OutsideDetector));
    assert_eq!(scene.read(window, &mut pixels[1..]), Err(DetectorError::BufferLength));
    let settings = SceneSettings::new(small_camera(), Motion::fixed([0.0; 4]), 0);
    assert_eq!(Scene::new(settings.clone(), &[]).err(), Some(SceneError::Motion));
    let settings = SceneSettings {
        imaging: ImagingModel { pixel_pitch_um: f64::NAN, ..ImagingModel::PLAIN },
        motion: Motion::fixed(IDENTITY),
        ..settings
    };
    assert_eq!(Scene::new(settings, &[]).err(), Some(SceneError::Detector));
}

#[test]
fn a_new_effect_is_a_type_and_a_line() {
    #[derive(Debug)]
    struct Glow(f64);
    impl effects::Effect for Glow {
        fn add_to(&self, _: Window, electrons: &mut [f64], _: &mut CellBuffer) {
            electrons.iter_mut().for_each(|pixel| *pixel += self.0);
        }
    }
    let mean = |glows: bool| {
        let mut settings = SceneSettings::new(small_camera(), Motion::fixed(IDENTITY), 5);
        settings.camera.bits = 16;
        let mut scene = Scene::new(settings, &[]).unwrap();
        if glows {
            scene.add_effect(effects::Stage::Stray, |_, moment| vec![Arc::new(Glow(500.0 * moment.time_s))]);
        }
        scene.expose(400_000).unwrap();
        let whole = scene.geometry().whole();
        let numbers = read(&mut scene, whole);
        numbers.iter().map(|v| f64::from(*v)).sum::<f64>() / numbers.len() as f64
            * scene.settings().detector.gain_e_per_dn(16)
    };
    // 7680 pixels of a noise of 32 e-: 4 sigma of the difference are 2.1 e-.
    assert!((mean(true) - mean(false) - 200.0).abs() < 2.1);
}

#[test]
fn a_storm_adds_protons_until_it_is_over() {
    let mut scene = busy_scene([0.0; 3], 5);
    let whole = scene.geometry().whole();
    let mut bright = |hits| {
        scene.storm(hits);
        scene.expose_cycle(3, 200_000).unwrap();
        read(&mut scene, whole)
    };
    let calm = bright(0);
    let changed = bright(200).iter().zip(&calm).filter(|(storm, calm)| storm > calm).count();
    assert!(changed > 200, "{changed}");
    assert_eq!(bright(0), calm);
}
