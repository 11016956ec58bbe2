//! The instruments as C lends them: callbacks with a context, behind the traits of `fsw-hal`.
//!
//! In: a [`Instruments`] of function pointers. Out: a detector, a clock, a rate sensor, shutters and a
//! stage meter that the flight code calls. What a callback answers is a [`Reply`]; any other number counts as
//! a failed link.

use core::ffi::c_void;
use fsw_hal::{
    AngularRate, ClockError, DetectorError, DetectorGeometry, LocalTime, MagneticField, OpenPaths,
    ReadingError, ShutterError, Stage, StageMeter, Window as HalWindow,
};

/// What a callback answers. Any other number counts as `BUS`.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Done.
    Ok = 0,
    /// Any instrument: it did not answer in time.
    Timeout = 1,
    /// Any instrument: the link to it reported an error.
    Bus = 2,
    /// Detector: nothing has been exposed since power-on.
    NotExposed = 3,
    /// Detector: it cannot do this exposure time.
    Exposure = 4,
    /// Clock: its correlation with Terrestrial Time is not known.
    NotSynchronised = 5,
    /// Rate sensor: there is no reading since the last one was taken.
    NoReading = 6,
    /// Rate sensor: the rate is beyond its range.
    Saturated = 7,
    /// Shutters: one did not arrive where it was sent.
    Stuck = 8,
    /// Memory of an area: no word of it begins where the part does.
    Alignment = 9,
}

/// Fixed properties of a detector.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Geometry {
    /// Number of columns, px, at least 1; that of the parameter table.
    pub width_px: u16,
    /// Number of rows, px, at least 1; that of the parameter table.
    pub height_px: u16,
    /// Resolution of the converter, 1 to 16: full scale is 2^bits - 1.
    pub bits: u8,
}

/// A rectangle of pixels. Pixels count x right and y down; the centre of the first pixel read is (0, 0).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Column of the first pixel, px.
    pub x: u16,
    /// Row of the first pixel, px.
    pub y: u16,
    /// Number of columns, px.
    pub width: u16,
    /// Number of rows, px.
    pub height: u16,
}

/// The active-pixel detector. At most one exposure a cycle, then any number of windows of that image; a
/// window read twice gives the same values. All callbacks are needed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Detector {
    /// Handed to every callback of the detector; may be null.
    pub context: *mut c_void,
    /// Size and resolution; the same in every cycle.
    pub geometry: Geometry,
    /// Begins a new image, integrating for `exposure_us` microseconds, and returns without waiting for it.
    /// Answers `OK`, `EXPOSURE`, `TIMEOUT` or `BUS`.
    pub start_exposure: Option<unsafe extern "C" fn(context: *mut c_void, exposure_us: u32) -> u32>,
    /// Waits until the image that was begun can be read and writes the local time of the middle of its
    /// exposure to `local_us`, microseconds since power-on (of a rolling shutter: the middle row's).
    /// Answers `OK`, `NOT_EXPOSED`, `TIMEOUT` or `BUS`.
    pub finish_exposure: Option<unsafe extern "C" fn(context: *mut c_void, local_us: *mut i64) -> u32>,
    /// Reads `window` of the last image into `pixels`, row by row, raw digital numbers, right-aligned.
    /// `pixels` has room for `count` = width x height values; the window lies on the detector whole.
    /// Answers `OK`, `NOT_EXPOSED`, `TIMEOUT` or `BUS`; unless `OK`, the pixels are not used.
    pub read: Option<
        unsafe extern "C" fn(context: *mut c_void, window: Window, pixels: *mut u16, count: usize) -> u32,
    >,
}

impl Detector {
    /// Columns and rows, px.
    pub(crate) fn size_px(&self) -> [u16; 2] {
        [self.geometry.width_px, self.geometry.height_px]
    }
}

/// The on-board counter and its correlation with Terrestrial Time. Both callbacks are needed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Handed to every callback of the clock; may be null.
    pub context: *mut c_void,
    /// Writes the counter now to `local_us`, microseconds since power-on; never less than at the call
    /// before. Answers `OK`, `TIMEOUT` or `BUS`.
    pub local_time: Option<unsafe extern "C" fn(context: *mut c_void, local_us: *mut i64) -> u32>,
    /// Writes Terrestrial Time at the local instant `local_us` of the last seconds to `terrestrial_us`,
    /// microseconds since J2000.0 (2000-01-01T12:00:00 TT). An error of a millisecond displaces a low
    /// satellite by 8 m. Answers `OK`, `NOT_SYNCHRONISED`, `TIMEOUT` or `BUS`.
    pub terrestrial_time:
        Option<unsafe extern "C" fn(context: *mut c_void, local_us: i64, terrestrial_us: *mut i64) -> u32>,
}

