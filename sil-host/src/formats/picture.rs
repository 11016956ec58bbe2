//! A picture file served as a detector.
//!
//! In: a PNG, TIFF, JPEG, BMP, PGM (or another of Netpbm's) or FITS file. Out: [`Picture`], raw digital
//! numbers row by row, behind the same [`fsw_hal::Detector`] trait as a real instrument; exposing it only
//! marks it exposed.
//!
//! | file | raw values | bits |
//! |---|---|---|
//! | grey, 8 bit | as they are | 8 |
//! | grey, 16 bit | as they are | 16 |
//! | colour | luminance 0.2126 R + 0.7152 G + 0.0722 B (Rec. 709 weights on the stored values), 16 bits | 16 |
//! | FITS, 8 bit unscaled | as they are | 8 |
//! | FITS, whole numbers within 0..65535, or reals within it and reaching 256 | rounded | 16 |
//! | FITS, anything else | least to greatest value stretched to 0..65535 | 16 |
//!
//! Alpha is ignored. A side has [`SIDE_MIN_PX`] to [`SIDE_MAX_PX`] pixels.

use super::{SIDE_MAX_PX, SIDE_MIN_PX};
use crate::formats::fits::{self, FitsError, FitsPlanes};
use crate::words::{io_words, one_line};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// A picture has been exposed long ago; the trait wants a time.
pub const EXPOSURE_US: u32 = 1000;

/// Formats that are read, beside FITS.
const FORMATS: [ImageFormat; 5] =
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff, ImageFormat::Bmp, ImageFormat::Pnm];

/// A picture in memory that answers as a detector does.
#[derive(Debug, Clone)]
pub struct Picture {
    geometry: DetectorGeometry,
    pixels: Vec<u16>,
    exposed: bool,
}

/// What is wrong with a picture file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {fault}", one_line(&file.display().to_string()))]
pub struct PictureError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub fault: PictureFault,
}

/// The ways in which a picture file can be wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PictureFault {
    /// The system does not hand out the file.
    #[error("cannot be read: {0}; check the path and its permissions")]
    Unreadable(String),
    /// Nothing is in the file.
    #[error("the file is empty; record or copy it again")]
    Empty,
    /// The content is of no format known here.
    #[error("the format is unknown; give a PNG, TIFF, JPEG, BMP, PGM or FITS picture")]
    UnknownFormat,
    /// The picture ends too early or is damaged.
    #[error("truncated or damaged picture ({0}); copy it again")]
    Damaged(String),
    /// A side is too short or too long.
    #[error("{0} x {1} px is outside {SIDE_MIN_PX} to {SIDE_MAX_PX} px a side; crop or bin the picture")]
    Size(u64, u64),
    /// Nothing was measured in any pixel.
    #[error("{0}; write the picture again from the detector's values")]
    NoNumber(String),
    /// The picture is sound but of a kind not read here.
    #[error("{0}; convert it to 8- or 16-bit grey or colour")]
    Unsupported(String),
}

impl Picture {
    /// Reads the picture at `path`; the content decides on the format, not the name.
    ///
    /// # Errors
    /// See [`PictureFault`].
    pub fn load(path: &Path) -> Result<Self, PictureError> {
        let in_file = |fault| PictureError { file: path.to_path_buf(), fault };
        let bytes = std::fs::read(path).map_err(|e| in_file(PictureFault::Unreadable(io_words(&e))))?;
        Self::decode(&bytes).map_err(in_file)
    }

    /// Reads a picture from the content of a file.
    ///
    /// # Errors
    /// See [`PictureFault`].
    pub fn decode(bytes: &[u8]) -> Result<Self, PictureFault> {
        if bytes.is_empty() {
            return Err(PictureFault::Empty);
        }
        if fits::is_fits(bytes) {
            return from_fits(bytes);
        }
        let reader = ImageReader::new(Cursor::new(bytes));
        let reader = reader.with_guessed_format().map_err(|e| PictureFault::Damaged(io_words(&e)))?;
        let format = reader.format().ok_or(PictureFault::UnknownFormat)?;
        if !FORMATS.contains(&format) {
            return Err(PictureFault::UnknownFormat);
        }
        // The JPEG decoder fills up what is missing with grey, silently.
        if format == ImageFormat::Jpeg && !jpeg_is_whole(bytes) {
            return Err(PictureFault::Damaged("end of JPEG data missing".into()));
        }
        let decoder = reader.into_decoder().map_err(decoder_fault)?;
        let (width, height) = decoder.dimensions();
        if !side_ok(width.into()) || !side_ok(height.into()) {
            return Err(PictureFault::Size(width.into(), height.into()));
        }
        let image = DynamicImage::from_decoder(decoder).map_err(decoder_fault)?;
        let (pixels, bits) = digital_numbers(image)?;
        Ok(Self::new(width as u16, height as u16, bits, pixels))
    }

