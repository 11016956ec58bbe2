//! From values to heights in a panel: linear, or logarithmic away from zero where a curve spans orders of
//! magnitude.

/// A symmetric or one-sided scale of a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    /// Where the logarithm begins; none: linear.
    knee: Option<f64>,
}

/// Steps of 1, 2 or 5 times a power of ten: the least that is not below `value`.
pub(super) fn round_up(value: f64) -> f64 {
    let power = 10f64.powi(libm::floor(libm::log10(value)) as i32);
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * power)
        .find(|step| *step >= value * 0.999_999)
        .unwrap_or(value)
}

/// A range of errors this many times their median is drawn logarithmically; of Gaussian ones it is 5 times.
const LOGARITHMIC_FROM: f64 = 25.0;
/// An envelope is brought into the panel if it is no wider than this many times the range of the errors.
const ENVELOPE_MAX: f64 = 3.0;

impl Scale {
    /// For errors about zero of which half are below `median` and 99.9 % below `nearly_all`, in an envelope
    /// of typically `band`.
    pub fn about_zero(median: f64, nearly_all: f64, band: Option<f64>) -> Self {
        let nearly_all = nearly_all.max(1e-9);
        let band = band.filter(|band| *band <= ENVELOPE_MAX * nearly_all).unwrap_or(0.0);
        if nearly_all > LOGARITHMIC_FROM * median {
            let high = 1.3 * nearly_all.max(band);
            Self { low: -high, high, knee: Some(round_up(median.max(1e-4 * high)) * 0.5) }
        } else {
            let high = 1.15 * nearly_all.max(band);
            Self { low: -high, high, knee: None }
        }
    }

    /// From `low` to `high`, at least `least` apart.
    pub fn between(low: f64, high: f64, least: f64) -> Self {
        let margin = 0.5 * (least - (high - low)).max(0.1 * (high - low));
        Self { low: low - margin, high: high + margin, knee: None }
    }

    /// From zero up to somewhat more than `largest`.
    pub fn from_zero(largest: f64) -> Self {
        Self { low: 0.0, high: 1.1 * largest.max(1.0), knee: None }
    }

    /// The value at the upper edge.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Whether values away from zero are drawn by their logarithm.
    pub fn is_logarithmic(&self) -> bool {
        self.knee.is_some()
    }

    fn bend(&self, value: f64) -> f64 {
        match self.knee {
            Some(knee) => libm::asinh(value / knee),
            None => value,
        }
    }

    /// Height of a value, 0 at the bottom to 1 at the top, cut off beyond.
    pub fn height(&self, value: f64) -> f64 {
        let (low, high) = (self.bend(self.low), self.bend(self.high));
        ((self.bend(value) - low) / (high - low)).clamp(-0.02, 1.02)
    }

    /// Values to mark.
    pub fn ticks(&self) -> Vec<f64> {
        match self.knee {
            None => {
                let step = round_up((self.high - self.low) / 6.0);
                let count = (self.high / step).floor() as i32;
                let first = (self.low / step).ceil() as i32;
                (first..=count).map(|n| f64::from(n) * step).collect()
            }
            Some(knee) => {
                let mut ticks = vec![0.0];
                let mut at = 10f64.powi(libm::round(libm::log10(2.0 * knee)) as i32);
                // At most four labels a side.
                let decades = libm::log10(self.high / at).max(0.0);
                let stride = 10f64.powi(((decades / 4.0).floor() as i32 + 1).max(1));
                while at <= self.high {
                    ticks.extend([-at, at]);
                    at *= stride;
                }
                // Labels must not stand on each other.
                ticks.retain(|tick| *tick == 0.0 || (self.height(*tick) - 0.5).abs() > 0.1);
                ticks
            }
        }
    }
}

/// A number without needless digits.
pub fn label(value: f64) -> String {
    with_digits(value, digits(value))
}

/// The label of one of these ticks, with digits enough to tell it from its neighbours.
pub fn tick_label(tick: f64, ticks: &[f64]) -> String {
    let mut sorted = ticks.to_vec();
    sorted.sort_by(f64::total_cmp);
    let apart = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let needed =
        if apart > 0.0 && apart.is_finite() { -libm::floor(libm::log10(apart * 1.000_001)) } else { 0.0 };
    with_digits(tick, digits(tick).max(needed.clamp(0.0, 6.0) as usize))
}

/// Digits behind the point of a number of three digits.
fn digits(value: f64) -> usize {
    match value.abs() {
        0.0 => 0,
        size => (2 - libm::floor(libm::log10(size)) as i32).clamp(0, 6) as usize,
    }
}

fn with_digits(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_drawn_linearly_in_their_own_range() {
        let scale = Scale::about_zero(0.67, 3.3, Some(3.0));
        assert!(!scale.is_logarithmic());
        assert!((scale.height(0.0) - 0.5).abs() < 1e-12);
        assert!(scale.height(3.3) > 0.9 && scale.height(3.3) < 1.0);
        let ticks = scale.ticks();
        assert!(ticks.contains(&0.0) && (3..=9).contains(&ticks.len()), "{ticks:?}");
    }

    #[test]
    fn a_wide_envelope_does_not_flatten_the_errors() {
        let fits = Scale::about_zero(1.0, 5.0, Some(14.0));
        assert!(fits.high() > 14.0 && fits.high() < 17.0, "{fits:?}");
        let wide = Scale::about_zero(1.0, 5.0, Some(1000.0));
        assert!(wide.high() < 6.0, "{wide:?}");
    }

    #[test]
    fn a_curve_that_falls_from_thousands_to_tenths_shows_both() {
        let scale = Scale::about_zero(0.2, 3000.0, None);
        assert!(scale.is_logarithmic());
        assert!(scale.height(0.2) - scale.height(0.0) > 0.03, "{scale:?}");
        assert!(scale.height(3000.0) < 1.0 && scale.height(3000.0) > 0.9);
        let ticks = scale.ticks();
        assert!((3..=11).contains(&ticks.len()), "{ticks:?}");
    }

    #[test]
    fn a_level_curve_has_room_about_it() {
        let scale = Scale::between(35_786.0, 35_786.0, 2.0);
        assert!((scale.height(35_786.0) - 0.5).abs() < 1e-9);
        assert!(scale.ticks().len() >= 3);
    }

    #[test]
    fn labels_are_short() {
        let labels: Vec<String> = [0.0, 0.05, -2.0, 1500.0, 12.5].into_iter().map(label).collect();
        assert_eq!(labels, ["0", "0.05", "\u{2212}2", "1500", "12.5"]);
        let ticks = Scale::between(35_777.2, 35_778.4, 2.0).ticks();
        let labels: Vec<String> = ticks.iter().map(|tick| tick_label(*tick, &ticks)).collect();
        assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{labels:?}");
        assert!(labels.contains(&"35777.5".to_owned()) && labels.contains(&"35778".to_owned()), "{labels:?}");
    }
}
