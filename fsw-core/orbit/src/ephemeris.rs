//! Analytical ephemerides: Sun, neighbour, pole, rotation and velocity of a central body.
//!
//! Time in is TT, microseconds since J2000.0; vectors out are from the body's centre, km (or km/s), ICRS
//! axes.
//!
//! | body | Sun | neighbour | velocity |
//! |---|---|---|---|
//! | Earth | as below | the Moon | of the barycentre |
//! | Moon | the Earth's, less the Moon's place | the Earth | the same, and the change of its place |
//! | Mars | its own mean ellipse ([`super::body::SolarOrbit`]) | none: Phobos pulls at 1e-8 of Mars | of the ellipse |
//!
//! - Sun: Kepler's ellipse of the Earth-Moon barycentre with the mean elements of Standish (JPL, 1800-2050),
//!   which refer to the ecliptic and equinox of J2000, so that no precession enters; the Earth's own circle
//!   about the barycentre is added where the Moon is at hand.
//! - Moon: the larger terms of Brown's theory (Montenbruck and Gill, *Satellite Orbits*, §3.3.2), mean
//!   longitude referred to the equinox of J2000.
//! - Pole of the Earth: the pole of date by the IAU 2006 precession, to the second order of time, and the two
//!   greatest terms of nutation (IERS Conventions 2010, tab. 5.2a and 5.2b, `X` and `Y`). Without nutation,
//!   up to 9 arcsec, a low orbit is 168 m off after a day. The motion of the pole in the crust, up to 0.6
//!   arcsec, is left out: in proportion 11 m.
//! - Pole and meridian of other bodies: [`super::body::BodyAxes`].
//!
//! Errors 2000-2050 were found against ERFA's `epv00`, `moon98` and `xys06a` at 4,000 random times (a sample
//! is kept in the tests): see each function. Positions are geometric: neither light time nor aberration. Mean
//! angles are reduced to one turn in f64, all else is f32, whose rounding (0.05 arcsec, 30 km of the Sun's
//! distance) is far below these errors. Cost on the target: about 10,000 cycles for Sun and Moon together.

use super::body::{BodyAxes, CentralBody, EARTH, MOON, SolarOrbit};
use super::constants::{AU_KM, CENTURY_US, MICROSECONDS, MOON_SHARE};
use fsw_ground::frames::{Direction, Icrs};
use fsw_ground::trigonometry::sine_cosine;
use nalgebra::{Matrix3, Vector3};

/// Cosine and sine of the obliquity of J2000, 84381.406 arcsec (IAU 2006).
const OBLIQUITY: [f32; 2] = [0.917_482_14, 0.397_776_96];
const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;
const RAD_PER_ARCSEC: f64 = RAD_PER_DEG / 3600.0;
/// Seconds in a century.
const CENTURY_S: f64 = 36_525.0 * 86_400.0;

/// Days in a century.
const CENTURY_DAYS: f64 = 36_525.0;
/// Newton's steps for Kepler's equation: below 1e-7 rad up to an eccentricity of 0.1.
const KEPLER_STEPS: usize = 3;
/// Half of the time over which the Moon's velocity is taken, us: its path bends by 1e-5 km/s in it.
const HALF_US: i64 = 450_000_000;

/// TT less UT1, s: 69.2 from 2017 to 2026 within 0.4; 64 to 69 from 2000 to 2017 (IERS).
const TT_LESS_UT1_S: f64 = 69.2;

/// Julian centuries of TT since J2000.0.
fn centuries(time_us: i64) -> f64 {
    time_us as f64 / CENTURY_US
}

/// An angle of any number of turns, degrees, as one within a turn, rad.
#[inline(never)]
fn reduced_rad(angle_deg: f64) -> f32 {
    let turns = angle_deg * (1.0 / 360.0);
    ((turns - libm::floor(turns)) * core::f64::consts::TAU) as f32
}

/// From the ecliptic of J2000 to ICRS axes (the frame bias of 0.02 arcsec is left out).
#[inline(never)]
fn equatorial(v: Vector3<f32>) -> Vector3<f32> {
    let [cosine, sine] = OBLIQUITY;
    Vector3::new(v.x, cosine * v.y - sine * v.z, sine * v.y + cosine * v.z)
}