    /// A picture from raw values, row by row; `None` when their number is not `width_px * height_px` or
    /// `bits` is not 1 to 16.
    pub fn from_pixels(geometry: DetectorGeometry, pixels: Vec<u16>) -> Option<Self> {
        let right = pixels.len() == geometry.whole().area() && (1..=16).contains(&geometry.bits);
        right.then_some(Self { geometry, pixels, exposed: false })
    }

    /// All raw values, row by row.
    pub fn pixels(&self) -> &[u16] {
        &self.pixels
    }

    /// Changes the lowest bit of half of its pixels, others for each `seed`: shown anew with the same noise it
    /// is an old image to the flight code.
    pub fn renew_noise(&mut self, seed: u32) {
        // The golden ratio, 64 bits; then Marsaglia's xorshift.
        let mut bits = 0x9e37_79b9_7f4a_7c15 ^ u64::from(seed);
        for pixels in self.pixels.chunks_mut(u64::BITS as usize) {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            for (bit, pixel) in pixels.iter_mut().enumerate() {
                *pixel ^= (bits >> bit & 1) as u16;
            }
        }
    }

    /// Why nothing can be found in the picture, whatever is looked for: its pixels are all alike, or most
    /// are at full scale. `None` where that is not so.
    pub fn without_content(&self) -> Option<&'static str> {
        let full_scale = self.geometry.full_scale();
        let full = self.pixels.iter().filter(|value| **value == full_scale).count();
        let first = self.pixels.first().copied().unwrap_or(0);
        if 2 * full > self.pixels.len() {
            Some("overexposed: more than half of the pixels are at full scale")
        } else if self.pixels.iter().all(|value| *value == first) {
            Some("every pixel has the same value")
        } else {
            None
        }
    }

    /// The picture read in blocks of `side_px` by `side_px`, each their mean, in 16 bits; an incomplete block
    /// at the right or lower edge is left out. `None` where nothing of use is left ([`SIDE_MIN_PX`]).
    pub fn binned(&self, side_px: u16) -> Option<Self> {
        let DetectorGeometry { width_px, height_px, .. } = self.geometry;
        let (width, height) = (width_px.checked_div(side_px)?, height_px.checked_div(side_px)?);
        if !side_ok(width.into()) || !side_ok(height.into()) {
            return None;
        }
        let block = usize::from(side_px);
        let most = u64::from(self.geometry.full_scale()) * (block * block) as u64;
        let mut pixels = Vec::with_capacity(usize::from(width) * usize::from(height));
        for rows in self.pixels.chunks_exact(block * usize::from(width_px)) {
            for column in 0..usize::from(width) {
                let lines = rows.chunks_exact(usize::from(width_px));
                let values = lines.flat_map(|line| &line[column * block..][..block]);
                let sum: u64 = values.map(|value| u64::from(*value)).sum();
                pixels.push(((sum * 65_535 + most / 2) / most) as u16);
            }
        }
        Some(Self::new(width, height, 16, pixels))
    }

    fn new(width_px: u16, height_px: u16, bits: u8, pixels: Vec<u16>) -> Self {
        Self { geometry: DetectorGeometry { width_px, height_px, bits }, pixels, exposed: false }
    }
}

impl fsw_hal::ErrorType for Picture {
    type Error = DetectorError;
}

impl Detector for Picture {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    /// A picture has been exposed long ago; any time is accepted.
    fn start_exposure(&mut self, _exposure_us: u32) -> Result<(), DetectorError> {
        self.exposed = true;
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        check_request(&self.geometry, window, pixels.len())?;
        if !self.exposed {
            return Err(DetectorError::NotExposed);
        }
        copy_window(&self.pixels, &self.geometry, window, pixels);
        Ok(())
    }
}

/// The trait's refusals, the same for every detector of the host.
pub(crate) fn check_request(
    geometry: &DetectorGeometry,
    window: Window,
    length: usize,
) -> Result<(), DetectorError> {
    if !window.fits(geometry) {
        return Err(DetectorError::OutsideDetector);
    }
    if length != window.area() {
        return Err(DetectorError::BufferLength);
    }
    Ok(())
}

/// Copies a window that fits out of a whole frame.
pub(crate) fn copy_window(frame: &[u16], geometry: &DetectorGeometry, window: Window, pixels: &mut [u16]) {
    if pixels.is_empty() {
        return;
    }
    let width = usize::from(window.width);
    for (row, target) in pixels.chunks_exact_mut(width).enumerate() {
        let start = (usize::from(window.y) + row) * usize::from(geometry.width_px) + usize::from(window.x);
        target.copy_from_slice(&frame[start..start + width]);
    }
}

