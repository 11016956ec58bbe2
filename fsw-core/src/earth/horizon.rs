//! Heights that neighbouring limb points share.
//!
//! A point's own sigma says how well its place is measured, and how the limb scatters from one point to the next. Clouds and air
//! masses lift the limb by kilometres over hundreds and thousands of kilometres besides, and a slant of the light moves half its
//! brightness alike. Over a long arc that is averaged out; over a short one it looks like another radius, and the centre moves by
//! many sigmas of the points, the residuals being as small as ever.
//!
//! In: the fitted limb, and how the fit answers to a point that is displaced. Out: the covariance of its unknowns for such heights.
//! They are a Fourier series in the azimuth about the centre, up to [`MODES`] waves a turn, of the variance
//!
//! `σ_k² = σ² s_k / Σ s`, `s_0 = 1`, `s_k = 2 (1 + (k L / ρ)²)^(-3/2)`
//!
//! for cosine and sine alike: a field of the standard deviation `σ` whose correlation over the distance `d` is `x K₁(x)`, `x = d / L`
//! (Matérn's of order one: 0.6 at `L`), along a circle of the radius `ρ`, the limb's. Waves shorter than the last are left to the
//! points' own sigmas. Test: `horizon/tests.rs`.
//!
//! Cost: 18 operations a point and wave, 20,000 for 24 points.

use super::EarthParameters;
use super::rays::Cone;
use super::shape::Body;
use nalgebra::{Matrix3, Vector3};

/// Waves about the whole limb: 570 km in a low orbit, 1250 km in the geostationary one are the shortest.
pub(super) const MODES: usize = 32;

/// Heights along a limb, by wave.
pub(super) struct Horizon {
    /// Standard deviation, rad at the limb.
    sigma_rad: f32,
    /// `(L / ρ)²`.
    stiffness: f32,
}

impl Horizon {
    /// Along the limb of this cone.
    pub(super) fn new(cone: &Cone, body: &Body, parameters: &EarthParameters) -> Self {
        // Distance and radius of the limb; both sine and cosine are positive.
        let distance_km = body.radius_km() * cone.cosine / cone.sine;
        let length = parameters.horizon_cell_km / (body.radius_km() * cone.cosine);
        Self { sigma_rad: parameters.horizon_sigma_km / distance_km, stiffness: length * length }
    }

    /// Share of a wave, not yet of the sum.
    fn share(&self, wave: usize) -> f32 {
        let damping = 1.0 + self.stiffness * (wave * wave) as f32;
        let both_ways = if wave == 0 { 1.0 } else { 2.0 };
        both_ways / (damping * libm::sqrtf(damping))
    }
}

/// How the unknowns of a fit answer to a wave of height, by its cosine and its sine.
pub(super) struct Response {
    waves: [[Vector3<f32>; 2]; MODES],
}

impl Default for Response {
    fn default() -> Self {
        Self { waves: [[Vector3::zeros(); 2]; MODES] }
    }
}

impl Response {
    /// Takes in a point whose azimuth has this cosine and sine, by which the unknowns change by `gain` for a radian.
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
    pub(super) fn covariance(&self, horizon: &Horizon) -> Matrix3<f32> {
        let (mut sum, mut shares) = (Matrix3::zeros(), 0.0);
        for (wave, [cosine, sine]) in self.waves.iter().enumerate() {
            let share = horizon.share(wave);
            sum += (cosine * cosine.transpose() + sine * sine.transpose()) * share;
            shares += share;
        }
        // The first share is one.
        sum * (horizon.sigma_rad * horizon.sigma_rad / shares)
    }
}

#[cfg(test)]
mod tests;
