//! Prediction of the Earth's image from a position.
//!
//! In: the vector to the Earth's centre, km, and the [`Body`] in the Earth path's frame. Out: the sky that
//! the disc and its glow cover, and the predicted limb points on the detector where it is lit.
//!
//! In sphere space the limb is the cone of half angle `asin(1 / |C|)` about the centre `C`. Its points are
//! `w cos + (e1 cos φ + e2 sin φ) sin`; the vector from the centre to a point is
//! `(e1 cos φ + e2 sin φ) cos - w sin`. A coarse pass over [`COARSE`] azimuths finds the cells that are in
//! the field and lit, a fine pass of [`FINE`] azimuths over those cells gives points evenly along an arc of
//! any length, 20 deg to a full turn. Azimuths advance by a constant rotation instead of sine calls.
//!
//! Assumes that the limb's height is even. Error against an f64 projection 2e-3 px. Cost: about 250
//! projections.

use super::shape::{Body, normal_basis, unit};
use super::{EarthParameters, MAX_LIMB_POINTS};
use crate::camera::Camera;
use crate::frames::{Direction, EarthPath};
use crate::trigonometry::sine_cosine;
use heapless::Vec;
use nalgebra::Vector3;

/// Azimuths of the coarse pass; an arc shorter than a cell, 2.8 deg, may be missed.
pub const COARSE: usize = 128;
/// Azimuths of the fine pass: twice as many as strips at most, so that these stand evenly to half a step.
pub const FINE: usize = 96;
/// Azimuths at which a lit limb is looked for where every one counts, 0.5 deg apart.
const AZIMUTHS: u16 = 720;
/// Cosine and sine from one to the next that is looked at, 199 further on: all are met in the end, and after
/// n steps no gap is wider than 2.2 turns / n.
const NEXT_AZIMUTH: [f32; 2] = [-0.165_047_6, 0.986_285_6];
/// Between two of them: cosine and sine of 1/4, 1/8, 1/16, 1/32 and 1/64 deg.
const BETWEEN: [[f32; 2]; 5] = [
    [0.999_990_5, 4.363_309e-3],
    [0.999_997_6, 2.181_661e-3],
    [0.999_999_4, 1.090_831e-3],
    [0.999_999_8, 5.454_154e-4],
    [0.999_999_96, 2.727_077e-4],
];
/// Of half a degree of azimuth the limb is on the detector in both ends or this near to it, px.
const NEAR_PX: f32 = 32.0;
/// Number of phases in which evenly spread points can stand.
pub const PHASES: u8 = 8;
/// A cell of the coarse pass, rad.
const CELL_RAD: f32 = core::f32::consts::TAU / COARSE as f32;
/// Cosine and sine of a cell.
const CELL: [f32; 2] = [0.998_795_45, 0.049_067_676];
/// Half of the distance over which slopes on the detector are taken, px: f32 leaves an error of 3e-5 of them.
const SLOPE_BASE_PX: f32 = 3.0;

const _: () = assert!(FINE <= 128 && COARSE <= 128 && MAX_LIMB_POINTS <= FINE);

/// A point at which the limb is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedLimb {
    /// Where, px.
    pub at_px: [f32; 2],
    /// Unit vector on the detector across the limb, towards space.
    pub outward_px: [f32; 2],
    /// Unit vector along which height is counted there, Earth path's frame: a centre displaced by `d` lowers
    /// the limb by `normal · d` less.
    pub normal: Vector3<f32>,
    /// Height above the limb that a pixel across it spans, km.
    pub km_per_px: f32,
    /// Sine of the Sun's elevation there; one where the Sun is not known.
    pub sun_sine: f32,
    /// Cosine of the angle at the limb between the directions to the Sun and to the camera; zero where the
    /// Sun is not known.
    pub sun_facing: f32,
    /// How far the exposure draws it out across itself, px; zero of a camera at rest.
    pub drawn_px: f32,
}

/// Length of limb in the field, rad of azimuth about the centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LitArcs {
    /// Lit or not.
    pub arc_rad: f32,
    /// Lit.
    pub lit_rad: f32,
    /// Lit well enough to be measured.
    pub usable_rad: f32,
}

