//! How the two paths look: the Earth path from the orbit, the star path from the mounting.
//!
//! In: position and velocity (ICRS), pointing, mounting angles. Out: direction cosine matrices, components of the first
//! frame to components of the second.
//!
//! The Earth path's frame without off-nadir and roll: z to the Earth's centre, x along flight in the orbit plane,
//! y = z x x, against the orbit normal (LVLH). `off_nadir_deg` turns the line of sight from nadir towards flight, so that
//! z = cos · nadir + sin · flight; `roll_deg` then turns about z. The star path's frame is that of the Earth path
//! turned about x, then y, then z of the turned frame: `[0, 90, 0]` looks along flight, `[90, 0, 0]` along the orbit
//! normal when the Earth path looks to nadir.

use super::attitude::{Vector, normalised};
use super::vector::{cross, plus, product, times, transposed, unit};

/// Where the Earth path looks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pointing {
    /// Angle of the line of sight from nadir towards flight, degrees.
    pub off_nadir_deg: f64,
    /// Angle by which the frame is then turned about the line of sight, degrees.
    pub roll_deg: f64,
}

impl Pointing {
    /// ICRS to the Earth path's frame, from position and velocity about the Earth's centre.
    pub fn icrs_to_earth_path(&self, position: Vector, velocity: Vector) -> [Vector; 3] {
        let nadir = times(-1.0, unit(position));
        let y = times(-1.0, unit(cross(position, velocity)));
        let flight = cross(y, nadir);
        let (sine, cosine) = sine_cosine(self.off_nadir_deg);
        let z = plus(times(cosine, nadir), sine, flight);
        let x = plus(times(cosine, flight), -sine, nadir);
        let (sine, cosine) = sine_cosine(self.roll_deg);
        [plus(times(cosine, x), sine, y), plus(times(cosine, y), -sine, x), z]
    }
}

/// How the star path is mounted beside the Earth path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mount {
    /// Angles about x, then y, then z of the turned frame, degrees.
    pub star_path_deg: [f64; 3],
}

impl Mount {
    /// Earth path to star path.
    pub fn earth_to_star(&self) -> [Vector; 3] {
        let [x, y, z] = self.star_path_deg.map(f64::to_radians);
        product(&rotation(2, z), &product(&rotation(1, y), &rotation(0, x)))
    }

    /// The quaternion `[x, y, z, w]` whose matrix takes components in the star path's frame to the Earth path's.
    pub fn star_to_earth(&self) -> [f64; 4] {
        quaternion(&transposed(&self.earth_to_star()))
    }
}

/// The matrix that takes components to a frame turned by `angle_rad` about axis 0 (x), 1 (y) or 2 (z).
pub fn rotation(axis: usize, angle_rad: f64) -> [Vector; 3] {
    let (s, c) = libm::sincos(angle_rad);
    match axis {
        0 => [[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]],
        1 => [[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]],
        _ => [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]],
    }
}

/// The quaternion of a rotation matrix, `matrix(quaternion(A)) = A`, scalar not negative.
///
/// The largest of the four components is found from the diagonal, the others from sums and differences across it
/// (Shepperd 1978), so that no small number is divided by.
pub fn quaternion(a: &[Vector; 3]) -> [f64; 4] {
    let trace = a[0][0] + a[1][1] + a[2][2];
    let squares = [0, 1, 2].map(|k| 1.0 + 2.0 * a[k][k] - trace);
    let (yz, zx, xy) = (a[1][2] + a[2][1], a[2][0] + a[0][2], a[0][1] + a[1][0]);
    let (x, y, z) = (a[1][2] - a[2][1], a[2][0] - a[0][2], a[0][1] - a[1][0]);
    let w = 1.0 + trace;
    let largest = squares.iter().fold(w, |most, square| most.max(*square));
    let parallel = match largest {
        m if m == w => [x, y, z, w],
        m if m == squares[0] => [squares[0], xy, zx, x],
        m if m == squares[1] => [xy, squares[1], yz, y],
        _ => [zx, yz, squares[2], z],
    };
    normalised(parallel).unwrap_or([0.0, 0.0, 0.0, 1.0])
}

fn sine_cosine(degrees: f64) -> (f64, f64) {
    libm::sincos(degrees.to_radians())
}

#[cfg(test)]
mod tests {
    use super::super::attitude::{apply, dot, matrix};
    use super::*;
    use proptest::prelude::*;

    const POSITION: Vector = [7000.0, 0.0, 0.0];
    const VELOCITY: Vector = [0.4, 7.0, 2.0];

    fn close(a: Vector, b: Vector) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn without_angles_the_earth_path_looks_down_with_x_along_flight() {
        let [x, y, z] = Pointing::default().icrs_to_earth_path(POSITION, VELOCITY);
        let normal = unit(cross(POSITION, VELOCITY));
        assert!(close(z, [-1.0, 0.0, 0.0]) && close(y, times(-1.0, normal)));
        assert!(dot(x, VELOCITY) > 7.0 && dot(x, POSITION).abs() < 1e-9 && close(cross(x, y), z));
    }

    #[test]
    fn off_nadir_raises_the_line_of_sight_towards_flight() {
        let down = Pointing::default().icrs_to_earth_path(POSITION, VELOCITY);
        let raised = Pointing { off_nadir_deg: 60.0, roll_deg: 0.0 }.icrs_to_earth_path(POSITION, VELOCITY);
        let expected = plus(times(0.5, down[2]), 0.75f64.sqrt(), down[0]);
        assert!(close(raised[2], expected) && close(raised[1], down[1]));
        let rolled = Pointing { off_nadir_deg: 60.0, roll_deg: 90.0 }.icrs_to_earth_path(POSITION, VELOCITY);
        assert!(close(rolled[2], expected) && close(rolled[0], raised[1]));
    }

    #[test]
    fn mounting_angles_point_the_star_path_where_the_documentation_says() {
        let sight = |star_path_deg| Mount { star_path_deg }.earth_to_star()[2];
        assert!(close(sight([0.0, 90.0, 0.0]), [1.0, 0.0, 0.0]));
        assert!(close(sight([90.0, 0.0, 0.0]), [0.0, -1.0, 0.0]));
        assert!(close(sight([-90.0, 0.0, 0.0]), [0.0, 1.0, 0.0]));
        // Turning about z last leaves the line of sight alone.
        assert!(close(sight([90.0, 0.0, 37.0]), [0.0, -1.0, 0.0]));
    }

    proptest! {
        #[test]
        fn a_mounting_is_a_rotation_and_its_quaternion_goes_the_other_way(
            star_path_deg in prop::array::uniform3(-180.0..180.0f64), v in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let mount = Mount { star_path_deg };
            let there = apply(&mount.earth_to_star(), v);
            prop_assert!(close(apply(&matrix(mount.star_to_earth()), there), v));
            let [x, y, z] = mount.earth_to_star();
            prop_assert!(close(cross(x, y), z));
        }
    }
}
