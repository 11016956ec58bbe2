//! The change indicator: what the flight code says in every second of the mission through all modes, as a
//! table in the repository.
//!
//! World and flight code give the same bits on every machine, so the table changes only when somebody changes
//! what flies, or the sky it flies under. That may be meant; then the difference is looked at, row by row,
//! and the table made anew: `SEXTANT_BLESS=1 cargo test -p system-tests --test change_indicator`.

use fsw_core::telemetry::Report;
use sil_host::commands::record::{self, mission::MISSION};
use sil_host::harness::status::{activity_word, fault_words};
use sil_host::judge::expected::word;
use system_tests::{scratch, workspace};

const TABLE: &str = "tests/system/tests/change_indicator.csv";
const COLUMNS: &str = "second,mode,status,stars,detections,qx,qy,qz,qw,sigma_x_arcsec,sigma_y_arcsec,sigma_z_arcsec,\
                       earth_status,limb_points,earth_x,earth_y,earth_z,distance_km,x_km,y_km,z_km,sigma_km,events,activity,faults";
/// Rows of a difference that are shown.
const SHOWN: usize = 12;

/// Numbers, or as many empty cells.
fn numbers<const N: usize>(values: Option<[f64; N]>, digits: usize) -> String {
    let cell = |k: usize| values.map_or_else(String::new, |values| format!("{:.digits$}", values[k]));
    (0..N).map(cell).collect::<Vec<_>>().join(",")
}

fn row(report: &Report) -> String {
    let Report { attitude, earth, orbit, .. } = report;
    let arcsec = |sigma: [f32; 3]| sigma.map(|rad| f64::from(rad).to_degrees() * 3600.0);
    let worst = |sigma: [f32; 3]| [sigma.into_iter().fold(0.0, f32::max).into()];
    let events: Vec<String> = report.events.iter().map(|event| format!("{event:?}")).collect();
    [
        report.cycle.to_string(),
        word(report.mode).to_owned(),
        report.outcome.map_or_else(|| "Waiting".to_owned(), |outcome| format!("{outcome:?}")),
        report.stars.len().to_string(),
        report.detections.to_string(),
        numbers(attitude.map(|attitude| attitude.quaternion.map(f64::from)), 7),
        numbers(attitude.map(|attitude| arcsec(attitude.sigma_rad)), 2),
        format!("{:?}", report.earth_status),
        report.limb_px.len().to_string(),
        numbers(earth.map(|earth| earth.direction.map(f64::from)), 6),
        numbers(earth.map(|earth| [earth.distance_km.into()]), 1),
        numbers(orbit.map(|orbit| orbit.position_km), 3),
        numbers(orbit.map(|orbit| worst(orbit.sigma_position_km)), 3),
        format!("\"{}\"", events.join(" ")),
        activity_word(report.activity).to_owned(),
        fault_words(report),
    ]
    .join(",")
}

#[test]
fn what_flies_is_what_was_reviewed() {
    let folder = scratch("change-indicator");
    let (_, reports) = record::record_flight(&MISSION, &folder).expect("the target folder can be written");
    // The frames are large.
    std::fs::remove_dir_all(&folder).expect("the folder was made above");
    let mut found = format!("{COLUMNS}\n");
    reports.iter().for_each(|report| found += &format!("{}\n", row(report)));
    let path = workspace().join(TABLE);
    if std::env::var_os("SEXTANT_BLESS").is_some() {
        std::fs::write(&path, &found).expect("the repository can be written");
    }
    let reviewed = std::fs::read_to_string(&path).expect("the table is in the repository");
    let pairs = || reviewed.lines().zip(found.lines()).filter(|(old, new)| old != new);
    for (old, new) in pairs().take(SHOWN) {
        println!("- {old}\n+ {new}");
    }
    let rows = (reviewed.lines().count(), found.lines().count());
    assert!(
        rows.0 == rows.1 && pairs().count() == 0,
        "{} rows differ from {TABLE} ({} there, {} here); if that is meant, look at them and make it anew with SEXTANT_BLESS=1",
        pairs().count(),
        rows.0,
        rows.1
    );
}