/// The Earth-Moon barycentre about the Sun: position km, velocity km/s, ecliptic of J2000.
#[inline(never)]
fn barycentre(time_us: i64) -> (Vector3<f32>, Vector3<f32>) {
    /// Mean motion against the equinox of J2000, deg per century.
    const RATE_DEG: f64 = 35_999.372_449_81;
    const AXIS_KM: f64 = 1.000_002_61 * AU_KM;
    const MEAN_SPEED_KM_S: f32 = (AXIS_KM * RATE_DEG * RAD_PER_DEG / CENTURY_S) as f32;
    const AXIS_KM_F32: f32 = AXIS_KM as f32;
    let t = centuries(time_us);
    let perihelion_deg = 102.937_681_93 + 0.323_273_64 * t;
    let mean = reduced_rad(100.464_571_66 + RATE_DEG * t - perihelion_deg);
    let (sine_perihelion, cosine_perihelion) = sine_cosine(reduced_rad(perihelion_deg));
    let t = t as f32;
    let eccentricity = 0.016_711_23 - 0.000_043_92 * t;
    // Kepler's equation to the third order, short by 0.5 arcsec: E = M + e sin M (1 + e cos M).
    let (sine_mean, cosine_mean) = sine_cosine(mean);
    let (sine, cosine) = sine_cosine(mean + eccentricity * sine_mean * (1.0 + eccentricity * cosine_mean));
    let minor = libm::sqrtf(1.0 - eccentricity * eccentricity);
    // The orbit's tilt against the ecliptic of J2000 is 47 arcsec per century times T: about the node, kept
    // to first order.
    let tilt = (-0.000_015_31 - 0.012_946_68 * t) * RAD_PER_DEG as f32;
    let in_ecliptic = |along: f32, across: f32, scale: f32| {
        let x = cosine_perihelion * along - sine_perihelion * across;
        let y = sine_perihelion * along + cosine_perihelion * across;
        Vector3::new(x, y, tilt * y) * scale
    };
    let speed_km_s = MEAN_SPEED_KM_S / (1.0 - eccentricity * cosine);
    (
        in_ecliptic(cosine - eccentricity, minor * sine, AXIS_KM_F32),
        in_ecliptic(-sine, minor * cosine, speed_km_s),
    )
}

/// A term of the Moon's series: amplitude, and multiples of the Moon's mean anomaly, the Sun's, the argument
/// of latitude and the elongation.
type Term = (f32, [i8; 4]);

/// Longitude less mean longitude, sines, arcsec.
const INEQUALITY: [Term; 14] = [
    (22_640.0, [1, 0, 0, 0]),
    (-4_586.0, [1, 0, 0, -2]),
    (2_370.0, [0, 0, 0, 2]),
    (769.0, [2, 0, 0, 0]),
    (-668.0, [0, 1, 0, 0]),
    (-412.0, [0, 0, 2, 0]),
    (-212.0, [2, 0, 0, -2]),
    (-206.0, [1, 1, 0, -2]),
    (192.0, [1, 0, 0, 2]),
    (-165.0, [0, 1, 0, -2]),
    (148.0, [1, -1, 0, 0]),
    (-125.0, [0, 0, 0, 1]),
    (-110.0, [1, 1, 0, 0]),
    (-55.0, [0, 0, 2, -2]),
];

/// What is added to [`INEQUALITY`] for the argument of the latitude's first term, sines, arcsec.
const NODE: [Term; 2] = [(412.0, [0, 0, 2, 0]), (541.0, [0, 1, 0, 0])];

/// Latitude but for its first term, sines, arcsec.
const LATITUDE: [Term; 7] = [
    (-526.0, [0, 0, 1, -2]),
    (44.0, [1, 0, 1, -2]),
    (-31.0, [-1, 0, 1, -2]),
    (-25.0, [-2, 0, 1, 0]),
    (-23.0, [0, 1, 1, -2]),
    (21.0, [-1, 0, 1, 0]),
    (11.0, [0, -1, 1, -2]),
];

