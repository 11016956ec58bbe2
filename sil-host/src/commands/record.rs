//! `sil-host record`: what the emulated computer is to fly, and what the host makes of it.
//!
//! In: a picture and its field of view, or nothing for the [`mission`]. Out, in a folder:
//!
//! | file | content |
//! |---|---|
//! | `frames.bin` | a frame a second with what gyro and magnetometer read ([`crate::formats::frames_file`]) |
//! | `parameters.bin` | the parameter table for them ([`fsw_core::parameters`]) |
//! | `bad-pixels.bin` | the detector's defects as they are known on board ([`crate::formats::defects_file`]) |
//! | `telemetry.bin` | the host's telemetry for these frames, a stream ([`fsw_core::telemetry`]) |
//! | `commands.bin` | what the [`ground`] sends meanwhile, where it sends anything |
//!
//! A picture is shown every second anew. Its focal length is refined first, as `solve` does, because the
//! flight code is made for a calibrated camera; catalogue and calibration are those in the flight image.

pub mod ground;
pub mod mission;

use crate::cli::RecordArguments;
use crate::commands::picture_camera::PictureCamera;
use crate::commands::solve::PictureSolver;
use crate::error::HostError;
use crate::flight;
use crate::formats::defects_file;
use crate::formats::frames_file::{FramesWriter, Readings, Recording};
use crate::formats::picture::Picture;
use crate::harness::corrected;
use crate::harness::status::status_word;
use crate::judge::expected::word;
use crate::output::write_whole;
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::sensor::{Command, Instruments, Sensor};
use fsw_core::stars::identify::IdentificationParameters;
use fsw_core::telemetry::{self, Report};
use fsw_hal::{Detector, DetectorGeometry, Instant, LocalTime};
use ground::Ground;
use mission::Flight;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Relative error that a refined focal length of an uncalibrated lens leaves in a separation.
const SCALE_UNCERTAINTY: f32 = 0.001;

/// The instrument that was recorded, as it is known on board.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    /// Its detector.
    pub geometry: DetectorGeometry,
    /// The parameter table for it.
    pub parameters: Parameters,
    /// The file of its detector's defects.
    pub defects: Vec<u8>,
}

/// The files of a recording.
#[derive(Clone, Debug)]
pub struct RecordingFiles {
    /// Frames.
    pub frames: PathBuf,
    /// Parameter table.
    pub parameters: PathBuf,
    /// Defects of the detector.
    pub bad_pixels: PathBuf,
    /// The host's telemetry.
    pub telemetry: PathBuf,
    /// What the ground sends.
    pub commands: PathBuf,
}

impl RecordingFiles {
    /// The files in a folder.
    pub fn within(folder: &Path) -> Self {
        let file = |name| folder.join(name);
        Self {
            frames: file("frames.bin"),
            parameters: file("parameters.bin"),
            bad_pixels: file("bad-pixels.bin"),
            telemetry: file("telemetry.bin"),
            commands: file("commands.bin"),
        }
    }
}

/// A recorded second of a sensor, with what was read beside the detector.
///
/// # Errors
/// When the file of defects is damaged.
pub fn fly_second(
    sensor: &mut Sensor,
    (recording, defects): (&mut Recording, &[u8]),
    second: usize,
    command: Command,
) -> Result<Report, HostError> {
    let clock = &mut recording.turn_to(second);
    let (mut rate_sensor, mut magnetometer) = recording.beside();
    let mut instruments = Instruments {
        detector: &mut corrected(recording, defects)?,
        clock,
        meter: &mut (),
        rate_sensor: &mut rate_sensor,
        magnetometer: &mut magnetometer,
        shutter: &mut (),
    };
    Ok(sensor.cycle(&mut instruments, command))
}

