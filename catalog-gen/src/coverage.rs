//! How many catalogue stars a random field holds, and how often that is enough.
//!
//! In: the usable stars of a catalogue. Out: the share of random fields with at least 3, 4 and 5 of them,
//! with the whole field free and with an Earth disc in its middle. The field is the one the catalogue was
//! made for, pointed uniformly over the sky with a uniform roll. The random numbers are seeded and need only
//! `+ - * / sqrt`: the same answer everywhere.

use crate::parameters::REFERENCE_FIELD_DEG;
use crate::source::normalised;

/// Half the reference detector in focal lengths: 640 and 512 px of 3000.
const HALF_FIELD: [f64; 2] = [640.0 / 3000.0, 512.0 / 3000.0];
/// Radius of the Earth's disc from a geostationary orbit, 459 px of 3000 (8.7 degrees).
const EARTH_RADIUS: f64 = 459.0 / 3000.0;
/// Seed of every coverage figure.
const SEED: u64 = 0x5e87_a297;
/// Fields that make 99.9 % a statement: 20 of 20,000 may fail.
pub const DEFAULT_FIELDS: u32 = 20_000;

/// Shares of random fields, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Number of random fields.
    pub fields: u32,
    /// Mean number of stars in a field.
    pub mean_stars: f64,
    /// Fewest stars seen in a field.
    pub fewest_stars: u32,
    /// Share of fields with at least 3, 4, 5 stars.
    pub share: [f64; 3],
    /// Fewest stars seen in a field with an Earth disc in its middle.
    pub fewest_stars_with_earth: u32,
    /// Share of fields with at least 3, 4, 5 stars beside an Earth disc in the middle.
    pub share_with_earth: [f64; 3],
}

/// Half of a field whose longer side is `field_deg`, in focal lengths: the reference detector, or one of its
/// shape.
pub fn half_field(field_deg: f64) -> [f64; 2] {
    if (field_deg - REFERENCE_FIELD_DEG[0]).abs() < 1e-6 {
        return HALF_FIELD;
    }
    let half = libm::tan(0.5 * field_deg.to_radians());
    [half, half * HALF_FIELD[1] / HALF_FIELD[0]]
}

/// Counts the stars in `fields` random fields, each half so large in focal lengths.
pub fn coverage(stars: &[[f64; 3]], fields: u32, half_field: [f64; 2]) -> Coverage {
    let mut random = SplitMix64::new(SEED);
    let (mut total, mut fewest, mut enough) = (0u64, [u32::MAX; 2], [[0u32; 3]; 2]);
    for _ in 0..fields {
        let counts = count(stars, &random.attitude(), half_field);
        total += u64::from(counts[0]);
        for disc in 0..2 {
            fewest[disc] = fewest[disc].min(counts[disc]);
            for (wanted, enough) in (3..).zip(&mut enough[disc]) {
                *enough += u32::from(counts[disc] >= wanted);
            }
        }
    }
    let share = |disc: usize| enough[disc].map(|enough| f64::from(enough) / f64::from(fields.max(1)));
    Coverage {
        fields,
        mean_stars: total as f64 / f64::from(fields.max(1)),
        fewest_stars: fewest[0],
        share: share(0),
        fewest_stars_with_earth: fewest[1],
        share_with_earth: share(1),
    }
}

/// Stars in the field whose axes are the rows of `[right, down, out]`: all, and those beside the Earth's
/// disc.
fn count(stars: &[[f64; 3]], [right, down, out]: &[[f64; 3]; 3], [half_x, half_y]: [f64; 2]) -> [u32; 2] {
    let dot = |[a, b, c]: &[f64; 3], [x, y, z]: &[f64; 3]| a * x + b * y + c * z;
    let mut counts = [0; 2];
    for star in stars {
        let depth = dot(out, star);
        // Cheap first: no star outside 45 degrees is in the field.
        if depth < 0.7 {
            continue;
        }
        let (x, y) = (dot(right, star) / depth, dot(down, star) / depth);
        if x.abs() <= half_x && y.abs() <= half_y {
            counts[0] += 1;
            counts[1] += u32::from(x * x + y * y > EARTH_RADIUS * EARTH_RADIUS);
        }
    }
    counts
}

/// The generator of Steele, Lea and Flood 2014 ("splitmix64"): a counter and a mixer, enough for statistics.
#[derive(Clone, Debug)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// A generator whose numbers follow from the seed alone.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 random bits.
    pub fn next_bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// Uniform in -1 to 1.
    pub fn symmetric(&mut self) -> f64 {
        (self.next_bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A uniform unit vector: points of the cube that lie in the ball, so no trigonometry is needed.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let point = [self.symmetric(), self.symmetric(), self.symmetric()];
            let square: f64 = point.iter().map(|x| x * x).sum();
            if (1e-6..=1.0).contains(&square) {
                return normalised(point);
            }
        }
    }

    /// A uniform attitude as the rows of a rotation matrix, from a uniform quaternion.
    pub fn attitude(&mut self) -> [[f64; 3]; 3] {
        loop {
            let point = [self.symmetric(), self.symmetric(), self.symmetric(), self.symmetric()];
            let square: f64 = point.iter().map(|x| x * x).sum();
            if (1e-6..=1.0).contains(&square) {
                let [x, y, z, w] = point.map(|component| component / square.sqrt());
                return [
                    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
                    [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
                    [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
                ];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_gives_the_published_numbers() {
        let mut random = SplitMix64::new(1_234_567);
        let published = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(published.map(|_| random.next_bits()), published);
    }

    #[test]
    fn the_mean_field_holds_its_share_of_evenly_spread_stars() {
        let mut random = SplitMix64::new(2);
        let stars: Vec<[f64; 3]> = (0..3000).map(|_| random.direction()).collect();
        let coverage = coverage(&stars, 4000, HALF_FIELD);
        // Solid angle of a rectangle seen from one focal length above its middle: 4 asin(a b / sqrt(...)).
        let [a, b] = HALF_FIELD;
        let solid_angle = 4.0 * libm::asin(a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt());
        let expected = 3000.0 * solid_angle / (4.0 * core::f64::consts::PI);
        assert!((coverage.mean_stars / expected - 1.0).abs() < 0.02, "{} {expected}", coverage.mean_stars);
    }

    #[test]
    fn an_empty_catalogue_covers_nothing() {
        let nothing = coverage(&[], 10, HALF_FIELD);
        assert_eq!((nothing.share, nothing.share_with_earth, nothing.fewest_stars), ([0.0; 3], [0.0; 3], 0));
    }
}
