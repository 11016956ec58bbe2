//! `sil-host campaign identify`: the flight code's identification on random fields, beside the best peers'
//! figures.
//!
//! In: numbers of fields, a seed. Out: the robustness grid (noise by false stars), the hard cases, the random
//! skies and fields without stars, a row each with the share identified, the peers' best and what was wrong.
//! Fields are tried in blocks of [`blocks::FIELDS`]. Ends with status 1 when an identification was wrong or a
//! cell is behind the peers.
//!
//! | module | what it is |
//! |---|---|
//! | [`cases`] | the kinds of fields |
//! | [`blocks`] | fields tried at a time |

pub mod blocks;
pub mod cases;

use super::{Experiment, runs};
use crate::cli::CampaignIdentifyArguments;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::flight::lost_in_space::Solver;
use crate::flight::{self, Density};
use crate::formats::json;
use crate::harness::star_scene;
use crate::words::program;
use blocks::{Block, Key, Outcome};
use cases::{Case, LIMIT_V, Maker, Peers};
use fsw_core::camera::Camera;
use serde::Serialize;
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
    /// First field of the block with the most wrong, or else the fewest identified.
    pub worst_first: u64,
    /// Whether nothing was wrong (where the user's criterion takes more: no more than was stated and three of
    /// its standard deviations), and the share not behind
    /// the peers.
    pub kept: bool,
}

impl Row {
    fn new(case: &Case, outcome: Outcome, worst_first: u64) -> Self {
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
            worst_first,
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
            "{:<28}{tried:>9}{:>13.3}{peers:>10}{wrong:>8}{:>12.1e}{names:>11}{wrong_names:>8}{companions:>13}  {}",
            self.case,
            self.identified_percent,
            self.stated_wrong,
            if self.kept { "kept" } else { "MISSED" }
        )
    }
}

/// Blocks of fields of every case.
struct Fields<'a> {
    seed: u64,
    cases: Vec<(Case, Maker<'a>)>,
    keys: Vec<Key>,
    camera: Camera,
    catalogue: Vec<u8>,
}

impl Experiment for Fields<'_> {
    type Key = (usize, Key);
    type Run = Block;
    type Workspace = Solver;

    fn name(&self) -> &str {
        "identify"
    }

    fn keys(&self) -> Vec<Self::Key> {
        self.keys.iter().filter_map(|key| self.of(key)).collect()
    }

    fn key_of(&self, block: &Block) -> Option<Self::Key> {
        self.of(&block.key).filter(|_| block.key.seed == self.seed)
    }

    fn workspace(&self) -> Solver {
        Solver::default()
    }

    fn fly(&self, solver: &mut Solver, (case, key): &Self::Key) -> Result<Block, HostError> {
        let catalogue = flight::open(&self.catalogue)?;
        Ok(blocks::fly(key.clone(), &self.cases[*case].1, &self.camera, &catalogue, solver))
    }
}

impl Fields<'_> {
    /// A key with the place of its case in the table.
    fn of(&self, key: &Key) -> Option<(usize, Key)> {
        Some((self.cases.iter().position(|(case, _)| case.name == key.case)?, key.clone()))
    }
}

/// The rows of a campaign; `out` is the file of finished blocks.
///
/// # Errors
/// When the file cannot be used.
pub fn rows(arguments: &CampaignIdentifyArguments) -> Result<Vec<Row>, HostError> {
    let common = &arguments.common;
    let sky: Vec<_> = star_scene::sky().into_iter().filter(|star| star.v <= LIMIT_V).collect();
    let few = cases::grid().into_iter().chain(cases::hard()).map(|case| (case, arguments.fields));
    let many = [(cases::skies(), arguments.skies), (cases::no_stars(), arguments.no_stars)];
    let (mut tried, mut keys) = (Vec::new(), Vec::new());
    for (case, fields) in few.chain(many).filter(|(_, fields)| *fields > 0) {
        keys.extend(blocks::of_case(&case, common.seed, common.numbers(fields)));
        let maker = Maker::new(&case, common.seed, &sky)?;
        tried.push((case, maker));
    }
    if tried.is_empty() {
        let to_do = "give --fields, --skies or --no-stars above 0";
        return Err(HostError::usage("no field is asked for", to_do));
    }
    let camera = flight::camera(&cases::camera()?, Path::new("the camera of the campaign"))?;
    let catalogue = flight::catalogue_bytes(&camera, Density::Full)?;
    let fields = Fields { seed: common.seed, cases: tried, keys, camera, catalogue: catalogue.to_vec() };
    let blocks = runs(&fields, common)?;
    Ok(fields.cases.iter().map(|(case, _)| row(case, &blocks)).collect())
}

/// The row of a case.
fn row(case: &Case, blocks: &[Block]) -> Row {
    let blocks = || blocks.iter().filter(|block| block.key.case == case.name);
    let outcome = blocks().fold(Outcome::default(), |sum, block| sum.and(&block.outcome));
    let badness = |block: &&Block| (block.outcome.wrong, block.outcome.tried - block.outcome.identified);
    Row::new(case, outcome, blocks().max_by_key(badness).map_or(0, |block| block.key.first))
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
        print_summary(&rows, arguments.common.seed);
    }
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

/// The table for people.
fn print_summary(rows: &[Row], seed: u64) {
    let sum = rows.iter().fold(Outcome::default(), |sum, row| sum.and(&row.outcome));
    let head = format!(
        "Identification, lost in space: 15 deg square on 1024 x 1024 px, stars to V = 6\n\
         {:<28}{:>9}{:>13}{:>10}{:>8}{:>12}{:>11}{:>8}{:>13}\n\
         {:<28}{:>9}{:>13}{:>10}{:>8}{:>12}{:>11}{:>8}{:>13}",
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
    let again = rows.iter().filter(|row| !row.kept).map(|row| {
        let (program, first, fields) = (program(), row.worst_first, blocks::FIELDS);
        format!(
            "To see the worst of {} again: {program} campaign identify --seed {seed} --first {first} --fields {fields} --skies {fields}",
            row.case
        )
    });
    let lines: Vec<_> =
        std::iter::once(head).chain(rows.iter().map(Row::line)).chain([foot]).chain(again).collect();
    print_line!("{}", lines.join("\n"));
}

#[cfg(test)]
mod tests;
