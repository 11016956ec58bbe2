//! A handful of short flights with turned bits, by the program itself.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What is drawn: a place in the geostationary orbit, known from the ground to 1 km; 24 s instead of 160.
const VARY: &str = "
[scenario]
duration_s = 24

[orbit]
true_anomaly_deg = { uniform = [180.0, 270.0] }

[orbit_filter.start]
position_sigma_km = 1.0
velocity_sigma_m_s = 1.0
";
/// Bits turned over in a flight: one in 3 s, in the long campaign one in 40.
const FLIPS: usize = 8;

/// Flies so many flights of seed 1 from `first` on; a line of the file for each.
fn fly(name: &str, (first, runs): (u32, u32)) -> Vec<Value> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let (vary, out) = (folder.join("upsets.toml"), folder.join(format!("{name}.jsonl")));
    std::fs::write(&vary, VARY).unwrap();
    // None of a run before.
    let _ = std::fs::remove_file(&out);
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../families/rest.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_upsets"));
    command.arg("fly").arg(scenario).arg("--vary").arg(&vary).arg("--out").arg(&out);
    let numbers =
        [("--flips", FLIPS.to_string()), ("--first", first.to_string()), ("--runs", runs.to_string())];
    numbers.iter().for_each(|(key, value)| {
        command.args([*key, value.as_str()]);
    });
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code().is_some_and(|code| code <= 1), "{said}");
    let mut flown: Vec<Value> = std::fs::read_to_string(&out)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    flown.sort_by_key(|flown| flown["run"].as_u64());
    assert_eq!(flown.len(), runs as usize);
    flown
}

#[test]
fn turned_bits_tell_nothing_wrong_and_the_same_flight_comes_again() {
    let flown = fly("all", (0, 4));
    for flown in &flown {
        assert_eq!(flown["flips"].as_array().unwrap().len(), FLIPS);
        assert_eq!(flown["wrong"].as_array().unwrap().len(), 0, "{flown}");
        // Until the first turned bit the telemetry over the link is that of the harness, to the byte.
        let first = flown["flips"][0]["second"].as_u64().unwrap();
        assert!(flown["changed_s"].as_u64().is_none_or(|changed| changed >= first), "{flown}");
        assert!(flown["without"]["attitude"]["seconds"].as_u64().unwrap() > 20, "{flown}");
    }
    let changed: Vec<&Value> = flown.iter().filter(|flown| !flown["changed_s"].is_null()).collect();
    let Some(one) = changed.first() else { panic!("32 turned bits changed nothing") };
    let run = one["run"].as_u64().unwrap() as u32;
    assert_eq!(fly("one", (run, 1))[0], **one);
}
