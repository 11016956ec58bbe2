//! Plots as inline SVG: panels one above the other over a common axis of time.
//!
//! Colours are the page's variables, so that plots follow light and dark. Behind the curves the geometry is
//! shaded: the Sun in a path, and eclipse.

use super::scale::{Scale, label};
use super::trace::{Banded, Marks, Stretches, Trace};
use std::fmt::Write as _;

/// Width of a plot, and of the margins left and right of its panels.
const WIDTH: f64 = 1000.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 24.0;
/// Height of a panel, of the gap between two, and of the axis of time.
const HEIGHT: f64 = 112.0;
const GAP: f64 = 10.0;
const AXIS: f64 = 30.0;

/// Shaded: the Sun in a path.
pub const SUN: u8 = 0;
/// Shaded: eclipse.
pub const DARK: u8 = 1;

/// What all plots of a run share.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The run's time.
    pub stretches: Stretches,
    /// [`SUN`] and [`DARK`].
    pub geometry: &'a Marks,
}

/// A curve in a panel.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    name: &'a str,
    unit: &'a str,
    line: &'a Trace,
    band: Option<&'a Trace>,
    scale: Scale,
    /// A level to compare with.
    level: Option<f64>,
}

impl<'a> Panel<'a> {
    /// An error in its three-sigma envelope.
    pub fn banded(name: &'a str, unit: &'a str, of: &'a Banded) -> Self {
        let mut sigmas: Vec<f64> = of.sigma.magnitudes().collect();
        sigmas.sort_by(f64::total_cmp);
        let band = sigmas.get(sigmas.len() / 2).map(|sigma| 3.0 * sigma);
        let scale = Scale::about_zero(of.error.magnitudes(), band);
        Self { name, unit, line: &of.error, band: Some(&of.sigma), scale, level: None }
    }

    /// An error without an envelope.
    pub fn signed(name: &'a str, unit: &'a str, line: &'a Trace) -> Self {
        let scale = Scale::about_zero(line.magnitudes(), None);
        Self { name, unit, line, band: None, scale, level: None }
    }

    /// A count, or another quantity from zero up, beside a level.
    pub fn counted(name: &'a str, unit: &'a str, line: &'a Trace, level: Option<f64>) -> Self {
        let scale = Scale::from_zero(line.magnitudes().chain(level));
        Self { name, unit, line, band: None, scale, level }
    }
}

/// Stretches in a row that have values: number, least, greatest.
fn pieces(trace: &Trace) -> Vec<Vec<(usize, f64, f64)>> {
    let mut pieces: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new()];
    for (index, range) in trace.ranges().iter().enumerate() {
        match (range, pieces.last_mut()) {
            (Some((low, high)), Some(piece)) => piece.push((index, *low, *high)),
            (None, Some(piece)) if !piece.is_empty() => pieces.push(Vec::new()),
            _ => {}
        }
    }
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

