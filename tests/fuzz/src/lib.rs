//! Every door through which bytes come in, as a function that tries some: no panic, and what gets through is
//! sound.
//!
//! `cargo test -p fuzz` knocks with mutilated files of the repository, the same in every run. With a nightly
//! compiler and `cargo install cargo-fuzz`, libFuzzer looks for the way in by itself and stops at the first
//! crash:
//!
//! ```sh
//! cargo +nightly fuzz run --fuzz-dir tests/fuzz/libfuzzer seconds     # or packets, tables, pixels, files, link
//! ```

pub mod files;
pub mod link;
pub mod packets;
pub mod pixels;
pub mod seconds;
pub mod tables;

use fsw_core::checksum::crc32;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, LocalTime, Window};

/// The packet of a body under this version, its checksum right: else hardly anything gets past the door.
fn sealed_packet(version: u8, body: &[u8]) -> Vec<u8> {
    let mut packet = vec![version];
    packet.extend(body);
    packet.extend(crc32(&packet).to_le_bytes());
    packet
}

/// The same of a table, whose checksum stands at byte 8 and protects what follows it.
fn sealed_table(table: &[u8]) -> Vec<u8> {
    let mut table = table.to_vec();
    if let Some((head, protected)) = table.split_at_mut_checked(12) {
        head[8..].copy_from_slice(&crc32(protected).to_le_bytes());
    }
    table
}

/// A detector that shows the same bytes over and over, or fails where they say so.
struct Bytes<'a> {
    /// Its size and resolution.
    geometry: DetectorGeometry,
    /// Its pixels: a byte each for the first bits, the rest of the bits after a hash of the place.
    pixels: &'a [u8],
    /// Instant of its images.
    instant: LocalTime,
}

impl Bytes<'_> {
    fn pixel(&self, x: u16, y: u16) -> u16 {
        let place = usize::from(y) * usize::from(self.geometry.width_px) + usize::from(x);
        let byte = self.pixels.get(place % self.pixels.len().max(1)).copied().unwrap_or(0);
        let noise = (place as u32).wrapping_mul(0x9E37_79B9) >> 24;
        let value = u32::from(byte) << 8 | noise;
        (value >> (16 - u32::from(self.geometry.bits))) as u16
    }
}

impl fsw_hal::ErrorType for Bytes<'_> {
    type Error = DetectorError;
}

impl Detector for Bytes<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        if self.pixels.first() == Some(&0xFF) { Err(DetectorError::Bus) } else { Ok(()) }
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(self.instant)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        if !window.fits(&self.geometry) {
            return Err(DetectorError::OutsideDetector);
        }
        if pixels.len() != window.area() {
            return Err(DetectorError::BufferLength);
        }
        let places = (window.y..window.y + window.height)
            .flat_map(|y| (window.x..window.x + window.width).map(move |x| (x, y)));
        pixels.iter_mut().zip(places).for_each(|(pixel, (x, y))| *pixel = self.pixel(x, y));
        Ok(())
    }
}
