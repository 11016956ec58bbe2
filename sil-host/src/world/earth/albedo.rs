//! Sea, land, ice and clouds: the albedo of a place.
//!
//! In: a place in axes that turn with the Earth, radii; the size of what is asked for. Out: albedo, 0.05 to
//! 0.85, mean about 0.3.
//!
//! Clouds are a sum of eight octaves of value noise with cells of 2600 to 20 km, of weights that fall by
//! 0.86, seen through a displacement by noise of larger cells that draws them into bands and whorls; they
//! cover about 60 %, most in the belt of rising air north of the equator and in the storm tracks, least over
//! the subtropics. The seed makes them; sea and land (29 %, five octaves from 3600 km), deserts and the ice
//! of the poles are the same for every seed. Nothing of the real map is meant. Octaves whose cells the asked
//! size does not resolve fade out. Clouds neither move nor change in a run.

use super::lattice::{DEVIATION, Lattice, smooth};
use crate::world::attitude::{Vector, apply, matrix, uniform};
use crate::world::noise::{Noise, Stream};
use crate::world::vector::plus;

/// Octaves of the clouds.
const OCTAVES: usize = 8;
/// Cells a radius of the first octave; each further has twice as many.
const FIRST_CELLS: f64 = 2.45;
/// Weight of an octave over that before.
const PERSISTENCE: f64 = 0.86;
/// Displacements: cells a radius, most displacement along an axis in radii.
const WHORLS: [(f64, f64); 2] = [(3.6, 0.22), (14.0, 0.035)];
/// Length of the Earth's radius as the cells count it, km.
const RADIUS_KM: f64 = 6371.0;
/// Octaves of the land: cells a radius, weight.
const LAND: [(f64, f64); 5] = [(1.77, 0.5), (4.1, 0.25), (9.7, 0.13), (23.0, 0.08), (57.0, 0.04)];
/// The Earth's own number: land and sea are of no run.
const EARTH: u64 = 0x0ea7;

/// The Earth's face.
#[derive(Debug, Clone)]
pub struct Albedo {
    clouds: Lattice,
    land: Lattice,
    /// Turns each octave against the others, so that the lattices' axes do not show.
    turns: [[Vector; 3]; OCTAVES],
    mean: f64,
    contrast: f64,
}

impl Albedo {
    /// A face of the given mean and contrast.
    pub fn new(seed: u64, mean: f64, contrast: f64) -> Self {
        let clouds = Noise::new(seed, 0, Stream::Albedo);
        let turns = [0, 1, 2, 3, 4, 5, 6, 7].map(|octave| matrix(uniform(&clouds, 1_000_000 + octave)));
        let land = Lattice::new(&Noise::new(EARTH, 1, Stream::Albedo));
        Self { clouds: Lattice::new(&clouds), land, turns, mean, contrast }
    }

    /// The albedo at `place` over `size_km` of ground.
    pub fn at(&self, place: Vector, size_km: f64) -> f64 {
        if self.contrast == 0.0 {
            return self.mean;
        }
        let clouds = self.clouds(place, size_km);
        let cover = smooth((clouds + 0.62) * (1.0 / 1.1));
        let thick = smooth((clouds + 0.3) * (1.0 / 3.3));
        let ground = if cover < 1.0 { self.ground(place, size_km) } else { 0.0 };
        let albedo = ground * (1.0 - cover) + cover * (0.31 + 0.54 * thick);
        self.mean + self.contrast * (albedo - self.mean)
    }

    /// Clouds: of mean about 0 and deviation about 1, the denser the greater.
    fn clouds(&self, place: Vector, size_km: f64) -> f64 {
        let seen_from = self.displaced(place, &WHORLS);
        let mut sum = 0.0;
        let (mut cells, mut weight) = (FIRST_CELLS, 1.0);
        for turn in &self.turns {
            let seen = resolved(size_km, cells);
            if seen == 0.0 {
                break;
            }
            sum += weight * seen * self.clouds.at(apply(turn, seen_from), cells);
            cells *= 2.0;
            weight *= PERSISTENCE;
        }
        sum * (1.0 / (SPREAD * DEVIATION)) + climate(place[2])
    }

    /// The two octaves of the clouds that the limb can resolve (650 and 330 km), of deviation 1.
    pub fn tops(&self, place: Vector) -> f64 {
        // The smaller whorls are less than what the limb can tell apart.
        let seen_from = self.displaced(place, &WHORLS[..1]);
        let octave = |k: usize, cells: f64| self.clouds.at(apply(&self.turns[k], seen_from), cells);
        let sum = octave(2, 4.0 * FIRST_CELLS) + PERSISTENCE * octave(3, 8.0 * FIRST_CELLS);
        sum * (1.0 / (DEVIATION * (1.0 + PERSISTENCE * PERSISTENCE).sqrt()))
    }

