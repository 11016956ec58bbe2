//! The list of commands: what each is called, its service and subservice, its fields.
//!
//! In: service, subservice and the fields' bytes, big-endian. Out: a [`Telecommand`]. [`ROWS`] lists them for
//! the host, which makes the page `TELECOMMANDS.md` of them.

use super::refusal::Refusal;
use super::{GroundOrbit, TimeCorrelation};
use crate::orbit::OrbitState;
use fsw_hal::{Area, LocalTime, OpenPaths};
use nalgebra::Vector3;

/// Version of the list: it moves when a command or its fields change, not when one is added.
pub const VERSION: u8 = 2;
/// Service of the commands to the sensor; mission-specific services begin at 128.
pub const SENSOR: u8 = 128;
/// Service of the parameter table and of the files of the areas.
pub const TABLE: u8 = 129;
/// Service of what the ground asks for: the log of events, the spots of the image.
pub const REQUESTS: u8 = 130;
/// Most bytes of a table or a file in a packet.
pub const MAX_PART_BYTES: usize = 200;
/// Subservice of [`TABLE`] with which a part of the table is sent down.
pub(super) const PART_DOWN: u8 = 4;
/// Subservices of [`REQUESTS`] with which a part of the log and some of the spots are sent down.
pub(super) const EVENTS_DOWN: u8 = 2;
pub(super) const SPOTS_DOWN: u8 = 4;

/// A command as it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Telecommand<'a> {
    /// [`Command::Reacquire`](super::Command::Reacquire).
    Reacquire,
    /// [`Command::Restart`](super::Command::Restart).
    Restart,
    /// [`Command::Safe`](super::Command::Safe).
    Safe,
    /// [`Command::Exposure`](super::Command::Exposure), us.
    Exposure(u32),
    /// [`Command::Orbit`](super::Command::Orbit).
    Orbit(GroundOrbit),
    /// [`Command::Time`](super::Command::Time).
    Time(TimeCorrelation),
    /// [`Command::Shutter`](super::Command::Shutter).
    Shutter(Option<OpenPaths>),
    /// A part of a parameter table, or of the file of an area: it begins anew at 0, else where the last part
    /// ended.
    Part {
        /// The area; `None`: the parameter table.
        area: Option<Area>,
        /// Where in the table or file it begins, bytes.
        offset: u32,
        /// The part.
        bytes: &'a [u8],
    },
    /// Load the table, or take the file of an area, that was sent in parts.
    Load {
        /// The area; `None`: the parameter table.
        area: Option<Area>,
        /// Its length, bytes.
        length: u32,
        /// Its CRC-32 (ISO-HDLC), all bytes.
        crc: u32,
    },
    /// Send the parameter table in force down in parts.
    Dump,
    /// Send the log of events down in parts.
    Events,
    /// Send the spots that were found last down in parts.
    Spots,
}

/// A field of a command.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Its type, big-endian; the last one of a command may be `bytes`.
    pub kind: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

/// A command of the list, for people.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Service and subservice.
    pub number: (u8, u8),
    /// Its name.
    pub name: &'static str,
    /// Its fields in their order.
    pub fields: &'static [Field],
    /// What it does.
    pub about: &'static str,
    /// Why it can be refused, beside what holds for every packet.
    pub refusals: &'static [Refusal],
}

/// Which area a part or a load is of.
const AREA: Field = field("area", "u8", "0 parameter table, 1 catalogue, 2 calibration, 3 bad pixels");

const fn field(name: &'static str, kind: &'static str, unit: &'static str) -> Field {
    Field { name, kind, unit }
}

