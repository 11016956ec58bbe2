use super::super::{EMBEDDED, Scenario};
use super::*;
use crate::flight;
use crate::world::lens::optics::Optics;
use std::path::Path;

/// The default scenario with this table.
fn with(table: &str) -> Result<Scenario, HostError> {
    Scenario::parse(Path::new("some.toml"), &format!("{}\n[believed]\n{table}\n", EMBEDDED[0].1))
}

#[test]
fn every_scenario_flies_with_the_differences_of_the_instrument_and_each_can_be_zero() {
    for (name, text) in EMBEDDED {
        let believed = Scenario::parse(Path::new(name), text).unwrap().believed;
        // The lens of the bad day is warmer still.
        let warmer = Believed { focal_length_ppm: -200.0, ..Believed::default() };
        let expected = if name == "bad-day" { warmer } else { Believed::default() };
        assert_eq!(believed, expected, "{name}");
    }
    assert_eq!(with("differences = false").unwrap().believed, Believed::TRUTH);
    let one = with("differences = false\nclock_offset_s = 0.5").unwrap().believed;
    assert_eq!(one, Believed { clock_offset_s: 0.5, ..Believed::TRUTH });
    let zero = with("mount_deg = [0, 0, 0]").unwrap().believed;
    assert_eq!(zero, Believed { mount_deg: [0.0; 3], ..Believed::default() });
    for wrong in ["clock_drift_ppm = 1e9", "mount_deg = [0, 99, 0]", "gain = 1", "optical_centre_px = [1.0]"]
    {
        assert!(with(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn the_flight_code_is_told_what_is_believed() {
    let told = with("").unwrap();
    let truth = with("differences = false").unwrap();
    let [told_parameters, true_parameters] = [&told, &truth].map(|scenario| scenario.flight_parameters(None));
    let (camera, known) = (told_parameters.camera, true_parameters.camera);
    let ratio = f64::from(camera.focal_length_px) / f64::from(known.focal_length_px);
    assert!((1e6 * (ratio - 1.0) + 50.0).abs() < 0.2, "{ratio}");
    assert!((camera.optical_centre_px[0] - known.optical_centre_px[0] - 0.05).abs() < 1e-4);
    let turned = f64::from(
        (0..4)
            .map(|k| told_parameters.mount.star_to_earth[k] * true_parameters.mount.star_to_earth[k])
            .sum::<f32>(),
    );
    // Twice the angle's half, in single precision.
    let deg = 2.0 * libm::acos(turned.clamp(-1.0, 1.0)).to_degrees();
    assert!((deg - libm::sqrt(17.0) * 1e-3).abs() < 0.02, "{deg}");
    let calibrations = [&told, &truth].map(|scenario| scenario.calibration().unwrap().unwrap());
    let [more, less] =
        calibrations.each_ref().map(|bytes| f64::from(bytes.open().unwrap().electrons_per_count()));
    assert!((more / less - 1.03).abs() < 1e-6);
    // What is stays what it is.
    assert_eq!((&told.camera, told.mount, told.detector), (&truth.camera, truth.mount, truth.detector));
}

#[test]
fn a_distortion_moves_the_farthest_corner_by_as_much_and_a_turn_the_earth_path() {
    let camera = CameraFile::reference();
    let told = Believed { distortion_px: 0.5, ..Believed::TRUTH }.camera(&camera);
    let [from, to] = [&camera, &told].map(|camera| Optics::new(camera).unwrap());
    let corner = from.unproject([0.0, 0.0]).unwrap();
    let [x, y] = to.project(corner).unwrap();
    assert!((libm::hypot(x, y) - 0.5).abs() < 1e-3 && x < 0.0 && y < 0.0, "{x} {y}");
    let mount = Mount { star_path_deg: [0.0, 90.0, 0.0] };
    let told = Believed { mount_deg: [0.0, 0.0, 0.3], ..Believed::TRUTH }.star_to_earth(&mount);
    let known = Believed::TRUTH.star_to_earth(&mount);
    let half = (0..4).map(|k| told[k] * known[k]).sum::<f64>();
    assert!((2.0 * libm::acos(half.abs()).to_degrees() - 0.3).abs() < 1e-6);
}

#[test]
fn clock_and_gyro_read_what_is_believed() {
    let believed = Believed { clock_offset_s: 0.25, clock_drift_ppm: 10.0, ..Believed::TRUTH };
    let clock = believed.clock(100_000_000, 5_000_000);
    assert_eq!(clock, Instant::new(LocalTime::from_us(100_001_000), 5_251_000));
    assert_eq!(Believed::TRUTH.clock(7, 9), Instant::new(LocalTime::from_us(7), 9));
    let gyro = GyroModel::default();
    let told = Believed { gyro_noise_percent: -20.0, ..Believed::TRUTH }.gyro(&gyro);
    assert!(
        (told.noise_deg_s / gyro.noise_deg_s - 0.8).abs() < 1e-12 && told.scale_error == gyro.scale_error
    );
    let read = Believed { gyro_scale_percent: 1.0, ..Believed::TRUTH }.gyro_reading([1.0, -2.0, 0.0]);
    assert_eq!(read, [1.01, -2.02, 0.0]);
}

#[test]
fn only_the_reference_camera_has_been_calibrated() {
    let reference = CameraFile::reference();
    let found = flight::calibrated_camera(&reference);
    let ppm = 1e6 * (found.focal_length_px / reference.focal_length_px - 1.0);
    // Lopsided stars move it by some 10 ppm; the laboratory's temperature is taken off.
    assert!(ppm != 0.0 && ppm.abs() < 20.0, "{ppm}");
    let other = CameraFile { focal_length_px: 2000.0, ..reference };
    assert_eq!(flight::calibrated_camera(&other), other);
}
