use super::*;
use crate::world::noise::{Noise, Stream};

const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 320, height_px: 240, bits: 12 };

/// Dark pictures of Gaussian noise of 3 DN about 100, each row and picture with a level of its own, changed
/// by `change` (value, picture, column, row).
fn frames(count: u64, change: impl Fn(f64, u64, u16, u16) -> f64) -> Vec<Vec<u16>> {
    let frame = |picture: u64| {
        let (pixel, row) = (Noise::new(1, picture, Stream::Read), Noise::new(1, picture, Stream::Row));
        let places = (0..GEOMETRY.height_px).flat_map(|y| (0..GEOMETRY.width_px).map(move |x| (x, y)));
        let value = |(x, y): (u16, u16)| {
            let noise =
                3.0 * pixel.quick_gaussian(x.into(), y.into()) + 2.0 * row.quick_gaussian(0, y.into());
            change(100.0 + picture as f64 + noise, picture, x, y).round().clamp(0.0, 4095.0) as u16
        };
        places.map(value).collect()
    };
    (0..count).map(frame).collect()
}

fn found(frames: &[Vec<u16>]) -> Option<Survey> {
    survey(&frames.iter().map(Vec::as_slice).collect::<Vec<_>>(), GEOMETRY)
}

#[test]
fn a_sound_detector_has_no_defects_and_the_noise_is_known() {
    for count in [5, 6, 8] {
        let survey = found(&frames(count, |value, _, _, _| value)).unwrap();
        println!("{count} pictures: noise {:.3} DN, {:?}", survey.noise_dn, survey.bad);
        // Seven false ones in a million are half a pixel here.
        assert!(survey.bad.len() <= 1 && survey.offsets.is_empty());
        assert!(survey.bad.iter().all(|(_, kind)| *kind == Kind::Flickering));
        assert!((survey.noise_dn / 3.0 - 1.0).abs() < 0.03, "{}", survey.noise_dn);
    }
}

#[test]
fn hot_dead_and_flickering_pixels_and_columns_are_found_and_hits_are_not() {
    let frames = frames(9, |value, picture, x, y| match (x, y) {
        (40, 10) => value + 30.0,
        (41, 10) => 4095.0,
        (0, 0) => 0.0,
        (319, 239) => value - 25.0,
        // Telegraph noise in a third of the pictures, hits in one.
        (200, 100) if picture % 3 == 0 => value + 60.0,
        (201, 100) if picture == 4 => 3000.0,
        (100..103, 200..203) if picture == 2 => 2000.0,
        // A block of four, and a column that is off by 6.
        (60..62, 60..62) => value + 200.0,
        (150, _) => value + 6.0,
        (151, _) => value - 9.4,
        (280, _) => value + 900.0,
        _ => value,
    });
    let survey = found(&frames).unwrap();
    let of =
        |kind| survey.bad.iter().filter(move |(_, is)| *is == kind).map(|(at, _)| *at).collect::<Vec<_>>();
    let mut hot: Vec<[u16; 2]> = (0..240).map(|y| [280, y]).collect();
    hot.extend([[40, 10], [41, 10], [60, 60], [61, 60], [60, 61], [61, 61]]);
    hot.sort_by_key(|[x, y]| (*y, *x));
    assert_eq!(of(Kind::Hot), hot);
    assert_eq!(of(Kind::Dead), [[0, 0], [319, 239]]);
    assert_eq!(of(Kind::Flickering), [[200, 100]]);
    assert_eq!(survey.offsets, [(150, 6), (151, -9)]);
    assert!(survey.bad.is_sorted_by_key(|([x, y], _)| (*y, *x)));
}

#[test]
fn pictures_of_less_noise_than_a_number_show_no_false_defects() {
    // Numbers that flip between two values, and a glow towards a corner.
    let frames = frames(5, |value, _, x, y| {
        let glow = f64::from(x) * f64::from(y) / 2000.0;
        100.3 + (value - 100.0) * 0.05 + glow
    });
    let survey = found(&frames).unwrap();
    assert_eq!((survey.bad.len(), survey.offsets.len()), (0, 0), "{survey:?}");
}

#[test]
fn what_is_not_dark_is_refused() {
    let frames = frames(4, |value, _, x, y| if (x / 3 + y / 3) % 3 == 0 { value + 500.0 } else { value });
    assert_eq!(found(&frames), None);
}

#[test]
fn medians_means_and_chi_squares() {
    assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
    assert_eq!(median(&mut [4.0, 1.0, 2.0, 9.0]), 3.0);
    let mut values: Vec<f64> = (0..19).map(f64::from).collect();
    values.extend([1e6, -1e6]);
    assert_eq!(mean_of_most(&mut values), 9.0);
    // Chi-square of 8 degrees of freedom: median 7.344, 97.72 % (2 sigmas) 17.80.
    assert!((8.0 * chi_square_ratio(8.0, 0.0) - 7.344).abs() < 0.01);
    assert!((8.0 * chi_square_ratio(8.0, 2.0) - 17.80).abs() < 0.1);
}
