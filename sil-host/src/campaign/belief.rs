//! `sil-host campaign belief`: what each difference between what is and what the flight code is told costs.
//!
//! In: a scenario, a number of runs, a seed. Out: a row each for the scenario's own differences
//! ([`Believed`]), for none, and for each of them alone (`only`) and left out (`without`); columns are the
//! medians over the runs of [`FIGURES`]. All rows fly the same seeds, so that rows differ by the differences
//! alone. A difference of the scenario that is zero has no rows of its own.
//!
//! The runs of a row are those of `campaign run` with a scenario of another name ([`flights`]).

use super::Experiment;
use super::family::Family;
use super::flights::{self, Flights, Flown};
use crate::cli::CampaignRunArguments;
use crate::error::HostError;
use crate::formats::json;
use crate::judge::table::{self, Figure};
use crate::report::figures_table;
use crate::scenario::{Believed, PARTS};
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

/// The flights of all rows.
struct Beliefs<'a> {
    name: &'a str,
    rows: Vec<Flights<'a>>,
}

impl Experiment for Beliefs<'_> {
    /// Row and run.
    type Key = (usize, u64);
    type Run = Flown;
    type Workspace = ();

    fn name(&self) -> &str {
        self.name
    }

    fn keys(&self) -> Vec<(usize, u64)> {
        let of_row = |(row, flights): (usize, &Flights<'_>)| {
            flights.keys().into_iter().map(move |run| (row, run)).collect::<Vec<_>>()
        };
        self.rows.iter().enumerate().flat_map(of_row).collect()
    }

    fn key_of(&self, flown: &Flown) -> Option<(usize, u64)> {
        let rows = self.rows.iter().enumerate();
        rows.filter_map(|(row, flights)| Some((row, flights.key_of(flown)?))).next()
    }

    fn workspace(&self) {}

    fn fly(&self, (): &mut (), (row, run): &(usize, u64)) -> Result<Flown, HostError> {
        self.rows[*row].fly(&mut (), run)
    }
}

/// The rows of a family's variants.
fn rows(
    family: &Family,
    variants: &[Variant],
    arguments: &CampaignRunArguments,
) -> Result<Vec<Row>, HostError> {
    let base = &family.base.name;
    let families: Vec<Family> = variants
        .iter()
        .map(|Variant { name, believed }| family.believing(format!("{base}, {name}"), *believed))
        .collect();
    let flights = families.iter().map(|family| Flights::new(family, arguments)).collect::<Result<_, _>>()?;
    let flown = super::runs(&Beliefs { name: base, rows: flights }, &arguments.common)?;
    let row = |(family, variant): (&Family, &Variant)| {
        let ours = flown.iter().filter(|flown| flown.scenario == family.base.name);
        Row::new(variant.name.clone(), &ours.cloned().collect::<Vec<_>>())
    };
    Ok(families.iter().zip(variants).map(row).collect())
}

/// Runs the command.
///
/// # Errors
/// As `campaign run`.
pub fn run(arguments: &CampaignRunArguments) -> Result<ExitCode, HostError> {
    let family = Family::new(arguments.scenario.as_deref(), arguments.vary.as_deref())?;
    let rows = rows(&family, &variants(&family.base.believed), arguments)?;
    if arguments.common.json {
        rows.iter().for_each(json::print_line);
    } else {
        say!("{}: medians of {} runs\n{}", family.base.name, arguments.runs, text(&rows));
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests;
