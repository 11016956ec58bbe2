//! Frames recorded for the emulated target, and their replay on the host.
//!
//! All numbers are little-endian. A 16-byte header, then the frames: local time (i64, microseconds since
//! power-on) and Terrestrial Time (i64, microseconds since J2000.0) of the middle of the exposure; the gyro's
//! reading, its local time (i64; the least: none) and rates about x, y, z of the body (f32, rad/s); the
//! magnetometer's, the same and flux densities (f32, uT); and the pixels row by row, a `u16` each:
//!
//! | byte | what |
//! |---|---|
//! | 0 | magic `SXTF` |
//! | 4 | version, u16, 5 |
//! | 6 | width, u16, px |
//! | 8 | height, u16, px |
//! | 10 | bits, u8 |
//! | 11 | 0 |
//! | 12 | number of frames, u32 |
//!
//! A replay shows the frame of the second it was [turned to](Recording::turn_to), whether or not those before
//! it were exposed. The firmware reads the same file by semihosting, so that host and target see the same
//! pixels.

use crate::error::HostError;
use crate::formats::picture::{check_request, copy_window};
use crate::output::PartialFile;
use crate::words::io_words;
use fsw_hal::{
    AngularRate, Detector, DetectorError, DetectorGeometry, Instant, LocalTime, MagneticField, Magnetometer,
    RateSensor, ReadingError, Window,
};
use std::path::{Path, PathBuf};

/// The first four bytes of a file of frames.
pub const MAGIC: [u8; 4] = *b"SXTF";
/// The version written and read.
pub const VERSION: u16 = 5;
/// Length of the header, bytes.
pub const HEADER_BYTES: usize = 16;
/// Length of what stands before a frame's pixels, bytes.
const HEAD_BYTES: usize = 56;

fn fault(file: &Path, what: impl Into<String>, to_do: &str) -> HostError {
    HostError::input(file, None, what, to_do)
}

/// What the instruments beside the detector read in a second.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Readings {
    /// The gyro.
    pub rate: Option<AngularRate>,
    /// The magnetometer.
    pub field: Option<MagneticField>,
}

/// Writes frames, one after another; the count is put into the header at the end.
#[derive(Debug)]
pub struct FramesWriter {
    path: PathBuf,
    file: PartialFile,
    geometry: DetectorGeometry,
    count: u32,
}

impl FramesWriter {
    /// Begins the file that is to be `path`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(path: &Path, geometry: DetectorGeometry) -> Result<Self, HostError> {
        let mut file = PartialFile::create(path)?;
        file.write(&header(geometry, 0))?;
        Ok(Self { path: path.to_path_buf(), file, geometry, count: 0 })
    }

    /// Appends a whole frame, row by row, taken at `instant`, and what was read beside it.
    ///
    /// # Errors
    /// When the frame has another size than the detector or the file cannot be written.
    pub fn push(
        &mut self,
        instant: Instant,
        Readings { rate, field }: Readings,
        frame: &[u16],
    ) -> Result<(), HostError> {
        if frame.len() != self.geometry.whole().area() {
            let what =
                format!("a frame of {} px for a detector of {}", frame.len(), self.geometry.whole().area());
            return Err(fault(&self.path, what, "write whole frames"));
        }
        let mut bytes = Vec::with_capacity(HEAD_BYTES + 2 * frame.len());
        bytes.extend(instant.local.as_us().to_le_bytes());
        bytes.extend(instant.terrestrial_us.unwrap_or(NONE).to_le_bytes());
        let none = (LocalTime::from_us(NONE), [0.0; 3]);
        let rate = rate.map_or(none, |rate| (rate.instant, rate.rad_s));
        let field = field.map_or(none, |field| (field.instant, field.ut));
        for (instant, axes) in [rate, field] {
            bytes.extend(instant.as_us().to_le_bytes());
            bytes.extend(axes.iter().flat_map(|axis| axis.to_le_bytes()));
        }
        bytes.extend(frame.iter().flat_map(|value| value.to_le_bytes()));
        self.file.write(&bytes)?;
        self.count += 1;
        Ok(())
    }

    /// Exposes `detector` and appends its whole frame as that of `instant`, and what was read beside it.
    ///
    /// # Errors
    /// When the detector fails or [`Self::push`] does.
    pub fn record<D: Detector<Error = DetectorError>>(
        &mut self,
        detector: &mut D,
        (instant, readings): (Instant, Readings),
        exposure_us: u32,
    ) -> Result<(), HostError> {
        let mut frame = vec![0; self.geometry.whole().area()];
        detector.expose(exposure_us).and_then(|_| detector.read(self.geometry.whole(), &mut frame)).map_err(
            |e| fault(&self.path, format!("the detector failed: {e:?}"), "check the exposure time"),
        )?;
        self.push(instant, readings, &frame)
    }

    /// Writes the count and gives the file its name; gives the number of frames.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<u32, HostError> {
        self.file.overwrite(0, &header(self.geometry, self.count))?;
        self.file.finish()?;
        Ok(self.count)
    }
}

