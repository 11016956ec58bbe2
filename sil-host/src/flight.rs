//! Hands what the host knows to the flight code: cameras, calibrations, catalogues, parameters.
//!
//! In: a camera file. Out: the flight camera, and the catalogue that serves its field: the embedded one where
//! it was made for such a field, else one built in memory from the same star source.

pub mod blind;
pub mod lost_in_space;

use crate::calibration;
use crate::calibration::pictures::{self, Laboratory, SkyPicture};
use crate::error::HostError;
use crate::formats::camera_file::{CameraFile, Projection};
use crate::words::program;
use crate::world::detector::imaging::ImagingModel;
use crate::world::sky;
use crate::world::sky::stars::DetectorModel;
use catalog_gen::parameters::DEFAULT_EPOCH_YEAR;
use fsw_core::camera::{self, Camera, CameraParameters};
use fsw_core::catalog::Catalogue;
use fsw_core::checksum::crc32;
use fsw_core::image::calibration::{Calibration, CalibrationError};
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Instruments, Sensor, SensorError, Workspace};
use fsw_core::telemetry::Report;
use fsw_hal::{Clock, Detector};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// The embedded catalogue serves fields whose longer side differs from its own by no more than this share.
const FIELD_TOLERANCE: f64 = 0.1;

/// A second of a sensor that has a detector and a clock, and nothing beside them.
pub fn second<D: Detector, C: Clock>(
    sensor: &mut Sensor,
    detector: &mut D,
    clock: &mut C,
    command: Command,
) -> Report {
    let (meter, rate_sensor, magnetometer, shutter) = (&mut (), &mut (), &mut (), &mut ());
    sensor.cycle(&mut Instruments { detector, clock, meter, rate_sensor, magnetometer, shutter }, command)
}

/// The flight code's description of a camera.
pub fn camera_parameters(file: &CameraFile) -> CameraParameters {
    let single = |value: f64| value as f32;
    let d = &file.distortion;
    CameraParameters {
        width_px: file.width_px,
        height_px: file.height_px,
        focal_length_px: single(file.focal_length_px),
        optical_centre_px: file.optical_centre_px.map(single),
        projection: match file.projection {
            Projection::Rectilinear => camera::Projection::Rectilinear,
            Projection::Equiangular => camera::Projection::Equiangular,
        },
        distortion: camera::Distortion {
            k1: single(d.k1),
            k2: single(d.k2),
            k3: single(d.k3),
            p1: single(d.p1),
            p2: single(d.p2),
        },
        corner_loss: single(file.corner_loss),
        mirrored: file.mirrored,
    }
}

/// The flight camera of a camera file; `path` is for the message.
///
/// # Errors
/// What the flight code refuses.
pub fn camera(file: &CameraFile, path: &Path) -> Result<Camera, HostError> {
    Camera::new(camera_parameters(file)).map_err(|error| {
        HostError::input(
            path,
            None,
            format!("the flight code refuses the camera ({error:?})"),
            "correct the optics",
        )
    })
}

/// The reference camera's calibration, also in the flight image. It and the camera file beside it were made
/// of pictures of the cooler lens by the command that [`crate::commands::calibrate`] names.
pub const REFERENCE_CALIBRATION: &[u8] = include_bytes!("../cameras/reference-calibrated.corr");

/// A camera as it was calibrated, at the temperature of the flight: for the reference camera what `calibrate`
/// found; another one is known.
pub fn calibrated_camera(camera: &CameraFile) -> CameraFile {
    if !is_reference(camera) {
        return camera.clone();
    }
    let found = CameraFile::reference_calibrated();
    CameraFile {
        focal_length_px: found.focal_length_px / (1.0 - pictures::FOCAL_LENGTH_PER_K * pictures::WARMER_K),
        mirrored: camera.mirrored,
        correction_table: None,
        bits: camera.bits,
        ..found
    }
}

/// Whether it is the reference camera, before a mirror or not.
fn is_reference(camera: &CameraFile) -> bool {
    *camera == CameraFile { mirrored: camera.mirrored, ..CameraFile::reference() }
}

/// Bytes of a calibration, shared by all that fly with it.
#[derive(Clone, Debug)]
pub struct StarCalibration(Arc<[u8]>);

impl StarCalibration {
    /// Of bytes that were checked.
    fn new(bytes: impl Into<Arc<[u8]>>) -> Self {
        Self(bytes.into())
    }

