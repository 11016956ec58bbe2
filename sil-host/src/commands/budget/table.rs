//! What the metered seconds of all flights come to, beside the limits.

use super::bounds::{Bounds, StageBound};
use super::flown::{Flown, MeteredCycle, MeteredStage};
use super::limits::{CycleLimits, LimitsFile, MemoryLimits};
use crate::judge::expected::word;
use fsw_core::modes::Mode;
use fsw_core::telemetry::{Event, Report};
use fsw_hal::Stage;
use serde::Serialize;
use std::collections::BTreeMap;

/// Stages of the star part of a second that is none of acquisition.
const STARS: &[Stage] = &[Stage::Predict, Stage::Windows, Stage::Confirm];
/// Stages of the Earth part of any; its limit is another where the whole detector is searched.
const EARTH: &[Stage] = &[Stage::Limb, Stage::Centre, Stage::Search];
/// Stages of the orbit part of any.
const ORBIT: &[Stage] = &[Stage::Orbit];

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
    /// From reset to the first second: catalogue and calibration are opened, the sensor is made.
    start_cycles: u64,
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
    fn memory(&self) -> [(&'static str, u64, u64); 4] {
        [
            ("flash, bytes", self.flash_bytes, self.limits.flash_bytes),
            ("static RAM, bytes", self.ram_bytes, self.limits.static_ram_bytes),
            ("RAM and stack, bytes", self.ram_bytes + self.stack_bytes, self.limits.ram_bytes),
            ("stack, bytes", self.stack_bytes, self.limits.stack_bytes),
        ]
    }

    /// Whether every limit is kept.
    pub(super) fn kept(&self) -> bool {
        self.telemetry_identical
            && self.modes.values().all(ModeBudget::kept)
            && self.scans.values().all(Scan::kept)
            && self.bounds.values().all(StageBound::kept)
            && self.memory().iter().all(|(_, used, limit)| used <= limit)
    }

    /// Prints it for people.
    pub(super) fn print(&self) {
        print_line!(
            "{} at {} MHz, {} wait states; worst cycles of a second and of its stages",
            self.target,
            self.clock_hz / 1_000_000,
            self.wait_states
        );
        row("start", "", self.start_cycles, None);
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
            for (name, reached, cap) in bound.short_of_caps() {
                print_line!("  {stage:18} {name}: {reached} of {cap}  NOT AT ITS CAP");
            }
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

/// Name of a stage.
pub(super) fn stage_name(number: u8) -> &'static str {
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
        (Stage::Image, "image"),
    ];
    stages.iter().find(|(stage, _)| *stage as u8 == number).map_or("other", |(_, name)| name)
}

/// What a second is judged as, and its limit: its mode; but a second in which the whole detector is searched
/// for the Earth or for stars, or in which the orbit crosses a jump of the clock, is no second of tracking,
/// whatever the mode.
fn kind(report: &Report, stages: &BTreeMap<u8, MeteredStage>, limits: &CycleLimits) -> (&'static str, u64) {
    let searched = |stage: Stage| stages.contains_key(&(stage as u8));
    match report.mode {
        Mode::Acquisition => (word(report.mode), limits.acquisition),
        _ if report.events.contains(&Event::ClockJump) => ("clock-jump", limits.acquisition),
        _ if searched(Stage::Search) => ("earth-search", limits.acquisition),
        _ if searched(Stage::Scan) || searched(Stage::Streaks) => ("star-search", limits.acquisition),
        mode => (word(mode), limits.tracking),
    }
}

/// The parts of a second of these stages that have limits of their own; its own limit is `limit_cycles`.
fn parts(
    stages: &BTreeMap<u8, MeteredStage>,
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
pub(super) fn table(limits: &LimitsFile, wait_states: u8, flights: &[Flown], bounds: &Bounds) -> Budget {
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
        for (number, stage) in &cycle.stages {
            let worst = mode.stages.entry(stage_name(*number)).or_insert(0);
            *worst = (*worst).max(stage.work.cycles);
        }
        for (part, stages, limit_cycles) in parts(&cycle.stages, limit_cycles, &limits.cycles) {
            let of_part = stages.iter().filter_map(|stage| cycle.stages.get(&(*stage as u8)));
            let cycles = of_part.map(|stage| stage.work.cycles).sum::<u64>();
            if cycles > 0 {
                let part = mode.parts.entry(part).or_insert(Part { worst_cycles: 0, limit_cycles });
                part.worst_cycles = part.worst_cycles.max(cycles);
            }
        }
    }
    let dearest_scan = |flown: &Flown| {
        let of_cycle =
            |(cycle, _): &(MeteredCycle, Report)| Some(cycle.stages.get(&(Stage::Scan as u8))?.work.cycles);
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
        start_cycles: flights.iter().map(|flown| flown.start.cycles).max().unwrap_or(0),
        modes,
        bounds: bounds.stages().clone(),
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
