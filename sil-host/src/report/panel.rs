//! A curve in a panel of its own, and the scale it is drawn on.
//!
//! An error is drawn in its own range, with its envelope where that fits in ([`Scale`]); what the panel
//! cannot show it says.

use super::scale::{Scale, label};
use super::trace::{Banded, Trace};

/// Errors to be seen in a panel; the others are marked at its edge.
const NEARLY_ALL: f64 = 0.999;

/// A curve in a panel.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    pub(super) name: &'a str,
    pub(super) unit: &'a str,
    pub(super) line: &'a Trace,
    /// The sigma of which three are drawn.
    pub(super) band: Option<&'a Trace>,
    /// What the sigma cannot be less than, of which three are drawn.
    pub(super) bound: Option<&'a Trace>,
    pub(super) scale: Scale,
    /// A level to compare with.
    pub(super) level: Option<f64>,
}

/// Three sigma, as they typically were.
fn envelope(sigma: &Trace) -> Option<f64> {
    sigma.quantile(0.5).map(|sigma| 3.0 * sigma)
}

fn scale_of(line: &Trace, band: Option<f64>) -> Scale {
    let of = |share| line.quantile(share).unwrap_or(1.0);
    // A class of sizes ends 1.2 % above its middle.
    let nearly_all = (1.012 * of(NEARLY_ALL)).min(line.largest().unwrap_or(f64::INFINITY));
    Scale::about_zero(of(0.5), nearly_all, band)
}

impl<'a> Panel<'a> {
    /// An error in its three-sigma envelope.
    pub fn banded(name: &'a str, unit: &'a str, of: &'a Banded) -> Self {
        Self::banded_like(name, unit, of, of)
    }

    /// The same on the scale of another.
    pub fn banded_like(name: &'a str, unit: &'a str, of: &'a Banded, like: &Banded) -> Self {
        let scale = scale_of(&like.error, envelope(&like.sigma));
        Self { name, unit, line: &of.error, band: Some(&of.sigma), bound: None, scale, level: None }
    }

    /// With a bound of its sigma.
    pub fn above(self, bound: &'a Trace) -> Self {
        Self { bound: Some(bound), ..self }
    }

    /// An error without an envelope.
    pub fn signed(name: &'a str, unit: &'a str, line: &'a Trace) -> Self {
        Self { name, unit, line, band: None, bound: None, scale: scale_of(line, None), level: None }
    }

    /// A count, or another quantity from zero up, beside a level.
    pub fn counted(name: &'a str, unit: &'a str, line: &'a Trace, level: Option<f64>) -> Self {
        let scale = Scale::from_zero(line.largest().unwrap_or(0.0).max(level.unwrap_or(0.0)));
        Self { name, unit, line, band: None, bound: None, scale, level }
    }

    /// A quantity in the range in which it lies, at least `least` wide.
    pub fn ranging(name: &'a str, unit: &'a str, line: &'a Trace, least: f64) -> Self {
        let (low, high) = line.extremes().unwrap_or((0.0, 0.0));
        Self {
            name,
            unit,
            line,
            band: None,
            bound: None,
            scale: Scale::between(low, high, least),
            level: None,
        }
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.line.is_empty()
    }

    /// Whether no part of the envelope is in the panel.
    pub(super) fn envelope_off_scale(&self) -> bool {
        let least = self.band.and_then(|sigma| sigma.extremes()).map(|(low, _)| 3.0 * low);
        least.is_some_and(|least| least > self.scale.high())
    }

    /// What the panel cannot show.
    pub(super) fn notes(&self) -> String {
        let mut notes = Vec::new();
        let high = self.scale.high();
        if self.scale.is_logarithmic() {
            notes.push("logarithmic away from 0".to_owned());
        }
        if let Some(largest) = self.line.largest().filter(|largest| *largest > 1.001 * high) {
            notes.push(format!("largest {} {}", label(largest), self.unit));
        }
        if let Some(three_sigma) = self.band.and_then(envelope).filter(|three_sigma| *three_sigma > high) {
            notes.push(format!(
                "\u{b1}3\u{3c3} off the scale: {} {} (median)",
                label(three_sigma),
                self.unit
            ));
        }
        notes.join(" \u{b7} ")
    }
}