    /// The calibration; `None` for damaged bytes.
    pub fn open(&self) -> Option<Calibration<'_>> {
        Calibration::open(&self.0).ok()
    }

    /// The same with so many times the electrons a count.
    pub fn with_gain(&self, factor: f64) -> Self {
        if (factor - 1.0).abs() < 1e-9 {
            self.clone()
        } else {
            Self::new(calibration::with_gain(&self.0, factor))
        }
    }
}

/// Stars of the pictures that a camera is calibrated with in this program, and most pictures that are drawn
/// for them.
const STARS: usize = 4_000;
const PICTURES_MAX: u32 = 150;

/// Calibrations made in this program, by what they were made from.
static MADE: Mutex<BTreeMap<u32, Option<StarCalibration>>> = Mutex::new(BTreeMap::new());

/// The calibration that a camera flies with: the one its file names; for the reference camera the embedded
/// one, whatever the optics are on the day; for another one made now of pictures of the cooler lens. `None`
/// where the lens cannot be calibrated: nothing is corrected then.
///
/// # Errors
/// When the named file cannot be read or is no calibration.
pub fn calibration(
    camera: &CameraFile,
    imaging: &ImagingModel,
    detector: &DetectorModel,
) -> Result<Option<StarCalibration>, HostError> {
    if let Some(path) = &camera.correction_table {
        return Ok(Some(StarCalibration::new(calibration_file(path)?)));
    }
    if is_reference(camera) {
        return Ok(Some(StarCalibration::new(REFERENCE_CALIBRATION)));
    }
    let design = format!("{camera:?} {:?} {} {detector:?}", imaging.psf, imaging.pixel_pitch_um);
    let make = || calibrated((camera, imaging), detector).ok().map(StarCalibration::new);
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(made.entry(crc32(design.as_bytes())).or_insert_with(make).clone())
}

/// A calibration from pictures of the sky through the cooler lens, their attitudes known.
///
/// # Errors
/// Where the lens cannot be calibrated.
fn calibrated(
    (camera, imaging): (&CameraFile, &ImagingModel),
    detector: &DetectorModel,
) -> Result<Vec<u8>, HostError> {
    let stars = sky::in_year(DEFAULT_EPOCH_YEAR);
    let catalogued = calibration::sights::catalogued(DEFAULT_EPOCH_YEAR);
    let (camera, imaging) = pictures::cooler(camera, imaging, pictures::WARMER_K);
    let mut laboratory = Laboratory::new((&camera, &imaging), detector, &stars, pictures::SEED)?;
    let (mut sights, mut attitudes) = (Vec::new(), Vec::new());
    for index in 0..PICTURES_MAX {
        let SkyPicture { picture, attitude } = laboratory.picture(index)?;
        sights.extend(calibration::sights::sights(
            (attitudes.len(), &picture, &attitude),
            &camera,
            &catalogued,
        ));
        attitudes.push(attitude);
        if sights.len() >= STARS {
            break;
        }
    }
    let pixels = (pictures::BITS, detector.full_well_e * pictures::GAIN_FOUND);
    calibration::build(sights, attitudes, &camera, pixels).map(|built| built.bytes)
}

/// The sensor with these parameters and the calibration that they name, if any.
///
/// # Errors
/// What the flight code refuses.
pub fn sensor<'c>(
    catalogue: Catalogue<'c>,
    calibration: Option<Calibration<'c>>,
    parameters: Parameters,
    workspace: &'c mut Workspace,
) -> Result<Sensor<'c>, SensorError> {
    let sensor = Sensor::new(catalogue, parameters, workspace)?;
    match calibration {
        Some(calibration) => sensor.calibrated(calibration),
        None => Ok(sensor),
    }
}

/// Bytes of the calibration that a camera file names, checked.
///
/// # Errors
/// When the file cannot be read, or is no calibration of this version, or is damaged.
pub fn calibration_file(path: &Path) -> Result<Vec<u8>, HostError> {
    let bytes =
        std::fs::read(path).map_err(|error| HostError::system(path, "read", &error, "check the path"))?;
    let what = match Calibration::open(&bytes) {
        Ok(_) => return Ok(bytes),
        Err(CalibrationError::NotACalibration) => "offset 0: does not begin with SXCC".to_owned(),
        Err(CalibrationError::Version(version)) => format!("offset 4: version {version} is not read"),
        Err(CalibrationError::Length) => "offset 12: another length than the file's".to_owned(),
        Err(CalibrationError::Checksum) => "offset 8: the checksum does not match".to_owned(),
        Err(CalibrationError::Structure) => "its numbers contradict each other".to_owned(),
    };
    Err(HostError::input(path, None, what, format!("make it again with `{} calibrate`", program())))
}

