//! Bad input gets one clear line (what, where, what to do) and status 2, and what was good is still answered.

use std::path::{Path, PathBuf};
use system_tests::{data, json_lines, refused, run, scratch, workspace};

fn write(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path: PathBuf = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

fn reference_camera() -> String {
    workspace().join("sil-host/cameras/reference.toml").to_str().unwrap().to_owned()
}

#[test]
fn pictures_that_are_missing_or_truncated() {
    let folder = scratch("pictures");
    refused(&["solve", "no-such.png", "--fov-deg", "15", "--json"], &["no-such.png", "check the path"]);
    let text = write(&folder, "text.png", b"this is no picture");
    refused(&["solve", &text, "--fov-deg", "15"], &["text.png", "format"]);
    let empty = write(&folder, "empty.png", b"");
    refused(&["solve", &empty, "--fov-deg", "15"], &["empty"]);
    let Some(picture) = data("sky/cedar-solve/orion_belt.jpg") else { return };
    let bytes = std::fs::read(&picture).unwrap();
    let half = write(&folder, "half.jpg", &bytes[..bytes.len() / 2]);
    refused(&["solve", &half, "--fov-deg", "10"], &["half.jpg", "truncated"]);
}

#[test]
fn one_bad_picture_does_not_lose_the_good_one() {
    let Some(picture) = data("sky/cedar-solve/orion_belt.jpg") else { return };
    let arguments = ["solve", "no-such.png", picture.to_str().unwrap(), "--fov-deg", "10.1", "--json"];
    let answers = refused(&arguments, &["no-such.png"]);
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0]["status"], "identified");
}

#[test]
fn fields_that_no_catalogue_serves() {
    let Some(picture) = data("sky/cedar-solve/orion_belt.jpg") else { return };
    let picture = picture.to_str().unwrap();
    for fov_deg in ["0.5", "100"] {
        refused(&["solve", picture, "--fov-deg", fov_deg], &["no catalogue serves a field"]);
    }
    for fov_deg in ["-3", "0", "NaN"] {
        refused(&["solve", picture, "--fov-deg", fov_deg], &[]);
    }
}

#[test]
fn lines_of_fields_that_are_no_fields() {
    let folder = scratch("fields");
    let good = r#"{"id":"good","centroids":[[10,10],[500,500],[900,100]]}"#;
    let bad = [
        ("{\"id\":1,\"centroids\":[[1,2],", "EOF"),
        ("{\"id\":1,\"centroids\":[[NaN,2]]}", "expected value"),
        ("{\"id\":1,\"centroids\":[[1e300,2]]}", "not finite"),
        ("{\"id\":1,\"centroids\":[[null,2]]}", "null"),
        ("{\"id\":1,\"centroids\":[[1]]}", "1 numbers"),
        ("{\"centroids\":[]}", "id"),
    ];
    for (line, word) in bad {
        let file = write(&folder, "fields.jsonl", format!("{good}\n{line}\n{good}\n").as_bytes());
        let camera = reference_camera();
        let answers =
            refused(&["identify", &file, "--camera", &camera, "--json"], &["fields.jsonl:2:", word]);
        assert_eq!(answers.len(), 2, "the good lines are answered");
        assert!(answers.iter().all(|answer| answer["id"] == "good" && answer["status"] == "not_identified"));
    }
    refused(&["identify", "no-such.jsonl", "--camera", &reference_camera()], &["no-such.jsonl"]);
}

#[test]
fn cameras_that_are_wrong_name_file_line_and_key() {
    let folder = scratch("cameras");
    let file = write(&folder, "fields.jsonl", b"");
    let reference = std::fs::read_to_string(reference_camera()).unwrap();
    let wrong = reference.replace("focal_length_px = 3000.0", "focal_length_px = -3.0");
    assert_ne!(wrong, reference);
    let camera = write(&folder, "wrong.toml", wrong.as_bytes());
    refused(&["identify", &file, "--camera", &camera], &["wrong.toml:", "focal_length_px"]);
    let camera = write(&folder, "unknown.toml", format!("{reference}\nfocus = 3\n").as_bytes());
    refused(&["identify", &file, "--camera", &camera], &["unknown.toml:", "focus"]);
    refused(&["identify", &file, "--camera", "no-such.toml"], &["no-such.toml"]);
}

