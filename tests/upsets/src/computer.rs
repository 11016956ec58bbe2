//! The on-board computer: a process that holds a sensor and flies a second for each message.
//!
//! In, on standard input: [`Second`]s and [`Answer`]s. Out, on standard output: [`Request`]s. It begins with
//! a sensor that knows nothing, made of the scenario's tables, as after power-on or after its watchdog has
//! ended it. The watchdog is the system's: a second that takes more than [`WATCHDOG_S`] of processor time
//! ends the process.

use crate::ComputerArguments;
use crate::link::{self, Answer, DETECTOR, RATE, Request, Second, kind};
use crate::memory::{Flip, Part, STATE_BYTES, WORKSPACE_BYTES};
use fsw_core::sensor::{Command, Instruments, Sensor, Workspace};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES};
use fsw_hal::{AngularRate, Detector, DetectorError, DetectorGeometry, Instant, LocalTime};
use fsw_hal::{RateSensor, ReadingError, Window};
use sil_host::error::HostError;
use sil_host::harness;
use std::io::{BufReader, BufWriter, Stdin, Stdout, stdin, stdout};

/// Processor time that a second may take, s: the slowest of this machine takes a hundredth of it.
const WATCHDOG_S: i64 = 2;

/// The link to the world.
struct Link {
    from: BufReader<Stdin>,
    to: BufWriter<Stdout>,
}

impl Link {
    /// Asks the world; without an answer there is nothing left to fly in.
    fn ask(&mut self, request: &Request) -> Answer {
        let answer = link::send(&mut self.to, request).and_then(|()| link::receive(&mut self.from));
        answer.unwrap_or_else(|_| std::process::exit(0))
    }
}

/// The detector of a second, behind the link.
struct Linked<'l> {
    link: &'l mut Link,
    geometry: DetectorGeometry,
}

impl fsw_hal::ErrorType for Linked<'_> {
    type Error = DetectorError;
}

impl Detector for Linked<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        match self.link.ask(&Request::Start(exposure_us)) {
            Answer::Started(done) => done.map_err(|number| kind(&DETECTOR, number)),
            _ => Err(DetectorError::Bus),
        }
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        match self.link.ask(&Request::Finish) {
            Answer::Finished(done) => done.map(LocalTime::from_us).map_err(|number| kind(&DETECTOR, number)),
            _ => Err(DetectorError::Bus),
        }
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let Window { x, y, width, height } = window;
        let Answer::Pixels(read) = self.link.ask(&Request::Read([x, y, width, height])) else {
            return Err(DetectorError::Bus);
        };
        let read = read.map_err(|number| kind(&DETECTOR, number))?;
        if read.len() != pixels.len() {
            return Err(DetectorError::BufferLength);
        }
        pixels.copy_from_slice(&read);
        Ok(())
    }
}

/// What the rate sensor reads in a second.
struct Reading(Result<Option<AngularRate>, ReadingError>);

impl fsw_hal::ErrorType for Reading {
    type Error = ReadingError;
}

impl RateSensor for Reading {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, ReadingError> {
        self.0
    }
}

/// The sensor and its workspace, held by plain pointers, as whoever turns its bits over does.
struct Memory {
    state: *mut Sensor<'static>,
    workspace: *mut Workspace,
}

impl Memory {
    fn turn_over(&mut self, flip: &Flip) {
        let (part, bytes) = match flip.part {
            Part::State => (self.state.cast::<u8>(), STATE_BYTES),
            Part::Workspace => (self.workspace.cast::<u8>(), WORKSPACE_BYTES),
        };
        assert!(flip.byte < bytes && flip.bit < 8);
        // SAFETY: the byte is one of the part. That its new value is one of its type nobody can promise: that
        // is what is flown here.
        unsafe {
            let byte = part.add(flip.byte);
            byte.write_volatile(byte.read_volatile() ^ 1 << flip.bit);
        }
    }

    /// Flies a second; its telemetry frame.
    fn fly(&mut self, link: &mut Link, second: &Second) -> Vec<u8> {
        let (width_px, height_px, bits) = second.geometry;
        let geometry = DetectorGeometry { width_px, height_px, bits };
        let (local_us, terrestrial_us) = second.clock;
        let reading = |(us, rad_s)| AngularRate { instant: LocalTime::from_us(us), rad_s };
        let rate = second.rate.map(|read| read.map(reading)).map_err(|number| kind(&RATE, number));
        let mut instruments = Instruments {
            detector: &mut Linked { link, geometry },
            clock: &mut Instant { local: LocalTime::from_us(local_us), terrestrial_us },
            meter: &mut (),
            rate_sensor: &mut Reading(rate),
            magnetometer: &mut (),
            shutter: &mut (),
        };
        let command = if second.restart { Command::Restart } else { Command::Continue };
        // SAFETY: a sensor was written there; of its bits see `turn_over`.
        let report = unsafe { &mut *self.state }.cycle(&mut instruments, command);
        let mut frame = [0; MAX_FRAME_BYTES];
        telemetry::encode(&report, &mut frame).map_or(Vec::new(), <[u8]>::to_vec)
    }
}

/// Lets the system end this process after so much more processor time; 0: not at all.
fn watch(seconds: i64) {
    let zero = libc::timeval { tv_sec: 0, tv_usec: 0 };
    let timer =
        libc::itimerval { it_interval: zero, it_value: libc::timeval { tv_sec: seconds, tv_usec: 0 } };
    // SAFETY: the timer is a whole one, and no old one is asked for.
    let set = unsafe { libc::setitimer(libc::ITIMER_PROF, &raw const timer, std::ptr::null_mut()) };
    assert_eq!(set, 0, "the watchdog can be set");
}

/// Is the computer of a flight until the world ends.
///
/// # Errors
/// When the scenario cannot be read or flown.
pub fn run(arguments: &ComputerArguments) -> Result<(), HostError> {
    let (scenario, _) = arguments.of.family()?.member(arguments.seed, arguments.run)?;
    let (catalogue, calibration) = harness::tables(&scenario)?;
    let workspace = Box::into_raw(Box::new(Workspace::new()));
    // SAFETY: a whole workspace that lasts; the sensor alone refers to it.
    let lent = unsafe { &mut *workspace };
    let calibration = Box::leak(Box::new(calibration)).as_ref();
    let state = Box::into_raw(Box::new(harness::sensor(&scenario, catalogue, calibration, lent)?));
    let mut memory = Memory { state, workspace };
    let mut link = Link { from: BufReader::new(stdin()), to: BufWriter::new(stdout()) };
    while let Ok(second) = link::receive::<Second>(&mut link.from) {
        second.flips.iter().for_each(|flip| memory.turn_over(flip));
        watch(WATCHDOG_S);
        let frame = memory.fly(&mut link, &second);
        watch(0);
        if link::send(&mut link.to, &Request::Done(frame)).is_err() {
            break;
        }
    }
    Ok(())
}
