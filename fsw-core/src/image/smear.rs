//! What the sensor's turning during the exposure made of the stars of an image.
//!
//! In: of every spot what its shape says, and how bright the sky is behind it. Out: the [`Smear`] of the
//! image.
//!
//! Only what stands against the darkest sky of the image is counted: clouds of the lit Earth are drawn out in
//! every image, and a hill of them is a spot that the lens's profile does not fit. Of a turning sensor the
//! stars in the dark are drawn out as well as all others.

use super::{Detection, FULL_SCALE};
use heapless::Vec;

/// Places of streaks kept.
pub const MAX_STREAK_PLACES: usize = 24;
/// What stands against a sky brighter than the darkest by more than a sixty-fourth of full scale is not
/// counted.
pub(super) const SAME_SKY: i32 = FULL_SCALE / 64;
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
    /// The same of most of them: of a lens that was calibrated otherwise, or where a turn begins or ends
    /// within the exposure and goes far, of which they show where it rests.
    MostlyBlurred,
    /// They are drawn out, most of them inside the square in which a centre is measured: 4 to 8 px. A spot
    /// that is not drawn out is a part of a faint one, or a hit.
    Drawn,
    /// Most leave that square: what is seen are parts, of which some look round and some whole. None of them
    /// is to be believed.
    Streaks,
}

/// What the shapes of an image's spots say.
#[derive(Clone, Debug, Default)]
pub(super) struct Evidence {
    /// By how much the darkest sky behind a spot is darker than full scale, scaled counts; 0 without a spot,
    /// so that a static of it is all zero and costs no flash.
    darkness: i32,
    /// Spots in the open sky that are drawn out, and round ones bright enough to tell.
    drawn: u32,
    clear_round: u32,
    /// Of these, those that the lens's profile does not fit.
    blurred: u32,
    /// Parts of streaks; a long one has several.
    streaks: u32,
    streak_places: Vec<[u16; 2], MAX_STREAK_PLACES>,
}

impl Evidence {
    /// No spot yet.
    pub(super) const fn new() -> Self {
        let streak_places = Vec::new();
        Self { darkness: 0, drawn: 0, clear_round: 0, blurred: 0, streaks: 0, streak_places }
    }

    /// Whether a spot against such a `background`, scaled counts, is counted. Where it is the darkest so far
    /// by more than [`SAME_SKY`], those before it are not.
    fn counts(&mut self, background: i32) -> bool {
        let darkness = FULL_SCALE.saturating_sub(background);
        if darkness > self.darkness + SAME_SKY {
            *self = Self::new();
        }
        self.darkness = self.darkness.max(darkness.min(FULL_SCALE));
        darkness >= self.darkness - SAME_SKY
    }

    /// Counts a spot in the open sky. `clear`: its light is so far above the noise that its shape shows
    /// whether it is drawn out; `misfits`: the lens's profile does not fit it.
    pub(super) fn note_spot(&mut self, spot: &Detection, background: i32, clear: bool, misfits: bool) {
        if spot.extended || !self.counts(background) {
            return;
        }
        let drawn = clear && spot.drawn_px > 0;
        self.drawn = self.drawn.saturating_add(u32::from(drawn));
        self.clear_round = self.clear_round.saturating_add(u32::from(clear && !drawn));
        self.blurred = self.blurred.saturating_add(u32::from(clear && !drawn && misfits));
    }

    /// Counts a spot that is the part of a streak.
    pub(super) fn note_streak(&mut self, [x, y]: [u16; 2], background: i32) {
        if !self.counts(background) {
            return;
        }
        self.streaks = self.streaks.saturating_add(1);
        let near =
            |place: &[u16; 2]| place[0].abs_diff(x) < SAME_STREAK_PX && place[1].abs_diff(y) < SAME_STREAK_PX;
        if !self.streak_places.iter().any(near) {
            // Of more than there is room for the first are kept.
            let _ = self.streak_places.push([x, y]);
        }
    }

    /// What the sensor's turning made of the stars; fewer than `fewest` that are drawn out are pairs, tracks
    /// of particles and satellites. Of a turning sensor no bright star is round, hits are; at rest most are.
    pub(super) fn smear(&self, fewest: u32) -> Smear {
        let all = self.drawn.saturating_add(self.streaks);
        if all < fewest || all < self.clear_round {
            let otherwise = all.saturating_add(self.blurred);
            let part = if otherwise < FEWEST_BLURRED { 0 } else { BLURRED_SHARE * otherwise };
            if part > (BLURRED_SHARE - 1) * self.clear_round {
                Smear::MostlyBlurred
            } else if part > self.clear_round {
                Smear::Blurred
            } else {
                Smear::Points
            }
        } else if self.streaks < self.drawn {
            Smear::Drawn
        } else {
            Smear::Streaks
        }
    }

    /// Brightness of sky that is as dark as the darkest behind a spot, at most, scaled counts.
    pub(super) fn sky(&self) -> i32 {
        FULL_SCALE - self.darkness + SAME_SKY
    }

    /// Spots in the open sky that are drawn out whole.
    pub(super) fn drawn(&self) -> u32 {
        self.drawn
    }

    /// Spots that are parts of streaks.
    pub(super) fn streaks(&self) -> u32 {
        self.streaks
    }

    /// Places that are parts of streaks, px, the first that were found.
    pub(super) fn streak_places(&self) -> &[[u16; 2]] {
        &self.streak_places
    }
}

#[cfg(test)]
mod tests;
