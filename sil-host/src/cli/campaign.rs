//! Arguments of the campaigns.

use super::flights::scenario_help;
use crate::world::earth::horizon::Family;
use crate::world::earth::photometry::Photometry;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Arguments of `campaign`: what it is of, or a scenario and a folder.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct CampaignArguments {
    /// Of what
    #[command(subcommand)]
    pub of: Option<Campaign>,
    /// A scenario
    #[command(flatten)]
    pub scenario: Option<CampaignFolderArguments>,
}

/// What campaigns there are.
#[derive(Debug, Subcommand)]
pub enum Campaign {
    /// Identification of random skies beside the peers' figures, with a count of false identifications
    Identify(CampaignIdentifyArguments),
    /// A scenario flown many times: every figure's median, its interval, what 95 % of the flights keep
    Run(CampaignRunArguments),
    /// The same with every difference between what is and what the flight code is told, with none, and with
    /// each alone or left out: what it costs, figure by figure
    Belief(CampaignBeliefArguments),
    /// Every scenario flown many times, with differences drawn between what is and what the flight code is
    /// told and with none: a page of all limited figures
    Scenarios(CampaignScenariosArguments),
    /// The whole sensor lost in space, from full frames in random directions of the sky
    Acquire(CampaignAcquireArguments),
    /// The Earth in single frames from low orbits to the geostationary one: error, sigma and honesty of its
    /// centre
    Earth(CampaignEarthArguments),
}

/// What every campaign asks for.
#[derive(Debug, Default, Args)]
pub struct CommonArguments {
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of the first run; campaigns of other machines begin elsewhere
    #[arg(long, value_name = "I", default_value_t = 0)]
    pub first: u64,
    /// Runs at a time [default: one for each core]
    #[arg(long, value_name = "J")]
    pub jobs: Option<u16>,
    /// File to which finished runs are appended; what it holds already is not done again
    #[arg(long, value_name = "FILE.jsonl")]
    pub out: Option<PathBuf>,
    /// Do nothing anew: what the file of --out holds
    #[arg(long, requires = "out")]
    pub held: bool,
    /// Write all runs as a table, a row a run: CSV or Parquet; may be given several times
    #[arg(long, value_name = "FILE.(csv,parquet)")]
    pub table: Vec<PathBuf>,
    /// One JSON object a row on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

impl CommonArguments {
    /// The numbers of so many runs.
    pub fn numbers(&self, runs: u64) -> std::ops::Range<u64> {
        self.first..self.first.saturating_add(runs)
    }
}

/// Arguments of `campaign run`.
#[derive(Debug, Args)]
pub struct CampaignRunArguments {
    /// Scenario file, or the name of one that comes with the program; none: the default one.
    #[arg(value_name = "SCENARIO.toml", help = scenario_help())]
    pub scenario: Option<PathBuf>,
    /// Flights
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    pub runs: u64,
    /// Keys of the scenario that every flight draws anew: a file in the scenario's shape with
    /// { uniform = [low, high] }, { log_uniform = [low, high] }, { normal = [mean, sigma] },
    /// { whole = [low, high] } or { choice = [a, b] } in the place of values
    #[arg(long, value_name = "FILE.toml")]
    pub vary: Option<PathBuf>,
    /// The rest
    #[command(flatten)]
    pub common: CommonArguments,
}

/// Arguments of `campaign SCENARIO.toml`: `campaign run` with its files in a folder.
#[derive(Debug, Args)]
pub struct CampaignFolderArguments {
    /// Scenario file, or the name of one that comes with the program: `campaign run` with its files in a
    /// folder
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Flights
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    pub runs: u64,
    /// Number of the first run; campaigns of other machines begin elsewhere
    #[arg(long, value_name = "I", default_value_t = 0)]
    pub first: u64,
    /// Runs at a time [default: one for each core]
    #[arg(long, value_name = "J")]
    pub jobs: Option<u16>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// What every flight draws anew, as of `campaign run`
    #[arg(long, value_name = "FILE.toml")]
    pub vary: Option<PathBuf>,
    /// Folder for flights.jsonl, to which finished flights are appended (what it holds is not flown again),
    /// flights.csv, a row a flight, and figures.txt, what is printed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// One JSON object a row on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

impl CampaignFolderArguments {
    /// The same as arguments of `campaign run`.
    pub fn as_run(&self) -> CampaignRunArguments {
        CampaignRunArguments {
            scenario: Some(self.scenario.clone()),
            runs: self.runs,
            vary: self.vary.clone(),
            common: CommonArguments {
                seed: self.seed,
                first: self.first,
                jobs: self.jobs,
                out: Some(self.out.join("flights.jsonl")),
                held: false,
                table: vec![self.out.join("flights.csv")],
                json: self.json,
            },
        }
    }
}

/// Arguments of `campaign belief`.
#[derive(Debug, Args)]
pub struct CampaignBeliefArguments {
    /// Scenario file, or the name of one that comes with the program; none: the default one.
    #[arg(value_name = "SCENARIO.toml", help = scenario_help())]
    pub scenario: Option<PathBuf>,
    /// Flights of each row, with the same seeds
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..))]
    pub runs: u64,
    /// The rest
    #[command(flatten)]
    pub common: CommonArguments,
}

