//! The head that catalogue, calibration and table of defects have alike, little-endian, and its check.
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic |
//! | 4 | u16 | version |
//! | 6 | u16 | header length in bytes |
//! | 8 | u32 | CRC-32 (ISO-HDLC) of every byte from offset 12 on |
//! | 12 | u32 | total length in bytes |

use crate::checksum::crc32;

/// Offset of the total length.
pub const LENGTH_FROM: usize = 12;
/// Offset of the CRC-protected part.
pub const CRC_FROM: usize = 12;

/// Why bytes were refused.
pub(crate) enum Refusal {
    /// Another magic.
    Magic,
    /// Another version (the one found).
    Version(u16),
    /// Shorter or longer than the head says, or than a header.
    Length,
    /// The checksum does not match.
    Checksum,
    /// Another header length.
    Header,
}

/// Checks the head for a file of this magic, version and header length, in the order of [`Refusal`], and gives
/// the bytes under the checksum, and it.
pub(crate) fn check(
    bytes: &[u8],
    magic: [u8; 4],
    version: u16,
    header_bytes: usize,
) -> Result<(&[u8], u32), Refusal> {
    if !bytes.starts_with(&magic) {
        return Err(Refusal::Magic);
    }
    let found = u16_at(bytes, 4).ok_or(Refusal::Length)?;
    if found != version {
        return Err(Refusal::Version(found));
    }
    let word = |offset| u32_at(bytes, offset).ok_or(Refusal::Length);
    if bytes.len() < header_bytes || word(LENGTH_FROM)? as usize != bytes.len() {
        return Err(Refusal::Length);
    }
    let (protected, crc) = (bytes.get(CRC_FROM..).ok_or(Refusal::Length)?, word(8)?);
    if crc32(protected) != crc {
        return Err(Refusal::Checksum);
    }
    if u16_at(bytes, 6).map(usize::from) != Some(header_bytes) {
        return Err(Refusal::Header);
    }
    Ok((protected, crc))
}

pub(crate) fn u16_at(bytes: &[u8], offset: usize) -> Option<u16> {
    bytes.get(offset..)?.first_chunk().map(|word| u16::from_le_bytes(*word))
}

pub(crate) fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    bytes.get(offset..)?.first_chunk().map(|word| u32::from_le_bytes(*word))
}
