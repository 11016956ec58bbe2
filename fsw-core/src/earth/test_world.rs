//! The Earth for the tests of this room, in f64 and apart from the flight code: a ray is cut with the
//! ellipsoid in the body's own axes; brightness is Lambert's law times clouds, above the surface exp(-h / H);
//! the picture is sampled finely near the limb, blurred by a Gaussian and rounded to counts.

use super::limb::Reach;
use super::view::{ExpectedLimb, View};
use super::{Body, EarthParameters, LimbPoint};
use crate::camera::Camera;
use crate::frames::{Direction, EarthPath};
use crate::oracle::{self, Generator};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use nalgebra::{Matrix3, Vector3};
use std::vec::Vec;

pub const A_KM: f64 = 6378.137;
pub const B_KM: f64 = 6356.752;
pub const GEO_KM: f64 = 42_164.0;
pub const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 1280, height_px: 1024, bits: 10 };
pub const SCALE_HEIGHT_KM: f64 = 8.0;
pub const PSF_PX: f64 = 0.9;
/// Pedestal and dark signal, counts.
pub const DARK: f64 = 40.0;

/// A strip's reach, the same to either side.
pub fn even(reach_px: u16) -> Reach {
    Reach { outward_px: reach_px, inward_px: reach_px }
}

/// Parameters that know this world.
pub fn parameters() -> EarthParameters {
    let mut parameters = EarthParameters::default();
    parameters.limb.height_km = (SCALE_HEIGHT_KM * std::f64::consts::LN_2) as f32;
    (parameters.limb.lommel_share, parameters.limb.height_sigma_km) = (0.0, 0.0);
    (parameters.horizon.sigma_km, parameters.horizon.sigma_px) = (0.0, 0.0);
    parameters
}

pub fn camera() -> Camera {
    Camera::new(oracle::reference_camera()).unwrap()
}

pub fn narrow(vector: &Vector3<f64>) -> Vector3<f32> {
    vector.map(|part| part as f32)
}

pub fn direction(vector: &Vector3<f64>) -> Direction<EarthPath> {
    Direction::new(narrow(vector)).unwrap()
}

#[derive(Clone)]
pub struct World {
    /// From the camera to the Earth's centre, km.
    pub centre: Vector3<f64>,
    pub pole: Vector3<f64>,
    /// Turns the camera's frame into the body's own axes, pole along z.
    pub to_body: Matrix3<f64>,
    pub sun: Vector3<f64>,
    /// Counts of a white surface under the Sun.
    pub white: f64,
    /// Albedo between these.
    pub albedo: [f64; 2],
    /// Wave vectors, radii, and phases of the clouds.
    pub waves: Vec<(Vector3<f64>, f64)>,
}

/// Error of a point across the limb, px, of an expected point that stands on it.
pub fn error_px(found: &LimbPoint, expected: &ExpectedLimb) -> f64 {
    let [nx, ny] = expected.outward_px;
    f64::from((found.centre_px[0] - expected.at_px[0]) * nx + (found.centre_px[1] - expected.at_px[1]) * ny)
}

/// The pixels of a window through a lens that dims by the fourth power of the cosine, and by half of the light
/// in the corner besides.
pub fn through_a_dark_lens(pixels: &mut [u16], window: &Window) {
    let width = usize::from(window.width);
    for (place, pixel) in pixels.iter_mut().enumerate() {
        let x = f64::from(window.x) + (place % width) as f64 - 639.5;
        let y = f64::from(window.y) + (place / width) as f64 - 511.5;
        let square = x * x + y * y;
        let cosine_square = 1.0 / (1.0 + square / 3000f64.powi(2));
        let gain = cosine_square * cosine_square * (1.0 - 0.5 * square / 819f64.powi(2));
        *pixel = (DARK + gain * (f64::from(*pixel) - DARK)).round().max(0.0) as u16;
    }
}

impl World {
    pub fn new(centre: Vector3<f64>, pole: Vector3<f64>, sun: Vector3<f64>, seed: u64) -> Self {
        let mut generator = Generator::new(seed);
        // Cloud fields of 1500 to 6000 km: a factor of several over tens of pixels.
        let waves = (0..12)
            .map(|_| {
                let length_km = generator.between(1500.0, 6000.0);
                let wave = generator.unit() * (std::f64::consts::TAU * A_KM / length_km);
                (wave, generator.between(0.0, std::f64::consts::TAU))
            })
            .collect();
        let pole = pole.normalize();
        let aside = if pole.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
        let x = aside.cross(&pole).normalize();
        Self {
            centre,
            pole,
            to_body: Matrix3::from_rows(&[x.transpose(), pole.cross(&x).transpose(), pole.transpose()]),
            sun: sun.normalize(),
            white: 800.0,
            albedo: [0.25, 0.9],
            waves,
        }
    }

