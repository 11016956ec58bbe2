//! Plots as inline SVG: panels one above the other over a common axis of time.
//!
//! Colours are the page's variables, so that plots follow light and dark. Behind the curves is shaded what
//! the sensor met: the Sun in a path, no lit limb, injected faults; what happened to the orbit is a line.

use super::panel::Panel;
use super::scale::tick_label;
use super::trace::{Marks, Stretches, Trace};
use crate::harness::faults::Fault;
use std::fmt::Write as _;

/// Width of a plot over the whole page, and of one beside another.
pub const WIDE: f64 = 1000.0;
/// See [`WIDE`].
pub const HALF: f64 = 500.0;
/// Margins left and right of the panels.
const LEFT: f64 = 74.0;
const RIGHT: f64 = 24.0;
/// Height of a panel, of its name above it, and of the axis of time.
const HEIGHT: f64 = 112.0;
const NAME: f64 = 24.0;
/// Height of notes below the name, where they do not fit beside it.
const NOTES: f64 = 15.0;
/// Widths of a letter of a name and of a note.
const NAME_LETTER: f64 = 7.4;
const NOTE_LETTER: f64 = 6.0;
const AXIS: f64 = 30.0;
/// Shaded: the Sun in a path.
pub const SUN: u8 = 0;
/// Shaded: no lit limb in the field.
pub const DARK: u8 = 1;

