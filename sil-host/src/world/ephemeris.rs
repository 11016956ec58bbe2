//! Sun, Moon, the Earth's motion, pole and rotation.
//!
//! In: TT, µs since J2000.0. Out: geocentric positions in km and velocities in km/s, ICRS axes; the rotation from ICRS to
//! the true equator of date. Sun: Kepler's ellipse with the mean elements of date and the larger perturbations by Venus,
//! Jupiter and the Moon (Meeus, Astronomical Algorithms, ch. 25, and his older Formulae, ch. 18), precessed back to J2000.
//! Moon: the 27 + 13 largest terms of ELP 2000-82 (Meeus ch. 47). Precession IAU 2006 (Capitaine et al. 2003), the
//! four largest terms of nutation, sidereal time IAU 1982 with TT - UT1 held at [`TT_MINUS_UT1_S`].
//!
//! Greatest errors at 16 dates from 2000 to 2050 against SOFA's routines: Sun 12 arcsec and 7000 km, Moon 0.016 deg and
//! 31 km, the Earth's velocity 3 m/s, pole 0.11 arcsec, sidereal angle 0.3 arcsec. Cost: a Sun 12 sines, a Moon 42.

use super::attitude::{Vector, apply};
use super::pointing::rotation;
use super::vector::{minus, product, times, transposed};

/// Astronomical unit, km.
pub const AU_KM: f64 = 149_597_870.7;
/// Speed of light, km/s.
pub const LIGHT_KM_S: f64 = 299_792.458;
/// Difference of the clocks, s: 37 + 32.184 of 2017 and after, UT1 - UTC being held at zero (below 0.4 s since).
pub const TT_MINUS_UT1_S: f64 = 69.184;
/// The Earth's rate of rotation, rad/s.
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

const DAY_US: f64 = 86_400e6;
const CENTURY_DAYS: f64 = 36_525.0;
const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;
/// Half the time over which the Earth's velocity is a difference of positions, s.
const VELOCITY_STEP_S: i64 = 3600;

/// Julian centuries since J2000.0.
fn centuries(time_us: i64) -> f64 {
    time_us as f64 / DAY_US / CENTURY_DAYS
}

/// The Julian year of a time, for proper motions.
pub fn julian_year(time_us: i64) -> f64 {
    2000.0 + 100.0 * centuries(time_us)
}

fn sine(degrees: f64) -> f64 {
    libm::sin(degrees.to_radians())
}

