//! The plots of the page, and the orbit.

use super::{TABLE, TABLE_END};
use crate::judge::Figures;
use crate::judge::quantities::QUANTITIES;
use crate::judge::series::SigmaFit;
use crate::report::Recorder;
use crate::report::panel::Panel;
use crate::report::plot::{Frame, HALF, WIDE};
use crate::report::recorder::MODE_ROWS;
use crate::report::scale::label;
use crate::report::strip::Rows;
use crate::report::trace::Banded;
use std::fmt::Write as _;

/// Level beside the innovation: 95 % of a chi-square number of nine degrees of freedom, over nine.
const NIS_95: f64 = 1.88;
const ATTITUDE_AXES: [&str; 3] = ["about x", "about y", "about z (line of sight)"];
const ORBIT_AXES: [&str; 3] = ["radial", "along track", "cross track"];

/// All plots.
pub(super) fn all(page: &mut String, recorder: &Recorder, figures: &Figures) {
    let wide = Frame {
        stretches: recorder.stretches,
        geometry: &recorder.geometry,
        faults: &recorder.faults,
        restarts: &recorder.restarts,
        width: WIDE,
    };
    legend(page, recorder);
    let rows = Rows {
        names: &MODE_ROWS,
        expected: &recorder.expected,
        flown: &recorder.flown,
        wrong: &recorder.wrong,
    };
    let words = "Pale: what the geometry asks for. Solid: what was flown; red where it is neither right nor on its way there.";
    section(page, "Modes", words, &wide.strip("Modes", &rows));
    attitude(page, recorder, &wide);
    orbit(page, recorder, &wide);
    histograms(page, recorder, figures);
    geometry(page, recorder, &wide);
    rests_on(page, recorder, &wide);
}

fn section(page: &mut String, title: &str, words: &str, svg: &str) {
    let _ = write!(page, "<h2>{title}</h2><p class=\"soft\">{words}</p><figure>{svg}</figure>");
}

/// Panels over the time of the run; a sentence instead where nothing was reported.
fn panels_section(page: &mut String, title: &str, words: &str, frame: &Frame<'_>, panels: &[Panel<'_>]) {
    if panels.iter().all(Panel::is_empty) {
        let _ = write!(page, "<h2>{title}</h2><p class=\"soft\">Not reported in this run.</p>");
    } else {
        section(page, title, words, &frame.plot(title, panels));
    }
}

/// A plot of three axes, where any of them was reported.
fn if_any(of: &[Banded; 3]) -> Option<&[Banded; 3]> {
    of.iter().any(|banded| !banded.error.is_empty()).then_some(of)
}

fn three<'a>(names: [&'a str; 3], unit: &'a str, of: &'a [Banded; 3]) -> Vec<Panel<'a>> {
    names.into_iter().zip(of).map(|(name, banded)| Panel::banded(name, unit, banded)).collect()
}

fn legend(page: &mut String, recorder: &Recorder) {
    let key = |variable: &str, words: &str| {
        format!("<span><span class=\"key\" style=\"background:var(--{variable})\"></span>{words}</span> ")
    };
    page.push_str("<h2>Plots</h2><p class=\"legend soft\">");
    page.push_str(&key("line", "error, least to greatest of every stretch"));
    page.push_str(&key("band", "\u{b1}3 reported sigma"));
    if recorder.position_bound.iter().any(|bound| !bound.is_empty()) {
        page.push_str(&key("good", "dashed: \u{b1}3 bound of the horizon"));
    }
    page.push_str(&key("bad", "at an edge: beyond it"));
    page.push_str(&key("dark", "no lit limb (eclipse)"));
    page.push_str(&key("sun", "Sun in a path"));
    if !recorder.faults.is_empty() {
        page.push_str(&key("fault", "fault injected"));
    }
    if !recorder.restarts.is_empty() {
        page.push_str(&key("restart", "line: orbit begun, restarted or forgotten"));
    }
    page.push_str(
        "</p><p class=\"soft\">Every panel shows 99.9 % of its errors. Where the envelope would flatten them it is left out, \
         and its size is told in the panel.</p>",
    );
}

fn attitude(page: &mut String, recorder: &Recorder, wide: &Frame<'_>) {
    let half = Frame { width: HALF, ..*wide };
    let raw = three(ATTITUDE_AXES, "arcsec", &recorder.attitude);
    let both = ATTITUDE_AXES.into_iter().zip(recorder.filtered.iter().zip(&recorder.attitude));
    let filtered: Vec<Panel<'_>> = both
        .map(|(name, (filtered, raw))| {
            let like = if raw.error.is_empty() { filtered } else { raw };
            Panel::banded_like(name, "arcsec", filtered, like)
        })
        .collect();
    if raw.iter().chain(&filtered).all(Panel::is_empty) {
        page.push_str("<h2>Attitude error</h2><p class=\"soft\">Not reported in this run.</p>");
    } else {
        let _ = write!(
            page,
            "<h2>Attitude error</h2><p class=\"soft\">Star path axes, outside Sun outages. Left: of each image alone. Right: of the \
         attitude filter, on the same scale.</p><div class=\"pair\"><figure>{}<figcaption>of each image alone</figcaption></figure>\
         <figure>{}<figcaption>filtered</figcaption></figure></div>",
            half.plot("Attitude error of each image", &raw),
            half.plot("Filtered attitude error", &filtered)
        );
    }
    if let Some(of) = if_any(&recorder.sun_attitude) {
        let panels = three(ATTITUDE_AXES, "arcsec", of);
        let words = "The detector is blinded; the last attitude is carried on.";
        panels_section(page, "Attitude error in Sun outages", words, wide, &panels);
    }
    let panels = ATTITUDE_AXES.iter().zip(&recorder.rate);
    let panels: Vec<Panel<'_>> = panels.map(|(name, rate)| Panel::signed(name, "arcsec/s", rate)).collect();
    let words = "Star path axes; the sensor reports no sigma of it.";
    panels_section(page, "Rate error", words, wide, &panels);
    if let Some(of) = if_any(&recorder.turning) {
        let panels = three(ATTITUDE_AXES, "deg/s", of);
        let words =
            "From streaks, or from stars not yet identified; where either sense is possible, the nearer one.";
        panels_section(page, "Rate error without an attitude", words, wide, &panels);
    }
}

