//! How well the best of all methods could know the Earth's centre from one frame.
//!
//! In: where the limb can be measured, by azimuth about the centre, and what heights in the world's own
//! fields have in common ([`Heights`]). Out: the Cramér-Rao bound of the direction for Gaussian heights of
//! that covariance: the sigma of the best linear unbiased estimate, which weighs neighbours by what they
//! share. Where limb points can be had is asked of the flight code; what they are worth is not.
//!
//! A limb point at the azimuth `φ` is raised by `-a1 cos φ - a2 sin φ + a3` when the centre turns by `(a1,
//! a2)` and the cone narrows by `a3`; with these rows `H` and the covariance `C` of the heights the bound is
//! that of `(Hᵀ C⁻¹ H)⁻¹`.

use crate::world::attitude::{Vector, dot};
use crate::world::earth::heights::Heights;
use fsw_core::camera::Camera;
use fsw_core::earth::reach::STRIP_MARGIN_PX;
use fsw_core::earth::view::View;
use fsw_core::earth::{EarthParameters, MAX_LIMB_POINTS};
use nalgebra::{DMatrix, Matrix3};

/// Deviation of a limb point by photons and readout alone, px: 55 e- of noise where the limb rises by 1900 e-
/// a pixel, over the pixels of its edge.
const EDGE_PX: f64 = 0.03;

/// The limb of a frame.
#[derive(Clone, Debug)]
pub struct Limb {
    /// Azimuths at which it can be measured, rad.
    pub azimuths: Vec<f64>,
    /// Its distance from the camera, km.
    pub distance_km: f64,
    /// Radius of the circle on which it lies, km.
    pub radius_km: f64,
    /// Angle of a pixel.
    pub rad_per_px: f64,
}

impl Limb {
    /// That of a view, azimuth counting from the first of these axes across the line to the centre.
    pub fn of(view: &View, camera: &Camera, [x, y]: [Vector; 2], parameters: &EarthParameters) -> Self {
        let seen = view.limb(camera, STRIP_MARGIN_PX, (MAX_LIMB_POINTS, 4), parameters);
        let azimuth = |normal: Vector| libm::atan2(dot(normal, y), dot(normal, x));
        let azimuths = seen.points.iter().map(|point| azimuth(point.normal.map(f64::from).into()));
        Self {
            azimuths: azimuths.collect(),
            distance_km: view.limb_distance_km().into(),
            radius_km: f64::from(view.limb_distance_km() * view.limb_sine()),
            rad_per_px: camera.rad_per_px().into(),
        }
    }
}

/// The bound of the direction on both axes across it, azimuth counting from the first, deg; none where the
/// limb is too short to say.
pub fn direction_deg(limb: &Limb, heights: &Heights) -> Option<[f64; 2]> {
    let own_km = EDGE_PX * limb.distance_km * limb.rad_per_px;
    let count = limb.azimuths.len();
    let covariance = DMatrix::from_fn(count, count, |i, j| {
        let apart_km = 2.0 * limb.radius_km * libm::sin(0.5 * (limb.azimuths[i] - limb.azimuths[j])).abs();
        heights.covariance_km2(apart_km) + if i == j { own_km * own_km } else { 0.0 }
    });
    let rows = DMatrix::from_fn(count, 3, |i, column| {
        let (sine, cosine) = libm::sincos(limb.azimuths[i]);
        [-cosine, -sine, 1.0][column]
    });
    let information = rows.transpose() * covariance.cholesky()?.solve(&rows);
    let bound_km2 = Matrix3::from_fn(|i, j| information[(i, j)]).cholesky()?.inverse();
    Some([0, 1].map(|axis| (bound_km2[(axis, axis)].sqrt() / limb.distance_km).to_degrees()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn limb(count: usize, arc: f64) -> Limb {
        let azimuths = (0..count).map(|k| arc * (k as f64 + 0.5) / count as f64 - 0.5 * arc).collect();
        Limb { azimuths, distance_km: 3000.0, radius_km: 5700.0, rad_per_px: 1e-3 }
    }

    #[test]
    fn independent_points_all_around_average_out() {
        // σ sqrt(2 / n), whatever the mean height.
        let expected = (EDGE_PX * 1e-3 * (2.0f64 / 40.0).sqrt()).to_degrees();
        let bound = direction_deg(&limb(40, TAU), &Heights::even(0.0)).unwrap();
        assert!(bound.iter().all(|axis| (axis / expected - 1.0).abs() < 1e-9), "{bound:?}");
    }

    #[test]
    fn a_short_arc_says_little_along_its_middle_and_neighbours_that_agree_say_less() {
        let [along, across] = direction_deg(&limb(40, 1.0), &Heights::even(0.0)).unwrap();
        assert!(along > 3.0 * across);
        let shared = Heights::even(9.0);
        let [shared_along, shared_across] = direction_deg(&limb(40, 1.0), &shared).unwrap();
        assert!(shared_along > along && shared_across > across);
        // More places on the same arc hardly help then.
        let [more, _] = direction_deg(&limb(80, 1.0), &shared).unwrap();
        assert!(more < shared_along && more > 0.8 * shared_along, "{more} {shared_along}");
        assert_eq!(direction_deg(&limb(2, 1.0), &shared), None);
    }
}
