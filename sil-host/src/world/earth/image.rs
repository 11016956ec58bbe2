//! The image of the Earth: mean electrons of the pixels of a window.
//!
//! In: the satellite's position and velocity, Sun, the Earth path and its rate, shutter, PSF, seed. Out:
//! light, pixel by pixel; a pixel's value depends on its place only.
//!
//! A pixel's line of sight meets the ellipsoid or passes it at a height ([`super::sight`]). Brightness of a
//! point of the surface: [`super::photometry`], by `m` and `μ'`; `m` is the cosine of the Sun's zenith angle
//! with a smooth foot, `(μ0 + w)² / 4w` between ± w, the twilight; `μ' = sqrt(μ² + 0.1²)` is the cosine of
//! the view with the limb's edge taken off it. A line that passes shows the brightness of the surface under
//! its lowest point times the profile of [`super::limb`], which stands as high as [`super::horizon`] says.
//! All falls with `cos³` off the axis.
//!
//! PSF: the profile across the limb is convolved with the Gaussian; the limb is straight over five PSF
//! widths. The surface is taken where the line meets it whose depth below the limb is the mean over the PSF,
//! and is not blurred otherwise: [`super::map`] leaves out what a pixel cannot resolve.
//!
//! Motion: a row collects light over the exposure about its own time. While the limb moves by no more than 2
//! px across itself the blur has the variance of the motion, `(way across the limb)² / 12`, added. Beyond
//! that the profile is integrated over the way ([`super::limb::Limb::read`]), and the exposure is divided
//! into parts over each of which clouds of the smallest kind hardly move: 7 km on the ground, 2 to 8 px. The
//! ground's motion within a part counts to what a pixel cannot resolve; terminator and clouds stand still
//! within it.
//!
//! What is smooth is not computed for every pixel. The detector is divided into cells of 16 x 8 px, whatever
//! the window: depth and height of the limb are those of the biquadratic through 3 x 3 points of a cell, the
//! lowest points lie on parabolas along its rows, everything else is bilinear between its corners. This moves
//! the limb by at most 0.006 px in the geostationary orbit and 0.003 px in low ones, and changes brightness
//! by at most 0.2 % of the greatest (tests). Cells in which no light falls cost nothing. The night sky is
//! drawn about the limb only; deep in the disc it is 1e-3 electrons an exposure and left out, as are Moon and
//! towns. Cost: `cargo bench -p sil-host --bench rendering`; filling the maps of a hemisphere takes 0.3 s,
//! once.

use super::cell::{AREA, Cell, HEIGHT, KM_PER_DEPTH, Lane, Node, Places, SIGMA_KM, WIDTH};
use super::cell::{BACK, COUNT, CUBE, MOVED_KM, SLOPE, SPREAD, WAY_KM};
use super::ellipsoid::Figure;
use super::lattice::smooth;
use super::limb::REACH_SIGMAS;
use super::looks::Looks;
use super::map::{AlbedoMap, MapBuffer};
use super::photometry::{Photometry, minnaert};
pub use super::sight::View;
use super::sight::{Pose, Sight, Sights, limb_motion_px};
use super::{EQUATOR_KM, EarthModel};
use crate::world::attitude::{Vector, apply, rotation};
use crate::world::lens::optics::Optics;
use crate::world::time::ephemeris::LIGHT_KM_S;
use crate::world::vector::{angle, length, times, unit};
use fsw_hal::Window;
use std::sync::Arc;

/// Cosine of the view that is added in squares at the limb: the surface's last 30 km blur into haze.
const HAZE: f32 = 0.1;
/// Variance of a pixel's own width, px².
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;
/// Motion of the limb across itself up to which it counts as blur, px.
const STEP_PX: f64 = 2.0;
/// Motion of the image in a part of a divided exposure, km at the limb, and most of it, px.
const PART_KM: f64 = 7.0;
const PART_PX: f64 = 8.0;
/// Most parts of an exposure.
const STEPS_MAX: f64 = 512.0;
/// `q` at which the limb's height begins and ceases to count, from the disc's middle outwards: deep in the
/// disc the lowest point says nothing of the horizon.
const HORIZON_DEPTH: (f64, f64) = (0.6, 0.2);

