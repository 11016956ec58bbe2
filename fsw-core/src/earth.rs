//! From the limb's pixels to the Earth's centre (thesis §3.2).
//!
//! Terms. The *limb* is the edge of the Earth as seen; it is *lit* where the Sun stands above the horizon
//! there. A *limb point* is a place on the detector where brightness passes half of its local rise. The *limb
//! height* is the height above the ellipsoid at which that happens. The *dark side* of a limb point,
//! *outward*, is space. A *strip* is a thin window across an expected limb. *Sphere space* is space stretched
//! along the pole so that the ellipsoid, limb height included, becomes the unit sphere (the matrix B = Q T of
//! Christian and Robinson 2016); there the limb is a circular cone about the centre, from low orbits as well
//! as from high ones. The *arc* is the part of that circle's azimuth which points span.
//!
//! In: windows of raw pixels, the camera, the pole and the Sun in the Earth path's frame. Out: the vector to
//! the Earth's centre, km, with its covariance. All f32.
//!
//! [`view`] tells where the limb must stand, [`reach`] how long a strip across it must be, [`limb`] finds it
//! in strips, [`search`] without prediction; [`consensus`] says which points belong to one body, [`centre`]
//! fits it, `shared_heights` adds the covariance of heights that neighbouring points share, and [`limb_sensor`] takes these
//! steps one after the other. [`comparison`] holds what does not fly.

pub mod centre;
pub mod comparison;
pub mod consensus;
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
#[cfg(test)]
mod test_world;
pub mod view;

pub use parameters::{EarthParameters, Ellipsoid};
pub use shape::Body;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Most points of the limb in tracking, and in a report.
pub const MAX_LIMB_POINTS: usize = 48;
/// Most points of the limb in a search of the whole detector.
pub const MAX_SEARCH_POINTS: usize = 128;

/// Why no centre was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FitError {
    /// Fewer limb points than make a fit.
    TooFewPoints,
    /// The points do not agree on one body.
    NoConsensus,
    /// The arc of the limb is too short.
    ShortArc,
    /// The points do not fix a centre, or fix an impossible one.
    Degenerate,
    /// The centre is known worse than the parameters criteria.
    Uncertain,
}

/// A place where the limb was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbPoint {
    /// Where, px.
    pub centre_px: [f32; 2],
    /// Standard deviation along `outward_px`, px.
    pub sigma_px: f32,
    /// Unit vector on the detector along which the limb was measured, from the bright side to the dark one.
    pub outward_px: [f32; 2],
}

/// The Earth's centre as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthFix {
    /// From the camera to the Earth's centre, Earth path's frame, km.
    pub centre_km: Vector3<f32>,
    /// The centre about which the fit was linear, km: `centre_km` itself, or near where it was expected.
    pub linearisation_km: Vector3<f32>,
    /// Covariance of `centre_km`, km², what is not known of the limb's height included.
    pub covariance_km2: Matrix3<f32>,
    /// The part of it that is new with every picture, km²: the points' own errors. The other is shared by
    /// neighbouring points, and for some time by pictures that follow each other.
    pub noise_km2: Matrix3<f32>,
    /// Azimuth about the centre that the points span, rad, up to a turn.
    pub arc_rad: f32,
    /// Root mean square distance of the inliers from the fitted limb, px.
    pub rms_px: f32,
    /// Bit i is set where point i is an inlier.
    pub inliers: u128,
}

impl EarthFix {
    /// Whether the point of this number is an inlier.
    pub fn is_inlier(&self, point: usize) -> bool {
        self.inliers.checked_shr(point as u32).unwrap_or(0) & 1 != 0
    }

    /// Standard deviation of the direction to the centre, the greater of the two across it, rad, and of the
    /// distance, km.
    pub fn sigmas(&self) -> (f32, f32) {
        let range_km = libm::sqrtf(self.centre_km.dot(&self.centre_km)).max(1.0);
        let axis = self.centre_km * (1.0 / range_km);
        let (first, second) = shape::normal_basis(&axis);
        let variance = |one, other| shape::bilinear(one, &self.covariance_km2, other);
        let (xx, xy, yy) = (variance(&first, &first), variance(&first, &second), variance(&second, &second));
        let half = 0.5 * (xx - yy);
        let greatest = 0.5 * (xx + yy) + libm::sqrtf(half * half + xy * xy);
        (libm::sqrtf(greatest.max(0.0)) / range_km, libm::sqrtf(variance(&axis, &axis).max(0.0)))
    }
}

/// When points count as those of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitCriteria {
    /// Farthest that an inlier may lie from the limb, px.
    pub tolerance_px: f32,
    /// Fewest inliers.
    pub min_inliers: usize,
    /// Whether the centre they make must be known by itself as well as the parameters criteria.
    pub standalone: bool,
}

/// Strips that were read across a limb.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strips {
    /// How many.
    pub read: usize,
    /// Places at which none was read, because the limb may lie farther off than a strip reaches.
    pub skipped: usize,
    /// What a pixel spans at that limb, km.
    pub km_per_px: f32,
}

#[cfg(test)]
mod tests;
