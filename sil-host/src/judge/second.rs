//! One second judged: the errors of attitude, Earth vector and orbit, each with the sigma reported for it.
//!
//! In: the [`Report`] of a second and the [`Truth`] of its instant. Out: [`Judged`]. The attitude of a search
//! that took several seconds is that of its image, so it is held against the truth of that second.

use super::attitude_error;
use crate::world::attitude::{Vector, apply, dot};
use crate::world::scene::{SensorState, Truth};
use crate::world::vector::{cross, minus};
use fsw_core::command::CommandOutcome;
use fsw_core::modes::Mode;
use fsw_core::shutting::ShutterParameters;
use fsw_core::telemetry::{NextState, OrbitReport, Outcome, RateReport, Report};
use fsw_hal::OpenPaths;

/// An error and the standard deviation reported for it, per axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// Estimate less truth.
    pub error: Vector,
    /// Reported standard deviation.
    pub sigma: Vector,
}

impl Axes {
    /// Largest error over its sigma.
    pub fn worst_sigma(&self) -> f64 {
        (0..3).map(|axis| (self.error[axis] / self.sigma[axis]).abs()).fold(0.0, f64::max)
    }

    /// Length of the error.
    pub fn length(&self) -> f64 {
        libm::sqrt(dot(self.error, self.error))
    }
}

/// An error whose axes are correlated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlated {
    /// Each axis by itself.
    pub axes: Axes,
    /// Reported correlations of the axes: first with second, first with third, second with third.
    pub correlation: Vector,
    /// `L⁻¹ error` of the reported covariance `L Lᵀ`: independent and of sigma 1 where the covariance is
    /// right.
    pub deviates: Vector,
}

impl Correlated {
    /// Normalised error squared, three degrees of freedom.
    pub fn nees(&self) -> f64 {
        dot(self.deviates, self.deviates)
    }
}

/// The Earth's direction and distance against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthError {
    /// The direction, rad: along x and y of the Earth path as nearly as they are across the true one. The
    /// third axis is that of the distance, and counts by itself.
    pub direction_rad: Correlated,
    /// Reported for the direction, the greater of the two across it, rad.
    pub sigma_rad: f64,
    /// Distance, km.
    pub distance_km: f64,
    /// Reported, km.
    pub sigma_km: f64,
}

/// The orbit against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitError {
    /// Position: radial, along, cross, km.
    pub position_km: Correlated,
    /// Velocity: radial, along, cross, km/s.
    pub velocity_km_s: Correlated,
    /// Limb height and its sigma, km.
    pub limb_height_km: [f64; 2],
    /// Normalised innovation squared of the second's observation, and its degrees of freedom.
    pub nis: Option<[f64; 2]>,
    /// Whether the filter says it has converged.
    pub settled: bool,
    /// Seconds since the last fix.
    pub since_fix_s: u32,
}

/// A rate that needed no attitude, against the truth. Where it is said to be either of two, the nearer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningError {
    /// Star path axes, rad/s.
    pub rad_s: Axes,
    /// Its size over the true one, less 1.
    pub size: f64,
    /// Between its axis and the true one, deg.
    pub axis_deg: f64,
    /// It may as well be the opposite one.
    pub either_sense: bool,
}

/// One second, judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
    /// Second of the run, from 0.
    pub cycle: u32,
    /// The sensor's mode.
    pub mode: Mode,
    /// Whether it did as it was commanded.
    pub commanded: bool,
    /// The geometry.
    pub state: SensorState,
    /// The Sun is in the Earth path, which has a shutter: stars can be seen.
    pub spared: bool,
    /// Lit limb in the field, deg of azimuth.
    pub lit_limb_deg: f64,
    /// Whether the Earth comes near the star path's field.
    pub earth_in_star_path: bool,
    /// True rate, all axes together, deg/s.
    pub rate_deg_s: f64,
    /// Attitude error, star path axes, rad.
    pub attitude_rad: Option<Axes>,
    /// Error of the filtered attitude, star path axes, rad.
    pub filtered_rad: Option<Axes>,
    /// Error of the rate, star path axes, rad/s.
    pub rate_rad_s: Option<Vector>,
    /// Error of a rate that needed no attitude.
    pub turning: Option<TurningError>,
    /// The Earth.
    pub earth: Option<EarthError>,
    /// The orbit.
    pub orbit: Option<OrbitError>,
    /// By what the Earth path is turned against the star path, Earth path axes, rad.
    pub mounting_rad: Option<Axes>,
    /// Whether attitude and orbit are known.
    pub locally_known: bool,
    /// The sensor's state as it tells it.
    pub told_state: Option<fsw_core::outages::SensorState>,
    /// The next change of state as it is foreseen.
    pub next_state: Option<NextState>,
    /// Stars recognised.
    pub stars: u16,
    /// Star-like spots.
    pub detections: u16,
    /// Limb points.
    pub limb_points: u16,
}

