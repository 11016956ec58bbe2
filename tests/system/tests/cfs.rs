//! The cFS application of `fsw-c/cfs` on a stand-in of cFE: the same telemetry and reports as Rust, also with
//! a restart between; and the library by CMake.

use crate::c_face::host_library;
use fsw_core::catalog::Catalogue;
use fsw_core::command::{CommandLink, MAX_REPORT_BYTES, Refusal, Telecommand};
use fsw_core::image::calibration::Calibration;
use fsw_core::sensor::Workspace;
use fsw_core::telemetry::{self, MAX_FRAME_BYTES, Report};
use fsw_hal::LocalTime;
use serde_json::{Value, json};
use sil_host::commands::record::ground::{APID, Ground, KEY};
use sil_host::commands::record::mission::{Clip, Flight, GYRO, MISSION};
use sil_host::commands::record::{Instrument, fly_second, record_flight};
use sil_host::flight;
use sil_host::formats::frames_file::Recording;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Output};
use std::sync::OnceLock;
use system_tests::{json_lines, scratch, target_dir, workspace};

/// GEO with the Earth whole: an orbit goes up in its second 5, and a restart comes before its second 16.
const RESTARTED: Flight =
    Flight { clips: &[Clip { scenario: "geo-eclipse", from_s: 0, seconds: 24 }], ..MISSION };
const RESTART_SECOND: usize = 16;

/// A few seconds.
const SHORT: Flight = Flight { clips: &[MISSION.clips[0]], ..MISSION };

/// Seconds after which the test's app keeps a frame.
const KEEP: &str = "-DSEXTANT_APP_KEEP_SECONDS=4";

/// Runs a compiler or a program and insists on success.
fn done(process: &mut Process) -> Output {
    let output = process.output().expect("it starts");
    assert!(output.status.success(), "{process:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// The app as cFE's build compiles it, as C99 with these warnings, linked with the stand-in.
fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let (root, folder) = (workspace(), scratch("cfs-host"));
        let compiler = |standard: &str| {
            let mut compiler = Process::new("cc");
            compiler.args([standard, "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", KEEP]);
            for include in ["fsw-c/include", "fsw-c/cfs", "tests/cfs-host", "tests/c-image"] {
                compiler.arg("-I").arg(root.join(include));
            }
            compiler
        };
        let app = ["sextant_app", "sextant_app_time"].map(|name| {
            let object = folder.join(name).with_extension("o");
            let source = root.join("fsw-c/cfs").join(name).with_extension("c");
            let warnings =
                ["-Wstrict-prototypes", "-Wwrite-strings", "-Wpointer-arith", "-Wcast-align=strict"];
            done(compiler("-std=c99").args(warnings).arg("-c").arg(source).arg("-o").arg(&object));
            object
        });
        let program = folder.join("cfs-host");
        let sources = ["cfs-host/main", "cfs-host/cfe_host", "c-image/recorded", "c-image/packets"];
        let sources = sources.iter().chain(&["c-image/platform_host"]);
        done(
            compiler("-std=c11")
                .args(sources.map(|name| root.join("tests").join(name).with_extension("c")))
                .args(app)
                .arg(host_library())
                .args(["-lm", "-lpthread", "-ldl", "-o"])
                .arg(&program),
        );
        program
    })
}

/// Runs the app on the files of a folder, `commands.bin` among them; its housekeeping. Telemetry and reports
/// go to `cfs.bin` and `cfs-reports.bin`.
fn run(program: &Path, folder: &Path, restart: &[&str]) -> Value {
    let files = ["frames.bin", "parameters.bin", "cfs.bin", "commands.bin", "cfs-reports.bin"];
    let output = done(Process::new(program).args(files).args(restart).current_dir(folder));
    let housekeeping = json_lines(&output).pop().expect("a line of housekeeping");
    println!("cFS app: {housekeeping}");
    housekeeping
}

