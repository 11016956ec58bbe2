//! The shutters of the two paths in the world: their driver, and the detector behind them.

use super::ThisSecond;
use fsw_hal::{
    Detector, DetectorError, DetectorGeometry, LocalTime, OpenPaths, Shutter, ShutterError, Window,
};
use std::cell::Cell;

/// Shutters before a detector: what they were told last counts for the next exposure.
pub(super) struct Shuttered<'a, 's> {
    /// The detector behind them.
    pub(super) detector: ThisSecond<'a>,
    /// Where they stand.
    pub(super) stand: &'s Cell<OpenPaths>,
}

impl fsw_hal::ErrorType for Shuttered<'_, '_> {
    type Error = DetectorError;
}

impl Detector for Shuttered<'_, '_> {
    fn geometry(&self) -> DetectorGeometry {
        self.detector.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.detector.scene.open(self.stand.get());
        self.detector.start_exposure(exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        self.detector.finish_exposure()
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.detector.read(window, pixels)
    }
}

/// The shutters' driver. Those that are stuck stay where they are, and it does not know.
pub(super) struct Shutters<'s> {
    /// Where they stand.
    pub(super) stand: &'s Cell<OpenPaths>,
    /// Whether they do not move.
    pub(super) stuck: bool,
}

impl fsw_hal::ErrorType for Shutters<'_> {
    type Error = ShutterError;
}

impl Shutter for Shutters<'_> {
    fn open(&mut self, paths: OpenPaths) -> Result<(), ShutterError> {
        if !self.stuck {
            self.stand.set(paths);
        }
        Ok(())
    }
}
