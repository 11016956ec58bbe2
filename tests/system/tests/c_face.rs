//! The C face as a program in C: the same bits as the host's Rust, within the flight computer's memory.

use fsw_core::telemetry::{self, Report};
use serde_json::{Value, json};
use sil_host::commands::record::mission::{Flight, GYRO, MISSION};
use sil_host::commands::record::record_flight;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use system_tests::{cargo, json_lines, scratch, target_dir, workspace};

/// Limits of the purpose on the reference computer, bytes: flash with the catalogue, static RAM, stack.
const FLASH_BYTES: u64 = 512 << 10;
const STATIC_RAM_BYTES: u64 = 64 << 10;
const STACK_BYTES: u64 = 16 << 10;

/// The library of the host, built with the program so that they share what they are made of.
pub fn host_library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        cargo(&["build", "--release", "-p", "sil-host", "-p", "fsw-c"]);
        target_dir().join("release/libsextant.a")
    })
}

/// Runs the C program, on the host or in the emulator, on files of a folder; the telemetry goes to `c.bin`.
/// `commands`: no names, or those of the files of packets and reports.
fn run_c(platform: &str, folder: &Path, commands: &[&str]) -> Output {
    let mut run = Command::new(workspace().join("tests/c-image/run.sh"));
    if platform == "host" {
        run.env("LIBRARY", host_library());
    }
    run.arg(platform)
        .args(["frames.bin", "parameters.bin", "c.bin"].iter().chain(commands).map(|name| folder.join(name)))
        .env("CARGO_TARGET_DIR", target_dir())
        .output()
        .expect("a shell starts")
}

fn reports(mut stream: &[u8]) -> Vec<Report> {
    let mut reports = Vec::new();
    while let Some((frame, rest)) = telemetry::split_first(stream) {
        reports.push(telemetry::decode(frame).expect("a whole frame"));
        stream = rest;
    }
    reports
}