/// Distance but for its constant, cosines, km.
const DISTANCE: [Term; 8] = [
    (-20_905.0, [1, 0, 0, 0]),
    (-3_699.0, [1, 0, 0, -2]),
    (-2_956.0, [0, 0, 0, 2]),
    (-570.0, [2, 0, 0, 0]),
    (246.0, [2, 0, 0, -2]),
    (-205.0, [0, 1, 0, -2]),
    (-171.0, [1, 0, 0, 2]),
    (-152.0, [1, 1, 0, -2]),
];

/// Sums of the terms' sines and cosines.
#[inline(never)]
fn series(terms: &[Term], angles_rad: &[f32; 4]) -> (f32, f32) {
    terms.iter().fold((0.0, 0.0), |(sines, cosines), (amplitude, multiples)| {
        let angle = multiples.iter().zip(angles_rad).fold(0.0, |sum, (n, angle)| sum + f32::from(*n) * angle);
        let (sine, cosine) = sine_cosine(angle);
        (sines + amplitude * sine, cosines + amplitude * cosine)
    })
}

/// The Moon about the Earth, km, ecliptic of J2000.
#[inline(never)]
fn moon_ecliptic(time_us: i64) -> Vector3<f32> {
    const PER_ARCSEC: f32 = RAD_PER_ARCSEC as f32;
    let t = centuries(time_us);
    let anomaly = reduced_rad(134.962_92 + 477_198.867_53 * t);
    let sun_anomaly = reduced_rad(357.525_43 + 35_999.049_44 * t);
    let latitude_argument = reduced_rad(93.272_83 + 483_202.018_73 * t);
    let elongation = reduced_rad(297.850_27 + 445_267.111_35 * t);
    let angles = [anomaly, sun_anomaly, latitude_argument, elongation];
    let (inequality, _) = series(&INEQUALITY, &angles);
    // Referred to the equinox of J2000: 481267.88088 less the precession of 1.3972 deg per century.
    let mean_longitude = reduced_rad(218.316_17 + (481_267.880_88 - 1.397_2) * t);
    let (sine_longitude, cosine_longitude) = sine_cosine(mean_longitude + inequality * PER_ARCSEC);
    let node = inequality + series(&NODE, &angles).0;
    let (main, _) = sine_cosine(latitude_argument + node * PER_ARCSEC);
    let (sine, cosine) = sine_cosine((18_520.0 * main + series(&LATITUDE, &angles).0) * PER_ARCSEC);
    let distance_km = 385_000.0 + series(&DISTANCE, &angles).1;
    Vector3::new(cosine * cosine_longitude, cosine * sine_longitude, sine) * distance_km
}

/// Position and velocity on an ellipse about the Sun, km and km/s, ecliptic of J2000; error of Mars 0.02 deg.
#[inline(never)]
fn on_ellipse(orbit: &SolarOrbit, time_us: i64) -> (Vector3<f32>, Vector3<f32>) {
    let t = centuries(time_us);
    let mut now = orbit.at_epoch;
    for (element, rate) in now.iter_mut().zip(&orbit.a_century) {
        *element += rate * t;
    }
    let [axis_au, eccentricity, inclination, longitude, perihelion, node] = now;
    let [.., longitude_rate, perihelion_rate, _] = orbit.a_century;
    let axis_km = (axis_au * AU_KM) as f32;
    let motion_rad_s = ((longitude_rate - perihelion_rate) * RAD_PER_DEG / CENTURY_S) as f32;
    let e = eccentricity as f32;
    let mean = reduced_rad(longitude - perihelion);
    let mut eccentric = mean + e * sine_cosine(mean).0;
    for _ in 0..KEPLER_STEPS {
        let (sine, cosine) = sine_cosine(eccentric);
        eccentric -= (eccentric - e * sine - mean) / (1.0 - e * cosine);
    }
    let (sine, cosine) = sine_cosine(eccentric);
    let minor = libm::sqrtf(1.0 - e * e);
    let [(sw, cw), (si, ci), (sn, cn)] =
        [perihelion - node, inclination, node].map(|angle| sine_cosine(reduced_rad(angle)));
    let in_ecliptic = |along: f32, across: f32, scale: f32| {
        let (x, y) = (cw * along - sw * across, sw * along + cw * across);
        Vector3::new(cn * x - sn * ci * y, sn * x + cn * ci * y, si * y) * scale
    };
    let speed_km_s = motion_rad_s * axis_km / (1.0 - e * cosine);
    (in_ecliptic(cosine - e, minor * sine, axis_km), in_ecliptic(-sine, minor * cosine, speed_km_s))
}

