//! The errors of all instruments, in the idiom of `embedded-hal` 1.0.
//!
//! A driver names its own error type by [`ErrorType`]; the flight code asks it for its [`Error::kind`] alone.
//! Each instrument has its own kinds, an enum of its module; `Error<K>` says that an error is of one of the
//! kinds `K`.

use core::convert::Infallible;
use core::fmt::Debug;

/// The kinds of error that one instrument has.
pub trait ErrorKind: Copy + Debug {}

/// An instrument driver's error, of the kinds `K`.
pub trait Error<K: ErrorKind>: Debug {
    /// What kind of error it is.
    fn kind(&self) -> K;
}

/// A driver without errors of its own uses the kinds themselves.
impl<K: ErrorKind> Error<K> for K {
    fn kind(&self) -> K {
        *self
    }
}

/// Never made: the error of `()`, an instrument that is not on board.
impl<K: ErrorKind> Error<K> for Infallible {
    fn kind(&self) -> K {
        match *self {}
    }
}

/// Why an instrument that is read once a second, a rate sensor or a magnetometer, did not deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadingError {
    /// What it measures is beyond its range along an axis.
    Saturated,
    /// It did not answer in time.
    Timeout,
    /// The link to it reported an error.
    Bus,
}

impl ErrorKind for ReadingError {}

/// The error type of an instrument driver.
pub trait ErrorType {
    /// Error type; each instrument's trait says of which kinds it is.
    type Error: Debug;
}

impl<T: ErrorType + ?Sized> ErrorType for &mut T {
    type Error = T::Error;
}

impl ErrorType for () {
    type Error = Infallible;
}

/// An instrument that may be missing.
impl<T: ErrorType> ErrorType for Option<T> {
    type Error = T::Error;
}
