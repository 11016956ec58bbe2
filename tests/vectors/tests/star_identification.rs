//! The worked example of star identification, thesis App. A.1.1: six measurements, one of them false, two
//! constellations.

use catalog_gen::{CatalogueStar, TableParameters, assemble};
use fsw_core::camera::{Camera, CameraParameters, Distortion, Projection};
use fsw_core::catalog::Catalogue;
use fsw_core::stars::identify::{IdentificationParameters, Identifier, Progress};
use fsw_core::stars::{MeasuredStar, StarField};
use serde_json::Value;
use std::collections::BTreeSet;

type ExampleIdentifier = Identifier<64, 256, 256>;
/// Measurement name and star number of each corner.
type Names = BTreeSet<(String, u32)>;

struct Example {
    labels: Vec<String>,
    measured: Vec<MeasuredStar>,
    catalogue: Vec<u8>,
    camera: Camera,
    expected: Vec<Names>,
}

fn vector(value: &Value) -> [f64; 3] {
    let numbers = [0, 1, 2].map(|index| value[index].as_f64().unwrap());
    // Printed with four decimals: not of unit length.
    let norm = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
    numbers.map(|x| x / norm)
}

fn example() -> Option<Example> {
    let path = system_tests::data("../vectors/star_id_example.json")?;
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let focal_length_px = file["focal_length_px"].as_f64().unwrap() as f32;
    let camera = Camera::new(CameraParameters {
        width_px: 1280,
        height_px: 1024,
        focal_length_px,
        optical_centre_px: [639.5, 511.5],
        projection: Projection::Rectilinear,
        distortion: Distortion::default(),
        corner_loss: 0.0,
        mirrored: false,
    })
    .unwrap();
    let (mut labels, mut measured) = (Vec::new(), Vec::new());
    for (label, value) in file["measurements"].as_object().unwrap() {
        let [x, y, z] = vector(value);
        let place = [x, y].map(|side| (side / z) as f32 * focal_length_px);
        let [cx, cy] = camera.parameters().optical_centre_px;
        labels.push(label.clone());
        measured.push(MeasuredStar::new(&camera, [place[0] + cx, place[1] + cy], 0.3).unwrap());
    }
    let stars: Vec<_> = file["catalogue"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(number, value)| CatalogueStar {
            direction: vector(value),
            hip: number.parse().unwrap(),
            v: 3.0,
            b_v: 0.0,
            proximity: false,
        })
        .collect();
    let tables =
        TableParameters { max_separation_deg: 12.0, epoch_year: 2000.0, field_deg: 21.0, source_crc: 0 };
    let expected = file["expected_polygons"].as_array().unwrap().iter().map(|polygon| {
        let corners =
            polygon["measurements"].as_array().unwrap().iter().zip(polygon["stars"].as_array().unwrap());
        corners.map(|(m, s)| (m.as_str().unwrap().to_owned(), s.as_u64().unwrap() as u32)).collect()
    });
    let expected = expected.collect();
    Some(Example { labels, measured, catalogue: assemble(&stars, &tables).unwrap(), camera, expected })
}

/// Searches to the end, or until the false-identification probability is below `10^log10_limit`.
fn search(example: &Example, log10_limit: f32) -> (Progress, Vec<Names>) {
    let catalogue = Catalogue::open(&example.catalogue).unwrap();
    let parameters =
        IdentificationParameters { log10_false_limit: log10_limit, ..IdentificationParameters::default() };
    let mut identifier = ExampleIdentifier::new();
    identifier.restart(0.0);
    let field = StarField::whole(&example.measured, &catalogue, &example.camera);
    let progress = identifier.advance(&field, &parameters, u32::MAX);
    let name = |corner: &(u8, u16)| {
        (example.labels[usize::from(corner.0)].clone(), catalogue.star(corner.1).unwrap().hip)
    };
    let polygons =
        identifier.polygons().iter().map(|polygon| polygon.corners.iter().map(name).collect()).collect();
    (progress, polygons)
}

#[test]
fn both_printed_polygons_are_found_and_the_larger_is_ranked_first() {
    let Some(example) = example() else { return };
    // A limit that nothing passes makes the search visit every side.
    let (_, polygons) = search(&example, -30.0);
    println!("{polygons:#?}");
    assert_eq!(example.expected.len(), 2);
    assert_eq!(polygons[0], example.expected[0], "the selected polygon comes first");
    assert!(polygons.contains(&example.expected[1]), "the other stays readable");
}

#[test]
fn the_larger_polygon_is_chosen_and_the_false_star_dropped() {
    let Some(example) = example() else { return };
    // Five stars of a catalogue of twelve are no evidence for one in a thousand million.
    let (progress, _) = search(&example, -6.0);
    let Progress::Identified(confirmed, log10_false) = progress else { panic!("not identified") };
    let catalogue = Catalogue::open(&example.catalogue).unwrap();
    let names: Names = confirmed
        .matches
        .iter()
        .map(|found| {
            (example.labels[usize::from(found.measured)].clone(), catalogue.star(found.star).unwrap().hip)
        })
        .collect();
    println!("false with 10^{log10_false:.1}");
    assert_eq!(names, example.expected[0]);
    assert!(names.iter().all(|(label, _)| label != "false"));
}
