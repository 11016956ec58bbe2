//! Fits of made-up skies, of which everything is known.

use super::*;
use crate::formats::camera_file::Distortion;
use crate::world::attitude::{matrix, uniform};
use crate::world::noise::{Noise, Stream};
use crate::world::vector::{transposed, unit};

/// The reference camera as it truly is.
fn truth() -> CameraFile {
    CameraFile {
        focal_length_px: 3013.7,
        optical_centre_px: [632.0, 519.0],
        distortion: Distortion { k1: -0.15, k2: 0.3, k3: 0.0, p1: 4e-4, p2: -3e-4 },
        mirrored: true,
        ..CameraFile::reference()
    }
}

/// `pictures` of `stars` each, their centroids off by `sigma_px`.
fn views(camera: &CameraFile, pictures: u32, stars: u32, sigma_px: f64, seed: u64) -> Vec<View> {
    let optics = Optics::new(camera).unwrap();
    let (places, errors) = (Noise::new(seed, 0, Stream::Attitude), Noise::new(seed, 0, Stream::Centroid));
    (0..pictures)
        .map(|picture| {
            let attitude = matrix(uniform(&places, picture));
            let star = |index: u32| {
                let place = |axis: u32, side: u16| {
                    places.part(7).uniform(2 * index + axis, picture) * (f64::from(side) - 1.0)
                };
                let pixel = [place(0, camera.width_px), place(1, camera.height_px)];
                let seen = optics.unproject(pixel).unwrap();
                let error = |axis: u32| sigma_px * errors.gaussian(2 * index + axis, picture);
                Sighting {
                    hip: index,
                    direction: unit(apply(&transposed(&attitude), seen)),
                    at_px: [pixel[0] + error(0), pixel[1] + error(1)],
                    sigma_px,
                }
            };
            View { attitude, stars: (0..stars).map(star).collect() }
        })
        .collect()
}

/// The sky as it is thought to be before: attitudes that fit a plain camera.
fn start() -> CameraFile {
    CameraFile { mirrored: true, ..CameraFile::reference() }
}

#[test]
fn without_noise_the_lens_is_found_whole() {
    let fit = fit(&start(), &views(&truth(), 4, 40, 1e-6, 1)).unwrap();
    assert_eq!(fit.free.len(), 7);
    for (free, _) in &fit.free {
        let (found, true_value) = (free.of(&fit.camera), free.of(&truth()));
        assert!((found - true_value).abs() < 1e-4 * free.step(&truth()), "{free:?}: {found} {true_value}");
    }
    assert!(fit.rms_px() < 1e-4 && fit.outliers == 0);
}

#[test]
fn a_star_that_leaves_the_field_is_never_a_gain() {
    let mut sky = views(&truth(), 4, 40, 0.05, 9);
    let problem = |views: &[View]| Problem { free: LADDER[0], camera: truth(), views: views.to_vec() };
    let straight = problem(&sky).chi2();
    let mut turned = sky.clone();
    turned[0].attitude = product(&rotation(1, std::f64::consts::PI), &turned[0].attitude);
    assert!(straight < 1000.0 && problem(&turned).chi2() == f64::INFINITY);
    // A star with the name of one behind the camera is left out and counted.
    let away = sky[0].stars[0].direction.map(|axis| -axis);
    sky[0].stars[0].direction = away;
    let fit = fit(&start(), &sky).unwrap();
    assert!(fit.outliers >= 1 && fit.views[0].stars.iter().all(|star| star.direction != away));
    assert!((fit.camera.focal_length_px - truth().focal_length_px).abs() < 2.0, "{:?}", fit.camera);
}

#[test]
fn sigmas_are_honest() {
    // Square of error over sigma of seven parameters in 40 skies, mean 1: 280 values, correlated within a
    // sky, of which some 120 count as independent; 3 sigma of their mean are 0.39. Skies whose criterion
    // takes fewer parameters are no part of it.
    let (mut sum, mut count) = (0.0, 0.0);
    for seed in 0..40 {
        let fit = fit(&start(), &views(&truth(), 6, 40, 0.05, 100 + seed)).unwrap();
        if fit.free.len() < 7 {
            continue;
        }
        for (free, sigma) in &fit.free {
            sum += ((free.of(&fit.camera) - free.of(&truth())) / sigma).powi(2);
            count += 1.0;
        }
    }
    println!("{:.2} over {count}", sum / count);
    assert!(count > 200.0 && (sum / count - 1.0).abs() < 0.39);
}

#[test]
fn few_noisy_stars_make_no_distortion_and_wrong_ones_are_left_out() {
    let plain = CameraFile { focal_length_px: 3020.0, ..start() };
    let mut sky = views(&plain, 1, 12, 0.2, 5);
    let fit = |sky: &[View]| fit(&start(), sky).unwrap();
    let found = fit(&sky);
    assert_eq!(found.free.len(), 1, "{:?}", found.free);
    let (focal, sigma) = found.free[0];
    assert!((focal.of(&found.camera) - 3020.0).abs() < 3.0 * sigma);
    sky[0].stars[3].at_px[0] += 6.0;
    let found = fit(&sky);
    assert_eq!((found.outliers, found.views[0].stars.len()), (1, 11));
    assert!((focal.of(&found.camera) - 3020.0).abs() < 3.0 * found.free[0].1);
}

#[test]
fn too_few_stars_determine_nothing() {
    assert!(fit(&start(), &views(&truth(), 1, 1, 0.1, 1)).is_none());
    assert!(fit(&start(), &[]).is_none());
}
