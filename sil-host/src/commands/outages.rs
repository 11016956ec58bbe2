//! `sil-host outages`: what the sensor will be able to do along an orbit, by the flight code's own prediction
//! ([`fsw_core::outages`]; thesis tab. 8.1, figs. 8.5 to 8.10).
//!
//! In: scenario files. Of each its start, orbit, law of pointing, mount and camera count, as the flight code
//! is told them ([`crate::scenario::Believed`]); jitter and slews are left out, which a line on stderr says
//! of slews. A body that turns freely has no law and is refused.
//!
//! Out: the states from the start on, with the seconds at which they begin and end, and of each state how
//! often and how long. As JSON:
//! `{"orbit","start_utc","start_t_s","duration_s","period_s","states":[{"state","name",
//! "begin_s","end_s","duration_s"}],"totals":[{"state","name","count","seconds","share","shortest_s",
//! "longest_s"}]}`; seconds count from the start. The first state and the last are cut off by the span.
//!
//! States shorter than [`fsw_core::outages::STEP_S`] may be passed over. Six orbits of the thesis stand in
//! `sil-host/orbits`.

pub mod page;

use crate::cli::OutagesArguments;
use crate::error::{Faults, HostError};
use crate::formats::json;
use crate::output;
use crate::scenario::Scenario;
use crate::words::name;
use crate::world::motion::pointing::Law;
use fsw_core::frames::Rotation;
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::constants::MICROSECONDS;
use fsw_core::orbit::forces::Dynamics;
use fsw_core::orbit::parameters::OrbitParameters;
use fsw_core::outages::{Forecast, PointingLaw};
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// Longest span, s: a year and a month.
const LONGEST_S: f64 = 400.0 * 86_400.0;
/// Most states that are listed for people; totals are told of all.
const LISTED: usize = 40;

/// All states, by their numbers: name in JSON, words for people.
pub const STATES: [(&str, &str); 5] = [
    ("full", "full"),
    ("sun_in_earth_path", "Sun in the Earth path"),
    ("eclipse", "eclipse"),
    ("sun_in_star_path", "Sun in the star path"),
    ("sun_in_star_path_over_earth", "Sun in the star path, over the Earth"),
];

/// Number of a state, as it stands, with its words.
pub fn words(state: u8) -> String {
    format!("{state} {}", STATES[usize::from(state)].1)
}

/// A stretch of seconds in one state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Number of the state (thesis tab. 8.1).
    pub state: u8,
    /// Its name.
    pub name: &'static str,
    /// First second, from the start.
    pub begin_s: u32,
    /// The second after its last.
    pub end_s: u32,
    /// How long.
    pub duration_s: u32,
}

/// A state over the whole span.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Total {
    /// Number of the state.
    pub state: u8,
    /// Its name.
    pub name: &'static str,
    /// How often it comes.
    pub count: usize,
    /// In all.
    pub seconds: u32,
    /// Of the span.
    pub share: f64,
    /// Shortest and longest time without a break; `None` of a state that does not come.
    pub shortest_s: Option<u32>,
    /// See `shortest_s`.
    pub longest_s: Option<u32>,
}

/// What is to come along an orbit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outlook {
    /// The scenario's name.
    pub orbit: String,
    /// What is to be seen in it.
    #[serde(skip)]
    pub description: String,
    /// Start, UTC.
    pub start_utc: String,
    /// Start, TT, seconds since J2000.0.
    pub start_t_s: f64,
    /// How far ahead, s.
    pub duration_s: u32,
    /// Of the orbit at the start, s; `None` of one that does not close.
    pub period_s: Option<f64>,
    /// The states in their order.
    pub states: Vec<Interval>,
    /// All five.
    pub totals: Vec<Total>,
}

/// The law by which a scenario's satellite is pointed.
///
/// # Errors
/// When it turns freely.
fn law(scenario: &Scenario) -> Result<PointingLaw, HostError> {
    let rad = |degrees: &f64| degrees.to_radians() as f32;
    Ok(match &scenario.pointing.law {
        Law::Nadir { off_nadir_deg, roll_deg } => PointingLaw::nadir(rad(off_nadir_deg), rad(roll_deg)),
        Law::Horizon { below_deg, roll_deg } => {
            PointingLaw::Horizon { below_rad: rad(below_deg), roll_rad: rad(roll_deg) }
        }
        Law::Inertial(aim) => {
            let rows = aim.matrix().map(|row| Vector3::from(row).map(|part| part as f32).transpose());
            PointingLaw::Inertial(Rotation::from_orthogonal(Matrix3::from_rows(&rows)))
        }
        Law::Spin(_) => {
            let what = "pointing.law: a body that turns freely is pointed by no law";
            return Err(HostError::input(&scenario.file, None, what, "use nadir, horizon or inertial"));
        }
    })
}