impl Frame<'_> {
    fn x(&self, second: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * second / f64::from(self.stretches.seconds)
    }

    /// Middle of a stretch.
    fn middle(&self, index: usize) -> f64 {
        0.5 * (self.x(self.stretches.start_s(index)) + self.x(self.stretches.start_s(index + 1)))
    }

    fn open(&self, svg: &mut String, title: &str, height: f64) {
        let _ = write!(
            svg,
            "<svg class=\"plot\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{title}\">"
        );
    }

    fn shade(&self, svg: &mut String, top: f64, height: f64) {
        for (bit, class) in [(DARK, "dark"), (SUN, "sun")] {
            for (from, to) in self.geometry.runs(bit) {
                let (left, right) =
                    (self.x(self.stretches.start_s(from)), self.x(self.stretches.start_s(to)));
                let width = right - left;
                let _ = write!(
                    svg,
                    "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
                );
            }
        }
    }

    /// Lines of the axis of time through panels that end at `bottom`, and its labels.
    fn time_axis(&self, svg: &mut String, bottom: f64) {
        let seconds = f64::from(self.stretches.seconds);
        let steps = [
            1.0, 2.0, 5.0, 10.0, 20.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 10_800.0,
            21_600.0, 43_200.0,
        ];
        let step = steps.into_iter().find(|step| seconds / step <= 13.0).unwrap_or(86_400.0);
        let mut at = 0.0;
        while at <= seconds {
            let x = self.x(at);
            let text = if step >= 60.0 {
                format!("{}:{:02}", (at / 3600.0).floor(), ((at / 60.0) as u32) % 60)
            } else {
                format!("{at}")
            };
            let y = bottom + 16.0;
            let _ = write!(svg, "<path class=\"grid\" d=\"M{x:.1} 0V{bottom:.1}\"/>");
            let _ = write!(
                svg,
                "<text class=\"tick\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{text}</text>"
            );
            at += step;
        }
        let unit = if step >= 60.0 { "h:min" } else { "s" };
        let _ = write!(
            svg,
            "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{unit} since start</text>",
            WIDTH - RIGHT,
            bottom + AXIS - 2.0
        );
    }

    /// Panels over the axis of time.
    pub fn plot(&self, title: &str, panels: &[Panel<'_>]) -> String {
        let bottom = panels.len() as f64 * (HEIGHT + GAP) - GAP;
        let mut svg = String::new();
        self.open(&mut svg, title, bottom + AXIS);
        self.time_axis(&mut svg, bottom);
        for (number, panel) in panels.iter().enumerate() {
            self.panel(&mut svg, panel, number as f64 * (HEIGHT + GAP));
        }
        svg.push_str("</svg>");
        svg
    }

    fn panel(&self, svg: &mut String, panel: &Panel<'_>, top: f64) {
        let width = WIDTH - LEFT - RIGHT;
        let _ = write!(
            svg,
            "<svg x=\"0\" y=\"{top}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\">\
             <rect class=\"ground\" x=\"{LEFT}\" y=\"0\" width=\"{width}\" height=\"{HEIGHT}\"/>"
        );
        self.shade(svg, 0.0, HEIGHT);
        let y = |value: f64| HEIGHT * (1.0 - panel.scale.height(value));
        for tick in panel.scale.ticks() {
            let (at, text, right) = (y(tick), label(tick), WIDTH - RIGHT);
            let class = if tick == 0.0 { "zero" } else { "grid" };
            let place = (at + 4.0).clamp(10.0, HEIGHT - 2.0);
            let _ = write!(
                svg,
                "<path class=\"{class}\" d=\"M{LEFT} {at:.1}H{right}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{place:.1}\" text-anchor=\"end\">{text}</text>",
                LEFT - 6.0
            );
        }
        if let Some(level) = panel.level {
            let _ = write!(svg, "<path class=\"level\" d=\"M{LEFT} {:.1}H{:.1}\"/>", y(level), WIDTH - RIGHT);
        }
        self.line(svg, panel.line, y);
        // Over the curve, so that its edge is seen where the curve fills it.
        if let Some(sigma) = panel.band {
            self.band(svg, sigma, y);
        }
        if panel.line.is_empty() {
            let _ = write!(
                svg,
                "<text class=\"none\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">not reported in this run</text>",
                LEFT + 0.5 * width,
                0.5 * HEIGHT + 4.0
            );
        }
        let _ = write!(
            svg,
            "<text class=\"name\" x=\"{:.1}\" y=\"16\">{} <tspan class=\"unit\">{}</tspan></text></svg>",
            LEFT + 8.0,
            panel.name,
            panel.unit
        );
    }

    fn line(&self, svg: &mut String, trace: &Trace, y: impl Fn(f64) -> f64) {
        let mut path = String::new();
        for piece in pieces(trace) {
            for (number, (index, low, high)) in piece.iter().enumerate() {
                let (x, letter) = (self.middle(*index), if number == 0 { 'M' } else { 'L' });
                let _ = write!(path, "{letter}{x:.1} {:.1}", y(*low));
                // A lone second must be seen too.
                if high > low || piece.len() == 1 {
                    let _ = write!(path, "L{:.1} {:.1}", x + 0.1, y(*high));
                }
            }
        }
        let _ = write!(svg, "<path class=\"line\" d=\"{path}\"/>");
    }

    fn band(&self, svg: &mut String, sigma: &Trace, y: impl Fn(f64) -> f64) {
        let mut path = String::new();
        for piece in pieces(sigma) {
            let forth = piece.iter().map(|(index, _, high)| (*index, 3.0 * high));
            let back = piece.iter().rev().map(|(index, _, high)| (*index, -3.0 * high));
            for (number, (index, value)) in forth.chain(back).enumerate() {
                let letter = if number == 0 { 'M' } else { 'L' };
                let _ = write!(path, "{letter}{:.1} {:.1}", self.middle(index), y(value));
            }
            path.push('Z');
        }
        let _ = write!(svg, "<path class=\"band\" d=\"{path}\"/>");
    }

    /// Rows of things that were the case: pale where expected, solid where flown, in another colour where
    /// wrong. A row is its name and its bit in both sets.
    pub fn strip(
        &self,
        title: &str,
        rows: &[&str],
        expected: &Marks,
        flown: &Marks,
        wrong: &Marks,
    ) -> String {
        const ROW: f64 = 24.0;
        let bottom = rows.len() as f64 * ROW;
        let mut svg = String::new();
        self.open(&mut svg, title, bottom + AXIS);
        self.time_axis(&mut svg, bottom);
        for (bit, name) in rows.iter().enumerate() {
            let top = bit as f64 * ROW;
            for (marks, class, inset) in
                [(expected, "expected", 2.0), (flown, "flown", 8.0), (wrong, "wrong", 8.0)]
            {
                for (from, to) in marks.runs(bit as u8) {
                    let left = self.x(self.stretches.start_s(from));
                    // A single second of a day must be seen too.
                    let width = (self.x(self.stretches.start_s(to)) - left).max(1.5);
                    let _ = write!(
                        svg,
                        "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{:.1}\"/>",
                        top + inset,
                        ROW - 2.0 * inset
                    );
                }
            }
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{LEFT} {:.1}H{:.1}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>",
                top + ROW,
                WIDTH - RIGHT,
                LEFT - 6.0,
                top + 16.0
            );
        }
        svg.push_str("</svg>");
        svg
    }
}
