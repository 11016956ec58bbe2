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
    /// 95 % confidence interval of the median by order statistics, from the lower to the higher end; missing
    /// where so few runs do not bound it: below 6.
    pub median_interval: [Option<f64>; 2],
    /// What 95 % of the runs keep: the 95 % quantile, or that of 5 % where more is better.
    pub kept_by_95_percent: f64,
    /// 95 % confidence interval of it by order statistics, from the better to the worse end; an end is
    /// missing where so few runs do not bound it: the worse one below 72 runs.
    pub kept_interval: [Option<f64>; 2],
}

/// Share of the runs that keep [`Spread::kept_by_95_percent`].
const KEEP: f64 = 0.95;
/// Probability that an end of an interval is on the wrong side.
const TAIL: f64 = 0.025;

/// The ranks, from 1, that bound the quantile of `share` of so many runs. With `X` runs at or below it, of the
/// distribution `B(runs, share)`: the greatest `l` with `P(X < l) <= TAIL`, the least `u` with
/// `P(X >= u) <= TAIL`; none where there is no such rank.
fn ranks_about_quantile(share: f64, runs: usize) -> [Option<usize>; 2] {
    let n = runs as f64;
    let probability = |of: usize| {
        let of = of as f64;
        let ways = libm::lgamma(n + 1.0) - libm::lgamma(of + 1.0) - libm::lgamma(n - of + 1.0);
        libm::exp(ways + of * libm::log(share) + (n - of) * libm::log(1.0 - share))
    };
    let below: Vec<f64> =
        (0..=runs).scan(0.0, |sum, of| Some(std::mem::replace(sum, *sum + probability(of)))).collect();
    [(1..=runs).rev().find(|rank| below[*rank] <= TAIL), (1..=runs).find(|rank| 1.0 - below[*rank] <= TAIL)]
}

impl Spread {
    /// Of values from the best to the worst; `None` of none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let (runs, last) = (values.len(), values.len().checked_sub(1)?);
        // The smallest rank that at least this share of the runs do not exceed.
        let ranked = |share: f64| values[((share * runs as f64).ceil() as usize).clamp(1, runs) - 1];
        let bounds =
            |share: f64| ranks_about_quantile(share, runs).map(|rank| rank.map(|rank| values[rank - 1]));
        let [one, other] = bounds(0.5);
        let falls = one.zip(other).is_some_and(|(one, other)| one > other);
        Some(Self {
            runs,
            median: 0.5 * (values[last / 2] + values[runs / 2]),
            median_interval: if falls { [other, one] } else { [one, other] },
            kept_by_95_percent: ranked(KEEP),
            kept_interval: bounds(KEEP),
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
            (10.5, [Some(6.0), Some(15.0)], 19.0)
        );
        let falling: Vec<f64> = values.iter().rev().copied().collect();
        let spread = Spread::of(&falling).unwrap();
        assert_eq!((spread.median_interval, spread.kept_by_95_percent), ([Some(6.0), Some(15.0)], 2.0));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn the_quantile_of_95_percent_is_bounded_by_the_ranks_of_the_binomial() {
        // Binomial probabilities by hand, n = 20: P(X <= 16) = 0.0159, P(X <= 17) = 0.0755, P(X = 20) = 0.358.
        assert_eq!(ranks_about_quantile(KEEP, 20), [Some(17), None]);
        // 0.95^71 = 0.0262, 0.95^72 = 0.0249.
        assert_eq!(ranks_about_quantile(KEEP, 71)[1], None);
        assert_eq!(ranks_about_quantile(KEEP, 72)[1], Some(72));
        assert_eq!(ranks_about_quantile(KEEP, 1), [None, None]);
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(Spread::of(&values).unwrap().kept_interval, [Some(17.0), None]);
    }

    #[test]
    fn few_runs_do_not_bound_a_median() {
        // All of n on one side of it: 2^-5 = 0.031, 2^-6 = 0.016.
        assert_eq!(Spread::of(&[3.0, 2.0, 1.0]).unwrap().median_interval, [None; 2]);
        assert_eq!(ranks_about_quantile(0.5, 5), [None; 2]);
        assert_eq!(ranks_about_quantile(0.5, 6), [Some(1), Some(6)]);
    }

    #[test]
    fn shares_have_wilsons_interval() {
        // 9 of 10: 59.6 to 98.2 %, Wilson 1927 as tabulated.
        let [low, high] = share_interval_percent(9, 10);
        assert!((low - 59.58).abs() < 0.02 && (high - 98.21).abs() < 0.02, "{low} {high}");
        assert_eq!(share_interval_percent(5, 5)[1], 100.0);
    }
}
