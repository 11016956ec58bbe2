//! Scrubbing: what a second rests on is looked through for bits that an upset has turned.
//!
//! In: the parameters with what was made of them, their copy and the CRC they were loaded with; catalogue and
//! calibration with theirs; attitude, orbit, mode and time with the sums of their words at the end of the
//! last second. Out: events, parameters that are those that were loaded, and a state that nobody changed.
//!
//! - Parameters are compared with their copy in every second, before they are used. Where the two differ, the
//!   one whose CRC is right is taken; where neither is, no image is taken until a table is loaded.
//! - A damaged filter of the attitude is forgotten, and stars are acquired anew, near to the attitude that
//!   was measured last. A damaged orbit begins anew with the position and velocity that were told last, and
//!   with [`INFLATION`] times their sigma. A damaged mode is entered anew; of the time all is forgotten, so
//!   that the clock's next answer is no step. What ground is usual is learned anew. Damaged shutters are
//!   opened, and moved by the Sun again.
//! - Of catalogue and calibration [`SLICE_BYTES`] are passed in a second: both of the reference camera, 183
//!   kB, in 12 minutes. A wrong CRC at the end of one is told; it is used all the same, as a turned bit
//!   spoils one of 3,200 stars or one of 37,000 pairs, and each must be confirmed by others.
//!
//! Cost on the target: 6,000 cycles a second, and about as many more where an orbit is known: its 940 words,
//! twice.

use super::Sensor;
use super::motion::Motion;
use super::record::Events;
use super::timekeeping::Timekeeper;
use crate::camera::Camera;
use crate::checksum::SlicedCrc32;
use crate::command::GroundOrbit;
use crate::earth::ground::UsualGround;
use crate::frames::{EarthPath, Rotation, StarPath};
use crate::modes::{Guard, Mode, Modes};
use crate::parameters::{MAX_TABLE_BYTES, Parameters};
use crate::shutting::Shutting;
use crate::telemetry::{Event, OrbitReport};

/// Bytes of catalogue or calibration that are passed in a second.
pub(super) const SLICE_BYTES: usize = 256;

/// A second copy of the parameters and of what was made of them.
#[derive(Clone, Debug)]
pub(super) struct Spare {
    parameters: Parameters,
    camera: Camera,
    star_to_earth: Rotation<StarPath, EarthPath>,
    /// CRC of the parameters' packet; `None` where it could not be made, and then never equal to another.
    crc: Option<u32>,
}

/// CRC of a table's packet: its last four bytes.
#[inline(never)]
fn table_crc(parameters: &Parameters) -> Option<u32> {
    let mut buffer = [0; MAX_TABLE_BYTES];
    let table = parameters.encode(&mut buffer).ok()?;
    table.last_chunk().map(|crc| u32::from_le_bytes(*crc))
}

impl Spare {
    /// Of a table that was checked.
    pub(super) fn new(
        parameters: &Parameters,
        camera: &Camera,
        star_to_earth: &Rotation<StarPath, EarthPath>,
    ) -> Self {
        let crc = table_crc(parameters);
        Self { parameters: *parameters, camera: *camera, star_to_earth: *star_to_earth, crc }
    }

    /// Takes the camera as the stars show it.
    pub(super) fn take_camera(&mut self, camera: Camera) {
        self.camera = camera;
    }
}

/// An orbit that begins anew has so many times the sigma of its worst axis. The covariance of its position
/// and velocity then is greater in every direction than the one that is lost: that of two correlated parts
/// is at most twice that of the same parts uncorrelated, that of three axes three times the worst one's
/// variance; the root of 6 is 2.4.
const INFLATION: f64 = 3.0;

/// What the last second left: sums of words, and copies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seal {
    /// Of the attitude's filter; 0 without one.
    attitude: u32,
    /// Of the orbit's; 0 without one.
    orbit: u32,
    /// The orbit that was told last.
    told: Option<GroundOrbit>,
    /// Of mode and counters, and the mode.
    modes: u32,
    mode: Mode,
    /// Of both times.
    timekeeper: u32,
    /// Of the usual ground.
    usual_ground: u32,
    /// The shutters' themselves.
    shutting: Shutting,
}

impl Seal {
    /// Before the first second: neither attitude nor orbit are known.
    pub(super) fn new(modes: &Modes, timekeeper: &Timekeeper, shutting: Shutting) -> Self {
        Self {
            attitude: 0,
            orbit: 0,
            told: None,
            modes: modes.word_sum(),
            mode: modes.mode(),
            timekeeper: timekeeper.word_sum(),
            usual_ground: UsualGround::default().word_sum(),
            shutting,
        }
    }
}

