//! The Moon: a disc with a phase.
//!
//! In: the directions of Moon and Sun and the Moon's distance, in the axes of a path. Out: mean electrons of
//! a window. A point of the disc has the radiance factor `2 p m / (m + μ) · f`, after Lommel and Seeliger
//! with the geometric albedo p = 0.12; m and μ are the cosines of Sun and view. `f = exp(-phase / 69 deg)`
//! makes the half Moon a tenth as bright as the full one (V = -10.2 and -12.7) and stands for its roughness.
//! Maria and earthshine are left out. The edge is blurred by the PSF in closed form, the terminator fades by
//! itself. While the image moves by more than [`STEP_PX`] it is drawn in steps.

use crate::world::attitude::{Vector, dot};
use crate::world::lens::optics::Optics;
use crate::world::vector::{length, plus, times, unit};
use fsw_hal::Window;

/// Mean radius, km.
pub const RADIUS_KM: f64 = 1737.4;
/// Geometric albedo between 500 and 900 nm.
const ALBEDO: f64 = 0.12;
/// Phase angle over which the roughness costs a factor e, rad.
const ROUGHNESS_RAD: f64 = 1.204;
/// PSF widths beyond which the edge leaves no light.
const REACH_SIGMAS: f64 = 5.0;
/// Longest step of a moving image, px.
pub const STEP_PX: f64 = 1.0;

/// The Moon as a path sees it at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoonView {
    /// Unit vector to the Moon, path axes.
    pub moon: Vector,
    /// Its distance, km.
    pub distance_km: f64,
    /// Unit vector from the Moon to the Sun, path axes.
    pub sun: Vector,
}

/// The Moon's image in an exposure.
#[derive(Debug, Clone)]
pub struct MoonImage {
    optics: Optics,
    /// Equal steps of the exposure.
    views: Vec<Step>,
    /// Columns and rows between which all of them lie, px.
    box_px: [[f64; 2]; 2],
    sigma_rad: f64,
    /// Electrons a second of a pixel that sees a white Lambert surface with the Sun in the zenith.
    white_e_s: f64,
}

/// A step of an exposure.
#[derive(Debug, Clone, Copy)]
struct Step {
    view: MoonView,
    radius_rad: f64,
    /// Less than the cosine of the angle from the Moon's centre beyond which there is no light.
    reach_cosine: f64,
}

impl Step {
    fn new(view: MoonView, sigma_rad: f64) -> Self {
        let radius_rad = view.radius_rad();
        // Light ends where the sine of the angle is the reach.
        let reach = (radius_rad + REACH_SIGMAS * sigma_rad).min(1.0);
        Self { view, radius_rad, reach_cosine: (1.0 - reach * reach).sqrt() - 1e-9 }
    }

    /// Columns and rows about its image that hold all its light, px: twice what a lens without distortion
    /// needs.
    fn box_px(&self, optics: &Optics, sigma_rad: f64) -> [[f64; 2]; 2] {
        let z = self.view.moon[2];
        match optics.project(self.view.moon).filter(|_| z > 0.3) {
            Some(centre) => {
                let reach_rad = self.radius_rad + REACH_SIGMAS * sigma_rad;
                let reach_px = 2.0 * optics.focal_length_px() * reach_rad / (z * z) + 2.0;
                centre.map(|at| [at - reach_px, at + reach_px])
            }
            None => [[f64::MIN, f64::MAX]; 2],
        }
    }
}

