//! What adds to the pixels of an exposure: one trait, one list.
//!
//! In: a scene and a moment. Out: [`Effect`]s, which add mean electrons to any window at one of three
//! [`Stage`]s. A new effect is a type with [`Effect::add_to`] and a line in [`EFFECTS`]. Light of stars,
//! planets and satellites comes last among the light; it is placed with the truth of what is visible.

use super::{Deposits, Exposing, Look, Scene, SensorState, Truth};
use crate::world::earth::image::{CellBuffer, EarthImage};
use crate::world::lens::spots::Spots;
use crate::world::lens::streaks::Streaks;
use crate::world::sky::bodies::BodyLight;
use crate::world::sky::sun;
use fsw_hal::Window;
use std::fmt::Debug;
use std::sync::Arc;

/// What adds mean electrons to the pixels of a window, row by row: a pure function of their places.
pub trait Effect: Debug + Send + Sync {
    /// Adds them; `buffer` is room for what draws cell by cell.
    fn add_to(&self, window: Window, electrons: &mut [f64], buffer: &mut CellBuffer);
}

/// When an effect adds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Light through the lens, which the vignetting dims.
    Light = 0,
    /// Light that no vignetting dims.
    Stray = 1,
    /// Charge without light: no gain of a pixel counts.
    Charge = 2,
}

/// An exposure that is to be made.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Its cycle.
    pub cycle: u64,
    /// Its length, s.
    pub time_s: f64,
    /// Its truth; trajectories only.
    pub truth: Option<&'a Truth>,
}

/// Makes the effect of an exposure, where there is any.
pub type Maker = fn(&Scene, &Moment<'_>) -> Vec<Arc<dyn Effect>>;

/// All effects, in the order in which they add.
pub const EFFECTS: [(Stage, Maker); 4] =
    [(Stage::Light, earths), (Stage::Light, bodies), (Stage::Stray, veil), (Stage::Charge, hot_pixels)];

/// The Earth in either path.
fn earths(scene: &Scene, moment: &Moment<'_>) -> Vec<Arc<dyn Effect>> {
    let Some((trajectory, truth)) = scene.settings.motion.trajectory().zip(moment.truth) else {
        return Vec::new();
    };
    let imaging = &scene.settings.imaging;
    let [star_path, earth_path] = scene.transmissions();
    let look = Look {
        seed: scene.settings.earth_seed,
        psf_sigma_px: scene.psf.rms_px(),
        exposure_s: moment.time_s,
        row_time_s: imaging.shutter.row_time_s(),
        transmission: earth_path,
    };
    let throughput = scene.settings.detector.throughput * star_path;
    let in_star_path = Look { transmission: throughput, ..look };
    let mut earths: Vec<Arc<dyn Effect>> =
        vec![Arc::new(trajectory.earth_image(truth, &scene.optics, &look))];
    if let Some(image) = trajectory.earth_in_star_path(truth, &scene.optics, &in_star_path) {
        earths.push(Arc::new(image));
    }
    earths
}

/// Moon and Sun in either path.
fn bodies(scene: &Scene, moment: &Moment<'_>) -> Vec<Arc<dyn Effect>> {
    let Some((trajectory, truth)) = scene.settings.motion.trajectory().zip(moment.truth) else {
        return Vec::new();
    };
    let [star_path, earth_path] = scene.transmissions();
    let filter = trajectory.earth.mirror_transmission * trajectory.earth.filter_transmission;
    let exposing = Exposing {
        t_s: (truth.instant_us - trajectory.orbit.start_us()) as f64 * 1e-6,
        time_s: moment.time_s,
        psf_sigma_px: scene.psf.rms_px(),
        transmissions: [scene.settings.detector.throughput * star_path, filter * earth_path],
    };
    let light = BodyLight::new(&scene.settings.bodies, trajectory, truth, &scene.optics, &exposing);
    vec![Arc::new(Timed { of: light, time_s: moment.time_s })]
}

/// The even veil of a Sun in a path.
fn veil(scene: &Scene, moment: &Moment<'_>) -> Vec<Arc<dyn Effect>> {
    let blinded = moment.truth.filter(|truth| truth.state.is_blinded());
    let Some((trajectory, truth)) = scene.settings.motion.trajectory().zip(blinded) else {
        return Vec::new();
    };
    let [star_path, earth_path] = scene.transmissions();
    let transmission = match truth.state {
        SensorState::SunInEarthPath => earth_path,
        _ => star_path,
    };
    let veil_e_s = transmission * sun::veil_e_s(&trajectory.earth, &scene.settings.camera.geometry());
    vec![Arc::new(Even { electrons: veil_e_s * moment.time_s })]
}

/// Pixels with a high dark current.
fn hot_pixels(scene: &Scene, moment: &Moment<'_>) -> Vec<Arc<dyn Effect>> {
    vec![Arc::new(Timed { of: scene.hot_pixels.clone(), time_s: moment.time_s })]
}

/// What adds so much a second.
#[derive(Debug)]
struct Timed<T> {
    of: T,
    time_s: f64,
}

/// The same in every pixel.
#[derive(Debug)]
struct Even {
    electrons: f64,
}

impl Effect for EarthImage {
    fn add_to(&self, window: Window, electrons: &mut [f64], buffer: &mut CellBuffer) {
        self.add_to(window, electrons, buffer);
    }
}

impl Effect for Spots {
    fn add_to(&self, window: Window, electrons: &mut [f64], _: &mut CellBuffer) {
        self.add_to(window, electrons);
    }
}

impl Effect for Streaks {
    fn add_to(&self, window: Window, electrons: &mut [f64], _: &mut CellBuffer) {
        self.add_to(window, electrons);
    }
}

impl Effect for Timed<BodyLight> {
    fn add_to(&self, window: Window, electrons: &mut [f64], _: &mut CellBuffer) {
        self.of.add_to(window, self.time_s, electrons);
    }
}

impl Effect for Timed<Arc<Deposits>> {
    fn add_to(&self, window: Window, electrons: &mut [f64], _: &mut CellBuffer) {
        self.of.add_to(window, self.time_s, electrons);
    }
}

impl Effect for Even {
    fn add_to(&self, _: Window, electrons: &mut [f64], _: &mut CellBuffer) {
        electrons.iter_mut().for_each(|pixel| *pixel += self.electrons);
    }
}