/// The list.
pub const ROWS: &[Row] = &[
    Row {
        number: (SENSOR, 1),
        name: "reacquire",
        fields: &[],
        about: "forget the attitude and acquire anew; ends commanded safe",
        refusals: &[Refusal::ParametersLost],
    },
    Row {
        number: (SENSOR, 2),
        name: "restart",
        fields: &[],
        about: "forget attitude, orbit and what was learned of lens, rate sensor and magnetometer, begin with \
                the self-test; ends commanded safe",
        refusals: &[Refusal::ParametersLost],
    },
    Row {
        number: (SENSOR, 3),
        name: "safe",
        fields: &[],
        about: "forget the attitude and take no image until `reacquire` or `restart`",
        refusals: &[],
    },
    Row {
        number: (SENSOR, 4),
        name: "exposure",
        fields: &[field("exposure_us", "u32", "us")],
        about: "set `imaging.exposure_us` of the parameter table in force",
        refusals: &[Refusal::Exposure, Refusal::ParametersLost],
    },
    Row {
        number: (SENSOR, 5),
        name: "orbit",
        fields: &[
            field("time_us", "i64", "us of TT since J2000.0"),
            field("position_km", "3 f64", "km, ICRS axes"),
            field("velocity_km_s", "3 f64", "km/s, ICRS axes"),
            field("position_sigma_km", "f64", "km"),
            field("velocity_sigma_km_s", "f64", "km/s"),
        ],
        about: "take this orbit in the place of the one in force",
        refusals: &[Refusal::Orbit, Refusal::Epoch, Refusal::ParametersLost],
    },
    Row {
        number: (SENSOR, 6),
        name: "time",
        fields: &[
            field("local_us", "i64", "us of the on-board counter"),
            field("terrestrial_us", "i64", "us of TT since J2000.0"),
        ],
        about: "Terrestrial Time at an instant of the counter; serves a day while the clock gives none",
        refusals: &[Refusal::ClockServes, Refusal::Correlation],
    },
    Row {
        number: (SENSOR, 7),
        name: "shutter",
        fields: &[field("paths", "u8", "0 by the Sun, 1 both, 2 star, 3 Earth, 4 both without the filter")],
        about: "hold these paths open, whatever the Sun does, until another such command, `restart`, or a \
                parameter table that does not allow them",
        refusals: &[Refusal::Shutter, Refusal::ParametersLost],
    },
    Row {
        number: (TABLE, 1),
        name: "part",
        fields: &[AREA, field("offset", "u32", "bytes"), field("bytes", "bytes", "1 to 200")],
        about: "a part of a parameter table or of the file of an area; offset 0 begins anew, any other \
                continues the last part",
        refusals: &[Refusal::Part, Refusal::Area, Refusal::Memory],
    },
    Row {
        number: (TABLE, 2),
        name: "load",
        fields: &[
            AREA,
            field("length", "u32", "bytes"),
            field("crc", "u32", "CRC-32 (ISO-HDLC) of the table or file"),
        ],
        about: "take what was sent in parts: a parameter table now, and acquire anew with it; the file of an \
                area from the next start on, once it was checked, 4,096 bytes a second",
        refusals: &[
            Refusal::Incomplete,
            Refusal::TableChecksum,
            Refusal::TableDamaged,
            Refusal::TableRange,
            Refusal::TableCalibration,
            Refusal::Area,
            Refusal::Memory,
            Refusal::AreaChecksum,
            Refusal::AreaContent,
            Refusal::AreaDetector,
        ],
    },
    Row {
        number: (TABLE, 3),
        name: "dump",
        fields: &[],
        about: "send the parameter table in force down, in reports (129, 4)",
        refusals: &[],
    },
    Row {
        number: (REQUESTS, 1),
        name: "events",
        fields: &[],
        about: "send the last 64 events down, in reports (130, 2)",
        refusals: &[],
    },
    Row {
        number: (REQUESTS, 3),
        name: "spots",
        fields: &[],
        about: "send the spots that were found last down, stars and what else is bright, in reports (130, 4)",
        refusals: &[],
    },
];

/// The paths to be held open, by their codes; `None`: by the Sun.
const PATHS: [Option<OpenPaths>; 5] =
    [None, Some(OpenPaths::Both), Some(OpenPaths::Star), Some(OpenPaths::Earth), Some(OpenPaths::BothClear)];

/// The code of paths to be held open.
pub(super) fn paths_code(paths: Option<OpenPaths>) -> u8 {
    PATHS.iter().position(|known| *known == paths).unwrap_or(0) as u8
}

/// The areas by their codes; `None`: the parameter table.
const AREAS: [Option<Area>; 4] =
    [None, Some(Area::Catalogue), Some(Area::Calibration), Some(Area::BadPixels)];

