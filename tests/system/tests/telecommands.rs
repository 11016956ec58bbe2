//! The command link in flight: packets of every command on the host and on the emulated Cortex-M4F, with the
//! same telemetry and the same reports.

use crate::{c_face, cfs};
use fsw_core::command::ground;
use fsw_core::command::{CommandOutcome, Refusal, Telecommand, TimeCorrelation};
use fsw_core::frames::{Icrs, Rotation, StarPath};
use fsw_core::modes::{Guard, Mode};
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::shutting::ShutterParameters;
use fsw_core::telemetry::{self, Event, MAX_FRAME_BYTES, Outcome, Report};
use fsw_hal::OpenPaths;
use serde_json::Value;
use sil_host::commands::record::ground::{Ground, fly};
use sil_host::commands::record::mission::{Clip, Flight, MISSION};
use sil_host::commands::record::record_flight;
use sil_host::formats::frames_file::Recording;
use sil_host::world::instruments::magnetometer::MagnetometerModel;
use std::path::Path;
use std::process::Command as Process;
use system_tests::{scratch, target_dir, workspace};

const SECONDS: usize = 34;
const FLIGHT: Flight =
    Flight { clips: &[Clip { scenario: "geo-eclipse", from_s: 0, seconds: SECONDS as u32 }], ..MISSION };

/// A low orbit with a magnetometer, whose star path is to be shut.
const MAGNETIC: Flight = Flight {
    clips: &[Clip { scenario: "leo-oblique", from_s: 60, seconds: 20 }],
    magnetometer: Some(MagnetometerModel {
        hard_iron_ut: [0.5, -0.3, 0.4],
        zero_sigma_ut: 0.5,
        noise_ut: 0.2,
        drift_ut_h: 0.15,
        resolution_ut: 0.043,
        range_ut: 80.0,
        ring_current_ut: 0.02,
    }),
    ..MISSION
};

/// Two fields of stars, the Earth dark.
const TWO_FIELDS: Flight = Flight {
    clips: &[Clip { scenario: "geo-two-fields", from_s: 4_000, seconds: 34 }],
    open: OpenPaths::BothClear,
    ..MISSION
};

fn commands(recording: &mut Recording, wanted: &Parameters) -> Ground {
    let mut ground = Ground::default();
    let orbit = FLIGHT.orbit(20).unwrap();
    let then = recording.turn_to(20);
    ground.send(8, &Telecommand::Safe).unwrap();
    ground.send(10, &Telecommand::Exposure(1)).unwrap();
    ground.send(11, &Telecommand::Exposure(90_000)).unwrap();
    ground.send(13, &Telecommand::Reacquire).unwrap();
    let mut buffer = [0; MAX_TABLE_BYTES];
    let table = wanted.encode(&mut buffer).unwrap();
    for upload in ground::upload(None, table, 150) {
        let second = if matches!(upload, Telecommand::Load { .. }) { 19 } else { 18 };
        ground.send(second, &upload).unwrap();
    }
    ground.send(22, &Telecommand::Dump).unwrap();
    ground.send(23, &Telecommand::Orbit(orbit)).unwrap();
    let correlation = TimeCorrelation { local: then.local, terrestrial_us: 800_000_000_000_000 };
    ground.send(24, &Telecommand::Time(correlation)).unwrap();
    // One that was sent before, and one that was damaged on its way.
    let safe = ground.packets[0].1.clone();
    ground.packets.push((25, safe.clone()));
    ground.packets.push((25, safe[..safe.len() - 1].to_vec()));
    // The Earth alone is left.
    ground.send(26, &Telecommand::Shutter(Some(OpenPaths::Earth))).unwrap();
    ground.send(28, &Telecommand::Reacquire).unwrap();
    ground.send(30, &Telecommand::Spots).unwrap();
    ground.send(31, &Telecommand::Restart).unwrap();
    ground
}

/// Service, subservice and reason of a report.
fn summary(packet: &[u8]) -> (u8, u8, u16) {
    let reason = match packet[8] {
        2 | 8 if packet[7] == 1 => u16::from_be_bytes([packet[24], packet[25]]),
        _ => 0,
    };
    (packet[7], packet[8], reason)
}

