//! Deepest stack that the flight image can use, from its machine code: no function of it has to run.
//!
//! `stack-depth IMAGE.elf`. Out: one line of JSON on stdout, [`depth::Depth`]: bytes of the deepest path from
//! the reset vector, the path, and what would make the figure worthless: calls whose target the code does not
//! name, recursion, frames of a length that is computed. With any of these the exit status is 1; bad input
//! is 2.
//!
//! A function's frame is the sum of all its instructions that lower the stack pointer ([`decode`]). Each
//! counts once: the compiler lowers it in prologues, and of two that exclude each other both count, so the
//! figure is an upper bound. A tail call counts the frame of the function that jumps, although it is given
//! back first.
//!
//! # What it cannot see
//!
//! Exceptions: the image enables no interrupt, and a fault ends it. Jumps through a register (tables of a
//! `match`) are taken to stay in their function; they are counted in `computed_jumps`. Code that the
//! debugger's host runs (semihosting) uses no stack of the target.
#![forbid(unsafe_code)]

mod decode;
mod depth;
mod image;

use std::process::ExitCode;

fn main() -> ExitCode {
    let fail = |what: String| {
        eprintln!("stack-depth: {what}");
        ExitCode::from(2)
    };
    let Some(path) = std::env::args_os().nth(1) else {
        return fail("no image named; give the path of an ELF file".into());
    };
    let bytes = match std::fs::read(&path) {
        Ok(bytes) => bytes,
        Err(error) => return fail(format!("{}: {error}; give the path of an ELF file", path.display())),
    };
    let functions = match image::functions(&bytes) {
        Ok(functions) => functions,
        Err(what) => return fail(format!("{}: {what}; give the flight image", path.display())),
    };
    let depth = depth::deepest(&functions);
    match serde_json::to_string(&depth) {
        Ok(line) => println!("{line}"),
        Err(error) => return fail(error.to_string()),
    }
    if depth.is_sound() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
