//! Artificial calibrations for the tests, written from the layout's description: Gaussian stars, any
//! corrections.

use super::{POINTS_PER_PX, PROFILE_REACH_PX, RADIAL_POINTS, TANGENTIAL_POINTS};
use crate::checksum::crc32;
use std::vec::Vec;

/// Optical centre of all samples, px: that of the thesis's example.
pub const CENTRE_PX: [f32; 2] = [620.0, 512.0];
/// What a correction of 1 is worth, px.
pub const PX_PER_ENTRY: f32 = 0.0005;
/// Electrons of a scaled count.
pub const ELECTRONS_PER_COUNT: f32 = 2.5;
/// Displacement of stars a magnitude of B-V redder than 0.5, px.
pub const COLOUR_PX: f32 = -0.03;
/// What the corrections are said to leave, px.
pub const RESIDUAL_PX: f32 = 0.002;

/// Writes the checksum again after a change.
pub fn seal(bytes: &mut [u8]) {
    let crc = crc32(&bytes[12..]);
    bytes[8..12].copy_from_slice(&crc.to_le_bytes());
}

/// Share of a Gaussian star in a pixel whose middle is (x, y) from it.
pub fn light(sigma_px: f64, x: f64, y: f64) -> f64 {
    let share = |at: f64| {
        let edge = |at: f64| libm::erf(at / (sigma_px * core::f64::consts::SQRT_2));
        0.5 * (edge(at + 0.5) - edge(at - 0.5))
    };
    share(x) * share(y)
}

/// How the tables lie.
#[derive(Clone, Copy)]
pub struct Tables {
    pub columns: u16,
    pub rows: u16,
    pub step_px: u16,
    pub first_px: Option<[i16; 2]>,
}

/// A calibration for a detector of 1280 x 1024 px with one Gaussian profile; `correction` gives the entries
/// of a table (column, row) at a phase (column, row). Without a first table's place the tables are those of
/// one quadrant.
pub fn bytes(sigma_px: f64, tables: Tables, correction: impl Fn([u16; 2], [usize; 2]) -> [i8; 2]) -> Vec<u8> {
    let mut bytes = b"SXCC\x02\x00\x40\x00".to_vec();
    bytes.extend([0; 8]);
    let short = |bytes: &mut Vec<u8>, value: u16| bytes.extend(value.to_le_bytes());
    short(&mut bytes, 1280);
    short(&mut bytes, 1024);
    CENTRE_PX.iter().for_each(|px| bytes.extend(px.to_le_bytes()));
    [1, 64, tables.columns, tables.rows, tables.step_px].iter().for_each(|value| short(&mut bytes, *value));
    short(&mut bytes, u16::from(tables.first_px.is_none()));
    tables.first_px.unwrap_or([0, 0]).iter().for_each(|px| bytes.extend(px.to_le_bytes()));
    [PX_PER_ENTRY, ELECTRONS_PER_COUNT, RESIDUAL_PX]
        .iter()
        .for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes.extend(0xDEAD_BEEFu32.to_le_bytes());
    bytes.extend(0.5f32.to_le_bytes());
    let scale = 1.0f64 / 32_768.0;
    bytes.extend((scale as f32).to_le_bytes());
    bytes.extend(COLOUR_PX.to_le_bytes());
    for v in 0..TANGENTIAL_POINTS {
        for u in 0..RADIAL_POINTS {
            // A spline through values: less an eighth of their second differences, to the fourth order of the
            // step.
            let at = |du: f64, dv: f64| {
                let per_px = POINTS_PER_PX as f64;
                light(sigma_px, (u as f64 + du) / per_px - PROFILE_REACH_PX as f64, (v as f64 + dv) / per_px)
            };
            let bend = at(1.0, 0.0) + at(-1.0, 0.0) + at(0.0, 1.0) + at(0.0, -1.0) - 4.0 * at(0.0, 0.0);
            let point = (at(0.0, 0.0) - bend / 8.0) / scale;
            bytes.extend((point.round() as i16).to_le_bytes());
        }
    }
    for (row, column) in (0..tables.rows).flat_map(|row| (0..tables.columns).map(move |column| (row, column)))
    {
        for (y, x) in (0..10).flat_map(|y| (0..10).map(move |x| (y, x))) {
            bytes.extend(correction([column, row], [x, y]).map(|entry| entry as u8));
        }
    }
    let length = bytes.len() as u32;
    bytes[12..16].copy_from_slice(&length.to_le_bytes());
    seal(&mut bytes);
    bytes
}

/// A Gaussian star, nothing to correct.
pub fn gaussian(sigma_px: f64) -> Vec<u8> {
    bytes(sigma_px, Tables { columns: 2, rows: 2, step_px: 1000, first_px: None }, |_, _| [0, 0])
}
