//! `sil-host modes`: the modes of the flight code and what leads from one to another, as a page, as JSON, or
//! as a drawing.
//!
//! In: the tables by which the flight code changes modes ([`TRANSITIONS`]) or is made to ([`FORCED`]). Out:
//! the page `fsw-core/MODES.md`, the drawing `sil-host/book/src/modes.svg`, or one JSON object
//! `{"transitions": [{"from", "when": [{"words", "parameter"}], "guard", "to"}], "forced": [{"from", "cause",
//! "guard", "to"}]}`.

mod drawing;

use crate::cli::ModesArguments;
use crate::error::HostError;
use crate::harness::events::reason;
use crate::judge::expected::word;
use fsw_core::modes::{Condition, FORCED, Forced, Mode, ModeParameters, TRANSITIONS, Transition};
use serde_json::json;
use std::process::ExitCode;

/// Does what the command line asks for.
///
/// # Errors
/// None.
pub fn run(arguments: &ModesArguments) -> Result<ExitCode, HostError> {
    super::print_reference(arguments.json, json, if arguments.svg { drawing::svg } else { page });
    Ok(ExitCode::SUCCESS)
}

fn json() -> serde_json::Value {
    let all = |modes: &[Mode]| modes.iter().map(|mode| word(*mode)).collect::<Vec<_>>();
    let condition = |of: &Condition| {
        let (words, parameter) = of.words();
        json!({ "words": words, "parameter": parameter })
    };
    let transition = |row: &Transition| {
        json!({
            "from": all(row.from), "when": row.when.iter().map(condition).collect::<Vec<_>>(),
            "guard": format!("{:?}", row.guard), "to": all(row.to),
        })
    };
    let forced = |row: &Forced| {
        json!({
            "from": all(row.from), "cause": row.cause, "guard": format!("{:?}", row.guard),
            "to": row.to.map(word),
        })
    };
    json!({
        "transitions": TRANSITIONS.iter().map(transition).collect::<Vec<_>>(),
        "forced": FORCED.iter().map(forced).collect::<Vec<_>>(),
    })
}

/// Modes in words; all of them are `any`.
fn words(modes: &[Mode]) -> String {
    if modes == Mode::ALL {
        return "any".to_owned();
    }
    modes.iter().map(|mode| word(*mode)).collect::<Vec<_>>().join(", ")
}

/// The letter of a change that is forced.
fn letter(number: usize) -> char {
    char::from(b'a' + number as u8)
}

/// A condition in words, with its parameter and the parameter's default.
fn condition(of: Condition) -> String {
    let (words, parameter) = of.words();
    let default =
        |name: &str| ModeParameters::ROWS.iter().find(|row| row.name == name).map(|row| row.default);
    match parameter {
        Some(name) => format!("`{name}` ({} s) {words}", default(name).unwrap_or("?")),
        None => words.to_owned(),
    }
}

/// The page.
pub fn page() -> String {
    let mut page = "# Changes of mode\n\n\
         Written by `cargo sil modes`; a test compares this page with the code, which changes modes by this table. The first row that \
         holds decides, once a second. A time is a parameter of the group `modes`, here with its default.\n\n\
         | | from | when all of these hold | event | to |\n|---|---|---|---|---|\n"
        .to_owned();
    for (number, row) in (1..).zip(TRANSITIONS) {
        let when: Vec<_> = row.when.iter().map(|of| condition(*of)).collect();
        let to = match row.to {
            [lit, dark] => format!("{}; {} where no limb in the field is lit", word(*lit), word(*dark)),
            to => words(to),
        };
        let (from, event) = (words(row.from), reason(row.guard));
        page += &format!("| {number} | {from} | {} | {event} | {to} |\n", when.join("; "));
    }
    page += "\n## Commands and damage\n\n\
             Before a second begins, whatever the table says. Of the same mode the counters begin anew. A parameter table that is \
             taken from its copy changes no mode.\n\n\
             | | from | cause | event | to |\n|---|---|---|---|---|\n";
    for (number, row) in FORCED.iter().enumerate() {
        let to = row.to.map_or("the same", word);
        let (from, event) = (words(row.from), reason(row.guard));
        page += &format!("| {} | {from} | {} | {event} | {to} |\n", letter(number), row.cause);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_page_and_drawing_are_the_generated_ones() {
        let committed = include_str!("../../../fsw-core/MODES.md");
        assert!(committed == page(), "write it again: cargo sil modes > fsw-core/MODES.md");
        let committed = include_str!("../../book/src/modes.svg");
        assert!(
            committed == drawing::svg(),
            "write it again: cargo sil modes --svg > sil-host/book/src/modes.svg"
        );
    }

    #[test]
    fn every_row_is_in_the_page_the_drawing_and_the_json() {
        let (page, drawing, json) = (page(), drawing::svg(), json());
        for number in 1..=TRANSITIONS.len() {
            assert!(page.contains(&format!("\n| {number} | ")), "{number}");
            let labels = drawing.split("</text>").filter_map(|text| text.rsplit_once('>'));
            let mut numbers = labels.flat_map(|(_, label)| label.split(", "));
            assert!(numbers.any(|label| label == number.to_string()), "{number}");
        }
        assert_eq!(json["transitions"].as_array().unwrap().len(), TRANSITIONS.len());
        assert_eq!(json["forced"].as_array().unwrap().len(), FORCED.len());
    }
}
