//! A detector, a gyro and a magnetometer that play what was recorded in a file of the host.
//!
//! In: the file. Out: windows of its frames through [`Detector`], and what the others read ([`Recorded`]).
//! The frame is that of the second the detector was [turned to](RecordedDetector::turn_to). Exposure times
//! are not looked at: the picture is taken.
//!
//! # The file, version 5, little-endian
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic `SXTF` |
//! | 4 | u16 | version, 5 |
//! | 6 | u16 | width W, px, 1 to 32,767 |
//! | 8 | u16 | height H, px, at least 1 |
//! | 10 | u8 | bits of the converter, 1 to 16 |
//! | 11 | u8 | zero |
//! | 12 | u32 | number of frames N, at least 1 |
//! | 16 | N x (i64, i64, i64, 3 x f32, i64, 3 x f32, H x W x u16) | frames one after the other: local time (microseconds since power-on) and
//! Terrestrial Time (microseconds since J2000.0; the least i64: not known) of the middle of the exposure;
//! local time of the gyro's reading (the least i64: none) and its rates about x, y, z of the body, rad/s;
//! the same of the magnetometer and its flux densities, uT; then the pixels row by row from the top left, digital numbers right-aligned |
//!
//! The whole file stays below 2 GiB (the host takes a signed 32-bit offset); a frame of 1280 x 1024 px has
//! 2.6 MB, so 800 of them fit.
//!
//! Cost: a seek and a read a row, one of each for all rows when the window is as wide as the detector; the
//! meter pauses for it ([`marks`]).

use crate::host::{File, HostError, Mode};
use crate::marks;
use fsw_hal::{
    AngularRate, Detector, DetectorError, DetectorGeometry, Instant, LocalTime, MagneticField, Magnetometer,
    RateSensor, ReadingError, Window,
};

const MAGIC: [u8; 4] = *b"SXTF";
const VERSION: u16 = 5;
const HEADER_BYTES: usize = 16;
const PIXEL_BYTES: usize = size_of::<u16>();
/// A reading: time and axes.
const READING_BYTES: usize = size_of::<i64>() + 3 * size_of::<f32>();
/// Before the pixels of a frame: two times and two readings.
const HEAD_BYTES: usize = 2 * size_of::<i64>() + 2 * READING_BYTES;
/// A time that is not known.
const NONE: i64 = i64::MIN;
const LARGEST_FILE_BYTES: u64 = i32::MAX as u64;

/// Why a frame file was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum FrameFileError {
    /// Cannot be opened or is shorter than its header.
    Unreadable,
    /// Does not begin with the magic.
    NotAFrameFile,
    /// A layout this image does not read.
    Version,
    /// No pixels, no frames, too many, or an impossible converter.
    Geometry,
}

/// The recorded detector.
#[derive(Debug)]
pub struct RecordedDetector {
    file: File,
    geometry: DetectorGeometry,
    frames: u32,
    second: u32,
    /// Local time of that second's frame.
    local: LocalTime,
    exposed: Option<u32>,
}

