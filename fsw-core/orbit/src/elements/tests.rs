use super::*;
use crate::OrbitState;
use crate::body::EARTH;
use crate::forces::Forces;
use proptest::prelude::*;

/// A state from Kepler's elements (km, angles in rad), by the rotations of the textbook.
fn kepler(axis_km: f64, e: f64, [i, node, perigee, anomaly]: [f64; 4]) -> (Vector3<f64>, Vector3<f64>) {
    let parameter = axis_km * (1.0 - e * e);
    let radius = parameter / (1.0 + e * anomaly.cos());
    let speed = (EARTH.mu_km3_s2 / parameter).sqrt();
    let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), node)
        * nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), i)
        * nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), perigee);
    let position = Vector3::new(anomaly.cos(), anomaly.sin(), 0.0) * radius;
    let velocity = Vector3::new(-anomaly.sin(), e + anomaly.cos(), 0.0) * speed;
    (turn * position, turn * velocity)
}

fn apart((r, v): (Vector3<f64>, Vector3<f64>), (s, w): (Vector3<f64>, Vector3<f64>)) -> f64 {
    ((r - s).norm() / r.norm()).max((v - w).norm() / v.norm())
}

proptest! {
    #[test]
    fn a_state_comes_back_from_its_elements(
        axis_km in 6_600.0..200_000.0f64,
        e in 0.0..0.95f64,
        i in 0.0..core::f64::consts::PI,
        node in 0.0..6.3f64,
        perigee in 0.0..6.3f64,
        anomaly in 0.0..6.3f64,
    ) {
        let (r, v) = kepler(axis_km, e, [i, node, perigee, anomaly]);
        let elements = Equinoctial::of(EARTH.mu_km3_s2, &r, &v).unwrap();
        prop_assert!(apart(elements.state(EARTH.mu_km3_s2).unwrap(), (r, v)) < 1e-9);
        let [h, k] = elements.eccentricity;
        prop_assert!((h.hypot(k) - e).abs() < 1e-9);
        let [p, q] = elements.inclination;
        // At most 90 deg from the pole that the retrograde factor chooses.
        prop_assert!(p.hypot(q) <= 1.0 + 1e-9);
        let period = TAU * (axis_km.powi(3) / EARTH.mu_km3_s2).sqrt();
        prop_assert!((elements.mean_motion_rad_s * period / TAU - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_singular_cases_of_keplers_elements_are_regular() {
    for (e, i) in
        [(0.0, 0.0), (0.0, 1.0), (0.3, 0.0), (0.0, core::f64::consts::PI), (0.3, core::f64::consts::PI)]
    {
        let (r, v) = kepler(7_000.0, e, [i, 0.4, 1.1, 2.0]);
        let elements = Equinoctial::of(EARTH.mu_km3_s2, &r, &v).unwrap();
        assert!(apart(elements.state(EARTH.mu_km3_s2).unwrap(), (r, v)) < 1e-12, "e {e}, i {i}");
    }
}

#[test]
fn only_the_longitude_grows_about_a_point_mass() {
    for angles in [[0.1, 0.2, 0.3, 0.4], [2.5, 3.0, 1.0, 2.0]] {
        let (position_km, velocity_km_s) = kepler(9_000.0, 0.2, angles);
        let start = OrbitState { time_us: 0, position_km, velocity_km_s };
        let before = Equinoctial::of(EARTH.mu_km3_s2, &position_km, &velocity_km_s).unwrap();
        let after = Forces::KEPLER.propagate(&start, 100_000_000).unwrap();
        let after = Equinoctial::of(EARTH.mu_km3_s2, &after.position_km, &after.velocity_km_s).unwrap();
        let [n, h, k, p, q, longitude] = after.minus(&before).unwrap();
        assert!(n.abs() < 1e-6 * before.mean_motion_rad_s);
        assert!([h, k, p, q].iter().all(|element| element.abs() < 1e-6));
        assert!((longitude - 100.0 * before.mean_motion_rad_s).abs() < 1e-6);
    }
}

#[test]
fn what_is_no_closed_orbit_has_no_elements() {
    let (r, v) = kepler(9_000.0, 0.2, [0.1, 0.2, 0.3, 0.4]);
    // Faster than the escape, in line with the position, at rest, not finite.
    for bad in [v * 2.0, r * 1e-6, Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0)] {
        assert_eq!(Equinoctial::of(EARTH.mu_km3_s2, &r, &bad), None);
    }
    assert_eq!(Equinoctial::of(EARTH.mu_km3_s2, &Vector3::zeros(), &v), None);
    let open = Equinoctial { eccentricity: [0.9, 0.9], ..Equinoctial::of(EARTH.mu_km3_s2, &r, &v).unwrap() };
    assert_eq!(open.state(EARTH.mu_km3_s2), None);
    let still = Equinoctial { mean_motion_rad_s: -1.0, ..open };
    assert_eq!(still.state(EARTH.mu_km3_s2), None);
}

#[test]
fn the_difference_of_longitudes_is_the_shorter_one() {
    let (r, v) = kepler(9_000.0, 0.2, [0.1, 0.2, 0.3, 0.4]);
    let one = Equinoctial { longitude_rad: 3.1, ..Equinoctial::of(EARTH.mu_km3_s2, &r, &v).unwrap() };
    let other = Equinoctial { longitude_rad: -3.1, ..one };
    let [.., difference] = one.minus(&other).unwrap();
    assert!((difference - (6.2 - TAU)).abs() < 1e-12);
    assert_eq!(one.plus(&[0.0; 6]), one);
    assert_eq!(Equinoctial { retrograde: true, ..one }.minus(&one), None);
}
