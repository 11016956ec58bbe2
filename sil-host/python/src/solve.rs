//! `solve`: attitude from a picture of stars.

use crate::arrays::{Row, Rows, fault, picture, row, rows, whole};
use crate::optics;
use numpy::PyArray1;
use pyo3::prelude::*;
use sil_host::commands::solve::SolveAnswer;
use sil_host::commands::solve::session::Session;
use std::path::{Path, PathBuf};

/// What a picture of stars tells; without an identified sky all but reason and spots_px is None or empty.
#[pyclass(frozen, get_all, module = "sextant")]
pub(crate) struct Solution {
    /// Whether the sky was identified.
    identified: bool,
    /// Why not, where not.
    reason: Option<String>,
    /// (4,) float64: ICRS to sensor, [x, y, z, w].
    quaternion: Option<Row>,
    /// (3,) float64: standard deviations about the sensor's x, y, z, arcsec.
    sigma_arcsec: Option<Row>,
    /// Right ascension of the picture's middle, deg, ICRS.
    ra_deg: Option<f64>,
    /// Declination of the picture's middle, deg, ICRS.
    dec_deg: Option<f64>,
    /// Position angle of the picture's upward direction at its middle, deg from north through east.
    roll_deg: Option<f64>,
    /// Horizontal field with the focal length that the stars ask for, deg.
    fov_deg: Option<f64>,
    /// Whether the picture shows the sky as in a mirror; x of the sensor frame then runs to the left.
    mirrored: Option<bool>,
    /// Probability that the names are wrong.
    false_id_probability: Option<f64>,
    /// (n,) int64: Hipparcos numbers of the stars recognised, brightest first.
    hip: Py<PyArray1<i64>>,
    /// (n, 2) float64: their measured places, x and y, px.
    star_px: Rows,
    /// (n, 2) float64: measured less projected places, px.
    residual_px: Rows,
    /// (m, 2) float64: places of the brightest star-like spots, px, brightest first.
    spots_px: Rows,
}

impl Solution {
    fn new(py: Python<'_>, answer: &SolveAnswer) -> PyResult<Self> {
        let stars = &answer.stars;
        Ok(Self {
            identified: answer.q.is_some(),
            reason: answer.reason.map(str::to_owned),
            quaternion: answer.q.map(|q| row(py, &q)),
            sigma_arcsec: answer.sigma_arcsec.map(|sigma| row(py, &sigma)),
            ra_deg: answer.ra_deg,
            dec_deg: answer.dec_deg,
            roll_deg: answer.roll_deg,
            fov_deg: answer.fov_deg,
            mirrored: answer.mirrored,
            false_id_probability: answer.false_id_probability,
            hip: whole(py, stars.iter().map(|star| star.hip.into())),
            star_px: rows(py, stars.iter().map(|star| [star.x, star.y]))?,
            residual_px: rows(py, stars.iter().map(|star| star.residual_px))?,
            spots_px: rows(py, answer.spots.iter().copied())?,
        })
    }
}

/// Attitude from a picture of stars, without prior knowledge: what `sextant solve` answers.
///
/// image: (rows, columns) uint8 or uint16, raw values. fov_deg: horizontal field of an undistorted camera,
/// deg, right to 2 %; or camera: path of a camera file; with neither all fields of 5 to 40 deg are tried.
///
/// Returns a Solution. Raises ValueError for an image or optics that cannot be used.
#[pyfunction]
#[pyo3(signature = (image, *, fov_deg=None, camera=None))]
pub(crate) fn solve(
    image: &Bound<'_, PyAny>,
    fov_deg: Option<f64>,
    camera: Option<PathBuf>,
) -> PyResult<Solution> {
    let py = image.py();
    let (mut picture, cameras) = (picture(image)?, optics::known(fov_deg, camera)?);
    let solve = || Session::new(cameras, None, true).solve(Path::new("image"), &mut picture);
    let (answer, _) = py.detach(solve).map_err(|error| fault(&error))?;
    Solution::new(py, &answer)
}
