//! `sil-host attitude`: the flight code's attitude methods on lists of vector pairs, or compared over the
//! sky.
//!
//! In: one set a line, `{"id":..,"b":[[x,y,z],...],"r":[[x,y,z],...],"sigma_rad":[..]}`: unit vectors
//! measured (sensor frame) and in the catalogue (ICRS), and the standard deviation of each measured one per
//! axis across the line of sight. An optional `"covariance_rad2":[[xx,xy,yy],...]`, of the x and y of each
//! measured vector, is what the method `anisotropic` weighs by; without it that solves the same problem as
//! the others.
//!
//! Out: an answer a set and method, in the order given:
//! `{"id","method","status","reason","q","sigma_arcsec","loss","us"}`. `status` is `solved` or, with a
//! `reason`, `refused`; `q` is ICRS to sensor; `sigma_arcsec` about x, y, z; `loss` what was minimised, half
//! a chi-square with two degrees of freedom a star, less three; `us` host time. A line that is no set costs
//! one line on stderr with its number and status 2 at the end; the others are still answered.
//!
//! A set whose directions contradict each other is refused for all methods alike ([`agreement`]).
//!
//! `--table`: see [`crate::commands::attitude::table`].

pub mod agreement;
pub mod methods;
pub mod table;

use crate::cli::AttitudeArguments;
use crate::error::{Faults, HostError};
use crate::formats::json;
use fsw_core::attitude::comparison::{self, WahbaMethod};
use fsw_core::attitude::covariance::sigmas_rad;
use fsw_core::attitude::wahba::{Solution, WahbaError};
use fsw_core::attitude::{ExtendedPair, VectorPair};
use fsw_core::frames::{ARCSEC_PER_RAD, Direction};
use methods::name;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// How far from one the length of a unit vector may be.
const UNIT_TOLERANCE: f64 = 1e-3;
const TO_DO: &str = "give {\"id\":..,\"b\":[[x,y,z],...],\"r\":[[x,y,z],...],\"sigma_rad\":[..]}";

/// Why the flight code refuses a set, in words.
pub fn reason_words(reason: WahbaError) -> &'static str {
    match reason {
        WahbaError::TooFew => "fewer than two directions",
        WahbaError::Parallel => "directions are nearly parallel",
        WahbaError::Collinear => "directions lie on one great circle",
        WahbaError::Ambiguous => "directions contradict each other",
        WahbaError::NotFinite => "a sigma or covariance is not finite",
        WahbaError::Weight => "a sigma or covariance is not positive, or out of range",
    }
}

/// A set as given.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetInput {
    /// Anything that names the set; given back.
    pub id: serde_json::Value,
    /// Measured unit vectors, sensor frame.
    pub b: Vec<Vec<f64>>,
    /// The same in the catalogue, ICRS.
    pub r: Vec<Vec<f64>>,
    /// Standard deviation of each measured vector per axis, rad.
    pub sigma_rad: Vec<f64>,
    /// Covariance of the x and y of each measured vector, `[xx, xy, yy]`, rad².
    #[serde(default)]
    pub covariance_rad2: Option<Vec<Vec<f64>>>,
}

/// The answer for a set and a method.
#[derive(Clone, Debug, Serialize)]
pub struct SetAnswer {
    /// As given.
    pub id: serde_json::Value,
    /// Name of the method.
    pub method: &'static str,
    /// `solved` or `refused`.
    pub status: &'static str,
    /// Why not, where not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// ICRS to sensor, `[x, y, z, w]`.
    pub q: Option<[f32; 4]>,
    /// Standard deviations about x, y, z, arcsec.
    pub sigma_arcsec: Option<[f32; 3]>,
    /// What the method minimised.
    pub loss: Option<f32>,
    /// Host time, microseconds.
    pub us: f64,
}

/// The pairs of a set.
enum Pairs {
    Plain(Vec<VectorPair>),
    /// With error ellipses, or why these are none.
    Extended(Result<Vec<ExtendedPair>, WahbaError>),
}

/// The vector called `name`, if it is one of unit length.
fn unit<F>(name: &str, index: usize, vector: &[f64]) -> Result<Direction<F>, String> {
    let [x, y, z] = *vector else {
        return Err(format!("{name}[{index}] has {} numbers instead of 3", vector.len()));
    };
    let length = (x * x + y * y + z * z).sqrt();
    let direction = Direction::new([x as f32, y as f32, z as f32].into());
    match direction {
        Some(direction) if (length - 1.0).abs() < UNIT_TOLERANCE => Ok(direction),
        _ => Err(format!("{name}[{index}] is no unit vector")),
    }
}

