//! The flight code behind the link to its computer, as the harness flies it.
//!
//! A computer that ends in a second (its watchdog, a fault of the processor) is gone: that second has no
//! telemetry, and in the next one another begins with a sensor that knows nothing.

use crate::FamilyArguments;
use crate::link::{self, Answer, DETECTOR, RATE, Request, Second, number};
use crate::memory::Flip;
use fsw_core::sensor::{Command, Instruments};
use fsw_core::telemetry::{self, Report};
use fsw_hal::{Detector, DetectorError, Error, Instant, Magnetometer, RateSensor, Shutter, Window};
use serde::{Deserialize, Serialize};
use sil_host::error::HostError;
use sil_host::harness::FlightCode;
use std::io::{self, BufReader, BufWriter};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, ChildStdin, ChildStdout, ExitStatus, Stdio};

/// A computer that ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ended {
    /// In this second.
    pub second: u32,
    /// How: `watchdog`, or the system's word.
    pub how: String,
}

/// A computer that runs.
struct Computer {
    process: Child,
    to: BufWriter<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Computer {
    fn start(of: &FamilyArguments, (seed, run): (u64, u64)) -> io::Result<Self> {
        let mut command = std::process::Command::new(std::env::current_exe()?);
        command.arg("computer").arg(&of.scenario);
        of.vary.iter().for_each(|vary| {
            command.arg("--vary").arg(vary);
        });
        command.args(["--seed", &seed.to_string(), "--run", &run.to_string()]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        // SAFETY: system calls alone, which need no memory of this process.
        unsafe { command.pre_exec(same_each_time) };
        let mut process = command.spawn()?;
        let ends = process.stdin.take().zip(process.stdout.take());
        let (to, from) = ends.ok_or_else(|| io::Error::other("a process without a link"))?;
        Ok(Self { process, to: BufWriter::new(to), from: BufReader::new(from) })
    }

    /// How it ended. One that speaks nonsense is ended.
    fn end(mut self) -> io::Result<ExitStatus> {
        // It may have ended by itself.
        let _ = self.process.kill();
        self.process.wait()
    }
}

/// Memory at the same addresses in every process, and no core on the disk when it ends.
fn same_each_time() -> io::Result<()> {
    let none = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: the limit is a whole one. Where a call is refused the flight is flown all the same.
    unsafe {
        libc::setrlimit(libc::RLIMIT_CORE, &raw const none);
        #[cfg(target_os = "linux")]
        libc::personality(libc::ADDR_NO_RANDOMIZE as libc::c_ulong);
    }
    Ok(())
}

/// A flight code whose memory suffers.
pub struct Aboard<'f> {
    of: &'f FamilyArguments,
    /// Seed and number of the flight.
    flight: (u64, u64),
    /// What is turned over.
    pub flips: &'f [Flip],
    second: u32,
    computer: Option<Computer>,
    /// The computers that ended.
    pub ended: Vec<Ended>,
    /// The telemetry of each second, empty where there was none.
    pub frames: Vec<Vec<u8>>,
}

impl<'f> Aboard<'f> {
    /// Before the first second.
    pub fn new(of: &'f FamilyArguments, flight: (u64, u64), flips: &'f [Flip]) -> Self {
        Self { of, flight, flips, second: 0, computer: None, ended: Vec::new(), frames: Vec::new() }
    }
}

impl Drop for Aboard<'_> {
    fn drop(&mut self) {
        if let Some(computer) = self.computer.take() {
            let _ = computer.end();
        }
    }
}

fn refused(error: &io::Error) -> HostError {
    HostError::usage(format!("the computer cannot be started: {error}"), "report this")
}

/// Serves a computer through a second; its telemetry.
fn serve<D: Detector<Error = DetectorError>>(
    computer: &mut Computer,
    second: &Second,
    detector: &mut D,
) -> io::Result<Vec<u8>> {
    link::send(&mut computer.to, second)?;
    loop {
        let answer = match link::receive(&mut computer.from)? {
            Request::Start(exposure_us) => Answer::Started(of(detector.start_exposure(exposure_us))),
            Request::Finish => Answer::Finished(of(detector.finish_exposure().map(|at| at.as_us()))),
            Request::Read([x, y, width, height]) => {
                let window = Window { x, y, width, height };
                let mut pixels = vec![0; if window.fits(&detector.geometry()) { window.area() } else { 0 }];
                Answer::Pixels(of(detector.read(window, &mut pixels).map(|()| pixels)))
            }
            Request::Done(frame) => return Ok(frame),
        };
        link::send(&mut computer.to, &answer)?;
    }
}

fn of<T>(answer: Result<T, DetectorError>) -> Result<T, u8> {
    answer.map_err(|error| number(&DETECTOR, error))
}

impl FlightCode for Aboard<'_> {
    fn second<D: Detector<Error = DetectorError>, R: RateSensor, B: Magnetometer, S: Shutter>(
        &mut self,
        instruments: &mut Instruments<'_, D, Instant, (), R, B, S>,
        command: Command<'_>,
    ) -> Result<Report, HostError> {
        // No family has shutters or a magnetometer.
        let Instruments { detector, clock, rate_sensor, .. } = instruments;
        let geometry = detector.geometry();
        let reading = rate_sensor.angular_rate();
        let now = self.second;
        self.second += 1;
        let second = Second {
            flips: self.flips.iter().filter(|flip| flip.second == now).copied().collect(),
            restart: command == Command::Restart,
            geometry: (geometry.width_px, geometry.height_px, geometry.bits),
            clock: (clock.local.as_us(), clock.terrestrial_us),
            rate: reading
                .map(|read| read.map(|rate| (rate.instant.as_us(), rate.rad_s)))
                .map_err(|error| number(&RATE, error.kind())),
        };
        let mut computer = match self.computer.take() {
            Some(computer) => computer,
            None => Computer::start(self.of, self.flight).map_err(|error| refused(&error))?,
        };
        let frame = match serve(&mut computer, &second, *detector) {
            Ok(frame) => {
                self.computer = Some(computer);
                frame
            }
            Err(_) => {
                let status = computer.end().map_err(|error| refused(&error))?;
                let how = match status.signal() {
                    Some(libc::SIGPROF) => "watchdog".to_owned(),
                    _ => status.to_string(),
                };
                self.ended.push(Ended { second: now, how });
                Vec::new()
            }
        };
        // The world counts its seconds itself: a computer that began anew counts from 0.
        let told = telemetry::decode(&frame).map(|report| Report { cycle: now, ..report });
        self.frames.push(frame);
        Ok(told.unwrap_or_else(|_| Report { cycle: now, ..Report::default() }))
    }
}