impl Judged {
    /// Holds `report` against the truth of its second; `image_truth` is that of the second whose image the
    /// attitude rests on ([`image_cycle`]).
    pub fn new(report: &Report, truth: &Truth, image_truth: &Truth) -> Self {
        let axes = |quaternion, sigma_rad: [f32; 3]| Axes {
            error: attitude_error(quaternion, image_truth.quaternion),
            sigma: sigma_rad.map(f64::from),
        };
        Self {
            cycle: report.cycle,
            mode: report.mode,
            commanded: report.command == Some(CommandOutcome::Done),
            state: truth.state,
            spared: false,
            lit_limb_deg: truth.lit_limb_deg,
            earth_in_star_path: truth.earth_in_star_path,
            rate_deg_s: libm::sqrt(dot(truth.rate_rad_s, truth.rate_rad_s)).to_degrees(),
            attitude_rad: report.attitude.map(|attitude| axes(attitude.quaternion, attitude.sigma_rad)),
            filtered_rad: report.filtered.map(|filtered| axes(filtered.quaternion, filtered.sigma_rad)),
            rate_rad_s: report.rate_rad_s.map(|rate| minus(rate.map(f64::from), truth.rate_rad_s)),
            turning: report.rate.map(|rate| turning_error(&rate, truth.rate_rad_s)),
            earth: report.earth.and_then(|earth| earth_error(&earth, truth)),
            orbit: report.orbit.map(|orbit| orbit_error(&orbit, truth)),
            mounting_rad: None,
            locally_known: report.local.is_some(),
            told_state: report.state,
            next_state: report.next_state,
            stars: report.stars.len() as u16,
            detections: report.detections,
            limb_points: report.limb_px.len() as u16,
        }
    }

    /// The same of an instrument with these shutters.
    pub fn with_shutters(self, shutters: Option<ShutterParameters>) -> Self {
        let fitted = shutters.is_some_and(|shutters| shutters.allow(OpenPaths::Star));
        Self { spared: fitted && self.state == SensorState::SunInEarthPath, ..self }
    }

    /// The same of paths that are turned by `misalignment_rad` against what the flight code is told.
    pub fn with_mounting(self, report: &Report, misalignment_rad: Vector) -> Self {
        let mounting_rad = report.orbit.map(|orbit| Axes {
            error: minus(orbit.misalignment_rad.map(f64::from), misalignment_rad),
            sigma: orbit.misalignment_sigma_rad.map(f64::from),
        });
        Self { mounting_rad, ..self }
    }

    /// Whether the Sun blinds the detector in this second, or would if the star path were not shut.
    pub fn sun(&self) -> bool {
        sun(self.state) && !self.spared
    }
}

/// Whether the Sun blinds the detector in a state.
pub fn sun(state: SensorState) -> bool {
    !matches!(state, SensorState::Full | SensorState::Eclipse)
}

/// Second in which the image was taken that gave a report's attitude: an identification may take several.
pub fn image_cycle(report: &Report) -> u32 {
    match (report.outcome, report.attitude) {
        (Some(Outcome::Identified), Some(attitude)) => report.cycle.saturating_sub(attitude.age_s.into()),
        _ => report.cycle,
    }
}

/// `a` scaled to unit length; `None` when it is (nearly) zero or no number.
fn unit(a: Vector) -> Option<Vector> {
    let length = libm::sqrt(dot(a, a));
    (length.is_finite() && length > 1e-9).then(|| a.map(|component| component / length))
}

/// Radial, along and cross unit vectors of a state, as rows.
pub fn orbit_axes(position: Vector, velocity: Vector) -> Option<[Vector; 3]> {
    let radial = unit(position)?;
    let normal = unit(cross(position, velocity))?;
    Some([radial, cross(normal, radial), normal])
}

fn turning_error(rate: &RateReport, truth: Vector) -> TurningError {
    let length = |vector: Vector| libm::sqrt(dot(vector, vector));
    let found = rate.rad_s.map(f64::from);
    let found = if rate.either_sense && dot(found, truth) < 0.0 { found.map(|part| -part) } else { found };
    TurningError {
        rad_s: Axes { error: minus(found, truth), sigma: rate.sigma_rad_s.map(f64::from) },
        size: length(found) / length(truth) - 1.0,
        axis_deg: libm::atan2(length(cross(found, truth)), dot(found, truth)).to_degrees(),
        either_sense: rate.either_sense,
    }
}

