//! How high the limb stands: the horizon's height above where the mean profile has it.
//!
//! In: a family of fields, a place in axes that turn with the Earth, radii; the Sun's declination. Out:
//! height, km. The families share nothing but the clouds' noise; flight constants were fitted on the first.
//!
//! [`Family::Noise`], this project's choice of amplitudes: noise with cells of 2800 km, of deviation
//! `variation`; the clouds' own noise with cells of 650 and 330 km (the limb sees no less: its light comes
//! from 250 km to either side of the lowest point), of half that deviation, so that high clouds are bright
//! and lift the limb; and the season, `2.4 (1/3 - s²) + 0.8 s sin(δ) / sin(23.4°)` with the sine `s` of the
//! latitude. Mean 0 over the Earth.
//!
//! [`Family::Temperature`], clear air: the limb is that of an optical depth, and stands where the air above
//! weighs the same. Heights of the surface that has the pressure of the standard atmosphere at 10 and at 15
//! km, less these, in the five model atmospheres (McClatchey et al., AFCRL-72-0497, 1972; pressures at whole
//! km): see `ATMOSPHERES_KM`. Between latitudes they are blended, between the seasons they follow the Sun's
//! declination. On top come planetary waves of cells of 2800 km, 0.2 km: the order of the deviation of
//! heights at 300 hPa in storm tracks, no table of which was at hand.
//!
//! [`Family::CloudTops`], thick cloud everywhere: tops are spread evenly from the ground to 6 km with
//! probability 0.45 and from there to the tropopause else, as lidars in space count them (Berthier et al.,
//! Atmos. Chem. Phys. 8, 6965, 2008); the tropopause lies at 16.5 km to 25 degrees of latitude and at 9 km
//! from 55 on (radiosondes, Seidel and Randel 2007). Cells as those of the clouds. The air above a cloud
//! shines half as bright as it (`EarthModel::air_brightness`), so the limb moves by half of what the top
//! does. Mean 0 over the Earth; neither Gaussian nor of one deviation.
//!
//! Limb-scatter radiances by latitude (OSIRIS, OMPS) would be the better third source; none was at hand in
//! numbers.
//!
//! The seed's part is drawn once into a map of 256 x 256 cells of 60 to 140 km ([`super::octahedron`]), and a
//! quadratic spline runs through its corners.

use super::albedo::Albedo;
use super::lattice::{DEVIATION, Lattice, smooth};
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
/// Sine of the latitude, mean height over the year and what the summer adds, km, of the model atmospheres:
/// the mean of the surfaces of 265.0 and 121.1 hPa. Tropical +0.52 and +0.50, midlatitude summer +0.40 and
/// +0.45, winter -0.21 and -0.18, subarctic summer +0.07 and +0.22, winter -0.58 and -0.59 km.
const ATMOSPHERES_KM: [(f64, f64, f64); 3] =
    [(0.258_8, 0.51, 0.0), (std::f64::consts::FRAC_1_SQRT_2, 0.117, 0.309), (0.866_0, -0.223, 0.366)];
/// Deviation of planetary waves, km.
const WAVES_KM: f64 = 0.2;
/// Share of low cloud tops, and where they end, km.
const LOW_TOPS: (f64, f64) = (0.45, 6.0);
/// The tropopause over tropics and poles, km, and the sines of latitude where it begins and ceases to fall.
const TROPOPAUSE_KM: (f64, f64) = (16.5, 9.0);
const TROPOPAUSE_SINES: (f64, f64) = (0.422_6, 0.819_2);
/// What the limb follows of a cloud's top.
const TOP_SHARE: f64 = 0.5;
/// Cells along a side of the map.
const SIDE: usize = 256;
/// Corners along it, with one more on either side.
const CORNERS: usize = SIDE + 3;