/// All that the pixels of an exposure have in common.
#[derive(Debug, Clone)]
pub struct EarthImage {
    sights: Sights,
    equator_km: f32,
    /// Square of the equator's radius over the pole's.
    squashed: f32,
    /// The Earth's radius over the body's: the map's cells are the Earth's.
    map_scale: f32,
    looks: Arc<Looks>,
    /// Unit vector to the Sun in axes that turn with the Earth, its z stretched as the normal's is.
    sun: [f32; 3],
    declination_sine: f64,
    /// Direction to the Earth's centre in camera axes, and the cone about it that holds all light, rad.
    centre: Vector,
    cone_rad: f64,
    variance_px2: f64,
    per_focal_length: f64,
    /// Parts of the exposure, and the length of one, s.
    steps: u32,
    step_s: f64,
    /// Whether the limb's profile is integrated over its motion in a part.
    integrates: bool,
    white_e_s: f64,
    top_km: f64,
    shade: Shade,
}

/// What the light of a point of the surface depends on.
#[derive(Debug, Clone, Copy)]
struct Shade {
    law: Photometry,
    mean_albedo: f32,
    haze: f32,
    lommel_seeliger: f32,
    twilight: f32,
}

/// What a cell holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Content {
    Nothing,
    Limb,
    Surface,
}

/// Length of the parts of a window for which it is asked whether light may fall into them, px.
const LOOK_PX: u16 = 128;
/// Far more than the limb is lifted, km.
const HIGHEST_KM: f64 = 20.0;

/// Room for the pixels that are drawn at once: those of a cell that lie in the window.
#[derive(Debug, Clone)]
pub struct CellBuffer {
    places: Places,
    /// Those that see something of the surface, and their numbers.
    seen: Places,
    numbers: [u8; AREA],
    light: Lane,
    depth: Lane,
    glow: Lane,
    cube: Lane,
    share: Lane,
    km_per_depth: Lane,
    sigma_km: Lane,
    moved_km: Lane,
    /// Of a line of sight: lowest point, direction back, slope, way, spread.
    sight: [Lane; 9],
    /// Of the point seen: place, sunlight, view, and size on the ground, then level, then albedo.
    place: [Lane; 3],
    lit: Lane,
    view: Lane,
    albedo: Lane,
    map: MapBuffer,
}

impl CellBuffer {
    /// Nothing on it.
    pub const EMPTY: Self = Self {
        places: Places::EMPTY,
        seen: Places::EMPTY,
        numbers: [0; AREA],
        light: [0.0; AREA],
        depth: [0.0; AREA],
        glow: [0.0; AREA],
        cube: [0.0; AREA],
        share: [0.0; AREA],
        km_per_depth: [0.0; AREA],
        sigma_km: [0.0; AREA],
        moved_km: [0.0; AREA],
        sight: [[0.0; AREA]; 9],
        place: [[0.0; AREA]; 3],
        lit: [0.0; AREA],
        view: [0.0; AREA],
        albedo: [0.0; AREA],
        map: MapBuffer::EMPTY,
    };
}

