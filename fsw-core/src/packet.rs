//! Bytes that cross the sensor's border: a version, a postcard body, a checksum.
//!
//! | length | content |
//! |---|---|
//! | 1 | version of the body's layout |
//! | n | body, postcard encoding |
//! | 4 | CRC-32 (ISO-HDLC) of all before, little-endian |
//!
//! Telemetry frames and parameter tables are packets. Equal values give equal bytes on every machine.

use crate::checksum::crc32;
use serde::{Deserialize, Serialize};

/// Why a packet was not made or not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketError {
    /// The buffer is too short.
    Buffer,
    /// Too short to be a packet, or the checksum does not match.
    Checksum,
    /// Another version of the layout (the one found).
    Version(u8),
    /// The body is not what it should be.
    Content,
}

/// Writes `value` into `buffer` and gives the bytes used.
///
/// # Errors
/// [`PacketError::Buffer`] when `buffer` is shorter than the packet.
pub fn encode<'a, T: Serialize>(
    version: u8,
    value: &T,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], PacketError> {
    let (head, body) = buffer.split_first_mut().ok_or(PacketError::Buffer)?;
    *head = version;
    let body_length = postcard::to_slice(value, body).map_err(|_| PacketError::Buffer)?.len();
    let (content, rest) = buffer.split_at_mut_checked(1 + body_length).ok_or(PacketError::Buffer)?;
    let crc = rest.first_chunk_mut::<4>().ok_or(PacketError::Buffer)?;
    *crc = crc32(content).to_le_bytes();
    buffer.get(..body_length + 5).ok_or(PacketError::Buffer)
}

/// Reads a packet that is `packet` whole.
///
/// # Errors
/// The first check that fails: checksum, version, content.
pub fn decode<'a, T: Deserialize<'a>>(version: u8, packet: &'a [u8]) -> Result<T, PacketError> {
    let (content, crc) = packet.split_last_chunk::<4>().ok_or(PacketError::Checksum)?;
    if crc32(content) != u32::from_le_bytes(*crc) {
        return Err(PacketError::Checksum);
    }
    let (found, body) = content.split_first().ok_or(PacketError::Checksum)?;
    if *found != version {
        return Err(PacketError::Version(*found));
    }
    match postcard::take_from_bytes(body) {
        Ok((value, [])) => Ok(value),
        _ => Err(PacketError::Content),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_comes_back_from_its_packet() {
        let mut buffer = [0; 32];
        let packet = encode(7, &(1u32, -2i16), &mut buffer).unwrap();
        assert_eq!(decode::<(u32, i16)>(7, packet), Ok((1, -2)));
        assert_eq!(decode::<(u32, i16)>(8, packet), Err(PacketError::Version(7)));
    }

    #[test]
    fn bytes_after_the_value_are_refused_even_under_a_good_checksum() {
        let mut buffer = [0; 32];
        let packet = encode(7, &(1u8, 2u8), &mut buffer).unwrap();
        assert_eq!(decode::<u8>(7, packet), Err(PacketError::Content));
    }

    #[test]
    fn a_buffer_that_is_too_short_is_an_error_at_every_length() {
        let length = encode(1, &[1u8, 2, 3], &mut [0; 32]).unwrap().len();
        for short in 0..length {
            assert_eq!(encode(1, &[1u8, 2, 3], &mut [0; 32][..short]), Err(PacketError::Buffer));
        }
    }
}
