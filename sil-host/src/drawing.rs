//! Pictures in colours with what was found drawn on them.
//!
//! In: a picture, shapes at places in its pixels (centre of the first: (0, 0)). Out: a PNG. Shapes and
//! letters grow with the picture's width, so that a drawing looks the same however large it is.

use crate::error::HostError;
use crate::formats::picture::Picture;
use crate::output::write_whole;
use fsw_hal::{Detector, DetectorGeometry};
use image::{Rgb, RgbImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// What an answer rests on.
pub(crate) const TAKEN: Rgb<u8> = Rgb([60, 255, 60]);
/// What was found and left out.
pub(crate) const LEFT_OUT: Rgb<u8> = Rgb([255, 60, 60]);
/// What was fitted.
pub(crate) const FITTED: Rgb<u8> = Rgb([255, 220, 0]);
/// Coordinates.
pub(crate) const GRID: Rgb<u8> = Rgb([70, 120, 200]);
/// Width of a drawing in which shapes have their nominal size, px.
const NOMINAL_WIDTH_PX: f32 = 1000.0;
/// Blank around letters, px.
const MARGIN_PX: i32 = 2;

/// Sizes of letters, px.
const LETTERS: [RasterHeight; 3] = [RasterHeight::Size16, RasterHeight::Size24, RasterHeight::Size32];

/// How a picture becomes grey: shares of the pixels that are at most black, and at most white.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Share at most black.
    pub black: f64,
    /// Share at most white.
    pub white: f64,
}

/// A drawing under way.
pub(crate) struct Drawing {
    image: RgbImage,
    /// Pixels of the drawing for one of the picture.
    zoom: f32,
    /// Size of shapes over their nominal size.
    scale: f32,
    letters: RasterHeight,
    /// Boxes that hold letters: left, top, right, bottom.
    labels: Vec<[i32; 4]>,
}

/// What the drawings of these pictures are called: `STEM-ENDING`; where a stem comes again, from another
/// folder, with another extension or in other case, `STEM-2-ENDING`, or the next number that is free.
pub(crate) fn names(pictures: &[PathBuf], ending: &str) -> Vec<String> {
    let mut taken = HashSet::new();
    let mut free = |picture: &PathBuf| {
        let stem = picture.file_stem().map_or_else(|| "picture".into(), |stem| stem.to_string_lossy());
        let numbered = (2u32..).map(|number| format!("{stem}-{number}{ending}"));
        let mut all = std::iter::once(format!("{stem}{ending}")).chain(numbered);
        all.find(|name| taken.insert(name.to_lowercase()))
    };
    pictures.iter().filter_map(&mut free).collect()
}

/// Makes the folder for files of a command's pictures, if there is none; `None` where none is asked for.
///
/// # Errors
/// When the system refuses.
pub(crate) fn folder(path: Option<&PathBuf>) -> Result<(), HostError> {
    path.map_or(Ok(()), |folder| {
        std::fs::create_dir_all(folder)
            .map_err(|error| HostError::system(folder, "made", &error, "name another folder"))
    })
}

impl Drawing {
    /// Begins with the picture in grey; one narrower than `least_width_px` is enlarged a whole number of
    /// times.
    pub(crate) fn over(picture: &Picture, stretch: Stretch, least_width_px: u32) -> Self {
        let DetectorGeometry { width_px, height_px, .. } = picture.geometry();
        let mut sorted = picture.pixels().to_vec();
        sorted.sort_unstable();
        let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(0);
        let black = if stretch.black > 0.0 { at(stretch.black) } else { 0 };
        let range = u32::from(at(stretch.white).saturating_sub(black).max(1));
        let zoom = least_width_px.div_ceil(width_px.into()).max(1);
        let image = RgbImage::from_fn(zoom * u32::from(width_px), zoom * u32::from(height_px), |x, y| {
            let raw = picture.pixels()[(y / zoom) as usize * usize::from(width_px) + (x / zoom) as usize];
            Rgb([(u32::from(raw.saturating_sub(black)).min(range) * 255 / range) as u8; 3])
        });
        let scale = (image.width() as f32 / NOMINAL_WIDTH_PX).max(0.5);
        let nearest = |height: &&RasterHeight| (height.val() as f32 - 16.0 * scale).abs();
        let letters = LETTERS.iter().min_by(|a, b| nearest(a).total_cmp(&nearest(b)));
        let letters = letters.copied().unwrap_or(RasterHeight::Size16);
        Self { image, zoom: zoom as f32, scale, letters, labels: Vec::new() }
    }

