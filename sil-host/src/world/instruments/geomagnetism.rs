//! The Earth's magnetic field: IGRF-14 to degree 3.
//!
//! In: place (km, ICRS axes about the Earth's centre), instant. Out: flux density, microtesla, in the same
//! axes. `B = -∇V`, `V = a Σ (a / r)^(n+1) Σ (g cos mλ + h sin mλ) P(sin φ)` with Schmidt's half
//! normalisation, written with solid harmonics `H(u)`, polynomials of the unit vector `u` in Earth-fixed
//! axes: `B = -(a / r)^(n+2) (∇H - (2n + 1) H u)`, `H = u · ∇H / n`, so that the poles are no exception.
//! Coefficients of 2025.0 and their yearly change to 2030 (IAGA, IGRF-14, doi 10.5281/zenodo.14012302),
//! carried on as a straight line to other years.
//!
//! Against the whole model of degree 13, epoch 2027: 2.2 uT rms, 5 uT at most at 450 km; 3.4 and 7.7 at the
//! ground; below 0.0001 in GEO. Fields of currents outside the Earth are left out.

use crate::world::attitude::{Vector, apply, dot, rotation};
use crate::world::time::ephemeris::{icrs_to_equator, julian_year, sidereal_angle};
use crate::world::vector::{length, plus, product, times, transposed};

/// Reference radius of the model, km.
const RADIUS_KM: f64 = 6_371.2;
/// Epoch of the coefficients, Julian year.
const EPOCH: f64 = 2025.0;
/// Degree, coefficient at the epoch (nT), and at 2030.0; in the order of [`gradients`]: g of order 0, then g
/// and h.
const COEFFICIENTS: [(i32, f64, f64); 15] = [
    (1, -29_350.0, -29_287.0),
    (1, -1_410.3, -1_360.3),
    (1, 4_545.5, 4_438.0),
    (2, -2_556.2, -2_612.2),
    (2, 2_950.9, 2_924.4),
    (2, -3_133.6, -3_270.1),
    (2, 1_648.7, 1_607.2),
    (2, -814.2, -869.7),
    (3, 1_360.9, 1_353.4),
    (3, -2_404.2, -2_426.2),
    (3, -56.9, -37.9),
    (3, 1_243.8, 1_245.8),
    (3, 237.6, 236.6),
    (3, 453.4, 375.4),
    (3, -549.6, -569.1),
];

/// Gradients of the solid harmonics at the unit vector `[x, y, z]`.
fn gradients([x, y, z]: Vector) -> [Vector; 15] {
    let (s3, s6, s10, s15) = (3f64.sqrt(), 6f64.sqrt() / 4.0, 10f64.sqrt() / 4.0, 15f64.sqrt());
    [
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-x, -y, 2.0 * z],
        times(s3, [z, 0.0, x]),
        times(s3, [0.0, z, y]),
        times(s3, [x, -y, 0.0]),
        times(s3, [y, x, 0.0]),
        [-3.0 * x * z, -3.0 * y * z, 3.0 * z * z - 1.5 * (x * x + y * y)],
        times(s6, [4.0 * z * z - 3.0 * x * x - y * y, -2.0 * x * y, 8.0 * x * z]),
        times(s6, [-2.0 * x * y, 4.0 * z * z - x * x - 3.0 * y * y, 8.0 * y * z]),
        times(0.5 * s15, [2.0 * x * z, -2.0 * y * z, x * x - y * y]),
        times(s15, [y * z, x * z, x * y]),
        times(s10, [3.0 * (x * x - y * y), -6.0 * x * y, 0.0]),
        times(s10, [6.0 * x * y, 3.0 * (x * x - y * y), 0.0]),
    ]
}

/// Flux density in Earth-fixed axes, nT, at a place in them, km.
fn fixed_nt(place_km: Vector, year: f64) -> Vector {
    let radius = length(place_km);
    let (up, shrink) = (times(radius.recip(), place_km), RADIUS_KM / radius);
    let mut field = [0.0; 3];
    for ((degree, then, later), gradient) in COEFFICIENTS.iter().zip(gradients(up)) {
        let n = f64::from(*degree);
        let coefficient = then + (later - then) / 5.0 * (year - EPOCH);
        let scale = -coefficient * (0..degree + 2).fold(1.0, |power, _| power * shrink);
        let harmonic = dot(up, gradient) / n;
        field = plus(field, scale, plus(gradient, -(2.0 * n + 1.0) * harmonic, up));
    }
    field
}

