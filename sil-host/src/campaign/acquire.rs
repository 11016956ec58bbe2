//! `sil-host campaign acquire`: the whole sensor, lost in space, in random directions of the sky.
//!
//! In: a number of runs, a seed. Out: how many found their attitude in the first, second and third cycle, how
//! many a wrong one, and how good it was. A run is a satellite in GEO (`acquire.toml`) with the Earth's disc
//! in the middle of the detector, ten false stars, hot pixels and proton hits. Its star path looks in a
//! direction and with a roll that are evenly spread over all; its place on the orbit, and so the Earth's
//! phase, is drawn as well; the clouds are the same for all. The sensor is switched on, tests itself and
//! acquires. Directions in which the Earth or the Sun stand in the star path are drawn anew.
//!
//! Ends with status 1 when an attitude was wrong, or less than [`GOAL_PERCENT`] were found.

use super::spread::{Spread, share_interval_percent};
use super::{Experiment, again};
use crate::cli::CampaignAcquireArguments;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::flight::{self, StarCalibration};
use crate::formats::json;
use crate::harness::{Flight, truth_of};
use crate::judge::arcsec;
use crate::scenario::Scenario;
use crate::world::attitude::{apply, matrix, rotation};
use crate::world::motion::pointing::Mount;
use crate::world::noise::{Noise, Stream};
use crate::world::scene::{Scene, SensorState};
use fsw_core::catalog::Catalogue;
use fsw_core::sensor::Workspace;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::ExitCode;

/// Cycles after the self-test within which an attitude is asked for.
pub const CYCLES: u32 = 3;
/// Runs of a hundred that must have one by then.
pub const GOAL_PERCENT: f64 = 99.9;
/// An error of a sight line beyond this, about x or y, is another part of the sky, arcsec.
const WRONG_ARCSEC: f64 = 300.0;
/// Directions drawn before it is given up: of a hundred, four or five are hidden.
const DRAWS: u32 = 50;

const TEXT: &str = include_str!("acquire.toml");

/// What came of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
    /// Direction of the star path: right ascension, declination, deg.
    pub sight_deg: [f64; 2],
    /// Cycles after the self-test until the first attitude; none within [`CYCLES`].
    pub cycles: Option<u32>,
    /// Error of that attitude about x, y, z of the star path, arcsec.
    pub error_arcsec: Option<[f64; 3]>,
    /// Its sigmas.
    pub sigma_arcsec: Option<[f64; 3]>,
    /// Stars identified.
    pub stars: u16,
}

impl Run {
    fn wrong(&self) -> bool {
        self.error_arcsec.is_some_and(|[x, y, _]| x.abs().max(y.abs()) > WRONG_ARCSEC)
    }
}

/// The satellite of a run, `None` where something stands in its star path.
fn satellite(
    base: &Scenario,
    seed: u64,
    run: u64,
    draw: u32,
) -> Result<Option<(Scenario, Scene)>, HostError> {
    let noise = Noise::new(seed, run, Stream::Attitude);
    let uniform = |slot| noise.uniform(draw, slot);
    // The middle angle of three is not even: its sine is.
    let star_path_deg =
        [360.0 * uniform(0), libm::asin(2.0 * uniform(1) - 1.0).to_degrees(), 360.0 * uniform(2)];
    let along = rotation(2, -std::f64::consts::TAU * uniform(3));
    let scenario = Scenario {
        seed: seed.wrapping_mul(1_000_003).wrapping_add(run),
        mount: Mount { star_path_deg },
        position_km: apply(&along, base.position_km),
        velocity_km_s: apply(&along, base.velocity_km_s),
        ..base.clone()
    };
    let scene = scenario.scene_above(seed)?;
    let truth = truth_of(&scene, 0)?;
    let free = truth.state == SensorState::Full && !truth.earth_in_star_path;
    Ok(free.then_some((scenario, scene)))
}

