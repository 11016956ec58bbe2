//! `sil-host campaign scenarios`: every scenario flown many times, with differences of belief and without.
//!
//! In: names of scenarios (none: all that come with the program), a number of runs, a seed. Out: a page in
//! Markdown with a table for each: of every limited figure, and of those [`BESIDE`] them, median and 95 %
//! quantile over the flights with their 95 % confidence intervals, the limit, and how many flights kept it;
//! first as the flight code flies, then told the truth ([`DRAWN`], [`NONE`]). Both fly the same seeds. What is
//! drawn for `[believed]` stands in `scenarios.toml` or in the file of `--vary`; what is not is the scenario's.
//!
//! Of a quantity's sigmas NEES (of the orbit filter's innovations NIS) is judged flight by flight: the limit
//! of its probability makes the band in which 99 % of the flights with right sigmas lie, and the share of
//! flights that kept it is said.
//!
//! Like any campaign it stops and goes on, and its files are put one behind the other: `--out` holds a line a
//! flight with the program that flew it, `--first` and the names of scenarios split the work, and `--held`
//! makes the page of what a file holds. Ends with status 1 when a flight as the flight code flies missed a
//! limit.

mod page;

use super::family::Family;
use super::flights::{self, Flown};
use super::variants::{Flight, Variants};
use super::vary::Variation;
use crate::cli::CampaignScenariosArguments;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::json;
use crate::judge::table::{self, Figure};
use crate::output;
use crate::scenario::{EMBEDDED, Scenario};
use crate::words::program;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Name of the flights in which differences of belief are drawn.
pub const DRAWN: &str = "drawn";
/// Name of those whose flight code is told the truth.
pub const NONE: &str = "none";
/// What is drawn where no file says it.
const VARY: &str = include_str!("scenarios.toml");

/// Figures that are shown whether or not a scenario limits them.
pub const BESIDE: [&str; 16] = [
    "attitude_rms_arcsec",
    "attitude_bias_arcsec",
    "attitude_noise_arcsec",
    "filtered_rms_arcsec",
    "filtered_bias_arcsec",
    "filtered_noise_arcsec",
    "rate_95_deg_s",
    "earth_direction_rms_deg",
    "earth_distance_rms_km",
    "last_orbit_position_km",
    "position_sigma_km",
    "last_orbit_velocity_m_s",
    "attitude_nees",
    "filtered_nees",
    "position_nees",
    "velocity_nees",
];

/// A figure of a scenario, with the differences and without.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scenario's name.
    pub scenario: String,
    /// The figure's key.
    pub figure: &'static str,
    /// With the differences drawn; `None` where no flight yielded the figure.
    pub drawn: Option<flights::Row>,
    /// Told the truth.
    pub none: Option<flights::Row>,
    /// The scenario's limit.
    pub limit: Option<f64>,
    /// Flights that missed it, of those with the differences and of those without; also those that did not
    /// yield the figure.
    pub missed: [usize; 2],
}

/// A scenario's part of the page.
struct Part<'a> {
    scenario: &'a Scenario,
    /// With the differences, and without.
    flown: [Vec<Flown>; 2],
}

impl Part<'_> {
    /// The limit of a figure. That every number be finite is demanded of every scenario with limits.
    fn limit(&self, figure: &Figure) -> Option<f64> {
        let limits = &self.scenario.limits;
        let own = limits.iter().find(|limit| limit.of == figure).map(|limit| limit.value);
        let demanded = !limits.is_empty() && *figure == table::NOT_FINITE;
        own.or(demanded.then_some(0.0))
    }

    /// Its figures in the order of the judge's table, the limited ones first.
    fn rows(&self) -> Vec<Row> {
        let limits = &self.scenario.limits;
        let limited = |figure: &&Figure| self.limit(figure).is_some();
        let beside = |figure: &&Figure| !limited(figure) && BESIDE.contains(&figure.key);
        let rows = table::figures().filter(limited).chain(table::figures().filter(beside));
        let row = |figure: &'static Figure| {
            let [drawn, none] = self.flown.each_ref().map(|flown| flights::row(figure, limits, flown));
            Row {
                scenario: self.scenario.name.clone(),
                figure: figure.key,
                drawn,
                none,
                limit: self.limit(figure),
                missed: self.flown.each_ref().map(|flown| missed(figure, flown)),
            }
        };
        rows.map(row).filter(|row| row.limit.is_some() || row.drawn.is_some() || row.none.is_some()).collect()
    }
}

