//! Density of the upper air after Harris and Priester.
//!
//! In: position and the Sun's direction in axes of the true equator. Out: density, kg/m³. Tables of the least
//! and the greatest density of a day at mean solar activity, heights in between exponentially; the greatest
//! follows the Sun by 30 deg and falls off with the sixth power of `cos (psi / 2)`, psi being the angle from
//! there, as published (Montenbruck and Gill, Satellite Orbits, 3.5.2, table 3.8). Nothing above 1000 km.
//! Solar and magnetic activity, which change the density several-fold, are left out.
//!
//! Height is counted along the radius, 3 m from the geodetic one at 500 km (5e-5 of the density).

use crate::world::attitude::{Vector, apply, dot, rotation};
use crate::world::earth::{EQUATOR_KM, POLE_KM};
use crate::world::vector::length;

/// By how much the bulge follows the Sun, rad.
const LAG_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Exponent of `cos² (psi / 2)`: half of the published n, which is 2 for low and 6 for polar orbits.
const SHARPNESS: f64 = 3.0;

/// Height (km), least and greatest density (g/km³).
const TABLE: [[f64; 3]; 50] = [
    [100.0, 4.974e5, 4.974e5],
    [120.0, 2.490e4, 2.490e4],
    [130.0, 8.377e3, 8.710e3],
    [140.0, 3.899e3, 4.059e3],
    [150.0, 2.122e3, 2.215e3],
    [160.0, 1.263e3, 1.344e3],
    [170.0, 8.008e2, 8.758e2],
    [180.0, 5.283e2, 6.010e2],
    [190.0, 3.617e2, 4.297e2],
    [200.0, 2.557e2, 3.162e2],
    [210.0, 1.839e2, 2.396e2],
    [220.0, 1.341e2, 1.853e2],
    [230.0, 9.949e1, 1.455e2],
    [240.0, 7.488e1, 1.157e2],
    [250.0, 5.709e1, 9.308e1],
    [260.0, 4.403e1, 7.555e1],
    [270.0, 3.430e1, 6.182e1],
    [280.0, 2.697e1, 5.095e1],
    [290.0, 2.139e1, 4.226e1],
    [300.0, 1.708e1, 3.526e1],
    [320.0, 1.099e1, 2.511e1],
    [340.0, 7.214, 1.819e1],
    [360.0, 4.824, 1.337e1],
    [380.0, 3.274, 9.955],
    [400.0, 2.249, 7.492],
    [420.0, 1.558, 5.684],
    [440.0, 1.091, 4.355],
    [460.0, 7.701e-1, 3.362],
    [480.0, 5.474e-1, 2.612],
    [500.0, 3.916e-1, 2.042],
    [520.0, 2.819e-1, 1.605],
    [540.0, 2.042e-1, 1.267],
    [560.0, 1.488e-1, 1.005],
    [580.0, 1.092e-1, 7.997e-1],
    [600.0, 8.070e-2, 6.390e-1],
    [620.0, 6.012e-2, 5.123e-1],
    [640.0, 4.519e-2, 4.121e-1],
    [660.0, 3.430e-2, 3.325e-1],
    [680.0, 2.632e-2, 2.691e-1],
    [700.0, 2.043e-2, 2.185e-1],
    [720.0, 1.607e-2, 1.779e-1],
    [740.0, 1.281e-2, 1.452e-1],
    [760.0, 1.036e-2, 1.190e-1],
    [780.0, 8.496e-3, 9.776e-2],
    [800.0, 7.069e-3, 8.059e-2],
    [840.0, 4.680e-3, 5.741e-2],
    [880.0, 3.200e-3, 4.210e-2],
    [920.0, 2.210e-3, 3.130e-2],
    [960.0, 1.560e-3, 2.360e-2],
    [1000.0, 1.150e-3, 1.810e-2],
];

/// Height above the ellipsoid along the radius, km; `r` in axes of the equator.
pub fn height_km(r: Vector) -> f64 {
    let distance = length(r);
    let sine = r[2] / distance;
    // The ellipse in polar coordinates.
    let square = (POLE_KM / EQUATOR_KM) * (POLE_KM / EQUATOR_KM);
    distance - POLE_KM / (square + (1.0 - square) * sine * sine).sqrt()
}

