//! Gathers a run's seconds into its figures.
//!
//! In: [`Judged`] seconds, one after the other. Every quantity's errors are kept until the end ([`Series`],
//! 80 bytes a second each).

use super::arcsec;
use super::chi_square::two_sided;
use super::expected::{ModeJudge, word};
use super::figures::{
    AttitudeFigures, EarthFigures, Figures, FilteredFigures, OrbitFigures, QuantityFigures, RateFigures,
    THESIS_ATTITUDE_ARCSEC, THESIS_POSITION_KM,
};
use super::foreseen::{Agreement, Foreseen};
use super::quantities::{NEXT_STATE, QUANTITIES};
use super::second::Judged;
use super::series::Series;
use super::sums::{Share, Sizes, Squares};
use crate::world::attitude::Vector;
use crate::world::vector::length;
use fsw_core::modes::Mode;

/// Gathers the figures of a run.
#[derive(Clone, Debug)]
pub struct Judge {
    last_orbit_from: u32,
    period_s: f64,
    figures: Figures,
    modes: ModeJudge,
    foreseen: Foreseen,
    valid: Share,
    /// Seconds without an attitude up to now.
    without: u32,
    /// The mode of the second before, and the latest seconds in which it was another than before.
    mode: Option<Mode>,
    changed: Vec<u32>,
    series: [Series; QUANTITIES.len()],
    bound: [Squares; 3],
    rate: RateSums,
    last_rac: [Squares; 3],
    last_bound: [Squares; 3],
    /// Degrees of freedom of all innovations, and the sum of their squares.
    nis: [f64; 2],
    /// Seconds in which the sensor told its state, and of these those in which it was right.
    state_told: Share,
    state_right: Share,
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
            period_s,
            figures: Figures::default(),
            modes: ModeJudge::default(),
            foreseen: Foreseen::default(),
            valid: Share::default(),
            without: 0,
            mode: None,
            changed: Vec::new(),
            series: QUANTITIES.each_ref().map(|quantity| Series::new(quantity.axes)),
            bound: Default::default(),
            rate: RateSums::default(),
            last_rac: Default::default(),
            last_bound: Default::default(),
            nis: [0.0; 2],
            state_told: Share::default(),
            state_right: Share::default(),
        }
    }

    /// Adds a second; gives whether its mode was right.
    pub fn add(&mut self, second: &Judged) -> bool {
        self.figures.seconds += 1;
        *self.figures.mode_seconds.entry(word(second.mode)).or_insert(0) += 1;
        for (quantity, series) in QUANTITIES.iter().zip(&mut self.series) {
            let Some(axes) = (quantity.of)(second) else { continue };
            match quantity.deviates.and_then(|of| of(second)) {
                Some(deviates) => series.add_correlated(second.cycle, axes, deviates),
                None => series.add(second.cycle, axes),
            }
        }
        self.add_availability(second);
        if second.attitude_rad.is_none()
            && !second.sun()
            && !matches!(second.mode, Mode::SelfTest | Mode::Safe | Mode::CommandedSafe)
        {
            self.rate.add(second, &mut self.figures.rate);
        }
        self.add_orbit(second);
        self.add_change(second);
        self.foreseen.add(second);
        self.state_told.add(second.told_state.is_some());
        if let Some(told) = second.told_state {
            self.state_right.add(told as u8 == second.state as u8);
        }
        self.modes.add(second)
    }

    /// Adds the Cramer-Rao bound of a second's attitude, rad.
    pub fn add_bound(&mut self, bound_rad: Vector) {
        for (sum, bound) in self.bound.iter_mut().zip(bound_rad) {
            sum.add(bound);
        }
    }

    /// Adds the bound of a second's position by the horizon, radial, along, cross, km; none where there is
    /// none yet.
    pub fn add_position_bound(&mut self, cycle: u32, bound_km: Option<Vector>) {
        let revolutions = |seconds: u32| (f64::from(seconds) / self.period_s).floor();
        if self.period_s > 0.0 && revolutions(cycle + 1) > revolutions(cycle) {
            self.figures.orbit.orbit_bounds_rac_km.push(bound_km);
        }
        if let Some(bound_km) = bound_km.filter(|_| cycle >= self.last_orbit_from) {
            for (sum, bound) in self.last_bound.iter_mut().zip(bound_km) {
                sum.add(bound);
            }
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

    /// A change by command is none of the sensor's own, nor is the end of the self-test that it asked for; those
    /// after it are counted anew.
    fn add_change(&mut self, second: &Judged) {
        let before = self.mode.replace(second.mode).filter(|before| *before != Mode::SelfTest);
        let changed = before.is_some_and(|before| before != second.mode);
        if second.commanded {
            self.changed.clear();
        } else if changed {
            self.changed.push(second.cycle);
        }
        self.changed.retain(|at| second.cycle < at + 10);
        let most = self.figures.mode_changes_10_s.get_or_insert(0);
        *most = (*most).max(self.changed.len() as u32);
    }

    fn add_orbit(&mut self, second: &Judged) {
        let Some(orbit) = &second.orbit else { return };
        let figures = &mut self.figures.orbit;
        figures.first_s.get_or_insert(second.cycle + 1);
        figures.final_position_km = Some(orbit.position_km.axes.length());
        if let Some([square, freedom]) = orbit.nis {
            self.figures.not_finite += u32::from(!square.is_finite());
            self.nis = [self.nis[0] + freedom, self.nis[1] + square];
        }
        if second.cycle >= self.last_orbit_from {
            for (sum, error) in self.last_rac.iter_mut().zip(orbit.position_km.axes.error) {
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
        let Agreement { share, time_s, length_s } = self.foreseen.finish();
        figures.next_state_share = share;
        figures.next_state_length_95_s = length_s.quantile(0.95);
        for (quantity, series) in QUANTITIES.iter().zip(&self.series).chain([(&NEXT_STATE, &time_s)]) {
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
        figures.state_told_share = self.state_told.value();
        figures.state_share = self.state_right.value();
        figures.faint_limb_s = self.modes.faint_s();
        figures.fast_s = self.modes.fast_s();
        figures.disagreements = self.modes.disagreements();
        figures.attitude = attitude(&figures, &self.bound);
        figures.rate = RateFigures {
            share: self.rate.valid.value(),
            either_sense_share: self.rate.either.value(),
            error_percent: self.rate.size.median().map(|size| 100.0 * size),
            axis_deg: self.rate.axis.median(),
            within_3_sigma_share: figures.run("rate").map(|of| of.all_within_3_share),
            ..figures.rate
        };
        let filtered = figures.run("filtered");
        figures.filtered = FilteredFigures {
            rms_arcsec: filtered.and_then(|of| three(&of.rms_axes)),
            bias_arcsec: filtered.and_then(|of| three(&of.bias_axes)),
            noise_arcsec: filtered.and_then(|of| three(&of.noise_axes)),
            sigma_arcsec: filtered.and_then(|of| three(&of.sigma_axes)),
            within_3_sigma_share: filtered.map(|of| of.all_within_3_share),
            normalised_square: filtered.map(|of| of.normalised_square),
        };
        figures.earth = earth(&figures);
        let position = figures.run("position");
        let [last_rac, last_bound] = [&self.last_rac, &self.last_bound]
            .map(|sums| three(&sums.iter().filter_map(Squares::rms).collect::<Vec<f64>>()));
        let jump = position.and_then(|of| of.jump_sigma);
        figures.orbit = OrbitFigures {
            last_orbit_rac_km: last_rac,
            last_orbit_bound_rac_km: last_bound,
            last_orbit_bound_km: last_bound.map(length),
            last_orbit_position_km: figures.last_orbit("position").map(|of| of.rms),
            last_orbit_velocity_m_s: figures.last_orbit("velocity").map(|of| of.rms),
            position_within_3_sigma_share: position.map(|of| of.all_within_3_share),
            position_normalised_square: position.map(|of| of.normalised_square),
            position_largest_sigma: position.map(|of| of.largest_sigma),
            outage_largest_sigma: figures.run("dark_position").map(|of| of.largest_sigma),
            position_jump_sigma: jump.map(|(sigma, _)| sigma),
            position_jump_at_s: jump.map(|(_, at)| at),
            nis_mean: (self.nis[0] > 0.0).then(|| self.nis[1] / self.nis[0]),
            // Innovations of a consistent filter are white.
            nis_consistency: (self.nis[0] > 0.0).then(|| two_sided(self.nis[1] / self.nis[0], self.nis[0])),
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
        bias_arcsec: of.and_then(|of| three(&of.bias_axes)),
        noise_arcsec: of.and_then(|of| three(&of.noise_axes)),
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
    size: Sizes,
    axis: Sizes,
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
mod tests;
