use super::*;
use crate::camera::CameraParameters;
use crate::catalog::{Catalogue, sample};
use crate::command::telecommand::ROWS;
use crate::command::{
    CommandLink, MAX_PART_BYTES, MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES, Telecommand, TimeCorrelation,
};
use crate::oracle::{Generator, reference_camera};
use crate::orbit::OrbitState;
use crate::parameters::MAX_TABLE_BYTES;
use crate::sensor::Workspace;
use fsw_hal::{Instant, LocalTime};
use nalgebra::Vector3;
use std::boxed::Box;
use std::string::String;
use std::vec;
use std::vec::Vec;

/// Terrestrial Time of the last second, us since J2000.0.
const NOW_US: i64 = 800_000_000_000_000;
/// The counter then.
const LOCAL_US: i64 = 90_000_000_000;

fn parameters() -> Parameters {
    Parameters::for_camera(reference_camera())
}

fn table(parameters: &Parameters) -> Vec<u8> {
    parameters.encode(&mut [0; MAX_TABLE_BYTES]).unwrap().to_vec()
}

/// Does something with a sensor in tracking whose last second had these times.
fn with_sensor(times: Option<Instant>, test: impl FnOnce(&mut Sensor)) {
    let catalogue = sample::bytes(&sample::sky(&mut Generator::new(1), 20), 26, 1 << 31);
    let mut workspace = Box::new(Workspace::new());
    let catalogue = Catalogue::open(&catalogue).unwrap();
    let mut sensor = Sensor::new(catalogue, parameters(), &mut workspace).unwrap();
    sensor.modes.enter(Mode::Tracking);
    if let Some(mut clock) = times {
        let now = sensor.timekeeper.read_counter(&mut clock);
        sensor.timekeeper.times(&mut clock, &now, None);
    }
    test(&mut sensor);
}

fn synchronised() -> Option<Instant> {
    Some(Instant::new(LocalTime::from_us(LOCAL_US), NOW_US))
}

fn unsynchronised() -> Option<Instant> {
    Some(Instant { local: LocalTime::from_us(LOCAL_US), terrestrial_us: None })
}

/// All that a command could change, in words.
fn state(sensor: &Sensor) -> String {
    std::format!(
        "{:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
        sensor.parameters,
        sensor.spare,
        sensor.modes,
        sensor.timekeeper,
        sensor.orbit,
        (sensor.fixed_us, sensor.converged, sensor.earth_misses, sensor.searching_since),
        sensor.motion.as_ref().is_some(),
        sensor.images_given_up,
        sensor.shutting,
    )
}

fn obey(sensor: &mut Sensor, command: Command) -> (Option<CommandOutcome>, Vec<Event>) {
    let mut events = Events::default();
    let outcome = sensor.obey(&command, &mut events);
    (outcome, events.0.into_iter().collect())
}

#[track_caller]
fn refused(sensor: &mut Sensor, command: Command, reason: Refusal) {
    let before = state(sensor);
    assert_eq!(obey(sensor, command), (Some(CommandOutcome::Refused(reason)), Vec::new()));
    assert_eq!(state(sensor), before, "a refused command changed something");
}

#[track_caller]
fn done(sensor: &mut Sensor, command: Command) -> Vec<Event> {
    let (outcome, events) = obey(sensor, command);
    assert_eq!(outcome, Some(CommandOutcome::Done));
    events
}

fn orbit(age_us: i64) -> GroundOrbit {
    GroundOrbit {
        state: OrbitState {
            time_us: NOW_US - age_us,
            position_km: Vector3::new(42164.0, 0.0, 0.0),
            velocity_km_s: Vector3::new(0.0, 3.0746, 0.0),
        },
        position_sigma_km: 10.0,
        velocity_sigma_km_s: 0.01,
    }
}

