//! Non-volatile store of the state that is to outlive a restart.
//!
//! A record is bytes that only who keeps them understands: an orbit, a parameter table. The store knows when
//! it was kept, whether it is whole, and whether it is too old.
//!
//! Instants are Terrestrial Time: the on-board counter begins anew with the restart.

use crate::error::{self, Error, ErrorType};

/// Why a record was not kept or not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The record is longer than the store has room for, or than the buffer.
    Length,
    /// It was kept too long ago, or at an instant that is still to come.
    Stale,
    /// The memory did not answer in time.
    Timeout,
    /// The link to the memory reported an error, or what was written is not what is read.
    Bus,
}

impl error::ErrorKind for ErrorKind {}

/// A store of one record.
pub trait StateStore: ErrorType<Error: Error<ErrorKind>> {
    /// Keeps `record` in the place of the one before, as of `instant_us` (Terrestrial Time, microseconds
    /// since J2000.0). Where power is lost before this returns, one of the two is there, whole.
    ///
    /// # Errors
    /// [`ErrorKind::Length`] for a record that does not fit, [`ErrorKind::Timeout`] or [`ErrorKind::Bus`]
    /// when the hardware fails; the record before stays then.
    fn keep(&mut self, record: &[u8], instant_us: i64) -> Result<(), Self::Error>;

    /// The record that was kept last and whole, at the front of `buffer`; `None` where there is none.
    /// `now_us` is Terrestrial Time, microseconds since J2000.0.
    ///
    /// # Errors
    /// [`ErrorKind::Stale`] where it is older than `max_age_us` or was kept after `now_us`,
    /// [`ErrorKind::Length`] where it is longer than `buffer`, [`ErrorKind::Timeout`] or [`ErrorKind::Bus`]
    /// when the hardware fails; `buffer` is not to be used then.
    fn kept<'b>(
        &mut self,
        buffer: &'b mut [u8],
        now_us: i64,
        max_age_us: i64,
    ) -> Result<Option<&'b [u8]>, Self::Error>;
}

impl<S: StateStore + ?Sized> StateStore for &mut S {
    fn keep(&mut self, record: &[u8], instant_us: i64) -> Result<(), Self::Error> {
        S::keep(self, record, instant_us)
    }

    fn kept<'b>(
        &mut self,
        buffer: &'b mut [u8],
        now_us: i64,
        max_age_us: i64,
    ) -> Result<Option<&'b [u8]>, Self::Error> {
        S::kept(self, buffer, now_us, max_age_us)
    }
}

/// None on board: nothing is ever kept.
impl StateStore for () {
    fn keep(&mut self, _: &[u8], _: i64) -> Result<(), Self::Error> {
        Ok(())
    }

    fn kept<'b>(&mut self, _: &'b mut [u8], _: i64, _: i64) -> Result<Option<&'b [u8]>, Self::Error> {
        Ok(None)
    }
}
