//! `sil-host budget`: what a second costs on the reference on-board computer, against its limits.
//!
//! Builds the flight image and the cycle meter, records the
//! [mission](crate::commands::record::mission) through every mode, the widest limb, a storm of protons, one in
//! a crowded field and a sunrise with a gyro, flies them in the emulator and prints, per mode and stage, the worst cycles observed,
//! the cycles at the caps (`bounds`), flash, static RAM and stack. The stack is the deeper of two: the deepest path through the calls of the
//! machine code (`tests/stack-depth`, which also proves that nothing calls itself and no call's target is
//! unknown), and what was touched. Status 1 when a limit is overrun or the target's telemetry is not the
//! host's to the byte. Cycles are those of the meter's model (Cortex-M4F, zero wait states, no interrupts);
//! the cost of reading pixels from a real detector is not in them. With
//! `--wait-states W` every line of 16 bytes of code and every word loaded costs W more, as from a flash without
//! cache and prefetch: a bound, held against the same limits.
//!
//! What stars and Earth cost of a second, several stages each, is held against limits of its own, in
//! acquisition too where the limb is predicted: the first strips after a search are as long as strips can be.
//! A row is a mode. Two kinds of seconds have rows of their own, whatever their mode, and the limit of
//! acquisition: those in which the whole detector is searched for the Earth, and those in which the orbit
//! crosses a jump of the clock.

mod bounds;

use crate::cli::BudgetArguments;
use crate::commands::record;
use crate::commands::record::mission::{CROWD, Flight, GYRO, MISSION, STORM, WIDE_LIMB};
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::json;
use crate::judge::expected::word;
use crate::words::io_words;
use bounds::{Bounds, StageBound};
use fsw_core::camera::CameraParameters;
use fsw_core::modes::Mode;
use fsw_core::telemetry::{Event, Report};
use fsw_hal::{DetectorGeometry, Stage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};

/// The file of limits, from the workspace's root.
const LIMITS_FILE: &str = "tests/obc-image/budget.toml";
/// The version of it that is read.
const LIMITS_VERSION: u32 = 1;

/// Names of the flights that drive stages to their caps.
const EVERY_MODE: &str = "every mode";
const WIDEST_LIMB: &str = "widest limb";
const PROTON_STORM: &str = "storm";
const CROWDED_FIELD: &str = "crowd";

#[derive(Clone, Debug, Deserialize)]
struct LimitsFile {
    version: u32,
    target: TargetLimits,
    cycles: CycleLimits,
    memory: MemoryLimits,
}

#[derive(Clone, Debug, Deserialize)]
struct TargetLimits {
    core: String,
    clock_hz: u64,
}

#[derive(Clone, Debug, Deserialize)]
struct CycleLimits {
    acquisition: u64,
    tracking: u64,
    stars_of_tracking: u64,
    earth_of_acquisition: u64,
    earth_of_tracking: u64,
    orbit: u64,
    scan_per_pixel: u64,
}

/// Stages of the star part of a second that is none of acquisition.
const STARS: &[Stage] = &[Stage::Predict, Stage::Windows, Stage::Confirm];
/// Stages of the Earth part of any; its limit is another where the whole detector is searched.
const EARTH: &[Stage] = &[Stage::Limb, Stage::Centre, Stage::Search];
/// Stages of the orbit part of any.
const ORBIT: &[Stage] = &[Stage::Orbit];

/// Limits of memory, bytes.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MemoryLimits {
    flash_bytes: u64,
    static_ram_bytes: u64,
    stack_bytes: u64,
}

/// What the image prints of itself.
#[derive(Clone, Debug, Deserialize)]
struct ImageFigures {
    /// Deepest that was touched.
    stack_bytes: u64,
    static_ram_bytes: u64,
    flash_bytes: u64,
}

