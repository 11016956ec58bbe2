//! Sine and cosine of angles up to 100 rad, f32 and f64, and a hypotenuse, f32.
//!
//! The angle less the nearest multiple of a right angle, which is subtracted in two parts so that no digit is
//! lost; sine and cosine of the rest, at most 45 degrees, by the polynomials of FDLIBM (`k_sinf`, `k_cosf`,
//! `k_sin`, `k_cos`); the quadrant exchanges them and their signs. `libm`'s functions also reduce angles up
//! to 1e308, by tables of 4.4 KB that no angle here needs, and its f32 functions compute in f64.
//!
//! | | greatest error over -100 to 100 rad | cycles on the target, sine and cosine together |
//! |---|---|---|
//! | f32 | 1.2e-7 | about 120 (libm: 1,900 to 3,300 each) |
//! | f64 | 2.3e-16 | about 5,000 (30 operations in software) |
//!
//! Beyond 100 rad the reduction loses digits; of an angle that is not finite neither is finite.

use crate::matrix::Real;

/// A right angle in two parts, the first short enough that its multiples are exact, and the polynomials of a
/// number type.
trait Circle: Real {
    const RIGHT_ANGLE: [Self; 2];
    const PER_RIGHT_ANGLE: Self;
    /// `sin x = x + x³ (s0 + s1 x² + ...)`.
    const SINE: &'static [Self];
    /// `cos x = 1 - x² / 2 + x⁴ (c0 + c1 x² + ...)`.
    const COSINE: &'static [Self];
    /// The nearest whole number.
    fn nearest(self) -> i32;
    fn from_whole(whole: i32) -> Self;
}

impl Circle for f32 {
    const RIGHT_ANGLE: [Self; 2] = [1.570_785_5, 1.080_433_4e-5];
    const PER_RIGHT_ANGLE: Self = core::f32::consts::FRAC_2_PI;
    const SINE: &'static [Self] = &[-0.166_666_67, 8.333_329e-3, -1.983_933_5e-4, 2.718_311_4e-6];
    const COSINE: &'static [Self] = &[4.166_662_3e-2, -1.388_676_3e-3, 2.439_044_9e-5];

    fn nearest(self) -> i32 {
        (if self < 0.0 { self - 0.5 } else { self + 0.5 }) as i32
    }

    fn from_whole(whole: i32) -> Self {
        whole as f32
    }
}

impl Circle for f64 {
    const RIGHT_ANGLE: [Self; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
    const PER_RIGHT_ANGLE: Self = core::f64::consts::FRAC_2_PI;
    const SINE: &'static [Self] = &[
        -0.166_666_666_666_666_32,
        0.008_333_333_333_322_49,
        -0.000_198_412_698_298_579_5,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_3e-8,
        1.589_690_995_211_55e-10,
    ];
    const COSINE: &'static [Self] = &[
        0.041_666_666_666_666_6,
        -0.001_388_888_888_887_411,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];

    fn nearest(self) -> i32 {
        (if self < 0.0 { self - 0.5 } else { self + 0.5 }) as i32
    }

    fn from_whole(whole: i32) -> Self {
        f64::from(whole)
    }
}

fn polynomial<T: Circle>(coefficients: &[T], x: T) -> T {
    coefficients.iter().rev().fold(T::ZERO, |sum, coefficient| sum * x + *coefficient)
}

fn reduced_and_exchanged<T: Circle>(angle_rad: T) -> (T, T) {
    let quadrants = (angle_rad * T::PER_RIGHT_ANGLE).nearest();
    let count = T::from_whole(quadrants);
    let [high, low] = T::RIGHT_ANGLE;
    let x = (angle_rad - count * high) - count * low;
    let square = x * x;
    let sine = x + x * square * polynomial(T::SINE, square);
    let cosine = T::ONE - (square * T::HALF - square * square * polynomial(T::COSINE, square));
    let negative = |value: T| T::ZERO - value;
    match quadrants & 3 {
        0 => (sine, cosine),
        1 => (cosine, negative(sine)),
        2 => (negative(sine), negative(cosine)),
        _ => (negative(cosine), sine),
    }
}

/// Sine and cosine in f32.
#[inline(never)]
pub fn sine_cosine(angle_rad: f32) -> (f32, f32) {
    reduced_and_exchanged(angle_rad)
}

/// Sine and cosine in f64.
#[inline(never)]
pub fn sine_cosine_f64(angle_rad: f64) -> (f64, f64) {
    reduced_and_exchanged(angle_rad)
}

/// Root of the sum of two squares, to 1.2e-7 of it where it lies between 1e-15 and 1e18: `libm`'s also
/// cares for squares that no f32 holds.
#[inline(never)]
pub fn hypotenuse(one: f32, other: f32) -> f32 {
    libm::sqrtf(one * one + other * other)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: u32 = 2_000_000;
    const GREATEST_RAD: f64 = 100.0;

    fn greatest_error(errors: impl Fn(f64) -> [f64; 2]) -> f64 {
        (0..=STEPS)
            .map(|step| GREATEST_RAD * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0))
            .flat_map(errors)
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_error_over_the_whole_range_is_as_documented() {
        let single = greatest_error(|angle| {
            let angle = angle as f32;
            let (sine, cosine) = sine_cosine(angle);
            let (true_sine, true_cosine) = f64::from(angle).sin_cos();
            [(f64::from(sine) - true_sine).abs(), (f64::from(cosine) - true_cosine).abs()]
        });
        let double = greatest_error(|angle| {
            let (sine, cosine) = sine_cosine_f64(angle);
            let (true_sine, true_cosine) = angle.sin_cos();
            [(sine - true_sine).abs(), (cosine - true_cosine).abs()]
        });
        assert!(single < 1.2e-7, "f32: {single:e}");
        assert!(double < 2.3e-16, "f64: {double:e}");
    }

    #[test]
    fn small_angles_keep_all_their_digits() {
        for exponent in -30..0 {
            let angle = 10f32.powi(exponent);
            let (sine, cosine) = sine_cosine(angle);
            let relative = (f64::from(sine) / f64::from(angle).sin() - 1.0).abs();
            assert!(relative < 1.2e-7 && cosine <= 1.0, "{angle}: {relative:e}");
        }
        assert_eq!(sine_cosine(0.0), (0.0, 1.0));
        assert_eq!(sine_cosine_f64(0.0), (0.0, 1.0));
    }

    #[test]
    fn of_an_angle_that_is_not_finite_neither_is() {
        for angle in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (sine, cosine) = sine_cosine(angle);
            assert!(!sine.is_finite() && !cosine.is_finite());
        }
    }

    #[test]
    fn a_hypotenuse_is_as_exact_as_that_in_f64() {
        let mut worst = 0.0f64;
        for step in 0..3600u16 {
            let (sine, cosine) = f64::from(step).to_radians().sin_cos();
            for size in [1e-15, 1e-6, 1.0, 7e3, 1e18] {
                let (one, other) = ((size * sine) as f32, (0.1 * size * cosine) as f32);
                let truth = f64::from(one).hypot(f64::from(other));
                worst = worst.max((f64::from(hypotenuse(one, other)) / truth - 1.0).abs());
            }
        }
        std::println!("{worst:.2e}");
        assert!(worst < 1.2e-7, "{worst}");
        assert!(hypotenuse(f32::NAN, 1.0).is_nan() && hypotenuse(f32::INFINITY, 1.0) == f32::INFINITY);
    }
}
