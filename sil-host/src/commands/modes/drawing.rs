//! The diagram of modes, as SVG.
//!
//! In: the tables of transitions. Out: a box a mode, an arrow for every pair of modes that rows lead between,
//! with their numbers. A row that leaves most modes is one arrow from the frame about them. Dashed: commands
//! and damage, with their letters.

use super::letter;
use crate::judge::expected::word;
use crate::report::standing_alone::standing_alone;
use fsw_core::modes::{FORCED, Mode, TRANSITIONS};
use std::fmt::Write as _;

type Point = [f64; 2];

const SIZE: Point = [720.0, 480.0];
/// Half the size of a box.
const HALF: Point = [74.0, 19.0];
/// Corner and size of the frame about the modes that work.
const FRAME: [Point; 2] = [[20.0, 22.0], [680.0, 318.0]];
/// A row that leaves more modes than these begins at the frame.
const MOST_ARROWS: usize = 3;
/// Half the distance between arrows to and fro, px.
const APART: f64 = 8.0;
/// Width of a letter of a label, px.
const LETTER: f64 = 6.6;
/// Where a label stands, as a share of its arrow.
const LABEL: f64 = 0.3;

/// The middle of a mode's box.
fn place(mode: Mode) -> Point {
    match mode {
        Mode::SelfTest => [110.0, 80.0],
        Mode::Acquisition => [340.0, 80.0],
        Mode::Tracking => [600.0, 80.0],
        Mode::SunOutage => [340.0, 270.0],
        Mode::Eclipse => [600.0, 270.0],
        Mode::Safe => [110.0, 430.0],
        Mode::CommandedSafe => [480.0, 430.0],
    }
}

/// An arrow with its label.
fn arrow(svg: &mut String, [x, y]: Point, [to_x, to_y]: Point, label: &str, dashed: bool) {
    let dashes = if dashed { " stroke-dasharray=\"5 4\"" } else { "" };
    let (at_x, at_y) = (x + LABEL * (to_x - x), y + LABEL * (to_y - y));
    let half = 0.5 * LETTER * (label.len() + 1) as f64;
    let _ = write!(
        svg,
        "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{to_x:.1}\" y2=\"{to_y:.1}\" class=\"arrow\"{dashes} \
         stroke-width=\"1.4\" marker-end=\"url(#head)\"/><rect class=\"paper\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" \
         height=\"16\"/><text x=\"{at_x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
        at_x - half,
        at_y - 8.0,
        2.0 * half,
        at_y + 4.0
    );
}

/// From box to box, a little to the right of the line between their middles.
fn between(svg: &mut String, from: Mode, to: Mode, label: &str) {
    let (one, other) = (place(from), place(to));
    let way = [other[0] - one[0], other[1] - one[1]];
    let length = way[0].hypot(way[1]);
    let aside = [-way[1] / length * APART, way[0] / length * APART];
    // The share of the way that is inside a box, of an arrow that is so far aside in its direction.
    let inside = |side: f64| {
        let share = |axis: usize| (HALF[axis] - side * aside[axis] * way[axis].signum()) / way[axis].abs();
        (0..2).filter(|axis| way[*axis] != 0.0).map(share).fold(1.0, f64::min)
    };
    let at = |share: f64| [0, 1].map(|axis| one[axis] + aside[axis] + share * way[axis]);
    arrow(svg, at(inside(1.0)), at(1.0 - inside(-1.0)), label, false);
}

/// The letters of commands and damage for which this holds.
fn letters(of: impl Fn(Option<Mode>) -> bool) -> String {
    let rows = FORCED.iter().enumerate().filter(|(_, row)| of(row.to) && row.from == Mode::ALL);
    rows.map(|(number, _)| letter(number).to_string()).collect::<Vec<_>>().join(", ")
}

/// The drawing.
pub(super) fn svg() -> String {
    let mut svg = format!(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Modes and what leads from one to another\"><defs><marker \
         id=\"head\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\"><path \
         d=\"M0 0.5L8 4L0 7.5Z\" class=\"head\"/></marker></defs>",
        SIZE[0], SIZE[1]
    );
    let [[left, top], [width, height]] = FRAME;
    let bottom = top + height;
    let _ = write!(
        svg,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" rx=\"14\" class=\"ground\" \
         stroke-width=\"1.4\"/>"
    );
    // Each pair once, with the numbers of all its rows.
    let mut pairs: Vec<(Mode, Mode, Vec<String>)> = Vec::new();
    for (number, row) in (1..).zip(TRANSITIONS) {
        if row.from.len() > MOST_ARROWS {
            for to in row.to {
                let [x, y] = place(*to);
                arrow(&mut svg, [x, bottom], [x, y - HALF[1]], &format!("{number}"), false);
            }
            continue;
        }
        for (from, to) in row.from.iter().flat_map(|from| row.to.iter().map(move |to| (*from, *to))) {
            match pairs.iter_mut().find(|(one, other, _)| (*one, *other) == (from, to)) {
                Some((_, _, numbers)) => numbers.push(number.to_string()),
                None => pairs.push((from, to, vec![number.to_string()])),
            }
        }
    }
    for (from, to, numbers) in &pairs {
        between(&mut svg, *from, *to, &numbers.join(", "));
    }
    let [x, y] = place(Mode::CommandedSafe);
    let into = letters(|to| to == Some(Mode::CommandedSafe));
    let out = letters(|to| to.is_some_and(|to| to != Mode::CommandedSafe));
    arrow(&mut svg, [x - 30.0, bottom], [x - 30.0, y - HALF[1]], &into, true);
    arrow(&mut svg, [x + 30.0, y - HALF[1]], [x + 30.0, bottom], &out, true);
    for mode in Mode::ALL {
        let [x, y] = place(mode);
        let _ = write!(
            svg,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"8\" class=\"box\" \
             stroke-width=\"1.6\"/><text class=\"name\" x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            x - HALF[0],
            y - HALF[1],
            2.0 * HALF[0],
            2.0 * HALF[1],
            y + 5.0,
            word(mode)
        );
    }
    standing_alone(&(svg + "</svg>\n"))
}