/// Records the frames that `draw` writes, the table, what the ground sends, and the host's telemetry, into a
/// folder that exists or is made.
///
/// # Errors
/// When a file cannot be written.
pub fn record(
    instrument: &Instrument,
    ground: &Ground,
    folder: &Path,
    draw: impl FnOnce(&mut FramesWriter) -> Result<(), HostError>,
) -> Result<(RecordingFiles, Vec<Report>), HostError> {
    std::fs::create_dir_all(folder)
        .map_err(|error| HostError::system(folder, "made", &error, "give another folder"))?;
    let files = RecordingFiles::within(folder);
    let mut writer = FramesWriter::create(&files.frames, instrument.geometry)?;
    draw(&mut writer)?;
    writer.finish()?;
    let mut table = [0; MAX_TABLE_BYTES];
    write_whole(&files.parameters, instrument.parameters.encode(&mut table).map_err(encoding_fault)?)?;
    write_whole(&files.bad_pixels, &instrument.defects)?;
    if !ground.packets.is_empty() {
        write_whole(&files.commands, &ground.file())?;
    }
    let (reports, _) = ground::fly(&mut Recording::load(&files.frames)?, instrument, ground)?;
    let mut stream = Vec::new();
    let mut buffer = [0; telemetry::MAX_FRAME_BYTES];
    for report in &reports {
        stream.extend_from_slice(telemetry::encode_next(report, &mut buffer).map_err(encoding_fault)?);
    }
    write_whole(&files.telemetry, &stream)?;
    Ok((files, reports))
}

/// Records a flight.
///
/// # Errors
/// When its clips need different instruments, or a file cannot be written.
pub fn record_flight(flight: &Flight, folder: &Path) -> Result<(RecordingFiles, Vec<Report>), HostError> {
    record(&flight.instrument()?, &flight.ground()?, folder, |writer| flight.draw(writer))
}

/// Records a picture, shown every second anew.
fn record_picture(
    picture: &mut Picture,
    parameters: Parameters,
    seconds: u32,
    folder: &Path,
) -> Result<(RecordingFiles, Vec<Report>), HostError> {
    let geometry = picture.geometry();
    let defects = defects_file::table([geometry.width_px, geometry.height_px], &[], &[]);
    record(&Instrument { geometry, parameters, defects }, &Ground::default(), folder, |writer| {
        for second in 0..seconds {
            let us = i64::from(second) * 1_000_000;
            let instant = Instant::new(LocalTime::from_us(us), us);
            picture.renew_noise(second);
            writer.record(picture, (instant, Readings::default()), parameters.imaging.exposure_us)?;
        }
        Ok(())
    })
}

fn encoding_fault(error: fsw_core::packet::PacketError) -> HostError {
    HostError::usage(format!("a packet cannot be made ({error:?})"), "report this")
}

/// The picture and the parameters for its camera, its focal length refined.
fn picture(name: &Path, fov_deg: f64) -> Result<(Picture, Parameters), HostError> {
    let mut picture = Picture::load(name)?;
    let (camera, focal_length) = PictureCamera::FieldDeg(fov_deg).flight(name, &picture)?;
    let bytes = flight::catalogue_bytes(&camera, flight::Density::Brightest)?;
    let catalogue = flight::open(&bytes)?;
    let found = PictureSolver::default().find(name, &mut picture, (&camera, focal_length), &catalogue)?;
    let solution = found.solution.map_err(|reason| {
        HostError::input(name, None, format!("not identified ({reason})"), "give another picture")
    })?;
    let parameters = Parameters::for_camera(*solution.camera.parameters());
    let identification = IdentificationParameters {
        scale_uncertainty: SCALE_UNCERTAINTY,
        ..IdentificationParameters::default()
    };
    Ok((picture, Parameters { identification, ..parameters }))
}

/// Runs the command.
///
/// # Errors
/// When the picture cannot be used or a file cannot be written.
pub fn run(arguments: &RecordArguments) -> Result<ExitCode, HostError> {
    let (files, reports) = match (&arguments.image, arguments.fov_deg) {
        (Some(name), Some(fov_deg)) => {
            let (mut picture, parameters) = picture(name, fov_deg)?;
            record_picture(&mut picture, parameters, arguments.seconds, &arguments.out)?
        }
        _ => record_flight(&mission::MISSION, &arguments.out)?,
    };
    for report in &reports {
        print_line!(
            "second {}: {}, {}, {} stars named, Earth {:?}",
            report.cycle,
            word(report.mode),
            status_word(report),
            report.stars.len(),
            report.earth_status
        );
    }
    print_line!(
        "fly it: cargo obc -- {} {} obc-telemetry.bin",
        files.frames.display(),
        files.parameters.display()
    );
    print_line!("then compare obc-telemetry.bin with {}", files.telemetry.display());
    Ok(ExitCode::SUCCESS)
}
