//! `sil-host campaign`: many skies. `identify` (here) tries the flight code's identification on random ones,
//! beside the best peers' figures.
//!
//! In: numbers of fields, a seed. Out: the robustness grid (noise by false stars), the hard cases, the random
//! skies and fields without stars, a row each with the share identified, the peers' best and what was wrong;
//! with `--out` every finished block of fields is appended to a file, and a campaign that was stopped goes on
//! from there. Everything depends on the seed alone, whatever the number of threads. Ends with status 1 when
//! an identification was wrong or a cell is behind the peers.
//!
//! | module | what it is |
//! |---|---|
//! | [`cases`] | the kinds of fields |
//! | [`blocks`] | fields tried at a time |
//! | [`flights`] | a scenario flown many times |
//! | [`belief`] | the same with each difference between what is and what the flight code is told |
//! | [`acquire`] | the whole sensor lost in space, from pixels |
//! | [`earth`] | the Earth in single frames |
//! | [`lines`] | the file of what is done |

pub mod acquire;
pub mod belief;
pub mod blocks;
pub mod cases;
pub mod earth;
pub mod flights;
pub mod lines;

use crate::cli::CampaignIdentifyArguments;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::flight::lost_in_space::Solver;
use crate::flight::{self, Density};
use crate::formats::json;
use crate::harness::star_scene;
use crate::world::scene::WorldStar;
use blocks::{Block, Key, Outcome};
use cases::{Case, LIMIT_V, Maker, Peers};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lines::LinesFile;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

/// A row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The case.
    pub case: String,
    /// What came of it.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// Identified, %.
    pub identified_percent: f64,
    /// The best of the peers, %; where they were not measured, what they reach in an easier cell.
    pub peers_percent: Option<f64>,
    /// Whether the peers were measured in this cell.
    pub peers_measured: bool,
    /// Wrong identifications that the stated probabilities allow for.
    pub stated_wrong: f64,
    /// Whether nothing was wrong (where the user's criterion takes more: no more than was stated and three of
    /// its standard deviations), and the share not behind
    /// the peers.
    pub kept: bool,
}

impl Row {
    fn new(case: &Case, outcome: Outcome) -> Self {
        let identified_percent = 100.0 * outcome.identified as f64 / outcome.tried.max(1) as f64;
        let (peers_percent, peers_measured) = match case.peers {
            Peers::Measured(share) => (Some(share), true),
            Peers::AtMost(share) => (Some(share), false),
            Peers::Unknown => (None, false),
        };
        let ahead = peers_percent.is_none_or(|peers| identified_percent >= peers);
        let stated_wrong = outcome.stated_ppb as f64 * 1e-9;
        let allowed = if case.as_in_flight() { 0.0 } else { stated_wrong + 3.0 * stated_wrong.sqrt() };
        let kept = ahead && outcome.wrong as f64 <= allowed;
        Self {
            case: case.name.clone(),
            outcome,
            identified_percent,
            peers_percent,
            peers_measured,
            stated_wrong,
            kept,
        }
    }

    fn line(&self) -> String {
        let peers = match (self.peers_percent, self.peers_measured) {
            (Some(share), true) => format!("{share:.1}"),
            (Some(share), false) => format!("<= {share:.1}"),
            (None, _) => "-".to_string(),
        };
        let Outcome { tried, wrong, names, wrong_names, companions, .. } = self.outcome;
        format!(
            "{:<28}{tried:>9}{:>13.3}{peers:>10}{wrong:>8}{:>12.1e}{names:>11}{wrong_names:>8}{companions:>11}  {}",
            self.case,
            self.identified_percent,
            self.stated_wrong,
            if self.kept { "kept" } else { "MISSED" }
        )
    }
}

/// What a campaign is run with.
struct Campaign<'a> {
    seed: u64,
    sky: &'a [WorldStar],
    cases: Vec<(Case, u64)>,
}

impl Campaign<'_> {
    /// Tries the blocks that are not `held` yet, and calls `finished` with each.
    fn fly(
        &self,
        held: &HashMap<Key, Outcome>,
        finished: impl Fn(&blocks::Block) -> Result<(), HostError> + Sync,
    ) -> Result<Vec<Row>, HostError> {
        let file = cases::camera()?;
        let camera = flight::camera(&file, Path::new("the camera of the campaign"))?;
        let bytes = flight::catalogue_bytes(&camera, Density::Full)?;
        let catalogue = flight::open(&bytes)?;
        let mut outcomes = vec![Outcome::default(); self.cases.len()];
        let mut open = Vec::new();
        let mut makers = Vec::new();
        for (index, (case, fields)) in self.cases.iter().enumerate() {
            makers.push(Maker::new(case, self.seed, self.sky)?);
            for key in blocks::of_case(case, self.seed, *fields) {
                match held.get(&key) {
                    Some(outcome) => outcomes[index] = outcomes[index].and(outcome),
                    None => open.push((index, key)),
                }
            }
        }
        let flown: Vec<_> = open
            .into_iter()
            // In turn, so that a campaign that is stopped has done the first blocks.
            .par_bridge()
            .map_init(Solver::default, |solver, (index, key)| {
                let block = blocks::fly(key, &makers[index], &camera, &catalogue, solver);
                finished(&block)?;
                Ok((index, block.outcome))
            })
            .collect::<Result<_, HostError>>()?;
        for (index, outcome) in flown {
            outcomes[index] = outcomes[index].and(&outcome);
        }
        Ok(self.cases.iter().zip(outcomes).map(|((case, _), outcome)| Row::new(case, outcome)).collect())
    }
}

