//! What a spot is by its shape: a star, two of them, a streak, or a hit.
//!
//! In: conditioned pixels and a spot that `centroid` took for a star. Out: the [`Shape`], and of a star that the sensor's
//! turning has drawn out the centre anew.
//!
//! - Hit: a proton's track and hot pixels are sharper across than any lens: the lesser second moment of the 3 x 3 px about
//!   the maximum stays below [`THIN_PX2`]; that of a Gaussian of 0.5 px sigma, integrated over pixels, is 0.29 px² or more
//!   wherever it stands in its pixel.
//! - Streak: light shines at both ends of the square of [`SIDE`] px along the spot's axis. Only part of it was seen, so where
//!   its middle is is not known: no centre is given.
//! - Drawn out: the greater of the second moments under a Gaussian weight of 2 px sigma exceeds that of a star
//!   clearly, but all light is inside the square, which is moved until the light stands in its middle. Its centre is taken instead
//!   of that of a region chosen for a star; its larger area makes the sigma grow with it.
//! - Blend: a second maximum within [`BLEND_PX`]; the spot is flagged, and its sigma holds by how much the other draws the
//!   centre along.
//!
//! Each moment is judged with the noise that it has: a faint star is given the benefit of the doubt.
//!
//! Assumption: a PSF of 0.5 to 2 px sigma. Cost: within the prices of a candidate and of a second look
//! (`allowance`).

use super::Detection;
use super::condition::Place;

/// Distance of the ring that is the floor, px; within it a spot must have ended.
const RING: usize = 7;
/// Side of the square that is looked at.
const SIDE: usize = 2 * RING + 1;
/// Lesser second moment of the 3 x 3 px about a star's maximum, at least, px².
const THIN_PX2: f32 = 0.22;

/// The weight's values from its middle outwards, sixteenths.
const WEIGHT: [f32; 5] = [16.0, 14.1, 9.7, 5.2, 2.2];
/// Second moment under the weight from which on a spot is drawn out: a uniform streak 5 px long, or a Gaussian of 1.5 px sigma.
const DRAWN_PX2: f32 = 1.5;
/// ... and it must exceed the lesser one by this factor: a lens that is blunt all around is none.
const DRAWN_RATIO: f32 = 1.6;
/// More than a standard deviation of the moment under the weight, times flux over noise of a pixel, px².
const DRAWN_NOISE: f32 = 20.0;
/// Two standard deviations of a second moment of 3 x 3 px, times flux over noise of a pixel, px²: 2 sqrt(6).
const THIN_NOISE: f32 = 4.9;
/// Share of the middle's 3 x 3 px that the 3 x 3 px at an end of the square must hold to be light, percent.
const LIGHT_PERCENT: i32 = 25;
/// ... and so many sigmas of such a sum.
const LIGHT_SIGMAS: i32 = 2;
/// Sigmas by which a second maximum must stand out.
const BLEND_SIGMAS: i32 = 5;
/// Farthest second maximum that makes a blend, px.
const BLEND_PX: i32 = 4;
/// Share of the maximum that a second one must have, percent, and how far it must rise above what lies between.
const BLEND_PERCENT: i32 = 20;
/// Share of the light of nine pixels that one of them holds where it shines alone, percent.
const SINGLE_PERCENT: i32 = 75;
/// Second moment of a star's image, px².
const IMAGE_PX2: f32 = 1.0;
/// Times that the square is moved to the middle of the light.
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

/// Residuals of [`SIDE`] rows and columns.
pub type Pixels = [[i32; SIDE]; SIDE];

/// The residuals about (x, y), where they fit into the window.
fn pixels_about(window: &Place, x: usize, y: usize) -> Option<Pixels> {
    let (left, top) = (x.checked_sub(RING)?, y.checked_sub(RING)?);
    let mut pixels = [[0; SIDE]; SIDE];
    for (row, y) in pixels.iter_mut().zip(top..) {
        *row = window.run(left, y)?;
    }
    Some(pixels)
}

