//! A picture of the sky with what was found drawn on it.
//!
//! In: the picture and its answer. Out: a PNG in colours, as large as the picture or, of a narrow one, a
//! whole number of times larger: star-like spots circled, those with a name green and the others red; the
//! names, or Hipparcos numbers; residuals as yellow lines from the projected place towards the measured
//! one, [`LONGER`] times as long; lines of right ascension and declination; a cross at the line of sight.

use super::grid;
use super::pointing::Pointing;
use super::{SolveAnswer, star_names};
use crate::drawing::{Drawing, FITTED, GRID, LEFT_OUT, Stretch, TAKEN};
use crate::formats::picture::Picture;

/// By how much residuals are made longer.
const LONGER: f32 = 20.0;
/// Grey of a picture: most of the sky dark, the brightest stars white.
const STRETCH: Stretch = Stretch { black: 0.75, white: 0.999 };
/// Narrower pictures leave no room for letters, px.
const LEAST_WIDTH_PX: u32 = 1000;
/// Nominal radii of circles and half sides of the cross, px.
const NAMED_PX: f32 = 9.0;
const SPOT_PX: f32 = 6.0;
const CROSS_PX: f32 = 15.0;
/// Spots this near to a named star are that star, px of the picture.
const SAME_PX: f32 = 0.5;

/// Draws a picture's sky; `pointing` where it was identified.
pub(super) fn draw(picture: &Picture, answer: &SolveAnswer, pointing: Option<&Pointing>) -> Drawing {
    let mut drawing = Drawing::over(picture, STRETCH, LEAST_WIDTH_PX);
    let lines = pointing.map(grid::lines).unwrap_or_default();
    for line in &lines {
        for pair in line.places.windows(2) {
            if let [Some(from), Some(to)] = pair {
                drawing.line(*from, *to, GRID);
            }
        }
    }
    for spot in &answer.spots {
        let is_spot = |at: [f32; 2]| (at[0] - spot[0]).hypot(at[1] - spot[1]) < SAME_PX;
        if !answer.stars.iter().any(|star| is_spot([star.x, star.y])) {
            drawing.circle(*spot, SPOT_PX, LEFT_OUT);
        }
    }
    for star in &answer.stars {
        let (at, [dx, dy]) = ([star.x, star.y], star.residual_px);
        drawing.circle(at, NAMED_PX, TAKEN);
        let projected = [star.x - dx, star.y - dy];
        drawing.line(projected, [projected[0] + LONGER * dx, projected[1] + LONGER * dy], FITTED);
    }
    if let Some(pointing) = pointing {
        drawing.cross(pointing.camera.parameters().optical_centre_px, CROSS_PX, FITTED);
    }
    drawing.title(&title(answer), FITTED);
    for star in &answer.stars {
        let name = star_names::name(star.hip).map_or_else(|| star.hip.to_string(), str::to_owned);
        drawing.label([star.x, star.y], NAMED_PX, &name, TAKEN);
    }
    for line in &lines {
        label(&mut drawing, line, picture);
    }
    drawing
}

/// Labels a line of the grid at the end nearest to an edge of the picture that has room.
fn label(drawing: &mut Drawing, line: &grid::GridLine, picture: &Picture) {
    let geometry = fsw_hal::Detector::geometry(picture);
    let [right, low] = [geometry.width_px, geometry.height_px].map(f32::from);
    let inside = |[x, y]: &[f32; 2]| *x >= 0.0 && *y >= 0.0 && *x < right && *y < low;
    let mut seen: Vec<[f32; 2]> = line.places.iter().flatten().copied().filter(inside).collect();
    // The ends first, then what is next to them.
    let edge = |[x, y]: &[f32; 2]| x.min(*y).min(right - x).min(low - y);
    seen.sort_by(|a, b| edge(a).total_cmp(&edge(b)));
    let _ = seen.iter().take(40).any(|at| drawing.label(*at, 2.0, &line.label, GRID));
}

/// What stands in the corner.
fn title(answer: &SolveAnswer) -> Vec<String> {
    let spots = format!("{} of {} spots named", answer.stars.len(), answer.detections);
    match (answer.ra_deg, answer.dec_deg, answer.roll_deg, answer.fov_deg) {
        (Some(ra), Some(dec), Some(roll), Some(fov)) => vec![
            format!("RA {ra:.4}  Dec {dec:+.4}  roll {roll:.3}  field {fov:.3} deg"),
            format!("{spots}; residuals x {LONGER}"),
        ],
        _ => vec![format!("not identified: {}", answer.reason.unwrap_or("no reason")), spots],
    }
}
