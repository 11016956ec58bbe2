//! Where the point sources of a scene are imaged in an exposure.
//!
//! In: a scene, a cycle, its exposure and truth. Out: images ([`Spot`]) of stars, planets and satellites at
//! the places where they are at the times of the steps of their smear, and the stars on the detector at
//! mid-exposure.

use super::{Scene, Truth, VisibleStar, star_e_s};
use crate::world::attitude::{self, Vector, dot};
use crate::world::detector::shutter::Way;
use crate::world::lens::spots::{Spot, Spots};
use crate::world::scene::settings::SceneSettings;
use crate::world::vector::{length, plus};

/// Most images a star is smeared into.
const SMEAR_STEPS_MAX: u32 = 4096;

/// How the star path looks during an exposure.
#[derive(Debug, Clone, Copy)]
struct Sight {
    /// Exposure, s.
    time_s: f64,
    /// Longest way of a star image, px.
    smear_px: f64,
    /// Line of sight at mid-exposure, ICRS.
    boresight: Vector,
    /// `v / c` at mid-exposure.
    aberration: Vector,
}

impl Scene {
    /// Fills `spots` with the smeared stars and gives those on the detector at mid-exposure. None is seen
    /// through the Earth.
    pub(super) fn place_stars(
        &self,
        cycle: u64,
        time_s: f64,
        truth: Option<&Truth>,
        spots: &mut Vec<Spot>,
    ) -> Vec<VisibleStar> {
        let SceneSettings { motion, imaging, camera, .. } = &self.settings;
        let middle_s = self.middle_s(cycle);
        let rate_rad_s = length(motion.rate_rad_s(middle_s));
        let (exposure, rows) = ((middle_s, time_s), camera.height_px);
        let way = |steps| Way::new(imaging.shutter, |t| motion.at(t), exposure, steps, rows, rate_rad_s);
        let smear_px = self.smear_px(middle_s, time_s);
        let steps = (smear_px / self.psf.step_px()).ceil().clamp(1.0, f64::from(SMEAR_STEPS_MAX));
        let (smeared, middle) = (way(steps as u32), way(1));
        let boresight = attitude::matrix(motion.at(middle_s))[2];
        let row_s = imaging.shutter.row_time_s() * f64::from(rows);
        let margin_px = Spots::reach_px(&self.psf) + 1.0 + smear_px + self.smear_px(middle_s, row_s);
        let cone_cosine = self.optics.cone_cosine(margin_px);
        let aberration = motion.aberration(middle_s);
        let hidden = |direction| truth.is_some_and(|truth| truth.ellipsoid.hides(direction, 0.0));
        let sight = Sight { time_s, smear_px, boresight, aberration };
        self.place_points(middle_s, &sight, &way, hidden, spots);
        let mut visible = Vec::new();
        for number in self.sky.cells.near(boresight, cone_cosine) {
            let (star, e_s) = &self.sky.stars[number as usize];
            if dot(boresight, star.direction) < cone_cosine || hidden(star.direction) {
                continue;
            }
            let electrons = e_s.map(|e| e * time_s / steps);
            let seen = plus(star.direction, 1.0, aberration);
            for step in 0..smeared.steps() {
                if let Some([x_px, y_px]) = smeared.place(step, seen, &self.optics) {
                    spots.push(Spot { x_px, y_px, electrons });
                }
            }
            let pixel = middle.place(0, seen, &self.optics);
            if let Some([x_px, y_px]) = pixel.filter(|p| self.optics.on_detector(*p)) {
                visible.push((number, VisibleStar { hip: star.hip, x_px, y_px, v: star.v, b_v: star.b_v }));
            }
        }
        visible.sort_unstable_by_key(|(number, _)| *number);
        visible.into_iter().map(|(_, star)| star).collect()
    }

    /// Adds the planets and satellites to `spots`.
    fn place_points(
        &self,
        middle_s: f64,
        sight: &Sight,
        way: &impl Fn(u32) -> Way,
        hidden: impl Fn(Vector) -> bool,
        spots: &mut Vec<Spot>,
    ) {
        let SceneSettings { motion, bodies, seed, .. } = &self.settings;
        let Sight { time_s, smear_px, boresight, aberration } = *sight;
        let f = self.optics.focal_length_px();
        for point in bodies.points(*seed, middle_s, motion, &self.optics) {
            let smear_px = smear_px + 1.2 * f * time_s * point.rate_rad_s();
            let steps = (smear_px / self.psf.step_px()).ceil().clamp(1.0, f64::from(SMEAR_STEPS_MAX));
            let near = self.optics.cone_cosine(smear_px + Spots::reach_px(&self.psf));
            let direction = point.direction(middle_s);
            if dot(boresight, direction) < near || hidden(direction) {
                continue;
            }
            let electrons = star_e_s(&self.settings, point.v, point.b_v).map(|e| e * time_s / steps);
            let way = way(steps as u32);
            for step in 0..way.steps() {
                let seen = plus(point.direction(way.step_s(step)), 1.0, aberration);
                let pixel = way.place(step, seen, &self.optics);
                spots.extend(pixel.map(|[x_px, y_px]| Spot { x_px, y_px, electrons }));
            }
        }
    }

    /// Longest way of a star image during an exposure, px: turning across the line of sight moves it by f
    /// (1 + tan²), turning about it by its distance from the centre. The fastest of three instants counts.
    fn smear_px(&self, middle_s: f64, time_s: f64) -> f64 {
        let instants = [-0.5, 0.0, 0.5].map(|part| middle_s + part * time_s);
        instants.map(|t_s| self.smear_px_at(t_s, time_s)).into_iter().fold(0.0, f64::max)
    }

    fn smear_px_at(&self, t_s: f64, time_s: f64) -> f64 {
        let [x, y, z] = self.settings.motion.rate_rad_s(t_s);
        let (f, radius) = (self.optics.focal_length_px(), self.optics.radius_px());
        time_s * (libm::hypot(x, y) * f * (1.0 + (radius / f).powi(2)) + z.abs() * radius)
    }
}
