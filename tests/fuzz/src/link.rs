//! Telecommand packets into a link and a sensor: no panic; a packet or a command that is refused changes
//! nothing; every packet for the sensor is answered.
//!
//! The memory of the areas is that of the host: what serves in it after a restart opens.
//!
//! Two sensors fly side by side: one with what the link commands, the other with the commands that the first
//! one did. They must tell the same.

use crate::seconds::{CAMERA, SIDE_PX};
use fsw_core::catalog::Catalogue;
use fsw_core::command::{Command, CommandLink, CommandOutcome, Key, MAX_REPORT_BYTES, Refusal};
use fsw_core::image::calibration::Calibration;
use fsw_core::image::defects::Defects;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Sensor, Workspace};
use fsw_core::telemetry::Report;
use fsw_hal::{Area, DetectorGeometry, Instant, LocalTime};
use sil_host::flight;
use sil_host::harness::areas::RamAreas;

/// APID of the link.
pub const APID: u16 = 0x2A5;
/// Its key, where the first byte is odd.
pub const KEY: Key = Key::new([0x2b; 16]);
/// Terrestrial Time when the counter begins, us since J2000.0; the clock gives it where the second bit is
/// set.
pub const BEGIN_US: i64 = 800_000_000_000_000;

fn fly(sensor: &mut Sensor, second: usize, synchronised: bool, command: Command) -> Report {
    let geometry = DetectorGeometry { width_px: SIDE_PX, height_px: SIDE_PX, bits: 10 };
    let local_us = second as i64 * 1_000_000;
    let pixels = [second as u8 & 0x7F, 3, 5];
    let mut detector = crate::Bytes { geometry, pixels: &pixels, instant: LocalTime::from_us(local_us) };
    let terrestrial_us = synchronised.then_some(BEGIN_US + local_us);
    let mut clock = Instant { local: LocalTime::from_us(local_us), terrestrial_us };
    flight::second(sensor, &mut detector, &mut clock, command)
}

/// Tries the bytes: flags, then packets, each led by its length. Gives how many were accepted.
pub fn try_bytes(bytes: &[u8]) -> usize {
    let [flags, bytes @ ..] = bytes else { return 0 };
    let (keyed, synchronised) = (flags & 1 == 1, flags & 2 == 2);
    let catalogue = Catalogue::open(catalog_gen::REFERENCE).expect("the catalogue is sound");
    let parameters = Parameters::for_camera(CAMERA);
    let (mut workspace, mut others) = (Box::new(Workspace::new()), Box::new(Workspace::new()));
    let mut sensor = Sensor::new(catalogue, parameters, &mut workspace).expect("the defaults are sound");
    let mut other = Sensor::new(catalogue, parameters, &mut others).expect("the defaults are sound");
    let mut areas = RamAreas::default();
    let mut link = CommandLink::with_areas(APID, keyed.then_some(KEY), 0, &mut areas);
    let (mut accepted, mut second, mut rest) = (0, 0, bytes);
    while let Some((length, after)) = rest.split_first() {
        let (packet, after) = after.split_at(usize::from(*length).min(after.len()));
        rest = after;
        let received = link.receive(packet).map_err(|refused| refused.reason).map(|_| ());
        accepted += usize::from(received.is_ok());
        assert!(received.is_ok() || link.command() == Command::Continue);
        let report = fly(&mut sensor, second, synchronised, link.command());
        let done = report.command == Some(CommandOutcome::Done);
        let same =
            fly(&mut other, second, synchronised, if done { link.command() } else { Command::Continue });
        assert_eq!(Report { command: None, ..report.clone() }, Report { command: None, ..same });
        assert_eq!(sensor.parameters(), other.parameters());
        link.conclude(report.command);
        link.log(report.cycle, &report.events);
        link.check_area(sensor.parameters());
        let (mut buffer, mut reports) = ([0; MAX_REPORT_BYTES], Vec::new());
        let now = LocalTime::from_us(second as i64);
        while let Some(report) = link.next_report(now, &sensor.downlink(), &mut buffer) {
            reports.push((report[7], report[8]));
        }
        // The check of an area may end in the same second.
        let answers = match &reports[..] {
            [answers @ .., (1, 7 | 8)] => answers,
            answers => answers,
        };
        match received {
            // One accepted without a wish for reports is answered only where it was refused later.
            Ok(()) => {
                assert!(reports.iter().all(|report| [(1, 1), (1, 7), (1, 8), (129, 4)].contains(report)))
            }
            Err(Refusal::Apid) => assert!(answers.is_empty()),
            Err(_) => assert!(packet.len() < 4 || answers == [(1, 2)]),
        }
        second += 1;
    }
    areas.restart();
    let opens = |area, open: fn(&[u8]) -> bool| areas.serving(area).is_none_or(open);
    assert!(opens(Area::Catalogue, |file| Catalogue::open(file).is_ok()));
    assert!(opens(Area::Calibration, |file| Calibration::open(file).is_ok()));
    assert!(opens(Area::BadPixels, |file| {
        Defects::open(file).is_ok_and(|defects| defects.size_px() == [SIDE_PX; 2])
    }));
    accepted
}
