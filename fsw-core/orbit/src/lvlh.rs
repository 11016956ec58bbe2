//! Local vertical, local horizontal (thesis fig. 2.3, §5.2): z down to the Earth's centre, y against the
//! orbit's normal, x along the flight (exactly so on a circle). Hill's axes are the same in another order and
//! sense: outwards, along, across (eq. 5.28).

use fsw_ground::matrix::{cross, dot, scaled};
use nalgebra::{Matrix3, Vector3};

/// Smallest sine of the angle between position and velocity that still fixes the plane of the orbit.
const FLATTEST: f64 = 1e-3;

/// The rotation from ICRS axes to LVLH (rows are the LVLH axes); `None` without a plane of the orbit.
pub fn lvlh(position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let radius = libm::sqrt(dot(position_km, position_km));
    let speed = libm::sqrt(dot(velocity_km_s, velocity_km_s));
    let momentum = cross(position_km, velocity_km_s);
    let length = libm::sqrt(dot(&momentum, &momentum));
    // Also refuses what is not finite.
    if !(length > FLATTEST * radius * speed && length > 0.0 && length < 1e12) {
        return None;
    }
    let z = scaled(position_km, -1.0 / radius);
    let y = scaled(&momentum, -1.0 / length);
    let x = cross(&y, &z);
    Some(Matrix3::new(x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z))
}

/// The rotation from ICRS axes to Hill's (rows are Hill's axes): radial, outwards; along the track; across it,
/// along the orbit's normal. `None` without a plane of the orbit.
pub fn hill(position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let [x, y, z] = lvlh(position_km, velocity_km_s)?.transpose().data.0.map(Vector3::from);
    Some(Matrix3::from_columns(&[scaled(&z, -1.0), x, scaled(&y, -1.0)]).transpose())
}

#[cfg(test)]
mod tests;
