//! The normal distribution and its inverse.
//!
//! [`inverse_normal`]: in a probability, out the standardised deviate below which it lies, by the three
//! rational approximations of algorithm AS 241 (Wichura 1988, Applied Statistics 37, 477), stated relative
//! error 1e-16. The logarithm is `libm`'s and the square root exact by the standard, so the bits are the same
//! on every machine.
//!
//! The two quick ones read tables that `libm` filled. [`QuickInverse`]: a parabola through three points in
//! each of 1024 equal parts of (0, 1), exact in the outer sixteen on either side; the distribution function
//! of what comes out is off by less than 5e-7. [`QuickNormal`]: second order from the nearest of 64 entries a
//! unit, error below 1e-7.

use std::sync::LazyLock;

/// 1.5 · 2⁵²: a number added to it is rounded to a whole one, which stands in the lowest bits. Far quicker
/// than a conversion, and as exact.
pub const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Numerator and denominator, constant term first.
type Ratio = ([f64; 8], [f64; 8]);

// Constants of AS 241: centre, |p - 1/2| <= 0.425; tails down to exp(-25); far tails.
const CENTRE: Ratio = (
    [
        3.387_132_872_796_366_5,
        133.141_667_891_784_38,
        1_971.590_950_306_551_3,
        13_731.693_765_509_46,
        45_921.953_931_549_87,
        67_265.770_927_008_7,
        33_430.575_583_588_13,
        2_509.080_928_730_122_7,
    ],
    [
        1.0,
        42.313_330_701_600_91,
        687.187_007_492_057_9,
        5_394.196_021_424_751,
        21_213.794_301_586_597,
        39_307.895_800_092_71,
        28_729.085_735_721_943,
        5_226.495_278_852_854,
    ],
);
const TAIL: Ratio = (
    [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        0.241_780_725_177_450_6,
        0.022_723_844_989_269_184,
        7.745_450_142_783_414e-4,
    ],
    [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        0.689_767_334_985_1,
        0.148_103_976_427_480_08,
        0.015_198_666_563_616_457,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ],
);
const FAR_TAIL: Ratio = (
    [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        0.296_560_571_828_504_87,
        0.026_532_189_526_576_124,
        1.242_660_947_388_078_4e-3,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ],
    [
        1.0,
        0.599_832_206_555_888,
        0.136_929_880_922_735_8,
        0.014_875_361_290_850_615,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ],
);

/// The argument at which the normal distribution function is `p`, 0 < p < 1.
#[inline]
pub fn inverse_normal(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return q * ratio(&CENTRE, 0.180_625 - q * q);
    }
    let r = f64::sqrt(-libm::log(if q < 0.0 { p } else { 1.0 - p }));
    let value = if r <= 5.0 { ratio(&TAIL, r - 1.6) } else { ratio(&FAR_TAIL, r - 5.0) };
    if q < 0.0 { -value } else { value }
}

/// Parts of (0, 1) in the table of the inverse.
const PARTS: usize = 1024;
/// Parts on either side that are not read from the table: the inverse is too steep there.
const OUTER: usize = 16;

/// Value at the start of a part, and the coefficients of the place within it and its square.
static INVERSE: LazyLock<Box<[[f64; 3]; PARTS]>> = LazyLock::new(|| {
    let mut table = Box::new([[0.0; 3]; PARTS]);
    for (part, entry) in table.iter_mut().enumerate().take(PARTS - OUTER).skip(OUTER) {
        let [a, b, c] = [0.0, 0.5, 1.0].map(|step| inverse_normal((part as f64 + step) / PARTS as f64));
        *entry = [a, 4.0 * b - 3.0 * a - c, 2.0 * (a + c) - 4.0 * b];
    }
    table
});

