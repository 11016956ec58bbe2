use super::*;
use crate::attitude::filter::Filter;
use crate::camera::{CameraParameters, Distortion, Projection};
use crate::catalog::{Catalogue, sample};
use crate::command::{Command, CommandOutcome, Refusal};
use crate::frames::Icrs;
use crate::image::calibration;
use crate::image::calibration::Calibration;
use crate::oracle::Generator;
use crate::orbit::OrbitState;
use crate::sensor::Workspace;
use fsw_hal::LocalTime;
use nalgebra::{Matrix3, Vector3};
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
        corner_loss: 0.0,
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
    sensor.seal(None);
    test(&mut sensor);
}

/// A second in which no orbit is told.
fn scrubbed(sensor: &mut Sensor) -> Vec<Event> {
    let mut events = Events::default();
    sensor.scrub(&mut events);
    sensor.seal(None);
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
fn a_parameter_that_was_changed_is_taken_from_the_copy_and_tracking_goes_on() {
    with_sensor(|sensor| {
        let loaded = sensor.parameters;
        sensor.parameters.tracking.gate_px = 6;
        let back = [Event::ParametersRestored];
        assert_eq!(scrubbed(sensor), back);
        assert_eq!((sensor.parameters, sensor.modes.mode()), (loaded, Mode::Tracking));
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
            sensor.seal(None);
            sensor.parameters.tracking.gate_px = 6;
            assert_eq!(scrubbed(sensor)[0], Event::ParametersRestored);
            assert_eq!(sensor.modes.mode(), mode);
        });
    }
}

fn unturned() -> Rotation<Icrs, StarPath> {
    Rotation::from_orthogonal(Matrix3::identity())
}

/// A filter of the attitude turned by so much about z, rad.
fn attitude(angle_rad: f32) -> Filter {
    Filter::new(unturned().turned(&Vector3::z().scale(angle_rad)), [1e-5; 3], LocalTime::from_us(7))
}

#[test]
fn a_damaged_mode_is_entered_anew_and_a_damaged_correlation_is_no_step_of_the_clock() {
    with_sensor(|sensor| {
        sensor.modes.enter(Mode::CommandedSafe);
        assert_eq!(scrubbed(sensor), [Event::Mode(Mode::Tracking, Guard::MemoryDamaged)]);
        let second = |timekeeper: &mut Timekeeper, us: i64, ahead_us: i64| {
            let terrestrial_us = 800_000_000_000_000 + us + ahead_us;
            let clock = &mut fsw_hal::Instant::new(LocalTime::from_us(us), terrestrial_us);
            let now = timekeeper.read_counter(clock);
            timekeeper.times(clock, &now, None).step_us
        };
        // Another bit of its correlation: 0.26 s.
        let mut damaged = sensor.timekeeper;
        assert_eq!(second(&mut damaged, 5_000_000, 1 << 18), None);
        assert_eq!(second(&mut damaged.clone(), 6_000_000, 0), Some(-(1 << 18)));
        assert_eq!(second(&mut sensor.timekeeper, 5_000_000, 0), None);
        sensor.seal(None);
        assert!(scrubbed(sensor).is_empty());
        sensor.timekeeper = damaged;
        assert_eq!(scrubbed(sensor), [Event::TimeForgotten]);
        assert_eq!(second(&mut sensor.timekeeper, 6_000_000, 0), None);
    });
}

#[test]
fn a_damaged_attitude_is_forgotten_and_acquired_anew_near_to_the_one_measured_last() {
    with_sensor(|sensor| {
        (sensor.motion, sensor.former) = (attitude(0.1).into(), Some(unturned()));
        sensor.seal(None);
        assert!(scrubbed(sensor).is_empty());
        assert!(sensor.motion.as_ref().is_some());
        sensor.motion = attitude(0.2).into();
        assert_eq!(scrubbed(sensor), [Event::Mode(Mode::Acquisition, Guard::MemoryDamaged)]);
        assert!(sensor.motion.any().is_none() && sensor.former.is_some());
        assert!(scrubbed(sensor).is_empty());
        // One that was lost is not trusted again by an upset.
        sensor.motion = attitude(0.1).into();
        sensor.motion.lose();
        sensor.seal(None);
        sensor.motion = attitude(0.1).into();
        assert_eq!(scrubbed(sensor), [Event::Mode(Mode::Acquisition, Guard::MemoryDamaged)]);
    });
}