impl EarthImage {
    /// Prepares an exposure of the run `seed`; `optics` are those of the Earth path.
    pub fn new(model: &EarthModel, seed: u64, optics: &Optics, psf_sigma_px: f64, view: &View) -> Self {
        let variance_px2 = psf_sigma_px * psf_sigma_px + PIXEL_VARIANCE;
        let f = optics.focal_length_px();
        let distance = length(view.position_km);
        let Figure { equator_km, pole_km } = *view.ellipsoid.figure();
        let limb_km = (distance * distance - pole_km * pole_km).max(0.0).sqrt();
        let part_px = (PART_KM * f / limb_km.max(1.0)).clamp(STEP_PX, PART_PX);
        let moved_px = limb_motion_px(optics, view);
        // Along the limb the ground goes by as well.
        let turned_px = length(view.rate_rad_s) * f * view.exposure_s;
        let integrates = moved_px > STEP_PX;
        let parts = if integrates { moved_px.max(turned_px) / part_px } else { 1.0 };
        let steps = parts.ceil().clamp(1.0, STEPS_MAX);
        // The way to the limb is shorter than that to the limb of the smallest sphere inside.
        let way_km = limb_km + 2000.0;
        let reach_px = (REACH_SIGMAS + 1.0) * (variance_px2 + STEP_PX).sqrt() + 0.5 * PART_PX;
        let reach_km = reach_px * way_km / f;
        let top_km = model.atmosphere_top_km + 2.0 * reach_km + HIGHEST_KM;
        let cone_sine = ((equator_km + top_km) / distance).min(1.0);
        let sights = Sights::new(model, optics, view);
        let half_s = 0.5 * view.exposure_s + sights.row_s(-0.5).abs();
        let speed_km_s = LIGHT_KM_S * length(view.velocity_c);
        // The limb of a body at least 100 km below.
        let turned_rad = half_s * (length(view.rate_rad_s) + speed_km_s / (distance - pole_km).max(100.0));
        let [x, y, z] = apply(&rotation(2, view.sidereal_rad), apply(view.ellipsoid.equator(), view.sun));
        Self {
            sights,
            equator_km: equator_km as f32,
            squashed: ((equator_km / pole_km) * (equator_km / pole_km)) as f32,
            map_scale: (EQUATOR_KM / equator_km) as f32,
            looks: Looks::of(seed, model),
            sun: [x as f32, y as f32, (z * equator_km / pole_km) as f32],
            declination_sine: z,
            centre: unit(apply(view.earth_path, times(-1.0, view.position_km))),
            cone_rad: libm::asin(cone_sine) + length(view.velocity_c) + turned_rad,
            variance_px2,
            per_focal_length: f.recip(),
            steps: steps as u32,
            integrates,
            step_s: view.exposure_s / steps,
            white_e_s: model.white_e_s(f) * view.transmission,
            top_km: model.atmosphere_top_km,
            shade: Shade {
                law: model.surface,
                mean_albedo: model.mean_albedo as f32,
                haze: model.limb_haze as f32 * HAZE,
                lommel_seeliger: model.lommel_seeliger as f32,
                twilight: libm::sin(model.twilight_deg.to_radians()) as f32,
            },
        }
    }

    /// Adds the electrons of the exposure to `electrons`, the pixels of `window` row by row.
    pub fn add_to(&self, window: Window, electrons: &mut [f64], cell_buffer: &mut CellBuffer) {
        let Some(lit) = self.lit(window) else { return };
        for step in 0..self.steps {
            let t_s = self.step_s * (f64::from(step) + 0.5 - 0.5 * f64::from(self.steps));
            self.add_part(lit, t_s, (window, electrons), cell_buffer);
        }
    }

    /// The part of a window into which light may fall: parts of its longer side are looked at from either
    /// end.
    fn lit(&self, window: Window) -> Option<Window> {
        let across = window.width >= window.height;
        let length = if across { window.width } else { window.height };
        let part = |from: u16| {
            let long = LOOK_PX.min(length - from);
            if across {
                Window { x: window.x + from, width: long, ..window }
            } else {
                Window { y: window.y + from, height: long, ..window }
            }
        };
        let may_touch = |from: &u16| part(*from).area() > 0 && self.may_touch(part(*from));
        let mut parts = (0..length).step_by(usize::from(LOOK_PX));
        let first = parts.find(may_touch)?;
        let last = parts.rev().find(may_touch).unwrap_or(first);
        let end = last + LOOK_PX.min(length - last);
        Some(if across {
            Window { x: window.x + first, width: end - first, ..window }
        } else {
            Window { y: window.y + first, height: end - first, ..window }
        })
    }

