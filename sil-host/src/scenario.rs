//! Scenario files: an orbit, a pointing, a camera, and what the judge demands.
//!
//! In: TOML text. Out: [`Scenario`], every value checked; a fault names file, line and key. Angles are
//! degrees, lengths km, in ICRS (GCRF) axes; times in the file are UTC, in the program TT since J2000.0. Keys
//! that have a default may be left out, unknown ones are refused. The files that come with the program
//! ([`EMBEDDED`]) show every table.
//!
//! | table | says |
//! |---|---|
//! | `[scenario]` | name, start, duration, seed, exposure |
//! | `[orbit]` | Keplerian elements, a state or a TLE, from which the orbit is flown; or an orbit file to follow |
//! | `[body]` | what it flies about: Earth, Moon or Mars |
//! | `[forces]` | what pulls and pushes the satellite, and how the Earth stands |
//! | `[pointing]` | where the Earth path looks: to nadir, into space, or tumbling; slews and jitter |
//! | `[mount]` | how the star path stands to the Earth path, and whether it is seen in a mirror |
//! | `[camera]` | the camera file; none: the reference camera |
//! | `[optics]` | what the lens does to stars and light, see `scenario/optics.rs` |
//! | `[detector]` | dark current, readout, what differs from pixel to pixel, see `scenario/detector.rs` |
//! | `[disturbances]` | what is on the detector and neither star nor Earth |
//! | `[sky]` | planets, Moon, Sun's light, other satellites |
//! | `[earth]` | how the Earth is drawn |
//! | `[orbit_filter]` | what the orbit filter takes of an image, and a state from the ground |
//! | `[shutters]` | `paths` that have one: "neither", "star", "earth" or "both" (none: all are open); `filter`: "adaptive" where the Earth path's can be put out of the way; `open`: held so by command |
//! | `[gyro]`, `[magnetometer]` | the errors of these sensors; none: not on board |
//! | `[believed]` | how what the flight code is told differs from all that, see `scenario/believed.rs` |
//! | `[parameters]` | values of the flight code's parameter table that are not its defaults, see `scenario/parameters.rs` |
//! | `[[faults]]` | what breaks, and when |
//! | `[limits]` | what a run must reach, or it ends with status 1 |

mod believed;
mod body;
mod detector;
mod earth;
mod faults;
mod forces;
mod instruments;
mod limits;
mod mount;
mod optics;
mod orbit;
pub mod orbit_filter;
pub mod parameters;
mod pointing;
mod sky;
mod text;
mod told;

pub use believed::{Believed, PARTS};

use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::harness::faults::Fault;
use crate::judge::Limit;
use crate::words::nearest_first;
use crate::world::attitude::{Vector, dot};
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::imaging::ImagingModel;
use crate::world::earth::EarthModel;
use crate::world::instruments::gyro::GyroModel;
use crate::world::instruments::magnetometer::MagnetometerModel;
use crate::world::motion::Motion;
use crate::world::motion::jitter::{Jitter, JitterModel};
use crate::world::motion::pointing::{Mount, Pointing};
use crate::world::motion::trajectory::Trajectory;
use crate::world::orbit::{Forces, TruthOrbit, mu_km3_s2};
use crate::world::scene::{Scene, SceneSettings};
use crate::world::sky as stars;
use crate::world::sky::bodies::BodiesModel;
use crate::world::sky::stars::DetectorModel;
use crate::world::time::civil_time;
use fsw_core::shutting::ShutterParameters;
use fsw_hal::OpenPaths;
use orbit_filter::OrbitFilterModel;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use text::Text;
use toml::Spanned;

