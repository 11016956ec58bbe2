//! Makes what the flight code wants to know of a lens and its pixels: a
//! [calibration](fsw_core::image::calibration).
//!
//! In: a camera, what the optics do to light, a detector. Out: the bytes of the file.
//!
//! Profiles: the world's image of a star on pixels that are sensitive throughout, at distances from the
//! optical centre [`PROFILE_STEP_PX`] apart.
//!
//! Corrections: stars without noise on the detector's own pixels are drawn where the flight code, with these
//! profiles, finds them at each tenth of a pixel (found by `ROUNDS` rounds, the error being a slow function
//! of the place), and what is missing to their true place is the entry. The centroids are those of the flight
//! code itself, the images those of the world's PSF and pixels, read here and drawn as single spots
//! ([`Lens`]), not as a scene.
//!
//! The stars have B-V = [`COLOUR`]; how far others are displaced outwards (lateral colour) is measured at
//! each profile. What is left at other places, phases and colours (B-V from 0 to 1.4) is measured last and,
//! with `UNMODELLED_PX`, written into the file: the part of a centroid's error that is no noise. Where the
//! world's stars have no colours, neither have these.

mod star;

use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::world::detector::pixel::PixelResponse;
use crate::world::noise::{Noise, Stream};
use fsw_core::checksum::crc32;
use fsw_core::image::FULL_SCALE;
use fsw_core::image::calibration::{
    CRC_FROM, Calibration, HEADER_BYTES, MAGIC, PHASES, POINTS_PER_PX, PROFILE_REACH_PX, RADIAL_POINTS,
    TANGENTIAL_POINTS, VERSION,
};
use fsw_hal::Window;
pub use star::{Lens, find, source_crc, window_about};

/// From a profile to the next, px.
pub const PROFILE_STEP_PX: u16 = 64;
/// Colour of the stars, B-V: the mean of those of the catalogue.
pub const COLOUR: f64 = 0.6;
/// What gains that differ by 1 % from pixel to pixel, and stars too faint to be separated within the image,
/// add to the error without noise, px: with it attitudes of flights lie within three of their sigmas as often
/// as they should.
const UNMODELLED_PX: f64 = 0.012;
/// Colours over which the rest is measured.
const COLOURS: [f64; 5] = [0.0, 0.3, 0.6, 1.0, 1.4];
/// Phases at which the displacement by colour is measured.
const COLOUR_PHASES: u32 = 16;
/// Rounds in which a star is brought to where it is measured at a phase.
const ROUNDS: u32 = 2;
/// Rounds in which the coefficients of a spline are found: 0.75^100 is 3e-13.
const SPLINE_ROUNDS: u32 = 100;
/// Half the side of a drawn window, px.
const HALF_WINDOW_PX: u16 = 16;
/// Greatest correction in the tables, px.
const LARGEST_PX: f64 = 0.4;
/// Places at which the rest is measured, for each colour.
const CHECKS: u32 = 400;

/// How the correction tables lie over the detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// From a table to the next, px.
    pub step_px: u16,
    /// Tables of one quadrant, the others being its mirror images; else of the whole detector.
    pub mirrored: bool,
}

impl Grid {
    /// That of the reference camera.
    pub const REFERENCE: Self = Self { step_px: 200, mirrored: false };
}

