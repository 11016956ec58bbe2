//! The spots of an image, the brightest of them kept.
//!
//! In: spots, in any order. Out: at most [`MAX_DETECTIONS`], brightest first once sorted, and how many there
//! were.

use super::Detection;
use super::smear::{Evidence, Smear};
use fsw_hal::DetectorError;
use heapless::Vec;

/// Error of a spot whose image holds more than a star, over the brightness behind it above the sky's and over
/// its flux, px: a cloud of the Earth, seen through the star path, draws it along. Of 231 in 120 flights.
const GROUND_PX: f32 = 1.5;
/// Spots kept of an image.
pub const MAX_DETECTIONS: usize = 96;

/// Star-like spots, kept by brightness.
#[derive(Clone, Debug, Default)]
pub struct Detections {
    spots: Vec<Detection, MAX_DETECTIONS>,
    found: u32,
    crowded_tiles: u32,
    unread: u32,
    unread_px: u32,
    evidence: Evidence,
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
        self.evidence.streaks()
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.spots.clear();
        self.found = 0;
        self.crowded_tiles = 0;
        self.unread = 0;
        self.unread_px = 0;
        self.evidence = Evidence::new();
    }

    /// No spots.
    pub const fn new() -> Self {
        Self {
            spots: Vec::new(),
            found: 0,
            crowded_tiles: 0,
            unread: 0,
            unread_px: 0,
            evidence: Evidence::new(),
        }
    }

    /// Whether the spot would be kept whatever its centre and flux: there is room, or it outshines the
    /// faintest of those kept.
    pub(super) fn keeps(&self, spot: &Detection) -> bool {
        let brightness = |spot: &Detection| (spot.extended, core::cmp::Reverse(spot.core_flux));
        !self.spots.is_full() || self.spots.iter().any(|kept| brightness(spot) <= brightness(kept))
    }

    /// Keeps the spot, in place of the faintest when full; whether it is another. A spot that two overlapping
    /// windows show is kept once.
    pub(super) fn insert(&mut self, spot: Detection) -> bool {
        const ONE_PX: u32 = 1 << 16;
        let same = |kept: &Detection| {
            kept.x_q16.abs_diff(spot.x_q16) < ONE_PX && kept.y_q16.abs_diff(spot.y_q16) < ONE_PX
        };
        if self.spots.iter().any(same) {
            return false;
        }
        self.found = self.found.saturating_add(1);
        if let Err(spot) = self.spots.push(spot)
            && let Some(faintest) = self.spots.iter_mut().max_by_key(|kept| kept.rank())
            && spot.rank() < faintest.rank()
        {
            *faintest = spot;
        }
        true
    }

    /// What the sensor's turning made of the stars; fewer than `fewest` that are drawn out are pairs, tracks
    /// of particles and satellites.
    pub fn smear(&self, fewest: u32) -> Smear {
        self.evidence.smear(fewest)
    }

    /// Spots in the open sky that are drawn out whole.
    pub fn drawn(&self) -> u32 {
        self.evidence.drawn()
    }

    /// Leaves the spots that are drawn out.
    pub(crate) fn keep_drawn(&mut self) {
        self.spots.retain(|spot| spot.drawn_px > 0 && !spot.extended);
    }

    /// Adds to the errors of spots that look round.
    pub(crate) fn doubt_round(&mut self, by_px: f32) {
        let round = self.spots.iter_mut().filter(|spot| spot.drawn_px == 0);
        round.for_each(|spot| *spot = spot.doubted(by_px));
    }

    /// Adds to the errors of all spots that of a centre whose star moved as nobody knows.
    pub(crate) fn doubt(&mut self, by_px: f32) {
        self.spots.iter_mut().for_each(|spot| *spot = spot.doubted(by_px));
    }

    /// Places that are parts of streaks, px, the first that were found.
    pub fn streak_places(&self) -> &[[u16; 2]] {
        self.evidence.streak_places()
    }

    /// What the shapes of the spots say, to be added to.
    pub(super) fn evidence(&mut self) -> &mut Evidence {
        &mut self.evidence
    }

    /// Counts a window whose search ended with its allowance.
    pub(super) fn note_crowded(&mut self) {
        self.crowded_tiles = self.crowded_tiles.saturating_add(1);
    }

    /// Counts a window that the detector did not deliver, and the pixels in which it would have been
    /// searched: the image goes on without it.
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

    /// Marks those that stood in the last image too, with the number that they had there, and puts them first.
    pub(super) fn mark_repeated(&mut self, former: impl Fn(&Detection) -> Option<u8>) {
        for spot in &mut self.spots {
            let number = former(spot);
            (spot.repeated, spot.number) = (number.is_some(), number.unwrap_or(0));
        }
        self.sort();
    }

    /// The spots, to be numbered.
    pub(super) fn spots_mut(&mut self) -> &mut [Detection] {
        &mut self.spots
    }

    /// Once all of an image's spots are in: doubts those before uneven ground, and sorts them by
    /// [`Detection::rank`].
    pub(crate) fn settle(&mut self) {
        let sky = self.evidence.sky();
        for spot in &mut self.spots {
            let brighter = i32::from(spot.backdrop) - sky;
            if brighter > 0 {
                *spot = spot.doubted(GROUND_PX * brighter as f32 / spot.flux.max(1) as f32);
            }
        }
        self.sort();
    }

    fn sort(&mut self) {
        crate::order::sort_unstable(&mut self.spots, |a, b| a.rank() < b.rank());
    }
}

#[cfg(test)]
pub(super) mod tests;
