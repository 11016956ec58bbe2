//! The second, top to bottom: one call a room.
//!
//! [`Sensor::cycle`] is called once a second:
//!
//! 1. the clock is read; Sun, pole and the observer's velocity (aberration) are those of the instant, the orbit is
//!    propagated to it;
//! 2. the mode says what is asked of the detector (`stars`): a self-test, the whole field searched for stars (over
//!    several seconds if need be, on the stars of that one image, then on those of another), or for streaks and the rate
//!    (`turning`), predicted stars followed in windows, or only whether the Sun still blinds;
//! 3. with an attitude from this second's image the Earth is looked at (`earth`): in strips about the limb where the
//!    orbit predicts it, else on a grid over the whole detector; its centre is a position, which the orbit filter takes in;
//! 4. the guards decide the next mode; the report is what was seen.
//!
//! Memory: [`Workspace`] holds what is large, the readout buffer of 16 KiB and the chains of identification, and can be
//! placed in a static; [`Sensor`] itself is small, and the stack serves a few KiB of lists. The parts of a second are not
//! inlined into it, so that their lists do not lie on the stack together.

mod earth;
mod stars;
mod turning;
mod workspace;

use crate::attitude::filter::Filter;
use crate::camera::Camera;
use crate::catalog::Catalogue;
use crate::frames::{Direction, EarthPath, Icrs, Rotation, StarPath};
use crate::image::calibration::Calibration;
use crate::modes::{Guard, Mode, Modes, Seen};
use crate::orbit::constants::LIGHT_KM_S;
use crate::orbit::ephemeris;
use crate::orbit::filter::OrbitFilter;
use crate::parameters::{ParameterError, Parameters};
use crate::telemetry::{EarthStatus, Event, Fault, Report, Status};
use fsw_hal::{Clock, Detector, RateSensor, Stage, StageMeter};
use nalgebra::Vector3;
pub use workspace::{MAX_BASE_SIDES, MAX_CATALOGUE_STARS, MAX_TRIANGLES, Workspace};

/// Instants between which the clock is believed: the years 2000 and 2100, microseconds since J2000.0.
pub const INSTANTS_US: (i64, i64) = (0, 3_155_760_000_000_000);
/// A second is so long, and its instant may be off by as much.
const SECOND_US: i64 = 1_000_000;
const SECOND_TOLERANCE_US: i64 = 100_000;

/// So far the optical centre may have been refined since the lens was calibrated, px: "the shape of the PSF does not vary
/// when moving the optical center by one pixel" (thesis §3.1.2.2).
const CALIBRATED_CENTRE_PX: f32 = 1.5;

/// A reading of the rate sensor is of the second before, its middle at most so long ago, us.
const READING_AGE_US: i64 = 1_500_000;

/// The instruments, as the spacecraft lends them for a second.
pub struct Instruments<'a, D, C, M> {
    /// The active-pixel detector behind both paths.
    pub detector: &'a mut D,
    /// Tells the instant of the second.
    pub clock: &'a mut C,
    /// Receives the marks of the stages; `&mut ()` where nothing is measured.
    pub meter: &'a mut M,
    /// Tells how the body turns, where there is one; heard only where [`Parameters::rate_sensor`] says how good it is.
    pub rate_sensor: Option<&'a mut dyn RateSensor>,
}

/// What the spacecraft wants of this second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Command {
    /// Go on.
    #[default]
    Continue,
    /// Forget the attitude and acquire anew.
    Reacquire,
    /// Forget attitude and orbit and begin with the self-test.
    Restart,
    /// Go to safe mode.
    Safe,
}

/// Why a sensor could not be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorError {
    /// The parameters were refused.
    Parameters(ParameterError),
    /// The catalogue holds more stars than [`MAX_CATALOGUE_STARS`].
    CatalogueTooLarge,
    /// The calibration is not the one that the parameters name, or not for this detector and optical centre.
    Calibration,
}

/// What time alone tells.
#[derive(Clone, Copy)]
struct Sky {
    sun: Direction<Icrs>,
    pole: Direction<Icrs>,
}