/// What makes the limb stand higher here than there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Family {
    /// Noise of stated deviations, and a season.
    #[default]
    Noise,
    /// The temperature of the air, by latitude and season.
    Temperature,
    /// The tops of clouds.
    CloudTops,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Noise, Self::Temperature, Self::CloudTops];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Temperature => "temperature",
            Self::CloudTops => "cloud_tops",
        }
    }

    /// That of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.name() == name)
    }
}

/// The field of heights.
#[derive(Debug, Clone)]
pub struct Horizon {
    /// What the seed makes of it, km, corner by corner; empty for none.
    corners_km: Vec<f32>,
    family: Family,
    season: bool,
}

impl Horizon {
    /// A field of `family`; `clouds` are those of the same seed. `variation_km` is the deviation of the large
    /// part of [`Family::Noise`]; 0 leaves out what the seed makes in all of them.
    pub fn new(family: Family, seed: u64, variation_km: f64, season: bool, clouds: &Albedo) -> Self {
        let large = Lattice::new(&Noise::new(seed, 2, Stream::Albedo));
        let mean_km = mean_top_km();
        let height = |place: Vector| {
            let wave = large.at(place, LARGE_CELLS) * (1.0 / DEVIATION);
            (match family {
                Family::Noise => variation_km * (wave + CLOUD_SHARE * clouds.tops(place)),
                Family::Temperature => WAVES_KM * wave,
                Family::CloudTops => {
                    let rank = 0.5 * libm::erfc(-std::f64::consts::FRAC_1_SQRT_2 * clouds.tops(place));
                    TOP_SHARE * (top_km(rank, place[2]) - mean_km)
                }
            }) as f32
        };
        let at = |k: usize| (k as f64 - 1.0) / SIDE as f64;
        let corner = |index: usize| continued(at(index % CORNERS), at(index / CORNERS));
        let count = if variation_km == 0.0 { 0 } else { CORNERS * CORNERS };
        Self { corners_km: (0..count).map(|index| height(corner(index))).collect(), family, season }
    }

