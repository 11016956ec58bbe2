//! The files that the program reads and writes.
//!
//! | module | file |
//! |---|---|
//! | [`camera_file`] | cameras (TOML) |
//! | [`ccsds`] | CCSDS OEM and AEM under way |
//! | [`cycles`] | `cycles.csv`, a row a second |
//! | [`defects_file`] | a detector's defects |
//! | [`ephemerides`] | the four CCSDS messages of a run |
//! | [`fits`] | the first picture of a FITS file |
//! | [`frames_file`] | frames recorded for the emulated target, and their replay |
//! | [`json`] | one JSON object a line |
//! | [`orbit_state`] | a state of an orbit (JSON) |
//! | [`picture`] | a picture file served as a detector |
//! | [`telemetry_stream`] | telemetry frames from a file or a link, found again behind damaged bytes |
//! | [`toml_keys`] | lines of the keys of a TOML file, for messages |

pub mod camera_file;
pub mod ccsds;
pub mod cycles;
pub mod defects_file;
pub mod ephemerides;
pub mod fits;
pub mod frames_file;
pub mod json;
pub mod orbit_state;
pub mod picture;
pub mod telemetry_stream;
pub mod toml_keys;

/// Smallest side of a detector or picture, px: less cannot hold a star field.
pub const SIDE_MIN_PX: u32 = 32;
/// Largest side, px: coordinates are `u16`.
pub const SIDE_MAX_PX: u32 = 65_535;
