//! Where the flight code finds a star in a window; single stars before a lens, to judge that by.
//!
//! In: pixels about a star. Out: the flight code's centroid. [`Lens`] draws stars without noise in windows of
//! their own, in electrons, by the world's [`Psf`] and [`PixelResponse`]: no calibration is made from it.

use super::HALF_WINDOW_PX;
use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::world::detector::imaging::ImagingModel;
use crate::world::detector::pixel::PixelResponse;
use crate::world::lens::optics::Optics;
use crate::world::lens::psf::Psf;
use crate::world::lens::spots::{Brush, Spot};
use crate::world::sky::colour;
use crate::world::sky::stars::DetectorModel;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::scan::{Detections, TILE_PIXELS, read_stars};
use fsw_core::image::{DetectionMethod, DetectionParameters};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use std::sync::Arc;

/// Electrons of the stars: bright, but no pixel near its full well.
const ELECTRONS: f64 = 50_000.0;
/// Bits of the converter that draws them: so many that it does not matter.
const BITS: u8 = 16;

/// Colour of the stars that centroids are judged by, B-V: the mean of those of the catalogue.
pub const COLOUR: f64 = 0.6;

/// Stars without noise, as the world images them.
#[derive(Debug, Clone)]
pub struct Lens {
    psf: Arc<Psf>,
    response: PixelResponse,
    full_well_e: f64,
    colours: bool,
}

impl Lens {
    /// Of a camera with these optics and pixels.
    ///
    /// # Errors
    /// Where the world cannot draw it.
    pub fn new(
        camera: &CameraFile,
        imaging: &ImagingModel,
        detector: &DetectorModel,
    ) -> Result<Self, HostError> {
        let refuse = |what: &str| HostError::usage(what, "give another camera, or other [optics]");
        let optics = Optics::new(camera).ok_or_else(|| refuse("the world draws rectilinear cameras only"))?;
        let psf = imaging.psf(&optics).ok_or_else(|| refuse("the lens cannot be made for this camera"))?;
        Ok(Self {
            psf,
            response: detector.response,
            full_well_e: detector.full_well_e,
            colours: imaging.star_colours,
        })
    }

    /// Adds the image of a star to the pixels of a window.
    pub fn draw(&self, response: PixelResponse, spot: &Spot, window: Window, light: &mut [f64]) {
        Brush::default().draw(&self.psf, response, spot, window, light);
    }

    /// A star of so many electrons and this colour.
    pub fn spot(&self, at_px: [f64; 2], electrons: f64, b_v: f64) -> Spot {
        let shares = colour::shares(if self.colours { b_v } else { 0.0 });
        let all: f64 = shares.iter().sum();
        Spot { x_px: at_px[0], y_px: at_px[1], electrons: shares.map(|share| electrons * share / all) }
    }

    /// Where the flight code finds a star without noise; `None` where it finds none.
    pub fn measured(&self, at_px: [f64; 2], b_v: f64, calibration: Option<&Calibration>) -> Option<[f64; 2]> {
        let window = window_about(at_px);
        let mut light = vec![0.0; window.area()];
        self.draw(self.response, &self.spot(at_px, ELECTRONS, b_v), window, &mut light);
        let full_scale = f64::from((1u32 << BITS) - 1);
        let number = |e: &f64| (e / self.full_well_e * full_scale + 1000.5).clamp(0.0, full_scale) as u16;
        let found = find(window, BITS, light.iter().map(number).collect(), calibration, at_px)?;
        Some(found.0)
    }
}

/// A window about a place.
pub fn window_about(at_px: [f64; 2]) -> Window {
    let [x, y] = at_px.map(|at| (at.round() as u16).saturating_sub(HALF_WINDOW_PX));
    Window { x, y, width: 2 * HALF_WINDOW_PX + 1, height: 2 * HALF_WINDOW_PX + 1 }
}

/// A window that has been read.
struct Drawn {
    bits: u8,
    pixels: Vec<u16>,
}

impl fsw_hal::ErrorType for Drawn {
    type Error = DetectorError;
}

impl Detector for Drawn {
    fn geometry(&self) -> DetectorGeometry {
        DetectorGeometry { width_px: u16::MAX, height_px: u16::MAX, bits: self.bits }
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, _: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        pixels.copy_from_slice(&self.pixels);
        Ok(())
    }
}

/// The flight code's centroid nearest to a place in a window with these pixels, and its sigma, px. Whether it
/// has a star's shape is not asked here: centres do not depend on it.
pub fn find(
    window: Window,
    bits: u8,
    pixels: Vec<u16>,
    calibration: Option<&Calibration>,
    near_px: [f64; 2],
) -> Option<([f64; 2], f64)> {
    let parameters = DetectionParameters {
        peak_to_region_percent: 0,
        peak_to_inner_percent: 0,
        inner_to_outer_percent: 0,
        inner_share_percent: 0,
        ..DetectionParameters::default()
    };
    let method = DetectionMethod { parameters: &parameters, calibration, turn: None };
    let (mut detections, mut buffer) = (Detections::new(), [0; TILE_PIXELS]);
    read_stars(&mut Drawn { bits, pixels }, window, &mut buffer, method, &mut detections).ok()?;
    let place = |x: i32| f64::from(x) / 65_536.0;
    let spots = detections.spots().iter().map(|spot| {
        let at = [place(spot.x_q16), place(spot.y_q16)];
        let square = (0..2).map(|k| (at[k] - near_px[k]).powi(2)).sum::<f64>();
        (square, at, place(spot.sigma_q16))
    });
    let nearest = spots.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((nearest.1, nearest.2))
}
