//! `sil-host earth`: the Earth in real pictures, served to the flight code as a detector.
//!
//! In: picture files, a camera file or a field of view, the Earth's pole and the Sun in the sensor frame
//! where they are known. Out: a line a picture, JSON or text, with limb points, centre, Earth vector and
//! distance; a drawing on request. A picture that cannot be read costs one line on stderr and status 2 at the
//! end; the others are still answered. A picture without an Earth is an answer, not a fault.
//!
//! The flight code's limb is a rise of some tens of pixels. From a low orbit a long lens makes it hundreds:
//! such a picture is read in blocks of 2, 4 or 8 px ([`BINNINGS`]), the first that gives a centre. Places in
//! the answer are the picture's own pixels.

mod drawing;

use crate::cli::EarthArguments;
use crate::commands::picture_camera::PictureCamera;
use crate::error::{Faults, HostError};
use crate::flight;
use crate::formats::camera_file::CameraFile;
use crate::formats::defects_file::{self, DefectsFile};
use crate::formats::json;
use crate::formats::picture::{EXPOSURE_US, Picture};
use fsw_core::camera::{Camera, Projection};
use fsw_core::earth::limb::{BREADTH, MAX_LENGTH};
use fsw_core::earth::limb_sensor::{self, Buffers, LimbSensor};
use fsw_core::earth::parameters::{HorizonParameters, LimbParameters};
use fsw_core::earth::search::Points;
use fsw_core::earth::view::View;
use fsw_core::earth::{Body, EarthFix, EarthParameters, Ellipsoid, FitError, centre};
use fsw_core::frames::{Direction, EarthPath};
use fsw_hal::Detector;
use nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Sides of the blocks in which a picture is read, px, in this order.
pub const BINNINGS: [u16; 4] = [1, 2, 4, 8];
/// Shorter side that must be left, px: fewer lines of the search could agree by chance.
const LEAST_SIDE_PX: u16 = 256;
/// Pictures come from deep space, too: the parameter's greatest value, km.
const FARTHEST_KM: f32 = 1e9;
/// Least standard deviation of a limb point of a picture, px: published pictures are resampled, sharpened and
/// masked by others.
const PICTURE_FLOOR_PX: f32 = 0.3;
/// Radius of the mean sphere, km (IUGG).
const MEAN_RADIUS_KM: f32 = 6371.009;
/// Height of the ellipsoid over that sphere, root mean square, and the distance over which it changes, km.
const FLATTENING_KM: f32 = 6.4;
const FLATTENING_CELL_KM: f32 = 3000.0;
/// Points of a limb that is drawn or measured.
const OUTLINE: usize = 720;

/// A limb point in the answer.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LimbAnswer {
    /// Column, px.
    pub x: f32,
    /// Row, px.
    pub y: f32,
    /// Whether the centre rests on it.
    pub inlier: bool,
}

/// Host time of the parts, ms.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Milliseconds {
    /// Search, strips and centre, all binnings tried.
    pub find: f64,
}

/// The answer for one picture.
#[derive(Clone, Debug, Serialize)]
pub struct EarthAnswer {
    /// The file as given.
    pub image: String,
    /// `found` or `not_found`.
    pub status: &'static str,
    /// Why not, where not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// Image of the Earth's centre, px; none where it lies behind the camera.
    pub centre_px: Option<[f32; 2]>,
    /// Mean distance of the limb from it, px; where a part of the limb lies behind the camera, that of a limb
    /// about the line of sight.
    pub radius_px: Option<f32>,
    /// Limb points measured.
    pub points: usize,
    /// Those on which the centre rests.
    pub inliers: u32,
    /// Root mean square distance of these from the fitted limb, px.
    pub rms_px: Option<f32>,
    /// Unit vector to the Earth's centre, sensor frame.
    pub direction: Option<[f32; 3]>,
    /// Distance of the Earth's centre, km.
    pub distance_km: Option<f32>,
    /// Standard deviation of the direction, the greater of the two across it, deg.
    pub sigma_deg: Option<f32>,
    /// Standard deviation of the distance, km.
    pub sigma_distance_km: Option<f32>,
    /// Azimuth about the centre that the inliers span, deg.
    pub arc_deg: Option<f32>,
    /// Side of the blocks in which the picture was read, px.
    pub binning_px: u16,
    /// The limb points.
    pub limb: Vec<LimbAnswer>,
    /// Host time.
    pub ms: Milliseconds,
}

