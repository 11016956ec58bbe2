//! Tests of the scene: windows against whole frames, fluxes and noise against analytic values, truth, speed.

use super::*;
use proptest::prelude::*;

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

fn small_camera() -> CameraFile {
    CameraFile {
        width_px: 96,
        height_px: 80,
        focal_length_px: 300.0,
        optical_centre_px: [47.5, 39.5],
        ..CameraFile::reference()
    }
}

/// A star that an unrotated small camera sees at `pixel`.
fn star_at(pixel: [f64; 2], v: f64) -> WorldStar {
    let direction = Optics::new(&small_camera()).unwrap().unproject(pixel).unwrap();
    WorldStar { hip: 1, direction, v }
}

fn read(scene: &mut Scene, window: Window) -> Vec<u16> {
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
    };
    (0..count).map(star).collect()
}

fn busy_scene(rate_rad_s: Vector, seed: u64) -> Scene {
    let motion = Motion::turning([0.3, -0.2, 0.5, 0.7], rate_rad_s);
    let mut settings = SceneSettings::new(small_camera(), motion, seed);
    settings.disturbances =
        Disturbances { false_stars: 20, hot_pixels: 30, proton_hits: 15, ..Disturbances::default() };
    Scene::new(settings, &sky(9000)).unwrap()
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
        let geometry = scene.geometry();
        let part = read(&mut scene, window);
        let whole = read(&mut scene, geometry.whole());
        let mut crop = vec![0; window.area()];
        crate::picture::copy_window(&whole, &geometry, window, &mut crop);
        prop_assert_eq!(&part, &crop);
        // And the same cycle drawn without the one before it.
        let mut alone = busy_scene(rate, seed);
        alone.expose_cycle(1, exposure_us).unwrap();
        prop_assert_eq!(read(&mut alone, window), part);
    }
}

#[test]
fn a_star_gives_the_electrons_of_its_magnitude() {
    let star = star_at([40.3, 30.7], 4.0);
    let mut scene =
        Scene::new(SceneSettings::new(small_camera(), Motion::fixed(IDENTITY), 5), &[star]).unwrap();
    let detector = scene.settings().detector;
    let (window, time_s, frames) = (Window { x: 32, y: 22, width: 17, height: 17 }, 0.5, 400);
    let (gain, pedestal) = (detector.gain_e_per_dn(10), detector.pedestal_dn(10));
    let mut sum = 0.0;
    for _ in 0..frames {
        scene.expose(500_000).unwrap();
        sum += read(&mut scene, window).iter().map(|v| (f64::from(*v) - pedestal) * gain).sum::<f64>();
    }
    let pixels = window.area() as f64;
    let dark = detector.dark_now_e_s() * time_s;
    let flux = detector.star_e_s(4.0) * time_s;
    let mean = sum / f64::from(frames) - pixels * dark;
    let pixel_variance = dark + detector.read_noise_e.powi(2) + gain * gain / 12.0;
    let sigma = ((flux + pixels * pixel_variance) / f64::from(frames)).sqrt();
    // 4 sigma: a right scene passes with probability 0.99994.
    assert!((mean - flux).abs() < 4.0 * sigma, "{mean} e- for {flux} ± {sigma}");
}

#[test]
fn the_background_has_the_analytic_mean_and_variance() {
    let mut scene =
        Scene::new(SceneSettings::new(CameraFile::reference(), Motion::fixed(IDENTITY), 9), &[]).unwrap();
    let detector = scene.settings().detector;
    for (cycle, exposure_us) in [(0, 30_000), (1, 100_000), (2, 1_000_000)] {
        scene.expose_cycle(cycle, exposure_us).unwrap();
        let values = read(&mut scene, Window { x: 100, y: 200, width: 400, height: 400 });
        let gain = detector.gain_e_per_dn(10);
        let electrons = |v: &u16| (f64::from(*v) - detector.pedestal_dn(10)) * gain;
        let count = values.len() as f64;
        let mean = values.iter().map(electrons).sum::<f64>() / count;
        let variance = values.iter().map(|v| (electrons(v) - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let dark = detector.dark_now_e_s() * f64::from(exposure_us) * 1e-6;
        let noise = dark + detector.read_noise_e.powi(2);
        let expected = noise + gain * gain / 12.0;
        assert!(
            (mean - dark).abs() < 4.0 * (expected / count).sqrt() + 0.02,
            "{exposure_us}: mean {mean}, {dark}"
        );
        // Chi-square with n - 1 degrees of freedom: 4 sigma of the ratio; the second term is what rounding to whole
        // numbers may change where the noise is only half a step.
        let rounding = 4.0 * (-2.0 * std::f64::consts::PI.powi(2) * noise / (gain * gain)).exp();
        let limit = 4.0 * (2.0 / count).sqrt() + rounding;
        assert!((variance / expected - 1.0).abs() < limit, "{exposure_us}: variance {variance}, {expected}");
    }
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
    let settings = SceneSettings { psf_sigma_px: f64::NAN, motion: Motion::fixed(IDENTITY), ..settings };
    assert_eq!(Scene::new(settings, &[]).err(), Some(SceneError::Detector));
}
