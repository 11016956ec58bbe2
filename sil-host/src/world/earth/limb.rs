//! The profile across the limb: how bright a line of sight is that passes the Earth at a height, as the lens
//! blurs it.
//!
//! In: height `h` of the line's lowest point above where the limb stands, width `s` of the blur, both km.
//! Out: [`Blurred`]: the share of the brightness of the surface below, the mean depth of the line below the
//! limb, and the light of the night sky.
//!
//! `share(h) = C + (1 - C) b A(h)` above 0, 1 below: clouds hide what is behind them with `C = exp(-h /
//! h_c)`; where they do not, the air shines `b` times as bright as the surface where it is thick, `A = Σ w_i
//! (1 - exp(-τ_i(h)))`. The optical depth along the line is that of the lowest point's density and of the way
//! below the top, as in the thesis (eq. 4.1, 4.2), `τ(h) = τ_0 (2 pi R / H)^(1/2) exp(-h / H) ((top - h) /
//! top)^(1/2)`, for molecules with `H` of the model and for haze with 2 km. The band 500 to 900 nm is the sum
//! of three wavelengths with the Sun's photons as weights; vertical depths of molecules 0.0973, 0.0365,
//! 0.0166 at 550, 700 and 850 nm (Bodhaine et al. 1999), of haze 0.1 at 550 nm falling with λ^-1.3.
//!
//! Dusty air instead has one depth in all of the band, `EarthModel::dust_depth`, and one scale height.
//!
//! Night sky: a layer about 90 km, 8 km thick, whose photons in the band number 10 kR looking straight down
//! (OH, O2 and O lines: a usual night); a line along the limb passes 60 times as much of it. Relative to a
//! white surface under the Sun.
//!
//! A line that sweeps through heights sees their mean: the difference of the integrals of what it sees at
//! either end of its way.
//!
//! The blur is a Gaussian. Its convolution with the profile stands in tables, one for each of 64 widths an
//! octave, filled when first asked for; the nearest width is taken, between heights they are linear. Error:
//! below 2e-3 of the brightness of the surface, odd about the edge, so that this does not move, and 4e-3 s of
//! the depth.

use super::EarthModel;
use fsw_core::orbit::body::CentralBody;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Widths of the blur beyond which the profile is as without it.
pub const REACH_SIGMAS: f64 = 5.0;
/// Weight, molecules' and haze's vertical optical depth of a wavelength.
const BANDS: [(f64, f64, f64); 3] = [(0.362, 0.0973, 0.1), (0.349, 0.0365, 0.0731), (0.289, 0.0166, 0.0568)];
/// Height over which haze thins out, km.
const HAZE_SCALE_KM: f64 = 2.0;
/// The Earth's mean radius, km.
const RADIUS_KM: f64 = 6371.0;
/// Photons of the night sky looking straight down, rayleigh; a rayleigh is 1e10 / 4 pi photons/m²/s/sr.
const NIGHT_SKY_R: f64 = 1.0e4;
/// Middle and standard deviation of the layer, km.
const LAYER_KM: (f64, f64) = (90.0, 3.5);
/// Lowest height of the night sky's table, km.
const GLOW_LOW_KM: f64 = -200.0;
/// Narrowest and widest blur, km.
const SIGMA_KM: (f32, f32) = (0.125, 1000.0);
/// Bits of a width below those that count the levels of an octave (6).
const LEVEL_SHIFT: u32 = 23 - 6;
const LEVELS: usize = 13 * 64 + 1;
/// Entries of a table in a width of the blur.
const STEPS: f64 = 16.0;
/// Share of the surface's brightness below which none is left: a hundredth of an electron.
const LEAST_SHARE: f32 = 1e-5;
/// Points of the profile in an entry.
const FINE: u32 = 8;

/// What the blurred profile says of a line of sight.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Blurred {
    /// Share of the surface's brightness.
    pub share: f32,
    /// Mean of the line's depth below the limb, never negative, km. It takes the infinite slope from the
    /// edge, where a line's first point on the surface runs away.
    pub depth_km: f32,
    /// Light of the night sky, relative to a white surface with the Sun in the zenith.
    pub glow: f32,
}

/// The profile before the blur.
#[derive(Debug, Clone)]
pub struct Profile {
    /// Mean radius, km.
    radius_km: f64,
    dust_depth: f64,
    cloud_top_km: f64,
    air_brightness: f64,
    scale_km: f64,
    top_km: f64,
    /// Night sky from -200 km to the top, every km.
    glow: Vec<f64>,
}

/// The blurred profile for every width.
#[derive(Debug)]
pub struct Limb {
    profile: Profile,
    levels: Vec<OnceLock<Level>>,
}

/// A table for one width.
#[derive(Debug)]
struct Level {
    low_km: f32,
    per_km: f32,
    entries: Vec<Blurred>,
    /// Integral of the entries, linear in between, from the first to each: share, depth, light; steps.
    sums: Vec<[f64; 3]>,
}

