//! `sil-host campaign earth`: the Earth in single frames, from a low orbit to the geostationary one.
//!
//! In: a number of frames a case, a seed. Out: for every case and way of looking a row: how often the centre
//! was found, how wrong it was, and how far its covariance can be believed; then what the centre does at
//! noon. Every frame is drawn by the world with clouds, an uneven horizon, hot pixels and protons, on a day
//! and from a place of its own; eight share an Earth.
//!
//! | module | what it is |
//! |---|---|
//! | [`cases`] | the kinds of views |
//! | [`seen`] | the ways of looking, and their errors |
//! | [`limit`] | what the best of all methods could reach |
//! | [`rows`] | the table |
//!
//! Ends with status 1 when a row with a goal misses it; a goal beyond what is possible is replaced by what is
//! nearly possible.

pub mod cases;
pub mod limit;
pub mod rows;
pub mod seen;

use super::{Experiment, again};
use crate::cli::CampaignEarthArguments;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::json;
use crate::scenario::Scenario;
use crate::world::earth::heights::Heights;
use crate::world::noise::{Noise, Stream};
use cases::CASES;
use rows::Table;
use seen::{Frame, Seen, Way};
use serde::{Deserialize, Serialize};
use std::process::ExitCode;

/// A frame, looked at in every way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
    /// Name of the case.
    pub case: String,
    /// Name of the family of horizon heights.
    pub horizon: String,
    /// Name of the law by which surfaces are bright.
    pub surface: String,
    /// Angle between Sun and satellite seen from the Earth, deg.
    pub phase_deg: f64,
    /// Lit limb on the detector, deg of azimuth about the centre.
    pub lit_limb_deg: f64,
    /// Least sigma of the direction towards the Sun and across that any unbiased method could have, deg.
    pub limit_deg: Option<[f64; 2]>,
    /// What was seen.
    pub seen: Vec<Seen>,
}

/// Draws a frame and looks at it.
fn fly(base: &Scenario, heights: &Heights, seed: u64, run: u64, number: usize) -> Result<Run, HostError> {
    let case = &CASES[number];
    let drawn = cases::draw(base, number, case, seed, run)?;
    let (phase_deg, lit_limb_deg) = (drawn.phase_deg, drawn.truth.lit_limb_deg);
    let noise = Noise::new(seed, run, Stream::Centroid).part(number as u64);
    let mut frame = Frame::new(drawn, case, &noise)?;
    let (limit_deg, seen) = (frame.limit_deg(heights), frame.look(&noise)?);
    let (horizon, surface) = (base.earth.horizon.name().to_owned(), base.earth.surface.name().to_owned());
    let rounded =
        Run { seed, run, case: case.name.into(), horizon, surface, phase_deg, lit_limb_deg, limit_deg, seen };
    // As a file holds it: rounded to what a line says.
    Ok(rounded.rounded())
}

impl Run {
    fn rounded(mut self) -> Self {
        (self.phase_deg, self.lit_limb_deg) = (millionths(self.phase_deg), millionths(self.lit_limb_deg));
        self.limit_deg = self.limit_deg.map(|limit| limit.map(millionths));
        for fix in self.seen.iter_mut().filter_map(|seen| seen.fix.as_mut()) {
            fix.map(millionths);
        }
        self
    }
}

/// Rounded, so that a file holds it as it is.
fn millionths(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

/// Frames of a campaign.
struct Frames<'a> {
    arguments: &'a CampaignEarthArguments,
    base: Scenario,
    heights: Heights,
}

impl Experiment for Frames<'_> {
    /// Case and run.
    type Key = (usize, u64);
    type Run = Run;
    type Workspace = ();

    fn name(&self) -> &str {
        "earth"
    }

    fn keys(&self) -> Vec<Self::Key> {
        // Run by run, so that neighbours share an Earth.
        let numbers = self.arguments.common.numbers(self.arguments.runs);
        numbers.flat_map(|run| (0..CASES.len()).map(move |case| (case, run))).collect()
    }

    fn key_of(&self, run: &Run) -> Option<Self::Key> {
        let case = CASES.iter().position(|case| case.name == run.case)?;
        let CampaignEarthArguments { horizon, surface, .. } = self.arguments;
        let ours = run.seed == self.arguments.common.seed
            && run.horizon == horizon.name()
            && run.surface == surface.name();
        ours.then_some((case, run.run))
    }

    fn workspace(&self) {}

    fn fly(&self, (): &mut (), (case, run): &Self::Key) -> Result<Run, HostError> {
        fly(&self.base, &self.heights, self.arguments.common.seed, *run, *case)
    }
}

/// All frames in order of case and number.
///
/// # Errors
/// When the file cannot be used.
pub fn runs(arguments: &CampaignEarthArguments) -> Result<Vec<Run>, HostError> {
    let mut base = cases::base()?;
    (base.earth.horizon, base.earth.surface) = (arguments.horizon, arguments.surface);
    let heights = Heights::of(&base.earth);
    super::runs(&Frames { arguments, base, heights }, &arguments.common)
}

/// The run with the frame of which the flight's way knows least: none, or the largest error of the direction
/// over its sigma.
fn worst(runs: &[Run]) -> u64 {
    let of = |run: &Run| {
        let tracked = run.seen.iter().find(|seen| seen.way == Way::Tracked);
        let over_sigma = tracked.and_then(|seen| {
            let fix = seen.fix.as_ref()?;
            let sigma = fix.sigma_deg?;
            Some((fix.error_deg[0] / sigma[0]).abs().max((fix.error_deg[1] / sigma[1]).abs()))
        });
        over_sigma.unwrap_or(f64::INFINITY)
    };
    runs.iter().max_by(|one, other| of(one).total_cmp(&of(other))).map_or(0, |run| run.run)
}

/// Runs the command.
///
/// # Errors
/// When the file of runs cannot be used.
pub fn run(arguments: &CampaignEarthArguments) -> Result<ExitCode, HostError> {
    let runs = runs(arguments)?;
    let table = Table::of(&runs);
    if arguments.common.json {
        table.rows.iter().for_each(json::print_line);
        table.noons.iter().for_each(json::print_line);
    } else {
        print_line!("{}", table.text());
        print_line!("{}", again("earth", arguments.common.seed, worst(&runs)));
    }
    Ok(if table.kept() { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

#[cfg(test)]
mod tests;
