//! The flight library on the reference on-board computer (Cortex-M4F), run in the emulator.
//!
//! In: the command line `FRAMES PARAMETERS TELEMETRY [COMMANDS REPORTS] [LOG]`: a frame file ([`recorded`]), a
//! parameter table, the file for telemetry, those of the command link ([`commands`]; default: no command) and
//! one for defmt frames (default: none); in the memory for what is sent up a table of bad pixels (default:
//! none, [`memory`]). Out: telemetry, one line of figures on
//! standard output ([`figures`]), and the status 0 done, 1 a second could not be flown, 2 bad input or usage,
//! 3 processor fault (the line then is `{"fault_pc":ADDRESS}`).
//!
//! The image is what `cargo budget` judges: linked whole, without a single reachable panic (`panic-never`
//! makes one a link error), its size and stack measured ([`memory`]) and its cycles countable from outside
//! ([`marks`]).
#![no_std]
#![no_main]

mod commands;
mod figures;
mod flight;
mod host;
mod log;
mod marks;
mod memory;
mod recorded;

// Brings the critical section of a single core.
use commands::Commands;
use cortex_m as _;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use figures::Figures;
use flight::{Flight, StartError};
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::sensor::Sensor;
use host::{File, HostError, Mode};
use panic_never as _;
use recorded::{FrameFileError, RecordedDetector};

const STATUS_DONE: u8 = 0;
const STATUS_FAILED: u8 = 1;
const STATUS_INPUT: u8 = 2;
const STATUS_FAULT: u8 = 3;

/// Why nothing was flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
enum InputError {
    /// No frame file on the command line.
    Usage,
    /// The frame file was refused.
    Frames(FrameFileError),
    /// The parameter table is unreadable, damaged or of another version.
    Parameters,
    /// The sensor refuses to start.
    Refused(StartError),
    /// A file to write cannot be opened or the figures cannot be printed.
    Output,
}

impl InputError {
    /// One line for people; the host's runner shows it where defmt is not decoded.
    fn text(self) -> &'static str {
        match self {
            Self::Usage => "usage: obc-image FRAMES PARAMETERS TELEMETRY [COMMANDS REPORTS] [LOG]\n",
            Self::Frames(FrameFileError::Unreadable) => {
                "FRAMES: cannot be read or is shorter than a header\n"
            }
            Self::Frames(FrameFileError::NotAFrameFile) => "FRAMES: offset 0: does not begin with SXTF\n",
            Self::Frames(FrameFileError::Version) => "FRAMES: offset 4: version is not 5\n",
            Self::Frames(FrameFileError::Geometry) => {
                "FRAMES: offset 6: impossible geometry or frame count\n"
            }
            Self::Parameters => "PARAMETERS: cannot be read, damaged, or of another version\n",
            Self::Refused(StartError::Parameters) => "PARAMETERS: a value is out of its range\n",
            Self::Refused(StartError::Calibration) => {
                "PARAMETERS: another calibration than the image's, which may be damaged\n"
            }
            Self::Refused(StartError::Catalogue) => "the onboard catalogue is damaged\n",
            Self::Refused(StartError::BadPixels) => "BAD_PIXELS: damaged, or of another version\n",
            Self::Refused(StartError::OtherDetector) => "BAD_PIXELS: another detector's than FRAMES\n",
            Self::Refused(StartError::FlownBefore) => "the image has flown before; start it anew\n",
            Self::Output => {
                "TELEMETRY, REPORTS, LOG or standard output: cannot be written; or COMMANDS: cannot be read\n"
            }
        }
    }
}

impl From<FrameFileError> for InputError {
    fn from(error: FrameFileError) -> Self {
        Self::Frames(error)
    }
}

impl From<HostError> for InputError {
    fn from(HostError: HostError) -> Self {
        Self::Output
    }
}

#[entry]
fn main() -> ! {
    host::exit(match run() {
        Ok(Flight { failed: 0, .. }) => STATUS_DONE,
        Ok(_) => STATUS_FAILED,
        Err(error) => {
            defmt::error!("nothing flown: {}", error);
            if let Ok(mut people) = File::open(b":tt", Mode::Append) {
                let _ = people.write(error.text().as_bytes());
            }
            STATUS_INPUT
        }
    })
}

/// Opens what the command line names, flies every frame and reports.
fn run() -> Result<Flight, InputError> {
    let (sensor, mut detector, mut telemetry, mut commands) = start()?;
    let seconds = detector.frames();
    let flight = flight::fly(sensor, &mut detector, seconds, &mut telemetry, &mut commands);
    let flight = flight.map_err(InputError::Refused)?;
    report(&flight)?;
    Ok(flight)
}

/// What flies, by the files that the command line names: the sensor, the detector, where telemetry goes and
/// where commands come from.
type Started = (&'static mut Sensor<'static>, RecordedDetector, File, Option<Commands>);

/// Starts the sensor. Not inlined, nor is [`report`]: parameters and buffers would lie under the flight's stack
/// and be measured with it.
#[inline(never)]
fn start() -> Result<Started, InputError> {
    let mut command_line = [0; host::COMMAND_LINE_BYTES];
    let mut arguments = host::arguments(&mut command_line);
    let frames = arguments.next().ok_or(InputError::Usage)?;
    let parameters = arguments.next().ok_or(InputError::Usage)?;
    let telemetry = arguments.next().ok_or(InputError::Usage)?;
    let (packets, reports, log) = match [arguments.next(), arguments.next(), arguments.next()] {
        [log, None, _] => (None, None, log),
        all => all.into(),
    };
    if let Some(name) = log {
        log::to(File::open(name, Mode::Write)?);
    }
    let commands = match packets.zip(reports) {
        Some((packets, reports)) => Some(Commands::open(packets, reports)?),
        None => None,
    };
    let mut table = [0; MAX_TABLE_BYTES];
    let length = File::open(parameters, Mode::Read).and_then(|mut file| file.read_some(&mut table));
    let table = table.get(..length.map_err(|HostError| InputError::Parameters)?).unwrap_or(&[]);
    let parameters = Parameters::decode(table).map_err(|_| InputError::Parameters)?;
    let (detector, telemetry) = (RecordedDetector::open(frames)?, File::open(telemetry, Mode::Write)?);
    let sensor = flight::sensor(parameters).map_err(InputError::Refused)?;
    Ok((sensor, detector, telemetry, commands))
}

/// Measures the memory and prints the figures.
#[inline(never)]
fn report(flight: &Flight) -> Result<(), InputError> {
    let memory = memory::measure();
    defmt::info!("{} seconds, {} failed, stack {} bytes", flight.seconds, flight.failed, memory.stack_bytes);
    Figures::default()
        .number("seconds", flight.seconds)
        .number("failed", flight.failed)
        .number("stack_bytes", memory.stack_bytes)
        .number("stack_room_bytes", memory.stack_room_bytes)
        .number("static_ram_bytes", memory.static_ram_bytes)
        .number("flash_bytes", memory.flash_bytes)
        .print()?;
    Ok(())
}

/// Any fault ends the run: without a handler the emulator would spin for ever. Not told by defmt, which the
/// fault may have interrupted in the middle of a frame.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    let _ = Figures::default().number("fault_pc", frame.pc()).print();
    host::exit(STATUS_FAULT)
}