/// Flux density, uT, at `position_km` about the Earth's centre, both in ICRS axes; `instant_us` is TT since
/// J2000.0.
pub fn field_ut(position_km: Vector, instant_us: i64) -> Vector {
    let to_fixed = product(&rotation(2, sidereal_angle(instant_us)), &icrs_to_equator(instant_us));
    let field = fixed_nt(apply(&to_fixed, position_km), julian_year(instant_us));
    times(1e-3, apply(&transposed(&to_fixed), field))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit vectors up, south and east of a colatitude and longitude, degrees.
    fn axes(colatitude_deg: f64, longitude_deg: f64) -> [Vector; 3] {
        let (s, c) = libm::sincos(colatitude_deg.to_radians());
        let (sl, cl) = libm::sincos(longitude_deg.to_radians());
        [[s * cl, s * sl, c], [c * cl, c * sl, -s], [-sl, cl, 0.0]]
    }

    #[test]
    fn the_field_is_that_of_the_published_model_cut_at_degree_3() {
        // Epoch 2027.0; up, south, east in nT by ppigrf 2.1.0 with its file of IGRF-14, degrees 1 to 3.
        let published = [
            (6371.2, 40.0, 15.0, [-46_294.8, -24_922.1, 2_892.3]),
            (6371.2, 90.0, 0.0, [12_573.4, -23_858.8, -1_762.1]),
            (6371.2, 90.0, 250.0, [-10_148.2, -29_465.5, 3_821.1]),
            (6828.0, 116.0, 302.0, [11_598.0, -16_015.5, -2_432.6]),
            (42_164.0, 95.0, 100.0, [51.2, -102.7, -3.3]),
        ];
        for (radius_km, colatitude_deg, longitude_deg, expected) in published {
            let axes = axes(colatitude_deg, longitude_deg);
            let field = apply(&axes, fixed_nt(times(radius_km, axes[0]), 2027.0));
            for (a, b) in field.iter().zip(expected) {
                assert!((a - b).abs() < 0.1, "{field:?} {expected:?}");
            }
        }
    }

    #[test]
    fn equator_and_poles_have_the_field_that_the_whole_model_has_within_its_neglected_part() {
        // Degree 13, epoch 2027.0, at the reference radius: strength in nT.
        for (colatitude_deg, longitude_deg, expected) in
            [(90.0, 0.0, 31_907.0), (90.0, 250.0, 30_061.0), (0.0, 0.0, 56_581.0), (180.0, 0.0, 53_863.0)]
        {
            let up = axes(colatitude_deg, longitude_deg)[0];
            let strength = length(fixed_nt(times(RADIUS_KM, up), 2027.0));
            assert!((strength - expected).abs() < 7_700.0, "{strength} {expected}");
        }
        // Down at the north pole, up at the south pole, north at the equator.
        assert!(fixed_nt([0.0, 0.0, 6378.0], 2027.0)[2] < -4e4);
        assert!(fixed_nt([0.0, 0.0, -6378.0], 2027.0)[2] < -4e4);
        assert!(fixed_nt([6378.0, 0.0, 0.0], 2027.0)[2] > 2e4);
    }

    #[test]
    fn the_field_has_neither_sources_nor_curl_in_space() {
        let place = [3100.0, -5200.0, 2900.0];
        let slope = |axis: usize| {
            let at = |step_km: f64| {
                let mut place = place;
                place[axis] += step_km;
                fixed_nt(place, 2027.0)
            };
            times(0.5, plus(at(1.0), -1.0, at(-1.0)))
        };
        let [by_x, by_y, by_z] = [slope(0), slope(1), slope(2)];
        // The slopes themselves are some 10 nT/km.
        assert!((by_x[0] + by_y[1] + by_z[2]).abs() < 1e-4);
        for curl in [by_y[2] - by_z[1], by_z[0] - by_x[2], by_x[1] - by_y[0]] {
            assert!(curl.abs() < 1e-4, "{curl}");
        }
    }

    #[test]
    fn the_field_turns_with_the_earth() {
        // A sidereal day apart the same place in space has the same field, half a day apart another.
        let (place, noon) = ([42_164.0, 0.0, 0.0], 843_393_969_184_000);
        let at = |s: f64| field_ut(place, noon + (s * 1e6) as i64);
        let (now, later, other) = (at(0.0), at(86_164.1), at(43_082.0));
        assert!(length(plus(now, -1.0, later)) < 1e-4 && length(plus(now, -1.0, other)) > 5e-3);
    }
}
