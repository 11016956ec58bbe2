//! Faults of detector, clock and gyro, injected through their own traits, and restarts.
//!
//! In: any [`Detector`], any clock's reading, the [`Fault`]s of a scenario, a second. Out: the same, broken
//! as the scenario says. The flight code cannot distinguish a fault from the real thing, and the world knows
//! nothing of it. What happens is a pure function of (seed, second, pixel), like the frames themselves: a
//! window read twice has the same faults.
//!
//! | kind | what the sensor meets |
//! |---|---|
//! | `time-out` | the exposure is not acknowledged: [`DetectorError::Timeout`] |
//! | `dropped-window` | a readout breaks off: [`DetectorError::Bus`] |
//! | `late-frame` | the exposure is not made, and the image before it is handed out with the instant of a new one |
//! | `doubled-image` | the exposure is not made, and the image before it is handed out with its own instant |
//! | `late-image` | the second begins, and its exposure is made, so many seconds late; those after it follow in haste |
//! | `clock-step` | Terrestrial Time is off by so many seconds |
//! | `clock-invalid` | the clock is not synchronised |
//! | `wrong-geometry` | the detector says it has half its columns |
//! | `stuck-row` | a row (or more) reads full scale |
//! | `bit-flips` | a bit of a pixel is turned over |
//! | `noise-burst` | Gaussian noise on every pixel, cut at the ends of the scale |
//! | `blinded` | every pixel of an exposure is at full scale, whenever it is handed out |
//! | `proton-storm` | so many more protons hit in every exposure: [`crate::world::scene::Scene::storm`] |
//! | `gyro-offset` | the gyro reads so much more about each axis |
//! | `gyro-silent` | the gyro gives no reading |
//! | `magnetometer-offset` | the magnetometer reads so much more along each axis |
//! | `magnetometer-silent` | the magnetometer gives no reading |
//! | `shutter-stuck` | the shutters stay where they are, and their driver does not know |
//! | `restart` | the spacecraft's command to restart: attitude, orbit and what was learned are forgotten |

use crate::world::noise::{Noise, Stream};
use fsw_core::sensor::Command;
use fsw_hal::{
    AngularRate, Detector, DetectorError, DetectorGeometry, Instant, LocalTime, MagneticField, Window,
};

/// What is broken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// An exposure is not acknowledged, with this probability.
    TimeOut(f64),
    /// A readout breaks off, with this probability a window.
    DroppedWindow(f64),
    /// The image before is handed out again as a new one, with this probability a second.
    LateFrame(f64),
    /// The same with its own instant.
    DoubledImage(f64),
    /// The second is late by so much, s.
    LateImage(f64),
    /// Terrestrial Time by the clock is off by so much, s.
    ClockStep(f64),
    /// The clock gives no time.
    ClockInvalid,
    /// Half the columns are reported, with this probability a second.
    WrongGeometry(f64),
    /// The row reads full scale.
    StuckRow(u16),
    /// A pixel has a bit turned over, with this probability.
    BitFlips(f64),
    /// Every pixel is disturbed, with this standard deviation in digital numbers.
    NoiseBurst(f64),
    /// Every pixel reads full scale.
    Blinded,
    /// So many more protons hit in an exposure.
    ProtonStorm(u32),
    /// The gyro reads so much more about each axis, deg/s.
    GyroOffset(f64),
    /// The gyro gives no reading.
    GyroSilent,
    /// The magnetometer reads so much more along each axis, uT.
    MagnetometerOffset(f64),
    /// The magnetometer gives no reading.
    MagnetometerSilent,
    /// The shutters do not move.
    ShutterStuck,
    /// The spacecraft commands a restart, with this probability a second.
    Restart(f64),
}

impl FaultKind {
    /// Its word in scenario files and tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::TimeOut(_) => "time-out",
            Self::DroppedWindow(_) => "dropped-window",
            Self::LateFrame(_) => "late-frame",
            Self::DoubledImage(_) => "doubled-image",
            Self::LateImage(_) => "late-image",
            Self::ClockStep(_) => "clock-step",
            Self::ClockInvalid => "clock-invalid",
            Self::WrongGeometry(_) => "wrong-geometry",
            Self::StuckRow(_) => "stuck-row",
            Self::BitFlips(_) => "bit-flips",
            Self::NoiseBurst(_) => "noise-burst",
            Self::Blinded => "blinded",
            Self::ProtonStorm(_) => "proton-storm",
            Self::GyroOffset(_) => "gyro-offset",
            Self::GyroSilent => "gyro-silent",
            Self::MagnetometerOffset(_) => "magnetometer-offset",
            Self::MagnetometerSilent => "magnetometer-silent",
            Self::ShutterStuck => "shutter-stuck",
            Self::Restart(_) => "restart",
        }
    }
}

