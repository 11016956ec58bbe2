//! Equinoctial elements (Broucke and Cefola 1972): an orbit without the singular cases of Kepler's elements.
//!
//! `h = e sin(ω + IΩ)`, `k = e cos(ω + IΩ)`, `p = tanᴵ(i/2) sin Ω`, `q = tanᴵ(i/2) cos Ω`, the mean
//! longitude `λ = M + ω + IΩ` and the mean motion. The retrograde factor `I` is 1 where the orbit's normal
//! is north of the equator of the axes, -1 where it is south: regular at every inclination, and at `e = 0`.
//!
//! About a point mass all but `λ` are constant and `λ` grows by the mean motion: errors in these elements
//! stay Gaussian however far the orbit is carried, where Cartesian errors bend (Horwood, Aragon and Poore
//! 2011).

use core::f64::consts::{PI, TAU};
use fsw_ground::matrix::{add_scaled, cross, dot, plus_scaled, scaled};
use fsw_ground::trigonometry::sine_cosine_f64;
use nalgebra::Vector3;

/// Most steps of Newton's method for Kepler's equation: below 1e-12 rad up to the greatest eccentricity.
const KEPLER_STEPS: usize = 12;
/// A step below this, rad, is the last: what it leaves is below rounding.
const LAST_STEP_RAD: f64 = 1e-9;
/// Greatest eccentricity; beyond, and for open orbits, there are no elements.
const GREATEST_ECCENTRICITY: f64 = 0.97;

/// A change of the mean motion, `h`, `k`, `p`, `q` and the mean longitude.
pub type Change = [f64; 6];

/// Elements of a closed orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equinoctial {
    /// Mean motion, rad/s.
    pub mean_motion_rad_s: f64,
    /// `h` and `k`: the eccentricity vector along the two axes of the frame.
    pub eccentricity: [f64; 2],
    /// `p` and `q`: the direction of the normal.
    pub inclination: [f64; 2],
    /// Mean longitude, rad, -π to π from a state.
    pub longitude_rad: f64,
    /// Whether the retrograde factor is -1.
    pub retrograde: bool,
}

/// The axes `f`, `g` of the orbit's plane from `p`, `q` and the retrograde factor.
#[inline(never)]
fn plane([p, q]: [f64; 2], factor: f64) -> [Vector3<f64>; 2] {
    let scale = 1.0 / (1.0 + p * p + q * q);
    let f = Vector3::new(1.0 - p * p + q * q, 2.0 * p * q, -2.0 * factor * p);
    let g = Vector3::new(2.0 * factor * p * q, factor * (1.0 + p * p - q * q), 2.0 * q);
    [scaled(&f, scale), scaled(&g, scale)]
}

/// Angle of a direction with these components, of unit length together: to f32 by `atan2f`, the rest, at most
/// 1e-6 rad, by its sine. `libm::atan2` is 1.5 KB of flash more.
pub(crate) fn angle_rad(sine: f64, cosine: f64) -> f64 {
    let near = f64::from(libm::atan2f(sine as f32, cosine as f32));
    let (s, c) = sine_cosine_f64(near);
    near + (sine * c - cosine * s)
}

/// The cube root of a positive number: to f32 by `cbrtf`, then two of Newton's steps. `libm::cbrt` is 2 KB of
/// flash more.
fn cube_root(number: f64) -> f64 {
    let mut root = f64::from(libm::cbrtf(number as f32));
    for _ in 0..2 {
        root -= (root - number / (root * root)) * (1.0 / 3.0);
    }
    root
}

fn factor_of(retrograde: bool) -> f64 {
    if retrograde { -1.0 } else { 1.0 }
}

/// Distance and semi-major axis, km; not positive for an open orbit.
pub fn radius_and_axis_km(
    mu_km3_s2: f64,
    position_km: &Vector3<f64>,
    velocity_km_s: &Vector3<f64>,
) -> (f64, f64) {
    let radius_km = libm::sqrt(dot(position_km, position_km));
    (radius_km, 1.0 / (2.0 / radius_km - dot(velocity_km_s, velocity_km_s) / mu_km3_s2))
}

