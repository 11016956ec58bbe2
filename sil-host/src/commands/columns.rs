//! `sil-host columns`: the columns of `cycles.csv`, as a page or as JSON.
//!
//! In: the columns that the file's writer declares ([`COLUMNS`]). Out: the page `sil-host/CYCLES.md`, or one
//! JSON object `{"version", "columns": [{"name", "unit", "frame", "meaning"}]}`.

use crate::cli::ReferenceArguments;
use crate::error::HostError;
use crate::formats::cycles::columns::{COLUMNS, VERSION};
use serde_json::json;
use std::process::ExitCode;

/// Does what the command line asks for.
///
/// # Errors
/// None.
pub fn run(arguments: &ReferenceArguments) -> Result<ExitCode, HostError> {
    super::print_reference(arguments.json, json, page);
    Ok(ExitCode::SUCCESS)
}

fn json() -> serde_json::Value {
    let rows = COLUMNS.iter().flat_map(|of| {
        let row = |name| json!({ "name": name, "unit": of.unit, "frame": of.frame, "meaning": of.meaning });
        of.names.iter().map(row)
    });
    json!({ "version": VERSION, "columns": rows.collect::<Vec<_>>() })
}

/// The page.
pub fn page() -> String {
    let mut page = format!(
        "# Columns of `cycles.csv`\n\n\
         Written by `cargo sil columns`; a test compares this page with the code. `sil-host run` writes a row a second. Format \
         version {VERSION}, in the column `format_version`: raised when a column is added, at the end, or means something else; \
         names stay. An empty field is a value that was not there. Errors are estimate less truth. There is no column of \
         processor cycles: the host has none that are the same in every run; `cargo budget` counts those of the emulated \
         target.\n\n\
         | column | unit | frame | what it is |\n|---|---|---|---|\n"
    );
    for of in COLUMNS {
        let names = of.names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        page += &format!("| {names} | {} | {} | {} |\n", of.unit, of.frame, of.meaning);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_page_is_the_generated_one() {
        let committed = include_str!("../../CYCLES.md");
        assert!(committed == page(), "write it again: cargo sil columns > sil-host/CYCLES.md");
    }

    #[test]
    fn every_column_is_in_the_json_and_says_what_it_is() {
        let json = json();
        let columns = json["columns"].as_array().unwrap();
        assert_eq!(columns.len(), crate::formats::cycles::columns::names().count());
        assert!(columns.iter().all(|column| !column["meaning"].as_str().unwrap().is_empty()));
    }
}
