//! The link on bytes. The packets in hexadecimal were made by another program (Python's `struct` and
//! `crc_hqx`, the CMAC of OpenSSL 3) from the standards.

use super::ground::{self, Envelope};
use super::telecommand::{ROWS, SENSOR, TABLE};
use super::*;
use crate::checksum::crc32;
use crate::image::SPOT;
use crate::modes::{Guard, Mode};
use crate::oracle::reference_camera;
use crate::parameters::{MAX_TABLE_BYTES, Parameters};
use crate::telemetry::Event;
use fsw_hal::{Area, AreaStore};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::format;
use std::string::String;
use std::vec::Vec;

mod areas;

const APID: u16 = 0x2A5;
const KEY: Key = Key::new([
    0x2b, 0x7e, 0x15, 0x16, 0x28, 0xae, 0xd2, 0xa6, 0xab, 0xf7, 0x15, 0x88, 0x09, 0xcf, 0x4f, 0x3c,
]);
const NOW: LocalTime = LocalTime::from_us(12_500_000);
const IMAGE: LocalTime = LocalTime::from_us(12_000_000);
const SAFE: &str = "1aa5c00700072f800300000253b1";
const ORBIT: GroundOrbit = GroundOrbit {
    state: OrbitState {
        time_us: 800_000_000_000_000,
        position_km: Vector3::new(42164.0, 0.0, 0.0),
        velocity_km_s: Vector3::new(0.0, 3.0746, 0.0),
    },
    position_sigma_km: 10.0,
    velocity_sigma_km_s: 0.01,
};
const TIME: TimeCorrelation =
    TimeCorrelation { local: LocalTime::from_us(5_000_000), terrestrial_us: 800_000_000_000_000 };