    /// Adds the light that falls into `window` in the part of the exposure about `t_s` after its middle, to
    /// the pixels of the window around it.
    fn add_part(
        &self,
        window: Window,
        t_s: f64,
        (around, electrons): (Window, &mut [f64]),
        cell_buffer: &mut CellBuffer,
    ) {
        let [left, top, width, height] = [window.x, window.y, window.width, window.height].map(usize::from);
        let stride = usize::from(around.width);
        let first = usize::from(window.y - around.y) * stride + usize::from(window.x - around.x);
        let columns = left / WIDTH..(left + width).div_ceil(WIDTH);
        let rows = top / HEIGHT..(top + height).div_ceil(HEIGHT);
        let still = self.sights.pose(t_s);
        let nodes = |y: usize| {
            let between = !y.is_multiple_of(HEIGHT);
            let y = y as f64;
            let turned = (!self.sights.at_once()).then(|| self.sights.pose(t_s + self.sights.row_s(y)));
            let pose = turned.as_ref().unwrap_or(&still);
            let x = |k| (k * WIDTH / 2) as f64;
            (2 * columns.start..=2 * columns.end)
                .map(|k| {
                    if between || k % 2 == 1 {
                        self.node::<false>(pose, [x(k), y])
                    } else {
                        self.node::<true>(pose, [x(k), y])
                    }
                })
                .collect::<Vec<_>>()
        };
        let scale = self.white_e_s * self.step_s;
        let mut below = nodes(rows.start * HEIGHT);
        for row in rows {
            let above = below;
            let between = nodes(row * HEIGHT + HEIGHT / 2);
            below = nodes((row + 1) * HEIGHT);
            let lines = (row * HEIGHT).max(top)..((row + 1) * HEIGHT).min(top + height);
            for column in columns.clone() {
                let at = 2 * (column - columns.start);
                let cell = [&above, &between, &below].map(|row| [&row[at], &row[at + 1], &row[at + 2]]);
                let content = self.content(&cell);
                if content == Content::Nothing {
                    continue;
                }
                let (from, to) = ((column * WIDTH).max(left), ((column + 1) * WIDTH).min(left + width));
                let (left_px, top_px) = (column * WIDTH, row * HEIGHT);
                cell_buffer
                    .places
                    .fill(from - left_px..to - left_px, lines.start - top_px..lines.end - top_px);
                self.light(&cell, content, cell_buffer);
                let lights = cell_buffer.light.chunks_exact(to - from);
                for (y, lights) in lines.clone().zip(lights) {
                    let start = first + (y - top) * stride + from - left;
                    for (pixel, light) in electrons[start..start + to - from].iter_mut().zip(lights) {
                        *pixel += scale * f64::from(*light);
                    }
                }
            }
        }
    }

