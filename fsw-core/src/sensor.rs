//! The second, top to bottom: one call a room.
//!
//! [`Sensor::cycle`] is called once a second. Before it begins parameters, catalogue, calibration and what
//! the last second left are checked against upsets of their memory (`scrubbing`), and the spacecraft's
//! command is done (`commanding`). Then:
//!
//! 1. the shutters are moved as the second before decided, and the image that the mode asks for is taken
//!    (`exposing`); its mid-exposure instant is that of the second,
//!    the counter's where none was asked for or may be used (`timekeeping`);
//! 2. orbit and attitude are propagated to that instant; Sun, pole and the observer's velocity (aberration)
//!    are those of it (`propagation`); the magnetometer is read, and where the image shows no stars it checks
//!    and corrects the attitude that is carried on (`magnetism`);
//! 3. the mode says what is done with the image: a self-test, the whole field searched for stars
//!    (`acquisition`, over several seconds if need be, on the stars of that one image, then on those of
//!    another), or for streaks and the rate (`turning`), predicted stars followed in windows (`tracking`), or
//!    only whether the Sun still blinds (`outage`); the filter takes the attitude in (`attitude`);
//! 4. with an attitude from this second's image the Earth is looked at (`earth`): in strips about the limb
//!    where the orbit or the last fix predicts it, else on a grid over the whole detector; its centre is a
//!    position, which the orbit filter takes in (`orbit`). With the star path shut it is the other way round:
//!    orbit, Earth and magnetic field or terminator give the attitude. Around a dark Earth the Earth path may
//!    show stars, and they how the paths are mounted (`mounting`);
//! 5. a path that the Sun is about to enter is to be shut, and the Earth path's filter to be in it before
//!    light of the Earth comes (`outage`), the guards decide the next mode; the report is made of the
//!    `record` of the second.
//!
//! A stage takes what it needs as arguments and returns what it found, or fills the part of the record that
//! is its own. What is generic over the instruments calls them and no more; the work between two calls is
//! not, and is compiled once.
//!
//! Memory: [`Workspace`] holds what is large, the readout buffer of 16 KiB and the chains of identification,
//! and can be placed in a static; [`Sensor`] itself is small, and the stack serves a few KiB of lists. The
//! parts of a second are not inlined into it, so that their lists do not lie on the stack together.

mod acquisition;
mod attitude;
mod commanding;
mod earth;
mod exposing;
mod forecasting;
mod freshness;
mod magnetism;
mod motion;
mod mounting;
mod orbit;
mod outage;
mod propagation;
mod record;
mod resuming;
mod scrubbing;
mod timekeeping;
mod tracking;
mod turning;
mod workspace;

use crate::camera::Camera;
use crate::camera::focal_length::FocalLength;
use crate::catalog::Catalogue;
pub use crate::command::Command;
use crate::command::Downlink;
use crate::earth::ground::UsualGround;
use crate::frames::{EarthPath, Icrs, Rotation, StarPath};
use crate::image::calibration::Calibration;
use crate::image::fingerprint::Fingerprint;
use crate::magnetism::Magnetism;
use crate::modes::{Guard, Mode, Modes};
use crate::orbit::filter::OrbitFilter;
use crate::parameters::{ParameterError, Parameters};
use crate::shutting::Shutting;
use crate::telemetry::{Activity, DetectorFault, Event, Outcome, ReadingFault, Report};
use core::mem::MaybeUninit;
use exposing::Image;
use fsw_hal::detector::ByKind;
use fsw_hal::{
    Clock, Detector, DetectorError, Error, LocalTime, Magnetometer, RateSensor, Shutter, Stage, StageMeter,
};
use motion::Motion;
use nalgebra::Vector3;
use propagation::Ephemeris;
use record::{Events, Record, StarRecord};
use scrubbing::{Scrubber, Seal, Spare};
pub use timekeeping::INSTANTS_US;
use timekeeping::Timekeeper;
pub use workspace::{MAX_BASE_SIDES, MAX_TRIANGLES, Workspace};

