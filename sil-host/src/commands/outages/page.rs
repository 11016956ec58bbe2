//! The page of outages: of each orbit its states over time as thesis figs. 8.5 to 8.10 have them, and a
//! table.

use super::{LISTED, Outlook, words};
use crate::report::page::{self, TABLE, TABLE_END, escaped};
use crate::report::plot::{Frame, WIDE};
use crate::report::strip::Rows;
use crate::report::trace::{Marks, Stretches};
use std::fmt::Write as _;

/// The page of all orbits.
pub fn html(outlooks: &[Outlook]) -> String {
    let mut page = page::opening("Outages");
    let _ = write!(
        page,
        "<h1>What the sensor will be able to do</h1><p>States of thesis table 8.1, predicted by the flight code \
         from orbit, pointing and camera: {}. With the Sun in a path the detector is blinded; in eclipse the \
         stars are seen and the orbit is propagated.</p>",
        [0, 1, 2, 3, 4].map(words).join("; ")
    );
    outlooks.iter().for_each(|outlook| section(&mut page, outlook));
    page.push_str(page::CLOSING);
    page
}

/// The states over time, as inline SVG.
pub fn strip(outlook: &Outlook) -> String {
    let stretches = Stretches::of(outlook.duration_s);
    let (mut flown, none) = (Marks::new(stretches), Marks::new(stretches));
    for interval in outlook.states.iter().filter(|interval| interval.duration_s > 0) {
        let [first, last] = [interval.begin_s, interval.end_s - 1].map(|second| stretches.index(second));
        (first..=last).for_each(|index| flown.add(index, interval.state));
    }
    let frame = Frame { stretches, geometry: &none, faults: &[], restarts: &[], width: WIDE };
    let names = [0, 1, 2, 3, 4].map(|state| format!("state {state}"));
    let names = names.each_ref().map(String::as_str);
    frame.strip("sensor states", &Rows { names: &names, expected: &none, flown: &flown, wrong: &none })
}

/// Height of the strip of five states, of the title above it and of a line of the states' names below.
const STRIP: f64 = 150.0;
const TITLE: f64 = 38.0;
const LINE: f64 = 18.0;

/// The states over time under a title, the states named: a drawing that stands without a page.
pub fn drawing(title: &str, outlook: &Outlook) -> String {
    let title = escaped(title);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDE} {}\" role=\"img\" aria-label=\"{title}\"><text class=\"name\" x=\"74\" y=\"24\">{title}</text>",
        TITLE + STRIP + 3.0 * LINE
    );
    let placed = format!("<svg x=\"0\" y=\"{TITLE}\" width=\"{WIDE}\" height=\"{STRIP}\" ");
    svg += &strip(outlook).replacen("<svg ", &placed, 1);
    for state in 0..=4 {
        let (column, line) = (f64::from(state % 2), f64::from(state / 2));
        let (x, y) = (74.0 + 440.0 * column, TITLE + STRIP + LINE * (line + 0.7));
        let _ = write!(svg, "<text x=\"{x}\" y=\"{y:.1}\">state {}</text>", words(state));
    }
    svg.push_str("</svg>\n");
    svg
}

fn section(page: &mut String, outlook: &Outlook) {
    let Outlook { orbit, description, start_utc, duration_s, states, totals, .. } = outlook;
    let _ = write!(
        page,
        "<h2>{}</h2><p class=\"soft\">{}. {duration_s} s from {} UTC.</p><figure>{}</figure>\
         {TABLE}<tr><th>state</th><th>share</th><th>seconds</th><th>times</th><th>shortest, longest, s</th></tr>",
        escaped(orbit),
        escaped(description),
        escaped(start_utc),
        strip(outlook),
    );
    for total in totals {
        let spans = match (total.shortest_s, total.longest_s) {
            (Some(shortest), Some(longest)) => format!("{shortest}, {longest}"),
            _ => "\u{2013}".to_owned(),
        };
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{:.2} %</td><td>{}</td><td>{}</td><td>{spans}</td></tr>",
            words(total.state),
            100.0 * total.share,
            total.seconds,
            total.count
        );
    }
    page.push_str(TABLE_END);
    if states.len() > LISTED {
        return;
    }
    let _ = write!(page, "{TABLE}<tr><th>from, s</th><th>to, s</th><th>seconds</th><th>state</th></tr>");
    for interval in states {
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            interval.begin_s,
            interval.end_s,
            interval.duration_s,
            words(interval.state)
        );
    }
    page.push_str(TABLE_END);
}
