//! The time of a second.
//!
//! A second of operation has one instant: the middle of its exposure. The sensor reads it once, at the beginning of the
//! second; orbit, Sun and aberration are those of that instant.

/// A clock that knows the instant of the present second.
pub trait Clock {
    /// The middle of this second's exposure: Terrestrial Time, microseconds since J2000.0 (2000-01-01T12:00:00 TT).
    /// An error of a millisecond displaces a low satellite by 8 m.
    fn instant_us(&mut self) -> i64;
}

/// An instant that was read beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instant(pub i64);

impl Clock for Instant {
    fn instant_us(&mut self) -> i64 {
        self.0
    }
}
