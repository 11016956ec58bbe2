use super::centroid::{COLOUR, Lens};
use super::pictures::{Laboratory, SkyPicture};
use super::*;
use crate::commands::centroids::{Sky, THESIS_PX};
use crate::flight::{self, REFERENCE_CALIBRATION};
use crate::formats::camera_file::REFERENCE_CALIBRATED;
use crate::scenario::Scenario;
use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::detector::imaging::ImagingModel;
use crate::world::noise::{Noise, Stream};
use crate::world::sky;
use crate::world::sky::stars::DetectorModel;
use fsw_core::checksum::crc32;

/// The default scenario's lens and detector: the reference.
fn reference() -> (Scenario, Lens) {
    let scenario = Scenario::default_embedded();
    let lens = Lens::new(&scenario.camera, &scenario.imaging, &scenario.detector).unwrap();
    (scenario, lens)
}

/// The reference camera as the world has it and as it was calibrated.
fn optics() -> [Optics; 2] {
    let camera = CameraFile::reference();
    [&camera, &flight::calibrated_camera(&camera)].map(|camera| Optics::new(camera).unwrap())
}

/// Root mean square error an axis of stars without noise over the detector against where the calibrated
/// camera has them, px.
fn error_px(lens: &Lens, b_v: f64, calibration: Option<&Calibration>) -> f64 {
    let [world, calibrated] = optics();
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 0..900 {
        let at = [40.0 + 41.37 * f64::from(k % 30), 40.0 + 32.61 * f64::from(k / 30)];
        let wanted = calibrated.project(world.unproject(at).unwrap()).unwrap();
        if let Some(seen) = lens.measured(at, b_v, calibration) {
            let shift = calibration
                .map_or([0.0; 2], |known| known.colour_shift_px(at.map(|px| px as f32), b_v as f32));
            sum +=
                (0..2).map(|axis| (seen[axis] - f64::from(shift[axis]) - wanted[axis]).powi(2)).sum::<f64>();
            count += 2.0;
        }
    }
    assert!(count > 1700.0, "{count}");
    (sum / count).sqrt()
}

#[test]
fn the_embedded_camera_and_calibration_are_of_the_pictures_that_the_command_renders() {
    let head = REFERENCE_CALIBRATED.lines().next().unwrap();
    let (_, crc) = head.split_once("CRC-32 of the first ").expect(head);
    let start = CameraFile::reference();
    let (camera, imaging) = pictures::cooler(&start, &ImagingModel::REFERENCE, pictures::WARMER_K);
    let stars = sky::in_year(catalog_gen::parameters::DEFAULT_EPOCH_YEAR);
    let detector = DetectorModel::reference();
    let mut laboratory = Laboratory::new((&camera, &imaging), &detector, &stars, pictures::SEED).unwrap();
    let SkyPicture { picture, .. } = laboratory.picture(0).unwrap();
    let bytes: Vec<u8> = picture.pixels().iter().flat_map(|value| value.to_le_bytes()).collect();
    let found = format!("{:08x}", crc32(&bytes));
    assert!(crc.starts_with(&found), "the pictures are others now ({found}): {head}");
    // The calibration was made for the camera beside it, and flies.
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let calibrated = CameraFile { correction_table: None, ..CameraFile::reference_calibrated() };
    assert_eq!(calibration.source_crc(), crc32(calibrated.to_toml().as_bytes()));
    assert!(REFERENCE_CALIBRATION.len() < 28 * 1024, "{} bytes", REFERENCE_CALIBRATION.len());
    let flown = Scenario::default_embedded().calibration().unwrap().unwrap();
    assert_eq!(flown.open().unwrap().crc(), calibration.crc());
}

#[test]
fn the_error_of_place_and_phase_is_a_hundredth_of_a_pixel_and_not_more_than_stated() {
    let (_, lens) = reference();
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let stated = f64::from(calibration.residual_px());
    let before = error_px(&lens, COLOUR, None);
    for b_v in [0.0, COLOUR, 1.4] {
        let after = error_px(&lens, b_v, Some(&calibration));
        println!(
            "B-V {b_v}: centre of intensity {before:.4} px, calibrated {after:.4} px, stated {stated:.4}"
        );
        assert!(after < 0.01 && after < stated && before > 0.05, "{before} {after}");
    }
}

#[test]
fn centroids_reach_the_cramer_rao_bound_to_15_percent_and_a_twentieth_of_a_pixel_at_v_5() {
    let (scenario, lens) = reference();
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let [world, calibrated] = optics();
    let sky = Sky {
        lens: &lens,
        optics: [&world, &calibrated],
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
    let camera = CameraFile { focal_length_px: 2990.0, ..CameraFile::reference() };
    let made =
        flight::calibration(&camera, &ImagingModel::PLAIN, &DetectorModel::default()).unwrap().unwrap();
    let calibration = made.open().unwrap();
    for at in [[100.0, 100.0], [900.0, 700.0]] {
        // 4,000 stars leave this much noise in their corrections.
        assert!(calibration.colour_shift_px(at, 1.5).iter().all(|px| px.abs() < 2e-3));
        assert!(calibration.correction_px(at).iter().all(|px| px.abs() < 0.03));
    }
}

#[test]
fn a_gain_moves_the_electrons_of_a_count_and_nothing_else() {
    let twice = with_gain(REFERENCE_CALIBRATION, 2.0);
    let [one, two] = [REFERENCE_CALIBRATION, &twice].map(|bytes| Calibration::open(bytes).unwrap());
    assert_eq!(two.electrons_per_count(), 2.0 * one.electrons_per_count());
    assert_eq!(two.correction_px([300.3, 700.8]), one.correction_px([300.3, 700.8]));
    assert!(with_gain(&twice, 0.5) == REFERENCE_CALIBRATION);
}

#[test]
fn what_the_fit_leaves_beyond_the_noise_is_found() {
    // Errors of 0.02 px beside a noise of 0.01 to 0.06 px that is stated 1.4 times too large.
    let noise = Noise::new(1, 0, Stream::Centroid);
    let squares: Vec<(f64, f64)> = (0..20_000)
        .map(|k| {
            let sigma = 0.01 + 0.05 * noise.uniform(k, 0);
            let miss = sigma.hypot(0.02) * noise.gaussian(k, 1);
            (2.0 * sigma * sigma, miss * miss)
        })
        .collect();
    let residual = beyond_noise_px(&squares);
    assert!((residual - 0.02).abs() < 0.002, "{residual}");
}

#[test]
fn too_few_stars_and_what_has_no_axis_on_the_detector_are_refused() {
    let camera = CameraFile { optical_centre_px: [-200.0, 500.0], ..CameraFile::reference() };
    assert!(Lens::new(&camera, &ImagingModel::REFERENCE, &DetectorModel::reference()).is_err());
    assert!(Layout::new(&camera, 40_000.0).is_err());
    assert!(Layout::new(&CameraFile::reference(), f64::NAN).is_err());
    let refused = build(Vec::new(), Vec::new(), &CameraFile::reference(), (16, 40_000.0));
    assert!(refused.unwrap_err().to_string().contains("0 stars do not give star profiles"));
}