fn orbit(page: &mut String, recorder: &Recorder, wide: &Frame<'_>) {
    let panels = three(ORBIT_AXES, "km", &recorder.position).into_iter().zip(&recorder.position_bound);
    let panels: Vec<Panel<'_>> = panels.map(|(panel, bound)| panel.above(bound)).collect();
    let words = "Along the true axes, the envelope by the reported covariance. Dashed: three times the bound; no filter has \
                 a smaller sigma and is right, see the terms.";
    panels_section(page, "Position error", words, wide, &panels);
    let words = "Along the true axes, the envelope by the reported covariance.";
    let panels = three(ORBIT_AXES, "m/s", &recorder.velocity);
    panels_section(page, "Velocity error", words, wide, &panels);
    let [x, y, distance] = &recorder.earth;
    let panels = [
        Panel::banded("direction, x", "deg", x),
        Panel::banded("direction, y", "deg", y),
        Panel::banded("distance", "km", distance),
    ];
    let words = "The Earth's centre as found in each frame alone, Earth path axes. The sigma reported of the direction is that of its worse axis.";
    panels_section(page, "Earth vector error", words, wide, &panels);
}

/// Error over sigma of every quantity that was estimated.
fn histograms(page: &mut String, recorder: &Recorder, figures: &Figures) {
    page.push_str(
        "<h2>Are the sigmas right?</h2><p class=\"soft\">Error over reported sigma, all axes and seconds. Right sigmas give the curve: \
         the unit Gaussian. A narrow peak: sigmas too large. Wide or aside: too small, or biased.</p><div class=\"histograms\">",
    );
    for (quantity, deviates) in QUANTITIES.iter().zip(&recorder.deviates) {
        let (all, beyond) = deviates.counts();
        let Some(run) = figures.run(quantity.key).filter(|_| all > 0) else { continue };
        let (class, word) = match run.sigma_fit() {
            SigmaFit::Right => ("good", "right"),
            SigmaFit::TooLarge => ("bad", "too large"),
            SigmaFit::TooSmall => ("bad", "too small"),
        };
        let words = quantity.words;
        let _ = write!(
            page,
            "<figure>{}<figcaption><b>{words}</b>: sigmas <b class=\"{class}\">{word}</b>; <span class=\"whole\">(e/\u{3c3})\u{b2} {}</span>; <span class=\"whole\">{:.2} % beyond 5\u{3c3}</span></figcaption></figure>",
            deviates.draw(words),
            label(run.normalised_square),
            100.0 * f64::from(beyond) / f64::from(all)
        );
    }
    page.push_str("</div>");
}

fn geometry(page: &mut String, recorder: &Recorder, wide: &Frame<'_>) {
    let _ = write!(
        page,
        "<h2>Orbit and Sun</h2><p class=\"soft\">Truth, seen from the orbit's normal, to scale. The first revolution; blue: Earth and \
         stars seen, dark: no lit limb in the field, yellow: Sun in a path.</p><div class=\"pair\"><figure>{}</figure><div>{TABLE}",
        recorder.orbit.draw()
    );
    for (what, value) in recorder.orbit.words() {
        let _ = write!(page, "<tr><td>{what}</td><td>{value}</td></tr>");
    }
    let [earth_path, star_path] = &recorder.sun_angles;
    let panels = [
        Panel::ranging("altitude", "km", &recorder.altitude, 2.0),
        Panel::ranging("Sun from the Earth path's axis", "deg", earth_path, 10.0),
        Panel::ranging("Sun from the star path's axis", "deg", star_path, 10.0),
        Panel::counted("lit limb in the field", "deg", &recorder.lit_limb, None),
    ];
    let _ = write!(page, "{TABLE_END}</div></div><figure>{}</figure>", wide.plot("Orbit and Sun", &panels));
}

fn rests_on(page: &mut String, recorder: &Recorder, wide: &Frame<'_>) {
    let panels = [
        Panel::counted("stars used", "", &recorder.stars, None),
        Panel::counted("limb points", "", &recorder.limb_points, None),
        Panel::counted(
            "innovation squared (NIS) of a degree of freedom",
            "95 % lie below the line",
            &recorder.nis,
            Some(NIS_95),
        ),
        Panel::banded("limb height, estimated", "km", &recorder.limb_height),
    ];
    panels_section(page, "What it rests on", "", wide, &panels);
}
