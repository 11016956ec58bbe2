//! The truth orbit against its own half steps, Kepler, and trajectories of another program.

use super::*;
use std::path::PathBuf;

const START_US: i64 = 843_393_969_184_000;

fn geo() -> (Vector, Vector) {
    state_of_elements(42_164.17, 0.0002, 0.05, 40.0, 10.0, 75.0).unwrap()
}

fn leo() -> (Vector, Vector) {
    state_of_elements(6828.0, 0.001, 51.6, 120.0, 30.0, 15.0).unwrap()
}

#[test]
fn half_the_step_moves_a_day_by_less_than_metres() {
    let elliptic = state_of_elements(24_400.0, 0.73, 7.0, 20.0, 178.0, 90.0).unwrap();
    for (name, (r, v), limit_m) in [("GEO", geo(), 1.0), ("LEO", leo(), 5.0), ("GTO", elliptic, 5.0)] {
        let fly = |step| TruthOrbit::with_forces(START_US, r, v, 86_400, Forces::default(), step).unwrap();
        let (whole, half) = (fly(STEP_S), fly(0.5 * STEP_S));
        // Between the nodes as well as on them.
        let apart = |t| 1e3 * length(minus(whole.at(t).0, half.at(t).0));
        let worst = (0..864).map(|k| apart(f64::from(k) * 100.0 + 2.5)).fold(0.0, f64::max);
        println!("{name}: {worst:.4} m in a day");
        assert!(worst < limit_m, "{name}: {worst} m");
    }
}

#[test]
fn velocity_is_the_slope_of_position() {
    let (r, v) = leo();
    let orbit = TruthOrbit::new(START_US, r, v, 600).unwrap();
    assert_eq!(orbit.at(0.0), (r, v));
    for t in [-0.5, 0.1, 2.5, 333.3, 599.0, 600.4] {
        let slope = times(1e2, minus(orbit.at(t + 5e-3).0, orbit.at(t - 5e-3).0));
        assert!(length(minus(slope, orbit.at(t).1)) < 1e-7, "{t}");
    }
}

#[test]
fn elements_give_a_state_that_has_them() {
    let (a, e, i) = (24_400.0, 0.7, 63.4f64);
    let (r, v) = state_of_elements(a, e, i, 40.0, 270.0, 130.0).unwrap();
    let momentum = cross(r, v);
    assert!((1.0 / (2.0 / length(r) - dot(v, v) / MU_EARTH) / a - 1.0).abs() < 1e-12);
    assert!((momentum[2] / length(momentum) - i.to_radians().cos()).abs() < 1e-12);
    let eccentricity = minus(times(1.0 / MU_EARTH, cross(v, momentum)), times(1.0 / length(r), r));
    assert!((length(eccentricity) - e).abs() < 1e-12);
    assert!((dot(eccentricity, r) / e / length(r) - 130f64.to_radians().cos()).abs() < 1e-12);
    // The node: where the orbit rises, at 40 deg.
    assert!((momentum[0] / -momentum[1] - 40f64.to_radians().tan()).abs() < 1e-12);
    // Perigee at 270 deg: south of the equator.
    assert!(eccentricity[2] < -0.6);
}

#[test]
fn impossible_orbits_are_refused_by_name() {
    let refused = |a, e| state_of_elements(a, e, 0.0, 0.0, 0.0, 0.0).unwrap_err().to_string();
    assert_eq!(refused(7000.0, 1.0), "eccentricity 1 is not that of an ellipse (0 to below 1)");
    assert_eq!(refused(7000.0, 0.1), "perigee at 6300.0 km from the Earth's centre is below 6478 km");
    assert_eq!(refused(-7000.0, 0.1), "semi-major axis -7000 km is not positive");
    assert_eq!(refused(f64::NAN, 0.1), "the semi-major axis is no number");
    assert!(refused(3e5, 0.8).starts_with("apogee at 540000 km"));
    let start = |r, v| TruthOrbit::new(START_US, r, v, 10).unwrap_err();
    assert_eq!(start([7000.0, 0.0, 0.0], [0.0, 12.0, 0.0]), OrbitError::Escape(12.0));
    assert!(matches!(start([7000.0, 0.0, 0.0], [0.0, 6.0, 0.0]), OrbitError::Perigee(_)));
    assert_eq!(TruthOrbit::new(START_US, geo().0, geo().1, u32::MAX), Err(OrbitError::Duration(u32::MAX)));
}

/// Samples `[t_s, r, v]` of a reference trajectory; `None` where there are no data.
fn reference(name: &str) -> Option<Vec<[f64; 7]>> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let root = std::env::var_os("SEXTANT_DATA").map_or_else(beside, PathBuf::from);
    let text = std::fs::read_to_string(root.join("orbits").join(name)).ok()?;
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    serde_json::from_value(file["samples"].clone()).unwrap()
}

/// 2023-05-16 20:00 UTC.
const REFERENCE_START_US: i64 = 737_539_269_184_000;

#[test]
fn another_programs_trajectories_are_met_with_its_forces() {
    // GMAT: EGM96 to degree and order 2, Sun and Moon of DE440. What is left comes from this world's Sun, Moon and
    // UT1, from the Earth's figure in C21 and S21, and from the frame of its pole.
    for (name, day_m, week_m) in [("geo_j2.json", 5.0, 40.0), ("leo_iss_j2.json", 5.0, 40.0)] {
        let Some(samples) = reference(name) else {
            println!("skipped: no data");
            continue;
        };
        let [_, x, y, z, u, v, w] = samples[0];
        let forces = Forces { sectorial: true, ..Forces::default() };
        let fly = |forces| {
            TruthOrbit::with_forces(REFERENCE_START_US, [x, y, z], [u, v, w], 7 * 86_400, forces, STEP_S)
        };
        let (matched, plain) = (fly(forces).unwrap(), fly(Forces::default()).unwrap());
        let apart = |orbit: &TruthOrbit, until_s: f64| {
            let early = samples.iter().filter(|s| s[0] <= until_s + 1.0);
            early.map(|s| 1e3 * length(minus(orbit.at(s[0]).0, [s[1], s[2], s[3]]))).fold(0.0, f64::max)
        };
        let (day, week) = (apart(&matched, 86_400.0), apart(&matched, 6e5 + 4800.0));
        println!(
            "{name}: {day:.2} m in a day, {week:.2} m in a week; without C22, S22 {:.1} m in a day",
            apart(&plain, 86_400.0)
        );
        assert!(day < day_m && week < week_m, "{name}: {day} m, {week} m");
    }
}
