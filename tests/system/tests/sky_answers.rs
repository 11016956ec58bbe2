//! What `sil-host solve` gives beside its line, a drawing and a FITS header with world coordinates; the
//! formats that it reads; and pictures of unknown optics.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use system_tests::{amount, data, direction, json_lines, refused, run, scratch, separation_arcsec};

/// A picture and its field, degrees.
const PICTURES: [(&str, &str); 4] = [
    ("cedar-solve/orion_belt.jpg", "10.153"),
    ("cedar-solve/hale_bopp.jpg", "15.4535"),
    ("esa-tetra3/2019-07-29T204726_Alt60_Azi45_Try1.tiff", "11.4255"),
    ("tomcreusot/16mm_checker_2/Nunki/nunki_700000e_11.3g.png", "14.2421"),
];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// The answer for a picture, with these arguments besides.
fn solve(picture: &Path, arguments: &[&str]) -> Value {
    let all = [&["solve", picture.to_str().unwrap(), "--json"], arguments].concat();
    let output = run(&all);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    json_lines(&output).remove(0)
}

/// Keywords of a FITS header and their values as text.
fn keywords(header: &[u8]) -> BTreeMap<String, String> {
    assert_eq!(header.len() % 2880, 0);
    let cards = header.chunks_exact(80).map(|card| std::str::from_utf8(card).unwrap());
    let of = |card: &str| {
        let value = card.get(8..10).filter(|mark| *mark == "= ").and(card.get(10..))?;
        let value = value.split('/').next().unwrap().trim().trim_matches('\'').trim().to_owned();
        Some((card[..8].trim().to_owned(), value))
    };
    cards.filter_map(of).collect()
}

/// The gnomonic projection of a header, read as any FITS reader does: the ICRS direction of a pixel, the
/// first one (0, 0).
fn sky_by_header(header: &BTreeMap<String, String>, [x, y]: [f64; 2]) -> [f64; 3] {
    let get = |key: &str| header[key].parse::<f64>().unwrap();
    let (dx, dy) = (x + 1.0 - get("CRPIX1"), y + 1.0 - get("CRPIX2"));
    let xi = (get("CD1_1") * dx + get("CD1_2") * dy).to_radians();
    let eta = (get("CD2_1") * dx + get("CD2_2") * dy).to_radians();
    let (ra, dec) = (get("CRVAL1").to_radians(), get("CRVAL2").to_radians());
    let east = [-ra.sin(), ra.cos(), 0.0];
    let north = [-dec.sin() * ra.cos(), -dec.sin() * ra.sin(), dec.cos()];
    let sight = [dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin()];
    let seen = [0, 1, 2].map(|k| sight[k] + xi * east[k] + eta * north[k]);
    let length = seen.iter().map(|part| part * part).sum::<f64>().sqrt();
    seen.map(|part| part / length)
}

/// The ICRS direction of a pixel by the answer's quaternion and field.
fn sky_by_answer(answer: &Value, [width, height]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 3] {
    let focal_length = 0.5 * width / (0.5 * number(&answer["fov_deg"]).to_radians()).tan();
    let seen = [(x - 0.5 * (width - 1.0)) / focal_length, (y - 0.5 * (height - 1.0)) / focal_length, 1.0];
    let length = seen.iter().map(|part| part * part).sum::<f64>().sqrt();
    let [a, b, c] = seen.map(|part| part / length);
    let [x, y, z, w] = [0, 1, 2, 3].map(|k| number(&answer["q"][k]));
    // The inverse of A(q) = (w² - |v|²) I + 2 v vᵀ - 2 w [v×].
    let (dot, d) = (x * a + y * b + z * c, w * w - x * x - y * y - z * z);
    let cross = [y * c - z * b, z * a - x * c, x * b - y * a];
    let square = x * x + y * y + z * z + w * w;
    let of = |k: usize| (d * [a, b, c][k] + 2.0 * dot * [x, y, z][k] + 2.0 * w * cross[k]) / square;
    [of(0), of(1), of(2)]
}

