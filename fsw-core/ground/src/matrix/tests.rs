use super::*;
use crate::oracle::Generator;
use nalgebra::{Matrix3, Matrix6, Vector3};

fn random<const R: usize, const C: usize>(seed: u64) -> SMatrix<f64, R, C> {
    let mut generator = Generator::new(seed);
    SMatrix::from_fn(|_, _| generator.gaussian())
}

#[test]
fn products_of_every_shape_have_the_bits_of_nalgebra() {
    for seed in 0..200 {
        let (a, b) = (random::<6, 3>(seed), random::<3, 7>(seed + 1000));
        assert_eq!(product(&a, &b), a * b);
        assert_eq!(product_transposed(&a, &b.transpose()), a * b);
        assert_eq!(transposed_product(&a.transpose(), &b), a * b);
        let before = random::<6, 7>(seed + 2000);
        let mut sum = before;
        add_product_transposed(&mut sum, &a, &b.transpose());
        assert_eq!(sum, before + a * b);
        let (a, b) = (a.map(|x| x as f32), b.map(|x| x as f32));
        assert_eq!(product(&a, &b), a * b);
    }
}

#[test]
fn an_update_of_rank_one_and_a_scaled_sum_are_what_they_are_called() {
    let (u, v) = (random::<3, 1>(1), random::<4, 1>(2));
    let mut matrix = random::<3, 4>(3);
    let before = matrix;
    add_product_transposed(&mut matrix, &u, &v);
    assert_eq!(matrix, before + u * v.transpose());
    add_scaled(&mut matrix, 0.25, &before);
    assert_eq!(matrix, before + u * v.transpose() + before * 0.25);
    assert_eq!(scaled(&before, 3.0), before * 3.0);
}

#[test]
fn a_carried_covariance_is_symmetric_to_the_last_bit() {
    for seed in 0..100 {
        let (a, root) = (random::<4, 6>(seed), random::<6, 6>(seed + 1000));
        let carried = symmetric_product(&a, &(root * root.transpose()));
        assert_eq!(carried, carried.transpose());
        assert!((carried - a * root * root.transpose() * a.transpose()).amax() < 1e-12 * carried.amax());
    }
}

#[test]
fn cholesky_solves_inverts_and_whitens() {
    for seed in 0..200 {
        let root = random::<6, 6>(seed);
        let matrix: Matrix6<f64> = root * root.transpose() + Matrix6::identity() * 0.1;
        let factor = Cholesky::of(&matrix).unwrap();
        let inverse = factor.inverse();
        assert!((inverse * matrix - Matrix6::identity()).amax() < 1e-10, "{seed}");
        let right = random::<6, 1>(seed + 1000);
        assert!((matrix * factor.solve(&right) - right).amax() < 1e-10, "{seed}");
        // |L⁻¹ b|² = bᵀ M⁻¹ b.
        let white = factor.whitened(&right);
        let expected = right.dot(&(inverse * right));
        assert!((white.dot(&white) / expected - 1.0).abs() < 1e-10, "{seed}");
    }
}

#[test]
fn what_is_not_positive_definite_has_no_factor() {
    let flat = Vector3::new(1.0f32, 2.0, 3.0);
    let refused = [
        Matrix3::zeros(),
        -Matrix3::identity(),
        flat * flat.transpose(),
        Matrix3::identity() * f32::NAN,
        Matrix3::identity() * f32::INFINITY,
    ];
    for matrix in refused {
        assert!(inverse(&matrix).is_none(), "{matrix}");
    }
}

#[test]
fn a_cross_matrix_times_a_vector_is_the_vector_product() {
    let (v, w) = (random::<3, 1>(1), random::<3, 1>(2));
    assert_eq!(cross_matrix(&v) * w, v.cross(&w));
    assert_eq!(plus_scaled(&v, 2.0, &w), v + w * 2.0);
    assert_eq!(dot(&v, &w), v.x * w.x + v.y * w.y + v.z * w.z);
    assert_eq!(identity::<f32, 3>(), Matrix3::identity());
}

#[test]
fn equations_taken_into_a_triangle_have_the_least_squares_solution_and_its_residuals() {
    for seed in 0..50 {
        let coefficients = random::<12, 3>(seed).map(|value| value as f32);
        let right = random::<12, 1>(seed + 1000).map(|value| value as f32);
        let mut triangle = [[0.0f32; 4]; 3];
        let mut square = 0.0;
        for (row, value) in coefficients.row_iter().zip(right.iter()) {
            let mut equation = [row[0], row[1], row[2], *value];
            rotate_into(&mut triangle, &mut equation);
            square += equation[3] * equation[3];
        }
        let [[a, b, c, x], [d, e, f, y], [g, h, i, z]] = triangle;
        assert!([d, g, h].iter().all(|below| *below == 0.0));
        let triangle = Matrix3::new(a, b, c, 0.0, e, f, 0.0, 0.0, i);
        let found = triangle.try_inverse().unwrap() * Vector3::new(x, y, z);
        let normal = coefficients.transpose() * coefficients;
        let expected = normal.try_inverse().unwrap() * (coefficients.transpose() * right);
        assert!((found - expected).amax() < 1e-4 * expected.amax(), "{seed}: {found} {expected}");
        let left = (coefficients * expected - right).norm_squared();
        assert!((square / left - 1.0).abs() < 1e-4, "{seed}: {square} {left}");
    }
}
