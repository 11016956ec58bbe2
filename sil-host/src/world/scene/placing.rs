//! Where the point sources of a scene are imaged in an exposure.
//!
//! In: a scene, a cycle, its exposure and truth. Out: light of stars, planets and satellites
//! ([`PointLight`]), and the stars on the detector at mid-exposure. What moves little, or to and fro, is a row
//! of images at the places where it is at the times of the steps of its smear; what moves farther than
//! [`IMAGES_PX`] one way is a line through its places at the ends of chords, and a row of images where it
//! begins to move or comes to rest.

use super::{Scene, Truth, VisibleStar, star_e_s};
use crate::world::attitude::{self, Vector, apply, dot};
use crate::world::detector::shutter::Way;
use crate::world::lens::optics::Optics;
use crate::world::lens::psf::Psf;
use crate::world::lens::spots::{Spot, Spots};
use crate::world::lens::streaks::{Streaks, length_px};
use crate::world::motion::Motion;
use crate::world::motion::trajectory::{EXPOSURE_STEPS, Trajectory};
use crate::world::scene::settings::SceneSettings;
use crate::world::sky::colour::BANDS;
use crate::world::vector::{length, plus, transposed};

/// Longest smear that is drawn as images in a row, px.
const IMAGES_PX: f64 = 8.0;
/// Longest chord of a line, px.
const CHORD_PX: f64 = 32.0;
/// Farthest that a chord is off the way between its ends, px.
const SAGITTA_PX: f64 = 0.005;
/// A line's light a pixel of way is taken as even over the width of an image. Chords along which it changes
/// by more than this share over that width are images.
const UNEVEN: f64 = 0.03;
/// Most chords of a line, and images in a row.
const PARTS_MAX: f64 = 4096.0;

/// What point sources are drawn as.
#[derive(Debug)]
pub(super) struct PointLight {
    /// Images.
    pub spots: Vec<Spot>,
    /// Lines.
    pub streaks: Streaks,
}

/// A path through which points are seen.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointPath<'a> {
    optics: Optics,
    motion: &'a Motion,
    /// The trajectory whose Earth path it is; `None`: it is the star path.
    earth_path_of: Option<&'a Trajectory>,
    /// A point's light over what it is through the star path.
    share: f64,
}

impl PointPath<'_> {
    /// ICRS to this path.
    fn at(&self, t_s: f64) -> [f64; 4] {
        match self.earth_path_of {
            Some(trajectory) => attitude::quaternion(&trajectory.earth_path(t_s)),
            None => self.motion.at(t_s),
        }
    }

    /// Its rate in its own axes, rad/s.
    fn rate_rad_s(&self, t_s: f64) -> Vector {
        let rate_rad_s = self.motion.rate_rad_s(t_s);
        self.earth_path_of.map_or(rate_rad_s, |trajectory| {
            apply(&transposed(&trajectory.mount.earth_to_star()), rate_rad_s)
        })
    }

    /// How fast star images move: turning across the line of sight moves them by f (1 + tan²), turning about
    /// it by their distance from the centre.
    fn pace(&self, middle_s: f64, time_s: f64) -> Pace {
        let (f, radius) = (self.optics.focal_length_px(), self.optics.radius_px());
        let step_s = time_s / f64::from(EXPOSURE_STEPS);
        let begin_s = middle_s - 0.5 * time_s;
        let px_per_rad =
            |[x, y, z]: Vector| libm::hypot(x, y) * f * (1.0 + (radius / f).powi(2)) + z.abs() * radius;
        let rate = |step| self.rate_rad_s(begin_s + f64::from(step) * step_s);
        let rates: Vec<Vector> = (0..=EXPOSURE_STEPS).map(rate).collect();
        let mean = rates.iter().fold([0.0; 3], |sum, rate| plus(sum, 1.0, *rate));
        let comes_back = rates.iter().any(|rate| dot(*rate, mean) < 0.0);
        let mut pace = Pace { comes_back, ..Pace::default() };
        let mut last: Option<Vector> = None;
        for rate_rad_s in rates {
            pace.smear_px = pace.smear_px.max(time_s * px_per_rad(rate_rad_s));
            pace.turned_rad = pace.turned_rad.max(time_s * length(rate_rad_s));
            if let Some(last) = last.replace(rate_rad_s) {
                let change = px_per_rad(plus(rate_rad_s, -1.0, last)) / step_s;
                pace.change_px_s2 = pace.change_px_s2.max(change);
            }
        }
        pace
    }
}

/// How a path looks during an exposure.
#[derive(Debug, Clone, Copy)]
struct Sight<'a> {
    path: &'a PointPath<'a>,
    middle_s: f64,
    /// Exposure, s.
    time_s: f64,
    pace: Pace,
    /// Line of sight at mid-exposure, ICRS.
    boresight: Vector,
    /// `v / c` at mid-exposure.
    aberration: Vector,
}

