//! `sil-host campaign belief`: what each difference between what is and what the flight code is told costs.
//!
//! In: a scenario, a number of runs, a seed. Out: a row each for the scenario's own differences
//! ([`Believed`]), for none, and for each of them alone (`only`) and left out (`without`); columns are the
//! medians over the runs of [`FIGURES`]. All rows fly the same seeds, so that rows differ by the differences
//! alone. A difference of the scenario that is zero has no rows of its own.
//!
//! Each row is a `campaign run` of a scenario of another name ([`flights`]): a campaign that was stopped goes
//! on, and files of several machines may be put one behind the other.

use super::flights::{self, Flown};
use crate::cli::CampaignRunArguments;
use crate::error::HostError;
use crate::formats::json;
use crate::judge::table::{self, Figure};
use crate::report::figures_table;
use crate::scenario::{Believed, PARTS, Scenario};
use serde::Serialize;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// The figures shown, with the heads of their columns.
pub const FIGURES: [(&str, &str); 10] = [
    ("attitude_rms_arcsec", "attitude"),
    ("filtered_rms_arcsec", "filtered"),
    ("within_3_sigma_share", "within 3 s"),
    ("rate_95_deg_s", "rate 95 %"),
    ("earth_direction_rms_deg", "Earth dir."),
    ("earth_distance_rms_km", "distance"),
    ("last_orbit_position_km", "position"),
    ("last_orbit_velocity_m_s", "velocity"),
    ("position_consistency", "consistent"),
    ("nis_consistency", "NIS"),
];

/// What is believed in a row.
#[derive(Clone, Debug, PartialEq)]
struct Variant {
    name: String,
    believed: Believed,
}

/// The rows for a scenario that believes this.
fn variants(believed: &Believed) -> Vec<Variant> {
    let named = |name: &str, believed| Variant { name: name.to_owned(), believed };
    let mut all = vec![named("all", *believed), named("none", Believed::TRUTH)];
    for (key, take) in PARTS {
        let (mut only, mut without) = (Believed::TRUTH, *believed);
        take(&mut only, believed);
        take(&mut without, &Believed::TRUTH);
        if only != Believed::TRUTH {
            all.push(named(&format!("only {key}"), only));
            all.push(named(&format!("without {key}"), without));
        }
    }
    all
}

/// A row: the medians of the figures that its runs yielded.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Row {
    differences: String,
    runs: usize,
    medians: BTreeMap<&'static str, f64>,
}

impl Row {
    fn new(differences: String, flown: &[Flown]) -> Self {
        let figures = FIGURES.iter().filter_map(|(key, _)| table::figure(key));
        let median = |figure: &'static Figure| Some((figure.key, flights::row(figure, &[], flown)?.median));
        Self { differences, runs: flown.len(), medians: figures.filter_map(median).collect() }
    }
}

/// The table; without the columns that no run yielded.
fn text(rows: &[Row]) -> String {
    let yielded = |(key, _): &&(&str, &str)| rows.iter().any(|row| row.medians.contains_key(key));
    let columns: Vec<_> = FIGURES.iter().filter(yielded).collect();
    let heads: String = columns.iter().map(|(_, head)| format!("{head:>15}")).collect();
    let mut text = format!("{:32}{heads}\n", "differences");
    for row in rows {
        text += &format!("{:32}", row.differences);
        for (key, _) in &columns {
            let unit = table::figure(key).map_or("", |figure| figure.unit);
            let value = row.medians.get(key).map(|value| figures_table::value(Some(*value), unit));
            text += &format!("{:>15}", value.unwrap_or_default());
        }
        text.push('\n');
    }
    text
}

/// Runs the command.
///
/// # Errors
/// As `campaign run`.
pub fn run(arguments: &CampaignRunArguments) -> Result<ExitCode, HostError> {
    let base = Scenario::named(arguments.scenario.as_deref())?;
    let threads = flights::threads(arguments.jobs)?;
    let mut rows = Vec::new();
    for Variant { name, believed } in variants(&base.believed) {
        let scenario = Scenario { name: format!("{}, {name}", base.name), believed, ..base.clone() };
        let flown = threads.install(|| flights::flown(&scenario, arguments))?;
        rows.push(Row::new(name, &flown));
    }
    if arguments.common.json {
        rows.iter().for_each(json::print_line);
    } else {
        say!("{}: medians of {} runs\n{}", base.name, arguments.runs, text(&rows));
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests;
