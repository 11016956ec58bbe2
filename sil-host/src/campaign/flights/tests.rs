use super::*;
use crate::campaign::vary::Variation;
use crate::cli::CommonArguments;
use std::path::{Path, PathBuf};

/// A flight that yields one figure.
fn flown(run: u64, of: f64, missed: bool) -> Flown {
    Flown {
        scenario: "made up".into(),
        seed: 1,
        run,
        flight_seed: 100 + run,
        drawn: Values::new(),
        figures: [("mode_share".to_owned(), 1.0 - of), ("final_position_km".to_owned(), of)].into(),
        missed: if missed { vec!["final_position_km".into()] } else { Vec::new() },
        program: String::new(),
    }
}

#[test]
fn rows_are_those_counted_by_hand() {
    // 0.01 to 0.2, in no order.
    let runs: Vec<Flown> =
        (0..20).map(|run| flown(run, 0.01 * (1 + run * 7 % 20) as f64, run == 3)).collect();
    let limit = Limit { of: table::figure("final_position_km").unwrap(), value: 0.19 };
    let position = row(limit.of, &[limit], &runs).unwrap();
    assert_eq!((position.spread.runs, position.missed, position.limit), (20, 1, Some(0.19)));
    let spread = &position.spread;
    assert!((spread.median - 0.105).abs() < 1e-12 && (spread.kept_by_95_percent - 0.19).abs() < 1e-12);
    // The greatest is the worst here, the least of what is to be at least something.
    assert_eq!((position.worst_run, position.worst_flight_seed), (17, 117));
    let share = row(table::figure("mode_share").unwrap(), &[limit], &runs).unwrap();
    assert_eq!((share.worst_flight_seed, share.limit, share.missed), (117, None, 0));
    assert!((share.spread.kept_by_95_percent - 0.81).abs() < 1e-12);
    assert!(row(table::figure("first_attitude_s").unwrap(), &[], &runs).is_none());
    let text = text(&[position, share], runs.len());
    assert!(text.contains("MISSED 1/20") && text.contains("0.19 km") && text.contains("81.00 %"), "{text}");
}

#[test]
fn any_split_of_the_runs_and_any_stop_merge_to_the_same_flights() {
    let folder = std::env::temp_dir().join(format!("sextant-flights-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let text = crate::scenario::EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 12");
    let path = Path::new("short.toml");
    let variation = Variation::parse(path, "scenario.exposure_ms = { uniform = [380, 420] }".into()).unwrap();
    let family = Family::of_text(path, &text, Some(variation)).unwrap();
    let arguments = |first: u64, runs: u64, out: Option<PathBuf>| CampaignRunArguments {
        scenario: None,
        runs,
        vary: None,
        common: CommonArguments { seed: 5, first, out, json: true, ..CommonArguments::default() },
    };
    let whole = super::flown(&family, &arguments(0, 4, None)).unwrap();
    let [one, other, both] = ["one", "other", "both"].map(|name| folder.join(name));
    super::flown(&family, &arguments(0, 3, Some(one.clone()))).unwrap();
    super::flown(&family, &arguments(3, 1, Some(other.clone()))).unwrap();
    let merged = std::fs::read_to_string(&other).unwrap() + &std::fs::read_to_string(&one).unwrap();
    // The last line was cut off.
    std::fs::write(&both, &merged[..merged.len() - 9]).unwrap();
    let resumed = super::flown(&family, &arguments(0, 4, Some(both))).unwrap();
    assert_eq!(whole.len(), 4);
    assert!(whole == resumed);
    assert!(whole[0].figures != whole[1].figures && whole[0].flight_seed != whole[1].flight_seed);
    // What another campaign drew is none of this one's.
    let plain = Family::of_text(path, &text, None).unwrap();
    let held = Flights::new(&plain, &arguments(0, 4, None)).unwrap();
    assert!(whole.iter().all(|flown| !flown.drawn.is_empty() && held.key_of(flown).is_none()));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_recovery_is_shown_of_flights_with_faults_without_a_limit() {
    let drawn = |key: &str| {
        let drawn = [(key.to_owned(), serde_json::json!(1))].into();
        has_drawn_faults(&Flown { drawn, ..flown(0, 0.1, false) })
    };
    assert!(drawn("faults.0.share") && !drawn("scenario.start"));
    assert!(is_beside("recovery_s", true) && !is_beside("recovery_s", false));
    assert!(is_beside("position_95_km", false) && is_beside("attitude_sigma_arcsec", false));
    assert!(!is_beside("first_attitude_s", true));
}