fn bytes(hex: &str) -> Vec<u8> {
    hex.as_bytes()
        .chunks(2)
        .map(|pair| u8::from_str_radix(core::str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn open_link() -> CommandLink {
    CommandLink::new(APID, None, 0)
}

fn keyed_link() -> CommandLink {
    CommandLink::new(APID, Some(KEY), 65)
}

fn parameters() -> Parameters {
    Parameters::for_camera(reference_camera())
}

fn packet(telecommand: &Telecommand, sequence: u16, authentication: Option<(Key, u32)>) -> Vec<u8> {
    let envelope = Envelope { apid: APID, sequence, authentication };
    ground::encode(telecommand, &envelope, &mut [0; MAX_TELECOMMAND_BYTES]).expect("it fits").to_vec()
}

/// The packet of these data, whatever they are, its checksum right.
fn raw_packet((service, subservice): (u8, u8), sequence: u16, data: &[u8]) -> Vec<u8> {
    let mut packet = bytes("1aa5");
    packet.extend((0xC000 | sequence).to_be_bytes());
    packet.extend((data.len() as u16 + 6).to_be_bytes());
    packet.extend([0x2F, service, subservice, 0, 0]);
    packet.extend(data);
    sealed(&packet)
}

/// Adds the checksum, CRC-16 (IBM-3740, the standards' CCITT).
fn sealed(content: &[u8]) -> Vec<u8> {
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740).checksum(content);
    [content, &crc.to_be_bytes()].concat()
}

/// All reports that wait.
fn reports<S: AreaStore>(link: &mut CommandLink<S>) -> Vec<Vec<u8>> {
    reports_with(link, &[])
}

/// The same with these spots of the last image.
fn reports_with<S: AreaStore>(link: &mut CommandLink<S>, spots: &[Detection]) -> Vec<Vec<u8>> {
    let mut buffer = [0; MAX_REPORT_BYTES];
    let told = Downlink { parameters: &parameters(), image: IMAGE, spots };
    core::iter::from_fn(|| link.next_report(NOW, &told, &mut buffer).map(<[u8]>::to_vec)).collect()
}

/// Service, subservice and data of a report.
fn parts(report: &[u8]) -> ((u8, u8), &[u8]) {
    ((report[7], report[8]), &report[20..report.len() - 2])
}

/// The reason that a packet is refused with, which must be that of its report too.
fn refusal<S: AreaStore>(link: &mut CommandLink<S>, packet: &[u8]) -> Option<Refusal> {
    let refused = link.receive(packet).err().map(|refused| refused.reason);
    if let Some(reason) = refused.filter(|reason| *reason != Refusal::Apid && packet.len() >= 4) {
        let reports = reports(link);
        let told = reports.iter().map(|report| parts(report)).collect::<Vec<_>>();
        let data = [&packet[..4], &reason.code().to_be_bytes()].concat();
        assert_eq!(told, [((1, 2), &data[..])]);
    }
    refused
}

#[test]
fn every_command_comes_out_of_the_bytes_that_another_program_made() {
    for (sequence, telecommand, packet_hex) in [
        (7, Telecommand::Safe, SAFE),
        (8, Telecommand::Exposure(50_000), "1aa5c008000b2f80040000020000c350cb59"),
        (9, Telecommand::Time(TIME), "1aa5c00900172f800600000200000000004c4b400002d79883d200003997"),
        (
            10,
            Telecommand::Orbit(ORBIT),
            "1aa5c00a004f2f80050000020002d79883d2000040e49680000000000000000000000000000000000000000000000000\
             00000000400898c7e28240b8000000000000000040240000000000003f847ae147ae147b41db",
        ),
        (
            11,
            Telecommand::Part { area: None, offset: 0, bytes: &[13, 1, 2] },
            "1aa5c00b000f2f810100000200000000000d0102b872",
        ),
    ] {
        let packet_bytes = bytes(packet_hex);
        assert_eq!(hex(&packet(&telecommand, sequence, None)), packet_hex);
        let mut link = open_link();
        let accepted = link.receive(&packet_bytes).expect("it is right");
        assert_eq!(accepted.telecommand, telecommand);
        assert_eq!(accepted.request.0, packet_bytes[..4]);
    }
    let load = bytes("1aa5c00c00102f81020000020000000003112233446a86");
    assert_eq!(packet(&Telecommand::Load { area: None, length: 3, crc: 0x1122_3344 }, 12, None), load);
    assert_eq!(refusal(&mut open_link(), &load), Some(Refusal::Incomplete));
    let area = Some(Area::Catalogue);
    let part = bytes("1aa5c00d00102f81010000020100000000535854432e84");
    assert_eq!(packet(&Telecommand::Part { area, offset: 0, bytes: b"SXTC" }, 13, None), part);
    let area = Some(Area::BadPixels);
    let load = bytes("1aa5c00e00102f81020000020300011170deadbeefbaf4");
    assert_eq!(packet(&Telecommand::Load { area, length: 70_000, crc: 0xDEAD_BEEF }, 14, None), load);
}

#[test]
fn a_key_wants_the_tag_that_another_program_made() {
    let safe = "1aa5c007001b2f8003000002000000424cdd742431ca64d9e2ff05c16cf4face80a1";
    let exposure = "1aa5ffff001f2f80040000020000c350010203047d0928afc539a0ce6847adec8f66eb84fab1";
    assert_eq!(hex(&packet(&Telecommand::Safe, 7, Some((KEY, 66)))), safe);
    let mut link = keyed_link();
    assert_eq!(link.receive(&bytes(safe)).map(|accepted| accepted.telecommand), Ok(Telecommand::Safe));
    assert_eq!((link.counter(), link.command()), (66, Command::Safe));
    let mut link = keyed_link();
    assert!(link.receive(&bytes(exposure)).is_ok());
    assert_eq!((link.counter(), link.command()), (0x0102_0304, Command::Exposure(50_000)));
}

#[test]
fn acceptance_and_completion_are_reported_in_the_bytes_of_the_standard() {
    let mut link = open_link();
    assert!(link.receive(&bytes(SAFE)).is_ok());
    link.conclude(Some(CommandOutcome::Refused(Refusal::Exposure)));
    let reports: Vec<_> = reports(&mut link).iter().map(|report| hex(report)).collect();
    assert_eq!(
        reports,
        [
            "0aa5c0000013200101000000000000000c8000001aa5c007a2d8",
            "0aa5c0010015200108000000000000000c8000001aa5c00700239d4b",
        ]
    );
}

#[test]
fn every_command_of_the_list_is_reported_accepted_and_done_and_only_with_its_own_fields() {
    let length = |kind: &str| match kind {
        "u8" => 1,
        "u16" => 2,
        "u32" => 4,
        "i64" | "f64" => 8,
        "3 f64" => 24,
        "bytes" => 1,
        kind => panic!("{kind}"),
    };
    for row in ROWS {
        let fields: usize = row.fields.iter().map(|field| length(field.kind)).sum();
        let data = |fields: usize| [&[VERSION][..], &std::vec![0; fields]].concat();
        let mut link = open_link();
        // All fields zero: also the load of no bytes, whose CRC is zero.
        let fitting = raw_packet(row.number, 5, &data(fields));
        let accepted = link.receive(&fitting).unwrap_or_else(|refused| panic!("{}: {refused:?}", row.name));
        assert_eq!(accepted.telecommand.number(), row.number);
        link.conclude(Some(CommandOutcome::Done));
        let reports = reports(&mut link);
        let told: Vec<_> = reports.iter().map(|report| parts(report)).collect();
        assert_eq!(told.first(), Some(&((1, 1), &fitting[..4])), "{}", row.name);
        assert!(told.contains(&((1, 7), &fitting[..4])), "{}", row.name);
        for fields in [fields.wrapping_sub(1), fields + 1] {
            let open_ended = row.fields.last().is_some_and(|last| last.kind == "bytes");
            if fields < 100 && !open_ended {
                let packet = raw_packet(row.number, 5, &data(fields));
                assert_eq!(refusal(&mut open_link(), &packet), Some(Refusal::Fields), "{}", row.name);
            }
        }
    }
}

#[test]
fn reports_are_made_only_where_they_are_asked_for_and_always_of_a_refusal() {
    let quiet = |packet: &[u8]| {
        let mut content = packet[..packet.len() - 2].to_vec();
        content[6] = 0x20;
        sealed(&content)
    };
    let mut link = open_link();
    assert!(link.receive(&quiet(&bytes(SAFE))).is_ok());
    link.conclude(Some(CommandOutcome::Done));
    assert!(reports(&mut link).is_empty());
    assert!(link.receive(&quiet(&packet(&Telecommand::Exposure(1), 8, None))).is_ok());
    link.conclude(Some(CommandOutcome::Refused(Refusal::Exposure)));
    assert_eq!(parts(&reports(&mut link)[0]).0, (1, 8));
    assert_eq!(refusal(&mut link, &quiet(&bytes(SAFE))), Some(Refusal::Sequence));
}

#[test]
fn what_is_no_telecommand_of_ours_is_refused_and_says_why() {
    let safe = bytes(SAFE);
    let changed = |place: usize, value: u8| {
        let mut content = safe[..safe.len() - 2].to_vec();
        content[place] = value;
        sealed(&content)
    };
    for (packet, reason) in [
        (Vec::new(), Refusal::Length),
        (safe[..3].to_vec(), Refusal::Length),
        (safe[..10].to_vec(), Refusal::Length),
        (safe[..safe.len() - 1].to_vec(), Refusal::Length),
        ([&safe[..], &[0]].concat(), Refusal::Length),
        (raw_packet((TABLE, 1), 1, &[VERSION; 300]), Refusal::Length),
        ([&safe[..12], &[0, 0]].concat(), Refusal::Checksum),
        // Another packet version, telemetry, no secondary header.
        (changed(0, 0x3A), Refusal::Header),
        (changed(0, 0x0A), Refusal::Header),
        (changed(0, 0x12), Refusal::Header),
        (changed(1, 0xA6), Refusal::Apid),
        // A first segment; the header of an older standard.
        (changed(2, 0x40), Refusal::Header),
        (changed(6, 0x1F), Refusal::Header),
        (changed(7, 127), Refusal::Unknown),
        (changed(8, 8), Refusal::Unknown),
        (raw_packet((SENSOR, 7), 7, &[VERSION, 5]), Refusal::Shutter),
        (raw_packet((TABLE, 1), 7, &[VERSION, 4, 0, 0, 0, 0, 1]), Refusal::Area),
        (changed(11, 1), Refusal::Version),
        (raw_packet((SENSOR, 3), 7, &[]), Refusal::Fields),
    ] {
        let mut link = open_link();
        assert_eq!(refusal(&mut link, &packet), Some(reason), "{}", hex(&packet));
        assert_eq!(link.command(), Command::Continue);
        assert!(reports(&mut link).is_empty());
    }
}

#[test]
fn old_sequence_counts_are_refused_and_newer_ones_taken_over_gaps_and_the_turn_of_the_counter() {
    let mut link = open_link();
    let mut try_count = |count: u16| {
        let packet = packet(&Telecommand::Reacquire, count, None);
        let reason = link.receive(&packet).err().map(|refused| refused.reason);
        link.conclude(Some(CommandOutcome::Done));
        reports(&mut link);
        reason
    };
    for (count, reason) in [
        (16_000, None),
        (16_000, Some(Refusal::Sequence)),
        (15_999, Some(Refusal::Sequence)),
        (16_383, None),
        (0, None),
        (16_383, Some(Refusal::Sequence)),
        (8_191, None),
        (16_382, None),
        (8_191, Some(Refusal::Sequence)),
    ] {
        assert_eq!(try_count(count), reason, "{count}");
    }
}

#[test]
fn with_a_key_no_packet_is_taken_without_its_tag_nor_twice_nor_an_older_one() {
    let mut link = keyed_link();
    let tagged = |sequence, counter| packet(&Telecommand::Reacquire, sequence, Some((KEY, counter)));
    assert_eq!(refusal(&mut link, &bytes(SAFE)), Some(Refusal::Tag));
    let other = Key::new([0; 16]);
    assert_eq!(
        refusal(&mut link, &packet(&Telecommand::Reacquire, 1, Some((other, 70)))),
        Some(Refusal::Tag)
    );
    assert_eq!(refusal(&mut link, &tagged(1, 65)), Some(Refusal::Counter));
    assert!(link.receive(&tagged(1, 66)).is_ok());
    link.conclude(Some(CommandOutcome::Done));
    reports(&mut link);
    assert_eq!(refusal(&mut link, &tagged(1, 66)), Some(Refusal::Counter));
    assert_eq!(refusal(&mut link, &tagged(1, 67)), Some(Refusal::Sequence));
    // What was authentic is not taken again, though it was refused.
    assert_eq!(link.counter(), 67);
    assert!(link.receive(&tagged(2, u32::MAX)).is_ok());
    // A link that is made anew with the counter that was stored.
    let mut link = CommandLink::new(APID, Some(KEY), link.counter());
    assert_eq!(refusal(&mut link, &tagged(3, u32::MAX)), Some(Refusal::Counter));
}

/// Second and bytes of an event.
type LoggedEvent = (u32, [u8; 3]);

/// What is sent down of the log: number of the first event and events left of each part, and the events.
fn logged(link: &mut CommandLink, sequence: u16) -> (Vec<(u32, u16)>, Vec<LoggedEvent>) {
    assert!(link.receive(&packet(&Telecommand::Events, sequence, None)).is_ok());
    let (mut heads, mut events, mut verdicts) = (Vec::new(), Vec::new(), Vec::new());
    for report in reports(link) {
        let (number, data) = parts(&report);
        if number != (130, 2) {
            verdicts.push(number);
            continue;
        }
        let (head, data) = data.split_at(6);
        let first = u32::from_be_bytes(head[..4].try_into().unwrap());
        heads.push((first, u16::from_be_bytes(head[4..].try_into().unwrap())));
        for event in data.chunks(7) {
            let (cycle, event) = event.split_first_chunk().unwrap();
            events.push((u32::from_be_bytes(*cycle), event.try_into().unwrap()));
        }
    }
    assert_eq!(verdicts, [(1, 1), (1, 7)]);
    (heads, events)
}

#[test]
fn the_log_of_events_is_sent_down_in_parts_the_oldest_first() {
    let mut link = open_link();
    assert_eq!(logged(&mut link, 1), (std::vec![(0, 0)], Vec::new()));
    link.log(7, &[Event::Mode(Mode::Eclipse, Guard::EarthDark), Event::ClockJump]);
    link.log(8, &[] as &[Event]);
    link.log(300, &[Event::Overran]);
    // By the places of mode, guard and event in their lists.
    let expected = [(7, [0, 3, 3]), (7, [6, 0, 0]), (300, [17, 0, 0])];
    assert_eq!(logged(&mut link, 2), (std::vec![(0, 3)], expected.to_vec()));
    // Of 103 the last 64 are kept, 28 in a part.
    (0..100).for_each(|cycle| link.log(1000 + cycle, &[Event::FixDownweighted]));
    let (heads, events) = logged(&mut link, 3);
    assert_eq!(heads, [(39, 64), (67, 36), (95, 8)]);
    let expected: Vec<_> = (1036..1100).map(|cycle| (cycle, [3, 0, 0])).collect();
    assert_eq!(events, expected);
}

#[test]
fn the_spots_of_the_image_are_sent_down_in_parts_in_their_order() {
    let spots: Vec<_> = (0..30u8)
        .map(|k| Detection {
            x_q16: i32::from(k) << 16,
            number: k,
            saturated: k == 2,
            blended: k == 2,
            ..SPOT
        })
        .collect();
    let mut link = open_link();
    assert!(link.receive(&packet(&Telecommand::Spots, 1, None)).is_ok());
    let (mut left, mut columns, mut verdicts) = (Vec::new(), Vec::new(), Vec::new());
    for report in reports_with(&mut link, &spots) {
        let (number, data) = parts(&report);
        if number != (130, 4) {
            verdicts.push(number);
            continue;
        }
        assert_eq!(data[..8], IMAGE.as_us().to_be_bytes());
        left.push(u16::from_be_bytes(data[8..10].try_into().unwrap()));
        for spot in data[10..].chunks_exact(16) {
            let (column, rest) = spot.split_first_chunk().unwrap();
            let column = i32::from_be_bytes(*column) >> 16;
            columns.push(column);
            // Row, light, sigma; the number, and for the third that it is saturated and two in one.
            let flags = if column == 2 { 5 } else { 0 };
            let expected =
                [&[0; 4], &10_000u32.to_be_bytes()[..], &3000u16.to_be_bytes(), &[column as u8, flags]];
            assert_eq!(rest, expected.concat());
        }
    }
    assert_eq!((left, verdicts), (std::vec![30, 18, 6], std::vec![(1, 1), (1, 7)]));
    assert_eq!(columns, (0..30).collect::<Vec<_>>());
    // Without one that is said.
    assert!(link.receive(&packet(&Telecommand::Spots, 2, None)).is_ok());
    let none = reports_with(&mut link, &[]);
    assert_eq!(parts(&none[1]), ((130, 4), &[&IMAGE.as_us().to_be_bytes()[..], &[0, 0]].concat()[..]));
}

#[test]
fn one_command_waits_for_its_second_and_the_next_is_refused_until_it_is_done() {
    let mut link = open_link();
    assert!(link.receive(&packet(&Telecommand::Orbit(ORBIT), 1, None)).is_ok());
    reports(&mut link);
    assert_eq!(refusal(&mut link, &packet(&Telecommand::Safe, 2, None)), Some(Refusal::Busy));
    assert_eq!(link.command(), Command::Orbit(ORBIT));
    // A second that was flown without it does not complete it.
    link.conclude(None);
    assert_eq!(link.command(), Command::Orbit(ORBIT));
    link.conclude(Some(CommandOutcome::Done));
    assert_eq!(link.command(), Command::Continue);
    assert!(link.receive(&packet(&Telecommand::Time(TIME), 3, None)).is_ok());
    assert_eq!(link.command(), Command::Time(TIME));
}

#[test]
fn reports_that_nobody_takes_stop_the_link_and_lose_no_completion() {
    let mut link = open_link();
    let part = |sequence| packet(&Telecommand::Part { area: None, offset: 0, bytes: &[1] }, sequence, None);
    let taken = (1..=20).filter(|sequence| link.receive(&part(*sequence)).is_ok()).count();
    assert_eq!(taken, 6);
    assert_eq!(link.receive(&part(21)).unwrap_err().reason, Refusal::Busy);
    let told = reports(&mut link);
    assert_eq!(told.iter().filter(|report| parts(report).0 == (1, 7)).count(), 6);
    assert!(told.len() <= 16);
    // Both counters of the packets go on without a gap.
    for (sequence, report) in told.iter().enumerate() {
        assert_eq!(u16::from_be_bytes([report[2], report[3]]), 0xC000 | sequence as u16);
    }
    assert!(link.receive(&part(22)).is_ok());
}

/// Sends a table up in parts of `length` bytes; the next sequence count.
fn upload(link: &mut CommandLink, table: &[u8], length: usize, mut sequence: u16) -> u16 {
    for (part, bytes) in table.chunks(length).enumerate() {
        let offset = (part * length) as u32;
        let part = Telecommand::Part { area: None, offset, bytes };
        link.receive(&packet(&part, sequence, None)).expect("it is right");
        reports(link);
        sequence += 1;
    }
    sequence
}

#[test]
fn a_table_is_loaded_only_when_its_parts_are_whole() {
    let mut buffer = [0; MAX_TABLE_BYTES];
    let table = parameters().encode(&mut buffer).unwrap().to_vec();
    let (length, crc) = (table.len() as u32, crc32(&table));
    let load = |length, crc, sequence| packet(&Telecommand::Load { area: None, length, crc }, sequence, None);
    let mut link = open_link();
    let next = upload(&mut link, &table[..table.len() - 1], MAX_PART_BYTES, 1);
    assert_eq!(refusal(&mut link, &load(length, crc, next)), Some(Refusal::Incomplete));
    let part =
        |offset, bytes, sequence| packet(&Telecommand::Part { area: None, offset, bytes }, sequence, None);
    assert_eq!(refusal(&mut link, &part(length, &[0], next + 1)), Some(Refusal::Part));
    assert_eq!(refusal(&mut link, &part(0, &[], next + 2)), Some(Refusal::Part));
    assert!(link.receive(&part(length - 1, &table[table.len() - 1..], next + 3)).is_ok());
    reports(&mut link);
    assert_eq!(refusal(&mut link, &load(length, crc ^ 1, next + 4)), Some(Refusal::TableChecksum));
    assert!(link.receive(&load(length, crc, next + 5)).is_ok());
    assert_eq!(link.command(), Command::LoadParameters(&table));
    reports(&mut link);
    // The table that waits is not written over.
    assert_eq!(refusal(&mut link, &part(0, &[9], next + 6)), Some(Refusal::Busy));
    assert_eq!(link.command(), Command::LoadParameters(&table));
    // More than any table has.
    let mut link = open_link();
    let next = upload(&mut link, &[7; MAX_TABLE_BYTES], 64, 1);
    let beyond = part(MAX_TABLE_BYTES as u32, &[7], next);
    assert_eq!(refusal(&mut link, &beyond), Some(Refusal::Part));
}

#[test]
fn a_dump_sends_the_table_in_force_in_parts_and_is_then_done() {
    let mut buffer = [0; MAX_TABLE_BYTES];
    let table = parameters().encode(&mut buffer).unwrap().to_vec();
    let mut link = open_link();
    assert!(link.receive(&packet(&Telecommand::Dump, 1, None)).is_ok());
    assert_eq!(link.command(), Command::Continue);
    let reports = reports(&mut link);
    let told: Vec<_> = reports.iter().map(|report| parts(report)).collect();
    assert_eq!(told[0].0, (1, 1));
    assert_eq!(told.last().map(|last| last.0), Some((1, 7)));
    let mut dumped = Vec::new();
    for ((service, subservice), data) in &told[1..told.len() - 1] {
        assert_eq!((*service, *subservice), (TABLE, 4));
        assert_eq!(data[..2], (dumped.len() as u16).to_be_bytes());
        assert_eq!(data[2..4], (table.len() as u16).to_be_bytes());
        dumped.extend_from_slice(&data[4..]);
    }
    assert_eq!(dumped, table);
}

#[test]
fn reasons_have_codes_of_their_own_in_rising_order() {
    assert!(refusal::ALL.windows(2).all(|pair| pair[0].code() < pair[1].code()));
    for row in ROWS {
        assert!(row.refusals.iter().all(|reason| refusal::ALL.contains(reason)));
    }
}

fn mutilated() -> impl Strategy<Value = Vec<u8>> {
    let kinds: Vec<Vec<u8>> = ROWS
        .iter()
        .map(|row| raw_packet(row.number, 9, &[&[VERSION][..], &[0; 30]].concat()))
        .chain([packet(&Telecommand::Orbit(ORBIT), 9, Some((KEY, 99))), bytes(SAFE)])
        .collect();
    let cut = (any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<u8>(), any::<bool>());
    (prop::sample::select(kinds), cut).prop_map(|(mut packet, (place, end, value, seal))| {
        packet.truncate(end.index(packet.len()) + 1);
        let place = place.index(packet.len());
        packet[place] = value;
        if let Some(length) = packet.len().checked_sub(5).filter(|_| seal) {
            packet[4..6.min(length + 5)].copy_from_slice(&(length as u16).to_be_bytes()[..2.min(length + 1)]);
            packet = sealed(&packet);
        }
        packet
    })
}

proptest! {
    #[test]
    fn no_bytes_panic_and_what_is_refused_leaves_no_command(
        packets in prop::collection::vec(
            prop_oneof![mutilated(), prop::collection::vec(any::<u8>(), 0..300)],
            1..6,
        ),
        keyed in any::<bool>(),
    ) {
        let mut link = if keyed { keyed_link() } else { open_link() };
        for packet in &packets {
            let before = link.clone();
            if link.receive(packet).is_err() {
                prop_assert_eq!(link.command(), before.command());
                prop_assert_eq!(link.upload.table(), before.upload.table());
            }
            link.conclude(Some(CommandOutcome::Done));
            for report in reports(&mut link) {
                prop_assert!(report.len() <= MAX_REPORT_BYTES);
            }
        }
    }

    #[test]
    fn a_flipped_bit_of_an_authentic_packet_is_refused_even_under_a_right_checksum(
        place in any::<prop::sample::Index>(),
        bit in 0u8..8,
    ) {
        let packet = packet(&Telecommand::Orbit(ORBIT), 7, Some((KEY, 66)));
        let mut content = packet[..packet.len() - 2].to_vec();
        let place = place.index(content.len());
        content[place] ^= 1u8 << bit;
        let mut link = keyed_link();
        prop_assert!(link.receive(&sealed(&content)).is_err());
        prop_assert_eq!(link.counter(), 65);
    }
}
