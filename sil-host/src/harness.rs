//! Flies a scenario: the world behind the detector trait, one [`Sensor::cycle`] a second.
//!
//! In: a [`Scenario`]. Out: every second, handed to a listener: the report, the truth and the judged errors.
//! Nothing depends on the time of day or on the number of cores, so a scenario and a seed give the same
//! seconds everywhere.

pub mod areas;
pub mod events;
pub mod faults;
mod shutters;
pub mod star_scene;
pub mod status;
mod watched;

use crate::error::HostError;
use crate::flight::{self, StarCalibration};
use crate::judge::Judged;
use crate::judge::second::image_cycle;
use crate::scenario::{Believed, Scenario};
use crate::world::attitude::Vector;
use crate::world::instruments::gyro::Gyro;
use crate::world::instruments::magnetometer::BodyMagnetometer;
use crate::world::scene::{Scene, Truth};
use faults::{Fault, Faulty};
use fsw_core::catalog::Catalogue;
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::defects::Defects;
use fsw_core::sensor::{Command, Instruments, Sensor, Workspace};
use fsw_core::telemetry::Report;
use fsw_hal::{
    AngularRate, Detector, DetectorError, DetectorGeometry, Instant, LocalTime, MagneticField, Magnetometer,
    OpenPaths, RateSensor, ReadingError, Shutter, Window,
};
use shutters::{Shuttered, Shutters};
use std::cell::Cell;
use watched::Watched;

/// A second that was flown.
#[derive(Clone, Copy, Debug)]
pub struct Second<'a> {
    /// Its number, from 0.
    pub cycle: u32,
    /// What the sensor reported.
    pub report: &'a Report,
    /// How it was.
    pub truth: &'a Truth,
    /// The errors.
    pub judged: &'a Judged,
    /// What the gyro read, where there is one and its range sufficed.
    pub rate: Option<AngularRate>,
    /// What the magnetometer read, where there is one and its range sufficed.
    pub field: Option<MagneticField>,
    /// The world, holding the image of this second where the sensor asked for one.
    pub scene: &'a Scene,
    /// What breaks in the run.
    pub faults: &'a [Fault],
    /// The windows that the sensor read, in that order.
    pub windows: &'a [Window],
}

/// The detector in one second: an exposure in it is one of that second, however many seconds went without.
#[derive(Debug)]
pub struct ThisSecond<'a> {
    /// The world.
    pub scene: &'a mut Scene,
    /// The second.
    pub cycle: u64,
    /// Its image's instant.
    pub instant: LocalTime,
}

impl fsw_hal::ErrorType for ThisSecond<'_> {
    type Error = DetectorError;
}

impl Detector for ThisSecond<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.scene.expose_cycle(self.cycle, exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        // An image of another second is one that was exposed before: its instant is as far back.
        let ago_s = self.scene.ago_s(self.cycle).ok_or(DetectorError::NotExposed)?;
        Ok(self.instant.plus_us(-(1e6 * ago_s).round() as i64))
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.scene.read(window, pixels)
    }
}

/// A second, us.
const SECOND_US: i64 = 1_000_000;
/// After a late second those that follow are called in haste, so far apart, until they are on time again, us.
const HASTE_US: i64 = 500_000;
/// The counter in the first second: the sensor is not the first that is switched on, us.
const POWERED_US: i64 = 10 * SECOND_US;

/// The truth of a second; a scenario's scene always has one.
pub fn truth_of(scene: &Scene, cycle: u32) -> Result<Truth, HostError> {
    scene.truth_at(cycle.into()).ok_or_else(|| no_truth(cycle))
}

fn no_truth(cycle: u32) -> HostError {
    HostError::usage(format!("second {cycle} has no truth"), "report this")
}

/// What flies in the world: the flight code, in this process or behind a link.
pub trait FlightCode {
    /// Its next second.
    ///
    /// # Errors
    /// Where it cannot be reached.
    fn second<D: Detector<Error = DetectorError>, R: RateSensor, B: Magnetometer, S: Shutter>(
        &mut self,
        instruments: &mut Instruments<'_, D, Instant, (), R, B, S>,
        command: Command<'_>,
    ) -> Result<Report, HostError>;
}

