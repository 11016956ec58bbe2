//! Covariance of position and velocity as it is told.
//!
//! The filter's covariance is that of small errors. Long ones lie along the orbit, not along its tangent: a
//! satellite that is `d` ahead or aside is `d² / 2 r` lower, and its velocity is turned. In the blind half of
//! a first revolution that is 4 km in the mean where the linear covariance is as thick as that. So the rms of
//! the second order is added, `√3/2 (σ / r)²` of position and velocity alike, with the variance `σ²` across
//! the local vertical: the mean of `d⁴` is `3 σ⁴`.

use super::OrbitState;
use super::body::CentralBody;
use super::factor::{Factor, MOTION, POSITION, VELOCITY};
use fsw_ground::matrix::{cross, dot, dot_slices, scaled};
use nalgebra::{Matrix3, Vector3};

/// Half of √3.
const SECOND_ORDER: f32 = 0.866;

/// Covariance of position (km) and velocity (km/s), ICRS axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionCovariance([[f32; MOTION]; MOTION]);

/// How well it is known when the satellite comes to a place of its orbit, without what is periodic.
///
/// Variance, s², of by how much it is late where it is; covariance, s, of that with the share by which it
/// falls behind; variance of this share, 3/2 of that by which the semi-major axis is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing([f32; 3]);

impl Timing {
    /// Sigma of the time of a place to which it comes in so many seconds, s.
    pub fn sigma_s(&self, ahead_s: f32) -> f32 {
        let Self([late_s2, shared_s, behind]) = self;
        libm::sqrtf((late_s2 + ahead_s * (2.0 * shared_s + ahead_s * behind)).max(0.0))
    }
}

/// How much the semi-major axis of an orbit is longer, as a share, by a change of position (km) and of
/// velocity (km/s), and the pull of gravity against its position, km/s².
pub(crate) fn axis_share(
    body: CentralBody,
    OrbitState { position_km, velocity_km_s, .. }: &OrbitState,
) -> ([f32; MOTION], Vector3<f64>) {
    let mu = body.facts().mu_km3_s2;
    let square_km2 = dot(position_km, position_km);
    let length_km = libm::sqrt(square_km2);
    let gravity_km_s2 = scaled(position_km, mu / (square_km2 * length_km));
    // x = 2 a (mu r / r³ · dr + v · dv) / mu, and 1 / a = 2 / r - v² / mu.
    let scale = 2.0 / (2.0 * mu / length_km - dot(velocity_km_s, velocity_km_s));
    let mut row = [0.0; MOTION];
    for (place, element) in row.iter_mut().zip(gravity_km_s2.iter().chain(velocity_km_s)) {
        *place = (scale * element) as f32;
    }
    (row, gravity_km_s2)
}

impl MotionCovariance {
    /// How well times are known, for the state whose covariance this is.
    pub fn timing(&self, body: CentralBody, state: &OrbitState) -> Timing {
        let (behind, _) = axis_share(body, state);
        let behind = behind.map(|element| 1.5 * element);
        let velocity = &state.velocity_km_s;
        let square = dot(velocity, velocity);
        let mut late = [0.0; MOTION];
        for (place, element) in late.iter_mut().zip(velocity) {
            *place = (-element / square) as f32;
        }
        Timing([self.along(&late, &late), self.along(&late, &behind), self.along(&behind, &behind)])
    }

    /// Sigma of how far the satellite is across the plane of its orbit, rad seen from the body's centre: root
    /// of the mean square over a revolution of a circle, for the state whose covariance this is.
    pub fn across_rad(&self, OrbitState { position_km, velocity_km_s, .. }: &OrbitState) -> f32 {
        let normal = cross(position_km, velocity_km_s);
        let square = dot(&normal, &normal);
        let variance = |place: usize, length: &Vector3<f64>| {
            let scale = 1.0 / libm::sqrt(square * dot(length, length));
            let mut row = [0.0; MOTION];
            for (element, axis) in row.iter_mut().skip(place).zip(&normal) {
                *element = (scale * axis) as f32;
            }
            self.along(&row, &row)
        };
        let both = variance(POSITION, position_km) + variance(VELOCITY, velocity_km_s);
        libm::sqrtf((0.5 * both).max(0.0))
    }

    /// Covariance of two sums of the state's elements, each by its weights.
    fn along(&self, one: &[f32; MOTION], other: &[f32; MOTION]) -> f32 {
        self.0.iter().zip(one).fold(0.0, |sum, (row, weight)| sum + weight * dot_slices(row, other))
    }

    /// That of a filter's state.
    #[inline(never)]
    pub(crate) fn of(factor: &Factor, OrbitState { position_km, velocity_km_s, .. }: &OrbitState) -> Self {
        let mut motion = [0.0; MOTION];
        for (place, element) in motion.iter_mut().zip(position_km.iter().chain(velocity_km_s)) {
            *place = *element as f32;
        }
        let mut covariance = [[0.0; MOTION]; MOTION];
        for (i, row) in covariance.iter_mut().enumerate() {
            for (j, element) in row.iter_mut().enumerate() {
                *element = factor.covariance(i, j);
            }
        }
        let place = motion.get(..VELOCITY).unwrap_or(&[]);
        let square_km2 = dot_slices(place, place).max(1.0);
        let along = covariance.iter().zip(place).map(|(row, element)| element * dot_slices(place, row));
        let vertical_km2 = along.sum::<f32>() / square_km2;
        let share = SECOND_ORDER * (factor.trace(POSITION) - vertical_km2).max(0.0) / square_km2;
        for (row, one) in covariance.iter_mut().zip(&motion) {
            for (element, other) in row.iter_mut().zip(&motion) {
                *element += (share * one) * (share * other);
            }
        }
        Self(covariance)
    }

    fn element(&self, row: usize, column: usize) -> f32 {
        self.0.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0)
    }

    fn sigma(&self, state: usize) -> f32 {
        libm::sqrtf(self.element(state, state))
    }

    /// Sigmas of the position, km.
    pub fn position_sigma_km(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.sigma(POSITION + axis))
    }

    /// Sigmas of the velocity, km/s.
    pub fn velocity_sigma_km_s(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.sigma(VELOCITY + axis))
    }

    /// Covariance of the position, km².
    pub fn position_km2(&self) -> Matrix3<f64> {
        let mut block = Matrix3::zeros();
        for (j, column) in block.data.0.iter_mut().enumerate() {
            for (i, element) in column.iter_mut().enumerate() {
                *element = f64::from(self.element(POSITION + i, POSITION + j));
            }
        }
        block
    }

    /// Correlations: the lower left half without its diagonal, row by row; 0 where a variance is not positive.
    pub fn correlations(&self) -> [f32; MOTION * (MOTION - 1) / 2] {
        let mut correlations = [0.0; MOTION * (MOTION - 1) / 2];
        let mut places = correlations.iter_mut();
        for row in 0..MOTION {
            for (column, place) in (0..row).zip(&mut places) {
                let scale = self.sigma(row) * self.sigma(column);
                if scale > 0.0 {
                    *place = (self.element(row, column) / scale).clamp(-1.0, 1.0);
                }
            }
        }
        correlations
    }
}

#[cfg(test)]
mod tests;