/// What the analysis of its machine code says (`tests/stack-depth`).
#[derive(Clone, Debug, Deserialize)]
struct StackDepth {
    /// Deepest that any path through its calls can need.
    stack_bytes: u64,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
struct Work {
    instructions: u64,
    cycles: u64,
    /// Lines of code fetched and words loaded.
    waits: u64,
}

#[derive(Clone, Debug, Deserialize)]
struct MeteredCycle {
    #[serde(flatten)]
    work: Work,
    stages: BTreeMap<u8, Work>,
}

impl MeteredCycle {
    /// Adds so many wait states.
    fn wait(&mut self, wait_states: u64) {
        for work in self.stages.values_mut().chain([&mut self.work]) {
            work.cycles += wait_states * work.waits;
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
struct MeterReport {
    cycles: Vec<MeteredCycle>,
    unfinished_cycles: u64,
    unknown_blocks: u64,
}

/// A mode's worst second.
#[derive(Clone, Debug, Serialize)]
pub struct ModeBudget {
    /// Seconds flown in it.
    seconds: u32,
    limit_cycles: u64,
    worst_cycles: u64,
    worst_instructions: u64,
    /// The dearest of its seconds, had each of its stages cost what it costs at its caps.
    bound_cycles: u64,
    /// Worst cycles of each stage.
    stages: BTreeMap<&'static str, u64>,
    /// Worst cycles of the star, the Earth and the orbit part, with their limits.
    parts: BTreeMap<&'static str, Part>,
}

/// Several stages together.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Part {
    worst_cycles: u64,
    limit_cycles: u64,
}

impl ModeBudget {
    fn kept(&self) -> bool {
        self.worst_cycles <= self.limit_cycles
            && self.parts.values().all(|part| part.worst_cycles <= part.limit_cycles)
    }
}

/// The table.
#[derive(Clone, Debug, Serialize)]
pub struct Budget {
    target: String,
    clock_hz: u64,
    /// Of the flash, cycles.
    wait_states: u8,
    /// Seconds flown.
    seconds: usize,
    modes: BTreeMap<&'static str, ModeBudget>,
    /// What each stage costs at its caps.
    bounds: BTreeMap<&'static str, StageBound>,
    /// The dearest scan for stars of each flight.
    scans: BTreeMap<&'static str, Scan>,
    flash_bytes: u64,
    ram_bytes: u64,
    /// The deeper of the two that follow.
    stack_bytes: u64,
    /// Deepest that was touched in the emulator.
    stack_painted_bytes: u64,
    /// Deepest path through the calls of the machine code.
    stack_analysed_bytes: u64,
    limits: MemoryLimits,
    telemetry_identical: bool,
}

/// The dearest scan for stars of a flight.
#[derive(Clone, Copy, Debug, Serialize)]
struct Scan {
    cycles_per_pixel: f64,
    /// None where the detector is disturbed on purpose: there a second's limit holds.
    limit: Option<u64>,
}

impl Scan {
    fn kept(&self) -> bool {
        self.limit.is_none_or(|limit| self.cycles_per_pixel <= limit as f64)
    }
}

impl Budget {
    /// Every limit of memory with what was used of it.
    fn memory(&self) -> [(&'static str, u64, u64); 3] {
        [
            ("flash, bytes", self.flash_bytes, self.limits.flash_bytes),
            ("static RAM, bytes", self.ram_bytes, self.limits.static_ram_bytes),
            ("stack, bytes", self.stack_bytes, self.limits.stack_bytes),
        ]
    }

    fn kept(&self) -> bool {
        self.telemetry_identical
            && self.modes.values().all(ModeBudget::kept)
            && self.scans.values().all(Scan::kept)
            && self.bounds.values().all(StageBound::kept)
            && self.memory().iter().all(|(_, used, limit)| used <= limit)
    }

    fn print(&self) {
        print_line!(
            "{} at {} MHz, {} wait states; worst cycles of a second and of its stages",
            self.target,
            self.clock_hz / 1_000_000,
            self.wait_states
        );
        for (mode, budget) in &self.modes {
            let seconds = format!("{} s", budget.seconds);
            row(mode, &seconds, budget.worst_cycles, Some(budget.limit_cycles));
            row("", "at the caps", budget.bound_cycles, None);
            for (stage, cycles) in &budget.stages {
                row("", stage, *cycles, None);
            }
            for (part, Part { worst_cycles, limit_cycles }) in &budget.parts {
                row("", part, *worst_cycles, Some(*limit_cycles));
            }
        }
        print_line!("  worst cycles of a stage, of those at its caps");
        for (stage, bound) in &self.bounds {
            row(stage, "", bound.worst_cycles, Some(bound.bound_cycles));
        }
        for (flight, scan) in &self.scans {
            let Scan { cycles_per_pixel, limit } = scan;
            let limit = limit.map_or(String::new(), |limit| format!(" of {limit:>11}"));
            let judged = if scan.kept() { "" } else { "  OVERRUN" };
            print_line!("  {:18} {flight:12} {cycles_per_pixel:>11.1}{limit}{judged}", "scan, a pixel");
        }
        for (name, used, limit) in self.memory() {
            row(name, "", used, Some(limit));
        }
        row("", "by its code", self.stack_analysed_bytes, None);
        row("", "as touched", self.stack_painted_bytes, None);
        let same = if self.telemetry_identical { "identical, byte for byte" } else { "NOT IDENTICAL" };
        print_line!("  telemetry of target and host over {} seconds: {same}", self.seconds);
    }
}

/// A line of the table for people.
fn row(name: &str, part: &str, used: u64, limit: Option<u64>) {
    let judged = limit.map_or(String::new(), |limit| {
        let share = 100.0 * used as f64 / limit as f64;
        format!(" of {limit:>11}  {share:5.1} %{}", if used > limit { "  OVERRUN" } else { "" })
    });
    print_line!("  {name:18} {part:12} {used:>11}{judged}");
}

fn stage_name(number: u8) -> &'static str {
    let stages = [
        (Stage::Scan, "scan"),
        (Stage::Identify, "identify"),
        (Stage::Predict, "predict"),
        (Stage::Windows, "windows"),
        (Stage::Confirm, "confirm"),
        (Stage::Limb, "limb"),
        (Stage::Centre, "centre"),
        (Stage::Orbit, "orbit"),
        (Stage::Search, "search"),
        (Stage::Streaks, "streaks"),
    ];
    stages.iter().find(|(stage, _)| *stage as u8 == number).map_or("other", |(_, name)| name)
}

/// The workspace's root: the nearest folder at or above this one that holds the file of limits.
fn workspace() -> Result<PathBuf, HostError> {
    let here = std::env::current_dir().unwrap_or_default();
    let root = here.ancestors().find(|folder| folder.join(LIMITS_FILE).is_file());
    root.map(Path::to_path_buf).ok_or_else(|| {
        HostError::usage(format!("{LIMITS_FILE} is not here or above"), "run it inside the repository")
    })
}

fn limits(root: &Path) -> Result<LimitsFile, HostError> {
    let path = root.join(LIMITS_FILE);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| HostError::system(&path, "read", &error, "restore it"))?;
    let limits: LimitsFile = toml::from_str(&text)
        .map_err(|error| HostError::input(&path, None, error.message().to_owned(), "correct it"))?;
    if limits.version == LIMITS_VERSION {
        Ok(limits)
    } else {
        let what = format!("version {} instead of {LIMITS_VERSION}", limits.version);
        Err(HostError::input(&path, None, what, "use the program of the same revision"))
    }
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
struct Flown {
    /// What it is flown for.
    name: &'static str,
    /// Its camera and detector.
    camera: CameraParameters,
    geometry: DetectorGeometry,
    /// Whether there is more on it than the scenarios say.
    disturbed: bool,
    figures: ImageFigures,
    depth: StackDepth,
    /// Every second with what the host says of it.
    seconds: Vec<(MeteredCycle, Report)>,
    telemetry_identical: bool,
}

/// Records a flight, builds image and meter, and flies the recording.
fn fly(root: &Path, (name, flight): (&'static str, &Flight), folder: &Path) -> Result<Flown, HostError> {
    let (geometry, parameters) = flight.instrument()?;
    let (files, reports) = record::record_flight(flight, folder)?;
    let cargo = || {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(root);
        cargo
    };
    let tools = ["build", "--release", "-p", "cycle-meter", "-p", "stack-depth"];
    run_program(cargo().args(tools), "building the cycle meter and the stack analysis")?;
    let [meter, depth, telemetry] =
        ["cycles.json", "stack.json", "obc-telemetry.bin"].map(|name| folder.join(name));
    let arguments = [
        "run",
        "--quiet",
        "--profile",
        "flight",
        "-p",
        "obc-image",
        "--target",
        "thumbv7em-none-eabihf",
        "--",
    ];
    let output = run_program(
        cargo()
            .args(arguments)
            .args([&files.frames, &files.parameters, &telemetry])
            .env("CYCLE_METER", &meter)
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
        seconds: metered.cycles.into_iter().zip(reports).collect(),
        telemetry_identical: read(&telemetry)? == read(&files.telemetry)?,
    })
}

/// What a second is judged as, and its limit: its mode; but a second in which the whole detector is searched
/// for the Earth, or in which the orbit crosses a jump of the clock, is no second of tracking, whatever the
/// mode.
fn kind(report: &Report, stages: &BTreeMap<u8, Work>, limits: &CycleLimits) -> (&'static str, u64) {
    match report.mode {
        Mode::Acquisition => (word(report.mode), limits.acquisition),
        _ if report.events.contains(&Event::ClockJump) => ("clock-jump", limits.acquisition),
        _ if stages.contains_key(&(Stage::Search as u8)) => ("earth-search", limits.acquisition),
        mode => (word(mode), limits.tracking),
    }
}

/// The parts of a second of these stages that have limits of their own; its own limit is `limit_cycles`.
fn parts(
    stages: &BTreeMap<u8, Work>,
    limit_cycles: u64,
    limits: &CycleLimits,
) -> Vec<(&'static str, &'static [Stage], u64)> {
    let mut parts = vec![("orbit part", ORBIT, limits.orbit)];
    if limit_cycles == limits.tracking {
        parts.push(("star part", STARS, limits.stars_of_tracking));
    }
    parts.push(if stages.contains_key(&(Stage::Search as u8)) {
        ("earth search", EARTH, limits.earth_of_acquisition)
    } else {
        ("earth part", EARTH, limits.earth_of_tracking)
    });
    parts
}

/// Sorts the metered cycles by what they are judged as.
fn table(limits: &LimitsFile, wait_states: u8, flights: &[Flown], bounds: &Bounds) -> Budget {
    let mut modes = BTreeMap::new();
    let seconds = || flights.iter().flat_map(|flown| &flown.seconds);
    for (cycle, report) in seconds() {
        let (name, limit_cycles) = kind(report, &cycle.stages, &limits.cycles);
        let mode = modes.entry(name).or_insert_with(|| ModeBudget {
            seconds: 0,
            limit_cycles,
            worst_cycles: 0,
            worst_instructions: 0,
            bound_cycles: 0,
            stages: BTreeMap::new(),
            parts: BTreeMap::new(),
        });
        mode.seconds += 1;
        mode.worst_cycles = mode.worst_cycles.max(cycle.work.cycles);
        mode.bound_cycles = mode.bound_cycles.max(bounds.of_second(cycle));
        mode.worst_instructions = mode.worst_instructions.max(cycle.work.instructions);
        for (number, work) in &cycle.stages {
            let worst = mode.stages.entry(stage_name(*number)).or_insert(0);
            *worst = (*worst).max(work.cycles);
        }
        for (part, stages, limit_cycles) in parts(&cycle.stages, limit_cycles, &limits.cycles) {
            let of_part = stages.iter().filter_map(|stage| cycle.stages.get(&(*stage as u8)));
            let cycles = of_part.map(|work| work.cycles).sum::<u64>();
            if cycles > 0 {
                let part = mode.parts.entry(part).or_insert(Part { worst_cycles: 0, limit_cycles });
                part.worst_cycles = part.worst_cycles.max(cycles);
            }
        }
    }
    let dearest_scan = |flown: &Flown| {
        let of_cycle =
            |(cycle, _): &(MeteredCycle, Report)| Some(cycle.stages.get(&(Stage::Scan as u8))?.cycles);
        let cycles = flown.seconds.iter().filter_map(of_cycle).max().unwrap_or(0);
        Scan {
            cycles_per_pixel: cycles as f64
                / (f64::from(flown.geometry.width_px) * f64::from(flown.geometry.height_px)),
            limit: (!flown.disturbed).then_some(limits.cycles.scan_per_pixel),
        }
    };
    let most = |bytes: fn(&Flown) -> u64| flights.iter().map(bytes).max().unwrap_or(0);
    let painted = most(|flown| flown.figures.stack_bytes);
    let analysed = most(|flown| flown.depth.stack_bytes);
    Budget {
        target: limits.target.core.clone(),
        clock_hz: limits.target.clock_hz,
        wait_states,
        seconds: seconds().count(),
        modes,
        bounds: bounds.stages(),
        scans: flights.iter().map(|flown| (flown.name, dearest_scan(flown))).collect(),
        flash_bytes: most(|flown| flown.figures.flash_bytes),
        ram_bytes: most(|flown| flown.figures.static_ram_bytes),
        stack_bytes: painted.max(analysed),
        stack_painted_bytes: painted,
        stack_analysed_bytes: analysed,
        limits: limits.memory.clone(),
        telemetry_identical: flights.iter().all(|flown| flown.telemetry_identical),
    }
}

/// Runs the command.
///
/// # Errors
/// Outside the repository, or when building or emulating fails.
pub fn run(arguments: &BudgetArguments) -> Result<ExitCode, HostError> {
    let root = workspace()?;
    let limits = limits(&root)?;
    // The emulator takes no blanks in a file name, which a folder of the system's for such files does not
    // have.
    let folder = std::env::temp_dir().join(format!("sextant-budget-{}", std::process::id()));
    let flights = [
        (EVERY_MODE, MISSION),
        (WIDEST_LIMB, WIDE_LIMB),
        (PROTON_STORM, STORM),
        (CROWDED_FIELD, CROWD),
        ("gyro", GYRO),
    ];
    let flights = flights.iter().map(|(name, flight)| fly(&root, (name, flight), &folder));
    let flights: Result<Vec<Flown>, HostError> = flights.collect();
    let _ = std::fs::remove_dir_all(&folder);
    let mut flights = flights?;
    for (cycle, _) in flights.iter_mut().flat_map(|flown| &mut flown.seconds) {
        cycle.wait(arguments.wait_states.into());
    }
    let bounds = Bounds::new(&flights)?;
    let budget = table(&limits, arguments.wait_states, &flights, &bounds);
    if arguments.json {
        json::print_line(&budget);
    } else {
        budget.print();
    }
    Ok(if budget.kept() { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}
