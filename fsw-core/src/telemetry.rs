//! What leaves the sensor every second: the [`Report`] and its bytes.
//!
//! A frame is a [`packet`] of version [`VERSION`]. Equal images give equal frames on every machine. A stream
//! is one frame after the other, each led by its length (u16, little-endian).
//!
//! A second is described by what was done ([`Activity`]), what came of it ([`Outcome`], [`EarthStatus`] and
//! the quantities) and what did not serve ([`Faults`]); changes from one second to the next are [`Event`]s.

mod faults;

use crate::command::{CommandOutcome, GroundOrbit};
use crate::earth::FitError;
pub use crate::earth::MAX_LIMB_POINTS;
use crate::modes::{Guard, Mode};
use crate::orbit::OrbitState;
use crate::outages::SensorState;
use crate::packet::{self, PacketError};
use crate::stars::identify::NotIdentified;
pub use faults::{ClockFault, DetectorFault, Faults, FixFault, ImageFault, ReadingFault, ShutterFault};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the frame's layout.
pub const VERSION: u8 = 17;
/// A buffer of this length holds any frame.
pub const MAX_FRAME_BYTES: usize = 2560;
/// Most stars reported.
pub const MAX_STARS: usize = 48;
/// Correlations among the six states of position and velocity.
pub const MOTION_CORRELATIONS: usize = 15;
/// Most events in a second.
pub const MAX_EVENTS: usize = 8;

/// The text of the files whose types make a frame. From it the ground's page of the layout has its words
/// (`sil-host telemetry`); nothing of it is in an image that does not ask.
pub const SOURCES: [&str; 8] = [
    include_str!("telemetry.rs"),
    include_str!("telemetry/faults.rs"),
    include_str!("modes.rs"),
    include_str!("command.rs"),
    include_str!("command/refusal.rs"),
    include_str!("earth.rs"),
    include_str!("stars/identify.rs"),
    include_str!("outages.rs"),
];

/// What was done with a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activity {
    /// No image was asked for, or none could be used and no attitude is known.
    #[default]
    Waiting,
    /// Windows were read twice and compared.
    SelfTest,
    /// The whole image was searched for stars, or a search went on with the stars of an image before.
    StarSearch,
    /// The whole image was searched for streaks.
    StreakSearch,
    /// Predicted stars were sought in windows.
    StarTracking,
    /// Attitude and orbit were propagated only: the detector is or was blinded, or the image was not used.
    Propagation,
}

/// What came of the stars of a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// The self-test passed.
    SelfTestPassed,
    /// Stars were identified, without prior knowledge or near to an attitude known before: hardly by chance.
    Identified,
    /// The search goes on in the next second with the same image.
    Searching,
    /// The image was not identified.
    NotIdentified(NotIdentified),
    /// The sensor turned too fast: its stars are streaks, and no attitude is claimed.
    TooFast,
    /// Predicted stars were found again.
    Tracked,
    /// Too few predicted stars were found.
    Lost,
    /// The detector is blinded.
    Blinded,
    /// The star path is shut: an attitude is carried on, or where its age is 0 it is by the Earth, and by the
    /// terminator or the magnetic field.
    StarPathShut,
}

/// What Terrestrial Time of a second rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ClockState {
    /// The clock gave it in this second.
    Synchronised,
    /// The clock gave it before, at most a day ago, and local time has gone on since.
    Holdover,
    /// Neither: no Sun, no aberration, no Earth.
    #[default]
    Unknown,
}

/// A star that was recognised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StarReport {
    /// Hipparcos number.
    pub hip: u32,
    /// Measured centre, px.
    pub centre_px: [f32; 2],
    /// Measured less projected position, px.
    pub residual_px: [f32; 2],
}

/// An attitude and how far to trust it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttitudeReport {
    /// ICRS to star path, `[x, y, z, w]`.
    pub quaternion: [f32; 4],
    /// Standard deviations about x, y, z of the star path, rad.
    pub sigma_rad: [f32; 3],
    /// Common logarithm of the probability that the names are wrong, from this image alone; 0 where there is
    /// none: predicted, or too few stars for an attitude of their own, each taken where it was expected.
    pub log10_false: f32,
    /// Seconds since the image from which it was found was taken. Above 0 it is carried on: without a rate
    /// sensor its sigmas hold how well the rate was known then, and of manoeuvres since those of the
    /// parameter `tracking.manoeuvre_rad_s2`.
    pub age_s: u16,
}

/// On what a rate rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateSource {
    /// The streaks of the image, their ends and the exposure.
    Streaks,
    /// The stars of the image and the last that was scanned, none of them identified.
    Images,
    /// Streaks, and their way from the last image to the image.
    Both,
}

