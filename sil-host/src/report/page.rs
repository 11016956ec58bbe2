//! The page itself.

use super::plot::{Frame, Panel};
use super::trace::Banded;
use super::{MODE_ROWS, Recorder, figures_table, frames};
use crate::error::HostError;
use crate::judge::{Figures, Verdict};
use crate::scenario::Scenario;
use crate::world::pointing::Law;
use crate::world::scene::Scene;
use std::fmt::Write as _;

/// Levels beside the innovation: 95 % of a chi-square number of nine degrees of freedom, over nine.
const NIS_95: f64 = 1.88;

/// Text fit for a page.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A time of the run.
fn clock(second: u32) -> String {
    format!("{}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60)
}

/// Writes the page.
///
/// # Errors
/// When a frame cannot be drawn again.
pub fn html(
    scenario: &Scenario,
    recorder: Recorder,
    figures: &Figures,
    verdicts: &[Verdict],
    scene: &mut Scene,
) -> Result<String, HostError> {
    let mut page = String::new();
    head(&mut page, scenario, verdicts);
    verdict_table(&mut page, verdicts);
    figures_section(&mut page, figures);
    plots(&mut page, &recorder);
    disagreements(&mut page, figures);
    frames_section(&mut page, &recorder, scene, scenario.exposure_us)?;
    events(&mut page, &recorder);
    setting(&mut page, scenario);
    page.push_str("</main></body></html>\n");
    Ok(page)
}

fn head(page: &mut String, scenario: &Scenario, verdicts: &[Verdict]) {
    let missed = verdicts.iter().filter(|verdict| !verdict.kept).count();
    let (class, words) = match (verdicts.is_empty(), missed) {
        (true, _) => ("none", "no limits".to_owned()),
        (false, 0) => ("good", "limits kept".to_owned()),
        (false, 1) => ("bad", "1 limit missed".to_owned()),
        (false, missed) => ("bad", format!("{missed} limits missed")),
    };
    let name = escaped(&scenario.name);
    let _ = write!(
        page,
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{name} \u{2013} Sextant</title><style>{}</style></head><body><main>\
         <h1>{name}<span class=\"badge {class}\">{words}</span></h1><p>{}. {} from {} UTC, one second a cycle, seed {}.</p>",
        include_str!("page.css"),
        escaped(&scenario.description),
        clock(scenario.duration_s),
        escaped(&scenario.start_utc),
        scenario.seed
    );
}

fn verdict_table(page: &mut String, verdicts: &[Verdict]) {
    if verdicts.is_empty() {
        return;
    }
    page.push_str("<table><tr><th>Limit</th><th>Demanded</th><th>Reached</th><th></th></tr>");
    for verdict in verdicts {
        let [what, demanded, reached] = figures_table::verdict(verdict);
        let (class, word) = if verdict.kept { ("good", "\u{2713} kept") } else { ("bad", "\u{2717} missed") };
        let _ = write!(
            page,
            "<tr><td>{what}</td><td>{demanded}</td><td>{reached}</td><td class=\"{class}\">{word}</td></tr>"
        );
    }
    page.push_str("</table>");
}

fn figures_section(page: &mut String, figures: &Figures) {
    page.push_str("<h2>Figures</h2><p class=\"soft\">Estimate less truth. Errors and sigmas: of the last orbit. The mean square of \
        error over sigma: of the run, 1 where the sigmas are right; 99 % of runs with right sigmas lie between the limits beside it, \
        which allow for errors that go together for minutes.</p><table>");
    for (index, row) in figures_table::quantities(figures).iter().enumerate() {
        let cell = if index == 0 { "th" } else { "td" };
        page.push_str("<tr>");
        row.iter().for_each(|text| {
            let _ = write!(page, "<{cell}>{text}</{cell}>");
        });
        page.push_str("</tr>");
    }
    page.push_str("</table><table><tr><th>What</th><th>Reached</th><th>Beside</th></tr>");
    for line in figures_table::lines(figures) {
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td><td class=\"soft\">{}</td></tr>",
            line.what, line.reached, line.beside
        );
    }
    page.push_str("</table>");
}

fn section(page: &mut String, title: &str, words: &str, svg: &str) {
    let _ = write!(page, "<h2>{title}</h2><p class=\"soft\">{words}</p><figure>{svg}</figure>");
}

fn three<'a>(names: [&'a str; 3], unit: &'a str, of: &'a [Banded; 3]) -> Vec<Panel<'a>> {
    names.into_iter().zip(of).map(|(name, banded)| Panel::banded(name, unit, banded)).collect()
}

