//! Where profiles and tables of a calibration lie, and its bytes.

use super::corrections::Nodes;
use super::{HALF_WINDOW_PX, PROFILE_STEP_PX, TABLE_STEP_PX};
use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use fsw_core::checksum::crc32;
use fsw_core::image::FULL_SCALE;
use fsw_core::image::calibration::{CRC_FROM, HEADER_BYTES, MAGIC, VERSION};

/// Greatest correction in the tables, px.
const LARGEST_PX: f64 = 0.4;
/// Charge of a full pixel that a detector may have, electrons.
const FULL_WELL_E: std::ops::RangeInclusive<f64> = 100.0..=1e8;
/// Where the electrons of a scaled count stand.
const ELECTRONS_OFFSET: usize = 48;
/// Where the checksum stands.
const CRC_OFFSET: usize = 8;

/// A star's profile.
#[derive(Debug, Clone, PartialEq)]
pub struct StarProfile {
    /// Coefficients of its spline, row by row.
    pub points: Vec<f64>,
    /// How far a star is displaced outwards for each magnitude of B-V, px.
    pub colour_px: f64,
}

/// What a calibration holds, beside its layout.
#[derive(Debug, Clone)]
pub struct Content<'a> {
    /// Profiles, from the optical centre outwards.
    pub profiles: &'a [StarProfile],
    /// Tables, node by node, px.
    pub tables: &'a [Vec<[f64; 2]>],
    /// What they leave of a centroid's error without noise, px an axis.
    pub residual_px: f64,
    /// Colour of the stars it was made from, B-V.
    pub colour: f64,
}

/// Detector and places of a calibration.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    size_px: [u16; 2],
    /// The optical centre, px.
    pub centre_px: [f64; 2],
    electrons_per_count: f64,
    camera_crc: u32,
}

impl Layout {
    /// Of a camera whose pixels hold so many electrons at full scale.
    ///
    /// # Errors
    /// Where the optical centre lies off the detector, or no detector holds so few or many electrons.
    pub fn new(camera: &CameraFile, full_well_e: f64) -> Result<Self, HostError> {
        if !FULL_WELL_E.contains(&full_well_e) {
            let what = format!("a full well of {full_well_e} electrons is out of range");
            return Err(HostError::usage(what, "give 100 to 1e8"));
        }
        let size_px = [camera.width_px, camera.height_px];
        let margin = 2.0 * f64::from(HALF_WINDOW_PX);
        let inside = |at: f64, side: u16| (margin..=f64::from(side) - margin).contains(&at);
        let centre_px = camera.optical_centre_px;
        if !inside(centre_px[0], size_px[0]) || !inside(centre_px[1], size_px[1]) {
            let what = "a lens whose optical centre lies off the detector is not calibrated";
            return Err(HostError::usage(what, "give another camera"));
        }
        let electrons_per_count = full_well_e / f64::from(FULL_SCALE);
        Ok(Self { size_px, centre_px, electrons_per_count, camera_crc: crc32(camera.to_toml().as_bytes()) })
    }

    /// Distances of the profiles from the optical centre, px.
    pub fn radii_px(&self) -> Vec<f64> {
        let far = |axis: usize| {
            self.centre_px[axis].max(f64::from(self.size_px[axis]) - 1.0 - self.centre_px[axis])
        };
        let last = (libm::hypot(far(0), far(1)) / f64::from(PROFILE_STEP_PX)).round() as u16;
        (0..=last).map(|index| f64::from(index) * f64::from(PROFILE_STEP_PX)).collect()
    }

    /// Optical coordinate of the first table along an axis, px, and their number.
    fn places(&self, axis: usize) -> (i16, u16) {
        let (step, centre) = (f64::from(TABLE_STEP_PX), self.centre_px[axis]);
        // Stars are seen from there on; from it to the edge the corrections go straight on.
        let before = ((centre - 1.5 * f64::from(HALF_WINDOW_PX)) / step).floor();
        let after = ((f64::from(self.size_px[axis]) - 1.0 - centre) / step).ceil().max(1.0);
        ((-before * step) as i16, (before + after) as u16 + 1)
    }

    /// The tables' nodes.
    pub fn nodes(&self) -> Nodes {
        let places = [0, 1].map(|axis| self.places(axis));
        Nodes {
            first_px: [0, 1].map(|axis| self.centre_px[axis] + f64::from(places[axis].0)),
            step_px: f64::from(TABLE_STEP_PX),
            count: places.map(|(_, count)| usize::from(count)),
        }
    }

    /// Bytes of the file.
    pub fn bytes(&self, content: &Content) -> Vec<u8> {
        let ((first_x, columns), (first_y, rows)) = (self.places(0), self.places(1));
        let all = content.tables.iter().flatten().flatten();
        let largest = all.map(|px| px.abs()).fold(0.0, f64::max).min(LARGEST_PX);
        let px_per_entry = (largest / 127.0) as f32;
        let mut body = Vec::new();
        let short = |body: &mut Vec<u8>, value: u16| body.extend(value.to_le_bytes());
        let real = |body: &mut Vec<u8>, value: f64| body.extend((value as f32).to_le_bytes());
        body.extend([0; 4]);
        self.size_px.into_iter().for_each(|side| short(&mut body, side));
        self.centre_px.into_iter().for_each(|at| real(&mut body, at));
        for value in [content.profiles.len() as u16, PROFILE_STEP_PX, columns, rows, TABLE_STEP_PX, 0] {
            short(&mut body, value);
        }
        body.extend(first_x.to_le_bytes());
        body.extend(first_y.to_le_bytes());
        body.extend(px_per_entry.to_le_bytes());
        real(&mut body, self.electrons_per_count);
        real(&mut body, content.residual_px);
        body.extend(self.camera_crc.to_le_bytes());
        real(&mut body, content.colour);
        for StarProfile { points, colour_px } in content.profiles {
            let scale = points.iter().map(|point| point.abs()).fold(1e-9, f64::max) / f64::from(i16::MAX);
            real(&mut body, scale);
            real(&mut body, *colour_px);
            body.extend(points.iter().flat_map(|point| ((point / scale).round() as i16).to_le_bytes()));
        }
        for [dx, dy] in content.tables.iter().flatten() {
            // Without any correction the scale is 0 and so are all entries.
            let entry = |px: &f64| (px / f64::from(px_per_entry).max(1e-9)).round().clamp(-127.0, 127.0);
            body.extend([entry(dx) as i8 as u8, entry(dy) as i8 as u8]);
        }
        let length = (CRC_FROM + body.len()) as u32;
        body[..4].copy_from_slice(&length.to_le_bytes());
        let mut bytes = Vec::new();
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((HEADER_BYTES as u16).to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(body);
        sealed(bytes)
    }
}

/// The file with the checksum of what it holds.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let crc = crc32(&bytes[CRC_FROM..]);
    bytes[CRC_OFFSET..CRC_FROM].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// A calibration whose electrons of a count are `factor` times as many.
pub fn with_gain(bytes: &[u8], factor: f64) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if let Some(field) = bytes.get_mut(ELECTRONS_OFFSET..ELECTRONS_OFFSET + 4) {
        let told = f32::from_le_bytes([field[0], field[1], field[2], field[3]]);
        field.copy_from_slice(&((f64::from(told) * factor) as f32).to_le_bytes());
    }
    sealed(bytes)
}
