//! A run on the page: what it is, and its seconds so far, in flight or recorded.

use super::ground::Ground;
use super::row;
use super::world::World;
use crate::formats::cycles::columns::{RowInputs, cells};
use crate::harness::Second;
use crate::harness::faults::Fault;
use crate::report::opinion::Grade;
use crate::scenario::Scenario;
use crate::world::attitude::Vector;
use crate::world::time::civil_time;
use fsw_core::orbit::body::CentralBody;
use fsw_core::telemetry::{self, Report};
use fsw_hal::Window;
use serde::{Serialize, Serializer};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a run is.
#[derive(Clone, Debug, Serialize)]
pub struct Title {
    /// Number of the run on this page, from 1.
    pub run: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// What is to be seen in it; empty where that is not known.
    pub description: String,
    /// Its seed.
    pub seed: u64,
    /// Instant of the first second, UTC.
    pub start_utc: String,
    /// Seconds of the whole run.
    pub duration_s: u32,
    /// Whether there is a gyro on board.
    pub gyro: bool,
    /// The folder of a recorded run.
    pub folder: Option<String>,
    /// Instant of the first second, TT since J2000, us.
    #[serde(skip)]
    pub start_us: i64,
    /// What is flown about.
    #[serde(serialize_with = "name")]
    pub body: CentralBody,
}

fn name<S: Serializer>(body: &CentralBody, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(body.name())
}

impl Title {
    /// Of a flight of a scenario.
    pub fn of(run: u32, scenario: &Scenario) -> Self {
        Self {
            run,
            scenario: scenario.name.clone(),
            description: scenario.description.clone(),
            seed: scenario.seed,
            start_utc: civil_time::utc_text(scenario.start_us),
            duration_s: scenario.duration_s,
            gyro: scenario.gyro.is_some(),
            folder: None,
            start_us: scenario.start_us,
            body: scenario.forces.body,
        }
    }
}

/// Where the satellite truly was in a second, and how it stood.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// TT since J2000, us.
    pub instant_us: i64,
    /// ICRS to star path, scalar last.
    pub quaternion: [f64; 4],
    /// ICRS, geocentric, km.
    pub position_km: Vector,
}

/// A second of the log.
#[derive(Clone, Debug)]
pub struct Logged {
    /// Its values, a JSON array ([`row`]).
    pub row: String,
    /// The truth.
    pub place: Place,
    /// The sensor's telemetry frame; none where it was not kept.
    pub frame: Option<Box<[u8]>>,
    /// The windows that the sensor read; none where they were not kept.
    pub windows: Option<Box<[Window]>>,
}

impl Logged {
    /// The sensor's report, where it was kept and can be read.
    pub fn report(&self) -> Option<Report> {
        telemetry::decode(self.frame.as_ref()?).ok()
    }
}

/// What a run that is over came to.
#[derive(Clone, Debug, Serialize)]
pub struct End {
    /// `good`, `doubt` or `bad`.
    pub grade: &'static str,
    /// In a sentence.
    pub words: String,
}

impl End {
    /// A sentence of this grade.
    pub fn new(grade: Grade, words: String) -> Self {
        Self { grade: grade.class(), words }
    }
}

/// The seconds so far.
#[derive(Debug, Default)]
pub struct Log {
    /// Second after second, from 0.
    pub seconds: Vec<Logged>,
    /// What breaks: the scenario's faults, then those of the buttons.
    pub faults: Vec<Fault>,
    /// What it came to, once it is over.
    pub end: Option<End>,
}

/// A run on the page.
#[derive(Debug)]
pub struct Run {
    /// What it is.
    pub title: Title,
    /// The world it is flown in, from which frames are drawn; or why there is none.
    pub world: Result<World, String>,
    /// The turning Earth.
    pub ground: Ground,
    log: Mutex<Log>,
}

impl Run {
    /// A run with these seconds so far.
    pub fn new(title: Title, world: Result<World, String>, log: Log) -> Self {
        let ground = Ground::new(title.body, title.start_us);
        Self { title, world, ground, log: Mutex::new(log) }
    }

    /// The log, for as long as the guard lives.
    pub fn log(&self) -> MutexGuard<'_, Log> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a second in flight that took the host `host_ms`.
    pub fn add(&self, second: Second<'_>, mode_right: bool, host_ms: f64) {
        let truth = second.truth;
        let place = Place {
            instant_us: truth.instant_us,
            quaternion: truth.quaternion,
            position_km: truth.position_km,
        };
        let below = self.ground.place_deg(place.position_km, place.instant_us);
        let row = row::of_cells(&cells(&RowInputs { second, mode_right }), below, host_ms);
        let mut buffer = [0; telemetry::MAX_FRAME_BYTES];
        let frame = telemetry::encode(second.report, &mut buffer).ok().map(Box::from);
        self.log().seconds.push(Logged { row, place, frame, windows: Some(second.windows.into()) });
    }
}
