//! Artificial skies and pictures of them for the tests of this room; the projection is the f64 oracle's.

use super::MeasuredStar;
use crate::camera::{Camera, CameraParameters, Distortion, Projection};
use crate::catalog::{Catalogue, sample};
use crate::frames::{Icrs, Rotation, StarPath};
use crate::oracle::{self, Generator};
use nalgebra::{Matrix3, Vector3};
use std::sync::LazyLock;
use std::vec::Vec;

/// Stars of the sky: 16 in a field.
pub const STARS: u32 = 3000;
/// Greatest separation of a catalogue pair.
pub const MAX_SEPARATION_DEG: f64 = 12.0;

/// A catalogue with the directions of its stars.
pub struct Sky {
    bytes: Vec<u8>,
    pub units: Vec<Vector3<f64>>,
}

impl Sky {
    fn new(seed: u64, count: u32, max_separation_deg: f64) -> Self {
        let stars = sample::sky(&mut Generator::new(seed), count);
        let max_chord = 2.0 * (0.5 * max_separation_deg.to_radians()).sin();
        let bytes = sample::bytes(&stars, 17, (max_chord * f64::from(1u32 << 30)) as u32);
        let unit = |star: &sample::SampleStar| {
            Vector3::from(star.unit_q30.map(|x| f64::from(x) / f64::from(1u32 << 30)))
        };
        Self { bytes, units: stars.iter().map(unit).collect() }
    }

    pub fn catalogue(&self) -> Catalogue<'_> {
        Catalogue::open(&self.bytes).unwrap()
    }
}

pub static SKY: LazyLock<Sky> = LazyLock::new(|| Sky::new(20, STARS, MAX_SEPARATION_DEG));

/// 1024 x 1024 px with a field of 15 deg.
pub fn camera_parameters() -> CameraParameters {
    CameraParameters {
        width_px: 1024,
        height_px: 1024,
        focal_length_px: 3889.0,
        optical_centre_px: [511.5, 511.5],
        projection: Projection::Rectilinear,
        distortion: Distortion::default(),
        corner_loss: 0.0,
        mirrored: false,
    }
}

pub fn camera() -> Camera {
    Camera::new(camera_parameters()).unwrap()
}

/// A spot on the detector and the catalogue star it is; `None` for a false star.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub centre_px: [f64; 2],
    pub star: Option<u16>,
}

/// What a camera sees, brightest first, and where it looked.
#[derive(Clone)]
pub struct Picture {
    pub spots: Vec<Spot>,
    pub look: Matrix3<f64>,
}

impl Picture {
    /// The stars of the sky that fall on a detector, exactly where they fall.
    pub fn of(sky: &Sky, parameters: &CameraParameters, look: Matrix3<f64>) -> Self {
        let (right, bottom) = (f64::from(parameters.width_px) - 1.0, f64::from(parameters.height_px) - 1.0);
        let seen = |(index, unit): (u16, &Vector3<f64>)| {
            let ahead = look * unit;
            if ahead.z < 0.9 {
                return None;
            }
            let [x, y] = oracle::project(parameters, &ahead);
            let inside = (0.0..=right).contains(&x) && (0.0..=bottom).contains(&y);
            inside.then_some(Spot { centre_px: [x, y], star: Some(index) })
        };
        Self { spots: (0u16..).zip(&sky.units).filter_map(seen).collect(), look }
    }

    /// Each spot moved by Gaussian errors.
    pub fn noisy(mut self, generator: &mut Generator, sigma_px: f64) -> Self {
        for spot in &mut self.spots {
            spot.centre_px = spot.centre_px.map(|x| x + sigma_px * generator.gaussian());
        }
        self
    }

    /// False stars at any brightness.
    pub fn with_false_stars(mut self, generator: &mut Generator, count: usize) -> Self {
        for _ in 0..count {
            let place = generator.bits() as usize % (self.spots.len() + 1);
            self.spots.insert(place, false_star(generator));
        }
        self
    }

    /// All spots in any order.
    pub fn shuffled(mut self, generator: &mut Generator) -> Self {
        for last in (1..self.spots.len()).rev() {
            self.spots.swap(last, generator.bits() as usize % (last + 1));
        }
        self
    }

    pub fn measured(&self, camera: &Camera, sigma_px: f32) -> Vec<MeasuredStar> {
        let star =
            |spot: &Spot| MeasuredStar::new(camera, spot.centre_px.map(|x| x as f32), sigma_px).unwrap();
        self.spots.iter().map(star).collect()
    }

    /// The rotation vector from where the camera looked to this attitude, rad.
    pub fn error_of(&self, attitude: &Rotation<Icrs, StarPath>) -> Vector3<f64> {
        oracle::small_turn(&self.look, &oracle::wide_matrix(attitude.matrix()))
    }

    /// The attitude in f32, turned by a small angle.
    pub fn attitude_turned(&self, angle_rad: &Vector3<f64>) -> Rotation<Icrs, StarPath> {
        Rotation::from_orthogonal((oracle::turn(angle_rad) * self.look).map(|x| x as f32))
    }
}

/// A spot that is no star, anywhere on the detector.
pub fn false_star(generator: &mut Generator) -> Spot {
    Spot { centre_px: [(); 2].map(|()| generator.between(0.0, 1023.0)), star: None }
}
