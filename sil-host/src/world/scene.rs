//! A synthetic sky behind the detector trait, and the truth for the judge.
//!
//! In: stars (ICRS unit vectors, V), a camera, a motion, a seed. Out: raw frames, drawn window by window. Every
//! [`Detector::expose`] advances one cycle of [`CYCLE_S`] (the first is cycle 0) and integrates for the exposure time
//! `T` about the instant `t = cycle * 1 s`, over `t ± T/2`; the truth is that of `t`. While the sensor turns, a star is
//! drawn as a row of spots at most half a PSF width apart. A pixel collects
//!
//! `Poisson(stars + dark + hot) + protons + read noise`, in electrons, cut at full well, and becomes
//! `round(electrons / gain + pedestal)`, cut to the detector's bits.
//!
//! The shutter is global. False stars and protons are new in each cycle, hot pixels stay.

use super::attitude::{self, Vector, dot};
use super::disturbances::{Deposits, Disturbances};
use super::earth::image::EarthImage;
pub use super::journey::{SensorState, Truth};
use super::motion::Motion;
use super::noise::{Noise, PoissonTable, Stream};
use super::optics::Optics;
use super::spots::{Spot, Spots};
use super::stars::DetectorModel;
use super::sun;
use super::vector::plus;
use crate::camera_file::CameraFile;
use crate::picture::check_request;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};

/// Length of a cycle, s.
pub const CYCLE_S: f64 = 1.0;
/// Most spots a star is smeared into.
const SMEAR_STEPS_MAX: u32 = 4096;

/// A star of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldStar {
    /// Hipparcos number.
    pub hip: u32,
    /// Unit vector, ICRS, at the scene's epoch.
    pub direction: Vector,
    /// Visual magnitude.
    pub v: f64,
}

/// Everything a scene is made of but its stars.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSettings {
    /// The camera; rectilinear.
    pub camera: CameraFile,
    /// The detector's electrons.
    pub detector: DetectorModel,
    /// Attitude of the star path over time, and the Earth where it is a journey.
    pub motion: Motion,
    /// Seed of all noise.
    pub seed: u64,
    /// Width of the Gaussian PSF, px.
    pub psf_sigma_px: f64,
    /// What is on the detector and is no star.
    pub disturbances: Disturbances,
}

impl SceneSettings {
    /// A quiet scene: the default detector, PSF of 0.9 px, no disturbances.
    pub fn new(camera: CameraFile, motion: Motion, seed: u64) -> Self {
        Self {
            camera,
            detector: DetectorModel::default(),
            motion,
            seed,
            psf_sigma_px: 0.9,
            disturbances: Disturbances::default(),
        }
    }
}

/// Why a scene cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// The camera is not rectilinear.
    #[error("the world draws rectilinear cameras only")]
    Projection,
    /// A value of the detector, the PSF or the disturbances makes no physical sense.
    #[error("a value of the detector model, the PSF width or the disturbances is out of range")]
    Detector,
    /// A value of the Earth model makes no physical sense.
    #[error("a value of the Earth model is out of range")]
    Earth,
    /// The quaternion or the rate is not finite, or the quaternion is zero.
    #[error("the attitude or the rate is no number")]
    Motion,
}

/// A star on the detector: truth for the judge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisibleStar {
    /// Hipparcos number.
    pub hip: u32,
    /// Column of its image at the middle of the exposure, px.
    pub x_px: f64,
    /// Row of its image at the middle of the exposure, px.
    pub y_px: f64,
    /// Visual magnitude.
    pub v: f64,
}

/// What one exposure holds.
#[derive(Debug, Clone)]
struct Exposure {
    cycle: u64,
    time_s: f64,
    /// Mean electrons of a pixel that sees neither star nor Earth: dark current, and the veil of the Sun in a path.
    dark: PoissonTable,
    spots: Spots,
    protons: Deposits,
    visible: Vec<VisibleStar>,
    truth: Option<Truth>,
    earth: Option<EarthImage>,
}

/// A sky, a camera and a motion, with the last exposure.
#[derive(Debug, Clone)]
pub struct Scene {
    settings: SceneSettings,
    optics: Optics,
    stars: Vec<WorldStar>,
    /// Charge in e-/s here, e- once multiplied with the exposure time.
    hot_pixels: Deposits,
    exposure: Option<Exposure>,
    // Kept from call to call so that a small window costs no allocation.
    scratch: Vec<f64>,
}