impl FlightCode for Sensor<'_> {
    fn second<D: Detector<Error = DetectorError>, R: RateSensor, B: Magnetometer, S: Shutter>(
        &mut self,
        instruments: &mut Instruments<'_, D, Instant, (), R, B, S>,
        command: Command<'_>,
    ) -> Result<Report, HostError> {
        Ok(self.cycle(instruments, command))
    }
}

impl<F: FlightCode> FlightCode for &mut F {
    fn second<D: Detector<Error = DetectorError>, R: RateSensor, B: Magnetometer, S: Shutter>(
        &mut self,
        instruments: &mut Instruments<'_, D, Instant, (), R, B, S>,
        command: Command<'_>,
    ) -> Result<Report, HostError> {
        F::second(self, instruments, command)
    }
}

/// A scenario under way: the world, and the flight code in it.
pub struct Flight<'a, F = Sensor<'a>> {
    scenario: &'a Scenario,
    scene: &'a mut Scene,
    flight_code: F,
    cycle: u32,
    /// By how much the second before was late, us.
    late_us: i64,
    /// What breaks: the scenario's faults, then those injected in flight.
    faults: Vec<Fault>,
    /// The windows read in the second.
    windows: Vec<Window>,
    /// Where the shutters stand.
    stand: Cell<OpenPaths>,
    /// By what the paths are turned against what the flight code is told, rad.
    misalignment_rad: Vector,
    /// The file of the detector's defects as they are known on board.
    defects: Vec<u8>,
}

/// By how much a second is late after one that was late by `before_us`, us.
fn late_after_us(faults: &[Fault], cycle: u32, before_us: i64) -> i64 {
    let late_us = (faults::lateness_s(faults, cycle) * 1e6) as i64;
    late_us.max(before_us - SECOND_US + HASTE_US).max(0)
}

/// By how much a second of a run with these faults is late, us.
pub fn late_us(faults: &[Fault], cycle: u32) -> i64 {
    (0..=cycle).fold(0, |before_us, cycle| late_after_us(faults, cycle, before_us))
}

/// The sensor as a scenario has it at the start; `catalogue` and `calibration` are those of its camera.
///
/// # Errors
/// When the flight code refuses the scenario.
pub fn sensor<'a>(
    scenario: &Scenario,
    catalogue: Catalogue<'a>,
    calibration: Option<&'a StarCalibration>,
    workspace: &'a mut Workspace,
) -> Result<Sensor<'a>, HostError> {
    let calibration = calibration.and_then(StarCalibration::open);
    let parameters = scenario.flight_parameters(calibration.as_ref());
    let mut sensor = flight::sensor(catalogue, calibration, parameters, workspace).map_err(|error| {
        let what = format!("the flight code refuses the scenario ({error:?})");
        HostError::input(&scenario.file, None, what, "change what it names")
    })?;
    if let Some((state, start)) = scenario.ground_state().zip(scenario.orbit_filter.start) {
        let velocity_sigma_km_s = 1e-3 * start.velocity_sigma_m_s;
        if !sensor.initialise_orbit(state, start.position_sigma_km, velocity_sigma_km_s) {
            let what = "the flight code refuses the state of orbit_filter.start";
            return Err(HostError::input(&scenario.file, None, what, "give smaller errors"));
        }
    }
    Ok(sensor)
}

/// Catalogue and calibration of a scenario's camera.
///
/// # Errors
/// When there are none for it.
pub fn tables(scenario: &Scenario) -> Result<(Catalogue<'static>, Option<StarCalibration>), HostError> {
    let camera = flight::camera(&scenario.believed_camera(), &scenario.file)?;
    Ok((flight::flight_catalogue(&camera, &scenario.file)?, scenario.calibration()?))
}

impl<'a> Flight<'a> {
    /// At the start; `catalogue` and `calibration` are those of the scenario's camera.
    ///
    /// # Errors
    /// When the flight code refuses the scenario.
    pub fn new(
        scenario: &'a Scenario,
        scene: &'a mut Scene,
        catalogue: Catalogue<'a>,
        calibration: Option<&'a StarCalibration>,
        workspace: &'a mut Workspace,
    ) -> Result<Self, HostError> {
        Ok(Self::of(scenario, scene, sensor(scenario, catalogue, calibration, workspace)?))
    }
}