/// What all plots of a run share.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The run's time.
    pub stretches: Stretches,
    /// [`SUN`] and [`DARK`].
    pub geometry: &'a Marks,
    /// What was broken, and when.
    pub faults: &'a [Fault],
    /// When the orbit was begun, restarted or forgotten, in words.
    pub restarts: &'a [(u32, String)],
    /// [`WIDE`] or [`HALF`].
    pub width: f64,
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
    /// Left edge of the panels, and right edge.
    pub(super) fn edges(&self) -> (f64, f64) {
        (LEFT, self.width - RIGHT)
    }

    pub(super) fn x(&self, second: f64) -> f64 {
        let (left, right) = self.edges();
        left + (right - left) * second / f64::from(self.stretches.seconds)
    }

    /// Where a run of stretches begins, and how wide it is.
    pub(super) fn span(&self, (from, to): (usize, usize)) -> (f64, f64) {
        let [left, right] = [from, to].map(|index| self.x(self.stretches.start_s(index)));
        (left, right - left)
    }

    /// Where a fault begins, and how wide it is: a single second of a day must be seen too.
    pub(super) fn span_of(&self, fault: &Fault) -> (f64, f64) {
        let [left, right] = [fault.from_s, fault.until_s].map(|second| self.x(second.into()));
        (left, (right - left).max(1.5))
    }

    /// Middle of a stretch.
    fn middle(&self, index: usize) -> f64 {
        0.5 * (self.x(self.stretches.start_s(index)) + self.x(self.stretches.start_s(index + 1)))
    }

    pub(super) fn open(&self, svg: &mut String, title: &str, height: f64) {
        let _ = write!(
            svg,
            "<svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{title}\">",
            self.width,
            height + AXIS
        );
    }

    /// What the sensor met, behind `height` of curves.
    fn shade(&self, svg: &mut String, height: f64) {
        for (bit, class, words) in [(DARK, "dark", "no lit limb"), (SUN, "sun", "Sun in a path")] {
            for run in self.geometry.runs(bit) {
                let (left, width) = self.span(run);
                let _ = write!(
                    svg,
                    "<rect class=\"{class}\" x=\"{left:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{height:.1}\">\
                     <title>{words}</title></rect>"
                );
            }
        }
        for (fault, words) in self.fault_spans() {
            let (left, width) = self.span_of(fault);
            let _ = write!(
                svg,
                "<rect class=\"fault\" x=\"{left:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{height:.1}\">\
                 <title>{words}</title></rect>"
            );
        }
    }

    /// The faults, those of the same seconds together, with their numbers and words.
    pub(super) fn fault_spans(&self) -> Vec<(&Fault, String)> {
        let mut spans: Vec<(&Fault, String)> = Vec::new();
        for (number, fault) in (1..).zip(self.faults) {
            let words = format!("{number} {}", fault.kind.word());
            let alike =
                |(of, _): &&mut (&Fault, String)| (of.from_s, of.until_s) == (fault.from_s, fault.until_s);
            match spans.iter_mut().find(alike) {
                Some((_, all)) => *all += &format!(", {words}"),
                None => spans.push((fault, words)),
            }
        }
        spans
    }

    /// Lines where the orbit was begun, restarted or forgotten.
    fn restart_lines(&self, svg: &mut String, height: f64) {
        for (second, words) in self.restarts {
            let x = self.x((*second).into());
            let _ = write!(
                svg,
                "<path class=\"restart\" d=\"M{x:.1} 0V{height:.1}\"><title>second {second}: {words}</title></path>"
            );
        }
    }

    /// Lines of the axis of time through panels that end at `bottom`, and its labels.
    pub(super) fn time_axis(&self, svg: &mut String, bottom: f64) {
        let seconds = f64::from(self.stretches.seconds);
        let steps = [
            1.0,
            2.0,
            5.0,
            10.0,
            20.0,
            60.0,
            120.0,
            300.0,
            600.0,
            1200.0,
            1800.0,
            3600.0,
            7200.0,
            10_800.0,
            21_600.0,
            43_200.0,
            86_400.0,
            172_800.0,
            432_000.0,
            864_000.0,
            1_728_000.0,
        ];
        let labels = 13.0 * self.width / WIDE;
        let step = steps.into_iter().find(|step| seconds / step <= labels).unwrap_or(3_456_000.0);
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
            self.edges().1,
            bottom + AXIS - 2.0
        );
    }

    /// Panels over the axis of time.
    pub fn plot(&self, title: &str, panels: &[Panel<'_>]) -> String {
        let head = if panels.iter().all(|panel| self.notes_fit(panel)) { NAME } else { NAME + NOTES };
        let bottom = panels.len() as f64 * (head + HEIGHT);
        let mut svg = String::new();
        self.open(&mut svg, title, bottom);
        self.time_axis(&mut svg, bottom);
        for (number, panel) in panels.iter().enumerate() {
            self.panel(&mut svg, panel, head, number as f64 * (head + HEIGHT));
        }
        svg.push_str("</svg>");
        svg
    }

    /// Whether a panel's notes fit beside its name.
    fn notes_fit(&self, panel: &Panel<'_>) -> bool {
        let (left, right) = self.edges();
        let letters = |text: &str| text.chars().count() as f64;
        let name = NAME_LETTER * (letters(panel.name) + 1.0 + letters(panel.unit));
        name + NOTE_LETTER * letters(&panel.notes()) < right - left
    }

    /// A panel below `top`, with its name and its notes in a head of this height.
    fn panel(&self, svg: &mut String, panel: &Panel<'_>, head: f64, top: f64) {
        let (left, right) = self.edges();
        let (width, whole) = (right - left, self.width);
        let _ = write!(
            svg,
            "<rect class=\"between\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{head}\"/>\
             <text class=\"name\" x=\"{left}\" y=\"{:.1}\">{} <tspan class=\"unit\">{}</tspan></text>\
             <text class=\"note\" x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <svg x=\"0\" y=\"{}\" width=\"{whole}\" height=\"{HEIGHT}\" viewBox=\"0 0 {whole} {HEIGHT}\">\
             <rect class=\"ground\" x=\"{left}\" y=\"0\" width=\"{width}\" height=\"{HEIGHT}\"/>",
            top + NAME - 7.0,
            panel.name,
            panel.unit,
            top + head - 7.0,
            panel.notes(),
            top + head
        );
        self.shade(svg, HEIGHT);
        let y = |value: f64| HEIGHT * (1.0 - panel.scale.height(value));
        let ticks = panel.scale.ticks();
        for tick in &ticks {
            let (at, text) = (y(*tick), tick_label(*tick, &ticks));
            let class = if *tick == 0.0 { "zero" } else { "grid" };
            let place = (at + 4.0).clamp(10.0, HEIGHT - 2.0);
            let _ = write!(
                svg,
                "<path class=\"{class}\" d=\"M{left} {at:.1}H{right}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{place:.1}\" text-anchor=\"end\">{text}</text>",
                left - 6.0
            );
        }
        if let Some(level) = panel.level {
            let _ = write!(svg, "<path class=\"level\" d=\"M{left} {:.1}H{right:.1}\"/>", y(level));
        }
        self.line(svg, panel, y);
        // Over the curve, so that its edge is seen where the curve fills it.
        if let Some(sigma) = panel.band.filter(|_| !panel.envelope_off_scale()) {
            self.band(svg, sigma, y);
        }
        if let Some(bound) = panel.bound {
            self.bound(svg, bound, y);
        }
        self.restart_lines(svg, HEIGHT);
        if panel.line.is_empty() {
            let _ = write!(
                svg,
                "<text class=\"none\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">not reported in this run</text>",
                left + 0.5 * width,
                0.5 * HEIGHT + 4.0
            );
        }
        svg.push_str("</svg>");
    }

    fn line(&self, svg: &mut String, panel: &Panel<'_>, y: impl Fn(f64) -> f64) {
        let (mut path, mut dots, mut beyond) = (String::new(), String::new(), String::new());
        for piece in pieces(panel.line) {
            for (number, (index, low, high)) in piece.iter().enumerate() {
                let (x, letter) = (self.middle(*index), if number == 0 { 'M' } else { 'L' });
                if piece.len() == 1 {
                    // A line as long as a lone value would not be seen.
                    let _ = write!(dots, "M{x:.1} {:.1}L{:.1} {:.1}", y(*low), x + 0.1, y(*high));
                } else {
                    let _ = write!(path, "{letter}{x:.1} {:.1}", y(*low));
                    if high > low {
                        let _ = write!(path, "L{:.1} {:.1}", x + 0.1, y(*high));
                    }
                }
                if y(*high) < 0.0 {
                    let _ = write!(beyond, "M{x:.1} 0v6");
                }
                if y(*low) > HEIGHT {
                    let _ = write!(beyond, "M{x:.1} {HEIGHT}v-6");
                }
            }
        }
        let _ = write!(svg, "<path class=\"line\" d=\"{path}\"/>");
        if !dots.is_empty() {
            let _ = write!(svg, "<path class=\"dots\" d=\"{dots}\"/>");
        }
        if !beyond.is_empty() {
            let _ = write!(svg, "<path class=\"beyond\" d=\"{beyond}\"/>");
        }
    }

    /// Three times a bound on either side of zero.
    fn bound(&self, svg: &mut String, bound: &Trace, y: impl Fn(f64) -> f64) {
        let mut path = String::new();
        for (piece, side) in pieces(bound).iter().flat_map(|piece| [(piece, 3.0), (piece, -3.0)]) {
            for (number, (index, _, high)) in piece.iter().enumerate() {
                let letter = if number == 0 { 'M' } else { 'L' };
                let _ = write!(path, "{letter}{:.1} {:.1}", self.middle(*index), y(side * high));
            }
        }
        let _ = write!(svg, "<path class=\"bound\" d=\"{path}\"><title>bound</title></path>");
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harness::faults::FaultKind;
    use crate::report::trace::Banded;

    fn banded(sigma: f64, spike: f64) -> Banded {
        let stretches = Stretches::of(4000);
        let mut of = Banded::new(stretches);
        for cycle in 0..4000 {
            let error = if cycle == 1234 { spike } else { f64::from(cycle % 7) - 3.0 };
            of.add(stretches.index(cycle), error, sigma);
        }
        of
    }

    #[test]
    fn an_envelope_that_does_not_fit_is_told_and_not_drawn() {
        let geometry = Marks::new(Stretches::of(4000));
        let frame = Frame {
            stretches: Stretches::of(4000),
            geometry: &geometry,
            faults: &[],
            restarts: &[(70, "orbit restarted".into())],
            width: WIDE,
        };
        let (fits, wide) = (banded(1.0, 0.0), banded(100.0, 0.0));
        let svg = frame.plot("", &[Panel::banded("radial", "km", &fits)]);
        assert!(svg.contains("class=\"band\"") && !svg.contains("off the scale"));
        assert!(svg.contains("second 70: orbit restarted"));
        let svg = frame.plot("", &[Panel::banded("radial", "km", &wide)]);
        assert!(!svg.contains("class=\"band\"") && svg.contains("\u{b1}3\u{3c3} off the scale: 3"), "{svg}");
    }

    #[test]
    fn a_lone_value_is_a_dot_and_long_notes_stand_below_the_name() {
        let stretches = Stretches::of(4000);
        let geometry = Marks::new(stretches);
        let wide = Frame { stretches, geometry: &geometry, faults: &[], restarts: &[], width: WIDE };
        let mut of = Banded::new(stretches);
        [100, 2000].into_iter().for_each(|cycle| of.add(stretches.index(cycle), 1.0, 1.0));
        let svg = wide.plot("", &[Panel::banded("radial", "km", &of)]);
        assert!(svg.contains("class=\"dots\" d=\"M"), "{svg}");
        let beyond = banded(100.0, 0.0);
        let panel = [Panel::banded("about z (line of sight)", "arcsec", &beyond)];
        let half = Frame { width: HALF, ..wide };
        for (frame, height) in [(wide, NAME), (half, NAME + NOTES)] {
            let svg = frame.plot("", &panel);
            assert!(svg.contains(&format!("height=\"{height}\"/>")), "{svg}");
        }
    }

    #[test]
    fn faults_of_the_same_seconds_are_shaded_once() {
        let fault = |row, from_s| Fault { kind: FaultKind::StuckRow(row), from_s, until_s: 900 };
        let geometry = Marks::new(Stretches::of(4000));
        let frame = Frame {
            stretches: Stretches::of(4000),
            geometry: &geometry,
            faults: &[fault(60, 700), fault(512, 700), fault(9, 800)],
            restarts: &[],
            width: WIDE,
        };
        let words: Vec<String> = frame.fault_spans().into_iter().map(|(_, words)| words).collect();
        assert_eq!(words, ["1 stuck-row, 2 stuck-row", "3 stuck-row"]);
    }

    #[test]
    fn a_spike_beyond_the_range_is_marked_and_told() {
        let geometry = Marks::new(Stretches::of(4000));
        let frame = Frame {
            stretches: Stretches::of(4000),
            geometry: &geometry,
            faults: &[],
            restarts: &[],
            width: HALF,
        };
        let of = banded(1.0, 50.0);
        let svg = frame.plot("", &[Panel::banded("radial", "km", &of)]);
        assert!(svg.contains("largest 50") && svg.contains("class=\"beyond\""), "{svg}");
    }
}
