//! How probable a mean square of normalised errors is, if the sigmas are right.
//!
//! A mean of squares of `freedom` independent Gaussian numbers of unit variance, times `freedom`, is
//! chi-square distributed. By the cube root's normal approximation (Wilson and Hilferty 1931): within 0.006
//! of the true probability from 3 degrees of freedom on.

/// Gaussian deviates within which 99 % lie.
const WITHIN_99: f64 = 2.5758;

/// Mean and standard deviation of the cube root of the mean square.
fn cube_root(freedom: f64) -> (f64, f64) {
    let variance = 2.0 / (9.0 * freedom);
    (1.0 - variance, libm::sqrt(variance))
}

/// Probability of a mean square at least as far from what is expected, on either side.
pub fn two_sided(mean_square: f64, freedom: f64) -> f64 {
    let (mean, sigma) = cube_root(freedom);
    libm::erfc(((libm::cbrt(mean_square) - mean) / sigma).abs() / std::f64::consts::SQRT_2)
}

/// Probability of a chi-square of an odd number of degrees of freedom at least as large, exact (Abramowitz and
/// Stegun, eq. 26.4.4): `erfc(√(x/2)) + √(2x/π) exp(-x/2) (1 + x/3 + x²/(3·5) + ...)` with `(freedom - 1)/2`
/// terms.
pub fn upper_tail_odd(chi_square: f64, freedom: usize) -> f64 {
    let half = 0.5 * chi_square;
    // Logarithms: with a thousand degrees of freedom the exponential is zero in f64, its product is not.
    let mut log_term = 0.5 * libm::log(half * 4.0 / std::f64::consts::PI) - half;
    let mut tail = libm::erfc(libm::sqrt(half));
    for index in 1..=(freedom - 1) / 2 {
        tail += libm::exp(log_term);
        log_term += libm::log(chi_square / (2 * index + 1) as f64);
    }
    tail
}

/// Between these 99 % of all mean squares lie.
pub fn band_99(freedom: f64) -> [f64; 2] {
    let (mean, sigma) = cube_root(freedom);
    [mean - WITHIN_99 * sigma, mean + WITHIN_99 * sigma].map(|root| root.max(0.0).powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_tail_is_that_of_the_tables() {
        // Quantiles of 0.1 % (Abramowitz and Stegun, tab. 26.8), and one of 1e-6.
        for (chi_square, freedom, probability) in
            [(10.828, 1, 1e-3), (16.266, 3, 1e-3), (20.515, 5, 1e-3), (61.098, 31, 1e-3), (30.665, 3, 1e-6)]
        {
            let tail = upper_tail_odd(chi_square, freedom);
            assert!((tail / probability - 1.0).abs() < 0.02, "{freedom}: {tail}");
        }
        let half = upper_tail_odd(2000.3, 2001);
        assert!((half - 0.5).abs() < 0.01, "{half}");
        assert!(upper_tail_odd(1e12, 2001) == 0.0 && upper_tail_odd(0.0, 5) == 1.0);
    }

    #[test]
    fn bands_are_those_of_the_tables() {
        // Chi-square quantiles of 0.5 % and 99.5 % over the degrees of freedom (Abramowitz and Stegun, tab.
        // 26.8).
        for (freedom, low, high) in [(3.0, 0.0717, 12.838), (10.0, 2.156, 25.188), (100.0, 67.328, 140.169)] {
            let [from, to] = band_99(freedom).map(|mean| mean * freedom);
            assert!((from - low).abs() < 0.1 && (to - high).abs() < 0.1, "{freedom}: {from} {to}");
            for edge in band_99(freedom) {
                assert!((two_sided(edge, freedom) - 0.01).abs() < 1e-4 || edge == 0.0);
            }
        }
        assert!(two_sided(1.0, 30.0) > 0.9 && two_sided(0.002, 12.0) < 1e-4 && two_sided(4.0, 12.0) < 1e-4);
    }
}
