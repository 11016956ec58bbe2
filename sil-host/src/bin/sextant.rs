//! The program under the name with which it is installed: `cargo install --path sil-host`.

use std::process::ExitCode;

fn main() -> ExitCode {
    sil_host::program::run()
}
