//! What the system tests share: where the data lie, and the program under test.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Root of the workspace.
pub fn workspace() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).expect("this package lies two folders below the root")
}

/// A file of the test data, or `None` (and a line that says so) where the data are absent. `.ci/run` sets
/// `SEXTANT_DATA` and so makes their absence a failure.
pub fn data(file: &str) -> Option<PathBuf> {
    let named = std::env::var_os("SEXTANT_DATA").map(PathBuf::from);
    let folder = named.clone().unwrap_or_else(|| workspace().join("../shared/data"));
    let path = folder.join(file);
    if path.exists() {
        return Some(path);
    }
    assert!(named.is_none(), "SEXTANT_DATA is set but {} is missing", path.display());
    println!("skipped: no data");
    None
}

/// Folder in which cargo puts what it builds for this run.
pub fn target_dir() -> PathBuf {
    let test = std::env::current_exe().expect("a running test has a path");
    test.ancestors().nth(3).expect("TARGET/PROFILE/deps/test").to_path_buf()
}

/// How much of a repeated trial is made: `gate` in the gate's tests, `long` in those of `tests/run long`,
/// which sets `SEXTANT_TIER=long`. Cases are drawn from fixed seeds and the gate's are the first of the long
/// ones.
pub fn amount<T>(gate: T, long: T) -> T {
    match std::env::var("SEXTANT_TIER").as_deref() {
        Ok("long") => long,
        Err(_) => gate,
        Ok(tier) => panic!("SEXTANT_TIER is \"long\" or not set, not {tier:?}"),
    }
}

/// Runs cargo in the workspace and insists on success.
pub fn cargo(arguments: &[&str]) {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .arg("--quiet")
        .args(arguments)
        .current_dir(workspace())
        .env("CARGO_TARGET_DIR", target_dir())
        .status()
        .expect("cargo starts");
    assert!(status.success(), "cargo {arguments:?} failed");
}

/// The program, built once for all tests, with the optimisation it is used with.
pub fn sil_host() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        cargo(&["build", "--release", "-p", "sil-host"]);
        target_dir().join("release").join(format!("sil-host{}", std::env::consts::EXE_SUFFIX))
    })
}

/// Runs the program with arguments.
pub fn run(arguments: &[&str]) -> Output {
    Command::new(sil_host()).args(arguments).output().expect("the program starts")
}

/// The JSON objects of an output, a line each.
pub fn json_lines(output: &Output) -> Vec<Value> {
    let text = std::str::from_utf8(&output.stdout).expect("JSON is UTF-8");
    text.lines().map(|line| serde_json::from_str(line).expect("a line is one JSON object")).collect()
}

/// Runs the program, expects status 2 and one line on stderr of the program's form that has these words; gives
/// its JSON objects.
pub fn refused(arguments: &[&str], words: &[&str]) -> Vec<Value> {
    let output = run(arguments);
    let line = String::from_utf8_lossy(&output.stderr);
    println!("{}", line.trim_end());
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {line}");
    assert_eq!(line.trim_end().lines().count(), 1, "{arguments:?}: {line:?}");
    assert!(line.starts_with("sil-host: "), "{line}");
    for word in words {
        assert!(line.contains(word), "{arguments:?}: {word:?} is not in {line:?}");
    }
    json_lines(&output)
}

/// A folder of its own for a test, empty.
pub fn scratch(name: &str) -> PathBuf {
    let folder = target_dir().join("test-scratch").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("the target folder can be written");
    folder
}

/// The Python that `tests/run` makes, with the packages that it names; `None` (and a line that says so) where it
/// could not be made.
pub fn python() -> Option<String> {
    let python = workspace().join("target/python/bin/python3");
    if !python.exists() {
        println!("skipped: no target/python, which tests/run makes");
        return None;
    }
    Some(python.to_str().expect("a path in UTF-8").to_owned())
}

/// Unit vector of right ascension and declination, degrees.
pub fn direction(ra_deg: f64, dec_deg: f64) -> [f64; 3] {
    let (ra, dec) = (ra_deg.to_radians(), dec_deg.to_radians());
    [dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin()]
}

/// Angle between two unit vectors, arcsec.
pub fn separation_arcsec(a: [f64; 3], b: [f64; 3]) -> f64 {
    let chord = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    (2.0 * (chord / 2.0).asin()).to_degrees() * 3600.0
}