/// The limb in the field.
#[derive(Clone, Debug, Default)]
pub struct LimbInField {
    /// Points where it is lit well enough, evenly along it.
    pub points: Vec<ExpectedLimb, MAX_LIMB_POINTS>,
    /// Its length.
    pub lit_arcs: LitArcs,
}

/// A direction by the limb, in sphere space; all times the direction's length there.
struct PastLimb {
    /// Component towards the centre.
    along: f32,
    /// Sine and cosine of the angle by which it passes the limb; negative: it meets the body.
    past: f32,
    facing: f32,
    length: f32,
}

/// The Earth seen from a place.
#[derive(Clone, Copy, Debug)]
pub struct View {
    body: Body,
    /// The centre in sphere space, Earth radii.
    centre: Vector3<f32>,
    /// Unit vector to it, and two across.
    axes: [Vector3<f32>; 3],
    /// Sine and cosine of the limb cone's half angle.
    sine: f32,
    cosine: f32,
}

impl View {
    /// From the vector to the Earth's centre, km. `None` when it is not finite, inside the body, or more than
    /// a thousand radii away.
    pub fn new(centre_km: &Vector3<f32>, body: &Body) -> Option<Self> {
        let (centre, sine, cosine) = body.limb_cone(centre_km)?;
        let axis = centre * sine;
        let (first, second) = normal_basis(&axis);
        Some(Self { body: *body, centre, axes: [axis, first, second], sine, cosine })
    }

    /// Distance of the limb, km: height that a radian spans there.
    pub fn limb_distance_km(&self) -> f32 {
        self.body.radius_km() * self.cosine / self.sine
    }

