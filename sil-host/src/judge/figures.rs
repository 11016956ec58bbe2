//! What a run comes to: the figures of `summary.json`, and the limits kept or not.
//!
//! In: [`Judged`] seconds, one after the other; constant memory. Attitude is judged in the seconds in which
//! the Sun does not blind the detector; position and velocity from the first orbit on, for its sigmas must
//! hold even while the filter converges; the last orbit is the last revolution, or the second half of a run
//! shorter than two.

use super::arcsec;
use super::expected::{Disagreement, ModeJudge, word};
use super::second::{Axes, Judged};
use super::sums::{AxesSums, Median, Share, Squares};
use crate::scenario::{Limit, Side};
use crate::world::attitude::Vector;
use crate::world::scene::SensorState;
use fsw_core::modes::Mode;
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
    /// 3-D velocity error, rms of the last orbit.
    pub last_orbit_velocity_m_s: Option<f64>,
    /// Share of the seconds with every ICRS axis within three sigma.
    pub position_within_3_sigma_share: Option<f64>,
    /// Mean of (error / sigma)² over the ICRS axes; 1 where the sigmas are right.
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
    /// Mean normalised innovation squared; 3 where noise and sigmas agree.
    pub nis_mean: Option<f64>,
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
    /// Share of seconds whose mode is as the geometry says.
    pub mode_share: Option<f64>,
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
}

impl Figures {
    /// The figure a limit is set on; `None` where the run did not yield it.
    pub fn of(&self, key: &str) -> Option<f64> {
        match key {
            "attitude_valid_share" => self.attitude_valid_share,
            "within_3_sigma_share" => self.within_3_sigma_share,
            "position_within_3_sigma_share" => self.orbit.position_within_3_sigma_share,
            "mode_share" => self.mode_share,
            "first_attitude_s" => self.first_attitude_s.map(f64::from),
            "attitude_rms_arcsec" => self.attitude.rms_arcsec.map(|[x, y, _]| x.max(y)),
            "rate_share" => self.rate.share,
            "rate_error_percent" => self.rate.error_percent,
            "rate_axis_deg" => self.rate.axis_deg,
            "rate_within_3_sigma_share" => self.rate.within_3_sigma_share,
            "filtered_rms_arcsec" => self.filtered.rms_arcsec.map(|[x, y, _]| x.max(y)),
            "earth_direction_rms_deg" => self.earth.direction_rms_deg,
            "earth_distance_rms_km" => self.earth.distance_rms_km,
            "final_position_km" => self.orbit.final_position_km,
            "last_orbit_position_km" => self.orbit.last_orbit_position_km,
            "last_orbit_velocity_m_s" => self.orbit.last_orbit_velocity_m_s,
            "position_jump_sigma" => self.orbit.position_jump_sigma,
            _ => None,
        }
    }
}

/// A limit, held against the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The figure's key.
    pub limit: &'static str,
    /// The side on which it is kept.
    pub side: Side,
    /// What was demanded.
    pub demanded: f64,
    /// What was reached; none where the run did not yield the figure.
    pub reached: Option<f64>,
    /// Whether the limit is kept.
    pub kept: bool,
}

impl Verdict {
    /// Holds a limit against the figures.
    pub fn new(limit: &Limit, figures: &Figures) -> Self {
        let reached = figures.of(limit.of.key);
        let kept = reached.is_some_and(|reached| match limit.of.side {
            Side::AtLeast => reached >= limit.value,
            Side::AtMost => reached <= limit.value,
        });
        Self { limit: limit.of.key, side: limit.of.side, demanded: limit.value, reached, kept }
    }
}

/// Gathers the figures of a run.
#[derive(Clone, Debug)]
pub struct Judge {
    last_orbit_from: u32,
    figures: Figures,
    modes: ModeJudge,
    valid: Share,
    attitude: AxesSums,
    filtered: AxesSums,
    bound: [Squares; 3],
    rate: RateSums,
    direction: [Squares; 2],
    direction_sigma: Squares,
    direction_within: Share,
    distance: [Squares; 2],
    distance_within: Share,
    position: AxesSums,
    last_position: AxesSums,
    last_velocity: AxesSums,
    nis: (u32, f64),
    before: Option<(Vector, Vector)>,
}

