//! A synthetic sky behind the detector trait, and the truth for the judge.
//!
//! In: stars (ICRS unit vectors, V), a camera, a motion, a seed. Out: raw frames, drawn window by window.
//! Every [`Detector::expose`] advances one cycle of [`CYCLE_S`] (the first is cycle 0) and integrates for the
//! exposure time `T` about the instant `t = cycle * 1 s`, over `t ± T/2`; the truth is that of `t`. What adds
//! light or charge is an [`effects::Effect`]. Light becomes a number in this order:
//!
//! 1. light: the Earth, Moon and Sun, stars and false stars; times the vignetting; the even veil of a Sun in
//!    the field
//! 2. charge: light times the pixel's gain, dark current, hot pixels, all of them means
//! 3. `Poisson(charge) + read noise`
//! 4. protons; offsets of column and row
//! 5. cut at full well, `round(electrons / gain + pedestal)`, cut to the detector's bits; dead pixels read
//!    0 or full scale
//!
//! With a rolling shutter a star is where it is at the time of its own row, see
//! [`crate::world::detector::shutter`]; the Earth is drawn as of the middle of the exposure. False stars and
//! protons are new in each cycle; hot and dead pixels and patterns stay.

use super::earth::image::CellBuffer;
use super::motion::Motion;
use super::noise::{Noise, Stream};
use crate::formats::picture::check_request;
use crate::world::attitude::{self, Vector};
use crate::world::detector::deposits::Deposits;
use crate::world::detector::fixed_pattern::{Darks, FixedPattern};
use crate::world::detector::protons;
use crate::world::lens::optics::Optics;
use crate::world::lens::psf::Psf;
use crate::world::lens::spots::{Brush, Spot, Spots};
use crate::world::lens::streaks::Streaks;
use crate::world::lens::vignetting::Vignetting;
use crate::world::motion::trajectory::Look;
pub use crate::world::motion::trajectory::{SensorState, Truth};
pub use crate::world::scene::settings::{SceneError, SceneSettings, VisibleStar, WorldStar};
use crate::world::sky::bodies::Exposing;
use crate::world::sky::cells::Cells;
use crate::world::sky::colour::{self, BANDS};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, LocalTime, OpenPaths, Window};
use std::sync::{Arc, Mutex, PoisonError};

pub mod effects;
mod kept;
mod placing;
mod settings;

use effects::{EFFECTS, Effect, Maker, Moment, Stage};
use kept::Kept;
use placing::PointLight;

/// Length of a cycle, s.
pub const CYCLE_S: f64 = 1.0;
/// Pixels of a window that are drawn together.
const BAND_PX: usize = 8192;

/// What one exposure holds.
#[derive(Debug, Clone)]
struct Exposure {
    cycle: u64,
    /// By how much its middle was late, s.
    late_s: f64,
    time_s: f64,
    /// Mean electrons of the dark current.
    darks: Darks,
    /// What adds to the pixels, by stage.
    effects: [Vec<Arc<dyn Effect>>; 3],
    protons: Deposits,
    visible: Vec<VisibleStar>,
    truth: Option<Truth>,
}

/// The stars, by where they are, with their electrons a second in each part of the band.
#[derive(Debug)]
struct Sky {
    stars: Vec<(WorldStar, [f64; BANDS])>,
    cells: Cells,
}

/// A sky, a camera and a motion, with the last exposure.
#[derive(Debug, Clone)]
pub struct Scene {
    settings: SceneSettings,
    optics: Optics,
    psf: Arc<Psf>,
    vignetting: Vignetting,
    sky: Arc<Sky>,
    pattern: Arc<FixedPattern>,
    /// Charge in e-/s here, e- once multiplied with the exposure time.
    hot_pixels: Arc<Deposits>,
    /// Place, and whether full scale is read; sorted by row.
    dead_pixels: Vec<(u16, u16, bool)>,
    effects: Vec<(Stage, Maker)>,
    exposure: Option<Exposure>,
    /// By how much the seconds are late, s.
    late_s: f64,
    /// Protons that hit in an exposure beside those of the settings.
    storm_hits: u32,
    /// The paths whose shutters are open.
    open: OpenPaths,
    /// The truth that was asked for last, by its time: world, flight and judge ask for the same.
    last_truth: Arc<Mutex<Option<(f64, Truth)>>>,
    /// What of the exposure is drawn.
    kept: Kept,
    // From call to call, so that a small window costs no allocation.
    scratch: Option<Box<Scratch>>,
}

/// Room for a window.
#[derive(Debug, Clone)]
struct Scratch {
    electrons: Vec<f64>,
    cell_buffer: CellBuffer,
}

