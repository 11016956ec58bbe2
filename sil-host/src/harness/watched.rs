//! A detector that notes which windows are read: what the flight code looked at in a second.

use fsw_hal::{Detector, DetectorError, DetectorGeometry, LocalTime, Window};

/// A detector, and the windows that were read from it.
#[derive(Debug)]
pub(super) struct Watched<'a, D> {
    pub detector: &'a mut D,
    /// Those that the detector delivered, in the order in which they were read.
    pub windows: &'a mut Vec<Window>,
}

impl<D: Detector<Error = DetectorError>> fsw_hal::ErrorType for Watched<'_, D> {
    type Error = DetectorError;
}

impl<D: Detector<Error = DetectorError>> Detector for Watched<'_, D> {
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
        self.detector.read(window, pixels)?;
        self.windows.push(window);
        Ok(())
    }
}
