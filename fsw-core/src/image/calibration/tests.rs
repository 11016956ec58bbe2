use super::sample::{self, PX_PER_ENTRY, Tables, seal};
use super::*;
use proptest::prelude::*;
use std::vec::Vec;

fn refusal(bytes: &[u8]) -> CalibrationError {
    Calibration::open(bytes).map(|_| ()).unwrap_err()
}

/// A small calibration with some bytes changed and the checksum made right again.
fn with(offset: usize, changed: &[u8]) -> Vec<u8> {
    let mut bytes = sample::gaussian(1.0);
    bytes[offset..offset + changed.len()].copy_from_slice(changed);
    seal(&mut bytes);
    bytes
}

/// Tables of one quadrant every 50 px.
const QUADRANT: Tables = Tables { columns: 14, rows: 12, step_px: 50, first_px: None };

#[test]
fn the_worked_example_of_table_3_6_comes_out() {
    // The four tables about the example's star, at every phase, px / 1000 each; the thesis gives what is
    // between them.
    let bytes = sample::bytes(1.0, QUADRANT, |[column, row], _| {
        let [dx, dy]: [f32; 2] = match (column, row) {
            (7, 4) => [45.0, -29.0],
            (8, 4) => [55.0, -34.0],
            (7, 5) => [47.0, -30.0],
            (8, 5) => [53.0, -36.0],
            _ => [-60.0, 60.0],
        };
        [dx, dy].map(|thousandths| (thousandths * 1e-3 / PX_PER_ENTRY) as i8)
    });
    let calibration = Calibration::open(&bytes).unwrap();
    let [dx, dy] = calibration.correction_px([1000.36, 712.74]);
    assert!((dx - 0.051).abs() < 5e-4 && (dy + 0.032).abs() < 5e-4, "{dx} {dy}");
    let optical = [1000.36 + dx - 620.0, 712.74 + dy - 512.0];
    assert!((optical[0] - 380.411).abs() < 1e-3 && (optical[1] - 200.708).abs() < 1e-3, "{optical:?}");
}

#[test]
fn at_a_tenth_of_a_pixel_the_entry_of_that_phase_is_taken() {
    // The example's index 4, 7: entries tell their phase.
    let bytes = sample::bytes(1.0, QUADRANT, |_, [x, y]| [10 * x as i8, -10 * y as i8]);
    let calibration = Calibration::open(&bytes).unwrap();
    let [dx, dy] = calibration.correction_px([1000.4, 712.7]).map(|px| px / PX_PER_ENTRY);
    assert!((dx - 40.0).abs() < 0.1 && (dy + 70.0).abs() < 0.1, "{dx} {dy}");
    // Between two tenths it goes straight.
    let [dx, dy] = calibration.correction_px([1000.36, 712.74]).map(|px| px / PX_PER_ENTRY);
    assert!((dx - 36.0).abs() < 0.1 && (dy + 74.0).abs() < 0.1, "{dx} {dy}");
    // After the last tenth comes the first of the next pixel.
    let [dx, dy] = calibration.correction_px([1000.95, 712.98]).map(|px| px / PX_PER_ENTRY);
    assert!((dx - 45.0).abs() < 0.1 && (dy + 18.0).abs() < 0.1, "{dx} {dy}");
}

#[test]
fn one_quadrant_is_mirrored_by_sign_into_the_others() {
    // As far from the first phase as from the next pixel's, so that nothing jumps between two pixels.
    let apart = |phase: usize| phase.min(10 - phase) as i8;
    let bytes = sample::bytes(1.0, QUADRANT, |[column, row], [x, y]| {
        [2 * apart(x) + column as i8, 3 * apart(y) + 2 * row as i8]
    });
    let calibration = Calibration::open(&bytes).unwrap();
    for [x, y] in [[380.36f32, 200.74], [12.5, 0.25], [610.0, 499.9]] {
        let at = |sx: f32, sy: f32| calibration.correction_px([620.0 + sx * x, 512.0 + sy * y]);
        let [dx, dy] = at(1.0, 1.0);
        for (sx, sy) in [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            let [mirrored_x, mirrored_y] = at(sx, sy);
            assert!((mirrored_x - sx * dx).abs() < 1e-6 && (mirrored_y - sy * dy).abs() < 1e-6, "{x} {y}");
        }
    }
}

