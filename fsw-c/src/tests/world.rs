//! What the tests fly: a detector of noise with a clock and a gyro, memory and outputs as C declares them.

use crate::doors::Bytes;
use crate::instruments::{AngularRateReading, Clock, Detector, Geometry, Instruments};
use crate::instruments::{MagneticFieldReading, Magnetometer, Meter, RateSensor, Reply, Shutter, Window};
use crate::memory::SensorMemory;
use crate::results::CycleResult;
use crate::status::Status;
use crate::*;
use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ptr::null_mut;
use fsw_core::attitude::filter::RateSensorNoise;
use fsw_core::camera::{CameraParameters, Distortion, Projection};
use fsw_core::parameters::Parameters;
use fsw_hal::{DetectorError, DetectorGeometry, LocalTime};
use std::boxed::Box;
use std::vec::Vec;

pub const GEOMETRY: Geometry = Geometry { width_px: 320, height_px: 256, bits: 10 };

/// Terrestrial Time of power-on, microseconds since J2000.0.
pub const POWER_ON_US: i64 = 800_000_000_000_000;

/// A detector of noise, a clock, a gyro and a meter in one, and what is to go wrong.
pub struct World {
    pub second: i64,
    /// What the detector's reading and the clock answer.
    pub reading: u32,
    pub clock: u32,
    pub rate: u32,
    pub marks: [u32; 2],
    /// What the shutters answer, and whether star path and Earth path were told to be open last, and the
    /// latter clear.
    pub shutter: u32,
    pub open: Option<[bool; 3]>,
    /// Whether every tenth pixel of every tenth row and the one beside it are hot.
    pub hot: bool,
    /// Whether the second before took too long.
    pub late: bool,
    /// A sensor to be called from within a callback with this parameter table, and what came of it.
    pub nested: *mut SensorMemory,
    pub table: Vec<u8>,
    pub nested_init: Status,
    pub nested_cycle: Status,
}

impl World {
    pub fn new() -> Box<Self> {
        Box::new(Self {
            second: 0,
            reading: Reply::Ok as u32,
            clock: Reply::Ok as u32,
            rate: Reply::Ok as u32,
            marks: [0; 2],
            shutter: Reply::Ok as u32,
            open: None,
            hot: false,
            late: false,
            nested: null_mut(),
            table: Vec::new(),
            nested_init: Status::Ok,
            nested_cycle: Status::Ok,
        })
    }

    pub fn local_us(&self) -> i64 {
        self.second * 1_000_000 + 50_000
    }

    /// Noise that differs from second to second.
    pub fn pixel(&self, x: u16, y: u16) -> u16 {
        if self.hot && is_hot(x, y) {
            return 900;
        }
        let place = (u32::from(y) << 16 | u32::from(x)) ^ (self.second as u32).wrapping_mul(0x85EB_CA6B);
        60 + (place.wrapping_mul(0x9E37_79B9) >> 28) as u16
    }

    pub fn instruments(&mut self) -> Instruments {
        let context = (&raw mut *self).cast();
        Instruments {
            detector: Detector {
                context,
                geometry: GEOMETRY,
                start_exposure: Some(start_exposure),
                finish_exposure: Some(local_time),
                read: Some(read),
            },
            clock: Clock { context, local_time: Some(local_time), terrestrial_time: Some(terrestrial_time) },
            rate_sensor: RateSensor { context, angular_rate: Some(angular_rate) },
            meter: Meter { context, begin: Some(begin), end: Some(end), overran: Some(overran) },
            shutter: Shutter { context, open: Some(open) },
            magnetometer: Magnetometer { context, magnetic_field: Some(magnetic_field) },
        }
    }
}

/// Which pixels are hot where some are.
pub fn is_hot(x: u16, y: u16) -> bool {
    y % 10 == 5 && matches!(x % 10, 5 | 6)
}

/// The world behind a context.
///
/// # Safety
/// The context is a world that nothing else uses.
pub unsafe fn world<'a>(context: *mut c_void) -> &'a mut World {
    // SAFETY: the caller's promise.
    unsafe { &mut *context.cast() }
}

