//! The figure of a body, seen from a place.
//!
//! In: the equator of date, a position, directions (ICRS). Out: whether a direction is hidden, how much of
//! the limb is lit. In axes stretched by (1/a, 1/a, 1/b) the ellipsoid is a unit sphere; the ray `p + s
//! d` comes closest to its centre at `s = -p'd' / d'd'`, in the distance `rho`. Its height above the
//! ellipsoid there is `(rho - 1) / |grad rho|`, right to 0.01 km up to 100 km.

use super::{EQUATOR_KM, POLE_KM};
use crate::world::attitude::{Vector, apply, dot};
use crate::world::vector::{cross, length, minus, plus, times, transposed, unit};
use fsw_core::orbit::body::CentralBody;
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Steps of the azimuth about the Earth's centre.
const AZIMUTHS: u32 = 720;
/// Sine and cosine of each.
static CIRCLE: LazyLock<Vec<(f64, f64)>> =
    LazyLock::new(|| (0..AZIMUTHS).map(|k| libm::sincos(TAU * f64::from(k) / f64::from(AZIMUTHS))).collect());
/// Halvings of a step in search of the last lit limb: to 0.0005 deg.
const BETWEEN: u32 = 10;
/// Sine of the Sun's elevation from which a limb point counts as lit (3 deg).
const LIT_SINE: f64 = 0.052_336;

/// Half axes of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// To the equator, km.
    pub equator_km: f64,
    /// To the pole, km.
    pub pole_km: f64,
}

impl Figure {
    /// Those of a body: the Earth's to the digits of WGS84.
    pub fn of(body: CentralBody) -> Self {
        let facts = body.facts();
        match body {
            CentralBody::Earth => Self { equator_km: EQUATOR_KM, pole_km: POLE_KM },
            _ => Self { equator_km: facts.radius_km, pole_km: facts.polar_km },
        }
    }

    /// Stretches equatorial axes so that the ellipsoid becomes a unit sphere. Of a point of that sphere it
    /// gives the ellipsoid's normal there, not of unit length.
    pub fn to_sphere(&self, [x, y, z]: Vector) -> Vector {
        let per_equator = 1.0 / self.equator_km;
        [x * per_equator, y * per_equator, z * (1.0 / self.pole_km)]
    }
}

/// The ellipsoid and a place outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    body: CentralBody,
    figure: Figure,
    equator: [Vector; 3],
    position: Vector,
    /// The place in the axes in which the ellipsoid is a unit sphere.
    place: Vector,
}

impl Ellipsoid {
    /// `equator`: ICRS to equator of date; `position` of the observer, ICRS, km.
    pub fn new(body: CentralBody, equator: &[Vector; 3], position: Vector) -> Self {
        let figure = Figure::of(body);
        Self { body, figure, equator: *equator, position, place: figure.to_sphere(apply(equator, position)) }
    }

    /// What body it is.
    pub fn body(&self) -> CentralBody {
        self.body
    }

    /// Its half axes.
    pub fn figure(&self) -> &Figure {
        &self.figure
    }

    /// ICRS to the equator of date.
    pub fn equator(&self) -> &[Vector; 3] {
        &self.equator
    }

    /// Height above the ellipsoid (negative: below) of the point of the ray along `direction` that is nearest
    /// to it, and the distance to there, both km; `None` when the ray leads away.
    pub fn height_km(&self, direction: Vector) -> Option<(f64, f64)> {
        let d = self.figure.to_sphere(apply(&self.equator, direction));
        let way = -dot(self.place, d) / dot(d, d);
        if way <= 0.0 {
            return None;
        }
        let nearest = plus(self.place, way, d);
        let rho = length(nearest);
        Some(((rho - 1.0) * rho / length(self.figure.to_sphere(nearest)), way * length(direction)))
    }

    /// Whether a disc of `radius_rad` about `direction` is hidden whole.
    pub fn hides(&self, direction: Vector, radius_rad: f64) -> bool {
        self.height_km(direction).is_some_and(|(height, distance)| height < -radius_rad * distance)
    }

