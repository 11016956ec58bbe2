use super::table::{Bounds, Field, Parameter};
use super::*;
use crate::oracle::reference_camera;
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

/// A gyro, where there was none.
fn gyro(parameters: &mut Parameters) -> &mut RateSensorNoise {
    parameters.rate_sensor.get_or_insert_default()
}

/// A value with its row and its bounds.
type Place<'a> = (&'static Row, Bounds, Field<'a>);

/// Every value but the camera's, with all instruments on board.
fn places(parameters: &mut Parameters) -> Vec<Place<'_>> {
    macro_rules! places {
        ($($Group:ty: $group:expr;)*) => {{
            let mut all: Vec<Place<'_>> = Vec::new();
            $({
                let group: &mut $Group = $group;
                let fields = group.fields(Box::leak(Box::new(group.numbers())));
                let known = <$Group>::ROWS.iter().zip(<$Group>::BOUNDS);
                all.extend(known.zip(fields).map(|((row, bounds), field)| (row, *bounds, field)));
            })*
            all
        }};
    }
    let Parameters { imaging, mount, detection, identification, tracking, earth, orbit, modes, .. } =
        parameters;
    places! {
        ImagingParameters: imaging;
        MountParameters: mount;
        DetectionParameters: detection;
        IdentificationParameters: identification;
        TrackingParameters: tracking;
        RateSensorNoise: parameters.rate_sensor.get_or_insert_default();
        MagnetometerErrors: parameters.magnetometer.get_or_insert_default();
        ShutterParameters: parameters.shutter.get_or_insert_default();
        earth::Ellipsoid: &mut earth.ellipsoid;
        earth::LimbParameters: &mut earth.limb;
        earth::LightParameters: &mut earth.light;
        earth::StripParameters: &mut earth.strips;
        earth::SearchParameters: &mut earth.search;
        earth::FitParameters: &mut earth.fit;
        earth::HorizonParameters: &mut earth.horizon;
        earth::PlausibleParameters: &mut earth.plausible;
        OrbitParameters: orbit;
        ModeParameters: modes;
    }
}

/// Sets a number, or all numbers of an array.
fn set(field: &mut Field<'_>, to: f32) {
    match field {
        Field::Single(value) => **value = to,
        Field::Singles(values) => values.fill(to),
        Field::Short(value) => **value = to as u16,
        Field::Long(value) => **value = to as u32,
        Field::Choice(_) => {}
    }
}

fn is_integer(row: &Row) -> bool {
    row.kind.starts_with('u')
}

/// Values that cannot be set to an end of their range alone: a quaternion has unit length.
const ONLY_REFUSED: [&str; 1] = ["mount.star_to_earth"];

fn checked(change: impl Fn(&mut Parameters)) -> Result<(), ParameterError> {
    let mut parameters = Parameters::for_camera(reference_camera());
    change(&mut parameters);
    parameters.check().map(|_| ())
}

/// Its numbers; of a choice its number.
fn numbers(field: &Field<'_>) -> Vec<f32> {
    match field {
        Field::Single(value) => std::vec![**value],
        Field::Singles(values) => values.to_vec(),
        Field::Short(value) => std::vec![f32::from(**value)],
        Field::Long(value) => std::vec![**value as f32],
        Field::Choice(value) => std::vec![f32::from(**value)],
    }
}

