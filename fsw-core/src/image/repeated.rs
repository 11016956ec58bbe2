//! Spots that stood in the last image too, as stars do and hits do not.
//!
//! In: the spots of an image. Out: which of them stood in the last image that was scanned, all moved alike.
//! A sensor that hardly turns moves its stars by the same few pixels from image to image; hits and false
//! stars are elsewhere in each. Where these outnumber the stars, what repeats is looked at first.
//!
//! The motion is the one that most pairs of places, one of each image, share. Of 96 spots each 23 pairs lie
//! within 32 px by chance, and hardly ever three of them alike. A pixel that is always bright repeats
//! too: what it does not have is a place in the catalogue.
//!
//! Each spot has a number, which it keeps from image to image as long as it is found: the tracking number of
//! the thesis (3.1.5), without an identification.

use super::Detection;
use super::detections::{Detections, MAX_DETECTIONS};
use crate::order::{fill, most_alike};
use heapless::Vec;

/// So far a spot may have moved along either axis, px.
const REACH_PX: i16 = 32;
/// Motions of the same turn differ by at most so much along either axis, in places' units: 1.5 px, by which a
/// turn of the reach moves stars in the corners of 15 deg farther than in the middle.
const ALIKE: i16 = 3 * PER_PX / 2;
/// Fewer pairs that moved alike are chance.
const FEWEST_ALIKE: usize = 4;
/// Most pairs compared.
const MAX_MOTIONS: usize = 96;
/// Places are kept in parts of a pixel.
const PER_PX: i16 = 8;

/// A place, in parts of a pixel.
type Place = [i16; 2];

/// Where the spots of the last scanned image stood.
#[derive(Clone, Debug, Default)]
pub struct Repeated {
    places: Vec<Place, MAX_DETECTIONS>,
    /// Their numbers.
    numbers: Vec<u8, MAX_DETECTIONS>,
    /// The number that was given last.
    last: u8,
}

/// Where a spot stands.
fn place(spot: &Detection) -> Place {
    // 2^16 parts to 8.
    [spot.x_q16, spot.y_q16].map(|at| (at >> 13) as i16)
}

/// From one place to another, where that is within reach.
fn motion([x, y]: Place, [to_x, to_y]: Place) -> Option<Place> {
    let motion = [to_x.wrapping_sub(x), to_y.wrapping_sub(y)];
    motion.iter().all(|axis| axis.unsigned_abs() < (REACH_PX * PER_PX).unsigned_abs()).then_some(motion)
}

fn are_alike([x, y]: Place, [u, v]: Place) -> bool {
    x.abs_diff(u) <= ALIKE.unsigned_abs() && y.abs_diff(v) <= ALIKE.unsigned_abs()
}

impl Repeated {
    /// No image yet.
    pub const fn new() -> Self {
        Self { places: Vec::new(), numbers: Vec::new(), last: 0 }
    }

    /// Marks and numbers the spots of an image, those that stood in the last one as there, and puts these
    /// first; the image is the last one from now on.
    #[inline(never)]
    pub fn put_first(&mut self, detections: &mut Detections) {
        let common = self.common_motion(detections.spots());
        if let Some(common) = common {
            detections.mark_repeated(|spot| {
                let to = place(spot);
                let off = |from: &Place| {
                    let motion = motion(*from, to).filter(|motion| are_alike(*motion, common))?;
                    Some(motion.iter().zip(common).map(|(axis, common)| axis.abs_diff(common)).sum::<u16>())
                };
                let places = self.places.iter().zip(&self.numbers);
                let alike = places.filter_map(|(from, number)| Some((off(from)?, *number)));
                alike.min().map(|(_, number)| number)
            });
        }
        self.number_others(detections.spots_mut());
        self.places.clear();
        self.numbers.clear();
        fill(&mut self.places, detections.spots().iter().map(place));
        fill(&mut self.numbers, detections.spots().iter().map(|spot| spot.number));
    }

    /// Numbers those anew that are new, or whose number a spot before them has.
    #[inline(never)]
    fn number_others(&mut self, spots: &mut [Detection]) {
        let mut taken = [false; 1 + u8::MAX as usize];
        let mut take = |number: u8| {
            taken.get_mut(usize::from(number)).is_some_and(|taken| !core::mem::replace(taken, true))
        };
        // 0 is of no spot.
        take(0);
        for spot in spots.iter_mut() {
            spot.number = if take(spot.number) { spot.number } else { 0 };
        }
        for spot in spots.iter_mut().filter(|spot| spot.number == 0) {
            let mut next = (1..=u8::MAX).map(|step| self.last.wrapping_add(step));
            let Some(free) = next.find(|number| take(*number)) else { return };
            (spot.number, self.last) = (free, free);
        }
    }

    /// The motion that most pairs share, if enough do.
    fn common_motion(&self, spots: &[Detection]) -> Option<Place> {
        let mut motions: Vec<Place, MAX_MOTIONS> = Vec::new();
        for spot in spots {
            let to = place(spot);
            // Of more than there is room for those to the brightest spots.
            fill(&mut motions, self.places.iter().filter_map(|from| motion(*from, to)));
        }
        most_alike(&motions, are_alike).filter(|(_, count)| *count >= FEWEST_ALIKE).map(|(motion, _)| motion)
    }
}

#[cfg(test)]
mod tests;
