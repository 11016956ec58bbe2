//! The main results of a second as a plain struct.
//!
//! In: the [`Report`](fsw_core::telemetry::Report) of the flight code. Out: a [`CycleResult`]. The telemetry
//! frame of the same second holds all of the report; this struct is what a spacecraft's control loop needs of
//! it.

mod conversions;

/// The detector did not serve, or not whole: what is told beside it is of the windows that it delivered.
pub const FAULT_DETECTOR: u32 = 1;
/// The image was not used for its instant, or is one of the last ones again.
pub const FAULT_IMAGE: u32 = 2;
/// The clock did not serve.
pub const FAULT_CLOCK: u32 = 4;
/// The rate sensor gave no reading that can be used.
pub const FAULT_RATE_SENSOR: u32 = 8;
/// The Earth's centre was no position for the orbit filter.
pub const FAULT_FIX: u32 = 16;
/// The shutters did not move: where they stand is not known.
pub const FAULT_SHUTTER: u32 = 32;
/// The magnetometer gave no reading that can be used.
pub const FAULT_MAGNETOMETER: u32 = 64;

/// Mode in which a second was spent.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Detector and clock are tested before their data are used.
    #[default]
    SelfTest = 0,
    /// Stars are identified: in windows where a filter still predicts them, else in the whole image.
    Acquisition = 1,
    /// Windows about predicted stars and about the Earth's limb are read.
    Tracking = 2,
    /// As tracking, but no limb in the field is lit: stars alone, the orbit is propagated.
    Eclipse = 3,
    /// The Sun blinds the detector: attitude by the last rate, orbit propagated.
    SunOutage = 4,
    /// After persistent faults or a time-out: the orbit is propagated, the self-test repeated in every
    /// second.
    Safe = 5,
    /// By command, or without a parameter table that can be used: the orbit is propagated, no image is taken
    /// until a command ends it.
    CommandedSafe = 6,
}

/// What came of the stars of a second.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// None were looked for, or a fault came first.
    #[default]
    None = 0,
    /// The self-test passed.
    SelfTestPassed = 1,
    /// Stars were identified, without prior knowledge or near to an attitude known before: hardly by chance.
    Identified = 2,
    /// The search goes on in the next second with the same image.
    Searching = 3,
    /// The image was not identified.
    NotIdentified = 4,
    /// The sensor turned too fast: its stars are streaks, and no attitude is claimed.
    TooFast = 5,
    /// Predicted stars were found again.
    Tracked = 6,
    /// Too few predicted stars were found.
    Lost = 7,
    /// The detector is blinded.
    Blinded = 8,
    /// The star path is shut: an attitude is carried on, or where its age is 0 it is by Earth and terminator.
    StarPathShut = 9,
}

/// What came of looking for the Earth in a second.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EarthStatus {
    /// It was not looked for: no attitude, stars that are lines, a blinded detector, or a shut Earth path.
    #[default]
    NotLooked = 0,
    /// No limb that the Sun lights is in the field.
    Dark = 1,
    /// The Sun lights a limb in the field, but not enough of it high enough to be measured.
    Faint = 2,
    /// The centre was found.
    Found = 3,
    /// It was looked for and no centre came of it.
    Refused = 4,
}

/// What Terrestrial Time of a second rests on.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClockState {
    /// No time: no Sun, no aberration, no Earth.
    #[default]
    Unknown = 0,
    /// The clock gave it in this second.
    Synchronised = 1,
    /// The clock gave it before, at most a day ago, and local time has gone on since.
    Holdover = 2,
}

/// An attitude and how far to trust it. All zero where it is not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Whether there is one.
    pub known: bool,
    /// ICRS to star path, x, y, z, w (scalar last): b = A(q) r turns a direction r of the ICRS into the
    /// sensor's frame, x along +x px, y along +y px, z out along the line of sight.
    pub quaternion: [f32; 4],
    /// Standard deviations about x, y, z of the star path, rad.
    pub sigma_rad: [f32; 3],
    /// Whole seconds since the image from which it was found was taken; 0: that of this second.
    pub age_s: u32,
}