/// Records a flight and has the C program fly it: the same telemetry, and a result struct that agrees with
/// it. Gives what the program printed.
fn fly(flight: &Flight, platform: &str) -> Value {
    let folder = scratch(&format!("c-{platform}"));
    record_flight(flight, &folder).expect("the flight can be recorded");
    let output = run_c(platform, &folder, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = json_lines(&output).pop().expect("a line of figures");
    println!("{platform}: {figures}");
    let [host, c] = ["telemetry.bin", "c.bin"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(!host.is_empty() && host == c, "telemetry of C and Rust differs");

    let reports = reports(&host);
    let attitudes: Vec<_> = reports.iter().filter_map(|report| report.attitude.as_ref()).collect();
    let orbits: Vec<_> = reports.iter().filter_map(|report| report.orbit.as_ref()).collect();
    assert_eq!((&figures["seconds"], &figures["failed"]), (&reports.len().into(), &0.into()));
    assert_eq!((&figures["attitudes"], &figures["orbits"]), (&attitudes.len().into(), &orbits.len().into()));
    assert_eq!(figures["mode"], reports.last().unwrap().mode as u32);
    let quaternion = attitudes.last().expect("an attitude").quaternion;
    let quaternion_bits = quaternion.map(|component| format!("{:08x}", component.to_bits()));
    let position = orbits.last().map_or([0.0; 3], |orbit| orbit.position_km);
    let position_bits = position.map(|component| format!("{:016x}", component.to_bits()));
    assert_eq!(figures["quaternion_bits"], json!(quaternion_bits));
    assert_eq!(figures["position_bits"], json!(position_bits));
    // A recording is large.
    let _ = std::fs::remove_dir_all(&folder);
    figures
}

#[test]
fn a_c_program_on_the_host_gives_the_telemetry_of_rust() {
    // Self-test, acquisition, tracking in a low orbit; the Earth whole from GEO.
    const FLIGHT: Flight = Flight { clips: &[MISSION.clips[0], MISSION.clips[12]], ..MISSION };
    fly(&FLIGHT, "host");
    // A gyro carries the attitude through a sunrise.
    fly(&GYRO, "host");
}

#[test]
fn a_c_program_flies_the_recorded_mission_on_the_target_with_the_telemetry_of_the_host() {
    let figures = fly(&MISSION, "obc");
    let bytes = |name: &str| figures[name].as_u64().expect(name);
    assert!(bytes("attitudes") > 100 && bytes("orbits") > 10, "stars and Earth were seen");
    check_memory(&figures);

    let depth = stack_depth();
    println!("stack by the machine code, callbacks apart: {}", depth["stack_bytes"]);
    assert!((1_000..=STACK_BYTES).contains(&depth["stack_bytes"].as_u64().unwrap()));
    for unsound in ["recursion", "unknown_frames", "unknown_targets"] {
        assert_eq!(depth[unsound], json!([]), "{unsound}");
    }
    // Calls whose target the machine code does not name are those of the callbacks: of the instruments, and
    // of the memory of files that are sent up.
    const CALLERS: [&str; 4] =
        ["fsw_core6sensor", "fsw_hal", "fsw_core7command6upload", "sextant_cycle_commanded"];
    for caller in depth["unknown_calls"].as_array().unwrap() {
        let caller = caller.as_str().unwrap();
        assert!(CALLERS.iter().any(|name| caller.contains(name)), "{caller}");
    }
}

/// The memory that the C image takes on the target, the command link in it, against the limits.
fn check_memory(figures: &Value) {
    let bytes = |name: &str| figures[name].as_u64().expect(name);
    assert!(bytes("flash_bytes") <= FLASH_BYTES);
    assert!(bytes("static_ram_bytes") <= STATIC_RAM_BYTES);
    assert!((1_000..=STACK_BYTES).contains(&bytes("stack_bytes")), "the paint was touched, not through");
}

/// Flies the files of a folder with its `commands.bin` by the C program, on the host and on the target:
/// telemetry and reports, which are those of Rust.
pub fn fly_commanded(folder: &Path, telemetry: &[u8], reports: &[u8]) {
    for platform in ["host", "obc"] {
        let output = run_c(platform, folder, &["commands.bin", "c-reports.bin"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let figures = json_lines(&output).pop().expect("a line of figures");
        println!("C with commands, {platform}: {figures}");
        let [flown, told] = ["c.bin", "c-reports.bin"].map(|name| std::fs::read(folder.join(name)).unwrap());
        assert!(flown == telemetry, "telemetry of C and Rust differs, {platform}");
        assert!(told == reports, "reports of C and Rust differ, {platform}");
        if platform == "obc" {
            check_memory(&figures);
        }
    }
}

/// What the analysis of the C image's machine code says.
fn stack_depth() -> Value {
    cargo(&["build", "--release", "-p", "stack-depth"]);
    let output = Command::new(target_dir().join("release/stack-depth"))
        .arg(target_dir().join("thumbv7em-none-eabihf/flight/c-image"))
        .output()
        .expect("the analysis starts");
    json_lines(&output).pop().expect("a line")
}

#[test]
fn the_c_program_refuses_bad_files_with_a_line_and_status_2() {
    let folder = scratch("c-refused");
    std::fs::write(folder.join("parameters.bin"), [12; 40]).unwrap();
    std::fs::write(folder.join("frames.bin"), b"SXTFgarbage of no length").unwrap();
    let output = run_c("host", &folder, &[]);
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert!(line.starts_with("FRAMES: ") && line.trim_end().lines().count() == 1, "{line:?}");

    let header = [&b"SXTF"[..], &[5, 0, 0, 5, 0, 4, 10, 0, 1, 0, 0, 0]].concat();
    std::fs::write(folder.join("frames.bin"), header).unwrap();
    let output = run_c("host", &folder, &[]);
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert_eq!(line, "PARAMETERS: the parameter table is damaged, or is none\n");
}

/// Compiles a C source of a folder with all warnings as errors, against header and library of the host.
fn compile(folder: &Path, source: &str, arguments: &[&str]) -> PathBuf {
    let program = folder.join("program");
    let include = workspace().join("fsw-c/include");
    let output = Command::new("cc")
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"])
        .arg(include)
        .args(arguments)
        .arg(folder.join(source))
        .arg(host_library())
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output()
        .expect("cc starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    program
}

#[test]
fn the_readmes_example_compiles_and_tells_that_no_camera_answers() {
    let readme = std::fs::read_to_string(workspace().join("fsw-c/README.md")).unwrap();
    let example =
        readme.split("```c\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let folder = scratch("c-example");
    std::fs::write(folder.join("example.c"), example).unwrap();
    let program = compile(&folder, "example.c", &["-std=c11"]);

    let parameters = MISSION.instrument().unwrap().parameters;
    let mut table = [0; fsw_core::parameters::MAX_TABLE_BYTES];
    std::fs::write(folder.join("parameters.bin"), parameters.encode(&mut table).unwrap()).unwrap();
    let output = Command::new(program).arg(folder.join("parameters.bin")).output().unwrap();
    let second = "mode 0, faults 5, attitude 0\n";
    assert_eq!(String::from_utf8_lossy(&output.stdout), second.repeat(3) + "done\n");
    assert!(output.status.success());
}
