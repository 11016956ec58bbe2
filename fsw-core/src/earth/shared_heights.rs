//! Heights that neighbouring limb points share.
//!
//! A point's own sigma covers its measurement and the scatter of the limb from one point to the next.
//! Besides, clouds and air masses raise the limb by kilometres over hundreds to thousands of kilometres,
//! and oblique sunlight shifts the half-brightness point over long arcs. Over a long arc these errors
//! average out; over a short one they appear as a change of radius and move the centre by many sigmas of
//! the points without any effect on the residuals.
//!
//! In: the fitted limb, and the fit's sensitivity to the displacement of a point. Out: the covariance of
//! the unknowns by these heights. They are modelled as a Fourier series in the azimuth about the centre, up
//! to [`MODES`] waves a turn, of the variance
//!
//! `σ_k² = σ² s_k / Σ s`, `s_0 = 1`, `s_k = 2 (1 + (k L / ρ)²)^(-3/2)`
//!
//! for cosine and sine alike: a field of the standard deviation `σ` whose correlation over the distance `d`
//! is `x K₁(x)`, `x = d / L` (Matérn's of order one: 0.6 at `L`), along a circle of the radius `ρ`, the
//! limb's. Shorter waves are covered by the points' own sigmas. There are two such fields: the heights
//! themselves, and the shift of the half-brightness point by clouds, which for a limb narrower than a pixel
//! is a fraction of a pixel and decreases with the limb's width. The variance of the limb's mean height is
//! added to the mean. Where the Sun is not known, the effect of oblique light is added to mean and first
//! wave: at noon it shifts the whole disc towards the Sun and shrinks it. Test: `shared_heights/tests.rs`;
//! fitted to `sil-host campaign earth` with seeds 1 and 2, evaluated with other seeds.
//!
//! Cost: 18 operations a point and wave, 20,000 for 24 points.

use super::EarthParameters;
use super::rays::Cone;
use super::shape::Body;
use crate::matrix::add_product_transposed;
use nalgebra::{Matrix3, Vector3};

/// Waves around the limb; the shortest are 570 km long in LEO, 1250 km in GEO.
pub(super) const MODES: usize = 32;

/// Power spectrum of a height field along a limb.
struct HeightField {
    /// `σ²`, of the angle at the limb, rad².
    variance: f32,
    /// `(L / ρ)²`.
    stiffness: f32,
}

impl HeightField {
    /// Unnormalised share of a wave.
    fn share(&self, wave: usize) -> f32 {
        let damping = 1.0 + self.stiffness * (wave * wave) as f32;
        let both_ways = if wave == 0 { 1.0 } else { 2.0 };
        both_ways / (damping * libm::sqrtf(damping))
    }
}

/// Height errors that neighbouring points share. Variances are of the angle at the limb, rad².
pub(super) struct SharedHeights {
    /// Of the heights, and of the shift by clouds.
    fields: [HeightField; 2],
    /// Additional variance of the mean height.
    mean: f32,
    /// Additional variance of mean and first wave where the Sun is not known.
    sunless: f32,
}

impl SharedHeights {
    /// Along the limb of `cone`, in an image of `rad_per_px`.
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

/// Sensitivity of the unknowns of a fit to the cosine and sine of every wave of height.
pub(super) struct FitResponse {
    waves: [[Vector3<f32>; 2]; MODES],
}

impl Default for FitResponse {
    fn default() -> Self {
        Self { waves: [[Vector3::zeros(); 2]; MODES] }
    }
}

impl FitResponse {
    /// Adds a point: `azimuth` by cosine and sine, `gain` the change of the unknowns per radian of its
    /// displacement.
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
