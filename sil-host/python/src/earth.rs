//! `earth`: direction and distance of the Earth from a picture of it.

use crate::arrays::{Numbers, Row, Rows, fault, picture, refused, row, rows, three};
use crate::optics;
use fsw_core::frames::{Direction, EarthPath};
use numpy::PyArray1;
use pyo3::prelude::*;
use sil_host::commands::earth::{EarthAnswer, Known, PictureEarth};
use std::path::{Path, PathBuf};

/// What a picture of the Earth tells; without an Earth all but reason and limb_px is None.
#[pyclass(frozen, get_all, module = "sextant")]
pub(crate) struct Earth {
    /// Whether the Earth was found.
    found: bool,
    /// Why not, where not.
    reason: Option<String>,
    /// (3,) float64: unit vector to the Earth's centre, sensor frame.
    direction: Option<Row>,
    /// Standard deviation of the direction, the greater of the two across it, deg.
    sigma_deg: Option<f64>,
    /// Distance of the Earth's centre, km.
    distance_km: Option<f64>,
    /// Standard deviation of the distance, km.
    sigma_distance_km: Option<f64>,
    /// (2,) float64: image of the centre, x and y, px; None also where it lies behind the camera.
    centre_px: Option<Row>,
    /// Mean distance of the limb from it, px.
    radius_px: Option<f64>,
    /// (n, 2) float64: limb points measured, x and y, px.
    limb_px: Rows,
    /// (n,) bool: whether the centre rests on them.
    inliers: Py<PyArray1<bool>>,
}

impl Earth {
    fn new(py: Python<'_>, answer: &EarthAnswer) -> PyResult<Self> {
        let inliers = answer.limb.iter().map(|point| point.inlier);
        Ok(Self {
            found: answer.direction.is_some(),
            reason: answer.reason.map(str::to_owned),
            direction: answer.direction.map(|direction| row(py, &direction)),
            sigma_deg: answer.sigma_deg.map(f64::from),
            distance_km: answer.distance_km.map(f64::from),
            sigma_distance_km: answer.sigma_distance_km.map(f64::from),
            centre_px: answer.centre_px.map(|centre| row(py, &centre)),
            radius_px: answer.radius_px.map(f64::from),
            limb_px: rows(py, answer.limb.iter().map(|point| [point.x, point.y]))?,
            inliers: PyArray1::from_vec(py, inliers.collect()).unbind(),
        })
    }
}

/// A direction that a caller gives.
fn direction(name: &str, vector: Option<Numbers<'_>>) -> PyResult<Option<Direction<EarthPath>>> {
    let Some(vector) = vector else { return Ok(None) };
    let vector = three(name, &vector)?.map(|number| number as f32);
    let direction = Direction::new(vector.into());
    direction
        .map(Some)
        .ok_or_else(|| refused(format!("{name}: no direction; give three numbers, not all zero")))
}

/// Direction and distance of the Earth from a picture of it, without prior knowledge: what `sextant earth`
/// answers.
///
/// image: (rows, columns) uint8 or uint16, raw values. fov_deg: horizontal field of an undistorted camera,
/// deg; or camera: path of a camera file. pole, sun: (3,) directions of the Earth's pole and of the Sun in
/// the sensor frame, where they are known; without a pole the Earth is a mean sphere.
///
/// Returns an Earth. Raises ValueError for an image or optics that cannot be used.
#[pyfunction]
#[pyo3(signature = (image, *, fov_deg=None, camera=None, pole=None, sun=None))]
pub(crate) fn earth(
    image: &Bound<'_, PyAny>,
    fov_deg: Option<f64>,
    camera: Option<PathBuf>,
    pole: Option<Numbers<'_>>,
    sun: Option<Numbers<'_>>,
) -> PyResult<Earth> {
    let py = image.py();
    let (picture, cameras) = (picture(image)?, optics::required(fov_deg, camera)?);
    let known = Known { pole: direction("pole", pole)?, sun: direction("sun", sun)? };
    let find = || PictureEarth::default().answer(Path::new("image"), &picture, &cameras, &known);
    let (answer, _) = py.detach(find).map_err(|error| fault(&error))?;
    Earth::new(py, &answer)
}
