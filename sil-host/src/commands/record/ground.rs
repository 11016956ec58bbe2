//! The ground while a recording is flown: what it sends, and what the link reports.
//!
//! In: telecommands, each with the second in which it arrives. Out: their packets, as the flight image reads
//! them, and the seconds of the host under them with the link's reports. Without any the flight is its own.

use super::{Instrument, fly_second};
use crate::error::HostError;
use crate::flight;
use crate::formats::frames_file::Recording;
use fsw_core::command::ground::{self, Envelope};
use fsw_core::command::{CommandLink, Key, MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES, Telecommand};
use fsw_core::image::calibration::Calibration;
use fsw_core::sensor::Workspace;
use fsw_core::telemetry::Report;
use fsw_hal::LocalTime;

/// APID of the flight image (`tests/obc-image`).
pub const APID: u16 = 0x2A5;
/// Its key, that of RFC 4493: it flies in an emulator only.
pub const KEY: Key = Key::new([
    0x2b, 0x7e, 0x15, 0x16, 0x28, 0xae, 0xd2, 0xa6, 0xab, 0xf7, 0x15, 0x88, 0x09, 0xcf, 0x4f, 0x3c,
]);

/// The ground's packets, each with its second, by rising seconds.
#[derive(Clone, Debug, Default)]
pub struct Ground {
    /// Second and packet.
    pub packets: Vec<(u32, Vec<u8>)>,
}

impl Ground {
    /// Sends a telecommand in a second.
    ///
    /// # Errors
    /// Where it is longer than a packet.
    pub fn send(&mut self, second: u32, telecommand: &Telecommand) -> Result<(), HostError> {
        let count = self.packets.len() as u32 + 1;
        let envelope = Envelope { apid: APID, sequence: count as u16, authentication: Some((KEY, count)) };
        let mut buffer = [0; MAX_TELECOMMAND_BYTES];
        let packet = ground::encode(telecommand, &envelope, &mut buffer)
            .ok_or_else(|| HostError::usage("a telecommand is too long for a packet", "report this"))?;
        self.packets.push((second, packet.to_vec()));
        Ok(())
    }

    /// As the flight image reads them.
    pub fn file(&self) -> Vec<u8> {
        let entry = |(second, packet): &(u32, Vec<u8>)| {
            [&second.to_le_bytes()[..], &(packet.len() as u16).to_le_bytes(), packet].concat()
        };
        self.packets.iter().flat_map(entry).collect()
    }
}

/// Flies recorded frames on the host: reports of the seconds, and the packets of the link.
///
/// # Errors
/// When the flight code refuses parameters or defects.
pub fn fly(
    recording: &mut Recording,
    instrument: &Instrument,
    ground: &Ground,
) -> Result<(Vec<Report>, Vec<Vec<u8>>), HostError> {
    let mut workspace = Box::new(Workspace::new());
    let catalogue = flight::open(catalog_gen::REFERENCE)?;
    // As in the flight image: its own calibration, where the parameters name one.
    let calibration = Calibration::open(flight::REFERENCE_CALIBRATION).ok();
    let calibration = calibration.filter(|_| instrument.parameters.imaging.calibration_crc != 0);
    let mut sensor =
        flight::sensor(catalogue, calibration, instrument.parameters, &mut workspace).map_err(|error| {
            HostError::usage(format!("the flight code refuses to start ({error:?})"), "report this")
        })?;
    let mut link = CommandLink::new(APID, Some(KEY), 0);
    let (mut reports, mut packets) = (Vec::new(), Vec::new());
    for second in 0..recording.len() {
        for (_, packet) in ground.packets.iter().filter(|(due, _)| *due as usize == second) {
            let _ = link.receive(packet);
        }
        let report = fly_second(&mut sensor, (&mut *recording, &instrument.defects), second, link.command())?;
        link.conclude(report.command);
        link.log(report.cycle, &report.events);
        let now = LocalTime::from_us(report.local_us);
        let mut buffer = [0; MAX_REPORT_BYTES];
        while let Some(packet) = link.next_report(now, &sensor.downlink(), &mut buffer) {
            packets.push(packet.to_vec());
        }
        reports.push(report);
    }
    Ok((reports, packets))
}
