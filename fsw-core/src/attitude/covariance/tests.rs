use super::*;
use crate::attitude::VectorPair;
use crate::attitude::wahba::svd;
use crate::frames::Direction;
use crate::oracle::{Generator, small_turn, wide, wide_matrix};
use nalgebra::Matrix3 as M3;
use nalgebra::Vector3 as V3;
use std::vec::Vec;

const CASES: usize = 4000;
/// 99.9 % of a normal distribution lie within so many sigmas.
const BAND: f64 = 3.29;

fn direction<F>(vector: &V3<f64>) -> Direction<F> {
    Direction::new(vector.map(|x| x as f32)).unwrap()
}

/// Stars in the reference field with sigmas of 10 to 60 arcsec, measured with exactly such errors, and the
/// truth.
fn noisy_field(generator: &mut Generator) -> (Vec<VectorPair>, M3<f64>) {
    let attitude = generator.rotation();
    let count = 3 + generator.bits() % 8;
    let see = |_| {
        let star = generator.unit_in_cap(0.19);
        let sigma_rad = generator.between(5e-5, 3e-4) as f32;
        let error = generator.gaussian_vector() * f64::from(sigma_rad);
        let across = error - star * star.dot(&error);
        VectorPair {
            measured: direction(&(star + across)),
            reference: direction(&(attitude.transpose() * star)),
            sigma_rad,
        }
    };
    ((0..count).map(see).collect(), attitude)
}

/// `[Σ a (I - b bᵀ)]⁻¹` in f64, literally eq. 3.27.
fn eq_3_27(pairs: &[VectorPair]) -> M3<f64> {
    let sum = pairs.iter().fold(M3::zeros(), |sum, pair| {
        let (b, sigma) = (wide(pair.measured.vector()), f64::from(pair.sigma_rad));
        sum + (M3::identity() * b.norm_squared() - b * b.transpose()) / (sigma * sigma)
    });
    sum.try_inverse().unwrap()
}

#[test]
fn eq_3_27_is_the_scatter_of_the_attitude_error() {
    let mut generator = Generator::new(1);
    let (mut nees, mut beyond_95) = (0.0, 0.0);
    let mut squares = V3::zeros();
    for _ in 0..CASES {
        let (pairs, truth) = noisy_field(&mut generator);
        let found = svd::solve(&pairs).unwrap();
        let error = small_turn(&truth, &wide_matrix(found.matrix()));
        let covariance = Information::of(&pairs).covariance_rad2().unwrap();
        let normalised = error.dot(&(wide_matrix(&covariance).try_inverse().unwrap() * error));
        nees += normalised / CASES as f64;
        // 95 % quantile of chi square with three degrees of freedom.
        beyond_95 += if normalised > 7.814_728 { 1.0 / CASES as f64 } else { 0.0 };
        let sigmas = V3::from(sigmas_rad(&covariance).map(f64::from));
        squares += error.component_div(&sigmas).map(|x| x * x) / CASES as f64;
    }
    std::println!("NEES {nees:.3} of 3, beyond 95 %: {beyond_95:.4}, axes {:.3?}", squares.as_slice());
    let cases = CASES as f64;
    // Chi square with n degrees of freedom has variance 2 n.
    assert!((nees - 3.0).abs() < BAND * (6.0 / cases).sqrt(), "{nees}");
    assert!((beyond_95 - 0.05).abs() < BAND * (0.05 * 0.95 / cases).sqrt(), "{beyond_95}");
    for square in squares.iter() {
        assert!((square - 1.0).abs() < BAND * (2.0 / cases).sqrt(), "{squares}");
    }
}

#[test]
fn the_covariance_is_eq_3_27_in_f64() {
    let mut generator = Generator::new(2);
    let mut worst = 0.0f64;
    for _ in 0..CASES {
        let (pairs, _) = noisy_field(&mut generator);
        let (flight, exact) = (Information::of(&pairs).covariance_rad2().unwrap(), eq_3_27(&pairs));
        for row in 0..3 {
            for column in 0..3 {
                let scale = (exact[(row, row)] * exact[(column, column)]).sqrt();
                let error = f64::from(flight[(row, column)]) - exact[(row, column)];
                worst = worst.max(error.abs() / scale);
            }
        }
    }
    std::println!("covariance against f64: {worst:.2e} relative");
    assert!(worst < 2e-5, "{worst:e}");
}

#[test]
fn solving_undoes_the_information_matrix() {
    let mut generator = Generator::new(3);
    for _ in 0..CASES {
        let (pairs, _) = noisy_field(&mut generator);
        let information = Information::of(&pairs);
        let right = generator.unit().map(|x| x as f32);
        let solution = information.solve(&right).unwrap();
        // Information counts in 1 / mrad².
        let expected = eq_3_27(&pairs) * 1e6 * wide(&right);
        let error = (wide(&solution) - expected).norm() / expected.norm();
        assert!(error < 2e-5, "{error:e}");
    }
}

#[test]
fn worse_centroids_give_larger_sigmas_in_proportion() {
    let mut generator = Generator::new(4);
    let (pairs, _) = noisy_field(&mut generator);
    let sigmas = |factor: f32| {
        let scaled: Vec<_> =
            pairs.iter().map(|pair| VectorPair { sigma_rad: pair.sigma_rad * factor, ..*pair }).collect();
        sigmas_rad(&Information::of(&scaled).covariance_rad2().unwrap())
    };
    for (one, two) in sigmas(1.0).iter().zip(sigmas(2.0)) {
        assert!((two / one - 2.0).abs() < 1e-3);
    }
}

#[test]
fn directions_that_leave_an_angle_open_have_no_covariance() {
    let mut generator = Generator::new(5);
    for _ in 0..1000 {
        // Up to 57 deg off the line of sight; beside the camera rounding can pass for information.
        let star = generator.unit_in_cap(1.0);
        let pair = VectorPair { measured: direction(&star), reference: direction(&star), sigma_rad: 1e-4 };
        for pairs in [&[][..], &[pair], &[pair; 6]] {
            assert!(Information::of(pairs).covariance_rad2().is_none(), "{star}");
            assert!(Information::of(pairs).solve(&Vector3::new(1.0, 0.0, 0.0)).is_none());
        }
    }
}
