//! What leaves the sensor every second: the [`Report`] and its bytes.
//!
//! A frame is the version (one byte), the report in postcard encoding, and the CRC-32 of both, little-endian. Equal
//! images give equal frames on every machine.

use crate::catalog::format::CRC32;
use crate::modes::Mode;
use crate::stars::identify::NotIdentified;
use fsw_hal::DetectorError;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the frame's layout.
pub const VERSION: u8 = 1;
/// A buffer of this length holds any frame.
pub const MAX_FRAME_BYTES: usize = 2048;
/// Most stars reported.
pub const MAX_STARS: usize = 64;

/// What came of this second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// Stars were identified without prior knowledge.
    Identified,
    /// The search goes on in the next second with the same image.
    Searching,
    /// The image was not identified.
    NotIdentified(NotIdentified),
    /// Predicted stars were found again.
    Tracked,
    /// Too few predicted stars were found.
    Lost,
    /// The detector failed; nothing was learnt.
    DetectorFault(Fault),
}

/// A detector's failure in telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// A window or buffer was refused: a fault of ours.
    Request,
    /// The geometry is not the one the parameters were made for.
    Geometry,
    /// The hardware did not deliver.
    Hardware,
}

impl From<DetectorError> for Fault {
    fn from(error: DetectorError) -> Self {
        match error {
            DetectorError::OutsideDetector | DetectorError::BufferLength | DetectorError::Exposure => {
                Self::Request
            }
            DetectorError::NotExposed | DetectorError::Timeout | DetectorError::Bus => Self::Hardware,
        }
    }
}

/// A star that was recognised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StarReport {
    /// Hipparcos number.
    pub hip: u32,
    /// Measured centre, px.
    pub centre_px: [f32; 2],
    /// Measured less projected position, px.
    pub residual_px: [f32; 2],
}

/// An attitude and how far to trust it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttitudeReport {
    /// ICRS to star path, `[x, y, z, w]`.
    pub quaternion: [f32; 4],
    /// Standard deviations about x, y, z of the star path, rad.
    pub sigma_rad: [f32; 3],
    /// Common logarithm of the probability that the names are wrong, from this image alone.
    pub log10_false: f32,
    /// Seconds since the image from which it was found was taken.
    pub age_s: u16,
}

/// One second of the sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Seconds since start.
    pub cycle: u32,
    /// Mode in which the second was spent.
    pub mode: Mode,
    /// What came of it.
    pub status: Status,
    /// The attitude, where there is one.
    pub attitude: Option<AttitudeReport>,
    /// Rate of the star path against the stars in its own frame, rad/s, from two attitudes in a row.
    pub rate_rad_s: Option<[f32; 3]>,
    /// Star-like spots in the image or its windows.
    pub detections: u16,
    /// Best focal length over the parameter, from this image's stars.
    pub focal_ratio: f32,
    /// The stars recognised, brightest first.
    pub stars: Vec<StarReport, MAX_STARS>,
}

/// Why a frame was not made or not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The buffer is too short.
    Buffer,
    /// Too short, or its CRC does not match.
    Checksum,
    /// Another version (given).
    Version(u8),
    /// Not a report.
    Content,
}

/// Writes a report as a frame and gives the bytes used.
///
/// # Errors
/// [`FrameError::Buffer`] when `buffer` is shorter than the frame; [`MAX_FRAME_BYTES`] always suffice.
pub fn encode<'a>(report: &Report, buffer: &'a mut [u8]) -> Result<&'a [u8], FrameError> {
    let (head, body) = buffer.split_first_mut().ok_or(FrameError::Buffer)?;
    *head = VERSION;
    let body_length = postcard::to_slice(report, body).map_err(|_| FrameError::Buffer)?.len();
    let (content, rest) = buffer.split_at_mut_checked(1 + body_length).ok_or(FrameError::Buffer)?;
    let crc = rest.first_chunk_mut::<4>().ok_or(FrameError::Buffer)?;
    *crc = CRC32.checksum(content).to_le_bytes();
    buffer.get(..body_length + 5).ok_or(FrameError::Buffer)
}

/// Reads the frame at the beginning of `bytes`, of `length` bytes.
///
/// # Errors
/// See [`FrameError`].
pub fn decode(frame: &[u8]) -> Result<Report, FrameError> {
    let (content, crc) = frame.split_last_chunk::<4>().ok_or(FrameError::Checksum)?;
    if CRC32.checksum(content) != u32::from_le_bytes(*crc) {
        return Err(FrameError::Checksum);
    }
    let (version, body) = content.split_first().ok_or(FrameError::Checksum)?;
    if *version != VERSION {
        return Err(FrameError::Version(*version));
    }
    postcard::from_bytes(body).map_err(|_| FrameError::Content)
}