impl Judge {
    /// A judge of a run of `seconds` on an orbit of `period_s`.
    pub fn new(seconds: u32, period_s: f64) -> Self {
        let last = if period_s > 0.0 && 2.0 * period_s <= f64::from(seconds) {
            period_s as u32
        } else {
            seconds / 2
        };
        Self {
            last_orbit_from: seconds - last,
            figures: Figures::default(),
            modes: ModeJudge::default(),
            valid: Share::default(),
            attitude: AxesSums::default(),
            filtered: AxesSums::default(),
            bound: Default::default(),
            rate: RateSums::default(),
            direction: Default::default(),
            direction_sigma: Squares::default(),
            direction_within: Share::default(),
            distance: Default::default(),
            distance_within: Share::default(),
            position: AxesSums::default(),
            last_position: AxesSums::default(),
            last_velocity: AxesSums::default(),
            nis: (0, 0.0),
            before: None,
        }
    }

    /// Adds a second; gives whether its mode was right.
    pub fn add(&mut self, second: &Judged) -> bool {
        self.figures.seconds += 1;
        *self.figures.mode_seconds.entry(word(second.mode)).or_insert(0) += 1;
        if second.attitude_rad.is_some() {
            self.figures.first_attitude_s.get_or_insert(second.cycle + 1);
        }
        if !second.sun() {
            self.valid.add(second.attitude_rad.is_some());
            if let Some(attitude) = &second.attitude_rad {
                self.attitude.add(attitude);
            }
            if let Some(filtered) = &second.filtered_rad {
                self.filtered.add(filtered);
            }
        }
        if second.attitude_rad.is_none()
            && !second.sun()
            && !matches!(second.mode, Mode::SelfTest | Mode::Safe)
        {
            self.rate.add(second, &mut self.figures.rate);
        }
        if let Some(earth) = &second.earth {
            let [x, y] = earth.across_rad;
            self.direction[0].add(x);
            self.direction[1].add(y);
            self.direction_sigma.add(earth.sigma_rad);
            self.direction_within.add(x.abs().max(y.abs()) <= 3.0 * earth.sigma_rad);
            self.distance[0].add(earth.distance_km);
            self.distance[1].add(earth.sigma_km);
            self.distance_within.add(earth.distance_km.abs() <= 3.0 * earth.sigma_km);
        }
        self.add_orbit(second);
        self.modes.add(second)
    }

    /// Adds the Cramer-Rao bound of a second's attitude, rad.
    pub fn add_bound(&mut self, bound_rad: Vector) {
        for (sum, bound) in self.bound.iter_mut().zip(bound_rad) {
            sum.add(bound);
        }
    }

    fn add_orbit(&mut self, second: &Judged) {
        let Some(orbit) = &second.orbit else {
            self.before = None;
            return;
        };
        let figures = &mut self.figures.orbit;
        figures.first_s.get_or_insert(second.cycle + 1);
        figures.final_position_km = Some(orbit.position_km.length());
        if let Some(jump) = self.before.map(|before| jump_sigma(before, &orbit.position_km))
            && figures.position_jump_sigma.is_none_or(|largest| jump > largest)
        {
            figures.position_jump_sigma = Some(jump);
            figures.position_jump_at_s = Some(second.cycle);
        }
        self.before = Some((orbit.position_km.error, orbit.position_km.sigma));
        if let Some(nis) = orbit.nis {
            self.nis = (self.nis.0 + 1, self.nis.1 + nis);
        }
        if second.cycle >= self.last_orbit_from {
            self.last_position.add(&orbit.position_rac_km);
            self.last_velocity.add(&orbit.velocity_rac_km_s);
        }
        if orbit.settled {
            figures.settled_s.get_or_insert(second.cycle + 1);
        }
        figures.longest_without_fix_s = figures.longest_without_fix_s.max(orbit.since_fix_s);
        if second.state != SensorState::Full {
            let worst = orbit.position_km.worst_sigma();
            let largest = figures.outage_largest_sigma.unwrap_or(0.0);
            figures.outage_largest_sigma = Some(worst.max(largest));
        }
        self.position.add(&orbit.position_km);
    }

