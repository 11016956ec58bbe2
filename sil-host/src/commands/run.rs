//! `sil-host run`: flies a scenario and judges it.
//!
//! In: a scenario file, or the name of one that comes with the program, or nothing for the default. Out, in a
//! folder:
//!
//! | file | content |
//! |---|---|
//! | `summary.json` | the figures, the limits, and whether they were kept |
//! | `cycles.csv` | a row a second ([`crate::formats::cycles::columns`]) |
//! | `truth.oem`, `estimate.oem`, `truth.aem`, `estimate.aem` | CCSDS ephemerides ([`crate::formats::ephemerides`]) |
//! | `telemetry.bin` | the sensor's telemetry, a stream ([`fsw_core::telemetry`]) |
//! | `report.html` | plots and frames, self-contained |
//!
//! The folder belongs to the run: what an earlier one left under these names is removed first, a second run
//! at the same time is refused, and a file under way is marked as partial ([`crate::output`]). Memory grows
//! by 400 bytes a second of the run. The same scenario and seed give the same bytes in every file. Ends with
//! status 1 when a limit was missed.

pub mod bounded;

use crate::campaign::family::Family;
use crate::cli::RunArguments;
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::cycles::CyclesFile;
use crate::formats::cycles::columns::RowInputs;
use crate::formats::ephemerides::{self, Ephemerides};
use crate::formats::json;
use crate::harness::{self, Second};
use crate::judge::{Figures, Verdict};
use crate::output::{Folder, PartialFile, write_whole};
use crate::report::{Recorder, page, terminal};
use crate::scenario::{EMBEDDED, Scenario};
use crate::words::program;
use bounded::BoundedJudge;
use fsw_core::telemetry;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Where runs are put when no folder is named.
pub const FOLDER: &str = "sextant-out";

/// What `summary.json` holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The scenario's name.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Instant of the first second, TT since J2000, s.
    pub start_t_s: f64,
    /// What is flown about, as a scenario names it.
    pub body: &'static str,
    /// Whether every limit was kept.
    pub kept: bool,
    /// The limits.
    pub limits: Vec<Verdict>,
    /// The figures.
    #[serde(flatten)]
    pub figures: Figures,
}

/// The files of a run, beside its ephemerides.
const FILES: [&str; 4] = ["cycles.csv", "telemetry.bin", "summary.json", "report.html"];

/// The stream of telemetry; whole frames only are handed to the system.
struct TelemetryFile {
    file: PartialFile,
    buffer: Vec<u8>,
}

impl TelemetryFile {
    fn create(path: &Path) -> Result<Self, HostError> {
        let buffer = vec![0; telemetry::MAX_FRAME_BYTES + 2];
        Ok(Self { file: PartialFile::create(path)?, buffer })
    }

    fn add(&mut self, report: &telemetry::Report) -> Result<(), HostError> {
        let frame = telemetry::encode_next(report, &mut self.buffer).map_err(|error| {
            HostError::usage(format!("a frame cannot be made ({error:?})"), "report this")
        })?;
        self.file.keep(frame);
        Ok(())
    }
}

/// The bar on a terminal; nothing elsewhere.
fn progress(scenario: &Scenario, json: bool) -> ProgressBar {
    let shown = std::io::stderr().is_terminal() && !json;
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(scenario.duration_s.into()), target);
    let template = "{prefix} [{bar:40}] {percent:>3} %  {per_sec:.0} times real time, {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> ").with_key(
            "per_sec",
            |state: &indicatif::ProgressState, text: &mut dyn std::fmt::Write| {
                let _ = write!(text, "{:.0}", state.per_sec());
            },
        ));
    }
    bar.set_prefix(scenario.name.clone());
    bar
}

