//! The messages between the world and the computer: each led by its length, the body by postcard.
//!
//! The world sends a [`Second`], the computer asks for exposures and windows in it ([`Request`], [`Answer`])
//! and ends it with its telemetry. Kinds of errors travel as their places in a table.

use crate::memory::Flip;
use fsw_hal::{DetectorError, ReadingError};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};

/// A second, begun.
#[derive(Debug, Serialize, Deserialize)]
pub struct Second {
    /// Bits to be turned over before it.
    pub flips: Vec<Flip>,
    /// Whether a restart is commanded.
    pub restart: bool,
    /// Columns, rows and bits that the detector states.
    pub geometry: (u16, u16, u8),
    /// The counter, and Terrestrial Time where the clock gives it, microseconds.
    pub clock: (i64, Option<i64>),
    /// What the rate sensor reads: instant, and rad/s.
    pub rate: Result<Option<(i64, [f32; 3])>, u8>,
}

/// What the computer asks for or tells.
#[derive(Debug, Serialize, Deserialize)]
pub enum Request {
    /// An exposure of so many microseconds.
    Start(u32),
    /// Its end.
    Finish,
    /// A window: x, y, width, height.
    Read([u16; 4]),
    /// The second is over; its telemetry frame, empty where none could be made.
    Done(Vec<u8>),
}

/// What the world answers.
#[derive(Debug, Serialize, Deserialize)]
pub enum Answer {
    /// To [`Request::Start`].
    Started(Result<(), u8>),
    /// To [`Request::Finish`]: the image's instant.
    Finished(Result<i64, u8>),
    /// To [`Request::Read`].
    Pixels(Result<Vec<u16>, u8>),
}

/// Kinds of a detector's errors, by their numbers.
pub const DETECTOR: [DetectorError; 6] = [
    DetectorError::Bus,
    DetectorError::OutsideDetector,
    DetectorError::BufferLength,
    DetectorError::NotExposed,
    DetectorError::Exposure,
    DetectorError::Timeout,
];
/// Those of a rate sensor.
pub const RATE: [ReadingError; 3] = [ReadingError::Bus, ReadingError::Saturated, ReadingError::Timeout];

/// The number of a kind; of one that the table does not have, the first.
pub fn number<K: PartialEq>(kinds: &[K], kind: K) -> u8 {
    kinds.iter().position(|known| *known == kind).unwrap_or(0) as u8
}

/// The kind of a number; of one beyond the table, the first.
pub fn kind<K: Copy>(kinds: &[K], number: u8) -> K {
    *kinds.get(usize::from(number)).unwrap_or(&kinds[0])
}

/// The longest message that is read, bytes: two thousand rows of pixels.
const LONGEST: usize = 1 << 24;

/// Sends a message.
///
/// # Errors
/// Where the other end is gone.
pub fn send(to: &mut impl Write, message: &impl Serialize) -> io::Result<()> {
    let body = postcard::to_extend(message, Vec::new()).map_err(io::Error::other)?;
    to.write_all(&(body.len() as u32).to_le_bytes())?;
    to.write_all(&body)?;
    to.flush()
}

/// Waits for a message.
///
/// # Errors
/// Where the other end is gone, or what it sent is no message.
pub fn receive<M: DeserializeOwned>(from: &mut impl Read) -> io::Result<M> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length) as usize;
    if length > LONGEST {
        return Err(io::Error::other("a message too long"));
    }
    let mut body = vec![0; length];
    from.read_exact(&mut body)?;
    postcard::from_bytes(&body).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_as_they_were_sent_and_broken_ones_are_errors() {
        let mut stream = Vec::new();
        send(&mut stream, &Request::Read([1, 2, 3, 40_000])).unwrap();
        send(&mut stream, &Answer::Pixels(Err(number(&DETECTOR, DetectorError::Timeout)))).unwrap();
        let mut from = &stream[..];
        assert!(matches!(receive(&mut from), Ok(Request::Read([1, 2, 3, 40_000]))));
        let Ok(Answer::Pixels(Err(found))) = receive(&mut from) else { panic!("another message") };
        assert_eq!(kind(&DETECTOR, found), DetectorError::Timeout);
        assert!(receive::<Request>(&mut from).is_err(), "the end");
        assert!(receive::<Request>(&mut &[255; 8][..]).is_err(), "too long");
        assert!(receive::<Request>(&mut &[1, 0, 0, 0, 9][..]).is_err(), "no such request");
        assert_eq!(kind(&RATE, 77), ReadingError::Bus);
    }
}