/// Words for the flight code's reason.
pub fn reason_words(reason: FitError) -> &'static str {
    match reason {
        FitError::TooFewPoints => "too few limb points",
        FitError::NoConsensus => "the limb points do not agree on one body",
        FitError::ShortArc => "the arc of the limb is too short",
        FitError::Degenerate => "the limb points fix no centre",
        FitError::Uncertain => "the limb points leave the centre too uncertain",
    }
}

/// What the flight code is given where the pole is not known: a mean sphere, from which the ellipsoid departs
/// by 6.4 km in the root mean square over all places, over distances as long as the Earth's radius.
pub fn of_a_mean_sphere(parameters: EarthParameters) -> EarthParameters {
    EarthParameters {
        ellipsoid: Ellipsoid { equatorial_km: MEAN_RADIUS_KM, polar_km: MEAN_RADIUS_KM },
        limb: LimbParameters { height_sigma_km: FLATTENING_KM, ..parameters.limb },
        horizon: HorizonParameters {
            sigma_km: FLATTENING_KM,
            cell_km: FLATTENING_CELL_KM,
            ..parameters.horizon
        },
        ..parameters
    }
}

/// Where the Earth's pole and the Sun stand, as far as is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known {
    /// The pole, sensor frame; without it the Earth is a sphere.
    pub pole: Option<Direction<EarthPath>>,
    /// The Sun, sensor frame.
    pub sun: Option<Direction<EarthPath>>,
}

impl Known {
    /// The body, and the parameters that belong to it.
    fn body(&self) -> (Body, EarthParameters) {
        let mut parameters = EarthParameters::default();
        parameters.strips.floor_px = PICTURE_FLOOR_PX;
        parameters.plausible.distance_km = FARTHEST_KM;
        if self.pole.is_none() {
            parameters = of_a_mean_sphere(parameters);
        }
        // Of a sphere any axis serves.
        let pole = self.pole.or_else(|| Direction::new(Vector3::new(0.0, 1.0, 0.0)));
        let pole = pole.expect("a unit vector is a direction");
        (Body::new(&pole, self.sun.as_ref(), &parameters), parameters)
    }
}

/// Finds the Earth in pictures.
pub struct PictureEarth {
    buffer: Vec<u16>,
    points: Points,
    rays: Box<centre::RayBuffer>,
}

impl Default for PictureEarth {
    fn default() -> Self {
        Self { buffer: Vec::new(), points: Points::new(), rays: Box::new(centre::RayBuffer::new()) }
    }
}

/// The Earth in a picture, places in its own pixels.
#[derive(Clone, Debug)]
pub struct Found {
    /// The centre, or why there is none.
    pub fix: Result<EarthFix, FitError>,
    /// The limb points of the last step.
    pub limb: Vec<LimbAnswer>,
    /// Side of the blocks in which the picture was read, px.
    pub binning_px: u16,
}

/// A limb as the camera shows it: places evenly about the centre, px, those behind the camera missing.
pub type Limb = Vec<Option<[f32; 2]>>;

impl PictureEarth {
    /// Looks for the Earth in a picture taken with this camera; `name` is for the message.
    ///
    /// # Errors
    /// When the picture does not serve as a detector.
    pub fn find(
        &mut self,
        name: &Path,
        picture: &Picture,
        file: &CameraFile,
        known: &Known,
    ) -> Result<Found, HostError> {
        let mut first = None;
        for binning_px in BINNINGS {
            let geometry = picture.geometry();
            let mut binned = match binning_px {
                1 => picture.clone(),
                side if geometry.width_px.min(geometry.height_px) / side < LEAST_SIDE_PX => break,
                side => match picture.binned(side) {
                    Some(binned) => binned,
                    None => break,
                },
            };
            let camera = match binning_px {
                1 => flight::camera(file, name)?,
                side => match flight::camera(&file.binned(side), name) {
                    Ok(camera) => camera,
                    Err(_) => break,
                },
            };
            let found = self.find_binned(name, &mut binned, &camera, known, binning_px)?;
            if found.fix.is_ok() {
                return Ok(found);
            }
            // The reason that got furthest: points that do not agree say more than none.
            if !matches!(&first, Some(Found { fix: Err(reason), .. }) if *reason != FitError::TooFewPoints) {
                first = Some(found);
            }
        }
        first.ok_or_else(|| HostError::input(name, None, "the picture is too small", "give a larger one"))
    }

