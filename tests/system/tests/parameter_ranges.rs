//! Every parameter at either end of its range: it is refused with its name, or a flight with it knows the
//! attitude.

use crate::flights::{fly, member};
use fsw_core::parameters::GROUPS;
use fsw_core::parameters::table::Row;
use sil_host::scenario::{EMBEDDED, Scenario};
use std::path::Path;

/// Seconds flown, and in how many of the last ones an attitude must be known.
const SECONDS: u32 = 24;
const LAST_S: u32 = 16;
const KNOWN_S: usize = 15;

/// The values at the ends of a range as a scenario writes them; of a choice all.
fn ends(row: &Row) -> Vec<String> {
    if let Some(words) = row.choices() {
        return words.map(|word| format!("\"{word}\"")).collect();
    }
    let (low, high) = row.range.split_once(" to ").expect("a range");
    let numbers = row.default.matches(',').count() + 1;
    let of = |end: &str| match row.kind.starts_with('[') {
        true => format!("[{}]", vec![end; numbers].join(", ")),
        false => end.to_owned(),
    };
    [low, high].map(of).to_vec()
}

/// In how many seconds from this one on an attitude is known, and the largest error over its sigma in all.
fn known_and_worst(scenario: &Scenario, from_s: u32) -> (usize, f64) {
    let (mut known, mut worst) = (0, 0.0f64);
    fly(scenario, |second| {
        if let Some(attitude) = second.judged.attitude_rad {
            worst = worst.max(attitude.worst_sigma());
            known += usize::from(second.judged.cycle >= from_s);
        }
    });
    (known, worst)
}

#[test]
fn every_parameter_flies_at_both_ends_of_its_range_or_is_refused_by_name() {
    let default = EMBEDDED[0].1.replace("duration_s = 21600", &format!("duration_s = {SECONDS}"));
    let (mut flown, mut refused, mut failed) = (0, 0, Vec::new());
    for row in GROUPS.into_iter().flatten() {
        for value in ends(row) {
            let name = format!("{}.{}", row.group, row.name);
            let text = format!("{default}\n[parameters]\n{name} = {value}\n");
            let scenario = match Scenario::parse(Path::new("ends.toml"), &text) {
                Ok(scenario) => scenario,
                Err(error) => {
                    assert!(error.to_string().contains(&name), "{error}");
                    refused += 1;
                    continue;
                }
            };
            let (known, worst) = known_and_worst(&scenario, SECONDS - LAST_S);
            let line = format!("{name} = {value}: known in {known} s, {worst:.1} sigma");
            println!("{line}");
            if known < KNOWN_S || worst >= 6.0 {
                failed.push(line);
            }
            flown += 1;
        }
    }
    println!("{flown} values flown, {refused} refused");
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(flown > 150 && refused > 0);
}

#[test]
fn a_minute_of_tracking_without_stars_ends_in_no_match_by_chance() {
    // Tracking is patient for a minute, its gate is the widest, its spots are noise: before stars that were
    // missing for seconds had to be as sure as an identification, one second told an attitude 210 sigma off.
    let (known, worst) = known_and_worst(&member("any.toml", "any-parameters.toml", 9601, 54), 0);
    println!("known in {known} s, {worst:.1} sigma");
    assert!(known > 60 && worst < 6.0);
}
