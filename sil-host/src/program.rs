//! The program: reads the command line, hands over to the commands, turns the outcome into an exit status.
//!
//! It has two names: `sil-host` in this repository, `sextant` where it is installed.

use crate::cli::{self, Request};
use crate::commands;
use crate::error::{EXIT_BAD_INPUT, HostError};
use crate::output;
use std::process::ExitCode;

/// Runs it with the arguments of the process.
pub fn run() -> ExitCode {
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
        Request::Run(command_line) => commands::obey(command_line.command.as_ref()),
    }
}
