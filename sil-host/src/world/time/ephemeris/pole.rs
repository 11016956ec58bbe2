//! Where the Earth's pole and equinox are: bias, precession and nutation.
//!
//! In: TT, centuries since J2000.0. Out: rotation from GCRF to the true equator and equinox of date, the CIO
//! locator s. Precession and frame bias IAU 2006 in the four angles of Fukushima and Williams (Hilton et al.
//! 2006), nutation IAU 2000B (McCarthy and Luzum 2003, 77 terms), s by the largest terms of its series (IERS
//! Conventions 2010, table 5.2d; what is left out stays below 10 µas to 2060). Nutation 2000B is within 1 mas
//! of 2000A from 1995 to 2050.

use super::harmonics::{multiples, phase};
use super::nutation_terms::TERMS;
use super::{ARCSEC, polynomial};
use crate::world::attitude::{Vector, rotation};
use crate::world::vector::product;

/// Fixed offsets of longitude and obliquity in place of the planetary terms, arcsec.
const PLANETARY: (f64, f64) = (-0.135e-3, 0.388e-3);

/// Bias and precession: the angles gamma, phi, psi and the mean obliquity, rad.
pub(super) fn fukushima_williams(t: f64) -> [f64; 4] {
    [
        polynomial(t, &[-0.052_928, 10.556_378, 0.493_204_4, -0.000_312_38, -0.000_002_788, 2.6e-8]),
        polynomial(t, &[84_381.412_819, -46.811_016, 0.051_126_8, 0.000_532_89, -4.4e-7, -1.76e-8]),
        polynomial(t, &[-0.041_775, 5_038.481_484, 1.558_417_5, -0.000_185_22, -0.000_026_452, -1.48e-8]),
        polynomial(t, &[84_381.406, -46.836_769, -0.000_183_1, 0.002_003_4, -5.76e-7, -4.34e-8]),
    ]
    .map(|arcsec| arcsec * ARCSEC)
}

/// Delaunay's arguments l, l', F, D and the Moon's node, rad (Simon et al. 1994, linear as the series asks).
fn arguments(t: f64) -> [f64; 5] {
    [
        485_868.249_036 + 1_717_915_923.217_8 * t,
        1_287_104.793_05 + 129_596_581.048_1 * t,
        335_779.526_232 + 1_739_527_262.847_8 * t,
        1_072_260.703_69 + 1_602_961_601.209 * t,
        450_160.398_036 - 6_962_890.543_1 * t,
    ]
    .map(|arcsec| libm::fmod(arcsec, 1_296_000.0) * ARCSEC)
}

/// Nutation in longitude and obliquity, rad.
pub(super) fn nutation(t: f64) -> (f64, f64) {
    let angles = arguments(t).map(multiples::<5>);
    let (mut longitude, mut obliquity) = (0.0, 0.0);
    // The small terms first, so that they are not lost in the sum.
    for (k, [sine_0, sine_1, cosine_0, cosine_o, cosine_1, sine_o]) in TERMS.iter().rev() {
        let (cosine, sine) = phase(&angles, k);
        longitude += (sine_0 + sine_1 * t) * sine + cosine_0 * cosine;
        obliquity += (cosine_o + cosine_1 * t) * cosine + sine_o * sine;
    }
    ((longitude * 1e-7 + PLANETARY.0) * ARCSEC, (obliquity * 1e-7 + PLANETARY.1) * ARCSEC)
}

/// GCRF to the true equator and equinox of date; the third row is the celestial intermediate pole.
pub(super) fn gcrf_to_true(t: f64) -> [Vector; 3] {
    let [gamma, phi, psi, obliquity] = fukushima_williams(t);
    let (longitude, tilt) = nutation(t);
    let ecliptic = product(&rotation(0, phi), &rotation(2, gamma));
    let turned = product(&rotation(2, -psi - longitude), &ecliptic);
    product(&rotation(0, -obliquity - tilt), &turned)
}

/// The CIO locator s of a pole with the components `x`, `y`, rad.
pub(super) fn cio_locator(t: f64, [x, y, _]: Vector) -> f64 {
    let [_, _, f, d, node] = arguments(t);
    let sine = libm::sin;
    let periodic = -2640.73 * sine(node)
        - 63.53 * sine(2.0 * node)
        - 11.75 * sine(2.0 * (f - d) + 3.0 * node)
        - 11.21 * sine(2.0 * (f - d) + node)
        + 4.57 * sine(2.0 * (f - d + node))
        + t * t * (743.52 * sine(node) + 56.91 * sine(2.0 * (f - d + node)));
    let micro_arcsec = polynomial(t, &[94.0, 3808.65, -122.68, -72_574.11, 27.98, 15.62]) + periodic;
    micro_arcsec * 1e-6 * ARCSEC - 0.5 * x * y
}
