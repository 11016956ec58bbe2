//! Truth attitude: quaternions `[x, y, z, w]`, scalar last, ICRS to sensor, in f64.
//!
//! `b = A(q) r` with `A(q) = (w² - |v|²) I + 2 v vᵀ - 2 w [v×]` (thesis eq. 2.4). A sensor turning with the
//! constant rate `ω` (rad/s, in its own axes) sees directions turn the other way, `A(t) = exp(-[ω×] t) A(0)`,
//! which is `q(t) = δ ⊗ q(0)` with `δ = [ω/|ω| sin(|ω| t / 2), cos(|ω| t / 2)]`.

use crate::world::noise::Noise;

/// A vector of three components.
pub type Vector = [f64; 3];

/// Dot product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The matrix `A(q)`, row by row.
pub fn matrix(q: [f64; 4]) -> [Vector; 3] {
    let [x, y, z, w] = q;
    let d = w * w - x * x - y * y - z * z;
    [
        [d + 2.0 * x * x, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), d + 2.0 * y * y, 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), d + 2.0 * z * z],
    ]
}

/// `matrix * vector`.
pub fn apply(matrix: &[Vector; 3], vector: Vector) -> Vector {
    [dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)]
}

/// The quaternion of `A(second) A(first)`.
pub fn compose(second: [f64; 4], first: [f64; 4]) -> [f64; 4] {
    let [ax, ay, az, aw] = second;
    let [bx, by, bz, bw] = first;
    [
        aw * bx + bw * ax - (ay * bz - az * by),
        aw * by + bw * ay - (az * bx - ax * bz),
        aw * bz + bw * az - (ax * by - ay * bx),
        aw * bw - (ax * bx + ay * by + az * bz),
    ]
}

/// `q` scaled to unit length with a scalar that is not negative; `None` when it is not finite or nearly zero.
pub fn normalised(q: [f64; 4]) -> Option<[f64; 4]> {
    let square: f64 = q.iter().map(|c| c * c).sum();
    if !(square.is_finite() && square > 1e-12) {
        return None;
    }
    let scale = if q[3] < 0.0 { -1.0 } else { 1.0 } / square.sqrt();
    Some(q.map(|c| c * scale))
}

/// A turning with constant rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    /// Attitude at time 0, ICRS to sensor.
    pub quaternion: [f64; 4],
    /// Angular rate in sensor axes, rad/s.
    pub rate_rad_s: Vector,
}

impl Turning {
    /// The attitude `t_s` seconds after time 0.
    pub fn at(&self, t_s: f64) -> [f64; 4] {
        let rate = dot(self.rate_rad_s, self.rate_rad_s).sqrt();
        let half = 0.5 * rate * t_s;
        // sin(a t / 2) / a tends to t / 2 where the rate vanishes.
        let scale = if rate > 0.0 { libm::sin(half) / rate } else { 0.5 * t_s };
        let [x, y, z] = self.rate_rad_s.map(|c| c * scale);
        let turned = compose([x, y, z, libm::cos(half)], self.quaternion);
        normalised(turned).unwrap_or(self.quaternion)
    }
}

/// A quaternion uniform over all rotations (Shoemake 1992): a pure function of `noise` and `index`.
pub fn uniform(noise: &Noise, index: u32) -> [f64; 4] {
    let u = |n| noise.uniform(index, n);
    let (inner, outer) = (libm::sqrt(1.0 - u(0)), libm::sqrt(u(0)));
    let (a, b) = (std::f64::consts::TAU * u(1), std::f64::consts::TAU * u(2));
    let q = [inner * libm::sin(a), inner * libm::cos(a), outer * libm::sin(b), outer * libm::cos(b)];
    normalised(q).unwrap_or([0.0, 0.0, 0.0, 1.0])
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

/// The rotation vector that turns attitude `before` into `after`, axes of what is turned, rad; small angles.
pub fn small_turn(after: [f64; 4], before: [f64; 4]) -> Vector {
    let [x, y, z, w] = before;
    let [x, y, z, w] = compose(after, [-x, -y, -z, w]);
    let sign = if w < 0.0 { -2.0 } else { 2.0 };
    [sign * x, sign * y, sign * z]
}

/// The quaternion of a rotation matrix, `matrix(quaternion(A)) = A`, scalar not negative.
///
/// The largest of the four components is found from the diagonal, the others from sums and differences across
/// it (Shepperd 1978), so that no small number is divided by.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::noise::Stream;
    use proptest::prelude::*;

    fn quaternion() -> impl Strategy<Value = [f64; 4]> {
        prop::array::uniform4(-1.0..1.0f64).prop_filter_map("zero", normalised)
    }

    proptest! {
        #[test]
        fn composition_is_the_product_of_the_matrices(a in quaternion(), b in quaternion(),
                                                       r in prop::array::uniform3(-1.0..1.0f64)) {
            let once = apply(&matrix(compose(a, b)), r);
            let twice = apply(&matrix(a), apply(&matrix(b), r));
            for (x, y) in once.iter().zip(twice) {
                prop_assert!((x - y).abs() < 1e-12);
            }
        }

        #[test]
        fn the_matrix_is_orthogonal_and_right_handed(q in quaternion()) {
            let [r0, r1, r2] = matrix(q);
            prop_assert!((dot(r0, r0) - 1.0).abs() < 1e-12 && dot(r0, r1).abs() < 1e-12);
            let cross = [r0[1] * r1[2] - r0[2] * r1[1], r0[2] * r1[0] - r0[0] * r1[2], r0[0] * r1[1] - r0[1] * r1[0]];
            prop_assert!((dot(cross, r2) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sensor_turning_about_y_sees_stars_move_to_minus_x() {
        // Turning +y carries the line of sight (+z) to +x, so what was ahead is now at -x.
        let motion = Turning { quaternion: [0.0, 0.0, 0.0, 1.0], rate_rad_s: [0.0, 0.01, 0.0] };
        let seen = apply(&matrix(motion.at(1.0)), [0.0, 0.0, 1.0]);
        assert!((seen[0] + 0.01f64.sin()).abs() < 1e-12 && seen[1].abs() < 1e-15);
    }

    #[test]
    fn random_attitudes_point_everywhere_alike() {
        let noise = Noise::new(11, 0, Stream::Attitude);
        let count = 4000;
        let mut mean = [0.0; 3];
        let mut polar = 0.0;
        for index in 0..count {
            let boresight = matrix(uniform(&noise, index))[2];
            (0..3).for_each(|k| mean[k] += boresight[k] / f64::from(count));
            polar += boresight[2] * boresight[2] / f64::from(count);
        }
        // Each component has variance 1/3: 4 sigma of the mean is 0.037; of the mean square 0.019.
        assert!(mean.iter().all(|m| m.abs() < 0.037), "{mean:?}");
        assert!((polar - 1.0 / 3.0).abs() < 0.019, "{polar}");
    }
}
