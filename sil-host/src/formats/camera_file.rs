//! Camera files: the detector and the optics in TOML.
//!
//! In: the text of a camera file. Out: [`CameraFile`], every value checked. A fault names the file, the line
//! and the key. Lengths are pixels; the optical centre counts from the centre of the first pixel read, x
//! right and y down. The first five keys (`width_px`, `height_px`, `bits`, `focal_length_px`,
//! `optical_centre_px`) must be there, the rest has defaults: rectilinear, no distortion, no correction
//! table.

use super::{SIDE_MAX_PX, SIDE_MIN_PX};
use crate::error::HostError;
use serde::Deserialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The reference camera, f = 3000 px on 1280 x 1024 px.
pub const REFERENCE: &str = include_str!("../../cameras/reference.toml");
/// What `sil-host calibrate` found of it in the laboratory.
pub const REFERENCE_CALIBRATED: &str = include_str!("../../cameras/reference-calibrated.toml");
/// The MITA flight camera, 386 x 290 px.
pub const MITA: &str = include_str!("../../cameras/mita.toml");
/// The field-experiment camera, f = 3432 px on 1280 x 1024 px.
pub const PCS2112: &str = include_str!("../../cameras/pcs2112.toml");

/// What the command line's help says of a camera file; the table is one.
pub const HELP: &str = "\
Camera file (TOML). The first five keys must be there, the others have the values shown:

[detector]
width_px = 1280                       # columns and rows, 32 to 65535
height_px = 1024
bits = 10                             # full scale is 2^bits - 1; 1 to 16
[optics]
focal_length_px = 3000.0              # focal length over the width of a pixel
optical_centre_px = [639.5, 511.5]    # centre of the first pixel: [0, 0]; x right, y down
projection = \"rectilinear\"            # or \"equiangular\": distance from the centre = f times the angle
distortion = { k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0 }    # Brown's, order and signs of OpenCV
corner_loss = 0.15                    # share of the light that the mounts take in the farthest corner
mirrored = false                      # whether a mirror turns the stars' image over left to right
# correction_table = \"camera.corr\"    # star profiles and corrections of centroids, beside this file:
#                                       made by `calibrate`, flown by `run`; no other command reads it";

const FOCAL_LENGTH_PX: (f64, f64) = (10.0, 1e7);
const DISTORTION: (f64, f64) = (-100.0, 100.0);
const CORNER_LOSSES: (f64, f64) = (0.0, 0.9);
/// Share of the light that the mounts of the reference lens take in the farthest corner.
pub const CORNER_LOSS: f64 = 0.15;
const FOV_MAX_DEG: f64 = 150.0;

/// How a direction becomes a place on the detector, before distortion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// Pinhole: x = f X/Z.
    #[default]
    Rectilinear,
    /// Scan angle times f, as on the grids of geostationary imagers.
    Equiangular,
}

/// Brown's distortion of the normalised coordinates, OpenCV's convention and order of signs. No unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// Radial, second power.
    pub k1: f64,
    /// Radial, fourth power.
    pub k2: f64,
    /// Radial, sixth power.
    pub k3: f64,
    /// Tangential, first.
    pub p1: f64,
    /// Tangential, second.
    pub p2: f64,
}

/// A camera as its file describes it, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraFile {
    /// Columns of the detector, px.
    pub width_px: u16,
    /// Rows of the detector, px.
    pub height_px: u16,
    /// Resolution of a raw value: full scale is `2^bits - 1`.
    pub bits: u8,
    /// Focal length, px.
    pub focal_length_px: f64,
    /// Where the optical axis meets the detector, px.
    pub optical_centre_px: [f64; 2],
    /// The projection.
    pub projection: Projection,
    /// The distortion.
    pub distortion: Distortion,
    /// Share of the light that the lens's mounts take in the farthest corner.
    pub corner_loss: f64,
    /// Whether the star path is seen in a mirror, which turns its image over left to right.
    pub mirrored: bool,
    /// Centroid correction table, relative to the camera file's folder resolved.
    pub correction_table: Option<PathBuf>,
}