impl MoonImage {
    /// In equal steps `views` of the exposure; `None` where no step shows any of it on the detector.
    pub fn new(optics: &Optics, psf_sigma_px: f64, white_e_s: f64, views: Vec<MoonView>) -> Option<Self> {
        let sigma_rad = psf_sigma_px / optics.focal_length_px();
        let seen = views.iter().any(|view| {
            let reach_px = (view.radius_rad() + REACH_SIGMAS * sigma_rad) * 1.3 * optics.focal_length_px();
            view.moon[2] >= optics.cone_cosine(reach_px)
        });
        let views: Vec<Step> = views.into_iter().map(|view| Step::new(view, sigma_rad)).collect();
        let boxes = views.iter().map(|step| step.box_px(optics, sigma_rad));
        let joined = |one: [[f64; 2]; 2], other: [[f64; 2]; 2]| {
            [0, 1].map(|axis| [one[axis][0].min(other[axis][0]), one[axis][1].max(other[axis][1])])
        };
        let box_px = boxes.reduce(joined).unwrap_or_default();
        seen.then_some(Self { optics: *optics, views, box_px, sigma_rad, white_e_s })
    }

    /// Adds the electrons of `time_s` to `electrons`, the pixels of `window` row by row; `hidden` says
    /// whether something stands before the Moon in a direction (path axes).
    pub fn add_to(
        &self,
        window: Window,
        time_s: f64,
        hidden: impl Fn(Vector) -> bool,
        electrons: &mut [f64],
    ) {
        let scale = self.white_e_s * time_s / self.views.len() as f64;
        let [columns, rows] =
            self.box_px.map(|[least, most]| move |at: &u16| (least..=most).contains(&f64::from(*at)));
        for (y, line) in (window.y..).zip(electrons.chunks_exact_mut(usize::from(window.width).max(1))) {
            if !rows(&y) {
                continue;
            }
            for (x, pixel) in (window.x..).zip(line).filter(|(x, _)| columns(x)) {
                let Some(direction) = self.optics.unproject([f64::from(x), f64::from(y)]) else { continue };
                let sum: f64 = self.views.iter().map(|step| step.radiance(direction, self.sigma_rad)).sum();
                if sum > 0.0 && !hidden(direction) {
                    *pixel += scale * sum;
                }
            }
        }
    }
}

impl MoonView {
    /// Angular radius, rad.
    pub fn radius_rad(&self) -> f64 {
        libm::asin((RADIUS_KM / self.distance_km).min(1.0))
    }
}

impl Step {
    /// Radiance factor in a direction (unit vector), the edge blurred by `sigma_rad`.
    fn radiance(&self, direction: Vector, sigma_rad: f64) -> f64 {
        let (MoonView { moon, sun, .. }, radius) = (self.view, self.radius_rad);
        let beside = dot(direction, moon);
        if beside < self.reach_cosine {
            return 0.0;
        }
        let across = plus(direction, -beside, moon);
        let off = length(across);
        let beyond = (off - radius) / sigma_rad;
        if beyond > REACH_SIGMAS || beside < 0.0 {
            return 0.0;
        }
        // Place on the visible half of the sphere; beyond the edge, that of the edge.
        let share = (off / radius).min(0.999);
        let aside = if off > 0.0 { times(share / off, across) } else { [0.0; 3] };
        let view = (1.0 - share * share).sqrt();
        let normal = plus(aside, -view, moon);
        let lit = dot(normal, sun);
        if lit <= 0.0 {
            return 0.0;
        }
        let phase = libm::acos((-dot(moon, sun)).clamp(-1.0, 1.0));
        let covered = 0.5 * libm::erfc(std::f64::consts::FRAC_1_SQRT_2 * beyond);
        2.0 * ALBEDO * libm::exp(-phase / ROUGHNESS_RAD) * covered * lit / (lit + view)
    }
}

