//! The camera that took a picture: by a camera file, or by a field of view and the picture's own size.

use crate::cli::OpticsArguments;
use crate::error::HostError;
use crate::flight;
use crate::flight::lost_in_space::FocalLength;
use crate::formats::camera_file::CameraFile;
use crate::formats::picture::Picture;
use fsw_core::camera::Camera;
use fsw_hal::{Detector, DetectorGeometry};
use std::path::{Path, PathBuf};

/// What is known of the cameras of pictures.
#[derive(Clone, Debug)]
pub enum PictureCamera {
    /// One camera took all, described in this file.
    File(PathBuf, CameraFile),
    /// Horizontal field of view of undistorted cameras, degrees.
    FieldDeg(f64),
}

impl PictureCamera {
    /// What the command line says, if anything.
    ///
    /// # Errors
    /// When the camera file cannot be read or is wrong.
    pub fn load(arguments: &OpticsArguments) -> Result<Option<Self>, HostError> {
        match &arguments.camera {
            Some(path) => Ok(Some(Self::File(path.clone(), CameraFile::load(path)?))),
            None => Ok(arguments.fov_deg.map(Self::FieldDeg)),
        }
    }

    /// The same for a command that cannot do without.
    ///
    /// # Errors
    /// Also when the command line says nothing.
    pub fn required(arguments: &OpticsArguments) -> Result<Self, HostError> {
        let nothing = || HostError::usage("the optics are not known", "give --camera or --fov-deg");
        Self::load(arguments)?.ok_or_else(nothing)
    }

    /// The camera of a picture; `name` is the picture's.
    ///
    /// # Errors
    /// When file and picture differ in size, or there is no such field.
    pub fn of(&self, name: &Path, picture: &Picture) -> Result<CameraFile, HostError> {
        let DetectorGeometry { width_px, height_px, bits } = picture.geometry();
        match self {
            Self::File(_, file) => check_size(file, name, picture).map(|()| file.clone()),
            Self::FieldDeg(fov_deg) => CameraFile::from_fov(width_px, height_px, bits, *fov_deg),
        }
    }

    /// The same as the flight code takes it, and how well its focal length is known.
    ///
    /// # Errors
    /// Those of [`Self::of`], and what the flight code refuses.
    pub fn flight(&self, name: &Path, picture: &Picture) -> Result<(Camera, FocalLength), HostError> {
        let file = self.of(name, picture)?;
        match self {
            Self::File(path, _) => Ok((flight::camera(&file, path)?, FocalLength::Rough)),
            Self::FieldDeg(_) => Ok((flight::camera(&file, name)?, FocalLength::Within2PercentEitherSense)),
        }
    }
}

/// Whether a picture has the size of a camera.
///
/// # Errors
/// When it has not, with both sizes; `name` is the picture's.
pub fn check_size(camera: &CameraFile, name: &Path, picture: &Picture) -> Result<(), HostError> {
    let DetectorGeometry { width_px, height_px, .. } = picture.geometry();
    let (w, h) = (camera.width_px, camera.height_px);
    if (w, h) == (width_px, height_px) {
        return Ok(());
    }
    let what = format!("the picture has {width_px} x {height_px} px, the camera {w} x {h}");
    Err(HostError::input(name, None, what, "give the camera of this picture"))
}
