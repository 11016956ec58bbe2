//! The Earth's magnetic field: IGRF-14, and the ring current.
//!
//! In: place (km, ICRS axes about the Earth's centre), instant, strength of the ring current. Out: flux
//! density, microtesla, in the same axes. `B = -∇V`, `V = a Σ (a / r)^(n+1) Σ (g cos mλ + h sin mλ)
//! P(cos θ)` to degree 13 with Schmidt's half normalisation, along up, south and east. Coefficients of 2025.0
//! and 2030.0 (IAGA, IGRF-14, doi 10.5281/zenodo.14012302), carried on as a straight line to other years. Of
//! the currents outside the Earth the ring current is there, as a field that is the same everywhere along the
//! dipole's axis.

use crate::world::attitude::{Vector, apply, rotation};
use crate::world::time::ephemeris::{icrs_to_equator, julian_year, sidereal_angle};
use crate::world::vector::{length, plus, product, times, transposed};

/// Reference radius of the model, km.
const RADIUS_KM: f64 = 6_371.2;
/// Epoch of the coefficients, Julian year, and years to the second one.
const EPOCH: f64 = 2025.0;
const YEARS: f64 = 5.0;
/// Degree of the model.
const DEGREE: usize = 13;
/// Of each degree the orders: g of 2025.0 and 2030.0, h of 2025.0 and 2030.0, nT.
const COEFFICIENTS: [[f64; 4]; 104] = [
    [-29350.0, -29287.0, 0.0, 0.0],
    [-1410.3, -1360.3, 4545.5, 4438.0],
    [-2556.2, -2612.2, 0.0, 0.0],
    [2950.9, 2924.4, -3133.6, -3270.1],
    [1648.7, 1607.2, -814.2, -869.7],
    [1360.9, 1353.4, 0.0, 0.0],
    [-2404.2, -2426.2, -56.9, -37.9],
    [1243.8, 1245.8, 237.6, 236.6],
    [453.4, 375.4, -549.6, -569.1],
    [894.7, 886.2, 0.0, 0.0],
    [799.6, 788.1, 278.6, 272.1],
    [55.8, 26.8, -134.0, -113.5],
    [-281.1, -254.1, 212.0, 220.0],
    [12.0, -22.0, -375.4, -395.9],
    [-232.9, -229.9, 0.0, 0.0],
    [369.0, 375.5, 45.3, 42.8],
    [187.2, 187.2, 220.0, 230.5],
    [-138.7, -135.2, -122.9, -120.4],
    [-141.9, -130.4, 42.9, 51.4],
    [20.9, 25.9, 106.2, 115.7],
    [64.3, 63.3, 0.0, 0.0],
    [63.8, 62.3, -18.4, -16.9],
    [76.7, 80.7, 16.8, 8.8],
    [-115.7, -109.7, 48.9, 46.9],
    [-40.9, -44.9, -59.8, -55.8],
    [14.9, 16.9, 10.9, 14.4],
    [-60.8, -56.3, 72.8, 77.3],
    [79.6, 79.1, 0.0, 0.0],
    [-76.9, -77.4, -48.9, -45.9],
    [-8.8, -9.3, -14.4, -11.9],
    [59.3, 61.8, -1.0, -4.5],
    [15.8, 15.3, 23.5, 23.5],
    [2.5, -1.5, -7.4, -11.9],
    [-11.2, -15.2, -25.1, -22.6],
    [14.3, 18.8, -2.2, -3.7],
    [23.1, 22.6, 0.0, 0.0],
    [10.9, 11.9, 7.2, 5.7],
    [-17.5, -17.5, -12.6, -10.6],
    [2.0, 4.0, 11.5, 10.0],
    [-21.8, -22.3, -9.7, -7.7],
    [16.9, 18.4, 12.7, 10.2],
    [14.9, 15.4, 0.7, -2.3],
    [-16.8, -16.8, -5.2, -3.7],
    [1.0, 2.5, 3.9, 4.9],
    [4.7, 4.7, 0.0, 0.0],
    [8.0, 8.0, -24.8, -24.8],
    [3.0, 3.0, 12.1, 12.1],
    [-0.2, -0.2, 8.3, 8.3],
    [-2.5, -2.5, -3.4, -3.4],
    [-13.1, -13.1, -5.3, -5.3],
    [2.4, 2.4, 7.2, 7.2],
    [8.6, 8.6, -0.6, -0.6],
    [-8.7, -8.7, 0.8, 0.8],
    [-12.8, -12.8, 9.8, 9.8],
    [-1.3, -1.3, 0.0, 0.0],
    [-6.4, -6.4, 3.3, 3.3],
    [0.2, 0.2, 0.1, 0.1],
    [2.0, 2.0, 2.5, 2.5],
    [-1.0, -1.0, 5.4, 5.4],
    [-0.5, -0.5, -9.0, -9.0],
    [-0.9, -0.9, 0.4, 0.4],
    [1.5, 1.5, -4.2, -4.2],
    [0.9, 0.9, -3.8, -3.8],
    [-2.6, -2.6, 0.9, 0.9],
    [-3.9, -3.9, -9.0, -9.0],
    [3.0, 3.0, 0.0, 0.0],
    [-1.4, -1.4, 0.0, 0.0],
    [-2.5, -2.5, 2.8, 2.8],
    [2.4, 2.4, -0.6, -0.6],
    [-0.6, -0.6, 0.1, 0.1],
    [0.0, 0.0, 0.5, 0.5],
    [-0.6, -0.6, -0.3, -0.3],
    [-0.1, -0.1, -1.2, -1.2],
    [1.1, 1.1, -1.7, -1.7],
    [-1.0, -1.0, -2.9, -2.9],
    [-0.1, -0.1, -1.8, -1.8],
    [2.6, 2.6, -2.3, -2.3],
    [-2.0, -2.0, 0.0, 0.0],
    [-0.1, -0.1, -1.2, -1.2],
    [0.4, 0.4, 0.6, 0.6],
    [1.2, 1.2, 1.0, 1.0],
    [-1.2, -1.2, -1.5, -1.5],
    [0.6, 0.6, 0.0, 0.0],
    [0.5, 0.5, 0.6, 0.6],
    [0.5, 0.5, -0.2, -0.2],
    [-0.1, -0.1, 0.8, 0.8],
    [-0.5, -0.5, 0.1, 0.1],
    [-0.2, -0.2, -0.9, -0.9],
    [-1.2, -1.2, 0.1, 0.1],
    [-0.7, -0.7, 0.2, 0.2],
    [0.2, 0.2, 0.0, 0.0],
    [-0.9, -0.9, -0.9, -0.9],
    [0.6, 0.6, 0.7, 0.7],
    [0.7, 0.7, 1.2, 1.2],
    [-0.2, -0.2, -0.3, -0.3],
    [0.5, 0.5, -1.3, -1.3],
    [0.1, 0.1, -0.1, -0.1],
    [0.7, 0.7, 0.2, 0.2],
    [0.0, 0.0, -0.2, -0.2],
    [0.3, 0.3, 0.5, 0.5],
    [0.2, 0.2, 0.6, 0.6],
    [0.4, 0.4, -0.6, -0.6],
    [-0.5, -0.5, -0.3, -0.3],
    [-0.4, -0.4, -0.5, -0.5],
];