/// Compares what the app sent.
fn compare(folder: &Path, telemetry: &[u8], reports: &[u8]) {
    let [flown, told] = ["cfs.bin", "cfs-reports.bin"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(!telemetry.is_empty() && flown == telemetry, "telemetry of the app and of Rust differs");
    assert!(told == reports, "reports of the app and of Rust differ");
}

/// Flies the files of a folder, whose telemetry and reports Rust gave so, by the app; its housekeeping.
pub fn fly_commanded(folder: &Path, telemetry: &[u8], reports: &[u8]) -> Value {
    let housekeeping = run(program(), folder, &[]);
    compare(folder, telemetry, reports);
    housekeeping
}

/// Records a flight without a command into a folder.
fn record(flight: &Flight, name: &str) -> PathBuf {
    let folder = scratch(name);
    record_flight(flight, &folder).expect("the flight can be recorded");
    std::fs::write(folder.join("commands.bin"), []).unwrap();
    folder
}

#[test]
fn the_cfs_app_flies_the_recorded_mission_with_the_telemetry_of_rust() {
    for (flight, name) in [(&MISSION, "cfs-mission"), (&GYRO, "cfs-gyro")] {
        let folder = record(flight, name);
        let telemetry = std::fs::read(folder.join("telemetry.bin")).unwrap();
        let housekeeping = fly_commanded(&folder, &telemetry, &[]);
        let seconds: u32 = flight.clips.iter().map(|clip| clip.seconds).sum();
        let told = |name: &str| housekeeping[name].as_u64().expect(name);
        assert_eq!((told("seconds"), told("refused_seconds")), (seconds.into(), 0));
        // Since the counters were set to zero: a function code that is none; zeros, of another APID.
        let refused = (told("refused_telecommands"), told("refusal"));
        assert_eq!((told("bad_messages"), told("telecommands")), (1, 0));
        assert_eq!(refused, (1, Refusal::Apid.code().into()));
        // A recording is large.
        let _ = std::fs::remove_dir_all(&folder);
    }
}

/// Flies seconds from one on as Rust does, resumed where a frame was kept.
fn fly(
    recording: &mut Recording,
    seconds: std::ops::Range<usize>,
    ground: &Ground,
    kept: Option<&Report>,
) -> [Vec<u8>; 2] {
    let Instrument { parameters, defects, .. } = RESTARTED.instrument().unwrap();
    let mut workspace = Box::new(Workspace::new());
    let catalogue: Catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
    let calibration = Calibration::open(flight::REFERENCE_CALIBRATION).ok();
    let mut sensor = flight::sensor(catalogue, calibration, parameters, &mut workspace).unwrap();
    if let Some(kept) = kept {
        assert!(sensor.resume(kept));
    }
    // Counts of before are those of the packets that were sent until then.
    let before = ground.packets.iter().filter(|(due, _)| (*due as usize) < seconds.start).count();
    let mut link = CommandLink::new(APID, Some(KEY), before as u32);
    let (mut stream, mut packets) = (Vec::new(), Vec::new());
    for second in seconds.clone() {
        for (_, packet) in ground.packets.iter().filter(|(due, _)| *due as usize == second) {
            let _ = link.receive(packet);
        }
        let report = fly_second(&mut sensor, (&mut *recording, &defects), second, link.command()).unwrap();
        link.conclude(report.command);
        assert!(kept.is_none() || report.orbit.is_some(), "the orbit goes on");
        stream.extend_from_slice(telemetry::encode_next(&report, &mut [0; MAX_FRAME_BYTES]).unwrap());
        let (now, mut buffer) = (LocalTime::from_us(report.local_us), [0; MAX_REPORT_BYTES]);
        while let Some(packet) = link.next_report(now, &sensor.downlink(), &mut buffer) {
            packets.extend_from_slice(packet);
        }
    }
    [stream, packets]
}

#[test]
fn an_orbit_goes_on_when_cfe_starts_the_app_again() {
    let folder = record(&RESTARTED, "cfs-restarted");
    let mut recording = Recording::load(&folder.join("frames.bin")).unwrap();
    let mut ground = Ground::default();
    ground.send(5, &Telecommand::Orbit(RESTARTED.orbit(4).unwrap())).unwrap();
    ground.send(20, &Telecommand::Reacquire).unwrap();
    std::fs::write(folder.join("commands.bin"), ground.file()).unwrap();
    let restart = RESTART_SECOND.to_string();
    let housekeeping = run(program(), &folder, &[&restart, "kept.bin", "9999"]);

    let store = std::fs::read(folder.join("kept.bin")).unwrap();
    let (length, frame) = store.split_at(size_of::<u32>());
    let length = u32::from_ne_bytes(length.try_into().unwrap()) as usize;
    let (frame, rest) = telemetry::split_first(&frame[..length]).expect("a frame was kept");
    assert!(rest.is_empty());
    let kept = telemetry::decode(frame).expect("a whole frame");
    assert!(kept.orbit.is_some());

    let [before, told_before] = fly(&mut recording, 0..RESTART_SECOND, &ground, None);
    let [after, told_after] = fly(&mut recording, RESTART_SECOND..24, &ground, Some(&kept));
    compare(&folder, &[&before[..], &after].concat(), &[&told_before[..], &told_after].concat());
    assert_eq!(
        (&housekeeping["resumed"], &housekeeping["seconds"], &housekeeping["counter"]),
        (&json!(1), &json!(24 - RESTART_SECOND), &json!(ground.packets.len()))
    );

    // A frame that was damaged is dropped, and its second flown all the same.
    let housekeeping = run(program(), &folder, &[&restart, "kept.bin", "100"]);
    let [after, told_after] = fly(&mut recording, RESTART_SECOND..24, &ground, None);
    compare(&folder, &[before, after].concat(), &[told_before, told_after].concat());
    assert_eq!((&housekeeping["resumed"], &housekeeping["refused_seconds"]), (&json!(2), &json!(0)));
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn an_app_whose_parameters_are_damaged_ends_with_an_error_and_a_line() {
    let folder = record(&SHORT, "cfs-refused");
    std::fs::write(folder.join("parameters.bin"), [12; 40]).unwrap();
    let files = ["frames.bin", "parameters.bin", "cfs.bin", "commands.bin", "cfs-reports.bin"];
    let output = Process::new(program()).args(files).current_dir(&folder).output().expect("it starts");
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{line}");
    assert_eq!(line, "SEXTANT: the parameter table is damaged, or is none, status 0x00000009\n");
    let _ = std::fs::remove_dir_all(&folder);
}

/// Configures and builds a folder by CMake; where it was built. `None` (and a line that says so) without
/// CMake.
fn cmake(source: &str, name: &str, options: &[&str]) -> Option<PathBuf> {
    if Process::new("cmake").arg("--version").output().is_err() {
        println!("skipped: no cmake");
        return None;
    }
    let built = scratch(name);
    let target = format!("-DSEXTANT_TARGET_DIR={}", target_dir().display());
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let configure = || {
        let mut configure = Process::new("cmake");
        configure.arg("-S").arg(workspace().join(source)).arg("-B").arg(&built);
        configure.args([&target, &format!("-DSEXTANT_CARGO={cargo}")]).args(options);
        configure
    };
    done(&mut configure());
    done(Process::new("cmake").arg("--build").arg(&built));
    Some(built)
}

#[test]
fn cmake_builds_the_library_the_c_program_and_the_cfs_app() {
    // With the program, as the library of the other tests is: alone it would be built anew, in its place.
    host_library();
    const HOST: [&str; 1] = ["-DSEXTANT_CARGO_OPTIONS=-p;sil-host"];
    let Some(c_image) = cmake("tests/c-image", "cmake-c-image", &HOST) else { return };
    let app = cmake("tests/cfs-host", "cmake-cfs-host", &HOST).unwrap();
    let folder = record(&SHORT, "cmake-flight");
    let telemetry = std::fs::read(folder.join("telemetry.bin")).unwrap();

    let files = ["frames.bin", "parameters.bin", "c.bin"];
    done(Process::new(c_image.join("c-image")).args(files).current_dir(&folder));
    assert!(std::fs::read(folder.join("c.bin")).unwrap() == telemetry, "telemetry of C and Rust differs");
    run(&app.join("cfs-host"), &folder, &[]);
    compare(&folder, &telemetry, &[]);

    // The link fails where a panic could be reached.
    let toolchain =
        format!("-DCMAKE_TOOLCHAIN_FILE={}", workspace().join("tests/c-image/cortex-m4f.cmake").display());
    let image = cmake("tests/c-image", "cmake-c-image-obc", &[&toolchain]).unwrap().join("c-image");
    let machine = std::fs::read(image).unwrap()[18];
    assert_eq!(machine, 40, "an image for an Arm processor");
    let _ = std::fs::remove_dir_all(&folder);
}
