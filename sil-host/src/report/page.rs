//! The page itself: verdict, frames, figures, plots, orbit, events, setting, terms.

mod plots;
mod setting;
mod whereabouts;

use super::figures_table;
use super::glossary::TERMS;
use super::opinion::{Opinion, duration};
use super::{Recorder, frames};
use crate::error::HostError;
use crate::judge::series::SigmaFit;
use crate::judge::{Figures, Verdict};
use crate::scenario::Scenario;
use crate::world::scene::Scene;
use std::fmt::Write as _;

/// Text fit for a page.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A time of the run.
fn clock(second: u32) -> String {
    format!("{}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60)
}

/// A table that a narrow window scrolls.
pub const TABLE: &str = "<div class=\"scroll\"><table>";
/// Its end.
pub const TABLE_END: &str = "</table></div>";

/// What every page of this program ends with.
pub const CLOSING: &str = "</main></body></html>\n";

/// The colours of every page of this program, light and dark.
pub const PALETTE: &str = include_str!("palette.css");

/// What every page of this program begins with; `title` is fit for a page.
pub fn opening(title: &str) -> String {
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title} \u{2013} Sextant</title><style>{PALETTE}{}</style></head><body><main>",
        include_str!("page.css"),
    )
}

/// Writes the page; `command` makes the run again.
///
/// # Errors
/// When a frame cannot be drawn again.
pub fn html(
    scenario: &Scenario,
    recorder: &Recorder,
    (figures, verdicts): (&Figures, &[Verdict]),
    scene: &mut Scene,
    command: &str,
) -> Result<String, HostError> {
    let mut page = String::new();
    head(&mut page, scenario, &Opinion::of(figures, verdicts), command);
    frames_section(&mut page, recorder, scene, scenario.exposure_us)?;
    verdict_table(&mut page, verdicts);
    figures_section(&mut page, figures);
    plots::all(&mut page, recorder, figures);
    whereabouts::write(&mut page, recorder.last_orbit.as_ref());
    disagreements(&mut page, figures);
    faults(&mut page, recorder);
    events(&mut page, recorder);
    setting::write(&mut page, scenario);
    glossary(&mut page);
    page.push_str(CLOSING);
    Ok(page)
}

fn head(page: &mut String, scenario: &Scenario, opinion: &Opinion, command: &str) {
    let class = opinion.grade.class();
    let name = escaped(&scenario.name);
    *page += &opening(&name);
    let _ = write!(page, "<h1>{name}<span class=\"badge {class}\">{}</span></h1>", opinion.badge);
    let _ = write!(
        page,
        "<p class=\"sentence {class}\">{}</p><p>{}</p>\
         <p class=\"soft\">Flown: {}. {} from {} UTC, one second a cycle, seed {}. Sextant {}. \
         The same run again: <code>{}</code></p>",
        opinion.sentence(),
        opinion.reached,
        escaped(&scenario.description),
        duration(scenario.duration_s),
        escaped(&scenario.start_utc),
        scenario.seed,
        env!("CARGO_PKG_VERSION"),
        escaped(command)
    );
}

fn verdict_table(page: &mut String, verdicts: &[Verdict]) {
    if verdicts.is_empty() {
        return;
    }
    let _ = write!(
        page,
        "<h2>Limits</h2>{TABLE}<tr><th>Limit</th><th>Demanded</th><th>Reached</th><th></th></tr>"
    );
    for verdict in figures_table::missed_first(verdicts) {
        let [what, demanded, reached] = figures_table::verdict(verdict);
        let (row, class, word) = if verdict.kept {
            ("", "good", "\u{2713} kept")
        } else {
            (" class=\"missed\"", "bad", "\u{2717} MISSED")
        };
        let _ = write!(
            page,
            "<tr{row}><td>{what}</td><td>{demanded}</td><td>{reached}</td><td class=\"{class}\">{word}</td></tr>"
        );
    }
    page.push_str(TABLE_END);
}

