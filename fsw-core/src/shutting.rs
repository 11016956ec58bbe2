//! Which path is shut against the Sun, and when the Earth path's filter is out of the way (thesis §9.2).
//!
//! In: once a second whether the Sun blinds the image, and which paths it leaves free by attitude and time,
//! where these are known. Out: the paths to be open in the next second.
//!
//! | image | the Sun by attitude and time | next |
//! |---|---|---|
//! | clear, its attitude known | in a path, or within the margin of its field | that path is shut |
//! | clear, its attitude known | in neither, or in both | both open |
//! | clear, its attitude known | in neither, and no light of the Earth in the Earth path | both open, the filter out |
//! | clear, the attitude carried on | in neither | both open |
//! | clear, else | - | as it is; a path that is shut is opened for a look every `look_s` |
//! | blinded | - | the path that the Sun is in is shut, else the Earth path; if that does not help the other one; if neither does both are open for `look_s` |
//!
//! With the filter out, an image that is blinded or whose attitude is not known puts it back; a blinded one
//! until the Earth has been lit by attitude and time. An image that was blinded with both paths open
//! contradicts a Sun that is in neither: then only a look opens them. Where a path has no shutter both are
//! open instead. A command holds them until another one.

use fsw_ground::table::{choice, parameter_group};
use fsw_hal::{LocalTime, OpenPaths};

/// Which paths have a shutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shutters {
    /// Neither: the filter is all that moves.
    Neither,
    /// The star path.
    Star,
    /// The Earth path.
    Earth,
    /// Both.
    Both,
}

choice! { Shutters: Neither, Star, Earth, Both }

impl Shutters {
    /// Whether these paths can be open and no other.
    pub fn allow(self, paths: OpenPaths) -> bool {
        match self {
            Self::Neither => !matches!(paths, OpenPaths::Star | OpenPaths::Earth),
            Self::Star => paths != OpenPaths::Star,
            Self::Earth => paths != OpenPaths::Earth,
            Self::Both => true,
        }
    }
}

/// The grey filter of the Earth path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EarthFilter {
    /// It stays in the path.
    Fixed,
    /// It can be put out of the way.
    Adaptive,
}

choice! { EarthFilter: Fixed, Adaptive }

parameter_group! {
    /// The shutters of the two paths and the Earth path's filter; nothing of them moves unless it is set.
    pub struct ShutterParameters in "shutter" {
        /// Which paths have a shutter.
        paths: Shutters = Shutters::Both, one of "Neither, Star, Earth, Both", "", "thesis 9.2";
        /// Whether the Earth path's filter can be put out of the way.
        filter: EarthFilter = EarthFilter::Fixed, one of "Fixed, Adaptive", "", "thesis tab. 9.1";
        /// So near to the field of a path the Sun's disc may come before it is shut.
        margin_rad: f32 = 0.0087, 0.0..=0.5, "rad",
            "half a degree: a low satellite turns by 0.13 deg in the two seconds to the end of the next exposure";
        /// A path that is shut without knowing that the Sun is there is opened for a look after so long.
        look_s: u16 = 30, 5..=10_000, "s", "chosen: a blinded image costs a second";
    }
}

impl ShutterParameters {
    /// Whether these paths can be open and no other.
    pub fn allow(&self, paths: OpenPaths) -> bool {
        self.paths.allow(paths) && (self.filter == EarthFilter::Adaptive || !paths.clear())
    }
}

/// Where the Sun is by attitude and time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SunPlace {
    /// The paths that it leaves free; both where it is in both, as shutting one of them does not help. Both
    /// clear where no light of it comes by the Earth either.
    pub free: OpenPaths,
    /// Whether the attitude is that of this second's image, and not one that is carried on.
    pub measured: bool,
}

impl SunPlace {
    /// Whether it is in neither path, or in both.
    fn is_in_neither(self) -> bool {
        self.free.both()
    }
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
    /// An image without the filter was blinded, and since then the Earth has been as dark as that.
    dazzled: bool,
    /// What the spacecraft wants, whatever the Sun does.
    held: Option<OpenPaths>,
}

impl Shutting {
    /// The paths that are to be open.
    pub fn open(&self) -> OpenPaths {
        self.open
    }

    /// The paths that the spacecraft wants open, whatever the Sun does.
    pub fn held(&self) -> Option<OpenPaths> {
        self.held
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
            self.contradicted = blinded && sun.is_none_or(SunPlace::is_in_neither);
        }
        if self.open.clear() && blinded {
            self.dazzled = true;
        } else if sun.is_some_and(|sun| sun.measured && !sun.free.clear()) {
            self.dazzled = false;
        }
        let wanted = match (blinded, self.open) {
            (true, OpenPaths::BothClear) => OpenPaths::Both,
            (true, _) => self.search(waited, sun),
            (false, _) => self.keep(waited, sun),
        };
        let wanted = if parameters.allow(wanted) { wanted } else { OpenPaths::Both };
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
            OpenPaths::BothClear => sun.measured && !self.contradicted && !self.dazzled,
            OpenPaths::Star | OpenPaths::Earth => sun.measured,
        });
        match believed {
            Some(sun) => {
                self.contradicted = false;
                sun.free
            }
            None if waited || self.open.clear() => OpenPaths::Both,
            None => self.open,
        }
    }
}

#[cfg(test)]
mod tests;