#[test]
fn a_sound_table_is_taken_and_stars_are_acquired_anew() {
    with_sensor(synchronised(), |sensor| {
        done(sensor, Command::Orbit(orbit(0)));
        let mut wanted = parameters();
        wanted.tracking.gate_px = 7;
        wanted.camera.focal_length_px = 3001.0;
        let events = done(sensor, Command::LoadParameters(&table(&wanted)));
        assert_eq!(events, [Event::Mode(Mode::Acquisition, Guard::Commanded)]);
        assert_eq!((*sensor.parameters(), *sensor.camera.parameters()), (wanted, wanted.camera));
        assert!(sensor.orbit.state().is_some(), "nothing that it rests on has changed");
        wanted.orbit.patience += 1;
        done(sensor, Command::LoadParameters(&table(&wanted)));
        assert!(sensor.orbit.state().is_none());
    });
}

#[test]
fn a_table_does_not_end_a_mode_that_looks_for_nothing() {
    for mode in [Mode::SelfTest, Mode::Safe, Mode::CommandedSafe] {
        with_sensor(synchronised(), |sensor| {
            sensor.modes.enter(mode);
            done(sensor, Command::LoadParameters(&table(&parameters())));
            assert_eq!(sensor.modes.mode(), mode);
        });
    }
}

#[test]
fn a_table_that_is_damaged_out_of_range_or_of_another_calibration_is_refused() {
    with_sensor(synchronised(), |sensor| {
        let sound = table(&parameters());
        for length in 0..sound.len() {
            refused(sensor, Command::LoadParameters(&sound[..length]), Refusal::TableDamaged);
        }
        let mut wanted = parameters();
        wanted.tracking.gate_px = 0;
        refused(sensor, Command::LoadParameters(&table(&wanted)), Refusal::TableRange);
        let mut wanted = parameters();
        wanted.imaging.calibration_crc = 1;
        refused(sensor, Command::LoadParameters(&table(&wanted)), Refusal::TableCalibration);
    });
}

#[test]
fn an_exposure_is_that_of_the_table_from_now_on_and_nothing_else_changes() {
    with_sensor(synchronised(), |sensor| {
        // What the stars have shown of the lens, and the ground that is usual.
        let focal_length_px = 1.001 * parameters().camera.focal_length_px;
        let learned = Camera::new(CameraParameters { focal_length_px, ..parameters().camera }).unwrap();
        sensor.take_camera(learned);
        sensor.usual_ground = UsualGround::sample(0.7);
        let ground = sensor.usual_ground.word_sum();
        assert!(done(sensor, Command::Exposure(50_000)).is_empty());
        let mut wanted = parameters();
        wanted.imaging.exposure_us = 50_000;
        assert_eq!((*sensor.parameters(), sensor.modes.mode()), (wanted, Mode::Tracking));
        assert_eq!((sensor.camera, sensor.usual_ground.word_sum()), (learned, ground));
        assert!(sensor.parameters_hold(), "the copy is the same");
        for exposure_us in [0, 99, 1_000_001, u32::MAX] {
            refused(sensor, Command::Exposure(exposure_us), Refusal::Exposure);
        }
    });
}

#[test]
fn an_orbit_is_taken_where_it_is_one_and_of_the_last_hundred_minutes() {
    with_sensor(synchronised(), |sensor| {
        for age_us in [-1, ORBIT_AGE_US + 1, i64::MAX, i64::MIN + NOW_US + 1] {
            refused(sensor, Command::Orbit(orbit(age_us)), Refusal::Epoch);
        }
        let sound = orbit(1_000_000);
        for spoilt in [
            GroundOrbit { position_sigma_km: 0.0, ..sound },
            GroundOrbit { velocity_sigma_km_s: f64::NAN, ..sound },
            GroundOrbit {
                state: OrbitState { position_km: Vector3::new(100.0, 0.0, 0.0), ..sound.state },
                ..sound
            },
            GroundOrbit {
                state: OrbitState { velocity_km_s: Vector3::new(0.0, f64::INFINITY, 0.0), ..sound.state },
                ..sound
            },
        ] {
            refused(sensor, Command::Orbit(spoilt), Refusal::Orbit);
        }
        done(sensor, Command::Orbit(sound));
        assert_eq!(sensor.orbit.state(), Some(&sound.state));
        // One that is known stays where the next one is refused.
        refused(sensor, Command::Orbit(orbit(-1)), Refusal::Epoch);
    });
    with_sensor(unsynchronised(), |sensor| refused(sensor, Command::Orbit(orbit(0)), Refusal::Epoch));
    with_sensor(None, |sensor| refused(sensor, Command::Orbit(orbit(0)), Refusal::Epoch));
}

