//! Stars by index and pairs by separation, each in O(1).
//!
//! The pair table is sorted by chord; a bin table holds the first pair of every bin of width `2^shift` in Q2.30, so a
//! range of chords is two array reads. A range is answered to the bin (reference catalogue: 2^17, 25 arcsec): it holds
//! every pair asked for and a few more, and the caller compares the exact separations it needs anyway.

use super::format::{Catalogue, FLAG_PROXIMITY, HIP_MASK, PAIR_BYTES, Pair, STAR_BYTES, Star};
use crate::frames::{Direction, Icrs};
use nalgebra::Vector3;

fn decode_star(record: &[u8; STAR_BYTES]) -> Star {
    let [x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3, i0, i1, i2, i3, m0, m1, c0, c1] = *record;
    let id = u32::from_le_bytes([i0, i1, i2, i3]);
    Star {
        unit_q30: [
            i32::from_le_bytes([x0, x1, x2, x3]),
            i32::from_le_bytes([y0, y1, y2, y3]),
            i32::from_le_bytes([z0, z1, z2, z3]),
        ],
        hip: id & HIP_MASK,
        proximity: id & FLAG_PROXIMITY != 0,
        magnitude_centi: i16::from_le_bytes([m0, m1]),
        colour_centi: i16::from_le_bytes([c0, c1]),
    }
}

/// Chord in Q2.30, saturating; a chord is at most 2.
fn chord_q30(chord: f32) -> u32 {
    (chord * (1u32 << 30) as f32) as u32
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

    /// Sets the velocity of the observer over that of light, ICRS, at most 1e-3 (else, or when it is not finite, zero):
    /// from then on directions are those he sees (aberration).
    pub fn set_observer_velocity(&mut self, velocity_per_c: Vector3<f32>) {
        let possible = velocity_per_c.dot(&velocity_per_c) < 1e-6;
        self.velocity = if possible { velocity_per_c } else { Vector3::new(0.0, 0.0, 0.0) };
    }

    /// The direction in which the observer sees a star: `r + v - (v r) r`, aberration to first order in `v` (the second is
    /// below 0.002 arcsec for the Earth's 30 km/s).
    pub fn seen(&self, star: &Star) -> Direction<Icrs> {
        let direction = star.direction();
        let unit = direction.vector();
        Direction::from_unit(unit + self.velocity - unit * unit.dot(&self.velocity))
    }

    /// The unit vector in which the observer sees the star at `index`, ICRS; only the 12 bytes needed are decoded.
    pub fn unit(&self, index: u16) -> Option<Vector3<f32>> {
        self.stars.get(usize::from(index)).map(|record| *self.seen(&decode_star(record)).vector())
    }

    /// Bytes of the pairs whose chord lies in `[low, high]`, to the bin; empty when the range is outside the table.
    fn range(&self, low: f32, high: f32) -> &'a [[u8; PAIR_BYTES]] {
        let first_of = |bin: u32| {
            let last = self.bins.len().saturating_sub(1);
            let entry = self.bins.get((bin as usize).min(last));
            entry.map_or(0, |entry| u32::from_le_bytes(*entry) as usize)
        };
        if !(low <= high && high >= 0.0) {
            return &[];
        }
        let first_bin = chord_q30(low) >> self.bin_shift;
        let end_bin = (chord_q30(high) >> self.bin_shift).saturating_add(1);
        self.pairs.get(first_of(first_bin)..first_of(end_bin)).unwrap_or(&[])
    }

    /// Number of pairs that [`Catalogue::pairs_between`] would give; two table reads.
    pub fn count_between(&self, low: f32, high: f32) -> usize {
        self.range(low, high).len()
    }

    /// Star pairs whose chord lies in `[low, high]`, to the bin, by rising bin.
    pub fn pairs_between(&self, low: f32, high: f32) -> impl Iterator<Item = Pair> + 'a {
        self.range(low, high).iter().map(|[a0, a1, b0, b1]| Pair {
            first: u16::from_le_bytes([*a0, *a1]),
            second: u16::from_le_bytes([*b0, *b1]),
        })
    }
}

#[cfg(test)]
mod tests;
