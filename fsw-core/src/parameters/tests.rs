use super::*;
use crate::oracle::reference_camera;
use std::string::String;
use std::vec::Vec;

/// Sets a number, or all numbers of an array.
trait Set {
    fn set(&mut self, value: f32);
}

impl Set for f32 {
    fn set(&mut self, value: f32) {
        *self = value;
    }
}

impl Set for u16 {
    fn set(&mut self, value: f32) {
        *self = value as u16;
    }
}

impl Set for u32 {
    fn set(&mut self, value: f32) {
        *self = value as u32;
    }
}

impl<const LENGTH: usize> Set for [f32; LENGTH] {
    fn set(&mut self, value: f32) {
        *self = [value; LENGTH];
    }
}

type Place = (&'static str, fn(&mut Parameters, f32));

macro_rules! places {
    ($($group:ident$(.$name:ident)+),* $(,)?) => {
        &[$((stringify!($group$(.$name)+), |p, value| p.$group$(.$name)+.set(value))),*]
    };
}

/// Every parameter that has a range, but those of the rate sensor.
const PLACES: &[Place] = places![
    imaging.exposure_us,
    imaging.row_time_ns,
    mount.star_to_earth,
    detection.threshold_sigma_tenths,
    detection.peak_to_region_percent,
    detection.peak_to_inner_percent,
    detection.inner_to_outer_percent,
    detection.inner_share_percent,
    detection.skirt_share_percent,
    detection.centroid_floor_millipx,
    identification.centroid_sigma_px,
    identification.scale_uncertainty,
    identification.log10_false_limit,
    identification.pairs_per_cycle,
    mount.boresight_sigma_px,
    tracking.gate_px,
    tracking.fewest_stars,
    tracking.carried_sigma_rad,
    tracking.manoeuvre_rad_s2,
    earth.ellipsoid.equatorial_km,
    earth.ellipsoid.polar_km,
    earth.limb.height_km,
    earth.limb.height_sigma_km,
    earth.limb.scale_height_km,
    earth.limb.scatter_km,
    earth.limb.cloud_share,
    earth.limb.ground_share,
    earth.limb.lommel_share,
    earth.limb.psf_sigma_px,
    earth.light.lit_deg,
    earth.light.usable_deg,
    earth.light.twilight_deg,
    earth.strips.contrast_share,
    earth.strips.dark_share,
    earth.strips.saturated_share,
    earth.strips.floor_px,
    earth.strips.tolerance_px,
    earth.strips.inlier_share,
    earth.search.step_px,
    earth.search.contrast_share,
    earth.search.dark_share,
    earth.search.run_px,
    earth.search.rise_px,
    earth.search.floor_px,
    earth.search.tolerance_px,
    earth.search.inlier_share,
    earth.fit.enough_share,
    earth.fit.fewest_points,
    earth.fit.least_arc_deg,
    earth.horizon.sigma_km,
    earth.horizon.cell_km,
    earth.horizon.sigma_px,
    earth.horizon.cloud_cell_km,
    earth.horizon.sunless_px,
    earth.plausible.sigma_deg,
    earth.plausible.told_deg,
    earth.plausible.told_points,
    earth.plausible.range_share,
    earth.plausible.distance_km,
    orbit.drag_m2_kg,
    orbit.radiation_m2_kg,
    orbit.height_sigma_km,
    orbit.height_sigma_rad,
    orbit.summer_sigma_km,
    orbit.tropics_km,
    orbit.tropics_sigma_km,
    orbit.field_sigma_km,
    orbit.field_length_km,
    orbit.edge_sigma_km,
    orbit.edge_sigma_rad,
    orbit.edge_patch_km,
    orbit.edge_patch_rad,
    orbit.edge_longest_s,
    orbit.edge_light_s,
    orbit.look_s,
    orbit.misalignment_sigma_rad,
    orbit.gravity_noise_km_s15,
    orbit.drag_noise_s05,
    orbit.force_noise_km_s15,
    orbit.gate_sigma,
    orbit.patience,
    orbit.settled_share,
    modes.patience_s,
    modes.dwell_s,
    modes.fault_patience_s,
    modes.settle_s,
    modes.acquisition_timeout_s,
    modes.outage_timeout_s,
    modes.healthy_s,
];

/// A fibre-optic gyro, where there was none.
fn gyro(parameters: &mut Parameters) -> &mut RateSensorNoise {
    parameters.rate_sensor.get_or_insert_default()
}

/// Shutters, where there were none.
fn shutter(parameters: &mut Parameters) -> &mut ShutterParameters {
    parameters.shutter.get_or_insert_default()
}

/// A magnetometer, where there was none.
fn magnetometer(parameters: &mut Parameters) -> &mut MagnetometerErrors {
    parameters.magnetometer.get_or_insert_default()
}

/// Of instruments that need not be on board.
const OPTIONAL_PLACES: &[Place] = &[
    // The gate's third, which is less than the range's end, has a test of its own.
    ("rate_sensor.walk_rad_s", |p, value| gyro(p).walk_rad_s = value),
    ("rate_sensor.bias_rad_s", |p, value| gyro(p).bias_rad_s = value),
    ("magnetometer.noise_ut", |p, value| magnetometer(p).noise_ut = value),
    ("magnetometer.zero_ut", |p, value| magnetometer(p).zero_ut = value),
    ("magnetometer.walk_ut", |p, value| magnetometer(p).walk_ut = value),
    ("magnetometer.field_ut", |p, value| magnetometer(p).field_ut = value),
    ("shutter.margin_rad", |p, value| shutter(p).margin_rad = value),
    ("shutter.look_s", |p, value| shutter(p).look_s = value as u16),
];

/// Values that cannot be set to an end of their range alone: a quaternion has unit length.
const ONLY_REFUSED: [&str; 1] = ["mount.star_to_earth"];

fn checked(change: impl Fn(&mut Parameters)) -> Result<(), ParameterError> {
    let mut parameters = Parameters::for_camera(reference_camera());
    change(&mut parameters);
    parameters.check().map(|_| ())
}

/// Name, bounds and whether it is an integer, of every row with a range.
fn bounds() -> Vec<(&'static str, f32, f32, bool)> {
    let bounds = [
        ImagingParameters::BOUNDS,
        MountParameters::BOUNDS,
        DetectionParameters::BOUNDS,
        IdentificationParameters::BOUNDS,
        TrackingParameters::BOUNDS,
        RateSensorNoise::BOUNDS,
        MagnetometerErrors::BOUNDS,
        ShutterParameters::BOUNDS,
        earth::Ellipsoid::BOUNDS,
        earth::LimbParameters::BOUNDS,
        earth::LightParameters::BOUNDS,
        earth::StripParameters::BOUNDS,
        earth::SearchParameters::BOUNDS,
        earth::FitParameters::BOUNDS,
        earth::HorizonParameters::BOUNDS,
        earth::PlausibleParameters::BOUNDS,
        OrbitParameters::BOUNDS,
        ModeParameters::BOUNDS,
    ];
    let rows = || GROUPS.into_iter().flatten();
    let integer = |name: &str| {
        let own = |row: &&Row| name == std::format!("{}.{}", row.group, row.name);
        rows().find(own).unwrap().kind.starts_with('u')
    };
    bounds.into_iter().flatten().map(|&(name, low, high)| (name, low, high, integer(name))).collect()
}

#[test]
fn the_defaults_pass_and_give_their_camera() {
    let parameters = Parameters::for_camera(reference_camera());
    assert_eq!(*parameters.check().unwrap().0.parameters(), reference_camera());
}

#[test]
fn an_exposure_that_leaves_no_time_for_the_readout_is_refused() {
    // 1024 rows of 100 us: 102.4 ms.
    let with = |us| checked(|p| (p.imaging.row_time_ns, p.imaging.exposure_us) = (100_000, us));
    assert_eq!((with(897_600), with(897_601)), (Ok(()), Err(ParameterError::ExposureBeyondSecond)));
}

#[test]
fn a_value_passes_to_the_ends_of_its_range_and_is_refused_by_name_beyond() {
    let places = || PLACES.iter().chain(OPTIONAL_PLACES);
    for (name, low, high, integer) in bounds() {
        if name == "rate_sensor.white_rad" {
            continue;
        }
        let (_, set) =
            places().find(|(place, _)| *place == name).unwrap_or_else(|| panic!("no place {name}"));
        let with = |p: &mut Parameters, value: f32| {
            set(p, value);
            // The two axes of the ellipsoid are tried as a sphere's.
            if name.starts_with("earth.ellipsoid") {
                let axis = if value.is_nan() { 6378.0 } else { value.clamp(100.0, 100_000.0) };
                p.earth.ellipsoid = earth::Ellipsoid { equatorial_km: axis, polar_km: axis };
                set(p, value);
            }
        };
        for good in [low, high] {
            if !ONLY_REFUSED.contains(&name) {
                assert_eq!(checked(|p| with(p, good)), Ok(()), "{name} = {good}");
            }
        }
        let beyond = if integer { [low - 1.0, high + 1.0] } else { [low.next_down(), high.next_up()] };
        let no_number = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        let no_number = if integer { &[][..] } else { &no_number };
        for bad in beyond.iter().chain(no_number).filter(|bad| !integer || **bad >= 0.0) {
            assert_eq!(checked(|p| with(p, *bad)), Err(ParameterError::Range(name)), "{name} = {bad}");
        }
    }
}

#[test]
fn one_bad_number_of_an_array_is_enough() {
    for place in 0..3 {
        let refused = checked(|p| p.identification.centroid_sigma_px[place] = f32::NAN);
        assert_eq!(refused, Err(ParameterError::Range("identification.centroid_sigma_px")));
    }
}

#[test]
fn axes_that_are_more_than_a_fifth_apart_are_refused() {
    let with = |share: f32| checked(|p| p.earth.ellipsoid.polar_km = share * p.earth.ellipsoid.equatorial_km);
    assert_eq!([with(0.81), with(1.19)], [Ok(()), Ok(())]);
    let refused = Err(ParameterError::Range("earth.ellipsoid.polar_km"));
    assert_eq!([with(0.79), with(1.21)], [refused, refused]);
}

#[test]
fn no_field_of_the_table_escapes_the_rows() {
    // Postcard writes a field after the other: those of the rows, and the camera's, which have their own
    // check. A real has four bytes, an integer of one byte and a choice one.
    let mut parameters = Parameters::for_camera(reference_camera());
    gyro(&mut parameters);
    magnetometer(&mut parameters);
    shutter(&mut parameters);
    for ((name, .., integer), (_, set)) in bounds().iter().filter_map(|bounds| {
        let place = PLACES.iter().find(|(place, _)| *place == bounds.0)?;
        Some((bounds, place))
    }) {
        assert!(!name.is_empty());
        if *integer {
            set(&mut parameters, 1.0);
        }
    }
    let bytes = postcard::to_slice(&parameters, &mut [0; MAX_TABLE_BYTES]).unwrap().len();
    let camera = postcard::to_slice(&reference_camera(), &mut [0; 256]).unwrap().len();
    let row = |row: &Row| match row.kind {
        "f32" => 4,
        "[f32; TOLERANCES]" => 3 * 4,
        "[f32; 4]" => 4 * 4,
        _ => 1,
    };
    let rows: usize = GROUPS.into_iter().flatten().map(row).sum();
    // That there are a rate sensor, a magnetometer and shutters.
    assert_eq!(bytes, camera + rows + 3);
}

#[test]
fn no_two_parameters_have_one_name_and_each_says_what_set_it() {
    let mut names = Vec::new();
    for row in GROUPS.into_iter().flatten() {
        let name = std::format!("{}.{}", row.group, row.name);
        assert!(!names.contains(&name), "{name} twice");
        assert!(!row.about.is_empty() && !row.source.is_empty(), "{name} has no words");
        names.push(name);
    }
}

#[test]
fn the_version_belongs_to_these_parameters() {
    // FNV-1a, which no other code of this table uses.
    let mut text = String::new();
    for Row { group, name, kind, default, range, .. } in GROUPS.into_iter().flatten() {
        text += &std::format!("{group}.{name}: {kind} = {default}, {range};\n");
    }
    let checksum =
        text.bytes().fold(0x811C_9DC5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    assert_eq!(
        checksum, CHECKSUM,
        "a parameter has changed: move parameters::VERSION, then set CHECKSUM to {checksum:#010X}"
    );
}

#[test]
fn an_impossible_camera_is_refused_first() {
    let refused = checked(|p| {
        p.camera.focal_length_px = f32::NAN;
        p.imaging.exposure_us = 0;
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
    gyro(&mut parameters);
    for ((.., integer), (_, set)) in
        bounds().iter().filter_map(|row| Some((row, PLACES.iter().find(|(place, _)| *place == row.0)?)))
    {
        if *integer {
            set(&mut parameters, u32::MAX as f32);
        }
    }
    parameters.imaging.calibration_crc = u32::MAX;
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
    let refused = Err(ParameterError::Range("mount.star_to_earth"));
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

#[test]
fn another_body_brings_ellipsoid_limb_and_forces_along() {
    for body in CentralBody::ALL {
        let parameters = Parameters::for_camera(reference_camera()).about(body);
        parameters.check().unwrap();
        let (facts, ellipsoid) = (body.facts(), parameters.earth.ellipsoid);
        // The Earth's defaults are those of its row.
        assert_eq!(ellipsoid.equatorial_km, facts.radius_km as f32);
        assert_eq!(ellipsoid.polar_km, facts.polar_km as f32);
        assert_eq!(parameters.orbit.body, body);
        assert_eq!(parameters.orbit.drag_m2_kg > 0.0, facts.air);
        let mut buffer = [0; MAX_TABLE_BYTES];
        let packet = parameters.encode(&mut buffer).unwrap();
        assert_eq!(Parameters::decode(packet).unwrap(), parameters);
    }
    let unchanged = Parameters::for_camera(reference_camera());
    assert_eq!(unchanged.about(CentralBody::Earth), unchanged);
}

#[test]
fn what_the_body_has_not_is_refused_by_name() {
    for body in [CentralBody::Moon, CentralBody::Mars] {
        let mut parameters = Parameters::for_camera(reference_camera()).about(body);
        parameters.orbit.drag_m2_kg = 0.01;
        assert_eq!(parameters.check().err(), Some(ParameterError::NotOfBody("orbit.drag_m2_kg")));
        // The body alone leaves the Earth's ellipsoid behind.
        let refused = checked(|p| (p.orbit.body, p.orbit.drag_m2_kg) = (body, 0.0));
        assert_eq!(refused, Err(ParameterError::NotOfBody("earth.ellipsoid.equatorial_km")));
    }
    // Pictures of other bodies are taken with their ellipsoid and without an orbit.
    let sphere = earth::Ellipsoid { equatorial_km: 1737.4, polar_km: 1737.4 };
    assert_eq!(checked(|p| p.earth.ellipsoid = sphere), Ok(()));
}
