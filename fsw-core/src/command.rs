//! The command link: telecommand packets in, the command of a second and reports out.
//!
//! In: the bytes of a packet ([`CommandLink::receive`]). Out: the [`Command`] of the next second
//! ([`CommandLink::command`]), and packets that report acceptance, completion or the reason of a refusal
//! ([`CommandLink::next_report`]). A command that is refused changes nothing.
//!
//! A telecommand is a space packet (CCSDS 133.0-B-2) with the secondary header of ECSS-E-ST-70-41C:
//!
//! | bytes | content |
//! |---|---|
//! | 6 | primary header: telecommand, secondary header, APID of the sensor, unsegmented, sequence count, length |
//! | 5 | secondary header: version 2 and acknowledgement flags, service, subservice, source |
//! | 1 | version of the [list of commands](telecommand), [`VERSION`] |
//! | n | fields of the command, big-endian |
//! | 4, 16 | only where a key is set: counter and tag, see [`authentication`] |
//! | 2 | CRC-16 (CCITT, register all ones at first) of all before |
//!
//! A report is a telemetry packet with the same primary header and checksum; its secondary header has the
//! version 2, service, subservice, the count of reports of this kind, destination 0, and the time: 4 bytes of
//! seconds and 3 of their fraction since the on-board counter began (CUC).
//!
//! | service, subservice | report | data |
//! |---|---|---|
//! | 1, 1 | accepted | the request: the first 4 bytes of its packet |
//! | 1, 2 | refused when it arrived | request; [`Refusal`], u16 |
//! | 1, 7 | done | request |
//! | 1, 8 | refused when it was to be done | request; [`Refusal`], u16 |
//! | 129, 4 | part of the parameter table | offset, u16; length of the table, u16; bytes |
//! | 130, 2 | part of the [log of events](event_log) | number of its first, u32; how many are left, u16; events |
//! | 130, 4 | some of the [spots](spot_list) that were found last | time of the image, i64; how many are left, u16; spots |
//!
//! Files of catalogue, calibration and bad pixels go up in parts as a parameter table does, into memory of
//! the board ([`AreaStore`](fsw_hal::AreaStore)), are checked there, a slice a second, and serve from the
//! next start on.
//!
//! An image that makes no link links nothing of this, and one without that memory nothing of the files.

mod area_check;
pub mod authentication;
pub mod event_log;
pub mod ground;
mod link;
mod packets;
pub mod refusal;
pub mod spot_list;
pub mod telecommand;
mod upload;

use crate::image::Detection;
use crate::orbit::OrbitState;
use crate::parameters::Parameters;
use fsw_hal::{LocalTime, OpenPaths};
use serde::{Deserialize, Serialize};

pub use authentication::Key;
pub use link::{Accepted, CommandLink, Refused};
pub use packets::{MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES, RequestId};
pub use refusal::Refusal;
pub use telecommand::{MAX_PART_BYTES, Telecommand, VERSION};

/// What is sent down where the ground asks for it.
#[derive(Clone, Copy, Debug)]
pub struct Downlink<'a> {
    /// The parameter table in force.
    pub parameters: &'a Parameters,
    /// Local time of the image in which spots were sought last.
    pub image: LocalTime,
    /// The spots found in it.
    pub spots: &'a [Detection],
}

/// What the spacecraft wants of a second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Command<'a> {
    /// Go on.
    #[default]
    Continue,
    /// Forget the attitude and acquire anew.
    Reacquire,
    /// Forget attitude, orbit and what was learned of lens and rate sensor and begin with the self-test.
    Restart,
    /// Go to safe mode, until [`Command::Reacquire`] or [`Command::Restart`].
    Safe,
    /// Take this parameter table, a packet as
    /// [`Parameters::encode`](crate::parameters::Parameters::encode) writes it, and acquire anew with it.
    LoadParameters(&'a [u8]),
    /// Take `imaging.exposure_us` of the parameter table from here, us; nothing else changes.
    Exposure(u32),
    /// Take the orbit from here.
    Orbit(GroundOrbit),
    /// Take Terrestrial Time from here where the clock gives none.
    Time(TimeCorrelation),
    /// Hold these paths open until another such command; `None`: shut them against the Sun again.
    Shutter(Option<OpenPaths>),
}

/// An orbit by the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundOrbit {
    /// Position and velocity, ICRS axes, and when: in the last 100 minutes.
    pub state: OrbitState,
    /// Standard deviation of the position along each axis, km.
    pub position_sigma_km: f64,
    /// Standard deviation of the velocity along each axis, km/s.
    pub velocity_sigma_km_s: f64,
}

/// One instant in both times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeCorrelation {
    /// On the on-board counter: in the last day.
    pub local: LocalTime,
    /// In Terrestrial Time, microseconds since J2000.0.
    pub terrestrial_us: i64,
}

/// What came of the command of a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CommandOutcome {
    /// It was done.
    Done,
    /// It was refused and changed nothing.
    Refused(Refusal),
}

#[cfg(test)]
mod tests;
