//! From pixels to directions in the frames of the two paths, and back (thesis eq. 3.2).
//!
//! In: pixel coordinates (x right, y down, first pixel's centre (0, 0)). Out: unit vectors, x along +x px, y
//! along +y px, z out along the line of sight. Rectilinear: the undistorted direction of a pixel is `((x -
//! cx) / f, (y - cy) / f, 1)`; equiangular: the distance from the optical centre is `f` times the angle from
//! the line of sight.
//!
//! Both paths share lens and detector; the Earth path is transmitted by the partial mirror, the star path
//! reflected, which turns its image over (determinant -1). Where the camera is `mirrored`, x of the star path
//! therefore runs along -x px, so that its frame is right-handed and an attitude is a rotation.
//!
//! Distortion is Brown's model on the normalised plane: `distorted = undistorted radial + tangential(p1, p2)`
//! with `radial = 1 + k1 r² + k2 r⁴ + k3 r⁶`. It is undone by [`UNDISTORT_STEPS`] fixed-point steps, each of
//! which shrinks the error to about `2 |k1| r²` of it; lenses with more than 10 % distortion at the corner
//! need a correction table instead.
//!
//! Of the light of an even surface a pixel at the angle `a` from the line of sight gets `cos⁴ a (1 - l (r /
//! R)²)` of what the optical centre's gets: its solid angle and the aperture's foreshortening, and what the
//! lens's mounts take, `l` in the farthest corner, `R` away.
//!
//! Error of a pixel's direction and back again, greatest over the whole reference detector: 1e-4 px without
//! and with distortion (k1 = -0.2, 0.9 % at 12 deg, and tangential), 3e-4 px equiangular.

pub mod focal_length;

use crate::frames::{Direction, EarthPath, StarPath};
use crate::trigonometry::sine_cosine;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Fixed-point steps that undo the distortion.
pub const UNDISTORT_STEPS: usize = 8;
/// Least z of a direction in the field: 87 deg off the line of sight.
const LEAST_FORWARD: f32 = 0.05;
/// Greatest error of undoing the distortion that is accepted at the detector's corners, px.
const UNDISTORT_ERROR_PX: f32 = 0.5;
/// How far below the corners' cosine that of a direction on the detector may fall: by rounding, and by a
/// tangential distortion, which bends the detector's edges.
const CORNER_ROUNDING: f32 = 1e-3;

/// Greatest share of the light that the mounts may take in the farthest corner.
const GREATEST_CORNER_LOSS: f32 = 0.9;

/// Ideal projection of the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Projection {
    /// Pinhole: radius `f tan(angle)`.
    Rectilinear,
    /// Radius `f angle` (scan grids of weather satellites).
    Equiangular,
}

/// Coefficients of Brown's distortion model, on the normalised image plane (no unit).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distortion {
    /// Radial, second order.
    pub k1: f32,
    /// Radial, fourth order.
    pub k2: f32,
    /// Radial, sixth order.
    pub k3: f32,
    /// Tangential, along y.
    pub p1: f32,
    /// Tangential, along x.
    pub p2: f32,
}

/// Lens and detector.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraParameters {
    /// Columns, px.
    pub width_px: u16,
    /// Rows, px.
    pub height_px: u16,
    /// Focal length, px.
    pub focal_length_px: f32,
    /// Principal point, px.
    pub optical_centre_px: [f32; 2],
    /// Ideal projection.
    pub projection: Projection,
    /// Distortion.
    pub distortion: Distortion,
    /// Share of the light that the lens's mounts take in the farthest corner; 0 where it is not known.
    pub corner_loss: f32,
    /// Whether the star path is mirrored in x.
    pub mirrored: bool,
}

/// Why camera parameters were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraError {
    /// A value is NaN or infinite.
    NotFinite,
    /// The detector is smaller than 32 px a side.
    Detector,
    /// The focal length is not between 10 and 1e6 px.
    FocalLength,
    /// The optical centre is more than a detector's size off the detector.
    OpticalCentre,
    /// The loss in the corner is not between 0 and 0.9.
    CornerLoss,
    /// A corner of the detector has no direction, or the distortion cannot be inverted there.
    Distortion,
}

