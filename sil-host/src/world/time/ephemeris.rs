//! Sun, Moon, the Earth's motion, pole and rotation.
//!
//! In: TT, µs since J2000.0. Out: geocentric positions in km and velocities in km/s, ICRS axes; the rotation
//! from ICRS to the true equator of date and the angle of the Earth's turning in it, for UT1 = UTC and a pole
//! at rest in the crust: see [`super::earth_orientation`] for both as observed.
//!
//! | module | model |
//! |---|---|
//! | `sun` | 118 terms of VSOP2000 as in SOFA's `epv00` |
//! | `moon` | Meeus, ch. 47, all 60 + 60 terms |
//! | `pole` | precession IAU 2006, nutation IAU 2000B, CIO locator |
//! | `harmonics` | sums of multiples of angles |
//!
//! Greatest errors at 16 dates from 2000 to 2050 against SOFA's routines: Sun 0.6 arcsec and 140 km, the
//! Earth's velocity 0.25 m/s, pole 0.6 mas, sidereal angle 0.9 mas. The Moon is `moon98` to 0.1 km, which
//! itself is within some 10 arcsec of DE405. Every call is a pure function of the time. Cost on a desktop
//! core: Sun 2.4 µs, velocity 3.2 µs, Moon 1.4 µs, equator 1.0 µs, sidereal angle 1.5 µs.

mod harmonics;
mod moon;
mod moon_terms;
mod nutation_terms;
mod pole;
mod sun;
mod sun_terms;

use super::civil_time;
use crate::world::attitude::{Vector, dot};
use crate::world::vector::times;

/// Astronomical unit, km.
pub const AU_KM: f64 = 149_597_870.7;
/// Speed of light, km/s.
pub const LIGHT_KM_S: f64 = 299_792.458;
/// The Earth's rate of rotation, rad/s.
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// Second of arc, rad.
pub(super) const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;
const DAY_US: f64 = civil_time::DAY_US as f64;
const CENTURY_DAYS: f64 = 36_525.0;

/// Julian centuries since J2000.0.
fn centuries(time_us: i64) -> f64 {
    time_us as f64 / DAY_US / CENTURY_DAYS
}

/// The Julian year of a time, for proper motions.
pub fn julian_year(time_us: i64) -> f64 {
    2000.0 + 100.0 * centuries(time_us)
}

/// `Σ c_k t^k`.
fn polynomial(t: f64, coefficients: &[f64]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// Between 0 and 2 pi.
fn whole_turn(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    libm::fmod(libm::fmod(angle_rad, turn) + turn, turn)
}

/// ICRS to the true equator and equinox of date; the third row is the Earth's pole.
pub fn icrs_to_equator(time_us: i64) -> [Vector; 3] {
    pole::gcrf_to_true(centuries(time_us))
}

/// The pole's components in ICRS and the CIO locator, rad.
pub(super) fn pole_and_locator(time_us: i64) -> (Vector, f64) {
    let t = centuries(time_us);
    let pole = pole::gcrf_to_true(t)[2];
    (pole, pole::cio_locator(t, pole))
}

/// Earth rotation angle, rad, 0 to 2 pi (IAU 2000).
pub(super) fn earth_rotation_angle(time_us: i64, tt_minus_ut1_s: f64) -> f64 {
    // The fraction of the day is taken from whole microseconds, so that centuries cost no digits.
    let ut1_us = time_us - libm::rint(tt_minus_ut1_s * 1e6) as i64;
    let day = ut1_us.rem_euclid(civil_time::DAY_US) as f64 / DAY_US;
    let days = ut1_us as f64 / DAY_US;
    whole_turn(std::f64::consts::TAU * (day + 0.779_057_273_264 + 0.002_737_811_911_354_48 * days))
}

/// Angle from the equinox of date to Greenwich, rad, 0 to 2 pi; UT1 = UTC.
pub fn sidereal_angle(time_us: i64) -> f64 {
    let t = centuries(time_us);
    let equator = pole::gcrf_to_true(t);
    let [x, y, z] = equator[2];
    // Where the CIO lies from the equinox (Wallace and Capitaine 2006).
    let share = x / (1.0 + z);
    let origin = [1.0 - share * x, -share * y, -x];
    let along = libm::atan2(dot(equator[1], origin), dot(equator[0], origin));
    let from_equinox = along - pole::cio_locator(t, equator[2]);
    whole_turn(earth_rotation_angle(time_us, civil_time::tt_minus_utc_s(time_us)) + from_equinox)
}

/// Geometric position of the Sun from the Earth's centre, km.
pub fn sun_km(time_us: i64) -> Vector {
    times(-AU_KM, sun::earth_from_sun_au(centuries(time_us)))
}

/// The Earth's velocity about the centre of mass of the solar system, km/s.
pub fn earth_velocity_km_s(time_us: i64) -> Vector {
    times(AU_KM / (365.25 * 86_400.0), sun::earth_velocity_au_year(centuries(time_us)))
}

/// Geometric position of the Moon from the Earth's centre, km.
pub fn moon_km(time_us: i64) -> Vector {
    moon::from_earth_km(centuries(time_us))
}

#[cfg(test)]
mod tests;
