//! Heights of limb points above the limb that is predicted.
//!
//! In: the rays of the limb points that a centre was fitted to ([`RayBuffer`]), and where the Earth's centre
//! is predicted. Out: a [`LimbHeight`] for each point.
//!
//! The residual of a ray about the predicted cone (`rays`) times the limb's distance is a height in sphere
//! space, where the orbit filter takes it; above the pole it is longer by a 300th. Normals stand at predicted
//! points, not at the measured ones, whose errors they would share: in LEO that shifts a position by 10 km.
//! Error 3e-4 px by rounding.

use super::Body;
use super::centre::RayBuffer;
use super::rays::{Cone, Ray};
use crate::frames::LimbHeight;
use nalgebra::Vector3;

/// The limb predicted from the vector to the Earth's centre.
#[derive(Clone, Copy, Debug)]
pub struct PredictedLimb {
    cone: Cone,
    /// Its distance, km of sphere space.
    distance_km: f32,
}

impl PredictedLimb {
    /// `None` where the centre cannot be: see [`Body`].
    pub fn new(centre_km: &Vector3<f32>, body: &Body) -> Option<Self> {
        let cone = Cone::about(centre_km, body)?;
        Some(Self { cone, distance_km: body.radius_km() * cone.cosine / cone.sine })
    }

    /// The heights of the points that were fitted; none of those whose line of measurement runs along the
    /// limb.
    pub fn heights(&self, fitted: &RayBuffer) -> impl Iterator<Item = LimbHeight> {
        fitted.rays().iter().filter_map(|ray| self.height(ray))
    }

    fn height(&self, ray: &Ray) -> Option<LimbHeight> {
        let Self { cone, distance_km } = self;
        let (residual, radial) = cone.residual(ray);
        let sigma = ray.sigma_rad(cone, &radial)?;
        Some(LimbHeight { radial, height_km: residual * distance_km, sigma_km: sigma * distance_km })
    }
}

#[cfg(test)]
mod tests;