// The file as written: numbers wide enough that a value out of range is our finding, with our words.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    detector: RawDetector,
    optics: RawOptics,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDetector {
    width_px: Spanned<i64>,
    height_px: Spanned<i64>,
    bits: Spanned<i64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawOptics {
    focal_length_px: Spanned<f64>,
    optical_centre_px: Spanned<[f64; 2]>,
    #[serde(default)]
    projection: Projection,
    #[serde(default)]
    distortion: RawDistortion,
    corner_loss: Option<Spanned<f64>>,
    #[serde(default)]
    mirrored: bool,
    correction_table: Option<Spanned<String>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawDistortion {
    k1: Option<Spanned<f64>>,
    k2: Option<Spanned<f64>>,
    k3: Option<Spanned<f64>>,
    p1: Option<Spanned<f64>>,
    p2: Option<Spanned<f64>>,
}

impl CameraFile {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// The first fault found, with line and key.
    pub fn load(path: &Path) -> Result<Self, HostError> {
        let text = std::fs::read_to_string(path).map_err(|error| {
            HostError::system(path, "read", &error, "give the path of a camera file (TOML text)")
        })?;
        Self::parse(path, &text)
    }

    /// Checks `text`; `path` is for messages and for the folder of the correction table.
    ///
    /// # Errors
    /// The first fault found, with line and key.
    pub fn parse(path: &Path, text: &str) -> Result<Self, HostError> {
        let source = Source { path, text };
        let raw: RawFile = toml::from_str(text).map_err(|error| source.syntax(&error))?;
        let (width_px, height_px) = (
            source.side("detector.width_px", &raw.detector.width_px)?,
            source.side("detector.height_px", &raw.detector.height_px)?,
        );
        let optics = raw.optics;
        let distortion = Distortion {
            k1: source.coefficient("optics.distortion.k1", optics.distortion.k1)?,
            k2: source.coefficient("optics.distortion.k2", optics.distortion.k2)?,
            k3: source.coefficient("optics.distortion.k3", optics.distortion.k3)?,
            p1: source.coefficient("optics.distortion.p1", optics.distortion.p1)?,
            p2: source.coefficient("optics.distortion.p2", optics.distortion.p2)?,
        };
        Ok(Self {
            width_px,
            height_px,
            bits: source.bits(&raw.detector.bits)?,
            focal_length_px: source.within(
                "optics.focal_length_px",
                optics.focal_length_px.span(),
                *optics.focal_length_px.get_ref(),
                FOCAL_LENGTH_PX,
            )?,
            optical_centre_px: source.centre(&optics.optical_centre_px, width_px, height_px)?,
            projection: optics.projection,
            distortion,
            corner_loss: source.or_default(
                "optics.corner_loss",
                optics.corner_loss,
                (CORNER_LOSS, CORNER_LOSSES),
            )?,
            mirrored: optics.mirrored,
            correction_table: source.table(optics.correction_table)?,
        })
    }

    /// The reference camera.
    pub fn reference() -> Self {
        Self::embedded("cameras/reference.toml", REFERENCE)
    }

    /// The reference camera as it was calibrated.
    pub fn reference_calibrated() -> Self {
        Self::embedded("cameras/reference-calibrated.toml", REFERENCE_CALIBRATED)
    }

    /// An undistorted camera whose `width_px` columns span `fov_deg` degrees: f = (w/2) / tan(fov/2), the
    /// optical centre in the middle.
    ///
    /// # Errors
    /// When a value is out of range; the message then names no file.
    pub fn from_fov(width_px: u16, height_px: u16, bits: u8, fov_deg: f64) -> Result<Self, HostError> {
        if !(fov_deg > 0.0 && fov_deg <= FOV_MAX_DEG) {
            return Err(HostError::usage(
                format!("--fov-deg: {fov_deg} deg is no horizontal field of view"),
                format!("give a value above 0 and up to {FOV_MAX_DEG} deg"),
            ));
        }
        let focal_length_px = 0.5 * f64::from(width_px) / (0.5 * fov_deg.to_radians()).tan();
        if !(FOCAL_LENGTH_PX.0..=FOCAL_LENGTH_PX.1).contains(&focal_length_px) {
            return Err(HostError::usage(
                format!(
                    "--fov-deg: {fov_deg} deg over {width_px} px gives a focal length of {focal_length_px:.3} px"
                ),
                format!(
                    "give a field whose focal length is {} to {} px",
                    FOCAL_LENGTH_PX.0, FOCAL_LENGTH_PX.1
                ),
            ));
        }
        Ok(Self::undistorted(fsw_hal::DetectorGeometry { width_px, height_px, bits }, focal_length_px))
    }

    /// A rectilinear camera without distortion, the optical centre in the middle.
    pub fn undistorted(geometry: fsw_hal::DetectorGeometry, focal_length_px: f64) -> Self {
        let fsw_hal::DetectorGeometry { width_px, height_px, bits } = geometry;
        Self {
            width_px,
            height_px,
            bits,
            focal_length_px,
            optical_centre_px: [width_px, height_px].map(|side| (f64::from(side) - 1.0) / 2.0),
            projection: Projection::Rectilinear,
            distortion: Distortion::default(),
            corner_loss: CORNER_LOSS,
            mirrored: false,
            correction_table: None,
        }
    }

    /// The detector's size and resolution.
    pub fn geometry(&self) -> fsw_hal::DetectorGeometry {
        fsw_hal::DetectorGeometry { width_px: self.width_px, height_px: self.height_px, bits: self.bits }
    }

    /// The camera of a detector read in blocks of `side_px` by `side_px`. The centre of its first pixel is
    /// the first block's.
    pub fn binned(&self, side_px: u16) -> Self {
        let side = f64::from(side_px);
        Self {
            width_px: self.width_px / side_px.max(1),
            height_px: self.height_px / side_px.max(1),
            bits: 16,
            focal_length_px: self.focal_length_px / side,
            optical_centre_px: self.optical_centre_px.map(|at| (at - 0.5 * (side - 1.0)) / side),
            ..self.clone()
        }
    }

    /// The text of a camera file that says what this one does.
    pub fn to_toml(&self) -> String {
        let Distortion { k1, k2, k3, p1, p2 } = self.distortion;
        let [x, y] = self.optical_centre_px;
        let projection = match self.projection {
            Projection::Rectilinear => "rectilinear",
            Projection::Equiangular => "equiangular",
        };
        let table = self.correction_table.as_ref().map_or_else(String::new, |path| {
            format!("correction_table = {}\n", toml::Value::String(path.display().to_string()))
        });
        format!(
            "[detector]\nwidth_px = {}\nheight_px = {}\nbits = {}\n\n[optics]\nfocal_length_px = {:?}\n\
             optical_centre_px = [{x:?}, {y:?}]\nprojection = \"{projection}\"\n\
             distortion = {{ k1 = {k1:?}, k2 = {k2:?}, k3 = {k3:?}, p1 = {p1:?}, p2 = {p2:?} }}\ncorner_loss = {:?}\nmirrored = {}\n{table}",
            self.width_px, self.height_px, self.bits, self.focal_length_px, self.corner_loss, self.mirrored
        )
    }

    fn embedded(name: &str, text: &str) -> Self {
        // The embedded files are part of the program and every one is read by a test.
        Self::parse(Path::new(name), text).expect("embedded camera file")
    }
}

/// The text being read, for turning places into line numbers and keys.
struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn error(&self, key: Option<&str>, at: usize, what: String, to_do: &str) -> HostError {
        let before = self.text.get(..at).unwrap_or(self.text);
        let what = key.map_or_else(|| what.clone(), |key| format!("{key}: {what}"));
        HostError::input(self.path, Some(before.matches('\n').count() + 1), what, to_do)
    }

    /// A fault the TOML reader or the structure found; it knows a place but not always the key.
    fn syntax(&self, error: &toml::de::Error) -> HostError {
        let message = error.message().to_string();
        let at = error.span().map_or(0, |span| span.start);
        let key = self.key_before(at);
        let to_do = if message.contains("missing field") {
            "add it; [detector] needs width_px, height_px, bits and [optics] focal_length_px, optical_centre_px"
        } else if message.contains("unknown field") {
            "correct or remove it"
        } else {
            "correct the line"
        };
        // Messages that quote the key themselves need no second one before them.
        let key = key.filter(|_| !message.contains("field `"));
        self.error(key.as_deref(), at, message, to_do)
    }

    /// The key of the value at byte `at`: the word left of the last `=` on its line, or on the nearest line
    /// above that has one (a list may go over several lines).
    fn key_before(&self, at: usize) -> Option<String> {
        let before = self.text.get(..at)?;
        for line in before.lines().rev().take(8) {
            let code = line.split('#').next().unwrap_or("");
            if let Some((left, _)) = code.rsplit_once('=') {
                let word = left.trim_end().rsplit([' ', '{', ',', '\t']).next()?.trim();
                return (!word.is_empty()).then(|| word.to_string());
            }
            if code.trim_start().starts_with("[") && code.trim_end().ends_with(']') {
                return None;
            }
        }
        None
    }

    fn side(&self, key: &str, value: &Spanned<i64>) -> Result<u16, HostError> {
        let number = *value.get_ref();
        if !(i64::from(SIDE_MIN_PX)..=i64::from(SIDE_MAX_PX)).contains(&number) {
            let what = format!("{number} px is out of range");
            let to_do = format!("use {SIDE_MIN_PX} to {SIDE_MAX_PX} px");
            return Err(self.error(Some(key), value.span().start, what, &to_do));
        }
        Ok(number as u16)
    }

    fn bits(&self, value: &Spanned<i64>) -> Result<u8, HostError> {
        let number = *value.get_ref();
        if !(1..=16).contains(&number) {
            let what = format!("{number} bits are out of range");
            return Err(self.error(Some("detector.bits"), value.span().start, what, "use 1 to 16"));
        }
        Ok(number as u8)
    }

    fn within(
        &self,
        key: &str,
        span: Range<usize>,
        value: f64,
        (low, high): (f64, f64),
    ) -> Result<f64, HostError> {
        // Written so that NaN is refused as well.
        if !(value >= low && value <= high) {
            let what = format!("{value} is out of range");
            return Err(self.error(Some(key), span.start, what, &format!("use {low} to {high}")));
        }
        Ok(value)
    }

    fn coefficient(&self, key: &str, value: Option<Spanned<f64>>) -> Result<f64, HostError> {
        self.or_default(key, value, (0.0, DISTORTION))
    }

    fn or_default(
        &self,
        key: &str,
        value: Option<Spanned<f64>>,
        (default, range): (f64, (f64, f64)),
    ) -> Result<f64, HostError> {
        value.map_or(Ok(default), |v| self.within(key, v.span(), *v.get_ref(), range))
    }

    /// The axis may miss the detector (an oblique view), but not by more than its size.
    fn centre(&self, value: &Spanned<[f64; 2]>, width: u16, height: u16) -> Result<[f64; 2], HostError> {
        let key = "optics.optical_centre_px";
        let [x, y] = *value.get_ref();
        let (width, height) = (f64::from(width), f64::from(height));
        let x = self.within(key, value.span(), x, (-width, 2.0 * width))?;
        let y = self.within(key, value.span(), y, (-height, 2.0 * height))?;
        Ok([x, y])
    }

    fn table(&self, value: Option<Spanned<String>>) -> Result<Option<PathBuf>, HostError> {
        let Some(value) = value else { return Ok(None) };
        if value.get_ref().is_empty() {
            let key = Some("optics.correction_table");
            return Err(self.error(
                key,
                value.span().start,
                "no file name".into(),
                "name a file or remove the key",
            ));
        }
        Ok(Some(self.path.parent().unwrap_or(Path::new("")).join(value.get_ref())))
    }
}

#[cfg(test)]
mod tests;
