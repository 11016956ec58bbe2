//! How high the limb stands: the horizon's height above where the mean profile has it.
//!
//! In: a place in axes that turn with the Earth, radii; the Sun's declination. Out: height, km, of mean 0
//! over the Earth.
//!
//! Three parts: noise with cells of 2800 km, of deviation `variation`; the clouds' own noise with cells of
//! 650 and 330 km (the limb sees no less: its light comes from 250 km to either side of the lowest point), of
//! half that deviation, so that high clouds are bright and lift the limb; and the season, `2.4 (1/3 - s²) +
//! 0.8 s sin(δ) / sin(23.4°)` with the sine `s` of the latitude: the tropopause stands higher over the
//! tropics and the summer half. The first two change with the seed. Amplitudes are this project's choice:
//! kilometres, as the stated spread of half-brightness heights in pictures of the limb.
//!
//! The seed's part is drawn once into a map of 256 x 256 cells of 60 to 140 km ([`super::octahedron`]), and a
//! quadratic spline runs through its corners.

use super::albedo::Albedo;
use super::lattice::{DEVIATION, Lattice};
use super::octahedron::{folded, unfolded};
use crate::world::attitude::Vector;
use crate::world::noise::{Noise, Stream};

/// Cells a radius of the large part.
const LARGE_CELLS: f64 = 2.3;
/// Deviation of the clouds' part over that of the large one.
const CLOUD_SHARE: f64 = 0.5;
/// Equator over pole, km.
const TROPICS_KM: f64 = 2.4;
/// Summer pole over the mean of both at the solstice, km.
const SUMMER_KM: f64 = 0.8;
/// Sine of the obliquity.
const OBLIQUITY_SINE: f64 = 0.397_8;
/// Cells along a side of the map.
const SIDE: usize = 256;
/// Corners along it, with one more on either side.
const CORNERS: usize = SIDE + 3;

/// The field of heights.
#[derive(Debug, Clone)]
pub struct Horizon {
    /// What the seed makes of it, km, corner by corner; empty for none.
    corners_km: Vec<f32>,
    season: bool,
}

impl Horizon {
    /// A field whose large part has the deviation `variation_km`; `clouds` are those of the same seed.
    pub fn new(seed: u64, variation_km: f64, season: bool, clouds: &Albedo) -> Self {
        let large = Lattice::new(&Noise::new(seed, 2, Stream::Albedo));
        let height = |place| {
            let large = large.at(place, LARGE_CELLS) * (1.0 / DEVIATION);
            (variation_km * (large + CLOUD_SHARE * clouds.tops(place))) as f32
        };
        let at = |k: usize| (k as f64 - 1.0) / SIDE as f64;
        let corner = |index: usize| continued(at(index % CORNERS), at(index / CORNERS));
        let count = if variation_km == 0.0 { 0 } else { CORNERS * CORNERS };
        Self { corners_km: (0..count).map(|index| height(corner(index))).collect(), season }
    }

    /// Height at `place`, km.
    pub fn height_km(&self, place: Vector, declination_sine: f64) -> f64 {
        let s = place[2];
        let season = TROPICS_KM * (1.0 / 3.0 - s * s) + SUMMER_KM / OBLIQUITY_SINE * declination_sine * s;
        (if self.season { season } else { 0.0 }) + self.mapped_km(place)
    }

    /// The part that the seed makes, drawn through the map's corners.
    fn mapped_km(&self, place: Vector) -> f64 {
        let [u, v] = unfolded(place.map(|c| c as f32)).map(|at| at * SIDE as f32);
        let (i, j) = ((u + 0.5) as i32 as usize, (v + 0.5) as i32 as usize);
        let (across, down) = (spline(u - i as f32), spline(v - j as f32));
        let row = |k: usize| {
            let start = (j + k) * CORNERS + i;
            let Some(near) = self.corners_km.get(start..start + 3) else { return 0.0 };
            across[0] * near[0] + across[1] * near[1] + across[2] * near[2]
        };
        f64::from(down[0] * row(0) + down[1] * row(1) + down[2] * row(2))
    }
}

/// Weights of the corners before, at and after a place `t` from the nearest: the quadratic B-spline, which
/// has no kinks (along three great circles the octahedron has some).
#[inline]
fn spline(t: f32) -> [f32; 3] {
    let (before, after) = (0.5 - t, 0.5 + t);
    [0.5 * before * before, 0.75 - t * t, 0.5 * after * after]
}