/// A fault and when it is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What is broken.
    pub kind: FaultKind,
    /// First second.
    pub from_s: u32,
    /// The second after the last.
    pub until_s: u32,
}

impl Fault {
    /// Whether it is there in a second.
    pub fn acts_in(&self, cycle: u32) -> bool {
        (self.from_s..self.until_s).contains(&cycle)
    }
}

/// The faults of a second of the run `seed`, each with noise of its own.
fn acting(faults: &[Fault], seed: u64, cycle: u32) -> impl Iterator<Item = (FaultKind, Noise)> {
    let noise = Noise::new(seed, cycle.into(), Stream::Fault);
    let numbered = (0u64..).zip(faults).filter(move |(_, fault)| fault.acts_in(cycle));
    numbered.map(move |(index, fault)| (fault.kind, noise.part(index)))
}

/// Whether something of probability `share` happens in a second.
fn happens(noise: &Noise, share: f64) -> bool {
    noise.uniform(0, 0) < share
}

/// What is handed out instead of a new image in a second of the run `seed`, if anything is.
fn instead_in(faults: &[Fault], seed: u64, cycle: u32) -> Option<FaultKind> {
    let happening = |(kind, noise): &(FaultKind, Noise)| match kind {
        FaultKind::TimeOut(share) | FaultKind::LateFrame(share) | FaultKind::DoubledImage(share) => {
            happens(noise, *share)
        }
        _ => false,
    };
    acting(faults, seed, cycle).find(happening).map(|(kind, _)| kind)
}

/// The spacecraft's command in a second of the run `seed`.
pub fn command(faults: &[Fault], seed: u64, cycle: u32) -> Command<'static> {
    let restarts = |(kind, noise)| matches!(kind, FaultKind::Restart(share) if happens(&noise, share));
    if acting(faults, seed, cycle).any(restarts) { Command::Restart } else { Command::Continue }
}

/// The words of all faults that act in a second, joined by `+`.
pub fn words(faults: &[Fault], cycle: u32) -> String {
    let acting = faults.iter().filter(|fault| fault.acts_in(cycle));
    acting.map(|fault| fault.kind.word()).collect::<Vec<_>>().join("+")
}

/// By how much a second is late, s.
pub fn lateness_s(faults: &[Fault], cycle: u32) -> f64 {
    let late = faults.iter().filter(|fault| fault.acts_in(cycle)).map(|fault| match fault.kind {
        FaultKind::LateImage(late_s) => late_s,
        _ => 0.0,
    });
    late.sum()
}

/// Protons that hit in the exposure of a second beside those of the world.
pub fn storm_hits(faults: &[Fault], cycle: u32) -> u32 {
    let hits = faults.iter().filter(|fault| fault.acts_in(cycle)).map(|fault| match fault.kind {
        FaultKind::ProtonStorm(hits) => hits,
        _ => 0,
    });
    hits.fold(0, u32::saturating_add)
}

/// Whether the shutters do not move in a second.
pub fn shutters_are_stuck(faults: &[Fault], cycle: u32) -> bool {
    faults.iter().any(|fault| fault.kind == FaultKind::ShutterStuck && fault.acts_in(cycle))
}

/// The clock of a second, with its faults.
pub fn faulty_clock(faults: &[Fault], cycle: u32, clock: Instant) -> Instant {
    let acting = faults.iter().filter(|fault| fault.acts_in(cycle));
    acting.fold(clock, |Instant { local, terrestrial_us }, fault| match fault.kind {
        FaultKind::ClockStep(step_s) => {
            Instant { local, terrestrial_us: terrestrial_us.map(|us| us + (step_s * 1e6) as i64) }
        }
        FaultKind::ClockInvalid => Instant { local, terrestrial_us: None },
        _ => Instant { local, terrestrial_us },
    })
}

/// The gyro's reading of a second, with its faults.
pub fn faulty_rate(faults: &[Fault], cycle: u32, reading: Option<AngularRate>) -> Option<AngularRate> {
    let acting = faults.iter().filter(|fault| fault.acts_in(cycle));
    acting.fold(reading, |reading, fault| match fault.kind {
        FaultKind::GyroOffset(deg_s) => reading.map(|AngularRate { instant, rad_s }| AngularRate {
            instant,
            rad_s: rad_s.map(|axis| axis + deg_s.to_radians() as f32),
        }),
        FaultKind::GyroSilent => None,
        _ => reading,
    })
}

