//! The Moon's place.
//!
//! In: TT, centuries since J2000.0. Out: geometric position from the Earth's centre, km, GCRF axes.
//! Longitude, latitude and distance by the 60 + 60 terms of Meeus (Astronomical Algorithms, ch. 47; ELP
//! 2000-82 shortened), mean longitude of Simon et al. (1994) as in SOFA's `moon98`; from the mean ecliptic of
//! date by the precession angles.

use super::harmonics::{multiples, phase};
use super::moon_terms::{LATITUDE, LONGITUDE};
use super::{pole, polynomial};
use crate::world::attitude::{Vector, apply, rotation};
use crate::world::vector::{product, times};

/// The Moon from the Earth's centre, km.
pub(super) fn from_earth_km(t: f64) -> Vector {
    let mean_longitude = polynomial(t, &[218.316_654_36, 481_267.881_234_21, -0.001_578_6, 1.0 / 538_841.0]);
    let [d, m, anomaly, f] = [
        polynomial(t, &[297.850_192_1, 445_267.111_403_4, -0.001_881_9, 1.0 / 545_868.0]),
        polynomial(t, &[357.529_109_2, 35_999.050_290_9, -0.000_153_6]),
        polynomial(t, &[134.963_396_4, 477_198.867_505_5, 0.008_741_4, 1.0 / 69_699.0]),
        polynomial(t, &[93.272_095_0, 483_202.017_523_3, -0.003_653_9, 1.0 / 3_526_000.0]),
    ];
    let angles = [d, m, anomaly, f].map(|degrees| multiples::<5>(degrees.to_radians()));
    // The Earth's orbit grows rounder, and with it every term of its anomaly.
    let rounder = 1.0 - t * (0.002_516 + 0.000_007_4 * t);
    let weight = [1.0, rounder, rounder * rounder];
    let sine = |degrees: f64| libm::sin(degrees.to_radians());
    let (venus, jupiter) = (119.75 + 131.849 * t, 53.09 + 479_264.290 * t);
    let mut longitude = 3958.0 * sine(venus) + 1962.0 * sine(mean_longitude - f) + 318.0 * sine(jupiter);
    let mut latitude = -2235.0 * sine(mean_longitude)
        + 382.0 * sine(313.45 + 481_266.484 * t)
        + 175.0 * (sine(venus - f) + sine(venus + f))
        + 127.0 * sine(mean_longitude - anomaly)
        - 115.0 * sine(mean_longitude + anomaly);
    let mut distance_m = 0.0;
    for (k, along, away) in LONGITUDE.iter().rev() {
        let (cosine, sine) = phase(&angles, k);
        let weight = weight[usize::from(k[1].unsigned_abs())];
        longitude += weight * along * sine;
        distance_m += weight * away * cosine;
    }
    for (k, up) in LATITUDE.iter().rev() {
        latitude += weight[usize::from(k[1].unsigned_abs())] * up * phase(&angles, k).1;
    }
    let (sin_l, cos_l) = libm::sincos((mean_longitude + 1e-6 * longitude).to_radians());
    let (sin_b, cos_b) = libm::sincos((1e-6 * latitude).to_radians());
    let of_date = times(385_000.56 + 1e-3 * distance_m, [cos_b * cos_l, cos_b * sin_l, sin_b]);
    let [gamma, phi, psi, _] = pole::fukushima_williams(t);
    let to_gcrf = product(&product(&rotation(2, -gamma), &rotation(0, -phi)), &rotation(2, psi));
    apply(&to_gcrf, of_date)
}
