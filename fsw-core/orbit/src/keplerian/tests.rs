use super::*;
use crate::body::EARTH;
use core::f64::consts::FRAC_PI_2;
use proptest::prelude::*;

fn turn(angle_rad: f64, from_rad: f64) -> f64 {
    (angle_rad - from_rad + PI).rem_euclid(TAU) - PI
}

fn apart((r, v): (Vector3<f64>, Vector3<f64>), (s, w): (Vector3<f64>, Vector3<f64>)) -> f64 {
    ((r - s).norm() / r.norm()).max((v - w).norm() / v.norm())
}

proptest! {
    #[test]
    fn elements_come_back_from_their_state(
        semi_major_axis_km in 6_600.0..200_000.0f64,
        eccentricity in 1e-4..0.95f64,
        inclination_rad in 1e-3..PI - 1e-3,
        node_rad in 0.0..TAU,
        perigee_rad in 0.0..TAU,
        anomaly_rad in 0.0..TAU,
    ) {
        let given = Keplerian {
            semi_major_axis_km, eccentricity, inclination_rad, node_rad, perigee_rad, anomaly_rad,
        };
        let (r, v) = given.state(EARTH.mu_km3_s2).unwrap();
        let back = Keplerian::of(EARTH.mu_km3_s2, &r, &v).unwrap();
        prop_assert!((back.semi_major_axis_km / semi_major_axis_km - 1.0).abs() < 1e-9);
        prop_assert!((back.eccentricity - eccentricity).abs() < 1e-10);
        prop_assert!((back.inclination_rad - inclination_rad).abs() < 1e-10);
        prop_assert!(turn(back.node_rad, node_rad).abs() < 1e-9);
        prop_assert!(turn(back.perigee_rad, perigee_rad).abs() < 1e-8);
        prop_assert!(turn(back.anomaly_rad, anomaly_rad).abs() < 1e-8);
        for angle in [back.node_rad, back.perigee_rad, back.anomaly_rad] {
            prop_assert!((0.0..TAU).contains(&angle));
        }
        prop_assert!(apart(back.state(EARTH.mu_km3_s2).unwrap(), (r, v)) < 1e-9);
    }

    #[test]
    fn nothing_that_is_given_makes_elements_that_are_not_finite(
        r in prop::array::uniform3(-1e6..1e6f64),
        v in prop::array::uniform3(-20.0..20.0f64),
    ) {
        if let Some(of) = Keplerian::of(EARTH.mu_km3_s2, &r.into(), &v.into()) {
            let Keplerian { semi_major_axis_km, eccentricity, inclination_rad, node_rad, .. } = of;
            let all = [semi_major_axis_km, eccentricity, inclination_rad, node_rad, of.perigee_rad, of.anomaly_rad];
            prop_assert!(all.iter().all(|element| element.is_finite()));
        }
    }
}

/// Circles and the equator, one way round and the other: what is not defined is 0, and the state comes back.
#[test]
fn the_singular_cases_are_exact() {
    for inclination_rad in [0.0, 1.0, FRAC_PI_2, PI] {
        for eccentricity in [0.0, 0.3] {
            let given = Keplerian {
                semi_major_axis_km: 7178.0,
                eccentricity,
                inclination_rad,
                node_rad: if inclination_rad == 0.0 || inclination_rad == PI { 0.0 } else { 2.0 },
                perigee_rad: if eccentricity == 0.0 { 0.0 } else { 4.0 },
                anomaly_rad: 5.0,
            };
            let (r, v) = given.state(EARTH.mu_km3_s2).unwrap();
            let back = Keplerian::of(EARTH.mu_km3_s2, &r, &v).unwrap();
            assert!((back.inclination_rad - inclination_rad).abs() < 1e-9, "{back:?}");
            for (angle, from) in [
                (back.node_rad, given.node_rad),
                (back.perigee_rad, given.perigee_rad),
                (back.anomaly_rad, given.anomaly_rad),
            ] {
                assert!(turn(angle, from).abs() < 1e-9, "{given:?} {back:?}");
            }
            assert!(apart(back.state(EARTH.mu_km3_s2).unwrap(), (r, v)) < 1e-10);
        }
    }
}

#[test]
fn the_worked_example_of_the_textbook() {
    // Vallado, Fundamentals of Astrodynamics, example 2-5.
    let r = Vector3::new(6524.834, 6862.875, 6448.296);
    let v = Vector3::new(4.901327, 5.533756, -1.976341);
    let of = Keplerian::of(EARTH.mu_km3_s2, &r, &v).unwrap();
    let degrees = [of.inclination_rad, of.node_rad, of.perigee_rad, of.anomaly_rad].map(f64::to_degrees);
    assert!((of.semi_major_axis_km - 36_127.343).abs() < 0.01, "{of:?}");
    assert!((of.eccentricity - 0.832_853).abs() < 1e-6);
    for (ours, book) in degrees.iter().zip([87.870, 227.898, 53.38, 92.335]) {
        assert!((ours - book).abs() < 6e-3, "{degrees:?}");
    }
}

#[test]
fn what_is_no_closed_orbit_is_refused() {
    let r = Vector3::new(7000.0, 0.0, 0.0);
    assert!(Keplerian::of(EARTH.mu_km3_s2, &r, &Vector3::new(0.0, 11.0, 0.0)).is_none());
    assert!(Keplerian::of(EARTH.mu_km3_s2, &r, &Vector3::new(0.0, f64::NAN, 0.0)).is_none());
    assert!(Keplerian::of(EARTH.mu_km3_s2, &r, &r).is_none());
    let elements = Keplerian::of(EARTH.mu_km3_s2, &r, &Vector3::new(0.0, 7.5, 1.0)).unwrap();
    assert!(Keplerian { eccentricity: 1.0, ..elements }.state(EARTH.mu_km3_s2).is_none());
    assert!(Keplerian { anomaly_rad: f64::NAN, ..elements }.state(EARTH.mu_km3_s2).is_none());
    assert!(Keplerian { semi_major_axis_km: -1.0, ..elements }.state(EARTH.mu_km3_s2).is_none());
}