impl Scene {
    /// A scene before its first exposure.
    ///
    /// # Errors
    /// See [`SceneError`].
    pub fn new(mut settings: SceneSettings, stars: &[WorldStar]) -> Result<Self, SceneError> {
        let optics = Optics::new(&settings.camera).ok_or(SceneError::Projection)?;
        let (low, high) = Spots::SIGMA_PX;
        let width_ok = (low..=high).contains(&settings.psf_sigma_px);
        if !settings.detector.is_sound() || !width_ok || !settings.disturbances.is_sound() {
            return Err(SceneError::Detector);
        }
        if let Motion::Turning(turning) = &mut settings.motion {
            turning.quaternion = attitude::normalised(turning.quaternion).ok_or(SceneError::Motion)?;
            if !turning.rate_rad_s.iter().all(|r| r.is_finite()) {
                return Err(SceneError::Motion);
            }
        }
        if settings.motion.journey().is_some_and(|journey| !journey.earth.is_sound()) {
            return Err(SceneError::Earth);
        }
        let mut scene = Self {
            settings,
            optics,
            stars: stars.to_vec(),
            hot_pixels: Deposits::default(),
            exposure: None,
            scratch: Vec::new(),
        };
        scene.hot_pixels =
            scene.settings.disturbances.hot_pixels(scene.settings.seed, scene.settings.camera.geometry());
        Ok(scene)
    }

    /// What the scene is made of.
    pub fn settings(&self) -> &SceneSettings {
        &self.settings
    }

    /// The truth optics.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// Number of the current cycle; `None` before the first exposure.
    pub fn cycle(&self) -> Option<u64> {
        self.exposure.as_ref().map(|e| e.cycle)
    }

    /// Truth attitude at the middle of the current exposure, ICRS to sensor; at time 0 before the first.
    pub fn quaternion(&self) -> [f64; 4] {
        self.settings.motion.at(self.time_s())
    }

    /// Truth rate in sensor axes at the same time, rad/s.
    pub fn rate_rad_s(&self) -> Vector {
        self.settings.motion.rate_rad_s(self.time_s())
    }

    /// The truth of the middle of the current exposure; journeys only, `None` before the first exposure.
    pub fn truth(&self) -> Option<Truth> {
        self.exposure.as_ref().and_then(|exposure| exposure.truth)
    }

    /// The truth of a cycle, whether it has been exposed or not; journeys only.
    pub fn truth_at(&self, cycle: u64) -> Option<Truth> {
        let journey = self.settings.motion.journey()?;
        Some(journey.truth(cycle as f64 * CYCLE_S, &self.optics))
    }

    /// Time of the middle of the current exposure, s; 0 before the first.
    fn time_s(&self) -> f64 {
        self.cycle().map_or(0.0, |cycle| cycle as f64 * CYCLE_S)
    }

    /// The stars whose image at the middle of the current exposure is centred on the detector, in the order of the
    /// star list; empty before the first exposure.
    pub fn visible_stars(&self) -> &[VisibleStar] {
        self.exposure.as_ref().map_or(&[], |e| &e.visible)
    }

    /// Exposes as if `cycle` had come: any frame of a run can be drawn without those before it.
    ///
    /// # Errors
    /// [`DetectorError::Exposure`] for a time outside the detector model's range.
    pub fn expose_cycle(&mut self, cycle: u64, exposure_us: u32) -> Result<(), DetectorError> {
        let (shortest, longest) = self.settings.detector.exposure_us;
        if !(shortest..=longest).contains(&exposure_us) {
            return Err(DetectorError::Exposure);
        }
        let time_s = f64::from(exposure_us) * 1e-6;
        let mut spots = Vec::new();
        let visible = self.place_stars(cycle, time_s, &mut spots);
        let SceneSettings { disturbances, detector, seed, .. } = &self.settings;
        let geometry = self.settings.camera.geometry();
        let electrons = |v| detector.star_e_s(v) * time_s;
        spots.extend(disturbances.false_stars(*seed, cycle, geometry, electrons));
        let protons = disturbances.protons(*seed, cycle, geometry);
        let spots = Spots::new(self.settings.psf_sigma_px, spots);
        let journey = self.settings.motion.journey();
        let truth = self.truth_at(cycle);
        let earth = journey
            .zip(truth.as_ref())
            .map(|(journey, truth)| journey.earth_image(truth, &self.optics, self.settings.psf_sigma_px));
        let veil_e_s = journey
            .filter(|_| truth.is_some_and(|truth| truth.state.is_blinded()))
            .map_or(0.0, |journey| sun::veil_e_s(&journey.earth, &geometry));
        let even_e_s = self.settings.detector.dark_now_e_s() + veil_e_s;
        let dark = PoissonTable::new(even_e_s * time_s);
        self.exposure = Some(Exposure { cycle, time_s, dark, spots, protons, visible, truth, earth });
        Ok(())
    }