#[test]
fn a_damaged_orbit_begins_anew_with_the_one_told_last_and_three_times_its_sigma() {
    let state = OrbitState {
        time_us: 800_000_000_000_000,
        position_km: Vector3::new(7000.0, 0.0, 0.0),
        velocity_km_s: Vector3::new(0.0, 5.0, 5.5),
    };
    let other = OrbitState { velocity_km_s: Vector3::new(0.0, 5.1, 5.5), ..state };
    with_sensor(|sensor| {
        assert!(sensor.initialise_orbit(state, 2.0, 0.002));
        assert!(scrubbed(sensor).is_empty());
        let told = sensor.orbit_report(None, &mut Events::default());
        sensor.seal(told.as_ref());
        let parameters = sensor.parameters.orbit;
        assert!(sensor.orbit.initialise(other, 2.0, 0.002, &parameters));
        assert_eq!(scrubbed(sensor), [Event::OrbitRestarted]);
        let begun = sensor.orbit_report(None, &mut Events::default()).unwrap();
        assert_eq!(sensor.orbit.state(), Some(&state));
        begun.sigma_position_km.iter().for_each(|sigma| assert!((sigma - 6.0).abs() < 1e-3));
        begun.sigma_velocity_km_s.iter().for_each(|sigma| assert!((sigma - 0.006).abs() < 1e-6));
        // Where none was told it is forgotten.
        assert!(sensor.orbit.initialise(other, 2.0, 0.002, &parameters));
        assert_eq!(scrubbed(sensor), [Event::OrbitForgotten]);
        assert_eq!(sensor.orbit.state(), None);
    });
}

#[test]
fn the_mounting_of_before_a_restart_is_that_of_the_orbit_after_it_and_an_upset_is_found() {
    let state = OrbitState {
        time_us: 800_000_000_000_000,
        position_km: Vector3::new(7000.0, 0.0, 0.0),
        velocity_km_s: Vector3::new(0.0, 5.0, 5.5),
    };
    let (turn_rad, sigma_rad) = ([1e-4, -2e-4, 3e-4], [3e-6, 3e-6, 9e-6]);
    with_sensor(|sensor| {
        let told = |sensor: &mut Sensor| {
            let report = sensor.orbit_report(None, &mut Events::default()).unwrap();
            (report.misalignment_rad, report.misalignment_sigma_rad)
        };
        let as_parameters = sensor.mounting();
        assert!(sensor.orbit.initialise_mounting(turn_rad, sigma_rad));
        sensor.seal(None);
        assert!(scrubbed(sensor).is_empty());
        let turned = sensor.mounting().angle_from(&as_parameters);
        assert!((turned - Vector3::from(turn_rad)).norm() < 1e-6, "{turned}");
        assert!(sensor.initialise_orbit(state, 2.0, 0.002));
        assert_eq!(told(sensor), (turn_rad, sigma_rad));
        assert!(scrubbed(sensor).is_empty() && !sensor.orbit.initialise_mounting([0.0; 3], sigma_rad));
        // An orbit that the clock has left behind leaves it to the next, one that was damaged does not.
        sensor.lose_orbit();
        sensor.seal(None);
        assert!(scrubbed(sensor).is_empty() && sensor.initialise_orbit(state, 2.0, 0.002));
        assert_eq!(told(sensor), (turn_rad, sigma_rad));
        sensor.lose_orbit();
        sensor.seal(None);
        assert!(sensor.orbit.initialise_mounting([0.0, 0.0, 1e-3], sigma_rad));
        assert_eq!(scrubbed(sensor), [Event::OrbitForgotten]);
        assert!(sensor.initialise_orbit(state, 2.0, 0.002) && told(sensor).0 == [0.0; 3]);
    });
}

#[test]
fn parameters_that_are_lost_end_in_safe_mode_until_a_table_is_loaded() {
    with_sensor(|sensor| {
        let loaded = sensor.parameters;
        sensor.parameters.tracking.gate_px = 6;
        sensor.spare.parameters.tracking.gate_px = 7;
        let lost = [Event::ParametersLost, Event::Mode(Mode::CommandedSafe, Guard::MemoryDamaged)];
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
        sensor.seal(None);
        assert!(scrubbed(sensor).is_empty());
        assert_eq!(sensor.parameters, loaded);
    });
}

#[test]
fn a_usual_ground_that_was_damaged_is_forgotten_and_told() {
    with_sensor(|sensor| {
        let other = UsualGround::sample(0.5);
        assert_ne!(other.word_sum(), sensor.usual_ground.word_sum());
        sensor.usual_ground = other;
        assert_eq!(scrubbed(sensor), [Event::GroundForgotten]);
        assert_eq!(sensor.usual_ground.word_sum(), UsualGround::default().word_sum());
        assert!(scrubbed(sensor).is_empty());
    });
}

#[test]
fn damaged_shutters_are_opened() {
    with_sensor(|sensor| {
        sensor.shutting.command(Some(fsw_hal::OpenPaths::Earth));
        assert_eq!(scrubbed(sensor), [Event::ShuttersReleased]);
        assert_eq!(sensor.shutting, Shutting::default());
        sensor.shutting.command(Some(fsw_hal::OpenPaths::Star));
        sensor.seal(None);
        assert!(scrubbed(sensor).is_empty());
        assert_eq!(sensor.shutting.open(), fsw_hal::OpenPaths::Star);
    });
}

#[test]
fn a_wrong_crc_of_catalogue_or_calibration_is_told_once_a_pass() {
    with_sensor(|sensor| {
        let passes = [seconds(&catalogue()), seconds(&calibration::sample::gaussian(1.2))];
        for (seconds, event) in passes.into_iter().zip([Event::CatalogueDamaged, Event::CalibrationDamaged]) {
            // As a damaged byte would.
            sensor.scrubber.passed.crc.add(&[1]);
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
