//! From the limb's pixels to the Earth's centre (thesis §3.2).
//!
//! Terms. The *limb* is the edge of the Earth's image; it is *lit* where the Sun stands above the horizon
//! there. A *limb point* is the detector position at which the brightness crosses half of its local rise.
//! The *limb height* is the height above the ellipsoid at which that happens. *Outward* of a limb point is
//! its *dark side*, space. A *strip* is a thin window across an expected limb. *Sphere space* is space
//! stretched along the pole so that the ellipsoid, limb height included, becomes the unit sphere (the
//! matrix B = Q T of Christian and Robinson 2016); there the limb is a circular cone about the centre, from
//! low orbits as well as from high ones. The *arc* is the part of that circle's azimuth which points span.
//!
//! In: windows of raw pixels, the camera, the pole and the Sun in the Earth path's frame. Out: the vector to
//! the Earth's centre, km, with its covariance. All f32.
//!
//! [`view`] predicts the limb on the detector, [`reach`] gives the length of a strip across it, [`limb`]
//! measures it in strips, [`search`] without a prediction. [`consensus`] rejects outliers, [`centre`] fits
//! the centre, [`ground`] moves points by how bright the ground is, `shared_heights` gives the covariance of
//! the height errors that neighbouring points share. [`terminator`] finds the Sun's side.
//! [`limb_sensor`] calls these steps in turn. [`comparison`] is not flown.

pub mod centre;
pub mod comparison;
pub mod consensus;
pub mod ground;
pub mod heights;
pub mod limb;
mod limb_model;
pub mod limb_sensor;
pub mod parameters;
mod plane;
mod rays;
pub mod reach;
pub mod search;
mod shape;
mod shared_heights;
pub mod terminator;
#[cfg(test)]
mod test_world;
pub mod view;

pub use ground::Ground;
pub use parameters::{EarthParameters, Ellipsoid};
pub use shape::Body;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Largest number of limb points in tracking, and in a report.
pub const MAX_LIMB_POINTS: usize = 48;
/// Largest number of limb points of a search of the whole detector.
pub const MAX_SEARCH_POINTS: usize = 128;

/// Why no centre was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FitError {
    /// Fewer limb points than [`FitCriteria::min_inliers`], or than three.
    TooFewPoints,
    /// Too few points within the tolerance of one limb, or an rms residual above it.
    NoConsensus,
    /// The inliers' arc is shorter than `earth.fit.least_arc_deg`.
    ShortArc,
    /// The normal equations are singular, or the centre is farther than `earth.plausible.distance_km`.
    Degenerate,
    /// The centre's sigma exceeds `earth.plausible.sigma_deg` or `earth.plausible.range_share`, or it is not
    /// to be told (`earth.plausible.told_deg`, without an orbit `told_points` too).
    Uncertain,
}

/// A measured point of the limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbPoint {
    /// Position, px.
    pub centre_px: [f32; 2],
    /// Standard deviation along `outward_px`, px.
    pub sigma_px: f32,
    /// Unit vector on the detector along which the limb was measured, from bright to dark.
    pub outward_px: [f32; 2],
    /// The ground just inside.
    pub ground: Ground,
}

impl LimbPoint {
    /// A point of which nothing is known of the ground.
    pub fn new(centre_px: [f32; 2], sigma_px: f32, outward_px: [f32; 2]) -> Self {
        Self { centre_px, sigma_px, outward_px, ground: Ground::default() }
    }
}

/// A measurement of the Earth's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthFix {
    /// From the camera to the Earth's centre, Earth path's frame, km.
    pub centre_km: Vector3<f32>,
    /// The centre about which the fit was linearised, km: `centre_km` itself, or with a prior the combined
    /// estimate.
    pub linearisation_km: Vector3<f32>,
    /// Covariance of `centre_km`, km², uncertainty of the limb's height included.
    pub covariance_km2: Matrix3<f32>,
    /// Its part that is independent from image to image, km²: the points' own errors. The rest is shared by
    /// neighbouring points and correlated between successive images.
    pub noise_km2: Matrix3<f32>,
    /// Azimuth about the centre that the points span, rad, up to a turn.
    pub arc_rad: f32,
    /// Root mean square distance of the inliers from the fitted limb, px.
    pub rms_px: f32,
    /// Bit i is set where point i is an inlier.
    pub inliers: u128,
}

impl EarthFix {
    /// Whether limb point number `point` is an inlier.
    pub fn is_inlier(&self, point: usize) -> bool {
        self.inliers.checked_shr(point as u32).unwrap_or(0) & 1 != 0
    }

    /// Distance to the centre, km.
    pub fn distance_km(&self) -> f32 {
        libm::sqrtf(self.centre_km.dot(&self.centre_km))
    }

    /// Standard deviation of the direction to the centre, rad (of the worst axis across it), and of the
    /// distance, km. A centre that lies across by `x` is farther by `x² / 2 d`: three sigma across count as
    /// three sigma along.
    pub fn sigmas(&self) -> (f32, f32) {
        let range_km = self.distance_km().max(1.0);
        let axis = self.centre_km * (1.0 / range_km);
        let (first, second) = shape::normal_basis(&axis);
        let variance = |one, other| shape::bilinear(one, &self.covariance_km2, other);
        let (xx, xy, yy) = (variance(&first, &first), variance(&first, &second), variance(&second, &second));
        let half = 0.5 * (xx - yy);
        let greatest = (0.5 * (xx + yy) + libm::sqrtf(half * half + xy * xy)).max(0.0);
        let farther_km = 1.5 * greatest / range_km;
        let along = variance(&axis, &axis).max(0.0) + farther_km * farther_km;
        (libm::sqrtf(greatest) / range_km, libm::sqrtf(along))
    }
}

/// Acceptance criteria of a centre fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitCriteria {
    /// Largest distance of an inlier from the fitted limb, px.
    pub tolerance_px: f32,
    /// Least number of inliers.
    pub min_inliers: usize,
    /// Whether the fix has no orbit as its prior, so that `earth.plausible` applies to its own covariance.
    pub standalone: bool,
}

/// Number and scale of the strips read across a limb.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strips {
    /// Strips read.
    pub read: usize,
    /// Expected limb points without a strip: three sigma of the limb's position exceed the longest strip.
    pub skipped: usize,
    /// Height that a pixel spans at the limb, km.
    pub km_per_px: f32,
}

#[cfg(test)]
mod tests;