    /// The limb about the Earth's centre: of sine and cosine of an azimuth the ellipsoid's normal and the
    /// place, ICRS, km.
    fn limb_at(&self) -> impl Fn((f64, f64)) -> (Vector, Vector) {
        let to_icrs = transposed(&self.equator);
        let far = length(self.place);
        let up = times(far.recip(), self.place);
        let aside = if up[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let east = unit(cross(aside, up));
        let north = cross(up, east);
        // The limb of a unit sphere is a circle in the plane 1 / far from its centre.
        let (depth, radius) = (far.recip(), (1.0 - 1.0 / (far * far)).max(0.0).sqrt());
        let figure = self.figure;
        move |(s, c)| {
            let point = plus(plus(times(depth, up), radius * c, east), radius * s, north);
            let [x, y, z] = point;
            let Figure { equator_km, pole_km } = figure;
            let place = [x * equator_km, y * equator_km, z * pole_km];
            (apply(&to_icrs, unit(figure.to_sphere(point))), apply(&to_icrs, place))
        }
    }

    /// Points of the limb, evenly about the Earth's centre: the ellipsoid's normal and the place, ICRS, km.
    pub fn limb(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let at = self.limb_at();
        CIRCLE.iter().map(move |azimuth| at(*azimuth))
    }

    /// Those points of the limb that the Sun, in direction `sun`, lights from more than 3 deg above the horizon,
    /// and that lie where `on_detector` says so of the way to them.
    pub fn lit_limb(
        &self,
        sun: Vector,
        on_detector: impl Fn(Vector) -> bool,
    ) -> impl Iterator<Item = (Vector, Vector)> {
        self.limb().filter(move |(normal, place)| {
            dot(*normal, sun) > LIT_SINE && on_detector(minus(*place, self.position))
        })
    }

    /// How many degrees of azimuth about the Earth's centre they are.
    pub fn lit_limb_deg(&self, sun: Vector, on_detector: impl Fn(Vector) -> bool) -> f64 {
        self.lit_limb(sun, on_detector).count() as f64 * 360.0 / f64::from(AZIMUTHS)
    }

    /// Whether any of the limb is lit by as much and lies where `inside_rad` of the way to it is positive,
    /// however little of it.
    pub fn has_lit_limb(&self, sun: Vector, inside_rad: impl Fn(Vector) -> f64) -> bool {
        let at = self.limb_at();
        // The Sun above the elevation, or how far inside, the less of both.
        let margin = |azimuth| {
            let (normal, place) = at(azimuth);
            (dot(normal, sun) - LIT_SINE).min(inside_rad(minus(place, self.position)))
        };
        let greater = |a: (f64, f64), b: (f64, f64)| if b.0 > a.0 { b } else { a };
        let all = (0..).zip(CIRCLE.iter()).map(|(step, azimuth)| (margin(*azimuth), f64::from(step)));
        let mut best = all.fold((f64::MIN, 0.0), greater);
        // The last of it lies between two of these.
        let between = |step: f64| (margin(libm::sincos(TAU * step / f64::from(AZIMUTHS))), step);
        for halvings in 1..=BETWEEN {
            let beside = 1.0 / f64::from(1 << halvings);
            best = [best.1 - beside, best.1 + beside].map(between).into_iter().fold(best, greater);
        }
        best.0 > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EQUATOR: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn a_ray_passes_the_equator_and_the_pole_at_the_height_it_should() {
        let seen = Ellipsoid::new(CentralBody::Earth, &EQUATOR, [42_164.0, 0.0, 0.0]);
        // From the equatorial plane, rays at right angles to the radius of the point they pass.
        for (radius, height) in [(EQUATOR_KM + 20.0, 20.0), (EQUATOR_KM - 5.0, -5.0)] {
            let sine = radius / 42_164.0;
            let (h, s) = seen.height_km([-(1.0 - sine * sine).sqrt(), sine, 0.0]).unwrap();
            assert!(
                (h - height).abs() < 1e-6 && (s - (42_164f64.powi(2) - radius * radius).sqrt()).abs() < 1e-6
            );
        }
        // Over the pole: the ray's own nearest point, found by walking along it.
        let direction = unit([-42_164.0, 0.0, 6450.0]);
        let above = |s: f64| {
            let [x, _, z] = plus([42_164.0, 0.0, 0.0], s, direction);
            // Distance to the ellipse by Newton's foot point of a latitude.
            let mut best = f64::MAX;
            for k in -2000..=2000 {
                let latitude = libm::atan2(z, x) + f64::from(k) * 5e-6;
                let (s, c) = libm::sincos(latitude);
                best = best.min(libm::hypot(x - EQUATOR_KM * c, z - POLE_KM * s));
            }
            best
        };
        let (h, s) = seen.height_km(direction).unwrap();
        let lowest = (-400..=400).map(|k| above(s + f64::from(k))).fold(f64::MAX, f64::min);
        assert!((h - lowest).abs() < 0.02, "{h} {lowest}");
        assert_eq!(seen.height_km([1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn half_the_limb_is_lit_from_the_side_less_what_the_low_sun_leaves() {
        let seen = Ellipsoid::new(CentralBody::Earth, &EQUATOR, [42_164.0, 0.0, 0.0]);
        // Sun at right angles to the line to the Earth: limb points at azimuth phi have sine cos(rho)
        // cos(phi).
        let expected =
            2.0 * (LIT_SINE / (1.0 - (EQUATOR_KM / 42_164.0f64).powi(2)).sqrt()).acos().to_degrees();
        assert!((seen.lit_limb_deg([0.0, 1.0, 0.0], |_| true) - expected).abs() < 1.1);
        assert_eq!(seen.lit_limb_deg([1.0, 0.0, 0.0], |_| true), 360.0);
        assert_eq!(seen.lit_limb_deg([-1.0, 0.0, 0.0], |_| true), 0.0);
        assert!((seen.lit_limb_deg([1.0, 0.0, 0.0], |d| d[2] > 0.0) - 180.0).abs() < 0.6);
    }
}
