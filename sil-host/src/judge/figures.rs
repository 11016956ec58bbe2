//! What a run comes to: the figures of `summary.json`.
//!
//! Errors are those of [`QUANTITIES`](super::quantities::QUANTITIES), over the run and over its last orbit:
//! the last revolution, or the second half of a run shorter than two.

use super::expected::Disagreement;
use super::series::Statistics;
use serde::Serialize;
use std::collections::BTreeMap;

/// Attitude of the thesis with five stars (tab. 7.4), about x, y, z, arcsec.
pub const THESIS_ATTITUDE_ARCSEC: [f64; 3] = [4.4, 4.4, 28.3];
/// Position of the thesis in GEO after two to three orbits with 0.1 deg of noise: radial, along, cross, km.
pub const THESIS_POSITION_KM: [f64; 3] = [0.5, 1.5, 0.5];

/// Attitude over the run, about x, y, z of the star path.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AttitudeFigures {
    /// Root mean square error.
    pub rms_arcsec: Option<[f64; 3]>,
    /// Mean error over the run: bias.
    pub bias_arcsec: Option<[f64; 3]>,
    /// Root mean square about it: noise.
    pub noise_arcsec: Option<[f64; 3]>,
    /// Root mean square of the reported sigmas.
    pub sigma_arcsec: Option<[f64; 3]>,
    /// Cramer-Rao bound for the stars used, sampled.
    pub bound_arcsec: Option<[f64; 3]>,
    /// Largest error over its sigma.
    pub largest_sigma: Option<f64>,
    /// The thesis's figures.
    pub thesis_arcsec: [f64; 3],
}

/// Rates that needed no attitude, over the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RateFigures {
    /// Seconds until the first of known sense, that second included.
    pub first_s: Option<u32>,
    /// Share of the seconds without an attitude, outside Sun states and self-tests, with a rate.
    pub share: Option<f64>,
    /// Share of these rates of which either sense is said to be possible.
    pub either_sense_share: Option<f64>,
    /// Median of the error of the size, percent.
    pub error_percent: Option<f64>,
    /// Median of the error of the axis.
    pub axis_deg: Option<f64>,
    /// Share of the rates with every axis within three sigma.
    pub within_3_sigma_share: Option<f64>,
}

/// The filtered attitude over the run, about x, y, z of the star path.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FilteredFigures {
    /// Root mean square error.
    pub rms_arcsec: Option<[f64; 3]>,
    /// Mean error over the run: bias.
    pub bias_arcsec: Option<[f64; 3]>,
    /// Root mean square about it: noise.
    pub noise_arcsec: Option<[f64; 3]>,
    /// Root mean square of the reported sigmas.
    pub sigma_arcsec: Option<[f64; 3]>,
    /// Share of the seconds with every axis within three sigma.
    pub within_3_sigma_share: Option<f64>,
    /// Mean of (error / sigma)² over the axes; 1 where the sigmas are right.
    pub normalised_square: Option<f64>,
}

/// The Earth's direction and distance over the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EarthFigures {
    /// Seconds in which it was found.
    pub found_s: u32,
    /// Root mean square error of the direction per axis.
    pub direction_rms_deg: Option<f64>,
    /// Root mean square of the reported sigma.
    pub direction_sigma_deg: Option<f64>,
    /// Share within three sigma on both axes.
    pub direction_within_3_sigma_share: Option<f64>,
    /// Root mean square error of the distance.
    pub distance_rms_km: Option<f64>,
    /// Root mean square of the reported sigma.
    pub distance_sigma_km: Option<f64>,
    /// Share within three sigma.
    pub distance_within_3_sigma_share: Option<f64>,
}

