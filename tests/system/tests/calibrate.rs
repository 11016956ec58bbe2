//! `sil-host calibrate` on real pictures: a lens found from some pictures serves the others of the same lens.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;
use system_tests::{amount, data, direction, json_lines, run, scratch, separation_arcsec, workspace};

/// Pictures of one lens, by a part of their names.
const LENSES: [&str; 3] = ["esa-tetra3/", "tomcreusot/", "ms.jpg"];
/// How far an answer may be from the truth, which is known to 1 to 8 arcsec.
const ALLOWED_ARCSEC: f64 = 15.0;
/// How wrong the focal length is from which calibration starts.
const START_ERROR: f64 = 1.01;

struct Photograph {
    path: PathBuf,
    truth: Value,
}

impl Photograph {
    fn number(&self, key: &str) -> f64 {
        self.truth[key].as_f64().unwrap()
    }
}

/// The pictures with their truth; `None` without data.
fn photographs() -> Option<Vec<Photograph>> {
    let truth = std::fs::read_to_string(data("sky/truth.json")?).unwrap();
    let truth: Vec<Value> = serde_json::from_str(&truth).unwrap();
    let path = |truth: &Value| data(&format!("sky/{}", truth["image"].as_str().unwrap()));
    truth.into_iter().map(|truth| Some(Photograph { path: path(&truth)?, truth })).collect()
}

/// A camera file with the size and, but for [`START_ERROR`], the field of a picture.
fn start_camera(photograph: &Photograph, folder: &Path) -> PathBuf {
    let size = |k: usize| photograph.truth["size"][k].as_f64().unwrap();
    let (width, height) = (size(0), size(1));
    let focal_length = START_ERROR * 0.5 * width / (0.5 * photograph.number("FOV_h_deg").to_radians()).tan();
    let text = format!(
        "[detector]\nwidth_px = {width}\nheight_px = {height}\nbits = 16\n[optics]\nfocal_length_px = {focal_length:.2}\n\
         optical_centre_px = [{:.1}, {:.1}]\n",
        0.5 * (width - 1.0),
        0.5 * (height - 1.0)
    );
    let path = folder.join("start.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn calibrate(pictures: &[&Photograph], start: &Path, out: &Path) -> Output {
    let mut arguments = vec!["calibrate"];
    arguments.extend(pictures.iter().map(|photograph| photograph.path.to_str().unwrap()));
    arguments.extend(["--camera", start.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    run(&arguments)
}

#[test]
fn a_lens_from_other_pictures_serves_each_picture() {
    let Some(all) = photographs() else { return };
    let folder = scratch("calibrate");
    let mut solved = 0;
    for lens in LENSES {
        let of_lens = |photograph: &&Photograph| photograph.truth["image"].as_str().unwrap().contains(lens);
        let pictures: Vec<&Photograph> = all.iter().filter(of_lens).collect();
        for (index, picture) in pictures.iter().enumerate() {
            let others: Vec<&Photograph> =
                pictures.iter().enumerate().filter(|(k, _)| *k != index).map(|(_, other)| *other).collect();
            let (start, camera) = (start_camera(others[0], &folder), folder.join("camera.toml"));
            let output = calibrate(&others, &start, &camera);
            assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
            assert!(folder.join("camera.svg").exists());
            let output = run(&[
                "solve",
                picture.path.to_str().unwrap(),
                "--camera",
                camera.to_str().unwrap(),
                "--json",
            ]);
            let answer = &json_lines(&output)[0];
            assert_eq!(answer["status"], "identified", "{answer}");
            let found = direction(answer["ra_deg"].as_f64().unwrap(), answer["dec_deg"].as_f64().unwrap());
            let error =
                separation_arcsec(found, direction(picture.number("RA_deg"), picture.number("Dec_deg")));
            let stars = answer["stars"].as_array().unwrap();
            println!("{}: {error:.1} arcsec from the truth, {} stars", picture.path.display(), stars.len());
            assert!(error < ALLOWED_ARCSEC);
            solved += 1;
        }
    }
    assert_eq!(solved, 10);
}

#[test]
fn bad_pictures_are_named_and_the_others_still_serve() {
    let Some(all) = photographs() else { return };
    let folder = scratch("calibrate-bad");
    let named = |part: &str| all.iter().find(|p| p.truth["image"].as_str().unwrap().contains(part)).unwrap();
    let (good, other_size) = (named("Albaldah"), named("orion_belt"));
    let dark = Photograph { path: data("sky/tomcreusot/dark_frame.png").unwrap(), truth: Value::Null };
    let start = start_camera(good, &folder);
    let out = folder.join("camera.toml");
    let output = calibrate(&[good, other_size], &start, &out);
    assert_eq!(output.status.code(), Some(2));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        words.lines().count() == 1 && words.contains("orion_belt") && words.contains("512 x 512"),
        "{words}"
    );
    assert!(out.exists());
    let output = calibrate(&[&dark], &start, &folder.join("none.toml"));
    assert_eq!(output.status.code(), Some(2));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("not identified") && words.contains("do not determine"), "{words}");
    assert!(!folder.join("none.toml").exists());
}

#[test]
fn a_field_of_view_serves_instead_of_a_camera_file_and_one_picture_is_said_to_be_few() {
    let Some(all) = photographs() else { return };
    let folder = scratch("calibrate-field");
    let pictures: Vec<&Photograph> =
        all.iter().filter(|p| p.truth["image"].as_str().unwrap().contains("esa-tetra3/")).collect();
    let focal_length = |count: usize| {
        let out = folder.join("camera.toml");
        let field_deg = (1.01 * pictures[0].number("FOV_h_deg")).to_string();
        let names = pictures[..count].iter().map(|picture| picture.path.to_str().unwrap());
        let mut arguments = vec!["calibrate"];
        arguments.extend(names);
        arguments.extend(["--fov-deg", &field_deg, "--out", out.to_str().unwrap()]);
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.contains("One picture: "), count == 1, "{text}");
        assert!(!text.contains("sil-host: "), "a message within a line needs no name: {text}");
        let line = text.lines().find(|line| line.starts_with("focal_length_px")).unwrap();
        let (value, sigma) = line.trim_start_matches("focal_length_px").split_once('±').unwrap();
        [value, sigma].map(|number| number.trim().parse::<f64>().unwrap())
    };
    let [one, all_three] = [focal_length(1), focal_length(3)];
    println!("focal length by 1 picture {one:?}, by 3 {all_three:?}");
    assert!((one[0] - all_three[0]).abs() < 2.0 * one[1] && all_three[1] < one[1]);
    // Aberration alone is 1e-4.
    assert!(one[1] > 1e-4 * one[0] && one[1] < 1e-3 * one[0]);
}

/// The gate compares the first picture alone (`calibration::tests`): all take a minute.
#[test]
fn the_calibrated_reference_camera_is_what_the_command_makes() {
    if !amount(false, true) {
        return;
    }
    let (cameras, folder) = (workspace().join("sil-host/cameras"), scratch("calibrate-rendered"));
    let (start, out) = (cameras.join("reference.toml"), folder.join("reference-calibrated.toml"));
    let files = ["--camera", start.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = run(&[&["calibrate", "--rendered", "400"][..], &files].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["reference-calibrated.toml", "reference-calibrated.corr"] {
        let [kept, made] = [&cameras, &folder].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(kept == made, "sil-host/cameras/{name} is out of date: make it anew and look at what flies");
    }
}
