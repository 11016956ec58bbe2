//! Parameters of the orbit filter.

use super::dynamics::Dynamics;
use crate::parameters::table::parameter_group;
use serde::{Deserialize, Serialize};

/// Components of a fix that are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Observation {
    /// All of it, with its covariance.
    Position,
    /// Its direction alone (eq. 5.25): the two components across the line to the Earth. Independent of the
    /// limb's height. After [`super::filter::OrbitFilter::initialise`] it converges from a distance wrong by
    /// up to three Earth radii in GEO.
    UnitVector,
    /// All of it until the filter has settled, its direction afterwards.
    Combined,
}

parameter_group! {
    /// Propagation and filter of the orbit.
    pub struct OrbitParameters in "orbit" {
        /// Components of a fix that are used.
        observation: Observation = Observation::Position, one of "Position, UnitVector, Combined", "",
            "the distance helps from every orbit";
        /// Forces of the prediction.
        dynamics: Dynamics = Dynamics::Full, one of "Kepler, Full", "", "J2, Sun and Moon";
        /// Share of a circular orbit's speed within which the velocity is taken to be zero along every axis
        /// at the start.
        start_speed_share: f32 = 1.0, 0.1..=3.0, "",
            "no fix measures the velocity: the circular speed itself is its sigma";
        /// Standard deviation of the limb height about the one that was set: colour, season, air masses and
        /// the slant of the light over thousands of km.
        limb_height_sigma_km: f32 = 2.0, 0.0..=100.0, "km",
            "rendered orbits: 2.1 km, the mean height of an arc in LEO and SSO";
        /// The same as an angle: the edge's blurred profile may be misjudged. It matters from afar. Both are
        /// joined as squares.
        limb_height_sigma_rad: f32 = 3e-5, 0.0..=0.01, "rad", "a tenth of the reference camera's pixel";
        /// Time for which a limb height lasts, over the time in which the satellite goes a radian of its
        /// orbit.
        limb_height_time_share: f32 = 0.5, 0.001..=100.0, "",
            "2 hours in GEO, 8 min in LEO; rendered orbits: 300 to 400 s in LEO";
        /// Misalignment of the paths against each other about each axis.
        misalignment_sigma_rad: f32 = 5e-5, 0.0..=0.02, "rad",
            "10 arcsec, 0.15 px of the reference camera: either path aligned to 0.1 px, the centroid error \
             of the thesis";
        /// Slow errors of a fix (clouds on the limb, the slant of the light) over its white noise, in every
        /// direction alike: neighbouring points of the limb share their clouds, which their sigmas do not
        /// include. They are considered, not estimated.
        bias_over_noise: f32 = 16.0, 0.0..=30.0, "", "rendered orbits: sigmas hold from the first orbit on";
        /// Time for which they last, over the Earth's rate divided by the square of the satellite's: the
        /// higher the orbit, the longer the same clouds are on the limb.
        bias_time_share: f32 = 0.08, 0.001..=10.0, "", "18 min in GEO, 5 s in LEO; rendered orbits";
        /// White acceleration at the Earth's surface, per root hertz. It stands for the gravity of the
        /// degrees above J2, 1e-7 km/s2 for a minute or so in LEO. It falls with the fourth power of the
        /// radius, as the pull of the second degree's tesserals does, so that one value serves from LEO to
        /// GEO.
        gravity_noise_km_s15: f32 = 2e-6, 0.0..=1e-3, "km/s^1.5",
            "errors on the real orbit of Jason-2 are as the filter says";
        /// White acceleration everywhere, per root hertz.
        force_noise_km_s15: f32 = 2e-8, 0.0..=1e-3, "km/s^1.5",
            "radiation pressure: 1e-10 km/s2 that lasts for hours";
        /// Gate: largest normalised innovation squared of an accepted fix.
        gate_nis: f32 = 30.0, 10.0..=1000.0, "", "chi squared of three: one good fix in a million is lost";
        /// Rejections in a row after which the filter starts anew.
        patience: u16 = 10, 1..=600, "",
            "twice the 5 s for which the errors of fixes last in LEO (`bias_time_share`)";
        /// The filter has settled when position and velocity are known to this share of their length.
        settled_share: f32 = 1e-3, 1e-6..=0.1, "",
            "a tenth of 0.01, at which the covariance is inflated last; 42 km in GEO, 7 km in LEO";
    }
}
