//! The command link as C uses it.

use super::world::{Memory, Outputs, World, encoded, init, parameters, tables};
use crate::areas::{Area, Areas};
use crate::doors::Bytes;
use crate::instruments::Reply;
use crate::results::{CommandResult, Mode};
use crate::status::Status;
use crate::*;
use core::ffi::c_void;
use core::ptr::null_mut;
use fsw_core::checksum::crc32;
use fsw_core::command::ground::{self, Envelope};
use fsw_core::command::{Key, Refusal, Telecommand};
use fsw_hal::Area as HalArea;
use memory::{LinkMemory, SensorMemory};
use std::vec::Vec;

const APID: u16 = 0x155;
const KEY: [u8; 16] = [7; 16];

#[repr(align(8))]
struct Place([u8; LINK_BYTES]);

const NOTHING: Bytes = Bytes { data: core::ptr::null(), length: 0 };
const NO_AREAS: Areas = Areas {
    context: null_mut(),
    catalogue: NOTHING,
    calibration: NOTHING,
    bad_pixels: NOTHING,
    write: None,
    mark_whole: None,
};

fn configuration() -> LinkConfiguration {
    LinkConfiguration { apid: APID, keyed: true, key: KEY, counter: 40, areas: NO_AREAS }
}

fn make(place: &mut Place, configuration: &LinkConfiguration) -> *mut LinkMemory {
    let mut link = null_mut();
    // SAFETY: memory of that length, and a configuration.
    let status =
        unsafe { sextant_link_init((&raw mut place.0).cast(), LINK_BYTES, configuration, &mut link) };
    assert_eq!(status, Status::Ok);
    link
}

fn packet(telecommand: &Telecommand, counter: u32) -> Vec<u8> {
    let envelope =
        Envelope { apid: APID, sequence: counter as u16, authentication: Some((Key::new(KEY), counter)) };
    ground::encode(telecommand, &envelope, &mut [0; TELECOMMAND_BYTES]).unwrap().to_vec()
}

fn receive(link: *mut LinkMemory, packet: &[u8]) -> u32 {
    let mut refusal = u32::MAX;
    let packet = Bytes { data: packet.as_ptr(), length: packet.len() };
    // SAFETY: a link, and bytes.
    assert_eq!(unsafe { sextant_link_receive(link, packet, &mut refusal) }, Status::Ok);
    refusal
}

/// Service and subservice of all reports that wait.
fn reports(link: *mut LinkMemory, sensor: *mut SensorMemory) -> Vec<(u8, u8)> {
    let (mut report, mut length) = ([0; REPORT_BYTES], 0);
    let mut next = || {
        let place = report.as_mut_ptr();
        // SAFETY: a link, a sensor, and a buffer of that length.
        let status =
            unsafe { sextant_link_report(link, sensor, 5_000_000, place, REPORT_BYTES, &mut length) };
        assert_eq!(status, Status::Ok);
        (length > 0).then_some((report[7], report[8]))
    };
    core::iter::from_fn(&mut next).collect()
}

fn fly(sensor: *mut SensorMemory, link: *mut LinkMemory, world: &mut World, outputs: &mut Outputs) {
    world.second += 1;
    let (instruments, telemetry) = (world.instruments(), outputs.telemetry.as_mut_ptr());
    let Outputs { length, result, .. } = outputs;
    // SAFETY: a sensor, a link, whole instruments, and outputs of the right lengths.
    let status = unsafe {
        sextant_cycle_commanded(sensor, link, &instruments, telemetry, TELEMETRY_BYTES, length, result)
    };
    assert_eq!(status, Status::Ok);
}