/// A reading of the body's rate.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngularRateReading {
    /// Middle of the time it was taken over, local time, microseconds since power-on.
    pub local_us: i64,
    /// Rate of the body against inertial space about the x, y, z axes of the Earth path, rad/s, as the
    /// sensor has it: bias, scale and alignment are not corrected.
    pub rad_s: [f32; 3],
}

/// The rate sensor (gyro). Asked only where the parameter table says how good it is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RateSensor {
    /// Handed to the callback; may be null.
    pub context: *mut c_void,
    /// Writes the newest reading. Answers `OK`, `NO_READING`, `SATURATED`, `TIMEOUT` or `BUS`. Null: none
    /// on board.
    pub angular_rate:
        Option<unsafe extern "C" fn(context: *mut c_void, reading: *mut AngularRateReading) -> u32>,
}

/// A reading of the magnetic flux density.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticFieldReading {
    /// Middle of the time it was taken over, local time, microseconds since power-on.
    pub local_us: i64,
    /// Flux density along the x, y, z axes of the Earth path, microtesla, as the sensor has it: the
    /// spacecraft's own field is in it.
    pub ut: [f32; 3],
}

/// The magnetometer. Asked only where the parameter table says how good it is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Magnetometer {
    /// Handed to the callback; may be null.
    pub context: *mut c_void,
    /// Writes the newest reading. Answers `OK`, `NO_READING`, `SATURATED`, `TIMEOUT` or `BUS`. Null: none
    /// on board.
    pub magnetic_field:
        Option<unsafe extern "C" fn(context: *mut c_void, reading: *mut MagneticFieldReading) -> u32>,
}

/// The shutters of the two paths and the filter of the Earth path. Moved only where the parameter table says
/// which there are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Shutter {
    /// Handed to the callback; may be null.
    pub context: *mut c_void,
    /// Opens the star path, the Earth path or both and shuts the other; `clear`: the Earth path's filter is
    /// to be out of the way, else in it. Returns when they stand so. Called in every cycle before the
    /// exposure. Answers `OK`, `STUCK`, `TIMEOUT` or `BUS`. Null: none on board.
    pub open: Option<
        unsafe extern "C" fn(context: *mut c_void, star_path: bool, earth_path: bool, clear: bool) -> u32,
    >,
}

/// Receives the marks between which the stages of a cycle are measured; stage 0 scan, 1 identify, 2
/// predict, 3 windows, 4 confirm, 5 limb, 6 centre, 7 orbit, 8 search, 9 streaks, 10
/// image.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Meter {
    /// Handed to the callbacks; may be null.
    pub context: *mut c_void,
    /// A stage begins; null where nothing is measured.
    pub begin: Option<unsafe extern "C" fn(context: *mut c_void, stage: u32)>,
    /// A stage ends; null where nothing is measured.
    pub end: Option<unsafe extern "C" fn(context: *mut c_void, stage: u32)>,
    /// Whether the last cycle took longer than it may, by a timer of your own: asked once as a cycle begins,
    /// which tells it as an event. Null: it did not.
    pub overran: Option<unsafe extern "C" fn(context: *mut c_void) -> bool>,
}

/// The instruments, lent for one cycle. The callbacks run on the caller's stack, within `sextant_cycle`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Instruments {
    /// The detector behind both paths.
    pub detector: Detector,
    /// Local time and Terrestrial Time.
    pub clock: Clock,
    /// The body's rate; all zero where there is none.
    pub rate_sensor: RateSensor,
    /// The stages' marks; all zero where nothing is measured.
    pub meter: Meter,
    /// The shutters of the paths; all zero where there are none.
    pub shutter: Shutter,
    /// The magnetic field; all zero where there is no magnetometer.
    pub magnetometer: Magnetometer,
}

impl Instruments {
    /// Whether no callback of detector and clock is missing and the geometry is possible.
    pub(crate) fn are_complete(&self) -> bool {
        let Self { detector, clock, .. } = self;
        let Geometry { width_px, height_px, bits } = detector.geometry;
        let possible = width_px > 0 && height_px > 0 && (1..=16).contains(&bits);
        let exposes = detector.start_exposure.is_some() && detector.finish_exposure.is_some();
        possible
            && exposes
            && detector.read.is_some()
            && clock.local_time.is_some()
            && clock.terrestrial_time.is_some()
    }