fn side_ok(side: u64) -> bool {
    (u64::from(SIDE_MIN_PX)..=u64::from(SIDE_MAX_PX)).contains(&side)
}

fn decoder_fault(error: image::ImageError) -> PictureFault {
    let words = one_line(&error.to_string());
    match error {
        image::ImageError::Unsupported(_) => PictureFault::Unsupported(words),
        image::ImageError::Limits(_) => PictureFault::Unsupported("the picture needs too much memory".into()),
        _ => PictureFault::Damaged(words),
    }
}

/// Whether the last scan of a JPEG file is followed by the end marker; inside the coded data 0xFF is always
/// stuffed, so neither marker can occur there by chance.
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    let last = |second: u8| bytes.windows(2).rposition(|pair| pair == [0xFF, second]);
    last(0xD9).is_some() && last(0xD9) > last(0xDA)
}

/// Raw values and their number of bits.
fn digital_numbers(image: DynamicImage) -> Result<(Vec<u16>, u8), PictureFault> {
    let luminance = |rgb: &[u16]| luminance_16(rgb[0], rgb[1], rgb[2]);
    // 8-bit colour times 257 is exactly the 16-bit scale: 255 becomes 65535.
    let wide =
        |rgb: &[u8]| luminance_16(u16::from(rgb[0]) * 257, u16::from(rgb[1]) * 257, u16::from(rgb[2]) * 257);
    Ok(match image {
        DynamicImage::ImageLuma8(grey) => (grey.iter().map(|v| u16::from(*v)).collect(), 8),
        DynamicImage::ImageLumaA8(grey) => (grey.chunks_exact(2).map(|p| u16::from(p[0])).collect(), 8),
        DynamicImage::ImageLuma16(grey) => (grey.into_raw(), 16),
        DynamicImage::ImageLumaA16(grey) => (grey.chunks_exact(2).map(|p| p[0]).collect(), 16),
        DynamicImage::ImageRgb8(rgb) => (rgb.chunks_exact(3).map(wide).collect(), 16),
        DynamicImage::ImageRgba8(rgb) => (rgb.chunks_exact(4).map(wide).collect(), 16),
        DynamicImage::ImageRgb16(rgb) => (rgb.chunks_exact(3).map(luminance).collect(), 16),
        DynamicImage::ImageRgba16(rgb) => (rgb.chunks_exact(4).map(luminance).collect(), 16),
        other => return Err(PictureFault::Unsupported(format!("pixels of kind {:?}", other.color()))),
    })
}

/// Rec. 709 luminance in integers, rounded; equal to the input where all three are equal.
fn luminance_16(red: u16, green: u16, blue: u16) -> u16 {
    ((2126 * u32::from(red) + 7152 * u32::from(green) + 722 * u32::from(blue) + 5000) / 10_000) as u16
}

fn from_fits(bytes: &[u8]) -> Result<Picture, PictureFault> {
    let picture = fits::read(bytes, side_ok).map_err(|error| match error {
        FitsError::Size(width, height) => PictureFault::Size(width, height),
        FitsError::NoPicture => PictureFault::Unsupported(error.to_string()),
        FitsError::NoNumber => PictureFault::NoNumber(error.to_string()),
        FitsError::Truncated | FitsError::Keyword(_) => PictureFault::Damaged(error.to_string()),
    })?;
    let (width, height) = (picture.width as u16, picture.height as u16);
    let (pixels, bits) = fits_numbers(&picture);
    Ok(Picture::new(width, height, bits, pixels))
}

/// Raw values and their number of bits, by the table at the top.
fn fits_numbers(picture: &FitsPlanes) -> (Vec<u16>, u8) {
    let all = || picture.planes.iter().flatten().copied();
    let (least, most) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
    let counts = least >= 0.0 && most <= 65_535.0 && (picture.whole || most >= 256.0);
    let (zero, scale) = match (picture.eight_bit, counts) {
        (true, _) if picture.planes.len() == 3 => (0.0, 257.0),
        (true, _) | (_, true) => (0.0, 1.0),
        _ if most > least => (least, 65_535.0 / (most - least)),
        _ => (least, 0.0),
    };
    let number = |value: f64| ((value - zero) * scale).round().clamp(0.0, 65_535.0) as u16;
    match picture.planes.as_slice() {
        [red, green, blue] => {
            let rgb = red.iter().zip(green).zip(blue);
            (rgb.map(|((r, g), b)| luminance_16(number(*r), number(*g), number(*b))).collect(), 16)
        }
        planes => {
            (planes.iter().flatten().map(|v| number(*v)).collect(), if picture.eight_bit { 8 } else { 16 })
        }
    }
}

#[cfg(test)]
mod tests;
