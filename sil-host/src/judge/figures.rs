//! What a run comes to: the figures of `summary.json`, and the limits kept or not.
//!
//! In: [`Judged`] seconds, one after the other. Every quantity's errors are kept until the end
//! ([`Series`](super::series::Series), 50 bytes a second each) and judged over the run and over its last orbit: the last
//! revolution, or the second half of a run shorter than two.

use super::arcsec;
use super::chi_square::two_sided;
use super::expected::{Disagreement, ModeJudge, word};
use super::quantities::QUANTITIES;
use super::second::Judged;
use super::series::{Series, Statistics};
use super::sums::{Median, Share, Squares};
use super::table;
use super::table::Side;
use crate::scenario::Limit;
use crate::world::attitude::Vector;
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
    /// Probability of such a mean or one farther from 3, if noise and sigmas agree.
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
    /// Longest time from a change of the geometry to the mode that it asks for.
    pub mode_latest_s: Option<u32>,
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
    /// Every quantity that was estimated ([`QUANTITIES`]).
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
        let reached = (limit.of.of)(figures);
        let kept = reached.is_some_and(|reached| match limit.of.side {
            Side::AtLeast => reached >= limit.value,
            Side::AtMost => reached <= limit.value,
        });
        Self { limit: limit.of.key, side: limit.of.side, demanded: limit.value, reached, kept }
    }

    /// Holds a scenario's limits against the figures; that every number be finite is demanded of every run.
    pub fn all(limits: &[Limit], figures: &Figures) -> Vec<Self> {
        let demanded = Limit { of: &table::NOT_FINITE, value: 0.0 };
        let limited = !limits.is_empty() || figures.not_finite > 0;
        let own = limited.then_some(demanded);
        limits.iter().chain(&own).map(|limit| Self::new(limit, figures)).collect()
    }
}

