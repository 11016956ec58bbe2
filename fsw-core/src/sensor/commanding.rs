//! What a command does before its second begins.
//!
//! In: the [`Command`]. Out: what came of it. Every check stands before the first change, so that a refused
//! command changes nothing.

use super::record::Events;
use super::scrubbing::Spare;
use super::{Sensor, calibration_fits};
use crate::camera::Camera;
use crate::camera::focal_length::FocalLength;
use crate::command::{Command, CommandOutcome, GroundOrbit, Refusal};
use crate::earth::ground::UsualGround;
use crate::frames::{EarthPath, Rotation, StarPath};
use crate::magnetism::Magnetism;
use crate::modes::{Guard, Mode};
use crate::parameters::Parameters;
use crate::telemetry::Event;
use fsw_hal::OpenPaths;

/// Oldest orbit that is taken, us: 100 minutes, of the two hours that the filter crosses.
const ORBIT_AGE_US: i64 = 6_000_000_000;

impl Sensor<'_> {
    /// Does what the spacecraft wants; what came of it, where it wanted something.
    #[inline(never)]
    pub(super) fn obey(&mut self, command: &Command, events: &mut Events) -> Option<CommandOutcome> {
        let done = match command {
            Command::Continue => return None,
            Command::Reacquire
            | Command::Restart
            | Command::Exposure(_)
            | Command::Orbit(_)
            | Command::Shutter(_)
                if !self.parameters_hold() =>
            {
                Err(Refusal::ParametersLost)
            }
            Command::Reacquire => {
                self.enter_commanded(Mode::Acquisition, events);
                Ok(())
            }
            Command::Restart => {
                self.forget_orbit();
                self.forget_instruments();
                self.enter_commanded(Mode::SelfTest, events);
                Ok(())
            }
            Command::Safe => {
                self.enter_commanded(Mode::CommandedSafe, events);
                Ok(())
            }
            Command::LoadParameters(table) => self.load(table, events),
            Command::Exposure(exposure_us) => self.set_exposure(*exposure_us),
            Command::Orbit(orbit) => self.take_orbit(orbit),
            Command::Time(correlation) => self.timekeeper.correlate(*correlation),
            Command::Shutter(paths) => self.hold_shutters(*paths),
        };
        Some(done.map_or_else(CommandOutcome::Refused, |()| CommandOutcome::Done))
    }

    fn enter_commanded(&mut self, mode: Mode, events: &mut Events) {
        self.forget_attitude();
        self.modes.enter(mode);
        events.note(Event::Mode(mode, Guard::Commanded));
    }

    /// Puts a checked table in force.
    pub(super) fn configure(
        &mut self,
        parameters: &Parameters,
        (camera, star_to_earth): (Camera, Rotation<StarPath, EarthPath>),
    ) {
        (self.parameters, self.camera, self.star_to_earth) = (*parameters, camera, star_to_earth);
        self.focal_length = FocalLength::new(parameters.identification.scale_uncertainty);
        self.usual_ground = UsualGround::default();
        self.spare = Spare::new(parameters, &camera, &star_to_earth);
    }

    /// Takes the camera as the stars show it.
    pub(super) fn take_camera(&mut self, camera: Camera) {
        self.camera = camera;
        self.spare.take_camera(camera);
    }

    /// Forgets what was learned of lens, rate sensor and magnetometer.
    fn forget_instruments(&mut self) {
        self.rate_sensor_doubts = 0;
        self.magnetism = Magnetism::default();
        self.shutting.command(None);
        let parameters = self.parameters;
        // They were checked when they came in force.
        if let Ok(checked) = parameters.check() {
            self.configure(&parameters, checked);
        }
    }

    /// Takes a parameter table. The orbit is kept where nothing it rests on is another.
    #[inline(never)]
    fn load(&mut self, table: &[u8], events: &mut Events) -> Result<(), Refusal> {
        let parameters = Parameters::decode(table).map_err(|_| Refusal::TableDamaged)?;
        let checked = parameters.check().map_err(|_| Refusal::TableRange)?;
        let fits = match &self.calibration {
            Some(calibration) => calibration_fits(&parameters, calibration),
            None => parameters.imaging.calibration_crc == 0,
        };
        if !fits {
            return Err(Refusal::TableCalibration);
        }
        let before = &self.parameters;
        if (&parameters.orbit, &parameters.earth, &parameters.mount)
            != (&before.orbit, &before.earth, &before.mount)
        {
            self.forget_orbit();
        }
        self.configure(&parameters, checked);
        let held = self
            .shutting
            .held()
            .filter(|paths| parameters.shutter.is_some_and(|fitted| fitted.allow(*paths)));
        self.shutting.command(held);
        self.enter_commanded(self.modes.with_new_parameters(), events);
        Ok(())
    }

    /// Sets the exposure; what was learned of lens and ground is kept.
    #[inline(never)]
    fn set_exposure(&mut self, exposure_us: u32) -> Result<(), Refusal> {
        let mut parameters = self.parameters;
        parameters.imaging.exposure_us = exposure_us;
        parameters.check().map_err(|_| Refusal::Exposure)?;
        self.parameters = parameters;
        self.spare = Spare::new(&parameters, &self.camera, &self.star_to_earth);
        Ok(())
    }

    fn hold_shutters(&mut self, paths: Option<OpenPaths>) -> Result<(), Refusal> {
        let fitted = self.parameters.shutter.ok_or(Refusal::Shutter)?;
        if paths.is_some_and(|paths| !fitted.allow(paths)) {
            return Err(Refusal::Shutter);
        }
        self.shutting.command(paths);
        Ok(())
    }

    fn take_orbit(&mut self, orbit: &GroundOrbit) -> Result<(), Refusal> {
        let GroundOrbit { state, position_sigma_km, velocity_sigma_km_s } = *orbit;
        let now_us = self.timekeeper.last_terrestrial_us().ok_or(Refusal::Epoch)?;
        if !(0..=ORBIT_AGE_US).contains(&now_us.saturating_sub(state.time_us)) {
            return Err(Refusal::Epoch);
        }
        let taken = self.initialise_orbit(state, position_sigma_km, velocity_sigma_km_s);
        taken.then_some(()).ok_or(Refusal::Orbit)
    }
}

#[cfg(test)]
mod tests;