fn correlation(local_us: i64, terrestrial_us: i64) -> Command<'static> {
    Command::Time(TimeCorrelation { local: LocalTime::from_us(local_us), terrestrial_us })
}

#[test]
fn a_time_correlation_serves_where_the_clock_gives_none() {
    with_sensor(synchronised(), |sensor| {
        refused(sensor, correlation(LOCAL_US, NOW_US), Refusal::ClockServes)
    });
    with_sensor(None, |sensor| refused(sensor, correlation(LOCAL_US, NOW_US), Refusal::Correlation));
    with_sensor(unsynchronised(), |sensor| {
        for (local_us, terrestrial_us) in [
            (LOCAL_US + 1, NOW_US),
            (LOCAL_US - 86_400_000_001, NOW_US),
            (i64::MIN, NOW_US),
            (LOCAL_US, -1),
            (LOCAL_US, i64::MAX),
        ] {
            refused(sensor, correlation(local_us, terrestrial_us), Refusal::Correlation);
        }
        done(sensor, correlation(LOCAL_US - 1_000_000, NOW_US - 1_000_000));
        assert_eq!(sensor.timekeeper.last_terrestrial_us(), Some(NOW_US));
        // A better one moves the orbit's epoch with it, once.
        done(sensor, Command::Orbit(orbit(0)));
        done(sensor, correlation(LOCAL_US, NOW_US + 500_000));
        let clock = &mut Instant { local: LocalTime::from_us(LOCAL_US + 1_000_000), terrestrial_us: None };
        let step_us = |sensor: &mut Sensor| {
            let now = sensor.timekeeper.read_counter(clock);
            let time = sensor.timekeeper.times(clock, &now, None);
            assert_eq!(time.terrestrial_us, Some(NOW_US + 1_500_000));
            time.step_us
        };
        let mut step_us = step_us;
        assert_eq!([step_us(sensor), step_us(sensor)], [Some(500_000), None]);
    });
}

#[test]
fn commanded_safe_lasts_through_every_command_but_those_that_end_it() {
    let table = table(&parameters());
    with_sensor(synchronised(), |sensor| {
        done(sensor, Command::Safe);
        for command in [
            Command::Continue,
            Command::LoadParameters(&table),
            Command::LoadParameters(&table[1..]),
            Command::Exposure(50_000),
            Command::Orbit(orbit(0)),
            correlation(LOCAL_US, NOW_US),
            Command::Safe,
        ] {
            obey(sensor, command);
            assert_eq!(sensor.modes.mode(), Mode::CommandedSafe, "{command:?}");
        }
        for (command, mode) in [(Command::Reacquire, Mode::Acquisition), (Command::Restart, Mode::SelfTest)] {
            sensor.modes.enter(Mode::CommandedSafe);
            assert_eq!(done(sensor, command), [Event::Mode(mode, Guard::Commanded)]);
            assert_eq!(sensor.modes.mode(), mode);
        }
    });
}

#[test]
fn shutters_are_held_where_the_table_has_them_until_they_are_given_free() {
    use crate::shutting::{EarthFilter, ShutterParameters, Shutters};
    use fsw_hal::OpenPaths::{Both, BothClear, Earth, Star};
    with_sensor(synchronised(), |sensor| {
        refused(sensor, Command::Shutter(Some(Star)), Refusal::Shutter);
        let paths = Shutters::Earth;
        let shutter = Some(ShutterParameters { paths, ..Default::default() });
        let with_shutter = Parameters { shutter, ..parameters() };
        done(sensor, Command::LoadParameters(&table(&with_shutter)));
        // The star path has none, and the filter stays.
        refused(sensor, Command::Shutter(Some(Earth)), Refusal::Shutter);
        refused(sensor, Command::Shutter(Some(BothClear)), Refusal::Shutter);
        for (held, open) in [(Some(Star), Star), (Some(Both), Both), (Some(Star), Star), (None, Both)] {
            assert!(done(sensor, Command::Shutter(held)).is_empty());
            assert_eq!(sensor.shutting.open(), open);
        }
        done(sensor, Command::Shutter(Some(Star)));
        done(sensor, Command::Restart);
        assert_eq!(sensor.shutting.open(), Both);
        // Another table lets them be where it has the shutter that is held, and no other does.
        done(sensor, Command::Shutter(Some(Star)));
        done(sensor, Command::LoadParameters(&table(&with_shutter)));
        assert_eq!(sensor.shutting.open(), Star);
        let of_stars = Some(ShutterParameters { paths: Shutters::Star, ..Default::default() });
        done(sensor, Command::LoadParameters(&table(&Parameters { shutter: of_stars, ..parameters() })));
        assert_eq!(sensor.shutting.open(), Both);
        let shutter = Some(ShutterParameters { paths, filter: EarthFilter::Adaptive, ..Default::default() });
        done(sensor, Command::LoadParameters(&table(&Parameters { shutter, ..parameters() })));
        assert!(done(sensor, Command::Shutter(Some(BothClear))).is_empty());
        assert_eq!(sensor.shutting.open(), BothClear);
    });
}

