//! A picture of the Earth with what was found drawn on it.
//!
//! In: the picture and its answer. Out: a PNG in colours, as large as the picture: grey stretched to its
//! brightest percent, limb points green (those left out red), the fitted limb yellow, a cross at the centre.

use super::EarthAnswer;
use crate::error::HostError;
use crate::formats::picture::Picture;
use crate::output::write_whole;
use fsw_hal::{Detector, DetectorGeometry};
use image::{Rgb, RgbImage};
use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};

const INLIER: Rgb<u8> = Rgb([60, 255, 60]);
const OUTLIER: Rgb<u8> = Rgb([255, 60, 60]);
const LIMB: Rgb<u8> = Rgb([255, 220, 0]);
/// Share of the pixels that are shown as dark as white or darker.
const WHITE_SHARE: f64 = 0.99;
/// Half sides of a point's square and of the centre's cross, px of a picture 1000 px wide.
const POINT_PX: f32 = 4.0;
const CROSS_PX: f32 = 12.0;

/// What the drawings of these pictures are called: `STEM-earth.png`; where a stem comes again, from another
/// folder or with another extension, `STEM-2-earth.png`, or the next number that is free.
pub(super) fn names(pictures: &[PathBuf]) -> Vec<String> {
    let mut taken = HashSet::new();
    let mut free = |picture: &PathBuf| {
        let stem = picture.file_stem().map_or_else(|| "picture".into(), |stem| stem.to_string_lossy());
        let numbered = (2u32..).map(|number| format!("{stem}-{number}-earth.png"));
        std::iter::once(format!("{stem}-earth.png")).chain(numbered).find(|name| taken.insert(name.clone()))
    };
    pictures.iter().filter_map(&mut free).collect()
}

/// Draws a picture's Earth into a file.
///
/// # Errors
/// When the file cannot be written.
pub(super) fn write(
    path: &Path,
    picture: &Picture,
    answer: &EarthAnswer,
    limb: &[Option<[f32; 2]>],
) -> Result<(), HostError> {
    let mut png = Cursor::new(Vec::new());
    draw(picture, answer, limb)
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|error| HostError::input(path, None, format!("cannot be made: {error}"), "report this"))?;
    write_whole(path, png.get_ref())
}

fn draw(picture: &Picture, answer: &EarthAnswer, limb: &[Option<[f32; 2]>]) -> RgbImage {
    let DetectorGeometry { width_px, height_px, .. } = picture.geometry();
    let mut sorted = picture.pixels().to_vec();
    sorted.sort_unstable();
    let white = sorted.get((WHITE_SHARE * sorted.len() as f64) as usize).copied().unwrap_or(1).max(1);
    let mut drawn = RgbImage::from_fn(width_px.into(), height_px.into(), |x, y| {
        let raw = picture.pixels()[y as usize * usize::from(width_px) + x as usize];
        Rgb([(u32::from(raw.min(white)) * 255 / u32::from(white)) as u8; 3])
    });
    let scale = (f32::from(width_px) / 1000.0).max(0.5);
    for (here, next) in limb.iter().zip(limb.iter().cycle().skip(1)) {
        if let (Some(here), Some(next)) = (here, next) {
            line(&mut drawn, *here, *next);
        }
    }
    for point in &answer.limb {
        let half = (POINT_PX * scale) as i32;
        let colour = if point.inlier { INLIER } else { OUTLIER };
        for along in -half..=half {
            for side in [-half, half] {
                dot(&mut drawn, [point.x + along as f32, point.y + side as f32], colour);
                dot(&mut drawn, [point.x + side as f32, point.y + along as f32], colour);
            }
        }
    }
    if let Some([x, y]) = answer.centre_px {
        let half = (CROSS_PX * scale) as i32;
        for along in -half..=half {
            dot(&mut drawn, [x + along as f32, y], LIMB);
            dot(&mut drawn, [x, y + along as f32], LIMB);
        }
    }
    drawn
}

/// A piece of the limb. What leads far outside the picture is left out.
fn line(drawn: &mut RgbImage, [x0, y0]: [f32; 2], [x1, y1]: [f32; 2]) {
    let steps = (x1 - x0).abs().max((y1 - y0).abs()).ceil();
    if steps > 2.0 * (drawn.width() + drawn.height()) as f32 {
        return;
    }
    for step in 0..=steps as u32 {
        let part = step as f32 / steps.max(1.0);
        dot(drawn, [x0 + part * (x1 - x0), y0 + part * (y1 - y0)], LIMB);
    }
}

/// Colours the pixel nearest to a place, if there is one.
fn dot(drawn: &mut RgbImage, [x, y]: [f32; 2], colour: Rgb<u8>) {
    let (x, y) = (x.round(), y.round());
    if x >= 0.0
        && y >= 0.0
        && let Some(pixel) = drawn.get_pixel_mut_checked(x as u32, y as u32)
    {
        *pixel = colour;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_drawing_overwrites_another_of_the_same_command() {
        let pictures = ["a/x.png", "b/x.png", "b/x.jpg", "c/x-2.png", "c/y.png", ".."].map(PathBuf::from);
        let expected = [
            "x-earth.png",
            "x-2-earth.png",
            "x-3-earth.png",
            "x-2-2-earth.png",
            "y-earth.png",
            "picture-earth.png",
        ];
        assert_eq!(names(&pictures), expected);
    }
}
