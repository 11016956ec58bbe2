//! Scrubbing: what a second rests on is looked through for bits that an upset has turned.
//!
//! In: the parameters with what was made of them, their copy and the CRC they were loaded with; catalogue and
//! calibration with theirs. Out: events, and parameters that are those that were loaded.
//!
//! - Parameters are compared with their copy in every second, before they are used. Where the two differ, the
//!   one whose CRC is right is taken, and stars are acquired anew; where neither is, no image is taken until
//!   a table is loaded.
//! - Of catalogue and calibration [`SLICE_BYTES`] are passed in a second: both of the reference camera, 183
//!   kB, in 12 minutes. A wrong CRC at the end of one is told; it is used all the same, as a turned bit
//!   spoils one of 3,200 stars or one of 37,000 pairs, and each must be confirmed by others.
//!
//! Cost on the target: 4,000 cycles a second.

use super::Sensor;
use super::record::Events;
use crate::camera::Camera;
use crate::checksum::Crc32;
use crate::frames::{EarthPath, Rotation, StarPath};
use crate::modes::{Guard, Mode};
use crate::parameters::{MAX_TABLE_BYTES, Parameters};
use crate::telemetry::Event;

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

/// How far the pass over catalogue and calibration is.
#[derive(Clone, Debug, Default)]
pub(super) struct Scrubber {
    /// Whether it is in the calibration.
    in_calibration: bool,
    /// Bytes passed.
    offset: usize,
    crc: Crc32,
}

impl Scrubber {
    /// Passes the next slice; at the end whether the CRC is right.
    fn pass(&mut self, (bytes, crc): (&[u8], u32)) -> Option<bool> {
        let rest = bytes.get(self.offset..).unwrap_or(&[]);
        let slice = rest.get(..SLICE_BYTES).unwrap_or(rest);
        self.crc.add(slice);
        self.offset = self.offset.saturating_add(slice.len());
        (slice.len() == rest.len()).then(|| self.crc.value() == crc)
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

    /// Looks through the parameters and a slice of catalogue or calibration.
    #[inline(never)]
    pub(super) fn scrub(&mut self, events: &mut Events) {
        if !self.parameters_hold() {
            self.restore(events);
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
        self.forget_attitude();
        let (mode, event) = match loaded {
            Some((parameters, checked)) => {
                self.configure(&parameters, checked);
                (self.modes.with_new_parameters(), Event::ParametersRestored)
            }
            None => (Mode::CommandedSafe, Event::ParametersLost),
        };
        self.modes.enter(mode);
        events.note(event);
        events.note(Event::Mode(mode, Guard::ParametersDamaged));
    }
}

#[cfg(test)]
mod tests;
