use super::*;
use crate::camera::{CameraParameters, Distortion, Projection};
use crate::catalog::{Catalogue, sample};
use crate::command::{Command, CommandOutcome, Refusal};
use crate::image::calibration;
use crate::image::calibration::Calibration;
use crate::oracle::Generator;
use crate::sensor::Workspace;
use proptest::prelude::*;
use std::boxed::Box;
use std::vec::Vec;

fn catalogue() -> Vec<u8> {
    sample::bytes(&sample::sky(&mut Generator::new(1), 200), 20, 1 << 29)
}

fn parameters(calibration_crc: u32) -> Parameters {
    let mut parameters = Parameters::for_camera(CameraParameters {
        width_px: 1280,
        height_px: 1024,
        focal_length_px: 3000.0,
        optical_centre_px: calibration::sample::CENTRE_PX,
        projection: Projection::Rectilinear,
        distortion: Distortion::default(),
        mirrored: false,
    });
    parameters.imaging.calibration_crc = calibration_crc;
    parameters
}

/// Does something with a sensor that has a calibration and is in tracking.
fn with_sensor(test: impl FnOnce(&mut Sensor)) {
    let (catalogue, calibration) = (catalogue(), calibration::sample::gaussian(1.2));
    let calibration = Calibration::open(&calibration).unwrap();
    let mut workspace = Box::new(Workspace::new());
    let catalogue = Catalogue::open(&catalogue).unwrap();
    let sensor = Sensor::new(catalogue, parameters(calibration.crc()), &mut workspace).unwrap();
    let mut sensor = sensor.calibrated(calibration).unwrap();
    sensor.modes.enter(Mode::Tracking);
    test(&mut sensor);
}

fn scrubbed(sensor: &mut Sensor) -> Vec<Event> {
    let mut events = Events::default();
    sensor.scrub(&mut events);
    events.0.into_iter().collect()
}

/// Seconds of a pass over so many bytes.
fn seconds(bytes: &[u8]) -> usize {
    bytes.len() / SLICE_BYTES + 1
}

#[test]
fn tables_as_they_were_loaded_give_no_event() {
    with_sensor(|sensor| {
        for _ in 0..3 * (seconds(&catalogue()) + seconds(&calibration::sample::gaussian(1.2))) {
            assert!(scrubbed(sensor).is_empty());
        }
        assert_eq!(sensor.modes.mode(), Mode::Tracking);
    });
}

#[test]
fn a_parameter_that_was_changed_is_taken_from_the_copy_and_stars_are_acquired_anew() {
    with_sensor(|sensor| {
        let loaded = sensor.parameters;
        sensor.parameters.tracking.gate_px = 6;
        let back = [Event::ParametersRestored, Event::Mode(Mode::Acquisition, Guard::ParametersDamaged)];
        assert_eq!(scrubbed(sensor), back);
        assert_eq!((sensor.parameters, sensor.modes.mode()), (loaded, Mode::Acquisition));
        assert!(scrubbed(sensor).is_empty());
        // What was made of them.
        sensor.camera = Camera::new(CameraParameters { focal_length_px: 2999.0, ..loaded.camera }).unwrap();
        assert_eq!(scrubbed(sensor), back);
        assert_eq!(sensor.camera, loaded.check().unwrap().0);
        // The copy itself.
        sensor.spare.parameters.modes.healthy_s += 1;
        assert_eq!(scrubbed(sensor), back);
        assert_eq!((sensor.parameters, sensor.spare.parameters), (loaded, loaded));
    });
}

#[test]
fn modes_that_look_for_nothing_last_when_parameters_are_restored() {
    for mode in [Mode::SelfTest, Mode::Safe, Mode::CommandedSafe] {
        with_sensor(|sensor| {
            sensor.modes.enter(mode);
            sensor.parameters.tracking.gate_px = 6;
            assert_eq!(scrubbed(sensor)[0], Event::ParametersRestored);
            assert_eq!(sensor.modes.mode(), mode);
        });
    }
}

#[test]
fn parameters_that_are_lost_end_in_safe_mode_until_a_table_is_loaded() {
    with_sensor(|sensor| {
        let loaded = sensor.parameters;
        sensor.parameters.tracking.gate_px = 6;
        sensor.spare.parameters.tracking.gate_px = 7;
        let lost = [Event::ParametersLost, Event::Mode(Mode::CommandedSafe, Guard::ParametersDamaged)];
        for _ in 0..3 {
            assert_eq!(scrubbed(sensor), lost);
        }
        for command in [Command::Reacquire, Command::Restart, Command::Exposure(50_000)] {
            let outcome = sensor.obey(&command, &mut Events::default());
            assert_eq!(outcome, Some(CommandOutcome::Refused(Refusal::ParametersLost)));
        }
        assert_eq!(sensor.modes.mode(), Mode::CommandedSafe);
        let mut buffer = [0; MAX_TABLE_BYTES];
        let table = loaded.encode(&mut buffer).unwrap();
        let outcome = sensor.obey(&Command::LoadParameters(table), &mut Events::default());
        assert_eq!(outcome, Some(CommandOutcome::Done));
        assert!(scrubbed(sensor).is_empty());
        assert_eq!(sensor.parameters, loaded);
    });
}

#[test]
fn a_wrong_crc_of_catalogue_or_calibration_is_told_once_a_pass() {
    with_sensor(|sensor| {
        let passes = [seconds(&catalogue()), seconds(&calibration::sample::gaussian(1.2))];
        for (seconds, event) in passes.into_iter().zip([Event::CatalogueDamaged, Event::CalibrationDamaged]) {
            // As a damaged byte would.
            sensor.scrubber.crc.add(&[1]);
            let events: Vec<_> = (0..seconds).flat_map(|_| scrubbed(sensor)).collect();
            assert_eq!(events, [event]);
        }
        assert!((0..passes.iter().sum()).all(|_| scrubbed(sensor).is_empty()));
        assert_eq!(sensor.modes.mode(), Mode::Tracking);
    });
}

proptest! {
    #[test]
    fn any_flipped_bit_is_seen_at_the_end_of_the_pass(
        bytes in prop::collection::vec(any::<u8>(), 1..2000),
        place in any::<prop::sample::Index>(),
        bit in 0u8..8,
    ) {
        let crc = crate::checksum::crc32(&bytes);
        let pass = |bytes: &[u8]| {
            let mut scrubber = Scrubber::default();
            (0..=bytes.len() / SLICE_BYTES).find_map(|_| scrubber.pass((bytes, crc)))
        };
        let mut damaged = bytes.clone();
        damaged[place.index(bytes.len())] ^= 1u8 << bit;
        prop_assert_eq!((pass(&bytes), pass(&damaged)), (Some(true), Some(false)));
    }
}
