//! Running sums: root mean squares, shares, quantiles, in constant memory.

/// A share of seconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Share {
    all: u32,
    of_them: u32,
}

impl Share {
    /// Adds a second.
    pub fn add(&mut self, is_one: bool) {
        self.all += 1;
        self.of_them += u32::from(is_one);
    }

    /// The share; none of no seconds.
    pub fn value(&self) -> Option<f64> {
        (self.all > 0).then(|| f64::from(self.of_them) / f64::from(self.all))
    }
}

/// How large a quantity is, to 2.4 %: its sizes from 1e-9 to 1e9 counted in a hundred classes a decade.
#[derive(Clone, Debug, PartialEq)]
pub struct Sizes {
    counts: Vec<u32>,
    all: u32,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { counts: vec![0; Self::CLASSES], all: 0 }
    }
}

impl Sizes {
    const CLASSES: usize = 1800;
    const PER_DECADE: f64 = 100.0;
    const LEAST_DECADE: f64 = -9.0;

    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        let class = (libm::log10(value.abs().max(1e-12)) - Self::LEAST_DECADE) * Self::PER_DECADE;
        self.counts[(class.max(0.0) as usize).min(Self::CLASSES - 1)] += 1;
        self.all += 1;
    }

    /// The middle of the class up to which `share` of the values lie, 0 to 1 exclusive; none of no values.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let mut below = 0;
        let class = self.counts.iter().position(|count| {
            below += count;
            f64::from(below) > share * f64::from(self.all)
        })?;
        Some(libm::pow(10.0, (class as f64 + 0.5) / Self::PER_DECADE + Self::LEAST_DECADE))
    }

    /// The median.
    pub fn median(&self) -> Option<f64> {
        self.quantile(0.5)
    }
}

/// Sum of squares of one quantity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Squares {
    count: u32,
    sum: f64,
}

impl Squares {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value * value;
    }

    /// Root mean square.
    pub fn rms(&self) -> Option<f64> {
        (self.count > 0).then(|| libm::sqrt(self.sum / f64::from(self.count)))
    }
}
