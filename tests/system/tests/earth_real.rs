//! Real pictures of the Earth: its centre, radius and limb as known from elsewhere, from LEO, GEO and deep
//! space; night is refused.
//!
//! Truth: the README beside the pictures (projections of the products, reference fits). The thesis's own
//! method runs on the same pictures and stands beside ours in the printed table.

use fsw_core::earth::comparison::thesis;
use fsw_core::earth::search::Points;
use fsw_hal::{Detector, DetectorGeometry};
use image::{ImageBuffer, Luma};
use serde_json::Value;
use sil_host::formats::picture::Picture;
use sil_host::world::noise::{Noise, Stream};
use std::path::{Path, PathBuf};
use system_tests::{data, json_lines, refused, run, scratch};

/// A camera that took a picture.
#[derive(Clone, Copy)]
pub struct Camera {
    size_px: [u32; 2],
    pub focal_length_px: f64,
    pub centre_px: [f64; 2],
    projection: &'static str,
}

/// GEO products lie on grids of scan angles: f is one over the angle of a pixel.
pub const GOES15: Camera = Camera {
    size_px: [469, 480],
    // Half axis of the joint fit over the half angle of the disc.
    focal_length_px: 235.25 / 0.151_852_1,
    centre_px: [234.13, 246.15],
    projection: "equiangular",
};
pub const GOES16: Camera = Camera {
    size_px: [520, 520],
    focal_length_px: 512.0 / (56e-6 * 5424.0),
    centre_px: [259.5, 259.5],
    projection: "equiangular",
};
pub const METEOSAT: Camera = Camera {
    size_px: [742, 742],
    focal_length_px: 742.0 / (83.843e-6 * 3712.0),
    centre_px: [370.5, 370.5],
    projection: "equiangular",
};
const OPS_SAT: Camera = Camera {
    size_px: [2048, 1944],
    focal_length_px: 10_300.0,
    centre_px: [1023.5, 971.5],
    projection: "rectilinear",
};
/// OSIRIS's narrow camera, 18.6 urad a pixel; of a disc so small the focal length moves the distance alone.
const ROSETTA: Camera = Camera {
    size_px: [1355, 1315],
    focal_length_px: 53_763.0,
    centre_px: [677.0, 657.0],
    projection: "rectilinear",
};

impl Camera {
    /// Writes the camera file.
    fn file(&self, folder: &Path) -> String {
        let Self { size_px: [width, height], focal_length_px, centre_px: [x, y], projection } = self;
        let text = format!(
            "[detector]\nwidth_px = {width}\nheight_px = {height}\nbits = 16\n[optics]\nfocal_length_px = {focal_length_px:?}\n\
             optical_centre_px = [{x:?}, {y:?}]\nprojection = \"{projection}\"\n"
        );
        let path: PathBuf = folder.join(format!("{width}x{height}-{focal_length_px:.0}.toml"));
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    }
}

/// The answer for one of the pictures.
pub fn earth(test: &str, picture: &str, camera: &Camera, arguments: &[&str]) -> Option<Value> {
    let path = data(&format!("earth/{picture}"))?;
    Some(earth_in(&path, &scratch(test), camera, arguments))
}

/// The answer for a picture, after a line about it and about what the thesis's method makes of it.
fn earth_in(path: &Path, folder: &Path, camera: &Camera, arguments: &[&str]) -> Value {
    let file = camera.file(folder);
    let all = [&["earth", path.to_str().unwrap(), "--camera", &file, "--json"], arguments].concat();
    let output = run(&all);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
    let answers = json_lines(&output);
    assert_eq!(answers.len(), 1, "one object a picture");
    let answer = answers.into_iter().next().unwrap();
    let ours = if answer["status"] == "found" {
        format!(
            "centre {:.2} {:.2}, radius {:.2} px, {} of {} points over {:.0} deg, rms {:.2} px, sigma {:.4} deg",
            number(&answer["centre_px"][0]),
            number(&answer["centre_px"][1]),
            number(&answer["radius_px"]),
            answer["inliers"],
            answer["points"],
            number(&answer["arc_deg"]),
            number(&answer["rms_px"]),
            number(&answer["sigma_deg"]),
        )
    } else {
        assert_eq!(answer["status"], "not_found");
        assert!(answer["reason"].is_string() && answer["direction"].is_null());
        format!("not found: {}", answer["reason"])
    };
    let name = path.file_name().unwrap().to_string_lossy();
    println!("{name}\n    ours:   {ours}\n    thesis: {}", by_the_thesis(path, !arguments.is_empty()));
    answer
}

