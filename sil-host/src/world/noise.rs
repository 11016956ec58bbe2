//! Counter-based noise: every number is a pure function of (seed, cycle, stream, x, y).
//!
//! No state is carried from one number to the next, so a window of a frame drawn alone equals the same window
//! of the whole frame to the bit, frames can be drawn in any order and on any machine, and `libm` instead of
//! the system's mathematics keeps the bits the same everywhere.
//!
//! A 64-bit key is made from (seed, cycle, stream); a number is the place `y 2³² + x`, whitened with the key
//! and put twice through a bijective mixer of multiplications and shifts with constants of the SplitMix and
//! Murmur families. The Gaussian is the inverse normal distribution ([`inverse_normal`]) of one uniform
//! number. Poisson numbers below a mean of [`POISSON_EXACT_BELOW`] are the inverse distribution, exact but
//! for the cut at [`POISSON_TERMS_MAX`] (probability < 1e-20); above it the Gaussian with the first skewness
//! term of Cornish and Fisher, rounded to whole events, whose distribution function is off by at most 0.00044
//! (at a mean of 30; 0.00003 at 400).
//!
//! A pixel's electrons ([`Noise::read_row`]) are a Poisson number and the readout's Gaussian. Where their
//! variance is [`POISSON_EXACT_BELOW`] or more and the readout is wider than [`JOINED_READ_E`], both come
//! from one deviate `g`: `mean + s g + mean (g² - 1) / 6 s²`, `s² = mean + read²`, as the third cumulant of
//! the sum is the mean; the distribution function is off by at most 0.0006 (no readout to speak of), below
//! 2e-5 with the 20 e- of the reference.

use super::normal::{self, QuickInverse, inverse_normal};

/// What a number is drawn for; different streams are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// Photons and dark current.
    Photon = 1,
    /// Readout.
    Read = 2,
    /// Places and rates of hot pixels.
    HotPixel = 3,
    /// Tracks of protons.
    Proton = 4,
    /// Places and magnitudes of false stars.
    FalseStar = 5,
    /// Attitudes of centroid fields.
    Attitude = 6,
    /// Errors of centroids.
    Centroid = 7,
    /// Order of centroids.
    Shuffle = 8,
    /// Clouds, land and sea.
    Albedo = 9,
    /// Gain of pixels.
    Gain = 20,
    /// Dark current of pixels.
    Dark = 21,
    /// Offsets of columns.
    Column = 22,
    /// Offsets of rows, new in each cycle.
    Row = 23,
    /// Pixels that say nothing.
    DeadPixel = 24,
    /// Number of protons.
    ProtonCount = 25,
    /// Faults of the detector.
    Fault = 30,
    /// Other satellites.
    Satellite = 31,
    /// Bits of the flight code's memory that are turned over.
    Upset = 32,
    /// Pointing errors.
    Jitter = 40,
    /// Errors of the rate sensor.
    RateSensor = 41,
    /// Errors of the magnetometer.
    Magnetometer = 42,
    /// Errors of the orbit that the ground tells at the start.
    GroundStart = 43,
    /// Keys of a scenario that a campaign draws.
    Variation = 50,
}

/// Mean from which on Poisson numbers come from the Gaussian.
pub const POISSON_EXACT_BELOW: f64 = 30.0;
/// Standard deviation of the readout, e-, above which whole events cannot be distinguished: the steps of the
/// distribution are down to `exp(-2 pi²)` of themselves.
pub const JOINED_READ_E: f64 = 1.0;
/// Bound of the loop for the exact Poisson numbers.
pub const POISSON_TERMS_MAX: u32 = 128;
/// Pixels of a row that are drawn together.
const ROW_PART: usize = 64;

/// The noise of one seed, cycle and stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Noise {
    key: u64,
}

