//! `sil-host navigate`: the flight code's orbit filter on a list of measurements.
//!
//! In: the initial guess, `{"t_s","r_km","v_km_s","sigma_r_km","sigma_v_km_s"}` and what the satellite flies
//! about ([`crate::formats::orbit_state`]); it may also hold `"gravity_noise_km_s15"` and
//! `"force_noise_km_s15"`, the flight parameters that stand for forces that are not modelled. Then a
//! measurement a line,
//! `{"t_s","u","range_km","sigma_rad","sigma_range_km"}`: `u` the unit vector from the body's centre to
//! the satellite along the ICRS axes with its error about each axis across, `range_km` the distance; either
//! may be null. A line without `u` is an outage: the orbit is propagated to it. Errors are taken for white:
//! nothing of a horizon is estimated.
//!
//! Out: a line a measurement, `{"t_s","status","r_km","v_km_s","sigma_r_km","sigma_v_km_s","nis",
//! "nis_freedom","bound_r_km","bound_v_km_s"}`, along the ICRS axes. `status` is `accepted`, `rejected`
//! (beyond the gate), `propagated` (nothing to take in), `lost` (too many were rejected: the orbit is
//! forgotten), `collecting` and `started` (of a first orbit out of positions), `unknown` (no orbit, and no
//! position) or `refused` (no position of a satellite). What is not known is null. The bounds are the least
//! sigmas that any filter can have by the measurements until then, along the orbit of the last line
//! (`bound`).
//!
//! `--observability` estimates nothing: it says what the measurements can tell of an orbit through the first
//! line's state (`observability`), a line a form of measurement without and with a misalignment of the paths,
//! `{"form","misalignment","states","rank","singular_values","unobservable","angles_observable"}`.
//!
//! A line that is no measurement, or earlier than the one before, costs a line on stderr and status 2 at the
//! end; the others are still answered.

mod bound;
mod observability;

use crate::bound::orbit::radial_along_cross;
use crate::cli::NavigateArguments;
use crate::error::{Faults, HostError};
use crate::formats::json;
use crate::formats::orbit_state::{StateInput, time_us};
use fsw_core::orbit::constants::MICROSECONDS;
use fsw_core::orbit::filter::{MAX_GAP_US, Nis, OrbitFilter, Update};
use fsw_core::orbit::forces::Dynamics;
use fsw_core::orbit::parameters::{Observation, OrbitParameters};
use fsw_core::orbit::point::PositionFix;
use nalgebra::{Matrix3, Matrix6, Vector3};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::ExitCode;

const FIRST: &str =
    "give {\"t_s\":..,\"r_km\":[x,y,z],\"v_km_s\":[x,y,z],\"sigma_r_km\":..,\"sigma_v_km_s\":..}";
const TO_DO: &str = "give {\"t_s\":..,\"u\":[x,y,z],\"range_km\":..,\"sigma_rad\":..,\"sigma_range_km\":..}";
/// How far from one the length of a unit vector may be.
const UNIT_TOLERANCE: f64 = 1e-3;
/// Distance at which a direction alone is noted as a fix, km: its rows are those of the predicted distance.
const NOTED_KM: f64 = 10_000.0;

/// The first line.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GuessInput {
    #[serde(flatten)]
    state: StateInput,
    sigma_r_km: f64,
    sigma_v_km_s: f64,
    #[serde(default)]
    gravity_noise_km_s15: Option<f32>,
    #[serde(default)]
    force_noise_km_s15: Option<f32>,
}

/// A measurement as given.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasurementInput {
    t_s: f64,
    #[serde(default)]
    u: Option<[f64; 3]>,
    #[serde(default)]
    range_km: Option<f64>,
    #[serde(default)]
    sigma_rad: Option<f64>,
    #[serde(default)]
    sigma_range_km: Option<f64>,
}

/// What was seen of the Earth.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// From the Earth's centre to the satellite.
    up: Vector3<f64>,
    /// Error about each axis across, rad.
    sigma_rad: f64,
    /// Distance and its sigma.
    range_km: Option<[f64; 2]>,
}

