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

/// Where a source at rest in direction `s` is seen from a frame that moves with `beta` (Lorentz's transformation of a light ray).
fn seen_in_flight(s: &Vector3<f64>, beta: &Vector3<f64>) -> Vector3<f64> {
    let gamma = 1.0 / (1.0 - beta.norm_squared()).sqrt();
    let along = s.dot(beta);
    (s / gamma + beta + beta * (along * gamma / (gamma + 1.0))) / (1.0 + along)
}

#[test]
fn without_aberration_a_fix_is_where_special_relativity_puts_it_to_the_first_order() {
    let mut generator = Generator::new(299);
    for _ in 0..200 {
        let distance_km = generator.between(6_600.0, 50_000.0);
        let down = generator.unit();
        // Up to ten times as fast as a low orbit, so that the second order shows.
        let velocity = generator.unit() * generator.between(1.0, 80.0);
        let beta = velocity / LIGHT_KM_S;
        let (truth, seen) = (-down * distance_km, -seen_in_flight(&down, &beta) * distance_km);
        assert!((seen.norm() / distance_km - 1.0).abs() < 1e-12);
        let place = seen + generator.unit() * 1.0;
        let covariance_km2 = Matrix3::identity() * 4.0;
        let fix = PositionFix { position_km: seen, covariance_km2, place_km: place };
        let cleaned = fix.without_aberration(&velocity);
        // The place is a kilometre aside: the shift is off by that share of itself.
        let second_order = distance_km * beta.norm_squared() + 2.0 * beta.norm();
        let error = (cleaned.position_km - truth).norm();
        assert!(error < second_order, "{error} of {second_order} km");
        assert!(((cleaned.position_km - cleaned.place_km) - (seen - place)).norm() < 1e-9);
        assert_eq!(cleaned.covariance_km2, covariance_km2);
    }
}

#[test]
fn the_aberration_of_a_low_orbit_is_five_arcseconds_backwards() {
    let position_km = Vector3::new(6_800.0, 0.0, 0.0);
    let fix = PositionFix { position_km, covariance_km2: Matrix3::identity(), place_km: position_km };
    let shift = fix.without_aberration(&Vector3::new(0.3, 7.6, 0.0)).position_km - position_km;
    let arcsec = shift.y / 6_800.0 * crate::oracle::ARCSEC;
    assert!((arcsec - 5.23).abs() < 0.01 && shift.x.abs() < 1e-9 && shift.z.abs() < 1e-9, "{shift}");
}
