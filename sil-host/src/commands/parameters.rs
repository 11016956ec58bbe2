//! `sil-host parameters`: the table of all parameters of the flight code, as a page or as JSON.
//!
//! In: the rows that the flight code declares ([`fsw_core::parameters::GROUPS`]). Out: the page
//! `fsw-core/PARAMETERS.md`, or one JSON object `{"version", "parameters": [{"group", "name", "type", "unit",
//! "default", "range", "about", "source"}]}`.

use crate::cli::ReferenceArguments;
use crate::error::HostError;
use fsw_core::parameters::table::Row;
use fsw_core::parameters::{GROUPS, VERSION};
use serde_json::json;
use std::fmt::Write as _;
use std::process::ExitCode;

/// Does what the command line asks for.
///
/// # Errors
/// None.
pub fn run(arguments: &ReferenceArguments) -> Result<ExitCode, HostError> {
    super::print_reference(arguments.json, json, page);
    Ok(ExitCode::SUCCESS)
}

/// The words of a row, without the spaces in front of a comment's lines.
fn about(row: &Row) -> &str {
    row.about.trim()
}

fn json() -> serde_json::Value {
    let row = |row: &Row| {
        json!({
            "group": row.group, "name": row.name, "type": row.kind, "unit": row.unit, "default": row.default,
            "range": row.range, "about": about(row), "source": row.source,
        })
    };
    let rows: Vec<_> = GROUPS.into_iter().flatten().map(row).collect();
    json!({ "version": VERSION, "parameters": rows })
}

/// The page.
pub fn page() -> String {
    let mut page = format!(
        "# Parameters of the flight code\n\n\
         Written by `cargo sil parameters`; a test compares this page with the code. Table version {VERSION}. A table with a value \
         outside its range is refused and the value named as `group.name`. The camera's values (`CameraParameters`) have no \
         defaults: they come from a camera file.\n"
    );
    for rows in GROUPS {
        let Some(first) = rows.first() else { continue };
        page += &format!("\n## {}\n\n", first.group);
        page += "| name | type | unit | default | range | what it is | source, what set it |\n|---|---|---|---|---|---|---|\n";
        for row in rows {
            let Row { name, kind, unit, default, range, source, .. } = row;
            let about = about(row);
            writeln!(page, "| `{name}` | {kind} | {unit} | {default} | {range} | {about} | {source} |")
                .expect("a string takes all");
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_page_is_the_generated_one() {
        let committed = include_str!("../../../fsw-core/PARAMETERS.md");
        assert!(committed == page(), "write it again: cargo sil parameters > fsw-core/PARAMETERS.md");
    }

    #[test]
    fn every_row_is_in_the_json() {
        let json = json();
        let rows = json["parameters"].as_array().unwrap();
        assert_eq!(rows.len(), GROUPS.into_iter().flatten().count());
        assert!(rows.iter().all(|row| !row["about"].as_str().unwrap().starts_with(' ')));
    }
}
