//! Histograms of error over reported sigma, with the unit Gaussian that right sigmas would give.
//!
//! In: errors and sigmas, all axes of a quantity together. Out: inline SVG. The area of the bars is the share
//! of the seconds within 5 sigma; the others are counted.

use crate::judge::second::Axes;
use std::fmt::Write as _;

/// Drawn up to so many sigma on either side.
const EDGE: f64 = 5.0;
/// Bars a sigma.
const PER_SIGMA: f64 = 4.0;
const BARS: usize = (2.0 * EDGE * PER_SIGMA) as usize;
/// Size of the drawing, of the bars' ground, and its left margin.
const SIZE: (f64, f64) = (320.0, 150.0);
const GROUND: (f64, f64) = (300.0, 122.0);
const LEFT: f64 = 10.0;
/// Height of the unit Gaussian.
const GAUSSIAN: f64 = 0.398_942_28;

/// Errors over their sigmas, counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviates {
    bars: [u32; BARS],
    beyond: u32,
    all: u32,
}

impl Default for Deviates {
    fn default() -> Self {
        Self { bars: [0; BARS], beyond: 0, all: 0 }
    }
}

impl Deviates {
    /// Adds the first `count` axes of a second; what is no number is left out.
    pub fn add(&mut self, of: &Axes, count: usize) {
        for (error, sigma) in of.error.iter().zip(of.sigma).take(count) {
            let deviate = error / sigma;
            if !deviate.is_finite() {
                continue;
            }
            self.all += 1;
            let bar = libm::floor((deviate + EDGE) * PER_SIGMA);
            match self.bars.get_mut(bar.max(-1.0) as usize).filter(|_| bar >= 0.0) {
                Some(count) => *count += 1,
                None => self.beyond += 1,
            }
        }
    }

    /// How many there are, and how many of them are beyond the drawing.
    pub fn counts(&self) -> (u32, u32) {
        (self.all, self.beyond)
    }

    /// Share of all a sigma, bar after bar.
    fn densities(&self) -> impl Iterator<Item = f64> + '_ {
        self.bars.iter().map(|count| f64::from(*count) * PER_SIGMA / f64::from(self.all.max(1)))
    }

    /// The drawing; `title` is for readers who do not see it.
    pub fn draw(&self, title: &str) -> String {
        let (width, height) = GROUND;
        let highest = self.densities().fold(GAUSSIAN, f64::max) * 1.06;
        let x = |deviate: f64| LEFT + width * (deviate + EDGE) / (2.0 * EDGE);
        let y = |density: f64| height * (1.0 - density / highest);
        let mut svg = format!(
            "<svg class=\"histogram\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{title}\">",
            SIZE.0, SIZE.1
        );
        for (bar, density) in self.densities().enumerate().filter(|(_, density)| *density > 0.0) {
            let _ = write!(
                svg,
                "<rect class=\"bar\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                x(bar as f64 / PER_SIGMA - EDGE),
                y(density),
                width / BARS as f64,
                height - y(density)
            );
        }
        let mut curve = String::new();
        for step in 0..=100 {
            let deviate = EDGE * (f64::from(step) / 50.0 - 1.0);
            let density = GAUSSIAN * libm::exp(-0.5 * deviate * deviate);
            let letter = if step == 0 { 'M' } else { 'L' };
            let _ = write!(curve, "{letter}{:.1} {:.1}", x(deviate), y(density));
        }
        let _ = write!(
            svg,
            "<path class=\"gaussian\" d=\"{curve}\"/><path class=\"zero\" d=\"M{LEFT} {height}h{width}\"/>"
        );
        for tick in [-4, -2, 0, 2, 4] {
            let at = x(f64::from(tick));
            let _ = write!(
                svg,
                "<path class=\"zero\" d=\"M{at:.1} {height}v4\"/>\
                 <text class=\"tick\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                height + 16.0,
                format!("{tick}\u{3c3}").replace('-', "\u{2212}")
            );
        }
        svg.push_str("</svg>");
        svg
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::noise::{Noise, Stream};

    fn deviates(scale: f64) -> Deviates {
        let noise = Noise::new(3, 0, Stream::Attitude);
        let mut deviates = Deviates::default();
        for cycle in 0..20_000 {
            let error = [scale * noise.gaussian(cycle, 0), scale * noise.gaussian(cycle, 1), 1e9];
            deviates.add(&Axes { error, sigma: [1.0; 3] }, 2);
        }
        deviates
    }

    #[test]
    fn right_sigmas_give_the_unit_gaussian() {
        let deviates = deviates(1.0);
        assert_eq!(deviates.counts(), (40_000, 0));
        for (bar, density) in deviates.densities().enumerate() {
            let middle = (bar as f64 + 0.5) / PER_SIGMA - EDGE;
            let expected = GAUSSIAN * (-0.5 * middle * middle).exp();
            // Four sigma of the count, and what the curve bends within a bar.
            let tolerance = 4.0 * (expected * PER_SIGMA / 40_000.0).sqrt() + 0.004;
            assert!((density - expected).abs() < tolerance, "{middle}: {density} for {expected}");
        }
    }

    #[test]
    fn sigmas_that_are_too_large_or_too_small_are_seen() {
        let narrow: f64 = deviates(0.01).densities().fold(0.0, f64::max);
        assert!(narrow > 1.9, "{narrow}");
        let (all, beyond) = deviates(10.0).counts();
        let share = f64::from(beyond) / f64::from(all);
        // Half a sigma on either side holds 38.3 % of all.
        assert!((share - 0.617).abs() < 0.01, "{share}");
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let mut deviates = Deviates::default();
        deviates.add(&Axes { error: [f64::NAN, 1.0, -7.0], sigma: [1.0, 0.0, 1.0] }, 3);
        assert_eq!(deviates.counts(), (1, 1));
        assert!(!deviates.draw("").contains("NaN"));
    }
}
