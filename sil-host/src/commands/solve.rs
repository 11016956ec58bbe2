//! `sil-host solve`: lost in space on real pictures, served to the flight code as a detector.
//!
//! In: picture files and a camera file or a field of view, or neither: then all fields of 5 to 40 deg are
//! tried ([`crate::flight::blind`]). Out: a line a picture, JSON or text, with attitude, sigma and the
//! stars recognised. A picture that cannot be read costs one line on stderr and status 2 at the end; the
//! others are still answered. A sky that cannot be identified is an answer, not a fault. On request a
//! drawing and a FITS header of each picture ([`wcs`]).

mod answer;
mod drawing;
mod grid;
pub mod pointing;
pub mod session;
pub mod star_names;
mod table;
pub mod wcs;

use crate::cli::SolveArguments;
use crate::commands::picture_camera::PictureCamera;
use crate::drawing::names;
use crate::error::{Faults, HostError};
use crate::flight;
use crate::flight::blind::BlindSearch;
use crate::flight::lost_in_space::{FocalLength, Solution, Solver};
use crate::formats::defects_file::{self, DefectsFile};
use crate::formats::json;
use crate::formats::picture::{EXPOSURE_US, Picture};
use crate::output::write_whole;
pub use answer::{Milliseconds, SolveAnswer, StarAnswer};
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::image::DetectionParameters;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_core::stars::identify::NotIdentified;
use fsw_hal::Detector;
use session::Session;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Words for the flight code's reason.
pub fn reason_words(reason: NotIdentified) -> &'static str {
    match reason {
        NotIdentified::TooFewStars => "fewer than three stars",
        NotIdentified::NoSides => "no separation lies in the catalogue's range",
        NotIdentified::NoMatch => "no polygon of stars passed confirmation",
    }
}

/// Why no sky was found with nothing known of the optics.
const NO_FIELD: &str = "no field of 5 to 40 deg fits the spots, nor one seen in a mirror";
/// What may help where a field was given.
const TRY_ALL: &str = "; fields within 2.4 % of --fov-deg were tried: without it all of 5 to 40 deg are";

/// Centroids with their sigmas, px, brightest first.
type Centroids = Vec<([f32; 2], f32)>;

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
        self.find_by(name, picture, |solver, centroids| {
            solver.search(centroids, camera, catalogue, focal_length).map_err(reason_words)
        })
    }

    /// Scans a picture and identifies its stars with nothing known of the optics; the catalogue is that of
    /// the stars' numbers, empty where there is no solution.
    ///
    /// # Errors
    /// When the picture does not serve as a detector.
    fn find_blind<'s>(
        &mut self,
        name: &Path,
        picture: &mut Picture,
        search: &'s mut BlindSearch,
        tried: impl FnMut(),
    ) -> Result<(Found, &'s [u8]), HostError> {
        let mut catalogue: &[u8] = &[];
        let found = self.find_by(name, picture, |solver, centroids| {
            let found = search.search(solver, centroids, tried).map_err(|reason| match reason {
                NotIdentified::TooFewStars => reason_words(reason),
                NotIdentified::NoSides | NotIdentified::NoMatch => NO_FIELD,
            })?;
            catalogue = found.catalogue;
            Ok(found.solution)
        })?;
        Ok((found, catalogue))
    }

    fn find_by(
        &mut self,
        name: &Path,
        picture: &mut Picture,
        search: impl FnOnce(&mut Solver, &Centroids) -> Result<Solution, &'static str>,
    ) -> Result<Found, HostError> {
        let fault = |error| HostError::detector(name, error);
        let begin = Instant::now();
        picture.expose(EXPOSURE_US).map_err(fault)?;
        scan(picture, &mut self.buffer, &DetectionParameters::default(), &mut self.detections)
            .map_err(fault)?;
        let detect = begin.elapsed();
        let spots = self.detections.spots();
        let centroids: Centroids = spots.iter().map(|spot| (spot.centre_px(), spot.sigma_px())).collect();
        let begin = Instant::now();
        let solution = search(&mut self.solver, &centroids);
        let identify = begin.elapsed();
        let solution = solution.map_err(|reason| picture.without_content().unwrap_or(reason));
        let spots = centroids.iter().map(|(centre, _)| *centre).collect();
        Ok(Found { solution, spots, detections: self.detections.found(), detect, identify })
    }
}

/// Runs the command.
///
/// # Errors
/// What concerns all pictures: camera file, catalogue, folders.
pub fn run(arguments: &SolveArguments) -> Result<ExitCode, HostError> {
    let cameras = PictureCamera::load(&arguments.optics)?;
    let defects = arguments.defects.as_deref().map(DefectsFile::load).transpose()?;
    let catalogue = arguments.catalog.as_deref().map(flight::catalogue_file).transpose()?;
    let mut session = Session::new(cameras, catalogue, arguments.json);
    crate::drawing::folder(arguments.overlay.as_ref())?;
    crate::drawing::folder(arguments.wcs.as_ref())?;
    let no_match = arguments.optics.fov_deg.map(|_| reason_words(NotIdentified::NoMatch));
    let (mut faults, mut answers) = (Faults::default(), Vec::new());
    let [drawings, headers] = ["-sky.png", ".wcs"].map(|ending| names(&arguments.images, ending));
    for (name, (drawing, header)) in arguments.images.iter().zip(drawings.iter().zip(&headers)) {
        let mut solve = || -> Result<SolveAnswer, HostError> {
            let mut picture = defects_file::picture(name, defects.as_ref())?;
            let (answer, pointing) = session.solve(name, &mut picture)?;
            if let Some(folder) = &arguments.overlay {
                drawing::draw(&picture, &answer, pointing.as_ref()).write(&folder.join(drawing))?;
            }
            if let Some((folder, pointing)) = arguments.wcs.as_ref().zip(pointing) {
                write_whole(&folder.join(header), &wcs::header(&pointing))?;
            }
            Ok(answer)
        };
        let Some(answer) = faults.noted(solve()) else { continue };
        if arguments.json {
            json::print_line(&answer);
        } else {
            let of_field = no_match.is_some() && answer.reason == no_match;
            answer::print_text(&answer, if of_field { TRY_ALL } else { "" });
        }
        answers.push(answer);
    }
    // Of no picture an answer: the table of an earlier run stays.
    if let Some(path) = arguments.csv.as_ref().filter(|_| !answers.is_empty()) {
        table::write(path, &answers)?;
    }
    Ok(faults.status())
}
