//! Nine lines of pixels side by side, each shifted by a part of a pixel, and their mean without the extremes.
//!
//! In: where each line begins and by how much it is shifted. Out: at each place the mean of the nine
//! interpolated values without the least and the greatest of them. Values are integers of [`FINE_SHIFT`]
//! fractional bits: the sum of nine values of 16 bits has room.
//!
//! Cost: 180 cycles a place (Cortex-M4 model, zero wait states). Three lines go together: more need more
//! numbers at hand than there are registers.

/// Lines side by side.
pub const LINES: usize = 9;
/// Fractional bits of a shift, px, and of a value, counts.
pub const FINE_SHIFT: u32 = 8;
/// Most places summed at a time.
pub const RUN: usize = 64;
/// Lines that go together.
const TOGETHER: usize = 3;

/// Where a line begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct LineStart {
    /// Index of its first pixel.
    pub at: usize,
    /// Weight of the next pixel against this one, 2^-8.
    pub part: i32,
}

/// Sum, least and greatest of some lines' values at a place.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    sum: i32,
    least: i32,
    greatest: i32,
}

impl Spread {
    /// Of no lines.
    pub const NONE: Self = Self { sum: 0, least: i32::MAX, greatest: i32::MIN };
}

/// The means without the extremes, counts, at places from the lines' first pixels and an offset on, at most
/// [`RUN`] of them. From one to the next the index grows by `inward`: 1 where pixels of a line are
/// neighbours, [`LINES`] where those of a place are, negative where the line runs backwards. `None` of other
/// steps, or where the lines leave the pixels. `spreads` is overwritten.
#[inline(never)]
pub fn trimmed_means(
    pixels: &[u16],
    (lines, offset): (&[LineStart; LINES], isize),
    inward: isize,
    spreads: &mut [Spread; RUN],
    means: &mut [f32],
) -> Option<()> {
    let places = means.len();
    let spreads = spreads.get_mut(..places)?;
    // A line that runs backwards is one that runs forwards from its end on, its parts those of the other
    // pixel.
    let backwards = inward < 0;
    let shift = if backwards { offset.checked_add(inward.checked_mul(places as isize)?)? } else { offset };
    let lines = lines.map(|line| LineStart {
        at: line.at.wrapping_add_signed(shift),
        part: if backwards { (1 << FINE_SHIFT) - line.part } else { line.part },
    });
    match inward.unsigned_abs() {
        1 => take_lines::<1>(pixels, &lines, spreads)?,
        LINES => take_lines::<LINES>(pixels, &lines, spreads)?,
        _ => return None,
    }
    if backwards {
        spreads.reverse();
    }
    const SHARE: f32 = 1.0 / ((LINES - 2) << FINE_SHIFT) as f32;
    for (mean, Spread { sum, least, greatest }) in means.iter_mut().zip(spreads) {
        *mean = (*sum - *least - *greatest) as f32 * SHARE;
    }
    Some(())
}

/// The spreads of all lines, whose pixels stand `STEP` apart.
fn take_lines<const STEP: usize>(
    pixels: &[u16],
    lines: &[LineStart; LINES],
    spreads: &mut [Spread],
) -> Option<()> {
    spreads.fill(Spread::NONE);
    lines.as_chunks::<TOGETHER>().0.iter().try_for_each(|three| take_three::<STEP>(pixels, three, spreads))
}

/// Adds three lines to the spreads.
#[inline(never)]
fn take_three<const STEP: usize>(
    pixels: &[u16],
    lines: &[LineStart; TOGETHER],
    spreads: &mut [Spread],
) -> Option<()> {
    let [a, b, c] = lines.map(|line| {
        let (steps, _) = pixels.get(line.at.checked_add(1)?..)?.as_chunks::<STEP>();
        steps.get(..spreads.len())
    });
    let (a, b, c) = (a?, b?, c?);
    let [px, py, pz] = lines.map(|line| line.part);
    // What the last pixel gives to the next value: that is `last (1 - part) + next part`.
    let [mut x_last, mut y_last, mut z_last] = lines.map(|line| {
        let last = pixels.get(line.at).map_or(0, |raw| i32::from(*raw));
        (last << FINE_SHIFT) - last * line.part
    });
    let value = |last: &mut i32, step: &[u16; STEP], part: i32| {
        let next = step.last().map_or(0, |raw| i32::from(*raw));
        let of_next = next * part;
        let value = *last + of_next;
        *last = (next << FINE_SHIFT) - of_next;
        value
    };
    for (((slot, x), y), z) in spreads.iter_mut().zip(a).zip(b).zip(c) {
        let x = value(&mut x_last, x, px);
        let y = value(&mut y_last, y, py);
        let z = value(&mut z_last, z, pz);
        slot.sum += x + y + z;
        slot.least = slot.least.min(x).min(y).min(z);
        slot.greatest = slot.greatest.max(x).max(y).max(z);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_sky::Chance;
    use std::vec::Vec;

    #[test]
    fn the_means_are_those_of_values_sorted_one_by_one() {
        let mut chance = Chance(5);
        let (places, length) = (20, 40);
        let pixels: Vec<u16> = (0..LINES * length).map(|_| chance.bits() as u16).collect();
        for (inward, first, across) in [(1, 0, length), (-1, length - 1, length), (9, 0, 1), (-9, 351, 1)] {
            let lines: [LineStart; LINES] = core::array::from_fn(|line| {
                let at = (first + line * across).wrapping_add_signed((2 * line as isize) * inward);
                LineStart { at, part: (chance.bits() % 256) as i32 }
            });
            let mut means = [0.0; RUN];
            trimmed_means(&pixels, (&lines, 0), inward, &mut [Spread::NONE; RUN], &mut means[..places])
                .unwrap();
            for (place, mean) in means.iter().enumerate().take(places) {
                let mut values = lines.map(|line| {
                    let pixel = |place: isize| i64::from(pixels[line.at.wrapping_add_signed(place * inward)]);
                    let (last, next) = (pixel(place as isize), pixel(place as isize + 1));
                    last * i64::from(256 - line.part) + next * i64::from(line.part)
                });
                values.sort_unstable();
                let kept = values[1..8].iter().sum::<i64>() as f64 / (7.0 * 256.0);
                assert!((f64::from(*mean) - kept).abs() < 2.0 * f64::from(f32::EPSILON) * kept);
            }
        }
    }

    #[test]
    fn lines_that_leave_the_pixels_have_no_means() {
        let lines = [LineStart { at: 3, part: 0 }; LINES];
        let means = |length: usize, inward: isize, places: usize| {
            let spreads = &mut [Spread::NONE; RUN];
            trimmed_means(&[7; 100][..length], (&lines, 0), inward, spreads, &mut [0.0; RUN + 1][..places])
        };
        assert!(means(10, 1, 6).is_some() && means(10, 1, 7).is_none());
        assert!(means(10, -1, 3).is_some() && means(10, -1, 4).is_none());
        assert!(means(100, 1, RUN).is_some() && means(100, 1, RUN + 1).is_none());
    }
}
