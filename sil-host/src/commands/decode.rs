//! `sil-host decode`: telemetry frames as they left a sensor, read.
//!
//! In: a stream of frames ([`telemetry`]), from a file or standard input. Out: with `--json` a report a line,
//! its fields as the page `fsw-core/TELEMETRY.md` lists them; else a line of words; each as soon as its frame
//! has come. A frame of another version and bytes that are damaged are named on stderr, left out, and make
//! the status 2; the frames behind them are read ([`crate::formats::telemetry_stream`]).

use crate::cli::DecodeArguments;
use crate::error::{Faults, HostError};
use crate::formats::json;
use crate::formats::telemetry_stream::{Piece, TelemetryStream};
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
/// Where the stream cannot be read or holds nothing.
pub fn run(arguments: &DecodeArguments) -> Result<ExitCode, HostError> {
    let DecodeArguments { stream: path, json } = arguments;
    let refused = |error: io::Error| HostError::system(path, "read", &error, "check the path");
    let source: Box<dyn Read> = if path == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        Box::new(File::open(path).map_err(refused)?)
    };
    let mut stream = TelemetryStream::new(source);
    let (mut faults, mut empty) = (Faults::default(), true);
    while let Some((at, piece)) = stream.piece().map_err(refused)? {
        empty = false;
        let (what, to_do) = match piece {
            Piece::Frame(_, Ok(report)) if *json => {
                json::print_line(&report);
                continue;
            }
            Piece::Frame(_, Ok(report)) => {
                print_line!("{}", words(&report));
                continue;
            }
            Piece::Frame(bytes, Err(error)) => (
                format!("a frame of {bytes} bytes: {}", reason(error)),
                "left out; the others are read".into(),
            ),
            Piece::Skipped(bytes) => (
                format!("{bytes} bytes are damaged and skipped (no frame whose checksum matches)"),
                "the frames behind them are read".into(),
            ),
            Piece::Rest(bytes) => {
                (format!("the stream breaks off: its last {bytes} bytes hold no whole frame"), to_do())
            }
        };
        faults.noted::<()>(Err(HostError::input(path, None, format!("byte {at}: {what}"), to_do)));
    }
    if empty {
        return Err(HostError::input(path, None, "it is empty: it holds no frame", to_do()));
    }
    Ok(faults.status())
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
