//! The program `sil-host`: reads the command line, hands over to the library, turns the outcome into an exit status.

use sil_host::cli::{self, Command, Request};
use sil_host::error::{EXIT_BAD_INPUT, HostError};
use sil_host::{budget, demo, identify, record, solve};
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    run().unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(EXIT_BAD_INPUT)
    })
}

/// Does what the arguments ask for; the status tells whether a judged run kept its limits.
fn run() -> Result<ExitCode, HostError> {
    match cli::parse(std::env::args_os())? {
        Request::Print(text) => {
            // A reader that closed the pipe has what it wanted: not a fault.
            let _ = std::io::stdout().write_all(text.as_bytes());
            Ok(ExitCode::SUCCESS)
        }
        Request::Run(command_line) => match command_line.command {
            None => demo::run(),
            Some(Command::Solve(arguments)) => solve::run(&arguments),
            Some(Command::Identify(arguments)) => identify::run(&arguments),
            Some(Command::Record(arguments)) => record::run(&arguments),
            Some(Command::Budget(arguments)) => budget::run(&arguments),
        },
    }
}
