//! `sil-host calibrate`: focal length, optical centre and distortion of a lens from pictures of the sky.
//!
//! In: pictures taken with one lens, a camera file or a field of view that is right to 2 %. Out: a camera
//! file, a drawing of the residuals beside it (same name, `.svg`), a table on stdout. Pictures are solved by
//! the flight code ([`crate::commands::solve`]), their stars taken from the star source in double precision,
//! and the lens fitted to all at once ([`fit`]). With the lens found the pictures are solved again, until no
//! star comes or goes: towards the corners a better lens finds more. Where the stars suffice, star profiles
//! and correction tables for the flight code come beside the camera file (same name, `.corr`;
//! [`calibration`]), and the lens is fitted once more with their centroids.
//!
//! With `--rendered N` the pictures are those of the laboratory ([`pictures`]). So the calibrated reference
//! camera of all scenarios was made: `cargo sil calibrate --rendered 400 --camera
//! sil-host/cameras/reference.toml --out sil-host/cameras/reference-calibrated.toml`.
//!
//! A picture that cannot be read or has another size costs one line on stderr and status 2 at the end; one
//! that cannot be identified is named and left out.

mod plot;

use crate::calibration::fit::{self, Fit, Free, Sighting, View};
use crate::calibration::pictures::{self, Laboratory};
use crate::calibration::{self, Built, sights};
use crate::cli::CalibrateArguments;
use crate::commands::picture_camera::{PictureCamera, check_size};
use crate::commands::solve::PictureSolver;
use crate::error::{Faults, HostError};
use crate::flight::lost_in_space::FocalLength;
use crate::flight::{self, Density};
use crate::formats::camera_file::{CameraFile, Projection};
use crate::formats::picture::Picture;
use crate::output::write_whole;
use crate::world::attitude::{Vector, matrix};
use crate::world::detector::imaging::ImagingModel;
use crate::world::sky;
use crate::world::sky::stars::DetectorModel;
use catalog_gen::parameters::DEFAULT_EPOCH_YEAR;
use fsw_core::checksum::crc32;
use fsw_core::frames::ARCSEC_PER_RAD;
use fsw_hal::Detector;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Most rounds of solving and fitting.
const ROUNDS_MAX: usize = 5;

/// Rounds of profiles and lens.
const LENS_ROUNDS: usize = 2;

/// What the sky of a picture stretches beyond the stars' noise, share of the focal length: aberration 1e-4,
/// refraction 2.8e-4 at the zenith and 5.6e-4 along the vertical at 45 deg. Single pictures of one lens
/// scatter by 4e-4.
const SKY_STRETCH: f64 = 3e-4;

/// Stars by Hipparcos number.
type Stars = BTreeMap<u32, Vector>;

/// The stars of a picture as the flight code names them with this camera; none where it names none.
fn view(
    solver: &mut PictureSolver,
    (name, picture): (&Path, &mut Picture),
    (camera, focal_length): (&CameraFile, FocalLength),
    stars: &Stars,
) -> Result<Result<View, &'static str>, HostError> {
    let camera = flight::camera(camera, name)?;
    let bytes = flight::catalogue_bytes(&camera, Density::Brightest)?;
    let catalogue = flight::open(&bytes)?;
    let found = solver.find(name, picture, (&camera, focal_length), &catalogue)?;
    let solution = match found.solution {
        Ok(solution) => solution,
        Err(reason) => return Ok(Err(reason)),
    };
    let sighting = |index: u8, star: u16| {
        let measured = solution.measured.get(usize::from(index))?;
        let hip = catalogue.star(star)?.hip;
        Some(Sighting {
            hip,
            direction: *stars.get(&hip)?,
            at_px: measured.centre_px.map(f64::from),
            sigma_px: measured.sigma_px.into(),
        })
    };
    let matches = solution.confirmed.matches.iter();
    Ok(Ok(View {
        attitude: matrix(solution.confirmed.attitude.quaternion().map(f64::from)),
        stars: matches.filter_map(|found| sighting(found.measured, found.star)).collect(),
    }))
}