    /// The answer for a picture, and its limb; none of a picture without an Earth.
    ///
    /// # Errors
    /// Those of [`Self::find`], and of the camera.
    pub fn answer(
        &mut self,
        name: &Path,
        picture: &Picture,
        cameras: &PictureCamera,
        known: &Known,
    ) -> Result<(EarthAnswer, Limb), HostError> {
        let (file, (camera, _)) = (cameras.of(name, picture)?, cameras.flight(name, picture)?);
        let begin = Instant::now();
        let found = self.find(name, picture, &file, known)?;
        let find_ms = begin.elapsed().as_secs_f64() * 1e3;
        Ok(answer((name, picture), &found, &camera, known, find_ms))
    }

    fn find_binned(
        &mut self,
        name: &Path,
        picture: &mut Picture,
        camera: &Camera,
        known: &Known,
        binning_px: u16,
    ) -> Result<Found, HostError> {
        let fault = |error| HostError::detector(name, error);
        let geometry = picture.geometry();
        let longer = usize::from(geometry.width_px.max(geometry.height_px));
        self.buffer.resize(longer.max(BREADTH * MAX_LENGTH), 0);
        picture.expose(EXPOSURE_US).map_err(fault)?;
        let (body, parameters) = known.body();
        let limb_sensor = LimbSensor { camera, body: &body, parameters: &parameters, turn: None };
        let mut buffers =
            Buffers { buffer: &mut self.buffer, points: &mut self.points, rays: &mut self.rays };
        let found = limb_sensor::acquire(&limb_sensor, picture, &mut buffers).map_err(fault)?;
        let side = f32::from(binning_px);
        let unbinned = |at: f32| at * side + 0.5 * (side - 1.0);
        let limb = self.points.iter().enumerate().map(|(index, point)| LimbAnswer {
            x: unbinned(point.centre_px[0]),
            y: unbinned(point.centre_px[1]),
            inlier: found.fix.as_ref().is_ok_and(|fix| fix.is_inlier(index)),
        });
        let fix = found.fix.map(|fix| EarthFix { rms_px: fix.rms_px * side, ..fix });
        Ok(Found { fix, limb: limb.collect(), binning_px })
    }
}

/// The limb of a body found, as the camera shows it: places evenly about the centre, those behind the camera
/// missing.
fn outline(view: &View, camera: &Camera) -> Vec<Option<[f32; 2]>> {
    (0..OUTLINE)
        .map(|step| {
            let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * step as f32 / OUTLINE as f32);
            camera.project_earth(&view.limb_ray([cosine, sine])?)
        })
        .collect()
}

/// The answer for what became of a picture, and the limb it shows.
fn answer(
    (name, picture): (&Path, &Picture),
    found: &Found,
    camera: &Camera,
    known: &Known,
    find_ms: f64,
) -> (EarthAnswer, Limb) {
    let mut answer = EarthAnswer {
        image: name.display().to_string(),
        status: "not_found",
        reason: found
            .fix
            .as_ref()
            .err()
            .map(|reason| picture.without_content().unwrap_or(reason_words(*reason))),
        centre_px: None,
        radius_px: None,
        points: found.limb.len(),
        inliers: 0,
        rms_px: None,
        direction: None,
        distance_km: None,
        sigma_deg: None,
        sigma_distance_km: None,
        arc_deg: None,
        binning_px: found.binning_px,
        limb: found.limb.clone(),
        ms: Milliseconds { find: find_ms },
    };
    let (body, _) = known.body();
    let Ok(fix) = &found.fix else { return (answer, Vec::new()) };
    let Some((direction, view)) = Direction::new(fix.centre_km).zip(View::new(&fix.centre_km, &body)) else {
        return (answer, Vec::new());
    };
    let limb = outline(&view, camera);
    let (sigma_rad, sigma_km) = fix.sigmas();
    answer.status = "found";
    answer.inliers = fix.inliers.count_ones();
    answer.rms_px = Some(fix.rms_px);
    answer.direction = Some((*direction.vector()).into());
    answer.distance_km = Some(fix.centre_km.norm());
    answer.sigma_deg = Some(sigma_rad.to_degrees());
    answer.sigma_distance_km = Some(sigma_km);
    answer.arc_deg = Some(fix.arc_rad.to_degrees());
    answer.centre_px = camera.project_earth(&direction);
    answer.radius_px = Some(radius_px(answer.centre_px, &limb, &view, camera));
    (answer, limb)
}

