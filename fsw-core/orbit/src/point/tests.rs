use super::*;
use crate::oracle::{Generator, rotation_of, turn};

fn narrow(q: [f64; 4]) -> [f32; 4] {
    q.map(|x| x as f32)
}

/// The term of the second order in the covariance of a position (eq. 5.13), km², ICRS axes: that of `ψ ×
/// δ`, the attitude's error times the Earth vector's, which are independent, `Σ P_ij [e_i×] C [e_j×]ᵀ`.
fn second_order_km2(
    earth_covariance_km2: &Matrix3<f32>,
    attitude: &Rotation<Icrs, StarPath>,
    attitude_covariance_rad2: &Matrix3<f32>,
    mounting: &Rotation<EarthPath, StarPath>,
) -> Matrix3<f64> {
    let to_star = mounting.matrix().map(f64::from);
    let earth = to_star * earth_covariance_km2.map(f64::from) * to_star.transpose();
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| cross_matrix(&axis));
    let p = attitude_covariance_rad2.map(f64::from);
    let own = |axis: &Matrix3<f64>, variance: f64| axis * earth * axis.transpose() * variance;
    let mixed = |one: &Matrix3<f64>, other: &Matrix3<f64>, covariance: f64| {
        let product = one * earth * other.transpose();
        (product + product.transpose()) * covariance
    };
    let in_star = own(&x, p.m11)
        + own(&y, p.m22)
        + own(&z, p.m33)
        + mixed(&x, &y, p.m12)
        + mixed(&x, &z, p.m13)
        + mixed(&y, &z, p.m23);
    let to_icrs = attitude.matrix().map(f64::from).transpose();
    symmetric_product(&to_icrs, &in_star)
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
            [&Matrix3::identity(), &Matrix3::zeros()],
            &earth.map(|x| x as f32),
            &earth_to_icrs(&attitude, &mounting),
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
    let seen_from = Rotation::from_quaternion(narrow(attitude)).unwrap();
    let mounted = Rotation::from_quaternion(narrow(mounting)).unwrap();
    let fix = PositionFix::new(
        &earth.map(|x| x as f32),
        [
            &Matrix3::from_diagonal(&sigma_earth.component_mul(&sigma_earth)).map(|x| x as f32),
            &Matrix3::zeros(),
        ],
        &earth.map(|x| x as f32),
        &earth_to_icrs(&seen_from, &mounted),
        &Matrix3::from_diagonal(&sigma_attitude.component_mul(&sigma_attitude)).map(|x| x as f32),
        &mounted,
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

/// Greatest departure of the scatter of positions by eq. 5.7 from a covariance, both whitened by it.
fn departure(
    covariance: &Matrix3<f64>,
    [a, t]: [&Matrix3<f64>; 2],
    earth: &Vector3<f64>,
    [attitude_factor, earth_factor]: [&Matrix3<f64>; 2],
    generator: &mut Generator,
) -> f64 {
    const RUNS: u32 = 200_000;
    let cross = |v: &Vector3<f64>| Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0);
    let mut scatter = Matrix3::zeros();
    for _ in 0..RUNS {
        let error = earth_factor * generator.gaussian_vector();
        let tilt = cross(&(attitude_factor * generator.gaussian_vector()));
        let seen = -(a.transpose() * (Matrix3::identity() - tilt) * t * (earth + error));
        let off = seen + a.transpose() * t * earth;
        scatter += off * off.transpose() / f64::from(RUNS);
    }
    let factor = covariance.cholesky().expect("positive definite").l();
    let whitener = factor.try_inverse().expect("of full rank");
    (whitener * scatter * whitener.transpose() - Matrix3::identity()).abs().max()
}