/// Runs the flight image in the emulator on a folder's files; the cycles of each second.
fn emulated(folder: &Path) -> Vec<u64> {
    let cargo = |arguments: &[&str]| {
        let mut cargo = Process::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(arguments).current_dir(workspace()).env("CARGO_TARGET_DIR", target_dir());
        cargo
    };
    let done = |cargo: &mut Process| {
        let output = cargo.output().expect("cargo starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    done(&mut cargo(&["build", "--quiet", "--release", "-p", "cycle-meter"]));
    let files = ["frames.bin", "parameters.bin", "obc.bin", "commands.bin", "reports.bin"];
    let meter = folder.join("cycles.json");
    done(
        cargo(&["run", "--quiet", "--profile", "flight", "-p", "obc-image"])
            .args(["--target", "thumbv7em-none-eabihf", "--"])
            .args(files.map(|file| folder.join(file)))
            .env("CYCLE_METER", &meter),
    );
    let metered: Value = serde_json::from_slice(&std::fs::read(meter).unwrap()).unwrap();
    let cycles = metered["cycles"].as_array().expect("the meter's seconds").iter();
    cycles.map(|second| second["cycles"].as_u64().expect("a count")).collect()
}

/// Flies the recording of a folder on the target, by the program in C and by the cFS app; telemetry and
/// reports must be those of the host. The cycles of each second on the target.
fn compare_with_target(folder: &Path, ground: &Ground, reports: &[Report], packets: &[Vec<u8>]) -> Vec<u64> {
    std::fs::write(folder.join("commands.bin"), ground.file()).unwrap();
    let cycles = emulated(folder);
    let mut stream = Vec::new();
    for report in reports {
        stream.extend_from_slice(telemetry::encode_next(report, &mut [0; MAX_FRAME_BYTES]).unwrap());
    }
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(read("obc.bin") == stream, "telemetry of host and target differs");
    assert!(read("reports.bin") == packets.concat(), "reports of host and target differ");
    c_face::fly_commanded(folder, &stream, &packets.concat());
    cfs::fly_commanded(folder, &stream, &packets.concat());
    cycles
}

/// The budget's limit of a second with windows.
fn limit_of_tracking() -> u64 {
    let text = std::fs::read_to_string(workspace().join("tests/obc-image/budget.toml")).unwrap();
    let budget: toml::Table = text.parse().unwrap();
    budget["cycles"]["tracking"].as_integer().expect("a number") as u64
}

#[test]
fn a_magnetometer_flies_on_host_and_target_with_the_same_telemetry() {
    let folder = scratch("magnetic");
    let (files, _) = record_flight(&MAGNETIC, &folder).expect("it can be recorded");
    let mut instrument = MAGNETIC.instrument().unwrap();
    instrument.parameters.shutter = Some(ShutterParameters::default());
    std::fs::write(&files.parameters, instrument.parameters.encode(&mut [0; MAX_TABLE_BYTES]).unwrap())
        .unwrap();
    let mut recording = Recording::load(&files.frames).unwrap();
    let mut ground = Ground::default();
    ground.send(5, &Telecommand::Orbit(MAGNETIC.orbit(4).unwrap())).unwrap();
    ground.send(12, &Telecommand::Shutter(Some(OpenPaths::Earth))).unwrap();
    ground.send(15, &Telecommand::Reacquire).unwrap();
    let (reports, packets) = fly(&mut recording, &instrument, &ground).unwrap();
    let known = |second: &Report| second.magnetometer.is_some();
    assert!(!reports[..5].iter().any(known) && reports[6..].iter().all(known), "from the orbit on");
    let used: Vec<_> =
        reports.iter().map(|second| second.magnetometer.is_some_and(|field| field.used)).collect();
    // Stars until the path is shut, then the carried attitude, then the Earth alone.
    assert!(!used[..12].contains(&true) && !used[13..].contains(&false), "{used:?}");
    let stars = Rotation::from_quaternion(reports[11].attitude.expect("it tracks").quaternion).unwrap();
    let alone = reports[19].attitude.expect("an attitude by Earth and field");
    let found: Rotation<Icrs, StarPath> = Rotation::from_quaternion(alone.quaternion).unwrap();
    let off = found.angle_from(&stars).map(f32::to_degrees);
    println!("by Earth and field: off by {off:?} deg, sigma {:?}", alone.sigma_rad.map(f32::to_degrees));
    // It turns by half a degree in the eight seconds.
    assert!(off.iter().zip(alone.sigma_rad).all(|(off, sigma)| off.abs() < 4.0 * sigma.to_degrees() + 0.6));
    compare_with_target(&folder, &ground, &reports, &packets);
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn stars_of_two_fields_tell_the_mounting_on_host_and_target_alike_and_within_the_budget() {
    let folder = scratch("two-fields");
    let (files, _) = record_flight(&TWO_FIELDS, &folder).expect("it can be recorded");
    let instrument = TWO_FIELDS.instrument().unwrap();
    let mut recording = Recording::load(&files.frames).unwrap();
    let mut ground = Ground::default();
    ground.send(5, &Telecommand::Orbit(TWO_FIELDS.orbit(4).unwrap())).unwrap();
    let (reports, packets) = fly(&mut recording, &instrument, &ground).unwrap();
    // From the second on that knows the orbit, of which one in sixteen looks.
    assert!(reports[7..].iter().all(|second| second.earth_path_clear));
    let looks: Vec<_> = reports.iter().filter_map(|second| second.earth_path_stars).collect();
    let sigma = |second: usize| reports[second].orbit.expect("an orbit").misalignment_sigma_rad;
    println!("looks {looks:?}, sigma of the mounting {:?}, then {:?} rad", sigma(10), sigma(33));
    assert!(looks.len() == 2 && looks.iter().all(|stars| *stars >= 3));
    assert!(sigma(33)[0] < 0.5 * sigma(10)[0] && sigma(33)[1] < 0.5 * sigma(10)[1]);
    let cycles = compare_with_target(&folder, &ground, &reports, &packets);
    let seconds = || reports.iter().zip(&cycles).skip(10);
    let most = |looking: bool| {
        let alike = seconds().filter(|(second, _)| second.earth_path_stars.is_some() == looking);
        *alike.map(|(_, cycles)| cycles).max().expect("there are such seconds")
    };
    println!("cycles of a second {} without a look, {} with one, at most", most(false), most(true));
    assert!(most(true) < limit_of_tracking());
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn every_command_flies_on_host_and_target_with_the_same_telemetry_and_reports() {
    let folder = scratch("telecommands");
    let (files, _) = record_flight(&FLIGHT, &folder).expect("it can be recorded");
    let instrument = FLIGHT.instrument().unwrap();
    let mut wanted = instrument.parameters;
    wanted.tracking.gate_px += 1;
    wanted.shutter = Some(ShutterParameters::default());
    let mut recording = Recording::load(&files.frames).unwrap();
    let ground = commands(&mut recording, &wanted);
    let (reports, packets) = fly(&mut recording, &instrument, &ground).unwrap();

    let (done, refused) = (Some(CommandOutcome::Done), |why| Some(CommandOutcome::Refused(why)));
    let outcomes = [
        (8, done),
        (10, refused(Refusal::Exposure)),
        (11, done),
        (13, done),
        (19, done),
        (23, done),
        (24, refused(Refusal::ClockServes)),
        (26, done),
        (28, done),
        (31, done),
    ];
    let told: Vec<_> = reports.iter().enumerate().filter(|(_, report)| report.command.is_some()).collect();
    assert_eq!(told.iter().map(|(second, report)| (*second, report.command)).collect::<Vec<_>>(), outcomes);
    assert!(reports[22].orbit.is_none() && reports[23].orbit.is_some());
    assert!(reports[8..13].iter().all(|report| report.mode == Mode::CommandedSafe));
    assert_eq!(reports[13].mode, Mode::Acquisition);
    assert!(reports[19].events.contains(&Event::Mode(Mode::Acquisition, Guard::Commanded)));
    assert_eq!(reports[18].mode, Mode::Tracking);
    assert_eq!(reports[22].mode, Mode::Tracking);
    let stars = Rotation::from_quaternion(reports[25].attitude.expect("it tracks").quaternion).unwrap();
    for report in &reports[28..31] {
        assert_eq!(report.outcome, Some(Outcome::StarPathShut));
        let alone = report.attitude.expect("an attitude by Earth and terminator");
        let found: Rotation<Icrs, StarPath> = Rotation::from_quaternion(alone.quaternion).unwrap();
        let off = found.angle_from(&stars);
        println!(
            "by the Earth alone: off by {:?} deg, sigma {:?}",
            off.map(f32::to_degrees),
            alone.sigma_rad
        );
        assert!(off.iter().zip(alone.sigma_rad).all(|(off, sigma)| off.abs() < 4.0 * sigma + 3e-4));
    }
    let counted = |kind| packets.iter().filter(|packet| summary(packet) == kind).count();
    // Thirteen commands of one packet and the parts were accepted; two were refused at once.
    let parts = ground.packets.len() - 14;
    assert_eq!(counted((1, 1, 0)), 12 + parts);
    assert_eq!(counted((1, 2, Refusal::Counter.code())) + counted((1, 2, Refusal::Length.code())), 2);
    assert_eq!(counted((1, 8, Refusal::Exposure.code())), 1);
    assert_eq!(counted((1, 7, 0)), 10 + parts);
    let dumped: Vec<u8> = packets
        .iter()
        .filter(|packet| summary(packet) == (129, 4, 0))
        .flat_map(|packet| packet[24..packet.len() - 2].to_vec())
        .collect();
    assert_eq!(Parameters::decode(&dumped), Ok(wanted));

    compare_with_target(&folder, &ground, &reports, &packets);
    // A recording is large.
    let _ = std::fs::remove_dir_all(&folder);
}
