//! Bits turned over in the working memory of the flight code while it flies.
//!
//! In: a scenario, what is drawn for each flight (`--vary`), how many bits are turned over in each. Out: what
//! came of it, against the same flights without a turned bit: told wrong, restarted, attitude lost for so
//! long, or nothing at all.
//!
//! | module | what it is |
//! |---|---|
//! | [`memory`] | the flight code's memory, and which bits of it are turned over when |
//! | [`computer`] | the on-board computer, a process of its own: sensor, watchdog, one second a message |
//! | [`aboard`] | the flight code behind its link, restarted where its computer ended |
//! | [`link`] | the messages between the two |
//! | [`flight`] | a flight with turned bits beside the same without, judged |
//! | [`table`] | what all flights came to |
//!
//! A turned bit can make a value of a Rust type that the language does not have (an enum's tag, a pointer).
//! What then happens is what the machine code does, as aboard; so the flight code flies in a process of its
//! own, and the world and its judge in another, which a crash does not reach. The memory lies at the same
//! addresses in every process (Linux), so that a flight is the same when it is flown again.
//!
//! What is turned over: [`fsw_core::sensor::Sensor`] and its [`fsw_core::sensor::Workspace`], between two
//! seconds, as they lie on this machine: words are of 64 bits, on the target of 32. Not the stack (empty
//! between two seconds), not catalogue and calibration (flash aboard), not the command link.
mod aboard;
mod computer;
mod flight;
mod link;
mod memory;
mod table;

use clap::{Args, Parser, Subcommand};
use sil_host::campaign;
use sil_host::campaign::family::Family;
use sil_host::cli::CommonArguments;
use sil_host::error::{EXIT_BAD_INPUT, EXIT_JUDGED_FAILED, HostError};
use std::path::PathBuf;
use std::process::ExitCode;

/// Flights of Sextant in whose working memory bits are turned over.
#[derive(Debug, Parser)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Fly them, judge them, print what came of it
    Fly(FlyArguments),
    /// The computer of a flight, for `fly`
    #[command(hide = true)]
    Computer(ComputerArguments),
}

/// Which flights.
#[derive(Clone, Debug, Args)]
struct FamilyArguments {
    /// Scenario file, or the name of one that comes with the program
    #[arg(value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Keys of the scenario that every flight draws anew, as of `sil-host campaign run`
    #[arg(long, value_name = "FILE.toml")]
    vary: Option<PathBuf>,
}

impl FamilyArguments {
    fn family(&self) -> Result<Family, HostError> {
        Family::new(Some(&self.scenario), self.vary.as_deref())
    }
}

#[derive(Debug, Args)]
struct FlyArguments {
    #[command(flatten)]
    of: FamilyArguments,
    /// Bits turned over in each flight, one in each of so many parts of its seconds
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
    flips: u32,
    /// Flights
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    #[command(flatten)]
    common: CommonArguments,
}

#[derive(Debug, Args)]
struct ComputerArguments {
    #[command(flatten)]
    of: FamilyArguments,
    #[arg(long)]
    seed: u64,
    #[arg(long)]
    run: u64,
}

fn main() -> ExitCode {
    let done = match CommandLine::parse().command {
        Command::Fly(arguments) => fly(&arguments),
        Command::Computer(arguments) => computer::run(&arguments).map(|()| ExitCode::SUCCESS),
    };
    done.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(EXIT_BAD_INPUT)
    })
}

/// Flies and judges; the status says whether anything was told wrong.
fn fly(arguments: &FlyArguments) -> Result<ExitCode, HostError> {
    let flights = flight::Flights::new(arguments)?;
    let flown = campaign::runs(&flights, &arguments.common)?;
    let table = table::Table::of(&flown);
    if arguments.common.json {
        println!("{}", serde_json::to_string(&table).expect("a table has string keys only"));
    } else {
        println!("{}", table.text(arguments, &flown));
    }
    Ok(if table.told_wrong == 0 { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}