/// Arguments of `campaign scenarios`.
#[derive(Debug, Default, Args)]
pub struct CampaignScenariosArguments {
    /// Scenario files, or names of those that come with the program; none: all of these
    #[arg(value_name = "SCENARIO.toml")]
    pub scenarios: Vec<PathBuf>,
    /// Flights of each scenario with differences, and as many with none
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    pub runs: u64,
    /// What is drawn for each flight [default: the place of the optical centre, with the sigma that the
    /// flight code is told]
    #[arg(long, value_name = "FILE.toml")]
    pub vary: Option<PathBuf>,
    /// Write the page, in Markdown [default: standard output]
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,
    /// The rest
    #[command(flatten)]
    pub common: CommonArguments,
}

/// Arguments of `campaign acquire`.
#[derive(Debug, Args)]
pub struct CampaignAcquireArguments {
    /// Directions
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    pub runs: u64,
    /// The rest
    #[command(flatten)]
    pub common: CommonArguments,
}

/// Arguments of `campaign earth`.
#[derive(Debug, Args)]
pub struct CampaignEarthArguments {
    /// Frames of each case
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..))]
    pub runs: u64,
    /// What makes the limb stand higher here than there: noise, temperature or cloud_tops
    #[arg(long, value_name = "FAMILY", default_value = "noise", value_parser = horizon)]
    pub horizon: Family,
    /// Law by which surfaces are bright: mixed or minnaert
    #[arg(long, value_name = "LAW", default_value = "mixed", value_parser = surface)]
    pub surface: Photometry,
    /// The rest
    #[command(flatten)]
    pub common: CommonArguments,
}

/// The family of horizon heights that a name means.
fn horizon(name: &str) -> Result<Family, String> {
    Family::named(name).ok_or_else(|| format!("give one of {}", Family::ALL.map(Family::name).join(", ")))
}

/// The law of brightness that a name means.
fn surface(name: &str) -> Result<Photometry, String> {
    let known = Photometry::ALL.map(Photometry::name);
    Photometry::named(name).ok_or_else(|| format!("give one of {}", known.join(", ")))
}

/// Arguments of `campaign identify`.
#[derive(Debug, Args)]
pub struct CampaignIdentifyArguments {
    /// Fields in each cell of the grid (noise by false stars) and of each hard case
    #[arg(long, value_name = "N", default_value_t = 500)]
    pub fields: u64,
    /// Random skies besides, noise and false stars mixed
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub skies: u64,
    /// Fields of false stars only
    #[arg(long, value_name = "N", default_value_t = 100)]
    pub no_stars: u64,
    /// The rest
    #[command(flatten)]
    pub common: CommonArguments,
}