/// The residuals about a place.
#[derive(Clone, Copy)]
struct Square<'p> {
    pixels: &'p Pixels,
    x: usize,
    y: usize,
}

impl Square<'_> {
    /// The residual at an offset from the middle, 0 outside.
    fn at(&self, dx: i32, dy: i32) -> i32 {
        let row = usize::try_from(dy + RING as i32).ok().and_then(|row| self.pixels.get(row));
        let column = usize::try_from(dx + RING as i32).ok();
        row.zip(column).and_then(|(row, column)| row.get(column)).copied().unwrap_or(0)
    }

    /// Rows and columns within `half` of the middle, with their offsets.
    fn near(&self, half: usize) -> impl Iterator<Item = (i32, i32, i32)> {
        let span = move || (-(half as i32)..).take(2 * half + 1);
        let rows = self.pixels.iter().skip(RING - half).zip(span());
        rows.flat_map(move |(row, dy)| {
            row.iter().skip(RING - half).zip(span()).map(move |(value, dx)| (dx, dy, *value))
        })
    }

    /// Mean of the ring.
    fn floor(&self) -> i32 {
        let sum = |half| self.near(half).fold(0, |sum, (.., value)| sum + value);
        (sum(RING) - sum(RING - 1)) / (8 * RING as i32)
    }

    /// The light of the 3 x 3 px at an offset.
    fn nine(&self, [x, y]: [i32; 2], floor: i32) -> i32 {
        let places = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        places.fold(0, |sum, (x, y)| sum + self.at(x, y) - floor)
    }

    /// The light of the 3 x 3 px at either end of the square along an axis.
    fn ends(&self, axis: [f32; 2], floor: i32) -> [i32; 2] {
        let reach = (RING - 1) as f32;
        let place = axis.map(|along| libm::floorf(along * reach + 0.5) as i32);
        [place, place.map(|at| -at)].map(|place| self.nine(place, floor))
    }
}

/// Second moments of light.
struct Moments {
    /// Along the axis in which they are greatest, and across it, px².
    greater: f32,
    lesser: f32,
    /// That axis.
    axis: [f32; 2],
    /// The light in all.
    sum: f32,
}

