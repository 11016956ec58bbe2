//! The second, top to bottom: one call a room.
//!
//! [`Sensor::cycle`] is called once a second:
//!
//! 1. the image that the mode asks for is taken (`exposing`); its mid-exposure instant is that of the second, the counter's where none
//!    was asked for or may be used (`timekeeping`);
//! 2. orbit and attitude are propagated to that instant; Sun, pole and the observer's velocity (aberration) are those of it;
//! 3. the mode says what is done with the image (`stars`): a self-test, the whole field searched for stars (over several
//!    seconds if need be, on the stars of that one image, then on those of another), or for streaks and the rate
//!    (`turning`), predicted stars followed in windows, or only whether the Sun still blinds;
//! 4. with an attitude from this second's image the Earth is looked at (`earth`): in strips about the limb where the
//!    orbit predicts it, else on a grid over the whole detector; its centre is a position, which the orbit filter takes in;
//! 5. the guards decide the next mode; the report is what was seen.
//!
//! Memory: [`Workspace`] holds what is large, the readout buffer of 16 KiB and the chains of identification, and can be
//! placed in a static; [`Sensor`] itself is small, and the stack serves a few KiB of lists. The parts of a second are not
//! inlined into it, so that their lists do not lie on the stack together.

mod earth;
mod exposing;
mod stars;
mod timekeeping;
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
use crate::telemetry::{ClockFault, ClockState, EarthStatus, Event, RateSensorFault, Report, Status};
use exposing::Image;
use fsw_hal::Error;
use fsw_hal::detector::ByKind;
use fsw_hal::{
    AngularRate, Clock, Detector, DetectorError, LocalTime, RateSensor, RateSensorError, Stage, StageMeter,
};
use nalgebra::Vector3;
pub use timekeeping::INSTANTS_US;
use timekeeping::{Time, Timekeeper};
pub use workspace::{MAX_BASE_SIDES, MAX_TRIANGLES, Workspace};

/// So far the optical centre may have been refined since the lens was calibrated, px: "the shape of the PSF does not vary
/// when moving the optical center by one pixel" (thesis §3.1.2.2).
const CALIBRATED_CENTRE_PX: f32 = 1.5;

/// A reading of the rate sensor is of the second before, its middle at most so long ago, us.
const READING_AGE_US: i64 = 1_500_000;
/// Aberration by the Earth's flight about the Sun and a low orbit's about the Earth, (30.3 + 7.9) km/s, rad: 26 arcsec. An attitude
/// whose stars were not corrected for it may be off by so much.
const ABERRATION_RAD: f32 = 1.27e-4;

/// The instruments, as the spacecraft lends them for a second.
pub struct Instruments<'a, D, C, M, R> {
    /// The active-pixel detector behind both paths.
    pub detector: &'a mut D,
    /// Tells local time and Terrestrial Time.
    pub clock: &'a mut C,
    /// Receives the marks of the stages; `&mut ()` where nothing is measured.
    pub meter: &'a mut M,
    /// Tells how the body turns; `&mut ()` where there is none. Asked only where [`Parameters::rate_sensor`] says how good it is.
    pub rate_sensor: &'a mut R,
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

/// Why a sensor could not be made; its `Display` says what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorError {
    /// The parameters were refused.
    Parameters(ParameterError),
    /// The calibration is not the one that the parameters name, or not for this detector and optical centre.
    Calibration,
}

impl core::fmt::Display for SensorError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Parameters(error) => write!(f, "parameters refused: {error}"),
            Self::Calibration => f.write_str(
                "the calibration is not the one that the parameters name, or of another detector or optical centre",
            ),
        }
    }
}

impl core::error::Error for SensorError {}

/// Directions that depend on Terrestrial Time alone.
#[derive(Clone, Copy)]
struct Ephemeris {
    sun: Direction<Icrs>,
    pole: Direction<Icrs>,
}