/// How the sensor turns. All zero where it is not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rate {
    /// Whether it is known.
    pub known: bool,
    /// It may as well be the opposite one: it rests on the streaks of a single image.
    pub either_sense: bool,
    /// Rate of the star path against the stars, in its own frame, rad/s.
    pub rad_s: [f32; 3],
    /// Standard deviations about x, y, z, rad/s; zero where the rate comes of the attitude's filter.
    pub sigma_rad_s: [f32; 3],
}

/// The Earth as seen in this second. All zero where it was not found.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Earth {
    /// Unit vector to the Earth's centre, Earth path.
    pub direction: [f32; 3],
    /// Standard deviation of the direction, the greater of the two across it, rad.
    pub sigma_rad: f32,
    /// Distance of the Earth's centre, km.
    pub distance_km: f32,
    /// Standard deviation of the distance, km.
    pub sigma_km: f32,
    /// Covariance of the centre, direction times distance, Earth path, km²: the lower left half of the matrix
    /// with its diagonal, row by row.
    pub covariance_km2: [f32; 6],
}

/// Position and velocity at the instant of the second. All zero where they are not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Orbit {
    /// Whether they are known.
    pub known: bool,
    /// Whether the filter has converged.
    pub settled: bool,
    /// Seconds since the last observation of the Earth that was accepted.
    pub since_fix_s: u32,
    /// Position, ICRS axes, geocentric, km.
    pub position_km: [f64; 3],
    /// Velocity, ICRS axes, km/s.
    pub velocity_km_s: [f64; 3],
    /// Standard deviations of the position along the ICRS axes, km.
    pub sigma_position_km: [f32; 3],
    /// Standard deviations of the velocity along the ICRS axes, km/s.
    pub sigma_velocity_km_s: [f32; 3],
    /// Standard deviations of the position: radial, along, cross, km.
    pub sigma_hill_km: [f32; 3],
    /// By what the Earth path is turned against the mounting of the parameters, rad: a rotation vector in the
    /// Earth path; 0 where it is not estimated.
    pub misalignment_rad: [f32; 3],
    /// Its standard deviations, rad.
    pub misalignment_sigma_rad: [f32; 3],
    /// The same orbit in Kepler's elements.
    pub elements: Elements,
}

/// Kepler's elements of an orbit, osculating, ICRS axes. All zero where they are not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Elements {
    /// Whether there are any: not those of an open orbit or of an eccentricity above 0.97.
    pub known: bool,
    /// Semi-major axis, km.
    pub semi_major_axis_km: f64,
    /// Eccentricity.
    pub eccentricity: f32,
    /// Inclination to the ICRS equator, rad, 0 to pi.
    pub inclination_rad: f32,
    /// Right ascension of the ascending node, rad, 0 to 2 pi; 0 in the equator's plane.
    pub node_rad: f32,
    /// Argument of perigee, rad, 0 to 2 pi; 0 on a circle.
    pub perigee_rad: f32,
    /// True anomaly, rad, 0 to 2 pi; on a circle it counts from the node.
    pub anomaly_rad: f32,
}

/// What the sensor can do.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorState {
    /// Earth and stars are seen.
    #[default]
    Full = 0,
    /// The Sun is in the Earth path and blinds the detector.
    SunInEarthPath = 1,
    /// No lit limb is on the detector; stars are seen.
    Eclipse = 2,
    /// The Sun is in the star path and blinds the detector.
    SunInStarPath = 3,
    /// The same, and its image lies on that of the Earth.
    SunInStarPathOverEarth = 4,
}

/// The sensor's next change of state: an outage that begins or ends. All zero where none is foreseen within a
/// revolution.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NextState {
    /// Whether one is foreseen.
    pub known: bool,
    /// What the sensor can do then.
    pub state: SensorState,
    /// Seconds until then.
    pub in_s: u32,
    /// Standard deviation of these, s.
    pub sigma_s: f32,
    /// Seconds that it lasts; 0 where its end is not foreseen.
    pub lasts_s: u32,
}