/// The moments of light at places about its own middle; `None` of no light.
fn moments(values: impl Iterator<Item = (i32, i32, f32)>) -> Option<Moments> {
    let (mut sum, mut first, mut second) = (0.0f32, [0.0f32; 2], [0.0f32; 3]);
    for (dx, dy, light) in values {
        let (dx, dy) = (dx as f32, dy as f32);
        sum += light;
        let (lx, ly) = (light * dx, light * dy);
        let ([fx, fy], [xx, yy, xy]) = (first, second);
        first = [fx + lx, fy + ly];
        second = [xx + lx * dx, yy + ly * dy, xy + lx * dy];
    }
    if sum < 1.0 {
        return None;
    }
    let per = 1.0 / sum;
    let [mx, my] = first.map(|moment| moment * per);
    let [xx, yy, xy] = second.map(|moment| moment * per);
    let (xx, yy, xy) = (xx - mx * mx, yy - my * my, xy - mx * my);
    let (middle, difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let half = libm::sqrtf(difference * difference + xy * xy);
    // Twice the axis's angle has the tangent xy / difference; halved by the half-angle formulas.
    let cosine = if half > 0.0 { difference / half } else { 1.0 };
    let along = libm::sqrtf((0.5 * (1.0 + cosine)).max(0.0));
    let across = libm::sqrtf((0.5 * (1.0 - cosine)).max(0.0));
    let axis = [along, if xy < 0.0 { -across } else { across }];
    Some(Moments { greater: middle + half, lesser: middle - half, axis, sum })
}

/// Light under the weight about the middle.
fn weighted(square: &Square, floor: i32) -> Option<Moments> {
    let weight = |at: i32| WEIGHT.get(at.unsigned_abs() as usize).copied().unwrap_or(0.0) / 16.0;
    let light = |(dx, dy, value): (i32, i32, i32)| (dx, dy, (value - floor) as f32 * weight(dx) * weight(dy));
    moments(square.near(WEIGHT.len() - 1).map(light))
}

/// Light at an end that is more than a star's skirt and the noise.
fn shines(end: i32, middle: i32, window: &Place) -> bool {
    end > (middle / 100 * LIGHT_PERCENT).max(LIGHT_SIGMAS * window.sum_sigma)
}

/// The centre of all light inside the ring; `None` where it ends nowhere.
fn whole(window: &Place, spot: &Detection, first: Square, axis: [f32; 2]) -> Option<Detection> {
    let mut moved;
    let mut square = first;
    for step in 0..=MOVES {
        let floor = square.floor();
        let half = RING - 1;
        let (mut sum, mut mx, mut my) = (0i32, 0i32, 0i32);
        for (dx, dy, value) in square.near(half) {
            let light = value - floor;
            sum += light;
            mx += light * dx;
            my += light * dy;
        }
        if sum <= 0 {
            return None;
        }
        let per = 1.0 / sum as f32;
        let (mx, my) = (mx as f32 * per, my as f32 * per);
        let reach = half as f32;
        if mx.abs() > reach || my.abs() > reach {
            return None;
        }
        let [x, y] = [mx, my].map(|at| libm::floorf(at + 0.5) as i32);
        if step < MOVES && (x, y) != (0, 0) {
            let to = |from: usize, steps: i32| from.checked_add_signed(steps as isize);
            let (x, y) = (to(square.x, x)?, to(square.y, y)?);
            moved = pixels_about(window, x, y)?;
            square = Square { pixels: &moved, x, y };
            continue;
        }
        let middle = square.nine([0, 0], floor);
        if square.ends(axis, floor).into_iter().any(|end| shines(end, middle, window)) {
            return None;
        }
        // The variance of an even streak is a twelfth of its squared length, and that of the image is added.
        let light = moments(square.near(half).map(|(dx, dy, value)| (dx, dy, (value - floor) as f32)));
        let variance = light.map_or(0.0, |light| light.greater) - IMAGE_PX2;
        let length_px = libm::sqrtf((12.0 * variance).max(1.0));
        let side = (2 * half + 1) as f32;
        let spread = side * side * reach * (reach + 1.0) / 3.0;
        let noise = window.sum_sigma as f32 / 3.0 * libm::sqrtf(spread) * per;
        let before = spot.sigma_px();
        let centre = |at: usize, offset: f32| ((at as i32) << 16) + (offset * 65_536.0) as i32;
        return Some(Detection {
            x_q16: centre(square.x, mx),
            y_q16: centre(square.y, my),
            flux: sum,
            drawn_px: length_px as u8,
            sigma_q16: (libm::sqrtf(noise * noise + before * before) * 65_536.0) as i32,
            ..*spot
        });
    }
    None
}

/// The greatest second maximum: its share of the light of both, percent, and its distance, px.
fn second_maximum(square: &Square, floor: i32, peak: i32, sigma: i32) -> Option<(i32, f32)> {
    let least = (peak / 100 * BLEND_PERCENT).max(BLEND_SIGMAS * sigma);
    let mut greatest: Option<(i32, i32)> = None;
    for (dx, dy, value) in square.near(BLEND_PX as usize) {
        let light = value - floor;
        if dx.abs().max(dy.abs()) < 2 || light <= least {
            continue;
        }
        let neighbours = (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))).filter(|at| *at != (0, 0));
        let tops = |(x, y): (i32, i32)| {
            let other = square.at(dx + x, dy + y);
            other < value || (other == value && (y, x) > (0, 0))
        };
        // Noise on a skirt has maxima too; those of stars rise above what lies on the way.
        let between = square.at(dx / 2, dy / 2).min(square.at(dx - dx.signum(), dy - dy.signum())) - floor;
        let rises = light - between > least;
        if rises && neighbours.into_iter().all(tops) && greatest.is_none_or(|(most, _)| light > most) {
            greatest = Some((light, dx * dx + dy * dy));
        }
    }
    let (light, square_px) = greatest?;
    Some(((100 * light).checked_div(light.saturating_add(peak)).unwrap_or(50), libm::sqrtf(square_px as f32)))
}