fn header(geometry: DetectorGeometry, count: u32) -> [u8; HEADER_BYTES] {
    let mut header = [0; HEADER_BYTES];
    header[..4].copy_from_slice(&MAGIC);
    header[4..6].copy_from_slice(&VERSION.to_le_bytes());
    header[6..8].copy_from_slice(&geometry.width_px.to_le_bytes());
    header[8..10].copy_from_slice(&geometry.height_px.to_le_bytes());
    header[10] = geometry.bits;
    header[12..].copy_from_slice(&count.to_le_bytes());
    header
}

/// Recorded frames served as a detector.
#[derive(Debug, Clone)]
pub struct Recording {
    geometry: DetectorGeometry,
    /// The file without its header.
    data: Vec<u8>,
    second: usize,
    /// Pixels of the frame that was exposed, and of which second it is.
    exposed: Option<(usize, Vec<u16>)>,
}

impl Recording {
    /// Reads the file at `path` whole.
    ///
    /// # Errors
    /// When it cannot be read, is no file of frames, or its length contradicts its header.
    pub fn load(path: &Path) -> Result<Self, HostError> {
        let bytes = std::fs::read(path).map_err(|e| {
            fault(path, format!("cannot be read: {}", io_words(&e)), "check the path and its permissions")
        })?;
        Self::decode(path, bytes)
    }

    fn decode(path: &Path, mut bytes: Vec<u8>) -> Result<Self, HostError> {
        const AGAIN: &str = "record the frames again";
        let Some((header, data)) = bytes.split_at_checked(HEADER_BYTES) else {
            return Err(fault(path, "shorter than a header", AGAIN));
        };
        let word = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        if header[..4] != MAGIC {
            return Err(fault(
                path,
                "no file of recorded frames (SXTF)",
                "give a file that this program wrote",
            ));
        }
        if word(4) != VERSION || header[11] != 0 {
            return Err(fault(path, format!("version {} is unknown", word(4)), AGAIN));
        }
        let geometry = DetectorGeometry { width_px: word(6), height_px: word(8), bits: header[10] };
        let count = u32::from_le_bytes([header[12], header[13], header[14], header[15]]);
        let frame_bytes = frame_bytes(&geometry);
        if frame_bytes == HEAD_BYTES || !(1..=16).contains(&geometry.bits) || count == 0 {
            return Err(fault(path, "the header describes no frame", AGAIN));
        }
        if Some(data.len()) != frame_bytes.checked_mul(count as usize) {
            let what = format!("{} bytes of pixels for {count} frames of {frame_bytes} bytes", data.len());
            return Err(fault(path, what, AGAIN));
        }
        let mut frames = data.chunks_exact(frame_bytes).filter_map(|frame| frame.get(HEAD_BYTES..));
        if frames.any(|frame| pixels(frame).any(|value| value > geometry.full_scale())) {
            return Err(fault(path, format!("a pixel exceeds {} bits", geometry.bits), AGAIN));
        }
        bytes.drain(..HEADER_BYTES);
        Ok(Self { geometry, data: bytes, second: 0, exposed: None })
    }