    /// The drawing's pixel of a place in the picture.
    fn place(&self, at: [f32; 2]) -> [f32; 2] {
        at.map(|px| (px + 0.5) * self.zoom - 0.5)
    }

    /// Colours the pixels nearest to a place of the drawing, as broad as lines are.
    fn dot(&mut self, [x, y]: [f32; 2], colour: Rgb<u8>) {
        let broad = (self.scale.round() as i32).max(1);
        let from = |at: f32| at.round() as i32 - (broad - 1) / 2;
        for row in from(y)..from(y) + broad {
            for column in from(x)..from(x) + broad {
                if let (Ok(column), Ok(row)) = (u32::try_from(column), u32::try_from(row))
                    && let Some(pixel) = self.image.get_pixel_mut_checked(column, row)
                {
                    *pixel = colour;
                }
            }
        }
    }

    fn stroke(&mut self, [x0, y0]: [f32; 2], [x1, y1]: [f32; 2], colour: Rgb<u8>) {
        let steps = (x1 - x0).abs().max((y1 - y0).abs()).ceil();
        if steps > 2.0 * (self.image.width() + self.image.height()) as f32 {
            return;
        }
        for step in 0..=steps as u32 {
            let part = step as f32 / steps.max(1.0);
            self.dot([x0 + part * (x1 - x0), y0 + part * (y1 - y0)], colour);
        }
    }

    /// A line between two places. One that leads far outside the picture is left out.
    pub(crate) fn line(&mut self, from: [f32; 2], to: [f32; 2], colour: Rgb<u8>) {
        let [from, to] = [from, to].map(|at| self.place(at));
        self.stroke(from, to, colour);
    }

