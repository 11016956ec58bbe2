use super::*;

use crate::body::{CentralBody, EARTH, MOON};
use crate::gravity::MAX_DEGREE;
use crate::reference::field_acceleration;
use proptest::prelude::*;

#[test]
fn the_field_is_that_of_cunninghams_recursion() {
    for (x, y, z) in [
        (6_828.0f64, 0.0, 0.0f64),
        (0.0, -5_000.0, 5_000.0),
        (0.0, 0.0, 6_900.0),
        (-1_000.0, 2_000.0, -6_700.0),
        (30_000.0, 20_000.0, -10_000.0),
    ] {
        let r = Vector3::new(x, y, z);
        let distance = r.norm();
        let zonal = {
            let (up, u2) = (r / distance, (z / distance) * (z / distance));
            let scale = -1.5 * EARTH.j2 * EARTH.mu_km3_s2 * EARTH.radius_km.powi(2) / distance.powi(4);
            (up * (1.0 - 5.0 * u2) + Vector3::z() * (2.0 * z / distance)) * scale
        };
        let theirs = field_acceleration(&r, 8) + r * (EARTH.mu_km3_s2 / distance.powi(3)) - zonal;
        let ours = gravity::acceleration(CentralBody::Earth, (&r.map(|axis| axis as f32), [0.0, 1.0]), 8, 8)
            .map(f64::from);
        let apart = (ours - theirs).norm() / theirs.norm();
        // The rest of the reference's J2, known to 9 digits, is the greatest part.
        assert!(apart < 1e-4, "{r}: {apart}");
    }
}

#[test]
fn densities_are_those_another_program_gives() {
    // Over the south pole, the Sun 23.1 deg south: the values in the tests of brahe 1.8.
    let sun = Vector3::new(24_622_331.959_58, -133_060_326.832_922, -57_688_711.921_833f32).normalize();
    let apex = Vector3::new(LAG[0] * sun.x - LAG[1] * sun.y, LAG[1] * sun.x + LAG[0] * sun.y, sun.z);
    for (height_km, density) in [
        (110.0, 1.112_89e-7),
        (210.0, 2.026_86e-10),
        (310.0, 1.911_55e-11),
        (410.0, 3.441_49e-12),
        (510.0, 8.307_8e-13),
        (610.0, 2.391_34e-13),
        (710.0, 7.850_43e-14),
        (810.0, 2.919_71e-14),
    ] {
        let found = atmosphere::density_kg_m3(height_km, atmosphere::bulge(-apex.z));
        assert!((found / density - 1.0).abs() < 0.05, "{height_km} km: {found}");
    }
    assert_eq!(atmosphere::density_kg_m3(1_000.1, 1.0), 0.0);
    assert_eq!(atmosphere::density_kg_m3(-500.0, 0.0), atmosphere::density_kg_m3(100.0, 0.0));
}

#[test]
fn sun_and_moon_pull_as_points_do() {
    let bodies = Bodies::at(CentralBody::Earth, 0);
    let forces = Forces { sun_and_moon: true, ..Forces::KEPLER };
    for place in [[6_828.0, 0.0, 0.0], [0.0, -42_164.0, 100.0], [200_000.0, 150_000.0, -50_000.0]] {
        let r = Vector3::from(place);
        let pull = |body: &Vector3<f64>, mu: f64| {
            mu * ((body - r) / (body - r).norm().powi(3) - body / body.norm().powi(3))
        };
        let theirs = pull(&bodies.sun_km, MU_SUN_KM3_S2) + pull(&bodies.neighbour_km, MOON.mu_km3_s2);
        let ours = Perturbations::at(forces, 0, &bodies).acceleration(&r, &Vector3::zeros(), 0.0);
        assert!((ours - theirs).norm() < 1e-5 * theirs.norm(), "{r}");
    }
}

#[test]
fn the_shadow_is_a_cone_behind_the_earth() {
    let sun = Vector3::x();
    let at = |x: f32, y: f32| sunlight(&Vector3::new(x, y, 0.0), &sun, RADIUS_KM);
    assert_eq!([at(7_000.0, 0.0), at(-7_000.0, 0.0), at(-7_000.0, 6_500.0)], [1.0, 0.0, 1.0]);
    // In GEO the penumbra is 392 km wide.
    assert_eq!([at(-42_164.0, 6_170.0), at(-42_164.0, 6_590.0)], [0.0, 1.0]);
    assert!((at(-42_164.0, RADIUS_KM) - 0.5).abs() < 1e-6);
}

#[test]
fn light_pushes_away_from_the_sun() {
    let forces = Forces { radiation_m2_kg: 0.013, ..Forces::KEPLER };
    let sun_km = Bodies::at(CentralBody::Earth, 0).sun_km;
    let towards = sun_km.normalize();
    let pushed = Perturbations::at(forces, 0, &Bodies::at(CentralBody::Earth, 0)).acceleration(
        &(towards * 42_164.0),
        &Vector3::zeros(),
        0.0,
    );
    // 4.56e-6 N/m² on 0.013 m²/kg.
    let expected = -towards * (5.928e-11 * (AU_KM / sun_km.norm()).powi(2));
    assert!((pushed - expected).norm() < 1e-15, "{pushed}");
}

proptest! {
    #[test]
    fn every_state_within_bounds_has_a_finite_small_pull(
        distance_km in EARTH.bounds_km[0]..EARTH.bounds_km[1],
        place in prop::array::uniform3(-1.0..1.0f64),
        velocity in prop::array::uniform3(-30.0..30.0f64),
        time_us in -3_000_000_000_000_000..3_000_000_000_000_000i64,
        since_s in -150.0..150.0f32,
        degree in 0..=MAX_DEGREE,
        area_m2_kg in 0.0..10.0f32,
    ) {
        let place = Vector3::from(place);
        prop_assume!(place.norm() > 0.1);
        let forces = Forces {
            body: CentralBody::Earth,
            degree,
            order: degree,
            sun_and_moon: true,
            drag_m2_kg: area_m2_kg,
            radiation_m2_kg: area_m2_kg,
        };
        let r = place.normalize() * distance_km;
        let bodies = Bodies::at(CentralBody::Earth, time_us);
        let velocity = Vector3::from(velocity);
        let small = Perturbations::at(forces, time_us, &bodies).acceleration(&r, &velocity, since_s);
        // The densest air of the table, 5e-7 kg/m³, at 60 km/s on 10 m²/kg.
        prop_assert!(small.norm() < 10.0, "{small}");
    }
}
