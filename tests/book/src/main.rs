//! `cargo run -p book`: builds the book and says where it lies.

use std::process::ExitCode;

fn main() -> ExitCode {
    let folder = system_tests::workspace().join("target/book");
    match book::build(&folder) {
        Ok(_) => {
            println!("{}", folder.join("index.html").display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("book: {error:#}");
            ExitCode::FAILURE
        }
    }
}
