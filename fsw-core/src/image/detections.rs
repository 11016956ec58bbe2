//! The spots of an image, the brightest of them kept.
//!
//! In: spots, in any order. Out: at most [`MAX_DETECTIONS`], brightest first once sorted, and how many there
//! were.

use super::Detection;
use fsw_hal::DetectorError;
use heapless::Vec;

/// Spots kept of an image.
pub const MAX_DETECTIONS: usize = 96;

/// Places of streaks kept.
pub const MAX_STREAK_PLACES: usize = 24;
/// Fewer bright spots that the lens's profile does not fit are pairs and hits ...
const FEWEST_BLURRED: u32 = 4;
/// ... and so are those that are not more than one in so many.
const BLURRED_SHARE: u32 = 3;
/// What is so near to a place kept, px, is of the same streak.
const SAME_STREAK_PX: u16 = 12;

/// What the sensor's turning during the exposure made of the stars of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smear {
    /// Their light stayed in its place, to 4 px or less.
    Points,
    /// They look round, but many of them otherwise than the turning that is told would make them: it changes
    /// within the exposure.
    Blurred,
    /// They are drawn out, most of them inside the square in which a centre is measured: 4 to 8 px. A spot that
    /// is not drawn out is a part of a faint one, or a hit.
    Drawn,
    /// Most leave that square: what is seen are parts, of which some look round and some whole. None of them is
    /// to be believed.
    Streaks,
}

/// Star-like spots, kept by brightness.
#[derive(Clone, Debug, Default)]
pub struct Detections {
    spots: Vec<Detection, MAX_DETECTIONS>,
    found: u32,
    crowded_tiles: u32,
    unread: u32,
    unread_px: u32,
    /// Spots in the open sky that are drawn out, and round ones bright enough to tell.
    drawn: u32,
    clear_round: u32,
    /// Of these, those that the lens's profile does not fit.
    blurred: u32,
    streaks: u32,
    streak_places: Vec<[u16; 2], MAX_STREAK_PLACES>,
}

impl Detections {
    /// The spots kept; [`scan`](super::scan::scan) leaves them brightest first.
    pub fn spots(&self) -> &[Detection] {
        &self.spots
    }

    /// How many spots were found in all, kept or not.
    pub fn found(&self) -> u32 {
        self.found
    }

    /// Windows that were too crowded to be searched whole within their allowance: their faintest spots are
    /// missing.
    pub fn crowded_tiles(&self) -> u32 {
        self.crowded_tiles
    }

    /// Windows that the detector did not deliver: nothing is known of what they would show.
    pub fn unread(&self) -> u32 {
        self.unread
    }

    /// Pixels of them in which a star's maximum could have stood.
    pub fn unread_px(&self) -> u32 {
        self.unread_px
    }

    /// Spots that are parts of streaks and were refused; a long streak has several.
    pub fn streaks(&self) -> u32 {
        self.streaks
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.spots.clear();
        self.found = 0;
        self.crowded_tiles = 0;
        self.unread = 0;
        self.unread_px = 0;
        self.drawn = 0;
        self.clear_round = 0;
        self.blurred = 0;
        self.streaks = 0;
        self.streak_places.clear();
    }

    /// No spots.
    pub const fn new() -> Self {
        Self {
            spots: Vec::new(),
            found: 0,
            crowded_tiles: 0,
            unread: 0,
            unread_px: 0,
            drawn: 0,
            clear_round: 0,
            blurred: 0,
            streaks: 0,
            streak_places: Vec::new(),
        }
    }

    /// Whether the spot would be kept whatever its centre and flux: there is room, or it outshines the
    /// faintest of those kept.
    pub(super) fn keeps(&self, spot: &Detection) -> bool {
        let brightness = |spot: &Detection| (spot.extended, core::cmp::Reverse(spot.core_flux));
        !self.spots.is_full() || self.spots.iter().any(|kept| brightness(spot) <= brightness(kept))
    }

