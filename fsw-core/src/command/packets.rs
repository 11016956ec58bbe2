//! Space packets: telecommands read by the crate spacepackets, reports written here.
//!
//! Its reader takes bytes behind the packet, telemetry for a telecommand and any version of the secondary
//! header; what is more than a telecommand of ours is refused here. Its writer has panic paths that the linker
//! of the flight image cannot remove. The checksum is computed bit by bit, without a table.

use super::refusal::Refusal;
use super::telecommand::MAX_PART_BYTES;
use fsw_hal::LocalTime;
use heapless::Vec;
use spacepackets::crc::CRC_CCITT_FALSE_NO_TABLE;
use spacepackets::ecss::tc::{GenericPusTcSecondaryHeader, PusTcReader};
use spacepackets::ecss::{MessageTypeId, PusError, PusPacket};
use spacepackets::{CcsdsPacket, PacketType, SequenceFlags};

/// Longest telecommand, bytes.
pub const MAX_TELECOMMAND_BYTES: usize = 256;
/// A buffer of this length holds any report.
pub const MAX_REPORT_BYTES: usize = HEADERS_BYTES + MAX_DATA_BYTES + CHECKSUM_BYTES;
/// Most data of a report: offset, length and a part of the table.
pub(super) const MAX_DATA_BYTES: usize = 4 + MAX_PART_BYTES;
const PRIMARY_BYTES: usize = 6;
/// Primary and secondary header of a report.
const HEADERS_BYTES: usize = PRIMARY_BYTES + 7 + TIME_BYTES;
const CHECKSUM_BYTES: usize = 2;
/// Seconds and their fraction.
const TIME_BYTES: usize = 7;
/// Version of the secondary header: ECSS-E-ST-70-41C.
const PUS_VERSION: u8 = 2;
/// Telemetry with a secondary header, in the first word; the APID is added.
const TELEMETRY: u16 = 0x0800;
/// Unsegmented, in the second word; the sequence count is added.
const UNSEGMENTED: u16 = 0xC000;
const SECOND_US: i64 = 1_000_000;

/// Which telecommand a report is about: version, type, APID and sequence count as they came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestId(pub [u8; 4]);

impl RequestId {
    /// That of a packet; `None` where it is too short to have one.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        bytes.first_chunk().map(|first| Self(*first))
    }

    /// APID of the packet.
    pub(super) fn apid(self) -> u16 {
        let [high, low, ..] = self.0;
        u16::from_be_bytes([high, low]) & 0x07FF
    }
}

/// A telecommand whose headers and checksum are right.
#[derive(Clone, Copy, Debug)]
pub(super) struct TelecommandPacket<'a> {
    /// Sequence count, 14 bits.
    pub(super) sequence: u16,
    /// Whether success is to be reported: of acceptance, of completion.
    pub(super) acknowledge: [bool; 2],
    /// Service and subservice.
    pub(super) number: (u8, u8),
    /// The packet without its checksum.
    pub(super) content: &'a [u8],
    /// What follows the headers in it.
    pub(super) data: &'a [u8],
}

/// Reads a packet that `bytes` is whole, for this APID.
pub(super) fn read(bytes: &[u8], apid: u16) -> Result<TelecommandPacket<'_>, Refusal> {
    if RequestId::of(bytes).ok_or(Refusal::Length)?.apid() != apid {
        return Err(Refusal::Apid);
    }
    if bytes.len() > MAX_TELECOMMAND_BYTES {
        return Err(Refusal::Length);
    }
    let packet = PusTcReader::new_checksum_no_table(bytes).map_err(|error| match error {
        PusError::ByteConversion(_) => Refusal::Length,
        _ => Refusal::Checksum,
    })?;
    if packet.len_packed() != bytes.len() {
        return Err(Refusal::Length);
    }
    let pus_version = bytes.get(6).map(|first| first >> 4);
    let plain = packet.ccsds_version().value() == 0
        && packet.packet_type() == PacketType::Tc
        && packet.sec_header_flag()
        && packet.sequence_flags() == SequenceFlags::Unsegmented
        && pus_version == Some(PUS_VERSION);
    if !plain {
        return Err(Refusal::Header);
    }
    let flags = packet.ack_flags();
    let MessageTypeId { type_id, subtype_id } = PusPacket::message_type_id(&packet);
    Ok(TelecommandPacket {
        sequence: packet.seq_count().value(),
        acknowledge: [flags.acceptance(), flags.completion()],
        number: (type_id, subtype_id),
        content: bytes.get(..bytes.len().saturating_sub(CHECKSUM_BYTES)).ok_or(Refusal::Length)?,
        data: packet.app_data(),
    })
}

/// Appends items to the data of a report as long as there is room for a whole one; how many.
pub(super) fn append_whole<const N: usize>(
    items: impl Iterator<Item = [u8; N]>,
    data: &mut Vec<u8, MAX_DATA_BYTES>,
) -> usize {
    items.take_while(|item| data.extend_from_slice(item).is_ok()).count()
}

/// Headers of a report.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReportHeaders {
    /// 11 bits.
    pub(super) apid: u16,
    /// Count of all reports, 14 bits.
    pub(super) sequence: u16,
    /// Service and subservice.
    pub(super) number: (u8, u8),
    /// Count of the reports of this kind.
    pub(super) count: u16,
    pub(super) now: LocalTime,
}

/// Writes a report and gives the bytes used; `None` where the buffer is too short.
pub(super) fn write<'a>(headers: &ReportHeaders, data: &[u8], buffer: &'a mut [u8]) -> Option<&'a [u8]> {
    let packet = buffer.get_mut(..HEADERS_BYTES + data.len() + CHECKSUM_BYTES)?;
    // The length field counts from 0, and what follows the primary header.
    let length = u16::try_from(packet.len().checked_sub(PRIMARY_BYTES + 1)?).ok()?;
    let (content, checksum) = packet.split_last_chunk_mut::<CHECKSUM_BYTES>()?;
    let (head, body) = content.split_first_chunk_mut::<HEADERS_BYTES>()?;
    let [a0, a1] = (TELEMETRY | headers.apid).to_be_bytes();
    let [s0, s1] = (UNSEGMENTED | headers.sequence).to_be_bytes();
    let [l0, l1] = length.to_be_bytes();
    let ([c0, c1], (service, subservice)) = (headers.count.to_be_bytes(), headers.number);
    let [t0, t1, t2, t3, t4, t5, t6] = time_code(headers.now);
    *head = [
        a0,
        a1,
        s0,
        s1,
        l0,
        l1, // primary header
        PUS_VERSION << 4,
        service,
        subservice,
        c0,
        c1,
        0,
        0, // secondary header
        t0,
        t1,
        t2,
        t3,
        t4,
        t5,
        t6,
    ];
    body.iter_mut().zip(data).for_each(|(place, byte)| *place = *byte);
    *checksum = CRC_CCITT_FALSE_NO_TABLE.checksum(content).to_be_bytes();
    Some(packet)
}

/// The counter as unsegmented time code of 4 and 3 bytes (CCSDS 301.0-B-4); it wraps after 136 years.
fn time_code(now: LocalTime) -> [u8; TIME_BYTES] {
    let (seconds, us) = (now.as_us().div_euclid(SECOND_US), now.as_us().rem_euclid(SECOND_US));
    let [.., a, b, c, d] = seconds.to_be_bytes();
    let [.., e, f, g] = ((us << 24) / SECOND_US).to_be_bytes();
    [a, b, c, d, e, f, g]
}
