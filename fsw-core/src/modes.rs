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

#[cfg(test)]
mod tests {
    use super::Mode::{Acquisition, Tracking};
    use super::*;

    const PATIENCE_S: u16 = 3;

    fn after(mode: Mode, attitude: bool, rate: bool, seconds_without: u16) -> Mode {
        next(mode, &Seen { attitude, rate, seconds_without }, PATIENCE_S)
    }

    #[test]
    fn the_sensor_begins_with_acquisition() {
        assert_eq!(Mode::default(), Acquisition);
    }

    #[test]
    fn acquisition_becomes_tracking_once_attitude_and_rate_are_known() {
        assert_eq!(after(Acquisition, true, true, 0), Tracking);
        // One image gives no rate; a rate without an attitude of this second is an old one.
        for (attitude, rate) in [(false, false), (true, false), (false, true)] {
            for seconds_without in [0, PATIENCE_S, u16::MAX] {
                assert_eq!(after(Acquisition, attitude, rate, seconds_without), Acquisition);
            }
        }
    }

    #[test]
    fn tracking_goes_on_until_patience_is_at_its_end() {
        for seconds_without in 0..PATIENCE_S {
            assert_eq!(after(Tracking, seconds_without == 0, true, seconds_without), Tracking);
            assert_eq!(after(Tracking, false, false, seconds_without), Tracking);
        }
        for seconds_without in [PATIENCE_S, PATIENCE_S + 1, u16::MAX] {
            assert_eq!(after(Tracking, false, true, seconds_without), Acquisition);
        }
    }
}