    /// Keeps the spot, in place of the faintest when full. A spot that two overlapping windows show is kept
    /// once. `clear`: its light is so far above the noise that its shape shows whether it is drawn out;
    /// `misfits`: the lens's profile does not fit it.
    pub(super) fn insert(&mut self, spot: Detection, clear: bool, misfits: bool) {
        const ONE_PX: u32 = 1 << 16;
        let same = |kept: &Detection| {
            kept.x_q16.abs_diff(spot.x_q16) < ONE_PX && kept.y_q16.abs_diff(spot.y_q16) < ONE_PX
        };
        if self.spots.iter().any(same) {
            return;
        }
        self.found = self.found.saturating_add(1);
        if !spot.extended {
            let drawn = spot.drawn_px > 0;
            self.drawn = self.drawn.saturating_add(u32::from(drawn));
            self.clear_round = self.clear_round.saturating_add(u32::from(clear && !drawn));
            self.blurred = self.blurred.saturating_add(u32::from(clear && !drawn && misfits));
        }
        if let Err(spot) = self.spots.push(spot)
            && let Some(faintest) = self.spots.iter_mut().max_by_key(|kept| kept.rank())
            && spot.rank() < faintest.rank()
        {
            *faintest = spot;
        }
    }

    /// What the sensor's turning made of the stars; fewer than `fewest` that are drawn out are pairs, tracks of
    /// particles and satellites. Of a turning sensor no bright star is round, hits are; at rest most are.
    pub fn smear(&self, fewest: u32) -> Smear {
        let all = self.drawn.saturating_add(self.streaks);
        if all < fewest || all < self.clear_round {
            let otherwise = all.saturating_add(self.blurred);
            let blurred = otherwise >= FEWEST_BLURRED && BLURRED_SHARE * otherwise > self.clear_round;
            if blurred { Smear::Blurred } else { Smear::Points }
        } else if self.streaks < self.drawn {
            Smear::Drawn
        } else {
            Smear::Streaks
        }
    }

    /// Spots in the open sky that are drawn out whole.
    pub fn drawn(&self) -> u32 {
        self.drawn
    }

    /// Leaves the spots that are drawn out.
    pub(crate) fn keep_drawn(&mut self) {
        self.spots.retain(|spot| spot.drawn_px > 0 && !spot.extended);
    }

    /// Places that are parts of streaks, px, the first that were found.
    pub fn streak_places(&self) -> &[[u16; 2]] {
        &self.streak_places
    }

    /// Counts a spot that is the part of a streak.
    pub(super) fn note_streak(&mut self, [x, y]: [u16; 2]) {
        self.streaks = self.streaks.saturating_add(1);
        let near =
            |place: &[u16; 2]| place[0].abs_diff(x) < SAME_STREAK_PX && place[1].abs_diff(y) < SAME_STREAK_PX;
        if !self.streak_places.iter().any(near) {
            // Of more than there is room for the first are kept.
            let _ = self.streak_places.push([x, y]);
        }
    }

    /// Counts a window whose search ended with its allowance.
    pub(super) fn note_crowded(&mut self) {
        self.crowded_tiles = self.crowded_tiles.saturating_add(1);
    }

    /// Counts a window that the detector did not deliver, and the pixels in which it would have been searched:
    /// the image goes on without it.
    ///
    /// # Errors
    /// The error itself where it is of our request, or more than `most` windows were not delivered.
    pub(crate) fn note_unread(
        &mut self,
        error: DetectorError,
        searched_px: usize,
        most: usize,
    ) -> Result<(), DetectorError> {
        self.unread = self.unread.saturating_add(1);
        self.unread_px = self.unread_px.saturating_add(searched_px as u32);
        let hardware = matches!(error, DetectorError::Timeout | DetectorError::Bus);
        if hardware && self.unread as usize <= most { Ok(()) } else { Err(error) }
    }

    /// Marks those that stood in the last image too, and puts them first.
    pub(super) fn mark_repeated(&mut self, is_repeated: impl Fn(&Detection) -> bool) {
        for spot in &mut self.spots {
            spot.repeated = is_repeated(spot);
        }
        self.settle();
    }

    /// Once all of an image's spots are in: sorts them by [`Detection::rank`].
    pub(crate) fn settle(&mut self) {
        crate::order::sort(&mut self.spots, |a, b| a.rank() < b.rank());
    }
}