    /// Whether any light can fall into `window`: cones about its middle and about the Earth meet.
    fn may_touch(&self, window: Window) -> bool {
        let Window { x, y, width, height } = window;
        let (left, top) = (f64::from(x) - 0.5, f64::from(y) - 0.5);
        let (w, h) = (f64::from(width), f64::from(height));
        let direction = |u, v| self.sights.optics.unproject([left + u * w, top + v * h]);
        let Some(middle) = direction(0.5, 0.5) else { return true };
        let mut reach: f64 = 0.0;
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let Some(corner) = direction(u, v) else { return true };
            reach = reach.max(angle(middle, corner));
        }
        // A hundredth more for edges that distortion bends.
        angle(middle, self.centre) <= self.cone_rad + 1.01 * reach
    }

    /// What pixels need to know of a line of sight; at a `CORNER` of a cell all of it.
    #[inline]
    fn node<const CORNER: bool>(&self, pose: &Pose, pixel: [f64; 2]) -> Node {
        let Some(sight) = self.sights.sight(pose, pixel) else {
            return Node { depth: f32::NAN, values: [0.0; COUNT] };
        };
        let moved_km = (sight.km_s * self.step_s).abs();
        let (blurred_km, moved_km) = if self.integrates { (0.0, moved_km) } else { (moved_km, 0.0) };
        let sigma2 = self.variance_px2 * sight.km_per_px * sight.km_per_px + blurred_km * blurred_km / 12.0;
        let sigma_km = sigma2.sqrt();
        let lift = self.lift_km(&sight, sigma_km, moved_km) / sight.km_per_depth.max(1e-9);
        let [x, y, z] = sight.nearest.map(|c| c as f32);
        let mut values = [0.0; COUNT];
        (values[0], values[1], values[2]) = (x, y, z);
        (values[KM_PER_DEPTH], values[SIGMA_KM]) = (sight.km_per_depth as f32, sigma_km as f32);
        values[MOVED_KM] = moved_km as f32;
        if CORNER {
            // A pixel's angle, and how far the ground goes by within a part: the box of the motion as a
            // Gaussian of two widths.
            let moved_rad = 0.577 * sight.ground_rad_s * self.step_s;
            let spread = (self.per_focal_length * self.per_focal_length + moved_rad * moved_rad).sqrt();
            for (value, exact) in values[BACK..].iter_mut().zip(sight.back) {
                *value = exact as f32;
            }
            values[CUBE] = (sight.cosine * sight.cosine * sight.cosine) as f32;
            (values[SLOPE], values[WAY_KM]) = (sight.slope as f32, sight.way_km as f32);
            values[SPREAD] = spread as f32;
        }
        Node { depth: (sight.depth + lift) as f32, values }
    }

    /// How much higher than in the mean the limb stands under a line of sight, km; 0 where that makes no
    /// difference.
    fn lift_km(&self, sight: &Sight, sigma_km: f64, moved_km: f64) -> f64 {
        let (deep, shallow) = HORIZON_DEPTH;
        let counts = smooth((deep - sight.depth) / (deep - shallow));
        // Two cells and more above the last light.
        let high = -sight.depth * sight.km_per_depth
            > self.top_km + REACH_SIGMAS * sigma_km + 0.5 * moved_km + HIGHEST_KM + 40.0 * sight.km_per_px;
        if counts == 0.0 || high {
            return 0.0;
        }
        let place = times((1.0 - sight.depth).max(1e-9).sqrt().recip(), sight.nearest);
        counts * self.looks.horizon.height_km(place, self.declination_sine)
    }

    /// What falls into a cell, from its points and some margin.
    fn content(&self, cell: &Cell) -> Content {
        let (mut low, mut high, mut sigma, mut moved) = (f32::MAX, f32::MIN, 0.0f32, 0.0f32);
        for node in cell.iter().flatten() {
            if node.depth.is_nan() {
                return Content::Nothing;
            }
            let height = -node.depth * node.values[KM_PER_DEPTH];
            (low, high) = (low.min(height), high.max(height));
            (sigma, moved) = (sigma.max(node.values[SIGMA_KM]), moved.max(node.values[MOVED_KM]));
        }
        let margin = 0.1 * (high - low) + 1.0;
        let reach = REACH_SIGMAS as f32 * 1.1 * sigma + 0.55 * moved + margin;
        if low > self.top_km as f32 + reach {
            Content::Nothing
        } else if high < -reach {
            Content::Surface
        } else {
            Content::Limb
        }
    }

    /// Brightness of the pixels in the buffer, relative to a white surface with the Sun in the zenith.
    fn light(&self, cell: &Cell, content: Content, cell_buffer: &mut CellBuffer) {
        let CellBuffer {
            places,
            seen,
            numbers,
            light,
            depth,
            glow,
            cube,
            share,
            km_per_depth,
            sigma_km,
            moved_km,
            ..
        } = cell_buffer;
        let count = places.count();
        places.depth(cell, depth);
        places.values(cell, CUBE, cube);
        let mut seeing = 0;
        if content == Content::Limb {
            places.values(cell, KM_PER_DEPTH, km_per_depth);
            places.values(cell, SIGMA_KM, sigma_km);
            for (depth, km) in depth[..count].iter_mut().zip(&*km_per_depth) {
                *depth *= -km;
            }
            moved_km[..count].fill(0.0);
            if self.integrates {
                places.values(cell, MOVED_KM, moved_km);
            }
            self.looks.limb.read([&sigma_km[..count], moved_km], [depth, share, glow]);
            // Nothing of the surface shines in the upper air.
            for number in 0..count {
                let (depth_km, part) = (depth[number], share[number]);
                (depth[seeing], share[seeing]) = (depth_km / km_per_depth[number], part);
                numbers[seeing] = number as u8;
                seeing += usize::from(part != 0.0);
            }
            seen.choose(places, &numbers[..seeing]);
            light[..count].fill(0.0);
        } else {
            seen.clone_from(places);
            share[..count].fill(1.0);
            glow[..count].fill(0.0);
        }
        if seen.count() > 0 {
            self.surface(cell, cell_buffer);
        }
        let CellBuffer { light, glow, cube, numbers, albedo, .. } = cell_buffer;
        if content == Content::Limb {
            for (number, albedo) in numbers[..seeing].iter().zip(&*albedo) {
                light[usize::from(*number) % AREA] = *albedo;
            }
        } else {
            light[..count].copy_from_slice(&albedo[..count]);
        }
        for ((light, glow), cube) in light[..count].iter_mut().zip(&*glow).zip(&*cube) {
            *light = cube * (*light + glow);
        }
    }

    /// Brightness of the surface at which the seeing lines arrive, `depth` deep, times `share`: in `albedo`.
    fn surface(&self, cell: &Cell, cell_buffer: &mut CellBuffer) {
        let CellBuffer { seen, depth, share, sight, place, lit, view, albedo, map, .. } = cell_buffer;
        let count = seen.count();
        for (k, lane) in sight.iter_mut().enumerate() {
            match k {
                0..=2 => seen.nearest(cell, k, lane),
                3..=5 => seen.values(cell, BACK + k - 3, lane),
                6 => seen.values(cell, SLOPE, lane),
                7 => seen.values(cell, WAY_KM, lane),
                _ => seen.values(cell, SPREAD, lane),
            }
        }
        self.arrive(seen.padded(), (depth, sight), (place, lit, view, albedo));
        let [x, y, z] = place;
        if lit[..count].iter().all(|lit| *lit == 0.0) {
            albedo[..count].fill(0.0);
            return;
        }
        self.looks.map.read([&x[..count], &y[..count], &z[..count]], &mut albedo[..count], map);
        let Shade { mean_albedo, haze, lommel_seeliger: k, .. } = self.shade;
        let [sx, sy, sz] = self.sun;
        for i in 0..seen.padded() {
            let mixed = albedo[i] + haze / view[i] * (mean_albedo - albedo[i]);
            albedo[i] = match self.shade.law {
                Photometry::Mixed => share[i] * mixed * lit[i] * (2.0 * k / (lit[i] + view[i]) + 1.0 - k),
                Photometry::Minnaert => {
                    // Stretched axes are as good as the Earth's to 0.3 %.
                    let phase = sight[3][i] * sx + sight[4][i] * sy + sight[5][i] * sz;
                    share[i] * minnaert(mixed, lit[i], view[i], phase)
                }
            };
        }
    }

    /// Where lines of sight arrive, `depth` deep: place, sunlight and view there, and the level of the map.
    // Alone, the compiler knows that nothing overlaps, and takes four at a time.
    #[inline(never)]
    fn arrive(
        &self,
        count: usize,
        (depth, [px, py, pz, bx, by, bz, slope, way, spread]): (&Lane, &[Lane; 9]),
        ([x, y, z], lit, view, level): (&mut [Lane; 3], &mut Lane, &mut Lane, &mut Lane),
    ) {
        let (squashed, equator_km, map_scale) = (self.squashed, self.equator_km, self.map_scale);
        let ([sx, sy, sz], w) = (self.sun, self.shade.twilight);
        let per_foot = 1.0 / (4.0 * w);
        for i in 0..count.min(AREA) {
            let root = depth[i].max(0.0).sqrt();
            (x[i], y[i], z[i]) = (px[i] + root * bx[i], py[i] + root * by[i], pz[i] + root * bz[i]);
            // The normal is (x, y, z a / b) stretched once more, of this length.
            let per_length = 1.0 / (x[i] * x[i] + y[i] * y[i] + squashed * (z[i] * z[i])).sqrt();
            let sunlight = (x[i] * sx + y[i] * sy + z[i] * sz) * per_length;
            let foot = (sunlight + w).max(0.0);
            lit[i] = if sunlight < w { foot * foot * per_foot } else { sunlight };
            let straight = root * slope[i] * per_length;
            view[i] = (straight * straight + HAZE * HAZE).sqrt();
            let size = (way[i] - root * equator_km).max(0.0) * spread[i] / view[i];
            level[i] = AlbedoMap::level_of(size * map_scale);
        }
    }
}

#[cfg(test)]
mod tests;
