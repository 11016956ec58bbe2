//! The words of the command line.
//!
//! In: the arguments of the process. Out: [`CommandLine`], or one line on stderr and exit status 2. Help and
//! version go to stdout with status 0.

mod campaign;
mod flights;
mod gallery;
mod installed;
mod orbits;
mod pictures;

pub use campaign::*;
pub use flights::*;
pub use gallery::*;
pub use installed::*;
pub use orbits::*;
pub use pictures::*;

use crate::error::HostError;
use crate::formats::camera_file;
use crate::words::{name, nearest, one_line, program};
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;

/// Software in the loop for the Sextant Earth and star sensor.
///
/// Without a subcommand the default scenario is flown: six hours in GEO around an eclipse.
#[derive(Debug, Parser)]
#[command(name = "sil-host", version, about, disable_help_subcommand = true)]
pub struct CommandLine {
    /// What to do; nothing asks for the default scenario.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly a scenario, judge it, write summary, cycles, telemetry and report
    Run(RunArguments),
    /// A page on this machine that flies a scenario live, with faults by button, and shows recorded runs
    Serve(ServeArguments),
    /// The frame the detector would show in a second of a scenario
    Render(RenderArguments),
    /// Attitude from real pictures, without prior knowledge; with neither --camera nor --fov-deg fields of
    /// 5 to 40 deg are tried
    #[command(after_long_help = camera_file::HELP)]
    Solve(SolveArguments),
    /// Earth vector and distance from real pictures of the Earth, without prior knowledge
    #[command(after_long_help = camera_file::HELP)]
    Earth(EarthArguments),
    /// Identification of centroid lists, one field a line
    #[command(after_help = crate::commands::identify::LINES)]
    #[command(after_long_help = format!("{}\n\n{}", crate::commands::identify::LINES, camera_file::HELP))]
    Identify(IdentifyArguments),
    /// Attitude from lists of vector pairs, by any of eight methods; or the methods compared (--table)
    #[command(after_help = crate::commands::attitude::methods::LINES)]
    Attitude(AttitudeArguments),
    /// The orbit filter on measurements of the Earth's direction and distance, beside their information bound
    Navigate(NavigateArguments),
    /// A state carried on by the dynamics that fly
    Propagate(PropagateArguments),
    /// What the sensor will be able to do along an orbit, and how long: Sun in a path, eclipse
    Outages(OutagesArguments),
    /// Focal length, optical centre, distortion, star profiles and corrections of a lens from its sky
    /// pictures
    #[command(after_long_help = camera_file::HELP)]
    Calibrate(CalibrateArguments),
    /// Bad pixels and columns' offsets of a detector, from dark pictures, for the flight code
    Defects(DefectsArguments),
    /// Many seeded runs of one thing, judged together
    Campaign(Box<CampaignArguments>),
    /// The thesis's figures and tables: ours over the thesis's numbers, where they differ and why
    Gallery(GalleryArguments),
    /// Frames, parameters and telemetry for the emulated computer
    Record(RecordArguments),
    /// Centroid errors by magnitude, beside the Cramer-Rao bound
    Centroids(CentroidsArguments),
    /// Cycles, flash, RAM and stack of the flight image in the emulator, against their limits
    Budget(BudgetArguments),
    /// All parameters of the flight code: unit, range, default, source (the page fsw-core/PARAMETERS.md)
    Parameters(ReferenceArguments),
    /// The modes of the flight code and what leads from one to another (the page fsw-core/MODES.md)
    Modes(ModesArguments),
    /// All columns of cycles.csv: unit, frame, meaning (the page sil-host/CYCLES.md)
    Columns(ReferenceArguments),
    /// All telecommands that the flight code obeys: service, fields, refusals (the page
    /// fsw-core/TELECOMMANDS.md)
    Telecommands(ReferenceArguments),
    /// The layout of the telemetry frames, for a ground system in any language (the page
    /// fsw-core/TELEMETRY.md)
    Telemetry(TelemetryArguments),
    /// Telemetry frames as they left a sensor, in words or as JSON
    Decode(DecodeArguments),
    /// Completions for a shell, of the installed program `sextant`
    Completions(CompletionsArguments),
    /// Manual pages of the installed program `sextant`, into a folder
    Man(ManArguments),
}