    /// The instruments behind the traits of `fsw-hal`. One without its callback answers as a failed link;
    /// rate sensor and magnetometer without one never have a reading, shutters without one stay open, marks
    /// are dropped.
    ///
    /// # Safety
    /// The callbacks are what their types and their documentation say, for as long as what is given is
    /// used.
    pub(crate) unsafe fn lend(self) -> (CDetector, CClock, CRateSensor, CMagnetometer, CMeter, CShutter) {
        let Self { detector, clock, rate_sensor, meter, shutter, magnetometer } = self;
        let (rate_sensor, magnetometer) = (CRateSensor(rate_sensor), CMagnetometer(magnetometer));
        (CDetector(detector), CClock(clock), rate_sensor, magnetometer, CMeter(meter), CShutter(shutter))
    }
}

/// What a detector's answer means.
fn detector_reply(reply: u32) -> Result<(), DetectorError> {
    const OK: u32 = Reply::Ok as u32;
    const TIMEOUT: u32 = Reply::Timeout as u32;
    const NOT_EXPOSED: u32 = Reply::NotExposed as u32;
    const EXPOSURE: u32 = Reply::Exposure as u32;
    match reply {
        OK => Ok(()),
        TIMEOUT => Err(DetectorError::Timeout),
        NOT_EXPOSED => Err(DetectorError::NotExposed),
        EXPOSURE => Err(DetectorError::Exposure),
        _ => Err(DetectorError::Bus),
    }
}

/// What a clock's answer means.
fn clock_reply(reply: u32) -> Result<(), ClockError> {
    const OK: u32 = Reply::Ok as u32;
    const TIMEOUT: u32 = Reply::Timeout as u32;
    const NOT_SYNCHRONISED: u32 = Reply::NotSynchronised as u32;
    match reply {
        OK => Ok(()),
        TIMEOUT => Err(ClockError::Timeout),
        NOT_SYNCHRONISED => Err(ClockError::NotSynchronised),
        _ => Err(ClockError::Bus),
    }
}

/// What the answer of a rate sensor or a magnetometer means: whether there is a reading.
fn reading_reply(reply: u32) -> Result<bool, ReadingError> {
    const OK: u32 = Reply::Ok as u32;
    const TIMEOUT: u32 = Reply::Timeout as u32;
    const NO_READING: u32 = Reply::NoReading as u32;
    const SATURATED: u32 = Reply::Saturated as u32;
    match reply {
        OK => Ok(true),
        NO_READING => Ok(false),
        TIMEOUT => Err(ReadingError::Timeout),
        SATURATED => Err(ReadingError::Saturated),
        _ => Err(ReadingError::Bus),
    }
}

/// What the shutters' answer means.
fn shutter_reply(reply: u32) -> Result<(), ShutterError> {
    const OK: u32 = Reply::Ok as u32;
    const TIMEOUT: u32 = Reply::Timeout as u32;
    const STUCK: u32 = Reply::Stuck as u32;
    match reply {
        OK => Ok(()),
        TIMEOUT => Err(ShutterError::Timeout),
        STUCK => Err(ShutterError::Stuck),
        _ => Err(ShutterError::Bus),
    }
}

/// The detector that [`Instruments::lend`] was told of.
pub(crate) struct CDetector(Detector);

impl fsw_hal::ErrorType for CDetector {
    type Error = DetectorError;
}

impl fsw_hal::Detector for CDetector {
    fn geometry(&self) -> DetectorGeometry {
        let Geometry { width_px, height_px, bits } = self.0.geometry;
        DetectorGeometry { width_px, height_px, bits }
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        let start_exposure = self.0.start_exposure.ok_or(DetectorError::Bus)?;
        // SAFETY: `lend` was told that the callbacks are what their types say.
        detector_reply(unsafe { start_exposure(self.0.context, exposure_us) })
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        let finish_exposure = self.0.finish_exposure.ok_or(DetectorError::Bus)?;
        let mut local_us = 0;
        // SAFETY: as in `start_exposure`; the callback writes at most the one number.
        detector_reply(unsafe { finish_exposure(self.0.context, &raw mut local_us) })?;
        Ok(LocalTime::from_us(local_us))
    }