/// The instruments, as the spacecraft lends them for a second.
pub struct Instruments<'a, D, C, M, R, B, S> {
    /// The active-pixel detector behind both paths.
    pub detector: &'a mut D,
    /// Local time and Terrestrial Time.
    pub clock: &'a mut C,
    /// Receives the marks of the stages; `&mut ()` where nothing is measured.
    pub meter: &'a mut M,
    /// The body's rate; `&mut ()` where there is none. Asked only where [`Parameters::rate_sensor`] says how
    /// good it is.
    pub rate_sensor: &'a mut R,
    /// The magnetic field along the body's axes; `&mut ()` where there is none. Asked only where
    /// [`Parameters::magnetometer`] says how good it is.
    pub magnetometer: &'a mut B,
    /// The shutters of the paths; `&mut ()` where there are none. Asked only where [`Parameters::shutter`]
    /// says which there are.
    pub shutter: &'a mut S,
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

/// Whether a calibration is the one that the parameters name, of their detector and their optical centre.
pub fn calibration_fits(parameters: &Parameters, calibration: &Calibration) -> bool {
    let camera = &parameters.camera;
    calibration.crc() == parameters.imaging.calibration_crc
        && calibration.is_of([camera.width_px, camera.height_px], camera.optical_centre_px)
}