    /// Mask of the sky hidden by the Earth and its glow, the latter to `margin_rad` (up to a right angle)
    /// from the limb.
    pub fn mask(&self, margin_rad: f32, parameters: &EarthParameters) -> EarthMask<'_> {
        let twilight_sine = sine_cosine(parameters.light.twilight_deg.to_radians()).0;
        EarthMask { view: self, margin_sine: sine_cosine(margin_rad).0, twilight_sine }
    }

    /// Radial unit vector of an azimuth given by its cosine and sine.
    fn radial(&self, [cosine, sine]: [f32; 2]) -> Vector3<f32> {
        let [_, first, second] = self.axes;
        first * cosine + second * sine
    }

    /// Vector to the limb, of any length, along a radial unit vector.
    fn towards_limb(&self, radial: &Vector3<f32>) -> Vector3<f32> {
        let [axis, ..] = self.axes;
        self.body.in_space(&(axis * self.cosine + radial * self.sine))
    }

    /// Direction of the limb at an azimuth about the centre, given by its cosine and sine; where azimuth
    /// begins is arbitrary.
    pub fn limb_ray(&self, azimuth: [f32; 2]) -> Option<Direction<EarthPath>> {
        Direction::new(self.towards_limb(&self.radial(azimuth)))
    }

    /// Sine of the angle between the centre and the limb, in sphere space.
    pub fn limb_sine(&self) -> f32 {
        self.sine
    }

    /// Place on the detector and sine of the Sun's elevation of the limb at an azimuth; `None` outside the
    /// field.
    fn project_limb(&self, azimuth: [f32; 2], camera: &Camera, margin_px: f32) -> Option<([f32; 2], f32)> {
        let (radial, [axis, ..]) = (self.radial(azimuth), self.axes);
        let ray = self.towards_limb(&radial);
        if camera.is_far_outside(&ray) {
            return None;
        }
        let at_px = camera.project_earth_inside(&Direction::new(ray)?, margin_px)?;
        let point = radial * self.cosine - axis * self.sine;
        Some((at_px, self.body.sun_sine(&point).unwrap_or(1.0)))
    }

    /// The predicted limb point at an azimuth; `None` outside the field.
    fn expected(&self, azimuth: [f32; 2], camera: &Camera, margin_px: f32) -> Option<ExpectedLimb> {
        let (at_px, sun_sine) = self.project_limb(azimuth, camera, margin_px)?;
        let ([cosine, sine], [axis, ..]) = (azimuth, self.axes);
        let (radial, tangent) = (self.radial(azimuth), self.radial([-sine, cosine]));
        let ray = self.body.in_space(&(axis * self.cosine + radial * self.sine));
        let step = SLOPE_BASE_PX * camera.rad_per_px();
        // Where the detector's position goes for a step along a vector of sphere space, px per unit.
        let slope = |vector: &Vector3<f32>| {
            let shift = self.body.in_space(vector) * step;
            let [x1, y1] = camera.project_earth(&Direction::new(ray + shift)?)?;
            let [x0, y0] = camera.project_earth(&Direction::new(ray - shift)?)?;
            Some([(x1 - x0) / (2.0 * step), (y1 - y0) / (2.0 * step)])
        };
        let [along_x, along_y] = slope(&tangent)?;
        let point = radial * self.cosine - axis * self.sine;
        let [out_x, out_y] = slope(&point)?;
        let length = libm::sqrtf(along_x * along_x + along_y * along_y);
        let turned = (out_x * along_y - out_y * along_x) / length.max(1e-3);
        let sense = if turned < 0.0 { -1.0 } else { 1.0 };
        let outward_px = [along_y * sense / length.max(1e-3), -along_x * sense / length.max(1e-3)];
        let normal = unit(&self.body.upward(&point), &radial);
        // The distance to the limb point is cos / sin radii.
        let km_per_rad = self.body.radius_km() * self.cosine / self.sine;
        let km_per_px = km_per_rad / (turned * sense).max(1e-3);
        let sun_facing =
            Direction::new(ray).and_then(|ray| self.body.sun_cosine(&ray)).map_or(0.0, |cosine| -cosine);
        Some(ExpectedLimb { at_px, outward_px, normal, km_per_px, sun_sine, sun_facing, drawn_px: 0.0 })
    }

    /// Where a direction meets the body, or else passes it nearest: vector from the centre, sphere space; and
    /// whether it meets.
    fn nearest(&self, direction: &Direction<EarthPath>) -> (Vector3<f32>, bool) {
        let ray = unit(&self.body.in_sphere_space(direction.vector()), direction.vector());
        let along = self.centre.dot(&ray);
        let nearest = self.centre - ray * along;
        let depth = 1.0 - nearest.dot(&nearest);
        let meets = depth >= 0.0 && along > 0.0;
        (ray * (along - libm::sqrtf(depth.max(0.0))) - self.centre, meets)
    }

    /// Upward normal of the ground that a direction meets: its components along the direction to the centre
    /// and the two across it from which azimuth is counted; `None` where it meets none.
    pub(super) fn upward_where_met(&self, direction: &Direction<EarthPath>) -> Option<[f32; 3]> {
        let (point, meets) = self.nearest(direction);
        let upward = unit(&self.body.upward(&point), &point);
        meets.then(|| self.axes.map(|axis| axis.dot(&upward)))
    }

    /// Direction at an azimuth, given by cosine and sine, and an angle from the line from the centre to the
    /// camera, given alike.
    pub(super) fn direction(&self, azimuth: [f32; 2], angle: [f32; 2]) -> Option<Direction<EarthPath>> {
        let ([axis, ..], [cosine, sine]) = (self.axes, angle);
        Direction::new(self.radial(azimuth) * sine - axis * cosine)
    }

    /// How much of the limb on the detector is lit, as an angle, rad: of how far a point of it is inside the
    /// field, and its Sun above the elevation from which it is lit, the less; of all points the most. None is
    /// lit where it is not positive. The search ends with a point that has more than `enough_rad`.
    pub fn lit_margin_rad(&self, camera: &Camera, parameters: &EarthParameters, enough_rad: f32) -> f32 {
        let lit = sine_cosine(parameters.light.lit_deg.to_radians()).0;
        let margin = |azimuth| {
            let limb = self.project_limb(azimuth, camera, -NEAR_PX);
            limb.map_or(f32::NEG_INFINITY, |(at_px, sun_sine)| {
                ((camera.inside_px(at_px) + 0.5) * camera.rad_per_px()).min(sun_sine - lit)
            })
        };
        let mut azimuth = [1.0, 0.0];
        let mut best = (margin(azimuth), azimuth);
        for _ in 1..AZIMUTHS {
            if best.0 > enough_rad {
                return best.0;
            }
            azimuth = add_angles(azimuth, NEXT_AZIMUTH);
            let here = margin(azimuth);
            if here > best.0 {
                best = (here, azimuth);
            }
        }
        // The most lies between two of these.
        for [cosine, sine] in BETWEEN {
            let middle = best.1;
            for beside in [add_angles(middle, [cosine, sine]), add_angles(middle, [cosine, -sine])] {
                let there = margin(beside);
                if there > best.0 {
                    best = (there, beside);
                }
            }
        }
        best.0
    }

    /// Whether a disc of `radius_rad` about a direction is hidden whole.
    pub fn hides_disc(&self, direction: &Direction<EarthPath>, radius_rad: f32) -> bool {
        let PastLimb { along, past, length, .. } = self.past_limb(direction);
        along > 0.0 && past < -radius_rad * length
    }

    /// How a direction passes the limb.
    #[inline]
    fn past_limb(&self, direction: &Direction<EarthPath>) -> PastLimb {
        let Self { body, axes: [axis, ..], sine, cosine, .. } = self;
        let ray = body.in_sphere_space(direction.vector());
        let turned = axis.cross(&ray);
        let (along, off) = (axis.dot(&ray), libm::sqrtf(turned.dot(&turned)));
        PastLimb {
            along,
            past: off * cosine - along * sine,
            facing: along * cosine + off * sine,
            length: libm::sqrtf(along * along + off * off),
        }
    }

    /// Length of limb inside the detector by `margin_px`. Ends as soon as some of it is lit and `enough_rad`
    /// can be measured: then all there is may be longer.
    pub fn lit_arcs(
        &self,
        camera: &Camera,
        margin_px: f32,
        enough_rad: f32,
        parameters: &EarthParameters,
    ) -> LitArcs {
        self.coarse(camera, margin_px, enough_rad, parameters).0
    }

    /// The same, and the cells in which a limb that can be measured may stand.
    fn coarse(
        &self,
        camera: &Camera,
        margin_px: f32,
        enough_rad: f32,
        parameters: &EarthParameters,
    ) -> (LitArcs, u128) {
        let lit = sine_cosine(parameters.light.lit_deg.to_radians()).0;
        let least = least_sun_sine(parameters);
        let mut light = LitArcs::default();
        // Bit i belongs to azimuth i.
        let mut usable = 0u128;
        let mut azimuth = [1.0, 0.0];
        for _ in 0..COARSE {
            usable >>= 1;
            if let Some((_, sun_sine)) = self.project_limb(azimuth, camera, margin_px) {
                light.arc_rad += CELL_RAD;
                if sun_sine > lit {
                    light.lit_rad += CELL_RAD;
                }
                if sun_sine > least {
                    light.usable_rad += CELL_RAD;
                    usable |= 1 << (COARSE - 1);
                }
                if light.lit_rad > 0.0 && light.usable_rad >= enough_rad {
                    break;
                }
            }
            azimuth = add_angles(azimuth, CELL);
        }
        // A limb that stands at an azimuth may begin in the cell before and end in the one after.
        (light, usable | usable.rotate_right(1))
    }

    /// The limb inside the detector by `margin_px`, with up to `most` points where it is lit well enough to
    /// be measured. `phase` moves them along it by eighths of their distance.
    pub fn limb(
        &self,
        camera: &Camera,
        margin_px: f32,
        (most, phase): (usize, u8),
        parameters: &EarthParameters,
    ) -> LimbInField {
        let least = least_sun_sine(parameters);
        let (lit_arcs, cells) = self.coarse(camera, margin_px, f32::INFINITY, parameters);
        let mut limb = LimbInField { points: Vec::new(), lit_arcs };
        let mut usable: Vec<[f32; 2], FINE> = Vec::new();
        for azimuth in FineAzimuths::over(cells) {
            let seen = self.project_limb(azimuth, camera, margin_px);
            if seen.is_some_and(|(_, sine)| sine > least) {
                // There are no more candidates than the list holds.
                let _ = usable.push(azimuth);
            }
        }
        let all = usable.len();
        let most = most.min(MAX_LIMB_POINTS).min(all);
        let mut rank = all * usize::from(phase % PHASES) / usize::from(PHASES);
        for azimuth in &usable {
            let before = rank;
            rank += most;
            // Of `all` points every one at which the count passes a multiple: evenly spread. `all` is not
            // zero here.
            let chosen = before / all.max(1) != rank / all.max(1);
            if !chosen {
                continue;
            }
            if let Some(expected) = self.expected(*azimuth, camera, margin_px) {
                let _ = limb.points.push(expected);
            }
        }
        limb
    }
}

