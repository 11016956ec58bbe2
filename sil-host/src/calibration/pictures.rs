//! Pictures of the sky from which a camera is calibrated, as a laboratory takes them at night.
//!
//! In: a camera, what its optics do to light, its detector. Out: pictures of the whole detector with the
//! attitude each was taken in. The camera rests in each, on a mount that follows the sky, in attitudes drawn
//! evenly from all; stars are exposed for [`EXPOSURE_US`]; the mean of `DARKS` pictures with a closed lens
//! is taken off, `PEDESTAL` is left as the value of an empty pixel, 16 bits hold the fraction that the mean
//! has. The lens is cooler than in flight, see [`cooler`].

use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::formats::picture::Picture;
use crate::world::attitude::{Vector, matrix, uniform};
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::imaging::ImagingModel;
use crate::world::detector::protons::Protons;
use crate::world::lens::psf::{LensModel, PsfModel};
use crate::world::motion::Motion;
use crate::world::noise::{Noise, Stream};
use crate::world::scene::{Scene, SceneSettings, WorldStar};
use crate::world::sky::stars::DetectorModel;
use fsw_hal::{Detector, DetectorGeometry};

/// Seed of attitudes, noise and pixel pattern.
pub const SEED: u64 = 1;
/// Exposure, µs: the longest of the detector; faint stars are many.
pub const EXPOSURE_US: u32 = 2_000_000;
/// Bits of the pictures' values.
pub const BITS: u8 = 16;
/// Pictures of darkness whose mean is taken off.
const DARKS: u64 = 16;
/// Value of an empty pixel, of 2^16.
const PEDESTAL: f64 = 2048.0;
/// By how much the lens is warmer in flight than in the laboratory, K.
pub const WARMER_K: f64 = 5.0;
/// Electrons a digital number as a laboratory finds them, over the true ones: a photon transfer curve.
pub const GAIN_FOUND: f64 = 1.03;
/// Growth of the focal length a kelvin: a lens that is compensated to less than half of its aluminium
/// barrel's 23e-6.
pub const FOCAL_LENGTH_PER_K: f64 = 10e-6;

/// The camera and its optics as many kelvins cooler: focal length and best focus go with the barrel.
pub fn cooler(camera: &CameraFile, imaging: &ImagingModel, kelvins: f64) -> (CameraFile, ImagingModel) {
    let share = FOCAL_LENGTH_PER_K * kelvins;
    let focal_length_px = camera.focal_length_px * (1.0 - share);
    let moved_mm = share * camera.focal_length_px * 1e-3 * imaging.pixel_pitch_um;
    let psf = match imaging.psf {
        PsfModel::Lens(lens) => PsfModel::Lens(LensModel { defocus_mm: lens.defocus_mm - moved_mm, ..lens }),
        round @ PsfModel::Gaussian { .. } => round,
    };
    (CameraFile { focal_length_px, ..camera.clone() }, ImagingModel { psf, ..*imaging })
}

/// A picture, and ICRS to sensor while it was taken.
#[derive(Debug, Clone)]
pub struct SkyPicture {
    /// The picture.
    pub picture: Picture,
    /// The attitude.
    pub attitude: [Vector; 3],
}

/// A camera under the sky.
#[derive(Debug, Clone)]
pub struct Laboratory {
    sky: Scene,
    /// Mean of the dark pictures, digital numbers.
    dark: Vec<f64>,
    seed: u64,
}

impl Laboratory {
    /// With a camera of this detector, before this sky; `seed` is that of attitudes, noise and pattern.
    ///
    /// # Errors
    /// When the world cannot draw the camera.
    pub fn new(
        (camera, imaging): (&CameraFile, &ImagingModel),
        detector: &DetectorModel,
        stars: &[WorldStar],
        seed: u64,
    ) -> Result<Self, HostError> {
        let mut settings = SceneSettings::new(camera.clone(), Motion::fixed([0.0, 0.0, 0.0, 1.0]), seed);
        settings.imaging = *imaging;
        settings.detector = *detector;
        settings.disturbances = Disturbances { protons: Protons::Fixed(0), ..Disturbances::default() };
        let scene = |stars: &[WorldStar]| {
            Scene::new(settings.clone(), stars)
                .map_err(|error| HostError::usage(error.to_string(), "give another camera"))
        };
        let mut closed = scene(&[])?;
        let mut dark = vec![0.0; camera.geometry().whole().area()];
        for cycle in 0..DARKS {
            for (mean, value) in dark.iter_mut().zip(exposed(&mut closed, cycle)?) {
                *mean += f64::from(value) / DARKS as f64;
            }
        }
        Ok(Self { sky: scene(stars)?, dark, seed })
    }

    /// Picture number `index`.
    ///
    /// # Errors
    /// Never for a detector that exposes so long.
    pub fn picture(&mut self, index: u32) -> Result<SkyPicture, HostError> {
        let quaternion = uniform(&Noise::new(self.seed, 0, Stream::Attitude), index);
        self.sky.rest_in(quaternion);
        // The darks were the first seconds.
        let raw = exposed(&mut self.sky, DARKS + u64::from(index))?;
        let DetectorGeometry { width_px, height_px, bits } = self.sky.geometry();
        let scale = f64::from(1u32 << (BITS - bits.min(BITS)));
        let corrected = |(value, dark): (u16, &f64)| {
            ((f64::from(value) - dark) * scale + PEDESTAL).round().clamp(0.0, 65_535.0) as u16
        };
        let pixels = raw.into_iter().zip(&self.dark).map(corrected).collect();
        let geometry = DetectorGeometry { width_px, height_px, bits: BITS };
        let misfit = || HostError::usage("a picture of another size", "report this");
        let picture = Picture::from_pixels(geometry, pixels).ok_or_else(misfit)?;
        Ok(SkyPicture { picture, attitude: matrix(quaternion) })
    }
}

/// The whole detector in an exposure.
fn exposed(scene: &mut Scene, cycle: u64) -> Result<Vec<u16>, HostError> {
    let fault = |error| HostError::usage(format!("the detector refuses ({error:?})"), "report this");
    scene.expose_cycle(cycle, EXPOSURE_US).map_err(fault)?;
    let whole = scene.geometry().whole();
    let mut pixels = vec![0; whole.area()];
    scene.read(whole, &mut pixels).map_err(fault)?;
    Ok(pixels)
}