/// What the thesis's method makes of a picture; where no pole is known nothing is circularised.
fn by_the_thesis(path: &Path, pole_known: bool) -> String {
    let eccentricity = if pole_known { thesis::ECCENTRICITY } else { 0.0 };
    let mut picture = Picture::load(path).unwrap();
    picture.expose(1000).unwrap();
    let mut points = Points::new();
    thesis::limb_points(&mut picture, &mut [0; 4096], &mut points).unwrap();
    match thesis::circle(&points, [0.0, -1.0], eccentricity) {
        Ok(circle) => format!(
            "centre {:.2} {:.2}, radius {:.2} px, {} of {} points",
            circle.centre_px[0],
            circle.centre_px[1],
            circle.radius_px,
            circle.inliers,
            points.len()
        ),
        Err(refusal) => format!("{refusal:?} of {} points", points.len()),
    }
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn centre(answer: &Value) -> [f64; 2] {
    assert_eq!(answer["status"], "found", "{}", answer["image"]);
    [number(&answer["centre_px"][0]), number(&answer["centre_px"][1])]
}

fn apart([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).hypot(ay - by)
}

/// North is up or down: a pole's sign does not matter.
pub const NORTH: [&str; 2] = ["--pole", "0,-1,0"];

#[test]
fn geo_tiles_agree_with_their_projection() {
    for (picture, camera, [a, b]) in [
        ("pytroll/natural_hrit.png", METEOSAT, [362.0, 360.8]),
        ("pytroll/GOES16_ABI_C02_520.png", GOES16, [255.97, 255.12]),
    ] {
        let Some(answer) = earth("geo-tiles", picture, &camera, &NORTH) else { return };
        let error = apart(centre(&answer), camera.centre_px);
        let radius = number(&answer["radius_px"]) / (0.5 * (a + b)) - 1.0;
        println!("    centre off by {error:.2} px, radius by {:+.2} %", 100.0 * radius);
        assert!(error <= 0.5, "{picture}: {error}");
        assert!(radius.abs() <= 0.004, "{picture}: {radius}");
        // Half angle 8.7 deg: from the geostationary orbit, within the radius's error.
        assert!((number(&answer["distance_km"]) / 42_164.0 - 1.0).abs() < 0.004);
    }
}

#[test]
fn three_hours_of_one_satellite_share_their_centre() {
    let mut centres = Vec::new();
    for hour in ["1506", "1806", "2106"] {
        let picture = format!("goestools/GOES15_FD_VS_20170821T{hour}Z.png");
        let Some(answer) = earth("goes15", &picture, &GOES15, &NORTH) else { return };
        centres.push(centre(&answer));
        let radius = number(&answer["radius_px"]) / (0.5 * (235.25 + 234.62)) - 1.0;
        assert!(radius.abs() <= 0.004, "{radius}");
    }
    let mean = [0, 1].map(|k| centres.iter().map(|centre| centre[k]).sum::<f64>() / 3.0);
    println!("common centre {mean:.2?}, of the joint fit {:.2?}", GOES15.centre_px);
    for found in centres {
        println!("    {:.2} px from the common centre", apart(found, mean));
        assert!(apart(found, mean) <= 0.7 && apart(found, GOES15.centre_px) <= 0.7);
    }
}

/// A picture as a cheaper camera would have taken it: over a dark level of 20, and with noise, of 255.
fn degraded(path: &Path, folder: &Path, noise: f64) -> PathBuf {
    let mut picture = image::open(path).unwrap().into_luma8();
    let source = Noise::new(2026, 0, Stream::Read);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        let value = 20.0 + 0.9 * f64::from(pixel.0[0]) + noise * source.gaussian(x, y);
        pixel.0[0] = value.round().clamp(0.0, 255.0) as u8;
    }
    let name = format!("noise-{noise}-{}", path.file_name().unwrap().to_string_lossy());
    let degraded = folder.join(name);
    picture.save(&degraded).unwrap();
    degraded
}