/// [`FINE`] azimuths spread evenly over the chosen cells of the coarse pass: candidate i stands at `(i + 1/2)
/// count / FINE` cells.
struct FineAzimuths {
    /// The cells from the present one on, in the lowest bits.
    cells: u128,
    /// How many there are in all, and how many have been passed with the present one, times [`FINE`].
    count: u32,
    passed: u32,
    /// The present cell, and the azimuth at which it begins.
    cell: usize,
    start: [f32; 2],
    /// The next candidate.
    candidate: u32,
}

impl FineAzimuths {
    fn over(cells: u128) -> Self {
        let passed = if cells & 1 != 0 { FINE as u32 } else { 0 };
        Self { cells, count: cells.count_ones(), passed, cell: 0, start: [1.0, 0.0], candidate: 0 }
    }
}

impl Iterator for FineAzimuths {
    type Item = [f32; 2];

    #[inline(never)]
    fn next(&mut self) -> Option<[f32; 2]> {
        while (2 * self.candidate + 1) * self.count >= 2 * self.passed {
            (self.cell, self.cells) = (self.cell + 1, self.cells >> 1);
            if self.cell >= COARSE {
                return None;
            }
            self.start = add_angles(self.start, CELL);
            self.passed += if self.cells & 1 != 0 { FINE as u32 } else { 0 };
        }
        let offset = (2 * self.candidate + 1) * self.count + 2 * FINE as u32 - 2 * self.passed;
        self.candidate += 1;
        let angle = CELL_RAD * offset as f32 * (0.5 / FINE as f32);
        let square = angle * angle;
        // Up to 0.05 rad: error 2e-10.
        let small = [1.0 - square * (0.5 - square * (1.0 / 24.0)), angle * (1.0 - square * (1.0 / 6.0))];
        Some(add_angles(self.start, small))
    }
}

