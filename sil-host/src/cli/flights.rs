//! Arguments of the commands that fly, draw or measure: scenarios, frames, the flight image.

use crate::scenario;
use clap::Args;
use std::path::PathBuf;

pub(super) fn scenario_help() -> String {
    let [(default, _), others @ ..] = &scenario::EMBEDDED;
    let others = others.map(|(name, _)| name).join(", ");
    format!("Scenario file, or one of {default} (the default), {others}")
}

/// Arguments of `run`.
#[derive(Debug, Default, Args)]
pub struct RunArguments {
    /// Scenario file, or the name of one that comes with the program; none: the default one.
    #[arg(value_name = "SCENARIO.toml", help = scenario_help())]
    pub scenario: Option<PathBuf>,
    /// Folder for the files [default: sextant-out/ and the scenario's name]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seed of everything random, instead of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Fly run I of `campaign run` with this --seed (of 1 if none is given)
    #[arg(long, value_name = "I")]
    pub run: Option<u64>,
    /// What the campaign varies
    #[arg(long, value_name = "FILE.toml", requires = "run")]
    pub vary: Option<PathBuf>,
    /// The summary as one line on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `serve`.
#[derive(Debug, Args)]
pub struct ServeArguments {
    /// Scenario file, or the name of one that comes with the program; none: the default one.
    #[arg(value_name = "SCENARIO.toml", help = scenario_help())]
    pub scenario: Option<PathBuf>,
    /// Seed of everything random, instead of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Port of the loopback address; 0: any that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Show a recorded run instead: the folder that `run --out` wrote
    #[arg(long, value_name = "DIR")]
    pub open: Option<PathBuf>,
}

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// Scenario file, or the name of one that comes with the program
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// The second, from 0
    #[arg(long, value_name = "N")]
    pub cycle: u32,
    /// Seed of everything random, instead of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// File: PNG or FITS, raw values in 16 bits
    #[arg(long, value_name = "FRAME.(png,fits)")]
    pub out: PathBuf,
}

/// Arguments of `record`.
#[derive(Debug, Args)]
pub struct RecordArguments {
    /// Picture to show every second; without one, the mission: three minutes through every mode
    #[arg(value_name = "IMAGE", requires = "fov_deg")]
    pub image: Option<PathBuf>,
    /// Horizontal field of view of the picture's camera, degrees
    #[arg(long, value_name = "F", requires = "image")]
    pub fov_deg: Option<f64>,
    /// Seconds for which a picture is shown
    #[arg(long, value_name = "N", requires = "image", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=300))]
    pub seconds: u32,
    /// Folder for the files
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Arguments of `centroids`.
#[derive(Debug, Args)]
pub struct CentroidsArguments {
    /// Scenario file, or the name of one that comes with the program [default: geo-eclipse]
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: Option<PathBuf>,
    /// Exposure, ms, instead of the scenario's
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=900))]
    pub exposure_ms: Option<u32>,
    /// Stars a magnitude
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub stars: u32,
    /// Seed of places and noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Arguments of `budget`.
#[derive(Debug, Args)]
pub struct BudgetArguments {
    /// Wait states of the flash: cycles are then a bound without cache and prefetch, against the same limits
    #[arg(long, value_name = "W", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=15))]
    pub wait_states: u8,
    /// One JSON object on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of what prints a list that the code declares: `parameters`, `columns`, `telecommands`.
#[derive(Debug, Args)]
pub struct ReferenceArguments {
    /// One JSON object on stdout instead of the page
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `modes`.
#[derive(Debug, Args)]
pub struct ModesArguments {
    /// One JSON object on stdout instead of the page
    #[arg(long)]
    pub json: bool,
    /// The diagram on stdout instead of the page, SVG
    #[arg(long, conflicts_with = "json")]
    pub svg: bool,
}

/// Arguments of `telemetry`.
#[derive(Debug, Args)]
pub struct TelemetryArguments {
    /// One JSON object on stdout instead of the page
    #[arg(long)]
    pub json: bool,
    /// An XTCE 1.2 document of frames, space packets and telecommands on stdout instead of the page
    #[arg(long, conflicts_with = "json")]
    pub xtce: bool,
}

/// Arguments of `decode`.
#[derive(Debug, Args)]
pub struct DecodeArguments {
    /// Frames, each led by its length (2 bytes, low byte first); `-` for standard input
    #[arg(value_name = "TELEMETRY")]
    pub stream: PathBuf,

    /// A JSON object a frame instead of words
    #[arg(long)]
    pub json: bool,
}
