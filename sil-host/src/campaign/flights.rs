//! `sil-host campaign run`: a scenario flown many times, judged as one.
//!
//! In: a scenario, a number of runs, a seed, and what varies. Out: of every figure that can be limited the
//! median over the runs with its 95 % confidence interval, the value that 95 % of the runs keep, how often
//! its limit was missed, and the run that was worst. A run is the scenario with another seed, from which
//! everything random in it follows (clouds, noise, hits, the horizon's height), and with the keys that
//! `--vary` draws; these stand in its result. `sil-host run SCENARIO --seed N --run I` flies one of them
//! again. Ends with status 1 when a limit was missed in a run.
//!
//! `sil-host campaign SCENARIO --out DIR` is the same with its files in a folder: the flights, their table
//! and what is printed.

use super::Experiment;
use super::family::{Family, Values};
use super::spread::Spread;
use crate::cli::{CampaignFolderArguments, CampaignRunArguments};
use crate::commands::run::bounded::BoundedJudge;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::json;
use crate::harness;
use crate::judge::Limit;
use crate::judge::Verdict;
use crate::judge::table::{self, Figure, Side};
use crate::output;
use crate::report::figures_table;
use crate::version;
use crate::words::program;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

/// A flight of the scenario, judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Flown {
    /// The scenario's name.
    pub scenario: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
    /// Seed of the flight.
    pub flight_seed: u64,
    /// What was drawn for it, by key of the scenario.
    #[serde(default, skip_serializing_if = "Values::is_empty")]
    pub drawn: Values,
    /// The figures that the flight yielded.
    pub figures: BTreeMap<String, f64>,
    /// Keys of the limits that were missed.
    pub missed: Vec<String>,
    /// The program that flew it, see [`crate::version`].
    #[serde(default)]
    pub program: String,
}

/// A figure over all runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its key.
    pub figure: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Over the runs.
    #[serde(flatten)]
    pub spread: Spread,
    /// The scenario's limit.
    pub limit: Option<f64>,
    /// Runs in which it was missed.
    pub missed: usize,
    /// The worst run.
    pub worst_run: u64,
    /// Seed of its flight.
    pub worst_flight_seed: u64,
}

/// Flights of a campaign.
struct Flights<'a> {
    family: &'a Family,
    seed: u64,
    /// What the runs that are asked for draw.
    drawn: BTreeMap<u64, Values>,
}

impl<'a> Flights<'a> {
    /// Every run's scenario is checked before any is flown.
    fn new(family: &'a Family, arguments: &CampaignRunArguments) -> Result<Self, HostError> {
        let seed = arguments.common.seed;
        let drawn = family.drawn(seed, arguments.common.numbers(arguments.runs))?;
        Ok(Self { family, seed, drawn })
    }
}

impl Experiment for Flights<'_> {
    type Key = u64;
    type Run = Flown;
    type Workspace = ();

    fn name(&self) -> &str {
        &self.family.base.name
    }

    fn keys(&self) -> Vec<u64> {
        self.drawn.keys().copied().collect()
    }

    fn key_of(&self, flown: &Flown) -> Option<u64> {
        let ours = flown.scenario == self.family.base.name && flown.seed == self.seed;
        (ours && self.drawn.get(&flown.run) == Some(&flown.drawn)).then_some(flown.run)
    }

    fn workspace(&self) {}

    fn fly(&self, (): &mut (), run: &u64) -> Result<Flown, HostError> {
        fly(self.family, self.seed, *run)
    }
}

/// Flies a run.
pub(super) fn fly(family: &Family, seed: u64, run: u64) -> Result<Flown, HostError> {
    let (scenario, drawn) = family.member(seed, run)?;
    let mut scene = scenario.scene()?;
    let mut judge = BoundedJudge::new(&scenario);
    harness::fly(&scenario, &mut scene, |second| {
        judge.add(&second);
        Ok(())
    })?;
    let figures = judge.finish();
    let verdicts = Verdict::all(&scenario.limits, &figures);
    let value = |figure: &Figure| Some((figure.key.to_owned(), (figure.of)(&figures)?));
    Ok(Flown {
        scenario: family.base.name.clone(),
        seed,
        run,
        flight_seed: scenario.seed,
        drawn,
        figures: table::figures().filter_map(value).collect(),
        missed: verdicts
            .iter()
            .filter(|verdict| !verdict.kept)
            .map(|verdict| verdict.limit.to_owned())
            .collect(),
        program: version::words().to_owned(),
    })
}

/// The runs in order.
fn flown(family: &Family, arguments: &CampaignRunArguments) -> Result<Vec<Flown>, HostError> {
    super::runs(&Flights::new(family, arguments)?, &arguments.common)
}