    fn read(&mut self, window: HalWindow, pixels: &mut [u16]) -> Result<(), DetectorError> {
        if !window.fits(&self.geometry()) {
            return Err(DetectorError::OutsideDetector);
        }
        if pixels.len() != window.area() {
            return Err(DetectorError::BufferLength);
        }
        let read = self.0.read.ok_or(DetectorError::Bus)?;
        let HalWindow { x, y, width, height } = window;
        let window = Window { x, y, width, height };
        // SAFETY: as in `start_exposure`; the callback writes at most `len` values, which are ours alone.
        detector_reply(unsafe { read(self.0.context, window, pixels.as_mut_ptr(), pixels.len()) })
    }
}

/// The clock that [`Instruments::lend`] was told of.
pub(crate) struct CClock(Clock);

impl fsw_hal::ErrorType for CClock {
    type Error = ClockError;
}

impl fsw_hal::Clock for CClock {
    fn local_time(&mut self) -> Result<LocalTime, ClockError> {
        let local_time = self.0.local_time.ok_or(ClockError::Bus)?;
        let mut local_us = 0;
        // SAFETY: `lend` was told that the callbacks are what their types say; one number is written.
        clock_reply(unsafe { local_time(self.0.context, &raw mut local_us) })?;
        Ok(LocalTime::from_us(local_us))
    }

    fn terrestrial_us(&mut self, at: LocalTime) -> Result<i64, ClockError> {
        let terrestrial_time = self.0.terrestrial_time.ok_or(ClockError::Bus)?;
        let mut terrestrial_us = 0;
        // SAFETY: as in `local_time`.
        clock_reply(unsafe { terrestrial_time(self.0.context, at.as_us(), &raw mut terrestrial_us) })?;
        Ok(terrestrial_us)
    }
}

/// The rate sensor that [`Instruments::lend`] was told of.
pub(crate) struct CRateSensor(RateSensor);

impl fsw_hal::ErrorType for CRateSensor {
    type Error = ReadingError;
}

impl fsw_hal::RateSensor for CRateSensor {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, ReadingError> {
        let Some(angular_rate) = self.0.angular_rate else { return Ok(None) };
        let mut reading = AngularRateReading { local_us: 0, rad_s: [0.0; 3] };
        // SAFETY: `lend` was told that the callbacks are what their types say; one reading is written.
        let given = reading_reply(unsafe { angular_rate(self.0.context, &raw mut reading) })?;
        let AngularRateReading { local_us, rad_s } = reading;
        Ok(given.then_some(AngularRate { instant: LocalTime::from_us(local_us), rad_s }))
    }
}

/// The magnetometer that [`Instruments::lend`] was told of.
pub(crate) struct CMagnetometer(Magnetometer);

impl fsw_hal::ErrorType for CMagnetometer {
    type Error = ReadingError;
}

impl fsw_hal::Magnetometer for CMagnetometer {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, ReadingError> {
        let Some(magnetic_field) = self.0.magnetic_field else { return Ok(None) };
        let mut reading = MagneticFieldReading { local_us: 0, ut: [0.0; 3] };
        // SAFETY: `lend` was told that the callbacks are what their types say; one reading is written.
        let given = reading_reply(unsafe { magnetic_field(self.0.context, &raw mut reading) })?;
        let MagneticFieldReading { local_us, ut } = reading;
        Ok(given.then_some(MagneticField { instant: LocalTime::from_us(local_us), ut }))
    }
}

/// The shutters that [`Instruments::lend`] was told of.
pub(crate) struct CShutter(Shutter);

impl fsw_hal::ErrorType for CShutter {
    type Error = ShutterError;
}

impl fsw_hal::Shutter for CShutter {
    fn open(&mut self, paths: OpenPaths) -> Result<(), ShutterError> {
        let Some(open) = self.0.open else { return Ok(()) };
        // SAFETY: `lend` was told that the callbacks are what their types say.
        shutter_reply(unsafe { open(self.0.context, paths.star(), paths != OpenPaths::Star, paths.clear()) })
    }
}

/// The marks that [`Instruments::lend`] was told of.
pub(crate) struct CMeter(Meter);

impl StageMeter for CMeter {
    fn begin(&mut self, stage: Stage) {
        if let Some(begin) = self.0.begin {
            // SAFETY: `lend` was told that the callbacks are what their types say.
            unsafe { begin(self.0.context, stage as u32) };
        }
    }

    fn end(&mut self, stage: Stage) {
        if let Some(end) = self.0.end {
            // SAFETY: as in `begin`.
            unsafe { end(self.0.context, stage as u32) };
        }
    }

    fn overran(&mut self) -> bool {
        // SAFETY: as in `begin`.
        self.0.overran.is_some_and(|overran| unsafe { overran(self.0.context) })
    }
}