/// What the arguments ask for.
#[derive(Debug)]
pub enum Request {
    /// Do this.
    Run(CommandLine),
    /// Print this on stdout and end well (help, version).
    Print(String),
}

/// Reads the arguments, the program's name first.
///
/// # Errors
/// [`HostError::Usage`] when they make no sense, in one line.
pub fn parse<I, T>(arguments: I) -> Result<Request, HostError>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString>,
{
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let matches = signed(CommandLine::command()).name(name()).try_get_matches_from(&arguments);
    match matches.and_then(|matches| CommandLine::from_arg_matches(&matches)) {
        Ok(command_line) => Ok(Request::Run(command_line)),
        Err(error) if !error.use_stderr() => Ok(Request::Print(error.render().to_string())),
        Err(error) => {
            let (words, alike) = subcommands(&arguments);
            let to_do = format!("see `{}{words} --help`", program());
            let mut what = complaint(&error.render().to_string());
            if let Some(alike) = alike.filter(|alike| !what.contains(alike.as_str())) {
                what += &format!(" (a similar subcommand exists: '{alike}')");
            }
            Err(HostError::usage(what, to_do))
        }
    }
}

/// A command whose options take numbers with a minus, so that their ranges refuse them and not the parser.
fn signed(command: clap::Command) -> clap::Command {
    let option = |argument: Arg| {
        let number = argument.get_action().takes_values() && !argument.is_positional();
        if number { argument.allow_negative_numbers(true) } else { argument }
    };
    command.mut_args(option).mut_subcommands(signed)
}

/// The subcommands that arguments begin with, behind the program's name, each after a blank; and the one that
/// the next argument is like.
fn subcommands(arguments: &[OsString]) -> (String, Option<String>) {
    let mut command = CommandLine::command();
    let mut words = String::new();
    for argument in arguments.iter().skip(1) {
        let Some(found) = command.find_subcommand(argument).cloned() else {
            let names = command.get_subcommands().map(clap::Command::get_name);
            return (words, nearest(&argument.to_string_lossy(), names).map(str::to_owned));
        };
        words.extend([" ", found.get_name()]);
        command = found;
    }
    (words, None)
}

