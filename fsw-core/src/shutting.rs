//! Which path is shut against the Sun (thesis §9.2).
//!
//! In: once a second whether the Sun blinds the image, and which paths it leaves free by attitude and time,
//! where these are known. Out: the paths to be open in the next second.
//!
//! | image | the Sun by attitude and time | next |
//! |---|---|---|
//! | clear, its attitude known | in a path, or within the margin of its field | that path is shut |
//! | clear, its attitude known | in neither, or in both | both open |
//! | clear, the attitude carried on | in neither | both open |
//! | clear, else | - | as it is; a path that is shut is opened for a look every `look_s` |
//! | blinded | - | the path that the Sun is in is shut, else the Earth path; if that does not help the other one; if neither does both are open for `look_s` |
//!
//! An image that was blinded with both paths open contradicts a Sun that is in neither: then only a look opens
//! them. Where a path has no shutter both are open instead. A command holds them until another one.

use fsw_ground::table::parameter_group;
use fsw_hal::{LocalTime, OpenPaths};
use serde::{Deserialize, Serialize};

/// Which paths have a shutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shutters {
    /// The star path.
    Star,
    /// The Earth path.
    Earth,
    /// Both.
    Both,
}

impl Shutters {
    /// Whether these paths can be open and no other.
    pub fn allow(self, paths: OpenPaths) -> bool {
        match self {
            Self::Star => paths.earth(),
            Self::Earth => paths.star(),
            Self::Both => true,
        }
    }
}

parameter_group! {
    /// The shutters of the two paths; there are none unless it is set.
    pub struct ShutterParameters in "shutter" {
        /// Which paths have a shutter.
        paths: Shutters = Shutters::Both, one of "Star, Earth, Both", "", "thesis 9.2";
        /// So near to the field of a path the Sun's disc may come before it is shut.
        margin_rad: f32 = 0.0087, 0.0..=0.5, "rad",
            "half a degree: a low satellite turns by 0.13 deg in the two seconds to the end of the next exposure";
        /// A path that is shut without knowing that the Sun is there is opened for a look after so long.
        look_s: u16 = 30, 5..=10_000, "s", "chosen: a blinded image costs a second";
    }
}

/// Where the Sun is by attitude and time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SunPlace {
    /// The paths that it leaves free; both where it is in both, as shutting one of them does not help.
    pub free: OpenPaths,
    /// Whether the attitude is that of this second's image, and not one that is carried on.
    pub measured: bool,
}

/// The shutters as they are asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shutting {
    open: OpenPaths,
    /// When they were moved last.
    moved: Option<LocalTime>,
    /// Paths shut in vain since the last clear image.
    tried: u8,
    /// An image with both paths open was blinded though the Sun was in neither by attitude and time, or these
    /// were not known; and none was clear with both open since.
    contradicted: bool,
    /// What the spacecraft wants, whatever the Sun does.
    held: Option<OpenPaths>,
}

impl Shutting {
    /// The paths that are to be open.
    pub fn open(&self) -> OpenPaths {
        self.open
    }

    /// Holds these paths open until another command; `None`: by the Sun again, from both open.
    pub fn command(&mut self, held: Option<OpenPaths>) {
        *self = Self { open: held.unwrap_or_default(), held, ..Self::default() };
    }

    /// Decides by the second that ended at `now`, whose image was `blinded` or not.
    pub fn next(
        &mut self,
        now: LocalTime,
        blinded: bool,
        sun: Option<SunPlace>,
        parameters: &ShutterParameters,
    ) {
        if self.held.is_some() {
            return;
        }
        let look_us = i64::from(parameters.look_s) * 1_000_000;
        let waited = self.moved.is_none_or(|moved| now.us_since(moved) >= look_us);
        if self.open == OpenPaths::Both {
            self.contradicted = blinded && sun.is_none_or(|sun| sun.free == OpenPaths::Both);
        }
        let wanted = if blinded { self.search(waited, sun) } else { self.keep(waited, sun) };
        let wanted = if parameters.paths.allow(wanted) { wanted } else { OpenPaths::Both };
        if wanted != self.open {
            (self.open, self.moved) = (wanted, Some(now));
        }
    }

    /// After a blinded image: the next path to be shut.
    fn search(&mut self, waited: bool, sun: Option<SunPlace>) -> OpenPaths {
        let (first, second) = match sun.map(|sun| sun.free) {
            Some(OpenPaths::Earth) => (OpenPaths::Earth, OpenPaths::Star),
            _ => (OpenPaths::Star, OpenPaths::Earth),
        };
        if self.tried >= 2 && waited {
            self.tried = 0;
        }
        self.tried = self.tried.saturating_add(1);
        match self.tried {
            1 => first,
            2 => second,
            _ => OpenPaths::Both,
        }
    }

    /// After a clear image.
    fn keep(&mut self, waited: bool, sun: Option<SunPlace>) -> OpenPaths {
        self.tried = 0;
        let believed = sun.filter(|sun| match sun.free {
            OpenPaths::Both => !self.contradicted,
            _ => sun.measured,
        });
        match believed {
            Some(sun) => {
                self.contradicted = false;
                sun.free
            }
            None if waited => OpenPaths::Both,
            None => self.open,
        }
    }
}

#[cfg(test)]
mod tests;
