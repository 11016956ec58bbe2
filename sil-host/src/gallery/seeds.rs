//! Figures over seeds: the median and what nineteen of twenty keep.

use super::{SEED, digits};
use crate::campaign::spread::Spread;
use rayon::prelude::*;

/// Seeds of a statistical figure.
pub const SEEDS: u64 = 20;

/// What `make` gives for each seed, side by side.
pub fn over_seeds<T: Send>(make: impl Fn(u64) -> T + Sync + Send) -> Vec<T> {
    (SEED..SEED + SEEDS).into_par_iter().map(make).collect()
}

/// A figure over seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverSeeds {
    /// Its median.
    pub median: f64,
    /// What 95 % of the seeds exceed, and what they keep.
    pub edges: [f64; 2],
}

impl OverSeeds {
    /// Of a value a seed; what is no number is left out.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let kept = |values: &[f64]| {
            Spread::of(values).map_or([f64::NAN; 2], |of| [of.median, of.kept_by_95_percent])
        };
        let [median, high] = kept(&sorted);
        sorted.reverse();
        let [_, low] = kept(&sorted);
        Self { median, edges: [low, high] }
    }

    /// Median and edge in a unit; "none" of no values.
    pub fn words(&self, unit: &str) -> String {
        if !self.median.is_finite() {
            return "none".into();
        }
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        format!("{}{unit} (95 %: {})", digits(self.median, 3), digits(self.edges[1], 3))
    }

    /// A point of a band.
    pub fn edge(&self, at: f64) -> [f64; 3] {
        [at, self.edges[0], self.edges[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_twenty_seeds_the_second_from_either_end_are_the_edges() {
        let of = OverSeeds::of((1..=20).map(f64::from).chain([f64::NAN]));
        assert_eq!((of.median, of.edges), (10.5, [2.0, 19.0]));
        assert_eq!(of.words("px"), "10.5 px (95 %: 19.0)");
        assert_eq!(OverSeeds::of([f64::NAN]).words("px"), "none");
    }
}