/// The Earth/star sensor.
pub struct Sensor<'c> {
    catalogue: Catalogue<'c>,
    camera: Camera,
    calibration: Option<Calibration<'c>>,
    parameters: Parameters,
    star_to_earth: Rotation<StarPath, EarthPath>,
    modes: Modes,
    cycle: u32,
    /// Instant of the last second.
    instant_us: Option<i64>,
    motion: Option<Filter<2>>,
    orbit: OrbitFilter,
    /// Instant of the last fix that the orbit accepted.
    fixed_us: i64,
    converged: bool,
    /// Seconds in a row in which the limb's strips gave no centre.
    strip_misses: u8,
    /// Normalised innovation squared of this second's fix.
    nis: Option<f32>,
    /// Cycle in which the image under search was taken.
    searching_since: Option<u32>,
    /// How it turns while no attitude is known.
    turning: turning::Turning,
    /// Images given up since the last attitude.
    images_given_up: u8,
    workspace: &'c mut Workspace,
}

impl<'c> Sensor<'c> {
    /// A sensor that knows nothing yet.
    ///
    /// # Errors
    /// Impossible parameters, or a catalogue beyond the workspace.
    pub fn new(
        catalogue: Catalogue<'c>,
        parameters: Parameters,
        workspace: &'c mut Workspace,
    ) -> Result<Self, SensorError> {
        let (camera, star_to_earth) = parameters.check().map_err(SensorError::Parameters)?;
        if catalogue.star_count() > MAX_CATALOGUE_STARS {
            return Err(SensorError::CatalogueTooLarge);
        }
        Ok(Self {
            catalogue,
            camera,
            calibration: None,
            parameters,
            star_to_earth,
            modes: Modes::default(),
            cycle: 0,
            instant_us: None,
            motion: None,
            orbit: OrbitFilter::new(),
            fixed_us: 0,
            converged: false,
            strip_misses: 0,
            nis: None,
            searching_since: None,
            turning: turning::Turning::default(),
            images_given_up: 0,
            workspace,
        })
    }

    /// The same with what is known of its lens.
    ///
    /// # Errors
    /// [`SensorError::Calibration`] where it belongs to another lens.
    pub fn calibrated(self, calibration: Calibration<'c>) -> Result<Self, SensorError> {
        let camera = self.camera.parameters();
        let [cx, cy] = calibration.centre_px();
        let [dx, dy] = [cx - camera.optical_centre_px[0], cy - camera.optical_centre_px[1]];
        let fits = calibration.crc() == self.parameters.imaging.calibration_crc
            && calibration.size_px() == [camera.width_px, camera.height_px]
            && dx.abs().max(dy.abs()) <= CALIBRATED_CENTRE_PX;
        if !fits {
            return Err(SensorError::Calibration);
        }
        Ok(Self { calibration: Some(calibration), ..self })
    }

    /// One second.
    #[inline(never)]
    pub fn cycle<D: Detector, C: Clock, M: StageMeter>(
        &mut self,
        instruments: &mut Instruments<D, C, M>,
        command: Command,
    ) -> Report {
        self.obey(command);
        let instant_us = instruments.clock.instant_us();
        let mut report = Report::new(self.cycle, instant_us, self.modes.mode());
        match self.check(instruments, instant_us) {
            Err(fault) => report.status = Status::DetectorFault(fault),
            Ok(()) => self.work(instruments, &mut report),
        }
        self.change_mode(&mut report);
        self.cycle = self.cycle.wrapping_add(1);
        report
    }

    /// Does what the spacecraft wants before the second begins.
    fn obey(&mut self, command: Command) {
        match command {
            Command::Continue => {}
            Command::Reacquire => {
                self.forget_attitude();
                self.modes.enter(Mode::Acquisition);
            }
            Command::Restart => {
                self.forget_attitude();
                self.forget_orbit();
                self.modes.enter(Mode::SelfTest);
            }
            Command::Safe => {
                self.forget_attitude();
                self.modes.enter(Mode::Safe);
            }
        }
    }

    fn forget_attitude(&mut self) {
        self.motion = None;
        self.searching_since = None;
        self.turning.forget();
        self.images_given_up = 0;
    }

    fn forget_orbit(&mut self) {
        self.orbit.forget();
        self.converged = false;
        self.strip_misses = 0;
    }

    /// Refuses a detector that is not the one the parameters were made for, and a clock that is out of its mind.
    fn check<D: Detector, C: Clock, M>(
        &self,
        instruments: &Instruments<D, C, M>,
        instant_us: i64,
    ) -> Result<(), Fault> {
        let (geometry, camera) = (instruments.detector.geometry(), self.camera.parameters());
        if (geometry.width_px, geometry.height_px) != (camera.width_px, camera.height_px) {
            return Err(Fault::Geometry);
        }
        if !(INSTANTS_US.0..=INSTANTS_US.1).contains(&instant_us) {
            return Err(Fault::Clock);
        }
        Ok(())
    }

