//! Where a solved picture looks: right ascension, declination, roll, in double precision.
//!
//! In: the camera and the attitude of a solution. Out: ICRS directions of pixels. The attitude has the
//! precision of the flight code, 1e-7 rad; what is derived from it here adds less than 2e-8 rad.

use crate::flight::lost_in_space::Solution;
use crate::world::attitude::{Vector, apply, dot, matrix, normalised};
use crate::world::vector::transposed;
use fsw_core::camera::Camera;

/// A share of the picture's height over which its upward direction is taken.
const UP_SHARE: f32 = 0.1;

/// Camera and attitude of a solved picture.
#[derive(Clone, Copy, Debug)]
pub struct Pointing {
    /// The camera, its focal length refined.
    pub camera: Camera,
    /// ICRS to sensor.
    pub attitude: [Vector; 3],
}

impl Pointing {
    /// That of a solution; `None` where its quaternion is none.
    pub fn new(solution: &Solution) -> Option<Self> {
        let quaternion = normalised(solution.confirmed.attitude.quaternion().map(f64::from))?;
        Some(Self { camera: solution.camera, attitude: matrix(quaternion) })
    }

    /// Unit vector, ICRS, that falls on a pixel; `None` where the camera sees nothing there.
    pub fn sky(&self, at_px: [f32; 2]) -> Option<Vector> {
        let seen = *self.camera.direction(at_px)?.vector();
        let seen = [seen.x, seen.y, seen.z].map(f64::from);
        let length = dot(seen, seen).sqrt();
        Some(apply(&transposed(&self.attitude), seen.map(|part| part / length)))
    }

    /// Right ascension and declination of the picture's middle, degrees.
    pub fn middle_deg(&self) -> Option<[f64; 2]> {
        self.sky(self.camera.middle_px()).map(ra_dec_deg)
    }

    /// Position angle of the picture's upward direction at its middle, degrees from north through east.
    pub fn roll_deg(&self) -> Option<f64> {
        let [x, y] = self.camera.middle_px();
        let above = self.sky([x, y - UP_SHARE * f32::from(self.camera.parameters().height_px)])?;
        let [east, north] = east_north(self.sky([x, y])?);
        Some(libm::atan2(dot(above, east), dot(above, north)).to_degrees().rem_euclid(360.0))
    }
}

/// Right ascension (0 to 360) and declination of an ICRS direction, degrees.
pub fn ra_dec_deg([x, y, z]: Vector) -> [f64; 2] {
    [libm::atan2(y, x).to_degrees().rem_euclid(360.0), libm::atan2(z, libm::hypot(x, y)).to_degrees()]
}

/// Unit vector of a right ascension and declination, degrees.
pub fn unit_vector([ra_deg, dec_deg]: [f64; 2]) -> Vector {
    let (sine, cosine) = libm::sincos(dec_deg.to_radians());
    let (y, x) = libm::sincos(ra_deg.to_radians());
    [cosine * x, cosine * y, sine]
}

/// Unit vectors towards east and north at an ICRS direction.
pub fn east_north(direction: Vector) -> [Vector; 2] {
    let [ra_deg, dec_deg] = ra_dec_deg(direction);
    let (sin_ra, cos_ra) = libm::sincos(ra_deg.to_radians());
    let (sin_dec, cos_dec) = libm::sincos(dec_deg.to_radians());
    [[-sin_ra, cos_ra, 0.0], [-sin_dec * cos_ra, -sin_dec * sin_ra, cos_dec]]
}
