//! The program as scripts call it: status, stdout, one line on stderr.

use std::path::PathBuf;
use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_catalog-gen")).args(arguments).output().expect("the program starts")
}

/// A file of this test alone.
fn temporary(name: &str, bytes: Option<&[u8]>) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    if let Some(bytes) = bytes {
        std::fs::write(&path, bytes).expect("the test's directory is writable");
    }
    path
}

/// Runs, expects status 2, nothing on stdout and one line on stderr; gives the line.
fn refusal(arguments: &[&str]) -> String {
    let output = run(arguments);
    let line = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert!(output.stdout.is_empty());
    assert!(line.starts_with("catalog-gen: ") && line.trim_end().lines().count() == 1, "{line:?}");
    line
}

#[test]
fn build_without_options_writes_the_embedded_catalogue_byte_for_byte() {
    let path = temporary("built.cat", None);
    let output = run(&["build", "--out", path.to_str().unwrap()]);
    assert!(output.status.success() && output.stdout.is_empty());
    assert!(std::fs::read(&path).unwrap() == catalog_gen::REFERENCE);
}

#[test]
fn the_options_of_build_reach_the_catalogue() {
    let path = temporary("options.cat", None);
    let options = ["--magnitude", "5", "--fov-deg", "20", "--max-separation-deg", "7", "--epoch", "2031.25"];
    let arguments =
        [&["build", "--out", path.to_str().unwrap(), "--stars-per-field", "10"], &options[..]].concat();
    assert!(run(&arguments).status.success());
    let output = run(&["inspect", path.to_str().unwrap(), "--json", "--fields", "10"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (json["max_separation_deg"].as_f64(), json["epoch_year"].as_f64()),
        (Some(7.0), Some(2031.25))
    );
    assert_eq!(json["field_deg"].as_f64(), Some(20.0));
    assert!(json["faintest_v"].as_f64().unwrap() <= 5.0 && json["stars"].as_u64().unwrap() < 1600);
}

#[test]
fn a_flight_catalogue_of_every_lens_fits_its_flash_and_holds_as_many_stars_a_field_as_can_be() {
    let path = temporary("flight.cat", None);
    let path = path.to_str().unwrap();
    for (field_deg, stars_per_field) in [("8", 7.0), ("12", 15.0), ("16", 17.0), ("24.1", 30.0), ("40", 30.0)]
    {
        assert!(run(&["build", "--out", path, "--for-flight", "--fov-deg", field_deg]).status.success());
        let output = run(&["inspect", path, "--json", "--fields", "10"]);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let side: f64 = field_deg.parse().unwrap();
        let per_field = json["stars"].as_f64().unwrap() * 0.8 * side * side / 41_253.0;
        println!("{field_deg} deg: {} stars, {} bytes", json["stars"], json["bytes"]);
        assert!(json["bytes"].as_u64().unwrap() <= 256 * 1024);
        assert!(per_field > stars_per_field, "{field_deg} deg: {per_field}");
    }
    // That of the reference camera is the embedded one.
    assert!(run(&["build", "--out", path, "--for-flight"]).status.success());
    assert!(std::fs::read(path).unwrap() == catalog_gen::REFERENCE);
    for field_deg in ["7.9", "40.2"] {
        let line = refusal(&["build", "--out", path, "--for-flight", "--fov-deg", field_deg]);
        assert!(line.contains("must be 8 to 40 deg: give another focal length"), "{line}");
    }
}

#[test]
fn inspect_prints_one_json_object_and_nothing_else() {
    let path = temporary("inspect.cat", Some(catalog_gen::REFERENCE));
    let output = run(&["inspect", path.to_str().unwrap(), "--json", "--fields", "200"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.trim_end().lines().count(), 1);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["bytes"].as_u64(), Some(catalog_gen::REFERENCE.len() as u64));
    assert_eq!(json["coverage"]["fields"].as_u64(), Some(200));
    assert_eq!(json["coverage"]["free"]["5"].as_f64(), Some(1.0));
    assert_eq!(json["coverage"]["earth_disc"]["3"].as_f64(), Some(1.0));
    let again = run(&["inspect", path.to_str().unwrap(), "--json", "--fields", "200"]);
    assert_eq!(again.stdout, text.as_bytes(), "the seed is fixed");
}

#[test]
fn bad_files_are_named_with_what_is_wrong_and_what_to_do() {
    let inspect =
        |name: &str, bytes: &[u8]| refusal(&["inspect", temporary(name, Some(bytes)).to_str().unwrap()]);
    let whole = catalog_gen::REFERENCE;
    let changed = |offset: usize, value: u8| {
        let mut bytes = whole.to_vec();
        bytes[offset] = value;
        bytes
    };
    let missing = refusal(&["inspect", "no/such/file.cat"]);
    assert!(missing.contains("no/such/file.cat: cannot be read (no such file or directory)"), "{missing}");
    assert!(inspect("cut.cat", &whole[..1000]).contains("cut.cat: was cut or extended"));
    assert!(inspect("empty.cat", &[]).contains("is not a Sextant catalogue"));
    assert!(inspect("version.cat", &changed(4, 9)).contains("has layout version 9, this program reads 3"));
    assert!(inspect("bad.cat", &changed(5000, whole[5000] ^ 1)).contains("its checksum does not match"));
    let text = temporary("text.dat", Some(b"no stars here"));
    let out = temporary("unwritten.bin", None);
    let line = refusal(&["source", text.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(line.contains("text.dat: line 1 has 3 columns"), "{line}");
    assert!(!out.exists());
}

#[test]
fn impossible_parameters_are_refused_in_one_line() {
    for (option, value, message) in [
        ("--magnitude", "8.5", "magnitude limit of 8.5 is impossible; give 0 to 8"),
        ("--magnitude", "nan", "magnitude limit of NaN is impossible"),
        ("--magnitude", "bright", "invalid value 'bright'"),
        ("--fov-deg", "3", "no catalogue serves a field of 3.0 x 2.4 deg"),
        ("--fov-deg", "-20", "no catalogue serves a field"),
        ("--max-separation-deg", "0", "largest separation of 0 is impossible"),
        ("--max-separation-deg", "inf", "largest separation of inf is impossible"),
        ("--stars-per-field", "0", "number of stars per field of 0 is impossible"),
        ("--epoch", "26.5", "epoch of 26.5 is impossible; give 1950 to 2100"),
    ] {
        let out = temporary("never.cat", None);
        let line = refusal(&["build", "--out", out.to_str().unwrap(), option, value]);
        assert!(line.contains(message), "{line}");
        assert!(!out.exists());
    }
}

#[test]
fn wrong_usage_is_answered_in_one_line_and_help_is_no_error() {
    assert!(refusal(&[]).contains("--help"));
    assert!(refusal(&["build"]).contains("--out"));
    assert!(refusal(&["fly"]).contains("fly"));
    assert!(refusal(&["inspect", "a.cat", "--fields", "0"]).contains("'0'"));
    let unwritable = refusal(&["build", "--out", "no/such/place/x.cat"]);
    assert!(unwritable.contains("no/such/place/x.cat: cannot be written"), "{unwritable}");
    let help = run(&["--help"]);
    assert!(help.status.success() && String::from_utf8(help.stdout).unwrap().contains("inspect"));
}