/// The pictures that serve, with their names.
struct Album {
    pictures: Vec<(PathBuf, Picture)>,
    faults: Faults,
}

impl Album {
    /// So many pictures of the rendered sky through this camera, the lens cooler than in flight.
    fn rendered(count: u32, camera: &CameraFile) -> Result<Self, HostError> {
        let stars = sky::in_year(DEFAULT_EPOCH_YEAR);
        let (camera, imaging) = pictures::cooler(camera, &ImagingModel::REFERENCE, pictures::WARMER_K);
        let detector = DetectorModel::reference();
        let mut laboratory = Laboratory::new((&camera, &imaging), &detector, &stars, pictures::SEED)?;
        let mut picture =
            |index| Ok((PathBuf::from(format!("sky {index}")), laboratory.picture(index)?.picture));
        let pictures = (0..count).map(&mut picture).collect::<Result<_, HostError>>()?;
        Ok(Self { pictures, faults: Faults::default() })
    }

    /// CRC-32 of the first picture's pixels.
    fn first_crc(&self) -> u32 {
        let pixels = self.pictures.first().map_or(&[][..], |(_, picture)| picture.pixels());
        crc32(&pixels.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>())
    }

    /// The pictures of these names that have the size of the first, and its camera.
    fn load(names: &[PathBuf], cameras: &PictureCamera) -> Result<(Self, CameraFile), HostError> {
        let (mut pictures, mut faults) = (Vec::new(), Faults::default());
        let mut start: Option<CameraFile> = None;
        for name in names {
            let mut load = || -> Result<Picture, HostError> {
                let picture = Picture::load(name)?;
                match &start {
                    Some(start) => check_size(start, name, &picture)?,
                    None => start = Some(cameras.of(name, &picture)?),
                }
                Ok(picture)
            };
            pictures.extend(faults.noted(load()).map(|picture| (name.clone(), picture)));
        }
        let start = start.ok_or_else(|| HostError::usage("no picture serves", "give pictures of the sky"))?;
        Ok((Self { pictures, faults }, start))
    }
}

/// A lens and the pictures it was found from.
pub struct Calibration {
    /// The lens.
    pub fit: Fit,
    /// The same stars with nothing but the focal length fitted: camera, attitudes.
    pub plain: (CameraFile, Vec<View>),
    /// Names of the pictures that were identified.
    pub names: Vec<PathBuf>,
}

/// Solves and fits in turn; `say` is called for pictures that are not identified.
///
/// # Errors
/// When the flight code refuses a camera, or the stars do not determine the lens.
fn calibrated(
    album: &mut Album,
    start: &CameraFile,
    mut say: impl FnMut(String),
) -> Result<Calibration, HostError> {
    let source = catalog_gen::source::stars();
    let stars: Stars = source.iter().map(|star| (star.hip, star.direction_at(DEFAULT_EPOCH_YEAR))).collect();
    let mut solver = PictureSolver::default();
    let mut camera = (start.clone(), FocalLength::Within2Percent);
    let mut last: Option<(Vec<Vec<u32>>, Calibration)> = None;
    for _ in 0..ROUNDS_MAX {
        let (mut views, mut names) = (Vec::new(), Vec::new());
        for (name, picture) in &mut album.pictures {
            match view(&mut solver, (name, picture), (&camera.0, camera.1), &stars)? {
                Ok(view) => {
                    views.push(view);
                    names.push(name.clone());
                }
                Err(reason) if last.is_none() => {
                    say(format!("{}: not identified ({reason}), left out", name.display()));
                }
                Err(_) => {}
            }
        }
        let hips = |view: &View| view.stars.iter().map(|star| star.hip).collect::<Vec<_>>();
        let named: Vec<Vec<u32>> = views.iter().map(hips).collect();
        if last.as_ref().is_some_and(|(before, _)| *before == named) {
            break;
        }
        let Some(fit) = fit::fit(start, &views) else {
            let what = format!(
                "{} stars in {} pictures do not determine the lens",
                named.concat().len(),
                views.len()
            );
            return Err(HostError::usage(what, "give more pictures, or a start camera nearer to the truth"));
        };
        camera = (fit.camera.clone(), FocalLength::Rough);
        let plain = fit::plain(start, &fit.views);
        last = Some((named, Calibration { fit, plain, names }));
    }
    last.map(|(_, calibration)| calibration)
        .ok_or_else(|| HostError::usage("no picture serves", "give pictures of the sky"))
}

