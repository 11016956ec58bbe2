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
        refused(&["solve", picture, "--fov-deg", fov_deg], &["orion_belt.jpg: no catalogue serves a field"]);
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
fn a_key_that_a_command_does_not_know_is_named_instead_of_ignored() {
    let folder = scratch("unknown-keys");
    let guess = r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0],"sigma_r_km":1,"sigma_v_km_s":0.001}"#;
    let with = |line: &str, key: &str| line.replacen('{', &format!("{{\"{key}\":1,"), 1);
    let refuse = |arguments: &[&str], text: &str, words: &[&str]| {
        let file = write(&folder, "given.json", text.as_bytes());
        refused(&[&[arguments[0], file.as_str()][..], &arguments[1..]].concat(), words)
    };
    let state = r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0]}"#;
    let propagate = ["propagate", "--duration-s", "60", "--step-s", "60", "--json"];
    refuse(
        &propagate,
        &with(state, "mas_kg"),
        &["given.json:", "unknown field `mas_kg`", "give ", "mass_kg"],
    );
    let navigate = ["navigate", "--json"];
    let words = ["given.json:1:", "unknown field `sigma_km`", "sigma_r_km"];
    refuse(&navigate, &with(guess, "sigma_km"), &words);
    let words = ["given.json:2:", "unknown field `range`", "range_km"];
    refuse(&navigate, &format!("{guess}\n{}", with(r#"{"t_s":10}"#, "range")), &words);
    let set = r#"{"id":1,"b":[[1,0,0],[0,1,0]],"r":[[1,0,0],[0,1,0]],"sigma_rad":[1e-4,1e-4]}"#;
    let words = ["given.json:1:", "unknown field `covariance`", "covariance_rad2"];
    refuse(&["attitude", "--json"], &with(set, "covariance"), &words);
}

#[test]
fn a_line_that_is_no_text_is_named_and_the_lines_beside_it_are_answered() {
    let folder = scratch("no-text");
    let with = |lines: [&str; 2], arguments: &[&str]| {
        let bytes = [lines[0].as_bytes(), b"\n\xFF\xFE\n", lines[1].as_bytes(), b"\n"].concat();
        let file = write(&folder, "lines.jsonl", &bytes);
        let arguments = [&[arguments[0], file.as_str()][..], &arguments[1..]].concat();
        refused(&arguments, &["lines.jsonl:2:", "UTF-8"])
    };
    let field = r#"{"id":1,"centroids":[[10,10],[500,500],[900,100]]}"#;
    assert_eq!(with([field, field], &["identify", "--camera", &reference_camera(), "--json"]).len(), 2);
    let set = r#"{"id":1,"b":[[1,0,0],[0,1,0]],"r":[[1,0,0],[0,1,0]],"sigma_rad":[1e-4,1e-4]}"#;
    assert_eq!(with([set, set], &["attitude", "--json"]).len(), 2);
    let guess = r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0],"sigma_r_km":1,"sigma_v_km_s":0.001}"#;
    assert_eq!(with([guess, r#"{"t_s":10}"#], &["navigate", "--json"]).len(), 1);
}

#[test]
fn a_file_without_lines_is_said() {
    let folder = scratch("no-lines");
    for bytes in [&b""[..], b"\n  \n"] {
        let file = write(&folder, "empty.jsonl", bytes);
        refused(
            &["identify", &file, "--camera", &reference_camera()],
            &["empty.jsonl", "no line", "centroids"],
        );
        refused(&["attitude", &file], &["empty.jsonl", "no line", "sigma_rad"]);
        refused(&["navigate", &file], &["empty.jsonl", "no line", "r_km"]);
        refused(
            &["propagate", &file, "--duration-s", "60", "--step-s", "60"],
            &["the file is empty", "r_km"],
        );
    }
}

/// A FITS picture of 32-bit reals, all of one value.
fn constant_fits(value: f32) -> Vec<u8> {
    let cards = ["SIMPLE  = T", "BITPIX  = -32", "NAXIS   = 2", "NAXIS1  = 64", "NAXIS2  = 48", "END"];
    let mut bytes: Vec<u8> = cards.iter().flat_map(|card| format!("{card:<80}").into_bytes()).collect();
    bytes.resize(2880, b' ');
    bytes.extend(value.to_be_bytes().repeat(64 * 48));
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    bytes
}

#[test]
fn pictures_without_content_are_named_as_such() {
    let folder = scratch("no-content");
    let nan = write(&folder, "nan.fits", &constant_fits(f32::NAN));
    for command in ["solve", "earth"] {
        refused(&[command, &nan, "--fov-deg", "15", "--json"], &["nan.fits", "no pixel", "number"]);
    }
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let [white, grey] = [path("white.png"), path("grey.png")];
    image::GrayImage::from_pixel(640, 480, image::Luma([255])).save(&white).unwrap();
    image::GrayImage::from_pixel(640, 480, image::Luma([9])).save(&grey).unwrap();
    let zero = write(&folder, "zero.fits", &constant_fits(0.0));
    for (picture, words) in [(&white, "overexposed"), (&grey, "same value"), (&zero, "same value")] {
        for command in ["solve", "earth"] {
            let output = run(&[command, picture, "--fov-deg", "15", "--json"]);
            assert!(output.status.success());
            let reason = json_lines(&output)[0]["reason"].as_str().unwrap().to_owned();
            assert!(reason.contains(words), "{command} {picture}: {reason}");
        }
    }
}

#[test]
fn darks_that_are_copies_or_show_stars() {
    let folder = scratch("darks");
    let Some(dark) = data("sky/tomcreusot/dark_frame.png") else { return };
    let table = folder.join("x.defects");
    let out = ["--out", table.to_str().unwrap()];
    let copies: Vec<String> =
        (1..=5).map(|k| write(&folder, &format!("dark{k}.png"), &std::fs::read(&dark).unwrap())).collect();
    let copies: Vec<&str> = copies.iter().map(String::as_str).collect();
    let words = ["dark2.png", "dark1.png", "equal"];
    refused(&[&["defects"], &copies[..], &out].concat(), &words);
    let lens = "sky/tomcreusot/16mm_checker_2";
    let names = ["Albaldah/albaldah", "Nunki/nunki", "Anteries/anteries", "Kekouan/kekouan"];
    let mut skies: Vec<PathBuf> =
        names.iter().map(|name| data(&format!("{lens}/{name}_700000e_11.3g.png")).unwrap()).collect();
    skies.push(data("sky/tomcreusot/16mm_checker_calib/distorted/up_2/up_2_16.png").unwrap());
    let skies: Vec<&str> = skies.iter().map(|path| path.to_str().unwrap()).collect();
    refused(&[&["defects"], &skies[..], &out].concat(), &["show stars", "lens closed"]);
    assert!(!table.exists());
}

#[test]
fn campaigns_of_nothing_are_said() {
    let folder = scratch("campaigns");
    let held = |out: &str, words: &[&str]| {
        refused(&["campaign", "acquire", "--runs", "3", "--held", "--out", out], words);
    };
    let file = folder.join("runs.jsonl");
    let path = file.to_str().unwrap();
    held(path, &["runs.jsonl", "no such file"]);
    assert!(!file.exists(), "it is not made");
    let empty = write(&folder, "empty.jsonl", b"");
    held(&empty, &["empty.jsonl", "none of these runs", "--seed"]);
    let binary = write(&folder, "binary.jsonl", b"\xFF\xFE\n");
    held(&binary, &["binary.jsonl:1:", "no line of such a campaign"]);
    let nothing = ["campaign", "identify", "--fields", "0", "--skies", "0", "--no-stars", "0"];
    refused(&nothing, &["no field is asked for", "--skies"]);
}

#[test]
fn hints_name_the_command_that_was_called() {
    let hints: [(&[&str], &str); 2] =
        [(&["campaign", "run", "--runs", "0"], "campaign run --help"), (&["decode", "-"], "telemetry")];
    for (called, (arguments, hint)) in
        ["sil-host", "cargo sil"].iter().flat_map(|by| hints.map(|hint| (by, hint)))
    {
        let mut command = std::process::Command::new(system_tests::sil_host());
        match *called {
            "cargo sil" => command.env("CARGO", "cargo"),
            _ => command.env_remove("CARGO"),
        };
        let output = command.args(arguments).stdin(std::process::Stdio::null()).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let line = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(line.trim_end().ends_with(&format!("`{called} {hint}`")), "{line}");
    }
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
    refused(&["solve", "a.png", "--catalog", "c"], &["--camera", "--fov-deg"]);
    refused(&["earth", "a.png"], &["--camera", "--fov-deg"]);
    refused(&["calibrate", "a.png", "--out", "x.toml"], &["--camera", "--fov-deg"]);
    refused(&["calibrate", "--rendered", "3", "--fov-deg", "24", "--out", "x.toml"], &["--fov-deg"]);
    for campaign in ["run", "belief", "scenarios", "acquire", "earth"] {
        refused(&["campaign", campaign, "--runs", "0"], &["--runs"]);
    }
    refused(&["record", "a.png", "--out", "x"], &["--fov-deg"]);
}

#[test]
fn names_that_are_misspelt_get_the_nearest_and_values_of_another_kind_their_key() {
    let folder = scratch("misspelt");
    refused(&["run", "geo-eclpise"], &["the nearest name is geo-eclipse"]);
    refused(&["gallery", "fig-8.55"], &["the nearest name is fig-8.5"]);
    refused(&["campain"], &["'campaign'"]);
    let (_, text) = sil_host::scenario::EMBEDDED[0];
    let kind =
        write(&folder, "kind.toml", text.replace("duration_s = 21600", "duration_s = \"1\"").as_bytes());
    refused(&["run", &kind], &["scenario.duration_s: string \"1\" in the place of a whole number"]);
    let vary = write(&folder, "vary.toml", b"[scenario]\nexposure_ms = { gauss = [400.0, 1.0] }\n");
    let words = ["vary.toml:2", "scenario.exposure_ms: gauss is no distribution", "normal = [mean, sigma]"];
    refused(&["campaign", "run", "geo-eclipse", "--vary", &vary], &words);
    let sets = write(&folder, "sets.jsonl", b"[1]\n");
    let message = run(&["attitude", &sets]);
    assert!(!String::from_utf8_lossy(&message.stderr).contains("struct"), "{message:?}");
}

#[test]
fn files_beside_another_are_not_written_over_it_and_an_old_table_stays() {
    let folder = scratch("beside");
    for name in ["camera.svg", "camera.corr"] {
        let out = folder.join(name);
        let out = out.to_str().unwrap();
        refused(&["calibrate", "a.png", "--fov-deg", "24", "--out", out], &[name, "would have its name"]);
    }
    let table = write(&folder, "old.csv", b"old");
    refused(&["solve", "no-such.png", "--csv", &table], &["no-such.png"]);
    assert_eq!(std::fs::read(&table).unwrap(), b"old");
}

#[test]
fn a_gyro_that_the_flight_code_cannot_use_is_said_in_a_line_and_flown() {
    let folder = scratch("unused-gyro");
    let text = std::fs::read_to_string(workspace().join("sil-host/src/scenarios/tumbling.toml")).unwrap();
    let duration = text.lines().find(|line| line.starts_with("duration_s")).expect("a duration");
    let text = text.replace(duration, "duration_s = 10");
    let out = folder.join("out");
    for (name, gyro, warnings) in [
        ("bare.toml", "[gyro]", 1),
        ("quiet.toml", "[gyro]\nnoise_deg_s = 0.0025\nresolution_deg_s = 0.0", 0),
    ] {
        let file = write(&folder, name, text.replace("[gyro]", gyro).as_bytes());
        let output = run(&["run", &file, "--json", "--out", out.to_str().unwrap()]);
        assert!(matches!(output.status.code(), Some(0 | 1)));
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        let said = words.lines().filter(|line| line.contains(name) && line.contains("the gyro is not used"));
        assert_eq!(said.count(), warnings, "{words}");
    }
}
