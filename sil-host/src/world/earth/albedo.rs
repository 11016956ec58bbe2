//! Sea, land and clouds: the albedo of a place.
//!
//! In: a place in axes that turn with the Earth, radii. Out: albedo, 0.06 to 0.8, mean about 0.3. Clouds are a sum of four
//! octaves of value noise with cells of 2100 to 130 km: random numbers on a lattice of cubes, blended smoothly
//! (`3 t² - 2 t³`) between its corners. They cover about 60 %. Octaves whose cells the pixel does not resolve fade out. Land is
//! one octave of 2900 km. Nothing of the real map is meant.

use crate::world::attitude::Vector;
use crate::world::noise::{Noise, Stream};
use std::sync::LazyLock;

/// Corners of the lattice along a side, after which it repeats; a power of two.
const SIDE: usize = 16;
/// 1.5 · 2⁵²: a number added to it is rounded to a whole one, which stands in the lowest bits. Far quicker than a
/// conversion, and as exact.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// Octaves of the clouds: cells a radius, weight.
const OCTAVES: [(f64, f64); 4] = [(3.0, 0.40), (7.5, 0.30), (19.0, 0.20), (49.0, 0.10)];
/// Spread of the weighted sum, by which it is divided.
const SPREAD: f64 = 0.088;
/// Cells a radius of the land.
const LAND_CELLS: f64 = 2.2;
/// Length of the Earth's radius as the cells count it, km.
const RADIUS_KM: f64 = 6371.0;

/// Random numbers of the lattice's corners; of a length known when compiling, so that no index need be checked.
type Lattice = [f32; SIDE * SIDE * SIDE];

static LATTICE: LazyLock<Box<Lattice>> = LazyLock::new(|| {
    let noise = Noise::new(0, 0, Stream::Albedo);
    let mut lattice = Box::new([0.0; SIDE * SIDE * SIDE]);
    for (index, corner) in (0..).zip(lattice.iter_mut()) {
        *corner = (noise.uniform(index, 0) - 0.5) as f32;
    }
    lattice
});

/// The Earth's face, ready to be asked.
#[derive(Debug, Clone, Copy)]
pub struct Albedo {
    lattice: &'static Lattice,
    mean: f64,
    contrast: f64,
}

impl Albedo {
    /// A face of the given mean and contrast.
    pub fn new(mean: f64, contrast: f64) -> Self {
        Self { lattice: &LATTICE, mean, contrast }
    }

    /// The albedo at `place` as a pixel sees it that covers `footprint_km` of ground.
    #[inline]
    pub fn at(&self, place: Vector, footprint_km: f64) -> f64 {
        if self.contrast == 0.0 {
            return self.mean;
        }
        let mut sum = 0.0;
        for (cells, weight) in OCTAVES {
            let seen = (1.5 - footprint_km * cells * (1.0 / RADIUS_KM)).clamp(0.0, 1.0);
            if seen > 0.0 {
                sum += weight * seen * self.noise(place, cells);
            }
        }
        let clouds = sum * (1.0 / SPREAD);
        let cover = smooth((clouds + 0.52) * (1.0 / 0.7));
        let thick = smooth((clouds + 0.8) * (1.0 / 3.6));
        let ground = if cover < 1.0 {
            0.06 + 0.2 * smooth((self.noise(place, LAND_CELLS) - 0.05) * (1.0 / 0.08))
        } else {
            0.0
        };
        let albedo = ground * (1.0 - cover) + cover * (0.22 + 0.58 * thick);
        self.mean + self.contrast * (albedo - self.mean)
    }

    /// Value noise, -0.5 to 0.5.
    #[inline]
    fn noise(&self, place: Vector, cells: f64) -> f64 {
        let at = place.map(|c| c * cells);
        // The cell below; on a corner it may be either, with the same result.
        let rounded = at.map(|c| c - 0.5 + ROUNDER);
        let [x, y, z] = [0, 1, 2].map(|k| smooth_inside(at[k] - (rounded[k] - ROUNDER)));
        let low = rounded.map(|c| c.to_bits() as usize & (SIDE - 1));
        let high = low.map(|c| (c + 1) & (SIDE - 1));
        let corner = |i: usize, j: usize, k: usize| f64::from(self.lattice[(k * SIDE + j) * SIDE + i]);
        let along_x = |j, k| {
            let (a, b) = (corner(low[0], j, k), corner(high[0], j, k));
            a + x * (b - a)
        };
        let along_y = |k| {
            let (a, b) = (along_x(low[1], k), along_x(high[1], k));
            a + y * (b - a)
        };
        let (a, b) = (along_y(low[2]), along_y(high[2]));
        a + z * (b - a)
    }
}

/// Rises from 0 at 0 to 1 at 1 without a corner.
#[inline]
fn smooth(t: f64) -> f64 {
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

    fn places(count: u32) -> impl Iterator<Item = Vector> {
        let noise = Noise::new(5, 0, Stream::Attitude);
        (0..count).map(move |index| matrix(uniform(&noise, index))[2])
    }

    #[test]
    fn the_face_has_the_earths_mean_albedo_range_and_cover() {
        let face = Albedo::new(0.3, 1.0);
        let values: Vec<f64> = places(20_000).map(|place| face.at(place, 5.0)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        // Sea and land without clouds are darker than 0.27.
        let cloudy = values.iter().filter(|v| **v > 0.22).count() as f64 / values.len() as f64;
        let least = values.iter().copied().fold(1.0, f64::min);
        let most = values.iter().copied().fold(0.0, f64::max);
        println!("mean {mean:.3}, clouds {cloudy:.2}, {least:.2} to {most:.2}");
        assert!((0.27..0.33).contains(&mean) && (0.5..0.7).contains(&cloudy));
        assert!((0.06..0.1).contains(&least) && (0.7..=0.8).contains(&most));
    }

    #[test]
    fn the_face_has_no_steps() {
        let face = Albedo::new(0.3, 1.0);
        for place in places(20_000) {
            let beside = place.map(|c| c + 1e-6);
            // 6 m further on, at most what 130 km change by.
            assert!((face.at(place, 5.0) - face.at(beside, 5.0)).abs() < 2e-3);
            assert!((face.at(place, 100.0) - face.at(place, 100.001)).abs() < 1e-4);
        }
    }

    #[test]
    fn without_contrast_all_is_the_mean() {
        let face = Albedo::new(0.3, 0.0);
        assert!(places(100).all(|place| face.at(place, 5.0) == 0.3));
    }
}
