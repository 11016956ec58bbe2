//! Tests of the scene by statistics: light, noise, places and patterns against analytic values. Seeds are
//! fixed; each limit is stated in standard deviations.

use super::tests::{IDENTITY, read, small_camera, star_at};
use super::*;
use crate::bound;
use crate::formats::camera_file::CameraFile;
use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::detector::imaging::ImagingModel;
use crate::world::sky::stars::DetectorModel;

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
        // Chi-square with n - 1 degrees of freedom: 4 sigma of the ratio; the second term is what rounding to
        // whole numbers may change where the noise is only half a step.
        let rounding = 4.0 * (-2.0 * std::f64::consts::PI.powi(2) * noise / (gain * gain)).exp();
        let limit = 4.0 * (2.0 / count).sqrt() + rounding;
        assert!((variance / expected - 1.0).abs() < limit, "{exposure_us}: variance {variance}, {expected}");
    }
}

/// 2240 renderings of stars of V = 3 at random phases, through lens and L-shaped pixels: the sums that
/// chi-square tests need.
#[test]
fn stars_have_the_light_the_noise_and_the_places_that_they_should_have() {
    let camera = CameraFile::reference();
    let optics = Optics::new(&camera).unwrap();
    let noise = Noise::new(20_260_923, 0, Stream::Attitude);
    let (v, time_s, half) = (3.0, 0.1, 7.0);
    let star = |index: u32| {
        let [dx, dy] = [0, 1].map(|k| noise.uniform(index, k));
        let (column, row) = (f64::from(index % 20), f64::from(index / 20));
        let direction = optics.unproject([40.0 + 62.0 * column + dx, 40.0 + 62.0 * row + dy]).unwrap();
        WorldStar { hip: index, direction, v, b_v: 2.0 * noise.uniform(index, 2) - 0.3 }
    };
    let stars: Vec<WorldStar> = (0..320).map(star).collect();
    let mut settings = SceneSettings::new(camera, Motion::fixed(IDENTITY), 11);
    // Steps of numbers much finer than the noise, so that rounding is noise of its own.
    (settings.camera.mirrored, settings.camera.bits) = (false, 14);
    settings.imaging = ImagingModel::REFERENCE;
    // Patterns are another test's: here every deviation is to be noise, and independent.
    settings.detector = DetectorModel { pattern: PatternModel::NONE, ..DetectorModel::reference() };
    let mut scene = Scene::new(settings, &stars).unwrap();
    let detector = scene.settings().detector;
    let (gain, dark) = (detector.gain_e_per_dn(14), detector.dark_now_e_s() * time_s);
    let empty = dark + detector.read_noise_e.powi(2) + gain * gain / 12.0;
    let (mut squares, mut pixels, mut flux, mut flux_variance, mut fits) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut drift, mut count) = ([0.0; 2], 0.0);
    for cycle in 0..7 {
        scene.expose_cycle(cycle, 100_000).unwrap();
        for star in scene.visible_stars().to_vec() {
            let at = [star.x_px, star.y_px];
            let side = 2 * half as u16 + 1;
            let [x, y] = at.map(|at| (at.round() - half) as u16);
            let window = Window { x, y, width: side, height: side };
            let values = read(&mut scene, window);
            let image = |at| scene.star_image(&star, at, time_s, window);
            let step = 0.02;
            let slope = |dx: f64, dy: f64| {
                let [ahead, behind] =
                    [1.0, -1.0].map(|s| image([at[0] + s * dx * step, at[1] + s * dy * step]));
                ahead.iter().zip(behind).map(|(a, b)| (a - b) / (2.0 * step)).collect::<Vec<_>>()
            };
            let (mean, across, down) = (image(at), slope(1.0, 0.0), slope(0.0, 1.0));
            // The fit of least squares, a step from the true place: F shift = sum of slope times residual
            // over variance.
            let (mut f, mut g) = ([0.0; 3], [0.0; 2]);
            for (k, value) in values.iter().enumerate() {
                let electrons = (f64::from(*value) - detector.pedestal_dn(14)) * gain;
                let (residual, variance) = (electrons - mean[k] - dark, mean[k] + empty);
                squares += residual * residual / variance;
                flux += residual;
                flux_variance += variance;
                pixels += 1.0;
                let (sx, sy) = (across[k], down[k]);
                [(0, sx * sx), (1, sx * sy), (2, sy * sy)].iter().for_each(|(i, t)| f[*i] += t / variance);
                [(0, sx), (1, sy)].iter().for_each(|(i, t): &(usize, f64)| g[*i] += t * residual / variance);
            }
            let determinant = f[0] * f[2] - f[1] * f[1];
            let shift =
                [(f[2] * g[0] - f[1] * g[1]) / determinant, (f[0] * g[1] - f[1] * g[0]) / determinant];
            let bound = bound::centroid_px(image, at, empty);
            for axis in 0..2 {
                fits += (shift[axis] / bound[axis]).powi(2);
                drift[axis] += shift[axis] / bound[axis];
            }
            count += 1.0;
        }
    }
    let root = |n: f64| (2.0 / n).sqrt();
    println!(
        "{count} stars: chi-square a pixel {:.4} ± {:.4}, flux {:.2} sigma, places {:.3} ± {:.3} of the bound's squares, \
         {:.2} {:.2} sigma off",
        squares / pixels,
        root(pixels),
        flux / flux_variance.sqrt(),
        fits / (2.0 * count),
        root(2.0 * count),
        drift[0] / count.sqrt(),
        drift[1] / count.sqrt()
    );
    // 4 sigma each: a right scene passes with probability 0.9999.
    assert_eq!(count, 2240.0);
    assert!((squares / pixels - 1.0).abs() < 4.0 * root(pixels));
    assert!(flux.abs() < 4.0 * flux_variance.sqrt());
    // The two axes of a star are not quite independent, which widens this by less than a tenth.
    assert!((fits / (2.0 * count) - 1.0).abs() < 4.4 * root(2.0 * count));
    assert!(drift.iter().all(|d| d.abs() < 4.0 * count.sqrt()));
}