/// g and h of a row of [`COEFFICIENTS`] in a year.
fn of_year([g, g_later, h, h_later]: [f64; 4], year: f64) -> [f64; 2] {
    let years = (year - EPOCH) / YEARS;
    [g + (g_later - g) * years, h + (h_later - h) * years]
}

/// Schmidt's functions of an order, and their derivatives by the colatitude, degrees from the order on; the
/// first is given.
fn functions(order: usize, first: [f64; 2], (sine, cosine): (f64, f64)) -> [[f64; 2]; DEGREE + 1] {
    let mut all = [[0.0; 2]; DEGREE + 1];
    all[order] = first;
    for n in order + 1..=DEGREE {
        let square = |n: usize| (n * n - order * order) as f64;
        let ([p, slope], before) = (all[n - 1], if n > order + 1 { all[n - 2] } else { [0.0; 2] });
        let (odd, root, root_before) = ((2 * n - 1) as f64, square(n).sqrt(), square(n - 1).sqrt());
        all[n] = [
            (odd * cosine * p - root_before * before[0]) / root,
            (odd * (cosine * slope - sine * p) - root_before * before[1]) / root,
        ];
    }
    all
}

/// Flux density in Earth-fixed axes, nT, at a place in them, km.
fn fixed_nt(place_km: Vector, year: f64) -> Vector {
    let (radius, [x, y, z]) = (length(place_km), place_km);
    let axis_km = libm::hypot(x, y);
    // On the axis any meridian will do.
    let (sine, cosine) = ((axis_km / radius).max(1e-12), z / radius);
    let (longitude_sine, longitude_cosine) =
        if axis_km > 0.0 { (y / axis_km, x / axis_km) } else { (0.0, 1.0) };
    let (mut multiple_cosine, mut multiple_sine) = (1.0, 0.0);
    let (mut sectorial, [mut up, mut south, mut east]) = ([1.0, 0.0], [0.0; 3]);
    for m in 0..=DEGREE {
        let all = functions(m, sectorial, (sine, cosine));
        for (n, [p, slope]) in all.into_iter().enumerate().skip(m.max(1)) {
            // The degrees before have 2 + 3 + ... + n coefficients.
            let [g, h] = of_year(COEFFICIENTS[(n - 1) * (n + 2) / 2 + m], year);
            let shrink = (RADIUS_KM / radius).powi(n as i32 + 2);
            let along = g * multiple_cosine + h * multiple_sine;
            let across = g * multiple_sine - h * multiple_cosine;
            up += (n + 1) as f64 * shrink * along * p;
            south -= shrink * along * slope;
            east += m as f64 * shrink * across * p / sine;
        }
        (multiple_cosine, multiple_sine) = (
            multiple_cosine * longitude_cosine - multiple_sine * longitude_sine,
            multiple_sine * longitude_cosine + multiple_cosine * longitude_sine,
        );
        let (next, [p, slope]) = ((m + 1) as f64, sectorial);
        let factor = if m == 0 { 1.0 } else { ((2.0 * next - 1.0) / (2.0 * next)).sqrt() };
        sectorial = [factor * sine * p, factor * (cosine * p + sine * slope)];
    }
    // South and east along the axes.
    let level = cosine * south + sine * up;
    [
        level * longitude_cosine - east * longitude_sine,
        level * longitude_sine + east * longitude_cosine,
        cosine * up - sine * south,
    ]
}

