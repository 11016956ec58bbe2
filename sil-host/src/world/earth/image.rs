//! The image of the Earth: mean electrons a second of the pixels of a window.
//!
//! In: the satellite's position and velocity, Sun, the Earth path, the PSF. Out: light, pixel by pixel; a pixel's value
//! depends on its place only.
//!
//! A pixel's line of sight `d` (less `|d| v/c`, aberration) meets the ellipsoid or passes it at the height `h` (see
//! [`super::ellipsoid`]). Brightness of a point of the surface: `albedo · m · (k 2 / (m + μ') + 1 - k)`, a mix of Lommel-Seeliger
//! and Lambert; `m` is the cosine of the Sun's zenith angle with a smooth foot, `(μ0 + w)² / 4w` between ± w, the twilight;
//! `μ' = sqrt(μ² + 0.1²)` is the cosine of the view with the limb's edge taken off it. A line that passes shows the
//! atmosphere: the brightness of the surface under its lowest point times `exp(-h/H)` (thesis eq. 4.1, 4.2), to 100 km.
//!
//! PSF: the profile across the limb, 1 below and `exp(-h/H)` above, is convolved with the Gaussian in closed form,
//! `Φ(-h/s) + exp(q²/2 - h/H) Φ(h/s - q)`, `q = s/H`, with `s` the PSF's width (pixel included) in km at the
//! limb; the limb is straight over five PSF widths. The surface is taken where the line meets it whose depth below the
//! limb is the mean over the PSF, and is not blurred otherwise: [`super::albedo`] leaves out what a pixel cannot resolve. Motion during the exposure is not drawn (1.3 px
//! in a low orbit and 0.4 s), nor is the Moon.
//!
//! Half of the brightness ten pixels inside stands 4 to 6 km above the ellipsoid in low orbits and 3 to 14 km in GEO, where a
//! pixel is 12 km: the lower the Sun (90 to 5 deg), the further from the 5.5 km of `H ln 2`; below with the Sun behind the
//! satellite, above with the Sun aside. Cost: about 85 ns a pixel of the lit disc, beside 28 ns for its noise.

use super::albedo::Albedo;
use super::ellipsoid::{Ellipsoid, to_sphere};
use super::{EQUATOR_KM, EarthModel, POLE_KM};
use crate::world::attitude::{Vector, apply, dot};
use crate::world::optics::Optics;
use crate::world::vector::{angle, length, plus, product, transposed, unit};
use fsw_hal::Window;
use std::sync::LazyLock;

/// Cosine of the view that is added in squares at the limb: the surface's last 30 km blur into haze.
const HAZE: f64 = 0.1;
/// Widths of the PSF beyond which the limb's profile is as without it.
const REACH_SIGMAS: f64 = 5.0;
/// PSF in scale heights above which the atmosphere only moves the edge.
const WIDE: f64 = 6.0;
/// Variance of a pixel's own width, px².
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;

/// All that the pixels of an exposure have in common.
#[derive(Debug, Clone)]
pub struct EarthImage {
    optics: Optics,
    /// Camera axes to those in which the Earth is a unit sphere.
    to_sphere: [Vector; 3],
    place: Vector,
    /// Line of sight in equatorial axes.
    boresight: Vector,
    /// Unit vector to the Sun in equatorial axes.
    sun: Vector,
    /// Equatorial axes to those that turn with the Earth: sine and cosine.
    sidereal: (f64, f64),
    /// v/c in camera axes.
    aberration: Vector,
    /// Direction to the Earth's centre in camera axes, and the cone about it that holds all light, rad.
    centre: Vector,
    cone_rad: f64,
    sigma_px: f64,
    per_focal_length: f64,
    /// Squares of `rho` between which the limb's profile may differ from 1 and from 0.
    limb_rho2: (f64, f64),
    white_e_s: f64,
    albedo: Albedo,
    model: EarthModel,
    twilight: f64,
}

/// Where the Earth is seen from.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The Earth's figure from the satellite's place.
    pub ellipsoid: &'a Ellipsoid,
    /// ICRS to Earth path.
    pub earth_path: &'a [Vector; 3],
    /// Position about the Earth's centre, ICRS, km.
    pub position_km: Vector,
    /// Velocity about the Earth's centre, ICRS, in units of the speed of light.
    pub velocity_c: Vector,
    /// Unit vector to the Sun, ICRS.
    pub sun: Vector,
    /// Greenwich sidereal angle, rad.
    pub sidereal_rad: f64,
}

