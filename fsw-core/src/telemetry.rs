//! What leaves the sensor every second: the [`Report`] and its bytes.
//!
//! A frame is a [`packet`] of version [`VERSION`]. Equal images give equal frames on every machine. A stream
//! is one frame after the other, each led by its length (u16, little-endian).

use crate::modes::Mode;
use crate::packet::{self, PacketError};
use crate::stars::identify::NotIdentified;
use fsw_hal::DetectorError;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the frame's layout.
pub const VERSION: u8 = 1;
/// A buffer of this length holds any frame.
pub const MAX_FRAME_BYTES: usize = 2048;
/// Most stars reported.
pub const MAX_STARS: usize = 48;

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

/// Writes a report as a frame and gives the bytes used.
///
/// # Errors
/// [`PacketError::Buffer`] when `buffer` is shorter than the frame; [`MAX_FRAME_BYTES`] always suffice.
pub fn encode<'a>(report: &Report, buffer: &'a mut [u8]) -> Result<&'a [u8], PacketError> {
    packet::encode(VERSION, report, buffer)
}

/// Reads a frame.
///
/// # Errors
/// See [`PacketError`].
pub fn decode(frame: &[u8]) -> Result<Report, PacketError> {
    packet::decode(VERSION, frame)
}

/// Writes a report as the next piece of a stream, length and frame, and gives the bytes used.
///
/// # Errors
/// As [`encode`].
pub fn encode_next<'a>(report: &Report, buffer: &'a mut [u8]) -> Result<&'a [u8], PacketError> {
    let (length, frame) = buffer.split_first_chunk_mut::<2>().ok_or(PacketError::Buffer)?;
    let bytes = u16::try_from(encode(report, frame)?.len()).map_err(|_| PacketError::Buffer)?;
    *length = bytes.to_le_bytes();
    buffer.get(..usize::from(bytes) + 2).ok_or(PacketError::Buffer)
}

/// Takes the first frame off a stream: the frame and the rest; `None` at its end or where it breaks off.
pub fn split_first(stream: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = stream.split_first_chunk::<2>()?;
    rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))
}

#[cfg(test)]
mod tests;
