//! `sil-host solve`: lost in space on real pictures, served to the flight code as a detector.
//!
//! In: picture files and a camera file or a field of view. Out: a line a picture, JSON or text, with
//! attitude, sigma and the stars recognised. A picture that cannot be read costs one line on stderr and
//! status 2 at the end; the others are still answered. A sky that cannot be identified is an answer, not a
//! fault. On request a drawing and a FITS header of each picture ([`wcs`]).

mod drawing;
mod grid;
pub mod pointing;
pub mod star_names;
pub mod wcs;

use crate::cli::SolveArguments;
use crate::commands::defects::{self, DefectsFile};
use crate::commands::picture_camera::PictureCamera;
use crate::drawing::names;
use crate::error::{Faults, HostError};
use crate::flight::lost_in_space::{FocalLength, Solution, Solver};
use crate::flight::{self, Density};
use crate::formats::json;
use crate::formats::picture::{EXPOSURE_US, Picture};
use crate::output::write_whole;
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::frames::ARCSEC_PER_RAD;
use fsw_core::image::DetectionParameters;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_core::stars::identify::NotIdentified;
use fsw_hal::Detector;
use pointing::Pointing;
use serde::Serialize;
use std::borrow::Cow;
use std::path::Path;
use std::process::ExitCode;
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

/// Words for the flight code's reason.
pub fn reason_words(reason: NotIdentified) -> &'static str {
    match reason {
        NotIdentified::TooFewStars => "fewer than three stars",
        NotIdentified::NoSides => "no separation lies in the catalogue's range",
        NotIdentified::NoMatch => "no polygon of stars passed confirmation",
    }
}

/// Finds and names the stars of pictures.
pub struct PictureSolver {
    solver: Solver,
    buffer: Box<[u16; TILE_PIXELS]>,
    detections: Detections,
}

/// What became of a picture.
pub struct Found {
    /// The solution, or why there is none, in words.
    pub solution: Result<Solution, &'static str>,
    /// Star-like spots.
    pub detections: u32,
    /// Places of the brightest of them, px.
    pub spots: Vec<[f32; 2]>,
    detect: Duration,
    identify: Duration,
}

impl Default for PictureSolver {
    fn default() -> Self {
        Self { solver: Solver::default(), buffer: Box::new([0; TILE_PIXELS]), detections: Detections::new() }
    }
}

impl PictureSolver {
    /// Scans a picture and identifies its stars; `name` is for the message.
    ///
    /// # Errors
    /// When the picture does not serve as a detector.
    pub fn find(
        &mut self,
        name: &Path,
        picture: &mut Picture,
        (camera, focal_length): (&Camera, FocalLength),
        catalogue: &Catalogue,
    ) -> Result<Found, HostError> {
        let fault = |error| HostError::detector(name, error);
        let begin = Instant::now();
        picture.expose(EXPOSURE_US).map_err(fault)?;
        scan(picture, &mut self.buffer, &DetectionParameters::default(), &mut self.detections)
            .map_err(fault)?;
        let detect = begin.elapsed();
        let spots = self.detections.spots();
        let centroids: Vec<_> = spots.iter().map(|spot| (spot.centre_px(), spot.sigma_px())).collect();
        let begin = Instant::now();
        let solution = self.solver.search(&centroids, camera, catalogue, focal_length);
        let solution = solution.map_err(|reason| picture.without_content().unwrap_or(reason_words(reason)));
        let spots = centroids.iter().map(|(centre, _)| *centre).collect();
        Ok(Found { solution, spots, detections: self.detections.found(), detect, identify: begin.elapsed() })
    }
}

/// The answer for what became of a picture.
fn answer(name: &Path, found: &Found, catalogue: &Catalogue) -> SolveAnswer {
    let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
    let mut answer = SolveAnswer {
        image: name.display().to_string(),
        status: "not_identified",
        reason: None,
        q: None,
        ra_deg: None,
        dec_deg: None,
        roll_deg: None,
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
            answer.ms.attitude = ms(time_attitude(solution, catalogue));
            fill(&mut answer, solution, catalogue);
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

/// Prints an answer for people.
fn print_text(answer: &SolveAnswer) {
    let Milliseconds { detect, identify, .. } = answer.ms;
    let SolveAnswer { ra_deg, dec_deg, roll_deg, fov_deg, sigma_arcsec, .. } = *answer;
    match (ra_deg, dec_deg, roll_deg, fov_deg, sigma_arcsec) {
        (Some(ra), Some(dec), Some(roll), Some(fov), Some([x, y, z])) => say!(
            "{}: identified, RA {ra:.4} Dec {dec:+.4} roll {roll:.3} deg, field {fov:.3} deg, sigma {x:.1} {y:.1} {z:.1} arcsec, \
             {} of {} spots named, false with {:.0e} ({detect:.1} + {identify:.1} ms)",
            answer.image,
            answer.stars.len(),
            answer.detections,
            answer.false_id_probability.unwrap_or(1.0)
        ),
        _ => say!(
            "{}: not identified ({}), {} spots ({detect:.1} + {identify:.1} ms)",
            answer.image,
            answer.reason.unwrap_or("no reason"),
            answer.detections
        ),
    }
}

/// Runs the command.
///
/// # Errors
/// What concerns all pictures: camera file, catalogue, field.
pub fn run(arguments: &SolveArguments) -> Result<ExitCode, HostError> {
    let cameras = PictureCamera::load(&arguments.optics)?;
    let named = arguments.catalog.as_deref().map(flight::catalogue_file).transpose()?;
    let defects = arguments.defects.as_deref().map(DefectsFile::load).transpose()?;
    crate::drawing::folder(arguments.overlay.as_ref())?;
    crate::drawing::folder(arguments.wcs.as_ref())?;
    let mut solver = PictureSolver::default();
    // Pictures of one camera share the catalogue built for it.
    let mut built: Option<([f64; 2], Cow<[u8]>)> = None;
    let mut faults = Faults::default();
    let [drawings, headers] = ["-sky.png", ".wcs"].map(|ending| names(&arguments.images, ending));
    for (name, (drawing, header)) in arguments.images.iter().zip(drawings.iter().zip(&headers)) {
        let mut solve = || -> Result<SolveAnswer, HostError> {
            let mut picture = defects::picture(name, defects.as_ref())?;
            let (camera, focal_length) = cameras.flight(name, &picture)?;
            let field_deg = flight::field_deg(&camera);
            if named.is_none() && built.as_ref().is_none_or(|(served, _)| *served != field_deg) {
                built = Some((field_deg, flight::catalogue_bytes(&camera, Density::Brightest)?));
            }
            let bytes = named.as_ref().or(built.as_ref().map(|(_, bytes)| bytes));
            let catalogue = flight::open(bytes.map_or(&[], |bytes| bytes))?;
            let found = solver.find(name, &mut picture, (&camera, focal_length), &catalogue)?;
            let answer = answer(name, &found, &catalogue);
            let pointing = found.solution.as_ref().ok().and_then(Pointing::new);
            if let Some(folder) = &arguments.overlay {
                drawing::draw(&picture, &answer, pointing.as_ref()).write(&folder.join(drawing))?;
            }
            if let Some((folder, pointing)) = arguments.wcs.as_ref().zip(pointing) {
                write_whole(&folder.join(header), &wcs::header(&pointing))?;
            }
            Ok(answer)
        };
        match faults.noted(solve()) {
            Some(answer) if arguments.json => json::print_line(&answer),
            Some(answer) => print_text(&answer),
            None => {}
        }
    }
    Ok(faults.status())
}