#[test]
fn catalogues_of_a_wrong_version_or_checksum() {
    let folder = scratch("catalogues");
    let file = write(&folder, "fields.jsonl", b"");
    let camera = reference_camera();
    let with = |bytes: &[u8], words: &[&str]| {
        let catalogue = write(&folder, "some.cat", bytes);
        refused(&["identify", &file, "--camera", &camera, "--catalog", &catalogue], words);
    };
    let mut bytes = catalog_gen::REFERENCE.to_vec();
    bytes[4] = 9;
    with(&bytes, &["some.cat", "version 9"]);
    bytes[4] = catalog_gen::REFERENCE[4];
    bytes[1000] ^= 1;
    with(&bytes, &["some.cat", "checksum"]);
    with(&catalog_gen::REFERENCE[..5000], &["some.cat"]);
    with(b"no catalogue", &["some.cat"]);
    refused(&["identify", &file, "--camera", &camera, "--catalog", "no-such.cat"], &["no-such.cat"]);
}

#[test]
fn more_centroids_than_the_cap_are_cut_to_the_brightest_and_said() {
    let folder = scratch("many");
    let centroids: Vec<_> = (0..100).map(|i| format!("[{},{},{i}]", 7 * i, (311 * i) % 1000)).collect();
    let line = format!("{{\"id\":7,\"centroids\":[{}]}}\n", centroids.join(","));
    let file = write(&folder, "fields.jsonl", line.as_bytes());
    let output = run(&["identify", &file, "--camera", &reference_camera(), "--json"]);
    assert!(output.status.success());
    let answers = json_lines(&output);
    assert_eq!(answers[0]["centroids_used"], 64);
    assert_eq!(answers[0]["hip"].as_array().unwrap().len(), 100);
}

#[test]
fn scenarios_that_are_wrong_name_file_line_and_key() {
    let folder = scratch("scenarios");
    let (_, good) = sil_host::scenario::EMBEDDED[0];
    let with = |from: &str, to: &str, words: &[&str]| {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        let scenario = write(&folder, "wrong.toml", text.as_bytes());
        let line = 1 + text.lines().position(|line| line.starts_with(to)).expect("the line");
        let place = format!("wrong.toml:{line}:");
        let words = [words, &[place.as_str()]].concat();
        refused(&["run", &scenario, "--out", folder.join("out").to_str().unwrap()], &words);
        refused(&["render", &scenario, "--cycle", "1", "--out", "x.png"], &words);
    };
    with("e = 0.0002", "e = 0.9", &["orbit.e", "perigee"]);
    with("a_km = 42164.17", "a_km = 6000", &["orbit.a_km", "out of range"]);
    with("duration_s = 21600", "duration_s = -1", &["scenario.duration_s"]);
    with("seed = 1", "seeed = 1", &["seeed"]);
    with("hot_pixels = 200", "hot_pixels = many", &[]);
    with("mode_share = 0.99", "mood_share = 0.99", &["mood_share", "mode_share"]);
    let binary = write(&folder, "binary.toml", &[0xFF, 0x00, 0xFE]);
    refused(&["run", &binary], &["binary.toml", "read"]);
    refused(&["run", "no-such.toml"], &["no-such.toml", "geo-eclipse"]);
    refused(&["run", folder.to_str().unwrap()], &["read"]);
    let file = write(&folder, "file", b"");
    refused(&["run", "geo-eclipse", "--out", &format!("{file}/out")], &["file/out"]);
    refused(&["render", "geo-eclipse", "--cycle", "21600", "--out", "x.png"], &["--cycle", "21599"]);
    refused(&["render", "geo-eclipse", "--cycle", "1", "--out", "x.gif"], &["x.gif", ".png"]);
    refused(&["run", "geo-eclipse", "--seed", "many"], &["--seed"]);
}

#[test]
fn usage_errors() {
    refused(&["fly"], &["fly"]);
    refused(&["solve", "a.png"], &["--camera"]);
    refused(&["record", "a.png", "--out", "x"], &["--fov-deg"]);
}
