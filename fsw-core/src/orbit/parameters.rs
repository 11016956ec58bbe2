//! What is set of the orbit filter, with units, defaults and ranges.

use super::dynamics::Dynamics;
use serde::{Deserialize, Serialize};

/// What of a fix is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Observation {
    /// All of it, with its covariance.
    Position,
    /// Its direction alone (eq. 5.25): the two components across the line to the Earth. The limb's height
    /// plays no part. From a start given by [`super::filter::OrbitFilter::start`] it converges if the
    /// distance is wrong by up to three Earth radii in GEO.
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
    /// Velocity is unknown about zero by this share of a circular orbit's speed along every axis when the
    /// filter starts (default 1, 0.1 to 3).
    pub start_speed_share: f32,
    /// Standard deviation of the limb height about the one that was set, km (default 2, 0 to 100: what
    /// colour, season, air masses and the slant of the light leave open over thousands of km).
    pub limb_height_sigma_km: f32,
    /// The same as an angle, rad (default 3e-5, 0 to 0.01): a tenth of the reference camera's pixel, by which
    /// the edge's blurred profile may be misjudged; it matters from afar. Both are joined as squares.
    pub limb_height_sigma_rad: f32,
    /// Time for which a limb height lasts, over the time in which the satellite goes a radian of its orbit
    /// (default 0.5: 2 hours in GEO, 8 min in LEO; 0.001 to 100).
    pub limb_height_time_share: f32,
    /// Misalignment of the paths against each other about each axis, rad (default 5e-5: 10 arcsec; 0 to
    /// 0.02).
    pub misalignment_sigma_rad: f32,
    /// Slow errors of a fix (clouds on the limb, the slant of the light) over its white noise, in every
    /// direction alike (default 16, 0 to 30): neighbouring points of the limb share their clouds, which their
    /// sigmas do not know. They are considered, not estimated.
    pub bias_over_noise: f32,
    /// Time for which they last, over the Earth's rate divided by the square of the satellite's: the higher
    /// it flies, the longer it looks at the same clouds (default 0.08: 18 min in GEO, 5 s in LEO; 0.001 to
    /// 10).
    pub bias_time_share: f32,
    /// White acceleration at the Earth's surface, km/s² per root hertz (default 2e-6, 0 to 1e-3). It stands
    /// for the gravity of the degrees above J2, 1e-7 km/s² with a correlation of a minute or so in LEO; with
    /// this value the filter's errors on the real orbit of Jason-2 are as it says (test
    /// `a_real_orbit_is_followed`). It falls with the fourth power of the radius, as the pull of the second
    /// degree's tesserals does, so that one value serves from LEO to GEO.
    pub gravity_noise_km_s15: f32,
    /// White acceleration everywhere, km/s² per root hertz (default 2e-8, 0 to 1e-3): radiation pressure,
    /// 1e-10 km/s² that lasts for hours.
    pub force_noise_km_s15: f32,
    /// Largest normalised innovation squared that is believed (default 30: one good fix in a million is lost;
    /// 10 to 1000).
    pub gate_nis: f32,
    /// Rejections in a row after which the filter starts anew (default 10, 1 to 600).
    pub patience: u16,
    /// The filter has settled when position and velocity are known to this share of their length (default
    /// 1e-3, 1e-6 to
    /// 0.1).
    pub settled_share: f32,
}

impl Default for OrbitParameters {
    fn default() -> Self {
        Self {
            observation: Observation::Position,
            dynamics: Dynamics::Full,
            start_speed_share: 1.0,
            limb_height_sigma_km: 2.0,
            limb_height_sigma_rad: 3e-5,
            limb_height_time_share: 0.5,
            misalignment_sigma_rad: 5e-5,
            bias_over_noise: 16.0,
            bias_time_share: 0.08,
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
    pub fn ranges(&self) -> [(&'static str, f32, f32, f32); 12] {
        [
            ("start_speed_share", self.start_speed_share, 0.1, 3.0),
            ("limb_height_sigma_km", self.limb_height_sigma_km, 0.0, 100.0),
            ("limb_height_sigma_rad", self.limb_height_sigma_rad, 0.0, 0.01),
            ("limb_height_time_share", self.limb_height_time_share, 0.001, 100.0),
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