impl<'a, F: FlightCode> Flight<'a, F> {
    /// At the start, with flight code that has not flown a second yet.
    pub fn of(scenario: &'a Scenario, scene: &'a mut Scene, flight_code: F) -> Self {
        let faults = scenario.faults.clone();
        let stand = Cell::new(OpenPaths::Both);
        let misalignment_rad = scenario.believed.misalignment_rad(&scenario.mount, &scenario.camera);
        Self {
            scenario,
            scene,
            flight_code,
            cycle: 0,
            late_us: 0,
            faults,
            windows: Vec::new(),
            stand,
            misalignment_rad,
            defects: scenario.known_defects(),
        }
    }

    /// From now on this breaks too, when its seconds come; what broke before is not changed by it.
    pub fn inject(&mut self, fault: Fault) {
        self.faults.push(fault);
    }

    /// The next second, handed to `listen`.
    ///
    /// # Errors
    /// When `listen` fails.
    pub fn second(
        &mut self,
        listen: impl FnOnce(Second<'_>) -> Result<(), HostError>,
    ) -> Result<(), HostError> {
        let (scenario, cycle) = (self.scenario, self.cycle);
        self.late_us = late_after_us(&self.faults, cycle, self.late_us);
        self.scene.delay(self.late_us as f64 * 1e-6);
        self.scene.storm(faults::storm_hits(&self.faults, cycle));
        self.windows.clear();
        let truth = truth_of(self.scene, cycle)?;
        let elapsed_us = POWERED_US + i64::from(cycle) * SECOND_US + self.late_us;
        let clock = scenario.believed.clock(elapsed_us, scenario.instant_us(cycle) + self.late_us);
        let local = clock.local;
        let mut clock = faults::faulty_clock(&self.faults, cycle, clock);
        let detector = ThisSecond { scene: self.scene, cycle: cycle.into(), instant: local };
        let mut detector = Shuttered { detector, stand: &self.stand };
        let stuck = faults::shutters_are_stuck(&self.faults, cycle);
        let shutter = &mut Shutters { stand: &self.stand, stuck };
        let mut detector = Faulty::new(&mut detector, &self.faults, scenario.seed, (cycle, local));
        let mut detector = corrected(&mut detector, &self.defects)?;
        let mut detector = Watched { detector: &mut detector, windows: &mut self.windows };
        let command = match scenario.held_open.filter(|_| cycle == 0) {
            Some(paths) => Command::Shutter(Some(paths)),
            None => faults::command(&self.faults, scenario.seed, cycle),
        };
        let mut gyro = gyro_of(scenario, (cycle, local), &truth, &self.faults);
        let mut magnetometer = magnetometer_of(scenario, (cycle, local), &truth, &self.faults);
        let report = self.flight_code.second(
            &mut Instruments {
                detector: &mut detector,
                clock: &mut clock,
                meter: &mut (),
                rate_sensor: &mut gyro,
                magnetometer: &mut magnetometer,
                shutter,
            },
            command,
        )?;
        let image = image_cycle(&report);
        let seen = self.scene.seen_at(image.into()).ok_or_else(|| no_truth(image))?;
        let truth = if image == cycle { seen } else { truth };
        let judged = Judged::new(&report, &truth, &seen)
            .with_shutters(scenario.shutters)
            .with_mounting(&report, self.misalignment_rad);
        listen(Second {
            cycle,
            report: &report,
            truth: &truth,
            judged: &judged,
            rate: gyro.and_then(|mut gyro| gyro.angular_rate().ok().flatten()),
            field: magnetometer.and_then(|mut read| read.magnetic_field().ok().flatten()),
            scene: self.scene,
            faults: &self.faults,
            windows: &self.windows,
        })?;
        self.cycle += 1;
        Ok(())
    }
}

/// A detector behind a driver that takes off the defects of a file; none of one that says that it is another
/// detector, which the flight code refuses.
///
/// # Errors
/// When the file is damaged.
pub fn corrected<'a, D: Detector>(
    detector: &'a mut D,
    file: &'a [u8],
) -> Result<BadPixelDetector<'a, D>, HostError> {
    let DetectorGeometry { width_px, height_px, .. } = detector.geometry();
    let size_px = [width_px, height_px];
    let of_this =
        |known: Defects<'a>| if known.size_px() == size_px { known } else { Defects::none(size_px) };
    Defects::open(file).and_then(|known| BadPixelDetector::new(detector, of_this(known))).map_err(|error| {
        HostError::usage(format!("the table of bad pixels is refused ({error:?})"), "report this")
    })
}

