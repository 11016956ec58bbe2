//! The Earth's way about the Sun and about the centre of mass of the solar system.
//!
//! In: TT, centuries since J2000.0 (TDB differs by 2 ms, in which the Earth goes 50 m). Out: au and au a
//! Julian year, GCRF axes. Sums of `a cos(w t) + b sin(w t)`, see [`super::sun_terms`]; velocities are their
//! derivatives.

use super::sun_terms::{EARTH, EARTH_PER_YEAR, SUN};
use crate::world::attitude::{Vector, apply};
use crate::world::vector::plus;

/// From the series' ecliptic axes to GCRF (SOFA's `epv00`, fitted to DE405).
const ECLIPTIC_TO_GCRF: [Vector; 3] = [
    [1.0, 0.000_000_211_284, -0.000_000_091_603],
    [-0.000_000_230_286, 0.917_482_137_087, -0.397_776_982_902],
    [0.0, 0.397_776_982_902, 0.917_482_137_087],
];

/// Sum of a series and its derivative.
fn sum(terms: &[[f64; 7]], years: f64) -> (Vector, Vector) {
    let (mut place, mut slope) = ([0.0; 3], [0.0; 3]);
    for [rate, parts @ ..] in terms.iter().rev() {
        let (sine, cosine) = libm::sincos(rate * years);
        for axis in 0..3 {
            let (a, b) = (parts[2 * axis], parts[2 * axis + 1]);
            place[axis] += a * cosine + b * sine;
            slope[axis] += rate * (b * cosine - a * sine);
        }
    }
    (place, slope)
}

/// The Earth's position from the Sun, au.
pub(super) fn earth_from_sun_au(t: f64) -> Vector {
    let years = 100.0 * t;
    let place = plus(sum(&EARTH, years).0, years, sum(&EARTH_PER_YEAR, years).0);
    apply(&ECLIPTIC_TO_GCRF, place)
}

/// The Earth's velocity about the centre of mass of the solar system, au a year.
pub(super) fn earth_velocity_au_year(t: f64) -> Vector {
    let years = 100.0 * t;
    let (growing, growing_slope) = sum(&EARTH_PER_YEAR, years);
    let about_sun = plus(plus(sum(&EARTH, years).1, years, growing_slope), 1.0, growing);
    apply(&ECLIPTIC_TO_GCRF, plus(about_sun, 1.0, sum(&SUN, years).1))
}
