//! `sil-host campaign`: many seeded runs of one thing, judged together.
//!
//! | module | what it is |
//! |---|---|
//! | [`flights`] | a scenario flown many times |
//! | [`scenarios`] | all scenarios, with differences of belief and without; the page of their figures |
//! | [`belief`] | a scenario with each difference between what is and what the flight code is told |
//! | [`family`] | the scenario of each run: its seed, and keys that are drawn (`--vary`) |
//! | [`variants`] | flights of several families with the same seeds |
//! | [`vary`] | the file that says what is drawn |
//! | [`identify`] | identification of random centroid fields |
//! | [`acquire`] | the whole sensor lost in space, from pixels |
//! | [`earth`] | the Earth in single frames |
//! | [`lines`] | the file of what is done |
//! | [`spread`] | medians, quantiles and confidence intervals over runs |
//! | [`table_file`] | all runs as CSV or Parquet |
//!
//! Each is an [`Experiment`], and [`runs`] does the same for all: run `i` depends on the seed and `i` alone,
//! so any number of threads, any stop and any split over machines (`--first`) give the same runs; put the
//! files of `--out` one behind the other to merge them (`sil-host/jobs` does so on clusters). What the file
//! holds already is not done again.

pub mod acquire;
pub mod belief;
pub mod earth;
pub mod family;
pub mod flights;
pub mod identify;
pub mod lines;
pub mod scenarios;
pub mod spread;
pub mod table_file;
pub mod variants;
pub mod vary;

use crate::cli::CommonArguments;
use crate::error::HostError;
use crate::words::program;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lines::LinesFile;
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use table_file::TableFile;

/// What is done many times.
pub trait Experiment: Sync {
    /// Which of them; results stand in the order of their keys.
    type Key: Ord + Clone + Send + Sync;
    /// What came of one, a line of the file.
    type Run: Serialize + DeserializeOwned + Send;
    /// What a thread uses again from run to run.
    type Workspace;

    /// Its name on the terminal.
    fn name(&self) -> &str;
    /// The runs that are asked for, in the order in which they are done.
    fn keys(&self) -> Vec<Self::Key>;
    /// The key of a run that a file holds; `None` where it is of another seed or another thing.
    fn key_of(&self, run: &Self::Run) -> Option<Self::Key>;
    /// A new workspace.
    fn workspace(&self) -> Self::Workspace;
    /// Does one.
    ///
    /// # Errors
    /// When it cannot be done, whatever comes of it.
    fn fly(&self, workspace: &mut Self::Workspace, key: &Self::Key) -> Result<Self::Run, HostError>;
}

/// All runs of an experiment in the order of their keys: those that the file of `--out` does not hold are
/// done, side by side, and added to it. The tables that were asked for are written.
///
/// # Errors
/// When a run cannot be done or a file not be used.
pub fn runs<E: Experiment>(experiment: &E, arguments: &CommonArguments) -> Result<Vec<E::Run>, HostError> {
    if let Some(path) = arguments.out.as_deref().filter(|path| arguments.held && !path.exists()) {
        return Err(HostError::input(
            path,
            None,
            "there is no such file",
            "give the file that holds runs by --out",
        ));
    }
    let tables = arguments.table.iter().map(|path| TableFile::new(path)).collect::<Result<Vec<_>, _>>()?;
    let (file, held) = LinesFile::open::<E::Run>(arguments.out.as_deref())?;
    let keys = experiment.keys();
    let mut done: BTreeMap<E::Key, Option<E::Run>> = keys.iter().map(|key| (key.clone(), None)).collect();
    for run in held {
        if let Some(place) = experiment.key_of(&run).and_then(|key| done.get_mut(&key)) {
            *place = Some(run);
        }
    }
    let wanted = |key: &E::Key| !arguments.held && done[key].is_none();
    let open: Vec<E::Key> = keys.into_iter().filter(wanted).collect();
    let bar = progress(experiment.name(), open.len() as u64, arguments.json);
    let fly_open = || -> Result<Vec<_>, HostError> {
        // In turn, so that a campaign that is stopped has done the first runs.
        let in_turn = open.into_iter().par_bridge();
        let flown = in_turn.map_init(
            || experiment.workspace(),
            |workspace, key| {
                let run = experiment.fly(workspace, &key)?;
                file.add(&run)?;
                bar.inc(1);
                Ok((key, run))
            },
        );
        flown.collect()
    };
    let flown = match arguments.jobs {
        None => fly_open(),
        Some(jobs) => {
            let threads = rayon::ThreadPoolBuilder::new().num_threads(jobs.into()).build();
            threads
                .map_err(|error| HostError::usage(error.to_string(), "ask for fewer --jobs"))?
                .install(fly_open)
        }
    };
    bar.finish_and_clear();
    done.extend(flown?.into_iter().map(|(key, run)| (key, Some(run))));
    let runs: Vec<E::Run> = done.into_values().flatten().collect();
    if let Some(path) = arguments.out.as_deref().filter(|_| arguments.held && runs.is_empty()) {
        let to_do = "give what it was flown with: the scenario, --seed, --first, --vary";
        return Err(HostError::input(path, None, "holds none of these runs", to_do));
    }
    tables.iter().try_for_each(|table| table.write(&runs))?;
    Ok(runs)
}

/// The line that says how to do the worst run of a campaign again.
fn again(campaign: &str, seed: u64, run: u64) -> String {
    let program = program();
    format!(
        "To see the worst of them again: {program} campaign {campaign} --seed {seed} --first {run} --runs 1"
    )
}

/// The bar on a terminal; nothing elsewhere.
pub(crate) fn progress(what: &str, pieces: u64, json: bool) -> ProgressBar {
    let shown = std::io::stderr().is_terminal() && !json;
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(pieces), target);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %  {eta} left") {
        bar.set_style(style.progress_chars("=> "));
        bar.set_message(what.to_string());
    }
    bar
}
