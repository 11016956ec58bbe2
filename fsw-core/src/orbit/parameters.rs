//! What is set of the orbit filter, with units, defaults and ranges.

use super::dynamics::Dynamics;
use serde::{Deserialize, Serialize};

/// What of a fix is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Observation {
    /// All of it, with its covariance.
    Position,
    /// Its direction alone (eq. 5.25): the two components across the line to the Earth. The limb's height plays no part.
    /// From a start given by [`super::filter::OrbitFilter::start`] it converges if the distance is wrong by up to three Earth
    /// radii in GEO.
    UnitVector,
    /// All of it until the filter has settled, its direction afterwards.
    Combined,
}

/// Parameters of the orbit filter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrbitParameters {
    /// What of a fix is used (default `Position`).
    pub observation: Observation,
    /// Forces of the prediction (default `Full`).
    pub dynamics: Dynamics,
    /// Velocity is unknown by this much about zero when the filter starts, km/s (default 8, 0.1 to 20).
    pub start_speed_km_s: f32,
    /// Limb height is unknown by this much when the filter starts, km (default 0.7, 0 to 100: what colour and season leave
    /// of the height that was set).
    pub limb_height_sigma_km: f32,
    /// Random walk of the limb height, km per root second (default 0.01: 0.4 km in half an hour; 0 to 1).
    pub limb_height_walk_km_s05: f32,
    /// Misalignment of the paths against each other about each axis, rad (default 1e-4: 20 arcsec; 0 to 0.02).
    pub misalignment_sigma_rad: f32,
    /// Slow errors of a fix (clouds on the limb, the slant of the light) over its white noise, in every direction alike
    /// (default 3, 0 to 30). They are considered, not estimated.
    pub bias_over_noise: f32,
    /// Time for which they last, over the time in which the satellite goes a radian of its orbit (default 0.2: 45 min in GEO,
    /// 3 min in LEO; 0.001 to 10).
    pub bias_time_share: f32,
    /// White acceleration at the Earth's surface, km/s² per root hertz (default 2e-6, 0 to 1e-3). It stands for the gravity
    /// of the degrees above J2, 1e-7 km/s² with a correlation of a minute or so in LEO; with this value the filter's errors
    /// on the real orbit of Jason-2 are as it says (test `a_real_orbit_is_followed`). It falls with the fourth power of the
    /// radius, as the pull of the second degree's tesserals does, so that one value serves from LEO to GEO.
    pub gravity_noise_km_s15: f32,
    /// White acceleration everywhere, km/s² per root hertz (default 2e-8, 0 to 1e-3): radiation pressure, 1e-10 km/s² that
    /// lasts for hours.
    pub force_noise_km_s15: f32,
    /// Largest normalised innovation squared that is believed (default 30: one good fix in a million is lost; 10 to 1000).
    pub gate_nis: f32,
    /// Rejections in a row after which the filter starts anew (default 10, 1 to 600).
    pub patience: u16,
    /// The filter has settled when position and velocity are known to this share of their length (default 1e-3, 1e-6 to
    /// 0.1).
    pub settled_share: f32,
}

impl Default for OrbitParameters {
    fn default() -> Self {
        Self {
            observation: Observation::Position,
            dynamics: Dynamics::Full,
            start_speed_km_s: 8.0,
            limb_height_sigma_km: 0.7,
            limb_height_walk_km_s05: 0.01,
            misalignment_sigma_rad: 1e-4,
            bias_over_noise: 3.0,
            bias_time_share: 0.2,
            gravity_noise_km_s15: 2e-6,
            force_noise_km_s15: 2e-8,
            gate_nis: 30.0,
            patience: 10,
            settled_share: 1e-3,
        }
    }
}

impl OrbitParameters {
    /// Every number with its name and range `(name, value, low, high)`, for the checked table.
    pub fn ranges(&self) -> [(&'static str, f32, f32, f32); 11] {
        [
            ("start_speed_km_s", self.start_speed_km_s, 0.1, 20.0),
            ("limb_height_sigma_km", self.limb_height_sigma_km, 0.0, 100.0),
            ("limb_height_walk_km_s05", self.limb_height_walk_km_s05, 0.0, 1.0),
            ("misalignment_sigma_rad", self.misalignment_sigma_rad, 0.0, 0.02),
            ("bias_over_noise", self.bias_over_noise, 0.0, 30.0),
            ("bias_time_share", self.bias_time_share, 0.001, 10.0),
            ("gravity_noise_km_s15", self.gravity_noise_km_s15, 0.0, 1e-3),
            ("force_noise_km_s15", self.force_noise_km_s15, 0.0, 1e-3),
            ("gate_nis", self.gate_nis, 10.0, 1000.0),
            ("patience", f32::from(self.patience), 1.0, 600.0),
            ("settled_share", self.settled_share, 1e-6, 0.1),
        ]
    }
}
