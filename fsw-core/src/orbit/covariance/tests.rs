//! Against the same algebra with full matrices of all thirteen states.

use super::*;
use crate::matrix::inverse;
use crate::oracle::Generator;
use crate::orbit::dynamics::{Dynamics, transition};
use crate::orbit::reference::circular;
use nalgebra::Matrix6;

type Full = SMatrix<f64, 13, 13>;

/// A random covariance: the product of a random matrix with itself, its axes stretched by up to `spread` to
/// either side.
fn random(generator: &mut Generator, spread: f64) -> Matrix3<f64> {
    let scale = |generator: &mut Generator| spread.powf(generator.between(-1.0, 1.0));
    let turn = generator.rotation();
    let axes = Vector3::new(scale(generator), scale(generator), scale(generator));
    let product = turn * Matrix3::from_diagonal(&axes) * turn.transpose();
    (product + product.transpose()) * 0.5
}

fn full(p: &Covariance) -> Full {
    Full::from_fn(|row, column| p.at(row, column))
}

/// A covariance in which everything hangs together, as the filter's does after some fixes: misalignment and
/// bias apart.
fn entangled(generator: &mut Generator) -> Covariance {
    let root = |generator: &mut Generator| Matrix3::from_fn(|_, _| generator.gaussian());
    let shared = [root(generator), root(generator)];
    let slow = [generator.gaussian_vector(), generator.gaussian_vector()];
    let (m, b) = (0.3, random(generator, 3.0));
    let bias = [root(generator) * 0.2, root(generator) * 0.2];
    let tilt = [root(generator) * 0.2, root(generator) * 0.2];
    let (height_bias, height_tilt) = (generator.gaussian_vector() * 0.1, generator.gaussian_vector() * 0.1);
    // x = shared noise + slow height + tilt m + bias b.
    let block = |i: usize, j: usize| {
        let own = if i == j { Matrix3::identity() } else { Matrix3::zeros() };
        own + shared[i] * shared[j].transpose()
            + slow[i] * slow[j].transpose()
            + tilt[i] * tilt[j].transpose() * m
            + bias[i] * b * bias[j].transpose()
    };
    let with_height = |i: usize| slow[i] + tilt[i] * height_tilt * m + bias[i] * b * height_bias;
    let mut p = Covariance::ZERO;
    p.set_block(POSITION, POSITION, &block(0, 0));
    p.set_block(POSITION, VELOCITY, &block(0, 1));
    p.set_block(VELOCITY, VELOCITY, &block(1, 1));
    p.set_block(MISALIGNMENT, MISALIGNMENT, &(Matrix3::identity() * m));
    p.set_block(BIAS, BIAS, &b);
    let height_variance = 1.0 + height_tilt.dot(&height_tilt) * m + height_bias.dot(&(b * height_bias));
    p.set(LIMB_HEIGHT, LIMB_HEIGHT, height_variance);
    for (i, first) in [POSITION, VELOCITY].into_iter().enumerate() {
        p.set_block(first, MISALIGNMENT, &(tilt[i] * m));
        p.set_block(first, BIAS, &(bias[i] * b));
        let height = with_height(i);
        (0..3).for_each(|axis| p.set(first + axis, LIMB_HEIGHT, height[axis]));
    }
    let (tilted, biased) = (height_tilt * m, b * height_bias);
    for axis in 0..3 {
        p.set(LIMB_HEIGHT, MISALIGNMENT + axis, tilted[axis]);
        p.set(LIMB_HEIGHT, BIAS + axis, biased[axis]);
    }
    p
}

fn assert_alike(found: &Full, expected: &Full, tolerance: f64) {
    let apart = (found - expected).abs().max() / expected.abs().max();
    assert!(apart < tolerance, "{apart:e}");
}

#[test]
fn an_inverse_times_its_covariance_is_one_over_eight_powers_of_ten() {
    let mut generator = Generator::new(8);
    for _ in 0..500 {
        let m = random(&mut generator, 1e4);
        let found = inverse(&m).expect("positive definite");
        let residual = (found * m - Matrix3::identity()).abs().max();
        assert!(residual < 1e-6, "{residual:e} of {m}");
        assert_eq!(found, found.transpose());
    }
}

#[test]
fn what_is_no_covariance_has_no_inverse() {
    let identity = Matrix3::identity();
    let flat = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
    for m in
        [Matrix3::zeros(), -identity, flat, Matrix3::from_element(1.0), identity * f64::NAN, identity * 1e31]
    {
        assert!(inverse(&m).is_none(), "{m}");
        assert!(!is_covariance(&m), "{m}");
    }
}

