//! Charts of one quantity over another, as SVG files that stand alone.
//!
//! In: axes with their units, curves, points and bands. Out: SVG. Colours are the page's, light and dark. A
//! curve of ours is solid, one of others dashed with diamonds; every curve is named below the panel.

use super::scale::round_up;
use super::standing_alone::standing_alone;
use std::fmt::Write as _;

/// Size of the panel, and margins left, above, right and below it.
const PANEL: [f64; 2] = [660.0, 340.0];
const LEFT: f64 = 84.0;
const TOP: f64 = 40.0;
const RIGHT: f64 = 24.0;
const BELOW: f64 = 52.0;
/// Height of a line of the legend, and width of a letter of it.
const LEGEND: f64 = 21.0;
const LETTER: f64 = 6.6;
/// Share of a range that is left free beyond the farthest values.
const MARGIN: f64 = 0.05;
/// Colours of curves, and dashes of others', in turn.
const COLOURS: usize = 7;
const DASHES: usize = 3;

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What is along it, with its unit.
    pub words: String,
    /// Whether equal factors are equally far.
    pub logarithmic: bool,
    /// Its ends; none: as the values need. The second may be the smaller one.
    pub ends: Option<[f64; 2]>,
}

impl Axis {
    /// Linear.
    pub fn new(words: &str) -> Self {
        Self { words: words.into(), logarithmic: false, ends: None }
    }

    /// Logarithmic.
    pub fn logarithmic(words: &str) -> Self {
        Self { logarithmic: true, ..Self::new(words) }
    }

    /// With these ends.
    pub fn between(self, ends: [f64; 2]) -> Self {
        Self { ends: Some(ends), ..self }
    }

    /// As it is laid along the panel.
    fn bend(&self, value: f64) -> f64 {
        if self.logarithmic { libm::log10(value.max(1e-300)) } else { value }
    }

    /// Its ends, bent.
    fn range(&self, values: impl Iterator<Item = f64>) -> [f64; 2] {
        if let Some(ends) = self.ends {
            return ends.map(|end| self.bend(end));
        }
        let usable = values.filter(|value| value.is_finite() && (!self.logarithmic || *value > 0.0));
        let [low, high] = usable
            .map(|value| self.bend(value))
            .fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)]);
        if low > high {
            return [0.0, 1.0];
        }
        let margin = MARGIN * (high - low).max(1e-9 * high.abs().max(1.0));
        // A curve that begins at zero begins at the edge.
        let low = if low == 0.0 && !self.logarithmic { 0.0 } else { low - margin };
        [low, high + margin]
    }

    /// Values to mark within a range.
    fn ticks(&self, [one, other]: [f64; 2]) -> Vec<f64> {
        let (low, high) = (one.min(other), one.max(other));
        if self.logarithmic && high - low > 0.8 {
            let decades = low.floor() as i32..=high.ceil() as i32;
            let steps: &[f64] = if high - low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
            return all.filter(|tick| (low - 1e-9..=high + 1e-9).contains(&self.bend(*tick))).collect();
        }
        let [low, high] = if self.logarithmic { [low, high].map(|end| 10f64.powf(end)) } else { [low, high] };
        let step = round_up((high - low) / 7.0);
        let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        (first..=last).map(|number| number as f64 * step).collect()
    }
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line through its points.
    Line,
    /// Points with a line through them.
    Marked,
    /// Points alone.
    Points,
}

/// Values over others.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend; empty: it belongs to another.
    pub name: String,
    /// Whether it is the thesis's.
    pub of_thesis: bool,
    /// How it is drawn.
    pub look: Look,
    /// Places; what is no number is a gap.
    pub points: Vec<[f64; 2]>,
    /// A band about it: place, lower and upper edge.
    pub band: Vec<[f64; 3]>,
}

impl Series {
    /// A line of ours.
    pub fn ours(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), of_thesis: false, look: Look::Line, points, band: Vec::new() }
    }

    /// A line of the thesis, or by what it says.
    pub fn thesis(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { of_thesis: true, ..Self::ours(name, points) }
    }

    /// With marks at its points.
    pub fn marked(self) -> Self {
        Self { look: Look::Marked, ..self }
    }

    /// Without a line.
    pub fn as_points(self) -> Self {
        Self { look: Look::Points, ..self }
    }

    /// With a band.
    pub fn within(self, band: Vec<[f64; 3]>) -> Self {
        Self { band, ..self }
    }
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Along the bottom.
    pub x: Axis,
    /// Up the side.
    pub y: Axis,
    /// What is drawn, the first below the others.
    pub series: Vec<Series>,
}

/// What is drawn, its colour's class and its place in the legend.
struct Named<'a> {
    series: &'a Series,
    class: String,
}