/// A measurement that is one; `None` seen in an outage.
#[derive(Clone, Copy, Debug)]
struct Measurement {
    time_us: i64,
    seen: Option<Seen>,
}

impl MeasurementInput {
    fn measurement(&self) -> Result<Measurement, String> {
        let time_us = time_us(self.t_s)?;
        let Some(up) = self.u.map(Vector3::from) else { return Ok(Measurement { time_us, seen: None }) };
        // Also refuses what is no number.
        let is_unit = (up.norm() - 1.0).abs() <= UNIT_TOLERANCE;
        if !is_unit {
            return Err("u is no unit vector".into());
        }
        let positive = |name: &str, value: Option<f64>, least: f64, most: f64| match value {
            Some(value) if (least..=most).contains(&value) => Ok(value),
            _ => Err(format!("{name} must be {least:e} to {most:e}")),
        };
        let sigma_rad = positive("sigma_rad", self.sigma_rad, 1e-9, 1.0)?;
        let range = |range_km| {
            Ok::<_, String>([
                positive("range_km", Some(range_km), 1.0, 1e6)?,
                positive("sigma_range_km", self.sigma_range_km, 1e-6, 1e6)?,
            ])
        };
        let range_km = self.range_km.map(range).transpose()?;
        Ok(Measurement { time_us, seen: Some(Seen { up: up.normalize(), sigma_rad, range_km }) })
    }
}

impl Seen {
    /// As a fix; a direction alone at [`NOTED_KM`].
    fn fix(&self) -> PositionFix {
        let [range_km, sigma_km] = self.range_km.unwrap_or([NOTED_KM, NOTED_KM * self.sigma_rad]);
        let along = self.up * self.up.transpose();
        let across_km = range_km * self.sigma_rad;
        PositionFix {
            position_km: self.up * range_km,
            covariance_km2: along * sigma_km.powi(2) + (Matrix3::identity() - along) * across_km.powi(2),
            shared_km2: Matrix3::zeros(),
            linearisation_km: self.up * range_km,
        }
    }
}

/// An answer.
#[derive(Clone, Debug, Serialize)]
struct Answer {
    /// TT, seconds since J2000.0.
    t_s: f64,
    status: &'static str,
    r_km: Option<[f64; 3]>,
    v_km_s: Option<[f64; 3]>,
    sigma_r_km: Option<[f32; 3]>,
    sigma_v_km_s: Option<[f32; 3]>,
    /// Normalised innovation squared.
    nis: Option<f32>,
    /// Its expectation.
    nis_freedom: Option<u8>,
    bound_r_km: Option<[f64; 3]>,
    bound_v_km_s: Option<[f64; 3]>,
}

/// The filter, and what it is to take of each measurement.
struct Navigator {
    filter: OrbitFilter,
    observation: Observation,
    parameters: OrbitParameters,
}

impl Navigator {
    /// One that begins with a guess.
    ///
    /// # Errors
    /// In words, where that cannot be.
    fn begun(guess: &GuessInput, observation: Observation, dynamics: Dynamics) -> Result<Self, String> {
        let flown = OrbitParameters::default().about(guess.state.body);
        let noise = |name: &str, given: Option<f32>, flown: f32| match given {
            Some(noise) if !(0.0..=1e-3).contains(&noise) => Err(format!("{name} must be 0 to 1e-3")),
            given => Ok(given.unwrap_or(flown)),
        };
        let parameters = OrbitParameters {
            observation,
            dynamics,
            gravity_noise_km_s15: noise(
                "gravity_noise_km_s15",
                guess.gravity_noise_km_s15,
                flown.gravity_noise_km_s15,
            )?,
            force_noise_km_s15: noise(
                "force_noise_km_s15",
                guess.force_noise_km_s15,
                flown.force_noise_km_s15,
            )?,
            height_sigma_km: 0.0,
            height_sigma_rad: 0.0,
            misalignment_sigma_rad: 0.0,
            ..flown
        };
        let mut filter = OrbitFilter::new();
        let state = guess.state.state()?;
        if filter.initialise(state, guess.sigma_r_km, guess.sigma_v_km_s, &parameters) {
            Ok(Self { filter, observation, parameters })
        } else {
            Err("no closed orbit above the ground, or a sigma that is none".into())
        }
    }