impl core::fmt::Display for CameraError {
    fn fmt(&self, out: &mut core::fmt::Formatter) -> core::fmt::Result {
        out.write_str(match self {
            Self::NotFinite => "a value is not finite",
            Self::Detector => "the detector is smaller than 32 px a side",
            Self::FocalLength => "the focal length is not between 10 and 1e6 px",
            Self::OpticalCentre => "the optical centre is more than a detector's size off the detector",
            Self::CornerLoss => "the loss in the corner is not between 0 and 0.9",
            Self::Distortion => {
                "a corner of the detector sees no direction, or the distortion cannot be undone there"
            }
        })
    }
}

/// A camera whose parameters have been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    parameters: CameraParameters,
    per_focal_length: f32,
    /// Cosine of the angle from the line of sight to the farthest corner.
    corner_forward: f32,
    /// Share of the light that the mounts take, per squared distance from the optical centre, 1/px².
    mounts_per_px2: f32,
}

impl Camera {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first check that fails, see [`CameraError`].
    pub fn new(parameters: CameraParameters) -> Result<Self, CameraError> {
        let CameraParameters { width_px, height_px, focal_length_px: f, corner_loss, .. } = parameters;
        let [cx, cy] = parameters.optical_centre_px;
        let Distortion { k1, k2, k3, p1, p2 } = parameters.distortion;
        if ![f, cx, cy, k1, k2, k3, p1, p2, corner_loss].iter().all(|value| value.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if width_px < 32 || height_px < 32 {
            return Err(CameraError::Detector);
        }
        if !(10.0..=1e6).contains(&f) {
            return Err(CameraError::FocalLength);
        }
        let (width, height) = (f32::from(width_px), f32::from(height_px));
        if !(-width..=2.0 * width).contains(&cx) || !(-height..=2.0 * height).contains(&cy) {
            return Err(CameraError::OpticalCentre);
        }
        if !(0.0..=GREATEST_CORNER_LOSS).contains(&corner_loss) {
            return Err(CameraError::CornerLoss);
        }
        let camera = Self { parameters, per_focal_length: 1.0 / f, corner_forward: 0.0, mounts_per_px2: 0.0 };
        let corner_forward = camera.forward_of_corners().ok_or(CameraError::Distortion)?;
        let square_px2 = |corner| camera.off_centre_px2(corner);
        let farthest_px2 = camera.corners_px().into_iter().map(square_px2).fold(1.0f32, f32::max);
        Ok(Self { corner_forward, mounts_per_px2: corner_loss / farthest_px2, ..camera })
    }

    /// Cosine of the angle from the line of sight to the farthest corner; `None` unless every corner has a
    /// direction that falls on it again: a distortion that folds the field has none.
    fn forward_of_corners(&self) -> Option<f32> {
        self.corners_px().into_iter().try_fold(1.0f32, |least, corner| {
            let direction = self.direction(corner)?;
            let [x, y] = self.project(&direction)?;
            let (dx, dy) = (x - corner[0], y - corner[1]);
            let falls_on_it = dx * dx + dy * dy < UNDISTORT_ERROR_PX * UNDISTORT_ERROR_PX;
            falls_on_it.then_some(least.min(direction.vector().z))
        })
    }

    /// The checked parameters.
    pub fn parameters(&self) -> &CameraParameters {
        &self.parameters
    }

    /// The camera as the Earth path has it, which no mirror turns over: what is said of a star path holds for
    /// the Earth path then.
    pub fn of_earth_path(&self) -> Self {
        Self { parameters: CameraParameters { mirrored: false, ..self.parameters }, ..*self }
    }

    /// Radians that a pixel spans at the optical centre.
    pub fn rad_per_px(&self) -> f32 {
        self.per_focal_length
    }

    /// Number of pixels of the detector.
    pub fn area_px(&self) -> f32 {
        f32::from(self.parameters.width_px) * f32::from(self.parameters.height_px)
    }

    /// Pixel of the detector's middle.
    pub fn middle_px(&self) -> [f32; 2] {
        [
            (f32::from(self.parameters.width_px) - 1.0) * 0.5,
            (f32::from(self.parameters.height_px) - 1.0) * 0.5,
        ]
    }

    /// Pixels of the detector's corners.
    pub fn corners_px(&self) -> [[f32; 2]; 4] {
        let [right, bottom] = self.middle_px().map(|half| 2.0 * half);
        [[0.0, 0.0], [right, 0.0], [0.0, bottom], [right, bottom]]
    }

    /// Square of the distance from the optical centre, px².
    fn off_centre_px2(&self, [x, y]: [f32; 2]) -> f32 {
        let [cx, cy] = self.parameters.optical_centre_px;
        (x - cx) * (x - cx) + (y - cy) * (y - cy)
    }

    /// Light of an even surface at a pixel position of the detector, as a share of that at the optical
    /// centre. The distortion is left out: of 1 % of the place it changes 0.2 % of the light in the corner.
    pub fn light_share(&self, at_px: [f32; 2]) -> f32 {
        let square_px2 = self.off_centre_px2(at_px);
        let square = square_px2 * self.per_focal_length * self.per_focal_length;
        let forward2 = match self.parameters.projection {
            Projection::Rectilinear => 1.0 / (1.0 + square),
            // cos² a to 1 % within 40 deg.
            Projection::Equiangular => 1.0 / (1.0 + square * (1.0 + square * (2.0 / 3.0))),
        };
        let mounts = 1.0 - self.mounts_per_px2 * square_px2;
        forward2 * forward2 * mounts.max(1.0 - GREATEST_CORNER_LOSS)
    }

    /// Whether a pixel position lies on the detector, `margin_px` inside its edge.
    pub fn contains(&self, [x, y]: [f32; 2], margin_px: f32) -> bool {
        let (right, bottom) = (f32::from(self.parameters.width_px), f32::from(self.parameters.height_px));
        x >= margin_px && y >= margin_px && x <= right - 1.0 - margin_px && y <= bottom - 1.0 - margin_px
    }

    /// How far inside the detector's outermost pixels a place is that is a number; negative outside.
    pub(crate) fn inside_px(&self, [x, y]: [f32; 2]) -> f32 {
        let (right, bottom) = (f32::from(self.parameters.width_px), f32::from(self.parameters.height_px));
        x.min(y).min(right - 1.0 - x).min(bottom - 1.0 - y)
    }

    /// Distortion at a point of the normalised plane: radial factor and tangential shift.
    fn distortion_at(&self, x: f32, y: f32) -> (f32, f32, f32) {
        let Distortion { k1, k2, k3, p1, p2 } = self.parameters.distortion;
        let square = x * x + y * y;
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
        let shift_x = 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x);
        let shift_y = p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y;
        (radial, shift_x, shift_y)
    }