/// Says what a spot is whose maximum stands at (x, y), with these pixels about it.
pub fn shape(window: &Place, [x, y]: [usize; 2], pixels: &Pixels, spot: &Detection) -> Shape {
    let square = Square { pixels, x, y };
    if spot.saturated {
        // Its plateau and skirt are no image of the lens.
        return Shape::Star(*spot);
    }
    let floor = square.floor();
    let peak = square.at(0, 0) - floor;
    let sigma = window.sigma;
    let core = moments(square.near(1).map(|(dx, dy, value)| (dx, dy, (value - floor) as f32)));
    if core.is_some_and(|core| core.lesser + THIN_NOISE * sigma as f32 / core.sum < THIN_PX2) {
        return Shape::Hit;
    }
    let Some(light) = weighted(&square, floor) else { return Shape::Star(*spot) };
    if light.greater > DRAWN_PX2 + DRAWN_NOISE * sigma as f32 / light.sum
        && light.greater > DRAWN_RATIO * light.lesser
    {
        return whole(window, spot, square, light.axis).map_or(Shape::Streak, Shape::Star);
    }
    if runs_on(window, &square, floor, light.axis) {
        return Shape::Streak;
    }
    let Some((share, distance_px)) = second_maximum(&square, floor, peak, sigma) else {
        return Shape::Star(*spot);
    };
    let drawn = share as f32 * 0.01 * distance_px;
    let sigma_px = spot.sigma_px();
    let sigma_q16 = (libm::sqrtf(sigma_px * sigma_px + drawn * drawn) * 65_536.0) as i32;
    Shape::Star(Detection { blended: true, sigma_q16, ..*spot })
}

/// Whether light shines at both ends of the square.
fn runs_on(window: &Place, square: &Square, floor: i32, axis: [f32; 2]) -> bool {
    let middle = square.nine([0, 0], floor);
    square.ends(axis, floor).into_iter().all(|end| shines(end, middle, window))
}

/// Whether a maximum that is no star is part of a streak.
pub fn is_streak(window: &Place, x: usize, y: usize) -> bool {
    let Some(pixels) = pixels_about(window, x, y) else { return false };
    let square = Square { pixels: &pixels, x, y };
    let floor = square.floor();
    weighted(&square, floor).is_some_and(|light| {
        light.greater > DRAWN_RATIO * light.lesser && runs_on(window, &square, floor, light.axis)
    })
}

/// Whether a single pixel shines about (x, y): a hot one, or a hit that went straight through. A glance, before anything is
/// measured: of a star's nine brightest pixels one holds half of the light at most.
pub fn is_single_pixel(window: &Place, x: usize, y: usize) -> bool {
    let (Some(left), Some(top)) = (x.checked_sub(2), y.checked_sub(2)) else { return false };
    let (mut all, mut nine, mut peak) = (0, 0, i32::MIN);
    for (dy, y) in (0..5).zip(top..) {
        let Some(row) = window.run::<5>(left, y) else { return false };
        let [_, a, b, c, _] = row;
        all += row.iter().sum::<i32>();
        if (1..4).contains(&dy) {
            nine += a + b + c;
            peak = peak.max(a).max(b).max(c);
        }
    }
    let floor = (all - nine) / 16;
    SINGLE_PERCENT * (nine - 9 * floor) < 100 * (peak - floor)
}