impl RecordedDetector {
    /// Opens the frame file `name` and checks its header.
    ///
    /// # Errors
    /// The first check that fails, see [`FrameFileError`].
    pub fn open(name: &[u8]) -> Result<Self, FrameFileError> {
        let mut header = [0u8; HEADER_BYTES];
        let mut file = File::open(name, Mode::Read).map_err(|HostError| FrameFileError::Unreadable)?;
        file.read(&mut header).map_err(|HostError| FrameFileError::Unreadable)?;
        let [m0, m1, m2, m3, v0, v1, w0, w1, h0, h1, bits, zero, n0, n1, n2, n3] = header;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(FrameFileError::NotAFrameFile);
        }
        if u16::from_le_bytes([v0, v1]) != VERSION || zero != 0 {
            return Err(FrameFileError::Version);
        }
        let (width_px, height_px) = (u16::from_le_bytes([w0, w1]), u16::from_le_bytes([h0, h1]));
        let frames = u32::from_le_bytes([n0, n1, n2, n3]);
        let pixel_bytes = u64::from(width_px) * u64::from(height_px) * PIXEL_BYTES as u64;
        let frame_bytes = HEAD_BYTES as u64 + pixel_bytes;
        let file_bytes = frame_bytes.saturating_mul(u64::from(frames)).saturating_add(HEADER_BYTES as u64);
        let possible = (1..=i16::MAX as u16).contains(&width_px) && (1..=16).contains(&bits);
        if !possible || pixel_bytes == 0 || frames == 0 || file_bytes > LARGEST_FILE_BYTES {
            return Err(FrameFileError::Geometry);
        }
        let geometry = DetectorGeometry { width_px, height_px, bits };
        Ok(Self { file, geometry, frames, second: 0, local: LocalTime::default(), exposed: None })
    }

    /// Number of frames in the file.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Turns to a second (past the last frame the last stays) and gives its times and readings.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn turn_to(&mut self, second: u32) -> Result<Second, HostError> {
        self.second = second.min(self.frames.saturating_sub(1));
        self.file.seek(self.frame_offset(self.second))?;
        self.local = LocalTime::from_us(self.read_i64()?);
        let terrestrial_us = Some(self.read_i64()?).filter(|us| *us != NONE);
        let rate = self.read_reading()?.map(|(instant, rad_s)| AngularRate { instant, rad_s });
        let field = self.read_reading()?.map(|(instant, ut)| MagneticField { instant, ut });
        Ok((Instant { local: self.local, terrestrial_us }, Recorded(rate), Recorded(field)))
    }

    /// Time and axes of a reading, where there is one.
    fn read_reading(&mut self) -> Result<Option<(LocalTime, [f32; 3])>, HostError> {
        let read_us = self.read_i64()?;
        let mut axes = [0.0; 3];
        for axis in &mut axes {
            let mut bytes = [0; size_of::<f32>()];
            self.file.read(&mut bytes)?;
            *axis = f32::from_le_bytes(bytes);
        }
        Ok((read_us != NONE).then_some((LocalTime::from_us(read_us), axes)))
    }

    fn read_i64(&mut self) -> Result<i64, HostError> {
        let mut bytes = [0; size_of::<i64>()];
        self.file.read(&mut bytes)?;
        Ok(i64::from_le_bytes(bytes))
    }

    /// Where `frame` begins in the file, bytes. Fits: [`RecordedDetector::open`] bounds the file.
    fn frame_offset(&self, frame: u32) -> usize {
        let area = usize::from(self.geometry.width_px) * usize::from(self.geometry.height_px);
        HEADER_BYTES + frame as usize * (HEAD_BYTES + area * PIXEL_BYTES)
    }

    /// Where pixel (x, y) of `frame` lies in the file, bytes.
    fn offset(&self, frame: u32, x: u16, y: u16) -> usize {
        let place = usize::from(y) * usize::from(self.geometry.width_px) + usize::from(x);
        self.frame_offset(frame) + HEAD_BYTES + place * PIXEL_BYTES
    }

    /// Reads consecutive pixels of `frame` from (x, y) on.
    fn read_run(&mut self, frame: u32, x: u16, y: u16, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let offset = self.offset(frame, x, y);
        self.file
            .seek(offset)
            .and_then(|()| self.file.read_words(pixels))
            .map_err(|HostError| DetectorError::Bus)
    }

    /// Reads a window that fits into `pixels` of its length.
    fn read_rows(&mut self, frame: u32, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        if window.width == self.geometry.width_px {
            return self.read_run(frame, window.x, window.y, pixels);
        }
        // `max(1)`: an empty window has no rows to read, and a chunk length of zero would be a panic.
        let rows = pixels.chunks_exact_mut(usize::from(window.width).max(1));
        for (row, y) in rows.zip(window.y..) {
            self.read_run(frame, window.x, y, row)?;
        }
        Ok(())
    }
}

/// An instrument that gives what it read in a second; nothing where there is none.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<T>(pub Option<T>);

/// Times, gyro and magnetometer of a second.
pub type Second = (Instant, Recorded<AngularRate>, Recorded<MagneticField>);

impl<T> fsw_hal::ErrorType for Recorded<T> {
    type Error = ReadingError;
}

impl RateSensor for Recorded<AngularRate> {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, ReadingError> {
        Ok(self.0)
    }
}

impl Magnetometer for Recorded<MagneticField> {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, ReadingError> {
        Ok(self.0)
    }
}

impl fsw_hal::ErrorType for RecordedDetector {
    type Error = DetectorError;
}

impl Detector for RecordedDetector {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    fn start_exposure(&mut self, _exposure_us: u32) -> Result<(), DetectorError> {
        self.exposed = Some(self.second);
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(self.local)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let frame = self.exposed.ok_or(DetectorError::NotExposed)?;
        if !window.fits(&self.geometry) {
            return Err(DetectorError::OutsideDetector);
        }
        if pixels.len() != window.area() {
            return Err(DetectorError::BufferLength);
        }
        // A file's rows are the emulator's trouble, not the flight computer's: the meter pauses.
        marks::pause_begin();
        let read = self.read_rows(frame, window, pixels);
        marks::pause_end();
        read
    }
}