/// The parser's complaint without its usage lines, which would make it longer than a line; with the name that
/// a misspelt one is like.
fn complaint(text: &str) -> String {
    let mut paragraphs = text.split("\n\n");
    let first = paragraphs.next().unwrap_or(text);
    let first = one_line(first.strip_prefix("error: ").unwrap_or(first));
    let first = first.replace("invalid digit found in string", "no whole number from 0 on");
    let alike = paragraphs.next().and_then(|tip| tip.trim().strip_prefix("tip: "));
    match alike.filter(|tip| tip.contains("similar")) {
        Some(tip) => format!("{first} ({})", one_line(tip)),
        None => first,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn usage(arguments: &[&str]) -> String {
        parse(arguments).expect_err("must be refused").to_string()
    }

    #[test]
    fn no_subcommand_asks_for_the_default_scenario() {
        assert!(matches!(parse(["sil-host"]), Ok(Request::Run(CommandLine { command: None }))));
    }

    #[test]
    fn solve_takes_several_pictures_and_one_description_of_the_optics() {
        let Ok(Request::Run(CommandLine { command: Some(Command::Solve(solve)) })) =
            parse(["sil-host", "solve", "a.png", "b.fits", "--fov-deg", "15.5", "--json"])
        else {
            panic!("not understood")
        };
        assert_eq!((solve.images.len(), solve.optics.fov_deg, solve.json), (2, Some(15.5), true));
        assert!(parse(["sil-host", "solve", "a.png"]).is_ok(), "then all fields are tried");
        assert!(usage(&["sil-host", "solve", "a.png", "--catalog", "c"]).contains("--camera"));
        assert!(
            usage(&["sil-host", "solve", "a.png", "--camera", "c", "--fov-deg", "3"]).contains("--fov-deg")
        );
        assert!(usage(&["sil-host", "solve", "--fov-deg", "3"]).contains("IMAGE"));
    }

    #[test]
    fn earth_takes_directions_with_signs() {
        let Ok(Request::Run(CommandLine { command: Some(Command::Earth(earth)) })) = parse([
            "sil-host",
            "earth",
            "a.png",
            "b.png",
            "--camera",
            "c",
            "--pole",
            "0,-1,0",
            "--sun",
            "-0.5, 0.1,1e-2",
        ]) else {
            panic!("not understood")
        };
        assert_eq!((earth.images.len(), earth.pole), (2, Some([0.0, -1.0, 0.0])));
        assert_eq!(earth.sun, Some([-0.5, 0.1, 0.01]));
        assert!(usage(&["sil-host", "earth", "a.png", "--camera", "c", "--pole", "0,0"]).contains("--pole"));
    }

    #[test]
    fn a_usage_error_is_one_line_and_help_is_none() {
        let message = usage(&["sil-host", "identify"]);
        assert!(message.starts_with("sil-host: ") && !message.contains('\n'), "{message}");
        assert!(message.ends_with(" identify --help`"), "{message}");
        assert!(usage(&["sil-host", "campaign", "run", "--runs", "0"]).ends_with(" campaign run --help`"));
        assert!(usage(&["sil-host", "fly"]).contains("fly"));
        assert!(matches!(parse(["sil-host", "--help"]), Ok(Request::Print(_))));
        assert!(matches!(parse(["sil-host", "--version"]), Ok(Request::Print(_))));
    }

    #[test]
    fn a_negative_number_reaches_the_range_and_a_misspelt_word_is_told_its_neighbour() {
        for (arguments, words) in [
            (&["run", "--seed", "-1"][..], "no whole number from 0 on"),
            (&["render", "geo-day", "--cycle", "-1", "--out", "a.png"], "-1 is not in 0..=4294967295"),
            (&["outages", "geo-day", "--duration-s", "-600"], "--duration-s"),
            (&["calibrate", "a.png", "--full-well-e", "-5", "--out", "a.toml"], "give 1 to"),
            (&["calibrate", "a.png", "--full-well-e", "nan", "--out", "a.toml"], "give 1 to"),
            (&["campain"], "'campaign'"),
            (&["campaign", "idnetify"], "'identify'"),
        ] {
            let message = usage(&[&["sil-host"], arguments].concat());
            assert!(message.contains(words) && !message.contains("unexpected"), "{message}");
        }
    }

    #[test]
    fn a_campaign_takes_a_scenario_in_the_place_of_a_kind() {
        let Ok(Request::Run(CommandLine { command: Some(Command::Campaign(campaign)) })) = parse([
            "sil-host", "campaign", "geo-day", "--runs", "3", "--first", "4", "--jobs", "2", "--out", "d",
        ]) else {
            panic!("not understood")
        };
        let run = campaign.scenario.unwrap().as_run();
        assert!(campaign.of.is_none() && run.scenario.as_deref() == Some("geo-day".as_ref()));
        assert_eq!((run.runs, run.common.first, run.common.jobs), (3, 4, Some(2)));
        assert_eq!(run.common.out.as_deref(), Some("d/flights.jsonl".as_ref()));
        assert!(usage(&["sil-host", "campaign"]).contains("SCENARIO.toml"));
        assert!(usage(&["sil-host", "campaign", "geo-day"]).contains("--out"));
    }

    fn help(arguments: &[&str]) -> String {
        match parse(arguments) {
            Ok(Request::Print(text)) => text,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_long_help_describes_lines_of_fields_camera_files_and_corrections() {
        for command in ["solve", "earth", "identify", "calibrate"] {
            let help = help(&["sil-host", command, "--help"]);
            for word in ["[optics]", "optical_centre_px", "correction_table", "equiangular"] {
                assert!(help.contains(word), "{command}: {word} is not in {help}");
            }
        }
        for flag in ["-h", "--help"] {
            let help = help(&["sil-host", "identify", flag]);
            assert!(help.contains("\"centroids\":[[x,y]") && help.contains("brightness"), "{help}");
        }
    }
}
