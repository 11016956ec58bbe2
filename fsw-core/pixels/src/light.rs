//! Second moments of the light about a place, and a glance at whether it is more than a single pixel.
//!
//! In: a patch and its floor, scaled counts. Out: the variances of the light along and across the axis in
//! which it is widest, px², and that axis; `shape` of `fsw-core` says what they mean. Single precision: sums
//! of at most 169 values of 15 bits.

use crate::patch::{MARGIN, Patch};

/// The weight's values from its middle outwards, sixteenths.
const WEIGHT: [f32; 5] = [16.0, 14.1, 9.7, 5.2, 2.2];
/// Share of the light of nine pixels that one of them holds where it shines alone, percent.
const SINGLE_PERCENT: i32 = 75;
/// Second moments of light.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// Along the axis in which they are greatest, and across it, px².
    pub greater: f32,
    /// See `greater`.
    pub lesser: f32,
    /// That axis.
    pub axis: [f32; 2],
    /// The light in all.
    pub sum: f32,
}

/// Sums of light, and of light times offset, about a pixel.
#[derive(Default)]
struct Light {
    sum: f32,
    first: [f32; 2],
    second: [f32; 3],
}

impl Light {
    #[inline(always)]
    fn add(&mut self, dx: i32, dy: i32, light: f32) {
        let (dx, dy) = (dx as f32, dy as f32);
        self.sum += light;
        let (lx, ly) = (light * dx, light * dy);
        let ([fx, fy], [xx, yy, xy]) = (self.first, self.second);
        self.first = [fx + lx, fy + ly];
        self.second = [xx + lx * dx, yy + ly * dy, xy + lx * dy];
    }

    /// The moments about its own middle; `None` of no light.
    fn moments(&self) -> Option<Moments> {
        if self.sum < 1.0 {
            return None;
        }
        let per = 1.0 / self.sum;
        let [mx, my] = self.first.map(|moment| moment * per);
        let [xx, yy, xy] = self.second.map(|moment| moment * per);
        let (xx, yy, xy) = (xx - mx * mx, yy - my * my, xy - mx * my);
        let (middle, difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let half = libm::sqrtf(difference * difference + xy * xy);
        // Twice the axis's angle has the tangent xy / difference; halved by the half-angle formulas.
        let cosine = if half > 0.0 { difference / half } else { 1.0 };
        let along = libm::sqrtf((0.5 * (1.0 + cosine)).max(0.0));
        let across = libm::sqrtf((0.5 * (1.0 - cosine)).max(0.0));
        let axis = [along, if xy < 0.0 { -across } else { across }];
        Some(Moments { greater: middle + half, lesser: middle - half, axis, sum: self.sum })
    }
}

/// The moments of the light of the 3 x 3 px in the middle above a floor; `None` of no light.
#[inline]
pub fn of_core(patch: &Patch, floor: i32) -> Option<Moments> {
    moments::<1>(patch, floor)
}

/// The moments of all light inside the outermost ring; `None` of no light.
#[inline]
pub fn of_all(patch: &Patch, floor: i32) -> Option<Moments> {
    moments::<{ MARGIN - 1 }>(patch, floor)
}

/// Second moments of the pixels up to `HALF` from the patch's middle above a floor, about the centre of their
/// own light; `None` where that sums to less than a count.
#[inline(always)]
fn moments<const HALF: usize>(patch: &Patch, floor: i32) -> Option<Moments> {
    let mut light = Light::default();
    patch.each::<HALF>(|dx, dy, value| light.add(dx, dy, (value - floor) as f32));
    light.moments()
}

/// The same under the Gaussian weight of 2 px sigma, which stands on the patch's middle: it narrows the
/// moments of wide light.
#[inline]
pub fn weighted(patch: &Patch, floor: i32) -> Option<Moments> {
    let weight = |at: i32| WEIGHT.get(at.unsigned_abs() as usize).copied().unwrap_or(0.0) / 16.0;
    let mut light = Light::default();
    patch.each::<{ WEIGHT.len() - 1 }>(|dx, dy, value| {
        light.add(dx, dy, (value - floor) as f32 * weight(dx) * weight(dy));
    });
    light.moments()
}

/// Whether a single pixel shines in the middle of 5 x 5 px: a hot one, or a hit that went straight through. A
/// glance, before anything is measured: of a star's nine brightest pixels one holds half of the light at
/// most.
#[inline]
pub fn is_single_pixel(pixels: &[[i32; 5]; 5]) -> bool {
    let (mut all, mut nine, mut peak) = (0, 0, i32::MIN);
    for (dy, row) in (0..).zip(pixels) {
        for (dx, value) in (0..).zip(row) {
            all += value;
            if (1..4).contains(&dx) && (1..4).contains(&dy) {
                nine += value;
                peak = peak.max(*value);
            }
        }
    }
    // Of the outer sixteen.
    let floor = (all - nine) / 16;
    SINGLE_PERCENT * (nine - 9 * floor) < 100 * (peak - floor)
}
