//! What a caller says of the optics.

use crate::arrays::{fault, refused};
use pyo3::prelude::*;
use sil_host::cli::OpticsArguments;
use sil_host::commands::picture_camera::PictureCamera;
use std::path::PathBuf;

fn arguments(fov_deg: Option<f64>, camera: Option<PathBuf>) -> PyResult<OpticsArguments> {
    if fov_deg.is_some() && camera.is_some() {
        return Err(refused("the optics are given twice; give camera or fov_deg"));
    }
    Ok(OpticsArguments { camera, fov_deg })
}

/// The camera, if anything is known.
pub(crate) fn known(fov_deg: Option<f64>, camera: Option<PathBuf>) -> PyResult<Option<PictureCamera>> {
    PictureCamera::load(&arguments(fov_deg, camera)?).map_err(|error| fault(&error))
}

/// The camera.
pub(crate) fn required(fov_deg: Option<f64>, camera: Option<PathBuf>) -> PyResult<PictureCamera> {
    PictureCamera::required(&arguments(fov_deg, camera)?).map_err(|error| fault(&error))
}