fn figures_section(page: &mut String, figures: &Figures) {
    let _ = write!(
        page,
        "<h2>Figures</h2><p class=\"soft\">Estimate less truth. Errors and sigmas: of the last orbit, all axes together. The mean \
         square of error over sigma (e/\u{3c3}): of the run, 1 where the sigmas are right; 99 % of runs with right sigmas lie in the \
         range beside it, which allows for errors that go together for minutes.</p>{TABLE}<tr><th>Error</th><th>rms</th>\
         <th>95 %</th><th>sigma</th><th></th><th>within 3\u{3c3}</th><th>(e/\u{3c3})\u{b2}</th><th>right between</th><th>sigmas are</th></tr>"
    );
    for row in figures_table::quantities(figures) {
        let (missed, class) = match row.fit {
            SigmaFit::Right => ("", "good"),
            _ => (" class=\"missed\"", "bad"),
        };
        let _ = write!(
            page,
            "<tr{missed}><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"soft\">{}</td>\
             <td class=\"{class}\">{}</td></tr>",
            row.what,
            row.rms,
            row.error_95,
            row.sigma,
            row.unit,
            row.within,
            row.square,
            row.band,
            row.word()
        );
    }
    let _ = write!(page, "{TABLE_END}{TABLE}<tr><th>What</th><th>Reached</th><th>Beside</th></tr>");
    for line in figures_table::lines(figures) {
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td><td class=\"soft\">{}</td></tr>",
            line.what, line.reached, line.beside
        );
    }
    page.push_str(TABLE_END);
}

fn disagreements(page: &mut String, figures: &Figures) {
    if figures.disagreements.is_empty() {
        return;
    }
    let _ = write!(
        page,
        "<h2>Longest disagreements of the mode</h2>{TABLE}<tr><th>From</th><th>Seconds</th><th>Flown</th><th>Expected</th></tr>",
    );
    for stretch in &figures.disagreements {
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            clock(stretch.from_s),
            stretch.seconds,
            stretch.mode,
            stretch.expected
        );
    }
    page.push_str(TABLE_END);
}

fn frames_section(
    page: &mut String,
    recorder: &Recorder,
    scene: &mut Scene,
    exposure_us: u32,
) -> Result<(), HostError> {
    let moments = recorder.moments.clone().into_vec();
    if moments.is_empty() {
        return Ok(());
    }
    page.push_str(
        "<h2>Frames</h2><p class=\"soft\">What the detector saw, and what the flight software found in it. Blue circles: stars \
         recognised, with Hipparcos numbers. Green: limb points. Dashed: the limb of the ellipsoid at the centre and distance found. \
         Half size, stretched.</p><div class=\"frames\">",
    );
    for moment in &moments {
        let svg = frames::draw(scene, moment, exposure_us)?;
        let report = &moment.report;
        let _ = write!(
            page,
            "<figure>{svg}<figcaption>{} \u{2013} {} after the start, {} stars, {} limb points, {:.0}\u{b0} of lit limb</figcaption></figure>",
            moment.title,
            clock(report.cycle),
            report.stars.len(),
            report.limb_px.len(),
            moment.lit_limb_deg
        );
    }
    page.push_str("</div>");
    Ok(())
}

/// What was broken, by the numbers of the plot of modes.
fn faults(page: &mut String, recorder: &Recorder) {
    if recorder.faults.is_empty() {
        return;
    }
    let _ = write!(
        page,
        "<h2>Injected faults</h2>{TABLE}<tr><th>Number</th><th>What breaks</th><th>From</th><th>To</th><th>Seconds</th></tr>"
    );
    for (number, fault) in (1..).zip(&recorder.faults) {
        let _ = write!(
            page,
            "<tr><td>{number}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            fault.kind.word(),
            clock(fault.from_s),
            clock(fault.until_s),
            fault.until_s - fault.from_s
        );
    }
    page.push_str(TABLE_END);
}

fn events(page: &mut String, recorder: &Recorder) {
    let _ = write!(page, "<h2>Events</h2>{TABLE}<tr><th>Time</th><th>Cycle</th><th>What</th></tr>");
    for (cycle, words) in &recorder.events {
        let _ = write!(page, "<tr><td>{}</td><td>{cycle}</td><td>{words}</td></tr>", clock(*cycle));
    }
    page.push_str(TABLE_END);
    if recorder.events_left_out > 0 {
        let _ = write!(page, "<p class=\"soft\">and {} more, in cycles.csv</p>", recorder.events_left_out);
    }
}

fn glossary(page: &mut String) {
    page.push_str("<h2>Terms</h2><dl>");
    for (term, meaning) in TERMS {
        let _ = write!(page, "<dt>{term}</dt><dd>{meaning}</dd>");
    }
    page.push_str("</dl>");
}