/// Flies a run.
fn fly(
    base: &Scenario,
    (catalogue, calibration): (Catalogue<'static>, Option<&StarCalibration>),
    seed: u64,
    run: u64,
    workspace: &mut Workspace,
) -> Result<Run, HostError> {
    let free = (0..DRAWS).find_map(|draw| satellite(base, seed, run, draw).transpose());
    let (scenario, mut scene) = free.unwrap_or_else(|| {
        Err(HostError::usage(format!("run {run} finds no free direction"), "report this"))
    })?;
    let mut flown = Run {
        seed,
        run,
        sight_deg: sight_deg(&truth_of(&scene, 0)?.quaternion).map(thousandths),
        cycles: None,
        error_arcsec: None,
        sigma_arcsec: None,
        stars: 0,
    };
    let mut flight = Flight::new(&scenario, &mut scene, catalogue, calibration, workspace)?;
    // The self-test has the first second.
    for cycle in 0..=CYCLES {
        flight.second(|second| {
            if let Some(attitude) = second.judged.attitude_rad {
                flown.cycles = Some(cycle);
                flown.error_arcsec = Some(attitude.error.map(arcsec).map(thousandths));
                flown.sigma_arcsec = Some(attitude.sigma.map(arcsec).map(thousandths));
                flown.stars = second.judged.stars;
            }
            Ok(())
        })?;
        if flown.cycles.is_some() {
            break;
        }
    }
    Ok(flown)
}

/// Rounded, so that a file holds it as it is.
fn thousandths(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// Right ascension and declination of a star path's line of sight.
fn sight_deg(quaternion: &[f64; 4]) -> [f64; 2] {
    let [x, y, z] = matrix(*quaternion)[2];
    [libm::atan2(y, x).to_degrees().rem_euclid(360.0), libm::asin(z.clamp(-1.0, 1.0)).to_degrees()]
}

/// What a campaign came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Runs flown.
    pub runs: u64,
    /// Of these, with an attitude in the first, second, third cycle.
    pub by_cycle: [u64; CYCLES as usize],
    /// With one from any of these, %.
    pub found_percent: f64,
    /// Its 95 % confidence interval, %.
    pub found_interval_percent: [f64; 2],
    /// With an attitude of another part of the sky.
    pub wrong: u64,
    /// Root mean square errors about x, y, z, arcsec.
    pub rms_arcsec: [f64; 3],
    /// Size of the error across the line of sight over the runs, arcsec.
    pub across_arcsec: Option<Spread>,
    /// Attitudes with every axis within three sigma, %.
    pub within_3_sigma_percent: f64,
    /// The runs without an attitude: number, right ascension and declination, deg.
    pub without: Vec<(u64, [f64; 2])>,
    /// The worst run: one without an attitude, or that with the largest error across.
    pub worst_run: u64,
    /// Whether the goal is kept.
    pub kept: bool,
}

impl Figures {
    /// Of runs in the order of their numbers.
    pub fn of(runs: &[Run]) -> Self {
        let mut figures = Self { runs: runs.len() as u64, ..Self::default() };
        let (mut found, mut within, mut squares) = (0_u64, 0_u64, [0.0; 3]);
        let mut across: Vec<(f64, u64)> = Vec::new();
        for run in runs {
            figures.wrong += u64::from(run.wrong());
            let (Some(cycles), Some(error), Some(sigma)) = (run.cycles, run.error_arcsec, run.sigma_arcsec)
            else {
                figures.without.push((run.run, run.sight_deg));
                continue;
            };
            found += 1;
            across.push((libm::hypot(error[0], error[1]), run.run));
            if let Some(count) = figures.by_cycle.get_mut(cycles.saturating_sub(1) as usize) {
                *count += 1;
            }
            within += u64::from(error.iter().zip(sigma).all(|(error, sigma)| error.abs() <= 3.0 * sigma));
            for (square, error) in squares.iter_mut().zip(error) {
                *square += error * error;
            }
        }
        let percent = |part: u64, of: u64| 100.0 * part as f64 / of.max(1) as f64;
        across.sort_by(|one, other| one.0.total_cmp(&other.0));
        let without = figures.without.first().map(|(run, _)| *run);
        figures.worst_run = without.or(across.last().map(|(_, run)| *run)).unwrap_or_default();
        figures.across_arcsec = Spread::of(&across.iter().map(|(error, _)| *error).collect::<Vec<f64>>());
        figures.found_percent = percent(found, figures.runs);
        figures.found_interval_percent = share_interval_percent(found, figures.runs);
        figures.within_3_sigma_percent = percent(within, found);
        figures.rms_arcsec = squares.map(|sum: f64| (sum / found.max(1) as f64).sqrt());
        figures.kept = figures.wrong == 0 && figures.found_percent >= GOAL_PERCENT;
        figures
    }

    fn text(&self, seed: u64) -> String {
        let [first, second, third] = self.by_cycle;
        let [low, high] = self.found_interval_percent;
        let [x, y, z] = self.rms_arcsec;
        let mut lines = vec![
            "Lost in space from full frames: GEO, the Earth in the middle, 10 false stars, 200 hot pixels, 20 hits a frame"
                .to_string(),
            format!("runs                     {}", self.runs),
            format!(
                "attitude within 3 cycles {:.2} %, {low:.2} to {high:.2} with 95 % confidence  ({first} in the first, {second} the second, {third} the third; goal {GOAL_PERCENT} %)",
                self.found_percent
            ),
            format!("wrong                    {}  (goal 0)", self.wrong),
            format!("error about x, y, z, rms {x:.2}, {y:.2}, {z:.1} arcsec"),
            self.across_arcsec.as_ref().map_or(String::new(), |across| {
                let [low, high] = across.median_interval.map(|end| end.map_or("?".to_owned(), |end| format!("{end:.2}")));
                format!(
                    "error across the sight   median {:.2} ({low} to {high}), 95 % within {:.2} arcsec",
                    across.median, across.kept_by_95_percent
                )
            }),
            format!("within 3 sigma           {:.2} %", self.within_3_sigma_percent),
        ];
        lines.extend(self.without.iter().map(|(run, [ra, dec])| {
            format!("without an attitude      run {run}, right ascension {ra:.1}, declination {dec:.1} deg")
        }));
        lines.push(again("acquire", seed, self.worst_run));
        lines.push(if self.kept { "kept" } else { "MISSED" }.to_string());
        lines.join("\n")
    }
}

/// Directions of a campaign.
struct Directions<'a> {
    arguments: &'a CampaignAcquireArguments,
    base: Scenario,
    catalogue: Catalogue<'static>,
    calibration: Option<StarCalibration>,
}

