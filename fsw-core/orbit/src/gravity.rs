//! The bodies' fields of gravity but for the point mass and J2, which [`super::dynamics`] computes in f64.
//!
//! In: the body, position in axes that turn with it, km; degree and order. Out: acceleration along the same
//! axes, km/s². Pines' formulation (*AIAA Journal* 11, 1973, 1508-1511), which has no singular point: with
//! `s, t, u` the direction's components, `A(n, m)` the derivatives of the Legendre polynomials of `u`, and
//! `c(m) + i s(m) = (s + i t)^m`, the potential is `mu/r Σ (R/r)^n A(n, m) (C c(m) + S s(m))`. One column
//! of `A` (one order) is made from the next lower degrees and used with the column of the next order, so
//! that two columns are all that is held.
//!
//! In f32, rounding 1e-6 of the sum: 3e-7 m/s² x 1e-6 in a low orbit, less than a millimetre a day. Cost on
//! the target: degrees 3 to 8 with the Sun's light add 1,700 cycles to a call at degree 2.

use super::body::CentralBody;
use nalgebra::Vector3;

/// Highest degree and order in the table.
pub const MAX_DEGREE: u8 = 8;
/// The same as an index.
const MOST: usize = MAX_DEGREE as usize;
/// C and S order by order, of each the degrees from 2 or the order to [`MAX_DEGREE`], not normalised: the
/// published ones times `sqrt((2 - [m = 0]) (2 n + 1) (n - m)! / (n + m)!)`. The first, C of degree 2 and
/// order 0, is not here: [`super::body::BodyFacts::j2`].
type Coefficients = [[f32; 2]; 42];
/// Of each order, degrees up to one more than the field's.
type Column = [f32; MOST + 2];

/// A body's field.
struct Field {
    /// Radius of the model, km.
    radius_km: f32,
    coefficients: &'static Coefficients,
}

const fn field(body: CentralBody) -> Field {
    match body {
        CentralBody::Earth => Field { radius_km: 6_378.136, coefficients: &EARTH },
        CentralBody::Moon => Field { radius_km: 1_738.0, coefficients: &MOON },
        CentralBody::Mars => Field { radius_km: 3_394.2, coefficients: &MARS },
    }
}

