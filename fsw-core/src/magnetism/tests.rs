//! Tests of the magnetometer's zero: drawn readings, and lies.

use super::*;
use crate::oracle::Generator;
use std::println;

const ERRORS: MagnetometerErrors =
    MagnetometerErrors { noise_ut: 0.25, zero_ut: 5.0, walk_ut: 2.5e-3, field_ut: 0.15 };

fn known_by_parameters() -> Magnetism {
    let mut magnetism = Magnetism::default();
    magnetism.propagate(1.0, &ERRORS);
    magnetism
}

/// Three numbers of a standard deviation.
fn drawn(rng: &mut Generator, sigma_ut: f32) -> Vector3<f32> {
    rng.gaussian_vector().map(|axis| sigma_ut * axis as f32)
}

#[test]
fn the_zero_is_found_to_its_sigma() {
    let mut rng = Generator::new(7);
    let runs = 200;
    let mut squares = 0.0;
    for _ in 0..runs {
        let mut magnetism = known_by_parameters();
        let (mut zero_ut, mut field_ut) = (drawn(&mut rng, ERRORS.zero_ut), Vector3::zeros());
        for second in 0..3_000 {
            // The field is another every five minutes.
            if second % 300 == 0 {
                field_ut = drawn(&mut rng, ERRORS.field_ut);
            }
            zero_ut += drawn(&mut rng, ERRORS.walk_ut);
            let off_ut = zero_ut + field_ut + drawn(&mut rng, ERRORS.noise_ut);
            magnetism.propagate(1.0, &ERRORS);
            magnetism.learn(&off_ut, &ERRORS, ERRORS.field_ut);
        }
        assert!(!magnetism.is_shut_out());
        let sigma_ut = magnetism.zero_sigma_ut();
        assert!((0.03..0.12).contains(&sigma_ut), "{sigma_ut}");
        squares += ((magnetism.zero_ut() - zero_ut) / sigma_ut).norm_squared() / 3.0;
    }
    // Two-sided 99 % of 600 squares of one degree of freedom: 0.86 to 1.15; readings that last for five
    // minutes are not quite white ones of 300 times the variance.
    let mean = squares / runs as f32;
    println!("squares of the zero's error over its sigma: {mean}");
    assert!((0.75..1.25).contains(&mean), "{mean}");
}

#[test]
fn a_reading_that_lies_is_not_taken_and_after_three_it_is_shut_out() {
    let mut rng = Generator::new(8);
    let mut magnetism = known_by_parameters();
    for _ in 0..600 {
        let off_ut = Vector3::new(1.0, -2.0, 3.0) + drawn(&mut rng, ERRORS.noise_ut);
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
