//! The world of the tests of whole seconds: detector and clock, both of which can be made to fail.

use fsw_core::image::calibration::Calibration;
use fsw_core::modes::Mode;
use fsw_core::orbit::OrbitState;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Workspace};
use fsw_core::telemetry::{Event, Report};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Instant, LocalTime, Window};
use sil_host::flight::{self, StarCalibration};
use sil_host::harness::star_scene;
use sil_host::scenario::{Believed, Scenario};
use sil_host::world::detector::shutter::Shutter;
use sil_host::world::motion::trajectory;
use sil_host::world::noise::{Noise, Stream};
use sil_host::world::scene::{Scene, SceneSettings, WorldStar};
use std::path::Path;

/// Lines of a strip across the limb; no star window is so thin.
const STRIP_BREADTH: u16 = 9;

/// Of the windows that are not delivered.
const LOSSES_SEED: u64 = 22;

/// Sigma along every axis of a state from the ground, km and km/s.
const GROUND_SIGMA: (f64, f64) = (5.0, 0.005);

/// The world behind detector and clock, both of which can be made to fail.
pub(super) struct World {
    pub scene: Scene,
    pub parameters: Parameters,
    pub calibration: Option<StarCalibration>,
    /// Second of the world.
    pub second: u64,
    pub instant_us: i64,
    pub fault: Option<DetectorError>,
    /// Whether the image before is handed out again as a new one.
    pub stale: bool,
    /// Share of the windows, by their place, that are not delivered.
    pub lost_share: f64,
    /// Whether nothing is seen, or nothing in strips across the limb.
    pub covered: bool,
    pub strips_covered: bool,
    /// Whether nothing is seen in strips and lines.
    pub limb_covered: bool,
    /// Where alone stars are seen, px, and the value of all other pixels.
    pub only: Vec<[f64; 2]>,
    pub elsewhere: u16,
    /// Whether only strips fail.
    pub strips_fail: bool,
    /// Whether a line across the whole detector was read in this second: only the search for the Earth does.
    pub searched: bool,
    /// Strips show what stands so many pixels to the right.
    pub strips_shifted_px: u16,
    pub geometry: Option<DetectorGeometry>,
    /// The image says that it was exposed so long before its second.
    pub exposed_ago_us: i64,
    /// Whether the ground tells the orbit at the start.
    ground_start: bool,
    /// What was kept of before a restart.
    pub kept: Option<Report>,
    /// Whether the clock knows Terrestrial Time.
    pub clock_serves: bool,
}

fn open(calibration: &Option<StarCalibration>) -> Option<Calibration<'_>> {
    calibration.as_ref().and_then(StarCalibration::open)
}

impl World {
    pub fn new(scene: Scene, parameters: Parameters, start_us: i64) -> Self {
        Self {
            scene,
            parameters,
            calibration: None,
            second: 0,
            instant_us: start_us,
            fault: None,
            stale: false,
            lost_share: 0.0,
            covered: false,
            strips_covered: false,
            limb_covered: false,
            only: Vec::new(),
            elsewhere: 0,
            strips_fail: false,
            searched: false,
            strips_shifted_px: 0,
            geometry: None,
            exposed_ago_us: 0,
            ground_start: false,
            kept: None,
            clock_serves: true,
        }
    }

    /// Stars alone, as the Earth's flight about the Sun displaces them.
    pub fn of_stars(settings: SceneSettings, stars: &[WorldStar]) -> Self {
        Self::new(Scene::new(settings, stars).unwrap(), star_scene::parameters(), star_scene::epoch_us())
    }

    pub fn star_scene() -> Self {
        let settings = star_scene::scene().unwrap().settings().clone();
        Self::of_stars(settings, &star_scene::sky_in_flight([0.0; 3]))
    }

    /// The beginning of a scenario that comes with the program.
    pub fn clip(name: &str) -> Self {
        let scenario = Scenario::load(Path::new(name)).unwrap();
        let calibration = scenario.calibration().unwrap();
        let parameters = scenario.flight_parameters(open(&calibration).as_ref());
        Self { calibration, ..Self::new(scenario.scene().unwrap(), parameters, scenario.start_us) }
    }

    /// The same with a state from the ground.
    pub fn clip_with_orbit(name: &str) -> Self {
        Self { ground_start: true, ..Self::clip(name) }
    }

