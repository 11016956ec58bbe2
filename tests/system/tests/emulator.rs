//! The flight image on the emulated Cortex-M4F: the same bits as on the host, within the limits of the
//! budget.

use fsw_core::modes::Mode;
use fsw_core::telemetry::{self, Outcome, Report};
use serde_json::Value;
use sil_host::commands::record::ground::{self, Ground};
use sil_host::commands::record::mission::{Clip, Flight, GYRO};
use sil_host::commands::record::record_flight;
use sil_host::formats::defects_file;
use sil_host::formats::frames_file::Recording;
use sil_host::world::detector::disturbances::Disturbances;
use std::path::Path;
use std::process::{Command, Output};
use system_tests::{data, direction, json_lines, run, scratch, separation_arcsec, target_dir, workspace};

/// The emulated machines: a Cortex-M4F, the reference, and a Cortex-M7.
const M4F: &str = "mps2-an386";
const M7: &str = "mps2-an500";

/// A gyro, and a detector of which nine hot pixels of ten are known on board.
const SURVEYED: Flight = Flight { disturbances: Some((0, surveyed)), ..GYRO };

/// Two seconds.
const SHORT: Clip = Clip { seconds: 2, ..GYRO.clips[0] };

fn surveyed() -> Disturbances {
    Disturbances { hot_pixels: 5_000, dead_low: 20, dead_high: 20, surveyed: 0.9, ..Disturbances::default() }
}

/// Runs the flight image in the emulator on files of a folder; the telemetry goes to `obc.bin`.
fn obc(machine: &str, folder: &Path, frames: &str, parameters: &str) -> Output {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["obc", "--quiet", "--"])
        .args([frames, parameters, "obc.bin"].map(|name| folder.join(name)))
        .current_dir(workspace())
        .env("CARGO_TARGET_DIR", target_dir())
        .env("OBC_MACHINE", machine)
        .env("BAD_PIXELS", folder.join("bad-pixels.bin"))
        .output()
        .expect("cargo starts")
}

/// Flies a recording in the emulator and gives host's and target's telemetry.
fn fly(machine: &str, folder: &Path) -> (Vec<u8>, Vec<u8>) {
    let output = obc(machine, folder, "frames.bin", "parameters.bin");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    (read("telemetry.bin"), read("obc.bin"))
}

fn reports(mut stream: &[u8]) -> Vec<Report> {
    let mut reports = Vec::new();
    while let Some((frame, rest)) = telemetry::split_first(stream) {
        reports.push(telemetry::decode(frame).expect("a whole frame"));
        stream = rest;
    }
    assert!(stream.is_empty(), "the stream ends with a whole frame");
    reports
}

