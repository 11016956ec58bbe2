//! Where Sun, Moon and the Earth's pole are, and how fast the Earth moves: from the time alone.
//!
//! Time in is TT, microseconds since J2000.0; vectors out are geocentric, km (or km/s), ICRS axes.
//!
//! - Sun: Kepler's ellipse of the Earth-Moon barycentre with the mean elements of Standish (JPL, 1800-2050), which refer
//!   to the ecliptic and equinox of J2000, so that no precession enters; the Earth's own circle about the barycentre is
//!   added where the Moon is at hand.
//! - Moon: the larger terms of Brown's theory (Montenbruck and Gill, *Satellite Orbits*, §3.3.2), mean longitude
//!   referred to the equinox of J2000.
//! - Pole: the mean pole of date to the second order of time (IAU 2006, `X` and `Y`); nutation (9 arcsec) is left out.
//!
//! Errors 2000-2050 were found against ERFA's `epv00`, `moon98` and `xys06a` at 4,000 random times (a sample is kept in
//! the tests): see each function. Positions are geometric: neither light time nor aberration. Cost: 16 calls of `sin` or
//! `cos` for Sun and Moon together.

use super::constants::{AU_KM, CENTURY_US, MOON_SHARE};
use crate::frames::{Direction, Icrs};
use crate::trigonometry::sine_cosine_f64;
use nalgebra::Vector3;

/// Cosine and sine of the obliquity of J2000, 84381.406 arcsec (IAU 2006).
const OBLIQUITY: Angle = Angle { cosine: 0.917_482_143_065_241_8, sine: 0.397_776_969_112_605_74 };
const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;
const RAD_PER_ARCSEC: f64 = RAD_PER_DEG / 3600.0;
/// Days in a century times seconds in a day.
const CENTURY_S: f64 = 36_525.0 * 86_400.0;

/// Julian centuries of TT since J2000.0.
fn centuries(time_us: i64) -> f64 {
    time_us as f64 / CENTURY_US
}

/// An angle as a point of the unit circle: sums and multiples of angles are products, and cost no sine.
#[derive(Clone, Copy)]
struct Angle {
    cosine: f64,
    sine: f64,
}

impl Angle {
    fn of_rad(angle: f64) -> Self {
        let (sine, cosine) = sine_cosine_f64(angle);
        Self { cosine, sine }
    }

    /// `constant + rate T` degrees; whole turns are taken off while they are exact.
    fn of_deg(angle: f64) -> Self {
        Self::of_rad((angle - 360.0 * libm::floor(angle / 360.0)) * RAD_PER_DEG)
    }

    fn plus(self, other: Self) -> Self {
        Self {
            cosine: self.cosine * other.cosine - self.sine * other.sine,
            sine: self.sine * other.cosine + self.cosine * other.sine,
        }
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self { cosine: other.cosine, sine: -other.sine })
    }

    fn twice(self) -> Self {
        self.plus(self)
    }
}

/// From the ecliptic of J2000 to ICRS axes (the frame bias of 0.02 arcsec is left out).
fn equatorial(v: Vector3<f64>) -> Vector3<f64> {
    let Angle { cosine, sine } = OBLIQUITY;
    Vector3::new(v.x, cosine * v.y - sine * v.z, sine * v.y + cosine * v.z)
}

/// The Earth-Moon barycentre about the Sun: position km, velocity km/s, ecliptic of J2000.
fn barycentre(time_us: i64) -> (Vector3<f64>, Vector3<f64>) {
    /// Mean motion against the equinox of J2000, deg per century.
    const RATE_DEG: f64 = 35_999.372_449_81;
    const AXIS_KM: f64 = 1.000_002_61 * AU_KM;
    let t = centuries(time_us);
    let eccentricity = 0.016_711_23 - 0.000_043_92 * t;
    let perihelion_deg = 102.937_681_93 + 0.323_273_64 * t;
    let perihelion = Angle::of_deg(perihelion_deg);
    let mean = Angle::of_deg(100.464_571_66 + RATE_DEG * t - perihelion_deg);
    // Kepler's equation to the third order: E - M = e sin M (1 + e cos M), short by 0.5 arcsec. The step is so small
    // that its sine needs no call.
    let step = eccentricity * mean.sine * (1.0 + eccentricity * mean.cosine);
    let eccentric =
        mean.plus(Angle { cosine: 1.0 - 0.5 * step * step, sine: step * (1.0 - step * step / 6.0) });
    let minor = libm::sqrt(1.0 - eccentricity * eccentricity);
    // The orbit's tilt against the ecliptic of J2000 is 47 arcsec per century times T: about the node, kept to first order.
    let tilt = (-0.000_015_31 - 0.012_946_68 * t) * RAD_PER_DEG;
    let place = |along: f64, across: f64| {
        let x = perihelion.cosine * along - perihelion.sine * across;
        let y = perihelion.sine * along + perihelion.cosine * across;
        Vector3::new(x, y, tilt * y)
    };
    let speed = AXIS_KM * RATE_DEG * RAD_PER_DEG / CENTURY_S / (1.0 - eccentricity * eccentric.cosine);
    (
        place(eccentric.cosine - eccentricity, minor * eccentric.sine) * AXIS_KM,
        place(-eccentric.sine, minor * eccentric.cosine) * speed,
    )
}

