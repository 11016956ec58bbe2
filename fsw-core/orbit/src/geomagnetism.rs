//! The Earth's magnetic field.
//!
//! In: position, km, ICRS axes about the Earth's centre; instant. Out: flux density, microtesla, the same
//! axes. The main field to degree 8, of the middle of 2027. Against the whole model of degree 13, an axis:
//! 0.04 uT rms at 450 km, 0.02 at 800 km; the field of 2025 or 2030 is 0.09 uT rms off that of 2027.5, 0.29
//! at most. Currents outside the Earth add 0.02 uT on quiet days, 0.1 and more in a storm: they are left out.

use super::body::CentralBody;
use super::ephemeris::{equator_axes, rotation_rad};
use super::harmonics::{Harmonics, MAX_DEGREE};
use fsw_ground::trigonometry::sine_cosine;
use nalgebra::Vector3;

/// Reference radius of the model, km.
const RADIUS_KM: f32 = 6_371.2;

/// IGRF-14 (IAGA, doi 10.5281/zenodo.14012302) of 2027.5, uT: g and h times
/// `sqrt((2 - [m = 0]) (n - m)! / (n + m)!)`.
#[rustfmt::skip]
static COEFFICIENTS: [[f32; 2]; 44] = [
    // Order 0.
    [-29.318_5, 0.0],
    [-2.584_2, 0.0],
    [1.357_15, 0.0],
    [0.890_45, 0.0],
    [-0.231_4, 0.0],
    [0.063_8, 0.0],
    [0.079_35, 0.0],
    [0.022_85, 0.0],
    // Order 1.
    [-1.385_3, 4.491_75],
    [1.696_053, -1.848_589],
    [-0.986_001_25, -0.019_350_968],
    [0.251_037_42, 0.087_073_32],
    [0.096_114_54, 0.011_373_661],
    [0.013_758_638, -0.003_851_545_7],
    [-0.014_579_98, -0.008_957_758],
    [0.001_9, 0.001_075],
    // Order 2.
    [0.469_948_68, -0.243_050_02],
    [0.160_702_99, 0.030_609_48],
    [0.003_078_320_3, -0.009_223_781],
    [0.009_134_425, 0.010_991_074],
    [0.002_715_407_9, 4.416_419_5e-4],
    [-2.327_408_9e-4, -3.381_815e-4],
    [-3.486_083_6e-4, -2.310_775_3e-4],
    // Order 3.
    [0.021_840_798, -0.029_480_334],
    [-0.005_330_719_5, 0.004_302_823],
    [-0.001_364_054_6, -0.001_211_663],
    [-6.480_866e-4, 2.754_511_7e-4],
    [2.202_182_2e-4, -1.000_165_3e-5],
    [7.356_123_7e-6, 2.635_944_3e-5],
    // Order 4.
    [-3.521_476e-5, -0.002_716_114_5],
    [-3.196_326_4e-4, 1.106_917_3e-4],
    [-4.504_076_8e-5, -6.068_429_5e-5],
    [8.525_957e-6, 1.288_488_7e-5],
    [-6.980_085_3e-6, -2.754_047_3e-6],
    // Order 5.
    [1.737_198e-5, 8.236_843e-5],
    [3.559_051_5e-6, 2.831_572_4e-6],
    [4.569_109e-8, -8.818_380_5e-7],
    [7.748_099e-7, 5.026_387e-7],
    // Order 6.
    [-3.783_322_9e-6, 4.849_502_6e-6],
    [-2.365_640_6e-7, -4.274_282_6e-7],
    [1.026_215_2e-7, -5.418_958e-9],
    // Order 7.
    [7.926_999_5e-8, -1.412_969_65e-8],
    [-2.077_66e-8, -5.503_325_4e-9],
    // Order 8.
    [5.410_573e-10, 1.360_372_6e-9],
];

/// Flux density at a place outside the Earth, uT; `pole` is its north pole of date.
#[inline(never)]
pub fn flux_density_ut(position_km: &Vector3<f64>, pole: &Vector3<f64>, time_us: i64) -> Vector3<f32> {
    let to_equator = equator_axes(pole);
    let (sine, cosine) = sine_cosine(rotation_rad(CentralBody::Earth, time_us));
    let r = to_equator * position_km.map(|axis| axis as f32);
    let field = Harmonics { radius_km: RADIUS_KM, first: 1, coefficients: &COEFFICIENTS };
    // B = -∇V, V = R²/r Σ (R/r)^n ...
    let scale = -RADIUS_KM * RADIUS_KM;
    to_equator.tr_mul(&field.turned_gradient(scale, (&r, [sine, cosine]), MAX_DEGREE, MAX_DEGREE))
}

#[cfg(test)]
mod tests;
