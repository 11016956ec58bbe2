//! `identify`: names of star vectors.

use crate::arrays::{Numbers, Row, fault, refused, row, whole};
use crate::optics;
use fsw_core::camera::Camera;
use fsw_core::frames::Direction;
use numpy::{AllowTypeChange, PyArray1, PyArrayLike2};
use pyo3::prelude::*;
use sil_host::commands::identify::{FieldAnswer, FieldInput, answer};
use sil_host::commands::picture_camera::PictureCamera;
use sil_host::error::HostError;
use sil_host::flight::lost_in_space::Solver;
use sil_host::flight::{self, Density};
use sil_host::formats::camera_file::CameraFile;
use std::path::{Path, PathBuf};

/// Sides of the detector behind a field of view alone, px: the accuracy that is expected of the vectors is a
/// tenth of a pixel.
const SIDE_PX: u16 = 1024;

/// Names of star vectors; without an identified field all but reason and hip is None.
#[pyclass(frozen, get_all, module = "sextant")]
pub(crate) struct Field {
    /// Whether the field was identified.
    identified: bool,
    /// Why not, where not.
    reason: Option<String>,
    /// (n,) int64: Hipparcos number of each vector, in the order given; 0: not named.
    hip: Py<PyArray1<i64>>,
    /// (4,) float64: ICRS to sensor, [x, y, z, w].
    quaternion: Option<Row>,
    /// (3,) float64: standard deviations about the sensor's x, y, z, arcsec.
    sigma_arcsec: Option<Row>,
    /// Probability that the names are wrong.
    false_id_probability: Option<f64>,
}

impl Field {
    fn new(py: Python<'_>, answer: &FieldAnswer) -> Self {
        Self {
            identified: answer.q.is_some(),
            reason: answer.reason.map(str::to_owned),
            hip: whole(py, answer.hip.iter().map(|hip| hip.unwrap_or(0).into())),
            quaternion: answer.q.map(|q| row(py, &q)),
            sigma_arcsec: answer.sigma_arcsec.map(|sigma| row(py, &sigma)),
            false_id_probability: answer.false_id_probability,
        }
    }
}

/// The camera behind the vectors.
fn camera_of(cameras: &PictureCamera) -> Result<Camera, HostError> {
    match cameras {
        PictureCamera::File(path, file) => flight::camera(file, path),
        PictureCamera::FieldDeg(fov_deg) => {
            flight::camera(&CameraFile::from_fov(SIDE_PX, SIDE_PX, 16, *fov_deg)?, Path::new("fov_deg"))
        }
    }
}

/// Where the camera shows the vectors, px, with their brightness.
fn centroids(
    vectors: &PyArrayLike2<'_, f64, AllowTypeChange>,
    brightness: Option<&Numbers<'_>>,
    camera: &Camera,
) -> PyResult<Vec<Vec<f64>>> {
    let vectors = vectors.as_array();
    if vectors.ncols() != 3 {
        return Err(refused("vectors: give an array (n, 3)"));
    }
    let brightness: Option<Vec<f64>> = brightness.map(|of| of.as_array().iter().copied().collect());
    let right = |of: &[f64]| of.len() == vectors.nrows() && of.iter().all(|value| value.is_finite());
    if brightness.as_deref().is_some_and(|of| !right(of)) {
        return Err(refused("brightness: give a finite number a vector"));
    }
    let place = |(index, vector): (usize, [f32; 3])| {
        let place = Direction::new(vector.into()).and_then(|direction| camera.project(&direction));
        let [x, y] = place.filter(|place| place.iter().all(|at| at.is_finite())).ok_or_else(|| {
            refused(format!(
                "vectors[{index}]: no direction that the camera shows; give unit vectors about +z"
            ))
        })?;
        let bright = brightness.as_ref().map(|of| of[index]);
        Ok([x.into(), y.into()].into_iter().chain(bright).collect())
    };
    let rows = vectors.rows().into_iter().map(|row| [0, 1, 2].map(|axis| row[axis] as f32));
    rows.enumerate().map(place).collect()
}

/// Names of star vectors, without prior knowledge: what `sextant identify` answers for their images.
///
/// vectors: (n, 3) float64, directions in the sensor frame, about its z. fov_deg: the camera's horizontal
/// field, deg, of a square detector of 1,024 px a side, of which the vectors are expected to be right to a
/// few tenths of a pixel; or camera: path of a camera file. brightness: (n,), in any unit, larger is
/// brighter; without it the vectors stand in order, brightest first. Of more than 64 the brightest are used.
///
/// Returns a Field. Raises ValueError for vectors or optics that cannot be used.
#[pyfunction]
#[pyo3(signature = (vectors, *, fov_deg=None, camera=None, brightness=None))]
pub(crate) fn identify(
    py: Python<'_>,
    vectors: PyArrayLike2<'_, f64, AllowTypeChange>,
    fov_deg: Option<f64>,
    camera: Option<PathBuf>,
    brightness: Option<Numbers<'_>>,
) -> PyResult<Field> {
    let cameras = optics::required(fov_deg, camera)?;
    let camera = camera_of(&cameras).map_err(|error| fault(&error))?;
    let centroids = centroids(&vectors, brightness.as_ref(), &camera)?;
    let bytes = flight::catalogue_bytes(&camera, Density::Full).map_err(|error| fault(&error))?;
    let catalogue = flight::open(&bytes).map_err(|error| fault(&error))?;
    let field = FieldInput { id: "vectors".into(), centroids };
    let answer = py.detach(|| answer(&mut Solver::default(), &field, &camera, &catalogue));
    Ok(Field::new(py, &answer))
}
