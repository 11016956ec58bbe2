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
pub mod star_names;
mod table;
pub mod wcs;

use crate::campaign::progress;
use crate::cli::SolveArguments;
use crate::commands::defects::{self, DefectsFile};
use crate::commands::picture_camera::PictureCamera;
use crate::drawing::names;
use crate::error::{Faults, HostError};
use crate::flight::blind::BlindSearch;
use crate::flight::lost_in_space::{FocalLength, Solution, Solver};
use crate::flight::{self, Density};
use crate::formats::json;
use crate::formats::picture::{EXPOSURE_US, Picture};
use crate::output::write_whole;
pub use answer::{Milliseconds, SolveAnswer, StarAnswer};
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::image::DetectionParameters;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_core::stars::identify::NotIdentified;
use fsw_hal::{Detector, DetectorGeometry};
use pointing::Pointing;
use std::borrow::Cow;
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

/// What pictures are solved with, and what those before leave for the next.
struct Session<'a> {
    arguments: &'a SolveArguments,
    cameras: Option<PictureCamera>,
    defects: Option<DefectsFile>,
    /// The catalogue that the user named.
    named: Option<Cow<'static, [u8]>>,
    /// The catalogue built for the field of the picture before, degrees.
    built: Option<([f64; 2], Cow<'static, [u8]>)>,
    /// The search over all optics for pictures of the size of the one before.
    blind: Option<(DetectorGeometry, BlindSearch)>,
    solver: PictureSolver,
}

impl<'a> Session<'a> {
    fn new(arguments: &'a SolveArguments) -> Result<Self, HostError> {
        Ok(Self {
            arguments,
            cameras: PictureCamera::load(&arguments.optics)?,
            defects: arguments.defects.as_deref().map(DefectsFile::load).transpose()?,
            named: arguments.catalog.as_deref().map(flight::catalogue_file).transpose()?,
            built: None,
            blind: None,
            solver: PictureSolver::default(),
        })
    }

    /// The answer for a picture, and where it looks if it was identified.
    fn solve(
        &mut self,
        name: &Path,
        picture: &mut Picture,
    ) -> Result<(SolveAnswer, Option<Pointing>), HostError> {
        let Some(cameras) = &self.cameras else { return self.solve_blind(name, picture) };
        let (camera, focal_length) = cameras.flight(name, picture)?;
        let field_deg = flight::field_deg(&camera);
        if self.named.is_none() && self.built.as_ref().is_none_or(|(served, _)| *served != field_deg) {
            self.built = Some((field_deg, flight::catalogue_bytes(&camera, Density::Brightest)?));
        }
        let bytes = self.named.as_ref().or(self.built.as_ref().map(|(_, bytes)| bytes));
        let catalogue = flight::open(bytes.map_or(&[], |bytes| bytes))?;
        let found = self.solver.find(name, picture, (&camera, focal_length), &catalogue)?;
        let pointing = found.solution.as_ref().ok().and_then(Pointing::new);
        Ok((answer::answer(name, &found, Some(&catalogue)), pointing))
    }

    /// The same with nothing known of the optics.
    fn solve_blind(
        &mut self,
        name: &Path,
        picture: &mut Picture,
    ) -> Result<(SolveAnswer, Option<Pointing>), HostError> {
        let geometry = picture.geometry();
        self.blind = self.blind.take().filter(|(served, _)| *served == geometry);
        let (_, search) = self.blind.get_or_insert_with(|| (geometry, BlindSearch::new(geometry)));
        let bar = progress("fields", search.tries(), self.arguments.json);
        let (found, catalogue) = self.solver.find_blind(name, picture, search, || bar.inc(1))?;
        bar.finish_and_clear();
        let catalogue = found.solution.as_ref().ok().map(|_| flight::open(catalogue)).transpose()?;
        let pointing = found.solution.as_ref().ok().and_then(Pointing::new);
        Ok((answer::answer(name, &found, catalogue.as_ref()), pointing))
    }
}

/// Runs the command.
///
/// # Errors
/// What concerns all pictures: camera file, catalogue, folders.
pub fn run(arguments: &SolveArguments) -> Result<ExitCode, HostError> {
    let mut session = Session::new(arguments)?;
    crate::drawing::folder(arguments.overlay.as_ref())?;
    crate::drawing::folder(arguments.wcs.as_ref())?;
    let no_match = arguments.optics.fov_deg.map(|_| reason_words(NotIdentified::NoMatch));
    let (mut faults, mut answers) = (Faults::default(), Vec::new());
    let [drawings, headers] = ["-sky.png", ".wcs"].map(|ending| names(&arguments.images, ending));
    for (name, (drawing, header)) in arguments.images.iter().zip(drawings.iter().zip(&headers)) {
        let mut solve = || -> Result<SolveAnswer, HostError> {
            let mut picture = defects::picture(name, session.defects.as_ref())?;
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
    if let Some(path) = &arguments.csv {
        table::write(path, &answers)?;
    }
    Ok(faults.status())
}
