//! Which mode comes next, and why (thesis §8).
//!
//! In: the present mode and what was seen this second. Out: the next mode. First form, two modes:
//!
//! | from | guard | to |
//! |---|---|---|
//! | acquisition | stars identified in two images, so that the rate is known and the names are confirmed | tracking |
//! | tracking | no attitude for `patience_s` seconds | acquisition |
//!
//! A command to reacquire is obeyed by the sensor at once, before the second begins.

use serde::{Deserialize, Serialize};

/// Mode of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// The whole detector is scanned and its stars identified without prior knowledge.
    #[default]
    Acquisition,
    /// Windows about predicted stars are read.
    Tracking,
}

/// What a second brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// An attitude was found or confirmed.
    pub attitude: bool,
    /// The rate is known: two attitudes in a row.
    pub rate: bool,
    /// Seconds in a row without one, this one included.
    pub seconds_without: u16,
}

/// The mode of the next second.
pub fn next(mode: Mode, seen: &Seen, patience_s: u16) -> Mode {
    match mode {
        Mode::Acquisition if seen.attitude && seen.rate => Mode::Tracking,
        Mode::Tracking if seen.seconds_without >= patience_s => Mode::Acquisition,
        unchanged => unchanged,
    }
}
