//! What the tests hold the flight code against: a seeded generator and the same mathematics in f64, written
//! apart from the flight code and by other methods where there are any (Rodrigues for rotations, Davenport's
//! q for attitude).

use nalgebra::{Matrix3, Matrix4, Vector3};

/// Arcseconds in a radian.
pub const ARCSEC: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// SplitMix64 (Steele, Lea, Flood 2014): one word of state, so a test's draw depends on its seed alone.
pub struct Generator(u64);

impl Generator {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        word ^ (word >> 31)
    }

    /// Evenly in `[low, high)`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Standard normal, by Box and Muller.
    pub fn gaussian(&mut self) -> f64 {
        let radius = (-2.0 * self.between(1e-300, 1.0).ln()).sqrt();
        radius * self.between(0.0, std::f64::consts::TAU).cos()
    }

    pub fn gaussian_vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.gaussian(), self.gaussian(), self.gaussian())
    }

    /// Evenly on the sphere.
    pub fn unit(&mut self) -> Vector3<f64> {
        self.gaussian_vector().normalize()
    }

    /// Evenly in the cap of this radius about +z.
    pub fn unit_in_cap(&mut self, radius_rad: f64) -> Vector3<f64> {
        let z = self.between(radius_rad.cos(), 1.0);
        let (sine, cosine) = self.between(0.0, std::f64::consts::TAU).sin_cos();
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * cosine, across * sine, z)
    }

    /// Evenly over all rotations, `[x, y, z, w]`.
    pub fn quaternion(&mut self) -> [f64; 4] {
        let q = [(); 4].map(|()| self.gaussian());
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        q.map(|x| x / norm)
    }

    /// Evenly over all rotations.
    pub fn rotation(&mut self) -> Matrix3<f64> {
        rotation_of(self.quaternion())
    }
}

pub fn wide(vector: &Vector3<f32>) -> Vector3<f64> {
    vector.map(f64::from)
}

pub fn wide_matrix(matrix: &Matrix3<f32>) -> Matrix3<f64> {
    matrix.map(f64::from)
}

fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Thesis eq. 2.4 as it is printed, `[x, y, z, w]` of unit length.
pub fn rotation_of([x, y, z, w]: [f64; 4]) -> Matrix3<f64> {
    let v = Vector3::new(x, y, z);
    Matrix3::identity() * (w * w - v.dot(&v)) + v * v.transpose() * 2.0 - cross_matrix(&v) * (2.0 * w)
}

/// Rodrigues' formula for components in a frame turned by the rotation vector: `exp(-[v×])`.
pub fn turn(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    if angle == 0.0 {
        return Matrix3::identity();
    }
    let axis = v / angle;
    let cross = cross_matrix(&axis);
    Matrix3::identity() - cross * angle.sin() + cross * cross * (1.0 - angle.cos())
}

/// The rotation vector of `to` against `from`, for angles well below 90 deg; sees neither scale nor shear.
pub fn small_turn(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Vector3<f64> {
    let m = to * from.transpose();
    Vector3::new(m.m23 - m.m32, m.m31 - m.m13, m.m12 - m.m21) * 0.5
}

/// Greatest element of `|A Aᵀ - I|`.
pub fn skewness(matrix: &Matrix3<f32>) -> f64 {
    let wide = wide_matrix(matrix);
    (wide * wide.transpose() - Matrix3::identity()).abs().max()
}

/// Wahba's problem by Davenport's q (thesis §3.1.4): the eigenvector of K with the largest eigenvalue, by
/// Jacobi rotations. Each item is (measured, reference, weight).
pub fn wahba(items: &[(Vector3<f64>, Vector3<f64>, f64)]) -> Matrix3<f64> {
    let b = items.iter().fold(Matrix3::zeros(), |sum, (b, r, a)| sum + b * r.transpose() * *a);
    let s = b + b.transpose();
    let z = Vector3::new(b.m23 - b.m32, b.m31 - b.m13, b.m12 - b.m21);
    let mut k = Matrix4::zeros();
    k.fixed_view_mut::<3, 3>(0, 0).copy_from(&(s - Matrix3::identity() * b.trace()));
    k.fixed_view_mut::<3, 1>(0, 3).copy_from(&z);
    k.fixed_view_mut::<1, 3>(3, 0).copy_from(&z.transpose());
    k[(3, 3)] = b.trace();
    let mut vectors = Matrix4::identity();
    for _ in 0..20 {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let (sine, cosine) = (0.5 * (2.0 * k[(p, q)]).atan2(k[(q, q)] - k[(p, p)])).sin_cos();
            let mut turn = Matrix4::identity();
            turn[(p, p)] = cosine;
            turn[(q, q)] = cosine;
            turn[(p, q)] = sine;
            turn[(q, p)] = -sine;
            k = turn.transpose() * k * turn;
            vectors *= turn;
        }
    }
    let largest = k.diagonal().imax();
    let q = vectors.column(largest).normalize();
    rotation_of([q[0], q[1], q[2], q[3]])
}
