use super::*;
use crate::oracle::{Generator, rotation_of, turn};

fn narrow(q: [f64; 4]) -> [f32; 4] {
    q.map(|x| x as f32)
}

#[test]
fn the_position_is_eq_5_4() {
    let mut generator = Generator::new(54);
    for _ in 0..200 {
        let (attitude, mounting) = (generator.quaternion(), generator.quaternion());
        let earth = generator.unit() * generator.between(6_500.0, 50_000.0);
        let expected = -(rotation_of(attitude).transpose() * rotation_of(mounting) * earth);
        let attitude = Rotation::from_quaternion(narrow(attitude)).unwrap();
        let mounting = Rotation::from_quaternion(narrow(mounting)).unwrap();
        let fix = PositionFix::new(
            &earth.map(|x| x as f32),
            &Matrix3::identity(),
            &earth.map(|x| x as f32),
            &attitude,
            &Matrix3::zeros(),
            &mounting,
        )
        .unwrap();
        assert!((fix.position_km - expected).norm() < 1e-6 * earth.norm());
        // The length is kept better than the direction.
        assert!((fix.position_km.norm() / earth.norm() - 1.0).abs() < 1.2e-7);
        let matrix = earth_to_icrs(&attitude, &mounting);
        assert!((matrix * matrix.transpose() - Matrix3::identity()).abs().max() < 1e-11);
    }
}

#[test]
fn covariance_is_the_scatter_of_the_position() {
    let mut generator = Generator::new(59);
    let (attitude, mounting) = (generator.quaternion(), generator.quaternion());
    let earth = Vector3::new(3_000.0, -2_000.0, 41_000.0);
    let sigma_earth = Vector3::new(10.0, 20.0, 90.0);
    // Large on purpose, and unequal: the roll counts.
    let sigma_attitude = Vector3::new(4e-4, 6e-4, 3e-3);
    let fix = PositionFix::new(
        &earth.map(|x| x as f32),
        &Matrix3::from_diagonal(&sigma_earth.component_mul(&sigma_earth)).map(|x| x as f32),
        &earth.map(|x| x as f32),
        &Rotation::from_quaternion(narrow(attitude)).unwrap(),
        &Matrix3::from_diagonal(&sigma_attitude.component_mul(&sigma_attitude)).map(|x| x as f32),
        &Rotation::from_quaternion(narrow(mounting)).unwrap(),
    )
    .unwrap();
    let inverse = fix.covariance_km2.try_inverse().unwrap();
    let (a, t) = (rotation_of(attitude), rotation_of(mounting));
    let truth = -(a.transpose() * t * earth);
    let runs = 20_000;
    let mut scatter = Matrix3::zeros();
    for _ in 0..runs {
        let seen = earth + generator.gaussian_vector().component_mul(&sigma_earth);
        let tilted = turn(&generator.gaussian_vector().component_mul(&sigma_attitude)) * a;
        let error = -(tilted.transpose() * t * seen) - truth;
        scatter += error * error.transpose() / f64::from(runs);
    }
    // Whitened, the scatter is the unit matrix but for 1/sqrt(runs) = 0.7 %.
    let excess = (inverse * scatter - Matrix3::identity()).abs().max();
    assert!(excess < 0.06, "{excess}");
}

#[test]
fn what_is_not_finite_makes_no_position() {
    let attitude = Rotation::from_quaternion([0.0, 0.0, 0.0, 1.0]).unwrap();
    let mounting = Rotation::from_quaternion([0.0, 0.0, 0.0, 1.0]).unwrap();
    let fix = |x: f32, c: f32| {
        PositionFix::new(
            &Vector3::new(x, 0.0, 0.0),
            &Matrix3::from_element(c),
            &Vector3::new(x, 0.0, 0.0),
            &attitude,
            &Matrix3::zeros(),
            &mounting,
        )
    };
    assert!(fix(7_000.0, 1.0).is_some());
    for (x, c) in [(f32::NAN, 1.0), (f32::INFINITY, 1.0), (7_000.0, f32::NAN)] {
        assert!(fix(x, c).is_none());
    }
}

#[test]
fn distance_is_eq_2_8() {
    let geo = distance_km((6_378.137f64 / 42_164.0).asin() as f32, 6_378.137).unwrap();
    assert!((geo - 42_164.0).abs() < 0.02, "{geo}");
    for wrong in [0.0, -0.1, 1.6, f32::NAN] {
        assert!(distance_km(wrong, 6_378.137).is_none());
    }
}