    pub fn body(&self, parameters: &EarthParameters) -> Body {
        Body::new(&direction(&self.pole), Some(&direction(&self.sun)), parameters)
    }

    /// Points of the limb where it stands, 48 of them.
    pub fn expected(&self) -> Vec<ExpectedLimb> {
        let parameters = parameters();
        let view = View::new(&narrow(&self.centre), &self.body(&parameters)).unwrap();
        view.limb(&camera(), 90.0, (48, 4), &parameters).points.iter().copied().collect()
    }

    /// Scaled so that the ellipsoid at `height` is the unit sphere: camera's position and the ray.
    fn scaled(&self, ray: &Vector3<f64>, height: f64) -> (Vector3<f64>, Vector3<f64>) {
        let scale = Vector3::new(A_KM + height, A_KM + height, B_KM + height).map(|axis| 1.0 / axis);
        let turn = self.to_body;
        ((turn * -self.centre).component_mul(&scale), (turn * ray).component_mul(&scale))
    }

    /// The point where a ray meets the surface at `height`, or else passes nearest: scaled, and whether it
    /// meets.
    fn nearest(&self, ray: &Vector3<f64>, height: f64) -> (Vector3<f64>, bool) {
        let (eye, step) = self.scaled(ray, height);
        let (a, b, c) = (step.dot(&step), eye.dot(&step), eye.dot(&eye) - 1.0);
        let root = b * b - a * c;
        if root >= 0.0 {
            (eye + step * ((-b - root.sqrt()) / a), true)
        } else {
            (eye - step * (b / a), false)
        }
    }

    /// Sine of the Sun's elevation where a ray meets the surface or passes nearest, and whether it meets.
    pub fn sun_sine(&self, ray: &Vector3<f64>, height: f64) -> (f64, bool) {
        let (point, meets) = self.nearest(ray, height);
        let normal = point.component_div(&Vector3::new(A_KM, A_KM, B_KM)).normalize();
        (normal.dot(&(self.to_body * self.sun)), meets)
    }

    fn cloud(&self, point: &Vector3<f64>) -> f64 {
        let sum: f64 = self.waves.iter().map(|(wave, phase)| (wave.dot(point) + phase).sin()).sum();
        let share = (0.5 + 0.17 * sum).clamp(0.0, 1.0);
        self.albedo[0] + (self.albedo[1] - self.albedo[0]) * share
    }

    /// Brightness along a ray, counts, and the height at which it passes, km (0 where it meets the ground).
    fn brightness(&self, ray: &Vector3<f64>) -> (f64, f64) {
        let (point, meets) = self.nearest(ray, 0.0);
        let height = if meets { 0.0 } else { (point.norm() - 1.0) * A_KM };
        if height > 150.0 {
            return (0.0, height);
        }
        let normal = point.component_div(&Vector3::new(A_KM, A_KM, B_KM)).normalize();
        let lit = normal.dot(&(self.to_body * self.sun)).max(0.0);
        (self.white * lit * self.cloud(&point.normalize()) * (-height / SCALE_HEIGHT_KM).exp(), height)
    }

    /// The ray of a pixel of the reference camera.
    pub fn ray(x: f64, y: f64) -> Vector3<f64> {
        Vector3::new((x - 639.5) / 3000.0, (y - 511.5) / 3000.0, 1.0).normalize()
    }

    /// Direction of the limb at `height` and an azimuth about the centre (from an arbitrary zero): by
    /// bisection.
    pub fn limb(&self, azimuth: f64, height: f64) -> Vector3<f64> {
        let axis = self.centre.normalize();
        let aside = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
        let first = (aside - axis * axis.dot(&aside)).normalize();
        let radial = first * azimuth.cos() + axis.cross(&first) * azimuth.sin();
        let (mut inside, mut outside) = (0.0, std::f64::consts::FRAC_PI_2);
        for _ in 0..60 {
            let angle: f64 = 0.5 * (inside + outside);
            let ray = axis * angle.cos() + radial * angle.sin();
            if self.nearest(&ray, height).1 { inside = angle } else { outside = angle }
        }
        let angle: f64 = 0.5 * (inside + outside);
        axis * angle.cos() + radial * angle.sin()
    }