/// A rate that needed no attitude, of this second's image or of that whose search goes on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateReport {
    /// Of the star path against the stars, in its own frame, at the second's instant, rad/s.
    pub rad_s: [f32; 3],
    /// Standard deviations about x, y, z, rad/s.
    pub sigma_rad_s: [f32; 3],
    /// On what it rests.
    pub source: RateSource,
    /// It may as well be the opposite one: in a single image either end of a streak may be the first.
    pub either_sense: bool,
    /// Whole streaks, or stars, on which it rests.
    pub stars: u8,
}

/// The attitude that the filter makes of all images so far, at the instant of the attitude beside it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilteredAttitude {
    /// ICRS to star path, `[x, y, z, w]`.
    pub quaternion: [f32; 4],
    /// Standard deviations about x, y, z of the star path, rad.
    pub sigma_rad: [f32; 3],
}

/// What came of looking for the Earth in this second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EarthStatus {
    /// It was not looked for: no attitude, stars that are lines, a blinded detector, or a shut Earth path.
    #[default]
    NotLooked,
    /// No limb that the Sun lights is in the field.
    Dark,
    /// The Sun lights a limb in the field, but not enough of it high enough to be measured.
    Faint,
    /// The centre was found.
    Found,
    /// It was looked for and no centre came of it.
    Refused(FitError),
}

/// The Earth as seen in this second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EarthReport {
    /// Unit vector to the Earth's centre, Earth path.
    pub direction: [f32; 3],
    /// Standard deviation of the direction, the greater of the two across it, rad.
    pub sigma_rad: f32,
    /// Distance of the Earth's centre, km.
    pub distance_km: f32,
    /// Standard deviation of the distance, km, the limb's height taken as known.
    pub sigma_km: f32,
    /// Covariance of the centre, direction times distance, Earth path, km²: the lower left half of the matrix
    /// with its diagonal, row by row. Of a short arc the direction along it is known ten times better than
    /// the one across, and this one goes with the distance.
    pub covariance_km2: [f32; 6],
    /// Limb points on which the centre rests.
    pub inliers: u16,
    /// Arc of the limb they span about the centre, deg.
    pub arc_deg: f32,
    /// Root mean square distance of the inliers from the fitted limb, px.
    pub rms_px: f32,
}

/// The orbit after this second, at the instant of its image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrbitReport {
    /// Position, ICRS, geocentric, km.
    pub position_km: [f64; 3],
    /// Velocity, ICRS, km/s.
    pub velocity_km_s: [f64; 3],
    /// Standard deviations of the position, ICRS axes, km.
    pub sigma_position_km: [f32; 3],
    /// Standard deviations of the velocity, ICRS axes, km/s.
    pub sigma_velocity_km_s: [f32; 3],
    /// Correlations of position and velocity: the lower left half of their matrix without its diagonal, row
    /// by row, the states in the order x, y, z, vx, vy, vz of the ICRS axes.
    pub correlations: [f32; MOTION_CORRELATIONS],
    /// Standard deviations of the position along Hill's axes, radial, along and cross, km; 0 where position
    /// and velocity span no plane.
    pub sigma_hill_km: [f32; 3],
    /// The same orbit in Kepler's elements, osculating, ICRS axes; `None` where it is open or its
    /// eccentricity above 0.97.
    pub elements: Option<ElementsReport>,
    /// Estimated departure of the limb's height from the parameter, km.
    pub limb_height_km: f32,
    /// Its standard deviation, km.
    pub limb_height_sigma_km: f32,
    /// By what the Earth path is turned against the mounting of the parameters, rad: a rotation vector in the
    /// Earth path; 0 where it is not estimated.
    pub misalignment_rad: [f32; 3],
    /// Its standard deviations, rad.
    pub misalignment_sigma_rad: [f32; 3],
    /// Normalised innovation squared of the observation taken in in this second; none without one.
    pub nis: Option<f32>,
    /// Its degrees of freedom: what is expected of it.
    pub nis_freedom: u8,
    /// Seconds since the last observation that was accepted.
    pub since_fix_s: u32,
    /// Whether the filter has converged.
    pub settled: bool,
}

/// Kepler's elements of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElementsReport {
    /// Semi-major axis, km.
    pub semi_major_axis_km: f64,
    /// Eccentricity.
    pub eccentricity: f32,
    /// Inclination to the ICRS equator, rad, 0 to π.
    pub inclination_rad: f32,
    /// Right ascension of the ascending node, rad, 0 to 2π; 0 in the equator's plane.
    pub node_rad: f32,
    /// Argument of perigee, rad, 0 to 2π; 0 on a circle.
    pub perigee_rad: f32,
    /// True anomaly, rad, 0 to 2π; on a circle it counts from the node.
    pub anomaly_rad: f32,
}

