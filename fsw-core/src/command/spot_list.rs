//! The spots that were found last, for a ground that wants to see what the sensor sees.
//!
//! In: the spots of an image. Out: the data of the reports in which they are sent down, those that stood in
//! the image before first, then the brightest.
//!
//! | data of a report | |
//! |---|---|
//! | local time of the image, us | i64 |
//! | how many spots are left from the first of this report on | u16 |
//! | spots, [`SPOT_BYTES`] each, as many as there is room for | |
//!
//! | a spot | |
//! |---|---|
//! | column and row of its centre, 2^-16 px | i32, i32 |
//! | light of its 3 x 3 pixels, scaled counts ([`Detection::core_flux`]) | i32 |
//! | standard deviation of the centre per axis, 2^-16 px, at most 65,535 | u16 |
//! | [tracking number](Detection::number) | u8 |
//! | flags: 1 saturated, 2 on or beside something extended, 4 two in one, 8 drawn out | u8 |
//!
//! All numbers are big-endian.

use super::Downlink;
use super::packets::{self, MAX_DATA_BYTES};
use crate::image::Detection;
use heapless::Vec;

/// Bytes of a spot in a report.
pub const SPOT_BYTES: usize = 16;

/// A spot as it is sent down.
fn bytes_of(spot: &Detection) -> [u8; SPOT_BYTES] {
    let flags = [spot.saturated, spot.extended, spot.blended, spot.drawn_px > 0];
    let flags = flags.iter().rev().fold(0, |flags, flag| flags << 1 | u8::from(*flag));
    let [x, y, light] = [spot.x_q16, spot.y_q16, spot.core_flux].map(i32::to_be_bytes);
    let sigma = spot.sigma_q16.clamp(0, i32::from(u16::MAX)) as u16;
    let mut bytes = [0; SPOT_BYTES];
    let parts = x.into_iter().chain(y).chain(light).chain(sigma.to_be_bytes()).chain([spot.number, flags]);
    bytes.iter_mut().zip(parts).for_each(|(byte, part)| *byte = part);
    bytes
}

/// Writes the spots from place `from` on: the place of the next one; no such place after the last one. `None`
/// where there is no room for the data.
pub(super) fn write(told: &Downlink, from: u16, data: &mut Vec<u8, MAX_DATA_BYTES>) -> Option<Option<u16>> {
    let left = told.spots.get(usize::from(from)..).unwrap_or(&[]);
    data.extend_from_slice(&told.image.as_us().to_be_bytes()).ok()?;
    data.extend_from_slice(&(left.len() as u16).to_be_bytes()).ok()?;
    let written = packets::append_whole(left.iter().map(bytes_of), data);
    Some((written < left.len()).then_some(from.wrapping_add(written as u16)))
}
