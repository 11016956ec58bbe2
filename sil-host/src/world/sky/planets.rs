//! The planets that a star sensor sees: stars that are in no catalogue.
//!
//! In: TT, µs since J2000.0. Out: geocentric directions (ICRS) and visual magnitudes of Mercury to Saturn.
//! Mean Keplerian elements and their rates about the J2000 ecliptic, 1800 to 2050 (Standish, "Approximate
//! Positions of the Planets", JPL). Magnitudes from distance and phase angle (Meeus, Astronomical Algorithms,
//! ch. 41); Saturn's rings, which may add a magnitude, are left out, as are light time (30 arcsec) and the
//! satellite's parallax.
//!
//! Error against SOFA's series at three dates from 2010 to 2040: below 0.15 deg, Saturn the worst; nothing on
//! board knows planets better.

use crate::world::attitude::{Vector, apply, rotation};
use crate::world::time::ephemeris::{AU_KM, sun_km};
use crate::world::vector::{length, plus, times, transposed, unit};
use fsw_core::orbit::body::{CentralBody, SolarOrbit};

/// Obliquity of the J2000 ecliptic, rad.
const OBLIQUITY_RAD: f64 = 0.409_092_804_222_329;
/// A Julian century, µs.
pub const CENTURY_US: f64 = 36_525.0 * 86_400e6;
/// Rounds of Newton's method for Kepler's equation; five reach 1e-12 for all eccentricities here.
const KEPLER_ROUNDS: u32 = 8;

/// Elements at J2000.0 and their changes a century: semi-major axis (au), eccentricity, inclination, mean
/// longitude, longitude of perihelion, longitude of the node (deg); magnitude at 1 au from Sun and Earth with
/// its terms in the phase angle (deg), B-V.
struct Elements {
    at_epoch: [f64; 6],
    a_century: [f64; 6],
    magnitude: [f64; 4],
    b_v: f64,
}

const PLANETS: [Elements; 5] = [
    Elements {
        at_epoch: [0.387_099_27, 0.205_635_93, 7.004_979_02, 252.250_323_50, 77.457_796_28, 48.330_765_93],
        a_century: [3.7e-7, 1.906e-5, -0.005_947_49, 149_472.674_111_75, 0.160_476_89, -0.125_340_81],
        magnitude: [-0.42, 0.038, -2.73e-4, 2e-6],
        b_v: 0.93,
    },
    Elements {
        at_epoch: [0.723_335_66, 0.006_776_72, 3.394_676_05, 181.979_099_50, 131.602_467_18, 76.679_842_55],
        a_century: [3.9e-6, -4.107e-5, -0.000_788_90, 58_517.815_387_29, 0.002_683_29, -0.277_694_18],
        magnitude: [-4.40, 0.0009, 2.39e-4, -6.5e-7],
        b_v: 0.82,
    },
    Elements {
        at_epoch: MARS_ORBIT.at_epoch,
        a_century: MARS_ORBIT.a_century,
        magnitude: [-1.52, 0.016, 0.0, 0.0],
        b_v: 1.36,
    },
    Elements {
        at_epoch: [5.202_887_00, 0.048_386_24, 1.304_396_95, 34.396_440_51, 14.728_479_83, 100.473_909_09],
        a_century: [-1.1607e-4, -1.3253e-4, -0.001_837_14, 3_034.746_127_75, 0.212_526_68, 0.204_691_06],
        magnitude: [-9.40, 0.005, 0.0, 0.0],
        b_v: 0.83,
    },
    Elements {
        at_epoch: [9.536_675_94, 0.053_861_79, 2.485_991_87, 49.954_244_23, 92.598_878_31, 113.662_424_48],
        a_century: [-1.2506e-3, -5.0991e-4, 0.001_936_09, 1_222.493_622_01, -0.418_972_16, -0.288_677_94],
        magnitude: [-8.88, 0.0, 0.0, 0.0],
        b_v: 1.04,
    },
];

/// Mars's ellipse, of the row that the flight code reads as well.
const MARS_ORBIT: &SolarOrbit = match &CentralBody::Mars.facts().about_sun {
    Some(orbit) => orbit,
    None => panic!("Mars goes about the Sun"),
};

/// A planet in the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planet {
    /// Unit vector from the Earth, ICRS.
    pub direction: Vector,
    /// Visual magnitude.
    pub v: f64,
    /// Colour index.
    pub b_v: f64,
}

