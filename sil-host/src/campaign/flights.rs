//! `sil-host campaign run`: a scenario flown many times, judged as one.
//!
//! In: a scenario, a number of runs, a seed. Out: of every figure that can be limited the median over the
//! runs with its 95 % confidence interval, the value that 95 % of the runs keep, how often its limit was
//! missed, and the run that was worst. A run is the scenario with another seed, from which everything random
//! in it follows: clouds, noise, hits, the horizon's height.
//!
//! Run `i` depends on the campaign's seed and `i` alone, so any split over machines (`--first`) merges to the
//! same table: put the files of `--out` one behind the other. A campaign that was stopped goes on from its
//! file. Ends with status 1 when a limit was missed in a run.

use super::fly_open;
use super::lines::LinesFile;
use crate::cli::CampaignRunArguments;
use crate::commands::run::judge_second;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::json;
use crate::harness;
use crate::judge::Limit;
use crate::judge::table::{self, Figure, Side};
use crate::judge::{Judge, Verdict};
use crate::report::figures_table;
use crate::scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
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
    /// Seed of the flight: `sil-host run SCENARIO --seed` flies it again.
    pub flight_seed: u64,
    /// The figures that the flight yielded.
    pub figures: BTreeMap<String, f64>,
    /// Keys of the limits that were missed.
    pub missed: Vec<String>,
}

/// A figure over all runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its key.
    pub figure: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Runs that yielded it.
    pub runs: usize,
    /// Median over them.
    pub median: f64,
    /// 95 % confidence interval of the median, by order statistics.
    pub median_interval: [f64; 2],
    /// What 95 % of the runs keep: the 95 % quantile, or that of 5 % where more is better.
    pub kept_by_95_percent: f64,
    /// The scenario's limit.
    pub limit: Option<f64>,
    /// Runs in which it was missed.
    pub missed: usize,
    /// Seed of the worst flight.
    pub worst_flight_seed: u64,
}

/// Seed of a run's flight. Odd multiples keep the runs of neighbouring seeds apart.
fn flight_seed(seed: u64, run: u64) -> u64 {
    seed.wrapping_mul(1_000_003).wrapping_add(run)
}

fn fly(base: &Scenario, seed: u64, run: u64) -> Result<Flown, HostError> {
    let scenario = base.clone().with_seed(Some(flight_seed(seed, run)));
    let mut scene = scenario.scene()?;
    let mut judge = Judge::new(scenario.duration_s, scenario.period_s());
    harness::fly(&scenario, &mut scene, |second| {
        judge_second(&mut judge, &second, scenario.exposure_us);
        Ok(())
    })?;
    let figures = judge.finish();
    let verdicts = Verdict::all(&scenario.limits, &figures);
    let value = |figure: &Figure| Some((figure.key.to_owned(), (figure.of)(&figures)?));
    Ok(Flown {
        scenario: scenario.name.clone(),
        seed,
        run,
        flight_seed: scenario.seed,
        figures: table::figures().filter_map(value).collect(),
        missed: verdicts
            .iter()
            .filter(|verdict| !verdict.kept)
            .map(|verdict| verdict.limit.to_owned())
            .collect(),
    })
}

/// The runs, those that the file holds already not flown again, in order.
pub(super) fn flown(base: &Scenario, arguments: &CampaignRunArguments) -> Result<Vec<Flown>, HostError> {
    let (file, held) = LinesFile::open::<Flown>(arguments.common.out.as_deref())?;
    let seed = arguments.common.seed;
    let numbers = arguments.first..arguments.first.saturating_add(arguments.runs);
    let ours = held.into_iter().filter(|flown| flown.scenario == base.name && flown.seed == seed);
    let done: BTreeMap<u64, Flown> = ours.map(|flown| (flown.run, flown)).collect();
    let terminal = (base.name.as_str(), arguments.common.json);
    fly_open(terminal, &file, done, numbers, || (), |(), run| fly(base, seed, run))
}