    /// Height at `place`, km.
    pub fn height_km(&self, place: Vector, declination_sine: f64) -> f64 {
        let s = place[2];
        let summer = declination_sine / OBLIQUITY_SINE;
        let season = match (self.season, self.family) {
            (true, Family::Noise) => TROPICS_KM * (1.0 / 3.0 - s * s) + SUMMER_KM * summer * s,
            (true, Family::Temperature) => clear_air_km(s, summer),
            _ => 0.0,
        };
        season + self.mapped_km(place)
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

/// Height of clear air's limb at a sine of latitude, km; `summer` is 1 at the northern solstice.
fn clear_air_km(sine: f64, summer: f64) -> f64 {
    let at = sine.abs();
    let [(s0, mean0, amp0), (s1, mean1, amp1), (s2, mean2, amp2)] = ATMOSPHERES_KM;
    let (first, second) = (smooth((at - s0) / (s1 - s0)), smooth((at - s1) / (s2 - s1)));
    let mean = mean0 + first * (mean1 - mean0) + second * (mean2 - mean1);
    let amplitude = amp0 + first * (amp1 - amp0) + second * (amp2 - amp1);
    mean + amplitude * summer * sine.signum()
}

/// Top of the cloud of a rank, 0 to 1, at a sine of latitude, km.
fn top_km(rank: f64, sine: f64) -> f64 {
    let (from, to) = TROPOPAUSE_SINES;
    let (tropics, poles) = TROPOPAUSE_KM;
    let tropopause = tropics + (poles - tropics) * smooth((sine.abs() - from) / (to - from));
    let (share, low) = LOW_TOPS;
    if rank < share { low * rank / share } else { low + (tropopause - low) * (rank - share) / (1.0 - share) }
}

/// Mean top over the Earth, km: even in the sine of latitude, and in the rank of either kind.
fn mean_top_km() -> f64 {
    let (share, low) = LOW_TOPS;
    let tropopause = |k: u32| top_km(1.0, (f64::from(k) + 0.5) / 64.0);
    let mean = (0..64).map(tropopause).sum::<f64>() / 64.0;
    share * 0.5 * low + (1.0 - share) * 0.5 * (low + mean)
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
        Horizon::new(Family::Noise, seed, 1.5, false, &Albedo::new(seed, 0.3, 1.0))
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
        let field = Horizon::new(Family::Noise, 1, 0.0, true, &clouds);
        let height = |latitude_deg: f64, declination_deg: f64| {
            let (s, c) = latitude_deg.to_radians().sin_cos();
            field.height_km([c, 0.0, s], declination_deg.to_radians().sin())
        };
        assert!((height(0.0, 0.0) - 0.8).abs() < 1e-12 && (height(90.0, 0.0) + 1.6).abs() < 1e-12);
        assert!((height(90.0, 23.44) - height(-90.0, 23.44) - 1.6).abs() < 2e-3);
        assert_eq!(Horizon::new(Family::Noise, 1, 0.0, false, &clouds).height_km([0.0, 0.0, 1.0], 0.3), 0.0);
    }

    #[test]
    fn clear_air_stands_as_high_as_the_model_atmospheres_say() {
        // Pressures (hPa) about the standard atmosphere's 265.0 at 10 km and 121.1 at 15 km: km below, there,
        // a km higher. AFCRL-72-0497: tropical, midlatitude summer and winter, subarctic summer and winter.
        let levels = [
            [(10.0, 286.0, 247.0), (15.0, 132.0, 111.0)],
            [(10.0, 281.0, 243.0), (15.0, 130.0, 111.0)],
            [(9.0, 299.2, 256.8), (14.0, 137.8, 117.8)],
            [(10.0, 267.7, 230.0), (15.0, 125.0, 108.0)],
            [(9.0, 282.9, 241.8), (14.0, 129.1, 110.3)],
        ];
        let height = |(below_km, below, above): (f64, f64, f64), pressure: f64, km: f64| {
            below_km + (below / pressure).ln() / (below / above).ln() - km
        };
        let mean = |[ten, fifteen]: [(f64, f64, f64); 2]| {
            0.5 * (height(ten, 265.0, 10.0) + height(fifteen, 121.1, 15.0))
        };
        let clouds = Albedo::new(1, 0.3, 1.0);
        let field = Horizon::new(Family::Temperature, 1, 0.0, true, &clouds);
        let places = [(15.0, 1.0), (45.0, 1.0), (45.0, -1.0), (60.0, 1.0), (60.0, -1.0)];
        for (level, (latitude_deg, summer)) in levels.into_iter().zip(places) {
            for half in [1.0, -1.0] {
                let (s, c) = f64::to_radians(half * latitude_deg).sin_cos();
                let found = field.height_km([c, 0.0, s], half * summer * OBLIQUITY_SINE);
                assert!(
                    (found - mean(level)).abs() < 0.01,
                    "{latitude_deg} {summer}: {found} {}",
                    mean(level)
                );
            }
        }
    }

    #[test]
    fn every_family_has_its_seeds_and_cloud_tops_no_mean() {
        for family in Family::ALL {
            let heights = |seed: u64| -> Vec<f64> {
                let clouds = Albedo::new(seed, 0.3, 1.0);
                let field = Horizon::new(family, seed, 1.5, true, &clouds);
                places(4000).iter().map(|p| field.height_km(*p, 0.2)).collect()
            };
            let (one, other) = (heights(1), heights(2));
            assert!(one == heights(1) && one != other);
            let all: Vec<f64> = (1..9).flat_map(heights).collect();
            let (mean, deviation) = moments(&all);
            println!("{}: mean {mean:.2}, deviation {deviation:.2} km", family.name());
            // Eight fields of some 1000 cells of clouds: 4 sigma of the mean are 0.1 km.
            assert!(family != Family::CloudTops || mean.abs() < 0.15, "{mean}");
            assert!((0.2..4.0).contains(&deviation));
        }
    }
}
