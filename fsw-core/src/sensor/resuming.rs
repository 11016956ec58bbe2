//! What was known before a restart.
//!
//! In: the report of a second of before, kept where a restart leaves it. Out: a sensor that goes on with what
//! images do not tell: that safe was commanded, the orbit, and how the paths are mounted. The attitude is
//! found in the sky within seconds.

use super::Sensor;
use crate::command::GroundOrbit;
use crate::modes::Mode;
use crate::telemetry::Report;

impl Sensor<'_> {
    /// Goes on from the report of a second before a restart, to be called before the first second. Where safe
    /// was commanded it is until a command ends it. The orbit of then is told once Terrestrial Time is known
    /// and the gap is crossed; one that is older than two hours then, or lies ahead of the clock, is
    /// forgotten with an event, not how the paths are mounted. Whether there was anything to go on with;
    /// `false`, and no change, after the first second.
    #[inline(never)]
    pub fn resume(&mut self, before: &Report) -> bool {
        if self.cycle > 0 {
            return false;
        }
        let safe = before.mode == Mode::CommandedSafe;
        if safe {
            self.modes.enter(Mode::CommandedSafe);
        }
        let mounted = before.orbit.as_ref().is_some_and(|told| {
            self.orbit.initialise_mounting(told.misalignment_rad, told.misalignment_sigma_rad)
        });
        let flies = before.ground_orbit().is_some_and(|orbit| {
            let GroundOrbit { state, position_sigma_km, velocity_sigma_km_s } = orbit;
            self.initialise_orbit(state, position_sigma_km, velocity_sigma_km_s)
        });
        if flies {
            self.orbit.hold_back();
        }
        self.seal(None);
        safe || mounted || flies
    }
}
