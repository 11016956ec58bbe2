//! The two times of the flight code.
//!
//! Local time counts microseconds since power-on and never steps: all elapsed times (filters, streaks,
//! time-outs) come from it. Terrestrial Time says where Sun and Earth stand; it is local time through a
//! correlation that the spacecraft may correct or lose.

use crate::error::{self, Error, ErrorType};

/// An instant on the on-board counter, microseconds since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct LocalTime(i64);

impl LocalTime {
    /// The instant at which the counter reads `us` microseconds.
    pub const fn from_us(us: i64) -> Self {
        Self(us)
    }

    /// The counter, microseconds.
    pub const fn as_us(self) -> i64 {
        self.0
    }

    /// Microseconds from `earlier` to this instant; negative where this is the earlier one, cut at the ends
    /// of the scale.
    pub const fn us_since(self, earlier: Self) -> i64 {
        self.0.saturating_sub(earlier.0)
    }

    /// The instant `us` microseconds later.
    pub const fn plus_us(self, us: i64) -> Self {
        Self(self.0.saturating_add(us))
    }
}

/// Why a clock gave no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The counter runs, but its correlation with Terrestrial Time is not known.
    NotSynchronised,
    /// The clock did not answer in time.
    Timeout,
    /// The link to the clock reported an error.
    Bus,
}

impl error::ErrorKind for ErrorKind {}

/// The on-board counter and its correlation with Terrestrial Time.
pub trait Clock: ErrorType<Error: Error<ErrorKind>> {
    /// The counter now; never less than at the call before.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] or [`ErrorKind::Bus`] when the hardware fails.
    fn local_time(&mut self) -> Result<LocalTime, Self::Error>;

    /// Terrestrial Time at a local instant of the last seconds, microseconds since J2000.0
    /// (2000-01-01T12:00:00 TT), by the correlation in force now. An error of a millisecond displaces a low
    /// satellite by 8 m.
    ///
    /// # Errors
    /// [`ErrorKind::NotSynchronised`] without a correlation, [`ErrorKind::Timeout`] or [`ErrorKind::Bus`]
    /// when the hardware fails.
    fn terrestrial_us(&mut self, at: LocalTime) -> Result<i64, Self::Error>;
}

impl<C: Clock + ?Sized> Clock for &mut C {
    fn local_time(&mut self) -> Result<LocalTime, Self::Error> {
        C::local_time(self)
    }

    fn terrestrial_us(&mut self, at: LocalTime) -> Result<i64, Self::Error> {
        C::terrestrial_us(self, at)
    }
}

/// A clock that was read beforehand: both times of one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instant {
    /// The counter.
    pub local: LocalTime,
    /// Terrestrial Time, microseconds since J2000.0; `None` while not synchronised.
    pub terrestrial_us: Option<i64>,
}

impl Instant {
    /// A synchronised clock.
    pub const fn new(local: LocalTime, terrestrial_us: i64) -> Self {
        Self { local, terrestrial_us: Some(terrestrial_us) }
    }
}

impl ErrorType for Instant {
    type Error = ErrorKind;
}

impl Clock for Instant {
    fn local_time(&mut self) -> Result<LocalTime, ErrorKind> {
        Ok(self.local)
    }

    fn terrestrial_us(&mut self, at: LocalTime) -> Result<i64, ErrorKind> {
        let now_us = self.terrestrial_us.ok_or(ErrorKind::NotSynchronised)?;
        Ok(now_us.saturating_add(at.us_since(self.local)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terrestrial_time_follows_the_counter() {
        let mut clock = Instant::new(LocalTime::from_us(5_000_000), 800_000_000);
        assert_eq!(clock.terrestrial_us(LocalTime::from_us(4_750_000)), Ok(799_750_000));
        clock.terrestrial_us = None;
        assert_eq!(clock.terrestrial_us(LocalTime::default()), Err(ErrorKind::NotSynchronised));
        assert_eq!(clock.local_time(), Ok(LocalTime::from_us(5_000_000)));
    }

    #[test]
    fn differences_are_cut_at_the_ends_of_the_scale() {
        let (first, last) = (LocalTime::from_us(i64::MIN), LocalTime::from_us(i64::MAX));
        assert_eq!((last.us_since(first), first.us_since(last)), (i64::MAX, i64::MIN));
        assert_eq!(last.plus_us(1), last);
    }
}
