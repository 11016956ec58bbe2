//! How well the best of all methods could know the Earth's centre from one frame.
//!
//! In: where the limb can be measured, by azimuth about the centre, and what is known of its heights. Out:
//! the Cramér-Rao bound of the direction for heights of the Gaussian field that the flight code's covariance
//! stands for (`fsw_core::earth::EarthParameters`): the sigma of the best linear unbiased estimate, which
//! weighs neighbours by what they share.
//!
//! A limb point at the azimuth `φ` is raised by `-a1 cos φ - a2 sin φ + a3` when the centre turns by `(a1,
//! a2)` and the cone narrows by `a3`; with these rows `H` and the covariance `C` of the heights the bound is
//! that of `(Hᵀ C⁻¹ H)⁻¹`.

use crate::world::attitude::{Vector, dot};
use fsw_core::camera::Camera;
use fsw_core::earth::reach::STRIP_MARGIN_PX;
use fsw_core::earth::view::View;
use fsw_core::earth::{EarthParameters, MAX_LIMB_POINTS};
use nalgebra::{DMatrix, Matrix3};

/// Step and end of the integral that gives the correlation.
const STEP: f64 = 0.1;
const STEPS: u32 = 140;

/// Matérn's correlation of order one, `x K₁(x)` with `K₁(x) = ∫ exp(-x cosh t) cosh t dt`, t from 0
/// (Abramowitz and Stegun 9.6.24).
fn correlation(x: f64) -> f64 {
    if x < 1e-3 {
        return 1.0;
    }
    let at = |k: u32| {
        let cosh = libm::cosh(STEP * f64::from(k));
        (-x * cosh).exp() * cosh
    };
    let sum: f64 = (1..STEPS).map(at).sum();
    x * STEP * (0.5 * at(0) + sum)
}

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
pub fn direction_deg(limb: &Limb, parameters: &EarthParameters) -> Option<[f64; 2]> {
    let square = |number: f64| number * number;
    let km_per_px = limb.distance_km * limb.rad_per_px;
    let reduction = f64::from(parameters.clouds_reduction(km_per_px as f32));
    let clouds_km2 = square(f64::from(parameters.horizon.sigma_px) * km_per_px / reduction);
    let heights_km2 = square(parameters.horizon.sigma_km.into());
    let mean_km2 = square(parameters.limb.height_sigma_km.into());
    let own_km2 =
        square(parameters.limb.scatter_km.into()) + square(f64::from(parameters.strips.floor_px) * km_per_px);
    let count = limb.azimuths.len();
    let covariance = DMatrix::from_fn(count, count, |i, j| {
        let apart_km = 2.0 * limb.radius_km * libm::sin(0.5 * (limb.azimuths[i] - limb.azimuths[j])).abs();
        let shared = heights_km2 * correlation(apart_km / f64::from(parameters.horizon.cell_km))
            + clouds_km2 * correlation(apart_km / f64::from(parameters.horizon.cloud_cell_km));
        mean_km2 + shared + if i == j { own_km2 } else { 0.0 }
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

    #[test]
    fn the_correlation_is_that_of_the_tables() {
        // K₁ of 0.1, 1, 2, 5: Abramowitz and Stegun, tables 9.8 and 9.9.
        for (x, k1) in [(0.1, 9.853_845), (1.0, 0.601_907), (2.0, 0.139_866), (5.0, 0.004_044_6)] {
            assert!((correlation(x) / (x * k1) - 1.0).abs() < 2e-5, "{x}");
        }
        assert!((correlation(1.1e-3) - 1.0).abs() < 1e-5);
    }

    fn parameters() -> EarthParameters {
        let mut parameters = EarthParameters::default();
        (parameters.horizon.sigma_km, parameters.horizon.sigma_px) = (0.0, 0.0);
        (parameters.limb.scatter_km, parameters.strips.floor_px) = (3.0, 0.0);
        parameters
    }

    fn limb(count: usize, arc: f64) -> Limb {
        let azimuths = (0..count).map(|k| arc * (k as f64 + 0.5) / count as f64 - 0.5 * arc).collect();
        Limb { azimuths, distance_km: 3000.0, radius_km: 5700.0, rad_per_px: 1e-3 }
    }

    #[test]
    fn independent_heights_all_around_average_out() {
        // σ sqrt(2 / n), whatever the mean height.
        let expected = (3.0 / 3000.0 * (2.0f64 / 40.0).sqrt()).to_degrees();
        let bound = direction_deg(&limb(40, TAU), &parameters()).unwrap();
        assert!(bound.iter().all(|axis| (axis / expected - 1.0).abs() < 1e-9), "{bound:?}");
    }

    #[test]
    fn a_short_arc_says_little_along_its_middle_and_neighbours_that_agree_say_less() {
        let [along, across] = direction_deg(&limb(40, 1.0), &parameters()).unwrap();
        assert!(along > 3.0 * across);
        let mut shared = parameters();
        (shared.horizon.sigma_km, shared.limb.scatter_km) = (3.0, 0.1);
        let [shared_along, shared_across] = direction_deg(&limb(40, 1.0), &shared).unwrap();
        assert!(shared_along > along && shared_across > across);
        // More places on the same arc hardly help then.
        let [more, _] = direction_deg(&limb(80, 1.0), &shared).unwrap();
        assert!(more < shared_along && more > 0.95 * shared_along, "{more} {shared_along}");
        assert_eq!(direction_deg(&limb(2, 1.0), &shared), None);
    }
}
