//! A recorded run: the folder that `run --out` wrote, opened for the page.
//!
//! In: `summary.json` (scenario, seed, start, limits), `cycles.csv` (the seconds), `telemetry.bin` (stars and
//! limb points; without it they are not shown). Out: a [`Run`] whose log is whole. Frames are not in the
//! folder. They are drawn again where the scenario is at hand and its world is that of the run, which is
//! tried on position and attitude of three seconds.

use super::ground::Ground;
use super::log::{End, Log, Logged, Place, Run, Title};
use super::row;
use super::world::World;
use crate::error::HostError;
use crate::report::opinion::Grade;
use crate::scenario::Scenario;
use crate::world::attitude::{dot, normalised};
use crate::world::time::civil_time;
use crate::world::vector::{length, minus};
use csv::StringRecord;
use fsw_core::orbit::body::CentralBody;
use fsw_core::telemetry;
use serde::Deserialize;
use std::fs::File;
use std::ops::RangeInclusive;
use std::path::Path;

/// Most seconds of a run that is opened.
const SECONDS_MAX: usize = 864_000;
/// When a run may start, TT since J2000, s: within two centuries.
const START_T_S: RangeInclusive<f64> = -6.4e9..=6.4e9;
/// Largest difference of a world that is the run's own: position, km; attitude, rad.
const SAME_KM: f64 = 1e-3;
const SAME_RAD: f64 = 1e-6;

/// What is read of `summary.json`.
#[derive(Debug, Deserialize)]
struct Summary {
    scenario: String,
    seed: u64,
    start_t_s: f64,
    /// What was flown about; a run of before this was told flew about the Earth.
    #[serde(default = "earth")]
    body: String,
    kept: bool,
    limits: Vec<Limit>,
}

fn earth() -> String {
    CentralBody::Earth.name().to_owned()
}

#[derive(Debug, Deserialize)]
struct Limit {
    limit: String,
    kept: bool,
}

/// Opens a folder as the run of this number; frames are drawn where one of the `scenarios` is the run's.
///
/// # Errors
/// When the folder's files cannot be read or are not those of a run.
pub fn open(run: u32, folder: &Path, scenarios: &[Scenario]) -> Result<Run, HostError> {
    let summary_path = folder.join("summary.json");
    let text = std::fs::read(&summary_path).map_err(|error| unread(&summary_path, &error))?;
    let summary: Summary = serde_json::from_slice(&text)
        .map_err(|error| HostError::input(&summary_path, Some(error.line()), error.to_string(), TO_DO))?;
    if !START_T_S.contains(&summary.start_t_s) {
        let what = format!("start_t_s: {} is no instant of a run", summary.start_t_s);
        return Err(HostError::input(&summary_path, None, what, TO_DO));
    }
    let body = CentralBody::of_name(&summary.body).ok_or_else(|| {
        let what = format!("body: {:?} is none that is known", summary.body);
        HostError::input(&summary_path, None, what, TO_DO)
    })?;
    let start_us = libm::round(summary.start_t_s * 1e6) as i64;
    let mut seconds = seconds(&folder.join("cycles.csv"), Ground::new(body, start_us), start_us)?;
    add_reports(&folder.join("telemetry.bin"), &mut seconds)?;
    let scenario = scenarios
        .iter()
        .find(|scenario| {
            let is_as_long = scenario.duration_s as usize >= seconds.len();
            scenario.name == summary.scenario && scenario.start_us == start_us && is_as_long
        })
        .map(|scenario| scenario.clone().with_seed(Some(summary.seed)));
    let title = Title {
        run,
        scenario: summary.scenario.clone(),
        description: scenario.as_ref().map_or_else(String::new, |scenario| scenario.description.clone()),
        seed: summary.seed,
        start_utc: civil_time::utc_text(start_us),
        duration_s: seconds.len() as u32,
        gyro: scenario.as_ref().is_some_and(|scenario| scenario.gyro.is_some()),
        folder: Some(folder.display().to_string()),
        start_us,
        body,
    };
    let faults = scenario.as_ref().map_or_else(Vec::new, |scenario| scenario.faults.clone());
    let world = world(scenario, &seconds);
    Ok(Run::new(title, world, Log { seconds, faults, end: Some(end(&summary)) }))
}

const TO_DO: &str = "name a folder that `run --out` wrote";

fn unread(path: &Path, error: &std::io::Error) -> HostError {
    HostError::system(path, "read", error, TO_DO)
}