#[test]
fn even_light_shows_gains_columns_and_rows() {
    // Many exposures of a warm, dark detector: what stays is the pattern, what comes and goes with the rows
    // their noise.
    let camera =
        CameraFile { width_px: 64, height_px: 64, optical_centre_px: [31.5; 2], ..CameraFile::reference() };
    let mut settings = SceneSettings::new(camera, Motion::fixed(IDENTITY), 21);
    settings.camera.bits = 16;
    let pattern = PatternModel { prnu: 0.0, dsnu: 0.1, column_offset_e: 30.0, row_noise_e: 15.0 };
    settings.detector = DetectorModel { pattern, ..DetectorModel::default() };
    let mut scene = Scene::new(settings, &[]).unwrap();
    let detector = scene.settings().detector;
    let frames = 200;
    let (mut mean, mut rows) = (vec![0.0; 4096], 0.0);
    let mut all = Vec::new();
    for cycle in 0..frames {
        scene.expose_cycle(cycle, 500_000).unwrap();
        let whole = scene.geometry().whole();
        let to_e = |v: &u16| (f64::from(*v) - detector.pedestal_dn(16)) * detector.gain_e_per_dn(16);
        let frame: Vec<f64> = read(&mut scene, whole).iter().map(to_e).collect();
        mean.iter_mut().zip(&frame).for_each(|(m, e)| *m += e / frames as f64);
        all.push(frame);
    }
    for frame in &all {
        for y in 0..64 {
            let row = (0..64).map(|x| frame[64 * y + x] - mean[64 * y + x]).sum::<f64>() / 64.0;
            rows += row * row;
        }
    }
    let spread = |values: &[f64]| {
        let middle = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|v| (v - middle).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
    };
    // Rows: their noise and the 64th part of the pixels'.
    let pixel = 400.0 + 400.0;
    let expected = (225.0 + pixel / 64.0) * (1.0 - 1.0 / frames as f64);
    let (found, degrees) = (rows / (frames as f64 * 64.0), frames as f64 * 64.0);
    assert!((found / expected - 1.0).abs() < 4.0 * (2.0 / degrees).sqrt(), "{found} {expected}");
    // Columns: 63 degrees of freedom; in the mean over rows little else is left.
    let columns: Vec<f64> = (0..64).map(|x| (0..64).map(|y| mean[64 * y + x]).sum::<f64>() / 64.0).collect();
    assert!((spread(&columns) / 925.0 - 1.0).abs() < 4.0 * (2.0f64 / 63.0).sqrt(), "{}", spread(&columns));
    // Pixels about their columns: a tenth of 400 e- of dark current, noise divided by the frames.
    let mut pixels = mean.clone();
    for (k, value) in pixels.iter_mut().enumerate() {
        *value -= columns[k % 64];
    }
    let expected = 1600.0 + (pixel + 225.0) / frames as f64;
    assert!((spread(&pixels) / expected - 1.0).abs() < 4.0 * (2.0f64 / 4032.0).sqrt() + 0.016);
}
