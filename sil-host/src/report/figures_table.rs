//! The figures of a run as people read them: in the report and on the terminal.

use super::scale::label;
use crate::judge::{Figures, Verdict};
use crate::scenario::{LIMITABLE, Side};

/// A figure in words: what, reached, and what it compares with.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What it is.
    pub what: String,
    /// What the run reached.
    pub reached: String,
    /// What to hold it against.
    pub beside: String,
}

/// A value that may not be there.
fn or_dash(value: Option<f64>, show: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "\u{2013}".to_owned(), show)
}

fn percent(value: Option<f64>) -> String {
    // Rounded down: 100 % is said of all only.
    or_dash(value, |share| format!("{:.2} %", libm::floor(share * 1e4) / 1e2))
}

fn three(values: Option<[f64; 3]>) -> String {
    values.map_or_else(|| "\u{2013}".to_owned(), |values| values.map(label).join(", "))
}

fn plain(value: Option<f64>, unit: &str) -> String {
    or_dash(value, |value| format!("{} {unit}", label(value)))
}

/// The table of figures.
pub fn lines(figures: &Figures) -> Vec<Line> {
    let line = |what: &str, reached: String, beside: String| Line { what: what.into(), reached, beside };
    let Figures { attitude, filtered, earth, orbit, .. } = figures;
    let seconds = |value: Option<u32>| plain(value.map(f64::from), "s");
    vec![
        line("First attitude", seconds(figures.first_attitude_s), String::new()),
        line("Attitude valid outside Sun states", percent(figures.attitude_valid_share), String::new()),
        line(
            "Attitude error about x, y, z, rms",
            format!("{} arcsec", three(attitude.rms_arcsec)),
            format!(
                "sigma {}; Cram\u{e9}r-Rao bound {}; thesis {}",
                three(attitude.sigma_arcsec),
                three(attitude.bound_arcsec),
                three(Some(attitude.thesis_arcsec))
            ),
        ),
        line(
            "Attitude within 3 sigma, all axes",
            percent(figures.within_3_sigma_share),
            format!("largest {}", plain(attitude.largest_sigma, "sigma")),
        ),
        line(
            "Filtered attitude, rms",
            format!("{} arcsec", three(filtered.rms_arcsec)),
            format!(
                "sigma {}; within 3 sigma {}; goal 1.5 about x, y",
                three(filtered.sigma_arcsec),
                percent(filtered.within_3_sigma_share)
            ),
        ),
        line("Mode as the geometry says", percent(figures.mode_share), String::new()),
        line(
            "Rate while no attitude is known",
            percent(figures.rate.share),
            format!(
                "median error {}, axis {}; within 3 sigma {}; of either sense {}; goal 1 %, 0.5 deg",
                plain(figures.rate.error_percent, "%"),
                plain(figures.rate.axis_deg, "deg"),
                percent(figures.rate.within_3_sigma_share),
                percent(figures.rate.either_sense_share)
            ),
        ),
        line("Earth found", format!("{} s", earth.found_s), format!("of {} s", figures.seconds)),
        line(
            "Earth's direction, rms per axis",
            plain(earth.direction_rms_deg, "deg"),
            format!(
                "sigma {}; within 3 sigma {}; goal 0.02 GEO, 0.05 LEO",
                plain(earth.direction_sigma_deg, "deg"),
                percent(earth.direction_within_3_sigma_share)
            ),
        ),
        line(
            "Earth's distance, rms",
            plain(earth.distance_rms_km, "km"),
            format!(
                "sigma {}; within 3 sigma {}",
                plain(earth.distance_sigma_km, "km"),
                percent(earth.distance_within_3_sigma_share)
            ),
        ),
        line("First orbit", seconds(orbit.first_s), format!("converged {}", seconds(orbit.settled_s))),
        line("Position error at the end, 3-D", plain(orbit.final_position_km, "km"), String::new()),
        line(
            "Position error of the last orbit, rms",
            plain(orbit.last_orbit_position_km, "km"),
            format!(
                "radial, along, cross {}; thesis (GEO) {}",
                three(orbit.last_orbit_rac_km),
                three(Some(orbit.thesis_geo_rac_km))
            ),
        ),
        line(
            "Velocity error of the last orbit, rms",
            plain(orbit.last_orbit_velocity_m_s, "m/s"),
            String::new(),
        ),
        line(
            "Position within 3 sigma, all axes",
            percent(orbit.position_within_3_sigma_share),
            format!(
                "mean (error / sigma)\u{b2} {} (1 is honest); largest {}",
                or_dash(orbit.position_normalised_square, label),
                plain(orbit.position_largest_sigma, "sigma")
            ),
        ),
        line(
            "Position in eclipse and Sun outage",
            plain(orbit.outage_largest_sigma, "sigma at most"),
            format!("longest without a fix {} s", orbit.longest_without_fix_s),
        ),
        line(
            "Largest position jump in a second",
            plain(orbit.position_jump_sigma, "sigma"),
            orbit.position_jump_at_s.map_or(String::new(), |at| format!("in second {at}")),
        ),
        line("Innovation (NIS), mean", or_dash(orbit.nis_mean, label), "expected 3".into()),
    ]
}

/// A verdict in words: what, demanded, reached.
pub fn verdict(verdict: &Verdict) -> [String; 3] {
    let of = LIMITABLE.iter().find(|limitable| limitable.key == verdict.limit);
    let (words, unit) = of.map_or((verdict.limit, ""), |of| (of.words, of.unit));
    let side = match verdict.side {
        Side::AtLeast => "\u{2265}",
        Side::AtMost => "\u{2264}",
    };
    let show = |value: Option<f64>| {
        if unit.is_empty() { percent(value) } else { plain(value, unit) }
    };
    [words.to_owned(), format!("{side} {}", show(Some(verdict.demanded))), show(verdict.reached)]
}