/// A star's profile, of a displacement by colour not known yet: the spline through the world's light at the
/// points of the grid.
fn profile(lens: &Lens, radius_px: f64) -> Vec<u8> {
    const REACH: i64 = PROFILE_REACH_PX as i64;
    const POINTS: i64 = POINTS_PER_PX as i64;
    let [cx, cy] = lens.centre_px;
    // The star stays where it is to half a pixel: the image changes slowly over the field.
    let base = [(cx + radius_px).round(), cy.round()];
    let half = REACH as u16 + 1;
    let side = 2 * half + 1;
    let window = Window { x: base[0] as u16 - half, y: base[1] as u16 - half, width: side, height: side };
    let mut light = vec![0.0; TANGENTIAL_POINTS * RADIAL_POINTS];
    for (px, py) in (0..POINTS).flat_map(|px| (0..POINTS).map(move |py| (px, py))) {
        let mut image = vec![0.0; window.area()];
        let at = [base[0] + px as f64 / POINTS as f64, base[1] + py as f64 / POINTS as f64];
        lens.draw(PixelResponse::Full, &lens.spot(at, 1.0, COLOUR), window, &mut image);
        for (index, share) in image.iter().enumerate() {
            let from = |pixel: usize, phase: i64| (pixel as i64 - i64::from(half)) * POINTS - phase;
            let (u, v) = (from(index % usize::from(side), px), from(index / usize::from(side), py));
            if u.abs() <= REACH * POINTS && (0..=REACH * POINTS).contains(&v) {
                light[v as usize * RADIAL_POINTS + (u + REACH * POINTS) as usize] = *share;
            }
        }
    }
    let points = spline(&light);
    let scale = points.iter().map(|point| point.abs()).fold(1e-9, f64::max) / f64::from(i16::MAX);
    let mut bytes = (scale as f32).to_le_bytes().to_vec();
    bytes.extend(0f32.to_le_bytes());
    bytes.extend(points.iter().flat_map(|point| ((point / scale).round() as i16).to_le_bytes()));
    bytes
}

