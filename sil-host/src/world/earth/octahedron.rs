//! The sphere unfolded as an octahedron onto a square, for maps without poles.
//!
//! `(x, y) / (|x| + |y| + |z|)`, the southern half turned out; opposite points of an edge are the same place,
//! so that no seam shows. In and out: places in axes that turn with the Earth, and (u, v) from 0 to 1 across
//! the square.

use crate::world::attitude::Vector;
use crate::world::vector::unit;

/// Where on the square a place of any length is.
#[inline]
pub fn unfolded([x, y, z]: [f32; 3]) -> [f32; 2] {
    let scale = 0.5 / (x.abs() + y.abs() + z.abs());
    let (u, v) = (x * scale, y * scale);
    let (a, b) = (u.abs(), v.abs());
    // South of the equator the triangle is turned over its edge.
    let (a, b) = if z < 0.0 { (0.5 - b, 0.5 - a) } else { (a, b) };
    [0.5 + a.copysign(x), 0.5 + b.copysign(y)]
}

/// The place, of length 1, at (`u`, `v`) of the square.
pub fn folded(u: f64, v: f64) -> Vector {
    let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let z = 1.0 - u.abs() - v.abs();
    if z < 0.0 {
        unit([(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v), z])
    } else {
        unit([u, v, z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::attitude::{matrix, uniform};
    use crate::world::noise::{Noise, Stream};

    #[test]
    fn folding_and_unfolding_are_inverse() {
        let noise = Noise::new(5, 0, Stream::Attitude);
        for index in 0..5000 {
            let place = matrix(uniform(&noise, index))[2];
            let [u, v] = unfolded(place.map(|c| c as f32)).map(f64::from);
            let back = folded(u, v);
            assert!((0..3).all(|k| (back[k] - place[k]).abs() < 1e-5), "{place:?} {back:?}");
        }
    }
}