impl Scratch {
    fn new() -> Box<Self> {
        Box::new(Self { electrons: Vec::new(), cell_buffer: CellBuffer::EMPTY })
    }
}

impl Scene {
    /// A scene before its first exposure.
    ///
    /// # Errors
    /// See [`SceneError`].
    pub fn new(mut settings: SceneSettings, stars: &[WorldStar]) -> Result<Self, SceneError> {
        let optics = Optics::new(&settings.camera).ok_or(SceneError::Projection)?;
        let SceneSettings { detector, imaging, bodies, disturbances, .. } = &settings;
        if !detector.is_sound() || !imaging.is_sound() || !bodies.is_sound() || !disturbances.is_sound() {
            return Err(SceneError::Detector);
        }
        if let Motion::Turning(turning) = &mut settings.motion {
            turning.quaternion = attitude::normalised(turning.quaternion).ok_or(SceneError::Motion)?;
            if !turning.rate_rad_s.iter().all(|r| r.is_finite()) {
                return Err(SceneError::Motion);
            }
        }
        if settings.motion.trajectory().is_some_and(|trajectory| !trajectory.earth.is_sound()) {
            return Err(SceneError::Earth);
        }
        let psf = settings.imaging.psf(&optics).ok_or(SceneError::Lens)?;
        let (seed, geometry) = (settings.seed, settings.camera.geometry());
        let lit: Vec<_> = stars.iter().map(|star| (*star, star_e_s(&settings, star.v, star.b_v))).collect();
        let cells = Cells::new(stars.iter().map(|star| star.direction));
        Ok(Self {
            vignetting: Vignetting::new(&settings.imaging.vignetting, &optics),
            pattern: FixedPattern::shared(&settings.detector.pattern, seed, geometry),
            hot_pixels: Arc::new(settings.disturbances.hot_pixels(seed, geometry)),
            effects: EFFECTS.to_vec(),
            dead_pixels: settings.disturbances.dead_pixels(seed, geometry),
            psf,
            sky: Arc::new(Sky { stars: lit, cells }),
            settings,
            optics,
            exposure: None,
            late_s: 0.0,
            storm_hits: 0,
            open: OpenPaths::Both,
            last_truth: Arc::default(),
            kept: Kept::default(),
            scratch: None,
        })
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

    /// The truth of the middle of the current exposure; trajectories only, `None` before the first exposure.
    pub fn truth(&self) -> Option<Truth> {
        self.exposure.as_ref().and_then(|exposure| exposure.truth)
    }

    /// The truth of a cycle, whether it has been exposed or not; trajectories only.
    pub fn truth_at(&self, cycle: u64) -> Option<Truth> {
        let trajectory = self.settings.motion.trajectory()?;
        let middle_s = self.middle_s(cycle);
        let mut last = self.last_truth.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, truth)) = last.filter(|(t_s, _)| *t_s == middle_s) {
            return Some(truth);
        }
        let truth = trajectory.truth(middle_s, &self.optics);
        *last = Some((middle_s, truth));
        Some(truth)
    }

    /// As [`Self::truth_at`], with attitude and rate as the last exposure saw them if it was that cycle's: their
    /// means over it.
    pub fn seen_at(&self, cycle: u64) -> Option<Truth> {
        let mut truth = self.truth_at(cycle)?;
        let trajectory = self.settings.motion.trajectory()?;
        if let Some(exposure) = self.exposure.as_ref().filter(|exposure| exposure.cycle == cycle) {
            let seen = trajectory.mean_over(self.middle_s(cycle), exposure.time_s);
            (truth.quaternion, truth.rate_rad_s) = seen.unwrap_or((truth.quaternion, truth.rate_rad_s));
        }
        Some(truth)
    }

    /// Adds an effect to those of the world, after them.
    pub fn add_effect(&mut self, stage: Stage, make: Maker) {
        self.effects.push((stage, make));
    }

    /// From now on the middle of a cycle's exposure is so much later, s.
    pub fn delay(&mut self, late_s: f64) {
        self.late_s = late_s;
    }

    /// From now on so many more protons hit in every exposure.
    pub fn storm(&mut self, hits: u32) {
        self.storm_hits = hits;
    }

    /// From now on these paths are open in every exposure, and the other one shut.
    pub fn open(&mut self, paths: OpenPaths) {
        self.open = paths;
    }

    /// Share of the light that filters and shutters of star path and Earth path let through; that of the
    /// Earth path over what its filter lets through.
    fn transmissions(&self) -> [f64; 2] {
        let imaging = &self.settings.imaging;
        let filter = || self.settings.motion.trajectory().map_or(1.0, |path| path.earth.filter_transmission);
        let earth_path = match self.open {
            OpenPaths::Star => 0.0,
            OpenPaths::Both | OpenPaths::Earth => imaging.earth_path_transmission,
            OpenPaths::BothClear => imaging.earth_path_transmission / filter(),
        };
        [if self.open.star() { imaging.star_path_transmission } else { 0.0 }, earth_path]
    }

    /// From now on the star path rests in this attitude, ICRS to sensor, and there is no Earth.
    pub fn rest_in(&mut self, quaternion: [f64; 4]) {
        self.settings.motion = Motion::fixed(quaternion);
    }

    /// Time of the middle of a cycle's exposure, s: of the last one, if that was this cycle's, or of one to come.
    fn middle_s(&self, cycle: u64) -> f64 {
        let exposed = self.exposure.as_ref().filter(|exposure| exposure.cycle == cycle);
        cycle as f64 * CYCLE_S + exposed.map_or(self.late_s, |exposure| exposure.late_s)
    }

    /// By how much the middle of the last exposure was earlier than that of a cycle's, s; `None` before the first.
    pub fn ago_s(&self, cycle: u64) -> Option<f64> {
        self.exposure.as_ref().map(|_| self.middle_s(cycle) - self.time_s())
    }

    /// Time of the middle of the current exposure, s; 0 before the first.
    fn time_s(&self) -> f64 {
        self.cycle().map_or(0.0, |cycle| self.middle_s(cycle))
    }

    /// The stars whose image at the middle of the current exposure is centred on the detector, in the order
    /// of the star list; empty before the first exposure.
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
        let SceneSettings { disturbances, detector, imaging, seed, .. } = &self.settings;
        let truth = self.truth_at(cycle);
        let streaks = Streaks::new(self.psf.clone(), detector.response);
        let mut light = PointLight { spots: Vec::new(), streaks };
        let open = self.open.star();
        let mut visible = Vec::new();
        if open {
            visible = self.place_stars(&self.star_path(), cycle, time_s, truth.as_ref(), &mut light);
        }
        if self.open.clear()
            && let Some(path) = self.clear_earth_path()
        {
            self.place_stars(&path, cycle, time_s, truth.as_ref(), &mut light);
        }
        let PointLight { mut spots, streaks } = light;
        let (run, geometry) = ((*seed, cycle), self.settings.camera.geometry());
        let electrons = |v| star_e_s(&self.settings, v, 0.0).map(|e| e * time_s);
        spots
            .extend(disturbances.false_stars(*seed, cycle, geometry, electrons).into_iter().filter(|_| open));
        let spots = Spots::new(self.psf.clone(), detector.response, spots);
        let pitch_um = imaging.pixel_pitch_um;
        let hits = disturbances.protons.hits(run, truth.as_ref(), geometry, pitch_um, time_s);
        let hits = hits.saturating_add(self.storm_hits);
        let moment = Moment { cycle, time_s, truth: truth.as_ref() };
        let mut effects: [Vec<Arc<dyn Effect>>; 3] = Default::default();
        for (stage, make) in &self.effects {
            effects[*stage as usize].extend(make(self, &moment));
        }
        effects[Stage::Light as usize].extend([Arc::new(spots) as Arc<dyn Effect>, Arc::new(streaks)]);
        self.kept.clear();
        self.exposure = Some(Exposure {
            cycle,
            late_s: self.late_s,
            time_s,
            darks: self.pattern.darks(detector.dark_now_e_s() * time_s),
            effects,
            protons: protons::tracks(run, hits, geometry, pitch_um),
            visible,
            truth,
        });
        Ok(())
    }

    /// Adds the mean electrons that the pixels of `window` have before the readout, row by row.
    fn add_charge(
        &self,
        exposure: &Exposure,
        window: Window,
        electrons: &mut [f64],
        buffer: &mut CellBuffer,
    ) {
        let [light, stray, charge] = &exposure.effects;
        let mut add = |effects: &[Arc<dyn Effect>], electrons: &mut [f64]| {
            effects.iter().for_each(|effect| effect.add_to(window, electrons, buffer));
        };
        add(light, electrons);
        self.vignetting.dim(window, electrons);
        add(stray, electrons);
        self.pattern.charge(window, &exposure.darks, electrons);
        add(charge, electrons);
    }

    /// Mean electrons that a star of this kind at `pixel` gives in `exposure_s` in the pixels of `window`, if
    /// it stands still: what a bound needs to know.
    pub fn star_image(
        &self,
        star: &VisibleStar,
        pixel: [f64; 2],
        exposure_s: f64,
        window: Window,
    ) -> Vec<f64> {
        let electrons = star_e_s(&self.settings, star.v, star.b_v).map(|e| e * exposure_s);
        let spot = Spot { x_px: pixel[0], y_px: pixel[1], electrons };
        let mut light = vec![0.0; window.area()];
        Brush::default().draw(&self.psf, self.settings.detector.response, &spot, window, &mut light);
        self.vignetting.dim(window, &mut light);
        light
    }

    /// How far from its place a star has light, px.
    pub fn star_reach_px(&self) -> f64 {
        Spots::reach_px(&self.psf)
    }

    /// Draws the `numbers` of `window`; `scratch` is room for them.
    fn read_band(&self, exposure: &Exposure, window: Window, scratch: &mut Scratch, numbers: &mut [u16]) {
        let Scratch { electrons, cell_buffer } = scratch;
        electrons.clear();
        electrons.resize(numbers.len(), 0.0);
        self.add_charge(exposure, window, electrons, cell_buffer);
        let SceneSettings { detector, camera, seed, .. } = &self.settings;
        let [photon, readout] =
            [Stream::Photon, Stream::Read].map(|stream| Noise::new(*seed, exposure.cycle, stream));
        let width = usize::from(window.width);
        for (y, line) in (window.y..).zip(electrons.chunks_exact_mut(width)) {
            let first = (u32::from(window.x), u32::from(y));
            photon.read_row(first, line, &readout, detector.read_noise_e);
        }
        exposure.protons.add_to(window, 1.0, electrons);
        let converter = detector.converter(camera.bits);
        let lines = electrons.chunks_exact(width).zip(numbers.chunks_exact_mut(width));
        let (rows_e, columns_e) =
            (self.pattern.rows_e(exposure.cycle), &self.pattern.columns_e()[usize::from(window.x)..]);
        for (y, (line, numbers)) in (window.y..).zip(lines) {
            let row_e = rows_e(y);
            for ((electrons, column_e), number) in line.iter().zip(columns_e).zip(numbers) {
                *number = converter.digital_number(*electrons + (row_e + column_e));
            }
        }
        self.set_dead_pixels(window, numbers);
    }

    /// Sets the dead pixels of a window to 0 or full scale.
    fn set_dead_pixels(&self, window: Window, pixels: &mut [u16]) {
        let full_scale = ((1u32 << self.settings.camera.bits.min(16)) - 1) as u16;
        let first = self.dead_pixels.partition_point(|(_, y, _)| *y < window.y);
        for (x, y, high) in self.dead_pixels[first..].iter().take_while(|d| d.1 - window.y < window.height) {
            if *x >= window.x && x - window.x < window.width {
                let place = usize::from(y - window.y) * usize::from(window.width) + usize::from(x - window.x);
                pixels[place] = if *high { full_scale } else { 0 };
            }
        }
    }
}