impl Noise {
    /// The noise of `stream` in `cycle` of the run `seed`.
    pub fn new(seed: u64, cycle: u64, stream: Stream) -> Self {
        let key = mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15));
        let key = mix(key ^ cycle.wrapping_mul(0xd1b5_4a32_d192_ed03));
        Self { key: mix(key.wrapping_add((stream as u64).wrapping_mul(0x8cb9_2ba7_2f3d_8dd7))) }
    }

    /// Independent noise for one of several parts of what the stream is for.
    pub fn part(&self, index: u64) -> Self {
        Self { key: mix(self.key ^ mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15))) }
    }

    /// 64 random bits for the place (x, y).
    #[inline]
    pub fn bits(&self, x: u32, y: u32) -> u64 {
        let place = u64::from(y) << 32 | u64::from(x);
        mix(mix(place ^ self.key).wrapping_add(self.key.rotate_left(32)))
    }

    /// Uniform in (0, 1), ends excluded, 52 bits.
    #[inline]
    pub fn uniform(&self, x: u32, y: u32) -> f64 {
        normal::uniform(self.bits(x, y))
    }

    /// Gaussian with mean 0 and variance 1.
    #[inline]
    pub fn gaussian(&self, x: u32, y: u32) -> f64 {
        inverse_normal(self.uniform(x, y))
    }

    /// The same to 5e-7 in its distribution function, from a table.
    #[inline]
    pub fn quick_gaussian(&self, x: u32, y: u32) -> f64 {
        QuickInverse::table().at(self.bits(x, y))
    }

    /// Number of events where `mean` are expected; 0 for a mean that is not positive.
    #[inline]
    pub fn poisson(&self, x: u32, y: u32, mean: f64) -> f64 {
        let uniform = self.uniform(x, y);
        if mean >= POISSON_EXACT_BELOW {
            let g = inverse_normal(uniform);
            // Square root and conversion are exact on every machine; both are far quicker than a call.
            let count = mean + mean.sqrt() * g + (g * g - 1.0) / 6.0;
            return (count + 0.5) as u64 as f64;
        }
        if mean > 0.0 { inverse_poisson(uniform, mean) } else { 0.0 }
    }

    /// Electrons read from pixels of a row, from (`x`, `y`) on, in which `pixels` are expected: Poisson
    /// numbers of this noise and Gaussians of standard deviation `read_e`, from `readout` where the two are
    /// not one.
    pub fn read_row(&self, (x, y): (u32, u32), pixels: &mut [f64], readout: &Self, read_e: f64) {
        let read_e2 = read_e * read_e;
        let quick = QuickInverse::table();
        let mut deviates = [0.0; ROW_PART];
        for (x, part) in (x..).step_by(ROW_PART).zip(pixels.chunks_mut(ROW_PART)) {
            // Any sign among the bits: a mean below 0.
            let signs = part.iter().fold(0, |signs, mean| signs | mean.to_bits());
            if read_e < JOINED_READ_E || read_e2 < POISSON_EXACT_BELOW || signs >> 63 == 1 {
                for (x, pixel) in (x..).zip(part) {
                    *pixel = self.electrons(x, y, *pixel, readout, read_e);
                }
                continue;
            }
            for (x, deviate) in (x..).zip(&mut deviates[..part.len()]) {
                *deviate = quick.at(self.bits(x, y));
            }
            for (pixel, g) in part.iter_mut().zip(&deviates) {
                *pixel = both(*pixel, *pixel + read_e2, *g);
            }
        }
    }

    /// [`Self::read_row`] for a single pixel.
    fn electrons(&self, x: u32, y: u32, mean: f64, readout: &Self, read_e: f64) -> f64 {
        let variance = mean + read_e * read_e;
        if read_e >= JOINED_READ_E && variance >= POISSON_EXACT_BELOW && mean >= 0.0 {
            return both(mean, variance, self.quick_gaussian(x, y));
        }
        self.apart(x, y, mean, readout, read_e)
    }

    #[cold]
    #[inline(never)]
    fn apart(&self, x: u32, y: u32, mean: f64, readout: &Self, read_e: f64) -> f64 {
        self.poisson(x, y, mean) + read_e * readout.gaussian(x, y)
    }
}

/// Photons and readout together, by one deviate.
#[inline]
fn both(mean: f64, variance: f64, g: f64) -> f64 {
    mean + variance.sqrt() * g + mean / (6.0 * variance) * (g * g - 1.0)
}

/// Bijective: every bit of the input reaches every bit of the output.
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 32).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 29).wrapping_mul(0xff51_afd7_ed55_8ccd);
    z ^ z >> 32
}

