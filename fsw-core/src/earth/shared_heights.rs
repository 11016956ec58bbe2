//! Heights that neighbouring limb points share.
//!
//! A point's own sigma says how well its place is measured, and how the limb scatters from one point to the
//! next. Clouds and air masses lift the limb by kilometres over hundreds and thousands of kilometres besides,
//! and a slant of the light moves half its brightness alike. Over a long arc that is averaged out; over a
//! short one it looks like another radius, and the centre moves by many sigmas of the points, the residuals
//! being as small as ever.
//!
//! In: the fitted limb, and how the fit answers to a point that is displaced. Out: the covariance of its
//! unknowns for such heights. They are a Fourier series in the azimuth about the centre, up to [`MODES`]
//! waves a turn, of the variance
//!
//! `σ_k² = σ² s_k / Σ s`, `s_0 = 1`, `s_k = 2 (1 + (k L / ρ)²)^(-3/2)`
//!
//! for cosine and sine alike: a field of the standard deviation `σ` whose correlation over the distance `d`
//! is `x K₁(x)`, `x = d / L` (Matérn's of order one: 0.6 at `L`), along a circle of the radius `ρ`, the
//! limb's. Waves shorter than the last are left to the points' own sigmas. There are two such fields: the
//! heights themselves, and what clouds do to the place of half brightness in a limb no wider than a pixel,
//! which is a part of a pixel, and less the wider the limb is. To the mean is added what is not known of the
//! limb's mean height; to mean and first wave what the slant of the light does where the Sun is not known: at
//! noon it draws the whole disc towards the Sun and makes it smaller. Test: `shared_heights/tests.rs`; fitted to the
//! frames of `sil-host campaign earth` of the seeds 1 and 2, and judged by those of others.
//!
//! Cost: 18 operations a point and wave, 20,000 for 24 points.

use super::EarthParameters;
use super::rays::Cone;
use super::shape::Body;
use crate::matrix::add_product_transposed;
use nalgebra::{Matrix3, Vector3};

/// Waves about the whole limb: 570 km in a low orbit, 1250 km in the geostationary one are the shortest.
pub(super) const MODES: usize = 32;

/// A field along a limb, by wave.
struct HeightField {
    /// `σ²`, of the angle at the limb, rad².
    variance: f32,
    /// `(L / ρ)²`.
    stiffness: f32,
}

impl HeightField {
    /// Share of a wave, not yet of the sum.
    fn share(&self, wave: usize) -> f32 {
        let damping = 1.0 + self.stiffness * (wave * wave) as f32;
        let both_ways = if wave == 0 { 1.0 } else { 2.0 };
        both_ways / (damping * libm::sqrtf(damping))
    }
}

/// What neighbours share along a limb. Variances are of the angle at the limb, rad².
pub(super) struct SharedHeights {
    /// Heights, and what clouds do.
    fields: [HeightField; 2],
    /// Variance of the mean height besides.
    mean: f32,
    /// Variance of mean and first wave besides.
    sunless: f32,
}

impl SharedHeights {
    /// Along the limb of this cone, seen in pixels of `rad_per_px`.
    pub(super) fn new(cone: &Cone, body: &Body, rad_per_px: f32, parameters: &EarthParameters) -> Self {
        // Distance and radius of the limb; both sine and cosine are positive.
        let distance_km = body.radius_km() * cone.cosine / cone.sine;
        let square = |number: f32| number * number;
        let field = |cell_km: f32, sigma_rad: f32| HeightField {
            variance: square(sigma_rad),
            stiffness: square(cell_km / (body.radius_km() * cone.cosine)),
        };
        let clouds =
            parameters.horizon.sigma_px * rad_per_px / parameters.clouds_reduction(distance_km * rad_per_px);
        let sunless_px = if body.has_sun() { 0.0 } else { parameters.horizon.sunless_px };
        Self {
            fields: [
                field(parameters.horizon.cell_km, parameters.horizon.sigma_km / distance_km),
                field(parameters.horizon.cloud_cell_km, clouds),
            ],
            mean: square(parameters.limb.height_sigma_km / distance_km),
            sunless: square(sunless_px * rad_per_px),
        }
    }
}

impl SharedHeights {
    /// Variance of every wave.
    fn variances(&self) -> [f32; MODES] {
        let mut variances = [0.0; MODES];
        for field in &self.fields {
            let shares: f32 = (0..MODES).map(|wave| field.share(wave)).sum();
            let scale = field.variance / shares;
            for (wave, variance) in variances.iter_mut().enumerate() {
                *variance += scale * field.share(wave);
            }
        }
        for (variance, more) in variances.iter_mut().zip([self.mean + self.sunless, self.sunless]) {
            *variance += more;
        }
        variances
    }
}

/// How the unknowns of a fit answer to a wave of height, by its cosine and its sine.
pub(super) struct FitResponse {
    waves: [[Vector3<f32>; 2]; MODES],
}

impl Default for FitResponse {
    fn default() -> Self {
        Self { waves: [[Vector3::zeros(); 2]; MODES] }
    }
}

impl FitResponse {
    /// Takes in a point whose azimuth has this cosine and sine, by which the unknowns change by `gain` for a
    /// radian.
    pub(super) fn add(&mut self, azimuth: [f32; 2], gain: &Vector3<f32>) {
        let [c1, s1] = azimuth;
        let [mut c, mut s] = [1.0, 0.0];
        for [cosine, sine] in &mut self.waves {
            *cosine += gain * c;
            *sine += gain * s;
            [c, s] = [c * c1 - s * s1, s * c1 + c * s1];
        }
    }

    /// The covariance of the unknowns.
    pub(super) fn covariance(&self, heights: &SharedHeights) -> Matrix3<f32> {
        let mut sum = Matrix3::zeros();
        for (both, variance) in self.waves.iter().zip(heights.variances()) {
            for gain in both {
                add_product_transposed(&mut sum, &(gain * variance), gain);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests;
