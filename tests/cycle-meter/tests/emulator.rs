//! The meter in the emulator, on a program counted by hand and against the emulator's own trace.
//!
//! Needs `qemu-system-arm` and the Rust target thumbv7em-none-eabihf; where one is missing the tests say so
//! and pass, except in CI (environment variable `CI`), where that is a failure.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

const EMULATOR: &str = "qemu-system-arm";
const TARGET: &str = "thumbv7em-none-eabihf";

/// What the comments of `counted.rs` add up to, within a cycle and within its stage.
/// Waits: five words loaded and three lines of code in the stage; a line before the loop and one in each of its ten
/// passes; the branch's line and that of its target.
const CYCLE: &str = r#""instructions":37,"cycles":92,"waits":21"#;
const STAGE: &str = r#""stages":{"3":{"calls":1,"instructions":9,"cycles":44,"waits":8}}"#;

/// Compiles the counted program; `None` when the tools are missing.
fn program(name: &str) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/emulator");
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let compiled = Command::new(env::var_os("RUSTC").unwrap_or("rustc".into()))
        .args(["--edition", "2024", "--target", TARGET, "-C", "panic=abort", "-o"])
        .arg(&program)
        .arg("-C")
        .arg(format!("link-arg=-T{}", source.join("counted.ld").display()))
        .arg(source.join("counted.rs"))
        .status();
    let emulator = Command::new(EMULATOR).arg("--version").stdout(Stdio::null()).status();
    if compiled.is_ok_and(|status| status.success()) && emulator.is_ok_and(|status| status.success()) {
        return Some(program);
    }
    assert!(env::var_os("CI").is_none(), "{EMULATOR} and the target {TARGET} must be installed");
    eprintln!("skipped: {EMULATOR} or the target {TARGET} is not installed");
    None
}

/// The emulator with `program` in it.
fn emulator(program: &Path) -> Command {
    let mut command = Command::new(EMULATOR);
    command.args(["-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(program);
    command
}

/// Runs `program` under the meter and gives its report.
fn metered(program: &Path, options: &str) -> String {
    // Cargo puts the plugin beside the tests.
    let meter = env::current_exe().expect("a path of our own").with_file_name("libcycle_meter.so");
    let report = program.with_extension("json");
    let plugin = format!("{},elf={},out={}{options}", meter.display(), program.display(), report.display());
    let status = emulator(program).args(["-plugin", &plugin]).status().expect("the emulator runs");
    assert!(status.success());
    fs::read_to_string(report).expect("a report")
}

#[test]
fn a_program_counted_by_hand_gives_the_same_count() {
    let Some(program) = program("by-hand") else { return };
    let report = metered(&program, "");
    let cycle = format!("{{{CYCLE},{STAGE}}}");
    assert!(report.contains(&format!(r#""cycles":[{cycle},{cycle}]"#)), "{report}");
    assert!(report.contains(r#""unfinished_cycles":0,"unknown_blocks":0"#), "{report}");
    assert_eq!(report, metered(&program, ""), "repeatable");
    // Ten taken branches a cycle.
    assert!(metered(&program, ",refill=3").contains(r#""instructions":37,"cycles":102"#));
}

#[test]
fn the_emulators_own_trace_has_as_many_instructions() {
    let Some(program) = program("traced") else { return };
    let trace = program.with_extension("trace");
    let status = emulator(&program)
        .args(["-singlestep", "-d", "exec,nochain", "-D"])
        .arg(&trace)
        .status()
        .expect("the emulator runs");
    assert!(status.success());
    let lines = fs::read_to_string(trace).expect("a trace");
    let traced = lines.lines().filter(|line| line.starts_with("Trace ")).count();
    let expected = format!(r#""image_instructions":{traced},"#);
    let report = metered(&program, "");
    assert!(report.contains(&expected), "{expected} {report}");
}
