//! From the limb's pixels to the Earth's centre (thesis §3.2).
//!
//! Terms. The *limb* is the edge of the Earth as seen; it is *lit* where the Sun stands above the horizon there. A *limb
//! point* is a place on the detector where brightness passes half of its local rise. The *limb height* is the height
//! above the ellipsoid at which that happens. The *dark side* of a limb point, *outward*, is space. A *strip* is a thin
//! window across an expected limb. *Sphere space* is space stretched along the pole so that the ellipsoid, limb height
//! included, becomes the unit sphere (the matrix B = Q T of Christian and Robinson 2016); there the limb is a circular
//! cone about the centre, from low orbits as well as from high ones. The *arc* is the part of that circle's azimuth
//! which points span.
//!
//! In: windows of raw pixels, the camera, the pole and the Sun in the Earth path's frame. Out: the vector to the Earth's
//! centre, km, with its covariance. All f32.
//!
//! [`view`] tells where the limb must stand, [`limb`] finds it in strips, [`search`] without prediction; [`consensus`]
//! says which points belong to one body, [`centre`] fits it, `horizon` says what heights that neighbouring points share make of it,
//! and [`look`] puts these together. For comparison, and not in flight: [`thesis`] is the way of the thesis, [`filters`] are its other
//! filters across the limb, [`scale`] checks the focal length.

pub mod centre;
pub mod consensus;
pub mod filters;
mod horizon;
pub mod limb;
pub mod look;
mod plane;
mod rays;
pub mod scale;
pub mod search;
mod shape;
#[cfg(test)]
mod test_world;
pub mod thesis;
pub mod view;
mod zone;

pub use shape::{Body, Ellipsoid};

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Most points of the limb in tracking, and in a report.
pub const MAX_LIMB_POINTS: usize = 48;
/// Most points of the limb in a search of the whole detector.
pub const MAX_SEARCH_POINTS: usize = 128;

/// Why no centre was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// Fewer limb points than make a fit.
    TooFewPoints,
    /// The points do not agree on one body.
    NoConsensus,
    /// The arc of the limb is too short.
    ShortArc,
    /// The points do not fix a centre, or fix an impossible one.
    Degenerate,
    /// The centre is known worse than the parameters demand.
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
    pub place_km: Vector3<f32>,
    /// Covariance of `centre_km`, km², what is not known of the limb's height included.
    pub covariance_km2: Matrix3<f32>,
    /// The part of it that is new with every picture, km²: the points' own errors. The other is shared by neighbouring points, and
    /// for some time by pictures that follow each other.
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
    pub fn holds(&self, point: usize) -> bool {
        self.inliers.checked_shr(point as u32).unwrap_or(0) & 1 != 0
    }

    /// Standard deviation of the direction to the centre, the greater of the two across it, rad, and of the distance, km.
    pub fn sigmas(&self) -> (f32, f32) {
        let range_km = libm::sqrtf(self.centre_km.dot(&self.centre_km)).max(1.0);
        let axis = self.centre_km * (1.0 / range_km);
        let (first, second) = shape::across(&axis);
        let variance = |one: &Vector3<f32>, other: &Vector3<f32>| one.dot(&(self.covariance_km2 * other));
        let (xx, xy, yy) = (variance(&first, &first), variance(&first, &second), variance(&second, &second));
        let half = 0.5 * (xx - yy);
        let greatest = 0.5 * (xx + yy) + libm::sqrtf(half * half + xy * xy);
        (libm::sqrtf(greatest.max(0.0)) / range_km, libm::sqrtf(variance(&axis, &axis).max(0.0)))
    }
}

/// Distance over which clouds change the place of a limb no wider than a pixel alike, km.
pub const CLOUD_CELL_KM: f32 = 300.0;

