//! Pressure of the Sun's light, and the central body's shadow.
//!
//! In: positions of satellite and Sun from its centre, km, and its radius. Out: the share of the Sun's disc
//! that is seen, acceleration of a ball, km/s². Shadow: umbra, penumbra and, beyond the umbra's tip, the
//! ring, from the overlap of two discs (Montenbruck and Gill, Satellite Orbits, 3.4.2); it is a ball of its
//! equatorial radius without air, so that eclipses over the Earth's poles begin and end up to 3 s off (21 km
//! of radius at 7.5 km/s). Pressure: 4.56e-6 N/m² at 1 au, along the Sun's light.

use crate::world::attitude::Vector;
use crate::world::time::ephemeris::AU_KM;
use crate::world::vector::{angle, length, minus, times};

/// Radius of the Sun (IAU 2015), km.
const SUN_KM: f64 = 695_700.0;
/// Pressure at 1 au, N/m².
const PRESSURE_N_M2: f64 = 4.56e-6;

/// Share of the Sun's disc that is seen from `r`, 0 to 1.
pub fn sunlight(r: Vector, sun: Vector, radius_km: f64) -> f64 {
    let towards = minus(sun, r);
    let disc = libm::asin((SUN_KM / length(towards)).min(1.0));
    let earth = libm::asin((radius_km / length(r)).min(1.0));
    let apart = angle(times(-1.0, r), towards);
    if apart >= disc + earth {
        return 1.0;
    }
    if apart <= earth - disc {
        return 0.0;
    }
    let whole = std::f64::consts::PI * disc * disc;
    if apart <= disc - earth {
        return 1.0 - earth * earth / (disc * disc);
    }
    // Two circles overlap in two segments.
    let x = (apart * apart + disc * disc - earth * earth) / (2.0 * apart);
    let y = (disc * disc - x * x).max(0.0).sqrt();
    let sector =
        |radius: f64, to_chord: f64| radius * radius * libm::acos((to_chord / radius).clamp(-1.0, 1.0));
    let hidden = sector(disc, x) + sector(earth, apart - x) - apart * y;
    (1.0 - hidden / whole).clamp(0.0, 1.0)
}

/// Acceleration, km/s², behind a ball of `radius_km`, with `area_per_mass` (m²/kg) times the coefficient of
/// reflection.
pub fn acceleration(r: Vector, sun: Vector, (radius_km, area_per_mass): (f64, f64)) -> Vector {
    let away = minus(r, sun);
    let distance = length(away);
    let ratio = AU_KM / distance;
    times(1e-3 * sunlight(r, sun, radius_km) * PRESSURE_N_M2 * area_per_mass * ratio * ratio / distance, away)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::earth::EQUATOR_KM as EARTH_KM;

    const SUN: Vector = [AU_KM, 0.0, 0.0];

    #[test]
    fn light_umbra_and_penumbra_lie_where_similar_triangles_put_them() {
        // Behind the Earth at x = -d: the cones' radii are R (1 - d / l) and R (1 + d / m), their tips at l =
        // R AU / (S - R) = 1,384,000 km behind the Earth and m = R AU / (S + R) before it; the cones touch
        // the globe, so that measured across the axis each is wider by 1 / cos of its half angle (1e-5).
        let d = 42_164.0;
        let umbra = EARTH_KM - d * (SUN_KM - EARTH_KM) / AU_KM;
        let penumbra = EARTH_KM + d * (SUN_KM + EARTH_KM) / AU_KM;
        let at = |y: f64| sunlight([-d, y, 0.0], SUN, EARTH_KM);
        assert_eq!((at(0.0), at(umbra - 1.0), at(penumbra + 1.0)), (0.0, 0.0, 1.0));
        assert!(at(umbra + 1.0) > 0.0 && at(penumbra - 1.0) < 1.0);
        // Half way the limb, nearly straight, halves the disc; its curve (0.27 deg on 8.7) hides a little
        // less.
        let half = at(0.5 * (umbra + penumbra));
        assert!((half - 0.5).abs() < 0.01, "{half}");
        // Monotone between.
        let shares: Vec<f64> =
            (0..=100).map(|k| at(umbra + (penumbra - umbra) * f64::from(k) / 100.0)).collect();
        assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]));
        // On the day side nothing is hidden; beyond the umbra's tip a ring remains.
        assert_eq!(sunlight([7000.0, 0.0, 0.0], SUN, EARTH_KM), 1.0);
        let ring = sunlight([-2e6, 0.0, 0.0], SUN, EARTH_KM);
        let expected = 1.0 - libm::pow(libm::asin(EARTH_KM / 2e6) / libm::asin(SUN_KM / (AU_KM + 2e6)), 2.0);
        assert!((ring - expected).abs() < 1e-12 && ring > 0.5);
    }

    #[test]
    fn pressure_pushes_away_from_the_sun() {
        // 4.56e-6 N/m² on 1.3 m² and 100 kg: 5.93e-8 m/s², a little more 7000 km nearer to the Sun.
        let [x, y, z] = acceleration([7000.0, 0.0, 0.0], SUN, (EARTH_KM, 0.013));
        assert!((-1e3 * x / 5.928e-8 - 1.0).abs() < 2e-4 && y == 0.0 && z == 0.0, "{x}");
        assert_eq!(acceleration([-7000.0, 0.0, 0.0], SUN, (EARTH_KM, 0.013)), [0.0; 3]);
    }
}
