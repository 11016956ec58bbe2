//! The calls of the C face.

use crate::doors::{Bytes, Extent, check, check_length, check_memory};
use crate::instruments::Instruments;
use crate::memory::{self, SensorMemory, Tables};
use crate::results::CycleResult;
use crate::status::Status;
use core::ffi::{CStr, c_char, c_void};
use fsw_core::catalog::{Catalogue, CatalogueError};
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::calibration::{Calibration, CalibrationError};
use fsw_core::image::defects::{Defects, DefectsError};
use fsw_core::packet::PacketError;
use fsw_core::parameters::{self, Parameters};
use fsw_core::sensor;
use fsw_core::telemetry::{self, Report};

/// Bytes of memory that hold a sensor, on any machine of 32 or 64 bits; `sextant_sensor_bytes` says how
/// many are used on this one.
pub const SENSOR_BYTES: usize = 46_464;
/// Alignment of that memory, bytes.
pub const SENSOR_ALIGNMENT: usize = 8;
/// Bytes that hold any telemetry frame with its length.
pub const TELEMETRY_BYTES: usize = 2560;
/// Bytes that hold any parameter table.
pub const PARAMETERS_BYTES: usize = 512;
/// Version of the telemetry frames' layout; their first byte after the length.
pub const TELEMETRY_VERSION: u8 = 17;
/// Version of the parameter table that is read; its first byte.
pub const PARAMETERS_VERSION: u8 = 27;

const _: () = assert!(size_of::<SensorMemory>() <= SENSOR_BYTES);
const _: () = assert!(align_of::<SensorMemory>() == SENSOR_ALIGNMENT);
const _: () = assert!(TELEMETRY_BYTES == telemetry::MAX_FRAME_BYTES);
const _: () = assert!(PARAMETERS_BYTES == parameters::MAX_TABLE_BYTES);
const _: () = assert!(TELEMETRY_VERSION == telemetry::VERSION);
const _: () = assert!(PARAMETERS_VERSION == parameters::VERSION);

/// The onboard catalogue of the reference field, built and checked by `catalog-gen`.
static REFERENCE_CATALOGUE: &[u8] = include_bytes!("../../catalog-gen/data/reference.cat");
/// Profiles and corrections of the reference camera, made by `sil-host calibrate`.
static REFERENCE_CALIBRATION: &[u8] = include_bytes!("../../sil-host/cameras/reference-calibrated.corr");

/// What the spacecraft wants of a second. More can be commanded through the link.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Go on.
    Continue = 0,
    /// Forget the attitude and acquire anew.
    Reacquire = 1,
    /// Forget attitude, orbit and what was learned of lens and rate sensor and begin with the self-test.
    Restart = 2,
    /// Go to safe mode, until `REACQUIRE` or `RESTART`.
    Safe = 3,
}

/// The tables that a sensor is made of.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SensorTables {
    /// Parameter table: version, postcard body, CRC-32. Copied; it need not last.
    pub parameters: Bytes,
    /// Star catalogue of `catalog-gen`, or `sextant_reference_catalogue()`. Not copied: it must last,
    /// unchanged, as long as the sensor.
    pub catalogue: Bytes,
    /// Calibration of lens and pixels, as `sil-host calibrate` writes it; empty where there is none. Used
    /// where the parameter table names it, and must last then, unchanged, as long as the sensor.
    pub calibration: Bytes,
    /// Bad pixels and offsets of columns of the detector, as `sil-host defects` writes them; empty where
    /// there are none. What the detector's callback reads is corrected by them. Not copied: they must last,
    /// unchanged, as long as the sensor.
    pub bad_pixels: Bytes,
}

/// The library's version, "major.minor.patch": a static string.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_version() -> *const c_char {
    const TEXT: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    const VERSION: &CStr = match CStr::from_bytes_with_nul(TEXT.as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// Bytes of memory that a sensor uses on this machine; at most `SEXTANT_SENSOR_BYTES`.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_sensor_bytes() -> usize {
    size_of::<SensorMemory>()
}

/// Alignment of that memory, bytes; equal to `SEXTANT_SENSOR_ALIGNMENT`.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_sensor_alignment() -> usize {
    align_of::<SensorMemory>()
}

/// The catalogue of the reference field, 24 x 19 deg. A program that does not call this does not link it.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_reference_catalogue() -> Bytes {
    Bytes::of(REFERENCE_CATALOGUE)
}

/// The calibration of the reference camera. A program that does not call this does not link it.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_reference_calibration() -> Bytes {
    Bytes::of(REFERENCE_CALIBRATION)
}

