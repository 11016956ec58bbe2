//! The flight library on the reference on-board computer (Cortex-M4F), run in the emulator.
//!
//! In: the command line `FRAMES [TELEMETRY [LOG]]`: a frame file ([`recorded`]), the file for telemetry (default
//! `telemetry.bin`) and one for defmt frames (default: none). Out: telemetry, one line of figures on standard output
//! ([`figures`]), and the status 0 done, 1 a second could not be flown, 2 bad input or usage, 3 processor fault (the line
//! then is `{"fault_pc":ADDRESS}`).
//!
//! The image is what `cargo budget` judges: linked whole, without a single reachable panic (`panic-never` makes one a
//! link error), its size and stack measured ([`memory`]) and its cycles countable from outside ([`marks`]).
#![no_std]
#![no_main]

mod figures;
mod flight;
mod host;
mod log;
mod marks;
mod memory;
mod recorded;

use cortex_m_rt::{ExceptionFrame, entry, exception};
use figures::Figures;
use flight::Flight;
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
    /// A file to write cannot be opened or the figures cannot be printed.
    Output,
}

impl InputError {
    /// One line for people; the host's runner shows it where defmt is not decoded.
    fn text(self) -> &'static str {
        match self {
            Self::Usage => "usage: obc-image FRAMES [TELEMETRY [LOG]]\n",
            Self::Frames(FrameFileError::Unreadable) => {
                "FRAMES: cannot be read or is shorter than a header\n"
            }
            Self::Frames(FrameFileError::NotAFrameFile) => "FRAMES: offset 0: does not begin with SXTF\n",
            Self::Frames(FrameFileError::Version) => "FRAMES: offset 4: version is not 1\n",
            Self::Frames(FrameFileError::Geometry) => {
                "FRAMES: offset 6: impossible geometry or frame count\n"
            }
            Self::Output => "TELEMETRY, LOG or standard output: cannot be written\n",
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
    let (mut detector, mut telemetry) = open()?;
    let seconds = detector.frames();
    let flight = flight::fly(&mut detector, seconds, &mut telemetry);
    report(&flight)?;
    Ok(flight)
}

/// The instruments and the telemetry file that the command line names. Not inlined, nor is [`report`]: their buffers
/// would lie under the flight's stack and be measured with it.
#[inline(never)]
fn open() -> Result<(RecordedDetector, File), InputError> {
    let mut command_line = [0; host::COMMAND_LINE_BYTES];
    let mut arguments = host::arguments(&mut command_line);
    let frames = arguments.next().ok_or(InputError::Usage)?;
    let telemetry = arguments.next().unwrap_or(b"telemetry.bin");
    if let Some(name) = arguments.next() {
        log::to(File::open(name, Mode::Write)?);
    }
    Ok((RecordedDetector::open(frames)?, File::open(telemetry, Mode::Write)?))
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

/// Any fault ends the run: without a handler the emulator would spin for ever. Not told by defmt, which the fault may have
/// interrupted in the middle of a frame.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    let _ = Figures::default().number("fault_pc", frame.pc()).print();
    host::exit(STATUS_FAULT)
}