/// The scenarios that come with the program, the default first: name and text.
pub const EMBEDDED: [(&str, &str); 18] = [
    ("geo-eclipse", include_str!("scenarios/geo-eclipse.toml")),
    ("geo-day", include_str!("scenarios/geo-day.toml")),
    ("sso-noon-midnight", include_str!("scenarios/sso-noon-midnight.toml")),
    ("leo-oblique", include_str!("scenarios/leo-oblique.toml")),
    ("geo-faults", include_str!("scenarios/geo-faults.toml")),
    ("geo-inertial", include_str!("scenarios/geo-inertial.toml")),
    ("sso-dawn-dusk", include_str!("scenarios/sso-dawn-dusk.toml")),
    ("gto", include_str!("scenarios/gto.toml")),
    ("molniya", include_str!("scenarios/molniya.toml")),
    ("sun-crossing", include_str!("scenarios/sun-crossing.toml")),
    ("tumbling", include_str!("scenarios/tumbling.toml")),
    ("bad-day", include_str!("scenarios/bad-day.toml")),
    ("geo-shutters", include_str!("scenarios/geo-shutters.toml")),
    ("geo-oblique", include_str!("scenarios/geo-oblique.toml")),
    ("geo-two-fields", include_str!("scenarios/geo-two-fields.toml")),
    ("moon-orbit", include_str!("scenarios/moon-orbit.toml")),
    ("mars-orbit", include_str!("scenarios/mars-orbit.toml")),
    ("inertial-outage", include_str!("scenarios/inertial-outage.toml")),
];

/// Seconds in a run: up to ten days.
const DURATION_S: (i64, i64) = (10, 864_000);
/// Exposure, ms; a second must hold it and its readout.
const EXPOSURE_MS: (f64, f64) = (1.0, 900.0);
/// Exposure where the file says nothing, ms.
const EXPOSURE_DEFAULT_MS: f64 = 400.0;
const ANGLE_DEG: (f64, f64) = (-360.0, 360.0);
/// Longest name: it becomes that of a folder.
const NAME_MAX: usize = 60;

