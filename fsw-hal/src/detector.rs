//! Active-pixel detector with random-access (windowed) readout.
//!
//! A second of operation is one [`Detector::expose`] and then any number of [`Detector::read`] calls; all windows
//! read between two exposures belong to the same image, and a window read twice gives the same values.

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
pub enum DetectorError {
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

/// A detector that exposes an image and hands out windows of it.
pub trait Detector {
    /// Size and resolution; the same at every call.
    fn geometry(&self) -> DetectorGeometry;

    /// Takes a new image, integrating for `exposure_us` microseconds.
    ///
    /// # Errors
    /// [`DetectorError::Exposure`] for a time the detector cannot do, [`DetectorError::Timeout`] or
    /// [`DetectorError::Bus`] when the hardware fails.
    fn expose(&mut self, exposure_us: u32) -> Result<(), DetectorError>;

    /// Reads `window` of the last image into `pixels`, row by row, raw digital numbers.
    ///
    /// # Errors
    /// [`DetectorError::OutsideDetector`] and [`DetectorError::BufferLength`] for a wrong request (then `pixels` is
    /// untouched), [`DetectorError::NotExposed`] before the first exposure, [`DetectorError::Timeout`] or
    /// [`DetectorError::Bus`] when the hardware fails (then `pixels` is not to be used).
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError>;
}
