//! The plot of modes: what the geometry asks for, what was flown, and what was broken meanwhile.

use super::plot::Frame;
use super::trace::Marks;
use std::fmt::Write as _;

/// Height of a row.
const ROW: f64 = 24.0;

/// What was the case: a row is a bit of each.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Names of the rows.
    pub names: &'a [&'a str],
    /// Drawn pale.
    pub expected: &'a Marks,
    /// Drawn solid.
    pub flown: &'a Marks,
    /// Drawn over it in another colour.
    pub wrong: &'a Marks,
}

impl Frame<'_> {
    /// The rows over the axis of time; above them the faults, by their numbers, where there are any.
    pub fn strip(&self, title: &str, rows: &Rows<'_>) -> String {
        let first = if self.faults.is_empty() { 0.0 } else { ROW };
        let bottom = first + rows.names.len() as f64 * ROW;
        let mut svg = String::new();
        self.open(&mut svg, title, bottom);
        self.time_axis(&mut svg, bottom);
        if !self.faults.is_empty() {
            self.fault_row(&mut svg);
        }
        for (bit, name) in rows.names.iter().enumerate() {
            let top = first + bit as f64 * ROW;
            for (marks, class, inset) in
                [(rows.expected, "expected", 2.0), (rows.flown, "flown", 8.0), (rows.wrong, "wrong", 8.0)]
            {
                for run in marks.runs(bit as u8) {
                    let (left, width) = self.span(run);
                    let _ = write!(
                        svg,
                        "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                        top + inset,
                        // A single second of a day must be seen too.
                        width.max(1.5),
                        ROW - 2.0 * inset
                    );
                }
            }
            self.row_name(&mut svg, name, top);
        }
        svg.push_str("</svg>");
        svg
    }

    fn fault_row(&self, svg: &mut String) {
        for (fault, words) in self.fault_spans() {
            let (left, width) = self.span_of(fault);
            let _ = write!(
                svg,
                "<rect class=\"fault\" x=\"{left:.1}\" y=\"2\" width=\"{width:.1}\" height=\"{:.1}\"><title>{words}</title></rect>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"16\" text-anchor=\"middle\">{}</text>",
                ROW - 4.0,
                left + 0.5 * width,
                numbers(&words)
            );
        }
        self.row_name(svg, "faults", 0.0);
    }

    fn row_name(&self, svg: &mut String, name: &str, top: f64) {
        let (left, right) = self.edges();
        let _ = write!(
            svg,
            "<path class=\"grid\" d=\"M{left} {:.1}H{right:.1}\"/>\
             <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>",
            top + ROW,
            left - 6.0,
            top + 16.0
        );
    }
}

/// The numbers of faults named together.
fn numbers(words: &str) -> String {
    let numbers = words.split(", ").filter_map(|fault| fault.split(' ').next());
    numbers.collect::<Vec<_>>().join("+")
}