impl EarthImage {
    /// Prepares an exposure; `optics` are those of the Earth path.
    pub fn new(model: &EarthModel, optics: &Optics, psf_sigma_px: f64, view: &View) -> Self {
        let equator = view.ellipsoid.equator();
        let to_icrs = transposed(view.earth_path);
        let to_equator = product(equator, &to_icrs);
        let columns = transposed(&to_equator).map(to_sphere);
        let sigma_px = (psf_sigma_px * psf_sigma_px + PIXEL_VARIANCE).sqrt();
        let f = optics.focal_length_px();
        let distance = length(view.position_km);
        // The way to the limb is shorter than that to the limb of the smallest sphere inside.
        let way_km = (distance * distance - POLE_KM * POLE_KM).sqrt() + 2000.0;
        let reach_km = (REACH_SIGMAS + 1.0) * sigma_px * way_km / f;
        let top_km = model.atmosphere_top_km + 2.0 * reach_km;
        let (inner, outer) = ((1.0 - reach_km / POLE_KM).max(0.0), 1.0 + top_km / POLE_KM);
        let cone_sine = ((EQUATOR_KM + top_km) / distance).min(1.0);
        Self {
            optics: *optics,
            to_sphere: transposed(&columns),
            place: view.ellipsoid.place(),
            boresight: columns_third(&to_equator),
            sun: apply(equator, view.sun),
            sidereal: libm::sincos(view.sidereal_rad),
            aberration: if model.aberration { apply(view.earth_path, view.velocity_c) } else { [0.0; 3] },
            centre: unit(apply(view.earth_path, view.position_km.map(|c| -c))),
            cone_rad: libm::asin(cone_sine) + length(view.velocity_c),
            sigma_px,
            per_focal_length: f.recip(),
            limb_rho2: (inner * inner, outer * outer),
            white_e_s: model.white_e_s(f),
            albedo: Albedo::new(model.mean_albedo, model.cloud_contrast),
            model: *model,
            twilight: libm::sin(model.twilight_deg.to_radians()),
        }
    }

    /// Adds the electrons of `time_s` to `electrons`, the pixels of `window` row by row.
    pub fn add_to(&self, window: Window, time_s: f64, electrons: &mut [f64]) {
        if window.area() == 0 || !self.may_touch(window) {
            return;
        }
        let scale = self.white_e_s * time_s;
        for (y, line) in (window.y..).zip(electrons.chunks_exact_mut(usize::from(window.width))) {
            for (x, pixel) in (window.x..).zip(line) {
                *pixel += scale * self.brightness([f64::from(x), f64::from(y)]);
            }
        }
    }

    /// Whether any light can fall into `window`: cones about its middle and about the Earth meet.
    fn may_touch(&self, window: Window) -> bool {
        let Window { x, y, width, height } = window;
        let (left, top) = (f64::from(x) - 0.5, f64::from(y) - 0.5);
        let (w, h) = (f64::from(width), f64::from(height));
        let direction = |u, v| self.optics.unproject([left + u * w, top + v * h]);
        let Some(middle) = direction(0.5, 0.5) else { return true };
        let mut reach: f64 = 0.0;
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let Some(corner) = direction(u, v) else { return true };
            reach = reach.max(angle(middle, corner));
        }
        // A hundredth more for edges that distortion bends.
        angle(middle, self.centre) <= self.cone_rad + 1.01 * reach
    }

    /// Brightness at `pixel` relative to a white Lambert surface under the Sun in the zenith.
    pub fn brightness(&self, pixel: [f64; 2]) -> f64 {
        let Some([u, v]) = self.optics.normalised(pixel) else { return 0.0 };
        let norm = (1.0 + u * u + v * v).sqrt();
        let d = plus([u, v, 1.0], -norm, self.aberration);
        let d = apply(&self.to_sphere, d);
        let (a, b) = (dot(d, d), dot(self.place, d));
        if b >= 0.0 {
            return 0.0;
        }
        let way = -b / a;
        let rho2 = dot(self.place, self.place) + way * b;
        if rho2 >= self.limb_rho2.1 {
            return 0.0;
        }
        let clear = Limb { share: 1.0, depth: 1.0 - rho2 };
        let limb = if rho2 < self.limb_rho2.0 { clear } else { self.limb(d, way, rho2) };
        if limb.share <= 0.0 {
            return 0.0;
        }
        // How far before its lowest point the line meets the surface, after x'd' = -root there.
        let root = (a * limb.depth).sqrt();
        let way = way - root / a;
        let to_surface = (rho2 + limb.depth).sqrt().recip();
        let point = plus(self.place, way, d).map(|c| c * to_surface);
        limb.share * self.surface(point, root / norm, way * norm)
    }

    /// What the limb does to a line whose lowest point is `way` along `d`.
    fn limb(&self, d: Vector, way: f64, rho2: f64) -> Limb {
        let rho = rho2.sqrt();
        let slope = to_sphere(plus(self.place, way, d));
        let steepness = length(slope);
        let rho_per_km = steepness / rho;
        let height = (rho - 1.0) / rho_per_km;
        let along_sight = dot(slope, self.boresight) / steepness;
        let km_per_px = way * self.per_focal_length * (1.0 - along_sight * along_sight).max(1e-9).sqrt();
        let sigma = self.sigma_px * km_per_px;
        if height > self.model.atmosphere_top_km + REACH_SIGMAS * sigma {
            return Limb { share: 0.0, depth: 0.0 };
        }
        let share = blurred_limb(height, sigma, self.model.scale_height_km);
        let depth_km = sigma * blurred_depth(height / sigma);
        Limb { share, depth: depth_km * rho_per_km * (1.0 + rho) }
    }

    /// Brightness of the surface at a point of the unit sphere.
    fn surface(&self, point: Vector, root: f64, distance_km: f64) -> f64 {
        let normal = to_sphere(point);
        let per_length = length(normal).recip();
        let w = self.twilight;
        let sunlight = dot(normal, self.sun) * per_length;
        if sunlight <= -w {
            return 0.0;
        }
        let lit = if sunlight < w { (sunlight + w) * (sunlight + w) / (4.0 * w) } else { sunlight };
        // The normal times the line of sight, from x'd' = -root.
        let view = root * per_length;
        let view = (view * view + HAZE * HAZE).sqrt();
        let k = self.model.lommel_seeliger;
        let path = view.recip();
        let [x, y, z] = point;
        let (s, c) = self.sidereal;
        let place = [c * x + s * y, c * y - s * x, z];
        let albedo = self.albedo.at(place, distance_km * self.per_focal_length * path);
        let haze = self.model.limb_haze * HAZE * path;
        let albedo = albedo + haze * (self.model.mean_albedo - albedo);
        albedo * lit * (2.0 * k / (lit + view) + 1.0 - k)
    }
}