/// How far the flight code finds stars displaced outwards for each magnitude of B-V, px: the mean over
/// phases.
fn colour_px(lens: &Lens, calibration: &Calibration, radius_px: f64) -> Option<f64> {
    let CameraFile { width_px, height_px, .. } = lens.camera;
    let corner = [f64::from(width_px) - lens.centre_px[0], f64::from(height_px) - lens.centre_px[1]];
    let outwards = corner.map(|side| side / libm::hypot(corner[0], corner[1]));
    let (mut sum, mut count) = (0.0, 0.0);
    for phase in 0..COLOUR_PHASES {
        let beside = [phase % 4, phase / 4].map(|k| f64::from(k) / 4.0 - 0.5);
        let at = [0, 1].map(|k| lens.centre_px[k] + radius_px * outwards[k] + beside[k]);
        let ends = [COLOURS[0], COLOURS[COLOURS.len() - 1]];
        if let [Some(hot), Some(cool)] = ends.map(|b_v| lens.measured(at, b_v, Some(calibration))) {
            sum += (0..2).map(|k| (cool[k] - hot[k]) * outwards[k]).sum::<f64>() / (ends[1] - ends[0]);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Coefficients of the quadratic B-spline through `values`: `1/8, 6/8, 1/8` of three neighbours along either
/// axis are a value. Each round leaves at most three quarters of what is missing.
fn spline(values: &[f64]) -> Vec<f64> {
    let at = |points: &[f64], row: i64, column: i64| {
        // Even about the first row; nothing beyond the other edges.
        let row = row.unsigned_abs() as usize;
        let inside = row < TANGENTIAL_POINTS && (0..RADIAL_POINTS as i64).contains(&column);
        if inside { points[row * RADIAL_POINTS + column as usize] } else { 0.0 }
    };
    let mut points = values.to_vec();
    for _ in 0..SPLINE_ROUNDS {
        let along: Vec<_> = (0..points.len())
            .map(|index| {
                let (row, column) = ((index / RADIAL_POINTS) as i64, (index % RADIAL_POINTS) as i64);
                let beside = |by: i64| at(&points, row, column + by);
                0.125 * (beside(-1) + beside(1)) + 0.75 * beside(0)
            })
            .collect();
        for (index, point) in points.iter_mut().enumerate() {
            let (row, column) = ((index / RADIAL_POINTS) as i64, (index % RADIAL_POINTS) as i64);
            let beside = |by: i64| at(&along, row + by, column);
            *point += values[index] - 0.125 * (beside(-1) + beside(1)) - 0.75 * beside(0);
        }
    }
    points
}

/// The tables' places along one side: optical coordinate of the first, and their number.
fn places(grid: Grid, centre: f64, side: u16) -> (i16, u16) {
    let step = f64::from(grid.step_px);
    let beyond = (f64::from(side) - 1.0 - centre).max(if grid.mirrored { centre } else { 0.0 });
    // A star must be drawn at the first; from it to the edge the corrections go straight on.
    let before =
        if grid.mirrored { 0.0 } else { ((centre - 1.5 * f64::from(HALF_WINDOW_PX)) / step).floor() };
    let after = (beyond / step).ceil().max(1.0);
    ((-before * step) as i16, (before + after) as u16 + 1)
}

/// One table: corrections at the phases about a place, px. Where the flight code takes a star's shape for
/// none, which it does at few phases, the entry is that of the phase before; `None` where it does so at most.
fn table(lens: &Lens, calibration: &Calibration, optical_px: [f64; 2]) -> Option<Vec<[f64; 2]>> {
    let base = [0, 1].map(|k| (lens.centre_px[k] + optical_px[k]).floor());
    let mut entries = Vec::with_capacity(PHASES * PHASES);
    let (mut last, mut unseen) = ([0.0; 2], 0);
    for (row, column) in (0..PHASES).flat_map(|row| (0..PHASES).map(move |column| (row, column))) {
        let phase = [column, row].map(|step| step as f64 / (PHASES - 1) as f64);
        let goal = [base[0] + phase[0], base[1] + phase[1]];
        let found = (0..ROUNDS).try_fold(goal, |place, _| {
            let seen = lens.measured(place, COLOUR, Some(calibration))?;
            Some([0, 1].map(|k| place[k] + goal[k] - seen[k]))
        });
        match found {
            Some(place) => last = [0, 1].map(|k| place[k] - goal[k]),
            None => unseen += 1,
        }
        entries.push(last);
    }
    (2 * unseen < entries.len()).then_some(entries)
}

/// Bytes of a calibration with these profiles and corrections.
fn file(
    lens: &Lens,
    grid: Grid,
    profiles: &[Vec<u8>],
    tables: &[Vec<[f64; 2]>],
    residual_px: f64,
) -> Vec<u8> {
    let CameraFile { width_px, height_px, .. } = lens.camera;
    let [cx, cy] = lens.centre_px;
    let ((first_x, columns), (first_y, rows)) = (places(grid, cx, width_px), places(grid, cy, height_px));
    let largest = tables.iter().flatten().flatten().map(|px| px.abs()).fold(0.0, f64::max).min(LARGEST_PX);
    let px_per_entry = (largest / 127.0) as f32;
    let mut body = Vec::new();
    let short = |body: &mut Vec<u8>, value: u16| body.extend(value.to_le_bytes());
    let real = |body: &mut Vec<u8>, value: f64| body.extend((value as f32).to_le_bytes());
    body.extend([0; 4]);
    short(&mut body, width_px);
    short(&mut body, height_px);
    real(&mut body, cx);
    real(&mut body, cy);
    short(&mut body, profiles.len() as u16);
    short(&mut body, PROFILE_STEP_PX);
    short(&mut body, columns);
    short(&mut body, rows);
    short(&mut body, grid.step_px);
    short(&mut body, u16::from(grid.mirrored));
    body.extend(first_x.to_le_bytes());
    body.extend(first_y.to_le_bytes());
    body.extend(px_per_entry.to_le_bytes());
    real(&mut body, lens.full_well_e / f64::from(FULL_SCALE));
    real(&mut body, residual_px);
    body.extend(lens.source_crc.to_le_bytes());
    real(&mut body, COLOUR);
    profiles.iter().for_each(|profile| body.extend(profile));
    for [dx, dy] in tables.iter().flatten() {
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
    bytes.extend(crc32(&body).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// Builds the calibration of a lens.
///
/// # Errors
/// Where the flight code does not find the stars.
pub fn build(lens: &Lens, grid: Grid) -> Result<Vec<u8>, HostError> {
    let CameraFile { width_px, height_px, .. } = lens.camera;
    let [cx, cy] = lens.centre_px;
    let far = |centre: f64, side: u16| centre.max(f64::from(side) - 1.0 - centre);
    let radius_px = libm::hypot(far(cx, width_px), far(cy, height_px));
    let last = (radius_px / f64::from(PROFILE_STEP_PX)).round() as u16;
    let radii = || (0..=last).map(|index| f64::from(index) * f64::from(PROFILE_STEP_PX));
    let mut profiles: Vec<_> = radii().map(|radius_px| profile(lens, radius_px)).collect();
    let ((first_x, columns), (first_y, rows)) = (places(grid, cx, width_px), places(grid, cy, height_px));
    let count = usize::from(columns) * usize::from(rows);
    let none = vec![vec![[0.0; 2]; PHASES * PHASES]; count];
    let unseen =
        || HostError::usage("the flight code does not find this lens's stars", "correct the [optics]");
    let uncorrected = file(lens, grid, &profiles, &none, 0.01);
    let open = |bytes| Calibration::open(bytes).map_err(|_| unseen());
    let step = f64::from(grid.step_px);
    let at = |first: i16, index: u16| f64::from(first) + step * f64::from(index);
    let nodes: Vec<_> = (0..rows)
        .flat_map(|row| (0..columns).map(move |column| [at(first_x, column), at(first_y, row)]))
        .collect();
    let calibration = open(&uncorrected)?;
    for (profile, radius_px) in profiles.iter_mut().zip(radii()) {
        let colour_px = colour_px(lens, &calibration, radius_px).ok_or_else(unseen)?;
        profile[4..8].copy_from_slice(&(colour_px as f32).to_le_bytes());
    }
    let tables = in_parallel(&nodes, |node| table(lens, &calibration, *node)).ok_or_else(unseen)?;
    let corrected = file(lens, grid, &profiles, &tables, 0.01);
    let rest = residual_px(lens, &open(&corrected)?).ok_or_else(unseen)?;
    Ok(file(lens, grid, &profiles, &tables, libm::hypot(rest, UNMODELLED_PX)))
}

/// Maps on all processors, in order. Not by rayon: callers hold a lock, and a worker of a pool that waits
/// takes up other work, which may want the same lock.
fn in_parallel<T: Sync, R: Send>(items: &[T], map: impl Fn(&T) -> Option<R> + Sync) -> Option<Vec<R>> {
    let workers = std::thread::available_parallelism().map_or(1, |count| count.get());
    let share = items.len().div_ceil(workers).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> = items
            .chunks(share)
            .map(|part| scope.spawn(|| part.iter().map(&map).collect::<Option<Vec<_>>>()))
            .collect();
        let mut all = Vec::with_capacity(items.len());
        for part in parts {
            // A thread that panicked has said why.
            all.extend(part.join().ok().flatten()?);
        }
        Some(all)
    })
}

/// Root mean square error an axis of stars without noise over places, phases and colours, px.
fn residual_px(lens: &Lens, calibration: &Calibration) -> Option<f64> {
    let noise = Noise::new(1, 0, Stream::Centroid);
    let margin = 2.0 * f64::from(HALF_WINDOW_PX);
    let along = |side: u16, part: f64| margin + (f64::from(side) - 2.0 * margin) * part;
    let places: Vec<_> = (0..CHECKS)
        .map(|k| {
            [
                along(lens.camera.width_px, noise.uniform(k, 0)),
                along(lens.camera.height_px, noise.uniform(k, 1)),
            ]
        })
        .collect();
    let squares = in_parallel(&places, |place| {
        Some(COLOURS.iter().fold((0.0, 0.0), |(sum, count), b_v| {
            match lens.measured(*place, *b_v, Some(calibration)) {
                Some(seen) => {
                    let shift = calibration.colour_shift_px(place.map(|px| px as f32), *b_v as f32);
                    let square = |k: usize| (seen[k] - place[k] - f64::from(shift[k])).powi(2);
                    (sum + square(0) + square(1), count + 2.0)
                }
                None => (sum, count),
            }
        }))
    })?;
    let (sum, count) = squares.iter().fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1));
    (count > 0.0).then(|| (sum / count).sqrt())
}

#[cfg(test)]
mod tests;