/// Smallest count whose distribution function reaches `uniform`.
fn inverse_poisson(uniform: f64, mean: f64) -> f64 {
    let mut term = libm::exp(-mean);
    let mut sum = term;
    let mut count = 0;
    while uniform > sum && count < POISSON_TERMS_MAX {
        count += 1;
        term *= mean / f64::from(count);
        sum += term;
    }
    f64::from(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: u32 = 256;

    fn samples(draw: impl Fn(u32, u32) -> f64) -> Vec<f64> {
        (0..SIDE * SIDE).map(|i| draw(i % SIDE, i / SIDE)).collect()
    }

    fn moments(values: &[f64]) -> (f64, f64) {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0))
    }

    /// Chi-square of counts against expected ones, as a normal deviate (Wilson and Hilferty).
    fn chi_square_deviate(observed: &[f64], expected: &[f64]) -> f64 {
        let chi: f64 = observed.iter().zip(expected).map(|(o, e)| (o - e).powi(2) / e).sum();
        let d = observed.len() as f64 - 1.0;
        ((chi / d).cbrt() - (1.0 - 2.0 / (9.0 * d))) / (2.0 / (9.0 * d)).sqrt()
    }

    // The deviates below have a fixed seed; a correct generator passes 4 sigma with probability 0.99994 each.
    #[test]
    fn uniform_numbers_fill_their_range_evenly_and_neighbours_know_nothing_of_each_other() {
        for (seed, cycle) in [(0, 0), (0, 1), (1, 0), (u64::MAX, 77)] {
            let noise = Noise::new(seed, cycle, Stream::Photon);
            let values = samples(|x, y| noise.uniform(x, y));
            let mut bins = [0.0; 256];
            values.iter().for_each(|v| bins[(v * 256.0) as usize] += 1.0);
            let deviate = chi_square_deviate(&bins, &[256.0; 256]);
            assert!(deviate.abs() < 4.0, "chi-square deviate {deviate}");
            for lag in [1, 2, SIDE as usize, SIDE as usize + 1] {
                let pairs = values.iter().zip(&values[lag..]);
                let sum: f64 = pairs.map(|(a, b)| 12.0 * (a - 0.5) * (b - 0.5)).sum();
                let deviate = sum / ((values.len() - lag) as f64).sqrt();
                assert!(deviate.abs() < 4.0, "lag {lag}: {deviate}");
            }
        }
    }

    #[test]
    fn streams_cycles_and_seeds_are_independent() {
        let base = Noise::new(5, 9, Stream::Photon);
        let others = [
            Noise::new(6, 9, Stream::Photon),
            Noise::new(5, 10, Stream::Photon),
            Noise::new(5, 9, Stream::Read),
        ];
        for other in others {
            let products = samples(|x, y| base.gaussian(x, y) * other.gaussian(x, y));
            let deviate = products.iter().sum::<f64>() / f64::from(SIDE);
            assert!(deviate.abs() < 4.0, "{deviate}");
        }
    }

    #[test]
    fn every_bit_is_fair() {
        let noise = Noise::new(3, 1, Stream::Read);
        for bit in 0..64 {
            let ones = (0..SIDE * SIDE).filter(|i| noise.bits(i % SIDE, i / SIDE) >> bit & 1 == 1).count();
            let deviate = (ones as f64 - 32_768.0) / 128.0;
            assert!(deviate.abs() < 4.5, "bit {bit}: {deviate}");
        }
    }

    #[test]
    fn gaussian_numbers_have_mean_zero_and_variance_one() {
        let noise = Noise::new(42, 3, Stream::Read);
        let (mean, variance) = moments(&samples(|x, y| noise.gaussian(x, y)));
        let count = f64::from(SIDE * SIDE);
        assert!((mean * count.sqrt()).abs() < 4.0, "{mean}");
        assert!(((variance - 1.0) * (count / 2.0).sqrt()).abs() < 4.0, "{variance}");
    }

    #[test]
    fn small_poisson_numbers_follow_the_distribution() {
        for mean in [0.5, 5.0, 20.0] {
            let noise = Noise::new(8, 0, Stream::Photon);
            let values = samples(|x, y| noise.poisson(x, y, mean));
            let mut expected = Vec::new();
            let mut observed = Vec::new();
            let mut probability = libm::exp(-mean);
            for count in 0..60u32 {
                if count > 0 {
                    probability *= mean / f64::from(count);
                }
                if probability * values.len() as f64 > 10.0 {
                    expected.push(probability * values.len() as f64);
                    observed.push(values.iter().filter(|v| **v == f64::from(count)).count() as f64);
                }
            }
            // What is left over makes a last cell.
            expected.push(values.len() as f64 - expected.iter().sum::<f64>());
            observed.push(values.len() as f64 - observed.iter().sum::<f64>());
            let deviate = chi_square_deviate(&observed, &expected);
            assert!(deviate.abs() < 4.0, "mean {mean}: {deviate}");
        }
    }

    #[test]
    fn large_poisson_numbers_have_the_right_mean_and_variance() {
        for mean in [30.0, 400.0, 1e6] {
            let noise = Noise::new(8, 1, Stream::Photon);
            let (got, variance) = moments(&samples(|x, y| noise.poisson(x, y, mean)));
            let count = f64::from(SIDE * SIDE);
            assert!(((got - mean) / (mean / count).sqrt()).abs() < 4.0, "{mean}: mean {got}");
            // Rounding to whole events adds 1/12, the skewness term 1/18.
            let expected = mean + 1.0 / 12.0 + 1.0 / 18.0;
            assert!((variance / expected - 1.0).abs() < 4.0 * (2.0 / count).sqrt(), "{mean}: {variance}");
        }
    }

    /// Distribution of a Poisson number of `mean` plus a Gaussian of `read_e`, at `x`.
    fn exact_below(mean: f64, read_e: f64, x: f64) -> f64 {
        let mut term = libm::exp(-mean);
        let mut sum = 0.0;
        for count in 0..(mean + 12.0 * mean.sqrt() + 30.0) as u32 {
            if count > 0 {
                term *= mean / f64::from(count);
            }
            let t = (x - f64::from(count)) / read_e;
            sum += term * 0.5 * libm::erfc(-t / std::f64::consts::SQRT_2);
        }
        sum
    }

    #[test]
    fn one_deviate_for_photons_and_readout_follows_their_joint_distribution() {
        for (mean, read_e, limit) in [
            (30.0, 1.0, 6e-4),
            (400.0, 1.0, 6e-5),
            (0.5, 20.0, 2e-5),
            (30.0, 20.0, 2e-5),
            (320.0, 20.0, 2e-5),
        ] {
            let mut worst = 0.0f64;
            for k in 1..2000 {
                let p = f64::from(k) / 2000.0;
                let (g, variance): (f64, f64) = (inverse_normal(p), mean + read_e * read_e);
                let value = both(mean, variance, g);
                worst = worst.max((exact_below(mean, read_e, value) - p).abs());
            }
            println!("mean {mean}, read {read_e}: {worst:.1e}");
            assert!(worst < limit, "{mean} {read_e}: {worst}");
        }
    }

    #[test]
    fn electrons_have_the_moments_of_photons_and_readout() {
        for (mean, read_e) in [(3.0, 0.0), (3.0, 0.5), (3.0, 20.0), (320.0, 20.0), (2e4, 20.0)] {
            let photon = Noise::new(4, 4, Stream::Photon);
            let readout = Noise::new(4, 4, Stream::Read);
            let (got, variance) = moments(&samples(|x, y| photon.electrons(x, y, mean, &readout, read_e)));
            let (count, expected) = (f64::from(SIDE * SIDE), mean + read_e * read_e);
            assert!(((got - mean) / (expected / count).sqrt()).abs() < 4.0, "{mean} {read_e}: {got}");
            // Fourth cumulant of a Poisson number: its mean.
            let spread = ((2.0 + mean / (expected * expected)) / count).sqrt();
            assert!((variance / expected - 1.0).abs() < 4.0 * spread + 1e-3, "{mean} {read_e}: {variance}");
        }
    }

    #[test]
    fn nothing_comes_of_nothing() {
        let noise = Noise::new(0, 0, Stream::Photon);
        assert_eq!(noise.poisson(1, 2, 0.0), 0.0);
        assert_eq!(noise.poisson(1, 2, -1.0), 0.0);
        assert_eq!(noise.poisson(1, 2, f64::NAN), 0.0);
    }
}