/// The bar on a terminal; nothing elsewhere.
fn progress(what: &str, pieces: u64, json: bool) -> ProgressBar {
    let shown = std::io::stderr().is_terminal() && !json;
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(pieces), target);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %  {eta} left") {
        bar.set_style(style.progress_chars("=> "));
        bar.set_message(what.to_string());
    }
    bar
}

/// Flies the runs of a campaign that are not done yet, on every core, adds each to the file, and gives all in
/// the order of their keys. `what` names the campaign on the terminal, `json`: nothing is shown there;
/// `workspace` makes what a thread uses again from run to run.
///
/// # Errors
/// When a run cannot be flown or the file not be written.
fn fly_open<K: Copy + Ord + Send, R: Serialize + Send, W>(
    (what, json): (&str, bool),
    file: &LinesFile,
    mut done: BTreeMap<K, R>,
    keys: impl Iterator<Item = K>,
    workspace: impl Fn() -> W + Send + Sync,
    fly: impl Fn(&mut W, K) -> Result<R, HostError> + Send + Sync,
) -> Result<Vec<R>, HostError> {
    let open: Vec<K> = keys.filter(|key| !done.contains_key(key)).collect();
    let bar = progress(what, open.len() as u64, json);
    let flown: Result<Vec<(K, R)>, HostError> = open
        .into_iter()
        // In turn, so that a campaign that is stopped has done the first runs.
        .par_bridge()
        .map_init(workspace, |workspace, key| {
            let flown = fly(workspace, key)?;
            file.add(&flown)?;
            bar.inc(1);
            Ok((key, flown))
        })
        .collect();
    bar.finish_and_clear();
    done.extend(flown?);
    Ok(done.into_values().collect())
}

/// The rows of a campaign; `out` is the file of finished blocks.
///
/// # Errors
/// When the file cannot be used.
pub fn rows(arguments: &CampaignIdentifyArguments) -> Result<Vec<Row>, HostError> {
    let sky: Vec<_> = star_scene::sky().into_iter().filter(|star| star.v <= LIMIT_V).collect();
    let few = cases::grid().into_iter().chain(cases::hard()).map(|case| (case, arguments.fields));
    let many = [(cases::skies(), arguments.skies), (cases::no_stars(), arguments.no_stars)];
    let cases: Vec<_> = few.chain(many).filter(|(_, fields)| *fields > 0).collect();
    let campaign = Campaign { seed: arguments.common.seed, sky: &sky, cases };
    let (file, held) = LinesFile::open::<Block>(arguments.common.out.as_deref())?;
    let held: HashMap<Key, Outcome> = held.into_iter().map(|block| (block.key, block.outcome)).collect();
    let keys = campaign.cases.iter().flat_map(|(case, n)| blocks::of_case(case, arguments.common.seed, *n));
    let open = keys.filter(|key| !held.contains_key(key)).count();
    let bar = progress("identify", open as u64, arguments.common.json);
    let rows = campaign.fly(&held, |block| {
        bar.inc(1);
        file.add(block)
    });
    bar.finish_and_clear();
    rows
}

/// Runs the command.
///
/// # Errors
/// When the file of blocks cannot be used.
pub fn run(arguments: &CampaignIdentifyArguments) -> Result<ExitCode, HostError> {
    let rows = rows(arguments)?;
    let kept = rows.iter().all(|row| row.kept);
    if arguments.common.json {
        rows.iter().for_each(json::print_line);
    } else {
        print_summary(&rows);
    }
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

/// The table for people.
fn print_summary(rows: &[Row]) {
    let sum = rows.iter().fold(Outcome::default(), |sum, row| sum.and(&row.outcome));
    let head = format!(
        "Identification, lost in space: 15 deg square on 1024 x 1024 px, stars to V = 6\n\
         {:<28}{:>9}{:>13}{:>10}{:>8}{:>12}{:>11}{:>8}{:>11}\n\
         {:<28}{:>9}{:>13}{:>10}{:>8}{:>12}{:>11}{:>8}{:>11}",
        "",
        "",
        "identified,",
        "peers'",
        "wrong",
        "wrong as",
        "",
        "wrong",
        "companions'",
        "case",
        "fields",
        "%",
        "best, %",
        "skies",
        "stated",
        "names",
        "names",
        "names",
    );
    let foot = format!(
        "{} skies identified, {} wrong; of {} names {} wrong",
        sum.identified, sum.wrong, sum.names, sum.wrong_names
    );
    let lines: Vec<_> = std::iter::once(head).chain(rows.iter().map(Row::line)).chain([foot]).collect();
    // A reader that closed the pipe has what it wanted: not a fault.
    say!("{}", lines.join("\n"));
}

#[cfg(test)]
mod tests;