/// How far the pass over catalogue and calibration is.
#[derive(Clone, Debug, Default)]
pub(super) struct Scrubber {
    /// Whether it is in the calibration.
    in_calibration: bool,
    /// What of it is passed.
    passed: SlicedCrc32,
}

impl Scrubber {
    /// Passes the next slice; at the end whether the CRC is right.
    fn pass(&mut self, (bytes, crc): (&[u8], u32)) -> Option<bool> {
        self.passed.pass(bytes, SLICE_BYTES);
        self.passed.of_all(bytes).map(|all| all == crc)
    }
}

impl Sensor<'_> {
    /// Whether the parameters and what was made of them are those of the copy.
    pub(super) fn parameters_hold(&self) -> bool {
        let Spare { parameters, camera, star_to_earth, .. } = &self.spare;
        self.parameters == *parameters
            && self.camera == *camera
            && self.star_to_earth.matrix() == star_to_earth.matrix()
    }

    /// Looks through state and parameters, and a slice of catalogue or calibration. What was sealed comes
    /// first, as what follows changes it.
    #[inline(never)]
    pub(super) fn scrub(&mut self, events: &mut Events) {
        if self.modes.word_sum() != self.seal.modes {
            self.enter_damaged(self.seal.mode, events);
        }
        if self.timekeeper.word_sum() != self.seal.timekeeper {
            self.timekeeper = Timekeeper::default();
            events.note(Event::TimeForgotten);
        }
        if self.usual_ground.word_sum() != self.seal.usual_ground {
            self.usual_ground = UsualGround::default();
            events.note(Event::GroundForgotten);
        }
        if self.shutting != self.seal.shutting {
            self.shutting.command(None);
            events.note(Event::ShuttersReleased);
        }
        if self.motion.word_sum() != self.seal.attitude {
            self.motion = Motion::default();
            self.lose_attitude();
            self.enter_damaged(self.modes.with_new_parameters(), events);
        }
        if !self.parameters_hold() {
            self.restore(events);
        }
        if self.orbit.word_sum() != self.seal.orbit {
            self.begin_orbit_anew(events);
        }
        let in_calibration = self.scrubber.in_calibration;
        let (protected, damaged) = match &self.calibration {
            Some(calibration) if in_calibration => (calibration.protected(), Event::CalibrationDamaged),
            _ => (self.catalogue.protected(), Event::CatalogueDamaged),
        };
        let Some(right) = self.scrubber.pass(protected) else { return };
        if !right {
            events.note(damaged);
        }
        let next = !in_calibration && self.calibration.is_some();
        self.scrubber = Scrubber { in_calibration: next, ..Scrubber::default() };
    }

    /// Takes the parameters, or their copy, whichever is as it was loaded.
    #[inline(never)]
    fn restore(&mut self, events: &mut Events) {
        let loaded = [self.parameters, self.spare.parameters].into_iter().find_map(|parameters| {
            let sound = self.spare.crc.is_some() && table_crc(&parameters) == self.spare.crc;
            Some((parameters, parameters.check().ok().filter(|_| sound)?))
        });
        let Some((parameters, checked)) = loaded else {
            events.note(Event::ParametersLost);
            self.forget_attitude();
            return self.enter_damaged(Mode::CommandedSafe, events);
        };
        self.configure(&parameters, checked);
        events.note(Event::ParametersRestored);
    }

    fn enter_damaged(&mut self, mode: Mode, events: &mut Events) {
        self.modes.enter(mode);
        events.note(Event::Mode(mode, Guard::MemoryDamaged));
    }

    /// Notes what the next second has to find, and the orbit as it is told.
    pub(super) fn seal(&mut self, told: Option<&OrbitReport>) {
        let told = self.orbit.state().zip(told).map(|(state, told)| told.ground_orbit(state.time_us));
        self.seal = Seal {
            attitude: self.motion.word_sum(),
            orbit: self.orbit.word_sum(),
            told,
            usual_ground: self.usual_ground.word_sum(),
            ..Seal::new(&self.modes, &self.timekeeper, self.shutting)
        };
    }

    /// Begins a damaged orbit with the one told last.
    #[inline(never)]
    fn begin_orbit_anew(&mut self, events: &mut Events) {
        self.forget_orbit();
        let begun =
            self.seal.told.is_some_and(|GroundOrbit { state, position_sigma_km, velocity_sigma_km_s }| {
                let sigmas = [position_sigma_km, velocity_sigma_km_s];
                let [position_km, velocity_km_s] = sigmas.map(|sigma| INFLATION * sigma);
                self.orbit.initialise(state, position_km, velocity_km_s, &self.parameters.orbit)
            });
        events.note(if begun { Event::OrbitRestarted } else { Event::OrbitForgotten });
    }
}

#[cfg(test)]
mod tests;