/// Gathers the figures of a run.
#[derive(Clone, Debug)]
pub struct Judge {
    last_orbit_from: u32,
    figures: Figures,
    modes: ModeJudge,
    valid: Share,
    /// Seconds without an attitude up to now.
    without: u32,
    series: [Series; QUANTITIES.len()],
    bound: [Squares; 3],
    rate: RateSums,
    last_rac: [Squares; 3],
    nis: (u32, f64),
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
            without: 0,
            series: QUANTITIES.each_ref().map(|quantity| Series::new(quantity.axes)),
            bound: Default::default(),
            rate: RateSums::default(),
            last_rac: Default::default(),
            nis: (0, 0.0),
        }
    }

    /// Adds a second; gives whether its mode was right.
    pub fn add(&mut self, second: &Judged) -> bool {
        self.figures.seconds += 1;
        *self.figures.mode_seconds.entry(word(second.mode)).or_insert(0) += 1;
        for (quantity, series) in QUANTITIES.iter().zip(&mut self.series) {
            if let Some(axes) = (quantity.of)(second) {
                series.add(second.cycle, axes);
            }
        }
        self.add_availability(second);
        if second.attitude_rad.is_none()
            && !second.sun()
            && !matches!(second.mode, Mode::SelfTest | Mode::Safe)
        {
            self.rate.add(second, &mut self.figures.rate);
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

    fn add_availability(&mut self, second: &Judged) {
        let known = second.attitude_rad.is_some();
        if known {
            self.figures.first_attitude_s.get_or_insert(second.cycle + 1);
        }
        self.without = if known || second.sun() { 0 } else { self.without + 1 };
        if self.figures.first_attitude_s.is_some() {
            let longest = self.figures.recovery_s.unwrap_or(0);
            self.figures.recovery_s = Some(longest.max(self.without));
        }
        if !second.sun() {
            self.valid.add(known);
        }
    }

    fn add_orbit(&mut self, second: &Judged) {
        let Some(orbit) = &second.orbit else { return };
        let figures = &mut self.figures.orbit;
        figures.first_s.get_or_insert(second.cycle + 1);
        figures.final_position_km = Some(orbit.position_km.length());
        if let Some(nis) = orbit.nis {
            self.figures.not_finite += u32::from(!nis.is_finite());
            self.nis = (self.nis.0 + 1, self.nis.1 + nis);
        }
        if second.cycle >= self.last_orbit_from {
            for (sum, error) in self.last_rac.iter_mut().zip(orbit.position_rac_km.error) {
                sum.add(error);
            }
        }
        if orbit.settled {
            figures.settled_s.get_or_insert(second.cycle + 1);
        }
        figures.longest_without_fix_s = figures.longest_without_fix_s.max(orbit.since_fix_s);
    }

    /// What the run came to.
    pub fn finish(self) -> Figures {
        let mut figures = self.figures;
        for (quantity, series) in QUANTITIES.iter().zip(&self.series) {
            figures.not_finite += series.not_finite();
            let [run, last_orbit] =
                [0, self.last_orbit_from].map(|first| series.statistics(first, quantity.scale));
            let of = QuantityFigures { unit: quantity.unit, run, last_orbit };
            figures.quantities.insert(quantity.key, of);
        }
        figures.attitude_valid_share = self.valid.value();
        figures.within_3_sigma_share = figures.run("attitude").map(|of| of.all_within_3_share);
        figures.mode_share = self.modes.share();
        figures.mode_latest_s = self.modes.latest_s();
        figures.faint_limb_s = self.modes.faint_s();
        figures.fast_s = self.modes.fast_s();
        figures.disagreements = self.modes.disagreements();
        figures.attitude = attitude(&figures, &self.bound);
        figures.rate = RateFigures {
            share: self.rate.valid.value(),
            either_sense_share: self.rate.either.value(),
            error_percent: self.rate.size.value().map(|size| 100.0 * size),
            axis_deg: self.rate.axis.value(),
            within_3_sigma_share: figures.run("rate").map(|of| of.all_within_3_share),
            ..figures.rate
        };
        let filtered = figures.run("filtered");
        figures.filtered = FilteredFigures {
            rms_arcsec: filtered.and_then(|of| three(&of.rms_axes)),
            sigma_arcsec: filtered.and_then(|of| three(&of.sigma_axes)),
            within_3_sigma_share: filtered.map(|of| of.all_within_3_share),
            normalised_square: filtered.map(|of| of.normalised_square),
        };
        figures.earth = earth(&figures);
        let (position, jump) =
            (figures.run("position"), figures.run("position").and_then(|of| of.jump_sigma));
        figures.orbit = OrbitFigures {
            last_orbit_rac_km: three(&self.last_rac.iter().filter_map(Squares::rms).collect::<Vec<f64>>()),
            last_orbit_position_km: figures.last_orbit("position").map(|of| of.rms),
            last_orbit_velocity_m_s: figures.last_orbit("velocity").map(|of| of.rms),
            position_within_3_sigma_share: position.map(|of| of.all_within_3_share),
            position_normalised_square: position.map(|of| of.normalised_square),
            position_largest_sigma: position.map(|of| of.largest_sigma),
            outage_largest_sigma: figures.run("dark_position").map(|of| of.largest_sigma),
            position_jump_sigma: jump.map(|(sigma, _)| sigma),
            position_jump_at_s: jump.map(|(_, at)| at),
            nis_mean: (self.nis.0 > 0).then(|| self.nis.1 / f64::from(self.nis.0)),
            // Innovations of a consistent filter are white: three degrees of freedom each.
            nis_consistency: (self.nis.0 > 0).then(|| {
                let freedom = 3.0 * f64::from(self.nis.0);
                two_sided(self.nis.1 / freedom, freedom)
            }),
            thesis_geo_rac_km: THESIS_POSITION_KM,
            ..figures.orbit
        };
        figures
    }
}

fn three(values: &[f64]) -> Option<[f64; 3]> {
    values.try_into().ok()
}

fn attitude(figures: &Figures, bound: &[Squares; 3]) -> AttitudeFigures {
    let of = figures.run("attitude");
    let bound: Vec<f64> = bound.iter().filter_map(Squares::rms).map(arcsec).collect();
    AttitudeFigures {
        rms_arcsec: of.and_then(|of| three(&of.rms_axes)),
        sigma_arcsec: of.and_then(|of| three(&of.sigma_axes)),
        bound_arcsec: three(&bound),
        largest_sigma: of.map(|of| of.largest_sigma),
        thesis_arcsec: THESIS_ATTITUDE_ARCSEC,
    }
}

fn earth(figures: &Figures) -> EarthFigures {
    let (direction, distance) = (figures.run("earth_direction"), figures.run("earth_distance"));
    EarthFigures {
        found_s: direction.map_or(0, |of| of.seconds),
        direction_rms_deg: direction.map(|of| of.rms / std::f64::consts::SQRT_2),
        direction_sigma_deg: direction.map(|of| of.sigma / std::f64::consts::SQRT_2),
        direction_within_3_sigma_share: direction.map(|of| of.all_within_3_share),
        distance_rms_km: distance.map(|of| of.rms),
        distance_sigma_km: distance.map(|of| of.sigma),
        distance_within_3_sigma_share: distance.map(|of| of.all_within_3_share),
    }
}

/// Sums over the rates of a run.
#[derive(Clone, Debug, Default)]
struct RateSums {
    valid: Share,
    either: Share,
    size: Median,
    axis: Median,
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
    }
}

#[cfg(test)]
#[path = "figures_tests.rs"]
mod tests;
