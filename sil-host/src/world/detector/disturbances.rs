//! What is on the detector and is no star: false stars, hot pixels, dead pixels, protons.
//!
//! In: counts and ranges, a seed, a cycle. Out: spots (false stars) and [`Deposits`] (electrons in single
//! pixels). False stars and protons ([`super::protons`]) are new in each cycle, hot and dead pixels stay.
//! Places are uniform over the detector. A dead pixel always reads 0 or full scale, whatever it collects.

use super::deposits::{Deposit, Deposits};
use super::protons::Protons;
use crate::world::lens::spots::Spot;
use crate::world::noise::{Noise, Stream};
use crate::world::sky::colour::BANDS;
use fsw_hal::DetectorGeometry;

/// What is on the detector and is no star; counts are for a whole frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbances {
    /// Star images that are none.
    pub false_stars: u32,
    /// Range of magnitudes of the false stars.
    pub false_star_v: (f64, f64),
    /// Pixels with a high dark current.
    pub hot_pixels: u32,
    /// Range of their dark current, e-/s; the logarithm is uniform.
    pub hot_pixel_e_s: (f64, f64),
    /// Pixels that always read 0.
    pub dead_low: u32,
    /// Pixels that always read full scale.
    pub dead_high: u32,
    /// Protons.
    pub protons: Protons,
    /// Share of the hot pixels, and of the dead ones, that was found when the detector was surveyed.
    pub surveyed: f64,
}

impl Default for Disturbances {
    fn default() -> Self {
        Self {
            false_stars: 0,
            false_star_v: (2.0, 5.5),
            hot_pixels: 0,
            hot_pixel_e_s: (4e3, 1e5),
            dead_low: 0,
            dead_high: 0,
            protons: Protons::Fixed(0),
            surveyed: 0.0,
        }
    }
}

impl Disturbances {
    /// Whether the ranges are finite, and positive where their logarithm is taken.
    pub(crate) fn is_sound(&self) -> bool {
        let (brightest, faintest) = self.false_star_v;
        let charges = [self.hot_pixel_e_s.0, self.hot_pixel_e_s.1];
        brightest.is_finite() && faintest.is_finite() && charges.iter().all(|c| c.is_finite() && *c > 0.0)
    }

    /// The false stars of a cycle; `electrons` gives those of a magnitude.
    pub fn false_stars(
        &self,
        seed: u64,
        cycle: u64,
        geometry: DetectorGeometry,
        electrons: impl Fn(f64) -> [f64; BANDS],
    ) -> Vec<Spot> {
        let noise = Noise::new(seed, cycle, Stream::FalseStar);
        let (brightest, faintest) = self.false_star_v;
        let place = |index| Spot {
            x_px: f64::from(geometry.width_px) * noise.uniform(index, 0) - 0.5,
            y_px: f64::from(geometry.height_px) * noise.uniform(index, 1) - 0.5,
            electrons: electrons(brightest + (faintest - brightest) * noise.uniform(index, 2)),
        };
        (0..self.false_stars).map(place).collect()
    }

    /// The hot pixels of a detector; their charge is a second's.
    pub fn hot_pixels(&self, seed: u64, geometry: DetectorGeometry) -> Deposits {
        let noise = Noise::new(seed, 0, Stream::HotPixel);
        let place = |index| {
            let (x, y) = random_pixel(&noise, index, geometry);
            Deposit { x, y, electrons: log_uniform(self.hot_pixel_e_s, noise.uniform(index, 2)) }
        };
        Deposits::new((0..self.hot_pixels).map(place).collect())
    }

    /// The dead pixels of a detector, sorted by row: place, and whether full scale is read.
    pub fn dead_pixels(&self, seed: u64, geometry: DetectorGeometry) -> Vec<(u16, u16, bool)> {
        let noise = Noise::new(seed, 0, Stream::DeadPixel);
        let place = |index| {
            let (x, y) = random_pixel(&noise, index, geometry);
            (x, y, index >= self.dead_low)
        };
        let mut dead: Vec<_> = (0..self.dead_low + self.dead_high).map(place).collect();
        dead.sort_by_key(|(_, y, _)| *y);
        dead
    }