/// The attitude against local vertical and local horizontal: z down to the Earth's centre, y against the
/// orbit's normal, x along the flight. By the attitude and the orbit of the same second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalAttitude {
    /// LVLH to star path, `[x, y, z, w]`.
    pub quaternion: [f32; 4],
    /// Angle between the Earth path's line of sight and the Earth's centre, rad, 0 to π.
    pub nadir_rad: f32,
    /// Yaw of the Earth path: the angle about the vertical, from the flight's direction towards LVLH y, to
    /// the path's x axis, rad, -π to π; 0 where that axis is vertical.
    pub yaw_rad: f32,
}

/// The sensor's next change of state (thesis tab. 8.1): an outage that begins or ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextState {
    /// What it is then.
    pub state: SensorState,
    /// Seconds until then.
    pub in_s: u32,
    /// Standard deviation of these, s: by orbit, directions and whole seconds.
    pub sigma_s: f32,
    /// Seconds that it lasts; `None` where its end is not foreseen.
    pub lasts_s: Option<u32>,
}

/// What a magnetometer reads, and how far it is to be believed; along the axes of the Earth path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MagnetometerReport {
    /// Its reading less its zero, uT: the Earth's field.
    pub field_ut: [f32; 3],
    /// Its zero as stars and orbit have shown it, uT: the spacecraft's own field.
    pub zero_ut: [f32; 3],
    /// Standard deviation of the zero, an axis, uT.
    pub zero_sigma_ut: f32,
    /// Whether the attitude of this second rests on it.
    pub used: bool,
}

/// Something that happened in a second and is worth a line in a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// The next second has another mode, and why; for [`Guard::Commanded`] and [`Guard::MemoryDamaged`]:
    /// this one has.
    Mode(Mode, Guard),
    /// The first arc's orbit has passed its tests: it is known from now on.
    OrbitStarted,
    /// The orbit's sigma fell below its goal.
    OrbitConverged,
    /// An observation contradicted the orbit and counted for less.
    FixDownweighted,
    /// So many observations contradicted the orbit that it was forgotten and begins anew; or it was damaged
    /// in memory and begins with the one told last, with three times its sigma.
    OrbitRestarted,
    /// The orbit was forgotten: it cannot be propagated over so long a gap, its position is no longer known
    /// to a tenth of its length, or it never converged and had no observation for a whole revolution; or it
    /// was damaged in memory in a second in which none was told.
    OrbitForgotten,
    /// Terrestrial Time by the clock differs by more than 0.1 s from its last value propagated by local time.
    ClockJump,
    /// The detector is blinded and the Sun is, by attitude and time, in the field of a path; reported when an
    /// outage begins.
    SunInPath,
    /// The parameters were damaged in memory and taken from their copy.
    ParametersRestored,
    /// The parameters were damaged in memory, and so was their copy: no image is taken until a table is
    /// loaded.
    ParametersLost,
    /// The catalogue does not have its CRC any more. It is used all the same.
    CatalogueDamaged,
    /// The calibration does not have its CRC any more. It is used all the same.
    CalibrationDamaged,
    /// Attitudes contradicted the rate sensor time after time: it is not asked until the restart.
    RateSensorShutOut,
    /// Stars and orbit contradicted the magnetometer time after time: it is not asked until the restart.
    MagnetometerShutOut,
    /// The time was damaged in memory, with what the ground said of it: the clock is asked anew.
    TimeForgotten,
    /// What ground is usual at the limb was damaged in memory: it is learned anew.
    GroundForgotten,
    /// What was commanded of the shutters was damaged in memory: both are opened, and moved by the Sun again.
    ShuttersReleased,
    /// The second before took longer than the computer allows ([`overran`](fsw_hal::StageMeter::overran)).
    Overran,
}