#[test]
fn noise_and_a_dark_level_hide_no_earth() {
    let folder = scratch("noise");
    for (picture, camera, semiaxes) in [
        ("pytroll/natural_hrit.png", METEOSAT, [362.0, 360.8]),
        ("pytroll/GOES16_ABI_C02_520.png", GOES16, [255.97, 255.12]),
        ("goestools/GOES15_FD_VS_20170821T1506Z.png", GOES15, [235.25, 234.62]),
        ("goestools/GOES15_FD_VS_20170821T1806Z.png", GOES15, [235.25, 234.62]),
        ("goestools/GOES15_FD_VS_20170821T2106Z.png", GOES15, [235.25, 234.62]),
    ] {
        let Some(path) = data(&format!("earth/{picture}")) else { return };
        for noise in [1.0, 2.0, 4.0] {
            let answer = earth_in(&degraded(&path, &folder, noise), &folder, &camera, &NORTH);
            let error = apart(centre(&answer), camera.centre_px);
            let radius = number(&answer["radius_px"]) / (0.5 * (semiaxes[0] + semiaxes[1])) - 1.0;
            println!("    centre off by {error:.2} px, radius by {:+.2} %", 100.0 * radius);
            assert!(error <= 1.0 && radius.abs() <= 0.004, "{picture}, noise {noise}: {error} {radius}");
        }
    }
}

#[test]
fn a_thin_crescent_from_deep_space() {
    let picture = "cislunar-explorers/crescentearth_rosetta_big.png";
    let Some(answer) = earth("rosetta", picture, &ROSETTA, &[]) else { return };
    let error = apart(centre(&answer), [670.96, 635.84]);
    let radius = number(&answer["radius_px"]) - 510.92;
    println!("    centre off the reference fit by {error:.2} px, radius by {radius:+.2} px");
    assert!(error <= 1.0 && radius.abs() <= 1.0);
}

#[test]
fn the_wide_limb_from_a_low_orbit_is_one_cone() {
    let Some(answer) = earth("opssat", "opssat/img_msec_1597559030639_2.png", &OPS_SAT, &[]) else { return };
    let rays: Vec<[f64; 3]> = answer["limb"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|point| point["inlier"] == true)
        .map(|point| {
            let [cx, cy] = OPS_SAT.centre_px;
            let (x, y) = (number(&point["x"]) - cx, number(&point["y"]) - cy);
            let length = x.hypot(y).hypot(OPS_SAT.focal_length_px);
            [x, y, OPS_SAT.focal_length_px].map(|part| part / length)
        })
        .collect();
    // Unit vectors of a cone end in a plane, n . s = 1; residuals along it, px, to the sine of the cone's
    // half angle.
    let n = plane(&rays);
    let length = n.iter().map(|k| k * k).sum::<f64>().sqrt();
    let sine = (1.0 - 1.0 / (length * length)).sqrt();
    let off = |s: &[f64; 3]| (dot(n, *s) - 1.0) / length / sine * OPS_SAT.focal_length_px;
    let rms = (rays.iter().map(|s| off(s).powi(2)).sum::<f64>() / rays.len() as f64).sqrt();
    let (distance, sigma) = (number(&answer["distance_km"]), number(&answer["sigma_distance_km"]));
    println!(
        "    {} rays, rms about one cone {rms:.2} px (by the fit {:.2}); distance {distance:.0} km, sigma {sigma:.0}",
        rays.len(),
        number(&answer["rms_px"])
    );
    assert!(rays.len() >= 20 && rms <= 0.5 && number(&answer["rms_px"]) <= 0.5);
    // The orbit's height is known to some km; an arc of 12 deg leaves the distance open by hundreds, and says
    // so.
    assert!((distance - (6371.0 + 515.0)).abs() <= 3.0 * sigma && sigma < 400.0);
}