/// Flights that missed the limit of a figure.
fn missed(figure: &Figure, flown: &[Flown]) -> usize {
    flown.iter().filter(|flown| flown.missed.iter().any(|missed| missed == figure.key)).count()
}

/// What is flown: of each scenario a row with the differences and one without.
fn variants_of(arguments: &CampaignScenariosArguments) -> Result<Variants, HostError> {
    let all = || EMBEDDED.iter().map(|(name, _)| PathBuf::from(name)).collect();
    let paths: Vec<PathBuf> =
        if arguments.scenarios.is_empty() { all() } else { arguments.scenarios.clone() };
    let variation = match &arguments.vary {
        Some(path) => Variation::load(path),
        None => Variation::parse(Path::new("scenarios.toml"), VARY.to_owned()),
    }?;
    let mut rows: Vec<(String, Family)> = Vec::new();
    for path in paths {
        let (file, text) = Scenario::text(Some(&path))?;
        let family = Family::of_text(&file, &text, Some(variation.clone()))?;
        if rows.iter().any(|(_, other)| other.base.name == family.base.name) {
            let what = format!("two scenarios are named {}", family.base.name);
            return Err(HostError::usage(what, "name each once"));
        }
        rows.push((DRAWN.to_owned(), family.clone()));
        rows.push((NONE.to_owned(), family.told_the_truth()));
    }
    Variants::new("scenarios", rows, (&arguments.common, arguments.runs))
}

/// The parts of the page, those without a flight left out.
fn parts(variants: &Variants, flights: Vec<Flight>) -> Vec<Part<'_>> {
    let mut flown = variants.by_row(flights).into_iter();
    let mut parts = Vec::new();
    for pair in variants.rows.chunks_exact(2) {
        let flown = [flown.next().unwrap_or_default(), flown.next().unwrap_or_default()];
        if flown.iter().any(|flown| !flown.is_empty()) {
            parts.push(Part { scenario: &pair[0].1.base, flown });
        }
    }
    parts
}

/// The command that makes the page again.
fn command(arguments: &CampaignScenariosArguments) -> String {
    let scenarios = arguments.scenarios.iter().map(|path| format!(" {}", path.display()));
    let vary = arguments.vary.iter().map(|path| format!(" --vary {}", path.display()));
    let words: String = scenarios.chain(vary).collect();
    let program = program();
    format!("{program} campaign scenarios{words} --runs {} --seed {}", arguments.runs, arguments.common.seed)
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be read or flown, or a file not be used.
pub fn run(arguments: &CampaignScenariosArguments) -> Result<ExitCode, HostError> {
    let variants = variants_of(arguments)?;
    let flights = super::runs(&variants, &arguments.common)?;
    let kept = flights.iter().all(|flight| flight.differences != DRAWN || flight.flown.missed.is_empty());
    let parts = parts(&variants, flights);
    if arguments.common.json {
        parts.iter().flat_map(Part::rows).for_each(|row| json::print_line(&row));
    }
    let text = page::text(&parts, &command(arguments), arguments.common.seed);
    match &arguments.page {
        Some(path) => output::write_whole(path, text.as_bytes())?,
        None if arguments.common.json => {}
        None => output::print(format_args!("{text}"), ""),
    }
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

#[cfg(test)]
mod tests;
