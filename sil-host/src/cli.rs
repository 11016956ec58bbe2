//! The words of the command line.
//!
//! In: the arguments of the process. Out: [`CommandLine`], or one line on stderr and exit status 2. Help and
//! version go to stdout with status 0.

use crate::error::HostError;
use crate::scenario;
use crate::words::one_line;
use crate::world::earth::horizon::Family;
use crate::world::earth::photometry::Photometry;
use clap::{Args, Parser, Subcommand};
use fsw_core::attitude::comparison::WahbaMethod;
use std::path::PathBuf;

/// Software in the loop for the Sextant Earth and star sensor.
///
/// Without a subcommand the default scenario is flown: six hours in GEO around an eclipse.
#[derive(Debug, Parser)]
#[command(name = "sil-host", version, about, disable_help_subcommand = true)]
pub struct CommandLine {
    /// What to do; nothing asks for the default scenario.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly a scenario, judge it, write summary, cycles, telemetry and report
    Run(RunArguments),
    /// The frame the detector would show in a second of a scenario
    Render(RenderArguments),
    /// Attitude from real pictures, without prior knowledge
    Solve(SolveArguments),
    /// Earth vector and distance from real pictures of the Earth, without prior knowledge
    Earth(EarthArguments),
    /// Identification of centroid lists, one field a line
    Identify(IdentifyArguments),
    /// Attitude from lists of vector pairs, by any of eight methods; or the methods compared (--table)
    #[command(after_help = crate::commands::attitude::methods::LINES)]
    Attitude(AttitudeArguments),
    /// Focal length, optical centre, distortion, star profiles and corrections of a lens from its sky
    /// pictures
    Calibrate(CalibrateArguments),
    /// Bad pixels and columns' offsets of a detector, from dark pictures, for the flight code
    Defects(DefectsArguments),
    /// Many seeded runs of one thing, judged together
    Campaign(CampaignArguments),
    /// Frames, parameters and telemetry for the emulated computer
    Record(RecordArguments),
    /// Centroid errors by magnitude, beside the Cramer-Rao bound
    Centroids(CentroidsArguments),
    /// Cycles, flash, RAM and stack of the flight image in the emulator, against their limits
    Budget(BudgetArguments),
    /// All parameters of the flight code: unit, range, default, source (the page fsw-core/PARAMETERS.md)
    Parameters(ParametersArguments),
    /// All columns of cycles.csv: unit, frame, meaning (the page sil-host/CYCLES.md)
    Columns(ColumnsArguments),
}

fn scenario_help() -> String {
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

/// Arguments of `solve`.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("optics").required(true).args(["camera", "fov_deg"]))]
pub struct SolveArguments {
    /// Pictures: PNG, TIFF, JPEG or FITS
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Camera file
    #[arg(long, value_name = "CAM.toml")]
    pub camera: Option<PathBuf>,
    /// Horizontal field of view of an undistorted camera, degrees
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub fov_deg: Option<f64>,
    /// Catalogue made by catalog-gen, instead of the embedded one
    #[arg(long, value_name = "FILE")]
    pub catalog: Option<PathBuf>,
    /// Defects of the detector, made by `defects`
    #[arg(long, value_name = "FILE.defects")]
    pub defects: Option<PathBuf>,
    /// One JSON object a picture on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `earth`.
#[derive(Debug, Args)]
pub struct EarthArguments {
    /// Pictures: PNG, TIFF, JPEG or FITS
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Camera file
    #[arg(long, value_name = "CAM.toml")]
    pub camera: PathBuf,
    /// The Earth's pole in the sensor frame; without it a mean sphere
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = vector)]
    pub pole: Option<[f32; 3]>,
    /// The Sun's direction in the sensor frame
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = vector)]
    pub sun: Option<[f32; 3]>,
    /// Defects of the detector, made by `defects`
    #[arg(long, value_name = "FILE.defects")]
    pub defects: Option<PathBuf>,
    /// Folder for drawings: each picture with its limb points (green, left out: red), the limb and the
    /// centre; NAME-earth.png, of pictures with one name the second is NAME-2-earth.png
    #[arg(long, value_name = "DIR")]
    pub overlay: Option<PathBuf>,
    /// One JSON object a picture on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Three numbers that make a direction.
