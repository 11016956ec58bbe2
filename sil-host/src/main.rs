//! The program `sil-host`: reads the command line, hands over to the library, turns the outcome into an exit
//! status.

use sil_host::cli::{self, Request};
use sil_host::commands;
use sil_host::error::{EXIT_BAD_INPUT, HostError};
use sil_host::output;
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
        Request::Run(command_line) => commands::obey(command_line.command.as_ref()),
    }
}