#[test]
fn every_mode_the_widest_limb_and_a_storm_give_the_hosts_telemetry_and_keep_the_budget() {
    let output = run(&["budget", "--json"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    let budget = json_lines(&output).pop().unwrap_or_else(|| panic!("no table: {errors}"));
    println!("{budget:#}");
    let seconds = Value::from(208 + 166 + 12 + 14 + 54 + 48 + 12);
    assert_eq!((&budget["seconds"], &budget["telemetry_identical"]), (&seconds, &Value::from(true)));
    assert!(output.status.success(), "a limit is overrun: {budget:#}");
    let stack = |key: &str| budget[key].as_u64().expect(key);
    assert!(stack("stack_painted_bytes") > 1_000, "the paint was touched");
    assert!(
        stack("stack_analysed_bytes") >= stack("stack_painted_bytes"),
        "the analysis bounds what is touched"
    );
    for mode in ["self-test", "acquisition", "tracking", "eclipse", "sun-outage", "safe"] {
        let used = budget["modes"][mode]["worst_cycles"].as_u64().expect(mode);
        assert!(used > 10_000, "{mode}: the meter counted");
        assert!(used <= budget["modes"][mode]["limit_cycles"].as_u64().unwrap());
        assert!(used <= budget["modes"][mode]["bound_cycles"].as_u64().expect("a bound"));
    }
    for (stage, bound) in budget["bounds"].as_object().expect("a bound of each stage") {
        assert!(bound["worst_cycles"].as_u64() <= bound["bound_cycles"].as_u64(), "{stage}");
        let reckoned = bound["reckoned"].as_array().expect("names");
        for (name, cap) in bound["caps"].as_object().expect("caps") {
            let reached = bound["reached"][name].as_u64().expect("a count") >= cap.as_u64().expect("a cap");
            assert!(reached || reckoned.iter().any(|other| other == name), "{stage}: {name}");
        }
    }
    let stages = |mode: &str| budget["modes"][mode]["stages"].as_object().unwrap().clone();
    for stage in ["predict", "windows", "confirm", "limb", "centre", "orbit"] {
        assert!(stages("tracking").contains_key(stage), "{stage} in tracking");
    }
    for stage in ["scan", "identify", "search"] {
        assert!(stages("acquisition").contains_key(stage), "{stage} in acquisition");
    }
}

#[test]
fn a_gyro_and_known_bad_pixels_fly_through_a_sunrise_on_the_target_as_on_the_host() {
    let folder = scratch("gyro");
    let (files, _) = record_flight(&SURVEYED, &folder).unwrap();
    let (host, target) = fly(M4F, &folder);
    assert!(!host.is_empty() && host == target, "telemetry of host and target differs");
    assert!(fly(M7, &folder).1 == target, "telemetry of Cortex-M4F and Cortex-M7 differs");
    let reports = reports(&target);
    assert!(reports.iter().all(|report| report.faults.rate_sensor.is_none()));
    let carried: Vec<_> = reports
        .iter()
        .filter_map(|report| report.attitude.as_ref())
        .filter(|attitude| attitude.age_s > 0)
        .collect();
    // Without the table another telemetry comes of it.
    let mut instrument = SURVEYED.instrument().unwrap();
    let [width_px, height_px] = [instrument.geometry.width_px, instrument.geometry.height_px];
    instrument.defects = defects_file::table([width_px, height_px], &[], &[]);
    let recording = &mut Recording::load(&files.frames).unwrap();
    assert!(ground::fly(recording, &instrument, &Ground::default()).unwrap().0 != reports);
    // The mission's time-outs give an outage up after its tenth second.
    let oldest_s = carried.iter().map(|attitude| attitude.age_s).max();
    println!("carried for {oldest_s:?} s");
    assert!(oldest_s >= Some(10), "{oldest_s:?}");
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn a_real_photograph_is_solved_on_the_target_as_on_the_host() {
    let image = "tomcreusot/16mm_checker_2/Nunki/nunki_700000e_11.3g.png";
    let (Some(picture), Some(truth)) = (data(&format!("sky/{image}")), data("sky/truth.json")) else {
        return;
    };
    let truth: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    let truth = truth.iter().find(|entry| entry["image"] == image).unwrap();
    let number = |key: &str| truth[key].as_f64().unwrap();

    let folder = scratch("photograph");
    let fov_deg = (number("FOV_h_deg") * 1.01).to_string();
    let (picture, out) = (picture.to_str().unwrap(), folder.to_str().unwrap());
    let output = run(&["record", picture, "--fov-deg", &fov_deg, "--seconds", "6", "--out", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (host, target) = fly(M4F, &folder);
    assert!(!host.is_empty() && host == target, "telemetry of host and target differs");

    let reports = reports(&target);
    assert_eq!(
        [reports[0].outcome, reports[1].outcome],
        [Outcome::SelfTestPassed, Outcome::Identified].map(Some)
    );
    let (first, tracking) = reports.split_at(3);
    assert!(
        tracking
            .iter()
            .all(|report| report.mode == Mode::Tracking && report.outcome == Some(Outcome::Tracked))
    );
    for report in first.iter().skip(1).chain(tracking) {
        let [x, y, z, w] = report
            .attitude
            .as_ref()
            .expect("an attitude every second after the self-test")
            .quaternion
            .map(f64::from);
        // Third row of the matrix of eq. 2.4: where the middle of the picture points.
        let middle = [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), w * w + z * z - x * x - y * y];
        let error = separation_arcsec(middle, direction(number("RA_deg"), number("Dec_deg")));
        println!("{:?}: {error:.1} arcsec from the truth", report.outcome);
        assert!(error < 60.0 + number("max_dev_from_consensus_arcsec"));
    }
}

#[test]
fn the_image_refuses_bad_files_with_a_line_and_status_2() {
    let folder = scratch("refused");
    let refused = |word: &str| {
        let output = obc(M4F, &folder, "frames.bin", "parameters.bin");
        let line = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(line.starts_with(word) && line.trim_end().lines().count() == 1, "{line:?}");
    };
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("frames.bin", b"SXTFgarbage");
    let of_another = defects_file::table([640, 480], &[[1, 1]], &[]);
    write("bad-pixels.bin", &of_another);
    refused("PARAMETERS: ");
    let (files, _) = record_flight(&Flight { clips: &[SHORT], ..GYRO }, &folder).unwrap();
    for (bytes, word) in [(&of_another[..], "another detector's"), (&of_another[..60], "damaged")] {
        std::fs::write(&files.bad_pixels, bytes).unwrap();
        refused(&format!("BAD_PIXELS: {word}"));
    }
    let _ = std::fs::remove_dir_all(&folder);
}