fn vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let vector = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    let length = |[x, y, z]: [f32; 3]| x.hypot(y).hypot(z);
    // Also refuses what is no number.
    vector.filter(|vector| (1e-3..1e6).contains(&length(*vector))).ok_or_else(|| {
        "no direction: give x,y,z along the columns, the rows and the line of sight, not all zero".into()
    })
}

/// Arguments of `identify`.
#[derive(Debug, Args)]
pub struct IdentifyArguments {
    /// Fields of centroids, one JSON object a line
    #[arg(value_name = "FIELDS.jsonl")]
    pub fields: PathBuf,
    /// Camera file
    #[arg(long, value_name = "CAM.toml")]
    pub camera: PathBuf,
    /// Catalogue made by catalog-gen, instead of the embedded one
    #[arg(long, value_name = "FILE")]
    pub catalog: Option<PathBuf>,
    /// One JSON object a field on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `attitude`.
#[derive(Debug, Args)]
pub struct AttitudeArguments {
    /// Sets of vector pairs, one JSON object a line
    #[arg(value_name = "SETS.jsonl", required_unless_present = "table")]
    pub sets: Option<PathBuf>,
    /// Methods, separated by commas: svd, q, quest, foam, esoq, esoq2, lsq, anisotropic
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',', default_value = "svd", value_parser = crate::commands::attitude::methods::method)]
    pub method: Vec<WahbaMethod>,
    /// All methods on the stars of the sky, beside the thesis's table 3.9 and the Cramer-Rao bound
    #[arg(long, conflicts_with_all = ["sets", "method"])]
    pub table: bool,
    /// One JSON object an answer (or a row) on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Pictures of one lens: PNG, TIFF, JPEG or FITS
    #[arg(required_unless_present = "rendered", value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// So many pictures of the rendered sky instead, through the camera of --camera in a laboratory that is
    /// cooler than the flight
    #[arg(long, value_name = "N", conflicts_with = "images", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rendered: Option<u32>,
    /// Camera file to start from, its focal length right to 2 %
    #[arg(long, value_name = "START.toml")]
    pub camera: PathBuf,
    /// Camera file to write; a drawing of the residuals (.svg) comes beside it, and the star profiles and
    /// corrections (.corr) where the pictures show enough stars
    #[arg(long, value_name = "CAM.toml")]
    pub out: PathBuf,
    /// Charge of a full pixel by the detector's data sheet, electrons; of a rendered one the laboratory's
    #[arg(long, value_name = "E", default_value_t = 40_000.0, conflicts_with = "rendered")]
    pub full_well_e: f64,
}