/// What the sensor is before a packet comes.
#[derive(Clone, Copy)]
enum Before {
    Sound,
    /// The parameters are not those of their copy, as scrubbing leaves them where neither is sound.
    Lost,
    /// The clock gives no Terrestrial Time.
    Unsynchronised,
}

/// Sends commands up as packets, does them, and gives the reports: service, subservice, reason. The last
/// report must be of the last packet.
fn answered(before: Before, telecommands: &[Telecommand]) -> Vec<(u8, u8, u16)> {
    use crate::command::ground::{Envelope, encode};
    let times = if matches!(before, Before::Unsynchronised) { unsynchronised() } else { synchronised() };
    let mut answers = Vec::new();
    with_sensor(times, |sensor| {
        if matches!(before, Before::Lost) {
            sensor.parameters.tracking.gate_px = 1;
        }
        let mut link = CommandLink::new(0x2A5, None, 0);
        for (sequence, telecommand) in (1..).zip(telecommands) {
            answers.clear();
            let envelope = Envelope { apid: 0x2A5, sequence, authentication: None };
            let mut packet = [0; MAX_TELECOMMAND_BYTES];
            let packet = encode(telecommand, &envelope, &mut packet).expect("it fits");
            assert!(link.receive(packet).is_ok());
            let state_before = state(sensor);
            let mut events = Events::default();
            let outcome = sensor.obey(&link.command(), &mut events);
            if let Some(CommandOutcome::Refused(_)) = outcome {
                assert_eq!(state(sensor), state_before, "{telecommand:?}");
            }
            link.conclude(outcome);
            let mut buffer = [0; MAX_REPORT_BYTES];
            while let Some(report) = link.next_report(LocalTime::from_us(0), &sensor.downlink(), &mut buffer)
            {
                assert_eq!(report[20..24], packet[..4], "a report of another packet");
                let reason = if report[8] == 8 { [report[24], report[25]] } else { [0; 2] };
                answers.push((report[7], report[8], u16::from_be_bytes(reason)));
            }
        }
    });
    answers
}

/// A table as it goes up: its parts, then the load.
fn upload(table: &[u8]) -> Vec<Telecommand<'_>> {
    crate::command::ground::upload(None, table, MAX_PART_BYTES).collect()
}

