//! What the heights of two places of the limb have in common.
//!
//! In: the Earth model. Out: the covariance of heights by the way between two places, km², as found in the
//! fields of [`super::horizon`] of `PAIRS` pairs of seeds that no run has. Of every pair the difference is
//! taken, so that what latitude and season do, which a method may know, does not count. A sum of Gaussians
//! with weights that are not negative is fitted to the means: it is a covariance, whatever the places. Test
//! `the_covariance_is_that_of_the_fields` makes the fit and holds the table against it.

use super::horizon::Family;
use super::{EQUATOR_KM, EarthModel, Figure};

/// Widths of the Gaussians, km.
const WIDTHS_KM: [f64; 6] = [80.0, 160.0, 320.0, 640.0, 1280.0, 2560.0];
/// Their variances, km², of the model's own variation.
const NOISE_KM2: [f64; 6] = [
    0.018718556862753855,
    0.22975108051076076,
    0.13583995263537735,
    0.0,
    2.120105160273413,
    0.4864139516114791,
];
const TEMPERATURE_KM2: [f64; 6] = [0.0, 0.0, 0.0, 0.0, 0.033479082970243886, 0.010304330298240776];
const CLOUD_TOPS_KM2: [f64; 6] =
    [0.0, 1.161013390264096, 2.496453531964553, 0.14718360366545322, 0.03814173099847607, 0.0];

/// The covariance of heights.
#[derive(Clone, Debug)]
pub struct Heights {
    /// Variances of the Gaussians, km².
    variances_km2: [f64; WIDTHS_KM.len()],
    /// The body's radius over the Earth's: cells are shares of it.
    share: f64,
}

impl Heights {
    /// Those of a model's fields.
    pub fn of(model: &EarthModel) -> Self {
        let unit = EarthModel::default().height_variation_km;
        let (variances_km2, scale) = match model.horizon {
            Family::Noise => (NOISE_KM2, (model.height_variation_km / unit).powi(2)),
            Family::Temperature => (TEMPERATURE_KM2, 1.0),
            Family::CloudTops => (CLOUD_TOPS_KM2, 1.0),
        };
        let scale = if model.height_variation_km == 0.0 { 0.0 } else { scale };
        let share = Figure::of(model.body).equator_km / EQUATOR_KM;
        Self { variances_km2: variances_km2.map(|variance| scale * variance), share }
    }

    /// Covariance of two heights, km².
    pub fn covariance_km2(&self, apart_km: f64) -> f64 {
        let terms = self.variances_km2.iter().zip(WIDTHS_KM);
        terms.map(|(variance, width_km)| variance * gaussian(apart_km, self.share * width_km)).sum()
    }
}

#[cfg(test)]
impl Heights {
    /// Heights that agree over about a thousand kilometres.
    pub fn even(variance_km2: f64) -> Self {
        Self { variances_km2: [0.0, 0.0, 0.0, 0.0, variance_km2, 0.0], share: 1.0 }
    }
}

