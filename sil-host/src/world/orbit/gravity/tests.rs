//! The field against its own potential and against closed forms.

use super::*;
use crate::world::vector::{length, minus};
use proptest::prelude::*;

/// Legendre's polynomial of degree n and its derivative (Bonnet's recursion).
fn legendre(n: usize, u: f64) -> (f64, f64) {
    let (mut p, mut q) = (u, 1.0);
    for k in 2..=n {
        let next = ((2 * k - 1) as f64 * u * p - (k - 1) as f64 * q) / k as f64;
        (q, p) = (p, next);
    }
    (p, n as f64 * (u * p - q) / (u * u - 1.0))
}

#[test]
fn zonals_are_those_of_legendre() {
    // One zonal at a time: the potential mu / r (R / r)^n C P_n(z / r), its slope along r and along the
    // meridian.
    let r = [3100.0, -4700.0, 4300.0];
    let radius = length(r);
    let u = r[2] / radius;
    for n in 2..=4 {
        let c = 1e-3 / f64::from(n as u8);
        let field = Gravity::of_table(MU_EARTH, &format!("{n} 0 {c} 0"), n);
        let (p, slope) = legendre(n, u);
        let strength = c * (2.0 * n as f64 + 1.0).sqrt() * MU_EARTH / (radius * radius)
            * libm::pow(RADIUS_KM / radius, n as f64);
        let point = MU_EARTH / (radius * radius * radius);
        for axis in 0..3 {
            let grad_u = (f64::from(axis == 2) - u * r[axis] / radius) * slope;
            let expected = strength * (grad_u - (n as f64 + 1.0) * p * r[axis] / radius) - point * r[axis];
            assert!((field.acceleration(r)[axis] - expected).abs() < 1e-16, "{n} {axis}");
        }
    }
}

#[test]
fn sectorials_are_those_of_the_equators_ellipse() {
    // 3 mu R² [C22 (x² - y²) + 2 S22 x y] / r⁵ with C22 not normalised, sqrt(5 / 12) of the normalised.
    let (c, s) = (2.4e-6, -1.4e-6);
    let field = Gravity::of_table(MU_EARTH, &format!("2 2 {c} {s}"), 2);
    let [x, y, z] = [3100.0, -4700.0, 4300.0f64];
    let (c22, s22) = (c * (5.0f64 / 12.0).sqrt(), s * (5.0f64 / 12.0).sqrt());
    let square = x * x + y * y + z * z;
    let form = c22 * (x * x - y * y) + 2.0 * s22 * x * y;
    let scale = 3.0 * MU_EARTH * RADIUS_KM * RADIUS_KM / (square * square * square.sqrt());
    let expected = [
        2.0 * c22 * x + 2.0 * s22 * y - 5.0 * form / square * x,
        -2.0 * c22 * y + 2.0 * s22 * x - 5.0 * form / square * y,
        -5.0 * form / square * z,
    ];
    let central = MU_EARTH / (square * square.sqrt());
    for axis in 0..3 {
        let rest = field.acceleration([x, y, z])[axis] + central * [x, y, z][axis];
        assert!((rest - scale * expected[axis]).abs() < 1e-17);
    }
}

#[test]
fn the_known_strengths_of_the_earth_are_found() {
    // J2 = 1.0826359e-3 with the lasting tide (IERS Conventions 2010, table 1.1, from laser ranging; the
    // model's own is 3.3e-10 less).
    let j2 = -EGM2008[0].c * 5f64.sqrt();
    assert!((j2 - 1.082_635_9e-3).abs() < 4e-10, "{j2}");
    assert_eq!(EGM2008.len(), index(LARGEST + 1, 0) - 3);
    // Normal gravity at the pole is 9.8322 m/s² and at the equator 9.7803, there with 0.0339 of the turning
    // taken off; what the field has beyond the ellipsoid is below 0.001.
    let field = Gravity::egm2008(20, 20);
    let pole = length(field.acceleration([0.0, 0.0, 6356.752]));
    let equator = length(field.acceleration([6378.137, 0.0, 0.0]));
    assert!((1e3 * pole - 9.832_2).abs() < 1e-3 && (1e3 * equator - 9.780_3 - 0.033_92).abs() < 1e-3);
}

proptest! {
    #[test]
    fn acceleration_is_the_slope_of_the_potential(
        direction in prop::array::uniform3(-1.0..1.0f64).prop_filter("zero", |d| length(*d) > 0.1),
        radius in 6500.0..9000.0f64,
        degree in 2..=LARGEST,
        order in 0..=LARGEST,
    ) {
        let field = Gravity::egm2008(degree, order.min(degree));
        let r = direction.map(|part| part * radius / length(direction));
        let slope = [0, 1, 2].map(|axis| {
            let beside = |step: f64| {
                let mut place = r;
                place[axis] += step;
                field.potential(place)
            };
            // Fourth order over 2 km: both its own error and the rounding of 60 km²/s² stay below 1e-13
            // km/s².
            (8.0 * (beside(2.0) - beside(-2.0)) - (beside(4.0) - beside(-4.0))) / 24.0
        });
        let apart = length(minus(slope, field.acceleration(r)));
        prop_assert!(apart < 2e-13, "{apart}");
    }
}