/// Reads the numbers of a set.
fn pairs(set: &SetInput) -> Result<Pairs, String> {
    let count = set.b.len();
    let lengths = [("r", set.r.len()), ("sigma_rad", set.sigma_rad.len())];
    let covariances = set.covariance_rad2.as_ref().map(|list| ("covariance_rad2", list.len()));
    if let Some((name, length)) = lengths.into_iter().chain(covariances).find(|(_, length)| *length != count)
    {
        return Err(format!("b has {count} entries and {name} has {length}"));
    }
    let pair = |index: usize| {
        Ok(VectorPair {
            measured: unit("b", index, &set.b[index])?,
            reference: unit("r", index, &set.r[index])?,
            sigma_rad: set.sigma_rad[index] as f32,
        })
    };
    let plain = (0..count).map(pair).collect::<Result<Vec<_>, String>>()?;
    let Some(covariances) = &set.covariance_rad2 else { return Ok(Pairs::Plain(plain)) };
    let numbers = |(index, list): (usize, &Vec<f64>)| match **list {
        [xx, xy, yy] => Ok([xx, xy, yy].map(|value| value as f32)),
        _ => Err(format!("covariance_rad2[{index}] has {} numbers instead of 3", list.len())),
    };
    let covariances = covariances.iter().enumerate().map(numbers).collect::<Result<Vec<_>, String>>()?;
    let extended =
        plain.into_iter().zip(covariances).map(|(pair, covariance)| ExtendedPair::new(pair, covariance));
    Ok(Pairs::Extended(extended.collect()))
}

/// Whether the directions of a set agree.
fn agreement(pairs: &Pairs) -> Result<(), WahbaError> {
    match pairs {
        Pairs::Plain(pairs) => agreement::check(WahbaMethod::Svd, pairs),
        Pairs::Extended(Ok(pairs)) => agreement::check(WahbaMethod::Anisotropic, pairs),
        Pairs::Extended(Err(reason)) => Err(*reason),
    }
}

/// Solves one set by one method; refused where its directions do not `agree`.
fn answer(
    id: &serde_json::Value,
    method: WahbaMethod,
    pairs: &Pairs,
    agree: Result<(), WahbaError>,
) -> SetAnswer {
    let begin = Instant::now();
    let found = match pairs {
        Pairs::Plain(pairs) => comparison::solve(method, pairs),
        Pairs::Extended(Ok(pairs)) => comparison::solve(method, pairs),
        Pairs::Extended(Err(reason)) => Err(*reason),
    };
    let us = begin.elapsed().as_secs_f64() * 1e6;
    let found = agree.and(found);
    let refused = SetAnswer {
        id: id.clone(),
        method: name(method),
        status: "refused",
        reason: None,
        q: None,
        sigma_arcsec: None,
        loss: None,
        us,
    };
    match found {
        Err(reason) => SetAnswer { reason: Some(reason_words(reason)), ..refused },
        Ok(Solution { attitude, covariance_rad2, loss }) => SetAnswer {
            status: "solved",
            q: Some(attitude.quaternion()),
            sigma_arcsec: Some(sigmas_rad(&covariance_rad2).map(|sigma| sigma * ARCSEC_PER_RAD)),
            loss: Some(loss),
            ..refused
        },
    }
}

/// Answers the set on one line.
fn answers(
    path: &Path,
    number: usize,
    text: &str,
    methods: &[WahbaMethod],
) -> Result<Vec<SetAnswer>, HostError> {
    let set: SetInput = json::read_line(path, number, text, TO_DO)?;
    let pairs = pairs(&set).map_err(|what| HostError::input(path, Some(number), what, TO_DO))?;
    let agree = agreement(&pairs);
    Ok(methods.iter().map(|method| answer(&set.id, *method, &pairs, agree)).collect())
}

/// Prints an answer for people.
fn print_text(answer: &SetAnswer) {
    let SetAnswer { id, method, us, .. } = answer;
    let text = match (answer.q, answer.sigma_arcsec, answer.loss) {
        (Some(q), Some([x, y, z]), Some(loss)) => {
            format!("q {q:.7?}, sigma {x:.2}, {y:.2}, {z:.1} arcsec, loss {loss:.2}, {us:.1} us")
        }
        _ => answer.reason.unwrap_or(answer.status).to_string(),
    };
    // A reader that closed the pipe has what it wanted: not a fault.
    print_line!("{id}: {method}: {text}");
}

/// Runs the command.
///
/// # Errors
/// What concerns all sets: the file of sets.
pub fn run(arguments: &AttitudeArguments) -> Result<ExitCode, HostError> {
    let Some(path) = arguments.sets.as_deref() else {
        return table::run(arguments.json);
    };
    let mut faults = Faults::default();
    for line in json::Lines::open(path, TO_DO)? {
        let answers = line.and_then(|(number, text)| answers(path, number, &text, &arguments.method));
        match faults.noted(answers) {
            Some(answers) if arguments.json => answers.iter().for_each(json::print_line),
            Some(answers) => answers.iter().for_each(print_text),
            None => {}
        }
    }
    Ok(faults.status())
}