#[test]
fn a_correction_is_schmidts_with_full_matrices() {
    let mut generator = Generator::new(13);
    for _ in 0..100 {
        let p = entangled(&mut generator);
        let mut h = Sensitivity::from_fn(|_, _| generator.gaussian());
        h.fixed_view_mut::<3, 3>(0, VELOCITY).fill(0.0);
        let (noise, innovation) = (random(&mut generator, 4.0), generator.gaussian_vector());
        let mut corrected = p;
        let found = corrected.correct(&h, &noise, &innovation).unwrap();

        let before = full(&p);
        assert!(before.cholesky().is_some(), "the test's own covariance");
        let s = h * before * h.transpose() + noise;
        let inverse = s.try_inverse().unwrap();
        let mut gain = before * h.transpose() * inverse;
        let state = gain * innovation;
        // What is only considered has no gain; Joseph's form holds for any gain.
        gain.fixed_view_mut::<6, 3>(7, 0).fill(0.0);
        let left = Full::identity() - gain * h;
        let after = left * before * left.transpose() + gain * noise * gain.transpose();
        assert_alike(&full(&corrected), &after, 1e-11);
        for axis in 0..3 {
            assert!((found.position_km[axis] - state[axis]).abs() < 1e-10);
            assert!((found.velocity_km_s[axis] - state[3 + axis]).abs() < 1e-10);
        }
        assert!((found.limb_height_km - state[6]).abs() < 1e-10);
        assert!((found.nis - innovation.dot(&(inverse * innovation))).abs() < 1e-9);
    }
}

#[test]
fn propagation_is_that_of_full_matrices() {
    let mut generator = Generator::new(14);
    let start = circular(7_000.0, 51.0);
    let dt = 60.0;
    let end = Dynamics::Full.propagate(&start, 60_000_000).unwrap();
    let motion = transition(&start, &end);
    let noise =
        ProcessNoise { acceleration: 1e-3, height_decay: 0.9, height_variance_added: 0.2, bias_decay: 0.7 };
    for _ in 0..100 {
        let p = entangled(&mut generator);
        let mut phi = Full::identity();
        phi.fixed_view_mut::<6, 6>(0, 0).copy_from(&Matrix6::from_fn(|row, column| motion[row][column]));
        phi[(6, 6)] = 0.9;
        let mut q = Full::zeros();
        q[(6, 6)] = 0.2;
        for axis in 0..3 {
            phi[(10 + axis, 10 + axis)] = 0.7;
            q[(axis, axis)] = 1e-3 * dt * dt * dt / 3.0;
            q[(axis, 3 + axis)] = 1e-3 * dt * dt / 2.0;
            q[(3 + axis, axis)] = q[(axis, 3 + axis)];
            q[(3 + axis, 3 + axis)] = 1e-3 * dt;
        }
        let expected = phi * full(&p) * phi.transpose() + q;
        let mut propagated = p;
        propagated.propagate(&motion, &noise, dt);
        assert_alike(&full(&propagated), &expected, 1e-11);
    }
}

#[test]
fn a_rotation_and_an_inflation_touch_position_and_velocity_alone() {
    let mut generator = Generator::new(15);
    let p = entangled(&mut generator);
    let turn = generator.rotation();
    let mut both = Full::identity();
    both.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
    both.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
    let mut rotated = p;
    rotated.rotate(&turn);
    assert_alike(&full(&rotated), &(both * full(&p) * both.transpose()), 1e-14);
    let mut inflated = p;
    inflated.inflate_motion(16.0);
    let expected = Full::from_fn(|row, column| match (row.min(column), row / 3 == column / 3) {
        (0..6, true) => 16.0 * p.at(row, column),
        (0..6, false) => 0.0,
        _ => p.at(row, column),
    });
    assert_eq!(full(&inflated), expected);
}

#[test]
fn correlations_are_those_of_the_full_matrix_row_by_row() {
    let mut generator = Generator::new(23);
    let p = entangled(&mut generator);
    let mut found = p.motion_correlations().into_iter();
    for row in 0..6 {
        for column in 0..row {
            let expected = p.at(row, column) / (p.at(row, row) * p.at(column, column)).sqrt();
            assert!((f64::from(found.next().unwrap()) - expected).abs() < 1e-7, "{row} {column}");
        }
    }
    assert_eq!(found.next(), None);
    assert_eq!(Covariance::ZERO.motion_correlations(), [0.0; 15]);
}
