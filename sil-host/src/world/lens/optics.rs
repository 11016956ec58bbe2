//! Truth projection: from a direction in the sensor frame to a pixel and back, in f64.
//!
//! `x' = X/Z`, `y' = Y/Z`, distorted after Brown in OpenCV's convention with `r² = x'² + y'²`: `x'' = x' (1 +
//! k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x' y' + p2 (r² + 2 x'²)`, `y'' = y' (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2
//! y'²) + 2 p2 x' y'`, pixel `(f x'' + cx, f y'' + cy)`. Back by fixed-point iteration. Where the camera is
//! mirrored, `X` of the star path is turned over before the lens; the Earth path never is. The equiangular
//! projection is not part of the world's first form.

use crate::formats::camera_file::{CameraFile, Distortion, Projection};
use crate::world::attitude::{Vector, dot};

/// The most rounds of the inverse distortion.
const INVERSE_ROUNDS_MAX: u32 = 100;
/// Agreement at which the inverse distortion ends, normalised coordinates (3e-9 px at f = 3000 px).
const INVERSE_TOLERANCE: f64 = 1e-12;

/// A camera without faults but its distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    focal_length_px: f64,
    centre_px: [f64; 2],
    size_px: [f64; 2],
    distortion: Distortion,
    mirrored: bool,
    /// Whether there is no distortion.
    straight: bool,
}

impl Optics {
    /// The star path of `camera`; `None` unless it is rectilinear.
    pub fn new(camera: &CameraFile) -> Option<Self> {
        (camera.projection == Projection::Rectilinear).then_some(Self {
            focal_length_px: camera.focal_length_px,
            centre_px: camera.optical_centre_px,
            size_px: [f64::from(camera.width_px), f64::from(camera.height_px)],
            distortion: camera.distortion,
            mirrored: camera.mirrored,
            straight: camera.distortion == Distortion::default(),
        })
    }

    /// The other path through the same lens, which no mirror turns over: the Earth path.
    pub fn earth_path(&self) -> Self {
        Self { mirrored: false, ..*self }
    }

    /// x of a direction as the lens sees it, behind the mirror where there is one; its own inverse.
    fn through_mirror(&self, x: f64) -> f64 {
        if self.mirrored { -x } else { x }
    }

    /// Where `direction` (sensor frame, any length) is imaged, px; `None` at or behind the detector's plane.
    pub fn project(&self, direction: Vector) -> Option<[f64; 2]> {
        let [x, y, z] = direction;
        if z <= 1e-6 {
            return None;
        }
        let [x, y] = self.distort([self.through_mirror(x) / z, y / z]);
        Some([self.focal_length_px * x + self.centre_px[0], self.focal_length_px * y + self.centre_px[1]])
    }

    /// The unit vector in the sensor frame that is imaged at `pixel`; `None` where the distortion has no
    /// inverse.
    pub fn unproject(&self, pixel: [f64; 2]) -> Option<Vector> {
        let [x, y] = self.normalised(pixel)?;
        let length = (1.0 + x * x + y * y).sqrt();
        Some([self.through_mirror(x) / length, y / length, 1.0 / length])
    }

    /// The undistorted `[X/Z, Y/Z]` before the lens, behind any mirror, that is imaged at `pixel`; `None`
    /// where the distortion has no inverse.
    #[inline]
    pub fn normalised(&self, pixel: [f64; 2]) -> Option<[f64; 2]> {
        let seen = [0, 1].map(|k| (pixel[k] - self.centre_px[k]) / self.focal_length_px);
        if self.straight { Some(seen) } else { self.undistorted(seen) }
    }

    fn undistorted(&self, seen: [f64; 2]) -> Option<[f64; 2]> {
        let mut guess = seen;
        for _ in 0..INVERSE_ROUNDS_MAX {
            let distorted = self.distort(guess);
            let step = [seen[0] - distorted[0], seen[1] - distorted[1]];
            guess = [guess[0] + step[0], guess[1] + step[1]];
            if step[0].abs().max(step[1].abs()) < INVERSE_TOLERANCE {
                return Some(guess);
            }
        }
        None
    }

    /// Whether `pixel` lies on the detector.
    pub fn on_detector(&self, pixel: [f64; 2]) -> bool {
        (0..2).all(|k| pixel[k] >= -0.5 && pixel[k] < self.size_px[k] - 0.5)
    }

    /// How far inside the detector `pixel` lies, px; negative outside.
    pub fn inside_px(&self, pixel: [f64; 2]) -> f64 {
        [0, 1]
            .map(|k| (pixel[k] + 0.5).min(self.size_px[k] - 0.5 - pixel[k]))
            .into_iter()
            .fold(f64::MAX, f64::min)
    }