fn gaussian(apart_km: f64, width_km: f64) -> f64 {
    libm::exp(-0.5 * (apart_km / width_km) * (apart_km / width_km))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::attitude::{Vector, dot, matrix, uniform};
    use crate::world::earth::albedo::Albedo;
    use crate::world::earth::horizon::Horizon;
    use crate::world::noise::{Noise, Stream};
    use crate::world::vector::{minus, plus, times, unit};

    /// Pairs of seeds.
    const PAIRS: u64 = 12;
    /// Pairs of places at each distance in each field.
    const PLACES: u32 = 1500;
    /// Ways at which heights are compared, km.
    const APART_KM: [f64; 16] = [
        0.0, 60.0, 120.0, 180.0, 250.0, 350.0, 450.0, 600.0, 800.0, 1100.0, 1500.0, 2000.0, 2800.0, 4000.0,
        6000.0, 9000.0,
    ];
    /// Rounds of the fit.
    const ROUNDS: u32 = 5000;
    /// The Earth's mean radius, km.
    const RADIUS_KM: f64 = 6371.0;
    /// First of the seeds, far from those of campaigns.
    const FIRST_SEED: u64 = 0x6865_6967_6874_7300;

    /// The fit to a model's fields.
    fn found(model: &EarthModel) -> Heights {
        let field = |seed| {
            let clouds = Albedo::new(seed, model.mean_albedo, model.cloud_contrast);
            Horizon::new(model.horizon, seed, model.height_variation_km, model.season, &clouds)
        };
        let mut sums = [0.0; APART_KM.len()];
        for pair in 0..PAIRS {
            let seed = FIRST_SEED + 2 * pair;
            let fields = [field(seed), field(seed + 1)];
            let difference = |place| fields[0].height_km(place, 0.0) - fields[1].height_km(place, 0.0);
            let noise = Noise::new(seed, 0, Stream::Attitude);
            for (index, (sum, apart_km)) in sums.iter_mut().zip(APART_KM).enumerate() {
                for k in 0..PLACES {
                    let [place, other] = places(&noise, index as u32 * PLACES + k, apart_km);
                    *sum += 0.5 * difference(place) * difference(other);
                }
            }
        }
        fitted(&sums.map(|sum| sum / (PAIRS as f64 * f64::from(PLACES))))
    }

    /// The Gaussians nearest to covariances at [`APART_KM`]: least squares by one weight after the other.
    fn fitted(found_km2: &[f64; APART_KM.len()]) -> Heights {
        let of = |width_km: f64| APART_KM.map(|apart_km| gaussian(apart_km, width_km));
        let terms = WIDTHS_KM.map(of);
        let mut variances_km2 = [0.0; WIDTHS_KM.len()];
        for round in 0..ROUNDS {
            let changed = round as usize % WIDTHS_KM.len();
            let (mut product, mut square) = (0.0, 0.0);
            for (place, found) in found_km2.iter().enumerate() {
                let others = (0..WIDTHS_KM.len()).filter(|term| *term != changed);
                let rest = found - others.map(|term| variances_km2[term] * terms[term][place]).sum::<f64>();
                product += rest * terms[changed][place];
                square += terms[changed][place] * terms[changed][place];
            }
            variances_km2[changed] = f64::max(product / square, 0.0);
        }
        Heights { variances_km2, share: 1.0 }
    }

    /// Two places as far apart, in any direction.
    fn places(noise: &Noise, index: u32, apart_km: f64) -> [Vector; 2] {
        let [_, across, place] = matrix(uniform(noise, index));
        let across = unit(minus(across, times(dot(across, place), place)));
        let (s, c) = libm::sincos(apart_km / RADIUS_KM);
        [place, plus(times(c, place), s, across)]
    }

    #[test]
    fn the_covariance_is_that_of_the_fields() {
        let of_family = Family::ALL.map(|horizon| {
            let model = EarthModel { horizon, ..EarthModel::default() };
            let found = found(&model);
            println!("{}: {:?} km2", horizon.name(), found.variances_km2);
            (horizon, found, Heights::of(&model))
        });
        for (horizon, found, table) in of_family {
            let whole = found.covariance_km2(0.0);
            for apart_km in APART_KM {
                let off = found.covariance_km2(apart_km) - table.covariance_km2(apart_km);
                assert!(off.abs() < 1e-4 * whole, "{}, {apart_km} km: {off}", horizon.name());
            }
        }
        let noise = Heights::of(&EarthModel::default());
        // 1.5 km in the large and half as much in the small.
        assert!((noise.covariance_km2(0.0).sqrt() / 1.677 - 1.0).abs() < 0.07);
        assert!(noise.covariance_km2(5000.0).abs() < 0.1 * noise.covariance_km2(0.0));
        // What latitude and season do is known: waves are left.
        let clear = EarthModel { horizon: Family::Temperature, ..EarthModel::default() };
        assert!((Heights::of(&clear).covariance_km2(0.0).sqrt() / 0.2 - 1.0).abs() < 0.15);
        let none = EarthModel { height_variation_km: 0.0, ..EarthModel::default() };
        assert_eq!(Heights::of(&none).covariance_km2(0.0), 0.0);
    }
}
