//! Against the same algebra with full matrices of all thirteen states.

use super::*;
use crate::oracle::Generator;
use crate::orbit::dynamics::Dynamics;
use crate::orbit::reference::circular;
use nalgebra::SMatrix;

type Full = SMatrix<f64, 13, 13>;

/// A random covariance: the product of a random matrix with itself, its axes stretched by up to `spread` to either side.
fn random(generator: &mut Generator, spread: f64) -> Matrix3<f64> {
    let scale = |generator: &mut Generator| spread.powf(generator.between(-1.0, 1.0));
    let turn = generator.rotation();
    let axes = Vector3::new(scale(generator), scale(generator), scale(generator));
    symmetric(&(turn * Matrix3::from_diagonal(&axes) * turn.transpose()))
}

fn full(p: &Covariance) -> Full {
    let mut m = Full::zeros();
    let mut put = |row: usize, column: usize, block: &Matrix3<f64>| {
        m.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        m.fixed_view_mut::<3, 3>(column, row).copy_from(&block.transpose());
    };
    put(0, 0, &p.rr);
    put(0, 3, &p.rv);
    put(3, 3, &p.vv);
    put(0, 7, &p.rm);
    put(3, 7, &p.vm);
    put(7, 7, &(Matrix3::identity() * p.mm));
    put(0, 10, &p.rb);
    put(3, 10, &p.vb);
    put(10, 10, &p.bb);
    for axis in 0..3 {
        for (row, vector) in [(0, &p.rh), (3, &p.vh), (7, &p.hm), (10, &p.hb)] {
            m[(row + axis, 6)] = vector[axis];
            m[(6, row + axis)] = vector[axis];
        }
    }
    m[(6, 6)] = p.hh;
    m
}

/// A covariance in which everything hangs together, as the filter's does after some fixes: misalignment and bias apart.
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
    Covariance {
        rr: symmetric(&block(0, 0)),
        rv: block(0, 1),
        vv: symmetric(&block(1, 1)),
        rh: with_height(0),
        vh: with_height(1),
        hh: 1.0 + height_tilt.dot(&height_tilt) * m + height_bias.dot(&(b * height_bias)),
        rm: tilt[0] * m,
        vm: tilt[1] * m,
        hm: height_tilt * m,
        mm: m,
        rb: bias[0] * b,
        vb: bias[1] * b,
        hb: b * height_bias,
        bb: b,
    }
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
        let sensitivity = Sensitivity {
            position: symmetric(&random(&mut generator, 2.0)),
            limb_height: generator.gaussian_vector(),
            misalignment: Matrix3::from_fn(|_, _| generator.gaussian()),
            bias: random(&mut generator, 2.0),
        };
        let (noise, innovation) = (random(&mut generator, 4.0), generator.gaussian_vector());
        let mut corrected = p;
        let found = corrected.correct(&sensitivity, &noise, &innovation).unwrap();

        let mut h = SMatrix::<f64, 3, 13>::zeros();
        h.fixed_view_mut::<3, 3>(0, 0).copy_from(&sensitivity.position);
        h.fixed_view_mut::<3, 1>(0, 6).copy_from(&sensitivity.limb_height);
        h.fixed_view_mut::<3, 3>(0, 7).copy_from(&sensitivity.misalignment);
        h.fixed_view_mut::<3, 3>(0, 10).copy_from(&sensitivity.bias);
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
    let transition = Transition::between(&start, &end);
    let noise = ProcessNoise { acceleration: 1e-3, height_kept: 0.9, height_renewed: 0.2, bias_kept: 0.7 };
    for _ in 0..100 {
        let p = entangled(&mut generator);
        let mut phi = Full::identity();
        phi.fixed_view_mut::<3, 3>(0, 0).copy_from(&transition.rr);
        phi.fixed_view_mut::<3, 3>(0, 3).copy_from(&transition.rv);
        phi.fixed_view_mut::<3, 3>(3, 0).copy_from(&transition.vr);
        phi.fixed_view_mut::<3, 3>(3, 3).copy_from(&transition.vv);
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
        assert_alike(&full(&p.propagated(&transition, &noise, dt)), &expected, 1e-11);
    }
}