/// The seconds of a `cycles.csv`, without reports.
fn seconds(path: &Path, ground: Ground, start_us: i64) -> Result<Vec<Logged>, HostError> {
    let file = File::open(path).map_err(|error| unread(path, &error))?;
    let mut reader = csv::Reader::from_reader(std::io::BufReader::new(file));
    let refused = |error: csv::Error| HostError::input(path, None, error.to_string(), TO_DO);
    let header = reader.headers().map_err(refused)?.clone();
    let column = |name: &str| {
        header
            .iter()
            .position(|column| column == name)
            .ok_or_else(|| HostError::input(path, Some(1), format!("there is no column `{name}`"), TO_DO))
    };
    let attitude = columns(["true_qx", "true_qy", "true_qz", "true_qw"], column)?;
    let position = columns(["true_x_km", "true_y_km", "true_z_km"], column)?;
    let cycle = column("cycle")?;
    let places = row::places(header.iter());
    let mut seconds = Vec::new();
    for record in reader.records() {
        let record = record.map_err(refused)?;
        let line = record.position().map(|position| position.line() as usize);
        let wrong = |what: &str| HostError::input(path, line, what, TO_DO);
        if record.get(cycle) != Some(seconds.len().to_string().as_str()) {
            return Err(wrong("the seconds are not numbered from 0 on"));
        }
        if seconds.len() >= SECONDS_MAX {
            return Err(wrong("more seconds than a run has"));
        }
        let quaternion = numbers(&record, attitude).and_then(normalised);
        let quaternion = quaternion.ok_or_else(|| wrong("true_qx to true_qw are no attitude"))?;
        let position_km = numbers(&record, position).filter(|position_km| length(*position_km) > 1.0);
        let position_km = position_km.ok_or_else(|| wrong("true_x_km to true_z_km are no position"))?;
        let instant_us = start_us + seconds.len() as i64 * 1_000_000;
        let row = row::of_fields(&record, &places, ground.place_deg(position_km, instant_us));
        let place = Place { instant_us, quaternion, position_km };
        seconds.push(Logged { row, place, frame: None, windows: None });
    }
    if seconds.is_empty() {
        return Err(HostError::input(path, None, "there is no second in it", TO_DO));
    }
    Ok(seconds)
}

fn columns<const N: usize>(
    names: [&str; N],
    column: impl Fn(&str) -> Result<usize, HostError>,
) -> Result<[usize; N], HostError> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        *place = column(name)?;
    }
    Ok(places)
}

fn numbers<const N: usize>(record: &StringRecord, places: [usize; N]) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for (number, place) in numbers.iter_mut().zip(places) {
        *number = record.get(place)?.parse().ok().filter(|number: &f64| number.is_finite())?;
    }
    Some(numbers)
}

/// Adds the telemetry frames, where the file is there and has one for every second.
fn add_reports(path: &Path, seconds: &mut [Logged]) -> Result<(), HostError> {
    let stream = match std::fs::read(path) {
        Ok(stream) => stream,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(unread(path, &error)),
    };
    let mut rest = &stream[..];
    for second in seconds {
        let Some((frame, behind)) = telemetry::split_first(rest) else {
            return Err(HostError::input(
                path,
                None,
                "it has fewer frames than cycles.csv has seconds",
                TO_DO,
            ));
        };
        second.frame = Some(frame.into());
        rest = behind;
    }
    Ok(())
}

/// The world of the run, from which its frames are drawn; or why there is none.
fn world(scenario: Option<Scenario>, seconds: &[Logged]) -> Result<World, String> {
    let scenario = scenario.ok_or(
        "The frame is not kept in the folder, and the scenario is none that comes with the program: start \
         `serve` with its file to have frames drawn again.",
    )?;
    let scene = scenario.scene().map_err(|error| error.to_string())?;
    let last = seconds.len() - 1;
    let same = [0, last / 2, last].into_iter().all(|cycle| {
        let Place { quaternion, position_km, .. } = seconds[cycle].place;
        scene.truth_at(cycle as u64).is_some_and(|truth| {
            let cosine = (0..4).map(|k| quaternion[k] * truth.quaternion[k]).sum::<f64>().abs();
            let apart = minus(position_km, truth.position_km);
            dot(apart, apart) <= SAME_KM * SAME_KM && 1.0 - cosine <= 0.5 * SAME_RAD
        })
    });
    if !same {
        return Err("The frame is not kept in the folder, and the scenario of this name has another world: \
                    the run was varied, or its file changed."
            .to_owned());
    }
    Ok(World::new(scenario, scene))
}

/// What the run came to.
fn end(summary: &Summary) -> End {
    let missed: Vec<&str> =
        summary.limits.iter().filter(|limit| !limit.kept).map(|limit| limit.limit.as_str()).collect();
    if summary.limits.is_empty() {
        End::new(Grade::Doubtful, "No limits were set.".into())
    } else if summary.kept {
        End::new(Grade::Right, format!("All {} limits are kept.", summary.limits.len()))
    } else {
        let (count, all, names) = (missed.len(), summary.limits.len(), missed.join(", "));
        End::new(Grade::Missed, format!("{count} of {all} limits missed: {names}."))
    }
}

/// Folders below `parent` that hold a run, by name.
pub fn found_in(parent: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(parent).into_iter().flatten().flatten().map(|entry| entry.path());
    let runs = entries.filter(|path| ["summary.json", "cycles.csv"].iter().all(|of| path.join(of).is_file()));
    let mut names: Vec<String> = runs.map(|path| path.display().to_string()).collect();
    names.sort();
    names
}
