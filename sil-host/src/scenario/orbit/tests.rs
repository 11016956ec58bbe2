//! Orbits and forces as scenario files give them.

use crate::scenario::{EMBEDDED, Scenario};
use crate::world::attitude::Vector;
use crate::world::orbit::tle;
use crate::world::vector::{length, minus};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const TLE: &str = "tle = [\"1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927\", \
                   \"2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537\"]\n";

/// The default scenario with `orbit` for its `[orbit]` and `start`.
fn with_orbit(start: &str, orbit: &str) -> String {
    let text = EMBEDDED[0].1.replace("2026-09-23T18:00:00", start);
    let (from, to) = (text.find("a_km").unwrap(), text.find("[pointing]").unwrap());
    [&text[..from], orbit, &text[to..]].concat()
}

/// Reads a scenario that lies in `folder`.
fn parse(folder: &Path, text: &str) -> Result<Scenario, String> {
    let result = Scenario::parse(&folder.join("some.toml"), text);
    result.map_err(|error| {
        let message = error.to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    })
}

/// Six hours and some of a circular orbit of 10,000 km about the pole, every 5 minutes, as an OEM and as SP3
/// would have it.
fn way() -> impl Iterator<Item = (i64, Vector)> {
    (0..100).map(|k| {
        let (sine, cosine) = libm::sincos(6.313_481e-4 * 300.0 * k as f64);
        (k * 300, [10_000.0 * cosine, 0.0, 10_000.0 * sine])
    })
}

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sextant-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn two_line_elements_start_a_flight() {
    let text = with_orbit("2008-09-20T12:25:40", TLE);
    let scenario = parse(Path::new(""), &text).unwrap();
    let lines: Vec<&str> = TLE.split('"').filter(|part| part.len() == 69).collect();
    let none = crate::world::time::earth_orientation::EarthOrientation::default();
    let state = tle::state([lines[0], lines[1]], scenario.start_us, &none).unwrap();
    assert_eq!((scenario.position_km, scenario.velocity_km_s), state);
    assert!((scenario.period_s() / 5497.0 - 1.0).abs() < 0.01, "{}", scenario.period_s());
    assert!(scenario.scene().is_ok());
    let message = parse(Path::new(""), &text.replace("2927", "2926")).unwrap_err();
    assert!(message.contains("orbit.tle: has the check digit 6 where 7 is right"), "{message}");
    let message = parse(Path::new(""), &text.replace("tle = ", "a_km = 7000\ntle = ")).unwrap_err();
    assert!(message.contains("elements and a TLE exclude each other"), "{message}");
}