    /// The place on the detector nearest to `pixel`.
    pub fn clamped(&self, pixel: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| pixel[k].clamp(-0.5, self.size_px[k] - 0.5))
    }

    /// Where the optical axis meets the detector, px.
    pub fn centre_px(&self) -> [f64; 2] {
        self.centre_px
    }

    /// Focal length, px.
    pub fn focal_length_px(&self) -> f64 {
        self.focal_length_px
    }

    /// Whether a mirror turns the path over.
    pub fn mirrored(&self) -> bool {
        self.mirrored
    }

    /// Components across the line of sight as the lens has them, behind the mirror where there is one.
    pub fn lens_axes(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.through_mirror(x), y]
    }

    /// Place of the line of sight on the detector, px.
    pub fn optical_centre_px(&self) -> [f64; 2] {
        self.centre_px
    }

    /// Columns and rows of the detector, px.
    pub fn size_px(&self) -> [f64; 2] {
        self.size_px
    }

    /// Half the diagonal of the detector, measured from the optical centre to the farthest corner, px.
    pub fn radius_px(&self) -> f64 {
        let reach = [0, 1].map(|k| (self.centre_px[k] + 0.5).max(self.size_px[k] - 0.5 - self.centre_px[k]));
        libm::hypot(reach[0], reach[1])
    }

    /// A cone about the line of sight that holds all that is imaged within `margin_px` of the detector: the
    /// cosine of its half angle. It also keeps away directions so far off that the distortion's polynomial
    /// folds them back.
    pub fn cone_cosine(&self, margin_px: f64) -> f64 {
        let [w, h] = self.size_px;
        let (low, m) = (-0.5 - margin_px, margin_px - 0.5);
        let xs = [low, self.centre_px[0].clamp(low, w + m), w + m];
        let ys = [low, self.centre_px[1].clamp(low, h + m), h + m];
        let mut least = 1.0f64;
        for pixel in xs.iter().flat_map(|x| ys.map(|y| [*x, y])) {
            let plain = [pixel[0] - self.centre_px[0], pixel[1] - self.centre_px[1], self.focal_length_px];
            let plain_cosine = self.focal_length_px / dot(plain, plain).sqrt();
            least = least.min(self.unproject(pixel).map_or(plain_cosine, |d| d[2]));
        }
        // A hundredth more in angle, for edges that bulge between the points looked at.
        libm::cos(1.01 * libm::acos(least))
    }

    fn distort(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Distortion { k1, k2, k3, p1, p2 } = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn distorted() -> Optics {
        let mut camera = CameraFile::reference();
        camera.distortion = Distortion { k1: -0.12, k2: 0.05, k3: -0.01, p1: 1e-3, p2: -7e-4 };
        Optics::new(&camera).unwrap()
    }

    #[test]
    fn an_undistorted_direction_lands_where_the_conventions_say() {
        let optics = Optics::new(&CameraFile::reference()).unwrap();
        assert_eq!(optics.project([0.0, 0.0, 2.0]), Some([639.5, 511.5]));
        let [x, y] = optics.project([0.1, -0.05, 1.0]).unwrap();
        assert!((x - 939.5).abs() < 1e-9 && (y - 361.5).abs() < 1e-9);
        assert_eq!(optics.project([0.1, 0.0, -1.0]), None);
    }

    #[test]
    fn the_distortion_is_the_one_of_the_worked_example() {
        // By hand for x' = 0.2, y' = -0.1: r² = 0.05, radial = 1 - 0.006 + 0.000125 - 0.00000125 =
        // 0.99412375.
        let [x, y] = distorted().project([0.2, -0.1, 1.0]).unwrap();
        let dx = 0.2 * 0.994_123_75 + 2.0 * 1e-3 * -0.02 - 7e-4 * 0.13;
        let dy = -0.1 * 0.994_123_75 + 1e-3 * 0.07 + 2.0 * -7e-4 * -0.02;
        assert!((x - 639.5 - 3000.0 * dx).abs() < 1e-9 && (y - 511.5 - 3000.0 * dy).abs() < 1e-9);
    }

    #[test]
    fn an_equiangular_camera_is_refused() {
        let camera = CameraFile { projection: Projection::Equiangular, ..CameraFile::reference() };
        assert!(Optics::new(&camera).is_none());
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same_pixel(x in -0.5..1279.5f64, y in -0.5..1023.5f64) {
            let optics = distorted();
            let direction = optics.unproject([x, y]).unwrap();
            let [bx, by] = optics.project(direction).unwrap();
            prop_assert!((x - bx).abs() < 1e-7 && (y - by).abs() < 1e-7);
            prop_assert!(direction[2] >= optics.cone_cosine(0.0));
            prop_assert!(optics.on_detector([x, y]));
        }
    }
}