/// The sky hidden by the Earth and its glow.
#[derive(Clone, Copy, Debug)]
pub struct EarthMask<'v> {
    view: &'v View,
    margin_sine: f32,
    twilight_sine: f32,
}

impl EarthMask<'_> {
    /// Whether stars in this direction are outshone: lit Earth or lit glow.
    pub fn hides(&self, direction: &Direction<EarthPath>) -> bool {
        self.covers(direction) && self.is_lit(direction)
    }

    /// Whether a direction meets the Earth, or passes its limb within the margin.
    pub fn covers(&self, direction: &Direction<EarthPath>) -> bool {
        let PastLimb { along, past, facing, length } = self.view.past_limb(direction);
        past < 0.0 && along > 0.0 || (facing > 0.0 && past < self.margin_sine * length)
    }

    /// Whether the Earth is lit where this direction meets it, or passes it nearest: the Sun is up, or
    /// below the horizon by no more than the twilight.
    fn is_lit(&self, direction: &Direction<EarthPath>) -> bool {
        let (point, _) = self.view.nearest(direction);
        self.view.body.sun_sine(&point).is_none_or(|sine| sine > -self.twilight_sine)
    }
}

/// Sine of the least elevation of the Sun at a limb that can be measured.
fn least_sun_sine(parameters: &EarthParameters) -> f32 {
    sine_cosine(parameters.light.usable_deg.to_radians()).0
}

/// Sum of two angles given by cosine and sine.
pub(super) fn add_angles([c1, s1]: [f32; 2], [c2, s2]: [f32; 2]) -> [f32; 2] {
    [c1 * c2 - s1 * s2, s1 * c2 + c1 * s2]
}

#[cfg(test)]
mod tests;
