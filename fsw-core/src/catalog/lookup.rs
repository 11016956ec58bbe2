//! Stars by index and pairs by separation, each in O(1).
//!
//! The pairs are sorted by bin of the chord; a table holds the first entry of every bin of width `2^shift` in
//! Q2.30, so a range of chords is two array reads. A range is rounded out to whole bins (reference
//! catalogue: 2^17, 25 arcsec): it contains every pair of the range and a few more; the caller compares
//! exact separations.

use super::format::{
    Bins, COLOUR_OFFSET, COLOUR_SHIFT, Catalogue, FLAG_PROXIMITY, HIP_MASK, Pair, SKIP, STAR_BYTES,
    STEP_BITS, Star,
};
use crate::frames::{Direction, Icrs};
use core::ops::Range;
use nalgebra::Vector3;

/// A dot product of two unit vectors with 15 bits a component after the point errs by less: each vector's
/// error is below `sqrt(3) 2^-15`, and the axis is shorter by 2^-15.
const COARSE_ERROR: f32 = 1.5e-4;
/// The chord of two such vectors errs by less: `sqrt(3) 2^-15`.
pub const COARSE_CHORD_ERROR: f32 = 6e-5;
/// Largest aberration of a direction, rad, and largest relative change of a chord: limit of the observer's
/// velocity (1e-3) and rounding.
pub const MAX_ABERRATION: f32 = 1.001e-3;

/// A cone in integers of 16 bits, widened by their rounding.
#[derive(Clone, Copy)]
struct CoarseCone {
    axis: [i32; 3],
    limit: i32,
}

impl CoarseCone {
    fn new(axis: &Direction<Icrs>, cosine: f32) -> Self {
        const ONE_Q15: f32 = (1 << 15) as f32;
        let axis = axis.vector().map(|component| (component * (ONE_Q15 - 1.0)) as i32).into();
        Self { axis, limit: ((cosine - COARSE_ERROR) * ONE_Q15 * ONE_Q15) as i32 }
    }

    fn contains(&self, record: &[u8; STAR_BYTES]) -> bool {
        // Of unit vectors: below 2^31.
        let products =
            self.axis.into_iter().zip(words(record)).map(|(axis, word)| axis.wrapping_mul(word >> 16));
        products.fold(0, i32::wrapping_add) >= self.limit
    }

    /// The next star within, with its index; `rest` are the stars not yet tested, and the index of the
    /// first. Not inlined: in a loop of its own 20 cycles a star, else 44.
    #[inline(never)]
    fn next<'a>(&self, rest: &mut (u16, &'a [[u8; STAR_BYTES]])) -> Option<(u16, &'a [u8; STAR_BYTES])> {
        let (first, stars) = *rest;
        let place = stars.iter().position(|record| self.contains(record))?;
        let (record, after) = stars.get(place..)?.split_first()?;
        let index = first.wrapping_add(place as u16);
        *rest = (index.wrapping_add(1), after);
        Some((index, record))
    }
}

/// The components of a star's record at the top of a word each, Q1.31; their low bits belong to
/// neighbouring fields. A whole word costs one load on the target, three bytes three.
fn words(record: &[u8; STAR_BYTES]) -> [i32; 3] {
    let word = |offset: usize| {
        let bytes = record.get(offset..).and_then(|bytes| bytes.first_chunk::<4>());
        bytes.map_or(0, |bytes| i32::from_le_bytes(*bytes))
    };
    [word(0) << 8, word(3) << 8, word(5)]
}

/// Unit vector of a star's record, Q1.30.
fn decode_unit(record: &[u8; STAR_BYTES]) -> [i32; 3] {
    words(record).map(|word| (word & !0xFF) >> 1)
}

fn decode_star(record: &[u8; STAR_BYTES]) -> Star {
    let [.., i0, i1, i2, i3] = *record;
    let word = u32::from_le_bytes([i0, i1, i2, i3]);
    Star {
        unit_q30: decode_unit(record),
        hip: word & HIP_MASK,
        proximity: word & FLAG_PROXIMITY != 0,
        colour_centi: (word >> COLOUR_SHIFT) as i16 - COLOUR_OFFSET,
    }
}

/// A chord or its square in Q2.30, saturating: they are at most 2 and 4, and what is less than 0 gives 0.
pub fn q30(value: f32) -> u32 {
    (value * (1u32 << 30) as f32) as u32
}

impl<'a> Catalogue<'a> {
    /// The star at `index` (stars are sorted by brightness, so a smaller index is a brighter star).
    pub fn star(&self, index: u16) -> Option<Star> {
        self.stars.get(usize::from(index)).map(decode_star)
    }

