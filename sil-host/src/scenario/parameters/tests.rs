use super::*;
use crate::scenario::EMBEDDED;
use fsw_core::orbit::forces::Dynamics;
use std::path::Path;

/// The default scenario with these lines before its `[mount]`.
fn parsed(lines: &str) -> Result<Scenario, HostError> {
    let text = EMBEDDED[0].1.replacen("[mount]", &format!("{lines}\n[mount]"), 1);
    Scenario::parse(Path::new("some.toml"), &text)
}

/// What is said of one parameter.
fn refusal(lines: &str) -> String {
    parsed(&format!("[parameters]\n{lines}")).expect_err(lines).to_string()
}

#[test]
fn numbers_arrays_and_choices_reach_the_flight_code_and_nothing_else_changes() {
    let told = parsed(
        "[parameters]\ntracking.gate_px = 8\nearth.fit.least_arc_deg = 5\norbit.dynamics = \"J2\"\n\
         identification.centroid_sigma_px = [0.2, 0.5, 1.5]",
    );
    let mut wanted = parsed("").unwrap().flight_parameters(None);
    wanted.tracking.gate_px = 8;
    wanted.earth.fit.least_arc_deg = 5.0;
    wanted.orbit.dynamics = Dynamics::J2;
    wanted.identification.centroid_sigma_px = [0.2, 0.5, 1.5];
    assert_eq!(told.unwrap().flight_parameters(None), wanted);
}

#[test]
fn every_parameter_is_told_here_or_by_another_table() {
    let all = "[gyro]\n[magnetometer]\n[shutters]\npaths = \"both\"\n";
    let here = GROUPS.into_iter().flatten().filter(|row| {
        let value = match row.choices().and_then(|mut words| words.next()) {
            Some(word) => format!("\"{word}\""),
            None => row.default.to_owned(),
        };
        let read = parsed(&format!("{all}[parameters]\n{} = {value}", name(row)));
        if let Err(error) = &read {
            assert!(error.to_string().contains("another table"), "{error}");
        }
        read.is_ok()
    });
    // 16 are said elsewhere: three of imaging, the mounting, three of the gyro, three of the magnetometer, two
    // of the shutters, body and observation of the orbit, two of its misalignment.
    assert_eq!(here.count(), GROUPS.into_iter().flatten().count() - 16);
}

#[test]
fn what_cannot_be_told_is_refused_with_its_line_and_what_to_do() {
    let first = EMBEDDED[0].1.lines().position(|line| line == "[mount]").unwrap() + 2;
    for (line, words) in [
        ("tracking.gate_px = 25", "tracking.gate_px is outside its range; use a whole number, 3 to 24"),
        ("tracking.gate_px = nan", "tracking.gate_px: a value of another kind; use a whole number, 3 to 24"),
        ("tracking.gate_px = 4.5", "tracking.gate_px: a value of another kind; use a whole number, 3 to 24"),
        ("tracking.gate_px = [4, 5]", "tracking.gate_px: a value of another kind"),
        (
            "earth.limb.height_km = nan",
            "earth.limb.height_km is outside its range; use a number, 0.0 to 60.0",
        ),
        ("orbit.dynamics = \"J3\"", "orbit.dynamics: a value of another kind; use one of Kepler, J2, Full"),
        ("orbit.dynamics = 1", "orbit.dynamics: a value of another kind"),
        (
            "identification.centroid_sigma_px = 0.3",
            "a value of another kind; use all its numbers, 0.05 to 2.5",
        ),
        ("tracking.gate = 5", "tracking.gate: unknown parameter; the nearest name is tracking.gate_px"),
        ("imaging.exposure_us = 5", "another table of the scenario says this; use scenario.exposure_ms"),
        ("shutter.look_s = 60", "shutter.look_s: there is none on board; add [shutters]"),
        ("magnetometer.field_ut = 0.2", "magnetometer.field_ut: there is none on board; add [magnetometer]"),
        (
            "earth.ellipsoid.equatorial_km = 100.0",
            "with it earth.ellipsoid.polar_km is outside its range; set",
        ),
        (
            "earth.ellipsoid.polar_km = 100.0",
            "earth.ellipsoid.polar_km is outside its range; use a number, 80.0 to 120_000.0",
        ),
    ] {
        let message = refusal(line);
        assert!(message.contains(&format!("some.toml:{first}: ")) && message.contains(words), "{message}");
    }
    let mars = EMBEDDED.iter().find(|(name, _)| *name == "mars-orbit").unwrap().1;
    let text = format!("{mars}\n[parameters]\nearth.ellipsoid.equatorial_km = 6378.0\n");
    let message = Scenario::parse(Path::new("some.toml"), &text).unwrap_err().to_string();
    assert!(message.contains("equatorial_km"), "{message}");
}
