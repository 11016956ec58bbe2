//! The book's commands work as they stand there, and those of its tables and of the README are commands.
//!
//! In a chapter the blocks ```` ```sh,run ```` are run line after line in one folder, into which the
//! chapter's blocks
//! ```` ```toml,file=NAME ```` were written; status 0 or, of a judged flight, 1 is right.

use sil_host::cli;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use system_tests::{scratch, sil_host, workspace};

/// Words of a line as a shell splits them, comments left out.
fn words(line: &str) -> Vec<String> {
    let line = line.split(" #").next().unwrap_or_default();
    line.split_whitespace().map(str::to_owned).collect()
}

/// Arguments of a line that calls the program; `None` of any other.
fn arguments(line: &str) -> Option<Vec<String>> {
    let words = words(line);
    match words.split_first_chunk() {
        Some(([cargo, sil], rest)) if cargo == "cargo" && sil == "sil" => Some(rest.to_vec()),
        _ => None,
    }
}

/// Blocks of a chapter: what stands behind the fence, and the lines.
fn blocks(text: &str) -> Vec<(&str, Vec<&str>)> {
    let (mut blocks, mut inside) = (Vec::new(), false);
    for line in text.lines() {
        match (line.strip_prefix("```"), inside) {
            (Some(kind), false) => {
                blocks.push((kind, Vec::new()));
                inside = true;
            }
            (Some(_), true) => inside = false,
            (None, true) => blocks.last_mut().expect("a block is open").1.push(line),
            (None, false) => {}
        }
    }
    blocks
}

/// The chapters of the book.
fn chapters() -> Vec<PathBuf> {
    let folder = workspace().join("sil-host/book/src");
    let files = fs::read_dir(folder).expect("the book").map(|entry| entry.expect("an entry").path());
    let mut chapters: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|of| of == "md")).collect();
    chapters.sort();
    chapters
}

#[test]
fn the_commands_of_the_book_run() {
    let mut run = 0;
    for chapter in chapters() {
        let name = chapter.file_stem().expect("a name").to_string_lossy().into_owned();
        let folder = scratch(&format!("book-{name}"));
        let text = fs::read_to_string(&chapter).expect("a chapter");
        for (kind, lines) in blocks(&text) {
            if let Some(file) = kind.strip_prefix("toml,file=") {
                fs::write(folder.join(file), lines.join("\n") + "\n").expect("written");
            }
            for line in lines.iter().filter(|_| kind == "sh,run") {
                let arguments = arguments(line).unwrap_or_else(|| panic!("{name}: no command: {line}"));
                let output = Command::new(sil_host()).args(&arguments).current_dir(&folder).output();
                let output = output.expect("the program starts");
                let words = String::from_utf8_lossy(&output.stderr).into_owned();
                assert!(matches!(output.status.code(), Some(0 | 1)), "{name}: {line}\n{words}");
                run += 1;
            }
        }
    }
    assert!(run >= 8, "{run}");
}

#[test]
fn every_command_that_is_written_down_is_one() {
    let mut read = 0;
    for page in chapters().into_iter().chain([workspace().join("README.md")]) {
        let text = fs::read_to_string(&page).expect("a page");
        let in_blocks = blocks(&text).into_iter().flat_map(|(_, lines)| lines);
        // In a table a command stands between backticks; what is left out of it as the reader's is `...`.
        let in_tables = text.lines().filter(|line| line.starts_with('|')).flat_map(|line| line.split('`'));
        for line in in_blocks.chain(in_tables).filter(|line| !line.contains("...")) {
            let Some(arguments) = arguments(line) else { continue };
            let given = std::iter::once("sil-host".to_owned()).chain(arguments);
            if let Err(error) = cli::parse(given) {
                panic!("{}: {line}: {error}", page.display());
            }
            read += 1;
        }
    }
    assert!(read >= 30, "{read}");
}
