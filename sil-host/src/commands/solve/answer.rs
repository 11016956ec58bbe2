//! The answer of `solve` for a picture, as JSON and for people.

use super::Found;
use super::pointing::Pointing;
use crate::flight;
use crate::flight::lost_in_space::Solution;
use fsw_core::catalog::Catalogue;
use fsw_core::frames::ARCSEC_PER_RAD;
use serde::Serialize;
use std::path::Path;
use std::time::{Duration, Instant};

/// A recognised star in the answer.
#[derive(Clone, Debug, Serialize)]
pub struct StarAnswer {
    /// Hipparcos number.
    pub hip: u32,
    /// Measured column, px.
    pub x: f32,
    /// Measured row, px.
    pub y: f32,
    /// Distance of the measured from the projected place, arcsec.
    pub residual_arcsec: f32,
    /// Measured less projected place, px.
    pub residual_px: [f32; 2],
}

/// Host time of the parts, ms.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Milliseconds {
    /// Reading windows and finding stars.
    pub detect: f64,
    /// Identification and its refinement.
    pub identify: f64,
    /// The attitude of the identified stars alone.
    pub attitude: f64,
}

/// The answer for one picture.
#[derive(Clone, Debug, Serialize)]
pub struct SolveAnswer {
    /// The file as given.
    pub image: String,
    /// `identified` or `not_identified`.
    pub status: &'static str,
    /// Why not, where not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// ICRS to sensor, `[x, y, z, w]`.
    pub q: Option<[f32; 4]>,
    /// Right ascension of the picture's middle, degrees.
    pub ra_deg: Option<f64>,
    /// Declination of the picture's middle, degrees.
    pub dec_deg: Option<f64>,
    /// Position angle of the picture's upward direction at its middle, degrees from north through east.
    pub roll_deg: Option<f64>,
    /// Whether the picture shows the sky as in a mirror; `q` then maps to a sensor frame whose x runs to
    /// the left.
    pub mirrored: Option<bool>,
    /// Horizontal field with the refined focal length, degrees.
    pub fov_deg: Option<f64>,
    /// Standard deviations about x, y, z, arcsec.
    pub sigma_arcsec: Option<[f32; 3]>,
    /// Probability that the names are wrong.
    pub false_id_probability: Option<f64>,
    /// Star-like spots found.
    pub detections: u32,
    /// Places of the brightest of them, px, brightest first.
    pub spots: Vec<[f32; 2]>,
    /// The stars recognised, brightest first.
    pub stars: Vec<StarAnswer>,
    /// Host time.
    pub ms: Milliseconds,
}

/// The answer for what became of a picture.
pub(super) fn answer(name: &Path, found: &Found, catalogue: Option<&Catalogue>) -> SolveAnswer {
    let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
    let mut answer = SolveAnswer {
        image: name.display().to_string(),
        status: "not_identified",
        reason: None,
        q: None,
        ra_deg: None,
        dec_deg: None,
        roll_deg: None,
        mirrored: None,
        fov_deg: None,
        sigma_arcsec: None,
        false_id_probability: None,
        detections: found.detections,
        spots: found.spots.clone(),
        stars: Vec::new(),
        ms: Milliseconds { detect: ms(found.detect), identify: ms(found.identify), attitude: 0.0 },
    };
    match &found.solution {
        Err(reason) => answer.reason = Some(reason),
        Ok(solution) => {
            if let Some(catalogue) = catalogue {
                answer.ms.attitude = ms(time_attitude(solution, catalogue));
                fill(&mut answer, solution, catalogue);
            }
        }
    }
    answer
}

/// How long the attitude of the matched stars takes by itself.
fn time_attitude(solution: &Solution, catalogue: &Catalogue) -> Duration {
    let pairs: Vec<_> = solution
        .confirmed
        .matches
        .iter()
        .filter_map(|found| {
            let seen = solution.measured.get(usize::from(found.measured))?;
            let star = catalogue.star(found.star)?;
            Some(seen.paired_with(catalogue.apparent_direction(&star), &solution.camera))
        })
        .collect();
    let begin = Instant::now();
    let _ = std::hint::black_box(fsw_core::attitude::wahba::svd::solve(std::hint::black_box(&pairs)));
    begin.elapsed()
}

/// Writes a solution into the answer.
fn fill(answer: &mut SolveAnswer, solution: &Solution, catalogue: &Catalogue) {
    let Solution { camera, measured, confirmed, log10_false } = solution;
    answer.status = "identified";
    answer.q = Some(confirmed.attitude.quaternion());
    if let Some(pointing) = Pointing::new(solution) {
        let middle_deg = pointing.middle_deg();
        answer.ra_deg = middle_deg.map(|[ra_deg, _]| ra_deg);
        answer.dec_deg = middle_deg.map(|[_, dec_deg]| dec_deg);
        answer.roll_deg = pointing.roll_deg();
    }
    answer.mirrored = Some(camera.parameters().mirrored);
    let [width_deg, _] = flight::field_deg(camera);
    answer.fov_deg = Some(width_deg);
    answer.sigma_arcsec = Some(confirmed.sigma_rad.map(|sigma| sigma * ARCSEC_PER_RAD));
    answer.false_id_probability = Some(10f64.powf(f64::from(*log10_false)));
    answer.stars = confirmed
        .matches
        .iter()
        .filter_map(|found| {
            let [x, y] = measured.get(usize::from(found.measured))?.centre_px;
            let [dx, dy] = found.residual_px;
            let residual_arcsec = dx.hypot(dy) * camera.rad_per_px() * ARCSEC_PER_RAD;
            let hip = catalogue.star(found.star)?.hip;
            Some(StarAnswer { hip, x, y, residual_arcsec, residual_px: found.residual_px })
        })
        .collect();
}

/// Prints an answer for people; `hint` is what may help where the sky was not identified.
pub(super) fn print_text(answer: &SolveAnswer, hint: &str) {
    let Milliseconds { detect, identify, .. } = answer.ms;
    let mirrored = if answer.mirrored == Some(true) { ", mirrored" } else { "" };
    let SolveAnswer { ra_deg, dec_deg, roll_deg, fov_deg, sigma_arcsec, .. } = *answer;
    match (ra_deg, dec_deg, roll_deg, fov_deg, sigma_arcsec) {
        (Some(ra), Some(dec), Some(roll), Some(fov), Some([x, y, z])) => print_line!(
            "{}: identified, RA {ra:.4} Dec {dec:+.4} roll {roll:.3} deg, field {fov:.3} deg{mirrored}, sigma {x:.1} {y:.1} {z:.1} arcsec, \
             {} of {} spots named, false with {:.0e} ({detect:.1} + {identify:.1} ms)",
            answer.image,
            answer.stars.len(),
            answer.detections,
            answer.false_id_probability.unwrap_or(1.0)
        ),
        _ => print_line!(
            "{}: not identified ({}), {} spots ({detect:.1} + {identify:.1} ms){hint}",
            answer.image,
            answer.reason.unwrap_or("no reason"),
            answer.detections
        ),
    }
}