/// Makes a sensor that knows nothing yet in memory of the caller; one that was there is forgotten.
///
/// - `memory`: `memory_bytes` bytes, at least `sextant_sensor_bytes()`, aligned to
///   `SEXTANT_SENSOR_ALIGNMENT`, in use until the last cycle. It must not be copied or moved. Zero it
///   before the first call (a static object is): a sensor that was in a cycle when its task was ended
///   counts as busy until its memory is zeroed.
/// - `tables`: what the sensor is made of.
/// - `sensor`: where the sensor's handle is written.
///
/// Returns `OK`; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments; `PARAMETERS_...`,
/// `CATALOGUE_...`, `CALIBRATION_...`, `BAD_PIXELS_...` for the tables; `BUSY`. Unless `OK`, memory and
/// handle are as before: a sensor that was there flies on with its old tables.
///
/// # Safety
/// The pointers point to objects of their types and of the lengths given, or are refused; tables stay as
/// they are while the sensor is used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_init(
    memory: *mut c_void,
    memory_bytes: usize,
    tables: *const SensorTables,
    sensor: *mut *mut SensorMemory,
) -> Status {
    // SAFETY: the caller's promises are the same.
    Status::of(unsafe { init(memory, memory_bytes, tables, sensor) })
}

/// [`sextant_init`].
///
/// # Safety
/// As there.
unsafe fn init(
    memory: *mut c_void,
    memory_bytes: usize,
    tables: *const SensorTables,
    sensor: *mut *mut SensorMemory,
) -> Result<(), Status> {
    let place = check_memory::<SensorMemory>(memory, memory_bytes)?;
    check(tables)?;
    check(sensor)?;
    let used = Extent::of(place);
    used.check_apart(Extent::of(sensor))?;
    // SAFETY: not null and aligned; the rest is the caller's promise.
    let tables = unsafe { tables.read() };
    for lasting in [tables.catalogue, tables.calibration, tables.bad_pixels] {
        used.check_apart(Extent::of_bytes(lasting.data, lasting.length))?;
    }
    // SAFETY: the caller promises the tables and the memory; it is aligned and long enough, and no table
    // that is to last lies in it.
    unsafe {
        memory::make(place, open(&tables)?)?;
        sensor.write(place);
    }
    Ok(())
}

/// Opens the tables.
///
/// # Safety
/// As [`sextant_init`].
unsafe fn open(tables: &SensorTables) -> Result<Tables, Status> {
    // SAFETY: the caller promises the bytes, all but the first for as long as the sensor is used.
    let (parameters, catalogue, calibration, bad_pixels) = unsafe {
        let SensorTables { parameters, catalogue, calibration, bad_pixels } = tables;
        (parameters.slice()?, catalogue.slice()?, calibration.slice()?, bad_pixels.slice()?)
    };
    let parameters = Parameters::decode(parameters).map_err(|error| match error {
        PacketError::Version(_) => Status::ParametersVersion,
        _ => Status::ParametersDamaged,
    })?;
    let catalogue = Catalogue::open(catalogue).map_err(|error| match error {
        CatalogueError::Version(_) => Status::CatalogueVersion,
        _ => Status::CatalogueDamaged,
    })?;
    // As in the flight image: a table that names none flies without.
    let calibration = match (parameters.imaging.calibration_crc, calibration) {
        (0, _) => None,
        (_, []) => return Err(Status::CalibrationMismatch),
        (_, bytes) => Some(Calibration::open(bytes).map_err(|error| match error {
            CalibrationError::Version(_) => Status::CalibrationVersion,
            _ => Status::CalibrationDamaged,
        })?),
    };
    let bad_pixels = match bad_pixels {
        [] => None,
        bytes => Some(Defects::open(bytes).map_err(|error| match error {
            DefectsError::Version(_) => Status::BadPixelsVersion,
            _ => Status::BadPixelsDamaged,
        })?),
    };
    Ok(Tables { parameters, catalogue, calibration, bad_pixels })
}

/// Flies one second: exposes, reads, measures, and reports. To be called once a second.
///
/// - `sensor`: the handle of `sextant_init`.
/// - `instruments`: lent for this call; its callbacks run within it.
/// - `command`: one of `sextant_command`.
/// - `telemetry`: where the telemetry frame is written, led by its length (two bytes, little-endian), so
///   that frames one after the other are a stream.
/// - `telemetry_bytes`: its room, at least `SEXTANT_TELEMETRY_BYTES`.
/// - `telemetry_length`: where the number of bytes written is written.
/// - `result`: where the main results are written.
///
/// Returns `OK`, also for a second in which an instrument failed: `result->faults` says so. `NULL`, `SIZE`,
/// `ALIGNMENT`, `OVERLAP`, `COMMAND`, `INSTRUMENTS` for the arguments; `NOT_A_SENSOR`, `BUSY`. Unless `OK`
/// nothing was flown and nothing written.
///
/// # Safety
/// The pointers point to objects of their types and of the lengths given, or are refused; the callbacks are
/// what their types and their documentation say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_cycle(
    sensor: *mut SensorMemory,
    instruments: *const Instruments,
    command: u32,
    telemetry: *mut u8,
    telemetry_bytes: usize,
    telemetry_length: *mut usize,
    result: *mut CycleResult,
) -> Status {
    let outputs = Outputs { telemetry, telemetry_bytes, telemetry_length, result };
    // SAFETY: the caller's promises are the same.
    Status::of(unsafe { cycle(sensor, instruments, command, &outputs) })
}

/// Where a cycle writes.
pub(crate) struct Outputs {
    pub(crate) telemetry: *mut u8,
    pub(crate) telemetry_bytes: usize,
    pub(crate) telemetry_length: *mut usize,
    pub(crate) result: *mut CycleResult,
}

