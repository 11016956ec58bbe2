//! What a spot is by its shape: a star, two of them, a streak, or a hit.
//!
//! In: conditioned pixels and a spot that `centroid` took for a star. Out: the [`Shape`], and of a star that
//! the sensor's turning has drawn out the centre anew.
//!
//! - Hit: a proton's track and hot pixels are sharper across than any lens: the lesser second moment of the 3
//!   x 3 px about the maximum stays below [`THIN_PX2`]; that of a Gaussian of 0.5 px sigma, integrated over
//!   pixels, is 0.29 px² or more wherever it stands in its pixel.
//! - Streak: light shines at both ends of the patch along the spot's axis. Only part of it was seen, so where
//!   its middle is is not known: no centre is given.
//! - Drawn out: the greater of the second moments under a Gaussian weight of 2 px sigma exceeds that of a
//!   star clearly, but all light is inside the patch, which is moved until the light stands in its middle.
//!   Its centre is taken instead of that of a region chosen for a star; the sigma grows with its area and
//!   with its length.
//! - Blend: a second maximum within [`BLEND_PX`]; the spot is flagged, and its sigma holds by how much the
//!   other draws the centre along.
//!
//! Each moment is judged with the noise that it has: a faint star is given the benefit of the doubt.
//!
//! Assumption: a PSF of 0.5 to 2 px sigma. Cost: within the prices of a candidate and of a second look
//! (`allowance`).

use super::Detection;
use crate::trigonometry::hypotenuse;
use fsw_pixels::condition::Place;
use fsw_pixels::light;
use fsw_pixels::patch::{MARGIN, Patch};

/// Lesser second moment of the 3 x 3 px about a star's maximum, at least, px².
const THIN_PX2: f32 = 0.22;

/// Second moment under the weight from which on a spot is drawn out: a uniform streak 5 px long, or a
/// Gaussian of 1.5 px sigma.
const DRAWN_PX2: f32 = 1.5;
/// ... and it must exceed the lesser one by this factor: a lens that is blunt all around is none.
const DRAWN_RATIO: f32 = 1.6;
/// More than a standard deviation of the moment under the weight, times flux over noise of a pixel, px².
const DRAWN_NOISE: f32 = 20.0;
/// Two standard deviations of a second moment of 3 x 3 px, times flux over noise of a pixel, px²: 2 sqrt(6).
const THIN_NOISE: f32 = 4.9;
/// Share of the middle's 3 x 3 px that the 3 x 3 px at an end of the patch must hold to be light, percent.
const LIGHT_PERCENT: i32 = 25;
/// ... and so many sigmas of such a sum.
const LIGHT_SIGMAS: i32 = 2;
/// Sigmas by which a second maximum must stand out.
const BLEND_SIGMAS: i32 = 5;
/// Farthest second maximum that makes a blend, px.
const BLEND_PX: usize = 4;
/// Share of the maximum that a second one must have, percent, and how far it must rise above what lies
/// between.
const BLEND_PERCENT: i32 = 20;
/// Second moment of a star's image, px².
const IMAGE_PX2: f32 = 1.0;
/// Error along its length of the centre of a bright spot that is drawn out, share of the length: of 500 in
/// flights that turned at up to 5 deg/s. What the patch cuts off at one end is missing.
const DRAWN_SHARE: f32 = 0.05;
/// Times that the patch is moved to the middle of the light.
const MOVES: usize = 3;

/// What a spot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A star, its centre where it was or measured anew.
    Star(Detection),
    /// Light that goes on beyond what was seen.
    Streak,
    /// Sharper than the lens.
    Hit,
}

/// Light of the 3 x 3 px at either end of the patch along an axis.
fn ends(patch: &Patch, axis: [f32; 2], floor: i32) -> [i32; 2] {
    let reach = (MARGIN - 1) as f32;
    let place = axis.map(|along| libm::floorf(along * reach + 0.5) as i32);
    [place, place.map(|at| -at)].map(|place| patch.nine(place) - 9 * floor)
}

/// Light at an end that is more than a star's skirt and the noise.
fn shines(end: i32, middle: i32, window: &Place) -> bool {
    end > (middle / 100 * LIGHT_PERCENT).max(LIGHT_SIGMAS * window.sum_sigma)
}

