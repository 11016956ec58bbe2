//! The central body in the world: where Sun and neighbour stand from it, how it moves, stands and turns.
//!
//! In: TT, µs since J2000.0. Out: from the body's centre, km and km/s, ICRS axes. Of the Earth by
//! [`super::time::ephemeris`]; of Moon and Mars by their rows of [`fsw_core::orbit::body`], which the flight
//! code reads too. The Moon stands by the Earth's ephemeris: its Sun is exact to that. Mars stands on its
//! mean ellipse, within 0.02 deg of the numerical ephemerides; flight and world share that error, which moves
//! the Sun's direction and the aberration by 0.03 arcsec.

use super::attitude::{Vector, rotation};
use super::sky::planets::{self, CENTURY_US};
use super::time::civil_time::DAY_US;
use super::time::ephemeris::{self, AU_KM};
use super::vector::{minus, plus, product, times};
use fsw_core::orbit::body::{BodyAxes, CentralBody, EARTH, MOON};

/// Half the time over which a velocity is a difference of places, µs.
const HALF_US: i64 = 300_000_000;

/// The Sun.
pub fn sun_km(body: CentralBody, time_us: i64) -> Vector {
    match (body, &body.facts().about_sun) {
        (_, Some(orbit)) => times(-AU_KM, planets::on_ellipse_au(&orbit.at_epoch, &orbit.a_century, time_us)),
        (CentralBody::Moon, _) => minus(ephemeris::sun_km(time_us), ephemeris::moon_km(time_us)),
        _ => ephemeris::sun_km(time_us),
    }
}

/// The body that pulls beside the Sun, with its gravitational parameter, km³/s²: the Moon on a satellite of
/// the Earth, the Earth on one of the Moon. Mars's moons pull at 1e-8 of Mars.
pub fn neighbour(body: CentralBody, time_us: i64) -> Option<(Vector, f64)> {
    match body {
        CentralBody::Earth => Some((ephemeris::moon_km(time_us), MOON.mu_km3_s2)),
        CentralBody::Moon => Some((times(-1.0, ephemeris::moon_km(time_us)), EARTH.mu_km3_s2)),
        CentralBody::Mars => None,
    }
}

/// Velocity about the centre of mass of the solar system.
pub fn velocity_km_s(body: CentralBody, time_us: i64) -> Vector {
    let change = |place: &dyn Fn(i64) -> Vector| {
        times(0.5e6 / HALF_US as f64, minus(place(time_us + HALF_US), place(time_us - HALF_US)))
    };
    match body {
        CentralBody::Earth => ephemeris::earth_velocity_km_s(time_us),
        CentralBody::Moon => plus(ephemeris::earth_velocity_km_s(time_us), 1.0, change(&ephemeris::moon_km)),
        CentralBody::Mars => change(&|at_us| times(-1.0, sun_km(body, at_us))),
    }
}

/// ICRS to the equator of date: x to its node (of the Earth: the equinox), z to the pole.
pub fn icrs_to_equator(body: CentralBody, time_us: i64) -> [Vector; 3] {
    let Some(axes) = &body.facts().axes else { return ephemeris::icrs_to_equator(time_us) };
    let [right_ascension, declination, _] = angles_rad(axes, time_us);
    let to_node = rotation(2, right_ascension + std::f64::consts::FRAC_PI_2);
    let tilt = rotation(0, std::f64::consts::FRAC_PI_2 - declination);
    product(&tilt, &to_node)
}

/// Angle from there to the prime meridian, rad.
pub fn meridian_rad(body: CentralBody, time_us: i64) -> f64 {
    match &body.facts().axes {
        Some(axes) => angles_rad(axes, time_us)[2],
        None => ephemeris::sidereal_angle(time_us),
    }
}

/// ICRS to axes that turn with a body of a row.
pub fn icrs_to_fixed(body: CentralBody, time_us: i64) -> [Vector; 3] {
    product(&rotation(2, meridian_rad(body, time_us)), &icrs_to_equator(body, time_us))
}

/// Right ascension and declination of the pole, and the prime meridian, rad.
fn angles_rad(axes: &BodyAxes, time_us: i64) -> [f64; 3] {
    let (centuries, days) = (time_us as f64 / CENTURY_US, time_us as f64 / DAY_US as f64);
    let linear = |[at_epoch, rate]: [f64; 2], time: f64| at_epoch + rate * time;
    let mut angles_deg = [
        linear(axes.right_ascension_deg, centuries),
        linear(axes.declination_deg, centuries),
        linear(axes.meridian_deg, days),
    ];
    for [at_epoch, rate, right_ascension, declination, meridian] in axes.terms {
        let (sine, cosine) = libm::sincos((at_epoch + rate * days).to_radians());
        for (angle, by) in
            angles_deg.iter_mut().zip([right_ascension * sine, declination * cosine, meridian * sine])
        {
            *angle += by;
        }
    }
    angles_deg.map(|angle| libm::fmod(angle, 360.0).to_radians())
}
