//! The ground's side: a command written as the packet that [`CommandLink`](super::CommandLink) reads. For the
//! host and for tests; no flight program links it.

use super::authentication::{Key, TAG_BYTES};
use super::packets::MAX_TELECOMMAND_BYTES;
use super::telecommand::{Telecommand, VERSION, area_code, paths_code};
use crate::checksum::crc32;
use arbitrary_int::{u11, u14};
use fsw_hal::Area;
use heapless::Vec;
use nalgebra::Vector3;
use spacepackets::SpHeader;
use spacepackets::ecss::tc::PusTcCreator;
use spacepackets::ecss::{CreatorConfig, MessageTypeId};

/// What a packet needs beside its command.
#[derive(Clone, Copy, Debug)]
pub struct Envelope {
    /// APID of the sensor, 11 bits.
    pub apid: u16,
    /// Sequence count, 14 bits: one more than that of the last packet.
    pub sequence: u16,
    /// Key and counter, where the link has a key.
    pub authentication: Option<(Key, u32)>,
}

/// What sends a parameter table (`None`) or the file of an area up: its parts, each of at most `part_bytes`,
/// 1 to [`MAX_PART_BYTES`](super::MAX_PART_BYTES), then the load.
pub fn upload(area: Option<Area>, file: &[u8], part_bytes: usize) -> impl Iterator<Item = Telecommand<'_>> {
    let part_bytes = part_bytes.max(1);
    let part = move |(number, bytes)| Telecommand::Part { area, offset: (number * part_bytes) as u32, bytes };
    let load = Telecommand::Load { area, length: file.len() as u32, crc: crc32(file) };
    file.chunks(part_bytes).enumerate().map(part).chain([load])
}

type Data = Vec<u8, MAX_TELECOMMAND_BYTES>;

fn put(data: &mut Data, bytes: &[u8]) -> Option<()> {
    data.extend_from_slice(bytes).ok()
}

fn put_vector(data: &mut Data, vector: &Vector3<f64>) -> Option<()> {
    vector.iter().try_for_each(|axis| put(data, &axis.to_be_bytes()))
}

/// Version and fields.
fn fields(telecommand: &Telecommand) -> Option<Data> {
    let mut data = Data::new();
    put(&mut data, &[VERSION])?;
    match telecommand {
        Telecommand::Reacquire
        | Telecommand::Restart
        | Telecommand::Safe
        | Telecommand::Dump
        | Telecommand::Events
        | Telecommand::Spots => {}
        Telecommand::Exposure(exposure_us) => put(&mut data, &exposure_us.to_be_bytes())?,
        Telecommand::Orbit(orbit) => {
            put(&mut data, &orbit.state.time_us.to_be_bytes())?;
            put_vector(&mut data, &orbit.state.position_km)?;
            put_vector(&mut data, &orbit.state.velocity_km_s)?;
            put(&mut data, &orbit.position_sigma_km.to_be_bytes())?;
            put(&mut data, &orbit.velocity_sigma_km_s.to_be_bytes())?;
        }
        Telecommand::Time(correlation) => {
            put(&mut data, &correlation.local.as_us().to_be_bytes())?;
            put(&mut data, &correlation.terrestrial_us.to_be_bytes())?;
        }
        Telecommand::Shutter(paths) => put(&mut data, &[paths_code(*paths)])?,
        Telecommand::Part { area, offset, bytes } => {
            put(&mut data, &[area_code(*area)])?;
            put(&mut data, &offset.to_be_bytes())?;
            put(&mut data, bytes)?;
        }
        Telecommand::Load { area, length, crc } => {
            put(&mut data, &[area_code(*area)])?;
            put(&mut data, &length.to_be_bytes())?;
            put(&mut data, &crc.to_be_bytes())?;
        }
    }
    Some(data)
}

/// Writes a command as a packet whose acceptance and completion are to be reported, and gives the bytes used;
/// `None` where they do not fit.
pub fn encode<'a>(
    telecommand: &Telecommand,
    envelope: &Envelope,
    buffer: &'a mut [u8; MAX_TELECOMMAND_BYTES],
) -> Option<&'a [u8]> {
    let header = SpHeader::new_for_unseg_tc(
        u11::extract_u16(envelope.apid, 0),
        u14::extract_u16(envelope.sequence, 0),
        0,
    );
    let (service, subservice) = telecommand.number();
    let write = |data: &[u8], buffer: &mut [u8]| {
        let number = MessageTypeId::new(service, subservice);
        let packet = PusTcCreator::new_simple(header, number, data, CreatorConfig::default());
        packet.write_to_slice_crc_no_table(buffer).ok()
    };
    let mut data = fields(telecommand)?;
    if let Some((key, counter)) = envelope.authentication {
        put(&mut data, &counter.to_be_bytes())?;
        let untagged = data.len();
        put(&mut data, &[0; TAG_BYTES])?;
        let length = write(&data, buffer)?;
        let message = buffer.get(..length.checked_sub(TAG_BYTES + 2)?)?;
        let tag = key.tag(message);
        data.get_mut(untagged..)?.copy_from_slice(&tag);
    }
    let length = write(&data, buffer)?;
    buffer.get(..length)
}