/// What the room wants to know of the Earth, its limb and the points on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EarthParameters {
    /// The body's ellipsoid (default WGS 84; axes 100 to 100,000 km, at most 20 % apart).
    pub ellipsoid: Ellipsoid,
    /// Height above the ellipsoid at which the limb is half bright, km (default 5.5, 0 to 60; thesis §4.2: depends on
    /// wavelength and season).
    pub limb_height_km: f32,
    /// Height over which the brightness above the surface falls to 1 / e, km (default 8, 0.5 to 50; thesis eq. 4.1).
    pub scale_height_km: f32,
    /// Standard deviation of the point spread, px (default 0.9, 0.2 to 5).
    pub psf_sigma_px: f32,
    /// Elevation of the Sun above which a limb counts as lit, deg (default 3, 0 to 45).
    pub lit_sun_elevation_deg: f32,
    /// Least elevation of the Sun at a limb point, deg (default 4, 0 to 45): lower, the slant of the light moves the place of
    /// half brightness. At the terminator every degree makes the arc longer: with 8 a dawn-dusk orbit is never found.
    pub least_sun_elevation_deg: f32,
    /// How far below the horizon the Sun still lights the air so that stars are not seen, deg (default 6, 0 to 18).
    pub twilight_deg: f32,
    /// Least rise of brightness across the limb of a strip, share of full scale (default 0.01, 0.005 to 0.5).
    pub least_contrast_share: f32,
    /// Brightest dark side of a limb point in a strip, share of full scale (default 0.12, 0.01 to 0.5; thesis 11 %).
    pub greatest_dark_share: f32,
    /// Brightness that counts as saturated, share of full scale (default 0.95, 0.5 to 1).
    pub saturated_share: f32,
    /// Least standard deviation of a limb point, px (default 0.05, 0.005 to 2).
    pub limb_floor_px: f32,
    /// Scatter of the limb's height along it, km (default 0.6, 0 to 10).
    pub limb_scatter_km: f32,
    /// Standard deviation of `limb_height_km`, km (default 1.4, 0 to 20): season, wavelength, and that a limb narrower than a pixel
    /// seems 2 km higher than a wide one.
    pub limb_height_sigma_km: f32,
    /// Standard deviation of the height that neighbouring points of the limb share, km (default 1.8, 0 to 20: what clouds and the
    /// horizon do to strips of rendered orbits, `sil-host campaign earth`).
    pub horizon_sigma_km: f32,
    /// The same of what they share on the detector, px (default 0.48, 0 to 5): clouds in a limb no wider than a pixel; in a wider one
    /// the less the wider it is.
    pub horizon_sigma_px: f32,
    /// Distance over which they share their height, km (default 400, 50 to 10,000).
    pub horizon_cell_km: f32,
    /// Difference of brightness between the limb and the bright side just inside that is not known, share of it (default
    /// 0.1, 0 to 1): clouds.
    pub limb_cloud_share: f32,
    /// Share of the surface's brightness that follows the law of Lommel and Seeliger, the rest Lambert's (default 0.5, 0 to 1).
    pub limb_lommel_share: f32,
    /// Distance between the rows and columns that a search reads, px (default 16, 4 to 64; thesis 10).
    pub search_step_px: f32,
    /// Least rise of brightness in a search, share of full scale (default 0.02, 0.01 to 0.5; thesis 12 %); in noise more.
    pub search_contrast_share: f32,
    /// Brightest dark side in a search over the darkest sky, share of full scale (default 0.06, 0.01 to 0.5; thesis 6 %); in all never
    /// more than `greatest_dark_share`.
    pub search_dark_share: f32,
    /// Least length of the bright side in a search, px (default 12, 4 to 64).
    pub search_run_px: f32,
    /// Greatest length of the rise in a search, px (default 64, 4 to 250): a terminator is longer.
    pub search_rise_px: f32,
    /// Least standard deviation of a limb point of a search, px (default 1.5, 0.01 to 5): clouds move
    /// neighbours alike.
    pub search_floor_px: f32,
    /// Farthest that an inlier may lie from the limb in a search, px (default 4, 0.2 to 20; thesis 4).
    pub search_tolerance_px: f32,
    /// The same in tracking (default 2, 0.2 to 20).
    pub tracking_tolerance_px: f32,
    /// Share of inliers at which a hypothesis is taken at once (default 0.95, 0.5 to 1; thesis §3.2.1).
    pub enough_share: f32,
    /// Least share of inliers of the best hypothesis in a search (default 0.3, 0.2 to 1; thesis §3.2.1: 0.5, but in a search that
    /// sees faint limbs a terminator gives as many points as the limb).
    pub search_share: f32,
    /// Least share of the strips read that must hold an inlier (default 0.5, 0.2 to 1): where they lie across the limb most do, and a
    /// few that agree by chance would give a centre that is wrong by many sigmas.
    pub strip_share: f32,
    /// Fewest inliers (default 6, 4 to 40).
    pub fewest_points: f32,
    /// Shortest arc, deg (default 10, 1 to 180).
    pub least_arc_deg: f32,
    /// Greatest standard deviation of the direction where no orbit helps, deg (default 10, 0.001 to 10).
    pub greatest_sigma_deg: f32,
    /// Greatest standard deviation of the distance, share of it, likewise (default 0.5, 0.001 to 1).
    pub greatest_range_share: f32,
    /// Farthest that the body can be, km, likewise (default 100,000, 10,000 to 1e9): a lit cloud in the night side is a small crescent.
    pub greatest_distance_km: f32,
}