impl Profile {
    /// That of `model`.
    pub fn new(model: &EarthModel) -> Self {
        let radius_km = match model.body {
            CentralBody::Earth => RADIUS_KM,
            body => body.facts().radius_km,
        };
        let mut profile = Self {
            radius_km,
            dust_depth: model.dust_depth,
            cloud_top_km: model.cloud_top_km,
            air_brightness: model.air_brightness,
            scale_km: model.scale_height_km,
            top_km: model.atmosphere_top_km,
            glow: Vec::new(),
        };
        let zenith = if model.airglow {
            let white = model.irradiance_w_m2.max(1e-9) / (PI * model.photon_j);
            NIGHT_SKY_R * 1e10 / (4.0 * PI) / white
        } else {
            0.0
        };
        let count = (GLOW_LOW_KM.abs() + profile.top_km) as usize + 2;
        profile.glow = (0..count).map(|k| zenith * passes(GLOW_LOW_KM + k as f64)).collect();
        profile
    }

    /// Share of the surface's brightness at a height, km.
    pub fn share(&self, h: f64) -> f64 {
        if h <= 0.0 {
            return 1.0;
        }
        if h >= self.top_km {
            return 0.0;
        }
        let clouds = libm::exp(-h / self.cloud_top_km);
        let slant = |scale: f64| libm::sqrt(2.0 * PI * self.radius_km / scale) * libm::exp(-h / scale);
        let chord = ((self.top_km - h) / self.top_km).sqrt();
        let (air, haze) = (slant(self.scale_km) * chord, slant(HAZE_SCALE_KM) * chord);
        if self.dust_depth > 0.0 {
            return clouds + (1.0 - clouds) * self.air_brightness * -libm::expm1(-air * self.dust_depth);
        }
        let shine = |(w, molecules, particles): (f64, f64, f64)| {
            w * -libm::expm1(-(air * molecules + haze * particles))
        };
        clouds + (1.0 - clouds) * self.air_brightness * BANDS.map(shine).iter().sum::<f64>()
    }

    fn glow(&self, h: f64) -> f64 {
        if h >= self.top_km {
            return 0.0;
        }
        let at = (h - GLOW_LOW_KM).clamp(0.0, (self.glow.len() - 2) as f64);
        let index = at as usize;
        self.glow[index] + (at - index as f64) * (self.glow[index + 1] - self.glow[index])
    }
}

/// How many times the layer's vertical light a line collects whose lowest point is at `h` km.
fn passes(h: f64) -> f64 {
    const STEP_KM: f64 = 5.0;
    let (middle, deviation) = LAYER_KM;
    let lowest = RADIUS_KM + h;
    let light = |k: i32| {
        let s = (f64::from(k) + 0.5) * STEP_KM;
        let t = ((lowest * lowest + s * s).sqrt() - RADIUS_KM - middle) / deviation;
        libm::exp(-0.5 * t * t)
    };
    let one_way = (0..420).map(light).sum::<f64>() * STEP_KM / (deviation * libm::sqrt(2.0 * PI));
    // The Earth hides what is behind it.
    if h < 0.0 { one_way } else { 2.0 * one_way }
}

impl Limb {
    /// Tables of `model`, still empty.
    pub fn new(model: &EarthModel) -> Self {
        let levels = (0..LEVELS).map(|_| OnceLock::new()).collect();
        Self { profile: Profile::new(model), levels }
    }

    /// The profile before the blur.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The profile at heights, blurred by `sigmas_km` and swept by `moved_km` about them: takes heights in
    /// km, and gives depths, shares and the night sky's light ([`Blurred`]).
    pub fn read(&self, [sigmas_km, moved_km]: [&[f32]; 2], [heights_km, shares, glows]: [&mut [f32]; 3]) {
        let Some(first) = sigmas_km.first() else { return };
        let mut last = level_of(*first);
        let mut level = self.level(last);
        let places = heights_km.iter_mut().zip(shares).zip(glows);
        for ((sigma_km, moved_km), ((height_km, share), glow)) in sigmas_km.iter().zip(moved_km).zip(places) {
            let number = level_of(*sigma_km);
            if number != last {
                (level, last) = (self.level(number), number);
            }
            let blurred = level.swept(*height_km, *moved_km);
            (*height_km, *share, *glow) = (blurred.depth_km, blurred.share, blurred.glow);
        }
    }

    #[inline]
    fn level(&self, level: usize) -> &Level {
        let level = level.min(LEVELS - 1);
        self.levels[level].get_or_init(|| self.profile.blurred(level))
    }
}

/// Number of the level that is nearest to a width.
#[inline]
fn level_of(sigma_km: f32) -> usize {
    const HALF: u32 = 1 << (LEVEL_SHIFT - 1);
    let bits = sigma_km.clamp(SIGMA_KM.0, SIGMA_KM.1).to_bits() - SIGMA_KM.0.to_bits() + HALF;
    (bits >> LEVEL_SHIFT) as usize
}