#[test]
fn a_real_horizon_in_pixels_as_wide_as_mitas_is_refused_and_in_half_of_them_gives_the_height() {
    let Some(path) = data("earth/opssat/img_msec_1597559030639_2.png") else { return };
    let folder = scratch("opssat-blocks");
    let whole = Picture::load(&path).unwrap();
    // The field is 11.4 deg wide, MITA's 12.7 by 17.2; f = 1287.5 px in blocks of 8, MITA's 1285.7.
    let in_blocks = |side: u16| {
        let picture = whole.binned(side).unwrap();
        let DetectorGeometry { width_px, height_px, .. } = picture.geometry();
        let file = folder.join(format!("{side}.png"));
        let size_px = [width_px, height_px].map(u32::from);
        let pixels = picture.pixels().to_vec();
        let written = ImageBuffer::<Luma<u16>, _>::from_raw(size_px[0], size_px[1], pixels).unwrap();
        written.save(&file).unwrap();
        let side = f64::from(side);
        let centre_px = OPS_SAT.centre_px.map(|at| (at - 0.5 * (side - 1.0)) / side);
        let camera =
            Camera { size_px, focal_length_px: OPS_SAT.focal_length_px / side, centre_px, ..OPS_SAT };
        earth_in(&file, &folder, &camera, &[])
    };
    let answer = in_blocks(4);
    assert_eq!(answer["status"], "found");
    let (distance, sigma) = (number(&answer["distance_km"]), number(&answer["sigma_distance_km"]));
    let off = distance - (6371.0 + 515.0);
    println!("    height off by {off:+.0} km from 515, sigma {sigma:.0}; thesis, MITA: 45");
    assert!(off.abs() <= 3.0 * sigma && sigma < 400.0);
    // Too few points of so short an arc: a centre would be a guess.
    assert_eq!(in_blocks(8)["reason"], "the limb points leave the centre too uncertain");
}

