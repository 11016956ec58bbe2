//! `sil-host identify`: the flight code's identification on lists of centroids.
//!
//! In: one field a line, `{"id":..,"centroids":[[x,y] or [x,y,brightness],...]}`. Out: one answer a line,
//! names in the order of the centroids. More centroids than the flight code takes: the brightest (without
//! brightness: the first) are used, and the answer says how many. A line that is no field costs one line on
//! stderr with its number and status 2 at the end; the others are still answered.

use crate::cli::IdentifyArguments;
use crate::commands::solve::reason_words;
use crate::error::{Faults, HostError};
use crate::flight::lost_in_space::{Solver, measure};
use crate::flight::{self, Density};
use crate::formats::camera_file::CameraFile;
use crate::formats::json;
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::frames::ARCSEC_PER_RAD;
use fsw_core::stars::MAX_MEASURED;
use fsw_core::stars::identify::IdentificationParameters;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Centroid error on which the reported sigma rests, px per axis; it is widened when the residuals are
/// larger.
const CENTROID_SIGMA_PX: f32 = 0.1;
/// What the help says of the lines.
pub const LINES: &str = "\
In, a field a line: {\"id\":..,\"centroids\":[[x,y],[x,y,brightness],...]}. id: anything, given back. x, y: px, the centre of the
first pixel is (0, 0), x right, y down. brightness: optional, in any unit, larger is brighter; the order means nothing then.
Out, a line a field: {\"id\",\"status\":\"identified|not_identified\",\"reason\",\"hip\":[number or null for each centroid],
\"q\":[x,y,z,w] from ICRS to sensor,\"sigma_arcsec\":[about x,y,z],\"false_id_probability\",\"candidates\",\"us\"}.";

const TO_DO: &str = "give {\"id\":..,\"centroids\":[[x,y],...]}";

/// A field as given.
#[derive(Clone, Debug, Deserialize)]
pub struct FieldInput {
    /// Anything that names the field; given back.
    pub id: serde_json::Value,
    /// Places, px, with an optional brightness.
    pub centroids: Vec<Vec<f64>>,
}

/// The answer for one field.
#[derive(Clone, Debug, Serialize)]
pub struct FieldAnswer {
    /// As given.
    pub id: serde_json::Value,
    /// `identified` or `not_identified`.
    pub status: &'static str,
    /// Why not, where not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// Hipparcos number of each centroid, in the order given.
    pub hip: Vec<Option<u32>>,
    /// ICRS to sensor, `[x, y, z, w]`.
    pub q: Option<[f32; 4]>,
    /// Standard deviations about x, y, z, arcsec.
    pub sigma_arcsec: Option<[f32; 3]>,
    /// Probability that the names are wrong.
    pub false_id_probability: Option<f64>,
    /// Candidate polygons that the search held ready.
    pub candidates: usize,
    /// How many centroids were used, where not all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centroids_used: Option<usize>,
    /// Host time, microseconds.
    pub us: f64,
}

/// What is wrong with a field's content, if anything.
fn fault(field: &FieldInput) -> Option<String> {
    field.centroids.iter().enumerate().find_map(|(index, centroid)| {
        if !(2..=3).contains(&centroid.len()) {
            Some(format!("centroid {index} has {} numbers instead of 2 or 3", centroid.len()))
        } else if centroid.iter().any(|value| !(*value as f32).is_finite()) {
            Some(format!("centroid {index} is not finite"))
        } else {
            None
        }
    })
}

/// Identifies one field as in flight.
pub fn answer(
    solver: &mut Solver,
    field: &FieldInput,
    camera: &Camera,
    catalogue: &Catalogue,
) -> FieldAnswer {
    answer_with(&IdentificationParameters::default(), solver, field, camera, catalogue)
}

/// Identifies one field by a criterion of the user's.
pub fn answer_with(
    parameters: &IdentificationParameters,
    solver: &mut Solver,
    field: &FieldInput,
    camera: &Camera,
    catalogue: &Catalogue,
) -> FieldAnswer {
    let begin = Instant::now();
    let mut order: Vec<usize> = (0..field.centroids.len()).collect();
    let brightness = |index: &usize| field.centroids[*index].get(2).copied().unwrap_or(0.0);
    // Stable, so without brightness the order stays as given.
    order.sort_by(|a, b| brightness(b).total_cmp(&brightness(a)));
    // A place the camera cannot map (far outside the detector) is no star; its index must not shift the
    // others.
    let place = |index: &usize| [field.centroids[*index][0] as f32, field.centroids[*index][1] as f32];
    order.retain(|index| camera.direction(place(index)).is_some());
    order.truncate(MAX_MEASURED);
    let centroids: Vec<_> = order.iter().map(|index| (place(index), CENTROID_SIGMA_PX)).collect();
    let measured = measure(&centroids, camera);
    let found = solver.identify(&measured, camera, catalogue, parameters);
    let mut answer = FieldAnswer {
        id: field.id.clone(),
        status: "not_identified",
        reason: None,
        hip: vec![None; field.centroids.len()],
        q: None,
        sigma_arcsec: None,
        false_id_probability: None,
        candidates: solver.candidates(),
        centroids_used: (order.len() < field.centroids.len()).then_some(order.len()),
        us: begin.elapsed().as_secs_f64() * 1e6,
    };
    match found {
        Err(reason) => answer.reason = Some(reason_words(reason)),
        Ok((confirmed, log10_false)) => {
            answer.status = "identified";
            for found in &confirmed.matches {
                let slot =
                    order.get(usize::from(found.measured)).and_then(|index| answer.hip.get_mut(*index));
                if let Some(slot) = slot {
                    *slot = catalogue.star(found.star).map(|star| star.hip);
                }
            }
            answer.q = Some(confirmed.attitude.quaternion());
            answer.sigma_arcsec = Some(confirmed.sigma_rad.map(|sigma| sigma * ARCSEC_PER_RAD));
            answer.false_id_probability = Some(10f64.powf(f64::from(log10_false)));
        }
    }
    answer
}

/// Reads the field on one line.
fn parse(path: &Path, number: usize, text: &str) -> Result<FieldInput, HostError> {
    let field: FieldInput = json::read_line(path, number, text, TO_DO)?;
    match fault(&field) {
        Some(what) => Err(HostError::input(path, Some(number), what, TO_DO)),
        None => Ok(field),
    }
}

/// Prints an answer for people.
fn print_text(answer: &FieldAnswer) {
    let named = answer.hip.iter().flatten().count();
    let used = answer.centroids_used.map(|used| format!(" (brightest {used} used)")).unwrap_or_default();
    print_line!(
        "{}: {}, {named} of {} centroids named{used}, {:.0} us",
        answer.id,
        answer.reason.unwrap_or(answer.status),
        answer.hip.len(),
        answer.us
    );
}

/// Runs the command.
///
/// # Errors
/// What concerns all fields: camera file, catalogue, the file of fields.
pub fn run(arguments: &IdentifyArguments) -> Result<ExitCode, HostError> {
    let camera = flight::camera(&CameraFile::load(&arguments.camera)?, &arguments.camera)?;
    let bytes = match &arguments.catalog {
        Some(path) => flight::catalogue_file(path)?,
        None => flight::catalogue_bytes(&camera, Density::Full)?,
    };
    let catalogue = flight::open(&bytes)?;
    let path = arguments.fields.as_path();
    let mut solver = Solver::default();
    let mut faults = Faults::default();
    for line in json::Lines::open(path, TO_DO)? {
        let field = line.and_then(|(number, text)| parse(path, number, &text));
        let Some(field) = faults.noted(field) else { continue };
        let answer = answer(&mut solver, &field, &camera, &catalogue);
        if arguments.json {
            json::print_line(&answer);
        } else {
            print_text(&answer);
        }
    }
    Ok(faults.status())
}