#[test]
fn tables_of_the_whole_detector_are_not_mirrored_and_go_straight_on_at_its_edge() {
    let tables = Tables { columns: 7, rows: 6, step_px: 200, first_px: Some([-600, -400]) };
    let bytes = sample::bytes(1.0, tables, |[column, row], _| [10 * column as i8, -10 * row as i8]);
    let calibration = Calibration::open(&bytes).unwrap();
    for (at, expected) in
        [([620.0, 512.0], [30.0, -20.0]), ([120.0, 112.0], [5.0, 0.0]), ([0.0, 12.0], [-1.0, 5.0])]
    {
        let [dx, dy] = calibration.correction_px(at).map(|px| px / PX_PER_ENTRY);
        assert!((dx - expected[0]).abs() < 0.01 && (dy - expected[1]).abs() < 0.01, "{at:?}: {dx} {dy}");
    }
}

#[test]
fn a_profile_is_the_light_it_was_made_of_and_its_slopes_are_its_own() {
    let bytes = sample::gaussian(0.9);
    let profile = Calibration::open(&bytes).unwrap().profile(300.0).unwrap();
    let light = |u: f32, v: f32| {
        let mut line = [[0.0; 3]; 2];
        profile.light_of_line([u - 0.5, v + 0.25], [0.5, -0.25], &mut line);
        line[1]
    };
    for k in 0..400 {
        let (u, v) = (-3.4 + 0.17 * (k % 40) as f32, -3.1 + 0.63 * (k / 40) as f32);
        let [light, along, across] = light(u, v);
        let exact = |u: f32, v: f32| sample::light(0.9, f64::from(u), f64::from(v));
        assert!((f64::from(light) - exact(u, v)).abs() < 3e-4, "{u} {v}");
        let slope = |du: f32, dv: f32| (exact(u + du, v + dv) - exact(u - du, v - dv)) / 2e-2;
        assert!((f64::from(along) - slope(1e-2, 0.0)).abs() < 2e-3, "{u} {v}");
        assert!((f64::from(across) - slope(0.0, 1e-2)).abs() < 2e-3, "{u} {v}");
    }
    for (u, v) in [(4.2, 0.0), (-4.2, 0.0), (0.0, 4.2), (0.0, -4.2), (1e9, -1e9)] {
        assert_eq!(light(u, v), [0.0; 3]);
    }
}

#[test]
fn damage_is_refused_by_its_name() {
    let good = sample::gaussian(1.0);
    let calibration = Calibration::open(&good).unwrap();
    assert_eq!((calibration.size_px(), calibration.centre_px()), ([1280, 1024], sample::CENTRE_PX));
    assert_eq!(calibration.source_crc(), 0xDEAD_BEEF);
    assert_eq!(refusal(b"SXTC"), CalibrationError::NotACalibration);
    assert_eq!(refusal(b"SXCC"), CalibrationError::Length);
    assert_eq!(refusal(&with(4, &[1, 0])), CalibrationError::Version(1));
    assert_eq!(refusal(&good[..good.len() - 1]), CalibrationError::Length);
    let mut flipped = good.clone();
    flipped[500] ^= 1;
    assert_eq!(refusal(&flipped), CalibrationError::Checksum);
    let wrong: [(usize, &[u8]); 9] = [
        (6, &[63, 0]),
        (20, &f32::NAN.to_le_bytes()),
        (28, &[0, 0]),
        (28, &[2, 0]),
        (30, &[0, 0]),
        (32, &[1, 0]),
        (36, &[0, 0]),
        (48, &0f32.to_le_bytes()),
        (64, &(-1f32).to_le_bytes()),
    ];
    for (offset, bytes) in wrong {
        assert_eq!(refusal(&with(offset, bytes)), CalibrationError::Structure, "{offset} {bytes:?}");
    }
}

proptest! {
    #[test]
    fn whatever_the_header_says_corrections_are_finite_or_it_is_refused(
        offset in 16usize..60, changed in prop::array::uniform4(any::<u8>()), x in any::<f32>(), y in any::<f32>(),
    ) {
        let bytes = with(offset, &changed);
        if let Ok(calibration) = Calibration::open(&bytes) {
            for at in [[x % 2000.0, y % 2000.0], [x, y]] {
                let correction = calibration.correction_px(at);
                prop_assert!(at.iter().any(|px| !px.is_finite()) || correction.iter().all(|px| px.abs() <= 5.0), "{correction:?}");
            }
            let _ = calibration.profile(x);
        }
    }
}