#[test]
fn the_covariance_is_within_five_percent_of_monte_carlo_and_its_second_order_counts_where_the_first_is_none()
{
    let mut generator = Generator::new(512);
    let arcsec = 1.0 / crate::oracle::ARCSEC;
    // Distance, sigmas of the Earth vector across and along, km; those of the attitude, rad.
    for (name, distance_km, [across_km, along_km], sigmas, first_is_enough) in [
        ("LEO", 6_828.0, [40.0, 100.0], [1.5 * arcsec, 1.5 * arcsec, 5.0 * arcsec], true),
        ("GEO", 42_164.0, [5.0, 25.0], [1.5 * arcsec, 1.5 * arcsec, 5.0 * arcsec], true),
        // A degree and two, and the distance all but known: what there is along the line is the product of
        // both errors.
        ("large, by direction alone", 42_164.0, [800.0, 2.0], [0.02, 0.03, 0.04], false),
    ] {
        let (attitude, mounting) = (generator.quaternion(), generator.quaternion());
        let (a, t) = (rotation_of(attitude), rotation_of(mounting));
        let down = generator.unit();
        let aside = generator.unit().cross(&down).normalize();
        let axes = Matrix3::from_columns(&[aside, down.cross(&aside), down]);
        let earth_factor = axes * Matrix3::from_diagonal(&Vector3::new(across_km, 0.7 * across_km, along_km));
        // Not along the axes of the star path either.
        let attitude_factor =
            rotation_of(generator.quaternion()) * Matrix3::from_diagonal(&Vector3::from(sigmas));
        let earth = down * distance_km;
        let single = |factor: &Matrix3<f64>| (factor * factor.transpose()).map(|element| element as f32);
        let (earth_covariance, attitude_covariance) = (single(&earth_factor), single(&attitude_factor));
        let attitude = Rotation::from_quaternion(narrow(attitude)).unwrap();
        let mounting = Rotation::from_quaternion(narrow(mounting)).unwrap();
        let seen = earth.map(|x| x as f32);
        let to_icrs = earth_to_icrs(&attitude, &mounting);
        let earth_both = [&earth_covariance, &Matrix3::zeros()];
        let fix =
            PositionFix::new(&seen, earth_both, &seen, &to_icrs, &attitude_covariance, &mounting).unwrap();
        let second = second_order_km2(&earth_covariance, &attitude, &attitude_covariance, &mounting);
        let mut off = |covariance: &Matrix3<f64>| {
            departure(covariance, [&a, &t], &earth, [&attitude_factor, &earth_factor], &mut generator)
        };
        let (first, both) = (off(&fix.covariance_km2), off(&(fix.covariance_km2 + second)));
        std::println!("{name}: eq. 5.12 within {first:.4} of Monte Carlo, with eq. 5.13 within {both:.4}");
        assert!(both < 0.05 && (first < 0.05) == first_is_enough, "{name}");
    }
}

#[test]
fn what_is_not_finite_makes_no_position() {
    let attitude = Rotation::from_quaternion([0.0, 0.0, 0.0, 1.0]).unwrap();
    let mounting = Rotation::from_quaternion([0.0, 0.0, 0.0, 1.0]).unwrap();
    let fix = |x: f32, c: f32| {
        PositionFix::new(
            &Vector3::new(x, 0.0, 0.0),
            [&Matrix3::from_element(c), &Matrix3::zeros()],
            &Vector3::new(x, 0.0, 0.0),
            &earth_to_icrs(&attitude, &mounting),
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

/// Where a source at rest in direction `s` is seen from a frame that moves with `beta` (Lorentz's
/// transformation of a light ray).
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
        let shared_km2 = Matrix3::zeros();
        let fix = PositionFix { position_km: seen, covariance_km2, shared_km2, linearisation_km: place };
        let cleaned = fix.without_aberration(&velocity);
        // The place is a kilometre aside: the shift is off by that share of itself.
        let second_order = distance_km * beta.norm_squared() + 2.0 * beta.norm();
        let error = (cleaned.position_km - truth).norm();
        assert!(error < second_order, "{error} of {second_order} km");
        assert!(((cleaned.position_km - cleaned.linearisation_km) - (seen - place)).norm() < 1e-9);
        assert_eq!(cleaned.covariance_km2, covariance_km2);
    }
}

#[test]
fn the_aberration_of_a_low_orbit_is_five_arcseconds_backwards() {
    let position_km = Vector3::new(6_800.0, 0.0, 0.0);
    let covariance_km2 = Matrix3::identity();
    let shared_km2 = Matrix3::zeros();
    let fix = PositionFix { position_km, covariance_km2, shared_km2, linearisation_km: position_km };
    let shift = fix.without_aberration(&Vector3::new(0.3, 7.6, 0.0)).position_km - position_km;
    let arcsec = shift.y / 6_800.0 * crate::oracle::ARCSEC;
    assert!((arcsec - 5.23).abs() < 0.01 && shift.x.abs() < 1e-9 && shift.z.abs() < 1e-9, "{shift}");
}