impl Experiment for Directions<'_> {
    type Key = u64;
    type Run = Run;
    type Workspace = Box<Workspace>;

    fn name(&self) -> &str {
        "acquire"
    }

    fn keys(&self) -> Vec<u64> {
        self.arguments.common.numbers(self.arguments.runs).collect()
    }

    fn key_of(&self, run: &Run) -> Option<u64> {
        (run.seed == self.arguments.common.seed).then_some(run.run)
    }

    fn workspace(&self) -> Box<Workspace> {
        Box::new(Workspace::new())
    }

    fn fly(&self, workspace: &mut Box<Workspace>, run: &u64) -> Result<Run, HostError> {
        let instrument = (self.catalogue, self.calibration.as_ref());
        fly(&self.base, instrument, self.arguments.common.seed, *run, workspace)
    }
}

/// All runs in order.
///
/// # Errors
/// When the file cannot be used.
pub fn runs(arguments: &CampaignAcquireArguments) -> Result<Vec<Run>, HostError> {
    let base = Scenario::parse(Path::new("the satellite of the campaign"), TEXT)?;
    let camera = flight::camera(&base.camera, &base.file)?;
    let catalogue = flight::flight_catalogue(&camera, &base.file)?;
    let calibration = base.calibration()?;
    super::runs(&Directions { arguments, base, catalogue, calibration }, &arguments.common)
}

/// Runs the command.
///
/// # Errors
/// When the file of runs cannot be used.
pub fn run(arguments: &CampaignAcquireArguments) -> Result<ExitCode, HostError> {
    let figures = Figures::of(&runs(arguments)?);
    if arguments.common.json {
        json::print_line(&figures);
    } else {
        print_line!("{}", figures.text(arguments.common.seed));
    }
    Ok(if figures.kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

#[cfg(test)]
mod tests;
