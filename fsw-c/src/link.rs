//! The command link for C: bytes of telecommand packets in, bytes of report packets out.

use crate::areas::{Areas, CAreas};
use crate::calls::{Outputs, SENSOR_ALIGNMENT, fly};
use crate::doors::{Bytes, Extent, check, check_length, check_memory};
use crate::instruments::Instruments;
use crate::memory::{self, LinkMemory, SensorMemory};
use crate::results::CycleResult;
use crate::status::Status;
use core::ffi::c_void;
use fsw_core::command::{self, CommandLink, Key, Refusal};
use fsw_core::telemetry::Report;
use fsw_hal::LocalTime;

/// Bytes of memory that hold a link, on any machine of 32 or 64 bits; aligned as a sensor's.
pub const LINK_BYTES: usize = 1536;
/// Bytes that hold any report.
pub const REPORT_BYTES: usize = 226;
/// Longest telecommand, bytes.
pub const TELECOMMAND_BYTES: usize = 256;
/// Version of the list of commands that is obeyed; the first byte after the headers.
pub const TELECOMMANDS_VERSION: u8 = 2;

const _: () = assert!(size_of::<LinkMemory>() <= LINK_BYTES);
const _: () = assert!(align_of::<LinkMemory>() <= SENSOR_ALIGNMENT);
const _: () = assert!(REPORT_BYTES == command::MAX_REPORT_BYTES);
const _: () = assert!(TELECOMMAND_BYTES == command::MAX_TELECOMMAND_BYTES);
const _: () = assert!(TELECOMMANDS_VERSION == command::VERSION);

/// What a link is made of.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct LinkConfiguration {
    /// APID of the packets, both ways: 11 bits.
    pub apid: u16,
    /// Whether every packet must carry a tag by `key`.
    pub keyed: bool,
    /// The key: AES-128 of the CMAC. Copied.
    pub key: [u8; 16],
    /// Counter of the last packet, as `sextant_link_counter` gave it before power was lost; else 0.
    pub counter: u32,
    /// Memory of the files that are sent up; all zero where there is none.
    pub areas: Areas,
}

/// Makes a link in memory of the caller; one that was there is forgotten.
///
/// - `memory`: `memory_bytes` bytes, at least `SEXTANT_LINK_BYTES`, aligned to `SEXTANT_SENSOR_ALIGNMENT`, in
///   use until the last call. It must not be copied or moved. Zero it before the first call (a static object
///   is).
/// - `configuration`: APID, key and counter; memory of the areas, which is used until the last call.
/// - `link`: where the link's handle is written.
///
/// Returns `OK`; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments; `BUSY`. Unless `OK`, memory and
/// handle are as before.
///
/// # Safety
/// The pointers point to objects of their types and of the lengths given, or are refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_link_init(
    memory: *mut c_void,
    memory_bytes: usize,
    configuration: *const LinkConfiguration,
    link: *mut *mut LinkMemory,
) -> Status {
    let make = || {
        let place = check_memory::<LinkMemory>(memory, memory_bytes)?;
        check(configuration)?;
        check(link)?;
        Extent::of(place).check_apart(Extent::of(link))?;
        // SAFETY: not null and aligned; the rest is the caller's promise.
        let LinkConfiguration { apid, keyed, key, counter, areas } = unsafe { configuration.read() };
        // SAFETY: what the areas are is the caller's promise.
        let areas = unsafe { areas.lend(Extent::of(place)) }?;
        let made = CommandLink::with_areas(apid, keyed.then_some(Key::new(key)), counter, areas);
        // SAFETY: the caller promises the memory; it is aligned and long enough, and apart from the handle.
        unsafe {
            memory::make_link(place, made)?;
            link.write(place);
        }
        Ok(())
    };
    Status::of(make())
}

/// Takes one telecommand packet. What came of it is reported by `sextant_link_report`.
///
/// - `link`: the handle of `sextant_link_init`.
/// - `packet`: its bytes, from the first to the last, no more; at most `SEXTANT_TELECOMMAND_BYTES`.
/// - `refusal`: where 0 is written for an accepted packet, else the reason code.
///
/// Returns `OK`, also for a packet that is refused; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments;
/// `NOT_A_SENSOR`, `BUSY`. Unless `OK` nothing is changed.
///
/// # Safety
/// The pointers point to objects of their types and of the lengths given, or are refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_link_receive(
    link: *mut LinkMemory,
    packet: Bytes,
    refusal: *mut u32,
) -> Status {
    let receive = || {
        check(link)?;
        check(refusal)?;
        let used = Extent::of(link);
        used.check_apart(Extent::of(refusal))?;
        used.check_apart(Extent::of_bytes(packet.data, packet.length))?;
        // SAFETY: the caller promises the bytes.
        let bytes = unsafe { packet.slice()? };
        // SAFETY: the handle is aligned; that a link's memory stands behind it is the caller's promise.
        let reason =
            unsafe { memory::with_link(link, |link| link.receive(bytes).err().map(|it| it.reason)) }?;
        // SAFETY: not null and aligned, and apart from the link.
        unsafe { refusal.write(reason.map_or(0, Refusal::code).into()) };
        Ok(())
    };
    Status::of(receive())
}

