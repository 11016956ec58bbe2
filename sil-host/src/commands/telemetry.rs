//! `sil-host telemetry`: the layout of the telemetry frames, for a ground system in any language.
//!
//! In: the types of a [`Report`], traced by what reads them from their bytes, and the words that stand
//! beside their fields in the flight code ([`SOURCES`]). Out: the page `fsw-core/TELEMETRY.md`, or one JSON
//! object `{"version", "root", "types": {NAME: {"about", "fields": [{"name", "type", "about"}]} or {"about",
//! "variants": [{"name", "types", "about"}]}}}`, a variant's number being its place. A type is the name of a
//! number or of a type of the list, or `{"array": [TYPE, COUNT]}`, `{"list": TYPE}` or `{"option": TYPE}`.
//! Or an XTCE document, with the telecommands ([`xtce`]).

pub mod xtce;

use crate::cli::TelemetryArguments;
use crate::error::HostError;
use fsw_core::command::CommandOutcome;
use fsw_core::command::refusal::{self, Refusal};
use fsw_core::earth::FitError;
use fsw_core::modes::{Guard, Mode};
use fsw_core::outages::SensorState;
use fsw_core::stars::identify::NotIdentified;
use fsw_core::telemetry::{
    Activity, ClockFault, ClockState, DetectorFault, EarthStatus, Event, FixFault, ImageFault, Outcome,
    RateSource, ReadingFault, Report, SOURCES, ShutterFault, VERSION,
};
use serde_json::{Map, Value, json};
use serde_reflection::{ContainerFormat, Format, Registry, Samples, Tracer, TracerConfig, VariantFormat};
use std::collections::BTreeMap;
use std::process::ExitCode;

/// The type of a frame's body.
const ROOT: &str = "Report";

/// Does what the command line asks for.
///
/// # Errors
/// None.
pub fn run(arguments: &TelemetryArguments) -> Result<ExitCode, HostError> {
    if arguments.xtce {
        crate::output::print(format_args!("{}", xtce::document()), "");
    } else {
        super::print_reference(arguments.json, layout, page);
    }
    Ok(ExitCode::SUCCESS)
}

/// The types of a report. Every enumeration is traced by itself, as a trace takes one variant of each.
fn registry() -> serde_reflection::Result<Registry> {
    let (mut tracer, samples) = (Tracer::new(TracerConfig::default()), Samples::new());
    macro_rules! trace {
        ($($name:ty),*) => { $(tracer.trace_type::<$name>(&samples)?;)* };
    }
    trace!(
        Report,
        Mode,
        Guard,
        Activity,
        NotIdentified,
        Outcome,
        ClockState,
        RateSource,
        FitError,
        EarthStatus,
        SensorState
    );
    trace!(
        Refusal,
        CommandOutcome, DetectorFault, ImageFault, ClockFault, ReadingFault, ShutterFault, FixFault, Event
    );
    tracer.registry()
}

/// The layout as JSON.
pub fn layout() -> Value {
    // The test of the page traces the same types.
    let registry = registry().unwrap_or_default();
    let words = words();
    let about = |of: &str, name: &str| words.get(&(of.into(), name.into())).cloned().unwrap_or_default();
    let mut types = Map::new();
    for (name, container) in &registry {
        let (key, parts): (&str, Vec<(&String, &str, Value)>) = match container {
            ContainerFormat::Enum(variants) => {
                ("variants", variants.values().map(|of| (&of.name, "types", contents(&of.value))).collect())
            }
            ContainerFormat::Struct(fields) => {
                ("fields", fields.iter().map(|of| (&of.name, "type", kind(&of.value))).collect())
            }
            // A report has no others.
            _ => continue,
        };
        let described = parts.into_iter().map(|(of, holds, what)| {
            let about = about(name, of);
            json!({ "name": of, holds: what, "about": about })
        });
        let parts: Vec<_> = described.collect();
        types.insert(name.clone(), json!({ "about": about(name, ""), key: parts }));
    }
    json!({ "version": VERSION, "root": ROOT, "types": types })
}

/// The types of what follows the number of a variant.
fn contents(format: &VariantFormat) -> Value {
    match format {
        VariantFormat::NewType(of) => json!([kind(of)]),
        VariantFormat::Tuple(of) => of.iter().map(kind).collect(),
        _ => json!([]),
    }
}

/// A type as the layout names it.
fn kind(format: &Format) -> Value {
    match format {
        Format::TypeName(name) => json!(name),
        Format::Option(of) => json!({ "option": kind(of) }),
        Format::Seq(of) => json!({ "list": kind(of) }),
        Format::TupleArray { content, size } => json!({ "array": [kind(content), size] }),
        // An array: all are of one type.
        Format::Tuple(of) => json!({ "array": [of.first().map(kind), of.len()] }),
        number => json!(format!("{number:?}").to_lowercase()),
    }
}

/// A type in words.
fn named(kind: &Value) -> String {
    let part = |key: &str| kind.get(key).map(named);
    match kind {
        Value::String(name) if name.starts_with(char::is_uppercase) => {
            format!("[`{name}`](#{})", name.to_lowercase())
        }
        Value::String(name) => name.clone(),
        _ => match (part("option"), part("list"), &kind["array"]) {
            (Some(of), ..) => format!("option of {of}"),
            (_, Some(of), _) => format!("list of {of}"),
            (.., array) => format!("{} x {}", array[1], named(&array[0])),
        },
    }
}