    /// The hot and dead pixels that the survey found (column, row), row by row.
    pub fn surveyed(&self, seed: u64, geometry: DetectorGeometry) -> Vec<[u16; 2]> {
        let counts =
            [(Stream::HotPixel, self.hot_pixels), (Stream::DeadPixel, self.dead_low + self.dead_high)];
        let found = |(stream, count)| {
            let noise = Noise::new(seed, 0, stream);
            let places = (0..count).filter(|index| noise.uniform(*index, 3) < self.surveyed);
            places.map(|index| random_pixel(&noise, index, geometry).into()).collect::<Vec<_>>()
        };
        let mut pixels: Vec<[u16; 2]> = counts.into_iter().flat_map(found).collect();
        pixels.sort_unstable_by_key(|[x, y]| [*y, *x]);
        pixels.dedup();
        pixels
    }
}

fn random_pixel(noise: &Noise, index: u32, geometry: DetectorGeometry) -> (u16, u16) {
    let pick = |side: u16, n| (f64::from(side) * noise.uniform(index, n)) as u16;
    (pick(geometry.width_px, 0), pick(geometry.height_px, 1))
}

fn log_uniform((low, high): (f64, f64), uniform: f64) -> f64 {
    low * libm::pow(high / low, uniform)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 100, height_px: 60, bits: 10 };

    #[test]
    fn disturbances_come_in_number_and_range() {
        let d = Disturbances {
            false_stars: 500,
            hot_pixels: 500,
            dead_low: 20,
            dead_high: 9,
            ..Disturbances::default()
        };
        let spots = d.false_stars(1, 2, GEOMETRY, |v| [v, 0.0, 0.0]);
        assert!(spots.len() == 500 && spots.iter().all(|s| (2.0..=5.5).contains(&s.electrons[0])));
        assert!(spots.iter().all(|s| (-0.5..99.5).contains(&s.x_px) && (-0.5..59.5).contains(&s.y_px)));
        let hot = d.hot_pixels(1, GEOMETRY);
        assert!(hot.as_slice().iter().all(|h| (4e3..=1e5).contains(&h.electrons) && h.x < 100 && h.y < 60));
        assert_eq!(hot.as_slice().len(), 500);
        let dead = d.dead_pixels(1, GEOMETRY);
        assert!(dead.len() == 29 && dead.iter().filter(|(.., high)| *high).count() == 9);
        assert!(dead.iter().all(|(x, y, _)| *x < 100 && *y < 60));
    }
    #[test]
    fn a_survey_finds_its_share_of_the_hot_and_dead_pixels_and_no_other() {
        let of = |surveyed| Disturbances {
            hot_pixels: 2_000,
            dead_low: 300,
            dead_high: 200,
            surveyed,
            ..Disturbances::default()
        };
        let bad: BTreeSet<_> = {
            let hot = of(0.0).hot_pixels(1, GEOMETRY);
            let hot: Vec<_> = hot.as_slice().iter().map(|h| [h.x, h.y]).collect();
            hot.into_iter().chain(of(0.0).dead_pixels(1, GEOMETRY).iter().map(|(x, y, _)| [*x, *y])).collect()
        };
        let found = |surveyed| of(surveyed).surveyed(1, GEOMETRY);
        let in_rows = |pixels: &[[u16; 2]]| pixels.is_sorted_by(|a, b| [a[1], a[0]] < [b[1], b[0]]);
        assert!(found(0.0).is_empty() && found(1.0).len() == bad.len());
        for pixels in [found(1.0), found(0.9)] {
            assert!(in_rows(&pixels) && pixels.iter().all(|at| bad.contains(at)));
        }
        // Of 2,500 draws 2,250 within 4.7 sigma of 15; places that were drawn twice are found oftener.
        let share = found(0.9).len() as f64 / bad.len() as f64;
        assert!((0.88..0.96).contains(&share), "{share}");
    }
}