/// The attitude against local vertical and local horizontal (z down to the Earth's centre, y against the
/// orbit's normal, x along the flight). All zero where attitude or orbit are not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Local {
    /// Whether it is known.
    pub known: bool,
    /// LVLH to star path, x, y, z, w.
    pub quaternion: [f32; 4],
    /// Angle between the Earth path's line of sight and the Earth's centre, rad, 0 to pi.
    pub nadir_rad: f32,
    /// Angle about the vertical, from the flight's direction towards LVLH y, to the Earth path's x axis, rad.
    pub yaw_rad: f32,
}

/// What the magnetometer reads, and how far it is to be believed; along the axes of the Earth path. All zero
/// without one, without a reading and where the orbit is not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MagneticField {
    /// Whether there is a reading.
    pub known: bool,
    /// Whether the attitude of this second rests on it.
    pub used: bool,
    /// The reading less the zero, microtesla: the Earth's field.
    pub field_ut: [f32; 3],
    /// The zero as stars and orbit have shown it, microtesla: the spacecraft's own field.
    pub zero_ut: [f32; 3],
    /// Standard deviation of the zero, an axis, microtesla.
    pub zero_sigma_ut: f32,
}

/// What came of the command of a second.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CommandResult {
    /// There was none.
    #[default]
    None = 0,
    /// It was done.
    Done = 1,
    /// It was refused and changed nothing.
    Refused = 2,
}

/// The main results of a second.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleResult {
    /// Cycles since start, from 0.
    pub cycle: u32,
    /// Mode in which the second was spent.
    pub mode: Mode,
    /// What came of the stars.
    pub outcome: Outcome,
    /// What came of looking for the Earth.
    pub earth_status: EarthStatus,
    /// What Terrestrial Time rests on.
    pub clock: ClockState,
    /// What did not serve: a sum of `SEXTANT_FAULT_...`, 0 where all did.
    pub faults: u32,
    /// Instant of the image, or of the second where none was used: local time, microseconds since power-on.
    pub local_us: i64,
    /// The same in Terrestrial Time, microseconds since J2000.0; 0 where the clock has never given it
    /// (`clock` then is `UNKNOWN`).
    pub terrestrial_us: i64,
    /// Star-like spots in the image or its windows.
    pub detections: u32,
    /// Stars that were recognised.
    pub stars: u32,
    /// The attitude by this second's image alone, or predicted where that gave none.
    pub attitude: Attitude,
    /// The attitude that the filter makes of all images so far, at the same instant.
    pub filtered: Attitude,
    /// The rate.
    pub rate: Rate,
    /// The Earth, where `earth_status` is `FOUND`.
    pub earth: Earth,
    /// The orbit.
    pub orbit: Orbit,
    /// The attitude against the local vertical.
    pub local: Local,
    /// The sensor's next change of state.
    pub next_state: NextState,
    /// What the magnetometer reads.
    pub magnetic_field: MagneticField,
    /// What came of the command.
    pub command: CommandResult,
    /// Reason code of a command that was refused, as reports tell it; else 0.
    pub refusal: u32,
    /// Exposure that the image was asked for with, us; 0 where the second needed no image.
    pub exposure_us: u32,
    /// Whether the star path was to be shut.
    pub star_path_shut: bool,
    /// Whether the Earth path was to be shut.
    pub earth_path_shut: bool,
    /// Whether the Earth path's filter was to be out of the way.
    pub earth_path_clear: bool,
    /// How many stars were seen through the Earth path that do not contradict each other; 0: none, or none
    /// were looked for.
    pub earth_path_stars: u8,
    /// Whether `sensor_state` is known: the Sun by attitude and time, the limb by what is seen of it or by
    /// the orbit.
    pub sensor_state_known: bool,
    /// What the sensor can do in this second; `FULL` where it is not known.
    pub sensor_state: SensorState,
}