/// The magnetometer's reading of a second, with its faults.
pub fn faulty_field(faults: &[Fault], cycle: u32, reading: Option<MagneticField>) -> Option<MagneticField> {
    let acting = faults.iter().filter(|fault| fault.acts_in(cycle));
    acting.fold(reading, |reading, fault| match fault.kind {
        FaultKind::MagnetometerOffset(off_ut) => reading.map(|MagneticField { instant, ut }| MagneticField {
            instant,
            ut: ut.map(|axis| axis + off_ut as f32),
        }),
        FaultKind::MagnetometerSilent => None,
        _ => reading,
    })
}

/// A detector with faults, for one second.
#[derive(Debug)]
pub struct Faulty<'a, D> {
    detector: &'a mut D,
    faults: &'a [Fault],
    cycle: u32,
    seed: u64,
    /// Instant of a new image of this second.
    instant: LocalTime,
    /// What is handed out instead of a new image: the last one, with a new instant or its own.
    instead: Option<FaultKind>,
    /// Whether the image that is handed out is of a second that blinded it.
    is_blinded: bool,
}

impl<'a, D: Detector<Error = DetectorError>> Faulty<'a, D> {
    /// Breaks `detector` as `faults` say for the second `cycle` of the run `seed`, whose image is of
    /// `instant`.
    pub fn new(
        detector: &'a mut D,
        faults: &'a [Fault],
        seed: u64,
        (cycle, instant): (u32, LocalTime),
    ) -> Self {
        let instead = instead_in(faults, seed, cycle);
        let is_made = |second: &u32| instead_in(faults, seed, *second).is_none();
        let exposed = (0..=cycle).rev().find(is_made).unwrap_or(cycle);
        let is_blinded =
            faults.iter().any(|fault| fault.kind == FaultKind::Blinded && fault.acts_in(exposed));
        Self { detector, faults, cycle, seed, instant, instead, is_blinded }
    }

    /// The faults of this second, each with noise of its own.
    fn acting(&self) -> impl Iterator<Item = (FaultKind, Noise)> {
        acting(self.faults, self.seed, self.cycle)
    }
}

impl<D: Detector<Error = DetectorError>> fsw_hal::ErrorType for Faulty<'_, D> {
    type Error = DetectorError;
}

impl<D: Detector<Error = DetectorError>> Detector for Faulty<'_, D> {
    fn geometry(&self) -> DetectorGeometry {
        let geometry = self.detector.geometry();
        let wrong = |(kind, noise): (FaultKind, Noise)| matches!(kind, FaultKind::WrongGeometry(share) if happens(&noise, share));
        if self.acting().any(wrong) {
            return DetectorGeometry { width_px: geometry.width_px / 2, ..geometry };
        }
        geometry
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        match self.instead {
            Some(FaultKind::TimeOut(_)) => Err(DetectorError::Timeout),
            Some(_) => Ok(()),
            None => self.detector.start_exposure(exposure_us),
        }
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        match self.instead {
            Some(FaultKind::LateFrame(_)) => Ok(self.instant),
            _ => self.detector.finish_exposure(),
        }
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let place = u32::from(window.y) << 16 | u32::from(window.x);
        let dropped = |(kind, noise): (FaultKind, Noise)| matches!(kind, FaultKind::DroppedWindow(share) if noise.uniform(place, 0) < share);
        if self.acting().any(dropped) {
            return Err(DetectorError::Bus);
        }
        self.detector.read(window, pixels)?;
        let geometry = self.detector.geometry();
        if self.is_blinded {
            pixels.fill(geometry.full_scale());
        }
        for (kind, noise) in self.acting() {
            spoil(kind, &noise, geometry, window, pixels);
        }
        Ok(())
    }
}

/// What a fault does to the pixels of a window.
fn spoil(kind: FaultKind, noise: &Noise, geometry: DetectorGeometry, window: Window, pixels: &mut [u16]) {
    let full_scale = geometry.full_scale();
    let lines = (window.y..).zip(pixels.chunks_mut(usize::from(window.width).max(1)));
    let each = lines.flat_map(|(y, line)| (window.x..).zip(line).map(move |(x, pixel)| (x, y, pixel)));
    match kind {
        FaultKind::StuckRow(row) => {
            each.filter(|(_, y, _)| *y == row).for_each(|(_, _, pixel)| *pixel = full_scale);
        }
        FaultKind::BitFlips(share) => {
            let bits = u64::from(geometry.bits.clamp(1, 16));
            for (x, y, pixel) in each {
                if noise.uniform(x.into(), y.into()) < share {
                    let which = noise.bits(u32::from(x) | 1 << 16, y.into()) % bits;
                    *pixel ^= 1 << which;
                }
            }
        }
        FaultKind::NoiseBurst(sigma_dn) => {
            for (x, y, pixel) in each {
                let disturbed = f64::from(*pixel) + sigma_dn * noise.gaussian(x.into(), y.into());
                *pixel = (disturbed + 0.5).clamp(0.0, f64::from(full_scale)) as u16;
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests;