/// The Earth/star sensor.
pub struct Sensor<'c> {
    catalogue: Catalogue<'c>,
    camera: Camera,
    focal_length: FocalLength,
    calibration: Option<Calibration<'c>>,
    parameters: Parameters,
    star_to_earth: Rotation<StarPath, EarthPath>,
    /// The last three once more.
    spare: Spare,
    scrubber: Scrubber,
    seal: Seal,
    modes: Modes,
    cycle: u32,
    timekeeper: Timekeeper,
    /// Local time of this second: of its image, or of the call where none was used.
    now: LocalTime,
    /// Instant of the image in which spots were sought last.
    sought: LocalTime,
    /// Exposure of the last image that was asked for, us.
    exposure_us: u32,
    /// Whether the catalogue's stars are corrected for aberration.
    aberration_corrected: bool,
    motion: Motion,
    /// The attitude measured last: a hypothesis for the stars, nothing that is told.
    former: Option<Rotation<Icrs, StarPath>>,
    /// The likeliest attitude of the last search that found none, and the instant of its image: a hypothesis
    /// too.
    likeliest: Option<(Rotation<Icrs, StarPath>, LocalTime)>,
    orbit: OrbitFilter,
    shutting: Shutting,
    forecasting: forecasting::Forecasting,
    /// Of the last image in which stars were sought in windows.
    followed: tracking::Followed,
    /// How the turn changes within the image whose stars are known or sought.
    turn_change: tracking::TurnChange,
    /// Attitudes in a row that contradict the rate sensor.
    rate_sensor_doubts: u8,
    magnetism: Magnetism,
    /// Terrestrial Time of the last fix that the orbit accepted.
    fixed_us: i64,
    converged: bool,
    /// Brightness of the ground at the limb that is usual.
    usual_ground: UsualGround,
    /// Seconds in a row in which the Earth was looked for without a centre.
    earth_misses: u8,
    /// Line of sight of the Earth path, ICRS, in the last image whose stars told how it is mounted; 0 before
    /// one did.
    mounting_seen_at: Vector3<f32>,
    /// Of the last two images, and of the last one that was not disturbed.
    fingerprints: [Fingerprint; 3],
    /// What is usual of the images' noise, and the last attitude of an image that is known to be new.
    freshness: freshness::Freshness,
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
        let checked = parameters.check().map_err(SensorError::Parameters)?;
        Ok(Self::assembled(catalogue, parameters, checked, None, workspace))
    }

    /// The same in its place, with what is known of its lens: the sensor does not pass over the stack.
    ///
    /// # Errors
    /// Impossible parameters; a calibration that belongs to another lens. The place then is as before.
    #[inline(never)]
    pub fn new_in<'p>(
        place: &'p mut MaybeUninit<Self>,
        catalogue: Catalogue<'c>,
        parameters: Parameters,
        calibration: Option<Calibration<'c>>,
        workspace: &'c mut Workspace,
    ) -> Result<&'p mut Self, SensorError> {
        let checked = parameters.check().map_err(SensorError::Parameters)?;
        if calibration.as_ref().is_some_and(|calibration| !calibration_fits(&parameters, calibration)) {
            return Err(SensorError::Calibration);
        }
        Ok(place.write(Self::assembled(catalogue, parameters, checked, calibration, workspace)))
    }

    #[inline(always)]
    fn assembled(
        catalogue: Catalogue<'c>,
        parameters: Parameters,
        (camera, star_to_earth): (Camera, Rotation<StarPath, EarthPath>),
        calibration: Option<Calibration<'c>>,
        workspace: &'c mut Workspace,
    ) -> Self {
        let spare = Spare::new(&parameters, &camera, &star_to_earth);
        let (modes, timekeeper) = (Modes::default(), Timekeeper::default());
        Self {
            catalogue,
            camera,
            focal_length: FocalLength::new(parameters.identification.scale_uncertainty),
            calibration,
            parameters,
            star_to_earth,
            spare,
            scrubber: Scrubber::default(),
            seal: Seal::new(&modes, &timekeeper, Shutting::default()),
            modes,
            cycle: 0,
            timekeeper,
            now: LocalTime::default(),
            sought: LocalTime::default(),
            exposure_us: 0,
            aberration_corrected: false,
            motion: Motion::default(),
            former: None,
            likeliest: None,
            orbit: OrbitFilter::new(),
            shutting: Shutting::default(),
            forecasting: forecasting::Forecasting::default(),
            followed: tracking::Followed::default(),
            turn_change: tracking::TurnChange::Steady,
            rate_sensor_doubts: 0,
            magnetism: Magnetism::default(),
            fixed_us: 0,
            converged: false,
            usual_ground: UsualGround::default(),
            earth_misses: 0,
            mounting_seen_at: Vector3::zeros(),
            fingerprints: [Fingerprint::default(); 3],
            freshness: freshness::Freshness::default(),
            searching_since: None,
            turning: turning::Turning::default(),
            images_given_up: 0,
            workspace,
        }
    }

    /// The same with what is known of its lens.
    ///
    /// # Errors
    /// [`SensorError::Calibration`] where it belongs to another lens.
    pub fn calibrated(self, calibration: Calibration<'c>) -> Result<Self, SensorError> {
        if !calibration_fits(&self.parameters, &calibration) {
            return Err(SensorError::Calibration);
        }
        Ok(Self { calibration: Some(calibration), ..self })
    }

    /// One second.
    #[inline(never)]
    pub fn cycle<D: Detector, C: Clock, M: StageMeter, R: RateSensor, B: Magnetometer, S: Shutter>(
        &mut self,
        instruments: &mut Instruments<D, C, M, R, B, S>,
        command: Command,
    ) -> Report {
        let mut events = Events::default();
        self.scrub(&mut events);
        let outcome = self.obey(&command, &mut events);
        let Instruments { detector, clock, meter, rate_sensor, magnetometer, shutter } = instruments;
        if meter.overran() {
            events.note(Event::Overran);
        }
        let detector = &mut ByKind(&mut **detector);
        let open = self.shutting.open();
        let moved = self.parameters.shutter.map_or(Ok(()), |_| shutter.open(open));
        let (image, time) = self.take_image(detector, *clock, *meter);
        self.now = time.local;
        let mut record = Record::new(self.cycle, self.modes.mode(), time, events);
        record.command = outcome;
        record.open = open;
        record.exposure_us = (image != Image::NotAsked).then_some(self.exposure_us);
        record.shutter_fault = moved.err().map(|error| error.kind().into());
        meter.begin(Stage::Orbit);
        let ephemeris = self.update_ephemeris(&record.time, &mut record.fix, &mut record.events);
        meter.end(Stage::Orbit);
        let shut_out = self.rate_sensor_is_shut_out();
        self.ask_rate_sensor(*rate_sensor, &mut record);
        self.ask_magnetometer(*magnetometer, ephemeris.as_ref(), &mut record);
        self.observe(detector, *meter, image, ephemeris.as_ref(), &mut record);
        self.shut_against_sun(image, ephemeris.as_ref(), &record.stars);
        if self.rate_sensor_is_shut_out() && !shut_out {
            record.events.note(Event::RateSensorShutOut);
        }
        record.state =
            ephemeris.as_ref().and_then(|known| self.state(known, (image, open), record.earth.dark));
        self.conclude_second(*meter, &mut record);
        let stars = (&self.workspace.measured[..], &self.catalogue);
        record.report(stars, self.workspace.shared.limb_points(), &self.magnetism)
    }

    /// The parameter table in force.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// What the command link sends down where it is asked for.
    pub fn downlink(&self) -> Downlink<'_> {
        Downlink {
            parameters: &self.parameters,
            image: self.sought,
            spots: self.workspace.detections.spots(),
        }
    }

    fn forget_attitude(&mut self) {
        self.lose_attitude();
        (self.motion, self.former) = (Motion::default(), None);
    }

    /// Attitudes near to which the stars are sought first: the last one measured, and the one predicted by
    /// the rate.
    fn hypotheses(&self) -> [Option<Rotation<Icrs, StarPath>>; 2] {
        let carried = self.motion.any().and_then(|motion| motion.at(self.now));
        [self.former, carried.map(|(attitude, _)| attitude)]
    }

    /// As [`Self::forget_attitude`], but stars are first sought where the attitude would have them.
    fn lose_attitude(&mut self) {
        self.motion.lose();
        self.likeliest = None;
        self.searching_since = None;
        self.turning.forget();
        self.images_given_up = 0;
    }

    /// Forgets the orbit and what it learned of the mounting.
    fn forget_orbit(&mut self) {
        self.orbit.reset();
        self.mounting_seen_at = Vector3::zeros();
        self.lose_orbit();
    }

    /// Forgets the orbit alone, which nothing has contradicted.
    fn lose_orbit(&mut self) {
        self.orbit.lose();
        self.converged = false;
        self.earth_misses = 0;
    }

    /// Propagates the attitude by the rate sensor, where there is one to be asked.
    #[inline(never)]
    fn ask_rate_sensor(&mut self, rate_sensor: &mut impl RateSensor, record: &mut Record) {
        if self.rate_sensor_is_shut_out() {
            record.rate_sensor_fault = Some(ReadingFault::ShutOut);
        } else if self.needs_rate() {
            let reading = rate_sensor.angular_rate().map_err(|error| error.kind());
            let reading = reading.map(|reading| reading.map(|rate| (rate.instant, rate.rad_s)));
            record.rate_sensor_fault = self.propagate_gyro(reading);
        }
    }

    /// Takes the magnetic field of the second, where there is a magnetometer to be asked and an orbit.
    #[inline(never)]
    fn ask_magnetometer(
        &mut self,
        magnetometer: &mut impl Magnetometer,
        ephemeris: Option<&Ephemeris>,
        record: &mut Record,
    ) {
        let (Some(errors), Some(_)) = (self.parameters.magnetometer, self.orbit.state()) else { return };
        self.magnetism.propagate(1.0, &errors);
        if self.magnetism.is_shut_out() {
            record.magnetometer_fault = Some(ReadingFault::ShutOut);
        } else {
            let reading = magnetometer.magnetic_field().map_err(|error| error.kind());
            let reading = reading.map(|reading| reading.map(|field| (field.instant, field.ut)));
            self.take_field(reading, ephemeris, record);
        }
    }

    /// What is done with the image: stars first, then the Earth.
    fn observe(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        image: Image,
        ephemeris: Option<&Ephemeris>,
        record: &mut Record,
    ) {
        let mode = record.mode;
        record.image_fault = image.fault();
        if image != Image::Taken || !self.shutting.open().star() {
            self.hold_by_field(record);
        }
        let observed = self.observe_stars(detector, meter, (mode, image), ephemeris, &mut record.stars);
        record.detector_fault = observed.err();
        if mode != Mode::SunOutage
            && record.stars.outcome == Some(Outcome::Blinded)
            && ephemeris.is_some_and(|ephemeris| self.sun_is_in_path(ephemeris))
        {
            record.events.note(Event::SunInPath);
        }
        self.propagate_in_outage(mode);
        if let Some((attitude, ephemeris)) = record.stars.own_attitude().zip(ephemeris) {
            self.learn_zero(&attitude, record);
            if record.open.clear() {
                match self.measure_mounting(detector, meter, ephemeris, &attitude) {
                    Ok(stars) => record.earth_path_stars = stars,
                    Err(error) => record.detector_fault = Some(error.into()),
                }
            }
            match self.measure_earth(detector, meter, ephemeris, &attitude, &mut record.events) {
                Ok((looked, fix)) => {
                    record.earth = looked;
                    record.fix.add(fix);
                }
                Err(error) => record.detector_fault = Some(error.into()),
            }
        } else if let (Some(Outcome::StarPathShut), Some(ephemeris)) = (record.stars.outcome, ephemeris) {
            let observed = self.observe_earth_alone(detector, meter, ephemeris, record);
            record.detector_fault = observed.err().map(DetectorFault::from);
        }
    }

    /// What the mode does with the image: the one step that fills the record of the stars.
    fn observe_stars(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        (mode, image): (Mode, Image),
        ephemeris: Option<&Ephemeris>,
        stars: &mut StarRecord,
    ) -> Result<(), DetectorFault> {
        match (mode, image) {
            (Mode::CommandedSafe, _) => {}
            (_, Image::Failed(fault)) => return Err(fault),
            (_, Image::Refused(_)) => self.propagate_only(None, stars),
            (Mode::SelfTest | Mode::Safe, _) => {
                stars.activity = Activity::SelfTest;
                stars.outcome = Some(self.self_test(detector)?);
            }
            (_, Image::Blinded) => self.propagate_only(Some(Outcome::Blinded), stars),
            _ if !self.shutting.open().star() => self.propagate_only(Some(Outcome::StarPathShut), stars),
            (Mode::Acquisition | Mode::SunOutage, _) => {
                self.acquire_or_turn(detector, meter, ephemeris, stars)?;
            }
            (Mode::Tracking | Mode::Eclipse, _) => {
                stars.activity = Activity::StarTracking;
                stars.outcome = Some(self.track(detector, meter, ephemeris, stars)?);
            }
        }
        Ok(())
    }

    /// A second without stars: the attitude is predicted, as long as that can be told.
    fn propagate_only(&self, outcome: Option<Outcome>, stars: &mut StarRecord) {
        stars.activity = Activity::Propagation;
        stars.outcome = outcome;
        stars.solution = self.propagated(true);
    }

    /// The orbit as it stands, what is foreseen by it, and the next mode.
    #[inline(never)]
    fn conclude_second(&mut self, meter: &mut impl StageMeter, record: &mut Record) {
        record.orbit = self.orbit_report(record.fix.nis, &mut record.events);
        record.local = self.local_attitude(record.stars.solution.as_ref());
        meter.begin(Stage::Orbit);
        record.next_state = self.look_ahead(record);
        meter.end(Stage::Orbit);
        self.change_mode(record);
        self.cycle = self.cycle.wrapping_add(1);
        self.seal(record.orbit.as_ref());
    }

    /// Lets the guards decide what comes next.
    fn change_mode(&mut self, record: &mut Record) {
        let inputs = record.mode_inputs(self.prediction_is_within_gate());
        let before = self.modes.mode();
        let Some(guard) = self.modes.next(self.now, &inputs, &self.parameters.modes) else { return };
        record.events.note(Event::Mode(self.modes.mode(), guard));
        // An attitude that was lost is not to be trusted again, nor one that was only predicted for too long.
        let lost = guard == Guard::AttitudeLost
            || (before, self.modes.mode()) == (Mode::SunOutage, Mode::Acquisition) && !inputs.attitude;
        if lost || self.modes.mode().is_safe() {
            self.lose_attitude();
        }
    }
}