fn earth_error(earth: &fsw_core::telemetry::EarthReport, truth: &Truth) -> Option<EarthError> {
    let distance_km = libm::sqrt(dot(truth.position_km, truth.position_km));
    let centre = unit(apply(&truth.earth_path, truth.position_km.map(|component| -component)))?;
    let seen = unit(earth.direction.map(f64::from))?;
    // Axes across the true direction: y turned the least, x to complete them.
    let x = unit(cross([0.0, 1.0, 0.0], centre)).or_else(|| unit(cross([1.0, 0.0, 0.0], centre)))?;
    let y = cross(centre, x);
    let square_km2 = f64::from(earth.distance_km).powi(2);
    let [xx, yx, yy, zx, zy, zz] = earth.covariance_km2.map(|element| f64::from(element) / square_km2);
    let covariance_rad2 = [[xx, yx, zx], [yx, yy, zy], [zx, zy, zz]];
    Some(EarthError {
        direction_rad: turned(&[x, y, centre], minus(seen, centre), covariance_rad2),
        sigma_rad: earth.sigma_rad.into(),
        distance_km: f64::from(earth.distance_km) - distance_km,
        sigma_km: earth.sigma_km.into(),
    })
}

/// Reported covariance of position and velocity, ICRS axes: km², km²/s, km²/s².
pub fn motion_covariance(orbit: &OrbitReport) -> [[f64; 6]; 6] {
    let ([x, y, z], [vx, vy, vz]) = (orbit.sigma_position_km, orbit.sigma_velocity_km_s);
    let sigma = [x, y, z, vx, vy, vz].map(f64::from);
    let mut covariance = [[0.0; 6]; 6];
    let mut correlations = orbit.correlations.iter();
    for row in 0..6 {
        covariance[row][row] = sigma[row] * sigma[row];
        for column in 0..row {
            let correlation = correlations.next().map_or(0.0, |correlation| f64::from(*correlation));
            let element = correlation * sigma[row] * sigma[column];
            (covariance[row][column], covariance[column][row]) = (element, element);
        }
    }
    covariance
}

/// Correlations are reported in single precision: less of a variance cannot be told from nothing.
const LEAST_SHARE: f64 = 1e-6;

/// An error and its covariance in other axes, the rows of `axes`.
fn turned(axes: &[Vector; 3], error: Vector, covariance: [Vector; 3]) -> Correlated {
    let error = apply(axes, error);
    let half = axes.map(|axis| apply(&covariance, axis));
    let turned = |row: usize, column: usize| dot(axes[row], half[column]);
    let variance = [turned(0, 0), turned(1, 1), turned(2, 2)];
    let pivot = |axis: usize, left: f64| libm::sqrt(left.max(LEAST_SHARE * variance[axis]));
    // Cholesky's factor, row by row, and the forward substitution.
    let l00 = pivot(0, variance[0]);
    let (l10, l20) = (turned(1, 0) / l00, turned(2, 0) / l00);
    let l11 = pivot(1, variance[1] - l10 * l10);
    let l21 = (turned(2, 1) - l20 * l10) / l11;
    let l22 = pivot(2, variance[2] - l20 * l20 - l21 * l21);
    let first = error[0] / l00;
    let second = (error[1] - l10 * first) / l11;
    let third = (error[2] - l20 * first - l21 * second) / l22;
    let sigma = variance.map(libm::sqrt);
    let correlation = |row: usize, column: usize| turned(row, column) / (sigma[row] * sigma[column]);
    Correlated {
        axes: Axes { error, sigma },
        correlation: [correlation(1, 0), correlation(2, 0), correlation(2, 1)],
        deviates: [first, second, third],
    }
}

fn orbit_error(orbit: &OrbitReport, truth: &Truth) -> OrbitError {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axes = orbit_axes(truth.position_km, truth.velocity_km_s).unwrap_or(identity);
    let covariance = motion_covariance(orbit);
    let block =
        |first: usize| [0, 1, 2].map(|row| [0, 1, 2].map(|column| covariance[first + row][first + column]));
    OrbitError {
        position_km: turned(&axes, minus(orbit.position_km, truth.position_km), block(0)),
        velocity_km_s: turned(&axes, minus(orbit.velocity_km_s, truth.velocity_km_s), block(3)),
        limb_height_km: [orbit.limb_height_km.into(), orbit.limb_height_sigma_km.into()],
        nis: orbit.nis.map(|nis| [nis.into(), orbit.nis_freedom.into()]),
        settled: orbit.settled,
        since_fix_s: orbit.since_fix_s,
    }
}

#[cfg(test)]
mod tests;