/// The gyro behind a driver with the believed scale, with its faults.
struct DrivenGyro<'t> {
    gyro: Gyro<'t>,
    believed: &'t Believed,
    faults: &'t [Fault],
    cycle: u32,
}

impl fsw_hal::ErrorType for DrivenGyro<'_> {
    type Error = ReadingError;
}

impl RateSensor for DrivenGyro<'_> {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, ReadingError> {
        let reading = self.gyro.angular_rate()?;
        let driven = |AngularRate { instant, rad_s }| AngularRate {
            instant,
            rad_s: self.believed.gyro_reading(rad_s),
        };
        Ok(faults::faulty_rate(self.faults, self.cycle, reading.map(driven)))
    }
}

/// The gyro in a second, where there is one.
fn gyro_of<'t>(
    scenario: &'t Scenario,
    (cycle, instant): (u32, LocalTime),
    truth: &'t Truth,
    faults: &'t [Fault],
) -> Option<DrivenGyro<'t>> {
    let model = scenario.gyro.as_ref()?;
    let gyro = Gyro { model, seed: scenario.seed, cycle: cycle.into(), instant, truth };
    Some(DrivenGyro { gyro, believed: &scenario.believed, faults, cycle })
}

/// The magnetometer with its faults.
struct FaultyMagnetometer<'t> {
    magnetometer: BodyMagnetometer<'t>,
    faults: &'t [Fault],
    cycle: u32,
}

impl fsw_hal::ErrorType for FaultyMagnetometer<'_> {
    type Error = ReadingError;
}

impl Magnetometer for FaultyMagnetometer<'_> {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, ReadingError> {
        Ok(faults::faulty_field(self.faults, self.cycle, self.magnetometer.magnetic_field()?))
    }
}

/// The magnetometer in a second, where there is one.
fn magnetometer_of<'t>(
    scenario: &'t Scenario,
    (cycle, instant): (u32, LocalTime),
    truth: &'t Truth,
    faults: &'t [Fault],
) -> Option<FaultyMagnetometer<'t>> {
    let model = scenario.magnetometer.as_ref()?;
    let magnetometer = BodyMagnetometer { model, seed: scenario.seed, cycle: cycle.into(), instant, truth };
    Some(FaultyMagnetometer { magnetometer, faults, cycle })
}

/// Makes the scenario's flight in the world and hands it to `fly`, which lets its seconds go by.
///
/// # Errors
/// When the world or the flight code refuses the scenario, or `fly` fails.
pub fn with_flight<T>(
    scenario: &Scenario,
    scene: &mut Scene,
    fly: impl FnOnce(&mut Flight<'_>) -> Result<T, HostError>,
) -> Result<T, HostError> {
    let (catalogue, calibration) = tables(scenario)?;
    let mut workspace = Box::new(Workspace::new());
    let flown = fly(&mut Flight::new(scenario, scene, catalogue, calibration.as_ref(), &mut workspace)?);
    scene.storm(0);
    scene.open(OpenPaths::Both);
    flown
}

/// Flies the scenario and hands every second to `listen`.
///
/// # Errors
/// When the world or the flight code refuses the scenario, or `listen` fails.
pub fn fly(
    scenario: &Scenario,
    scene: &mut Scene,
    mut listen: impl FnMut(Second<'_>) -> Result<(), HostError>,
) -> Result<(), HostError> {
    with_flight(scenario, scene, |flight| {
        (0..scenario.duration_s).try_for_each(|_| flight.second(&mut listen))
    })
}
