//! `sil-host serve`: the page that flies a scenario live ([`crate::serve`]).
//!
//! In: a scenario, or the folder of a recorded run. Out: a line on stdout with the page's address, which is
//! this machine's loopback; then the page, until the program is ended (Ctrl-C). It writes no file, so there is
//! nothing to put away.

use crate::cli::ServeArguments;
use crate::commands::run::FOLDER;
use crate::error::HostError;
use crate::serve::{Library, Server};
use std::path::Path;
use std::process::ExitCode;

/// Runs the command.
///
/// # Errors
/// When the scenario or the recorded run cannot be read, or the port cannot be had.
pub fn run(arguments: &ServeArguments) -> Result<ExitCode, HostError> {
    let library = Library::new(arguments.scenario.as_deref(), Path::new(FOLDER), arguments.open.clone())?;
    let scenario = library.scenarios[0].clone().with_seed(arguments.seed);
    let server = Server::bind(arguments.port, library)?;
    match &arguments.open {
        Some(folder) => server.open(folder)?,
        None => server.fly(scenario),
    }
    print_line!("{}", server.address());
    eprintln!("Open this address in a browser on this machine; Ctrl-C ends it.");
    server.run();
    Ok(ExitCode::SUCCESS)
}