/// A figure over the runs; `None` where none yielded it.
pub(super) fn row(figure: &'static Figure, limits: &[Limit], flown: &[Flown]) -> Option<Row> {
    let of = |flown: &Flown| Some((*flown.figures.get(figure.key)?, flown.flight_seed));
    let mut values: Vec<(f64, u64)> = flown.iter().filter_map(of).collect();
    values.sort_by(|one, other| one.0.total_cmp(&other.0));
    if figure.side == Side::AtLeast {
        values.reverse();
    }
    let (count, last) = (values.len(), values.len().checked_sub(1)?);
    // From the best to the worst: the smallest rank that at least this share of the runs do not exceed.
    let ranked = |share: f64| values[((share * count as f64).ceil() as usize).clamp(1, count) - 1].0;
    let spread = 0.98 / libm::sqrt(count as f64);
    let middle = 0.5 * (values[last / 2].0 + values[count / 2].0);
    Some(Row {
        figure: figure.key,
        unit: figure.unit,
        runs: count,
        median: middle,
        median_interval: [ranked(0.5 - spread), ranked(0.5 + spread)],
        kept_by_95_percent: ranked(0.95),
        limit: limits.iter().find(|limit| limit.of == figure).map(|limit| limit.value),
        missed: flown.iter().filter(|flown| flown.missed.iter().any(|missed| missed == figure.key)).count(),
        worst_flight_seed: values[last].1,
    })
}

/// The table: the limited figures, and errors and sigmas of the last orbit.
fn text(rows: &[Row]) -> String {
    let [median, interval, keep, limit, missed] = ["median", "95 % interval of it", "95 % keep", "limit", ""];
    let mut text =
        format!("{:30} {median:>14}  {interval:28} {keep:>14} {limit:>12}  {missed:12}  worst: --seed\n", "");
    for row in rows {
        let show = |value: f64| figures_table::value(Some(value), row.unit);
        let [low, high] = row.median_interval.map(show);
        let missed = match row.limit {
            None => String::new(),
            Some(_) if row.missed == 0 => "kept".to_owned(),
            Some(_) => format!("MISSED {}/{}", row.missed, row.runs),
        };
        text += &format!(
            "{:30} {:>14}  {:28} {:>14} {:>12}  {:12}  {}\n",
            row.figure,
            show(row.median),
            format!("{low} to {high}"),
            show(row.kept_by_95_percent),
            row.limit.map_or(String::new(), show),
            missed,
            row.worst_flight_seed
        );
    }
    text
}

/// The threads that fly, so many or one for each core.
pub(super) fn threads(jobs: Option<usize>) -> Result<rayon::ThreadPool, HostError> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0)).build();
    threads.map_err(|error| HostError::usage(error.to_string(), "ask for fewer --jobs"))
}

/// Runs the command.
///
/// # Errors
/// When the scenario cannot be read or flown, or the file of runs cannot be used.
pub fn run(arguments: &CampaignRunArguments) -> Result<ExitCode, HostError> {
    let base = Scenario::named(arguments.scenario.as_deref())?;
    let flown = threads(arguments.jobs)?.install(|| flown(&base, arguments))?;
    let rows: Vec<Row> = table::figures().filter_map(|figure| row(figure, &base.limits, &flown)).collect();
    if arguments.common.json {
        rows.iter().for_each(json::print_line);
    } else {
        let shown =
            |row: &&Row| row.limit.is_some() || row.figure.contains("_95_") || row.figure.contains("_sigma_");
        let shown: Vec<Row> = rows.iter().filter(shown).cloned().collect();
        let named = arguments.scenario.as_ref().map_or(base.name.clone(), |path| path.display().to_string());
        let worst = shown.iter().max_by_key(|row| row.missed).map_or(0, |row| row.worst_flight_seed);
        say!("{}: {} runs\n{}", base.name, flown.len(), text(&shown));
        say!("To see one of them again: sil-host run {named} --seed {worst}");
    }
    let kept = flown.iter().all(|flown| flown.missed.is_empty());
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

#[cfg(test)]
mod tests;