fn plots(page: &mut String, recorder: &Recorder) {
    let frame = Frame { stretches: recorder.stretches, geometry: &recorder.geometry };
    page.push_str(
        "<p style=\"margin-top:40px\" class=\"soft\"><span class=\"key\" style=\"background:var(--line)\"></span>error, least to \
         greatest of every stretch<span class=\"key\" style=\"background:var(--band)\"></span>\u{b1} 3 reported sigma\
         <span class=\"key\" style=\"background:var(--dark)\"></span>eclipse\
         <span class=\"key\" style=\"background:var(--sun)\"></span>Sun in a path. Where a curve spans orders of magnitude the scale \
         is logarithmic away from zero.</p>",
    );
    let strip = frame.strip("Modes", &MODE_ROWS, &recorder.expected, &recorder.flown, &recorder.wrong);
    let words = "Pale: what the geometry asks for. Solid: what was flown; red where it is neither right nor on its way there.";
    section(page, "Modes", words, &strip);
    let panels = three(["about x", "about y", "about z (line of sight)"], "arcsec", &recorder.attitude);
    section(page, "Attitude error", "Star path axes.", &frame.plot("Attitude error", &panels));
    let names = ["about x", "about y", "about z (line of sight)"];
    let panels = names.iter().zip(&recorder.rate);
    let panels: Vec<Panel<'_>> = panels.map(|(name, rate)| Panel::signed(name, "arcsec/s", rate)).collect();
    section(
        page,
        "Rate error",
        "Star path axes; the sensor reports no sigma of it.",
        &frame.plot("Rate error", &panels),
    );
    let panels = three(["radial", "along track", "cross track"], "km", &recorder.position);
    let words =
        "The envelope takes the errors of the ICRS axes as uncorrelated; limits are judged in ICRS axes.";
    section(page, "Position error", words, &frame.plot("Position error", &panels));
    let panels = three(["radial", "along track", "cross track"], "m/s", &recorder.velocity);
    section(page, "Velocity error", words, &frame.plot("Velocity error", &panels));
    let [x, y, distance] = &recorder.earth;
    let panels = [
        Panel::banded("direction, x", "deg", x),
        Panel::banded("direction, y", "deg", y),
        Panel::banded("distance", "km", distance),
    ];
    let words = "The Earth's centre as found in each frame alone, Earth path axes.";
    section(page, "Earth vector error", words, &frame.plot("Earth vector error", &panels));
    let panels = [
        Panel::counted("stars used", "", &recorder.stars, None),
        Panel::counted("limb points", "", &recorder.limb_points, None),
        Panel::counted("lit limb in the field (truth)", "deg", &recorder.lit_limb, None),
        Panel::counted(
            "innovation squared (NIS) of a degree of freedom",
            "95 % lie below the line",
            &recorder.nis,
            Some(NIS_95),
        ),
        Panel::banded("limb height, estimated", "km", &recorder.limb_height),
    ];
    section(page, "What it rests on", "", &frame.plot("What it rests on", &panels));
}

fn disagreements(page: &mut String, figures: &Figures) {
    if figures.disagreements.is_empty() {
        return;
    }
    page.push_str(
        "<h2>Longest disagreements of the mode</h2><table><tr><th>From</th><th>Seconds</th><th>Flown</th><th>Expected</th></tr>",
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
    page.push_str("</table>");
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
        "<h2>Frames</h2><p class=\"soft\">Blue circles: stars recognised, with Hipparcos numbers. Green: limb points. Dashed: the limb \
         of the ellipsoid at the centre and distance found. Half size, stretched.</p><div class=\"frames\">",
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

fn events(page: &mut String, recorder: &Recorder) {
    page.push_str("<h2>Events</h2><table><tr><th>Time</th><th>Cycle</th><th>What</th></tr>");
    for (cycle, words) in &recorder.events {
        let _ = write!(page, "<tr><td>{}</td><td>{cycle}</td><td>{words}</td></tr>", clock(*cycle));
    }
    page.push_str("</table>");
    if recorder.events_left_out > 0 {
        let _ = write!(page, "<p class=\"soft\">and {} more, in cycles.csv</p>", recorder.events_left_out);
    }
}

/// Where the Earth path looks.
fn pointing_words(scenario: &Scenario) -> String {
    let mut words = match &scenario.pointing.law {
        Law::Nadir { off_nadir_deg, roll_deg } => {
            format!("{off_nadir_deg} deg off nadir towards flight, rolled by {roll_deg} deg")
        }
        Law::Inertial(aim) => {
            format!(
                "right ascension {} deg, declination {} deg, rolled by {} deg",
                aim.ra_deg, aim.dec_deg, aim.roll_deg
            )
        }
        Law::Spin(tumble) => {
            let [x, y, z] = tumble.at(0.0).rate_rad_s.map(f64::to_degrees);
            format!("turning freely, at the start {x:.3}, {y:.3}, {z:.3} deg/s about x, y, z")
        }
    };
    if !scenario.pointing.slews.is_empty() {
        let _ = write!(words, "; slews: {}", scenario.pointing.slews.len());
    }
    if scenario.jitter.is_some() {
        words += "; with jitter";
    }
    words
}

fn setting(page: &mut String, scenario: &Scenario) {
    let camera = &scenario.camera;
    let [rx, ry, rz] = scenario.position_km.map(|value| format!("{value:.3}"));
    let [vx, vy, vz] = scenario.velocity_km_s.map(|value| format!("{value:.6}"));
    let [a, b, c] = scenario.mount.star_path_deg;
    let rows = [
        ("Position at the start, ICRS", format!("{rx}, {ry}, {rz} km")),
        ("Velocity at the start, ICRS", format!("{vx}, {vy}, {vz} km/s")),
        ("Period", format!("{:.0} s", scenario.period_s())),
        ("Earth path", pointing_words(scenario)),
        (
            "Star path",
            format!(
                "turned by {a}, {b}, {c} deg about x, y, z of the Earth path{}",
                if camera.mirrored { ", mirrored" } else { "" }
            ),
        ),
        (
            "Camera",
            format!(
                "{} x {} px, f = {} px, {} bits, {} ms",
                camera.width_px,
                camera.height_px,
                camera.focal_length_px,
                camera.bits,
                f64::from(scenario.exposure_us) * 1e-3
            ),
        ),
        (
            "A frame holds",
            format!(
                "{} false stars, {} hot pixels, {} dead ones, {}",
                scenario.disturbances.false_stars,
                scenario.disturbances.hot_pixels,
                scenario.disturbances.dead_low + scenario.disturbances.dead_high,
                scenario.disturbances.protons
            ),
        ),
    ];
    page.push_str("<h2>Setting</h2><table>");
    for (what, value) in rows {
        let _ = write!(page, "<tr><td>{what}</td><td>{value}</td></tr>");
    }
    page.push_str("</table>");
}