/// The orbit over the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OrbitFigures {
    /// Seconds until there was an orbit.
    pub first_s: Option<u32>,
    /// Seconds until the filter had converged.
    pub settled_s: Option<u32>,
    /// 3-D position error in the last second with an orbit.
    pub final_position_km: Option<f64>,
    /// Radial, along, cross position error, rms of the last orbit.
    pub last_orbit_rac_km: Option<[f64; 3]>,
    /// 3-D position error, rms of the last orbit.
    pub last_orbit_position_km: Option<f64>,
    /// Bound of the position by the horizon ([`crate::bound::position`]), radial, along, cross, rms of the
    /// last orbit.
    pub last_orbit_bound_rac_km: Option<[f64; 3]>,
    /// The same in 3-D.
    pub last_orbit_bound_km: Option<f64>,
    /// The same after each orbit, radial, along, cross; none where the limb seen fixed no orbit yet.
    pub orbit_bounds_rac_km: Vec<Option<[f64; 3]>>,
    /// 3-D velocity error, rms of the last orbit.
    pub last_orbit_velocity_m_s: Option<f64>,
    /// Share of the seconds with every axis (radial, along, cross) within three sigma.
    pub position_within_3_sigma_share: Option<f64>,
    /// Mean NEES over its three degrees of freedom; 1 where the covariance is right.
    pub position_normalised_square: Option<f64>,
    /// Largest position error over its sigma.
    pub position_largest_sigma: Option<f64>,
    /// The same in eclipse and Sun outage.
    pub outage_largest_sigma: Option<f64>,
    /// Longest time without a fix.
    pub longest_without_fix_s: u32,
    /// Largest change of the position's error from one second to the next, over the sigma before it.
    pub position_jump_sigma: Option<f64>,
    /// The second of it.
    pub position_jump_at_s: Option<u32>,
    /// Mean normalised innovation squared of a degree of freedom; 1 where noise and sigmas agree.
    pub nis_mean: Option<f64>,
    /// Probability of such a mean or one farther from 1, if noise and sigmas agree.
    pub nis_consistency: Option<f64>,
    /// The thesis's figures for GEO: radial, along, cross.
    pub thesis_geo_rac_km: [f64; 3],
}

/// A run's figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Seconds flown.
    pub seconds: u32,
    /// Seconds until the first attitude, that second included.
    pub first_attitude_s: Option<u32>,
    /// Share of the seconds outside Sun states with an attitude.
    pub attitude_valid_share: Option<f64>,
    /// Share of these attitudes with every axis within three sigma.
    pub within_3_sigma_share: Option<f64>,
    /// Longest time without an attitude outside Sun states, after the first one.
    pub recovery_s: Option<u32>,
    /// Share of seconds whose mode is as the geometry says.
    pub mode_share: Option<f64>,
    /// Share of the seconds in which the sensor tells its state.
    pub state_told_share: Option<f64>,
    /// Share of these in which it is as the geometry says.
    pub state_share: Option<f64>,
    /// Longest time from a change of the geometry to the mode that it asks for.
    pub mode_latest_s: Option<u32>,
    /// Most changes of the mode within ten seconds, but those by command and the self-test's end.
    pub mode_changes_10_s: Option<u32>,
    /// Share of the seconds with attitude and orbit in which the next change of state is foreseen.
    pub next_state_share: Option<f64>,
    /// Error of the length that this state has, where its begin is known to 5 s, 95 %, s.
    pub next_state_length_95_s: Option<f64>,
    /// Seconds in which a number was not finite or a sigma not positive, over all quantities.
    pub not_finite: u32,
    /// Seconds in which the lit arc is too short to be called light or dark.
    pub faint_limb_s: u32,
    /// Seconds in which the sensor turns too fast for a mode to be asked for.
    pub fast_s: u32,
    /// Seconds in each mode.
    pub mode_seconds: BTreeMap<&'static str, u32>,
    /// The longest stretches in which the mode was another.
    pub disagreements: Vec<Disagreement>,
    /// Attitude.
    pub attitude: AttitudeFigures,
    /// Rates that needed no attitude.
    pub rate: RateFigures,
    /// The same filtered.
    pub filtered: FilteredFigures,
    /// The Earth as seen.
    pub earth: EarthFigures,
    /// Position and velocity.
    pub orbit: OrbitFigures,
    /// Every quantity that was estimated.
    pub quantities: BTreeMap<&'static str, QuantityFigures>,
}

/// A quantity over the run and over its last orbit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct QuantityFigures {
    /// Unit of errors and sigmas.
    pub unit: &'static str,
    /// From its first second on.
    pub run: Option<Statistics>,
    /// The last orbit.
    pub last_orbit: Option<Statistics>,
}

impl Figures {
    /// A quantity over the run.
    pub fn run(&self, quantity: &str) -> Option<&Statistics> {
        self.quantities.get(quantity)?.run.as_ref()
    }

    /// A quantity over the last orbit.
    pub fn last_orbit(&self, quantity: &str) -> Option<&Statistics> {
        self.quantities.get(quantity)?.last_orbit.as_ref()
    }
}
