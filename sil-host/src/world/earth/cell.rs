//! A cell of the Earth's image: what its points know, and what pixels within take from them.
//!
//! In: 3 x 3 [`Node`]s of a cell of [`WIDTH`] x [`HEIGHT`] px, the part of it that is drawn. Out: values of
//! its pixels, packed one after the other whatever the part's shape, so that four go side by side in a column
//! as in a row. Depth is biquadratic, the lowest point lies on parabolas along the rows, everything else is
//! bilinear between the corners. A pixel's value depends on its place in the cell only.

use std::ops::Range;

/// Width of a cell, px.
pub const WIDTH: usize = 16;
/// Height of a cell, px.
pub const HEIGHT: usize = 8;
/// Pixels of a cell.
pub const AREA: usize = WIDTH * HEIGHT;

/// Pixels that the processor takes at once, or a multiple of that.
const GROUP: usize = 8;

/// Numbers of the columns.
const COLUMNS: [f32; WIDTH] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// Values at a point of a cell: those of a line of sight that pixels need.
pub type Values = [f32; COUNT];
/// Number of values.
pub const COUNT: usize = 13;
/// The lowest point's x; y and z follow.
pub const NEAREST: usize = 0;
/// x of the direction back; y and z follow.
pub const BACK: usize = 3;
/// Height by which a unit of depth counts, km.
pub const KM_PER_DEPTH: usize = 6;
/// Width of the blur, km.
pub const SIGMA_KM: usize = 7;
/// Cube of the cosine off the axis.
pub const CUBE: usize = 8;
/// Slope of the view.
pub const SLOPE: usize = 9;
/// Way to the lowest point, km.
pub const WAY_KM: usize = 10;
/// Angle that a pixel cannot resolve, rad.
pub const SPREAD: usize = 11;

/// How far the limb moves across itself in a part of the exposure, km.
pub const MOVED_KM: usize = 12;

/// A point of a cell.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// `q` as the limb's height lifts it; NaN where there is no line of sight.
    pub depth: f32,
    /// All else; what only corners are asked for is 0 between them.
    pub values: Values,
}

/// The points of a cell, row by row.
pub type Cell<'a> = [[&'a Node; 3]; 3];

/// A number for every pixel of a part of a cell.
pub type Lane = [f32; AREA];

/// Pixels of a cell.
#[derive(Debug, Clone)]
pub struct Places {
    count: usize,
    /// Columns from the cell's left edge, px.
    x: Lane,
    /// Rows from its upper edge, heights of the cell.
    t: Lane,
}

impl Places {
    /// None yet.
    pub const EMPTY: Self = Self { count: 0, x: [0.0; AREA], t: [0.0; AREA] };

    /// How many they are.
    #[inline]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The same in whole `GROUP`s: what is computed for the places beyond the last is not looked at.
    #[inline]
    pub fn padded(&self) -> usize {
        self.count.next_multiple_of(GROUP).min(AREA)
    }

    /// Takes those of `columns`, at least one, and `rows`, counted from the cell's upper left corner, row by
    /// row.
    pub fn fill(&mut self, columns: Range<usize>, rows: Range<usize>) {
        let columns = &COLUMNS[columns];
        self.count = (rows.len() * columns.len()).min(AREA);
        let rooms = self.x.chunks_exact_mut(columns.len()).zip(self.t.chunks_exact_mut(columns.len()));
        for (row, (x, t)) in rows.zip(rooms) {
            let row = row as f32 / HEIGHT as f32;
            for ((x, t), column) in x.iter_mut().zip(t).zip(columns) {
                (*x, *t) = (*column, row);
            }
        }
    }

    /// Takes those of `other` that `lit` names.
    pub fn choose(&mut self, other: &Self, lit: &[u8]) {
        self.count = lit.len().min(AREA);
        for ((x, t), index) in self.x.iter_mut().zip(&mut self.t).zip(lit) {
            let index = usize::from(*index) % AREA;
            (*x, *t) = (other.x[index], other.t[index]);
        }
    }

    /// How deep their lines of sight dive.
    #[inline(never)]
    pub fn depth(&self, cell: &Cell, out: &mut Lane) {
        let column = |k: usize| [cell[0][k].depth, cell[1][k].depth, cell[2][k].depth];
        let (left, middle, right) = (column(0), column(1), column(2));
        for ((out, x), t) in out[..self.padded()].iter_mut().zip(&self.x).zip(&self.t) {
            let t = *t;
            // Written out: closures over arrays are not always made part of the loop they stand in.
            let across = [parabola(left, t), parabola(middle, t), parabola(right, t)];
            *out = parabola(across, x / WIDTH as f32);
        }
    }

    /// Their values `k`.
    // Alone, the compiler knows that nothing overlaps, and takes four at a time; the same below.
    #[inline(never)]
    pub fn values(&self, cell: &Cell, k: usize, out: &mut Lane) {
        let side = |column: usize| [cell[0][column].values[k], cell[2][column].values[k]];
        let (left, right) = (side(0), side(2));
        for ((out, x), t) in out[..self.padded()].iter_mut().zip(&self.x).zip(&self.t) {
            let (from, step) = line(left, right, *t);
            *out = from + x * step;
        }
    }

    /// Component `k` of their lowest points.
    #[inline(never)]
    pub fn nearest(&self, cell: &Cell, k: usize, out: &mut Lane) {
        let side = |column: usize| [cell[0][column].values[NEAREST + k], cell[2][column].values[NEAREST + k]];
        let (left, middle, right) = (side(0), side(1), side(2));
        for ((out, x), t) in out[..self.padded()].iter_mut().zip(&self.x).zip(&self.t) {
            let (from, step) = line(left, right, *t);
            let bend = between(middle, *t) - from - 0.5 * WIDTH as f32 * step;
            let s = x / WIDTH as f32;
            *out = from + x * step + 4.0 * s * (1.0 - s) * bend;
        }
    }
}

/// The value at the left end of a row of a cell, and its step from column to column.
#[inline]
fn line(left: [f32; 2], right: [f32; 2], t: f32) -> (f32, f32) {
    let from = between(left, t);
    (from, (between(right, t) - from) / WIDTH as f32)
}

#[inline]
fn between([above, below]: [f32; 2], t: f32) -> f32 {
    above + t * (below - above)
}

/// The parabola through three points, at 0, 1/2 and 1.
#[inline]
fn parabola([from, middle, to]: [f32; 3], t: f32) -> f32 {
    from + t * (to - from) + 4.0 * t * (1.0 - t) * (middle - 0.5 * (from + to))
}