impl Chart {
    /// As an SVG file.
    pub fn svg(&self) -> String {
        let [width, height] = PANEL;
        let (mut ours, mut others) = (0, 0);
        let named: Vec<Named> = self
            .series
            .iter()
            .map(|series| Named {
                series,
                class: if series.of_thesis {
                    others += 1;
                    format!("thesis t{}", (others - 1) % DASHES)
                } else {
                    ours += 1;
                    format!("c{}", (ours - 1) % COLOURS)
                },
            })
            .collect();
        let legend = legend(&named);
        let rows = legend.last().map_or(0.0, |(_, _, row)| row + 1.0);
        let whole = [LEFT + width + RIGHT, TOP + height + BELOW + rows * LEGEND + 8.0];
        let mut svg = format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{title}\"><text class=\"name\" x=\"{LEFT}\" y=\"24\">{title}</text>",
            whole[0],
            whole[1],
            title = escaped(&self.title),
        );
        let points = || self.series.iter().flat_map(|series| series.points.iter());
        let bands = || self.series.iter().flat_map(|series| series.band.iter());
        let across = self.x.range(points().map(|point| point[0]).chain(bands().map(|edge| edge[0])));
        let up =
            self.y.range(points().map(|point| point[1]).chain(bands().flat_map(|edge| [edge[1], edge[2]])));
        let x = |value: f64| LEFT + width * (self.x.bend(value) - across[0]) / (across[1] - across[0]);
        let y = |value: f64| TOP + height * (1.0 - (self.y.bend(value) - up[0]) / (up[1] - up[0]));
        self.axes(&mut svg, [across, up], &x, &y);
        let _ = write!(
            svg,
            "<svg x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\" viewBox=\"{LEFT} {TOP} {width} {height}\">"
        );
        named.iter().for_each(|of| of.draw(&mut svg, &x, &y));
        svg.push_str("</svg>");
        let in_legend = named.iter().filter(|of| !of.series.name.is_empty());
        for ((of, left, row), named) in legend.iter().zip(in_legend) {
            let at = TOP + height + BELOW + row * LEGEND + 6.0;
            named.key(&mut svg, *left, at);
            let _ =
                write!(svg, "<text x=\"{:.1}\" y=\"{:.1}\">{}</text>", left + 38.0, at + 4.0, escaped(of));
        }
        svg.push_str("</svg>\n");
        standing_alone(&svg)
    }

    fn axes(
        &self,
        svg: &mut String,
        [across, up]: [[f64; 2]; 2],
        x: &impl Fn(f64) -> f64,
        y: &impl Fn(f64) -> f64,
    ) {
        let ([width, height], bottom) = (PANEL, TOP + PANEL[1]);
        let ticks = self.x.ticks(across);
        for tick in &ticks {
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{at:.1} {TOP}V{bottom}\"/><text class=\"tick\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 17.0,
                label(*tick, &ticks),
                at = x(*tick),
            );
        }
        let ticks = self.y.ticks(up);
        for tick in &ticks {
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{LEFT} {at:.1}h{width}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                y(*tick) + 4.0,
                label(*tick, &ticks),
                at = y(*tick),
            );
        }
        let middle = TOP + 0.5 * height;
        let _ = write!(
            svg,
            "<rect class=\"ground\" x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
             <text x=\"18\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 18 {middle})\">{}</text>",
            LEFT + 0.5 * width,
            bottom + 38.0,
            escaped(&self.x.words),
            escaped(&self.y.words),
        );
    }
}

/// Names with their left edge and line.
fn legend<'a>(named: &[Named<'a>]) -> Vec<(&'a str, f64, f64)> {
    let (mut left, mut row) = (LEFT, 0.0);
    let place = |of: &Named<'a>| {
        let wide = 38.0 + LETTER * of.series.name.chars().count() as f64 + 22.0;
        if left > LEFT && left + wide > LEFT + PANEL[0] + RIGHT {
            (left, row) = (LEFT, row + 1.0);
        }
        let at = (of.series.name.as_str(), left, row);
        left += wide;
        at
    };
    named.iter().filter(|of| !of.series.name.is_empty()).map(place).collect()
}