    /// What the run came to.
    pub fn finish(self) -> Figures {
        let rad_to_arcsec = arcsec(1.0);
        let mut figures = self.figures;
        figures.attitude_valid_share = self.valid.value();
        figures.within_3_sigma_share = self.attitude.within();
        figures.mode_share = self.modes.share();
        figures.faint_limb_s = self.modes.faint_s();
        figures.fast_s = self.modes.fast_s();
        figures.disagreements = self.modes.disagreements();
        let [x, y, z] = self.bound.map(|bound| bound.rms().map(|bound| bound * rad_to_arcsec));
        figures.attitude = AttitudeFigures {
            rms_arcsec: self.attitude.rms(rad_to_arcsec),
            sigma_arcsec: self.attitude.sigma(rad_to_arcsec),
            bound_arcsec: x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]),
            largest_sigma: self.attitude.largest_sigma(),
            thesis_arcsec: THESIS_ATTITUDE_ARCSEC,
        };
        figures.rate = RateFigures {
            share: self.rate.valid.value(),
            either_sense_share: self.rate.either.value(),
            error_percent: self.rate.size.value().map(|size| 100.0 * size),
            axis_deg: self.rate.axis.value(),
            within_3_sigma_share: self.rate.within.value(),
            ..figures.rate
        };
        figures.filtered = FilteredFigures {
            rms_arcsec: self.filtered.rms(rad_to_arcsec),
            sigma_arcsec: self.filtered.sigma(rad_to_arcsec),
            within_3_sigma_share: self.filtered.within(),
            normalised_square: self.filtered.normalised_square(),
        };
        let [x, y] = self.direction.map(|axis| axis.mean_square());
        figures.earth = EarthFigures {
            found_s: self.direction_within.seconds(),
            direction_rms_deg: x.zip(y).map(|(x, y)| libm::sqrt(0.5 * (x + y)).to_degrees()),
            direction_sigma_deg: self.direction_sigma.rms().map(f64::to_degrees),
            direction_within_3_sigma_share: self.direction_within.value(),
            distance_rms_km: self.distance[0].rms(),
            distance_sigma_km: self.distance[1].rms(),
            distance_within_3_sigma_share: self.distance_within.value(),
        };
        figures.orbit = OrbitFigures {
            last_orbit_rac_km: self.last_position.rms(1.0),
            last_orbit_position_km: self.last_position.length_rms(1.0),
            last_orbit_velocity_m_s: self.last_velocity.length_rms(1e3),
            position_within_3_sigma_share: self.position.within(),
            position_normalised_square: self.position.normalised_square(),
            position_largest_sigma: self.position.largest_sigma(),
            nis_mean: (self.nis.0 > 0).then(|| self.nis.1 / f64::from(self.nis.0)),
            thesis_geo_rac_km: THESIS_POSITION_KM,
            ..figures.orbit
        };
        figures
    }
}

/// Sums over the rates of a run.
#[derive(Clone, Debug, Default)]
struct RateSums {
    valid: Share,
    either: Share,
    size: Median,
    axis: Median,
    within: Share,
}

impl RateSums {
    /// Adds a second without an attitude.
    fn add(&mut self, second: &Judged, figures: &mut RateFigures) {
        self.valid.add(second.turning.is_some());
        let Some(turning) = &second.turning else { return };
        if !turning.either_sense {
            figures.first_s.get_or_insert(second.cycle + 1);
        }
        self.either.add(turning.either_sense);
        self.size.add(turning.size);
        self.axis.add(turning.axis_deg);
        self.within.add(turning.rad_s.worst_sigma() <= 3.0);
    }
}

/// Change of the position's error over the sigma it had before it, largest axis.
fn jump_sigma((error, sigma): (Vector, Vector), now: &Axes) -> f64 {
    (0..3).map(|axis| ((now.error[axis] - error[axis]) / sigma[axis]).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
#[path = "figures_tests.rs"]
mod tests;
