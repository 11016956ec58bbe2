//! The answers of `solve` as a table (CSV): a row a picture, a column a number; what is not known is empty.

use super::SolveAnswer;
use crate::error::HostError;
use crate::output::write_whole;
use serde::Serialize;
use std::path::Path;

/// A row: units and meaning as in [`SolveAnswer`].
#[derive(Serialize)]
struct Row<'a> {
    image: &'a str,
    status: &'a str,
    reason: Option<&'a str>,
    ra_deg: Option<f64>,
    dec_deg: Option<f64>,
    roll_deg: Option<f64>,
    fov_deg: Option<f64>,
    mirrored: Option<bool>,
    q_x: Option<f32>,
    q_y: Option<f32>,
    q_z: Option<f32>,
    q_w: Option<f32>,
    sigma_x_arcsec: Option<f32>,
    sigma_y_arcsec: Option<f32>,
    sigma_z_arcsec: Option<f32>,
    false_id_probability: Option<f64>,
    detections: u32,
    stars: usize,
}

impl<'a> From<&'a SolveAnswer> for Row<'a> {
    fn from(answer: &'a SolveAnswer) -> Self {
        let q = |part: usize| answer.q.map(|q| q[part]);
        let sigma = |axis: usize| answer.sigma_arcsec.map(|sigma| sigma[axis]);
        Self {
            image: &answer.image,
            status: answer.status,
            reason: answer.reason,
            ra_deg: answer.ra_deg,
            dec_deg: answer.dec_deg,
            roll_deg: answer.roll_deg,
            fov_deg: answer.fov_deg,
            mirrored: answer.mirrored,
            q_x: q(0),
            q_y: q(1),
            q_z: q(2),
            q_w: q(3),
            sigma_x_arcsec: sigma(0),
            sigma_y_arcsec: sigma(1),
            sigma_z_arcsec: sigma(2),
            false_id_probability: answer.false_id_probability,
            detections: answer.detections,
            stars: answer.stars.len(),
        }
    }
}

/// Writes the answers into a file.
///
/// # Errors
/// When it cannot be written.
pub(super) fn write(path: &Path, answers: &[SolveAnswer]) -> Result<(), HostError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let rows = answers.iter().try_for_each(|answer| table.serialize(Row::from(answer)));
    let bytes = rows.ok().and_then(|()| table.into_inner().ok());
    // Memory takes every row.
    let bytes = bytes.ok_or_else(|| HostError::input(path, None, "cannot be made", "report this"))?;
    write_whole(path, &bytes)
}
