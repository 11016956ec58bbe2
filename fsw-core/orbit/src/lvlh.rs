//! Local vertical, local horizontal (thesis fig. 2.3, §5.2): z down to the Earth's centre, y against the
//! orbit's normal, x along the flight (exactly so on a circle).

use nalgebra::{Matrix3, Vector3};

/// Smallest sine of the angle between position and velocity that still fixes the plane of the orbit.
const FLATTEST: f64 = 1e-3;

/// The rotation from ICRS axes to LVLH (rows are the LVLH axes); `None` without a plane of the orbit.
pub fn lvlh(position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let radius = libm::sqrt(position_km.dot(position_km));
    let speed = libm::sqrt(velocity_km_s.dot(velocity_km_s));
    let momentum = position_km.cross(velocity_km_s);
    let length = libm::sqrt(momentum.dot(&momentum));
    // Also refuses what is not finite.
    if !(length > FLATTEST * radius * speed && length > 0.0 && length < 1e12) {
        return None;
    }
    let z = -position_km / radius;
    let y = -momentum / length;
    let x = y.cross(&z);
    Some(Matrix3::new(x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z))
}

#[cfg(test)]
mod tests;