#[test]
fn a_command_by_packet_is_done_and_reported() {
    let (memory, mut world, mut outputs) = (Memory::new(), World::new(), Outputs::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let mut place = Place([0; LINK_BYTES]);
    let link = make(&mut place, &configuration());

    assert_eq!(receive(link, &packet(&Telecommand::Safe, 41)), 0);
    let mut counter = 0;
    // SAFETY: a link and a number.
    assert_eq!(unsafe { sextant_link_counter(link, &mut counter) }, Status::Ok);
    assert_eq!(counter, 41);
    fly(sensor, link, &mut world, &mut outputs);
    assert_eq!((outputs.result.command, outputs.result.refusal), (CommandResult::Done, 0));
    assert_eq!(outputs.result.mode, Mode::CommandedSafe);
    assert_eq!(reports(link, sensor), [(1, 1), (1, 7)]);

    // It is sent again; an exposure out of range; the table in force.
    assert_eq!(receive(link, &packet(&Telecommand::Safe, 41)), u32::from(Refusal::Counter.code()));
    assert_eq!(receive(link, &packet(&Telecommand::Exposure(1), 42)), 0);
    fly(sensor, link, &mut world, &mut outputs);
    let refused = u32::from(Refusal::Exposure.code());
    assert_eq!((outputs.result.command, outputs.result.refusal), (CommandResult::Refused, refused));
    assert_eq!(receive(link, &packet(&Telecommand::Dump, 43)), 0);
    let told = reports(link, sensor);
    assert_eq!(told[..4], [(1, 2), (1, 1), (1, 8), (1, 1)]);
    assert_eq!((told[4], told.last()), ((129, 4), Some(&(1, 7))));
    fly(sensor, link, &mut world, &mut outputs);
    assert_eq!(outputs.result.command, CommandResult::None);
}

/// A spare copy of the bad pixels.
struct Spare {
    bytes: [u8; 4096],
    marked: Option<(u32, usize, u32)>,
}

unsafe extern "C" fn write(
    context: *mut c_void,
    area: u32,
    offset: usize,
    part: *const u8,
    length: usize,
) -> u32 {
    if area != Area::BadPixels as u32 {
        return Reply::Bus as u32;
    }
    if !offset.is_multiple_of(8) {
        return Reply::Alignment as u32;
    }
    // SAFETY: the context is a spare copy whose bytes nobody borrows now, and the part has that length.
    unsafe { (&raw mut (*context.cast::<Spare>()).bytes).cast::<u8>().add(offset).copy_from(part, length) };
    Reply::Ok as u32
}

unsafe extern "C" fn mark_whole(context: *mut c_void, area: u32, length: usize, crc: u32) -> u32 {
    // SAFETY: the context is a spare copy.
    unsafe { (*context.cast::<Spare>()).marked = Some((area, length, crc)) };
    Reply::Ok as u32
}

/// A table of no bad pixels of a detector of this size.
fn bad_pixels(width: u16, height: u16) -> Vec<u8> {
    let words = [width, height, 0, 0, 0, 0].into_iter().chain((0..=height).map(|_| 0));
    let body: Vec<u8> = words.flat_map(u16::to_le_bytes).collect();
    let length = (16 + body.len() as u32).to_le_bytes();
    let protected = [&length[..], &body].concat();
    [b"SXDF\x01\x00\x1c\x00", &crc32(&protected).to_le_bytes()[..], &protected].concat()
}

#[test]
fn a_file_that_is_sent_up_is_written_checked_and_marked_by_callbacks() {
    let (memory, mut world, mut outputs) = (Memory::new(), World::new(), Outputs::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let mut spare = Spare { bytes: [0xFF; 4096], marked: None };
    let context = &raw mut spare;
    // SAFETY: a place within the spare copy.
    let copy = unsafe { Bytes { data: (&raw const (*context).bytes).cast(), length: 4096 } };
    let areas = Areas {
        context: context.cast(),
        bad_pixels: copy,
        write: Some(write),
        mark_whole: Some(mark_whole),
        ..NO_AREAS
    };
    let mut place = Place([0; LINK_BYTES]);
    let link = make(&mut place, &LinkConfiguration { areas, ..configuration() });
    let camera = parameters().camera;
    let table = bad_pixels(camera.width_px, camera.height_px);
    let mut counter = 40;
    let mut send = |telecommand: &Telecommand| {
        counter += 1;
        receive(link, &packet(telecommand, counter))
    };
    // SAFETY: nothing else uses the spare copy now.
    let marked = || unsafe { (*context).marked };
    for telecommand in ground::upload(Some(HalArea::BadPixels), &table, 192) {
        assert_eq!(send(&telecommand), 0);
        reports(link, sensor);
    }
    let mut told = Vec::new();
    for _ in 0..=table.len().div_ceil(4096) {
        assert_eq!((marked(), told.len()), (None, 0));
        fly(sensor, link, &mut world, &mut outputs);
        told = reports(link, sensor);
    }
    assert_eq!(told, [(1, 7)]);
    assert_eq!(marked(), Some((Area::BadPixels as u32, table.len(), crc32(&table))));
    // No catalogue is taken; a part that begins within a word; one beyond the room.
    let part = |area, offset, bytes| Telecommand::Part { area: Some(area), offset, bytes };
    let refused = |reason: Refusal| u32::from(reason.code());
    assert_eq!(send(&part(HalArea::Catalogue, 0, &[1])), refused(Refusal::Area));
    assert_eq!(send(&part(HalArea::BadPixels, 0, &[1; 3])), 0);
    assert_eq!(send(&part(HalArea::BadPixels, 3, &[1])), refused(Refusal::Part));
    for number in 0..20 {
        assert_eq!(send(&part(HalArea::BadPixels, 200 * number, &[1; 200])), 0);
        reports(link, sensor);
    }
    assert_eq!(send(&part(HalArea::BadPixels, 4000, &[1; 97])), refused(Refusal::Part));
}

#[test]
fn spoilt_areas_are_refused() {
    let mut place = Place([0; LINK_BYTES]);
    let bytes = [0u8; 64];
    let sound = Bytes { data: bytes.as_ptr(), length: 64 };
    let areas = Areas { catalogue: sound, write: Some(write), mark_whole: Some(mark_whole), ..NO_AREAS };
    let within = Bytes { data: (&raw const place.0).cast(), length: 64 };
    let mut handle = null_mut();
    for (areas, how) in [
        (Areas { write: None, ..areas }, Status::Null),
        (Areas { mark_whole: None, ..areas }, Status::Null),
        (Areas { bad_pixels: Bytes { length: 1, ..NOTHING }, ..areas }, Status::Null),
        (Areas { calibration: Bytes { length: usize::MAX, ..sound }, ..areas }, Status::Size),
        (Areas { calibration: within, ..areas }, Status::Overlap),
        (areas, Status::Ok),
    ] {
        let configuration = LinkConfiguration { areas, ..configuration() };
        let memory = (&raw mut place.0).cast();
        // SAFETY: memory of that length; what is wrong with the areas is refused.
        let status = unsafe { sextant_link_init(memory, LINK_BYTES, &configuration, &mut handle) };
        assert_eq!((status, handle.is_null()), (how, how != Status::Ok));
    }
}

#[test]
fn spoilt_arguments_of_the_link_are_refused() {
    let (memory, mut place) = (Memory::new(), Place([0; LINK_BYTES]));
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let place_of = |place: &mut Place| (&raw mut place.0).cast::<core::ffi::c_void>();
    let mut handle = null_mut();
    let (mut refusal, mut length) = (0u32, 0usize);
    let mut report = [0u8; REPORT_BYTES];
    // SAFETY: what is null, misaligned, short, overlapping or no link is refused; the rest is sound.
    unsafe {
        let at = place_of(&mut place);
        let wanted = configuration();
        for (memory, bytes, how) in [
            (null_mut(), LINK_BYTES, Status::Null),
            (at, 64, Status::Size),
            (at.wrapping_byte_add(1), LINK_BYTES - 1, Status::Alignment),
        ] {
            assert_eq!(sextant_link_init(memory, bytes, &wanted, &mut handle), how);
        }
        assert_eq!(sextant_link_init(at, LINK_BYTES, core::ptr::null(), &mut handle), Status::Null);
        assert_eq!(sextant_link_init(at, LINK_BYTES, &wanted, at.cast()), Status::Overlap);
        assert!(handle.is_null() && place.0.iter().all(|byte| *byte == 0));

        let link = make(&mut place, &configuration());
        let nothing = Bytes { data: core::ptr::null(), length: 0 };
        assert_eq!(sextant_link_receive(null_mut(), nothing, &mut refusal), Status::Null);
        assert_eq!(sextant_link_receive(link, nothing, null_mut()), Status::Null);
        assert_eq!(sextant_link_receive(link, nothing, link.cast()), Status::Overlap);
        let within = Bytes { data: link.cast(), length: 4 };
        assert_eq!(sextant_link_receive(link, within, &mut refusal), Status::Overlap);
        assert_eq!(sextant_link_receive(link, Bytes { length: 4, ..nothing }, &mut refusal), Status::Null);
        // A sensor is no link and a link no sensor.
        assert_eq!(sextant_link_receive(sensor.cast(), nothing, &mut refusal), Status::NotASensor);
        assert_eq!(sextant_link_counter(sensor.cast(), &mut refusal), Status::NotASensor);
        let write = report.as_mut_ptr();
        for (link, sensor, bytes, how) in [
            (null_mut(), sensor, REPORT_BYTES, Status::Null),
            (link, null_mut(), REPORT_BYTES, Status::Null),
            (link, sensor, REPORT_BYTES - 1, Status::Size),
            (link, link.cast(), REPORT_BYTES, Status::Overlap),
        ] {
            assert_eq!(sextant_link_report(link, sensor, 0, write, bytes, &mut length), how);
        }
        assert_eq!(
            sextant_link_report(link, sensor, 0, link.cast(), REPORT_BYTES, &mut length),
            Status::Overlap
        );
        let (mut world, mut outputs) = (World::new(), Outputs::new());
        let (instruments, frame) = (world.instruments(), outputs.telemetry.as_mut_ptr());
        let Outputs { length, result, .. } = &mut outputs;
        for (sensor, link, how) in [
            (null_mut(), link, Status::Null),
            (sensor, null_mut(), Status::Null),
            (sensor, sensor.cast(), Status::Overlap),
            (link.cast(), sensor.cast(), Status::NotASensor),
        ] {
            let status =
                sextant_cycle_commanded(sensor, link, &instruments, frame, TELEMETRY_BYTES, length, result);
            assert_eq!(status, how);
        }
    }
    assert_eq!((refusal, length), (0, 0));
}