/// Flies and judges a scenario; writes the files into `folder`. The report says that `command` flies it.
///
/// # Errors
/// When the scenario cannot be flown or a file cannot be written.
pub fn fly_into(scenario: &Scenario, folder: &Path, command: &str, json: bool) -> Result<Summary, HostError> {
    let mut scene = scenario.scene()?;
    let folder = Folder::claim(folder, &[FILES, ephemerides::FILES].concat())?;
    let [cycles, frames, summary_file, report_file] = FILES.map(|name| folder.file(name));
    let mut cycles = CyclesFile::create(&cycles)?;
    let mut frames = TelemetryFile::create(&frames)?;
    let mut ephemerides = Ephemerides::create(&folder, scenario)?;
    let mut judge = BoundedJudge::new(scenario);
    let mut recorder = Recorder::new(scenario.duration_s);
    let bar = progress(scenario, json);
    harness::fly(scenario, &mut scene, |second: Second<'_>| {
        let mode_right = judge.add(&second);
        recorder.add(&second, mode_right);
        recorder.add_bound(second.cycle, judge.position_bound_km());
        frames.add(second.report)?;
        ephemerides.add(&second)?;
        if cycles.add(&RowInputs { second, mode_right })? {
            frames.file.flush()?;
            ephemerides.flush()?;
            bar.set_position(second.cycle.into());
        }
        Ok(())
    })?;
    cycles.finish()?;
    frames.file.finish()?;
    ephemerides.finish()?;
    bar.finish_and_clear();
    let figures = judge.finish();
    let limits = Verdict::all(&scenario.limits, &figures);
    let html = page::html(scenario, &recorder, (&figures, &limits), &mut scene, command)?;
    let summary = Summary {
        scenario: scenario.name.clone(),
        seed: scenario.seed,
        start_t_s: scenario.start_us as f64 * 1e-6,
        body: scenario.forces.body.name(),
        kept: limits.iter().all(|verdict| verdict.kept),
        limits,
        figures,
    };
    let text = serde_json::to_string_pretty(&summary)
        .map_err(|error| HostError::usage(format!("the summary cannot be made: {error}"), "report this"))?;
    write_whole(&report_file, html.as_bytes())?;
    write_whole(&summary_file, format!("{text}\n").as_bytes())?;
    Ok(summary)
}

/// Runs the command.
///
/// # Errors
/// When the scenario cannot be read or flown, or a file cannot be written.
pub fn run(arguments: &RunArguments) -> Result<ExitCode, HostError> {
    let named = arguments.scenario.as_deref();
    let scenario = match arguments.run {
        None => Scenario::named(named)?.with_seed(arguments.seed),
        Some(run) => {
            Family::new(named, arguments.vary.as_deref())?.member(arguments.seed.unwrap_or(1), run)?.0
        }
    };
    scenario.warn();
    let folder = arguments.out.clone().unwrap_or_else(|| Path::new(FOLDER).join(&scenario.name));
    let began = Instant::now();
    let summary = fly_into(&scenario, &folder, &command(arguments, scenario.seed), arguments.json)?;
    let took_s = began.elapsed().as_secs_f64();
    if arguments.json {
        json::print_line(&summary);
    } else {
        let Summary { figures, limits, .. } = &summary;
        let width = terminal::width();
        print_line!("{}", terminal::summary(&scenario, figures, limits, (&folder, took_s), width));
    }
    Ok(if summary.kept { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}

/// The command that makes a run again, wherever its files went.
fn command(arguments: &RunArguments, seed: u64) -> String {
    let scenario = match &arguments.scenario {
        Some(path) => path.display().to_string(),
        None => EMBEDDED[0].0.to_owned(),
    };
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    let scenario =
        if scenario.chars().all(plain) { scenario } else { format!("'{}'", scenario.replace('\'', "'\\''")) };
    format!("{} run {scenario} --seed {seed}", program())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_one_that_a_shell_reads_alike() {
        let of = |scenario: Option<&str>| {
            let scenario = scenario.map(Into::into);
            command(&RunArguments { scenario, ..RunArguments::default() }, 7)
        };
        let called = |words: &str| format!("{} run {words} --seed 7", program());
        assert_eq!(of(None), called("geo-eclipse"));
        assert_eq!(of(Some("my/leo.toml")), called("my/leo.toml"));
        assert_eq!(of(Some("it's mine.toml")), called("'it'\\''s mine.toml'"));
    }
}