    /// The place at which the clouds over `place` are looked up.
    fn displaced(&self, place: Vector, whorls: &[(f64, f64)]) -> Vector {
        let mut at = place;
        for (cells, most) in whorls {
            at = plus(at, *most, self.clouds.vector(at, *cells));
        }
        at
    }

    /// What lies below the clouds.
    fn ground(&self, place: Vector, size_km: f64) -> f64 {
        let mut land = 0.0;
        for (cells, weight) in LAND {
            land += weight * resolved(size_km, cells) * self.land.at(place, cells);
        }
        let z = place[2].abs();
        // Ice to about 70 degrees, its edge moved by the land's noise.
        let ice = smooth((z + 0.3 * land - 0.925) * (1.0 / 0.03));
        let dry = smooth(1.0 - (z - 0.4).abs() * (1.0 / 0.22)) * smooth(0.5 + 4.0 * self.land.at(place, 5.3));
        let soil = 0.15 + 0.17 * dry;
        let bare = 0.05 + (soil - 0.05) * smooth((land - 0.042) * (1.0 / 0.015));
        bare + ice * (0.68 - bare)
    }
}

/// Root of the sum of the weights' squares.
const SPREAD: f64 = 1.870;

/// How much of an octave is left of what covers `size_km`.
fn resolved(size_km: f64, cells: f64) -> f64 {
    (1.5 - size_km * cells * (1.0 / RADIUS_KM)).clamp(0.0, 1.0)
}

/// What the latitude adds to the clouds, from its sine: rising air at 6 degrees north, dry belts, storm
/// tracks.
fn climate(sine: f64) -> f64 {
    let bump = |at: f64, width: f64| smooth(1.0 - (sine - at).abs() / width);
    0.55 * bump(0.11, 0.14) - 0.75 * (bump(0.42, 0.27) + bump(-0.32, 0.29))
        + 0.8 * (bump(0.86, 0.3) + bump(-0.84, 0.34))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(count: u32) -> impl Iterator<Item = Vector> {
        let noise = Noise::new(5, 0, Stream::Attitude);
        (0..count).map(move |index| matrix(uniform(&noise, index))[2])
    }

    #[test]
    fn the_face_has_the_earths_mean_albedo_range_and_cover() {
        let mut weights = [1.0; OCTAVES];
        (1..OCTAVES).for_each(|k| weights[k] = PERSISTENCE * weights[k - 1]);
        assert!((weights.iter().map(|w| w * w).sum::<f64>().sqrt() - SPREAD).abs() < 2e-3, "{weights:?}");
        for seed in 0..6 {
            let face = Albedo::new(seed, 0.3, 1.0);
            for size_km in [5.0, 25.0] {
                let values: Vec<f64> = places(20_000).map(|place| face.at(place, size_km)).collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                let cloudy = places(20_000).filter(|p| face.clouds(*p, size_km) > -0.3).count() as f64 / 2e4;
                let least = values.iter().copied().fold(1.0, f64::min);
                let most = values.iter().copied().fold(0.0, f64::max);
                println!(
                    "seed {seed}, {size_km} km: mean {mean:.3}, clouds {cloudy:.2}, {least:.2} to {most:.2}"
                );
                assert!((0.26..0.34).contains(&mean) && (0.5..0.7).contains(&cloudy));
                assert!((0.0499..0.1).contains(&least) && (0.7..0.851).contains(&most));
            }
        }
    }

    #[test]
    fn the_ground_is_the_same_for_every_seed_and_has_a_third_of_land() {
        let (one, other) = (Albedo::new(1, 0.3, 1.0), Albedo::new(2, 0.3, 1.0));
        assert!(places(2000).all(|p| one.ground(p, 5.0) == other.ground(p, 5.0)));
        assert!(places(2000).any(|p| one.at(p, 5.0) != other.at(p, 5.0)));
        let open: Vec<Vector> = places(20_000).filter(|p| p[2].abs() < 0.9).collect();
        let land = open.iter().filter(|p| one.ground(**p, 5.0) > 0.1).count() as f64 / open.len() as f64;
        println!("land {land:.2}");
        assert!((0.2..0.4).contains(&land));
        assert!(one.ground([0.0, 0.0, 1.0], 5.0) > 0.6 && one.ground([0.0, 0.0, -1.0], 5.0) > 0.6);
    }

    #[test]
    fn the_face_has_no_steps() {
        let face = Albedo::new(1, 0.3, 1.0);
        for place in places(20_000) {
            let beside = place.map(|c| c + 1e-6);
            // 10 m further on, at most what 5 km change by.
            assert!((face.at(place, 5.0) - face.at(beside, 5.0)).abs() < 2e-3);
            assert!((face.at(place, 100.0) - face.at(place, 100.001)).abs() < 1e-4);
        }
    }

    #[test]
    fn without_contrast_all_is_the_mean() {
        let face = Albedo::new(1, 0.3, 0.0);
        assert!(places(100).all(|place| face.at(place, 5.0) == 0.3));
    }
}
