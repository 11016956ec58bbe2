//! Value noise: smooth random numbers in space.
//!
//! In: a place (radii), cells a radius. Out: a number of mean 0, -0.5 to 0.5, standard deviation about
//! [`DEVIATION`]; or three of them. Random numbers on a lattice of cubes are blended between its corners by
//! `3 t² - 2 t³` along each axis, which leaves no corner in the field. The lattice repeats after [`SIDE`]
//! cells; users turn and shift it against the sphere.

use crate::world::attitude::Vector;
use crate::world::noise::Noise;
use crate::world::normal::ROUNDER;

/// Corners along a side, after which the lattice repeats; a power of two.
pub const SIDE: usize = 32;
/// Standard deviation over all places: that of a corner, 12^-1/2, times `E[w² + (1 - w)²]^(3/2)` with 26/35
/// for the blend.
pub const DEVIATION: f64 = 0.184_8;
/// Random numbers at the corners; of a length known when compiling, so that no index need be checked.
#[derive(Debug, Clone)]
pub struct Lattice(Box<[f32; SIDE * SIDE * SIDE]>);

impl Lattice {
    /// A lattice of the numbers of `noise`.
    pub fn new(noise: &Noise) -> Self {
        let mut corners = Box::new([0.0; SIDE * SIDE * SIDE]);
        for (index, corner) in (0..).zip(corners.iter_mut()) {
            *corner = (noise.uniform(index, 0) - 0.5) as f32;
        }
        Self(corners)
    }

    /// The noise at `place`.
    // Written out: closures over arrays are not always made part of the loop they stand in.
    #[inline]
    pub fn at(&self, place: Vector, cells: f64) -> f64 {
        let (x0, x1, x) = between(place[0] * cells);
        let (y0, y1, y) = between(place[1] * cells);
        let (z0, z1, z) = between(place[2] * cells);
        let low = self.plane(z0, (x0, x1, x), (y0, y1, y));
        let high = self.plane(z1, (x0, x1, x), (y0, y1, y));
        low + z * (high - low)
    }

    /// The noise in a plane of corners.
    #[inline]
    fn plane(&self, k: usize, (x0, x1, x): (usize, usize, f64), (y0, y1, y): (usize, usize, f64)) -> f64 {
        let (near, far) = ((k * SIDE + y0) * SIDE, (k * SIDE + y1) * SIDE);
        let (a, b) = (f64::from(self.0[near + x0]), f64::from(self.0[near + x1]));
        let (c, d) = (f64::from(self.0[far + x0]), f64::from(self.0[far + x1]));
        let (near, far) = (a + x * (b - a), c + x * (d - c));
        near + y * (far - near)
    }

    /// Three numbers that know nothing of each other: the lattice read in three places far apart.
    #[inline]
    pub fn vector(&self, place: Vector, cells: f64) -> Vector {
        let [x, y, z] = place;
        let aside = |far: f64| self.at([x + far / cells, y + far / cells, z + far / cells], cells);
        [aside(0.0), aside(11.37), aside(21.71)]
    }
}

/// The corners below and above a coordinate, and the blend between them.
#[inline]
fn between(at: f64) -> (usize, usize, f64) {
    // The cell below; on a corner it may be either, with the same result.
    let rounded = at - 0.5 + ROUNDER;
    let low = rounded.to_bits() as usize & (SIDE - 1);
    (low, (low + 1) & (SIDE - 1), smooth_inside(at - (rounded - ROUNDER)))
}

/// Rises from 0 at 0 to 1 at 1 without a corner.
#[inline]
pub fn smooth(t: f64) -> f64 {
    smooth_inside(t.clamp(0.0, 1.0))
}

#[inline]
fn smooth_inside(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::attitude::{matrix, uniform};
    use crate::world::noise::Stream;

    #[test]
    fn the_noise_has_the_stated_spread_and_three_numbers_are_independent() {
        let lattice = Lattice::new(&Noise::new(3, 0, Stream::Albedo));
        let places = Noise::new(5, 0, Stream::Attitude);
        let (mut squares, mut products, mut sum) = (0.0, 0.0, 0.0);
        let count = 40_000;
        for index in 0..count {
            let place = matrix(uniform(&places, index))[2];
            let [a, b, c] = lattice.vector(place, 30.0);
            sum += a + b + c;
            squares += a * a + b * b + c * c;
            products += a * b + b * c + c * a;
        }
        let n = 3.0 * f64::from(count);
        // About 11,000 cells are cut: 4 sigma of the variance is 5 %, of a mean 0.04 deviations.
        assert!(((squares / n).sqrt() / DEVIATION - 1.0).abs() < 0.03);
        assert!((sum / n).abs() < 0.04 * DEVIATION);
        assert!((products / n / DEVIATION / DEVIATION).abs() < 0.04);
    }
}