/// How fast a star image moves during an exposure.
#[derive(Debug, Clone, Copy, Default)]
struct Pace {
    /// Longest way, px.
    smear_px: f64,
    /// Greatest angle by which the path turns, rad.
    turned_rad: f64,
    /// Greatest change of its speed, px/s².
    change_px_s2: f64,
    /// Whether it comes back: a line is drawn one way only.
    comes_back: bool,
}

/// The instants at which a point's place is asked for.
enum Instants {
    /// Middles of the steps of an image in a row.
    Steps(Way),
    /// Ends of the chords of a line.
    Ends(Way),
}

impl Scene {
    /// The star path.
    pub(super) fn star_path(&self) -> PointPath<'_> {
        PointPath { optics: self.optics, motion: &self.settings.motion, earth_path_of: None, share: 1.0 }
    }

    /// The Earth path without its filter; `None` where there is no Earth.
    pub(super) fn clear_earth_path(&self) -> Option<PointPath<'_>> {
        let trajectory = self.settings.motion.trajectory()?;
        let star_share = self.settings.detector.throughput * self.settings.imaging.star_path_transmission;
        let share = trajectory.earth.mirror_transmission * self.settings.imaging.earth_path_transmission;
        let optics = self.optics.earth_path();
        (star_share > 0.0).then_some(PointPath {
            optics,
            earth_path_of: Some(trajectory),
            share: share / star_share,
            ..self.star_path()
        })
    }

    /// Adds the stars that a path shows to `light` and gives those on the detector at mid-exposure. None is
    /// seen through the Earth.
    pub(super) fn place_stars(
        &self,
        path: &PointPath<'_>,
        cycle: u64,
        time_s: f64,
        truth: Option<&Truth>,
        light: &mut PointLight,
    ) -> Vec<VisibleStar> {
        let SceneSettings { motion, imaging, camera, .. } = &self.settings;
        let middle_s = self.middle_s(cycle);
        let pace = path.pace(middle_s, time_s);
        let sight = Sight {
            path,
            middle_s,
            time_s,
            pace,
            boresight: attitude::matrix(path.at(middle_s))[2],
            aberration: motion.aberration(middle_s),
        };
        let (instants, middle) = (self.instants(&sight, pace.smear_px), self.way(&sight, time_s, 1));
        let row_s = imaging.shutter.row_time_s() * f64::from(camera.height_px);
        let margin_px = self.reach_px() + pace.smear_px + path.pace(middle_s, row_s).smear_px;
        let cone_cosine = path.optics.cone_cosine(margin_px);
        let hidden = |direction| truth.is_some_and(|truth| truth.ellipsoid.hides(direction, 0.0));
        self.place_points(&sight, hidden, light);
        let mut visible = Vec::new();
        for number in self.sky.cells.near(sight.boresight, cone_cosine) {
            let (star, e_s) = &self.sky.stars[number as usize];
            if dot(sight.boresight, star.direction) < cone_cosine || hidden(star.direction) {
                continue;
            }
            let seen = plus(star.direction, 1.0, sight.aberration);
            self.lay(&instants, |_| seen, (path, e_s.map(|e| e * time_s)), light);
            let pixel = middle.place(0, seen, &path.optics);
            if let Some([x_px, y_px]) = pixel.filter(|p| path.optics.on_detector(*p)) {
                visible.push((number, VisibleStar { hip: star.hip, x_px, y_px, v: star.v, b_v: star.b_v }));
            }
        }
        visible.sort_unstable_by_key(|(number, _)| *number);
        visible.into_iter().map(|(_, star)| star).collect()
    }

    /// Adds the planets and satellites to `light`.
    fn place_points(&self, sight: &Sight<'_>, hidden: impl Fn(Vector) -> bool, light: &mut PointLight) {
        let SceneSettings { motion, bodies, seed, .. } = &self.settings;
        let Sight { path, middle_s, time_s, .. } = *sight;
        let f = path.optics.focal_length_px();
        for point in bodies.points(*seed, middle_s, motion, &self.optics) {
            let smear_px = sight.pace.smear_px + 1.2 * f * time_s * point.rate_rad_s();
            let near = path.optics.cone_cosine(smear_px + self.reach_px());
            let direction = point.direction(middle_s);
            if dot(sight.boresight, direction) < near || hidden(direction) {
                continue;
            }
            let electrons = star_e_s(&self.settings, point.v, point.b_v).map(|e| e * time_s);
            let seen = |t_s| plus(point.direction(t_s), 1.0, sight.aberration);
            self.lay(&self.instants(sight, smear_px), seen, (path, electrons), light);
        }
    }

    /// How far from a point's place its light may be, px.
    fn reach_px(&self) -> f64 {
        Spots::reach_px(&self.psf) + 1.0
    }

    /// The instants by which a point that moves up to `smear_px` is drawn. The sagitta of a chord is an
    /// eighth of its length times the angle by which the way bends, which is at most that by which the path
    /// turns. Of a part in which the speed changes evenly the middle of the light is off the way's by a
    /// twelfth of the change times the square of the time.
    fn instants(&self, sight: &Sight<'_>, smear_px: f64) -> Instants {
        let even = sight.time_s * (sight.pace.change_px_s2 / (12.0 * SAGITTA_PX)).sqrt();
        if smear_px <= IMAGES_PX || sight.pace.comes_back {
            let steps = (smear_px / self.psf.step_px()).max(even).ceil().clamp(1.0, PARTS_MAX);
            return Instants::Steps(self.way(sight, sight.time_s, steps as u32));
        }
        let straight = (smear_px * sight.pace.turned_rad / (8.0 * SAGITTA_PX)).sqrt();
        let chords = (smear_px / CHORD_PX).max(straight).max(even).ceil().clamp(1.0, PARTS_MAX);
        // Middles of as many steps and one more are the ends of the chords.
        Instants::Ends(self.way(sight, sight.time_s * (chords + 1.0) / chords, chords as u32 + 1))
    }

    /// The attitudes of `steps` equal parts of `time_s`.
    fn way(&self, sight: &Sight<'_>, time_s: f64, steps: u32) -> Way {
        let SceneSettings { imaging, camera, .. } = &self.settings;
        let rate_rad_s = sight.pace.turned_rad / sight.time_s;
        let exposure = (sight.middle_s, time_s);
        Way::new(imaging.shutter, |t| sight.path.at(t), exposure, steps, camera.height_px, rate_rad_s)
    }

    /// Adds a point that gives `electrons` through the star path while it is seen in the direction `seen` of
    /// an instant.
    fn lay(
        &self,
        instants: &Instants,
        seen: impl Fn(f64) -> Vector,
        (path, electrons): (&PointPath<'_>, [f64; BANDS]),
        light: &mut PointLight,
    ) {
        let electrons = electrons.map(|e| e * path.share);
        let places = |way: &Way| -> Vec<_> {
            (0..way.steps()).map(|step| way.place(step, seen(way.step_s(step)), &path.optics)).collect()
        };
        match instants {
            Instants::Steps(way) => {
                let electrons = electrons.map(|e| e / way.steps() as f64);
                let image = |[x_px, y_px]: [f64; 2]| Spot { x_px, y_px, electrons };
                light.spots.extend(places(way).into_iter().flatten().map(image));
            }
            Instants::Ends(way) => {
                let electrons = electrons.map(|e| e / (way.steps() - 1) as f64);
                for part in places(way).split(Option::is_none) {
                    let points: Vec<[f64; 2]> = part.iter().flatten().copied().collect();
                    light.lay_way(&points, electrons, &self.psf);
                }
            }
        }
    }
}