#[test]
fn every_command_of_a_second_is_done_and_refused_for_each_of_its_reasons_by_packets() {
    let paths = Some(OpenPaths::Star);
    let sound = orbit(1_000_000);
    let shutter = Some(crate::shutting::ShutterParameters::default());
    let tables = [
        parameters(),
        Parameters { shutter, ..parameters() },
        Parameters {
            tracking: crate::parameters::TrackingParameters { gate_px: 0, ..parameters().tracking },
            ..parameters()
        },
        Parameters {
            imaging: crate::parameters::ImagingParameters { calibration_crc: 1, ..parameters().imaging },
            ..parameters()
        },
    ]
    .map(|parameters| table(&parameters));
    let [right, with_shutters, out_of_range, other_calibration] =
        tables.each_ref().map(|table| upload(table));
    let mut opened = with_shutters;
    opened.push(Telecommand::Shutter(paths));
    let of_other_version = [&[99], &tables[0][1..]].concat();
    let time = |local_us| {
        Telecommand::Time(TimeCorrelation { local: LocalTime::from_us(local_us), terrestrial_us: NOW_US })
    };
    let spoilt = GroundOrbit { position_sigma_km: 0.0, ..sound };
    let cases: [(Before, Vec<Telecommand>, Option<Refusal>); 22] = [
        (Before::Sound, vec![Telecommand::Reacquire], None),
        (Before::Lost, vec![Telecommand::Reacquire], Some(Refusal::ParametersLost)),
        (Before::Sound, vec![Telecommand::Restart], None),
        (Before::Lost, vec![Telecommand::Restart], Some(Refusal::ParametersLost)),
        (Before::Sound, vec![Telecommand::Safe], None),
        (Before::Lost, vec![Telecommand::Safe], None),
        (Before::Sound, vec![Telecommand::Exposure(50_000)], None),
        (Before::Sound, vec![Telecommand::Exposure(1)], Some(Refusal::Exposure)),
        (Before::Lost, vec![Telecommand::Exposure(50_000)], Some(Refusal::ParametersLost)),
        (Before::Sound, vec![Telecommand::Orbit(sound)], None),
        (Before::Sound, vec![Telecommand::Orbit(spoilt)], Some(Refusal::Orbit)),
        (Before::Sound, vec![Telecommand::Orbit(orbit(-1))], Some(Refusal::Epoch)),
        (Before::Lost, vec![Telecommand::Orbit(sound)], Some(Refusal::ParametersLost)),
        (Before::Unsynchronised, vec![time(LOCAL_US)], None),
        (Before::Unsynchronised, vec![time(LOCAL_US + 1)], Some(Refusal::Correlation)),
        (Before::Sound, vec![time(LOCAL_US)], Some(Refusal::ClockServes)),
        (Before::Sound, opened, None),
        (Before::Sound, vec![Telecommand::Shutter(paths)], Some(Refusal::Shutter)),
        (Before::Lost, vec![Telecommand::Shutter(paths)], Some(Refusal::ParametersLost)),
        (Before::Lost, right, None),
        (Before::Sound, out_of_range, Some(Refusal::TableRange)),
        (Before::Sound, other_calibration, Some(Refusal::TableCalibration)),
    ];
    let damaged = (Before::Sound, upload(&of_other_version), Some(Refusal::TableDamaged));
    let mut shown = Vec::new();
    for (before, telecommands, refusal) in cases.into_iter().chain([damaged]) {
        let last = telecommands.last().expect("a command");
        let end = refusal.map_or((1, 7, 0), |reason| (1, 8, reason.code()));
        assert_eq!(answered(before, &telecommands), [(1, 1, 0), end], "{last:?}");
        shown.push((last.number(), refusal));
    }
    // All of the list but what the link does by itself and what is told of an area or on arrival, which its
    // own tests show.
    let here = |reason: &Refusal| reason.code() >= 32 && reason.code() < Refusal::Area.code();
    for row in ROWS.iter().filter(|row| !["part", "dump", "events", "spots"].contains(&row.name)) {
        let reasons = row.refusals.iter().filter(|reason| here(reason)).map(|reason| Some(*reason));
        for wanted in reasons.chain([None]) {
            assert!(shown.contains(&(row.number, wanted)), "{}: {wanted:?} is not shown", row.name);
        }
    }
}

#[test]
fn commands_change_the_mode_as_the_table_of_forced_changes_says() {
    let table = table(&parameters());
    for row in crate::modes::FORCED.iter().filter(|row| row.guard == Guard::Commanded) {
        let command = match row.cause {
            "command `reacquire`" => Command::Reacquire,
            "command `restart`" => Command::Restart,
            "command `safe`" => Command::Safe,
            "another parameter table" => Command::LoadParameters(&table),
            cause => panic!("{cause}"),
        };
        for from in row.from {
            with_sensor(synchronised(), |sensor| {
                sensor.modes.enter(*from);
                let to = row.to.unwrap_or(*from);
                assert_eq!(done(sensor, command), [Event::Mode(to, Guard::Commanded)], "{from:?}");
                assert_eq!(sensor.modes.mode(), to);
            });
        }
    }
}
