//! The file of a detector's defects ([`fsw_core::image::defects`]): written, read, and put before a picture.
//!
//! A picture is mended as the flight code mends windows ([`fsw_core::image::bad_pixels`]).

use crate::error::HostError;
use crate::formats::picture::{EXPOSURE_US, Picture};
use crate::words::program;
use fsw_core::checksum::crc32;
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::defects::{CRC_FROM, Defects, DefectsError, HEADER_BYTES, MAGIC, VERSION};
use fsw_hal::{Detector, DetectorGeometry};
use std::path::{Path, PathBuf};

/// Bytes of a table: bad pixels (column, row) sorted by row, then column, and offsets of columns from the
/// left; at most 65,535 of either.
pub fn table([width, height]: [u16; 2], bad: &[[u16; 2]], offsets: &[(u16, i16)]) -> Vec<u8> {
    let mut words = vec![width, height, offsets.len() as u16, bad.len() as u16, 0, 0];
    words.extend((0..=height).map(|row| bad.partition_point(|[_, y]| *y < row) as u16));
    words.extend(bad.iter().map(|[x, _]| *x));
    words.extend(offsets.iter().flat_map(|(x, offset)| [*x, offset.cast_unsigned()]));
    let total = CRC_FROM + 4 + 2 * words.len();
    let mut protected = (total as u32).to_le_bytes().to_vec();
    protected.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((HEADER_BYTES as u16).to_le_bytes());
    bytes.extend(crc32(&protected).to_le_bytes());
    bytes.extend(protected);
    bytes
}

/// A table that was read and checked.
pub struct DefectsFile {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl DefectsFile {
    /// Reads a table.
    ///
    /// # Errors
    /// When the file cannot be read, or is no such table of this version, or is damaged.
    pub fn load(path: &Path) -> Result<Self, HostError> {
        let bytes =
            std::fs::read(path).map_err(|error| HostError::system(path, "read", &error, "check the path"))?;
        let what = match Defects::open(&bytes) {
            Ok(_) => return Ok(Self { path: path.to_path_buf(), bytes }),
            Err(DefectsError::NotDefects) => "offset 0: does not begin with SXDF".to_owned(),
            Err(DefectsError::Version(version)) => format!("offset 4: version {version} is not read"),
            Err(DefectsError::Length) => "offset 12: another length than the file's".to_owned(),
            Err(DefectsError::Checksum) => "offset 8: the checksum does not match".to_owned(),
            Err(DefectsError::Unsorted) => "its pixels or columns are out of order".to_owned(),
            Err(DefectsError::Outside) => "a pixel or column lies outside its detector".to_owned(),
            Err(DefectsError::Structure | DefectsError::OtherDetector) => {
                "its numbers contradict each other".to_owned()
            }
        };
        Err(HostError::input(path, None, what, format!("make it again with `{} defects`", program())))
    }

    /// A picture without these defects; `name` is the picture's.
    ///
    /// # Errors
    /// When the table is of a detector of another size.
    pub fn mend(&self, name: &Path, mut picture: Picture) -> Result<Picture, HostError> {
        let geometry = picture.geometry();
        let mut pixels = vec![0; geometry.whole().area()];
        let fault = |error| HostError::detector(name, error);
        // Checked when it was read.
        let table = Defects::open(&self.bytes).map_err(|_| self.other(name, geometry))?;
        let mut mended =
            BadPixelDetector::new(&mut picture, table).map_err(|_| self.other(name, geometry))?;
        mended.expose(EXPOSURE_US).and_then(|_| mended.read(geometry.whole(), &mut pixels)).map_err(fault)?;
        Ok(Picture::from_pixels(geometry, pixels).unwrap_or(picture))
    }

    fn other(&self, name: &Path, geometry: DetectorGeometry) -> HostError {
        let [w, h] = Defects::open(&self.bytes).map_or([0, 0], |table| table.size_px());
        let DetectorGeometry { width_px, height_px, .. } = geometry;
        let table = self.path.display();
        let what = format!("the picture has {width_px} x {height_px} px, the defects {table} {w} x {h}");
        HostError::input(name, None, what, "give the table of this picture's detector")
    }
}

/// Reads a picture, mended where there is a table.
///
/// # Errors
/// When it cannot be read, or has not the table's size.
pub fn picture(name: &Path, defects: Option<&DefectsFile>) -> Result<Picture, HostError> {
    let picture = Picture::load(name)?;
    match defects {
        Some(defects) => defects.mend(name, picture),
        None => Ok(picture),
    }
}

#[cfg(test)]
mod tests;
