//! What goes into a scene, what can be wrong with it, and what stars it shows.

use crate::formats::camera_file::CameraFile;
use crate::world::attitude::Vector;
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::imaging::ImagingModel;
use crate::world::motion::Motion;
use crate::world::sky::bodies::BodiesModel;
use crate::world::sky::stars::DetectorModel;

/// A star of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldStar {
    /// Hipparcos number.
    pub hip: u32,
    /// Unit vector, ICRS, at the scene's epoch.
    pub direction: Vector,
    /// Visual magnitude.
    pub v: f64,
    /// Colour index B-V.
    pub b_v: f64,
}

/// Everything a scene is made of but its stars.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSettings {
    /// The camera; rectilinear.
    pub camera: CameraFile,
    /// The detector's electrons.
    pub detector: DetectorModel,
    /// Attitude of the star path over time, and the Earth where it is a trajectory.
    pub motion: Motion,
    /// Seed of all noise.
    pub seed: u64,
    /// Seed of the Earth's clouds and horizon; as a rule the same.
    pub earth_seed: u64,
    /// What the optics do to light.
    pub imaging: ImagingModel,
    /// What is in the sky beside stars and Earth.
    pub bodies: BodiesModel,
    /// What is on the detector and is no star.
    pub disturbances: Disturbances,
}

impl SceneSettings {
    /// A plain scene: stars and Earth alone, pixels that are all alike, a Gaussian PSF of 0.9 px, white
    /// stars, no disturbances.
    pub fn new(camera: CameraFile, motion: Motion, seed: u64) -> Self {
        Self {
            camera,
            detector: DetectorModel::default(),
            motion,
            seed,
            earth_seed: seed,
            imaging: ImagingModel::PLAIN,
            bodies: BodiesModel::NONE,
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
    /// A value of the detector, the imaging or the disturbances makes no physical sense.
    #[error("a value of the detector model, the imaging or the disturbances is out of range")]
    Detector,
    /// The lens cannot be made for the camera.
    #[error("the lens cannot be scaled to this focal length, pixel pitch, aperture and defocus")]
    Lens,
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
    /// Column of its image at the middle of its row's exposure, px.
    pub x_px: f64,
    /// Row of its image at the middle of its row's exposure, px.
    pub y_px: f64,
    /// Visual magnitude.
    pub v: f64,
    /// Colour index B-V.
    pub b_v: f64,
}