impl Outputs {
    /// Refuses what cannot be written, or would be written into the sensor or into one another.
    pub(crate) fn check(&self, sensor: Extent) -> Result<(), Status> {
        check(self.telemetry)?;
        check(self.telemetry_length)?;
        check(self.result)?;
        check_length(self.telemetry.addr(), self.telemetry_bytes)?;
        if self.telemetry_bytes < TELEMETRY_BYTES {
            return Err(Status::Size);
        }
        let telemetry = Extent::of_bytes(self.telemetry, TELEMETRY_BYTES);
        let (length, result) = (Extent::of(self.telemetry_length), Extent::of(self.result));
        for (one, other) in [(telemetry, length), (telemetry, result), (length, result)] {
            one.check_apart(other)?;
        }
        for output in [telemetry, length, result] {
            output.check_apart(sensor)?;
        }
        Ok(())
    }

    /// Writes what a second came to. (Not inlined: the struct is not to lie under the second on the stack.)
    ///
    /// # Safety
    /// [`Outputs::check`] found nothing, and the outputs are what their types say.
    #[inline(never)]
    unsafe fn write(&self, report: &Report) -> Result<(), Status> {
        // SAFETY: not null, of that length by the caller's promise, and apart from the other outputs.
        let frame = unsafe { core::slice::from_raw_parts_mut(self.telemetry, TELEMETRY_BYTES) };
        let length = telemetry::encode_next(report, frame).map_err(|_| Status::Telemetry)?.len();
        // SAFETY: not null and aligned; the rest is the caller's promise.
        unsafe {
            self.telemetry_length.write(length);
            self.result.write(CycleResult::from(report));
        }
        Ok(())
    }
}

/// [`sextant_cycle`].
///
/// # Safety
/// As there.
unsafe fn cycle(
    sensor: *mut SensorMemory,
    instruments: *const Instruments,
    command: u32,
    outputs: &Outputs,
) -> Result<(), Status> {
    check(sensor)?;
    outputs.check(Extent::of(sensor))?;
    let command = flight_command(command)?;
    // SAFETY: the caller's promises are the same, and the outputs were checked.
    unsafe { fly(sensor, instruments, command, outputs, |_| ()) }
}

/// The instruments, or why they cannot be used.
///
/// # Safety
/// As [`sextant_cycle`].
unsafe fn whole(instruments: *const Instruments) -> Result<Instruments, Status> {
    check(instruments)?;
    // SAFETY: not null and aligned; the rest is the caller's promise.
    let instruments = unsafe { instruments.read() };
    if instruments.are_complete() { Ok(instruments) } else { Err(Status::Instruments) }
}

/// Flies a second with a command; what is `kept` of its report.
///
/// # Safety
/// As [`sextant_cycle`]; the sensor's handle and the outputs were checked.
pub(crate) unsafe fn fly<Kept>(
    sensor: *mut SensorMemory,
    instruments: *const Instruments,
    command: sensor::Command,
    outputs: &Outputs,
    kept: impl FnOnce(&Report) -> Kept,
) -> Result<Kept, Status> {
    // SAFETY: the caller's promise is the same.
    let lent = unsafe { whole(instruments) }?;
    // SAFETY: the caller promises the callbacks, for this call.
    let (mut detector, mut clock, mut rate_sensor, mut magnetometer, mut meter, mut shutter) =
        unsafe { lent.lend() };
    let second = |sensor: &mut sensor::Sensor, bad_pixels: Option<Defects<'static>>| {
        let defects = bad_pixels.unwrap_or(Defects::none(lent.detector.size_px()));
        let corrected = BadPixelDetector::new(&mut detector, defects);
        let mut instruments = sensor::Instruments {
            detector: &mut corrected.map_err(|_| Status::Instruments)?,
            clock: &mut clock,
            meter: &mut meter,
            rate_sensor: &mut rate_sensor,
            magnetometer: &mut magnetometer,
            shutter: &mut shutter,
        };
        let report = sensor.cycle(&mut instruments, command);
        // SAFETY: the outputs were checked; the rest is the caller's promise.
        unsafe { outputs.write(&report) }.map(|()| kept(&report))
    };
    // SAFETY: the handle is aligned; that a sensor's memory stands behind it is the caller's promise, and
    // the outputs lie outside of it.
    unsafe { memory::with(sensor, second) }?
}

/// The flight code's command for a number.
fn flight_command(command: u32) -> Result<sensor::Command<'static>, Status> {
    const CONTINUE: u32 = Command::Continue as u32;
    const REACQUIRE: u32 = Command::Reacquire as u32;
    const RESTART: u32 = Command::Restart as u32;
    const SAFE: u32 = Command::Safe as u32;
    match command {
        CONTINUE => Ok(sensor::Command::Continue),
        REACQUIRE => Ok(sensor::Command::Reacquire),
        RESTART => Ok(sensor::Command::Restart),
        SAFE => Ok(sensor::Command::Safe),
        _ => Err(Status::Command),
    }
}