/// Counter of the last packet whose tag was right. A program with a key stores it where it outlasts a loss of
/// power after every packet, before the next cycle.
///
/// Returns `OK`; `NULL`, `ALIGNMENT`, `OVERLAP` for the arguments; `NOT_A_SENSOR`, `BUSY`.
///
/// # Safety
/// The pointers point to objects of their types, or are refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_link_counter(link: *mut LinkMemory, counter: *mut u32) -> Status {
    let read = || {
        check(link)?;
        check(counter)?;
        Extent::of(link).check_apart(Extent::of(counter))?;
        // SAFETY: the handle is aligned; that a link's memory stands behind it is the caller's promise.
        let found = unsafe { memory::with_link(link, |link| link.counter()) }?;
        // SAFETY: not null and aligned, and apart from the link.
        unsafe { counter.write(found) };
        Ok(())
    };
    Status::of(read())
}

/// Flies one second as `sextant_cycle`, with the command that waits in the link, and goes on with the check
/// of a file that was sent up.
///
/// Returns what `sextant_cycle` returns. Unless `OK` nothing was flown, and the command waits on.
///
/// # Safety
/// As `sextant_cycle`, and `link` is the handle of `sextant_link_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_cycle_commanded(
    sensor: *mut SensorMemory,
    link: *mut LinkMemory,
    instruments: *const Instruments,
    telemetry: *mut u8,
    telemetry_bytes: usize,
    telemetry_length: *mut usize,
    result: *mut CycleResult,
) -> Status {
    let outputs = Outputs { telemetry, telemetry_bytes, telemetry_length, result };
    let commanded = || {
        check(sensor)?;
        check(link)?;
        outputs.check(Extent::of(sensor))?;
        outputs.check(Extent::of(link))?;
        Extent::of(sensor).check_apart(Extent::of(link))?;
        let second = |link: &mut CommandLink<CAreas>| {
            let kept = |report: &Report| (report.command, report.cycle, report.events.clone());
            // SAFETY: the caller's promises are the same; handle and outputs were checked.
            let flown = unsafe { fly(sensor, instruments, link.command(), &outputs, kept) };
            let (outcome, cycle, events) = flown?;
            link.conclude(outcome);
            link.log(cycle, &events);
            // SAFETY: as before. Where another call holds the sensor the check waits for the next second.
            let _ = unsafe { memory::with(sensor, |sensor, _| link.check_area(sensor.parameters())) };
            Ok(())
        };
        // SAFETY: the handle is aligned; that a link's memory stands behind it is the caller's promise.
        unsafe { memory::with_link(link, second) }?
    };
    Status::of(commanded())
}

/// Writes the next report packet, to be called until there is none.
///
/// - `link`: the handle of `sextant_link_init`.
/// - `sensor`: the handle of `sextant_init`: a dump sends its parameter table.
/// - `local_us`: the on-board counter now, microseconds; the time of the packet.
/// - `report`, `report_bytes`: where it is written, at least `SEXTANT_REPORT_BYTES`.
/// - `report_length`: where its length is written; 0 where no report waits.
///
/// Returns `OK`; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments; `NOT_A_SENSOR`, `BUSY`. Unless
/// `OK` nothing is written.
///
/// # Safety
/// The pointers point to objects of their types and of the lengths given, or are refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_link_report(
    link: *mut LinkMemory,
    sensor: *mut SensorMemory,
    local_us: i64,
    report: *mut u8,
    report_bytes: usize,
    report_length: *mut usize,
) -> Status {
    let write = || {
        check(link)?;
        check(sensor)?;
        check(report)?;
        check(report_length)?;
        check_length(report.addr(), report_bytes)?;
        if report_bytes < REPORT_BYTES {
            return Err(Status::Size);
        }
        let (packet, length) = (Extent::of_bytes(report, REPORT_BYTES), Extent::of(report_length));
        packet.check_apart(length)?;
        for used in [Extent::of(link), Extent::of(sensor)] {
            packet.check_apart(used)?;
            length.check_apart(used)?;
        }
        Extent::of(sensor).check_apart(Extent::of(link))?;
        // SAFETY: not null, of that length by the caller's promise, and apart from what else is used.
        let buffer = unsafe { &mut *report.cast::<[u8; REPORT_BYTES]>() };
        let now = LocalTime::from_us(local_us);
        // SAFETY: the handles are aligned; that their memories stand behind them is the caller's promise.
        let written = unsafe {
            memory::with_link(link, |link| {
                memory::with(sensor, |sensor, _| {
                    link.next_report(now, &sensor.downlink(), buffer).map_or(0, <[u8]>::len)
                })
            })
        }??;
        // SAFETY: not null and aligned.
        unsafe { report_length.write(written) };
        Ok(())
    };
    Status::of(write())
}
