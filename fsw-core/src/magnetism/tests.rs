//! Tests of the magnetometer's zero: drawn readings, and lies.

use super::*;
use crate::oracle::Generator;
use std::{println, vec};

const ERRORS: MagnetometerErrors =
    MagnetometerErrors { noise_ut: 0.25, zero_ut: 5.0, walk_ut: 2.5e-3, field_ut: 0.15 };

fn known_by_parameters() -> Magnetism {
    let mut magnetism = Magnetism::default();
    magnetism.propagate(1.0, &ERRORS);
    magnetism
}

/// Off by a zero, by a field that is another every five minutes, and by noise.
fn readings(rng: &mut Generator, zero_ut: Vector3<f32>, seconds: usize) -> vec::Vec<Vector3<f32>> {
    let mut field_ut = Vector3::zeros();
    (0..seconds)
        .map(|second| {
            let mut drawn = |sigma_ut: f32| Vector3::from_fn(|_, _| sigma_ut * rng.gaussian() as f32);
            if second % 300 == 0 {
                field_ut = drawn(ERRORS.field_ut);
            }
            zero_ut + field_ut + drawn(ERRORS.noise_ut)
        })
        .collect()
}

#[test]
fn the_zero_is_found_to_its_sigma() {
    let mut rng = Generator::new(7);
    let runs = 200;
    let mut squares = 0.0;
    for _ in 0..runs {
        let zero_ut = Vector3::from_fn(|_, _| 5.0 * rng.gaussian() as f32);
        let mut magnetism = known_by_parameters();
        for off_ut in readings(&mut rng, zero_ut, 3_000) {
            magnetism.propagate(1.0, &ERRORS);
            magnetism.learn(&off_ut, &ERRORS, ERRORS.field_ut);
        }
        assert!(!magnetism.is_shut_out());
        assert!((0.03..0.12).contains(&magnetism.zero_sigma_ut()), "{}", magnetism.zero_sigma_ut());
        let error = (magnetism.zero_ut() - zero_ut) / magnetism.zero_sigma_ut();
        squares += error.norm_squared() / 3.0;
    }
    // Two-sided 99 %: 600 squares of one degree of freedom.
    let mean = squares / runs as f32;
    println!("squares of the zero's error over its sigma: {mean}");
    assert!((0.6..1.4).contains(&mean), "{mean}");
}

#[test]
fn a_reading_that_lies_is_not_taken_and_after_three_it_is_shut_out() {
    let mut rng = Generator::new(8);
    let mut magnetism = known_by_parameters();
    for off_ut in readings(&mut rng, Vector3::new(1.0, -2.0, 3.0), 600) {
        magnetism.learn(&off_ut, &ERRORS, ERRORS.field_ut);
    }
    let before = magnetism;
    for lie in [Vector3::new(4.0, -2.0, 3.0), Vector3::repeat(f32::NAN), Vector3::repeat(f32::INFINITY)] {
        assert!(!magnetism.is_shut_out());
        magnetism.learn(&lie, &ERRORS, ERRORS.field_ut);
    }
    assert!(magnetism.is_shut_out());
    assert_eq!((magnetism.zero_ut(), magnetism.zero_sigma_ut()), (before.zero_ut(), before.zero_sigma_ut()));
}

#[test]
fn a_zero_that_is_not_measured_is_known_no_worse_than_at_first() {
    let mut magnetism = known_by_parameters();
    magnetism.learn(&Vector3::zeros(), &ERRORS, ERRORS.field_ut);
    let known = magnetism.zero_sigma_ut();
    magnetism.propagate(1e9, &ERRORS);
    assert!(known < ERRORS.zero_ut && magnetism.zero_sigma_ut() == ERRORS.zero_ut);
    magnetism.propagate(-5.0, &ERRORS);
    assert_eq!(magnetism.zero_sigma_ut(), ERRORS.zero_ut);
}