/// Electrons a second of a star in each part of the band.
fn star_e_s(settings: &SceneSettings, v: f64, b_v: f64) -> [f64; BANDS] {
    let colour = if settings.imaging.star_colours { b_v } else { 0.0 };
    let white = settings.detector.star_e_s(v) * settings.imaging.star_path_transmission;
    colour::shares(colour).map(|share| share * white)
}

impl fsw_hal::ErrorType for Scene {
    type Error = DetectorError;
}

impl Detector for Scene {
    fn geometry(&self) -> DetectorGeometry {
        self.settings.camera.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.expose_cycle(self.cycle().map_or(0, |cycle| cycle + 1), exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        let exposure = self.exposure.as_ref().ok_or(DetectorError::NotExposed)?;
        Ok(LocalTime::from_us((exposure.cycle as i64).saturating_mul((CYCLE_S * 1e6) as i64)))
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        check_request(&self.geometry(), window, pixels.len())?;
        let exposure = self.exposure.as_ref().ok_or(DetectorError::NotExposed)?;
        if pixels.is_empty() {
            return Ok(());
        }
        let mut kept = std::mem::take(&mut self.kept);
        if Kept::is_large(window) {
            kept.draw(self.geometry(), window, Scratch::new, |scratch, window, numbers| {
                self.read_band(exposure, window, scratch, numbers);
            });
        }
        let copied = kept.copy(window, pixels);
        self.kept = kept;
        if copied {
            return Ok(());
        }
        let mut scratch = self.scratch.take().unwrap_or_else(Scratch::new);
        // A band of the window is a window, and stays near the processor.
        let rows = (BAND_PX / usize::from(window.width)).max(1);
        let bands = pixels.chunks_mut(rows * usize::from(window.width));
        for (y, numbers) in (window.y..).step_by(rows).zip(bands) {
            let height = (numbers.len() / usize::from(window.width)) as u16;
            self.read_band(exposure, Window { y, height, ..window }, &mut scratch, numbers);
        }
        self.scratch = Some(scratch);
        Ok(())
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod statistics_tests;