    /// The star path's direction that falls on a pixel position; `None` when it is not finite, or that
    /// direction would be more than 87 deg off the line of sight.
    pub fn direction(&self, at_px: [f32; 2]) -> Option<Direction<StarPath>> {
        self.ray(at_px).map(|ray| self.mirrored_x(ray)).and_then(Direction::new)
    }

    /// The Earth path's direction that falls on a pixel position; `None` as for [`Camera::direction`].
    pub fn earth_direction(&self, at_px: [f32; 2]) -> Option<Direction<EarthPath>> {
        self.ray(at_px).and_then(Direction::new)
    }

    /// Where a direction of the star path falls, px (perhaps outside the detector); `None` behind the camera
    /// and more than 87 deg off its line of sight.
    pub fn project(&self, direction: &Direction<StarPath>) -> Option<[f32; 2]> {
        self.image(self.mirrored_x(*direction.vector()))
    }

    /// Where a direction of the Earth path falls, px; otherwise as [`Camera::project`].
    pub fn project_earth(&self, direction: &Direction<EarthPath>) -> Option<[f32; 2]> {
        self.image(*direction.vector())
    }

    /// Where on the detector, `margin_px` inside its edge, a direction of the Earth path falls; `None` where
    /// it does not.
    pub fn project_earth_inside(&self, direction: &Direction<EarthPath>, margin_px: f32) -> Option<[f32; 2]> {
        // Outside the field the distortion polynomial may fold directions back onto the detector.
        if direction.vector().z < self.corner_forward - CORNER_ROUNDING {
            return None;
        }
        self.project_earth(direction).filter(|at_px| self.contains(*at_px, margin_px))
    }

    /// Whether a vector of the Earth path, of any length, is surely outside the cone about the field: a first
    /// question without a root.
    pub(crate) fn is_far_outside(&self, vector: &Vector3<f32>) -> bool {
        let least = self.corner_forward - 2.0 * CORNER_ROUNDING;
        vector.z <= 0.0 || vector.z * vector.z < least * least * vector.dot(vector)
    }

    /// Whether a disc of `radius_rad` about a direction of the star path touches the detector.
    pub fn star_field_meets(&self, direction: &Direction<StarPath>, radius_rad: f32) -> bool {
        self.field_meets(&self.mirrored_x(*direction.vector()), radius_rad)
    }