impl Named<'_> {
    fn draw(&self, svg: &mut String, x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64) {
        let Self { series, class } = self;
        if !series.band.is_empty() {
            let forth = series.band.iter().map(|[at, low, _]| [*at, *low]);
            let back = series.band.iter().rev().map(|[at, _, high]| [*at, *high]);
            let edge: Vec<String> =
                forth.chain(back).map(|[at, value]| format!("{:.1} {:.1}", x(at), y(value))).collect();
            let _ = write!(svg, "<path class=\"area {class}\" d=\"M{}Z\"/>", edge.join("L"));
        }
        if series.look != Look::Points {
            let (mut path, mut begun) = (String::new(), false);
            for [at, value] in &series.points {
                let known = at.is_finite() && value.is_finite();
                if known {
                    let _ = write!(path, "{}{:.1} {:.1}", if begun { 'L' } else { 'M' }, x(*at), y(*value));
                }
                begun = known;
            }
            let others = if series.of_thesis { " others" } else { "" };
            let _ = write!(svg, "<path class=\"curve{others} {class}\" d=\"{path}\"/>");
        }
        if series.look != Look::Line {
            let known = series.points.iter().filter(|point| point.iter().all(|part| part.is_finite()));
            known.for_each(|[at, value]| self.mark(svg, x(*at), y(*value)));
        }
    }

    fn mark(&self, svg: &mut String, x: f64, y: f64) {
        let class = &self.class;
        let _ = if self.series.of_thesis {
            write!(svg, "<path class=\"{class}\" d=\"M{:.1} {y:.1}l5 -5l5 5l-5 5Z\"/>", x - 5.0)
        } else {
            let radius = if self.series.points.len() > 300 { 1.2 } else { 2.8 };
            write!(svg, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>")
        };
    }

    /// Its sample in the legend.
    fn key(&self, svg: &mut String, left: f64, at: f64) {
        let Self { series, class } = self;
        if !series.band.is_empty() {
            let _ = write!(
                svg,
                "<rect class=\"area {class}\" x=\"{left}\" y=\"{}\" width=\"32\" height=\"12\"/>",
                at - 6.0
            );
        }
        if series.look != Look::Points {
            let others = if series.of_thesis { " others" } else { "" };
            let _ = write!(svg, "<path class=\"curve{others} {class}\" d=\"M{left} {at:.1}h32\"/>");
        }
        if series.look != Look::Line {
            self.mark(svg, left + 16.0, at);
        }
    }
}

/// The label of one of these ticks: a power of ten where it is long, else with the digits that tell it from
/// its neighbours.
fn label(tick: f64, ticks: &[f64]) -> String {
    let apart = ticks.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(f64::MAX, f64::min);
    let text = if tick != 0.0 && !(1e-4..1e6).contains(&tick.abs()) {
        format!("{tick:e}")
    } else {
        let finest = if tick == 0.0 { apart } else { apart.min(tick.abs()) };
        let decimals = (-(finest * 1.000_001).log10().floor()).clamp(0.0, 6.0) as usize;
        let text = format!("{tick:.decimals$}");
        let even = text.trim_end_matches('0').trim_end_matches('.').to_owned();
        if text.contains('.') { even } else { text }
    };
    text.replace('-', "\u{2212}")
}

/// Text fit for a drawing.
fn escaped(text: &str) -> String {
    super::page::escaped(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let linear = Axis::new("x");
        assert_eq!(linear.ticks([0.0, 7.0]), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(linear.ticks([10.0, 0.0]).len(), 6, "an axis may run downwards");
        let logarithmic = Axis::logarithmic("x");
        assert_eq!(logarithmic.ticks([0.0, 2.0]), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(logarithmic.ticks([-3.0, 1.0]).len(), 5, "decades alone where there are many");
    }

    #[test]
    fn labels_tell_neighbours_apart() {
        let words = |ticks: &[f64]| ticks.iter().map(|tick| label(*tick, ticks)).collect::<Vec<_>>();
        assert_eq!(words(&[73.65, 73.7, 73.75]), ["73.65", "73.7", "73.75"]);
        assert_eq!(words(&[1e-9, 1e-8]), ["1e\u{2212}9", "1e\u{2212}8"]);
        assert_eq!(words(&[-0.5, 0.0, 0.5]), ["\u{2212}0.5", "0", "0.5"]);
        assert_eq!(words(&[1.0, 10.0, 100.0]), ["1", "10", "100"]);
    }

    #[test]
    fn both_are_named_and_a_gap_stays_one() {
        let ours = Series::ours("ours <1>", vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0]]);
        let thesis = Series::thesis("thesis", vec![[0.0, 2.0], [2.0, 2.0]]).marked();
        let chart = Chart {
            title: "t".into(),
            x: Axis::new("time, s"),
            y: Axis::new("error, px"),
            series: vec![ours, thesis],
        };
        let svg = chart.svg();
        for words in ["ours &lt;1&gt;", ">thesis<", "time, s", "error, px", "xmlns="] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        assert!(!svg.contains("NaN"));
        let curve = svg.split("class=\"curve c0\" d=\"").nth(1).unwrap();
        assert_eq!(curve.split('"').next().unwrap().matches('M').count(), 2);
        assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
    }
}
