//! Curves of a run in constant memory: least and greatest value of every stretch of seconds, so that spikes
//! stay visible; and how large their values are.

use crate::judge::sums::Sizes;

/// Most stretches a run is cut into: two values each, 1500 points a curve.
const STRETCHES_MAX: usize = 750;

/// The seconds of a run, cut into stretches of equal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretches {
    /// Seconds of the run.
    pub seconds: u32,
    /// Number of stretches.
    pub count: usize,
}

impl Stretches {
    /// Of a run of `seconds`.
    pub fn of(seconds: u32) -> Self {
        let seconds = seconds.max(1);
        Self { seconds, count: (seconds as usize).min(STRETCHES_MAX) }
    }

    /// The stretch in which second `cycle` lies.
    pub fn index(&self, cycle: u32) -> usize {
        let index = u64::from(cycle) * self.count as u64 / u64::from(self.seconds);
        (index as usize).min(self.count - 1)
    }

    /// First second of a stretch, or the end of the run after the last.
    pub fn start_s(&self, index: usize) -> f64 {
        index as f64 * f64::from(self.seconds) / self.count as f64
    }
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    ranges: Vec<Option<(f64, f64)>>,
    sizes: Sizes,
}

impl Trace {
    /// A curve without values.
    pub fn new(stretches: Stretches) -> Self {
        Self { ranges: vec![None; stretches.count], sizes: Sizes::default() }
    }

    /// Adds a value to stretch `index`; what is no number is left out.
    pub fn add(&mut self, index: usize, value: f64) {
        if let Some(range) = self.ranges.get_mut(index).filter(|_| value.is_finite()) {
            let (low, high) = range.unwrap_or((value, value));
            *range = Some((low.min(value), high.max(value)));
            self.sizes.add(value);
        }
    }

    /// Least and greatest value of every stretch; none of one without values.
    pub fn ranges(&self) -> &[Option<(f64, f64)>] {
        &self.ranges
    }

    /// Whether there is no value at all.
    pub fn is_empty(&self) -> bool {
        self.ranges.iter().all(Option::is_none)
    }

    /// Least and greatest value of all; none of a curve without values.
    pub fn extremes(&self) -> Option<(f64, f64)> {
        self.ranges.iter().flatten().copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Magnitude of the farthest value.
    pub fn largest(&self) -> Option<f64> {
        self.extremes().map(|(low, high)| low.abs().max(high.abs()))
    }

    /// Magnitude below which `share` of the seconds lie, to 2.4 %.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        self.sizes.quantile(share)
    }
}

/// An error and its reported sigma.
#[derive(Clone, Debug, PartialEq)]
pub struct Banded {
    /// The error.
    pub error: Trace,
    /// The sigma.
    pub sigma: Trace,
}

impl Banded {
    /// Without values.
    pub fn new(stretches: Stretches) -> Self {
        Self { error: Trace::new(stretches), sigma: Trace::new(stretches) }
    }

    /// Adds a second.
    pub fn add(&mut self, index: usize, error: f64, sigma: f64) {
        self.error.add(index, error);
        self.sigma.add(index, sigma);
    }
}

/// What was the case at some time in every stretch: a set of up to eight things.
#[derive(Clone, Debug, PartialEq)]
pub struct Marks {
    sets: Vec<u8>,
}

impl Marks {
    /// Nothing anywhere.
    pub fn new(stretches: Stretches) -> Self {
        Self { sets: vec![0; stretches.count] }
    }

    /// Thing number `bit` was the case in stretch `index`.
    pub fn add(&mut self, index: usize, bit: u8) {
        if let Some(set) = self.sets.get_mut(index) {
            *set |= 1 << bit;
        }
    }

    /// Runs of stretches in which thing number `bit` was the case: first, and one past the last.
    pub fn runs(&self, bit: u8) -> Vec<(usize, usize)> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (index, _) in self.sets.iter().enumerate().filter(|(_, set)| *set & (1 << bit) != 0) {
            match runs.last_mut() {
                Some((_, end)) if *end == index => *end += 1,
                _ => runs.push((index, index + 1)),
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_second_in_a_day_stays_visible() {
        let stretches = Stretches::of(86_400);
        let mut trace = Trace::new(stretches);
        for cycle in 0..86_400 {
            trace.add(stretches.index(cycle), if cycle == 43_210 { 9.0 } else { -0.5 });
        }
        assert!(stretches.count * 2 <= 1500);
        assert_eq!(trace.ranges()[stretches.index(43_210)], Some((-0.5, 9.0)));
        assert_eq!((trace.extremes(), trace.largest()), (Some((-0.5, 9.0)), Some(9.0)));
        let nearly_all = trace.quantile(0.999).unwrap();
        assert!((nearly_all / 0.5 - 1.0).abs() < 0.024, "{nearly_all}");
        assert_eq!(trace.ranges().iter().flatten().count(), stretches.count);
    }

    #[test]
    fn short_runs_keep_every_second_and_gaps_stay_gaps() {
        let stretches = Stretches::of(30);
        assert_eq!((stretches.count, stretches.index(29), stretches.index(99)), (30, 29, 29));
        let mut trace = Trace::new(stretches);
        trace.add(3, f64::NAN);
        assert!(trace.is_empty());
        let mut marks = Marks::new(stretches);
        for index in [0, 1, 2, 7, 29] {
            marks.add(index, 3);
        }
        assert_eq!(marks.runs(3), [(0, 3), (7, 8), (29, 30)]);
        assert!(marks.runs(2).is_empty());
    }
}