#[test]
fn the_header_puts_middle_corners_and_stars_where_the_solution_does() {
    let folder = scratch("headers");
    let stars = catalog_gen::source::stars();
    for (picture, fov_deg) in PICTURES {
        let Some(path) = data(&format!("sky/{picture}")) else { return };
        let answer = solve(&path, &["--fov-deg", fov_deg, "--wcs", folder.to_str().unwrap()]);
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let header = keywords(&std::fs::read(folder.join(format!("{stem}.wcs"))).unwrap());
        assert_eq!((header["CTYPE1"].as_str(), header["CTYPE2"].as_str()), ("RA---TAN", "DEC--TAN"));
        let size = ["IMAGEW", "IMAGEH"].map(|key| header[key].parse::<f64>().unwrap());
        let [right, low] = size.map(|side| side - 1.0);
        let middle = sky_by_header(&header, [0.5 * right, 0.5 * low]);
        let [ra_deg, dec_deg] = ["ra_deg", "dec_deg"].map(|key| number(&answer[key]));
        let off_deg = separation_arcsec(middle, direction(ra_deg, dec_deg)) / 3600.0;
        assert!(off_deg < 1e-6, "{picture}: {off_deg} deg");
        let corners = [[0.0, 0.0], [right, 0.0], [0.0, low], [right, low]];
        let off = |at| separation_arcsec(sky_by_header(&header, at), sky_by_answer(&answer, size, at));
        let worst = corners.map(off).into_iter().fold(0.0, f64::max);
        let found = answer["stars"].as_array().unwrap();
        let (mut squares, mut residuals) = (0.0, 0.0);
        for star in found {
            let seen = sky_by_header(&header, ["x", "y"].map(|key| number(&star[key])));
            let known = stars.iter().find(|known| u64::from(known.hip) == star["hip"]).unwrap();
            let miss = separation_arcsec(seen, known.direction_at(2026.5));
            // The catalogue on board is rounded.
            assert!(miss < number(&star["residual_arcsec"]) + 3.0, "{picture}: {star} {miss}");
            squares += miss * miss;
            residuals += number(&star["residual_arcsec"]).powi(2);
        }
        println!(
            "{picture}: middle {:.1e} deg, corners {worst:.3} arcsec, {} stars rms {:.2} arcsec, the fit's {:.2}",
            off_deg,
            found.len(),
            (squares / found.len() as f64).sqrt(),
            (residuals / found.len() as f64).sqrt()
        );
        assert!(worst < 0.1);
    }
}

#[test]
fn drawings_show_named_and_other_spots_residuals_and_the_grid() {
    let folder = scratch("sky-drawings");
    let out = folder.to_str().unwrap();
    for (picture, fov_deg) in PICTURES {
        let Some(path) = data(&format!("sky/{picture}")) else { return };
        let answer = solve(&path, &["--fov-deg", fov_deg, "--overlay", out]);
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let drawn = image::open(folder.join(format!("{stem}-sky.png"))).unwrap().into_rgb8();
        assert!(drawn.width() >= 1000);
        let of = |colour: [u8; 3]| drawn.pixels().filter(|pixel| pixel.0 == colour).count();
        let named = answer["stars"].as_array().unwrap().len();
        let spots = answer["spots"].as_array().unwrap().len();
        println!("{picture}: {named} of {spots} spots drawn with names");
        assert!(of([60, 255, 60]) > 30 * named, "named");
        assert!(of([255, 60, 60]) > 10 * (spots - named), "others");
        assert!(of([255, 220, 0]) > 100 && of([70, 120, 200]) > 2000, "residuals, grid");
    }
    let Some(dark) = data("sky/tomcreusot/dark_frame.png") else { return };
    let answer = solve(&dark, &["--fov-deg", "14.2", "--overlay", out, "--wcs", out]);
    assert_eq!(answer["status"], "not_identified");
    assert!(folder.join("dark_frame-sky.png").exists() && !folder.join("dark_frame.wcs").exists());
}

#[test]
fn pictures_of_one_name_from_two_folders_get_files_of_their_own() {
    let folder = scratch("sky-names");
    let Some(picture) = data("sky/cedar-solve/orion_belt.jpg") else { return };
    let other = folder.join("elsewhere/orion_belt.jpg");
    std::fs::create_dir_all(other.parent().unwrap()).unwrap();
    std::fs::copy(&picture, &other).unwrap();
    let [picture, other, out] = [&picture, &other, &folder].map(|path| path.to_str().unwrap());
    let output = run(&["solve", picture, other, "--fov-deg", "10.1", "--overlay", out, "--wcs", out]);
    assert!(output.status.success());
    let same = |one: &str, two: &str| {
        assert_eq!(std::fs::read(folder.join(one)).unwrap(), std::fs::read(folder.join(two)).unwrap());
    };
    same("orion_belt-sky.png", "orion_belt-2-sky.png");
    same("orion_belt.wcs", "orion_belt-2.wcs");
    let file = folder.join("file");
    std::fs::write(&file, "").unwrap();
    let inside = file.join("x");
    for option in ["--overlay", "--wcs"] {
        refused(&["solve", picture, "--fov-deg", "10.1", option, inside.to_str().unwrap()], &["file/x"]);
    }
}

/// Where the middle of the picture looks.
fn middle(answer: &Value) -> [f64; 3] {
    direction(number(&answer["ra_deg"]), number(&answer["dec_deg"]))
}

#[test]
fn a_picture_is_the_same_sky_in_every_format() {
    let folder = scratch("formats");
    let Some(picture) = data("sky/tomcreusot/16mm_checker_2/Nunki/nunki_700000e_11.3g.png") else { return };
    let expected = solve(&picture, &["--fov-deg", "14.24"]);
    assert_eq!(expected["status"], "identified");
    let grey = image::open(&picture).unwrap().into_luma8();
    for name in ["nunki.bmp", "nunki.pgm", "nunki.tif"] {
        let path: PathBuf = folder.join(name);
        grey.save(&path).unwrap();
        let answer = solve(&path, &["--fov-deg", "14.24"]);
        // Grey in a BMP is a palette and becomes 16 bits, whose scaled counts are rounded otherwise: 0.02 px.
        let apart = separation_arcsec(middle(&answer), middle(&expected));
        assert!(apart < 2.5, "{name}: {apart} arcsec");
    }
}

