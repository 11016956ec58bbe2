//! `sil-host decode`: telemetry frames as they left a sensor, read.
//!
//! In: a stream of frames ([`telemetry`]), from a file or standard input. Out: with `--json` a report a line,
//! its fields as the page `fsw-core/TELEMETRY.md` lists them; else a line of words. A frame that is broken or
//! of another version is named on stderr, left out, and makes the status 2.

use crate::cli::DecodeArguments;
use crate::error::{EXIT_BAD_INPUT, HostError};
use crate::formats::json;
use crate::words::program;
use fsw_core::packet::PacketError;
use fsw_core::telemetry::{self, Report};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::process::ExitCode;

/// What a stream is.
fn to_do() -> String {
    format!("give a stream of frames, each led by its length: `{} telemetry`", program())
}

/// Does what the command line asks for.
///
/// # Errors
/// Where the stream cannot be read, holds nothing, or breaks off; behind the frames before.
pub fn run(arguments: &DecodeArguments) -> Result<ExitCode, HostError> {
    let DecodeArguments { stream: path, json } = arguments;
    let mut stream = Vec::new();
    let read = if path == Path::new("-") {
        io::stdin().lock().read_to_end(&mut stream)
    } else {
        File::open(path).and_then(|mut file| file.read_to_end(&mut stream))
    };
    read.map_err(|error| HostError::system(path, "read", &error, "check the path"))?;
    if stream.is_empty() {
        return Err(HostError::input(path, None, "it is empty: it holds no frame", to_do()));
    }
    let mut status = ExitCode::SUCCESS;
    let mut rest = &stream[..];
    while !rest.is_empty() {
        let at = stream.len() - rest.len();
        let Some((frame, behind)) = telemetry::split_first(rest) else {
            let what = format!("byte {at}: the stream breaks off within a frame");
            return Err(HostError::input(path, None, what, to_do()));
        };
        rest = behind;
        match telemetry::decode(frame) {
            Ok(report) if *json => json::print_line(&report),
            Ok(report) => print_line!("{}", words(&report)),
            Err(error) => {
                let what = format!("byte {at}: a frame of {} bytes: {}", frame.len(), reason(error));
                eprintln!("{}", HostError::input(path, None, what, "left out; the others are read"));
                status = ExitCode::from(EXIT_BAD_INPUT);
            }
        }
    }
    Ok(status)
}

/// Why a frame is not read.
fn reason(error: PacketError) -> String {
    match error {
        PacketError::Version(found) => {
            format!("version {found} of the layout, this program reads {}", telemetry::VERSION)
        }
        PacketError::Content => "it is whole, but no report".into(),
        PacketError::Checksum | PacketError::Buffer => "its checksum does not match".into(),
    }
}

/// A report in a line.
fn words(report: &Report) -> String {
    let mut line = format!("{}: {:?}, {:?}", report.cycle, report.mode, report.activity);
    if let Some(outcome) = report.outcome {
        line += &format!(", {outcome:?}");
    }
    if let Some(attitude) = report.attitude {
        let sigma = attitude.sigma_rad.iter().fold(0.0, |most: f64, sigma| most.max(f64::from(*sigma)));
        let [x, y, z, w] = attitude.quaternion;
        line += &format!(
            "; attitude {x:.6}, {y:.6}, {z:.6}, {w:.6} to {:.1} arcsec",
            sigma.to_degrees() * 3600.0
        );
    }
    if let Some(orbit) = report.orbit {
        let ([x, y, z], sigma) = (orbit.position_km, orbit.sigma_hill_km);
        let sigma = sigma.iter().map(|sigma| sigma * sigma).sum::<f32>().sqrt();
        line += &format!("; position {x:.1}, {y:.1}, {z:.1} km to {sigma:.1}");
    }
    if report.faults != telemetry::Faults::default() {
        line += &format!("; {:?}", report.faults);
    }
    for event in &report.events {
        line += &format!("; {event:?}");
    }
    line
}
