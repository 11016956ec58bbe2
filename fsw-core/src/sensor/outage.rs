//! The Sun in a path: a blinded detector, and an outage that lasts.

use super::Sensor;
use super::propagation::Ephemeris;
use crate::modes::Mode;

/// Angular radius of the Sun, rad: 0.267 deg.
const SUN_RADIUS_RAD: f32 = 4.66e-3;

impl Sensor<'_> {
    /// In a Sun outage the filter's state is propagated every second: no step is longer, whatever the outage
    /// lasts.
    pub(super) fn propagate_in_outage(&mut self, mode: Mode) {
        if let (Mode::SunOutage, Some(motion)) = (mode, &mut self.motion) {
            motion.propagate(self.now, None);
        }
    }

    /// Whether the Sun's disc touches the field of a path, by the predicted attitude.
    #[inline(never)]
    pub(super) fn sun_is_in_path(&self, ephemeris: &Ephemeris) -> bool {
        let Some((attitude, _)) = self.motion.as_ref().and_then(|motion| motion.at(self.now)) else {
            return false;
        };
        let in_star_path = attitude.apply(&ephemeris.sun);
        let in_earth_path = self.mounting().apply(&in_star_path);
        let radius_px = SUN_RADIUS_RAD / self.camera.rad_per_px();
        [self.camera.project(&in_star_path), self.camera.project_earth(&in_earth_path)]
            .into_iter()
            .flatten()
            .any(|at_px| self.camera.contains(at_px, -radius_px))
    }
}
