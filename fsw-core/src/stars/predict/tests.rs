use super::*;
use crate::camera::{CameraParameters, Distortion};
use crate::catalog::sample;
use crate::oracle::{self, Generator, reference_camera, wide_matrix};
use nalgebra::{Matrix3, Vector3};
use std::vec::Vec;

fn attitude(matrix: &Matrix3<f64>) -> Rotation<Icrs, StarPath> {
    Rotation::from_orthogonal(matrix.map(|x| x as f32))
}

/// Stars evenly over a cap that is wider than the detector, about where this attitude looks.
fn stars_ahead(
    generator: &mut Generator,
    look: &Matrix3<f64>,
    radius_rad: f64,
    count: u32,
) -> Vec<sample::SampleStar> {
    (1..=count)
        .map(|hip| sample::star(&(look.transpose() * generator.unit_in_cap(radius_rad)), hip))
        .collect()
}

/// Holds the stars predicted against the oracle's: none missing, none invented, each where it belongs.
fn check(parameters: CameraParameters, seed: u64, radius_rad: f64, tolerance_px: f64) -> f64 {
    let camera = Camera::new(parameters).unwrap();
    let mut generator = Generator::new(seed);
    let mut worst = 0.0f64;
    for _ in 0..100 {
        let look = attitude(&generator.rotation());
        let stars = stars_ahead(&mut generator, &wide_matrix(look.matrix()), radius_rad, 60);
        let bytes = sample::bytes(&stars, 26, 0);
        let field = field_stars(&Catalogue::open(&bytes).unwrap(), &camera, &look).unwrap();
        for (index, star) in stars.iter().enumerate() {
            let unit = Vector3::from(star.unit_q30.map(|x| f64::from(x) / f64::from(1u32 << 30)));
            let [x, y] = oracle::project(&parameters, &(wide_matrix(look.matrix()) * unit));
            let (right, bottom) =
                (f64::from(parameters.width_px) - 1.0, f64::from(parameters.height_px) - 1.0);
            let inside = x.min(y).min(right - x).min(bottom - y);
            match field.iter().find(|found| usize::from(found.star) == index) {
                Some(found) => {
                    assert!(inside > -tolerance_px, "star {index} at {x}, {y} is off the detector");
                    let [fx, fy] = found.centre_px.map(f64::from);
                    worst = worst.max((fx - x).hypot(fy - y));
                }
                None => assert!(inside < tolerance_px, "star {index} at {x}, {y} is missing"),
            }
        }
    }
    assert!(worst < tolerance_px, "{worst} px");
    worst
}

#[test]
fn every_star_on_the_detector_is_predicted_where_the_oracle_sees_it() {
    let brown = Distortion { k1: -0.2, k2: 0.05, k3: -0.01, p1: 1e-3, p2: -7e-4 };
    let cameras = [
        ("reference", reference_camera(), 0.3, 3e-3),
        ("Brown", CameraParameters { distortion: brown, ..reference_camera() }, 0.3, 3e-3),
        (
            "off centre",
            CameraParameters { optical_centre_px: [100.0, 900.0], ..reference_camera() },
            0.45,
            3e-3,
        ),
        ("45 deg wide", CameraParameters { focal_length_px: 1500.0, ..reference_camera() }, 0.6, 3e-3),
        ("telescope, 0.7 deg", CameraParameters { focal_length_px: 1e5, ..reference_camera() }, 0.01, 0.05),
    ];
    for (seed, (name, parameters, radius_rad, tolerance_px)) in (1..).zip(cameras) {
        let worst = check(parameters, seed, radius_rad, tolerance_px);
        std::println!("{name}: {worst:.1e} px");
    }
}

#[test]
fn a_star_in_a_corner_is_not_missed_however_narrow_the_field() {
    let mut generator = Generator::new(8);
    for focal_length_px in [800.0, 3000.0, 3e4, 1e5, 3e5] {
        let camera = Camera::new(CameraParameters { focal_length_px, ..reference_camera() }).unwrap();
        for _ in 0..300 {
            let look = attitude(&generator.rotation());
            let corners = [[1.0, 1.0], [1278.0, 1.0], [1.0, 1022.0], [1278.0, 1022.0]];
            let stars: Vec<_> = (1..)
                .zip(corners)
                .map(|(hip, corner)| {
                    let seen = oracle::wide(camera.direction(corner).unwrap().vector());
                    sample::star(&(wide_matrix(look.matrix()).transpose() * seen).normalize(), hip)
                })
                .collect();
            let bytes = sample::bytes(&stars, 26, 0);
            let field = field_stars(&Catalogue::open(&bytes).unwrap(), &camera, &look).unwrap();
            assert_eq!(field.len(), 4, "{focal_length_px} px");
        }
    }
}

#[test]
fn of_a_crowded_field_the_brightest_are_kept_brightest_first() {
    let mut generator = Generator::new(9);
    let look = generator.rotation();
    let stars = stars_ahead(&mut generator, &look, 0.1, 200);
    let bytes = sample::bytes(&stars, 26, 0);
    let camera = Camera::new(reference_camera()).unwrap();
    let field = field_stars(&Catalogue::open(&bytes).unwrap(), &camera, &attitude(&look)).unwrap();
    let indices: Vec<u16> = field.iter().map(|star| star.star).collect();
    assert_eq!(indices, (0..MAX_FIELD_STARS as u16).collect::<Vec<_>>());
}

#[test]
fn stars_behind_are_not_predicted() {
    let mut generator = Generator::new(10);
    let look = generator.rotation();
    let behind = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0) * look;
    let bytes = sample::bytes(&stars_ahead(&mut generator, &behind, 0.3, 50), 26, 0);
    let camera = Camera::new(reference_camera()).unwrap();
    assert!(field_stars(&Catalogue::open(&bytes).unwrap(), &camera, &attitude(&look)).unwrap().is_empty());
}
