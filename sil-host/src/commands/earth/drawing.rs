//! A picture of the Earth with what was found drawn on it.
//!
//! In: the picture and its answer. Out: a PNG in colours, as large as the picture: grey stretched to its
//! brightest percent, limb points green (those left out red), the fitted limb yellow, a cross at the centre.

use super::EarthAnswer;
use crate::drawing::{Drawing, FITTED, LEFT_OUT, Stretch, TAKEN};
use crate::formats::picture::Picture;

/// Grey of a picture: white from its brightest percent on.
const STRETCH: Stretch = Stretch { black: 0.0, white: 0.99 };
/// Nominal half sides of a point's square and of the centre's cross, px.
const POINT_PX: f32 = 4.0;
const CROSS_PX: f32 = 12.0;

/// Draws a picture's Earth.
pub(super) fn draw(picture: &Picture, answer: &EarthAnswer, limb: &[Option<[f32; 2]>]) -> Drawing {
    let mut drawing = Drawing::over(picture, STRETCH, 0);
    for (here, next) in limb.iter().zip(limb.iter().cycle().skip(1)) {
        if let (Some(here), Some(next)) = (here, next) {
            drawing.line(*here, *next, FITTED);
        }
    }
    for point in &answer.limb {
        let colour = if point.inlier { TAKEN } else { LEFT_OUT };
        drawing.square([point.x, point.y], POINT_PX, colour);
    }
    if let Some(centre_px) = answer.centre_px {
        drawing.cross(centre_px, CROSS_PX, FITTED);
    }
    drawing
}
