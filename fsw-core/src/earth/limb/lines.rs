//! The pixels of a strip as lines from space inwards, shifted onto the middle one by the limb's known slope.
//!
//! In: a strip and its pixels. Out: the averaged line, its dark level, and the scatter of the lines about
//! it. Shifts and interpolated values are integers of [`FINE_SHIFT`] fractional bits, because averaging
//! ([`trimmed_means`]) is most of a strip's cost. A shift is rounded by at most 1/512 px.

use super::{BREADTH, MAX_LENGTH, MIDDLE, Strip};
use crate::order;
use fsw_pixels::lines::{FINE_SHIFT, LineStart, RUN, Spread, trimmed_means};

/// Places at either end that not every line covers: the slope is at most one.
pub(in crate::earth) const END_MARGIN: usize = MIDDLE as usize + 1;

/// A strip's pixels as lines from space inwards.
pub(in crate::earth) struct Lines<'a> {
    pixels: &'a [u16],
    /// Places of a line.
    pub(in crate::earth) length: usize,
    /// Index step from a place to the one inward of it.
    inward: isize,
    /// Where each line is as far from the limb as the middle one is at the place [`END_MARGIN`].
    starts: [LineStart; BREADTH],
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
        let (along, across) = if strip.along_x { (1, length) } else { (BREADTH, 1) };
        let inward = if strip.space_beyond { -(along as isize) } else { along as isize };
        let outer = if strip.space_beyond { along * (length - 1) } else { 0 };
        // Along the lines the limb moves by -flat / steep from one to the next; inward is against `steep`.
        let slope = flat / libm::fabsf(steep) * (1 << FINE_SHIFT) as f32;
        let starts = core::array::from_fn(|line| {
            let shift = libm::floorf(slope * (line as i32 - MIDDLE) as f32 + 0.5) as i32;
            let first = END_MARGIN as isize + (shift >> FINE_SHIFT) as isize;
            let at = (outer + line * across).wrapping_add_signed(first * inward);
            LineStart { at, part: shift & ((1 << FINE_SHIFT) - 1) }
        });
        Some(Self { pixels, length, inward, starts })
    }

    /// How far a place's pixel is from that of the place [`END_MARGIN`] on its line, as an index.
    fn offset(&self, place: usize) -> isize {
        (place as isize - END_MARGIN as isize) * self.inward
    }

    /// The averaged line, of which nothing is known yet. `None` where no place is covered by every line.
    pub(in crate::earth) fn averaged(&self) -> Option<AveragedLine<'_>> {
        let end = self.length.checked_sub(END_MARGIN).filter(|end| *end >= END_MARGIN)?;
        Some(AveragedLine {
            lines: self,
            counts: [0.0; MAX_LENGTH],
            spreads: [Spread::NONE; RUN],
            averaged: END_MARGIN,
            end,
        })
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
        let offset = self.offset(first);
        for LineStart { at, part } in self.starts {
            let mut at = at.wrapping_add_signed(offset);
            let begin = i32::from(*self.pixels.get(at)?);
            let (mut sum, mut last) = (0, begin);
            for _ in 0..places {
                sum += last;
                at = at.wrapping_add_signed(self.inward);
                last = i32::from(*self.pixels.get(at)?);
            }
            // Sum of the interpolated values, fine counts.
            let own = (sum << FINE_SHIFT) + part * (last - begin);
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

/// The averaged line, counts: at each place the mean of the lines without the smallest and the largest; zero
/// at both ends, which not every line covers. It is averaged from the outer end as far inwards as it is asked
/// for: what lies behind the limb's bright side is not.
pub(in crate::earth) struct AveragedLine<'a> {
    lines: &'a Lines<'a>,
    pub(in crate::earth) counts: [f32; MAX_LENGTH],
    /// Room for [`trimmed_means`].
    spreads: [Spread; RUN],
    /// Places averaged, those of the outer end included.
    averaged: usize,
    /// Places without the inner end.
    pub(in crate::earth) end: usize,
}

impl AveragedLine<'_> {
    /// Averages the places before `place`, none of the inner end.
    pub(in crate::earth) fn extend(&mut self, place: usize) -> Option<()> {
        while self.averaged < place.min(self.end) {
            let next = (self.averaged + RUN).min(self.end);
            let Lines { pixels, starts, inward, .. } = self.lines;
            let offset = self.lines.offset(self.averaged);
            let counts = self.counts.get_mut(self.averaged..next)?;
            trimmed_means(pixels, (starts, offset), *inward, &mut self.spreads, counts)?;
            self.averaged = next;
        }
        Some(())
    }

    /// The first place from `place` on whose brightness over the dark level is at least `least`.
    pub(in crate::earth) fn next_bright(&mut self, mut place: usize, dark: f32, least: f32) -> Option<usize> {
        loop {
            let found = self.known().get(place..)?.iter().position(|value| *value - dark >= least);
            if let Some(found) = found {
                return Some(place + found);
            }
            place = self.averaged;
            if place >= self.end {
                return None;
            }
            self.extend(place + 1)?;
        }
    }

    /// What is known of it, from its outer end on.
    pub(in crate::earth) fn known(&self) -> &[f32] {
        self.counts.get(..self.averaged).unwrap_or(&[])
    }

    /// Median of the outer end.
    pub(in crate::earth) fn dark(&mut self) -> Option<f32> {
        let mut outer = [0.0; MAX_LENGTH / 8];
        let outer = outer.get_mut(..(self.lines.length / 8).clamp(5, MAX_LENGTH / 8))?;
        self.extend(END_MARGIN + outer.len())?;
        for (dark, value) in outer.iter_mut().zip(self.counts.iter().skip(END_MARGIN)) {
            *dark = *value;
        }
        order::sort_numbers(outer);
        outer.get(outer.len() / 2).copied()
    }
}