    /// The second's work: time and orbit, then stars, then the Earth.
    fn work<D: Detector, C: Clock, M: StageMeter>(
        &mut self,
        instruments: &mut Instruments<D, C, M>,
        report: &mut Report,
    ) {
        let sky = self.tell_time(instruments.meter, report);
        self.hear_rate(&mut instruments.rate_sensor, report.instant_us);
        match report.mode {
            Mode::SelfTest => self.prove(instruments.detector, report),
            Mode::Acquisition => self.acquire_or_turn(instruments, report),
            Mode::Tracking | Mode::Eclipse => self.track(instruments, &sky, report),
            Mode::SunOutage => self.await_sunset(instruments.detector, report),
            Mode::Safe => report.status = Status::Waiting,
        }
        if let Some(attitude) = self.attitude_of_this_second(report) {
            self.look_at_earth(instruments, &sky, &attitude, report);
        }
        self.report_orbit(report);
    }

    /// Carries the attitude to this second by what the rate sensor tells of the one before; a reading that is old or not finite is none.
    #[inline(never)]
    fn hear_rate(&mut self, sensor: &mut Option<&mut dyn RateSensor>, instant_us: i64) {
        let (Some(noise), Some(motion)) = (self.parameters.rate_sensor, &mut self.motion) else { return };
        let told = sensor.as_mut().and_then(|sensor| sensor.angular_rate().ok().flatten());
        let new = told.filter(|told| {
            (0..=READING_AGE_US).contains(&instant_us.saturating_sub(told.instant_us))
                && told.rad_s.iter().all(|axis| axis.is_finite())
        });
        let to_star_path = self.star_to_earth.inverse();
        motion.hear(self.cycle, noise, new.map(|told| to_star_path.matrix() * Vector3::from(told.rad_s)));
    }

    /// Brings Sun, pole, aberration and orbit to the instant of the second.
    #[inline(never)]
    fn tell_time(&mut self, meter: &mut impl StageMeter, report: &mut Report) -> Sky {
        meter.begin(Stage::Orbit);
        let instant_us = report.instant_us;
        let expected = self.instant_us.map_or(instant_us, |before| before.saturating_add(SECOND_US));
        if !(-SECOND_TOLERANCE_US..=SECOND_TOLERANCE_US).contains(&instant_us.saturating_sub(expected)) {
            report.note(Event::ClockJump);
        }
        self.instant_us = Some(instant_us);
        let lost = self.orbit.advance(instant_us, &self.parameters.orbit).is_err();
        if lost || self.orbit.is_stale(self.fixed_us) {
            self.forget_orbit();
            report.note(Event::OrbitForgotten);
        }
        // About the Sun, and about the Earth where that is known: up to 5 arcsec of 25.
        let orbital_km_s = self.orbit.state().map_or(Vector3::zeros(), |state| state.velocity_km_s);
        let velocity_km_s = ephemeris::earth_velocity_km_s(instant_us) + orbital_km_s;
        self.catalogue.set_observer_velocity((velocity_km_s / LIGHT_KM_S).map(|axis| axis as f32));
        let sky = Sky { sun: ephemeris::sun_direction(instant_us), pole: ephemeris::pole(instant_us) };
        meter.end(Stage::Orbit);
        sky
    }

    /// Lets the guards decide what comes next.
    fn change_mode(&mut self, report: &mut Report) {
        let attitude = report.attitude.as_ref().filter(|_| report.status != Status::Blinded);
        let blinded = report.status == Status::Blinded;
        let seen = Seen {
            attitude: attitude.is_some(),
            rate: self.motion.as_ref().is_some_and(|motion| motion.rate().is_some()),
            carried: self.attitude_was_carried_well(),
            blinded,
            dark: match report.earth_status {
                EarthStatus::Dark => Some(true),
                EarthStatus::Faint | EarthStatus::Found => Some(false),
                EarthStatus::NotLooked | EarthStatus::Refused(_) => None,
            },
            fault: matches!(report.status, Status::DetectorFault(_)),
        };
        let before = self.modes.mode();
        let Some(guard) = self.modes.next(&seen, &self.parameters.modes) else { return };
        report.note(Event::Mode(self.modes.mode(), guard));
        // An attitude that was lost is not to be trusted again; one that was only carried too long is.
        let lost = guard == Guard::AttitudeLost
            || (before, self.modes.mode()) == (Mode::SunOutage, Mode::Acquisition);
        if lost || self.modes.mode() == Mode::Safe {
            self.forget_attitude();
        }
    }
}
