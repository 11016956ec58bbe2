//! Time: calendars and clocks, and what turns with them: Sun, Moon and the Earth's axes.

pub mod civil_time;
pub mod earth_orientation;
pub mod ephemeris;