    /// A square about a place; half its side is nominal.
    pub(crate) fn square(&mut self, at: [f32; 2], half_px: f32, colour: Rgb<u8>) {
        let (half, [x, y]) = ((half_px * self.scale).trunc(), self.place(at));
        let corners =
            [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]];
        for (corner, next) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            self.stroke(*corner, *next, colour);
        }
    }

    /// A circle about a place; its radius is nominal.
    pub(crate) fn circle(&mut self, at: [f32; 2], radius_px: f32, colour: Rgb<u8>) {
        let (radius, [x, y]) = (radius_px * self.scale, self.place(at));
        let steps = (8.0 * radius).ceil();
        for step in 0..steps as u32 {
            let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * step as f32 / steps);
            self.dot([x + radius * cosine, y + radius * sine], colour);
        }
    }

    /// A cross at a place; half its size is nominal.
    pub(crate) fn cross(&mut self, at: [f32; 2], half_px: f32, colour: Rgb<u8>) {
        let (half, [x, y]) = ((half_px * self.scale).trunc(), self.place(at));
        self.stroke([x - half, y], [x + half, y], colour);
        self.stroke([x, y - half], [x, y + half], colour);
    }

    /// Letters beside a place, a nominal distance away: right, left, above or below, where the drawing and
    /// other letters leave room; none where they do not. Whether they were written.
    pub(crate) fn label(&mut self, at: [f32; 2], distance_px: f32, text: &str, colour: Rgb<u8>) -> bool {
        let ([x, y], [width, height]) = (self.place(at).map(|px| px.round() as i32), self.size(text));
        let away = (distance_px * self.scale).round() as i32 + MARGIN_PX;
        let places = [
            [x + away, y - height / 2],
            [x - away - width, y - height / 2],
            [x - width / 2, y - away - height],
            [x - width / 2, y + away],
        ];
        places.into_iter().any(|[left, top]| self.write_at([left, top], text, colour))
    }

    /// Letters in the upper left corner, a line each, whatever is there.
    pub(crate) fn title(&mut self, lines: &[String], colour: Rgb<u8>) {
        for (line, text) in (0..).zip(lines) {
            let [_, height] = self.size(text);
            self.write_at([2 * MARGIN_PX, 2 * MARGIN_PX + line * (height + 2 * MARGIN_PX)], text, colour);
        }
    }

    /// Width and height of letters, px.
    fn size(&self, text: &str) -> [i32; 2] {
        let width = get_raster_width(FontWeight::Regular, self.letters) * text.chars().count();
        [width as i32, self.letters.val() as i32]
    }

    /// Writes letters on dimmed ground where there is room for all of them. Whether there was.
    fn write_at(&mut self, [left, top]: [i32; 2], text: &str, colour: Rgb<u8>) -> bool {
        let [width, height] = self.size(text);
        let [x0, y0, x1, y1] =
            [left - MARGIN_PX, top - MARGIN_PX, left + width + MARGIN_PX, top + height + MARGIN_PX];
        let inside =
            x0 >= 0 && y0 >= 0 && x1 <= self.image.width() as i32 && y1 <= self.image.height() as i32;
        let free = |[l, t, r, b]: &[i32; 4]| *l >= x1 || *r <= x0 || *t >= y1 || *b <= y0;
        if !inside || !self.labels.iter().all(free) {
            return false;
        }
        self.labels.push([x0, y0, x1, y1]);
        for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x as u32, y as u32))) {
            let Rgb(under) = self.image.get_pixel_mut(x, y);
            *under = under.map(|value| value / 3);
        }
        let mut pen = left as u32;
        for letter in text.chars() {
            let raster = get_raster(letter, FontWeight::Regular, self.letters)
                .or_else(|| get_raster('?', FontWeight::Regular, self.letters));
            let Some(raster) = raster else { continue };
            for (y, row) in (top as u32..).zip(raster.rows()) {
                for (x, strength) in (pen..).zip(row) {
                    let Rgb(under) = self.image.get_pixel_mut(x, y);
                    let mix = |under: u8, over: u8| {
                        let strength = u32::from(*strength);
                        ((u32::from(under) * (255 - strength) + u32::from(over) * strength) / 255) as u8
                    };
                    *under = [0, 1, 2].map(|band| mix(under[band], colour.0[band]));
                }
            }
            pen += raster.width() as u32;
        }
        true
    }

    /// Writes the drawing into a file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn write(self, path: &Path) -> Result<(), HostError> {
        let mut png = Cursor::new(Vec::new());
        self.image.write_to(&mut png, image::ImageFormat::Png).map_err(|error| {
            HostError::input(path, None, format!("cannot be made: {error}"), "report this")
        })?;
        write_whole(path, png.get_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_drawing_overwrites_another_of_the_same_command() {
        let pictures = ["a/x.png", "b/x.png", "b/x.jpg", "c/x-2.png", "c/y.png", "d/Y.png", ".."];
        let expected = [
            "x-earth.png",
            "x-2-earth.png",
            "x-3-earth.png",
            "x-2-2-earth.png",
            "y-earth.png",
            "Y-2-earth.png",
            "picture-earth.png",
        ];
        assert_eq!(names(&pictures.map(PathBuf::from), "-earth.png"), expected);
    }

    #[test]
    fn labels_never_cover_one_another_nor_leave_the_drawing() {
        let geometry = DetectorGeometry { width_px: 200, height_px: 100, bits: 8 };
        let picture = Picture::from_pixels(geometry, vec![0; 20_000]).unwrap();
        let mut drawing = Drawing::over(&picture, Stretch { black: 0.0, white: 0.99 }, 1000);
        assert_eq!((drawing.image.dimensions(), drawing.zoom), ((1000, 500), 5.0));
        let written =
            (0..40).filter(|k| drawing.label([5.0 * *k as f32, 50.0], 8.0, "Sirius", TAKEN)).count();
        assert!((15..40).contains(&written), "{written}");
        for (index, [x0, y0, x1, y1]) in drawing.labels.iter().enumerate() {
            assert!(*x0 >= 0 && *y0 >= 0 && *x1 <= 1000 && *y1 <= 500);
            for [l, t, r, b] in &drawing.labels[..index] {
                assert!(l >= x1 || r <= x0 || t >= y1 || b <= y0);
            }
        }
        assert!(drawing.image.pixels().any(|pixel| *pixel == TAKEN));
    }
}