unsafe extern "C" fn start_exposure(context: *mut c_void, _exposure_us: u32) -> u32 {
    // SAFETY: every context of these tests is a world.
    let world = unsafe { world(context) };
    if !world.nested.is_null() {
        let (mut outputs, mut sensor) = (Outputs::new(), null_mut());
        let instruments = world.instruments();
        let tables = tables(&world.table);
        let memory = world.nested.cast();
        // SAFETY: the memory is a sensor's; the calls are to be refused before it is touched.
        unsafe {
            world.nested_init = sextant_init(memory, sextant_sensor_bytes(), &tables, &mut sensor);
            world.nested_cycle = outputs.cycle(world.nested, &instruments, 0);
        }
    }
    Reply::Ok as u32
}

unsafe extern "C" fn local_time(context: *mut c_void, local_us: *mut i64) -> u32 {
    // SAFETY: as in `start_exposure`; the library lends a number.
    unsafe { local_us.write(world(context).local_us()) };
    Reply::Ok as u32
}

unsafe extern "C" fn terrestrial_time(context: *mut c_void, local_us: i64, terrestrial_us: *mut i64) -> u32 {
    // SAFETY: as in `local_time`.
    unsafe {
        terrestrial_us.write(POWER_ON_US + local_us);
        world(context).clock
    }
}

unsafe extern "C" fn read(context: *mut c_void, window: Window, pixels: *mut u16, count: usize) -> u32 {
    assert_eq!(count, usize::from(window.width) * usize::from(window.height));
    assert!(window.x + window.width <= GEOMETRY.width_px && window.y + window.height <= GEOMETRY.height_px);
    // SAFETY: as in `start_exposure`; the library lends room for `count` pixels.
    let (world, pixels) = unsafe { (world(context), core::slice::from_raw_parts_mut(pixels, count)) };
    for (row, y) in pixels.chunks_mut(usize::from(window.width).max(1)).zip(window.y..) {
        row.iter_mut().zip(window.x..).for_each(|(pixel, x)| *pixel = world.pixel(x, y));
    }
    world.reading
}

unsafe extern "C" fn angular_rate(context: *mut c_void, reading: *mut AngularRateReading) -> u32 {
    // SAFETY: as in `local_time`.
    unsafe {
        let world = world(context);
        reading.write(AngularRateReading { local_us: world.local_us(), rad_s: [1.0, 2.0, 3.0] });
        world.rate
    }
}

unsafe extern "C" fn magnetic_field(context: *mut c_void, reading: *mut MagneticFieldReading) -> u32 {
    // SAFETY: as in `local_time`.
    unsafe {
        let world = world(context);
        reading.write(MagneticFieldReading { local_us: world.local_us(), ut: [10.0, -20.0, 30.0] });
        world.rate
    }
}

unsafe extern "C" fn open(context: *mut c_void, star_path: bool, earth_path: bool, clear: bool) -> u32 {
    // SAFETY: as in `start_exposure`.
    let world = unsafe { world(context) };
    world.open = Some([star_path, earth_path, clear]);
    world.shutter
}

unsafe extern "C" fn begin(context: *mut c_void, stage: u32) {
    assert!(stage <= 10);
    // SAFETY: as in `start_exposure`.
    unsafe { world(context).marks[0] += 1 };
}

unsafe extern "C" fn end(context: *mut c_void, stage: u32) {
    assert!(stage <= 10);
    // SAFETY: as in `start_exposure`.
    unsafe { world(context).marks[1] += 1 };
}

unsafe extern "C" fn overran(context: *mut c_void) -> bool {
    // SAFETY: as in `start_exposure`.
    unsafe { world(context).late }
}

/// Memory as C declares it, zero at first. Held by a plain pointer, as C holds it.
pub struct Memory(*mut Place);

#[repr(align(8))]
struct Place([u8; SENSOR_BYTES]);

impl Memory {
    pub fn new() -> Self {
        Self(Box::into_raw(Box::new(Place([0; SENSOR_BYTES]))))
    }

    pub fn place(&self) -> *mut c_void {
        self.0.cast()
    }

    pub fn copy(&self) -> Self {
        let copy = Self::new();
        // SAFETY: both are memory of that length.
        unsafe { copy.0.cast::<MaybeUninit<Place>>().copy_from(self.0.cast(), 1) };
        copy
    }