/// The Moon's velocity about the Earth, km/s, ecliptic of J2000.
fn moon_velocity(time_us: i64) -> Vector3<f32> {
    let [before, after] = [-HALF_US, HALF_US].map(|by| moon_ecliptic(time_us.saturating_add(by)));
    (after - before) * (0.5e6 / HALF_US as f32)
}

/// Right ascension and declination of the pole, and the prime meridian's angle from the node of the equator,
/// rad.
#[inline(never)]
fn axes_rad(axes: &BodyAxes, time_us: i64) -> [f32; 3] {
    let t = centuries(time_us);
    let days = t * CENTURY_DAYS;
    let linear = |[at_epoch, rate]: [f64; 2], time: f64| at_epoch + rate * time;
    let mut angles_deg = [
        linear(axes.right_ascension_deg, t),
        linear(axes.declination_deg, t),
        linear(axes.meridian_deg, days),
    ];
    for [at_epoch, rate, alpha, delta, meridian] in axes.terms {
        let (sine, cosine) = sine_cosine(reduced_rad(at_epoch + rate * days));
        let (sine, cosine) = (f64::from(sine), f64::from(cosine));
        for (angle, by) in angles_deg.iter_mut().zip([alpha * sine, delta * cosine, meridian * sine]) {
            *angle += by;
        }
    }
    angles_deg.map(reduced_rad)
}

/// Positions of the perturbing bodies, and the pole of the central body's oblateness.
#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    /// The Sun, km; error up to 0.007 deg and 6e-5 of the distance, from Mars 0.02 deg.
    pub sun_km: Vector3<f64>,
    /// The Moon, from the Moon the Earth, km; error up to 0.1 deg (rms 0.02) and 600 km. From Mars 0.
    pub neighbour_km: Vector3<f64>,
    /// Its gravitational parameter, km³/s²; 0 where there is none.
    pub neighbour_km3_s2: f64,
    /// Unit vector to the north pole of date; error up to 0.6 arcsec, of Moon and Mars 0.03 deg.
    pub pole: Vector3<f64>,
}

impl Bodies {
    /// From the centre of `body` at this time, TT, microseconds since J2000.0.
    pub fn at(body: CentralBody, time_us: i64) -> Self {
        let pole = pole_vector(body, time_us).map(f64::from);
        if let Some(orbit) = &body.facts().about_sun {
            let sun_km = equatorial(-on_ellipse(orbit, time_us).0).map(f64::from);
            return Self { sun_km, neighbour_km: Vector3::zeros(), neighbour_km3_s2: 0.0, pole };
        }
        let moon = moon_ecliptic(time_us);
        let (barycentre, _) = barycentre(time_us);
        // The barycentre lies towards the Moon, so the Earth is opposite.
        let sun = moon * MOON_SHARE as f32 - barycentre;
        let (sun, neighbour, neighbour_km3_s2) = match body {
            CentralBody::Moon => (sun - moon, -moon, EARTH.mu_km3_s2),
            _ => (sun, moon, MOON.mu_km3_s2),
        };
        let [sun_km, neighbour_km] = [sun, neighbour].map(|place| equatorial(place).map(f64::from));
        Self { sun_km, neighbour_km, neighbour_km3_s2, pole }
    }
}

#[inline(never)]
fn pole_vector(body: CentralBody, time_us: i64) -> Vector3<f32> {
    let Some(axes) = &body.facts().axes else { return earth_pole(time_us) };
    let [alpha, delta, _] = axes_rad(axes, time_us).map(sine_cosine);
    Vector3::new(delta.1 * alpha.1, delta.1 * alpha.0, delta.0)
}

