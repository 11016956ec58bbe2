use super::*;
use crate::commands::centroids::{Sky, THESIS_PX};
use crate::flight::REFERENCE_CALIBRATION;
use crate::scenario::Scenario;
use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::detector::imaging::ImagingModel;
use crate::world::sky::stars::DetectorModel;

/// The default scenario's lens and detector: the reference.
fn reference() -> (Scenario, Lens) {
    let scenario = Scenario::default_embedded();
    let lens = Lens::new(&scenario.camera, &scenario.imaging, &scenario.detector).unwrap();
    (scenario, lens)
}

/// Root mean square error an axis of stars without noise of the table's colour over the detector, px.
fn error_px(lens: &Lens, calibration: Option<&Calibration>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 0..900 {
        let at = [40.0 + 41.37 * f64::from(k % 30), 40.0 + 32.61 * f64::from(k / 30)];
        if let Some(seen) = lens.measured(at, COLOUR, calibration) {
            sum += (0..2).map(|axis| (seen[axis] - at[axis]).powi(2)).sum::<f64>();
            count += 2.0;
        }
    }
    assert!(count > 1700.0, "{count}");
    (sum / count).sqrt()
}

#[test]
fn the_embedded_calibration_is_what_the_command_gives_and_small() {
    let (scenario, lens) = reference();
    let built = build(&lens, Grid::REFERENCE).unwrap();
    assert!(built == REFERENCE_CALIBRATION, "cameras/reference.corr is out of date: `sil-host corrections`");
    assert!(built.len() < 28 * 1024, "{} bytes", built.len());
    let flown = scenario.calibration().unwrap().unwrap();
    assert_eq!(flown.crc(), Calibration::open(REFERENCE_CALIBRATION).unwrap().crc());
}

#[test]
fn the_error_of_place_and_phase_is_below_a_hundredth_of_a_pixel() {
    let (_, lens) = reference();
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let (before, after) = (error_px(&lens, None), error_px(&lens, Some(&calibration)));
    println!("centre of intensity {before:.4} px, calibrated {after:.4} px");
    assert!(after < 0.008 && before > 0.05, "{before} {after}");
}

#[test]
fn pixels_that_are_an_l_break_the_mirror_images_of_one_quadrant() {
    let (_, lens) = reference();
    let error = |step_px, mirrored| {
        let bytes = build(&lens, Grid { step_px, mirrored }).unwrap();
        (error_px(&lens, Some(&Calibration::open(&bytes).unwrap())), bytes.len())
    };
    let (quadrant, quadrant_bytes) = error(50, true);
    let (whole, whole_bytes) = error(200, false);
    println!(
        "a quadrant every 50 px: {quadrant:.4} px, {quadrant_bytes} bytes; all every 200 px: {whole:.4}, {whole_bytes}"
    );
    assert!(quadrant > 2.0 * whole && whole_bytes < quadrant_bytes);
}

#[test]
fn centroids_reach_the_cramer_rao_bound_to_15_percent_and_a_twentieth_of_a_pixel_at_v_5() {
    let (scenario, lens) = reference();
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let sky = Sky {
        lens: &lens,
        detector: DetectorModel { pattern: PatternModel::NONE, ..scenario.detector },
        bits: scenario.camera.bits,
        size_px: [scenario.camera.width_px, scenario.camera.height_px],
        exposure_s: 0.9,
        stars: 800,
        seed: 3,
    };
    // 1600 errors: the scatter is known to 1.8 %, one sigma.
    for magnitude in [2.0, 3.0, 4.0, 5.0] {
        let line = sky.line(magnitude, &calibration);
        println!("{line:?}");
        assert!(line.after.scatter_px < 1.15 * line.bound_px, "{line:?}");
        assert!(line.after.scatter_px < 0.5 * THESIS_PX, "{line:?}");
        assert!(line.after.systematic_px < 0.01 && line.after.normalised_square < 1.15, "{line:?}");
        assert!(line.before.scatter_px > 2.0 * line.after.scatter_px && line.after.found > 0.97, "{line:?}");
    }
}

#[test]
fn a_lens_without_colours_or_with_round_stars_has_nothing_to_displace() {
    let camera = CameraFile::reference();
    let lens = Lens::new(&camera, &ImagingModel::PLAIN, &DetectorModel::default()).unwrap();
    let bytes = build(&lens, Grid::REFERENCE).unwrap();
    let calibration = Calibration::open(&bytes).unwrap();
    for at in [[100.0, 100.0], [900.0, 700.0]] {
        assert!(calibration.colour_shift_px(at, 1.5).iter().all(|px| px.abs() < 1e-3));
        assert!(calibration.correction_px(at).iter().all(|px| px.abs() < 2e-3));
    }
    assert_ne!(
        source_crc(&camera, &ImagingModel::PLAIN, &DetectorModel::default()),
        source_crc(&camera, &ImagingModel::REFERENCE, &DetectorModel::default())
    );
}

#[test]
fn what_has_no_axis_on_the_detector_is_refused() {
    let camera = CameraFile { optical_centre_px: [-200.0, 500.0], ..CameraFile::reference() };
    assert!(Lens::new(&camera, &ImagingModel::REFERENCE, &DetectorModel::reference()).is_err());
}