/// Unit vector to the magnetic north, Earth-fixed axes.
fn magnetic_north(year: f64) -> Vector {
    let [[g10, _], [g11, h11]] = [COEFFICIENTS[0], COEFFICIENTS[1]].map(|row| of_year(row, year));
    let dipole = [-g11, -h11, -g10];
    times(length(dipole).recip(), dipole)
}

/// Flux density, uT, at `position_km` about the Earth's centre, both in ICRS axes; `instant_us` is TT since
/// J2000.0. The ring current weakens the field at the equator by `ring_current_ut`.
pub fn field_ut(position_km: Vector, instant_us: i64, ring_current_ut: f64) -> Vector {
    let to_fixed = product(&rotation(2, sidereal_angle(instant_us)), &icrs_to_equator(instant_us));
    let year = julian_year(instant_us);
    let inside = times(1e-3, fixed_nt(apply(&to_fixed, position_km), year));
    apply(&transposed(&to_fixed), plus(inside, -ring_current_ut, magnetic_north(year)))
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
    fn the_field_is_that_of_the_published_model() {
        // 2027.0; up, south, east in nT by ppigrf 2.1.0 with its file of IGRF-14.
        let published = [
            (6371.2, 40.0, 15.0, [-45_418.3, -19_615.5, 1_847.5]),
            (6371.2, 90.0, 0.0, [16_069.6, -27_505.9, -1_810.0]),
            (6371.2, 90.0, 250.0, [-6_814.7, -29_017.6, 3_889.5]),
            (6371.2, 1e-6, 0.0, [-56_553.4, -1_679.9, 551.4]),
            (6371.2, 180.0 - 1e-6, 0.0, [51_221.1, -14_151.8, -8_803.3]),
            (6828.0, 116.0, 302.0, [10_304.9, -15_143.4, -3_495.6]),
            (42_164.0, 95.0, 100.0, [51.2, -102.7, -3.3]),
        ];
        for (radius_km, colatitude_deg, longitude_deg, expected) in published {
            let axes = axes(colatitude_deg, longitude_deg);
            let field = apply(&axes, fixed_nt(times(radius_km, axes[0]), 2027.0));
            for (a, b) in field.iter().zip(expected) {
                assert!((a - b).abs() < 0.2, "{field:?} {expected:?}");
            }
        }
        let [on_the_axis, beside] = [0.0, 1e-6].map(|off| fixed_nt([off, 0.0, 6371.2], 2027.0));
        assert!(length(plus(on_the_axis, -1.0, beside)) < 1e-3);
    }

    #[test]
    fn the_ring_current_weakens_the_field_at_the_equator() {
        let (place, noon) = ([7_000.0, 0.0, 0.0], 843_393_969_184_000);
        let [quiet, storm] = [0.0, 0.1].map(|current| length(field_ut(place, noon, current)));
        assert!((quiet - storm - 0.1).abs() < 0.02, "{quiet} {storm}");
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
        let at = |s: f64| field_ut(place, noon + (s * 1e6) as i64, 0.02);
        let (now, later, other) = (at(0.0), at(86_164.1), at(43_082.0));
        assert!(length(plus(now, -1.0, later)) < 1e-4 && length(plus(now, -1.0, other)) > 5e-3);
    }
}