impl PointLight {
    /// Adds a way in chords that give `electrons` each: as lines where their lengths change little and they
    /// are long, else as images.
    fn lay_way(&mut self, points: &[[f64; 2]], electrons: [f64; BANDS], psf: &Psf) {
        let lengths: Vec<f64> = points.windows(2).map(length_px).collect();
        let is_even = |chord: usize| {
            let beside = [chord.saturating_sub(1), (chord + 1).min(lengths.len() - 1)];
            let change_px = beside.map(|other| (lengths[other] - lengths[chord]).abs());
            change_px[0].max(change_px[1]) * psf.rms_px() <= UNEVEN * lengths[chord] * lengths[chord]
        };
        let chords: Vec<(usize, bool)> = (0..lengths.len()).map(|chord| (chord, is_even(chord))).collect();
        for alike in chords.chunk_by(|one, next| one.1 == next.1) {
            let (first, even) = alike[0];
            let run = &points[first..=first + alike.len()];
            if even && length_px(run) > IMAGES_PX {
                self.streaks.push(run.to_vec(), electrons);
            } else {
                self.spots.extend(images(run, electrons, psf.step_px()));
            }
        }
    }
}

/// Images in a row along chords that give `electrons` each, at most `step_px` apart.
fn images(points: &[[f64; 2]], electrons: [f64; BANDS], step_px: f64) -> impl Iterator<Item = Spot> {
    points.windows(2).flat_map(move |ends| {
        let (from, way) = (ends[0], [0, 1].map(|axis| ends[1][axis] - ends[0][axis]));
        let steps = (libm::hypot(way[0], way[1]) / step_px).ceil().max(1.0);
        let electrons = electrons.map(|e| e / steps);
        (0..steps as u32).map(move |step| {
            let part = (f64::from(step) + 0.5) / steps;
            Spot { x_px: from[0] + part * way[0], y_px: from[1] + part * way[1], electrons }
        })
    })
}

#[cfg(test)]
mod tests;
