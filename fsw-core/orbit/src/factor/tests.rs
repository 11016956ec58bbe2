use super::*;
use crate::oracle::Generator;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

type Square = SMatrix<f64, STATES, STATES>;
type Column = SVector<f64, STATES>;

/// The covariance by the definition, in f64; what the factor says of it must be that.
fn dense(factor: &Factor) -> Square {
    let product = |(one, other): (&f32, &f32)| f64::from(*one) * f64::from(*other);
    let by_definition = Square::from_fn(|i, j| factor.rows[i].iter().zip(&factor.rows[j]).map(product).sum());
    let told = Square::from_fn(|i, j| f64::from(factor.covariance(i, j)));
    assert!(close(&told, &by_definition));
    by_definition
}

/// A factor of correlated states with sigmas from 0.1 to 1.
fn any_factor(generator: &mut Generator) -> Factor {
    let mut factor = Factor::new();
    factor.begin(&core::array::from_fn(|_| generator.between(0.1, 1.0) as f32));
    for state in 0..STATES {
        for column in 0..state {
            factor.set(state, column, generator.between(-0.2, 0.2) as f32);
        }
    }
    factor
}

fn any_row(generator: &mut Generator) -> Row {
    core::array::from_fn(|_| generator.between(-1.0, 1.0) as f32)
}

fn close(one: &Square, other: &Square) -> bool {
    (one - other).abs().max() < 2e-5 * one.abs().max()
}

#[test]
fn a_settled_factor_has_the_same_covariance() {
    let mut generator = Generator::new(71);
    for _ in 0..20 {
        let mut factor = any_factor(&mut generator);
        let before = dense(&factor);
        let mut noise = Square::zeros();
        for _ in 0..SPARE {
            let shares: [(usize, f32); 3] =
                [0, 7, 21].map(|state| (state, generator.between(-1.0, 1.0) as f32));
            factor.append(&shares);
            let mut column = Column::zeros();
            for (state, share) in shares {
                column[state] = f64::from(share);
            }
            noise += column * column.transpose();
        }
        assert!(close(&dense(&factor), &(before + noise)));
        factor.settle();
        assert!(close(&dense(&factor), &(before + noise)));
        // A triangle: the last column is free for all but the last row.
        assert!(factor.rows[..STATES - 1].iter().all(|row| row[STATES - 1] == 0.0));
    }
}

#[test]
fn an_update_is_that_of_schmidt() {
    let mut generator = Generator::new(72);
    for _ in 0..20 {
        let mut factor = any_factor(&mut generator);
        let p = dense(&factor);
        let row = any_row(&mut generator);
        let h = Column::from_iterator(row.iter().map(|element| f64::from(*element)));
        let variance = h.dot(&(p * h)) + 1.0;
        let mut gain = p * h / variance;
        gain.rows_mut(MISALIGNMENT, STATES - MISALIGNMENT).fill(0.0);
        // For any gain (Joseph).
        let kept = Square::identity() - gain * h.transpose();
        let expected = kept * p * kept.transpose() + gain * gain.transpose();
        let told = factor.update(&row, Misalignment::Considered);
        for (told, expected) in told.iter().zip(gain.iter()) {
            assert!((f64::from(*told) - expected).abs() < 1e-5);
        }
        factor.settle();
        assert!(close(&dense(&factor), &expected));
        // What is considered is not learned.
        assert!((dense(&factor)[(21, 21)] / p[(21, 21)] - 1.0).abs() < 1e-5);
    }
}

#[test]
fn what_is_not_considered_has_the_optimal_gain() {
    let mut generator = Generator::new(74);
    let mut factor = any_factor(&mut generator);
    let p = dense(&factor);
    let row = any_row(&mut generator);
    let h = Column::from_iterator(row.iter().map(|element| f64::from(*element)));
    let gain = p * h / (h.dot(&(p * h)) + 1.0);
    let told = factor.update(&row, Misalignment::Estimated);
    for (told, expected) in told.iter().zip(gain.iter()) {
        assert!((f64::from(*told) - expected).abs() < 1e-5);
    }
    factor.settle();
    assert!(close(&dense(&factor), &(p - gain * h.transpose() * p)));
}

#[test]
fn propagation_is_the_transition_of_the_motion() {
    let mut generator = Generator::new(73);
    let mut factor = any_factor(&mut generator);
    let before = dense(&factor);
    let transition: [[f32; MOTION]; MOTION] =
        core::array::from_fn(|_| core::array::from_fn(|_| generator.between(-1.0, 1.0) as f32));
    let mut all = Square::identity();
    for (i, row) in transition.iter().enumerate() {
        for (j, element) in row.iter().enumerate() {
            all[(i, j)] = f64::from(*element);
        }
    }
    factor.propagate(&transition);
    assert!(close(&dense(&factor), &(all * before * all.transpose())));
}

#[test]
fn a_long_run_is_that_of_f64() {
    // An observation a step, noise on the rest: against Joseph's form of the three states concerned.
    let mut factor = Factor::new();
    factor.begin(&[3.0; STATES]);
    let mut row = [0.0; STATES];
    (row[0], row[9]) = (1.0, 0.3);
    let mut transition = [[0.0; MOTION]; MOTION];
    for (i, elements) in transition.iter_mut().enumerate() {
        elements[i] = 1.0;
    }
    transition[0][3] = 0.1;
    let step = Matrix3::new(1.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let noise = Matrix3::from_diagonal(&Vector3::new(0.0, 1e-6, 1e-6));
    let h = Vector3::new(1.0, 0.0, 0.3);
    let mut p = Matrix3::identity() * 9.0;
    for _ in 0..20_000 {
        factor.propagate(&transition);
        factor.append(&[(3, 1e-3)]);
        factor.append(&[(9, 1e-3)]);
        factor.update(&row, Misalignment::Considered);
        factor.settle();
        p = step * p * step.transpose() + noise;
        let gain = p * h / (h.dot(&(p * h)) + 1.0);
        let kept = Matrix3::identity() - gain * h.transpose();
        p = kept * p * kept.transpose() + gain * gain.transpose();
    }
    assert!(factor.is_valid());
    for (at, state) in [0, 3, 9].into_iter().enumerate() {
        let (told, expected) = (f64::from(factor.sigma(state)), f64::sqrt(p[(at, at)]));
        assert!((told / expected - 1.0).abs() < 1e-2, "{state}: {told} {expected}");
    }
}