/// Arguments of `defects`.
#[derive(Debug, Args)]
pub struct DefectsArguments {
    /// Five or more dark pictures of one detector: PNG, TIFF, JPEG or FITS
    #[arg(required = true, value_name = "DARK")]
    pub images: Vec<PathBuf>,
    /// The file to write
    #[arg(long, value_name = "FILE.defects")]
    pub out: PathBuf,
    /// One JSON object on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `campaign`.
#[derive(Debug, Args)]
pub struct CampaignArguments {
    /// Of what
    #[command(subcommand)]
    pub of: Campaign,
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

/// Arguments of `record`.
#[derive(Debug, Args)]
pub struct RecordArguments {
    /// Picture to show every second; without one, the mission: two minutes through every mode
    #[arg(value_name = "IMAGE", requires = "fov_deg")]
    pub image: Option<PathBuf>,
    /// Horizontal field of view of the picture's camera, degrees
    #[arg(long, value_name = "F", requires = "image", allow_negative_numbers = true)]
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
    /// One JSON object on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `parameters`.
#[derive(Debug, Args)]
pub struct ParametersArguments {
    /// One JSON object on stdout instead of the page
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `columns`.
#[derive(Debug, Args)]
pub struct ColumnsArguments {
    /// One JSON object on stdout instead of the page
    #[arg(long)]
    pub json: bool,
}

/// What the arguments ask for.
#[derive(Debug)]
pub enum Request {
    /// Do this.
    Run(CommandLine),
    /// Print this on stdout and end well (help, version).
    Print(String),
}

/// Reads the arguments, the program's name first.
///
/// # Errors
/// [`HostError::Usage`] when they make no sense, in one line.
pub fn parse<I, T>(arguments: I) -> Result<Request, HostError>
where
    I: IntoIterator<Item = T>,
    T: Into<std::ffi::OsString> + Clone,
{
    match CommandLine::try_parse_from(arguments) {
        Ok(command_line) => Ok(Request::Run(command_line)),
        Err(error) if !error.use_stderr() => Ok(Request::Print(error.render().to_string())),
        Err(error) => {
            Err(HostError::usage(first_paragraph(&error.render().to_string()), "see `sil-host --help`"))
        }
    }
}

/// The parser's complaint without its usage lines and hints, which would make it longer than a line.
fn first_paragraph(text: &str) -> String {
    let paragraph = text.split("\n\n").next().unwrap_or(text);
    one_line(paragraph.strip_prefix("error: ").unwrap_or(paragraph))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn usage(arguments: &[&str]) -> String {
        parse(arguments).expect_err("must be refused").to_string()
    }

    #[test]
    fn no_subcommand_asks_for_the_default_scenario() {
        assert!(matches!(parse(["sil-host"]), Ok(Request::Run(CommandLine { command: None }))));
    }

    #[test]
    fn solve_takes_several_pictures_and_one_description_of_the_optics() {
        let Ok(Request::Run(CommandLine { command: Some(Command::Solve(solve)) })) =
            parse(["sil-host", "solve", "a.png", "b.fits", "--fov-deg", "15.5", "--json"])
        else {
            panic!("not understood")
        };
        assert_eq!((solve.images.len(), solve.fov_deg, solve.json), (2, Some(15.5), true));
        assert!(usage(&["sil-host", "solve", "a.png"]).contains("--camera"));
        assert!(
            usage(&["sil-host", "solve", "a.png", "--camera", "c", "--fov-deg", "3"]).contains("--fov-deg")
        );
        assert!(usage(&["sil-host", "solve", "--fov-deg", "3"]).contains("IMAGE"));
    }

    #[test]
    fn earth_takes_directions_with_signs() {
        let Ok(Request::Run(CommandLine { command: Some(Command::Earth(earth)) })) = parse([
            "sil-host",
            "earth",
            "a.png",
            "b.png",
            "--camera",
            "c",
            "--pole",
            "0,-1,0",
            "--sun",
            "-0.5, 0.1,1e-2",
        ]) else {
            panic!("not understood")
        };
        assert_eq!((earth.images.len(), earth.pole), (2, Some([0.0, -1.0, 0.0])));
        assert_eq!(earth.sun, Some([-0.5, 0.1, 0.01]));
        assert!(usage(&["sil-host", "earth", "a.png", "--camera", "c", "--pole", "0,0"]).contains("--pole"));
    }

    #[test]
    fn a_usage_error_is_one_line_and_help_is_none() {
        let message = usage(&["sil-host", "identify"]);
        assert!(message.starts_with("sil-host: ") && !message.contains('\n'), "{message}");
        assert!(usage(&["sil-host", "fly"]).contains("fly"));
        assert!(matches!(parse(["sil-host", "--help"]), Ok(Request::Print(_))));
        assert!(matches!(parse(["sil-host", "--version"]), Ok(Request::Print(_))));
    }
}