/// Least squares of `n . s = 1`.
fn plane(rays: &[[f64; 3]]) -> [f64; 3] {
    let sum = |f: &dyn Fn(&[f64; 3]) -> f64| rays.iter().map(f).sum::<f64>();
    let m = [0, 1, 2].map(|i| [0, 1, 2].map(|j| sum(&|s| s[i] * s[j])));
    let v = [0, 1, 2].map(|i| sum(&|s| s[i]));
    let determinant = |m: [[f64; 3]; 3]| dot(m[0], cross(m[1], m[2]));
    // Cramer's rule; the matrix is symmetric, rows are columns.
    [0, 1, 2].map(|k| {
        let mut with = m;
        with[k] = v;
        determinant(with) / determinant(m)
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[test]
fn a_night_with_aurora_and_a_space_station_in_front_is_refused() {
    // The camera is not known: whatever it was.
    for focal_length_px in [1000.0, 1600.0, 2700.0, 5000.0, 20_000.0] {
        for projection in ["rectilinear", "equiangular"] {
            let camera =
                Camera { size_px: [2400, 1600], focal_length_px, centre_px: [1199.5, 799.5], projection };
            let picture = "planet_ruler/iss073e0293986_aurora_night.jpg";
            let Some(answer) = earth("aurora", picture, &camera, &[]) else { return };
            assert_eq!(answer["status"], "not_found");
        }
    }
}

#[test]
fn skies_without_an_earth_are_answers_of_status_0() {
    for sky in ["tomcreusot/dark_frame.png", "cedar-solve/orion_belt.jpg", "cedar-solve/hale_bopp.jpg"] {
        let Some(path) = data(&format!("sky/{sky}")) else { return };
        let geometry = Picture::load(&path).unwrap().geometry();
        let camera = Camera {
            size_px: [geometry.width_px.into(), geometry.height_px.into()],
            focal_length_px: 4000.0,
            centre_px: [300.0, 300.0],
            projection: "rectilinear",
        };
        let answer = earth("skies", &format!("../sky/{sky}"), &camera, &[]).unwrap();
        assert_eq!(answer["status"], "not_found");
    }
}

#[test]
fn a_drawing_on_request_shows_limb_and_points() {
    let folder = scratch("drawing");
    let arguments = ["--pole", "0,-1,0", "--overlay", folder.to_str().unwrap()];
    if earth("drawing-camera", "pytroll/GOES16_ABI_C02_520.png", &GOES16, &arguments).is_none() {
        return;
    }
    let drawn = image::open(folder.join("GOES16_ABI_C02_520-earth.png")).unwrap().into_rgb8();
    assert_eq!(drawn.dimensions(), (520, 520));
    let of = |colour: [u8; 3]| drawn.pixels().filter(|pixel| pixel.0 == colour).count();
    // The limb goes once round, less what points cover; every point is a square.
    assert!(of([255, 220, 0]) > 1000 && of([60, 255, 60]) > 100);
}

#[test]
fn a_field_of_view_serves_as_its_camera_file_does() {
    let picture = "opssat/img_msec_1597559030639_2.png";
    let Some(expected) = earth("field-camera", picture, &OPS_SAT, &[]) else { return };
    let field_deg = 2.0 * (0.5 * 2048.0 / OPS_SAT.focal_length_px).atan().to_degrees();
    let path = data(&format!("earth/{picture}")).unwrap();
    let output = run(&["earth", path.to_str().unwrap(), "--fov-deg", &field_deg.to_string(), "--json"]);
    let found = &json_lines(&output)[0];
    assert_eq!(found["status"], "found");
    let apart = [0, 1].map(|k| number(&found["centre_px"][k]) - number(&expected["centre_px"][k]));
    assert!(apart[0].hypot(apart[1]) < 0.1, "{apart:?}");
}

#[test]
fn drawings_of_pictures_with_one_name_from_two_folders_are_two() {
    let (folder, camera) = (scratch("drawings"), GOES16.file(&scratch("drawings-camera")));
    let Some(picture) = data("earth/pytroll/GOES16_ABI_C02_520.png") else { return };
    let other = folder.join("elsewhere").join(picture.file_name().unwrap());
    std::fs::create_dir_all(other.parent().unwrap()).unwrap();
    std::fs::copy(&picture, &other).unwrap();
    let [picture, other, out] = [&picture, &other, &folder].map(|path| path.to_str().unwrap());
    assert!(run(&["earth", picture, other, "--camera", &camera, "--overlay", out]).status.success());
    let drawn = ["GOES16_ABI_C02_520-earth.png", "GOES16_ABI_C02_520-2-earth.png"];
    let [one, two] = drawn.map(|name| std::fs::read(folder.join(name)).unwrap());
    assert_eq!(one, two, "one picture, twice");
}

#[test]
fn bad_input_is_one_line_and_status_2_and_good_pictures_are_still_answered() {
    let folder = scratch("earth-bad");
    let camera = GOES16.file(&folder);
    refused(&["earth", "a.png"], &["--camera"]);
    refused(&["earth", "--camera", &camera], &["IMAGE"]);
    refused(&["earth", "a.png", "--camera", "no-such.toml"], &["no-such.toml"]);
    refused(&["earth", "no-such.png", "--camera", &camera], &["no-such.png", "check the path"]);
    for vector in ["1,2", "0,0,0", "a,b,c", "NaN,0,1", "1,2,3,4", ""] {
        refused(&["earth", "a.png", "--camera", &camera, "--pole", vector], &["--pole", "x,y,z"]);
        refused(&["earth", "a.png", "--camera", &camera, "--sun", vector], &["--sun", "x,y,z"]);
    }
    let text = folder.join("text.png");
    std::fs::write(&text, "no picture").unwrap();
    let text = text.to_str().unwrap();
    refused(&["earth", text, "--camera", &camera, "--json"], &["text.png", "format"]);
    refused(&["earth", text, "--camera", &camera, "--overlay", &format!("{text}/x")], &["text.png/x"]);
    let wrong = folder.join("wrong.toml");
    let good = std::fs::read_to_string(&camera).unwrap();
    std::fs::write(&wrong, good.replace("equiangular", "round")).unwrap();
    refused(&["earth", text, "--camera", wrong.to_str().unwrap()], &["wrong.toml:8", "projection"]);

    let Some(picture) = data("earth/pytroll/GOES16_ABI_C02_520.png") else { return };
    let picture = picture.to_str().unwrap();
    let answers = refused(&["earth", text, picture, "--camera", &camera, "--json"], &["text.png"]);
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0]["status"], "found");
    let other = METEOSAT.file(&folder);
    refused(&["earth", picture, "--camera", &other], &["520 x 520", "742 x 742"]);
}
