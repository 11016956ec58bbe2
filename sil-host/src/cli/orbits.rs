//! Arguments of the commands about orbits.

use crate::words::named;
use clap::Args;
use fsw_core::orbit::forces::Dynamics;
use fsw_core::orbit::parameters::Observation;
use std::path::PathBuf;

/// What `--dynamics` may be.
const DYNAMICS: [(Dynamics, &str); 3] =
    [(Dynamics::Kepler, "kepler"), (Dynamics::J2, "j2"), (Dynamics::Full, "full")];
/// What `--filter` may be.
const FILTERS: [(Observation, &str); 3] = [
    (Observation::UnitVector, "unit"),
    (Observation::Position, "position"),
    (Observation::Combined, "combined"),
];

/// The forces that a name means.
///
/// # Errors
/// A list of the names, where there is none of this one.
pub fn dynamics(name: &str) -> Result<Dynamics, String> {
    named(&DYNAMICS, "dynamics", name)
}

fn filter(name: &str) -> Result<Observation, String> {
    named(&FILTERS, "filters", name)
}

/// A time that is longer than none, to the microsecond.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (1e-6..=1e9).contains(seconds));
    seconds.ok_or_else(|| "give seconds, from a millionth to 1e9".into())
}

/// Arguments of `propagate`.
#[derive(Debug, Args)]
pub struct PropagateArguments {
    /// The state: one JSON object, with what it flies about
    #[arg(value_name = "STATE.json")]
    pub state: PathBuf,
    /// How far to propagate, s
    #[arg(long, value_name = "T", value_parser = seconds)]
    pub duration_s: f64,
    /// A state is printed every so many seconds, and the last one
    #[arg(long, value_name = "H", value_parser = seconds)]
    pub step_s: f64,
    /// Forces: kepler (a point mass), j2 (the body's field of the second degree, Sun and Moon) or full (the
    /// field of the eighth, Sun, Moon, drag and the Sun's light)
    #[arg(long, value_name = "FORCES", default_value = "full", value_parser = dynamics)]
    pub dynamics: Dynamics,
    /// One JSON object a state on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `navigate`.
#[derive(Debug, Args)]
pub struct NavigateArguments {
    /// The initial guess on the first line, then a measurement a line
    #[arg(value_name = "MEAS.jsonl")]
    pub measurements: PathBuf,
    /// What is taken of a measurement: unit (its direction), position (direction and range) or combined (the
    /// position until the orbit is known to a thousandth, the direction afterwards)
    #[arg(long, value_name = "FILTER", default_value = "position", value_parser = filter)]
    pub filter: Observation,
    /// Forces: kepler (a point mass), j2 (the body's field of the second degree, Sun and Moon) or full (the
    /// field of the eighth, Sun, Moon, drag and the Sun's light)
    #[arg(long, value_name = "FORCES", default_value = "full", value_parser = dynamics)]
    pub dynamics: Dynamics,
    /// Estimate nothing; print what these measurements can tell of an orbit through the first line's state:
    /// ranks of observability by form of measurement, without and with a misalignment of the paths
    #[arg(long, conflicts_with = "filter")]
    pub observability: bool,
    /// One JSON object a measurement on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `outages`.
#[derive(Debug, Args)]
pub struct OutagesArguments {
    /// Scenario files, or names of those that come with the program: of each its start, orbit, pointing,
    /// mount and camera, as the flight code is told them
    #[arg(value_name = "ORBIT.toml", required = true)]
    pub orbits: Vec<PathBuf>,
    /// How far ahead, s; left out: one revolution
    #[arg(long, value_name = "T", value_parser = seconds)]
    pub duration_s: Option<f64>,
    /// Forces: kepler (a point mass), j2 (the body's field of the second degree, Sun and Moon) or full (the
    /// field of the eighth, Sun, Moon, drag and the Sun's light)
    #[arg(long, value_name = "FORCES", default_value = "full", value_parser = dynamics)]
    pub dynamics: Dynamics,
    /// Draw the states over time, and tables of them, on a page of its own
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// One JSON object an orbit on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}