    /// Times, readings and pixels of frame `index`, as in the file.
    fn frame(&self, index: usize) -> Option<(Instant, Readings, &[u8])> {
        let mut frames = self.data.chunks_exact(frame_bytes(&self.geometry));
        let (local, rest) = frames.nth(index)?.split_first_chunk()?;
        let (terrestrial, rest) = rest.split_first_chunk()?;
        let (rate, rest) = rest.split_first_chunk()?;
        let (field, pixels) = rest.split_first_chunk()?;
        let known = |bytes: &[u8; 8]| Some(i64::from_le_bytes(*bytes)).filter(|us| *us != NONE);
        let clock = Instant {
            local: LocalTime::from_us(i64::from_le_bytes(*local)),
            terrestrial_us: known(terrestrial),
        };
        let rate = reading(rate).map(|(instant, rad_s)| AngularRate { instant, rad_s });
        let field = reading(field).map(|(instant, ut)| MagneticField { instant, ut });
        Some((clock, Readings { rate, field }, pixels))
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.data.len() / frame_bytes(&self.geometry)
    }

    /// Whether there is no frame; never the case for a file that loads.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// Turns to a second (past the last frame the last stays) and gives its times.
    pub fn turn_to(&mut self, second: usize) -> Instant {
        self.second = second.min(self.len().saturating_sub(1));
        let none = Instant { local: LocalTime::default(), terrestrial_us: None };
        self.frame(self.second).map_or(none, |(instant, ..)| instant)
    }

    /// Gyro and magnetometer in that second.
    pub fn beside(&self) -> (Recorded<AngularRate>, Recorded<MagneticField>) {
        let readings = self.frame(self.second).map_or(Readings::default(), |(_, readings, _)| readings);
        (Recorded(readings.rate), Recorded(readings.field))
    }
}

/// An instrument that gives what it read in a second; nothing where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorded<T>(pub Option<T>);

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

/// A reading's instant and axes; `None` where there is none.
fn reading(bytes: &[u8; 20]) -> Option<(LocalTime, [f32; 3])> {
    let (instant, axes) = bytes.split_first_chunk()?;
    let instant_us = Some(i64::from_le_bytes(*instant)).filter(|us| *us != NONE)?;
    let mut of_axes = [0.0; 3];
    for (axis, bytes) in of_axes.iter_mut().zip(axes.as_chunks().0) {
        *axis = f32::from_le_bytes(*bytes);
    }
    Some((LocalTime::from_us(instant_us), of_axes))
}

/// A time that is not known.
const NONE: i64 = i64::MIN;

/// Length of a frame in the file with what stands before its pixels.
fn frame_bytes(geometry: &DetectorGeometry) -> usize {
    HEAD_BYTES + 2 * geometry.whole().area()
}

/// Little-endian pixels.
fn pixels(bytes: &[u8]) -> impl Iterator<Item = u16> {
    bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
}

impl fsw_hal::ErrorType for Recording {
    type Error = DetectorError;
}

impl Detector for Recording {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    /// The exposure time is that of the recording; any is accepted.
    fn start_exposure(&mut self, _exposure_us: u32) -> Result<(), DetectorError> {
        if self.exposed.as_ref().is_none_or(|(second, _)| *second != self.second) {
            self.exposed = self.frame(self.second).map(|(.., bytes)| (self.second, pixels(bytes).collect()));
        }
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        let (second, _) = self.exposed.as_ref().ok_or(DetectorError::NotExposed)?;
        Ok(self.frame(*second).ok_or(DetectorError::NotExposed)?.0.local)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        check_request(&self.geometry, window, pixels.len())?;
        let (_, frame) = self.exposed.as_ref().ok_or(DetectorError::NotExposed)?;
        copy_window(frame, &self.geometry, window, pixels);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 3, height_px: 2, bits: 10 };

