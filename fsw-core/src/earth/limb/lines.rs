//! The pixels of a strip as lines from space inwards, shifted onto the middle one by the limb's known slope.
//!
//! In: a strip and its pixels. Out: the averaged line, its dark level, and the scatter of the lines about
//! it. Shifts and interpolated values are integers of [`FINE_SHIFT`] fractional bits, because averaging is
//! most of a strip's cost. A shift is rounded by at most 1/512 px.

use super::{BREADTH, MAX_LENGTH, MIDDLE, Strip};
use crate::order;

/// Places at either end that not every line covers: the slope is at most one.
pub(in crate::earth) const END_MARGIN: usize = MIDDLE as usize + 1;
/// Fractional bits of a shift, px, and of a value, counts: nine values of 16 bits have room.
const FINE_SHIFT: u32 = 8;

/// A strip's pixels as lines from space inwards.
pub(in crate::earth) struct Lines<'a> {
    pixels: &'a [u16],
    /// Places of a line.
    pub(in crate::earth) length: usize,
    /// Index of the pixel at the first line's outer end.
    outer: i32,
    /// Index steps from a place to the one inward of it, and from a line to the next.
    inward: i32,
    across: i32,
    /// Inward shift of the limb from the middle line to each, fine px.
    shifts: [i32; BREADTH],
}

/// Read position on a line, moving inwards.
#[derive(Clone, Copy, Default)]
struct LineCursor {
    /// Index of the last pixel read, and its counts.
    at: usize,
    last: i32,
    /// Weight of the next pixel in a value, 2^-8.
    part: i32,
}

impl<'a> Lines<'a> {
    /// `None` where the pixels do not fit the strip, or the limb is inclined by more than 53 deg against
    /// it.
    pub(in crate::earth) fn of(pixels: &'a [u16], strip: &Strip) -> Option<Self> {
        let length = usize::from(if strip.along_x { strip.window.width } else { strip.window.height });
        let (steep, flat) = strip.normal_components();
        if pixels.len() != BREADTH * length || length > MAX_LENGTH || libm::fabsf(steep) < 0.6 {
            return None;
        }
        let (along, across) = if strip.along_x { (1, length as i32) } else { (BREADTH as i32, 1) };
        let (outer, inward) =
            if strip.space_beyond { (along * (length as i32 - 1), -along) } else { (0, along) };
        // Along the lines the limb moves by -flat / steep from one to the next; inward is against `steep`.
        let slope = flat / libm::fabsf(steep) * (1 << FINE_SHIFT) as f32;
        let shifts =
            core::array::from_fn(|line| libm::floorf(slope * (line as i32 - MIDDLE) as f32 + 0.5) as i32);
        Some(Self { pixels, length, outer, inward, across, shifts })
    }

    /// Cursor on a line, from the same distance to the limb as the middle line has at `place`.
    fn cursor(&self, line: usize, place: usize) -> Option<LineCursor> {
        let shift = *self.shifts.get(line)?;
        let first = place as i32 + (shift >> FINE_SHIFT);
        let at = usize::try_from(self.outer + line as i32 * self.across + first * self.inward).ok()?;
        let last = i32::from(*self.pixels.get(at)?);
        Some(LineCursor { at, last, part: shift & ((1 << FINE_SHIFT) - 1) })
    }

    /// The interpolated value, fine counts; moves to the next place.
    fn step(&self, cursor: &mut LineCursor) -> Option<i32> {
        cursor.at = cursor.at.wrapping_add_signed(self.inward as isize);
        let next = i32::from(*self.pixels.get(cursor.at)?);
        let value = (cursor.last << FINE_SHIFT) + cursor.part * (next - cursor.last);
        cursor.last = next;
        Some(value)
    }

    /// The averaged line, counts: at each place the mean of the lines without the smallest and the largest;
    /// zero at both ends, which not every line covers.
    pub(in crate::earth) fn profile(&self) -> Option<[f32; MAX_LENGTH]> {
        let mut cursors = [LineCursor::default(); BREADTH];
        for (line, cursor) in cursors.iter_mut().enumerate() {
            *cursor = self.cursor(line, END_MARGIN)?;
        }
        let mut profile = [0.0; MAX_LENGTH];
        for joined in profile.get_mut(END_MARGIN..self.length.checked_sub(END_MARGIN)?)? {
            let (mut sum, mut least, mut greatest) = (0, i32::MAX, 0);
            for cursor in &mut cursors {
                let value = self.step(cursor)?;
                sum += value;
                least = least.min(value);
                greatest = greatest.max(value);
            }
            const SHARE: f32 = 1.0 / ((BREADTH - 2) << FINE_SHIFT) as f32;
            *joined = (sum - least - greatest) as f32 * SHARE;
        }
        Some(profile)
    }

    /// Standard deviation of the mean of the lines' own crossings, px: from the deviation of each from the
    /// profile over the rise, `half` places to either side of `at`.
    pub(in crate::earth) fn scatter_px(&self, profile: &[f32], at: usize, half: usize) -> Option<f32> {
        let first = at.checked_sub(half)?;
        let places = 2 * half + 1;
        let joined = profile.get(first..first + places)?;
        let mean_rise = (joined.last()? - joined.first()?) / (places - 1).max(1) as f32;
        let rise = mean_rise * places as f32;
        if rise < 1e-3 {
            return None;
        }
        let joined: f32 = joined.iter().sum();
        let (mut squares, mut greatest) = (0.0, 0.0);
        for line in 0..BREADTH {
            let mut cursor = self.cursor(line, first)?;
            let mut own = 0;
            for _ in 0..places {
                own += self.step(&mut cursor)?;
            }
            let departure = (own as f32 * (1.0 / (1 << FINE_SHIFT) as f32) - joined) / rise;
            let square = departure * departure;
            squares += square;
            greatest = if square > greatest { square } else { greatest };
        }
        // Without the line of the largest deviation, because of stars and hot pixels; the mean uses seven
        // lines. Of nine squares of Gaussian values all but the largest make 0.64 of the sum.
        const KEPT: f32 = 0.64;
        let variance = (squares - greatest) / (KEPT * (BREADTH as f32 - 1.0));
        Some(libm::sqrtf(variance.max(0.0) / (BREADTH as f32 - 2.0)))
    }
}

/// Median of the outer end.
pub(in crate::earth) fn dark_of(profile: &[f32], length: usize) -> f32 {
    let mut outer = [0.0; MAX_LENGTH / 8];
    let count = (length / 8).clamp(5, MAX_LENGTH / 8);
    for (dark, value) in outer.iter_mut().zip(profile.iter().skip(END_MARGIN)).take(count) {
        *dark = *value;
    }
    if let Some(outer) = outer.get_mut(..count) {
        order::sort_numbers(outer);
    }
    outer.get(count / 2).copied().unwrap_or(0.0)
}
