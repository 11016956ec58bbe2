//! The Earth's field of gravity but for the point mass and J2, which [`super::dynamics`] computes in f64.
//!
//! In: position in axes that turn with the Earth, km; degree and order. Out: acceleration along the same
//! axes, km/s². Pines' formulation (*AIAA Journal* 11, 1973, 1508-1511), which has no singular point: with
//! `s, t, u` the direction's components, `A(n, m)` the derivatives of the Legendre polynomials of `u`, and
//! `c(m) + i s(m) = (s + i t)^m`, the potential is `mu/r Σ (R/r)^n A(n, m) (C c(m) + S s(m))`. One column
//! of `A` (one order) is made from the next lower degrees and used with the column of the next order, so
//! that two columns are all that is held.
//!
//! In f32, rounding 1e-6 of the sum: 3e-7 m/s² x 1e-6 in a low orbit, less than a millimetre a day. Cost on
//! the target: degrees 3 to 8 with the Sun's light add 1,700 cycles to a call at degree 2.

use super::constants::MU_EARTH_KM3_S2;
use nalgebra::Vector3;

/// Highest degree and order in the table.
pub const MAX_DEGREE: u8 = 8;
/// The same as an index.
const MOST: usize = MAX_DEGREE as usize;
/// Radius of the model, km.
const RADIUS_KM: f32 = 6_378.136;
const MU_KM3_S2: f32 = MU_EARTH_KM3_S2 as f32;
/// Of each order, degrees up to one more than the field's.
type Column = [f32; MOST + 2];

/// Coefficients C and S of EGM2008 (Pavlis, Holmes, Kenyon and Factor 2012, J. Geophys. Res. 117, B04406),
/// not normalised: the published ones times `sqrt((2 - [m = 0]) (2 n + 1) (n - m)! / (n + m)!)`. Order by
/// order, of each the degrees from 2 or the order to [`MAX_DEGREE`]. The first, C of degree 2 and order 0,
/// is not here: [`super::constants::J2`].
#[rustfmt::skip]
const FIELD: [[f32; 2]; 42] = [
    // Order 0.
    [0.0, 0.0],
    [2.532_410_5e-6, 0.0],
    [1.619_897_6e-6, 0.0],
    [2.277_535_9e-7, 0.0],
    [-5.406_666e-7, 0.0],
    [3.505_518e-7, 0.0],
    [2.039_931_2e-7, 0.0],
    // Order 1.
    [-2.667_395e-10, 1.787_270_6e-9],
    [2.193_149_6e-6, 2.680_871e-7],
    [-5.086_435_5e-7, -4.492_654_3e-7],
    [-5.388_249e-8, -8.081_347e-8],
    [-5.973_433e-8, 2.085_973_3e-8],
    [2.055_886_3e-7, 6.962_506e-8],
    [1.591_573_6e-8, 4.047_340_2e-8],
    // Order 2.
    [1.574_615_3e-6, -9.038_728e-7],
    [3.090_439e-7, -2.114_306_2e-7],
    [7.837_455e-8, 1.481_350_4e-7],
    [1.055_288_7e-7, -5.232_977_4e-8],
    [6.052_084_6e-9, -4.650_064e-8],
    [3.290_942_3e-8, 9.262_716e-9],
    [6.571_918e-9, 5.361_764e-9],
    // Order 3.
    [1.005_835_1e-7, 1.972_215_8e-7],
    [5.921_502e-8, -1.200_946_1e-8],
    [-1.492_648_8e-8, -7.100_917e-9],
    [1.186_914_9e-9, 1.856_100_1e-10],
    [3.527_933_3e-9, -3.058_307_4e-9],
    [-1.958_770_6e-10, -8.690_975e-10],
    // Order 4.
    [-3.983_204e-9, 6.524_673e-9],
    [-2.299_511_5e-9, 3.878_115e-10],
    [-3.256_407_4e-10, -1.784_568_8e-9],
    [-5.839_579e-10, -2.634_417_4e-10],
    [-3.189_389_6e-10, 9.111_232_6e-11],
    // Order 5.
    [4.304_280_3e-10, -1.648_171_9e-9],
    [-2.156_208_3e-10, -4.329_851_5e-10],
    [5.831_682e-13, 6.345_170_5e-12],
    [-4.651_868_7e-12, 1.614_569_6e-11],
    // Order 6.
    [2.206_478_5e-12, -5.530_528_5e-11],
    [-2.490_410_8e-11, 1.053_627_9e-11],
    [-1.842_311e-12, 8.628_472e-12],
    // Order 7.
    [2.796_427_8e-14, 4.471_954_8e-13],
    [3.429_469_7e-13, 3.817_591e-13],
    // Order 8.
    [-1.580_997_2e-13, 1.536_751_5e-13],
];

/// Derivatives of order `order` of the Legendre polynomials at `sine`; the first, `sectorial`, is
/// `(2 m - 1)!!`.
fn column(order: usize, sectorial: f32, sine: f32) -> Column {
    let mut column = [0.0; MOST + 2];
    let (mut last, mut before) = (sectorial, 0.0);
    for (degree, place) in column.iter_mut().enumerate().skip(order) {
        if degree > order {
            let (n, m) = (degree as f32, order as f32);
            (last, before) = (((2.0 * n - 1.0) * sine * last - (n + m - 1.0) * before) / (n - m), last);
        }
        *place = last;
    }
    column
}

fn at(column: &Column, degree: usize) -> f32 {
    column.get(degree).copied().unwrap_or(0.0)
}

/// Acceleration at `r` by the terms up to `degree` and `order`, without point mass and J2.
#[inline(never)]
pub(super) fn acceleration(r: &Vector3<f32>, degree: u8, order: u8) -> Vector3<f32> {
    let inverse = 1.0 / libm::sqrtf(r.dot(r));
    let [s, t, u] = [r.x * inverse, r.y * inverse, r.z * inverse];
    let mut powers = [0.0; MOST + 2];
    let mut power = MU_KM3_S2 * inverse * inverse;
    for place in &mut powers {
        *place = power;
        power *= RADIUS_KM * inverse;
    }
    let mut coefficients = FIELD.iter();
    let (mut this, mut sectorial) = (column(0, 1.0, u), 1.0);
    // Cosine and sine of the order's multiple of the longitude, times a power of the latitude's cosine; and
    // those of the order before.
    let ([mut cosine, mut sine], [mut cosine_before, mut sine_before]) = ([1.0, 0.0], [0.0, 0.0]);
    let (mut sum, mut radial) = (Vector3::zeros(), 0.0);
    for m in 0..=MOST {
        sectorial *= (2 * m + 1) as f32;
        let next = column(m + 1, sectorial, u);
        for (n, [c, s]) in (m.max(2)..=MOST).zip(&mut coefficients) {
            if n > usize::from(degree) || m > usize::from(order) {
                continue;
            }
            let power = at(&powers, n);
            let here = c * cosine + s * sine;
            let across = power * m as f32 * at(&this, n);
            sum.x += across * (c * cosine_before + s * sine_before);
            sum.y += across * (s * cosine_before - c * sine_before);
            sum.z += power * at(&next, n) * here;
            radial -= power * at(&next, n + 1) * here;
        }
        [cosine_before, sine_before] = [cosine, sine];
        [cosine, sine] = [s * cosine - t * sine, s * sine + t * cosine];
        this = next;
    }
    sum + Vector3::new(s, t, u) * radial
}
