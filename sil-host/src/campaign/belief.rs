//! `sil-host campaign belief`: what each difference between what is and what the flight code is told costs.
//!
//! In: a scenario, a number of runs, a seed. Out: a row each for the scenario's own differences
//! ([`Believed`]), for none, and for each of them alone (`only`) and left out (`without`); columns are the
//! medians over the runs of [`FIGURES`]. All rows fly the same seeds, so that rows differ by the differences
//! alone. A difference of the scenario that is zero has no rows of its own.
//!
//! Its runs are those of `campaign run` ([`flights`]) with another belief.

use super::family::Family;
use super::flights::{self, Flown};
use super::variants::{Flight, Variants};
use crate::cli::CampaignBeliefArguments;
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

/// The rows for a scenario that believes this.
fn variants(believed: &Believed) -> Vec<(String, Believed)> {
    let mut all = vec![("all".to_owned(), *believed), ("none".to_owned(), Believed::TRUTH)];
    for (key, take) in PARTS {
        let (mut only, mut without) = (Believed::TRUTH, *believed);
        take(&mut only, believed);
        take(&mut without, &Believed::TRUTH);
        if only != Believed::TRUTH {
            all.push((format!("only {key}"), only));
            all.push((format!("without {key}"), without));
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
        let median =
            |figure: &'static Figure| Some((figure.key, flights::row(figure, &[], flown)?.spread.median));
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

/// The rows of flights of this scenario.
fn variants_of(base: &Scenario, arguments: &CampaignBeliefArguments) -> Result<Variants, HostError> {
    let family = |believed| Family::of_scenario(Scenario { believed, ..base.clone() });
    let rows = variants(&base.believed).into_iter().map(|(name, believed)| (name, family(believed)));
    Variants::new(&base.name, rows.collect(), (&arguments.common, arguments.runs))
}

/// The table of these flights.
fn table_of(variants: &Variants, flights: Vec<Flight>) -> Vec<Row> {
    let by_row = variants.by_row(flights);
    let rows = variants.rows.iter().zip(by_row);
    rows.map(|((name, _), flown)| Row::new(name.clone(), &flown)).collect()
}

/// Runs the command.
///
/// # Errors
/// When the scenario cannot be read or flown, or the file of runs cannot be used.
pub fn run(arguments: &CampaignBeliefArguments) -> Result<ExitCode, HostError> {
    let base = Scenario::named(arguments.scenario.as_deref())?;
    let variants = variants_of(&base, arguments)?;
    let rows = table_of(&variants, super::runs(&variants, &arguments.common)?);
    if arguments.common.json {
        rows.iter().for_each(json::print_line);
    } else {
        print_line!("{}: medians of {} runs\n{}", base.name, arguments.runs, text(&rows));
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests;
