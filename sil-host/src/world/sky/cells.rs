//! The sky in cells, so that an exposure looks at the stars near its field only.
//!
//! In: directions. Out: for a cone, the stars that may lie in it. The sphere is a cube whose faces carry
//! `SIDE`² squares each; a cell knows its middle and the angle to its farthest star.

use crate::world::attitude::{Vector, dot};
use crate::world::vector::{angle, unit};

/// Squares along the edge of a face.
const SIDE: usize = 16;
const CELLS: usize = 6 * SIDE * SIDE;

/// Numbers of stars, by where they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    cells: Vec<Cell>,
}

#[derive(Debug, Clone, PartialEq)]
struct Cell {
    middle: Vector,
    /// Cosine and sine of the angle to the farthest star.
    reach: [f64; 2],
    stars: Vec<u32>,
}

impl Cells {
    /// Puts `directions` into cells, in their order.
    pub fn new(directions: impl Iterator<Item = Vector>) -> Self {
        let mut members: Vec<Vec<(u32, Vector)>> = vec![Vec::new(); CELLS];
        for (star, direction) in (0u32..).zip(directions) {
            members[cell_of(direction)].push((star, direction));
        }
        let cell = |stars: Vec<(u32, Vector)>| {
            let sum = stars.iter().fold([0.0; 3], |sum, (_, d)| [0, 1, 2].map(|k| sum[k] + d[k]));
            let middle = unit(sum);
            let reach = stars.iter().map(|(_, d)| angle(middle, *d)).fold(0.0, f64::max);
            let stars = stars.into_iter().map(|(star, _)| star).collect();
            // A millionth more than rounding could take.
            let (sin, cos) = libm::sincos(reach + 1e-6);
            Cell { middle, reach: [cos, sin], stars }
        };
        Self { cells: members.into_iter().filter(|stars| !stars.is_empty()).map(cell).collect() }
    }

    /// Numbers of all stars within the cone of half angle `acos(cone_cosine)` about `axis`, and of some
    /// beside it, cell by cell.
    pub fn near(&self, axis: Vector, cone_cosine: f64) -> impl Iterator<Item = u32> + '_ {
        let cone_sine = (1.0 - cone_cosine * cone_cosine).max(0.0).sqrt();
        let touches = move |cell: &&Cell| {
            let [cos, sin] = cell.reach;
            // Beyond half a turn together the cones cannot miss each other.
            cone_cosine <= -cos || dot(axis, cell.middle) >= cone_cosine * cos - cone_sine * sin
        };
        self.cells.iter().filter(touches).flat_map(|cell| cell.stars.iter().copied())
    }
}

fn cell_of(d: Vector) -> usize {
    let axis = (0..3).max_by(|a, b| d[*a].abs().total_cmp(&d[*b].abs())).unwrap_or(0);
    let square = |k: usize| {
        let place = (0.5 + 0.5 * d[k] / d[axis].abs().max(f64::MIN_POSITIVE)) * SIDE as f64;
        (place as usize).min(SIDE - 1)
    };
    let face = 2 * axis + usize::from(d[axis] < 0.0);
    (face * SIDE + square((axis + 1) % 3)) * SIDE + square((axis + 2) % 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::attitude;
    use crate::world::noise::{Noise, Stream};

    #[test]
    fn a_cone_finds_all_of_its_stars_and_few_others() {
        let noise = Noise::new(5, 0, Stream::Attitude);
        let direction = |k| attitude::matrix(attitude::uniform(&noise, k))[2];
        let stars: Vec<Vector> = (0..20_000).map(direction).collect();
        let cells = Cells::new(stars.iter().copied());
        for k in 0..60 {
            let axis = direction(50_000 + k);
            let cosine = libm::cos([0.01, 0.27, 1.2, 3.0][k as usize % 4]);
            let mut found: Vec<u32> = cells.near(axis, cosine).collect();
            let number = found.len();
            found.sort_unstable();
            found.retain(|s| dot(axis, stars[*s as usize]) >= cosine);
            let expected: Vec<u32> =
                (0..20_000).filter(|s| dot(axis, stars[*s as usize]) >= cosine).collect();
            assert_eq!(found, expected);
            if k % 4 == 1 {
                assert!(number < 3 * expected.len(), "{number} for {}", expected.len());
            }
        }
    }
}