/// [`folded`], a little beyond the edges as well: a step out of the square leads in again at the opposite
/// point of that edge.
fn continued(u: f64, v: f64) -> Vector {
    let inside = |at: f64| if at < 0.0 { -at } else { at.min(2.0 - at) };
    let (a, b) = (inside(u), inside(v));
    folded(if b == v { a } else { 1.0 - a }, if a == u { b } else { 1.0 - b })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::attitude::{dot, matrix, uniform};
    use crate::world::vector::{minus, plus, times, unit};

    fn field(seed: u64) -> Horizon {
        Horizon::new(seed, 1.5, false, &Albedo::new(seed, 0.3, 1.0))
    }

    fn places(count: u32) -> Vec<Vector> {
        let noise = Noise::new(5, 0, Stream::Attitude);
        (0..count).map(|index| matrix(uniform(&noise, index))[2]).collect()
    }

    /// Mean and deviation over places and seeds.
    fn moments(values: &[f64]) -> (f64, f64) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
    }

    #[test]
    fn the_field_has_the_stated_deviation_and_no_mean() {
        let mut heights = Vec::new();
        for seed in 0..40 {
            let field = field(seed);
            heights.extend(places(500).iter().map(|p| field.height_km(*p, 0.0)));
        }
        let (mean, deviation) = moments(&heights);
        // Large and cloud part: 1.5 (1 + 1/4)^(1/2). Forty fields of some 70 large cells each: 4 sigma are 6
        // %.
        assert!(mean.abs() < 0.12 && (deviation / 1.677 - 1.0).abs() < 0.06, "{mean} {deviation}");
    }

    #[test]
    fn the_map_has_no_seam() {
        // Along the equator's fold and the cuts of the southern half, steps of 6 km.
        let field = field(3);
        for (from, step) in [([1.0, 0.3, -0.02], [0.0, 0.0, 1e-3]), ([0.6, -0.02, -0.7], [0.0, 1e-3, 0.0])] {
            let height = |k: i32| field.height_km([0, 1, 2].map(|c| from[c] + step[c] * f64::from(k)), 0.0);
            let slope = |k: i32| height(k + 1) - height(k);
            let steepest = (0..40).map(|k| slope(k).abs()).fold(0.0, f64::max);
            println!("steepest {steepest:.4} km in 6 km");
            assert!(steepest < 0.05);
        }
    }

    #[test]
    fn neighbours_agree_and_far_places_know_nothing_of_each_other() {
        let mut products = [[0.0; 2]; 5];
        let distances_km = [50.0, 200.0, 600.0, 1400.0, 5000.0];
        for seed in 0..40 {
            let field = field(seed);
            for pair in places(800).chunks_exact(2) {
                let across = unit(minus(pair[1], times(dot(pair[0], pair[1]), pair[0])));
                let here = field.height_km(pair[0], 0.0);
                for (product, km) in products.iter_mut().zip(distances_km) {
                    let (s, c) = libm::sincos(km / 6371.0);
                    let there = field.height_km(plus(times(c, pair[0]), s, across), 0.0);
                    product[0] += here * there;
                    product[1] += here * here;
                }
            }
        }
        let correlation = products.map(|[ab, aa]| ab / aa);
        println!("correlation at {distances_km:?} km: {correlation:.3?}");
        assert!(correlation[0] > 0.97 && correlation[1] > 0.85);
        assert!((0.5..0.9).contains(&correlation[2]) && (0.2..0.7).contains(&correlation[3]));
        assert!(correlation[4].abs() < 0.06);
    }

    #[test]
    fn high_clouds_lift_the_limb() {
        let (field, clouds) = (field(7), Albedo::new(7, 0.3, 1.0));
        let pairs: Vec<[f64; 2]> = places(5000)
            .iter()
            .filter(|p| p[2].abs() < 0.85)
            .map(|p| [field.height_km(*p, 0.0), clouds.at(*p, 300.0)])
            .collect();
        let heights = moments(&pairs.iter().map(|p| p[0]).collect::<Vec<_>>());
        let albedo = moments(&pairs.iter().map(|p| p[1]).collect::<Vec<_>>());
        let product: f64 = pairs.iter().map(|p| (p[0] - heights.0) * (p[1] - albedo.0)).sum();
        let correlation = product / pairs.len() as f64 / heights.1 / albedo.1;
        println!("height with albedo: {correlation:.2}");
        assert!(correlation > 0.1);
    }

    #[test]
    fn the_season_lifts_the_tropics_and_the_summer() {
        let clouds = Albedo::new(1, 0.3, 1.0);
        let field = Horizon::new(1, 0.0, true, &clouds);
        let height = |latitude_deg: f64, declination_deg: f64| {
            let (s, c) = latitude_deg.to_radians().sin_cos();
            field.height_km([c, 0.0, s], declination_deg.to_radians().sin())
        };
        assert!((height(0.0, 0.0) - 0.8).abs() < 1e-12 && (height(90.0, 0.0) + 1.6).abs() < 1e-12);
        assert!((height(90.0, 23.44) - height(-90.0, 23.44) - 1.6).abs() < 2e-3);
        assert_eq!(Horizon::new(1, 0.0, false, &clouds).height_km([0.0, 0.0, 1.0], 0.3), 0.0);
    }
}