impl Equinoctial {
    /// Of a position (km) and a velocity (km/s) about a body of this gravitational parameter (km³/s²); `None`
    /// where they are not those of a closed orbit.
    #[inline(never)]
    pub fn of(mu_km3_s2: f64, position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> Option<Self> {
        let (radius, axis_km) = radius_and_axis_km(mu_km3_s2, position_km, velocity_km_s);
        let momentum = cross(position_km, velocity_km_s);
        let length = libm::sqrt(dot(&momentum, &momentum));
        // Also refuses what is not finite.
        if !(axis_km > 0.0 && length > 0.0 && axis_km < 1e9 && length < 1e12) {
            return None;
        }
        let normal = scaled(&momentum, 1.0 / length);
        let retrograde = normal.z < 0.0;
        let factor = factor_of(retrograde);
        let scale = 1.0 / (1.0 + factor * normal.z);
        let inclination = [normal.x * scale, -normal.y * scale];
        let [f, g] = plane(inclination, factor);
        let mut eccentricity = scaled(&cross(velocity_km_s, &momentum), 1.0 / mu_km3_s2);
        add_scaled(&mut eccentricity, -1.0 / radius, position_km);
        let (h, k) = (dot(&g, &eccentricity), dot(&f, &eccentricity));
        let square = h * h + k * k;
        if square > GREATEST_ECCENTRICITY * GREATEST_ECCENTRICITY {
            return None;
        }
        let (x, y) = (dot(&f, position_km), dot(&g, position_km));
        let root = libm::sqrt(1.0 - square);
        let b = 1.0 / (1.0 + root);
        let scale = 1.0 / (axis_km * root);
        let cosine = k + ((1.0 - k * k * b) * x - h * k * b * y) * scale;
        let sine = h + ((1.0 - h * h * b) * y - h * k * b * x) * scale;
        Some(Self {
            mean_motion_rad_s: libm::sqrt(mu_km3_s2 / axis_km) / axis_km,
            eccentricity: [h, k],
            inclination,
            longitude_rad: angle_rad(sine, cosine) + h * cosine - k * sine,
            retrograde,
        })
    }

    /// Position (km) and velocity (km/s) about a body of this gravitational parameter (km³/s²); `None` where
    /// the elements are not those of a closed orbit.
    #[inline(never)]
    pub fn state(&self, mu_km3_s2: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let Self { mean_motion_rad_s: motion, eccentricity: [h, k], .. } = *self;
        let square = h * h + k * k;
        // Also refuses what is not finite.
        if !(motion > 0.0 && motion < 1.0 && square <= GREATEST_ECCENTRICITY * GREATEST_ECCENTRICITY) {
            return None;
        }
        let axis_km = cube_root(mu_km3_s2 / (motion * motion));
        // Kepler's equation: λ = F + h cos F - k sin F.
        let mut eccentric = self.longitude_rad;
        for _ in 0..KEPLER_STEPS {
            let (sine, cosine) = sine_cosine_f64(eccentric);
            let off = eccentric + h * cosine - k * sine - self.longitude_rad;
            let step = off / (1.0 - h * sine - k * cosine);
            eccentric -= step;
            if libm::fabs(step) < LAST_STEP_RAD {
                break;
            }
        }
        let (sine, cosine) = sine_cosine_f64(eccentric);
        let b = 1.0 / (1.0 + libm::sqrt(1.0 - square));
        let [p, q, r] = [1.0 - h * h * b, 1.0 - k * k * b, h * k * b];
        let speed = motion * axis_km / (1.0 - h * sine - k * cosine);
        let [f, g] = self.axes();
        let at = |x: f64, y: f64| plus_scaled(&scaled(&f, x), y, &g);
        let position_km = at(axis_km * (p * cosine + r * sine - k), axis_km * (q * sine + r * cosine - h));
        let velocity_km_s = at(speed * (r * cosine - p * sine), speed * (q * cosine - r * sine));
        Some((position_km, velocity_km_s))
    }

    /// The axes of the orbit's plane from which longitudes count, the second a quarter of the way round.
    pub(crate) fn axes(&self) -> [Vector3<f64>; 2] {
        plane(self.inclination, factor_of(self.retrograde))
    }

    /// The elements less others, in the order of the fields; `None` where the retrograde factors differ.
    #[inline(never)]
    pub fn minus(&self, other: &Self) -> Option<Change> {
        if self.retrograde != other.retrograde {
            return None;
        }
        let mut change = self.numbers();
        for (element, theirs) in change.iter_mut().zip(&other.numbers()) {
            *element -= theirs;
        }
        // The shorter way round.
        let [.., longitude] = &mut change;
        if *longitude > PI {
            *longitude -= TAU;
        } else if *longitude < -PI {
            *longitude += TAU;
        }
        Some(change)
    }

    fn numbers(&self) -> Change {
        let ([h, k], [p, q]) = (self.eccentricity, self.inclination);
        [self.mean_motion_rad_s, h, k, p, q, self.longitude_rad]
    }

    /// These elements and a change of them.
    pub fn plus(&self, change: &Change) -> Self {
        let [n, h, k, p, q, l] = self.numbers();
        let [dn, dh, dk, dp, dq, dl] = *change;
        Self {
            mean_motion_rad_s: n + dn,
            eccentricity: [h + dh, k + dk],
            inclination: [p + dp, q + dq],
            longitude_rad: l + dl,
            retrograde: self.retrograde,
        }
    }
}

#[cfg(test)]
mod tests;