    /// The same of the Earth path.
    pub fn earth_field_meets(&self, direction: &Direction<EarthPath>, radius_rad: f32) -> bool {
        self.field_meets(direction.vector(), radius_rad)
    }

    /// Whether a disc about a unit vector in detector axes touches the detector: by the chord to the nearest
    /// place on it.
    fn field_meets(&self, unit: &Vector3<f32>, radius_rad: f32) -> bool {
        // Farther from the corners than twice the disc the distortion polynomial may fold.
        let sine = libm::sqrtf((1.0 - self.corner_forward * self.corner_forward).max(0.0));
        if unit.z < self.corner_forward - 2.0 * radius_rad * sine - CORNER_ROUNDING {
            return false;
        }
        let [width, height] = [self.parameters.width_px, self.parameters.height_px].map(f32::from);
        let nearest = self
            .image(*unit)
            // `clamp` would leave a panic in the image.
            .map(|[x, y]| [x.max(-0.5).min(width - 0.5), y.max(-0.5).min(height - 0.5)])
            .and_then(|at_px| self.ray(at_px));
        nearest.is_some_and(|ray| {
            let apart = ray * (1.0 / libm::sqrtf(ray.dot(&ray))) - unit;
            apart.dot(&apart) <= radius_rad * radius_rad
        })
    }

    /// A vector of the star path in detector axes, or back: a mirror changes the sign of x.
    fn mirrored_x(&self, vector: Vector3<f32>) -> Vector3<f32> {
        if self.parameters.mirrored { Vector3::new(-vector.x, vector.y, vector.z) } else { vector }
    }

    /// A vector, in detector axes, that falls on a pixel position.
    fn ray(&self, [x_px, y_px]: [f32; 2]) -> Option<Vector3<f32>> {
        let [cx, cy] = self.parameters.optical_centre_px;
        let (seen_x, seen_y) = ((x_px - cx) * self.per_focal_length, (y_px - cy) * self.per_focal_length);
        let (mut x, mut y) = (seen_x, seen_y);
        for _ in 0..UNDISTORT_STEPS {
            let (radial, shift_x, shift_y) = self.distortion_at(x, y);
            (x, y) = ((seen_x - shift_x) / radial, (seen_y - shift_y) / radial);
        }
        match self.parameters.projection {
            Projection::Rectilinear => {
                // The cosine of its angle from the axis is one over the root of this.
                let square = x * x + y * y + 1.0;
                (square < 1.0 / (LEAST_FORWARD * LEAST_FORWARD)).then_some(Vector3::new(x, y, 1.0))
            }
            Projection::Equiangular => {
                let angle = libm::sqrtf(x * x + y * y);
                if angle > core::f32::consts::FRAC_PI_2 {
                    return None;
                }
                let (sine, forward) = sine_cosine(angle);
                let sine_per_angle = if angle > 1e-4 { sine / angle } else { 1.0 };
                (forward > LEAST_FORWARD).then_some(Vector3::new(
                    x * sine_per_angle,
                    y * sine_per_angle,
                    forward,
                ))
            }
        }
    }

    /// Where a unit vector in detector axes falls, px.
    fn image(&self, unit: Vector3<f32>) -> Option<[f32; 2]> {
        if unit.z <= LEAST_FORWARD {
            return None;
        }
        let scale = match self.parameters.projection {
            Projection::Rectilinear => 1.0 / unit.z,
            Projection::Equiangular => {
                let sine = libm::sqrtf(unit.x * unit.x + unit.y * unit.y);
                if sine > 1e-4 { libm::atan2f(sine, unit.z) / sine } else { 1.0 }
            }
        };
        let (x, y) = (unit.x * scale, unit.y * scale);
        let (radial, shift_x, shift_y) = self.distortion_at(x, y);
        let [cx, cy] = self.parameters.optical_centre_px;
        let f = self.parameters.focal_length_px;
        Some([cx + f * (x * radial + shift_x), cy + f * (y * radial + shift_y)])
    }

    /// The same camera with another focal length (refined on a solved field).
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn with_focal_length(&self, focal_length_px: f32) -> Result<Self, CameraError> {
        Self::new(CameraParameters { focal_length_px, ..self.parameters })
    }
}

#[cfg(test)]
mod tests;