/// EGM2008 (Pavlis, Holmes, Kenyon and Factor 2012, J. Geophys. Res. 117, B04406).
#[rustfmt::skip]
static EARTH: Coefficients = [
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

/// LP165P (Konopliv, Asmar, Carranza, Sjogren and Yuan 2001, Icarus 150, 1).
#[rustfmt::skip]
static MOON: Coefficients = [
    // Order 0.
    [0.0, 0.0],
    [-8.475_906e-6, 0.0],
    [9.591_929e-6, 0.0],
    [-7.154_086_5e-7, 0.0],
    [1.357_771_5e-5, 0.0],
    [2.177_473_3e-5, 0.0],
    [9.674_866e-6, 0.0],
    // Order 1.
    [-3.514_128_8e-9, -9.779_519e-10],
    [2.843_688_5e-5, 5.902_187e-6],
    [-5.688_876e-6, 1.576_649_5e-6],
    [-8.727_87e-7, -3.518_955e-6],
    [1.205_358_9e-6, -2.027_258_5e-6],
    [5.527_688e-6, -9.489_571e-8],
    [-4.184_252_2e-8, 7.645_233_5e-7],
    // Order 2.
    [2.235_711_9e-5, 1.079_884e-8],
    [4.846_185_7e-6, 1.670_948_6e-6],
    [-1.583_540_2e-6, -1.516_865_2e-6],
    [7.082_871_3e-7, 1.754_449_8e-7],
    [-5.414_304_4e-7, -2.721_258_2e-7],
    [-6.605_579e-8, 2.375_306_8e-7],
    [2.459_737_8e-7, 1.581_767_7e-7],
    // Order 3.
    [1.713_209_1e-6, -2.489_688_3e-7],
    [-8.141_29e-8, -8.034_011e-7],
    [1.485_809_4e-8, 2.874_268_4e-7],
    [-6.780_089e-8, -7.192_883e-8],
    [8.207_558e-9, 3.318_318e-8],
    [-1.900_697e-8, 9.640_743e-9],
    // Order 4.
    [-1.273_178e-7, 8.324_002_5e-8],
    [2.167_251e-8, 4.624_115_8e-10],
    [1.399_800_5e-9, -1.540_237_3e-8],
    [-1.967_719e-9, 1.680_930_4e-9],
    [4.403_113e-9, -5.952_443_5e-10],
    // Order 5.
    [7.681_257e-9, -6.798_152_7e-9],
    [1.133_503_1e-9, -8.338_361e-9],
    [-9.624_822e-11, 3.988_265e-10],
    [-2.036_726_5e-10, 5.295_499_6e-10],
    // Order 6.
    [-1.096_007e-9, 1.685_843_6e-9],
    [-6.891_595e-11, 7.690_286_6e-11],
    [-4.310_236e-11, -6.278_88e-11],
    // Order 7.
    [-3.317_700_3e-11, -2.998_707_2e-11],
    [-8.114_968e-12, 1.642_961_6e-11],
    // Order 8.
    [-3.226_040_7e-12, 2.728_784_4e-12],
];

/// Mars50c (Konopliv and Sjogren 1995, JPL Publication 95-5).
#[rustfmt::skip]
static MARS: Coefficients = [
    // Order 0.
    [0.0, 0.0],
    [-3.157_457_5e-5, 0.0],
    [1.545_157_5e-5, 0.0],
    [-6.049_619_5e-6, 0.0],
    [5.252_061e-6, 0.0],
    [3.253_804_8e-6, 0.0],
    [2.054_609_7e-6, 0.0],
    // Order 1.
    [1.704_544_8e-8, 8.717_896e-10],
    [4.175_408_3e-6, 2.730_274e-5],
    [4.021_665_5e-6, 3.555_243_7e-6],
    [4.138_903e-7, 1.795_859e-6],
    [1.489_342_6e-6, -1.279_14e-6],
    [8.372_685_4e-7, -8.887_379e-8],
    [1.393_994_8e-7, 4.302_811_8e-7],
    // Order 2.
    [-5.442_329_3e-5, 3.206_735_3e-5],
    [-5.439_693e-6, 2.891_987_6e-6],
    [-2.496_498_7e-7, -2.004_275_3e-6],
    [-6.877_180_6e-7, -1.982_166_4e-7],
    [1.185_416_7e-7, 2.005_969e-7],
    [2.788_006_8e-7, -7.290_058e-8],
    [1.369_670_2e-7, 5.413_701e-8],
    // Order 3.
    [4.938_264e-6, 3.513_925e-6],
    [3.892_971_6e-7, -1.627_617e-8],
    [1.091_173_9e-7, 8.397_049e-9],
    [1.972_443e-8, 5.060_117_7e-9],
    [1.183_764_8e-8, -5.968_525e-9],
    [-1.099_084_9e-8, -1.341_900_8e-8],
    // Order 4.
    [2.387_623_9e-9, -2.724_648_3e-7],
    [-3.649_884e-8, -2.589_655_2e-8],
    [3.917_849_6e-9, 1.003_851_9e-8],
    [5.092_639e-9, -1.116_942_1e-9],
    [2.122_919_8e-9, 5.422_188e-11],
    // Order 5.
    [-1.088_753_1e-8, 9.445_274e-9],
    [1.437_991e-9, 1.314_686_6e-9],
    [-1.092_811_2e-10, -4.723_943_5e-10],
    [-5.059_89e-10, -2.943_568e-10],
    // Order 6.
    [6.489_181_4e-10, 1.829_698_2e-10],
    [-3.972_333_6e-11, -1.343_961e-10],
    [-2.812_207e-11, -4.936_154e-11],
    // Order 7.
    [7.776_358e-12, -3.285_713_7e-11],
    [-2.517_449_4e-12, 8.444_957e-12],
    // Order 8.
    [-3.901_650_6e-13, -3.363_740_2e-13],
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
pub(super) fn acceleration(body: CentralBody, r: &Vector3<f32>, degree: u8, order: u8) -> Vector3<f32> {
    let Field { radius_km, coefficients } = field(body);
    let inverse = 1.0 / libm::sqrtf(r.dot(r));
    let [s, t, u] = [r.x * inverse, r.y * inverse, r.z * inverse];
    let mut powers = [0.0; MOST + 2];
    let mut power = body.facts().mu_km3_s2 as f32 * inverse * inverse;
    for place in &mut powers {
        *place = power;
        power *= radius_km * inverse;
    }
    let mut coefficients = coefficients.iter();
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
