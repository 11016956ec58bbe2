//! Bad pixels and offsets of columns in front of the detector that C lends.
//!
//! In: a detector and the table of the sensor, where it has one. Out: a detector whose windows are corrected
//! as they are read. Without a table a window costs nothing more.

use crate::instruments::CDetector;
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::defects::Defects;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, LocalTime, Window};

/// A detector whose defects are taken off where they are known.
pub(crate) struct CorrectedDetector {
    pub(crate) detector: CDetector,
    pub(crate) bad_pixels: Option<Defects<'static>>,
}

impl fsw_hal::ErrorType for CorrectedDetector {
    type Error = DetectorError;
}

impl Detector for CorrectedDetector {
    fn geometry(&self) -> DetectorGeometry {
        self.detector.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.detector.start_exposure(exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        self.detector.finish_exposure()
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        match self.bad_pixels {
            None => self.detector.read(window, pixels),
            Some(defects) => BadPixelDetector::new(&mut self.detector, defects)
                .map_err(|_| DetectorError::OutsideDetector)?
                .read(window, pixels),
        }
    }
}
