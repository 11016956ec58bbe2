//! The program `sil-host`: reads the command line, hands over to the library, turns the outcome into an exit
//! status.

use sil_host::cli::{self, Campaign, Command, Request, RunArguments};
use sil_host::commands::{
    attitude, budget, calibrate, centroids, columns, defects, earth, identify, parameters, record, render,
    run, solve,
};
use sil_host::error::{EXIT_BAD_INPUT, HostError};
use sil_host::{campaign, output};
use std::process::ExitCode;

fn main() -> ExitCode {
    let status = obey().and_then(|status| output::lost().map(|()| status));
    status.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(EXIT_BAD_INPUT)
    })
}

/// Does what the arguments ask for; the status says whether a judged run kept its limits.
fn obey() -> Result<ExitCode, HostError> {
    match cli::parse(std::env::args_os())? {
        Request::Print(text) => {
            output::print(format_args!("{text}"), "");
            Ok(ExitCode::SUCCESS)
        }
        Request::Run(command_line) => match command_line.command {
            None => run::run(&RunArguments::default()),
            Some(Command::Run(arguments)) => run::run(&arguments),
            Some(Command::Render(arguments)) => render::run(&arguments),
            Some(Command::Solve(arguments)) => solve::run(&arguments),
            Some(Command::Earth(arguments)) => earth::run(&arguments),
            Some(Command::Calibrate(arguments)) => calibrate::run(&arguments),
            Some(Command::Defects(arguments)) => defects::run(&arguments),
            Some(Command::Identify(arguments)) => identify::run(&arguments),
            Some(Command::Attitude(arguments)) => attitude::run(&arguments),
            Some(Command::Campaign(arguments)) => match arguments.of {
                Campaign::Identify(arguments) => campaign::identify::run(&arguments),
                Campaign::Run(arguments) => campaign::flights::run(&arguments),
                Campaign::Belief(arguments) => campaign::belief::run(&arguments),
                Campaign::Acquire(arguments) => campaign::acquire::run(&arguments),
                Campaign::Earth(arguments) => campaign::earth::run(&arguments),
            },
            Some(Command::Record(arguments)) => record::run(&arguments),
            Some(Command::Centroids(arguments)) => centroids::run(&arguments),
            Some(Command::Budget(arguments)) => budget::run(&arguments),
            Some(Command::Parameters(arguments)) => parameters::run(&arguments),
            Some(Command::Columns(arguments)) => columns::run(&arguments),
        },
    }
}
