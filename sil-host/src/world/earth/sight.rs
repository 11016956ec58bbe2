//! Lines of sight: where the line of a pixel passes the Earth, at its row's time.
//!
//! In: pixel, time from the middle of the exposure. Out: [`Sight`], in axes that turn with the Earth,
//! stretched so that it is a unit sphere (see [`super::ellipsoid`]).
//!
//! The path turns with the rate `ω` in its own axes, so that the line `u = [x', y', 1]` of a pixel points
//! along `exp([ω×] t) u` in the axes of the middle of the exposure; the satellite moves straight. The Earth's
//! turning within an exposure (0.2 km at the equator in 0.4 s) is left out. From the line `d = M exp([ω×] t)
//! u - |u| M v/c` (aberration) and the place `p` follow the way to the lowest point `-p'd / d'd`, that point
//! `P`, and `q = 1 - P'P`, how deep it lies. With `q` go the height `-q w`, `w` km a unit, and by
//! differentiation the change of height a pixel, `2 w way |[P'M0, P'M1]| / f`, and a second, `2 w P'(v + way
//! d')`.

use super::EarthModel;
use super::ellipsoid::{Ellipsoid, Figure};
use crate::world::attitude::{Vector, apply, dot, rotation};
use crate::world::lens::optics::Optics;
use crate::world::time::ephemeris::LIGHT_KM_S;
use crate::world::vector::{cross, length, minus, plus, product, times, transposed};

/// Where and how the Earth is seen from.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The Earth's figure from the satellite's place.
    pub ellipsoid: &'a Ellipsoid,
    /// ICRS to Earth path, at the middle of the exposure.
    pub earth_path: &'a [Vector; 3],
    /// Rate of the Earth path in its own axes, rad/s.
    pub rate_rad_s: Vector,
    /// Position about the Earth's centre, ICRS, km.
    pub position_km: Vector,
    /// Velocity about the Earth's centre, ICRS, in units of the speed of light.
    pub velocity_c: Vector,
    /// Unit vector to the Sun, ICRS.
    pub sun: Vector,
    /// Angle from the equinox or node to the prime meridian, rad.
    pub sidereal_rad: f64,
    /// Time for which a row collects light, s.
    pub exposure_s: f64,
    /// Time by which a row is later than the one above, s; 0: all at once.
    pub row_time_s: f64,
    /// Light over that which mirror and grey filter of the Earth path let through.
    pub transmission: f64,
}

/// What all lines of sight of an exposure have in common.
#[derive(Debug, Clone)]
pub struct Sights {
    pub(super) optics: Optics,
    figure: Figure,
    /// Camera axes of the middle of the exposure to the stretched axes that turn with the Earth.
    to_earth: [Vector; 3],
    place: Vector,
    /// Of the place, 1/s.
    velocity: Vector,
    /// v/c in stretched axes.
    aberration: Vector,
    rate_rad_s: Vector,
    row_time_s: f64,
    middle_row: f64,
}

/// The same at a time.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    to_earth: [Vector; 3],
    /// Change of `to_earth`, 1/s.
    turning: [Vector; 3],
    place: Vector,
}

/// A line of sight.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// Its lowest point.
    pub nearest: Vector,
    /// Unit vector back along it.
    pub back: Vector,
    /// 1 less the square of the lowest point's distance from the centre.
    pub depth: f64,
    /// Height by which a unit of `-depth` counts near 0, km.
    pub km_per_depth: f64,
    /// Way to the lowest point, km.
    pub way_km: f64,
    /// Factor of the square root of the depth in the cosine of the view, about 1.
    pub slope: f64,
    /// Cosine of the angle off the camera's axis.
    pub cosine: f64,
    /// Change of height a pixel across the limb, km.
    pub km_per_px: f64,
    /// Change of height at a fixed pixel, km/s.
    pub km_s: f64,
    /// Turning of the ground as seen from here, rad/s.
    pub ground_rad_s: f64,
}

impl Sights {
    /// Those of a view; `optics` are those of the Earth path.
    pub fn new(model: &EarthModel, optics: &Optics, view: &View) -> Self {
        let figure = *view.ellipsoid.figure();
        let to_fixed = rotation(2, view.sidereal_rad);
        let from_icrs = product(&to_fixed, view.ellipsoid.equator());
        let columns = transposed(&product(&from_icrs, &transposed(view.earth_path)))
            .map(|column| figure.to_sphere(column));
        let velocity_c = figure.to_sphere(apply(&from_icrs, view.velocity_c));
        // The last row's centre lies half a pixel inside the detector's edge.
        let middle_row = 0.5 * (optics.clamped([0.0, f64::MAX])[1] - 0.5);
        Self {
            optics: *optics,
            figure,
            to_earth: transposed(&columns),
            place: figure.to_sphere(apply(&from_icrs, view.position_km)),
            velocity: times(LIGHT_KM_S, velocity_c),
            aberration: if model.aberration { velocity_c } else { [0.0; 3] },
            rate_rad_s: view.rate_rad_s,
            row_time_s: view.row_time_s,
            middle_row,
        }
    }