    /// Whether it is as it was at first; for memory in which no sensor was made.
    pub fn is_untouched(&self) -> bool {
        // SAFETY: all of it was initialised.
        unsafe { (*self.0).0 }.iter().all(|byte| *byte == 0)
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: it came from a box, and a sensor in it owns nothing.
        drop(unsafe { Box::from_raw(self.0.cast::<MaybeUninit<Place>>()) });
    }
}

pub struct Outputs {
    pub telemetry: Box<[u8; TELEMETRY_BYTES]>,
    pub length: usize,
    pub result: CycleResult,
}

impl Outputs {
    pub fn new() -> Self {
        Self { telemetry: Box::new([0xA5; TELEMETRY_BYTES]), length: 0, result: CycleResult::default() }
    }

    /// # Safety
    /// As [`sextant_cycle`].
    pub unsafe fn cycle(
        &mut self,
        sensor: *mut SensorMemory,
        instruments: *const Instruments,
        command: u32,
    ) -> Status {
        let Self { telemetry, length, result } = self;
        let telemetry = telemetry.as_mut_ptr();
        // SAFETY: the caller's promise, and outputs of the right lengths.
        unsafe { sextant_cycle(sensor, instruments, command, telemetry, TELEMETRY_BYTES, length, result) }
    }

    pub fn frame(&self) -> &[u8] {
        &self.telemetry[..self.length]
    }
}

pub fn camera() -> CameraParameters {
    CameraParameters {
        width_px: GEOMETRY.width_px,
        height_px: GEOMETRY.height_px,
        focal_length_px: 750.0,
        optical_centre_px: [159.5, 127.5],
        projection: Projection::Rectilinear,
        distortion: Distortion::default(),
        corner_loss: 0.0,
        mirrored: false,
    }
}

pub fn parameters() -> Parameters {
    Parameters { rate_sensor: Some(RateSensorNoise::default()), ..Parameters::for_camera(camera()) }
}

pub fn encoded(parameters: &Parameters) -> Vec<u8> {
    let mut table = [0; PARAMETERS_BYTES];
    parameters.encode(&mut table).unwrap().to_vec()
}

/// These parameters with the reference catalogue and calibration.
pub fn tables(parameters: &[u8]) -> SensorTables {
    SensorTables {
        parameters: Bytes { data: parameters.as_ptr(), length: parameters.len() },
        catalogue: sextant_reference_catalogue(),
        calibration: sextant_reference_calibration(),
        bad_pixels: Bytes { data: core::ptr::null(), length: 0 },
    }
}

pub fn init(memory: &Memory, tables: &SensorTables) -> (Status, *mut SensorMemory) {
    let mut sensor = null_mut();
    // SAFETY: memory and tables are sound.
    let status = unsafe { sextant_init(memory.place(), SENSOR_BYTES, tables, &mut sensor) };
    (status, sensor)
}

/// Flies seconds and gives their telemetry and the last result.
pub fn fly(sensor: *mut SensorMemory, world: &mut World, seconds: i64) -> (Vec<u8>, CycleResult) {
    let (mut stream, mut outputs) = (Vec::new(), Outputs::new());
    for _ in 0..seconds {
        let instruments = world.instruments();
        // SAFETY: a sensor and whole instruments.
        assert_eq!(unsafe { outputs.cycle(sensor, &instruments, 0) }, Status::Ok);
        stream.extend_from_slice(outputs.frame());
        world.second += 1;
    }
    (stream, outputs.result)
}

/// The same world behind the traits.
pub struct HalWorld(pub Box<World>);

impl fsw_hal::ErrorType for HalWorld {
    type Error = DetectorError;
}

impl fsw_hal::Detector for HalWorld {
    fn geometry(&self) -> DetectorGeometry {
        let Geometry { width_px, height_px, bits } = GEOMETRY;
        DetectorGeometry { width_px, height_px, bits }
    }

    fn start_exposure(&mut self, _exposure_us: u32) -> Result<(), DetectorError> {
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(LocalTime::from_us(self.0.local_us()))
    }

    fn read(&mut self, window: fsw_hal::Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        for (row, y) in pixels.chunks_mut(usize::from(window.width)).zip(window.y..) {
            row.iter_mut().zip(window.x..).for_each(|(pixel, x)| *pixel = self.0.pixel(x, y));
        }
        Ok(())
    }
}
