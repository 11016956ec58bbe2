//! Flies a scenario: the world behind the detector trait, one [`Sensor::cycle`] a second.
//!
//! In: a [`Scenario`]. Out: every second, handed to a listener: the report, the truth and the judged errors. Nothing
//! depends on the time of day or on the number of cores, so a scenario and a seed give the same seconds everywhere.

use crate::error::HostError;
use crate::flight;
use crate::judge::Judged;
use crate::judge::second::image_cycle;
use crate::run::faults::{Fault, Faulty};
use crate::scenario::Scenario;
use crate::world::gyro::Gyro;
use crate::world::magnetometer::BodyMagnetometer;
use crate::world::scene::{Scene, Truth};
use fsw_core::catalog::Catalogue;
use fsw_core::sensor::{Command, Instruments, Sensor, Workspace};
use fsw_core::telemetry::Report;
use fsw_hal::{
    AngularRate, Detector, DetectorError, DetectorGeometry, Instant, MagneticField, Magnetometer, RateSensor,
    Window,
};

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
    /// What the gyro told, where there is one and its range sufficed.
    pub rate: Option<AngularRate>,
    /// What the magnetometer told, where there is one and its range sufficed.
    pub field: Option<MagneticField>,
    /// The world, holding the image of this second where the sensor asked for one.
    pub scene: &'a Scene,
    /// What breaks in the run.
    pub faults: &'a [Fault],
}

/// The detector in one second: an exposure in it is one of that second, however many seconds went without.
#[derive(Debug)]
pub struct ThisSecond<'a> {
    /// The world.
    pub scene: &'a mut Scene,
    /// The second.
    pub cycle: u64,
}

impl Detector for ThisSecond<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }

    fn expose(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.scene.expose_cycle(self.cycle, exposure_us)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.scene.read(window, pixels)
    }
}

/// The truth of a second; a scenario's scene always has one.
pub fn truth_of(scene: &Scene, cycle: u32) -> Result<Truth, HostError> {
    let missing = || HostError::usage(format!("second {cycle} has no truth"), "report this");
    scene.truth_at(cycle.into()).ok_or_else(missing)
}

/// A scenario under way: the world, and the flight code in it.
pub struct Flight<'a> {
    scenario: &'a Scenario,
    scene: &'a mut Scene,
    sensor: Sensor<'a>,
    cycle: u32,
}

impl<'a> Flight<'a> {
    /// At the start; `catalogue` is that of the scenario's camera.
    ///
    /// # Errors
    /// When the flight code refuses the scenario.
    pub fn new(
        scenario: &'a Scenario,
        scene: &'a mut Scene,
        catalogue: Catalogue<'a>,
        workspace: &'a mut Workspace,
    ) -> Result<Self, HostError> {
        let calibration = scenario.calibration()?;
        let parameters = scenario.flight_parameters(calibration.as_ref());
        let sensor = flight::sensor(catalogue, calibration, parameters, workspace).map_err(|error| {
            let what = format!("the flight code refuses the scenario ({error:?})");
            HostError::input(&scenario.file, None, what, "change what it names")
        })?;
        Ok(Self { scenario, scene, sensor, cycle: 0 })
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
        let truth = truth_of(self.scene, cycle)?;
        let mut clock = Instant(scenario.instant_us(cycle));
        let mut detector = ThisSecond { scene: self.scene, cycle: cycle.into() };
        let mut detector = Faulty::new(&mut detector, &scenario.faults, scenario.seed, cycle);
        let mut gyro = gyro_of(scenario, cycle, &truth);
        let mut instruments = Instruments {
            detector: &mut detector,
            clock: &mut clock,
            meter: &mut (),
            rate_sensor: gyro.as_mut().map(|gyro| gyro as &mut dyn RateSensor),
        };
        let report = self.sensor.cycle(&mut instruments, Command::Continue);
        let image = image_cycle(&report);
        let judged = if image == cycle {
            Judged::new(&report, &truth, &truth)
        } else {
            Judged::new(&report, &truth, &truth_of(self.scene, image)?)
        };
        listen(Second {
            cycle,
            report: &report,
            truth: &truth,
            judged: &judged,
            rate: gyro.and_then(|mut gyro| gyro.angular_rate().ok().flatten()),
            field: field_of(scenario, cycle, &truth),
            scene: self.scene,
            faults: &scenario.faults,
        })?;
        self.cycle += 1;
        Ok(())
    }
}

/// The gyro in a second, where there is one.
fn gyro_of<'t>(scenario: &'t Scenario, cycle: u32, truth: &'t Truth) -> Option<Gyro<'t>> {
    let model = scenario.gyro.as_ref()?;
    Some(Gyro { model, seed: scenario.seed, cycle: cycle.into(), truth })
}

/// What the magnetometer tells in a second.
fn field_of(scenario: &Scenario, cycle: u32, truth: &Truth) -> Option<MagneticField> {
    let model = scenario.magnetometer.as_ref()?;
    BodyMagnetometer { model, seed: scenario.seed, cycle: cycle.into(), truth }
        .magnetic_field()
        .ok()
        .flatten()
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
    let camera = flight::camera(&scenario.camera, &scenario.file)?;
    let catalogue = flight::flight_catalogue(&camera, &scenario.file)?;
    let mut workspace = Box::new(Workspace::new());
    let mut flight = Flight::new(scenario, scene, catalogue, &mut workspace)?;
    for _ in 0..scenario.duration_s {
        flight.second(&mut listen)?;
    }
    Ok(())
}