impl Blurred {
    fn parts(self) -> [f64; 3] {
        [self.share, self.depth_km, self.glow].map(f64::from)
    }

    #[inline]
    fn towards(self, other: Self, part: f32) -> Self {
        Self {
            share: self.share + part * (other.share - self.share),
            depth_km: self.depth_km + part * (other.depth_km - self.depth_km),
            glow: self.glow + part * (other.glow - self.glow),
        }
    }
}

impl Level {
    #[inline]
    fn at(&self, height_km: f32) -> Blurred {
        let place = (height_km - self.low_km) * self.per_km;
        if place < 0.0 {
            return Blurred { share: 1.0, depth_km: -height_km, glow: self.entries[0].glow };
        }
        let index = (place as i32 as usize).min(self.entries.len() - 2);
        let [near, far] = [self.entries[index], self.entries[index + 1]];
        near.towards(far, (place - index as i32 as f32).min(1.0))
    }

    /// The mean over a way of `moved_km` about a height.
    #[inline]
    fn swept(&self, height_km: f32, moved_km: f32) -> Blurred {
        // Shorter than four entries: a quarter of the blur's width, which it hardly widens.
        let steps = f64::from(moved_km * self.per_km);
        if steps < 4.0 {
            return self.at(height_km);
        }
        let middle = f64::from((height_km - self.low_km) * self.per_km);
        let [low, high] = [middle - 0.5 * steps, middle + 0.5 * steps].map(|place| self.sum(place));
        let [share, depth_km, glow] = [0, 1, 2].map(|k| ((high[k] - low[k]) / steps) as f32);
        Blurred { share: if share < LEAST_SHARE { 0.0 } else { share }, depth_km, glow }
    }

    /// The integral from the first entry to a place, both in steps.
    fn sum(&self, place: f64) -> [f64; 3] {
        if place < 0.0 {
            // Below, all is light of the surface, as deep as the line lies.
            let deep_km = -f64::from(self.low_km) - 0.5 * place / f64::from(self.per_km);
            return [place, place * deep_km, place * f64::from(self.entries[0].glow)];
        }
        let index = (place as usize).min(self.entries.len() - 2);
        let part = (place - index as f64).min(1.0);
        let [near, far] = [self.entries[index], self.entries[index + 1]].map(Blurred::parts);
        let sum = self.sums[index];
        [0, 1, 2].map(|k| sum[k] + part * (near[k] + 0.5 * part * (far[k] - near[k])))
    }
}

impl Profile {
    /// The table of a level: sums over the Gaussian out to six widths, [`STEPS`] of them a width.
    #[cold]
    fn blurred(&self, level: usize) -> Level {
        let sigma = f64::from(f32::from_bits(((level as u32) << LEVEL_SHIFT) + SIGMA_KM.0.to_bits()));
        let step = sigma / STEPS;
        let reach = 6 * STEPS as usize;
        let low_km = -REACH_SIGMAS * sigma;
        let count = ((2.0 * REACH_SIGMAS * sigma + self.top_km) / step) as usize + 3;
        let heights = (0..count + 2 * reach).map(|k| low_km + (k as f64 - reach as f64) * step);
        // A step may be as long as a cloud is high: its mean, not its middle.
        let mean = |h: f64, of: &dyn Fn(f64) -> f64| {
            (0..FINE).map(|k| of(h + step * ((f64::from(k) + 0.5) / f64::from(FINE) - 0.5))).sum::<f64>()
                / f64::from(FINE)
        };
        let samples: Vec<[f64; 3]> = heights
            .map(|h| [mean(h, &|h| self.share(h)), mean(h, &|h| (-h).max(0.0)), self.glow(h)])
            .collect();
        let mut weights: Vec<f64> = (0..=2 * reach)
            .map(|k| (k as f64 - reach as f64) / STEPS)
            .map(|t| libm::exp(-0.5 * t * t))
            .collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        let mut entries: Vec<Blurred> = samples
            .windows(weights.len())
            .map(|window| {
                let mut sums = [0.0; 3];
                for (sample, weight) in window.iter().zip(&weights) {
                    (0..3).for_each(|k| sums[k] += weight * sample[k]);
                }
                let [share, depth_km, glow] = sums.map(|sum| sum as f32);
                let share = if share < LEAST_SHARE { 0.0 } else { share };
                Blurred { share, depth_km, glow }
            })
            .collect();
        // Nothing is left five widths above the top, so that what lies further out need not be looked at.
        if let Some(last) = entries.last_mut() {
            *last = Blurred::default();
        }
        let mut sums = vec![[0.0; 3]];
        for ends in entries.windows(2) {
            let (near, far, sum) = (ends[0].parts(), ends[1].parts(), sums[sums.len() - 1]);
            sums.push([0, 1, 2].map(|k| sum[k] + 0.5 * (near[k] + far[k])));
        }
        Level { low_km: low_km as f32, per_km: (1.0 / step) as f32, entries, sums }
    }
}

#[cfg(test)]
mod tests;
