//! The stars of pictures whose attitudes are known: where each should be, and the pixels about it.
//!
//! In: pictures with attitudes, a camera, stars. Out: [`Sight`]s: stars to `FAINTEST_V` that stand alone and
//! within the field.

use super::HALF_WINDOW_PX;
use super::centroid::window_about;
use crate::formats::camera_file::CameraFile;
use crate::formats::picture::Picture;
use crate::world::attitude::{Vector, apply, dot};
use crate::world::lens::optics::Optics;
use crate::world::scene::WorldStar;
use fsw_hal::{Detector, DetectorGeometry, Window};

/// Faintest star that is used.
const FAINTEST_V: f64 = 6.5;
/// Half the side of the pixels about a star, px: the reach of a profile and a line of sky.
pub const HALF: usize = 5;
/// Their side.
pub const SIDE: usize = 2 * HALF + 1;
/// A star within this distance disturbs one that is not so many magnitudes brighter, px and magnitudes.
const APART_PX: f64 = 12.0;
const BRIGHTER: f64 = 5.5;
/// A pixel above this share of full scale may be full.
const FULLEST: f64 = 0.9;

/// A star of a picture.
#[derive(Debug, Clone)]
pub struct Sight {
    /// Number of its picture.
    pub picture: usize,
    /// Hipparcos number.
    pub hip: u32,
    /// Direction, ICRS.
    pub direction: Vector,
    /// Colour index B-V.
    pub b_v: f64,
    /// Where it should be, px.
    pub at_px: [f64; 2],
    /// The pixels about it that were read.
    pub window: Window,
    /// Their values, digital numbers.
    pub pixels: Vec<u16>,
}

impl Sight {
    /// Places from the star of the pixels within [`HALF`] of the middle one, px, with their values.
    pub fn near(&self) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        let Window { x, y, width, .. } = self.window;
        let width = usize::from(width);
        let corner = width / 2 - HALF;
        (0..SIDE).flat_map(move |row| (0..SIDE).map(move |column| (corner + column, corner + row))).map(
            move |(column, row)| {
                let place =
                    [f64::from(x) + column as f64 - self.at_px[0], f64::from(y) + row as f64 - self.at_px[1]];
                (place, f64::from(self.pixels[row * width + column]))
            },
        )
    }
}

/// The stars as the catalogue's source has them, from which places on the detector are expected: not those of
/// the world.
pub fn catalogued(year: f64) -> Vec<WorldStar> {
    let star = |star: catalog_gen::SourceStar| WorldStar {
        hip: star.hip,
        direction: star.direction_at(year),
        v: star.v,
        b_v: star.b_v,
    };
    catalog_gen::source::stars().into_iter().map(star).collect()
}

/// The sights of picture number `index`, taken in this attitude.
pub fn sights(
    (index, picture, attitude): (usize, &Picture, &[Vector; 3]),
    camera: &CameraFile,
    stars: &[WorldStar],
) -> Vec<Sight> {
    let Some(optics) = Optics::new(camera) else { return Vec::new() };
    let cosine = optics.cone_cosine(APART_PX);
    let in_field = |star: &&WorldStar| dot(attitude[2], star.direction) > cosine;
    let mut placed: Vec<([f64; 2], &WorldStar)> = stars
        .iter()
        .filter(in_field)
        .filter_map(|star| Some((optics.project(apply(attitude, star.direction))?, star)))
        .collect();
    placed.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let alone = |number: usize| {
        let ([x, y], star) = placed[number];
        let disturbs = |(at, other): &([f64; 2], &WorldStar)| {
            other.v < star.v + BRIGHTER && libm::hypot(at[0] - x, at[1] - y) < APART_PX
        };
        let near = |(at, _): &&([f64; 2], &WorldStar)| (at[0] - x).abs() < APART_PX;
        !placed[..number].iter().rev().take_while(near).any(disturbs)
            && !placed[number + 1..].iter().take_while(near).any(disturbs)
    };
    (0..placed.len())
        .filter(|number| placed[*number].1.v <= FAINTEST_V && alone(*number))
        .filter_map(|number| {
            let (at_px, star) = placed[number];
            let (window, pixels) = cut(picture, at_px)?;
            let WorldStar { hip, direction, b_v, .. } = *star;
            let sight = Sight { picture: index, hip, direction, b_v, at_px, window, pixels };
            let full = FULLEST * f64::from((1u32 << picture.geometry().bits) - 1);
            let dark_enough = sight.near().all(|(_, value)| value < full);
            dark_enough.then_some(sight)
        })
        .collect()
}

/// The window about a place and its pixels; `None` where it is not wholly on the detector.
fn cut(picture: &Picture, at_px: [f64; 2]) -> Option<(Window, Vec<u16>)> {
    let inside = |at: f64, side: u16| {
        let margin = f64::from(HALF_WINDOW_PX) + 1.0;
        (margin..=f64::from(side) - 1.0 - margin).contains(&at)
    };
    let DetectorGeometry { width_px, height_px, .. } = picture.geometry();
    if !inside(at_px[0], width_px) || !inside(at_px[1], height_px) {
        return None;
    }
    let window = window_about(at_px);
    let rows = picture.pixels().chunks_exact(width_px.into()).skip(window.y.into());
    let left = usize::from(window.x);
    let of_row = |row: &[u16]| row[left..left + usize::from(window.width)].to_vec();
    Some((window, rows.take(window.height.into()).flat_map(of_row).collect()))
}