impl Default for EarthParameters {
    fn default() -> Self {
        Self {
            ellipsoid: Ellipsoid::WGS84,
            limb_height_km: 5.5,
            scale_height_km: 8.0,
            psf_sigma_px: 0.9,
            lit_sun_elevation_deg: 3.0,
            least_sun_elevation_deg: 4.0,
            twilight_deg: 6.0,
            least_contrast_share: 0.01,
            greatest_dark_share: 0.12,
            saturated_share: 0.95,
            limb_floor_px: 0.05,
            limb_scatter_km: 0.6,
            limb_height_sigma_km: 1.4,
            horizon_sigma_km: 1.8,
            horizon_sigma_px: 0.48,
            horizon_cell_km: 400.0,
            limb_cloud_share: 0.1,
            limb_lommel_share: 0.5,
            search_step_px: 16.0,
            search_contrast_share: 0.02,
            search_dark_share: 0.06,
            search_run_px: 12.0,
            search_rise_px: 64.0,
            search_floor_px: 1.5,
            search_tolerance_px: 4.0,
            tracking_tolerance_px: 2.0,
            enough_share: 0.95,
            search_share: 0.3,
            strip_share: 0.5,
            fewest_points: 6.0,
            least_arc_deg: 10.0,
            greatest_sigma_deg: 10.0,
            greatest_range_share: 0.5,
            greatest_distance_km: 100_000.0,
        }
    }
}

/// When points count as those of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Farthest that an inlier may lie from the limb, px.
    pub tolerance_px: f32,
    /// Fewest inliers.
    pub inliers: usize,
    /// Whether the centre they make must be known by itself as well as the parameters demand.
    pub alone: bool,
}

/// Strips that were read across a limb.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strips {
    /// How many.
    pub read: usize,
    /// Places at which none was read, because the limb may lie farther off than a strip reaches.
    pub unsure: usize,
    /// What a pixel spans at that limb, km.
    pub km_per_px: f32,
}

/// How many of its scatters ([`EarthParameters::limb_scatter_km`]) a limb point may be off.
const TOLERATED_SCATTERS: f32 = 4.0;

impl EarthParameters {
    /// What is demanded of a search that found so many points.
    pub fn in_search(&self, points: usize) -> Demand {
        let inliers = self.fewest(self.search_share, points);
        Demand { tolerance_px: self.search_tolerance_px, inliers, alone: true }
    }

    /// What is demanded of these strips; `alone` where no orbit says what the limb does not. Where a pixel spans less than the limb
    /// scatters, inliers may lie farther apart.
    pub fn in_strips(&self, strips: &Strips, alone: bool) -> Demand {
        let inliers = self.fewest(self.strip_share, strips.read);
        let scatter_px = TOLERATED_SCATTERS * self.limb_scatter_km / strips.km_per_px.max(1e-3);
        let tolerance_px =
            libm::sqrtf(self.tracking_tolerance_px * self.tracking_tolerance_px + scatter_px * scatter_px);
        Demand { tolerance_px, inliers, alone }
    }