#[inline(never)]
fn earth_pole(time_us: i64) -> Vector3<f32> {
    const PER_ARCSEC: f32 = RAD_PER_ARCSEC as f32;
    let t = centuries(time_us);
    // The Moon's node, and twice the Sun's mean longitude.
    let (node_sine, node_cosine) = sine_cosine(reduced_rad(125.044_555 - 1_934.136_261 * t));
    let (sun_sine, sun_cosine) = sine_cosine(reduced_rad(2.0 * (280.466_46 + 36_000.769_83 * t)));
    let t = t as f32;
    let x = (2_004.191_9 - 0.429_8 * t) * t - 6.844_3 * node_sine - 0.523_9 * sun_sine;
    let y = -22.407_3 * t * t + 9.205_2 * node_cosine + 0.573_0 * sun_cosine;
    let [x, y] = [x * PER_ARCSEC, y * PER_ARCSEC];
    Vector3::new(x, y, 1.0 - 0.5 * (x * x + y * y))
}

/// Rows of the axes of the equator of date along ICRS: z the `pole`, x where the shortest turn of the pole
/// leads that of ICRS: of the Earth the celestial intermediate origin (IERS Conventions 2010, eq. 5.6, its
/// small angle `s` left out); error as of the pole.
pub fn equator_axes(pole: &Vector3<f64>) -> Matrix3<f32> {
    let [x, y, z] = pole.map(|axis| axis as f32).into();
    let a = 1.0 / (1.0 + z);
    Matrix3::new(1.0 - a * x * x, -a * x * y, -x, -a * x * y, 1.0 - a * y * y, -y, x, y, z)
}

/// Angle by which the prime meridian has turned from x of [`equator_axes`], rad, 0 to one turn. Of the Earth
/// by IAU 2000; error 15 arcsec a second of TT less UT1, which is taken as 69.2 s. Of others 0.03 deg.
pub fn rotation_rad(body: CentralBody, time_us: i64) -> f32 {
    if let Some(axes) = &body.facts().axes {
        // The node of the equator, at 90 deg from the pole's right ascension, is what that turn leaves in
        // place.
        let [alpha, _, meridian] = axes_rad(axes, time_us).map(f64::from);
        return reduced_rad((alpha + meridian) / RAD_PER_DEG + 90.0);
    }
    let days = (time_us as f64 / MICROSECONDS - TT_LESS_UT1_S) / 86_400.0;
    reduced_rad(360.0 * (0.779_057_273_264 + 1.002_737_811_911_354_5 * days))
}

/// Direction to the Sun from `body`; error up to 0.01 deg (geometric: the seen Sun stands 20 arcsec back
/// along the ecliptic), from Mars 0.02 deg, from the Moon 0.15 deg, the parallax of its distance from the
/// Earth.
pub fn sun_direction(body: CentralBody, time_us: i64) -> Direction<Icrs> {
    let about_sun = match &body.facts().about_sun {
        Some(orbit) => on_ellipse(orbit, time_us).0,
        None => barycentre(time_us).0,
    };
    // No body is ever at the Sun, so the vector always has a direction.
    Direction::new(equatorial(-about_sun) * (1.0 / AU_KM as f32)).unwrap_or(Direction::z())
}

/// Direction to the north pole of date of `body`; error up to 0.6 arcsec, of Moon and Mars 0.03 deg.
pub fn pole(body: CentralBody, time_us: i64) -> Direction<Icrs> {
    Direction::new(pole_vector(body, time_us)).unwrap_or(Direction::z())
}

/// [`pole`] as a unit vector in double precision.
pub fn pole_axis(body: CentralBody, time_us: i64) -> Vector3<f64> {
    pole(body, time_us).vector().map(f64::from)
}

/// Velocity of `body` about the barycentre of the solar system, km/s, ICRS axes, for annual aberration; error
/// up to 0.03 km/s (0.02 arcsec).
pub fn velocity_km_s(body: CentralBody, time_us: i64) -> Vector3<f64> {
    let of_earth = || barycentre(time_us).1;
    let velocity = match (body, &body.facts().about_sun) {
        (_, Some(orbit)) => on_ellipse(orbit, time_us).1,
        (CentralBody::Moon, _) => of_earth() + moon_velocity(time_us),
        _ => of_earth(),
    };
    equatorial(velocity).map(f64::from)
}

#[cfg(test)]
mod tests;