/// Width and height of the field, degrees.
pub fn field_deg(camera: &Camera) -> [f64; 2] {
    let parameters = camera.parameters();
    [parameters.width_px, parameters.height_px].map(|side| {
        let half = f64::from(side) / 2.0 / f64::from(parameters.focal_length_px);
        let half_rad = match parameters.projection {
            camera::Projection::Rectilinear => half.atan(),
            camera::Projection::Equiangular => half,
        };
        2.0 * half_rad.to_degrees()
    })
}

/// How rich a catalogue should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Every star that may be among the centroids: nothing is known of their brightness.
    Full,
    /// The brightest stars of every field only: the centroids are ranked by brightness.
    Brightest,
}

/// Stars in a field of [`Density::Brightest`]: the brightest spots of a picture are most of them, and few
/// pairs make few false hypotheses.
const BRIGHTEST_PER_FIELD: f64 = 14.0;

/// Bytes of the catalogue that serves a camera.
///
/// # Errors
/// When no catalogue serves such a field.
pub fn catalogue_bytes(camera: &Camera, density: Density) -> Result<Cow<'static, [u8]>, HostError> {
    let [width_deg, height_deg] = field_deg(camera);
    if is_like_reference([width_deg, height_deg]) {
        return Ok(Cow::Borrowed(catalog_gen::REFERENCE));
    }
    let refuse = |error: catalog_gen::BuildError| {
        HostError::usage(error.to_string(), "give --catalog or another camera")
    };
    let stars = catalog_gen::source::stars();
    let parameters =
        catalog_gen::parameters::for_field_from(&stars, width_deg, height_deg, DEFAULT_EPOCH_YEAR);
    let parameters = match density {
        Density::Full => parameters.map_err(refuse)?,
        Density::Brightest => parameters.map_err(refuse)?.with_stars_per_field(BRIGHTEST_PER_FIELD),
    };
    catalog_gen::build(&stars, &parameters).map(Cow::Owned).map_err(refuse)
}

/// Catalogues built for flight in this program, by the field in thousandths of a degree; they serve to its
/// end.
static FLOWN: Mutex<BTreeMap<[u32; 2], &'static [u8]>> = Mutex::new(BTreeMap::new());

/// The catalogue that a camera flies with: the embedded one where it was made for such a field, else what
/// `catalog-gen build --for-flight` gives for it. `path` is for the message.
///
/// # Errors
/// When the longer side of the field is not 8 to 40 deg.
pub fn flight_catalogue(camera: &Camera, path: &Path) -> Result<Catalogue<'static>, HostError> {
    let field_deg = field_deg(camera);
    if is_like_reference(field_deg) {
        return open(catalog_gen::REFERENCE);
    }
    let key = field_deg.map(|side| (side * 1e3).round() as u32);
    let mut flown = FLOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bytes) = flown.get(&key) {
        return open(bytes);
    }
    let stars = catalog_gen::source::stars();
    let built = catalog_gen::build_for_flight(&stars, field_deg, DEFAULT_EPOCH_YEAR);
    let bytes = built.map_err(|error| {
        let error = error.to_string();
        let (what, to_do) = error.split_once("; ").unwrap_or((&error, "give another camera"));
        HostError::input(path, None, what, to_do)
    })?;
    open(flown.entry(key).or_insert(Vec::leak(bytes)))
}

/// Whether the embedded catalogue serves a field.
fn is_like_reference([width_deg, height_deg]: [f64; 2]) -> bool {
    let [reference_deg, _] = catalog_gen::parameters::REFERENCE_FIELD_DEG;
    (width_deg.max(height_deg) / reference_deg - 1.0).abs() <= FIELD_TOLERANCE
}

/// Bytes of the catalogue a user named, checked.
///
/// # Errors
/// When the file cannot be read, or is no catalogue of this version, or is damaged.
pub fn catalogue_file(path: &Path) -> Result<Cow<'static, [u8]>, HostError> {
    let bytes =
        std::fs::read(path).map_err(|error| HostError::system(path, "read", &error, "check the path"))?;
    if let Err(error) = Catalogue::open(&bytes) {
        let explained = error.to_string();
        let (what, to_do) =
            explained.split_once("; ").unwrap_or((&explained, "build it again with catalog-gen"));
        return Err(HostError::input(path, None, what, to_do));
    }
    Ok(Cow::Owned(bytes))
}

/// Opens bytes that [`catalogue_bytes`] or [`catalogue_file`] gave.
///
/// # Errors
/// Never for such bytes; damaged ones are refused here too.
pub fn open(bytes: &[u8]) -> Result<Catalogue<'_>, HostError> {
    Catalogue::open(bytes).map_err(|error| HostError::usage(error.to_string(), "build it again"))
}
