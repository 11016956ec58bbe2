//! The limb on the detector, with noise, and the flight code's centre of it.

use crate::error::HostError;
use crate::flight;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{Vector, apply};
use crate::world::earth::ellipsoid::Ellipsoid;
use crate::world::lens::optics::Optics;
use crate::world::noise::Noise;
use crate::world::vector::{cross, minus, times, unit};
use fsw_core::camera::Camera;
use fsw_core::earth::centre::{RayBuffer, centre};
use fsw_core::earth::{Body, EarthParameters, FitCriteria, LimbPoint};
use fsw_core::frames::{Direction, EarthPath};
use fsw_core::orbit::body::CentralBody;
use nalgebra::Vector3;
use std::path::Path;

/// Parts of half a degree about the Earth's centre: of a low horizon that is 84 px.
const HORIZON_PARTS: u32 = 16;
/// Equator of date of the views: the ICRS.
const EQUATOR: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A view of the Earth.
pub(in crate::gallery) struct LimbView {
    /// ICRS to Earth path.
    rows: [Vector; 3],
    ellipsoid: Ellipsoid,
    position_km: Vector,
    pub(super) optics: Optics,
}

impl LimbView {
    /// From over the equator, the line of sight `off_deg` from the Earth's centre towards the east, the pole up the
    /// detector; with the reference's camera.
    pub(in crate::gallery) fn new(radius_km: f64, off_deg: f64) -> Result<Self, HostError> {
        let position_km = [radius_km, 0.0, 0.0];
        let (sine, cosine) = libm::sincos(off_deg.to_radians());
        let z = [-cosine, sine, 0.0];
        let y = [0.0, 0.0, -1.0];
        let optics = Optics::new(&CameraFile::reference())
            .ok_or_else(|| HostError::usage("the reference camera is not rectilinear", "report this"))?;
        Ok(Self {
            rows: [cross(y, z), y, z],
            ellipsoid: Ellipsoid::new(CentralBody::Earth, &EQUATOR, position_km),
            position_km,
            optics: optics.earth_path(),
        })
    }

    /// Where the limb is imaged, px, by azimuth about the centre of the Earth: of each half degree so many parts,
    /// between which a cubic curve goes; all of it that is before the camera.
    pub(in crate::gallery) fn limb_px(&self, parts: u32) -> Vec<[f64; 2]> {
        let places: Vec<Vector> = self.ellipsoid.limb().map(|(_, place)| place).collect();
        let at = |index: usize, k: usize| places[(index + places.len()) % places.len()][k];
        let between = |index: usize, t: f64| {
            [0, 1, 2].map(|k| {
                let [a, b, c, d] =
                    [index + places.len() - 1, index, index + 1, index + 2].map(|index| at(index, k));
                // Catmull and Rom's: off by 1e-9 of the radius at half degrees.
                let (slope, next) = (0.5 * (c - a), 0.5 * (d - b));
                b + t
                    * (slope + t * (3.0 * (c - b) - 2.0 * slope - next + t * (2.0 * (b - c) + slope + next)))
            })
        };
        let all = (0..places.len()).flat_map(|index| (0..parts).map(move |part| (index, part)));
        let place = |(index, part)| between(index, f64::from(part) / f64::from(parts));
        all.map(place)
            .filter_map(|place| self.optics.project(apply(&self.rows, minus(place, self.position_km))))
            .collect()
    }

    /// The limb on the detector, in order from left to right.
    pub(in crate::gallery) fn in_field(&self) -> Vec<[f64; 2]> {
        let mut points: Vec<[f64; 2]> =
            self.limb_px(HORIZON_PARTS).into_iter().filter(|place| self.optics.on_detector(*place)).collect();
        points.sort_by(|a, b| a[1].total_cmp(&b[1]));
        points
    }

    /// Direction of the Earth's centre, Earth path.
    pub(super) fn centre(&self) -> Vector {
        unit(apply(&self.rows, times(-1.0, self.position_km)))
    }

    /// Where it is imaged, px.
    pub(super) fn centre_px(&self) -> [f64; 2] {
        self.optics.project(self.centre()).unwrap_or([f64::NAN; 2])
    }
}

/// Limb points with noise across the limb, for the flight code.
pub(super) fn noisy(points: &[[f64; 2]], inside: [f64; 2], sigma_px: f64, noise: &Noise) -> Vec<LimbPoint> {
    let place = |index: usize| {
        // The limb's direction by its neighbours.
        let (before, after) = (points[index.saturating_sub(1)], points[(index + 1).min(points.len() - 1)]);
        let along = libm::hypot(after[0] - before[0], after[1] - before[1]);
        let mut outward = [(after[1] - before[1]) / along, (before[0] - after[0]) / along];
        let at = points[index];
        if (at[0] - inside[0]) * outward[0] + (at[1] - inside[1]) * outward[1] < 0.0 {
            outward = outward.map(|part| -part);
        }
        let error = sigma_px * noise.gaussian(index as u32, 0);
        LimbPoint::new(
            [0, 1].map(|k| (at[k] + error * outward[k]) as f32),
            sigma_px as f32,
            outward.map(|part| part as f32),
        )
    };
    (0..points.len()).map(place).collect()
}

/// The flight code's centre of limb points, px or as a direction.
pub(super) fn flown(view: &LimbView, camera: &Camera, points: &[LimbPoint], sigma_px: f64) -> Option<Vector> {
    let mut parameters = EarthParameters::default();
    parameters.limb.height_km = 0.0;
    (parameters.fit.least_arc_deg, parameters.plausible.range_share) = (5.0, 1.0);
    let pole: Direction<EarthPath> =
        Direction::new(Vector3::from(apply(&view.rows, [0.0, 0.0, 1.0])).map(|c| c as f32))?;
    let body = Body::new(&pole, None, &parameters);
    let criteria = FitCriteria { tolerance_px: (5.0 * sigma_px) as f32, min_inliers: 6, standalone: false };
    let fix = centre(points, camera, &body, &criteria, None, &parameters, &mut RayBuffer::new()).ok()?;
    Some(unit(fix.centre_km.map(f64::from).into()))
}

/// The reference camera.
pub(super) fn camera() -> Result<Camera, HostError> {
    flight::camera(&CameraFile::reference(), Path::new("the reference camera"))
}