/// A reading of the rate sensor that can serve at `now`, or why there is none.
fn usable(
    reading: Result<Option<AngularRate>, RateSensorError>,
    now: LocalTime,
) -> Result<AngularRate, RateSensorFault> {
    let reading = reading?.ok_or(RateSensorFault::Silent)?;
    if !(0..=READING_AGE_US).contains(&now.us_since(reading.instant)) {
        return Err(RateSensorFault::Stale);
    }
    let finite = reading.rad_s.iter().all(|axis| axis.is_finite());
    if finite { Ok(reading) } else { Err(RateSensorFault::NotFinite) }
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
    timekeeper: Timekeeper,
    /// Local time of this second: of its image, or of the call where none was used.
    now: LocalTime,
    /// Whether the catalogue's stars are corrected for aberration.
    aberration_corrected: bool,
    motion: Option<Filter<2>>,
    orbit: OrbitFilter,
    /// Terrestrial Time of the last fix that the orbit accepted.
    fixed_us: i64,
    converged: bool,
    /// Seconds in a row in which the limb's strips gave no centre.
    strip_misses: u8,
    /// Normalised innovation squared of this second's fix.
    nis: Option<f32>,
    /// Instant of the image under search.
    searching_since: Option<LocalTime>,
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
    /// Impossible parameters.
    pub fn new(
        catalogue: Catalogue<'c>,
        parameters: Parameters,
        workspace: &'c mut Workspace,
    ) -> Result<Self, SensorError> {
        let (camera, star_to_earth) = parameters.check().map_err(SensorError::Parameters)?;
        Ok(Self {
            catalogue,
            camera,
            calibration: None,
            parameters,
            star_to_earth,
            modes: Modes::default(),
            cycle: 0,
            timekeeper: Timekeeper::default(),
            now: LocalTime::default(),
            aberration_corrected: false,
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
    pub fn cycle<D: Detector, C: Clock, M: StageMeter, R: RateSensor>(
        &mut self,
        instruments: &mut Instruments<D, C, M, R>,
        command: Command,
    ) -> Report {
        let commanded = self.obey(command);
        let mut report = Report::new(self.cycle, self.modes.mode());
        if commanded {
            report.note(Event::Mode(self.modes.mode(), Guard::Commanded));
        }
        let Instruments { detector, clock, meter, rate_sensor } = instruments;
        let detector = &mut ByKind(&mut **detector);
        let (image, time) = self.take_image(detector, *clock, *meter);
        self.now = time.local;
        report.local_us = time.local.as_us();
        (report.instant_us, report.clock, report.clock_fault) = (time.terrestrial_us, time.state, time.fault);
        let ephemeris = self.update_ephemeris(*meter, &time, &mut report);
        report.rate_sensor_fault = self.propagate_gyro(*rate_sensor);
        self.work(detector, *meter, image, ephemeris.as_ref(), &mut report);
        self.report_orbit(&mut report);
        self.change_mode(&mut report);
        self.cycle = self.cycle.wrapping_add(1);
        report
    }

    /// Does what the spacecraft wants before the second begins; whether it wants another mode.
    fn obey(&mut self, command: Command) -> bool {
        let mode = match command {
            Command::Continue => return false,
            Command::Reacquire => Mode::Acquisition,
            Command::Restart => {
                self.forget_orbit();
                Mode::SelfTest
            }
            Command::Safe => Mode::Safe,
        };
        self.forget_attitude();
        self.modes.enter(mode);
        true
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

    /// What the mode does with the image: stars first, then the Earth.
    fn work(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        image: Image,
        ephemeris: Option<&Ephemeris>,
        report: &mut Report,
    ) {
        let mode = report.mode;
        match (mode, image) {
            (Mode::Safe, _) => report.status = Status::Waiting,
            (_, Image::Failed(fault)) => report.status = Status::DetectorFault(fault),
            (_, Image::Refused(fault)) => {
                report.status = Status::ImageRefused(fault);
                if mode != Mode::Acquisition {
                    self.report_predicted(report);
                }
            }
            (Mode::SelfTest, _) => self.self_test(detector, report),
            (_, Image::Blinded) => self.report_blinded(ephemeris, report),
            (Mode::Acquisition, _) => self.acquire_or_turn(detector, meter, report),
            (Mode::Tracking | Mode::Eclipse, _) => self.track(detector, meter, ephemeris, report),
            (Mode::SunOutage, _) => report.status = Status::Waiting,
        }
        self.check_sun_outage(mode);
        if let Some((attitude, ephemeris)) = self.attitude_of_this_second(report).zip(ephemeris) {
            self.look_at_earth(detector, meter, ephemeris, &attitude, report);
        }
    }

    /// In a Sun outage the filter's state is propagated every second: no step is longer, whatever the outage lasts.
    fn check_sun_outage(&mut self, mode: Mode) {
        if let (Mode::SunOutage, Some(motion)) = (mode, &mut self.motion) {
            motion.propagate(self.now, None);
        }
    }

    /// Propagates the attitude to this second by what the rate sensor tells of the one before; a reading that is old or not
    /// finite is none. Why there is none is returned.
    #[inline(never)]
    fn propagate_gyro(&mut self, sensor: &mut impl RateSensor) -> Option<RateSensorFault> {
        let (Some(noise), Some(motion)) = (self.parameters.rate_sensor, &mut self.motion) else {
            return None;
        };
        let reading = usable(sensor.angular_rate().map_err(|error| error.kind()), self.now);
        let to_star_path = self.star_to_earth.inverse();
        let rate_rad_s = reading.map(|reading| to_star_path.matrix() * Vector3::from(reading.rad_s));
        motion.propagate_gyro(self.now, noise, rate_rad_s.ok());
        reading.err()
    }

    /// Brings orbit, Sun, pole and aberration to the instant of the second. `None`, and stars without aberration, where
    /// Terrestrial Time is not known; the orbit goes on by local time all the same.
    #[inline(never)]
    fn update_ephemeris(
        &mut self,
        meter: &mut impl StageMeter,
        time: &Time,
        report: &mut Report,
    ) -> Option<Ephemeris> {
        meter.begin(Stage::Orbit);
        if time.fault == Some(ClockFault::CounterReset) {
            self.forget_attitude();
        }
        if let Some(step_us) = time.step_us {
            report.note(Event::ClockJump);
            self.orbit.shift_epoch(step_us);
            self.fixed_us = self.fixed_us.saturating_add(step_us);
        }
        if let Some(terrestrial_us) = time.terrestrial_us {
            let lost = self.orbit.advance(terrestrial_us, &self.parameters.orbit).is_err();
            if lost || self.orbit.is_stale(terrestrial_us.saturating_sub(self.fixed_us)) {
                self.forget_orbit();
                report.note(Event::OrbitForgotten);
            }
        }
        let known_us = time.terrestrial_us.filter(|_| time.state != ClockState::Unknown);
        self.aberration_corrected = known_us.is_some();
        // About the Sun, and about the Earth where that is known: up to 5 arcsec of 25.
        let velocity_km_s = known_us.map_or(Vector3::zeros(), |instant_us| {
            let orbital_km_s = self.orbit.state().map_or(Vector3::zeros(), |state| state.velocity_km_s);
            ephemeris::earth_velocity_km_s(instant_us) + orbital_km_s
        });
        self.catalogue.set_observer_velocity((velocity_km_s / LIGHT_KM_S).map(|axis| axis as f32));
        let ephemeris = known_us.map(|instant_us| Ephemeris {
            sun: ephemeris::sun_direction(instant_us),
            pole: ephemeris::pole(instant_us),
        });
        meter.end(Stage::Orbit);
        ephemeris
    }

    /// Lets the guards decide what comes next.
    fn change_mode(&mut self, report: &mut Report) {
        let blinded = report.status == Status::Blinded;
        let predicted = blinded || matches!(report.status, Status::ImageRefused(_));
        let seen = Seen {
            attitude: report.attitude.is_some() && !predicted,
            rate: self.motion.as_ref().is_some_and(|motion| motion.rate().is_some()),
            predicted: self.prediction_is_within_gate(),
            blinded,
            dark: match report.earth_status {
                EarthStatus::Dark => Some(true),
                EarthStatus::Faint | EarthStatus::Found => Some(false),
                EarthStatus::NotLooked | EarthStatus::Refused(_) => None,
            },
            fault: matches!(report.status, Status::DetectorFault(_)),
        };
        let before = self.modes.mode();
        let Some(guard) = self.modes.next(self.now, &seen, &self.parameters.modes) else { return };
        report.note(Event::Mode(self.modes.mode(), guard));
        // An attitude that was lost is not to be trusted again; one that was only predicted for too long is.
        let lost = guard == Guard::AttitudeLost
            || (before, self.modes.mode()) == (Mode::SunOutage, Mode::Acquisition);
        if lost || self.modes.mode() == Mode::Safe {
            self.forget_attitude();
        }
    }
}
