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

/// Between these 99 % of all mean squares lie.
pub fn band_99(freedom: f64) -> [f64; 2] {
    let (mean, sigma) = cube_root(freedom);
    [mean - WITHIN_99 * sigma, mean + WITHIN_99 * sigma].map(|root| root.max(0.0).powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

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
