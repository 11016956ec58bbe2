//! The program under its name in this repository.

use std::process::ExitCode;

fn main() -> ExitCode {
    sil_host::program::run()
}