/// Least and greatest density at a height, kg/m³; `None` outside 100 to 1000 km.
fn extremes(height_km: f64) -> Option<(f64, f64)> {
    let above = TABLE.partition_point(|row| row[0] <= height_km);
    let ([low, least, most], [high, least_up, most_up]) =
        (*TABLE.get(above.checked_sub(1)?)?, *TABLE.get(above)?);
    let share = (height_km - low) / (high - low);
    let between = |a: f64, b: f64| 1e-12 * a * libm::pow(b / a, share);
    Some((between(least, least_up), between(most, most_up)))
}

/// Density at `r` (km) with the Sun towards `sun`, both in axes of the true equator, kg/m³.
pub fn density_kg_m3(r: Vector, sun: Vector) -> f64 {
    let Some((least, most)) = extremes(height_km(r)) else { return 0.0 };
    let apex = apply(&rotation(2, -LAG_RAD), sun);
    let cosine = dot(apex, r) / (length(apex) * length(r));
    // cos² of half the angle.
    let half_square = (0.5 + 0.5 * cosine).max(0.0);
    least + (most - least) * libm::pow(half_square, SHARPNESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_are_those_of_the_table_at_apex_and_opposite() {
        // The bulge stands 30 deg east of the Sun.
        let sun = [1.0, 0.0, 0.0];
        for [height, least, most] in TABLE.iter().take(49) {
            let at = |degrees: f64| {
                let (s, c) = libm::sincos(degrees.to_radians());
                1e12 * density_kg_m3(
                    [(EQUATOR_KM + height + 1e-9) * c, (EQUATOR_KM + height + 1e-9) * s, 0.0],
                    sun,
                )
            };
            assert!((at(30.0) / most - 1.0).abs() < 1e-6, "{height}");
            assert!((at(210.0) / least - 1.0).abs() < 1e-6, "{height}");
            // A quarter turn from the apex: cos² 45 deg, to the third power an eighth.
            assert!((at(120.0) / (least + (most - least) / 8.0) - 1.0).abs() < 1e-6);
        }
        assert_eq!(density_kg_m3([EQUATOR_KM + 1000.1, 0.0, 0.0], sun), 0.0);
    }

    #[test]
    fn densities_are_those_another_program_gives() {
        // Over the south pole, the Sun 23.1 deg south, heights from 110 to 810 km: the values in the tests of
        // brahe 1.8.
        let sun = [24_622_331.959_58, -133_060_326.832_922, -57_688_711.921_833];
        for (z, density) in [
            (6_466.752_314, 1.112_89e-7),
            (6_566.752_314, 2.026_86e-10),
            (6_666.752_314, 1.911_55e-11),
            (6_766.752_314, 3.441_49e-12),
            (6_866.752_314, 8.307_8e-13),
            (6_966.752_314, 2.391_34e-13),
            (7_066.752_314, 7.850_43e-14),
            (7_166.752_314, 2.919_71e-14),
        ] {
            let found = density_kg_m3([0.0, 0.0, -z], sun);
            assert!((found / density - 1.0).abs() < 1e-4, "{z}: {found}");
        }
    }

    #[test]
    fn height_is_that_above_the_ellipsoid() {
        assert!(height_km([EQUATOR_KM, 0.0, 0.0]).abs() < 1e-9);
        assert!((height_km([0.0, 0.0, -6_356.752_314_2])).abs() < 1e-6);
        // Geodetic 45 deg, 500 km: N = 6388.838290 km, z = (N (1 - e²) + h) sin 45 deg.
        let (n, e2) = (6_388.838_290, 0.006_694_379_990_14);
        let root = 0.5f64.sqrt();
        let r = [(n + 500.0) * root, 0.0, (n * (1.0 - e2) + 500.0) * root];
        assert!((height_km(r) - 500.0).abs() < 0.003);
    }
}