/// The words beside every type, its own under an empty name, and beside every field or variant.
fn words() -> BTreeMap<(String, String), String> {
    let mut words = BTreeMap::new();
    for reason in refusal::ALL {
        words.insert(("Refusal".into(), format!("{reason:?}")), format!("{}.", reason.words()));
    }
    for source in SOURCES {
        let (mut of, mut text) = (String::new(), String::new());
        for line in source.lines() {
            if line == "}" {
                of.clear();
            }
            let line = line.trim();
            if let Some(more) = line.strip_prefix("///") {
                text = format!("{text}{more}");
                continue;
            }
            let opened = ["pub struct ", "pub enum "].iter().find_map(|word| line.strip_prefix(word));
            let name = identifier(opened.unwrap_or(line.trim_start_matches("pub ")));
            if opened.is_some() {
                of = name.into();
            }
            // An attribute stands between the words and what they are about.
            if line.starts_with("#[") {
                continue;
            }
            let text = std::mem::take(&mut text);
            if !of.is_empty() && !name.is_empty() && !text.is_empty() {
                let name = if opened.is_some() { "" } else { name };
                words.entry((of.clone(), name.into())).or_insert_with(|| without_links(text.trim()));
            }
        }
    }
    words
}

/// The name with which a line begins.
fn identifier(line: &str) -> &str {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default()
}

/// Words without the links of the documentation: `` [`A::B`](..) `` to `` `A::B` ``.
fn without_links(text: &str) -> String {
    let mut out = String::new();
    for (index, part) in text.split("[`").enumerate() {
        match part.split_once("`]").filter(|_| index > 0) {
            Some((name, rest)) => {
                let behind = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
                out += &format!("`{name}`{}", behind.map_or(rest, |(_, rest)| rest));
            }
            None => out += part,
        }
    }
    out
}

/// The text under a key.
fn text<'v>(of: &'v Value, key: &str) -> &'v str {
    of[key].as_str().unwrap_or_default()
}

/// The page.
pub fn page() -> String {
    let layout = layout();
    let mut page = format!(
        "# Telemetry frames of the flight code\n\n\
         Written by `cargo sil telemetry`; a test compares this page with the code, another reads a flight's \
         frames by `cargo sil telemetry --json` alone. Layout version {VERSION}. `cargo sil decode FILE --json` \
         reads a stream of frames.\n\n\
         A stream is one frame after the other, each led by its length (2 bytes, low byte first). A frame is the \
         version (1 byte), a body of the type [`{ROOT}`](#{}), and the CRC-32 (ISO-HDLC) of all before (4 bytes, \
         low byte first). The body is postcard's encoding, fields in the order below without anything \
         between:\n\n\
         | type | bytes |\n|---|---|\n\
         | `u8`, `i8`, `bool` | one |\n\
         | `u16`, `u32`, `u64` | seven bits a byte, the lowest first; the highest bit of a byte says that another \
         follows |\n\
         | `i16`, `i32`, `i64` | the same of 2 n for n not below 0, of -2 n - 1 else |\n\
         | `f32`, `f64` | IEEE 754, low byte first |\n\
         | N x type | that many |\n\
         | list | their number as a `u64`, then they |\n\
         | option | 0: none; 1: it follows |\n\
         | enumeration | the number of the variant as a `u32`, then what it holds |\n",
        ROOT.to_lowercase()
    );
    let types = layout["types"].as_object().into_iter().flatten();
    let (root, others): (Vec<_>, Vec<_>) = types.partition(|(name, _)| *name == ROOT);
    for (name, described) in root.into_iter().chain(others) {
        page += &format!("\n## {name}\n\n{}\n\n", text(described, "about"));
        if let Some(fields) = described["fields"].as_array() {
            page += "| field | type | meaning |\n|---|---|---|\n";
            for field in fields {
                let (name, about) = (text(field, "name"), text(field, "about"));
                page += &format!("| `{name}` | {} | {about} |\n", named(&field["type"]));
            }
            continue;
        }
        page += "| number | variant | holds | meaning |\n|---|---|---|---|\n";
        for (number, variant) in described["variants"].as_array().into_iter().flatten().enumerate() {
            let (name, about) = (text(variant, "name"), text(variant, "about"));
            let holds: Vec<_> = variant["types"].as_array().into_iter().flatten().map(named).collect();
            page += &format!("| {number} | `{name}` | {} | {about} |\n", holds.join(", "));
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_page_is_the_generated_one() {
        let committed = include_str!("../../../fsw-core/TELEMETRY.md");
        assert!(committed == page(), "write it again: cargo sil telemetry > fsw-core/TELEMETRY.md");
    }

    #[test]
    fn every_type_field_and_variant_has_words() {
        // Also that no enumeration was left out of the trace.
        let registry = registry().unwrap();
        assert!(registry.len() > 20 && registry.contains_key(ROOT));
        for (name, described) in layout()["types"].as_object().unwrap() {
            assert!(described["about"] != "", "{name}");
            let parts = ["fields", "variants"].iter().filter_map(|key| described[key].as_array()).flatten();
            for part in parts {
                assert!(part["about"] != "", "{name}: {part}");
            }
        }
    }

    #[test]
    fn words_lose_their_links() {
        assert_eq!(without_links("For [`A::B`] and [`C`](super::C): done."), "For `A::B` and `C`: done.");
    }
}