#[test]
fn pictures_of_unknown_optics_are_identified_upright_and_mirrored_and_never_wrongly() {
    let Some(truth) = data("sky/truth.json") else { return };
    let folder = scratch("blind");
    let truth: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    let mut identified = [0; 2];
    for picture in &truth {
        let image = picture["image"].as_str().unwrap();
        let upright = data(&format!("sky/{image}")).unwrap();
        let flipped = folder.join("flipped.png");
        image::open(&upright).unwrap().fliph().save(&flipped).unwrap();
        for (mirrored, path) in [(false, &upright), (true, &flipped)] {
            let answer = solve(path, &[]);
            if answer["status"] != "identified" {
                println!("{image}: not identified, mirrored: {mirrored} ({})", answer["reason"]);
                continue;
            }
            let of_truth = direction(number(&picture["RA_deg"]), number(&picture["Dec_deg"]));
            let error = separation_arcsec(middle(&answer), of_truth);
            let field_error = number(&answer["fov_deg"]) / number(&picture["FOV_h_deg"]) - 1.0;
            let ms = number(&answer["ms"]["identify"]);
            println!(
                "{image}: {error:.1} arcsec from the truth, field {:+.2} %, false with {:.0e}, {ms:.0} ms",
                100.0 * field_error,
                number(&answer["false_id_probability"])
            );
            assert_eq!(answer["mirrored"], mirrored);
            assert!(error < 60.0 + number(&picture["max_dev_from_consensus_arcsec"]), "{image}");
            assert!(field_error.abs() < 0.002 && number(&answer["false_id_probability"]) <= 1e-9);
            identified[usize::from(mirrored)] += 1;
        }
    }
    println!("{identified:?} of {} identified, upright and mirrored", truth.len());
    assert!(identified.iter().all(|count| *count >= 12));
}

/// A picture of so many round spots at random places, their brightness falling as that of stars does.
fn random_spots(seed: u64, count: u32) -> image::GrayImage {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (width, height) = (1024, 768);
    let mut sky: Vec<f64> = (0..width * height).map(|_| 10.0 + 4.0 * random()).collect();
    for rank in 1..=count {
        let (x, y) = (20.0 + 984.0 * random(), 20.0 + 728.0 * random());
        let peak = 40.0 + 200.0 / f64::from(rank);
        for (row, column) in (-6..=6).flat_map(|row| (-6..=6).map(move |column| (row, column))) {
            let (px, py) = (x.round() + f64::from(column), y.round() + f64::from(row));
            let square = (px - x).powi(2) + (py - y).powi(2);
            sky[py as usize * width + px as usize] += peak * (-square / (2.0 * 1.3f64.powi(2))).exp();
        }
    }
    let value = |x: u32, y: u32| image::Luma([sky[y as usize * width + x as usize].min(255.0) as u8]);
    image::GrayImage::from_fn(width as u32, height as u32, value)
}

#[test]
fn spots_at_random_places_are_no_sky_of_any_field() {
    let folder = scratch("random");
    for seed in 1..=amount(4, 200) {
        let path = folder.join("random.png");
        random_spots(seed, [8, 20, 40, 80][seed as usize % 4]).save(&path).unwrap();
        let answer = solve(&path, &[]);
        assert_eq!(answer["status"], "not_identified", "seed {seed}: {answer}");
        let reason = answer["reason"].as_str().unwrap();
        assert!(reason.contains("no field of 5 to 40 deg"), "{reason}");
    }
}

#[test]
fn a_table_has_a_row_for_each_picture_that_was_read() {
    let folder = scratch("table");
    let (Some(sky), Some(dark)) =
        (data("sky/cedar-solve/orion_belt.jpg"), data("sky/tomcreusot/dark_frame.png"))
    else {
        return;
    };
    let [sky, dark, table] =
        [&sky, &dark, &folder.join("t.csv")].map(|path| path.to_str().unwrap().to_owned());
    let arguments = ["solve", &sky, "no-such.png", &dark, "--fov-deg", "10.1", "--json", "--csv", &table];
    let answers = refused(&arguments, &["no-such.png"]);
    let text = std::fs::read_to_string(&table).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3, "{text}");
    assert_eq!(rows[0][..4], ["image", "status", "reason", "ra_deg"]);
    assert_eq!((rows[1][1], rows[2][1]), ("identified", "not_identified"));
    assert_eq!(rows[1][3].parse::<f64>().unwrap(), number(&answers[0]["ra_deg"]));
    assert!(rows[2][3].is_empty() && rows.iter().all(|row| row.len() == rows[0].len()));
    refused(&["solve", &sky, "--fov-deg", "10.1", "--json", "--csv", "no/such/t.csv"], &["no/such/t.csv"]);
}

#[test]
fn a_wrong_field_is_told_what_was_tried() {
    let Some(path) = data("sky/cedar-solve/orion_belt.jpg") else { return };
    let output = run(&["solve", path.to_str().unwrap(), "--fov-deg", "12"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && text.contains("not identified") && text.contains("without it"),
        "{text}"
    );
}