    /// How long after the middle of the exposure row `y` has its own, s.
    pub fn row_s(&self, y: f64) -> f64 {
        (y - self.middle_row) * self.row_time_s
    }

    /// Whether all rows collect at the same time.
    pub fn at_once(&self) -> bool {
        self.row_time_s == 0.0
    }

    /// The pose `t_s` after the middle of the exposure.
    pub fn pose(&self, t_s: f64) -> Pose {
        let to_earth = product(&self.to_earth, &turn(times(t_s, self.rate_rad_s)));
        let [x, y, z] = self.rate_rad_s;
        let rate = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        Pose { to_earth, turning: product(&to_earth, &rate), place: plus(self.place, t_s, self.velocity) }
    }

    /// The line of sight of `pixel`; `None` where the distortion has no inverse.
    // What the caller does not ask for is left out where this is part of it.
    #[inline(always)]
    pub fn sight(&self, pose: &Pose, pixel: [f64; 2]) -> Option<Sight> {
        let [x, y] = self.optics.normalised(pixel)?;
        let norm = (1.0 + x * x + y * y).sqrt();
        let (u, place) = ([x, y, 1.0], pose.place);
        let d = plus(apply(&pose.to_earth, u), -norm, self.aberration);
        let (a, b) = (dot(d, d), dot(place, d));
        // A line that leads away is lowest where it begins.
        let way = (-b / a).max(0.0);
        let nearest = plus(place, way, d);
        let rho2 = dot(nearest, nearest);
        let (depth, rho) = (1.0 - rho2, rho2.sqrt());
        let km_per_depth = rho / (length(self.figure.to_sphere(nearest)) * (1.0 + rho)).max(1e-12);
        let shift = plus(self.velocity, way, apply(&pose.turning, u));
        let [first, second, third] = pose.to_earth;
        let along = |k: usize| first[k] * nearest[0] + second[k] * nearest[1] + third[k] * nearest[2];
        let (along_x, along_y) = (along(0), along(1));
        let per_way = 2.0 * km_per_depth * way / self.optics.focal_length_px();
        let length_d = a.sqrt();
        // The ground comes as far before the lowest point as the depth says.
        let ground = (way - (depth.max(0.0) / a).sqrt()).max(1e-6);
        let drift = plus(times(ground.recip(), self.velocity), 1.0, apply(&pose.turning, u));
        let drift2 = dot(drift, drift) - dot(drift, d) * dot(drift, d) / a;
        Some(Sight {
            nearest,
            back: times(-length_d.recip(), d),
            depth,
            km_per_depth,
            way_km: way * norm,
            slope: length_d * self.figure.equator_km / norm,
            cosine: norm.recip(),
            km_per_px: per_way * (along_x * along_x + along_y * along_y).sqrt(),
            km_s: 2.0 * km_per_depth * dot(nearest, shift),
            ground_rad_s: (drift2.max(0.0) / a).sqrt(),
        })
    }
}

/// The rotation `exp([angle×])` (Rodrigues).
fn turn(angle: Vector) -> [Vector; 3] {
    let size = length(angle);
    let (s, c) = libm::sincos(size);
    let (first, second) = if size > 1e-9 { (s / size, (1.0 - c) / (size * size)) } else { (1.0, 0.5) };
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| {
        let once = cross(angle, axis);
        plus(plus(axis, first, once), second, cross(angle, once))
    });
    transposed(&columns)
}

/// Greatest motion of the limb across itself while a row collects light, px: for an observer turning with `ω`
/// and moving with `v`, a direction `n` of a fixed point in the distance `s` goes by `-(ω × n + v / s)`.
pub fn limb_motion_px(optics: &Optics, view: &View) -> f64 {
    let (f, tangent) = (optics.focal_length_px(), optics.radius_px() / optics.focal_length_px());
    let cone_cosine = optics.cone_cosine(0.1 * f);
    let velocity_km_s = times(LIGHT_KM_S, apply(view.earth_path, view.velocity_c));
    let mut most = 0.0f64;
    // Every fourth degree: it hardly changes from one to the next.
    for (normal, point) in view.ellipsoid.limb().step_by(8) {
        let line = apply(view.earth_path, minus(point, view.position_km));
        let distance = length(line);
        let direction = times(distance.recip(), line);
        if direction[2] < cone_cosine {
            continue;
        }
        let drift = plus(cross(view.rate_rad_s, direction), distance.recip(), velocity_km_s);
        most = most.max(dot(drift, apply(view.earth_path, normal)).abs());
    }
    most * f * (1.0 + tangent * tangent) * view.exposure_s
}