    /// Propagates to a time, however far it is.
    fn advance(&mut self, to_us: i64) {
        while let Some(state) = self.filter.state() {
            let next_us = to_us.min(state.time_us + MAX_GAP_US);
            // A reset leaves no state.
            if self.filter.advance(next_us, &self.parameters).is_err() || next_us == to_us {
                return;
            }
        }
    }

    /// Takes a measurement in; the status, and what its innovation came to.
    fn take(&mut self, measurement: &Measurement) -> (&'static str, Option<Nis>) {
        self.advance(measurement.time_us);
        let known = self.filter.state().is_some();
        let Some(seen) = &measurement.seen else {
            return (if known { "propagated" } else { "unknown" }, None);
        };
        if seen.range_km.is_none() && !known {
            return ("unknown", None);
        }
        self.parameters.observation =
            if seen.range_km.is_some() { self.observation } else { Observation::UnitVector };
        let fix = seen.fix();
        match self.filter.update(measurement.time_us, &fix, &Matrix3::identity(), &self.parameters) {
            Update::Accepted(nis) => ("accepted", Some(nis)),
            Update::Downweighted(nis) => ("downweighted", Some(nis)),
            Update::Diverged(nis) => ("lost", Some(nis)),
            Update::Started => ("started", None),
            Update::Collected | Update::Gathered => ("collecting", None),
            Update::Refused(_) => ("refused", None),
        }
    }

    fn answer(&mut self, measurement: &Measurement) -> Answer {
        let (status, nis) = self.take(measurement);
        let (state, covariance) = (self.filter.state(), self.filter.motion_covariance());
        Answer {
            t_s: measurement.time_us as f64 / MICROSECONDS,
            status,
            r_km: state.map(|state| state.position_km.into()),
            v_km_s: state.map(|state| state.velocity_km_s.into()),
            sigma_r_km: covariance.map(|covariance| covariance.position_sigma_km()),
            sigma_v_km_s: covariance.map(|covariance| covariance.velocity_sigma_km_s()),
            nis: nis.map(|nis| nis.square),
            nis_freedom: nis.map(|nis| nis.freedom),
            bound_r_km: None,
            bound_v_km_s: None,
        }
    }
}

/// The root of three diagonal elements of a covariance.
fn sigmas(covariance: &Matrix6<f64>, first: usize) -> [f64; 3] {
    [0, 1, 2].map(|axis| covariance[(first + axis, first + axis)].max(0.0).sqrt())
}

/// Prints what became of it all for people.
fn print_text(answers: &[Answer], filter: &OrbitFilter, bound: Option<&Matrix6<f64>>) {
    let count = |status: &str| answers.iter().filter(|answer| answer.status == status).count();
    let (sum, freedom) = answers.iter().fold((0.0, 0.0), |(sum, freedom), answer| {
        let nis = answer.nis.zip(answer.nis_freedom).filter(|_| answer.status == "accepted");
        let (square, of) = nis.map_or((0.0, 0.0), |(square, of)| (f64::from(square), f64::from(of)));
        (sum + square, freedom + of)
    });
    print_line!(
        "{} measurements: {} accepted, {} downweighted, {} without a direction",
        answers.len(),
        count("accepted"),
        count("downweighted"),
        count("propagated")
    );
    if freedom > 0.0 {
        print_line!(
            "Innovations squared over what is expected: {:.3} (1 where the filter is right)",
            sum / freedom
        );
    }
    let covariance = filter.motion_covariance().map(|covariance| covariance.position_km2());
    let Some((state, covariance)) = filter.state().zip(covariance) else {
        print_line!("No orbit is known at the end");
        return;
    };
    let ([x, y, z], [vx, vy, vz]): ([f64; 3], [f64; 3]) =
        (state.position_km.into(), state.velocity_km_s.into());
    print_line!("Last state: r {x:.3}, {y:.3}, {z:.3} km, v {vx:.6}, {vy:.6}, {vz:.6} km/s");
    let Some([radial, along, cross]) = radial_along_cross(state, &covariance) else { return };
    print_line!("Sigma radial, along, cross: {radial:.3}, {along:.3}, {cross:.3} km");
    let position = bound.map(|bound| bound.fixed_view::<3, 3>(0, 0).into_owned());
    match position.and_then(|position| radial_along_cross(state, &position)) {
        Some([radial, along, cross]) => {
            print_line!("Bound of these measurements: {radial:.3}, {along:.3}, {cross:.3} km")
        }
        None => print_line!("Bound of these measurements: they do not fix an orbit"),
    }
}