/// A scenario, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The file, for messages.
    pub file: PathBuf,
    /// Line of its `[orbit]`, for messages.
    pub orbit_line: usize,
    /// Name; also of the folder a run is written to.
    pub name: String,
    /// What is to be seen in it.
    pub description: String,
    /// Start as the file has it, UTC.
    pub start_utc: String,
    /// Instant of the first exposure's middle: TT, µs since J2000.0.
    pub start_us: i64,
    /// Seconds flown.
    pub duration_s: u32,
    /// Seed of everything random.
    pub seed: u64,
    /// Exposure, µs.
    pub exposure_us: u32,
    /// Position at the start about the body's centre, ICRS, km.
    pub position_km: Vector,
    /// Velocity at the start, ICRS, km/s.
    pub velocity_km_s: Vector,
    /// What pulls and pushes the satellite.
    pub forces: Forces,
    /// The orbit of a file, which is followed and not flown.
    pub track: Option<TruthOrbit>,
    /// Where the Earth path looks, without jitter: that needs the seed.
    pub pointing: Pointing,
    /// What is wrong with the pointing, if anything.
    pub jitter: Option<JitterModel>,
    /// How the star path stands to it.
    pub mount: Mount,
    /// The camera.
    pub camera: CameraFile,
    /// What the lens does to stars and light.
    pub imaging: ImagingModel,
    /// The detector's electrons.
    pub detector: DetectorModel,
    /// What is on the detector and neither star nor Earth.
    pub disturbances: Disturbances,
    /// What is in the sky beside stars and Earth.
    pub bodies: BodiesModel,
    /// How the Earth is drawn.
    pub earth: EarthModel,
    /// What the flight code is told, less what is true.
    pub believed: Believed,
    /// Values of the flight code's parameters that are not the defaults.
    pub parameters: Vec<parameters::Told>,
    /// What breaks, and when.
    pub faults: Vec<Fault>,
    /// What the orbit filter is told.
    pub orbit_filter: OrbitFilterModel,
    /// Shutters and an adaptive filter, where there are any.
    pub shutters: Option<ShutterParameters>,
    /// The paths that a command holds open from the first second on; `None`: they are shut against the Sun.
    pub held_open: Option<OpenPaths>,
    /// The errors of the gyro, where there is one.
    pub gyro: Option<GyroModel>,
    /// The errors of the magnetometer, where there is one.
    pub magnetometer: Option<MagnetometerModel>,
    /// What the judge demands.
    pub limits: Vec<Limit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    scenario: RawScenario,
    orbit: Spanned<orbit::RawOrbit>,
    #[serde(default)]
    body: body::RawBody,
    #[serde(default)]
    forces: forces::RawForces,
    #[serde(default)]
    pointing: pointing::RawPointing,
    #[serde(default)]
    mount: mount::RawMount,
    #[serde(default)]
    camera: RawCamera,
    #[serde(default)]
    optics: optics::RawOptics,
    #[serde(default)]
    detector: detector::RawDetector,
    #[serde(default)]
    disturbances: detector::RawDisturbances,
    #[serde(default)]
    sky: sky::RawSky,
    #[serde(default)]
    earth: earth::RawEarth,
    #[serde(default)]
    orbit_filter: orbit_filter::RawOrbitFilter,
    shutters: Option<instruments::RawShutters>,
    gyro: Option<instruments::RawGyro>,
    magnetometer: Option<Spanned<instruments::RawMagnetometer>>,
    #[serde(default)]
    believed: believed::RawBelieved,
    #[serde(default)]
    parameters: toml::Table,
    #[serde(default)]
    faults: Vec<faults::RawFault>,
    #[serde(default)]
    limits: BTreeMap<Spanned<String>, Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScenario {
    name: Spanned<String>,
    #[serde(default)]
    description: String,
    start: Spanned<String>,
    duration_s: Spanned<i64>,
    seed: Option<Spanned<i64>>,
    exposure_ms: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawCamera {
    file: Option<Spanned<String>>,
}

impl Scenario {
    /// The scenario flown when none is asked for.
    pub fn default_embedded() -> Self {
        // The embedded files are part of the program and every one is read by a test.
        Self::named(None).expect("embedded scenario")
    }

    /// A scenario file, or one that comes with the program; the default one where none is named.
    ///
    /// # Errors
    /// When the file cannot be read or is no scenario.
    pub fn named(path: Option<&Path>) -> Result<Self, HostError> {
        let (path, text) = Self::text(path)?;
        Self::parse(&path, &text)
    }

    /// Reads the file at `path`; where there is none, the name of an embedded scenario will do.
    ///
    /// # Errors
    /// The first fault found, with line and key.
    pub fn load(path: &Path) -> Result<Self, HostError> {
        Self::named(Some(path))
    }

    /// Path and text of a scenario file, or of one that comes with the program; of the default one where none
    /// is named.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn text(path: Option<&Path>) -> Result<(PathBuf, Cow<'static, str>), HostError> {
        let embedded = |(name, text): (&str, &'static str)| (embedded_path(name), Cow::Borrowed(text));
        let Some(path) = path else { return Ok(embedded(EMBEDDED[0])) };
        std::fs::read_to_string(path).map(|text| (path.to_path_buf(), Cow::Owned(text))).or_else(|error| {
            let named = EMBEDDED.into_iter().find(|(name, _)| path.as_os_str() == *name);
            named.map(embedded).ok_or_else(|| {
                let names = EMBEDDED.map(|(name, _)| name);
                let asked = path.file_stem().unwrap_or_default().to_string_lossy();
                let near = nearest_first(&asked, names);
                let to_do = format!("{near}give a scenario file or one of {}", names.join(", "));
                HostError::system(path, "read", &error, &to_do)
            })
        })
    }

    /// Checks `text`; `path` is for messages and for the folder of the camera file.
    ///
    /// # Errors
    /// The first fault found, with line and key.
    pub fn parse(path: &Path, text: &str) -> Result<Self, HostError> {
        let text = Text { path, text };
        let raw: RawFile = toml::from_str(text.text).map_err(|error| text.syntax(&error))?;
        let head = &raw.scenario;
        let start_us = civil_time::tt_us(head.start.get_ref()).map_err(|what| {
            let to_do = "give UTC as \"2026-09-23T18:00:00\"";
            text.fault(head.start.span().start, "scenario.start", what, to_do)
        })?;
        let exposure = head.exposure_ms.as_ref();
        let exposure_ms = text.number("scenario.exposure_ms", exposure, EXPOSURE_DEFAULT_MS, EXPOSURE_MS)?;
        let duration_s = text.whole("scenario.duration_s", Some(&head.duration_s), 0, DURATION_S)? as u32;
        let detector = detector::read(&text, &raw.detector)?.gathering(optics::light(&text, &raw.optics)?);
        let about = body::read(&text, &raw.body)?;
        let earth = earth::read(&text, &raw.earth, about)?;
        let mirror = optics::mirror(&text, &raw.optics)?;
        let field = raw.magnetometer.as_ref().map(|table| table.span().start);
        body::of_the_earth_alone(&text, about, &[("magnetometer", field)])?;
        let forces = forces::read(&text, &raw.forces, about, start_us, duration_s)?;
        let orbit = orbit::read(&text, &raw.orbit, start_us, duration_s, &forces)?;
        let scenario = Self {
            file: path.to_path_buf(),
            orbit_line: text.line(raw.orbit.span().start),
            name: name(&text, &head.name)?,
            description: head.description.split_whitespace().collect::<Vec<_>>().join(" "),
            start_utc: head.start.get_ref().clone(),
            start_us,
            duration_s,
            seed: text.whole("scenario.seed", head.seed.as_ref(), 1, (0, i64::MAX))? as u64,
            exposure_us: (exposure_ms * 1e3).round() as u32,
            position_km: orbit.position_km,
            velocity_km_s: orbit.velocity_km_s,
            forces,
            track: orbit.track,
            pointing: pointing::read(&text, &raw.pointing, duration_s)?,
            jitter: pointing::jitter(&text, &raw.pointing)?,
            mount: mount::read(&text, &raw.mount)?,
            camera: camera(&text, &raw)?,
            imaging: optics::read(&text, &raw.optics)?,
            detector: mirror.map_or(detector, |share| DetectorModel { throughput: 1.0 - share, ..detector }),
            disturbances: detector::disturbances(&text, &raw.disturbances)?,
            bodies: sky::read(&text, &raw.sky, about)?,
            earth: mirror.map_or(earth, |share| earth.behind(share)),
            orbit_filter: orbit_filter::read(&text, &raw.orbit_filter)?,
            shutters: raw.shutters.as_ref().map(instruments::shutters),
            held_open: raw.shutters.as_ref().and_then(instruments::held_open),
            gyro: instruments::gyro(&text, &raw.gyro)?,
            magnetometer: instruments::magnetometer(&text, raw.magnetometer.as_ref().map(Spanned::get_ref))?,
            believed: believed::read(&text, &raw.believed)?,
            parameters: parameters::read(&text, &raw.parameters)?,
            faults: faults::read(&text, &raw.faults, duration_s)?,
            limits: limits::read(&text, &raw.limits)?,
        };
        parameters::check(&scenario)?;
        Ok(scenario)
    }

    /// The truth orbit: that of a file, or flown from the start.
    fn orbit(&self) -> Result<TruthOrbit, HostError> {
        if let Some(track) = &self.track {
            return Ok(track.clone());
        }
        let (r, v) = (self.position_km, self.velocity_km_s);
        TruthOrbit::with_forces(self.start_us, r, v, self.duration_s, &self.forces).map_err(|error| {
            HostError::input(&self.file, Some(self.orbit_line), error.to_string(), "give another orbit")
        })
    }

    /// The world of this scenario, before its first exposure.
    ///
    /// # Errors
    /// When the orbit reaches the ground before the end, or the camera is one the world cannot draw.
    pub fn scene(&self) -> Result<Scene, HostError> {
        self.scene_above(self.seed)
    }

    /// The same above the Earth of another seed: runs that share one share its maps.
    ///
    /// # Errors
    /// As [`Scenario::scene`].
    pub fn scene_above(&self, earth_seed: u64) -> Result<Scene, HostError> {
        let jitter = self.jitter.as_ref().map_or_else(Jitter::default, |model| Jitter::new(model, self.seed));
        let pointing = Pointing { jitter, ..self.pointing.clone() };
        let orbit = self.orbit()?;
        let trajectory = Trajectory { orbit, pointing, mount: self.mount, earth: self.earth };
        let mut settings = SceneSettings::new(self.camera.clone(), Motion::orbiting(trajectory), self.seed);
        settings.earth_seed = earth_seed;
        (settings.imaging, settings.detector) = (self.imaging, self.detector);
        (settings.bodies, settings.disturbances) = (self.bodies, self.disturbances);
        Scene::new(settings, &stars::in_year(self.start_year())).map_err(|error| {
            let to_do = "give a longer focal length, a smaller aperture_mm, or psf = \"gaussian\"";
            HostError::input(&self.file, None, error.to_string(), to_do)
        })
    }

    /// Instant of the exposure's middle in a second: TT, µs since J2000.0.
    pub fn instant_us(&self, second: u32) -> i64 {
        self.start_us + i64::from(second) * 1_000_000
    }

    /// Julian year of the start.
    pub fn start_year(&self) -> f64 {
        2000.0 + self.start_us as f64 * 1e-6 / (365.25 * 86_400.0)
    }

    /// Time of a revolution at the start, s: Kepler's third law on the energy's semi-major axis.
    pub fn period_s(&self) -> f64 {
        let distance = libm::sqrt(dot(self.position_km, self.position_km));
        let mu = mu_km3_s2(self.forces.body);
        let a_km = 1.0 / (2.0 / distance - dot(self.velocity_km_s, self.velocity_km_s) / mu);
        std::f64::consts::TAU * libm::sqrt(a_km * a_km * a_km / mu)
    }

    /// The same with another seed, where one is given.
    pub fn with_seed(self, seed: Option<u64>) -> Self {
        Self { seed: seed.unwrap_or(self.seed), ..self }
    }
}

/// What an embedded scenario is called in messages.
fn embedded_path(name: &str) -> PathBuf {
    PathBuf::from(format!("{name}.toml"))
}

/// The name, fit for a folder.
fn name(text: &Text<'_>, value: &Spanned<String>) -> Result<String, HostError> {
    let name = value.get_ref();
    let fit = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
    if name.is_empty() || name.len() > NAME_MAX || !name.bytes().all(fit) {
        let to_do = format!("use 1 to {NAME_MAX} letters, digits, - and _");
        return Err(text.fault(value.span().start, "scenario.name", "cannot name a folder", &to_do));
    }
    Ok(name.clone())
}

/// The camera, with the mirror of the mount.
fn camera(text: &Text<'_>, raw: &RawFile) -> Result<CameraFile, HostError> {
    let mut camera = match &raw.camera.file {
        None => CameraFile::reference(),
        Some(file) => {
            let path = text.path.parent().unwrap_or(Path::new("")).join(file.get_ref());
            if !path.is_file() {
                let to_do = "give the path of a camera file, from the scenario's folder";
                return Err(text.fault(file.span().start, "camera.file", "no such file", to_do));
            }
            CameraFile::load(&path)?
        }
    };
    if let Some(mirrored) = raw.mount.mirrored {
        camera.mirrored = mirrored;
    }
    Ok(camera)
}

#[cfg(test)]
mod tests;