/// The Moon about the Earth, km, ecliptic of J2000.
fn moon_ecliptic(time_us: i64) -> Vector3<f64> {
    let t = centuries(time_us);
    // Mean anomalies of Moon and Sun, argument of latitude, elongation.
    let l = Angle::of_deg(134.962_92 + 477_198.867_53 * t);
    let s = Angle::of_deg(357.525_43 + 35_999.049_44 * t);
    let f = Angle::of_deg(93.272_83 + 483_202.018_73 * t);
    let d2 = Angle::of_deg(297.850_27 + 445_267.111_35 * t).twice();
    let l2 = l.twice();
    let f2 = f.twice();
    let evection = l.minus(d2);
    let l_d2 = l.plus(d2);
    let s_d2 = s.minus(d2);
    let ls_d2 = l.plus(s_d2);
    let l2_d2 = l2.minus(d2);
    let d = Angle::of_deg(297.850_27 + 445_267.111_35 * t);
    let inequality = 22_640.0 * l.sine + 769.0 * l2.sine - 4_586.0 * evection.sine + 2_370.0 * d2.sine
        - 668.0 * s.sine
        - 412.0 * f2.sine
        - 212.0 * l2_d2.sine
        - 206.0 * ls_d2.sine
        + 192.0 * l_d2.sine
        - 165.0 * s_d2.sine
        + 148.0 * l.minus(s).sine
        - 125.0 * d.sine
        - 110.0 * l.plus(s).sine
        - 55.0 * f2.minus(d2).sine;
    // Referred to the equinox of J2000: 481267.88088 less the precession of 1.3972 deg per century.
    let longitude = Angle::of_deg(218.316_17 + (481_267.880_88 - 1.397_2) * t + inequality / 3600.0);
    let node = Angle::of_rad((inequality + 412.0 * f2.sine + 541.0 * s.sine) * RAD_PER_ARCSEC);
    let f_d2 = f.minus(d2);
    let latitude = 18_520.0 * f.plus(node).sine - 526.0 * f_d2.sine + 44.0 * l.plus(f_d2).sine
        - 31.0 * f_d2.minus(l).sine
        - 25.0 * f.minus(l2).sine
        - 23.0 * s.plus(f_d2).sine
        + 21.0 * f.minus(l).sine
        + 11.0 * f_d2.minus(s).sine;
    let latitude = Angle::of_rad(latitude * RAD_PER_ARCSEC);
    let distance_km =
        385_000.0 - 20_905.0 * l.cosine - 3_699.0 * evection.cosine - 2_956.0 * d2.cosine - 570.0 * l2.cosine
            + 246.0 * l2_d2.cosine
            - 205.0 * s_d2.cosine
            - 171.0 * l_d2.cosine
            - 152.0 * ls_d2.cosine;
    Vector3::new(latitude.cosine * longitude.cosine, latitude.cosine * longitude.sine, latitude.sine)
        * distance_km
}

/// The bodies that pull at the satellite, and the axis the Earth bulges about.
#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    /// The Sun, km; error up to 0.007 deg and 6e-5 of the distance.
    pub sun_km: Vector3<f64>,
    /// The Moon, km; error up to 0.1 deg (rms 0.02) and 600 km.
    pub moon_km: Vector3<f64>,
    /// Unit vector to the mean north pole of date; error up to 12 arcsec (nutation).
    pub pole: Vector3<f64>,
}

impl Bodies {
    /// At this time, TT, microseconds since J2000.0.
    pub fn at(time_us: i64) -> Self {
        let moon = moon_ecliptic(time_us);
        let (barycentre, _) = barycentre(time_us);
        // The barycentre lies towards the Moon, so the Earth is opposite.
        Self {
            sun_km: equatorial(moon * MOON_SHARE - barycentre),
            moon_km: equatorial(moon),
            pole: pole_vector(time_us),
        }
    }
}

fn pole_vector(time_us: i64) -> Vector3<f64> {
    let t = centuries(time_us);
    let x = (2_004.191_9 * t - 0.429_8 * t * t) * RAD_PER_ARCSEC;
    let y = -22.407_3 * t * t * RAD_PER_ARCSEC;
    Vector3::new(x, y, 1.0 - 0.5 * (x * x + y * y))
}

/// Direction to the Sun; error up to 0.01 deg (geometric: the seen Sun stands 20 arcsec back along the ecliptic).
pub fn sun_direction(time_us: i64) -> Direction<Icrs> {
    let (barycentre, _) = barycentre(time_us);
    // The Earth is never at the Sun, so the vector always has a direction.
    Direction::new((equatorial(-barycentre) / AU_KM).map(|x| x as f32)).unwrap_or(Direction::z())
}

/// Direction to the Earth's mean north pole of date; error up to 12 arcsec (nutation).
pub fn pole(time_us: i64) -> Direction<Icrs> {
    Direction::new(pole_vector(time_us).map(|x| x as f32)).unwrap_or(Direction::z())
}

/// Velocity of the Earth about the barycentre of the solar system, km/s, ICRS axes, for annual aberration; error up to
/// 0.03 km/s (0.02 arcsec).
pub fn earth_velocity_km_s(time_us: i64) -> Vector3<f64> {
    equatorial(barycentre(time_us).1)
}

#[cfg(test)]
mod tests;
