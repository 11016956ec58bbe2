//! The pixels about a maximum, and what is summed over them.
//!
//! In: a window as it is looked at about a place. Out: sums over squares, rings and sides, which `centroid`
//! judges, and light pixel by pixel, of which `shape` says what it is.
//!
//! All sums are exact: residuals have at most 15 bits and a patch 225 pixels.

use crate::condition::Place;

/// Pixels needed around a maximum: the largest region of a star and the ring outside it.
pub const MARGIN: usize = 7;
/// Side of a patch.
const SIDE: usize = 2 * MARGIN + 1;

/// The residuals about a pixel.
pub struct Patch {
    /// The pixel in the window.
    pub at: [usize; 2],
    pixels: [[i32; SIDE]; SIDE],
    /// Sums over the squares up to each distance from the middle.
    squares: [i32; MARGIN + 1],
}

impl Patch {
    /// Nothing yet.
    pub const EMPTY: Self = Self { at: [0; 2], pixels: [[0; SIDE]; SIDE], squares: [0; MARGIN + 1] };

    /// Takes the pixels about (x, y); whether they are in the window. If not, nothing has changed.
    #[must_use]
    #[inline]
    pub fn take(&mut self, window: &Place, [x, y]: [usize; 2]) -> bool {
        if x.min(y) < MARGIN || x + MARGIN >= window.width() || y + MARGIN >= window.height() {
            return false;
        }
        let (left, top) = (x - MARGIN, y - MARGIN);
        self.at = [x, y];
        let mut squares = [0; MARGIN + 1];
        for ((row, y), dy) in self.pixels.iter_mut().zip(top..).zip(-(MARGIN as i32)..) {
            // They are in the window.
            if let Some(run) = window.run::<SIDE>(left, y) {
                row.iter_mut().zip(run).for_each(|(pixel, value)| *pixel = value);
            }
            let [a7, a6, a5, a4, a3, a2, a1, a0, b1, b2, b3, b4, b5, b6, b7] = *row;
            let mut sum = a0;
            let pairs = [0, a1 + b1, a2 + b2, a3 + b3, a4 + b4, a5 + b5, a6 + b6, a7 + b7];
            let spans = pairs.map(|pair| {
                sum += pair;
                sum
            });
            // A choice of addends rather than a start at |dy|: the loop has no branch.
            for ((radius, square), span) in (0..).zip(&mut squares).zip(spans) {
                *square += if radius >= dy.abs() { span } else { 0 };
            }
        }
        self.squares = squares;
        true
    }

    /// The residual at an offset from the middle, 0 outside.
    pub fn pixel(&self, dx: i32, dy: i32) -> i32 {
        let row = usize::try_from(dy + MARGIN as i32).ok().and_then(|row| self.pixels.get(row));
        let column = usize::try_from(dx + MARGIN as i32).ok();
        row.zip(column).and_then(|(row, column)| row.get(column)).copied().unwrap_or(0)
    }

    /// The rows up to `HALF` from the middle with their offsets, and in each the pixels with theirs. A length
    /// known to the compiler makes sums over them three times as fast on the target.
    #[inline(always)]
    fn rows<const HALF: usize>(&self) -> impl Iterator<Item = (i32, impl Iterator<Item = (i32, i32)>)> {
        let first = -(HALF as i32);
        let rows = self.pixels.iter().skip(MARGIN - HALF).take(2 * HALF + 1);
        (first..).zip(rows).map(move |(dy, row)| {
            (dy, (first..).zip(row.iter().copied().skip(MARGIN - HALF).take(2 * HALF + 1)))
        })
    }

    /// Calls `see` with offset and residual of each pixel up to `HALF` from the middle, in reading order.
    #[inline(always)]
    pub fn each<const HALF: usize>(&self, mut see: impl FnMut(i32, i32, i32)) {
        for (dy, row) in self.rows::<HALF>() {
            row.for_each(|(dx, value)| see(dx, dy, value));
        }
    }

    /// Sum over the square up to `half` from the middle.
    pub fn square(&self, half: usize) -> i32 {
        self.squares.get(half).copied().unwrap_or(0)
    }

    /// Sum and number of the pixels on the square ring at distance `radius`, at least 1.
    pub fn ring(&self, radius: usize) -> (i32, i32) {
        (self.square(radius) - self.square(radius.wrapping_sub(1)), 8 * radius as i32)
    }

    /// Mean of the outermost ring.
    pub fn floor(&self) -> i32 {
        let (sum, _) = self.ring(MARGIN);
        sum / (8 * MARGIN as i32)
    }

    /// Sum over the 3 x 3 px at an offset.
    pub fn nine(&self, [x, y]: [i32; 2]) -> i32 {
        let places = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        places.fold(0, |sum, (x, y)| sum + self.pixel(x, y))
    }

    /// Sum over the square up to `half` from the middle and its first moments, in x and y.
    #[inline]
    pub fn moments(&self, half: usize) -> [i32; 3] {
        match half {
            2 => self.moments_of::<2>(),
            3 => self.moments_of::<3>(),
            4 => self.moments_of::<4>(),
            _ => self.moments_of::<6>(),
        }
    }

    fn moments_of<const HALF: usize>(&self) -> [i32; 3] {
        let mut moments = [self.square(HALF), 0, 0];
        for (dy, row) in self.rows::<HALF>() {
            let (mut sum, mut moment) = (0, 0);
            row.for_each(|(dx, value)| {
                sum += value;
                moment += value * dx;
            });
            let [_, x, y] = &mut moments;
            *x += moment;
            *y += sum * dy;
        }
        moments
    }

    /// Sums over the four sides of the ring just outside the region: left, right, top, bottom, corners in two
    /// of them.
    #[inline]
    pub fn sides(&self, half: usize) -> [i32; 4] {
        match half {
            2 => self.sides_of::<3>(),
            3 => self.sides_of::<4>(),
            4 => self.sides_of::<5>(),
            _ => self.sides_of::<7>(),
        }
    }

    fn sides_of<const RADIUS: usize>(&self) -> [i32; 4] {
        let square = || self.pixels.iter().skip(MARGIN - RADIUS).take(2 * RADIUS + 1);
        let column = |x: usize| square().map(|row| row.get(x).copied().unwrap_or(0)).sum();
        let row = |y: usize| {
            let row =
                self.pixels.get(y).map(|row| row.iter().skip(MARGIN - RADIUS).take(2 * RADIUS + 1).sum());
            row.unwrap_or(0)
        };
        [column(MARGIN - RADIUS), column(MARGIN + RADIUS), row(MARGIN - RADIUS), row(MARGIN + RADIUS)]
    }

    /// The pixel nearest to the centre of all light.
    pub fn middle_of_light(&self) -> Option<[usize; 2]> {
        let [sum, moment_x, moment_y] = self.moments(MARGIN - 1);
        let steps = |moment: i32| (2 * moment + sum).checked_div_euclid(2 * sum);
        let to = |from: usize, steps: i32| from.checked_add_signed(steps as isize);
        (sum > 0).then_some(())?;
        let [x, y] = self.at;
        Some([to(x, steps(moment_x)?)?, to(y, steps(moment_y)?)?])
    }
}