/// What people read.
fn table(calibration: &Calibration) -> String {
    let Calibration { fit, plain: (plain, before), names } = calibration;
    let mut text = "Residuals with the focal length alone -> with the lens found:\n".to_owned();
    let arcsec = |px: f64| px / fit.camera.focal_length_px * f64::from(ARCSEC_PER_RAD);
    for ((name, view), old) in names.iter().zip(&fit.views).zip(before) {
        let rms = |camera: &CameraFile, view: &View| fit::rms_px(camera, std::slice::from_ref(view));
        let (was, is) = (rms(plain, old), rms(&fit.camera, view));
        let count = view.stars.len();
        let _ = writeln!(text, "{}: {count} stars, rms {was:.3} -> {is:.3} px an axis", name.display());
    }
    let (was, is) = (fit::rms_px(plain, before), fit.rms_px());
    let count: usize = fit.views.iter().map(|view| view.stars.len()).sum();
    let _ = writeln!(
        text,
        "{} pictures, {count} stars, {} outliers left out: rms {was:.3} -> {is:.3} px an axis ({:.1} -> {:.1} arcsec)",
        names.len(),
        fit.outliers,
        arcsec(was),
        arcsec(is)
    );
    let stretch_px = SKY_STRETCH * fit.camera.focal_length_px / (names.len() as f64).sqrt();
    for (free, sigma) in &fit.free {
        let of_sky = if *free == Free::FocalLength { stretch_px } else { 0.0 };
        let (value, sigma) = (free.of(&fit.camera), sigma.hypot(of_sky));
        let _ = writeln!(text, "{:<21} {value:>12.5} ± {sigma:.5}", free.key());
    }
    if names.len() == 1 {
        text += "One picture: refraction and aberration of its sky, and noise of its few stars, are taken for \
                 the lens, 2 to 4 of these sigmas; give 3 or more of different parts of the sky\n";
    }
    text
}

/// Runs the command.
///
/// # Errors
/// What concerns all pictures: camera files, a lens that the stars do not determine, files that cannot be
/// written.
pub fn run(arguments: &CalibrateArguments) -> Result<ExitCode, HostError> {
    let cameras = PictureCamera::required(&arguments.optics)?;
    apart(&arguments.out)?;
    if let PictureCamera::File(path, CameraFile { projection: Projection::Equiangular, .. }) = &cameras {
        let what = "only rectilinear cameras can be calibrated";
        return Err(HostError::input(path, None, what, "start from a rectilinear camera"));
    }
    let ((mut album, start), full_well_e) = match (arguments.rendered, &cameras) {
        (Some(count), PictureCamera::File(_, start)) => {
            let full_well_e = DetectorModel::reference().full_well_e * pictures::GAIN_FOUND;
            ((Album::rendered(count, start)?, start.clone()), full_well_e)
        }
        _ => (Album::load(&arguments.images, &cameras)?, arguments.full_well_e),
    };
    let mut calibration = calibrated(&mut album, &start, |line| eprintln!("{line}"))?;
    let profiles = star_calibration(&album, &start, &mut calibration, full_well_e);
    print_line!("{}", table(&calibration).trim_end());
    let mut camera = calibration.fit.camera.clone();
    match profiles {
        Ok(built) => {
            let path = arguments.out.with_extension("corr");
            write_whole(&path, &built.bytes)?;
            camera.correction_table = path.file_name().map(PathBuf::from);
            print_line!(
                "Star profiles and corrections of {} stars, {:.4} px an axis left beyond noise: {}",
                built.stars,
                built.residual_px,
                path.display()
            );
        }
        Err(error) => print_line!("No star profiles and corrections: {}", error.message()),
    }
    let rendered = arguments.rendered.map(|count| (count, album.first_crc()));
    write_whole(&arguments.out, (head(&calibration, rendered) + &camera.to_toml()).as_bytes())?;
    let drawing = arguments.out.with_extension("svg");
    write_whole(&drawing, plot::svg(&calibration).as_bytes())?;
    print_line!("Camera: {}   Residuals: {}", arguments.out.display(), drawing.display());
    Ok(album.faults.status())
}