    /// The pixels of a window, noise of `noise` counts.
    pub fn expose(&self, window: Window, noise: f64, seed: u64) -> Vec<u16> {
        const EDGE: usize = 5;
        let (width, height) = (usize::from(window.width) + 2 * EDGE, usize::from(window.height) + 2 * EDGE);
        let px = |column: usize, row: usize, dx: f64, dy: f64| {
            let x = f64::from(window.x) + column as f64 - EDGE as f64 + dx;
            let y = f64::from(window.y) + row as f64 - EDGE as f64 + dy;
            Self::ray(x, y)
        };
        let mut clear = std::vec![0.0; width * height];
        for row in 0..height {
            for column in 0..width {
                let ray = px(column, row, 0.0, 0.0);
                let (mut value, _) = self.brightness(&ray);
                // Within five pixels of the limb a pixel is sampled finely.
                let (eye, step) = self.scaled(&ray, 0.0);
                let closest = (eye - step * (eye.dot(&step) / step.dot(&step))).norm();
                let km_per_px = A_KM * eye.norm() / 3000.0;
                if ((closest - 1.0) * A_KM).abs() < 5.0 * km_per_px {
                    const FINE: usize = 5;
                    value = 0.0;
                    for sub in 0..FINE * FINE {
                        let offset = |index: usize| (index as f64 + 0.5) / FINE as f64 - 0.5;
                        value += self.brightness(&px(column, row, offset(sub % FINE), offset(sub / FINE))).0;
                    }
                    value /= (FINE * FINE) as f64;
                }
                clear[row * width + column] = value;
            }
        }
        let kernel: Vec<f64> =
            (0..=2 * EDGE).map(|i| (-0.5 * ((i as f64 - EDGE as f64) / PSF_PX).powi(2)).exp()).collect();
        let total: f64 = kernel.iter().sum();
        let mut across = std::vec![0.0; width * height];
        for row in 0..height {
            for column in EDGE..width - EDGE {
                across[row * width + column] = kernel
                    .iter()
                    .enumerate()
                    .map(|(i, weight)| weight / total * clear[row * width + column + i - EDGE])
                    .sum();
            }
        }
        let mut generator = Generator::new(seed);
        let mut pixels = Vec::new();
        for row in EDGE..height - EDGE {
            for column in EDGE..width - EDGE {
                let blurred: f64 = kernel
                    .iter()
                    .enumerate()
                    .map(|(i, weight)| weight / total * across[(row + i - EDGE) * width + column])
                    .sum();
                let value = DARK + blurred + noise * generator.gaussian();
                pixels.push(value.round().clamp(0.0, 1023.0) as u16);
            }
        }
        pixels
    }

    /// The whole detector.
    pub fn picture(&self, noise: f64, seed: u64) -> Picture {
        Picture { pixels: self.expose(GEOMETRY.whole(), noise, seed) }
    }
}

/// A picture taken by the reference camera.
pub struct Picture {
    pub pixels: Vec<u16>,
}

impl fsw_hal::ErrorType for Picture {
    type Error = DetectorError;
}

impl Detector for Picture {
    fn geometry(&self) -> DetectorGeometry {
        GEOMETRY
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        if !window.fits(&GEOMETRY) {
            return Err(DetectorError::OutsideDetector);
        }
        if pixels.len() != window.area() {
            return Err(DetectorError::BufferLength);
        }
        for (row, target) in pixels.chunks_exact_mut(usize::from(window.width).max(1)).enumerate() {
            let start = (usize::from(window.y) + row) * 1280 + usize::from(window.x);
            target.copy_from_slice(&self.pixels[start..start + usize::from(window.width)]);
        }
        Ok(())
    }
}

/// The Earth in the middle from the geostationary orbit, the Sun at this phase angle from behind the camera.
pub fn geostationary(phase_deg: f64, seed: u64) -> World {
    let (sine, cosine) = phase_deg.to_radians().sin_cos();
    let pole = Vector3::new(0.1, -1.0, 0.05);
    World::new(Vector3::new(120.0, -90.0, GEO_KM), pole, Vector3::new(sine, 0.2, -cosine), seed)
}

/// The horizon across the middle of the field from a low orbit, the Earth's centre `azimuth_deg` from +x
/// towards +y; at the limb there the Sun stands `sun_deg` high, `aside_deg` from the side of the camera.
pub fn low(altitude_km: f64, azimuth_deg: f64, [sun_deg, aside_deg]: [f64; 2], seed: u64) -> World {
    let range = A_KM + altitude_km;
    let off: f64 = (A_KM / range).asin();
    let (sine, cosine) = azimuth_deg.to_radians().sin_cos();
    let centre = Vector3::new(cosine * off.sin(), sine * off.sin(), off.cos()) * range;
    let up = -Vector3::new(cosine, sine, 0.0);
    let (aside, facing) = aside_deg.to_radians().sin_cos();
    let level = up.cross(&Vector3::z()) * aside - Vector3::z() * facing;
    let (high, flat) = sun_deg.to_radians().sin_cos();
    World::new(centre, Vector3::new(0.4, 0.5, 0.7), up * high + level * flat, seed)
}