/// [`inverse_normal`] from a table.
#[derive(Debug, Clone, Copy)]
pub struct QuickInverse(&'static [[f64; 3]; PARTS]);

impl QuickInverse {
    /// The table, which is filled when first asked for.
    pub fn table() -> Self {
        Self(&INVERSE)
    }

    /// The deviate of the probability `(bits + 1/2) / 2⁵²`, of which the highest 52 of the 64 `bits` count.
    // No conversions between whole numbers and others: part and step stand in the bits.
    #[inline]
    pub fn at(self, bits: u64) -> f64 {
        const ONE: u64 = 0x3ff0_0000_0000_0000;
        let part = (bits >> (64 - PARTS.trailing_zeros())) as usize;
        if part.wrapping_sub(OUTER) >= PARTS - 2 * OUTER {
            return steep(bits);
        }
        let [a, b, c] = self.0[part];
        let within = bits << PARTS.trailing_zeros() >> 12 & !0x3ff | 0x200;
        let step = f64::from_bits(ONE | within) - 1.0;
        a + step * (b + step * c)
    }
}

/// The middle of the interval that the highest 52 of 64 `bits` stand for: uniform in (0, 1), ends excluded.
#[inline]
pub fn uniform(bits: u64) -> f64 {
    // The half keeps 0 out; 52 bits and a half still fit a double, so 1 cannot come out by rounding.
    ((bits >> 12) as f64 + 0.5) * (1.0 / (1u64 << 52) as f64)
}

#[cold]
#[inline(never)]
fn steep(bits: u64) -> f64 {
    inverse_normal(uniform(bits))
}

/// Entries a unit of the distribution's table.
const STEPS: f64 = 64.0;
/// Its end on either side.
const REACH: f64 = 6.0;
/// More than are needed: a power of two spares a comparison.
const ENTRIES: usize = ((2.0 * REACH * STEPS) as usize + 1).next_power_of_two();

/// Distribution function and density.
static BELOW: LazyLock<Box<[[f64; 2]; ENTRIES]>> = LazyLock::new(|| {
    const DENSITY: f64 = 0.398_942_280_401_432_7;
    let mut table = Box::new([[0.0; 2]; ENTRIES]);
    for (index, entry) in table.iter_mut().enumerate() {
        let t = index as f64 / STEPS - REACH;
        let below = 0.5 * libm::erfc(-std::f64::consts::FRAC_1_SQRT_2 * t);
        *entry = [below, DENSITY * libm::exp(-0.5 * t * t)];
    }
    table
});

/// The normal distribution from a table.
#[derive(Debug, Clone, Copy)]
pub struct QuickNormal(&'static [[f64; 2]; ENTRIES]);

impl QuickNormal {
    /// The table, which is filled when first asked for.
    pub fn table() -> Self {
        Self(&BELOW)
    }

    /// Share of the distribution below `t`.
    #[inline]
    pub fn below(self, t: f64) -> f64 {
        let t = t.clamp(-REACH, REACH);
        let rounded = (t + REACH) * STEPS + ROUNDER;
        let [below, density] = self.0[rounded.to_bits() as usize % ENTRIES];
        let node = (rounded - ROUNDER) * (1.0 / STEPS) - REACH;
        let step = t - node;
        below + density * step * (1.0 - 0.5 * node * step)
    }
}

#[inline]
fn ratio((numerator, denominator): &Ratio, x: f64) -> f64 {
    let polynomial = |c: &[f64; 8]| c.iter().rev().fold(0.0, |sum, term| sum * x + term);
    polynomial(numerator) / polynomial(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_normal_inverts_the_normal_distribution() {
        for k in 1..4000 {
            let p = f64::from(k) / 4000.0;
            let back = 0.5 * libm::erfc(-inverse_normal(p) / std::f64::consts::SQRT_2);
            assert!((back - p).abs() < 1e-14, "{p}: {back}");
        }
        for exponent in 3..16 {
            let p = 10f64.powi(-exponent);
            let back = 0.5 * libm::erfc(-inverse_normal(p) / std::f64::consts::SQRT_2);
            assert!((back / p - 1.0).abs() < 1e-11, "{p}: {back}");
        }
    }

    #[test]
    fn the_quick_inverse_hardly_changes_the_distribution() {
        let quick = QuickInverse::table();
        let mut worst = 0.0f64;
        for k in 0..1_000_000u64 {
            let bits = k * (u64::MAX / 1_000_000) + 77_777;
            let below = 0.5 * libm::erfc(-quick.at(bits) / std::f64::consts::SQRT_2);
            worst = worst.max((below - uniform(bits)).abs());
        }
        assert!(worst < 5e-7, "{worst}");
        for bits in [0, 1 << 12, 1 << 30, u64::MAX / 64 - 4096, u64::MAX] {
            assert_eq!(quick.at(bits), inverse_normal(uniform(bits)));
        }
    }

    #[test]
    fn the_quick_distribution_is_right_to_1e_7() {
        let quick = QuickNormal::table();
        for k in -80_000..80_000 {
            let t = f64::from(k) * 1e-4;
            let exact = 0.5 * libm::erfc(-t / std::f64::consts::SQRT_2);
            assert!((quick.below(t) - exact).abs() < 1e-7, "{t}");
        }
    }
}
