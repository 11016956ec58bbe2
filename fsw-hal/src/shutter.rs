//! Shutters in front of the two paths.
//!
//! Both paths look at one detector: a Sun in either blinds both (thesis tab. 8.1, states 1, 3 and 4). Where
//! that path can be shut the other one goes on (thesis §9.2).

use crate::error::{self, Error, ErrorType};

/// Which of the two paths let light through; never none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpenPaths {
    /// Star path and Earth path.
    #[default]
    Both,
    /// The star path alone.
    Star,
    /// The Earth path alone.
    Earth,
}

impl OpenPaths {
    /// Whether stars can be seen.
    pub const fn star(self) -> bool {
        !matches!(self, Self::Earth)
    }

    /// Whether the Earth path can be seen through.
    pub const fn earth(self) -> bool {
        !matches!(self, Self::Star)
    }
}

/// Why a shutter did not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// It did not arrive where it was sent.
    Stuck,
    /// It did not answer in time.
    Timeout,
    /// The link to it reported an error.
    Bus,
}

impl error::ErrorKind for ErrorKind {}

/// The shutters of both paths.
pub trait Shutter: ErrorType<Error: Error<ErrorKind>> {
    /// Opens these paths and shuts the other one. Called in every second before the exposure, also where
    /// nothing is to be moved; returns when they stand so.
    ///
    /// # Errors
    /// [`ErrorKind::Stuck`], [`ErrorKind::Timeout`] or [`ErrorKind::Bus`]; then nothing is known of where
    /// they stand.
    fn open(&mut self, paths: OpenPaths) -> Result<(), Self::Error>;
}

impl<S: Shutter + ?Sized> Shutter for &mut S {
    fn open(&mut self, paths: OpenPaths) -> Result<(), Self::Error> {
        S::open(self, paths)
    }
}

/// None on board: both paths are open.
impl Shutter for () {
    fn open(&mut self, _: OpenPaths) -> Result<(), Self::Error> {
        Ok(())
    }
}