/// What the limb does to a line of sight.
#[derive(Debug, Clone, Copy)]
struct Limb {
    /// Share of the surface's brightness that is left.
    share: f64,
    /// `1 - rho²`, not below zero: how deep the line dives, averaged over the PSF.
    depth: f64,
}

/// Third column: the image of the z axis.
fn columns_third(m: &[Vector; 3]) -> Vector {
    [m[0][2], m[1][2], m[2][2]]
}

/// A profile of 1 below the height 0 and `exp(-h / scale)` above, blurred by a Gaussian of width `sigma`; all km.
pub fn blurred_limb(height: f64, sigma: f64, scale: f64) -> f64 {
    let (t, q) = (height / sigma, sigma / scale);
    if q > WIDE {
        // The light above the limb is that of a surface higher by the scale height.
        return normal_below((scale - height) / sigma);
    }
    if t < -REACH_SIGMAS {
        return 1.0;
    }
    let air = libm::exp(0.5 * q * q - height / scale);
    if t - q > REACH_SIGMAS { air } else { normal_below(-t) + air * normal_below(t - q) }
}

/// Mean of `max(0, -(t + g))` over a Gaussian `g` of width 1: the depth of a line below the limb that the PSF sees. It
/// takes the infinite slope from the edge, where a line's first point on the surface runs away.
fn blurred_depth(t: f64) -> f64 {
    if t < -REACH_SIGMAS {
        return -t;
    }
    if t > REACH_SIGMAS {
        return 0.0;
    }
    NORMAL.at(t, |entry| entry.depth)
}

/// Normal distribution function.
fn normal_below(t: f64) -> f64 {
    NORMAL.at(t, |entry| entry.below)
}

/// Entries of the table a unit.
const TABLE_STEPS: f64 = 64.0;
/// The table's end on either side.
const TABLE_REACH: f64 = 6.0;
const TABLE_LENGTH: usize = (2.0 * TABLE_REACH * TABLE_STEPS) as usize + 2;

/// The normal distribution and the blurred depth, linear between entries: right to 1e-5.
struct NormalTable(Box<[Normal; TABLE_LENGTH]>);

#[derive(Clone, Copy)]
struct Normal {
    below: f64,
    depth: f64,
}

static NORMAL: LazyLock<NormalTable> = LazyLock::new(|| {
    const DENSITY: f64 = 0.398_942_280_401_432_7;
    let mut table = Box::new([Normal { below: 0.0, depth: 0.0 }; TABLE_LENGTH]);
    for (index, entry) in table.iter_mut().enumerate() {
        let t = index as f64 / TABLE_STEPS - TABLE_REACH;
        let below = |t: f64| 0.5 * libm::erfc(-std::f64::consts::FRAC_1_SQRT_2 * t);
        let depth = (DENSITY * libm::exp(-0.5 * t * t) - t * below(-t)).max(0.0);
        *entry = Normal { below: below(t), depth };
    }
    NormalTable(table)
});

impl NormalTable {
    fn at(&self, t: f64, of: impl Fn(&Normal) -> f64) -> f64 {
        let place = (t.clamp(-TABLE_REACH, TABLE_REACH) + TABLE_REACH) * TABLE_STEPS;
        let index = (place as usize).min(TABLE_LENGTH - 2);
        let (low, high) = (of(&self.0[index]), of(&self.0[index + 1]));
        low + (place - index as f64) * (high - low)
    }
}

#[cfg(test)]
#[path = "image_tests.rs"]
mod tests;