/// The centre of all light inside the ring; `None` where it ends nowhere. Moves the patch to the middle of
/// the light.
#[inline(never)]
fn whole(window: &Place, spot: &Detection, patch: &mut Patch, axis: [f32; 2]) -> Option<Detection> {
    const HALF: usize = MARGIN - 1;
    for step in 0..=MOVES {
        let floor = patch.floor();
        let [all, mx, my] = patch.moments(HALF);
        let side = 2 * HALF as i32 + 1;
        let sum = all - side * side * floor;
        if sum <= 0 {
            return None;
        }
        let per = 1.0 / sum as f32;
        let (mx, my) = (mx as f32 * per, my as f32 * per);
        let reach = HALF as f32;
        if mx.abs() > reach || my.abs() > reach {
            return None;
        }
        let offset = [mx, my].map(|at| libm::floorf(at + 0.5) as isize);
        if step < MOVES && offset != [0, 0] {
            let ([x, y], [dx, dy]) = (patch.at, offset);
            let middle = [x.checked_add_signed(dx)?, y.checked_add_signed(dy)?];
            if !patch.take(window, middle) {
                return None;
            }
            continue;
        }
        let middle = patch.square(1) - 9 * floor;
        if ends(patch, axis, floor).into_iter().any(|end| shines(end, middle, window)) {
            return None;
        }
        // The variance of an even streak is a twelfth of its squared length, and that of the image is added.
        let variance = light::of_all(patch, floor).map_or(0.0, |light| light.greater) - IMAGE_PX2;
        let length_px = libm::sqrtf((12.0 * variance).max(1.0));
        let side = side as f32;
        let spread = side * side * reach * (reach + 1.0) / 3.0;
        let noise = window.sum_sigma as f32 / 3.0 * libm::sqrtf(spread) * per;
        let error = hypotenuse(noise, DRAWN_SHARE * length_px);
        let centre = |at: usize, offset: f32| ((at as i32) << 16) + (offset * 65_536.0) as i32;
        let [x, y] = patch.at;
        return Some(Detection {
            x_q16: centre(x, mx),
            y_q16: centre(y, my),
            flux: sum,
            drawn_px: length_px as u8,
            ..spot.doubted(error)
        });
    }
    None
}

/// The greatest second maximum: its share of the light of both, percent, and its distance, px.
fn second_maximum(patch: &Patch, floor: i32, peak: i32, sigma: i32) -> Option<(i32, f32)> {
    let least = (peak / 100 * BLEND_PERCENT).max(BLEND_SIGMAS * sigma);
    let mut greatest: Option<(i32, i32)> = None;
    patch.each::<BLEND_PX>(|dx, dy, value| {
        let light = value - floor;
        if light <= least || dx.abs().max(dy.abs()) < 2 {
            return;
        }
        let neighbours = (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))).filter(|at| *at != (0, 0));
        let tops = |(x, y): (i32, i32)| {
            let other = patch.pixel(dx + x, dy + y);
            other < value || (other == value && (y, x) > (0, 0))
        };
        // Noise on a skirt has maxima too; those of stars rise above what lies on the way.
        let between =
            patch.pixel(dx / 2, dy / 2).min(patch.pixel(dx - dx.signum(), dy - dy.signum())) - floor;
        let rises = light - between > least;
        if rises && neighbours.into_iter().all(tops) && greatest.is_none_or(|(most, _)| light > most) {
            greatest = Some((light, dx * dx + dy * dy));
        }
    });
    let (light, square_px) = greatest?;
    Some(((100 * light).checked_div(light.saturating_add(peak)).unwrap_or(50), libm::sqrtf(square_px as f32)))
}

/// Says what a spot is, with the patch about its maximum; of one that is drawn out the patch is moved to the
/// middle of its light.
pub fn shape(window: &Place, patch: &mut Patch, spot: &Detection) -> Shape {
    if spot.saturated {
        // Its plateau and skirt are no image of the lens.
        return Shape::Star(*spot);
    }
    let floor = patch.floor();
    let peak = patch.square(0) - floor;
    let sigma = window.sigma;
    let core = light::of_core(patch, floor);
    if core.is_some_and(|core| core.lesser + THIN_NOISE * sigma as f32 / core.sum < THIN_PX2) {
        return Shape::Hit;
    }
    let Some(light) = light::weighted(patch, floor) else { return Shape::Star(*spot) };
    if light.greater > DRAWN_PX2 + DRAWN_NOISE * sigma as f32 / light.sum
        && light.greater > DRAWN_RATIO * light.lesser
    {
        return whole(window, spot, patch, light.axis).map_or(Shape::Streak, Shape::Star);
    }
    if runs_on(window, patch, floor, light.axis) {
        return Shape::Streak;
    }
    let Some((share, distance_px)) = second_maximum(patch, floor, peak, sigma) else {
        return Shape::Star(*spot);
    };
    let drawn = share as f32 * 0.01 * distance_px;
    Shape::Star(Detection { blended: true, ..spot.doubted(drawn) })
}

/// Whether light shines at both ends of the patch.
fn runs_on(window: &Place, patch: &Patch, floor: i32, axis: [f32; 2]) -> bool {
    let middle = patch.square(1) - 9 * floor;
    ends(patch, axis, floor).into_iter().all(|end| shines(end, middle, window))
}

/// Whether a maximum that is no star is part of a streak.
pub fn is_streak(window: &Place, x: usize, y: usize) -> bool {
    let mut patch = Patch::EMPTY;
    if !patch.take(window, [x, y]) {
        return false;
    }
    let floor = patch.floor();
    light::weighted(&patch, floor).is_some_and(|light| {
        light.greater > DRAWN_RATIO * light.lesser && runs_on(window, &patch, floor, light.axis)
    })
}