    /// All stars, brightest first.
    pub fn stars(&self) -> impl Iterator<Item = Star> + 'a {
        self.stars.iter().map(decode_star)
    }

    /// Index and direction without aberration of every star within the cone about `axis` whose half angle
    /// has the `cosine`, brightest first, and of some just outside. Most stars are excluded by a dot
    /// product in integers of 16 bits.
    pub fn stars_in_cone(
        &self,
        axis: &Direction<Icrs>,
        cosine: f32,
    ) -> impl Iterator<Item = (u16, Direction<Icrs>)> + 'a {
        let cone = CoarseCone::new(axis, cosine);
        let mut rest = (0, self.stars);
        core::iter::from_fn(move || {
            let (index, record) = cone.next(&mut rest)?;
            Some((index, Direction::from_q30(decode_unit(record))))
        })
    }

    /// Sets the velocity of the observer over that of light, ICRS, at most 1e-3 (else, or when it is not
    /// finite, zero): from then on directions include its aberration.
    pub fn set_observer_velocity(&mut self, velocity_per_c: Vector3<f32>) {
        let possible = velocity_per_c.dot(&velocity_per_c) < 1e-6;
        self.velocity = if possible { velocity_per_c } else { Vector3::new(0.0, 0.0, 0.0) };
    }

    /// Apparent direction of a star for the observer: `r + v - (v r) r`, aberration to first order in `v`
    /// (the second is below 0.002 arcsec for the Earth's 30 km/s).
    pub fn apparent_direction(&self, star: &Star) -> Direction<Icrs> {
        self.aberrated(&star.direction())
    }

    /// `direction` with the observer's aberration.
    pub fn aberrated(&self, direction: &Direction<Icrs>) -> Direction<Icrs> {
        let unit = direction.vector();
        Direction::from_unit(unit + self.velocity - unit * unit.dot(&self.velocity))
    }

    /// Apparent unit vector of the star at `index`, ICRS: only the direction of its record is decoded.
    pub fn unit(&self, index: u16) -> Option<Vector3<f32>> {
        let record = self.stars.get(usize::from(index))?;
        Some(*self.aberrated(&Direction::from_q30(decode_unit(record))).vector())
    }

    /// Squared chord of two stars, Q2.30, from 16 bits a component and without aberration; 0 where there is
    /// no such star.
    pub fn coarse_square(&self, a: u16, b: u16) -> u32 {
        let record = |star: u16| self.stars.get(usize::from(star));
        let Some((a, b)) = record(a).zip(record(b)) else { return 0 };
        // Below 2^32 but for opposite stars, which are no pair.
        words(a).into_iter().zip(words(b)).fold(0, |sum, (a, b)| {
            let difference = (a >> 16) - (b >> 16);
            difference.wrapping_mul(difference).cast_unsigned().wrapping_add(sum)
        })
    }

    /// The bins of the pairs whose chord lies in `[low, high]`; none when that is outside the table.
    fn bins_between(&self, low: f32, high: f32) -> Range<usize> {
        if !(low <= high && high >= 0.0) {
            return 0..0;
        }
        let bins = self.bins.len().saturating_sub(1);
        let bin_of = |chord: f32| (q30(chord) >> self.bin_shift) as usize;
        bin_of(low).min(bins)..bin_of(high).saturating_add(1).min(bins)
    }

    /// Number of entries of those bins: at least that of the pairs which [`Catalogue::pairs_between`] gives
    /// (reference catalogue: 2.9 % more); two table reads.
    pub fn count_between(&self, low: f32, high: f32) -> usize {
        self.bins.entries_of(self.bins_between(low, high)).len()
    }

    /// Number of pairs; reads them all.
    pub fn pair_count(&self) -> usize {
        self.pairs_between(0.0, self.max_chord()).count()
    }

    /// Star pairs whose chord lies in `[low, high]`, to the bin, by rising bin.
    pub fn pairs_between(&self, low: f32, high: f32) -> impl Iterator<Item = Pair> + 'a {
        let (bins, entries) = (self.bins, self.entries);
        self.bins_between(low, high).flat_map(move |bin| pairs_of(bins, entries, bin))
    }
}

/// The pairs of a bin.
fn pairs_of<'a>(
    bins: Bins<'a>,
    (entries, bits): (&'a [u8], u32),
    bin: usize,
) -> impl Iterator<Item = Pair> + 'a {
    let mut first = 0u16;
    bins.entries_of(bin..bin.wrapping_add(1)).filter_map(move |entry| {
        let at = entry.wrapping_mul(bits as usize);
        let word = entries.get(at >> 3..)?.first_chunk::<4>()?;
        // Of 25 bits at most, behind 7.
        let word = u32::from_le_bytes(*word) >> (at & 7) & ((1 << bits) - 1);
        let step = word as u16 & SKIP;
        first = first.wrapping_add(step);
        (step < SKIP).then_some(Pair { first, second: (word >> STEP_BITS) as u16 })
    })
}

#[cfg(test)]
mod tests;