/// The measurement on one line, not earlier than `last_us`.
fn measurement(path: &Path, number: usize, text: &str, last_us: i64) -> Result<Measurement, HostError> {
    let input: MeasurementInput = json::read_line(path, number, text, TO_DO)?;
    let measurement =
        input.measurement().map_err(|what| HostError::input(path, Some(number), what, TO_DO))?;
    if measurement.time_us < last_us {
        let what = "earlier than the line before";
        return Err(HostError::input(path, Some(number), what, "give them in order of time"));
    }
    Ok(measurement)
}

/// Runs the command.
///
/// # Errors
/// What concerns all measurements: the file, its first line.
pub fn run(arguments: &NavigateArguments) -> Result<ExitCode, HostError> {
    let path = arguments.measurements.as_path();
    let mut lines = json::Lines::open(path, FIRST)?;
    let first = lines.next().unwrap_or_else(|| Err(HostError::input(path, None, "empty", FIRST)));
    let (number, line) = first?;
    let guess: GuessInput = json::read_line(path, number, &line, FIRST)?;
    let mut navigator = Navigator::begun(&guess, arguments.filter, arguments.dynamics)
        .map_err(|what| HostError::input(path, Some(number), what, FIRST))?;
    let mut faults = Faults::default();
    let mut measurements: Vec<Measurement> = Vec::new();
    let mut last_us = navigator.filter.state().map_or(0, |state| state.time_us);
    for line in lines {
        let measurement = line.and_then(|(number, text)| measurement(path, number, &text, last_us));
        let Some(measurement) = faults.noted(measurement) else { continue };
        last_us = measurement.time_us;
        measurements.push(measurement);
    }
    if arguments.observability {
        let seen = measurements.iter().filter(|measurement| measurement.seen.is_some());
        let times_us: Vec<i64> = seen.map(|measurement| measurement.time_us).collect();
        let first = navigator.filter.state();
        let table =
            first.and_then(|first| observability::table(first, &navigator.parameters.forces(), &times_us));
        let no_arc = || {
            let what = "no arc: fewer than three directions, or an orbit out of the bounds of the dynamics";
            HostError::input(path, None, what, TO_DO)
        };
        table.ok_or_else(no_arc)?.iter().for_each(|form| form.print(arguments.json));
        return Ok(faults.status());
    }
    let mut answers: Vec<Answer> =
        measurements.iter().map(|measurement| navigator.answer(measurement)).collect();
    let ranges = arguments.filter != Observation::UnitVector;
    let bounds = navigator.filter.state().map_or_else(Vec::new, |last| {
        bound::bounds(last, &navigator.parameters.forces(), &measurements, ranges)
    });
    for (answer, bound) in answers.iter_mut().zip(&bounds) {
        answer.bound_r_km = bound.as_ref().map(|bound| sigmas(bound, 0));
        answer.bound_v_km_s = bound.as_ref().map(|bound| sigmas(bound, 3));
    }
    if arguments.json {
        answers.iter().for_each(json::print_line);
    } else {
        print_text(&answers, &navigator.filter, bounds.last().and_then(Option::as_ref));
    }
    Ok(faults.status())
}