    /// [`Self::clip`] behind a rolling shutter; whether the flight code knows it. All else it is told truly.
    pub fn rolling(name: &str, row_time_s: f64, known: bool) -> Self {
        let mut scenario = Scenario::load(Path::new(name)).unwrap();
        scenario.believed = Believed::TRUTH;
        scenario.imaging.shutter = Shutter::Rolling { row_time_s };
        let calibration = scenario.calibration().unwrap();
        let mut parameters = scenario.flight_parameters(open(&calibration).as_ref());
        parameters.imaging.row_time_ns *= u32::from(known);
        Self { calibration, ..Self::new(scenario.scene().unwrap(), parameters, scenario.start_us) }
    }

    /// The counter in this second.
    pub fn local(&self) -> LocalTime {
        LocalTime::from_us(self.second as i64 * 1_000_000)
    }

    pub fn truth(&self, second: usize) -> trajectory::Truth {
        self.scene.truth_at(second as u64).expect("a clip is a trajectory")
    }

    /// What the ground says: each axis off by one sigma, this way or that.
    fn ground_state(&self) -> OrbitState {
        let truth = self.truth(self.second as usize);
        let off = |values: [f64; 3], sigma: f64| {
            let [x, y, z] = values;
            [x + sigma, y - sigma, z + sigma]
        };
        OrbitState {
            time_us: self.instant_us,
            position_km: off(truth.position_km, GROUND_SIGMA.0).into(),
            velocity_km_s: off(truth.velocity_km_s, GROUND_SIGMA.1).into(),
        }
    }
}

impl fsw_hal::ErrorType for World {
    type Error = DetectorError;
}

impl Detector for World {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry.unwrap_or(self.scene.geometry())
    }
    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        if self.stale {
            return Ok(());
        }
        self.scene.expose_cycle(self.second, exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(LocalTime::from_us(self.local().as_us() - self.exposed_ago_us))
    }
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let is_line = window.width.min(window.height) == 1;
        let is_strip = window.width.min(window.height) == STRIP_BREADTH;
        self.searched |= is_line;
        let x = if is_strip { window.x.saturating_add(self.strips_shifted_px) } else { window.x };
        self.scene.read(Window { x, ..window }, pixels)?;
        let covered = is_strip && self.strips_covered || (is_strip || is_line) && self.limb_covered;
        if self.covered || covered {
            pixels.fill(30);
        }
        let width = usize::from(window.width);
        for (index, pixel) in pixels.iter_mut().enumerate().filter(|_| !self.only.is_empty()) {
            let at = [usize::from(window.x) + index % width, usize::from(window.y) + index / width];
            let near = |[x, y]: &[f64; 2]| (x - at[0] as f64).hypot(y - at[1] as f64) < 30.0;
            if !self.only.iter().any(near) {
                *pixel = self.elsewhere;
            }
        }
        if is_strip && self.strips_fail {
            return Err(DetectorError::Timeout);
        }
        let noise = Noise::new(LOSSES_SEED, self.second, Stream::Fault);
        if noise.uniform(window.x.into(), window.y.into()) < self.lost_share {
            return Err(DetectorError::Bus);
        }
        self.fault.map_or(Ok(()), Err)
    }
}

/// Flies `seconds` seconds; `before` may spoil a second before it begins.
pub(super) fn fly(
    world: &mut World,
    seconds: u32,
    mut before: impl FnMut(u32, &mut World) -> Command<'static>,
    mut after: impl FnMut(&Report, &World),
) -> Vec<Report> {
    let catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
    let mut workspace = Box::new(Workspace::new());
    let calibration = world.calibration.clone();
    let mut sensor = flight::sensor(catalogue, open(&calibration), world.parameters, &mut workspace).unwrap();
    if world.ground_start {
        let (position_sigma_km, velocity_sigma_km_s) = GROUND_SIGMA;
        assert!(sensor.initialise_orbit(world.ground_state(), position_sigma_km, velocity_sigma_km_s));
    }
    if let Some(kept) = &world.kept {
        assert!(sensor.resume(kept));
    }
    (0..seconds)
        .map(|second| {
            world.searched = false;
            let command = before(second, world);
            let mut clock = Instant::new(world.local(), world.instant_us);
            clock.terrestrial_us = clock.terrestrial_us.filter(|_| world.clock_serves);
            let report = flight::second(&mut sensor, world, &mut clock, command);
            after(&report, world);
            world.second += 1;
            world.instant_us = world.instant_us.saturating_add(1_000_000);
            report
        })
        .collect()
}

pub(super) fn quietly(world: &mut World, seconds: u32) -> Vec<Report> {
    fly(world, seconds, |_, _| Command::Continue, |_, _| {})
}

pub(super) fn modes(reports: &[Report]) -> Vec<Mode> {
    reports.iter().map(|report| report.mode).collect()
}

pub(super) fn has(report: &Report, event: Event) -> bool {
    report.events.contains(&event)
}