    const RATE: AngularRate =
        AngularRate { instant: LocalTime::from_us(999_000), rad_s: [0.25, -0.5, f32::MIN_POSITIVE] };
    const FIELD: MagneticField =
        MagneticField { instant: LocalTime::from_us(998_000), ut: [20.0, -30.0, 40.0] };

    fn instant(us: i64) -> Instant {
        Instant::new(LocalTime::from_us(us + 40), us)
    }

    fn written(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("sextant-{}-{name}.sxtf", std::process::id()));
        let mut writer = FramesWriter::create(&path, GEOMETRY).unwrap();
        let (none, both) = (Readings::default(), Readings { rate: Some(RATE), field: Some(FIELD) });
        writer.push(instant(-7), none, &[0, 1, 2, 3, 4, 5]).unwrap();
        writer.push(instant(1_000_000), both, &[10, 11, 12, 13, 14, 1023]).unwrap();
        assert!(writer.push(instant(0), none, &[1]).is_err());
        assert_eq!(writer.finish(), Ok(2));
        path
    }

    #[test]
    fn the_bytes_are_those_of_the_table() {
        let path = written("bytes");
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(&bytes[..16], b"SXTF\x05\0\x03\0\x02\0\x0a\0\x02\0\0\0");
        assert_eq!((bytes.len(), &bytes[150..]), (152, &[0xff, 0x03][..]));
        // No readings in the first frame, both in the second.
        assert_eq!([&bytes[32..40], &bytes[52..60]], [i64::MIN.to_le_bytes(); 2]);
        assert_eq!(bytes[100..108], 999_000i64.to_le_bytes());
        assert_eq!(bytes[112..116], (-0.5f32).to_le_bytes());
        assert_eq!(bytes[120..128], 998_000i64.to_le_bytes());
        assert_eq!(bytes[136..140], 40.0f32.to_le_bytes());
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_replay_gives_frame_after_frame_and_keeps_the_last() {
        let path = written("replay");
        let mut recording = Recording::load(&path).unwrap();
        let window = Window { x: 1, y: 0, width: 2, height: 2 };
        let mut pixels = [0; 4];
        assert_eq!(recording.read(window, &mut pixels), Err(DetectorError::NotExposed));
        let seconds =
            [(0, -7, [1, 2, 4, 5]), (1, 1_000_000, [11, 12, 14, 1023]), (9, 1_000_000, [11, 12, 14, 1023])];
        for (second, instant_us, expected) in seconds {
            assert_eq!(recording.turn_to(second), instant(instant_us));
            let (mut gyro, mut magnetometer) = recording.beside();
            assert_eq!(gyro.angular_rate(), Ok((second > 0).then_some(RATE)));
            assert_eq!(magnetometer.magnetic_field(), Ok((second > 0).then_some(FIELD)));
            assert_eq!(recording.expose(1000), Ok(instant(instant_us).local));
            recording.read(window, &mut pixels).unwrap();
            assert_eq!(pixels, expected);
        }
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn damaged_files_are_refused() {
        let path = written("damaged");
        let good = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let refused =
            |bytes: &[u8]| Recording::decode(Path::new("f"), bytes.to_vec()).unwrap_err().to_string();
        for length in 0..good.len() {
            assert!(refused(&good[..length]).starts_with("sil-host: f: "));
        }
        for (at, value) in [(0, b'X'), (4, 1), (6, 4), (10, 0), (10, 9), (11, 1), (12, 3)] {
            let mut bytes = good.clone();
            bytes[at] = value;
            assert!(!refused(&bytes).contains('\n'), "byte {at}");
        }
    }
}
