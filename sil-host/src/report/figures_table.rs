//! The figures of a run as people read them: in the report and on the terminal.

use super::scale::label;
use crate::judge::quantities::{NEXT_STATE, QUANTITIES};
use crate::judge::series::SigmaFit;
use crate::judge::table::{self, PROBABILITY, Side};
use crate::judge::{Figures, Verdict};

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

/// A probability: of very small ones only that they are.
fn probability(value: f64) -> String {
    if value < 1e-4 { "< 0.0001".to_owned() } else { format!("{value:.4}") }
}

/// A quantity that was estimated, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityRow {
    /// What it is.
    pub what: &'static str,
    /// Error rms of the last orbit.
    pub rms: String,
    /// 95 % of these errors.
    pub error_95: String,
    /// Reported sigma of the last orbit.
    pub sigma: String,
    /// Unit of these.
    pub unit: &'static str,
    /// Share of the run within 3 sigma.
    pub within: String,
    /// Mean of (error / sigma)² over the run.
    pub square: String,
    /// Where 99 % of runs with right sigmas lie.
    pub band: String,
    /// Whether it lies there.
    pub fit: SigmaFit,
}

impl QuantityRow {
    /// Whether the sigmas are right, in a word.
    pub fn word(&self) -> &'static str {
        match self.fit {
            SigmaFit::Right => "right",
            SigmaFit::TooLarge => "TOO LARGE",
            SigmaFit::TooSmall => "TOO SMALL",
        }
    }
}

/// The quantities that were estimated.
pub fn quantities(figures: &Figures) -> Vec<QuantityRow> {
    let rows = QUANTITIES.iter().chain([&NEXT_STATE]).filter_map(|quantity| {
        let run = figures.run(quantity.key)?;
        let last = figures.last_orbit(quantity.key).unwrap_or(run);
        let [low, high] = run.band_99;
        Some(QuantityRow {
            what: quantity.words,
            rms: label(last.rms),
            error_95: label(last.error_95),
            sigma: label(last.sigma),
            unit: quantity.unit,
            within: percent(Some(run.within_share[2])),
            square: label(run.normalised_square),
            band: format!("{} to {}", label(low), label(high)),
            fit: run.sigma_fit(),
        })
    });
    rows.collect()
}

/// What is not said of every quantity.
pub fn lines(figures: &Figures) -> Vec<Line> {
    let line = |what: &str, reached: String, beside: String| Line { what: what.into(), reached, beside };
    let Figures { attitude, filtered, orbit, rate, .. } = figures;
    let parts = |bias, noise| format!("bias {}; noise about it {}", three(bias), three(noise));
    let seconds = |value: Option<u32>| plain(value.map(f64::from), "s");
    vec![
        line("First attitude", seconds(figures.first_attitude_s), String::new()),
        line(
            "Attitude valid outside Sun states",
            percent(figures.attitude_valid_share),
            format!("longest without {}", seconds(figures.recovery_s)),
        ),
        line(
            "Attitude about x, y, z, rms",
            format!("{} arcsec", three(attitude.rms_arcsec)),
            format!(
                "{}; sigma {}; Cram\u{e9}r-Rao bound {}; thesis {}",
                parts(attitude.bias_arcsec, attitude.noise_arcsec),
                three(attitude.sigma_arcsec),
                three(attitude.bound_arcsec),
                three(Some(attitude.thesis_arcsec))
            ),
        ),
        line(
            "Filtered about x, y, z, rms",
            format!("{} arcsec", three(filtered.rms_arcsec)),
            format!(
                "{}; sigma {}",
                parts(filtered.bias_arcsec, filtered.noise_arcsec),
                three(filtered.sigma_arcsec)
            ),
        ),
        line(
            "Mode as the geometry says",
            percent(figures.mode_share),
            format!(
                "latest after a change {}; at most {} changes in ten seconds",
                seconds(figures.mode_latest_s),
                figures.mode_changes_10_s.map_or_else(|| "–".into(), |most| most.to_string())
            ),
        ),
        line(
            "State told as the geometry says",
            percent(figures.state_share),
            format!("told in {} of the seconds", percent(figures.state_told_share)),
        ),
        line(
            "Rate while no attitude is known",
            percent(rate.share),
            format!(
                "median error {}, axis {}; of either sense {}; goal 1 %, 0.5 deg",
                plain(rate.error_percent, "%"),
                plain(rate.axis_deg, "deg"),
                percent(rate.either_sense_share)
            ),
        ),
        line("Earth found", format!("{} s", figures.earth.found_s), format!("of {} s", figures.seconds)),
        line(
            "Next change of state foreseen",
            percent(figures.next_state_share),
            format!(
                "while attitude and orbit are known; its length to {}",
                plain(figures.next_state_length_95_s, "s")
            ),
        ),
        line("First orbit", seconds(orbit.first_s), format!("settled {}", seconds(orbit.settled_s))),
        line(
            "Position of the last orbit, rms",
            plain(orbit.last_orbit_position_km, "km"),
            format!(
                "radial, along, cross {}; bound of the horizon {}; thesis (GEO) {}; at the end {}",
                three(orbit.last_orbit_rac_km),
                three(orbit.last_orbit_bound_rac_km),
                three(Some(orbit.thesis_geo_rac_km)),
                plain(orbit.final_position_km, "km")
            ),
        ),
        line(
            "Largest position jump in a second",
            plain(orbit.position_jump_sigma, "sigma"),
            orbit.position_jump_at_s.map_or(String::new(), |at| format!("in second {at}")),
        ),
        line(
            "Longest without a fix",
            format!("{} s", orbit.longest_without_fix_s),
            format!("in eclipse and Sun {}", plain(orbit.outage_largest_sigma, "sigma at most")),
        ),
        line(
            "Innovation (NIS), mean",
            or_dash(orbit.nis_mean, label),
            format!(
                "of a degree of freedom, expected 1; probability of such a mean {}",
                or_dash(orbit.nis_consistency, probability)
            ),
        ),
    ]
}

/// A figure's value with its unit.
pub fn value(value: Option<f64>, unit: &str) -> String {
    match unit {
        "" => percent(value),
        PROBABILITY => or_dash(value, probability),
        unit => plain(value, unit),
    }
}

/// A verdict in words: what, demanded, reached.
pub fn verdict(verdict: &Verdict) -> [String; 3] {
    let of = table::figure(verdict.limit);
    let (words, unit) = of.map_or((verdict.limit, ""), |of| (of.words, of.unit));
    let side = match verdict.side {
        Side::AtLeast => "\u{2265}",
        Side::AtMost => "\u{2264}",
    };
    let show = |of| value(of, unit);
    [words.to_owned(), format!("{side} {}", show(Some(verdict.demanded))), show(verdict.reached)]
}

/// Verdicts, those that miss first.
pub fn missed_first(verdicts: &[Verdict]) -> impl Iterator<Item = &Verdict> {
    let of = |kept: bool| verdicts.iter().filter(move |verdict| verdict.kept == kept);
    of(false).chain(of(true))
}
