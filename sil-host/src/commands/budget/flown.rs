//! A flight in the emulator, metered.
//!
//! The passes of a stage's loops are calls of functions of the image, which the meter counts and times.

use crate::commands::record::mission::Flight;
use crate::commands::record::{self, Instrument};
use crate::error::HostError;
use crate::words::io_words;
use fsw_core::camera::CameraParameters;
use fsw_core::telemetry::Report;
use fsw_hal::DetectorGeometry;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

/// What the image prints of itself.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct ImageFigures {
    /// Deepest that was touched.
    pub(super) stack_bytes: u64,
    pub(super) static_ram_bytes: u64,
    pub(super) flash_bytes: u64,
}

/// What the analysis of its machine code says (`tests/stack-depth`).
#[derive(Clone, Debug, Deserialize)]
pub(super) struct StackDepth {
    /// Deepest that any path through its calls can need.
    pub(super) stack_bytes: u64,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(super) struct Work {
    pub(super) instructions: u64,
    pub(super) cycles: u64,
    /// Lines of code fetched and words loaded.
    pub(super) waits: u64,
}

/// Calls of a function within a stage.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(super) struct Calls {
    /// How many.
    pub(super) calls: u64,
    /// All together.
    #[serde(flatten)]
    pub(super) work: Work,
    /// The dearest.
    pub(super) most: Work,
}

/// A stage of a second.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct MeteredStage {
    #[serde(flatten)]
    pub(super) work: Work,
    /// The counted functions' calls, by name.
    pub(super) counted: BTreeMap<String, Calls>,
}

impl MeteredStage {
    /// Calls of a function.
    pub(super) fn calls_of(&self, function: &str) -> Calls {
        self.counted.get(function).copied().unwrap_or_default()
    }
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct MeteredCycle {
    #[serde(flatten)]
    pub(super) work: Work,
    pub(super) stages: BTreeMap<u8, MeteredStage>,
}

impl Work {
    /// Adds so many wait states.
    fn wait(&mut self, wait_states: u64) {
        self.cycles += wait_states * self.waits;
    }
}

#[derive(Clone, Debug, Deserialize)]
struct MeterReport {
    start: Work,
    cycles: Vec<MeteredCycle>,
    unfinished_cycles: u64,
    unknown_blocks: u64,
}

/// Runs a program and gives what it printed; its failure is ours.
fn run_program(command: &mut Command, what: &str) -> Result<Output, HostError> {
    let output = command.output().map_err(|error| {
        HostError::usage(format!("{what} cannot be started: {}", io_words(&error)), "install it")
    })?;
    if output.status.success() {
        return Ok(output);
    }
    let words = String::from_utf8_lossy(&output.stderr);
    let last = words.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("no message").to_owned();
    Err(HostError::usage(format!("{what} failed: {last}"), "run it by hand"))
}

/// What came of an emulated flight.
pub(super) struct Flown {
    /// What it is flown for.
    pub(super) name: &'static str,
    /// Its camera and detector.
    pub(super) camera: CameraParameters,
    pub(super) geometry: DetectorGeometry,
    /// Whether there is more on it than the scenarios say.
    pub(super) disturbed: bool,
    pub(super) figures: ImageFigures,
    pub(super) depth: StackDepth,
    /// From reset to the first second.
    pub(super) start: Work,
    /// Every second with what the host says of it.
    pub(super) seconds: Vec<(MeteredCycle, Report)>,
    pub(super) telemetry_identical: bool,
}

impl Flown {
    /// Adds so many wait states of the flash.
    pub(super) fn wait(&mut self, wait_states: u64) {
        self.start.wait(wait_states);
        for (cycle, _) in &mut self.seconds {
            cycle.work.wait(wait_states);
            for stage in cycle.stages.values_mut() {
                let calls = stage.counted.values_mut().flat_map(|calls| [&mut calls.work, &mut calls.most]);
                calls.chain([&mut stage.work]).for_each(|work| work.wait(wait_states));
            }
        }
    }
}

/// Records a flight, builds image and meter, and flies the recording; `counted`: the functions whose calls
/// are counted.
pub(super) fn fly(
    root: &Path,
    (name, flight): (&'static str, &Flight),
    folder: &Path,
    counted: &str,
) -> Result<Flown, HostError> {
    let Instrument { geometry, parameters, .. } = flight.instrument()?;
    let (files, reports) = record::record_flight(flight, folder)?;
    let cargo = || {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(root);
        cargo
    };
    let tools = ["build", "--release", "-p", "cycle-meter", "-p", "stack-depth"];
    run_program(cargo().args(tools), "building the cycle meter and the stack analysis")?;
    let [meter, depth, telemetry, link] =
        ["cycles.json", "stack.json", "obc-telemetry.bin", "obc-reports.bin"].map(|name| folder.join(name));
    let commanded = if flight.orders.is_empty() { vec![] } else { vec![&files.commands, &link] };
    let output = run_program(
        cargo()
            .args(["obc", "--quiet", "--"])
            .args([&files.frames, &files.parameters, &telemetry])
            .args(commanded)
            .env("BAD_PIXELS", &files.bad_pixels)
            .env("CYCLE_METER", &meter)
            .env("CYCLE_METER_COUNT", counted)
            .env("STACK_DEPTH", &depth),
        "the flight image in the emulator (cargo obc)",
    )?;
    let read = |path: &Path| {
        std::fs::read(path).map_err(|error| HostError::system(path, "read", &error, "run it again"))
    };
    let parse = |path: &Path, error: serde_json::Error| {
        HostError::input(path, None, error.to_string(), "report this")
    };
    let metered: MeterReport =
        serde_json::from_slice(&read(&meter)?).map_err(|error| parse(&meter, error))?;
    if metered.unfinished_cycles != 0 || metered.unknown_blocks != 0 {
        return Err(HostError::input(&meter, None, "the meter lost count", "report this"));
    }
    let stages = metered.cycles.iter().flat_map(|cycle| cycle.stages.values());
    let mut counted = stages.flat_map(|stage| &stage.counted);
    if let Some((function, _)) = counted.find(|(_, calls)| calls.calls > 0 && calls.most.cycles == 0) {
        return Err(HostError::input(
            &meter,
            None,
            format!("calls of {function} are not timed"),
            "report this",
        ));
    }
    let depth = serde_json::from_slice(&read(&depth)?).map_err(|error| parse(&depth, error))?;
    let figures = serde_json::from_slice(&output.stdout)
        .map_err(|error| parse(Path::new("the image's figures"), error))?;
    if metered.cycles.len() != reports.len() {
        let what = format!("{} of {} seconds were metered", metered.cycles.len(), reports.len());
        return Err(HostError::usage(what, "report this"));
    }
    Ok(Flown {
        name,
        disturbed: flight.disturbances.is_some(),
        camera: parameters.camera,
        geometry,
        figures,
        depth,
        start: metered.start,
        seconds: metered.cycles.into_iter().zip(reports).collect(),
        telemetry_identical: read(&telemetry)? == read(&files.telemetry)?,
    })
}
