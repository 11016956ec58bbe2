//! How a figure spreads over runs: median, its confidence interval, what 95 % of the runs keep.

use serde::Serialize;

/// Standard deviations that hold 95 % of a Gaussian.
const SIGMAS_95: f64 = 1.96;

/// A figure over runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Runs that yielded it.
    pub runs: usize,
    /// Median over them.
    pub median: f64,
    /// 95 % confidence interval of the median, by order statistics.
    pub median_interval: [f64; 2],
    /// What 95 % of the runs keep: the 95 % quantile, or that of 5 % where more is better.
    pub kept_by_95_percent: f64,
}

impl Spread {
    /// Of values from the best to the worst; `None` of none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let (runs, last) = (values.len(), values.len().checked_sub(1)?);
        // The smallest rank that at least this share of the runs do not exceed.
        let ranked = |share: f64| values[((share * runs as f64).ceil() as usize).clamp(1, runs) - 1];
        let half = 0.5 * SIGMAS_95 / libm::sqrt(runs as f64);
        let [one, other] = [ranked(0.5 - half), ranked(0.5 + half)];
        Some(Self {
            runs,
            median: 0.5 * (values[last / 2] + values[runs / 2]),
            median_interval: [one.min(other), one.max(other)],
            kept_by_95_percent: ranked(0.95),
        })
    }
}

/// 95 % confidence interval of a probability of which `of_them` of `all` trials are known (Wilson 1927), %.
pub fn share_interval_percent(of_them: u64, all: u64) -> [f64; 2] {
    let (n, p) = (all.max(1) as f64, of_them as f64 / all.max(1) as f64);
    let square = SIGMAS_95 * SIGMAS_95 / n;
    let middle = (p + 0.5 * square) / (1.0 + square);
    let half = libm::sqrt(square * (p * (1.0 - p) + 0.25 * square)) / (1.0 + square);
    [middle - half, middle + half].map(|share| 100.0 * share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_twenty_values_the_interval_has_the_ranks_6_and_15() {
        // Their binomial probability is 95.9 %.
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        let spread = Spread::of(&values).unwrap();
        assert_eq!(
            (spread.median, spread.median_interval, spread.kept_by_95_percent),
            (10.5, [6.0, 15.0], 19.0)
        );
        let falling: Vec<f64> = values.iter().rev().copied().collect();
        let spread = Spread::of(&falling).unwrap();
        assert_eq!((spread.median_interval, spread.kept_by_95_percent), ([6.0, 15.0], 2.0));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn shares_have_wilsons_interval() {
        // 9 of 10: 59.6 to 98.2 %, Wilson 1927 as tabulated.
        let [low, high] = share_interval_percent(9, 10);
        assert!((low - 59.58).abs() < 0.02 && (high - 98.21).abs() < 0.02, "{low} {high}");
        assert_eq!(share_interval_percent(5, 5)[1], 100.0);
    }
}