/// The view of a Moon at `moon_km` from a satellite at `position_km`, ICRS axes about the Earth's centre,
/// through `path` (ICRS to path axes) with the aberration `v / c`.
pub fn view(
    moon_km: Vector,
    sun_km: Vector,
    position_km: Vector,
    aberration: Vector,
    path: &[Vector; 3],
) -> MoonView {
    let there = plus(moon_km, -1.0, position_km);
    let turn = |v: Vector| crate::world::attitude::apply(path, v);
    MoonView {
        moon: unit(turn(plus(unit(there), 1.0, aberration))),
        distance_km: length(there),
        sun: unit(turn(plus(sun_km, -1.0, moon_km))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::camera_file::CameraFile;

    fn optics() -> Optics {
        Optics::new(&CameraFile::reference()).unwrap()
    }

    /// Towards a pixel, with the Sun `phase_deg` from behind the observer.
    fn towards(pixel: [f64; 2], phase_deg: f64) -> MoonView {
        let moon = optics().unproject(pixel).unwrap();
        let aside = unit(crate::world::vector::cross(moon, [0.0, 1.0, 0.0]));
        let (s, c) = libm::sincos(phase_deg.to_radians());
        MoonView { moon, distance_km: 384_400.0, sun: plus(times(-c, moon), s, aside) }
    }

    fn drawn(views: Vec<MoonView>, window: Window) -> Vec<f64> {
        let mut electrons = vec![0.0; window.area()];
        MoonImage::new(&optics(), 0.9, 1.0, views).unwrap().add_to(window, 1.0, |_| false, &mut electrons);
        electrons
    }

    #[test]
    fn the_full_moon_gives_its_albedo_and_a_half_moon_a_tenth() {
        let window = Window { x: 560, y: 440, width: 100, height: 100 };
        let sum = |phase| drawn(vec![towards([610.0, 490.0], phase)], window).iter().sum::<f64>();
        let radius_px = 1737.4 / 384_400.0 * 3000.0;
        let full = sum(0.0) / (std::f64::consts::PI * radius_px * radius_px);
        // Lommel and Seeliger's full disc is even; the blurred edge adds σ²/R², 0.4 %, half of it inside.
        assert!((full / ALBEDO - 1.0).abs() < 0.02, "{full}");
        let half = sum(90.0) / sum(0.0);
        assert!((half - 0.1).abs() < 0.015, "{half}");
        assert!(sum(175.0) / sum(0.0) < 2e-3);
    }

    #[test]
    fn the_lit_side_is_towards_the_sun_and_the_edge_is_where_it_should_be() {
        let line =
            drawn(vec![towards([610.0, 490.0], 60.0)], Window { x: 560, y: 490, width: 100, height: 1 });
        // The Sun stands towards positive or negative x as the cross product above says: moon × y = -x.
        let (left, right): (f64, f64) = (line[..50].iter().sum(), line[51..].iter().sum());
        assert!(left > 3.0 * right, "{left} {right}");
        // Half of the edge's light at the radius of 13.56 px.
        let full =
            drawn(vec![towards([610.0, 490.0], 0.0)], Window { x: 560, y: 490, width: 100, height: 1 });
        let (inside, outside) = (full[50 - 13], full[50 - 14]);
        let crossing = 13.0 + (inside - 0.5 * ALBEDO) / (inside - outside);
        assert!((crossing - 13.56).abs() < 0.05, "{crossing}");
    }

    #[test]
    fn a_moving_moon_is_smeared_and_what_stands_before_it_hides_it() {
        let window = Window { x: 560, y: 480, width: 120, height: 20 };
        let still = drawn(vec![towards([610.0, 490.0], 0.0)], window);
        let moving = drawn(vec![towards([610.0, 490.0], 0.0), towards([630.0, 490.0], 0.0)], window);
        let (still, moved): (f64, f64) = (still.iter().sum(), moving.iter().sum());
        assert!((moved / still - 1.0).abs() < 1e-2);
        let mut nothing = vec![0.0; window.area()];
        let image = MoonImage::new(&optics(), 0.9, 1.0, vec![towards([610.0, 490.0], 0.0)]).unwrap();
        image.add_to(window, 1.0, |_| true, &mut nothing);
        assert!(nothing.iter().all(|e| *e == 0.0));
        assert!(MoonImage::new(&optics(), 0.9, 1.0, vec![towards([-400.0, 490.0], 0.0)]).is_none());
    }
}