fn cosine(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

/// Mean obliquity of the ecliptic, rad.
fn obliquity(t: f64) -> f64 {
    (84_381.406 - 46.836_769 * t - 0.000_183_1 * t * t) * ARCSEC
}

/// ICRS to the mean equator and equinox of date; the frame bias (0.02 arcsec) is left out.
fn precession(t: f64) -> [Vector; 3] {
    let zeta = 2.650_545 + t * (2_306.083_227 + t * (0.298_849_9 + t * 0.018_018_28));
    let z = -2.650_545 + t * (2_306.077_181 + t * (1.092_734_8 + t * 0.018_268_37));
    let theta = t * (2_004.191_903 + t * (-0.429_493_4 - t * 0.041_822_64));
    let turn = |axis, arcsec: f64| rotation(axis, arcsec * ARCSEC);
    product(&turn(2, -z), &product(&turn(1, theta), &turn(2, -zeta)))
}

/// Nutation in longitude and obliquity, rad.
fn nutation(t: f64) -> (f64, f64) {
    let node = 125.045 - 1934.136 * t;
    let (sun, moon) = (280.466 + 36_000.770 * t, 218.317 + 481_267.881 * t);
    let longitude =
        -17.20 * sine(node) - 1.32 * sine(2.0 * sun) - 0.23 * sine(2.0 * moon) + 0.21 * sine(2.0 * node);
    let obliquity = 9.20 * cosine(node) + 0.57 * cosine(2.0 * sun) + 0.10 * cosine(2.0 * moon)
        - 0.09 * cosine(2.0 * node);
    (longitude * ARCSEC, obliquity * ARCSEC)
}

/// ICRS to the true equator and equinox of date; the third row is the Earth's pole.
pub fn icrs_to_equator(time_us: i64) -> [Vector; 3] {
    let t = centuries(time_us);
    let (longitude, tilt) = nutation(t);
    let mean = obliquity(t);
    let nutated = product(&rotation(2, -longitude), &rotation(0, mean));
    product(&rotation(0, -mean - tilt), &product(&nutated, &precession(t)))
}

/// Angle from the equinox of date to Greenwich, rad, 0 to 2 pi.
pub fn sidereal_angle(time_us: i64) -> f64 {
    let t = centuries(time_us);
    let (longitude, _) = nutation(t);
    // The fraction of the day is taken from whole microseconds, so that centuries cost no digits.
    let ut_us = time_us - (TT_MINUS_UT1_S * 1e6) as i64;
    let t_ut = centuries(ut_us);
    let day = ut_us.rem_euclid(DAY_US as i64) as f64 / DAY_US;
    let days = ut_us.div_euclid(DAY_US as i64) as f64;
    let mean_deg =
        280.460_618_37 + 360.0 * day + 0.985_647_366_29 * (days + day) + 0.000_387_933 * t_ut * t_ut;
    let angle = mean_deg.to_radians() + longitude * libm::cos(obliquity(t));
    libm::fmod(libm::fmod(angle, std::f64::consts::TAU) + std::f64::consts::TAU, std::f64::consts::TAU)
}

/// From ecliptic longitude, latitude (degrees) and distance of date to ICRS.
fn from_ecliptic_of_date(t: f64, longitude_deg: f64, latitude_deg: f64, distance: f64) -> Vector {
    let (sin_l, cos_l) = libm::sincos(longitude_deg.to_radians());
    let (sin_b, cos_b) = libm::sincos(latitude_deg.to_radians());
    let ecliptic = [cos_b * cos_l, cos_b * sin_l, sin_b];
    let of_date = apply(&rotation(0, -obliquity(t)), ecliptic);
    times(distance, apply(&transposed(&precession(t)), of_date))
}

/// Geometric position of the Sun from the Earth's centre, km.
pub fn sun_km(time_us: i64) -> Vector {
    let t = centuries(time_us);
    let anomaly = 357.529_11 + t * (35_999.050_29 - 0.000_153_7 * t);
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + 0.000_303_2 * t);
    let eccentricity = 0.016_708_634 - t * (0.000_042_037 + 0.000_000_126_7 * t);
    let centre = (1.914_602 - t * (0.004_817 + 0.000_014 * t)) * sine(anomaly)
        + (0.019_993 - 0.000_101 * t) * sine(2.0 * anomaly)
        + 0.000_289 * sine(3.0 * anomaly);
    // Perturbations: their arguments count from 1900.
    let u = t + 1.0;
    let (venus, venus_2) = (153.23 + 22_518.754_1 * u, 216.57 + 45_037.508_2 * u);
    let (jupiter, moon) = (312.69 + 32_964.357_7 * u, 350.74 + 445_267.114_2 * u);
    let slow = 231.19 + 20.20 * u;
    let perturbed = 0.001_34 * cosine(venus)
        + 0.001_54 * cosine(venus_2)
        + 0.002_00 * cosine(jupiter)
        + 0.001_79 * sine(moon)
        + 0.001_78 * sine(slow);
    let longitude = mean_longitude + centre + perturbed;
    let distance = 1.000_001_018 * (1.0 - eccentricity * eccentricity)
        / (1.0 + eccentricity * cosine(anomaly + centre))
        + 0.000_030_76 * cosine(moon);
    from_ecliptic_of_date(t, longitude, 0.0, distance * AU_KM)
}

/// The Earth's velocity about the Sun, km/s. The Sun's own about the centre of mass (below 0.016 km/s, 0.011 arcsec of
/// aberration) is left out.
pub fn earth_velocity_km_s(time_us: i64) -> Vector {
    let step_us = VELOCITY_STEP_S * 1_000_000;
    let difference = minus(sun_km(time_us - step_us), sun_km(time_us + step_us));
    times(0.5 / VELOCITY_STEP_S as f64, difference)
}