    /// Fills `spots` with the smeared stars and gives those on the detector at mid-exposure.
    fn place_stars(&self, cycle: u64, time_s: f64, spots: &mut Vec<Spot>) -> Vec<VisibleStar> {
        let middle_s = cycle as f64 * CYCLE_S;
        let smear_px = self.smear_px(middle_s, time_s);
        let steps =
            ((2.0 * smear_px / self.settings.psf_sigma_px).ceil()).clamp(1.0, f64::from(SMEAR_STEPS_MAX));
        let attitude_at = |step: u32| {
            let t = middle_s + time_s * ((f64::from(step) + 0.5) / steps - 0.5);
            attitude::matrix(self.settings.motion.at(t))
        };
        let path: Vec<_> = (0..steps as u32).map(attitude_at).collect();
        let middle = attitude::matrix(self.settings.motion.at(middle_s));
        let margin_px = Spots::reach_px(self.settings.psf_sigma_px) as f64 + 1.0;
        let cone_cosine = self.optics.cone_cosine(margin_px + smear_px);
        let aberration = self.settings.motion.aberration(middle_s);
        let mut visible = Vec::new();
        for star in self.stars.iter().filter(|s| dot(middle[2], s.direction) >= cone_cosine) {
            let electrons = self.settings.detector.star_e_s(star.v) * time_s / steps;
            let seen = plus(star.direction, 1.0, aberration);
            for matrix in &path {
                if let Some([x_px, y_px]) = self.optics.project(attitude::apply(matrix, seen)) {
                    spots.push(Spot { x_px, y_px, electrons });
                }
            }
            let pixel = self.optics.project(attitude::apply(&middle, seen));
            if let Some([x_px, y_px]) = pixel.filter(|p| self.optics.on_detector(*p)) {
                visible.push(VisibleStar { hip: star.hip, x_px, y_px, v: star.v });
            }
        }
        visible
    }

    /// Longest way of a star image during an exposure, px: turning across the line of sight moves it by f (1 + tan²),
    /// turning about it by its distance from the centre.
    fn smear_px(&self, middle_s: f64, time_s: f64) -> f64 {
        let [x, y, z] = self.settings.motion.rate_rad_s(middle_s);
        let (f, radius) = (self.optics.focal_length_px(), self.optics.radius_px());
        time_s * (libm::hypot(x, y) * f * (1.0 + (radius / f).powi(2)) + z.abs() * radius)
    }
}

impl Detector for Scene {
    fn geometry(&self) -> DetectorGeometry {
        self.settings.camera.geometry()
    }

    fn expose(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.expose_cycle(self.cycle().map_or(0, |cycle| cycle + 1), exposure_us)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        check_request(&self.geometry(), window, pixels.len())?;
        let exposure = self.exposure.as_ref().ok_or(DetectorError::NotExposed)?;
        if pixels.is_empty() {
            return Ok(());
        }
        let (detector, bits) = (self.settings.detector, self.settings.camera.bits);
        self.scratch.clear();
        self.scratch.resize(pixels.len(), exposure.dark.mean());
        if let Some(earth) = &exposure.earth {
            earth.add_to(window, exposure.time_s, &mut self.scratch);
        }
        exposure.spots.add_to(window, &mut self.scratch);
        self.hot_pixels.add_to(window, exposure.time_s, &mut self.scratch);
        let photon = Noise::new(self.settings.seed, exposure.cycle, Stream::Photon);
        let readout = Noise::new(self.settings.seed, exposure.cycle, Stream::Read);
        let width = usize::from(window.width);
        for (row, line) in self.scratch.chunks_exact_mut(width).enumerate() {
            let y = u32::from(window.y) + row as u32;
            for (x, electrons) in (u32::from(window.x)..).zip(line) {
                let count = if *electrons == exposure.dark.mean() {
                    photon.poisson_of(x, y, &exposure.dark)
                } else {
                    photon.poisson(x, y, *electrons)
                };
                *electrons = count + detector.read_noise_e * readout.gaussian(x, y);
            }
        }
        exposure.protons.add_to(window, 1.0, &mut self.scratch);
        for (pixel, electrons) in pixels.iter_mut().zip(&self.scratch) {
            *pixel = detector.digital_number(*electrons, bits);
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "scene_tests.rs"]
mod tests;