/// Predicts the states of a scenario's sensor from its start; over one revolution where no span is given.
///
/// # Errors
/// A body that turns freely, an orbit that does not close without a span, too long a span, an orbit that
/// leaves the bounds of the dynamics.
pub fn outlook(
    scenario: &Scenario,
    duration_s: Option<f64>,
    dynamics: Dynamics,
) -> Result<Outlook, HostError> {
    let refuse = |what: &str, to_do: &str| HostError::input(&scenario.file, None, what, to_do);
    let pointing = law(scenario)?;
    let parameters = scenario.flight_parameters(None);
    let (camera, star_to_earth) = parameters.check().map_err(|error| {
        refuse(&format!("the flight code refuses camera or mount ({error:?})"), "correct them")
    })?;
    let period_s = Some(scenario.period_s()).filter(|period_s| period_s.is_finite());
    let Some(span_s) = duration_s.or(period_s) else {
        return Err(refuse("the orbit does not close", "give --duration-s"));
    };
    if span_s > LONGEST_S {
        return Err(refuse("a span of more than 400 days", "give a shorter --duration-s"));
    }
    let duration_s = span_s.ceil() as u32;
    let forces = OrbitParameters { dynamics, ..parameters.orbit }.forces();
    let forecast = Forecast { camera: &camera, star_to_earth, pointing, earth: &parameters.earth, forces };
    let mut orbit = OrbitState {
        time_us: scenario.start_us,
        position_km: scenario.position_km.into(),
        velocity_km_s: scenario.velocity_km_s.into(),
    };
    let lost = |at_s: u32| {
        let what =
            format!("after {at_s} s the orbit is inside the Earth or out of the bounds of the dynamics");
        refuse(&what, "give another orbit or a shorter --duration-s")
    };
    let mut state = forecast.state(&orbit).ok_or_else(|| lost(0))?;
    let mut states = Vec::new();
    let (mut begin_s, mut at_s) = (0, 0);
    while at_s < duration_s {
        let (later, next) = forecast.step(&orbit, state).map_err(|_| lost(at_s))?;
        at_s = ((later.time_us - scenario.start_us) as f64 / MICROSECONDS).round() as u32;
        if next != state || at_s >= duration_s {
            let end_s = at_s.min(duration_s);
            let (state, name) = (state as u8, STATES[state as usize].0);
            states.push(Interval { state, name, begin_s, end_s, duration_s: end_s - begin_s });
            begin_s = end_s;
        }
        (orbit, state) = (later, next);
    }
    let totals =
        (0..).zip(STATES).map(|(state, (name, _))| total((state, name), &states, duration_s)).collect();
    Ok(Outlook {
        orbit: scenario.name.clone(),
        description: scenario.description.clone(),
        start_utc: scenario.start_utc.clone(),
        start_t_s: scenario.start_us as f64 / MICROSECONDS,
        duration_s,
        period_s,
        states,
        totals,
    })
}

fn total((state, name): (u8, &'static str), states: &[Interval], duration_s: u32) -> Total {
    let spans = || states.iter().filter(|one| one.state == state).map(|one| one.duration_s);
    let seconds = spans().sum();
    Total {
        state,
        name,
        count: spans().count(),
        seconds,
        share: f64::from(seconds) / f64::from(duration_s),
        shortest_s: spans().min(),
        longest_s: spans().max(),
    }
}

impl Outlook {
    fn print(&self) {
        print_line!("{}: {} s from {} UTC", self.orbit, self.duration_s, self.start_utc);
        if self.states.len() <= LISTED {
            for Interval { state, begin_s, end_s, duration_s, .. } in &self.states {
                print_line!("  {begin_s:>9} to {end_s:>9} s  {duration_s:>9} s  {}", words(*state));
            }
        }
        for Total { state, seconds, share, count, shortest_s, longest_s, .. } in &self.totals {
            let spans = match (shortest_s, longest_s) {
                (Some(shortest), Some(longest)) => format!("{shortest} to {longest} s each"),
                _ => "never".to_owned(),
            };
            let share = 100.0 * share;
            let times = if *count == 1 { "time" } else { "times" };
            print_line!(
                "  {:<38} {share:>6.2} %  {seconds:>9} s  {count:>5} {times:<5}  {spans}",
                words(*state)
            );
        }
    }
}

/// Runs the command.
///
/// # Errors
/// Of writing the page; what is wrong with an orbit costs a line, and the others are still answered.
pub fn run(arguments: &OutagesArguments) -> Result<ExitCode, HostError> {
    let mut faults = Faults::default();
    let mut outlooks = Vec::new();
    for path in &arguments.orbits {
        let found = of_file(path, arguments.duration_s, arguments.dynamics);
        let Some(outlook) = faults.noted(found) else { continue };
        if arguments.json {
            json::print_line(&outlook);
        } else {
            outlook.print();
        }
        outlooks.push(outlook);
    }
    if let Some(path) = &arguments.page {
        output::write_whole(path, page::html(&outlooks).as_bytes())?;
        eprintln!("{}: page in {}", name(), path.display());
    }
    Ok(faults.status())
}

fn of_file(path: &Path, duration_s: Option<f64>, dynamics: Dynamics) -> Result<Outlook, HostError> {
    let scenario = Scenario::load(path)?;
    if !scenario.pointing.slews.is_empty() {
        eprintln!("{}: {}: slews are left out of the prediction", name(), path.display());
    }
    outlook(&scenario, duration_s, dynamics)
}

#[cfg(test)]
mod tests;