#[test]
fn every_parameter_is_set_by_its_name_and_takes_no_value_of_another_kind() {
    let mut parameters = Parameters::for_camera(reference_camera());
    for index in 0..places(&mut parameters).len() {
        let (row, (_, low, _), field) = places(&mut parameters).swap_remove(index);
        let is_whole = is_integer(row) || matches!(field, Field::Choice(_));
        let value = if row.range.starts_with("one of") { 1.0 } else { low };
        let values = std::vec![value; numbers(&field).len()];
        assert!(parameters.set(row.group, row.name, &values), "{row:?}");
        let refused = [&[][..], &[value; 9], &[0.5], &[-1.0], &[f32::NAN], &[1e9]];
        for refused in refused.into_iter().take(if is_whole { 6 } else { 2 }) {
            assert!(!parameters.set(row.group, row.name, refused), "{row:?} {refused:?}");
        }
        assert_eq!(numbers(&places(&mut parameters)[index].2), values, "{row:?}");
    }
    assert!(!parameters.set("tracking", "gate", &[5.0]) && !parameters.set("track", "gate_px", &[5.0]));
    assert!(!Parameters::for_camera(reference_camera()).set("rate_sensor", "white_rad", &[1e-5]));
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
    let defaults = Parameters::for_camera(reference_camera());
    for (place, (row, (name, low, high), _)) in places(&mut { defaults }).into_iter().enumerate() {
        assert_eq!(name, std::format!("{}.{}", row.group, row.name));
        // The gate's third, which is less than the range's end, has a test of its own.
        if low == f32::MIN || name == "rate_sensor.white_rad" {
            continue;
        }
        let checked = |value: f32| {
            let mut parameters = defaults;
            // The two axes of the ellipsoid are tried as a sphere's.
            if name.starts_with("earth.ellipsoid") {
                let axis = if value.is_nan() { 6378.0 } else { value.clamp(100.0, 100_000.0) };
                parameters.earth.ellipsoid = earth::Ellipsoid { equatorial_km: axis, polar_km: axis };
            }
            set(&mut places(&mut parameters)[place].2, value);
            parameters.check().map(|_| ())
        };
        for good in [low, high] {
            if !ONLY_REFUSED.contains(&name) {
                assert_eq!(checked(good), Ok(()), "{name} = {good}");
            }
        }
        let integer = is_integer(row);
        let beyond = if integer { [low - 1.0, high + 1.0] } else { [low.next_down(), high.next_up()] };
        let no_number = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        let no_number = if integer { &[][..] } else { &no_number };
        for bad in beyond.iter().chain(no_number).filter(|bad| !integer || **bad >= 0.0) {
            assert_eq!(checked(*bad), Err(ParameterError::Range(name)), "{name} = {bad}");
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
    let rows = places(&mut parameters).into_iter().map(|(_, _, mut field)| {
        set(&mut field, 1.0);
        match field {
            Field::Single(_) => 4,
            Field::Singles(values) => 4 * values.len(),
            Field::Short(_) | Field::Long(_) | Field::Choice(_) => 1,
        }
    });
    let rows: usize = rows.sum();
    let bytes = postcard::to_slice(&parameters, &mut [0; MAX_TABLE_BYTES]).unwrap().len();
    let camera = postcard::to_slice(&reference_camera(), &mut [0; 256]).unwrap().len();
    // That there are a rate sensor, a magnetometer and shutters.
    assert_eq!(bytes, camera + rows + 3);
    assert_eq!(places(&mut parameters).len(), GROUPS.into_iter().flatten().count());
}

#[test]
fn a_choice_without_a_name_is_refused() {
    let mut body = CentralBody::Earth;
    assert!((0..3).all(|number| body.choose(number) && body.number() == number));
    assert!(!body.choose(3) && body == CentralBody::Mars);
    // Every choice has as many numbers as names.
    let mut parameters = Parameters::for_camera(reference_camera());
    let names = |row: &Row| row.choices().unwrap().count();
    let choices = places(&mut parameters).into_iter().filter(|(.., field)| matches!(field, Field::Choice(_)));
    let names: Vec<usize> = choices.map(|(row, ..)| names(row)).collect();
    fn numbers<T: Parameter>(mut of: T) -> usize {
        (0..=u8::MAX).take_while(|number| of.choose(*number)).count()
    }
    let OrbitParameters { body, observation, dynamics, misalignment, .. } = parameters.orbit;
    let ShutterParameters { paths, filter, .. } = ShutterParameters::default();
    let orbit = [numbers(body), numbers(observation), numbers(dynamics), numbers(misalignment)];
    assert_eq!(names, [&[numbers(paths), numbers(filter)][..], &orbit].concat());
    // In a packet: the body's number is the only byte by which these two differ before the checksum.
    let earth = Parameters::for_camera(reference_camera());
    let moon = Parameters { orbit: OrbitParameters { body: CentralBody::Moon, ..earth.orbit }, ..earth };
    let mut buffer = [0; MAX_TABLE_BYTES];
    let moon = moon.encode(&mut buffer).unwrap().to_vec();
    let length = earth.encode(&mut buffer).unwrap().len();
    let place = moon.iter().zip(&buffer).position(|(one, other)| one != other).unwrap();
    buffer[place] = CentralBody::ALL.len() as u8;
    let crc = crate::checksum::crc32(&buffer[..length - 4]);
    buffer[length - 4..length].copy_from_slice(&crc.to_le_bytes());
    assert_eq!(Parameters::decode(&buffer[..length]), Err(PacketError::Content));
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
    for (_, _, mut field) in places(&mut parameters).into_iter().filter(|(row, ..)| is_integer(row)) {
        set(&mut field, u32::MAX as f32);
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