/// One second of the sensor; by default one of which nothing is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Seconds since start.
    pub cycle: u32,
    /// Instant of the image, or of the second where none was used: on-board counter, microseconds since
    /// power-on.
    pub local_us: i64,
    /// The same in Terrestrial Time, microseconds since J2000.0; `None` where the clock has never given it.
    pub instant_us: Option<i64>,
    /// What Terrestrial Time rests on. Where it is unknown stars are tracked without correcting their
    /// aberration.
    pub clock: ClockState,
    /// Mode in which the second was spent.
    pub mode: Mode,
    /// What was done with it.
    pub activity: Activity,
    /// Exposure that the image was asked for with, us: a shorter one than that of the parameters where the
    /// sensor turns. `None` where the second needed no image.
    pub exposure_us: Option<u32>,
    /// What came of the stars; `None` where none were looked for, or a fault came first.
    pub outcome: Option<Outcome>,
    /// What did not serve.
    pub faults: Faults,
    /// Whether the star path was to be shut.
    pub star_path_shut: bool,
    /// Whether the Earth path was to be shut.
    pub earth_path_shut: bool,
    /// Whether the Earth path's filter was to be out of the way.
    pub earth_path_clear: bool,
    /// How many stars were seen through the Earth path that do not contradict each other; `None` where none
    /// were looked for.
    pub earth_path_stars: Option<u8>,
    /// The attitude, where there is one: of one image alone.
    pub attitude: Option<AttitudeReport>,
    /// The same filtered, in a second whose image was taken into the filter.
    pub filtered: Option<FilteredAttitude>,
    /// Rate of the star path against the stars in its own frame, rad/s, from all images so far.
    pub rate_rad_s: Option<[f32; 3]>,
    /// Star-like spots in the image or its windows.
    pub detections: u16,
    /// Best focal length over the parameter, from this image's stars.
    pub focal_ratio: Option<f32>,
    /// The stars recognised, brightest first.
    pub stars: Vec<StarReport, MAX_STARS>,
    /// What came of looking for the Earth.
    pub earth_status: EarthStatus,
    /// The Earth, where it was found.
    pub earth: Option<EarthReport>,
    /// Limb points used, px.
    pub limb_px: Vec<[f32; 2], MAX_LIMB_POINTS>,
    /// The orbit, where it is known.
    pub orbit: Option<OrbitReport>,
    /// The attitude against the local vertical, where attitude and orbit are known.
    pub local: Option<LocalAttitude>,
    /// What happened.
    pub events: Vec<Event, MAX_EVENTS>,
    /// The rate while no attitude is known: from streaks, or from stars without names.
    pub rate: Option<RateReport>,
    /// What came of the command of the second; `None` without one.
    pub command: Option<CommandOutcome>,
    /// What the sensor can do in this second (thesis tab. 8.1): the Sun by attitude and time, the limb by
    /// what is seen of it or by the orbit. `None` where these do not tell.
    pub state: Option<SensorState>,
    /// The sensor's next change of state, where one is foreseen within a revolution: attitude and orbit are
    /// known, and the attitude is held, in space or against the local vertical.
    pub next_state: Option<NextState>,
    /// What the magnetometer reads, where there is one and the orbit is known.
    pub magnetometer: Option<MagnetometerReport>,
}

impl Report {
    /// The orbit as [`Command::Orbit`](crate::command::Command::Orbit) takes it back after a restart, its
    /// sigmas those of the worst axes; `None` without an orbit or without Terrestrial Time.
    pub fn ground_orbit(&self) -> Option<GroundOrbit> {
        Some(self.orbit.as_ref()?.ground_orbit(self.instant_us?))
    }
}

impl OrbitReport {
    /// The same as an orbit by the ground, of that Terrestrial Time.
    pub(crate) fn ground_orbit(&self, time_us: i64) -> GroundOrbit {
        let worst = |sigmas: [f32; 3]| f64::from(sigmas.into_iter().fold(0.0, f32::max));
        GroundOrbit {
            state: OrbitState {
                time_us,
                position_km: self.position_km.into(),
                velocity_km_s: self.velocity_km_s.into(),
            },
            position_sigma_km: worst(self.sigma_position_km),
            velocity_sigma_km_s: worst(self.sigma_velocity_km_s),
        }
    }
}

/// Writes a report as a frame and gives the bytes used.
///
/// # Errors
/// [`PacketError::Buffer`] when `buffer` is shorter than the frame; [`MAX_FRAME_BYTES`] always suffice.
pub fn encode<'a>(report: &Report, buffer: &'a mut [u8]) -> Result<&'a [u8], PacketError> {
    packet::encode(VERSION, report, buffer)
}

/// Reads a frame.
///
/// # Errors
/// See [`PacketError`].
pub fn decode(frame: &[u8]) -> Result<Report, PacketError> {
    packet::decode(VERSION, frame)
}

/// Writes a report as the next piece of a stream, length and frame, and gives the bytes used.
///
/// # Errors
/// As [`encode`].
pub fn encode_next<'a>(report: &Report, buffer: &'a mut [u8]) -> Result<&'a [u8], PacketError> {
    let (length, frame) = buffer.split_first_chunk_mut::<2>().ok_or(PacketError::Buffer)?;
    let bytes = u16::try_from(encode(report, frame)?.len()).map_err(|_| PacketError::Buffer)?;
    *length = bytes.to_le_bytes();
    buffer.get(..usize::from(bytes) + 2).ok_or(PacketError::Buffer)
}

/// Takes the first frame off a stream: the frame and the rest; `None` at its end or where it breaks off.
pub fn split_first(stream: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = stream.split_first_chunk::<2>()?;
    rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))
}

#[cfg(test)]
mod tests;
