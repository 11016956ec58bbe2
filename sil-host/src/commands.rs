//! What the commands do: one file a command, each with a `run` that takes its arguments and gives the exit
//! status.
//!
//! The campaigns have a room of their own, [`crate::campaign`]. A new command is a file here, a variant of
//! [`Command`] and a line in [`obey`]; one of another program is shown in `sil-host/examples/extended`.

pub mod attitude;
pub mod budget;
pub mod calibrate;
pub mod centroids;
pub mod columns;
pub mod decode;
pub mod defects;
pub mod earth;
pub mod gallery;
pub mod identify;
pub mod installed;
pub mod modes;
pub mod navigate;
pub mod outages;
pub mod parameters;
pub mod picture_camera;
pub mod propagate;
pub mod record;
pub mod render;
pub mod run;
pub mod serve;
pub mod solve;
pub mod telecommands;
pub mod telemetry;

use crate::campaign;
use crate::cli::{Campaign, CampaignArguments, Command, RunArguments};
use crate::error::HostError;
use std::process::ExitCode;

/// Prints a list that the code declares: as one JSON object, or as the page that people read.
fn print_reference(as_json: bool, json: fn() -> serde_json::Value, page: fn() -> String) {
    if as_json {
        crate::formats::json::print_line(&json());
    } else {
        crate::output::print(format_args!("{}", page()), "");
    }
}

/// Does what a campaign asks for.
fn obey_campaign(arguments: &CampaignArguments) -> Result<ExitCode, HostError> {
    match (&arguments.of, &arguments.scenario) {
        (Some(Campaign::Identify(arguments)), _) => campaign::identify::run(arguments),
        (Some(Campaign::Run(arguments)), _) => campaign::flights::run(arguments),
        (Some(Campaign::Belief(arguments)), _) => campaign::belief::run(arguments),
        (Some(Campaign::Scenarios(arguments)), _) => campaign::scenarios::run(arguments),
        (Some(Campaign::Acquire(arguments)), _) => campaign::acquire::run(arguments),
        (Some(Campaign::Earth(arguments)), _) => campaign::earth::run(arguments),
        (None, Some(arguments)) => campaign::flights::run_in_folder(arguments),
        (None, None) => {
            let to_do = format!("see `{} campaign --help`", crate::words::program());
            Err(HostError::usage("of what the campaign is to be is not said", to_do))
        }
    }
}

/// Does what a command asks for; none: flies the default scenario. The status says whether a judged run kept
/// its limits.
///
/// # Errors
/// What the command says.
pub fn obey(command: Option<&Command>) -> Result<ExitCode, HostError> {
    let Some(command) = command else { return run::run(&RunArguments::default()) };
    match command {
        Command::Run(arguments) => run::run(arguments),
        Command::Serve(arguments) => serve::run(arguments),
        Command::Render(arguments) => render::run(arguments),
        Command::Solve(arguments) => solve::run(arguments),
        Command::Earth(arguments) => earth::run(arguments),
        Command::Calibrate(arguments) => calibrate::run(arguments),
        Command::Defects(arguments) => defects::run(arguments),
        Command::Identify(arguments) => identify::run(arguments),
        Command::Attitude(arguments) => attitude::run(arguments),
        Command::Navigate(arguments) => navigate::run(arguments),
        Command::Propagate(arguments) => propagate::run(arguments),
        Command::Outages(arguments) => outages::run(arguments),
        Command::Campaign(arguments) => obey_campaign(arguments),
        Command::Gallery(arguments) => gallery::run(arguments),
        Command::Record(arguments) => record::run(arguments),
        Command::Centroids(arguments) => centroids::run(arguments),
        Command::Budget(arguments) => budget::run(arguments),
        Command::Parameters(arguments) => parameters::run(arguments),
        Command::Modes(arguments) => modes::run(arguments),
        Command::Columns(arguments) => columns::run(arguments),
        Command::Telecommands(arguments) => telecommands::run(arguments),
        Command::Telemetry(arguments) => telemetry::run(arguments),
        Command::Decode(arguments) => decode::run(arguments),
        Command::Completions(arguments) => installed::completions(arguments),
        Command::Man(arguments) => installed::man(arguments),
    }
}