/// Terms of the Moon's longitude (1e-6 deg) and distance (m): multiples of D, M, M', F.
const MOON_LONGITUDE: [([f64; 4], f64, f64); 27] = [
    ([0., 0., 1., 0.], 6_288_774., -20_905_355.),
    ([2., 0., -1., 0.], 1_274_027., -3_699_111.),
    ([2., 0., 0., 0.], 658_314., -2_955_968.),
    ([0., 0., 2., 0.], 213_618., -569_925.),
    ([0., 1., 0., 0.], -185_116., 48_888.),
    ([0., 0., 0., 2.], -114_332., -3_149.),
    ([2., 0., -2., 0.], 58_793., 246_158.),
    ([2., -1., -1., 0.], 57_066., -152_138.),
    ([2., 0., 1., 0.], 53_322., -170_733.),
    ([2., -1., 0., 0.], 45_758., -204_586.),
    ([0., 1., -1., 0.], -40_923., -129_620.),
    ([1., 0., 0., 0.], -34_720., 108_743.),
    ([0., 1., 1., 0.], -30_383., 104_755.),
    ([2., 0., 0., -2.], 15_327., 10_321.),
    ([0., 0., 1., 2.], -12_528., 0.),
    ([0., 0., 1., -2.], 10_980., 79_661.),
    ([4., 0., -1., 0.], 10_675., -34_782.),
    ([0., 0., 3., 0.], 10_034., -23_210.),
    ([4., 0., -2., 0.], 8_548., -21_636.),
    ([2., 1., -1., 0.], -7_888., 24_208.),
    ([2., 1., 0., 0.], -6_766., 30_824.),
    ([1., 0., -1., 0.], -5_163., -8_379.),
    ([1., 1., 0., 0.], 4_987., -16_675.),
    ([2., -1., 1., 0.], 4_036., -12_831.),
    ([2., 0., 2., 0.], 3_994., -10_445.),
    ([4., 0., 0., 0.], 3_861., -11_650.),
    ([2., 0., -3., 0.], 3_665., 14_403.),
];

/// Terms of the Moon's latitude (1e-6 deg): multiples of D, M, M', F.
const MOON_LATITUDE: [([f64; 4], f64); 13] = [
    ([0., 0., 0., 1.], 5_128_122.),
    ([0., 0., 1., 1.], 280_602.),
    ([0., 0., 1., -1.], 277_693.),
    ([2., 0., 0., -1.], 173_237.),
    ([2., 0., -1., 1.], 55_413.),
    ([2., 0., -1., -1.], 46_271.),
    ([2., 0., 0., 1.], 32_573.),
    ([0., 0., 2., 1.], 17_198.),
    ([2., 0., 1., -1.], 9_266.),
    ([0., 0., 2., -1.], 8_822.),
    ([2., -1., 0., -1.], 8_216.),
    ([2., 0., -2., -1.], 4_324.),
    ([2., 0., 1., 1.], 4_200.),
];

/// Geometric position of the Moon from the Earth's centre, km.
pub fn moon_km(time_us: i64) -> Vector {
    let t = centuries(time_us);
    let arguments = [
        297.850_192_1 + t * (445_267.111_403_4 - 0.001_881_9 * t),
        357.529_109_2 + t * (35_999.050_290_9 - 0.000_153_6 * t),
        134.963_396_4 + t * (477_198.867_505_5 + 0.008_741_4 * t),
        93.272_095_0 + t * (483_202.017_523_3 - 0.003_653_9 * t),
    ];
    let argument = |multiples: &[f64; 4]| (0..4).map(|k| multiples[k] * arguments[k]).sum::<f64>();
    // The Earth's orbit grows rounder, and with it every term of its anomaly.
    let rounder = 1.0 - t * (0.002_516 + 0.000_007_4 * t);
    let weight = |multiples: &[f64; 4]| if multiples[1] == 0.0 { 1.0 } else { rounder };
    let (mut longitude, mut distance_m, mut latitude) = (0.0, 0.0, 0.0);
    for (multiples, along, away) in &MOON_LONGITUDE {
        let (sine, cosine) = libm::sincos(argument(multiples).to_radians());
        longitude += weight(multiples) * along * sine;
        distance_m += weight(multiples) * away * cosine;
    }
    for (multiples, up) in &MOON_LATITUDE {
        latitude += weight(multiples) * up * sine(argument(multiples));
    }
    let mean_longitude = 218.316_447_7 + t * (481_267.881_234_21 - 0.001_578_6 * t);
    let distance_km = 385_000.56 + 1e-3 * distance_m;
    from_ecliptic_of_date(t, mean_longitude + 1e-6 * longitude, 1e-6 * latitude, distance_km)
}

#[cfg(test)]
#[path = "ephemeris_tests.rs"]
mod tests;