/// Refuses a camera file whose name is that of what is written beside it.
fn apart(out: &Path) -> Result<(), HostError> {
    let beside = ["svg", "corr"].into_iter().find(|ending| out.with_extension(ending) == out);
    beside.map_or(Ok(()), |ending| {
        let what = format!("--out {}: the .{ending} beside it would have its name", out.display());
        Err(HostError::usage(what, "name the camera file .toml"))
    })
}

/// The comment of the camera file; `rendered`: how many pictures were, and the CRC-32 of the first.
fn head(Calibration { fit, names, .. }: &Calibration, rendered: Option<(u32, u32)>) -> String {
    let by = match rendered {
        None => "sil-host calibrate".to_owned(),
        Some((count, _)) => format!("sil-host calibrate --rendered {count}"),
    };
    let of = rendered.map_or(String::new(), |(_, crc)| format!(" (CRC-32 of the first {crc:08x})"));
    let stars = fit.views.iter().map(|view| view.stars.len()).sum::<usize>();
    let (pictures, rms) = (names.len(), fit.rms_px());
    format!("# Calibrated by `{by}` from {pictures} pictures{of}: {stars} stars, rms {rms:.3} px an axis.\n")
}

/// Star profiles and corrections from the pictures that were identified. With the profiles the lens is fitted
/// to the centres of gravity of many more stars: what the flight code finds without them is displaced where
/// images are lopsided.
fn star_calibration(
    album: &Album,
    start: &CameraFile,
    calibration: &mut Calibration,
    full_well_e: f64,
) -> Result<Built, HostError> {
    for _ in 0..LENS_ROUNDS {
        let Built { views, .. } = built(album, calibration, full_well_e)?;
        let names = calibration.names.iter().cloned().zip(&views);
        calibration.names = names.filter(|(_, view)| !view.stars.is_empty()).map(|(name, _)| name).collect();
        let views: Vec<View> = views.into_iter().filter(|view| !view.stars.is_empty()).collect();
        calibration.plain = fit::plain(start, &views);
        calibration.fit = fit::fit(start, &views).ok_or_else(|| {
            HostError::usage("the stars of some pictures do not fit the lens", "leave these pictures out")
        })?;
    }
    built(album, calibration, full_well_e)
}

/// Star profiles and corrections with the lens and the attitudes as they are now.
fn built(
    album: &Album,
    Calibration { fit, names, .. }: &Calibration,
    full_well_e: f64,
) -> Result<Built, HostError> {
    let stars = sights::catalogued(DEFAULT_EPOCH_YEAR);
    let (mut sights, mut bits) = (Vec::new(), 1);
    for (index, (name, view)) in names.iter().zip(&fit.views).enumerate() {
        if let Some((_, picture)) = album.pictures.iter().find(|(taken, _)| taken == name) {
            bits = picture.geometry().bits;
            sights.extend(sights::sights((index, picture, &view.attitude), &fit.camera, &stars));
        }
    }
    let attitudes = fit.views.iter().map(|view| view.attitude).collect();
    calibration::build(sights, attitudes, &fit.camera, (bits, full_well_e))
}
