//! Shutters in front of the two paths, and the filter of the Earth path.
//!
//! Both paths look at one detector: a Sun in either blinds both (thesis tab. 8.1, states 1, 3 and 4). Where
//! that path can be shut the other one goes on (thesis §9.2). The Earth path has a grey filter. Where it can
//! be cleared, that path shows stars as well, as long as no lit Earth is in it (thesis tab. 9.1).

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
    /// Both, the Earth path without its filter: two fields of stars.
    BothClear,
}

impl OpenPaths {
    /// Whether stars can be seen.
    pub const fn star(self) -> bool {
        !matches!(self, Self::Earth)
    }

    /// Whether the lit Earth can be seen: the Earth path is open, its filter in it.
    pub const fn earth(self) -> bool {
        matches!(self, Self::Both | Self::Earth)
    }

    /// Whether both paths are open, with the filter or without.
    pub const fn both(self) -> bool {
        matches!(self, Self::Both | Self::BothClear)
    }

    /// Whether the Earth path is open without its filter.
    pub const fn clear(self) -> bool {
        matches!(self, Self::BothClear)
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

/// The shutters of both paths, and the filter of the Earth path.
pub trait Shutter: ErrorType<Error: Error<ErrorKind>> {
    /// Opens these paths and shuts the other one; the filter is out of the way for [`OpenPaths::BothClear`]
    /// alone. Called in every second before the exposure, also where nothing is to be moved; returns when
    /// they stand so.
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
