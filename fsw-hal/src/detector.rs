//! Active-pixel detector with random-access (windowed) readout.
//!
//! A second of operation is one exposure ([`Detector::start_exposure`], [`Detector::finish_exposure`]) and
//! then any number of [`Detector::read`] calls; all windows read between two exposures belong to the same
//! image, and a window read twice gives the same values.

use crate::clock::LocalTime;
use crate::error::{self, Error, ErrorType};

/// Fixed properties of a detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DetectorGeometry {
    /// Number of columns, px.
    pub width_px: u16,
    /// Number of rows, px.
    pub height_px: u16,
    /// Resolution of the converter: full scale is `2^bits - 1`, 1 to 16.
    pub bits: u8,
}

impl DetectorGeometry {
    /// Largest value a pixel can take, `2^bits - 1` (digital numbers).
    pub const fn full_scale(&self) -> u16 {
        let bits = if self.bits > 16 { 16 } else { self.bits };
        ((1u32 << bits) - 1) as u16
    }

    /// The window that covers every pixel.
    pub const fn whole(&self) -> Window {
        Window { x: 0, y: 0, width: self.width_px, height: self.height_px }
    }
}

/// A rectangle of pixels, row by row from its top left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Window {
    /// Column of the first pixel, px.
    pub x: u16,
    /// Row of the first pixel, px.
    pub y: u16,
    /// Number of columns, px.
    pub width: u16,
    /// Number of rows, px.
    pub height: u16,
}

impl Window {
    /// Number of pixels in the window.
    pub const fn area(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the window lies on the detector whole.
    pub const fn fits(&self, geometry: &DetectorGeometry) -> bool {
        self.x as u32 + self.width as u32 <= geometry.width_px as u32
            && self.y as u32 + self.height as u32 <= geometry.height_px as u32
    }
}

/// Why a detector did not deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The window leaves the detector.
    OutsideDetector,
    /// The buffer's length is not the window's area.
    BufferLength,
    /// Nothing has been exposed since power-on.
    NotExposed,
    /// The exposure time is outside what the detector can do.
    Exposure,
    /// The detector did not answer in time.
    Timeout,
    /// The link to the detector reported an error.
    Bus,
}

impl error::ErrorKind for ErrorKind {}

/// A detector that exposes an image and hands out windows of it.
pub trait Detector: ErrorType<Error: Error<ErrorKind>> {
    /// Size and resolution; the same at every call.
    fn geometry(&self) -> DetectorGeometry;

    /// Begins a new image, integrating for `exposure_us` microseconds, and returns without waiting for it.
    ///
    /// # Errors
    /// [`ErrorKind::Exposure`] for a time the detector cannot do, [`ErrorKind::Timeout`] or
    /// [`ErrorKind::Bus`] when the hardware fails.
    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), Self::Error>;

    /// Waits until the image that was begun can be read and gives the local time of the middle of its
    /// exposure (of a rolling shutter: of the middle row's).
    ///
    /// # Errors
    /// [`ErrorKind::NotExposed`] when none was begun, [`ErrorKind::Timeout`] or [`ErrorKind::Bus`] when the
    /// hardware fails.
    fn finish_exposure(&mut self) -> Result<LocalTime, Self::Error>;

    /// Takes a new image: both of the above.
    ///
    /// # Errors
    /// Theirs.
    fn expose(&mut self, exposure_us: u32) -> Result<LocalTime, Self::Error> {
        self.start_exposure(exposure_us)?;
        self.finish_exposure()
    }

    /// Reads `window` of the last image into `pixels`, row by row, raw digital numbers.
    ///
    /// # Errors
    /// [`ErrorKind::OutsideDetector`] and [`ErrorKind::BufferLength`] for a wrong request (then `pixels` is
    /// untouched), [`ErrorKind::NotExposed`] before the first exposure, [`ErrorKind::Timeout`] or
    /// [`ErrorKind::Bus`] when the hardware fails (then `pixels` is not to be used).
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), Self::Error>;
}

impl<D: Detector + ?Sized> Detector for &mut D {
    fn geometry(&self) -> DetectorGeometry {
        D::geometry(self)
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), Self::Error> {
        D::start_exposure(self, exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, Self::Error> {
        D::finish_exposure(self)
    }

    fn expose(&mut self, exposure_us: u32) -> Result<LocalTime, Self::Error> {
        D::expose(self, exposure_us)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), Self::Error> {
        D::read(self, window, pixels)
    }
}

/// Any detector, its errors reduced to their kinds: so the flight code needs one error type inside.
#[derive(Debug)]
pub struct ByKind<'a, D: ?Sized>(pub &'a mut D);

impl<D: ?Sized> ErrorType for ByKind<'_, D> {
    type Error = ErrorKind;
}

impl<D: Detector + ?Sized> Detector for ByKind<'_, D> {
    fn geometry(&self) -> DetectorGeometry {
        self.0.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), ErrorKind> {
        self.0.start_exposure(exposure_us).map_err(|error| error.kind())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, ErrorKind> {
        self.0.finish_exposure().map_err(|error| error.kind())
    }

    fn expose(&mut self, exposure_us: u32) -> Result<LocalTime, ErrorKind> {
        self.0.expose(exposure_us).map_err(|error| error.kind())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), ErrorKind> {
        self.0.read(window, pixels).map_err(|error| error.kind())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: DetectorGeometry = DetectorGeometry { width_px: 1280, height_px: 1024, bits: 10 };

    fn window(x: u16, y: u16, width: u16, height: u16) -> Window {
        Window { x, y, width, height }
    }

    #[test]
    fn full_scale_is_all_bits_set_and_never_more_than_a_u16() {
        for (bits, full_scale) in [(1, 1), (8, 255), (10, 1023), (12, 4095), (15, 32_767), (16, u16::MAX)] {
            assert_eq!(DetectorGeometry { bits, ..REFERENCE }.full_scale(), full_scale);
        }
        assert_eq!(DetectorGeometry { bits: u8::MAX, ..REFERENCE }.full_scale(), u16::MAX);
    }

    #[test]
    fn the_whole_window_covers_every_pixel() {
        assert_eq!(REFERENCE.whole().area(), 1280 * 1024);
        assert!(REFERENCE.whole().fits(&REFERENCE));
    }

    #[test]
    fn the_largest_window_has_a_countable_area() {
        assert_eq!(window(0, 0, u16::MAX, u16::MAX).area(), 65_535 * 65_535);
        assert_eq!(window(5, 5, 0, 7).area(), 0);
    }

    #[test]
    fn a_window_fits_to_the_last_pixel_and_no_further() {
        assert!(window(1279, 1023, 1, 1).fits(&REFERENCE));
        assert!(window(1253, 997, 27, 27).fits(&REFERENCE));
        for beyond in [
            window(1280, 0, 1, 1),
            window(0, 1024, 1, 1),
            window(1254, 0, 27, 27),
            window(0, 998, 27, 27),
            window(0, 0, 1281, 1024),
            window(0, 0, 1280, 1025),
        ] {
            assert!(!beyond.fits(&REFERENCE), "{beyond:?}");
        }
    }

    #[test]
    fn a_window_whose_end_overflows_sixteen_bits_does_not_fit() {
        let largest = DetectorGeometry { width_px: u16::MAX, height_px: u16::MAX, bits: 16 };
        assert!(largest.whole().fits(&largest));
        assert!(!window(u16::MAX, 0, u16::MAX, 1).fits(&largest));
        assert!(!window(0, 2, 1, u16::MAX).fits(&largest));
        assert!(!window(u16::MAX, u16::MAX, 1, 1).fits(&REFERENCE));
    }
}