    /// By how many times less clouds move a limb of which a pixel spans so many km than one that is no wider than a pixel.
    pub fn clouds_reduction(&self, km_per_px: f32) -> f32 {
        let wide = self.scale_height_km / km_per_px.max(1e-3);
        libm::sqrtf(1.0 + wide * wide)
    }

    fn fewest(&self, share: f32, count: usize) -> usize {
        let inliers = libm::ceilf(share * count as f32) as usize;
        inliers.max(self.fewest_points as usize).max(3)
    }

    /// Name, value and range of every parameter. Counts and lengths in px are used rounded down.
    pub fn ranges(&self) -> [(&'static str, f32, f32, f32); 35] {
        let Ellipsoid { equatorial_km, polar_km } = self.ellipsoid;
        [
            ("equatorial_km", equatorial_km, 100.0, 100_000.0),
            ("polar_km", polar_km, 0.8 * equatorial_km, 1.2 * equatorial_km),
            ("limb_height_km", self.limb_height_km, 0.0, 60.0),
            ("scale_height_km", self.scale_height_km, 0.5, 50.0),
            ("psf_sigma_px", self.psf_sigma_px, 0.2, 5.0),
            ("lit_sun_elevation_deg", self.lit_sun_elevation_deg, 0.0, 45.0),
            ("least_sun_elevation_deg", self.least_sun_elevation_deg, 0.0, 45.0),
            ("twilight_deg", self.twilight_deg, 0.0, 18.0),
            ("least_contrast_share", self.least_contrast_share, 0.005, 0.5),
            ("greatest_dark_share", self.greatest_dark_share, 0.01, 0.5),
            ("saturated_share", self.saturated_share, 0.5, 1.0),
            ("limb_floor_px", self.limb_floor_px, 0.005, 2.0),
            ("limb_scatter_km", self.limb_scatter_km, 0.0, 10.0),
            ("limb_height_sigma_km", self.limb_height_sigma_km, 0.0, 20.0),
            ("horizon_sigma_km", self.horizon_sigma_km, 0.0, 20.0),
            ("horizon_sigma_px", self.horizon_sigma_px, 0.0, 5.0),
            ("horizon_cell_km", self.horizon_cell_km, 50.0, 10_000.0),
            ("limb_cloud_share", self.limb_cloud_share, 0.0, 1.0),
            ("limb_lommel_share", self.limb_lommel_share, 0.0, 1.0),
            ("search_step_px", self.search_step_px, 4.0, 64.0),
            ("search_contrast_share", self.search_contrast_share, 0.01, 0.5),
            ("search_dark_share", self.search_dark_share, 0.01, 0.5),
            ("search_run_px", self.search_run_px, 4.0, 64.0),
            ("search_rise_px", self.search_rise_px, 4.0, 250.0),
            ("search_floor_px", self.search_floor_px, 0.01, 5.0),
            ("search_tolerance_px", self.search_tolerance_px, 0.2, 20.0),
            ("tracking_tolerance_px", self.tracking_tolerance_px, 0.2, 20.0),
            ("enough_share", self.enough_share, 0.5, 1.0),
            ("search_share", self.search_share, 0.2, 1.0),
            ("strip_share", self.strip_share, 0.2, 1.0),
            ("fewest_points", self.fewest_points, 4.0, 40.0),
            ("least_arc_deg", self.least_arc_deg, 1.0, 180.0),
            ("greatest_sigma_deg", self.greatest_sigma_deg, 0.001, 10.0),
            ("greatest_range_share", self.greatest_range_share, 0.001, 1.0),
            ("greatest_distance_km", self.greatest_distance_km, 1e4, 1e9),
        ]
    }
}

#[cfg(test)]
mod tests;