/// Mercury, Venus, Mars, Jupiter and Saturn at a time.
pub fn at(time_us: i64) -> [Planet; 5] {
    let earth = times(-1.0 / AU_KM, sun_km(time_us));
    PLANETS.map(|planet| {
        let about_sun = on_ellipse_au(&planet.at_epoch, &planet.a_century, time_us);
        let seen = plus(about_sun, -1.0, earth);
        let (far, sun, earth) = (length(seen), length(about_sun), length(earth));
        let phase_cosine = (sun * sun + far * far - earth * earth) / (2.0 * sun * far);
        let phase_deg = libm::acos(phase_cosine.clamp(-1.0, 1.0)).to_degrees();
        let [m0, m1, m2, m3] = planet.magnitude;
        let v = m0 + 5.0 * libm::log10(sun * far) + phase_deg * (m1 + phase_deg * (m2 + phase_deg * m3));
        Planet { direction: unit(seen), v, b_v: planet.b_v }
    })
}

/// Position about the Sun on an ellipse of mean elements at J2000.0 and their changes a century, ICRS axes,
/// au.
pub fn on_ellipse_au(at_epoch: &[f64; 6], a_century: &[f64; 6], time_us: i64) -> Vector {
    let centuries = time_us as f64 / CENTURY_US;
    let mut now = *at_epoch;
    for (element, rate) in now.iter_mut().zip(a_century) {
        *element += rate * centuries;
    }
    let [a, e, inclination, mean_longitude, perihelion, node] = now;
    let mean = (mean_longitude - perihelion).to_radians();
    let mut eccentric = mean + e * libm::sin(mean);
    for _ in 0..KEPLER_ROUNDS {
        let (s, c) = libm::sincos(eccentric);
        eccentric -= (eccentric - e * s - mean) / (1.0 - e * c);
    }
    let (s, c) = libm::sincos(eccentric);
    let in_plane = [a * (c - e), a * (1.0 - e * e).sqrt() * s, 0.0];
    let turn = |axis, degrees: f64, v| apply(&transposed(&rotation(axis, degrees.to_radians())), v);
    let ecliptic = turn(2, node, turn(0, inclination, turn(2, perihelion - node, in_plane)));
    apply(&transposed(&rotation(0, OBLIQUITY_RAD)), ecliptic)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::vector::angle;

    /// Directions from SOFA's `plan94` less `epv00`, at 0 h TT of 2010-03-01, 2026-09-23 and 2040-07-15.
    const ORACLE: [(i64, [Vector; 5]); 3] = [
        (
            320_673_600_000_000,
            [
                [0.855_697, -0.458_624, -0.239_678],
                [0.989_332, -0.122_252, -0.079_228],
                [-0.509_881, 0.759_176, 0.404_565],
                [0.937_962, -0.311_293, -0.152_721],
                [-0.997_894, -0.061_127, 0.021_686],
            ],
        ),
        (
            843_393_600_000_000,
            [
                [-0.944_843, -0.295_030, -0.142_229],
                [-0.802_272, -0.495_574, -0.332_815],
                [-0.447_607, 0.814_226, 0.369_708],
                [-0.740_084, 0.612_962, 0.276_683],
                [0.977_701, 0.206_526, 0.038_061],
            ],
        ),
        (
            1_279_195_200_000_000,
            [
                [-0.046_209, 0.937_182, 0.345_767],
                [-0.571_584, 0.743_347, 0.347_458],
                [-0.943_127, 0.298_135, 0.147_062],
                [-0.997_192, 0.057_494, 0.047_980],
                [-0.993_896, -0.110_290, -0.002_625],
            ],
        ),
    ];

    #[test]
    fn planets_stand_where_sofa_puts_them() {
        for (time_us, directions) in ORACLE {
            let apart: Vec<f64> = at(time_us)
                .iter()
                .zip(directions)
                .map(|(planet, truth)| angle(planet.direction, truth).to_degrees())
                .collect();
            println!("{time_us}: {apart:.3?} deg");
            assert!(apart.iter().all(|deg| *deg < 0.15), "{apart:?}");
        }
    }

    #[test]
    fn magnitudes_are_those_of_the_almanac() {
        // Meeus, example 41: Venus on 1992-12-20 0 h TD at r = 0.724604, distance 0.910947, phase angle 72.96
        // deg is -4.2.
        let [_, venus, ..] = at(-253_454_400_000_000);
        assert!((venus.v + 4.2).abs() < 0.1, "{}", venus.v);
        // Greatest brilliancy and opposition bound the others.
        for day in 0..4_000 {
            let [mercury, venus, mars, jupiter, saturn] =
                at(800_000_000_000_000 + day * 86_400_000_000).map(|p| p.v);
            assert!((-2.6..7.5).contains(&mercury) && (-5.0..-2.5).contains(&venus));
            assert!(
                (-3.0..2.0).contains(&mars)
                    && (-3.0..-1.5).contains(&jupiter)
                    && (0.2..1.6).contains(&saturn)
            );
        }
    }
}