/// The code of an area.
pub(super) fn area_code(area: Option<Area>) -> u8 {
    AREAS.iter().position(|known| *known == area).unwrap_or(0) as u8
}

/// Fields still to be read.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (field, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*field)
    }

    fn paths(&mut self) -> Option<Result<Option<OpenPaths>, Refusal>> {
        let [code] = self.bytes()?;
        Some(PATHS.get(usize::from(code)).copied().ok_or(Refusal::Shutter))
    }

    fn area(&mut self) -> Option<Result<Option<Area>, Refusal>> {
        let [code] = self.bytes()?;
        Some(AREAS.get(usize::from(code)).copied().ok_or(Refusal::Area))
    }

    fn u32(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_be_bytes)
    }

    fn i64(&mut self) -> Option<i64> {
        self.bytes().map(i64::from_be_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.bytes().map(f64::from_be_bytes)
    }

    fn vector(&mut self) -> Option<Vector3<f64>> {
        Some(Vector3::new(self.f64()?, self.f64()?, self.f64()?))
    }

    /// All that is left.
    fn rest(&mut self) -> &'a [u8] {
        core::mem::take(&mut self.0)
    }

    fn orbit(&mut self) -> Option<GroundOrbit> {
        Some(GroundOrbit {
            state: OrbitState {
                time_us: self.i64()?,
                position_km: self.vector()?,
                velocity_km_s: self.vector()?,
            },
            position_sigma_km: self.f64()?,
            velocity_sigma_km_s: self.f64()?,
        })
    }

    fn time(&mut self) -> Option<TimeCorrelation> {
        Some(TimeCorrelation { local: LocalTime::from_us(self.i64()?), terrestrial_us: self.i64()? })
    }
}

impl<'a> Telecommand<'a> {
    /// Reads the fields of a service's subservice.
    ///
    /// # Errors
    /// [`Refusal::Unknown`], [`Refusal::Fields`].
    pub fn decode(number: (u8, u8), fields: &'a [u8]) -> Result<Self, Refusal> {
        let mut fields = Fields(fields);
        let telecommand = match number {
            (SENSOR, 1) => Some(Self::Reacquire),
            (SENSOR, 2) => Some(Self::Restart),
            (SENSOR, 3) => Some(Self::Safe),
            (SENSOR, 4) => fields.u32().map(Self::Exposure),
            (SENSOR, 5) => fields.orbit().map(Self::Orbit),
            (SENSOR, 6) => fields.time().map(Self::Time),
            (SENSOR, 7) => fields.paths().transpose()?.map(Self::Shutter),
            (TABLE, 1) => {
                let area = fields.area().transpose()?;
                area.zip(fields.u32()).map(|(area, offset)| Self::Part { area, offset, bytes: fields.rest() })
            }
            (TABLE, 2) => {
                let area = fields.area().transpose()?;
                let length = area.zip(fields.u32());
                length.zip(fields.u32()).map(|((area, length), crc)| Self::Load { area, length, crc })
            }
            (TABLE, 3) => Some(Self::Dump),
            (REQUESTS, 1) => Some(Self::Events),
            (REQUESTS, 3) => Some(Self::Spots),
            _ => return Err(Refusal::Unknown),
        };
        telecommand.filter(|_| fields.0.is_empty()).ok_or(Refusal::Fields)
    }

    /// Its service and subservice.
    pub fn number(&self) -> (u8, u8) {
        match self {
            Self::Reacquire => (SENSOR, 1),
            Self::Restart => (SENSOR, 2),
            Self::Safe => (SENSOR, 3),
            Self::Exposure(_) => (SENSOR, 4),
            Self::Orbit(_) => (SENSOR, 5),
            Self::Time(_) => (SENSOR, 6),
            Self::Shutter(_) => (SENSOR, 7),
            Self::Part { .. } => (TABLE, 1),
            Self::Load { .. } => (TABLE, 2),
            Self::Dump => (TABLE, 3),
            Self::Events => (REQUESTS, 1),
            Self::Spots => (REQUESTS, 3),
        }
    }
}