/// A figure over the runs; `None` where none yielded it.
pub(super) fn row(figure: &'static Figure, limits: &[Limit], flown: &[Flown]) -> Option<Row> {
    let of = |flown: &'_ Flown| flown.figures.get(figure.key).copied();
    let mut values: Vec<(f64, &Flown)> = flown.iter().filter_map(|flown| Some((of(flown)?, flown))).collect();
    values.sort_by(|one, other| one.0.total_cmp(&other.0));
    if figure.side == Side::AtLeast {
        values.reverse();
    }
    let (_, worst) = values.last()?;
    Some(Row {
        figure: figure.key,
        unit: figure.unit,
        spread: Spread::of(&values.iter().map(|(value, _)| *value).collect::<Vec<f64>>())?,
        limit: limits.iter().find(|limit| limit.of == figure).map(|limit| limit.value),
        missed: flown.iter().filter(|flown| flown.missed.iter().any(|missed| missed == figure.key)).count(),
        worst_run: worst.run,
        worst_flight_seed: worst.flight_seed,
    })
}

/// Whether faults were drawn for a flight.
fn has_drawn_faults(flown: &Flown) -> bool {
    flown.drawn.keys().any(|key| key.starts_with("faults."))
}

/// Whether a figure is shown without a limit: errors and sigmas of the last orbit, and in flights with faults
/// the recovery.
fn is_beside(figure: &str, faults: bool) -> bool {
    figure.contains("_95_") || figure.contains("_sigma_") || faults && figure == "recovery_s"
}

/// The table of so many runs: the limited figures and those [beside](is_beside) them. A run without a figure
/// misses its limit.
fn text(rows: &[Row], runs: usize) -> String {
    let [median, interval, keep, limit, missed] = ["median", "95 % interval of it", "95 % keep", "limit", ""];
    let mut text =
        format!("{:30} {median:>14}  {interval:28} {keep:>14} {limit:>12}  {missed:12}  worst: --run\n", "");
    for row in rows {
        let show = |value: f64| figures_table::value(Some(value), row.unit);
        let [low, high] = row.spread.median_interval.map(|end| end.map_or("?".to_owned(), show));
        let missed = match row.limit {
            None => String::new(),
            Some(_) if row.missed == 0 => "kept".to_owned(),
            Some(_) => format!("MISSED {}/{runs}", row.missed),
        };
        text += &format!(
            "{:30} {:>14}  {:28} {:>14} {:>12}  {:12}  {}\n",
            row.figure,
            show(row.spread.median),
            format!("{low} to {high}"),
            show(row.spread.kept_by_95_percent),
            row.limit.map_or(String::new(), show),
            missed,
            row.worst_run
        );
    }
    text
}

/// The command that flies a run again and writes its report.
fn again(arguments: &CampaignRunArguments, run: u64) -> String {
    let scenario = arguments.scenario.iter().map(|path| format!(" {}", path.display()));
    let vary = arguments.vary.iter().map(|path| format!(" --vary {}", path.display()));
    let words: String = scenario.chain(vary).collect();
    format!("{} run{words} --seed {} --run {run}", program(), arguments.common.seed)
}

/// Runs the command.
///
/// # Errors
/// When the scenario cannot be read or flown, or the file of runs cannot be used.
pub fn run(arguments: &CampaignRunArguments) -> Result<ExitCode, HostError> {
    judged(&Family::new(arguments.scenario.as_deref(), arguments.vary.as_deref())?, arguments, None)
}

/// Runs the command with its files in a folder.
///
/// # Errors
/// As [`run`], and when the folder cannot be made.
pub fn run_in_folder(arguments: &CampaignFolderArguments) -> Result<ExitCode, HostError> {
    let folder = &arguments.out;
    let made =
        |error: std::io::Error| HostError::system(folder, "made", &error, "name another folder by --out");
    // A scenario that cannot be read leaves no folder.
    let family = Family::new(Some(&arguments.scenario), arguments.vary.as_deref())?;
    std::fs::create_dir_all(folder).map_err(made)?;
    judged(&family, &arguments.as_run(), Some(&folder.join("figures.txt")))
}

/// Flies what is not yet flown, judges all and prints it, into a file too where one is given.
fn judged(
    family: &Family,
    arguments: &CampaignRunArguments,
    page: Option<&Path>,
) -> Result<ExitCode, HostError> {
    let base = &family.base;
    base.warn();
    let flown = flown(family, arguments)?;
    let rows: Vec<Row> = table::figures().filter_map(|figure| row(figure, &base.limits, &flown)).collect();
    let faults = !base.faults.is_empty() || flown.iter().any(has_drawn_faults);
    let shown = |row: &&Row| row.limit.is_some() || is_beside(row.figure, faults);
    let shown: Vec<Row> = rows.iter().filter(shown).cloned().collect();
    let worst = shown.iter().max_by_key(|row| row.missed).map_or(arguments.common.first, |row| row.worst_run);
    let runs = flown.len();
    let words = format!(
        "{}: {runs} runs\n{}\nTo see one of them again: {}\n",
        base.name,
        text(&shown, runs),
        again(arguments, worst)
    );
    if arguments.common.json {
        rows.iter().for_each(json::print_line);
    } else {
        output::print(format_args!("{words}"), "");
    }
    if let Some(page) = page {
        output::write_whole(page, words.as_bytes())?;
    }
    let kept = flown.iter().all(|flown| flown.missed.is_empty());
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

#[cfg(test)]
mod tests;
