//! The Earth.

use super::attitude::{Vector, apply, dot};
use super::vector::{cross, length, minus, plus, times, unit};

/// Equatorial radius (WGS84), km.
pub const EQUATOR_KM: f64 = 6378.137;
/// Polar radius (WGS84), km.
pub const POLE_KM: f64 = 6_356.752_314_245;

/// The looks of the Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarthModel {
    /// From 0 (the same albedo everywhere) to 1.
    pub cloud_contrast: f64,
    /// Whether the satellite's motion shifts the Earth's image by v/c (5 arcsec in a low orbit), as it does in nature.
    pub aberration: bool,
}

impl Default for EarthModel {
    fn default() -> Self {
        Self { cloud_contrast: 1.0, aberration: true }
    }
}

/// The ellipsoid, seen from a place. Axes: ICRS.
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoid {
    equator: [Vector; 3],
    /// The place in axes in which the ellipsoid is a unit sphere.
    place: Vector,
    position: Vector,
}

/// Steps of the azimuth about the Earth's centre.
const AZIMUTHS: u32 = 720;
/// Sine of the Sun's elevation (3 deg) from which a limb point counts as lit.
const LIT_SINE: f64 = 0.052_336;

impl Ellipsoid {
    /// `equator`: ICRS to equator of date; `position` of the observer, ICRS, km.
    pub fn new(equator: &[Vector; 3], position: Vector) -> Self {
        let mut ellipsoid = Self { equator: *equator, place: [0.0; 3], position };
        ellipsoid.place = ellipsoid.to_sphere(position);
        ellipsoid
    }

    fn to_sphere(&self, v: Vector) -> Vector {
        let [x, y, z] = apply(&self.equator, v);
        [x / EQUATOR_KM, y / EQUATOR_KM, z / POLE_KM]
    }

    /// Normal at the point of the sphere `p`, ICRS, unit.
    fn normal(&self, [x, y, z]: Vector) -> Vector {
        let gradient = [x / EQUATOR_KM, y / EQUATOR_KM, z / POLE_KM];
        unit(apply(&super::vector::transposed(&self.equator), gradient))
    }

    /// Whether a disc of `radius_rad` about `direction` is hidden whole.
    pub fn hides(&self, direction: Vector, radius_rad: f64) -> bool {
        let d = self.to_sphere(direction);
        let (a, b) = (dot(d, d), dot(self.place, d));
        if b >= 0.0 {
            return false;
        }
        let way = -b / a;
        let nearest = plus(self.place, way, d);
        let rho = length(nearest);
        let [x, y, z] = nearest;
        let slope = length([x / EQUATOR_KM, y / EQUATOR_KM, z / POLE_KM]) / rho;
        let height = (rho - 1.0) / slope;
        let distance = way * length(direction);
        height < -radius_rad * distance
    }

    /// Degrees of azimuth of limb that is lit by `sun` and `on_detector`.
    pub fn lit_limb_deg(&self, sun: Vector, on_detector: impl Fn(Vector) -> bool) -> f64 {
        let far = length(self.place);
        let up = times(far.recip(), self.place);
        let aside = if up[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let e1 = unit(cross(aside, up));
        let e2 = cross(up, e1);
        let (depth, radius) = (far.recip(), (1.0 - 1.0 / (far * far)).max(0.0).sqrt());
        let lit = |k: &u32| {
            let (s, c) = libm::sincos(std::f64::consts::TAU * f64::from(*k) / f64::from(AZIMUTHS));
            let point = plus(plus(times(depth, up), radius * c, e1), radius * s, e2);
            if dot(self.normal(point), sun) <= LIT_SINE {
                return false;
            }
            let [x, y, z] = point;
            let of_date = [x * EQUATOR_KM, y * EQUATOR_KM, z * POLE_KM];
            let place = apply(&super::vector::transposed(&self.equator), of_date);
            on_detector(minus(place, self.position))
        };
        (0..AZIMUTHS).filter(lit).count() as f64 * 360.0 / f64::from(AZIMUTHS)
    }
}
