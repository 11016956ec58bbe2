use super::*;
use crate::earth::Ellipsoid;
use crate::oracle::reference_camera;

type Integer = (&'static str, fn(&mut Parameters, u32), u32, u32);
type Real = (&'static str, fn(&mut Parameters) -> &mut f32, f32, f32);

/// Name, setter and documented range of every integer.
const INTEGERS: &[Integer] = &[
    ("exposure_us", |p, v| p.exposure_us = v, 100, 1_000_000),
    ("row_time_ns", |p, v| p.row_time_ns = v, 0, 500_000),
    ("pairs_per_cycle", |p, v| p.pairs_per_cycle = v, 10_000, 4_000_000),
    ("threshold_sigma_tenths", |p, v| p.detection.threshold_sigma_tenths = v as u16, 30, 200),
    ("peak_to_region_percent", |p, v| p.detection.peak_to_region_percent = v as u16, 100, 1000),
    ("peak_to_inner_percent", |p, v| p.detection.peak_to_inner_percent = v as u16, 100, 1000),
    ("inner_to_outer_percent", |p, v| p.detection.inner_to_outer_percent = v as u16, 100, 1000),
    ("inner_share_percent", |p, v| p.detection.inner_share_percent = v as u16, 0, 100),
    ("skirt_share_percent", |p, v| p.detection.skirt_share_percent = v as u16, 1, 50),
    ("centroid_floor_millipx", |p, v| p.detection.centroid_floor_millipx = v as u16, 1, 1000),
    ("gate_px", |p, v| p.tracking.gate_px = v as u16, 3, 24),
    ("fewest_stars", |p, v| p.tracking.fewest_stars = v as u16, 3, 16),
    ("patience_s", |p, v| p.modes.patience_s = v as u16, 1, 60),
    ("fault_patience_s", |p, v| p.modes.fault_patience_s = v as u16, 1, 600),
    ("settle_s", |p, v| p.modes.settle_s = v as u16, 1, 60),
    ("acquisition_timeout_s", |p, v| p.modes.acquisition_timeout_s = v as u16, 5, 10_000),
    ("outage_timeout_s", |p, v| p.modes.outage_timeout_s = v as u16, 10, 60_000),
    ("pause_s", |p, v| p.modes.pause_s = v as u16, 1, 10_000),
    ("patience", |p, v| p.orbit.patience = v as u16, 1, 600),
];

/// A fibre-optic gyro, where there was none.
fn gyro(parameters: &mut Parameters) -> &mut RateSensorNoise {
    let noise = RateSensorNoise { white_rad: 1e-5, walk_rad_s: 1e-7, bias_rad_s: 1e-4 };
    parameters.rate_sensor.get_or_insert(noise)
}

/// Of the default ellipsoid.
const EQUATORIAL_KM: f32 = Ellipsoid::WGS84.equatorial_km;

/// Name, place and range of every real.
const REALS: &[Real] = &[
    ("carried_sigma_rad", |p| &mut p.tracking.carried_sigma_rad, 1e-4, 0.1),
    ("rate_sensor.walk_rad_s", |p| &mut gyro(p).walk_rad_s, 0.0, 1e-3),
    ("rate_sensor.bias_rad_s", |p| &mut gyro(p).bias_rad_s, 1e-8, 0.1),
    ("centroid_sigma_px[0]", |p| &mut p.identification.centroid_sigma_px[0], 0.05, 3.0),
    ("centroid_sigma_px[1]", |p| &mut p.identification.centroid_sigma_px[1], 0.05, 3.0),
    ("centroid_sigma_px[2]", |p| &mut p.identification.centroid_sigma_px[2], 0.05, 3.0),
    ("scale_uncertainty", |p| &mut p.identification.scale_uncertainty, 0.0, 0.01),
    ("log10_false_limit", |p| &mut p.identification.log10_false_limit, -30.0, -2.0),
    ("equatorial_km", |p| &mut p.earth.ellipsoid.equatorial_km, 100.0, 100_000.0),
    ("polar_km", |p| &mut p.earth.ellipsoid.polar_km, 0.8 * EQUATORIAL_KM, 1.2 * EQUATORIAL_KM),
    ("limb_height_km", |p| &mut p.earth.limb_height_km, 0.0, 60.0),
    ("scale_height_km", |p| &mut p.earth.scale_height_km, 0.5, 50.0),
    ("psf_sigma_px", |p| &mut p.earth.psf_sigma_px, 0.2, 5.0),
    ("lit_sun_elevation_deg", |p| &mut p.earth.lit_sun_elevation_deg, 0.0, 45.0),
    ("least_sun_elevation_deg", |p| &mut p.earth.least_sun_elevation_deg, 0.0, 45.0),
    ("twilight_deg", |p| &mut p.earth.twilight_deg, 0.0, 18.0),
    ("least_contrast_share", |p| &mut p.earth.least_contrast_share, 0.005, 0.5),
    ("greatest_dark_share", |p| &mut p.earth.greatest_dark_share, 0.01, 0.5),
    ("saturated_share", |p| &mut p.earth.saturated_share, 0.5, 1.0),
    ("limb_floor_px", |p| &mut p.earth.limb_floor_px, 0.005, 2.0),
    ("limb_scatter_km", |p| &mut p.earth.limb_scatter_km, 0.0, 10.0),
    ("limb_lommel_share", |p| &mut p.earth.limb_lommel_share, 0.0, 1.0),
    ("limb_height_sigma_km", |p| &mut p.earth.limb_height_sigma_km, 0.0, 20.0),
    ("horizon_sigma_px", |p| &mut p.earth.horizon_sigma_px, 0.0, 5.0),
    ("horizon_sigma_km", |p| &mut p.earth.horizon_sigma_km, 0.0, 20.0),
    ("horizon_cell_km", |p| &mut p.earth.horizon_cell_km, 50.0, 10_000.0),
    ("limb_cloud_share", |p| &mut p.earth.limb_cloud_share, 0.0, 1.0),
    ("search_step_px", |p| &mut p.earth.search_step_px, 4.0, 64.0),
    ("search_contrast_share", |p| &mut p.earth.search_contrast_share, 0.01, 0.5),
    ("search_dark_share", |p| &mut p.earth.search_dark_share, 0.01, 0.5),
    ("search_run_px", |p| &mut p.earth.search_run_px, 4.0, 64.0),
    ("search_rise_px", |p| &mut p.earth.search_rise_px, 4.0, 250.0),
    ("search_floor_px", |p| &mut p.earth.search_floor_px, 0.01, 5.0),
    ("search_tolerance_px", |p| &mut p.earth.search_tolerance_px, 0.2, 20.0),
    ("tracking_tolerance_px", |p| &mut p.earth.tracking_tolerance_px, 0.2, 20.0),
    ("enough_share", |p| &mut p.earth.enough_share, 0.5, 1.0),
    ("search_share", |p| &mut p.earth.search_share, 0.2, 1.0),
    ("strip_share", |p| &mut p.earth.strip_share, 0.2, 1.0),
    ("fewest_points", |p| &mut p.earth.fewest_points, 4.0, 40.0),
    ("least_arc_deg", |p| &mut p.earth.least_arc_deg, 1.0, 180.0),
    ("greatest_sigma_deg", |p| &mut p.earth.greatest_sigma_deg, 0.001, 10.0),
    ("greatest_range_share", |p| &mut p.earth.greatest_range_share, 0.001, 1.0),
    ("greatest_distance_km", |p| &mut p.earth.greatest_distance_km, 1e4, 1e9),
    ("start_speed_share", |p| &mut p.orbit.start_speed_share, 0.1, 3.0),
    ("limb_height_sigma_rad", |p| &mut p.orbit.limb_height_sigma_rad, 0.0, 0.01),
    ("limb_height_sigma_km", |p| &mut p.orbit.limb_height_sigma_km, 0.0, 100.0),
    ("limb_height_time_share", |p| &mut p.orbit.limb_height_time_share, 0.001, 100.0),
    ("misalignment_sigma_rad", |p| &mut p.orbit.misalignment_sigma_rad, 0.0, 0.02),
    ("bias_over_noise", |p| &mut p.orbit.bias_over_noise, 0.0, 30.0),
    ("bias_time_share", |p| &mut p.orbit.bias_time_share, 0.001, 10.0),
    ("gravity_noise_km_s15", |p| &mut p.orbit.gravity_noise_km_s15, 0.0, 1e-3),
    ("force_noise_km_s15", |p| &mut p.orbit.force_noise_km_s15, 0.0, 1e-3),
    ("gate_nis", |p| &mut p.orbit.gate_nis, 10.0, 1000.0),
    ("settled_share", |p| &mut p.orbit.settled_share, 1e-6, 0.1),
];

/// Values without a range: two choices of a byte each, and the mount's quaternion, whose length is checked.
const CHOICES: usize = 2;
const QUATERNION: usize = 4 * 4;

fn checked(change: impl Fn(&mut Parameters)) -> Result<(), ParameterError> {
    let mut parameters = Parameters::for_camera(reference_camera());
    change(&mut parameters);
    parameters.check().map(|_| ())
}

#[test]
fn the_defaults_pass_and_give_their_camera() {
    let parameters = Parameters::for_camera(reference_camera());
    assert_eq!(*parameters.check().unwrap().0.parameters(), reference_camera());
}

#[test]
fn an_exposure_that_leaves_no_time_for_the_readout_is_refused() {
    // 1024 rows of 100 us: 102.4 ms.
    let with = |exposure_us| checked(|p| (p.row_time_ns, p.exposure_us) = (100_000, exposure_us));
    assert_eq!((with(897_600), with(897_601)), (Ok(()), Err(ParameterError::ExposureBeyondSecond)));
}

#[test]
fn an_integer_passes_to_the_ends_of_its_range_and_is_refused_by_name_beyond() {
    for &(name, set, low, high) in INTEGERS {
        for good in [low, high] {
            assert_eq!(checked(|p| set(p, good)), Ok(()), "{name} = {good}");
        }
        for bad in low.checked_sub(1).into_iter().chain([high + 1]) {
            assert_eq!(checked(|p| set(p, bad)), Err(ParameterError::Range(name)), "{name} = {bad}");
        }
    }
}

#[test]
fn a_real_passes_to_the_ends_of_its_range_and_is_refused_by_name_beyond_or_without_a_value() {
    for &(name, place, low, high) in REALS {
        // The polar axis is held against the equatorial one, which is tried as a sphere's.
        let with = |p: &mut Parameters, value: f32| {
            *place(p) = value;
            if name == "equatorial_km" {
                p.earth.ellipsoid.polar_km = value;
            }
        };
        for good in [low, high] {
            assert_eq!(checked(|p| with(p, good)), Ok(()), "{name} = {good}");
        }
        for bad in [low.next_down(), high.next_up(), f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(checked(|p| with(p, bad)), Err(ParameterError::Range(name)), "{name} = {bad}");
        }
    }
}

#[test]
fn no_field_of_the_table_escapes_the_check() {
    // Postcard writes a field after the other: as many values as are checked here, those of the camera, whose own
    // door they pass, and none beside.
    let mut bytes = [0; 512];
    let with = |change: &dyn Fn(&mut Parameters), bytes: &mut [u8]| {
        let mut parameters = Parameters::for_camera(reference_camera());
        // One byte each for the smallest integers, four for the reals.
        INTEGERS.iter().for_each(|(_, set, ..)| set(&mut parameters, 1));
        change(&mut parameters);
        postcard::to_slice(&parameters, bytes).unwrap().len()
    };
    let camera = postcard::to_slice(&reference_camera(), &mut [0; 256]).unwrap().len();
    // Any name of a calibration may be right; none, 0, is one byte.
    let calibration_crc = 1;
    // That there is a rate sensor, and its noise, which has a test of its own.
    let rate_sensor = 1 + 4;
    let checked = QUATERNION + CHOICES + calibration_crc + rate_sensor + INTEGERS.len() + 4 * REALS.len();
    let length = with(
        &|parameters| {
            gyro(parameters);
        },
        &mut bytes,
    );
    assert_eq!(length, camera + checked);
}

#[test]
fn an_impossible_camera_is_refused_first() {
    let refused = checked(|p| {
        p.camera.focal_length_px = f32::NAN;
        p.exposure_us = 0;
    });
    assert_eq!(refused, Err(ParameterError::Camera(CameraError::NotFinite)));
}

#[test]
fn a_table_comes_back_from_its_packet() {
    let parameters = Parameters::for_camera(reference_camera());
    let mut buffer = [0; MAX_TABLE_BYTES];
    assert_eq!(Parameters::decode(parameters.encode(&mut buffer).unwrap()), Ok(parameters));
}

#[test]
fn the_longest_table_fits_its_buffer() {
    let mut parameters = Parameters::for_camera(reference_camera());
    INTEGERS.iter().for_each(|(_, set, ..)| set(&mut parameters, u32::MAX));
    (parameters.camera.width_px, parameters.camera.height_px) = (u16::MAX, u16::MAX);
    let mut buffer = [0; MAX_TABLE_BYTES];
    let packet = parameters.encode(&mut buffer).unwrap();
    std::println!("longest table: {} bytes", packet.len());
    assert_eq!(Parameters::decode(packet), Ok(parameters));
}

#[test]
fn a_damaged_table_is_refused() {
    let mut buffer = [0; MAX_TABLE_BYTES];
    let length = Parameters::for_camera(reference_camera()).encode(&mut buffer).unwrap().len();
    for place in 0..length {
        let mut packet = buffer;
        packet[place] ^= 0x10;
        assert_eq!(Parameters::decode(&packet[..length]), Err(PacketError::Checksum), "byte {place}");
    }
}

#[test]
fn a_mount_that_is_no_rotation_is_refused() {
    let refused = Err(ParameterError::Range("star_to_earth"));
    for quaternion in [[0.0; 4], [0.5, 0.5, 0.5, 0.6], [f32::NAN, 0.0, 0.0, 1.0], [f32::MAX; 4]] {
        assert_eq!(checked(|p| p.mount.star_to_earth = quaternion), refused, "{quaternion:?}");
    }
    assert_eq!(checked(|p| p.mount.star_to_earth = [0.5, -0.5, 0.5, -0.5]), Ok(()));
}

#[test]
fn a_rate_sensor_that_loses_the_stars_windows_is_refused() {
    let mut parameters = Parameters::for_camera(reference_camera());
    gyro(&mut parameters);
    assert!(parameters.check().is_ok());
    // Thesis tab. A.13: a car's.
    for white_rad in [0.22_f32.to_radians(), 0.0, f32::NAN] {
        gyro(&mut parameters).white_rad = white_rad;
        assert_eq!(parameters.check().unwrap_err(), ParameterError::Range("rate_sensor.white_rad"));
    }
}