/// Mean distance of the limb's image from the centre's, px; of a limb about the line of sight where not all
/// of it is before the camera.
fn radius_px(centre_px: Option<[f32; 2]>, limb: &[Option<[f32; 2]>], view: &View, camera: &Camera) -> f32 {
    let whole: Option<Vec<[f32; 2]>> = limb.iter().copied().collect();
    if let Some(([x, y], whole)) = centre_px.zip(whole) {
        let sum: f64 = whole.iter().map(|at| f64::from((at[0] - x).hypot(at[1] - y))).sum();
        return (sum / whole.len() as f64) as f32;
    }
    let half_rad = libm::asinf(view.limb_sine());
    let radius = match camera.parameters().projection {
        Projection::Rectilinear => libm::tanf(half_rad),
        Projection::Equiangular => half_rad,
    };
    radius * camera.parameters().focal_length_px
}

/// Prints an answer for people.
fn print_text(answer: &EarthAnswer) {
    let EarthAnswer { image, points, inliers, .. } = answer;
    let ms = answer.ms.find;
    let (Some([x, y, z]), Some(distance), Some(sigma), Some(sigma_km), Some(rms), Some(arc)) = (
        answer.direction,
        answer.distance_km,
        answer.sigma_deg,
        answer.sigma_distance_km,
        answer.rms_px,
        answer.arc_deg,
    ) else {
        print_line!(
            "{image}: no Earth found ({}), {points} limb points ({ms:.1} ms)",
            answer.reason.unwrap_or("no reason")
        );
        return;
    };
    let centre = answer.centre_px.map_or("behind the camera".into(), |[x, y]| format!("at {x:.2} {y:.2} px"));
    print_line!(
        "{image}: Earth {centre}, radius {:.2} px, direction {x:.6} {y:.6} {z:.6} (sigma {sigma:.4} deg), distance {distance:.0} km \
         (sigma {sigma_km:.0}), {inliers} of {points} limb points over {arc:.0} deg, rms {rms:.2} px ({ms:.1} ms)",
        answer.radius_px.unwrap_or(f32::NAN),
    );
}

/// Runs the command.
///
/// # Errors
/// What concerns all pictures: the camera file, the folder for drawings.
pub fn run(arguments: &EarthArguments) -> Result<ExitCode, HostError> {
    let cameras = PictureCamera::required(&arguments.optics)?;
    let direction = |vector: Option<[f32; 3]>| vector.and_then(|vector| Direction::new(vector.into()));
    let known = Known { pole: direction(arguments.pole), sun: direction(arguments.sun) };
    crate::drawing::folder(arguments.overlay.as_ref())?;
    let defects = arguments.defects.as_deref().map(DefectsFile::load).transpose()?;
    let mut earth = PictureEarth::default();
    let mut faults = Faults::default();
    let names = crate::drawing::names(&arguments.images, "-earth.png");
    for (name, drawn) in arguments.images.iter().zip(names) {
        let mut find = || -> Result<EarthAnswer, HostError> {
            let picture = defects_file::picture(name, defects.as_ref())?;
            let (answer, limb) = earth.answer(name, &picture, &cameras, &known)?;
            if let Some(folder) = &arguments.overlay {
                drawing::draw(&picture, &answer, &limb).write(&folder.join(&drawn))?;
            }
            Ok(answer)
        };
        match faults.noted(find()) {
            Some(answer) if arguments.json => json::print_line(&answer),
            Some(answer) => print_text(&answer),
            None => {}
        }
    }
    Ok(faults.status())
}
