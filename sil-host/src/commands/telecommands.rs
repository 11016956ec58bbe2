//! `sil-host telecommands`: the list of commands that the flight code obeys, as a page or as JSON.
//!
//! In: the rows and reasons that the flight code declares ([`ROWS`], [`ALL`]). Out: the page
//! `fsw-core/TELECOMMANDS.md`, or one JSON object `{"version", "commands": [{"service", "subservice", "name",
//! "fields", "about", "refusals"}], "refusals": [{"code", "name", "words"}]}`.

use crate::cli::ReferenceArguments;
use crate::error::HostError;
use fsw_core::command::refusal::ALL;
use fsw_core::command::telecommand::{Field, ROWS, Row, VERSION};
use fsw_core::command::{MAX_PART_BYTES, MAX_TELECOMMAND_BYTES};
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
    let field = |of: &Field| json!({ "name": of.name, "type": of.kind, "unit": of.unit });
    let command = |row: &Row| {
        json!({
            "service": row.number.0, "subservice": row.number.1, "name": row.name, "about": row.about,
            "fields": row.fields.iter().map(field).collect::<Vec<_>>(),
            "refusals": row.refusals.iter().map(|reason| reason.code()).collect::<Vec<_>>(),
        })
    };
    let commands: Vec<_> = ROWS.iter().map(command).collect();
    let refusals: Vec<_> = ALL
        .iter()
        .map(
            |reason| json!({ "code": reason.code(), "name": format!("{reason:?}"), "words": reason.words() }),
        )
        .collect();
    json!({ "version": VERSION, "commands": commands, "refusals": refusals })
}

/// The page.
pub fn page() -> String {
    let mut page = format!(
        "# Telecommands of the flight code\n\n\
         Written by `cargo sil telecommands`; a test compares this page with the code. Version {VERSION} of the list, the first byte \
         after the headers of a packet; numbers are big-endian. A packet has at most {MAX_TELECOMMAND_BYTES} bytes, a part of a \
         table or file at most {MAX_PART_BYTES}.\n\n\
         | service, subservice | command | fields | what it does | refused with |\n|---|---|---|---|---|\n"
    );
    for Row { number: (service, subservice), name, fields, about, refusals } in ROWS {
        let field = |of: &Field| format!("`{}` {} ({})", of.name, of.kind, of.unit);
        let fields: Vec<_> = fields.iter().map(field).collect();
        let refusals: Vec<_> = refusals.iter().map(|reason| reason.code().to_string()).collect();
        page += &format!(
            "| {service}, {subservice} | `{name}` | {} | {about} | {} |\n",
            fields.join(", "),
            refusals.join(", ")
        );
    }
    page += "\n## Reasons of a refusal\n\n\
             Those up to 31 are told when a packet arrives, in a report (1, 2), of any command; those from 32 when it is to be done, \
             in a report (1, 8); 41 to 43 in either.\n\n\
             | code | name | reason |\n|---|---|---|\n";
    for reason in ALL {
        page += &format!("| {} | `{reason:?}` | {} |\n", reason.code(), reason.words());
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_page_is_the_generated_one() {
        let committed = include_str!("../../../fsw-core/TELECOMMANDS.md");
        assert!(committed == page(), "write it again: cargo sil telecommands > fsw-core/TELECOMMANDS.md");
    }

    #[test]
    fn every_command_and_every_reason_is_in_the_json() {
        let json = json();
        assert_eq!(json["commands"].as_array().unwrap().len(), ROWS.len());
        assert_eq!(json["refusals"].as_array().unwrap().len(), ALL.len());
    }
}