#[test]
fn an_oem_is_followed_and_must_span_the_run() {
    let folder = folder("oem");
    let mut oem = "CCSDS_OEM_VERS = 2.0\nMETA_START\nCENTER_NAME = EARTH\nREF_FRAME = GCRF\nTIME_SYSTEM = UTC\nMETA_STOP\n"
        .to_owned();
    for (t, [x, y, z]) in way() {
        let (hour, minute) = (17 + t / 3600, t / 60 % 60);
        let (day, hour) = (23 + hour / 24, hour % 24);
        writeln!(oem, "2026-09-{day}T{hour:02}:{minute:02}:00 {x:.9} {y:.9} {z:.9} 0 0 0").unwrap();
    }
    std::fs::write(folder.join("way.oem"), &oem).unwrap();
    let text = with_orbit("2026-09-23T18:00:00", "oem_file = \"way.oem\"\n");
    let scenario = parse(&folder, &text).unwrap();
    let orbit = scenario.scene().map(|_| scenario.track.clone().unwrap()).unwrap();
    for t in [0.0, 777.7, 21_600.0] {
        let (sine, cosine) = libm::sincos(6.313_481e-4 * (3600.0 + t));
        let apart_m = 1e3 * length(minus(orbit.at(t).0, [10_000.0 * cosine, 0.0, 10_000.0 * sine]));
        assert!(apart_m < 0.01, "{apart_m}");
    }
    let message = parse(&folder, &text.replace("18:00:00", "20:00:00")).unwrap_err();
    let span = "orbit.oem_file: the run is not within 2026-09-23T17:00:00 to 2026-09-24T01:15:00 UTC";
    assert!(message.contains(span), "{message}");
    std::fs::write(folder.join("way.oem"), oem.replace("GCRF", "MOON")).unwrap();
    let message = parse(&folder, &text).unwrap_err();
    assert!(message.contains("way.oem:4: REF_FRAME MOON"), "{message}");
    let message = parse(&folder, &text.replace("way.oem", "none.oem")).unwrap_err();
    assert!(message.contains("orbit.oem_file: ") && message.contains("none.oem cannot be read"), "{message}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn an_sp3_file_is_followed_with_the_earth_as_observed() {
    let folder = folder("sp3");
    let mut sp3 =
        "#cP2026  9 23 17  0  0.00000000     100 ORBIT ITR05 FIT  XXX\n%c L  cc GPS ccc cccc\n".to_owned();
    for (t, [x, y, z]) in way() {
        let (hour, minute) = (17 + t / 3600, t / 60 % 60);
        writeln!(sp3, "*  2026  9 {:2} {:2} {minute:2}  0.00000000", 23 + hour / 24, hour % 24).unwrap();
        writeln!(sp3, "PL01{x:14.6}{y:14.6}{z:14.6} 999999.999999").unwrap();
    }
    std::fs::write(folder.join("way.sp3"), sp3).unwrap();
    let text = with_orbit("2026-09-23T18:00:00", "sp3_file = \"way.sp3\"\nsp3_satellite = \"L01\"\n");
    // A round orbit in turning axes is none in space, but it can be followed.
    let scenario = parse(&folder, &text).unwrap();
    assert!((length(scenario.position_km) - 10_000.0).abs() < 1e-3);
    let message = parse(&folder, &text.replace("L01", "G07")).unwrap_err();
    assert!(message.contains("way.sp3:1: holds no position of G07"), "{message}");
    // Orientation: a series that misses the day, one that is none, and one that has it.
    let forces = |file: &str| format!("{text}\n[forces]\nearth_orientation_file = \"{file}\"\n");
    let row = |day: i64, mjd: i64| format!("2026 9 {day} 0 {mjd}.00 0.1 0.3 0.05 0 0\n");
    std::fs::write(folder.join("eop.txt"), row(22, 61_305) + &row(23, 61_306)).unwrap();
    let message = parse(&folder, &forces("eop.txt")).unwrap_err();
    assert!(
        message.contains("forces.earth_orientation_file: the Earth orientation file does not cover"),
        "{message}"
    );
    std::fs::write(folder.join("eop.txt"), "# nothing\nfoo\n").unwrap();
    let message = parse(&folder, &forces("eop.txt")).unwrap_err();
    assert!(message.contains("eop.txt:2: is no row of an IERS C04 series"), "{message}");
    let rows: String = (22..=25).map(|day| row(day, 61_283 + day)).collect();
    std::fs::write(folder.join("eop.txt"), rows).unwrap();
    let observed = parse(&folder, &forces("eop.txt")).unwrap();
    // 0.05 s of UT1 and 0.3 arcsec of the pole at 10,000 km: up to 36 + 15 m.
    let moved_m = 1e3 * length(minus(observed.position_km, scenario.position_km));
    assert!((1.0..52.0).contains(&moved_m), "{moved_m}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn forces_are_read_and_checked() {
    let parse = |forces: &str| {
        let text = format!("{}\n[forces]\n{forces}\n", EMBEDDED[0].1);
        parse(Path::new(""), &text)
    };
    let forces = parse("gravity_degree = 8\ndrag = false\nmass_kg = 5\ncr = 1.8").unwrap().forces;
    assert_eq!((forces.gravity_degree, forces.gravity_order), (8, 8));
    assert!(!forces.drag && forces.sun && forces.satellite.mass_kg == 5.0 && forces.satellite.cr == 1.8);
    assert_eq!(parse("").unwrap().forces, crate::world::orbit::Forces::default());
    for (line, key) in [
        ("gravity_degree = 37", "forces.gravity_degree"),
        ("gravity_degree = 4\ngravity_order = 5", "forces.gravity_order"),
        ("mass_kg = 0", "forces.mass_kg"),
        ("cd = nan", "forces.cd"),
        ("drag_area_m2 = -1", "forces.drag_area_m2"),
        ("gravity = 5", "`gravity`"),
    ] {
        let message = parse(line).unwrap_err();
        assert!(message.contains(key), "{message}");
    }
}
