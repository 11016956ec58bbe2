//! The misalignment of the paths, learned in flight from the limb while the ground gives the orbit.

use crate::flights::{self, scenario};
use sil_host::judge::{arcsec, attitude_error};
use sil_host::scenario::Believed;
use sil_host::scenario::orbit_filter::{GroundStart, OrbitFilterModel};
use sil_host::world::attitude::Vector;
use sil_host::world::vector::{length, minus};

/// The mount as the flight code is told it is off by so much, and it is told a sigma of 0.1 deg.
const MOUNT_DEG: Vector = [0.1, -0.06, 0.08];
const SIGMA_ARCSEC: f64 = 360.0;
/// How well the ground tells the orbit, and how wrong it is: a ranging station.
const GROUND: GroundStart = GroundStart {
    position_sigma_km: 0.1,
    velocity_sigma_m_s: 0.01,
    position_error_km: [0.05, -0.08, 0.1],
    velocity_error_m_s: [0.005, 0.005, -0.005],
    drawn: false,
};

/// Flies so many seconds of a scenario whose mount is told wrong, and gives what is learned of it less what
/// is true, its sigmas, arcsec, and the greatest error of the position, km.
fn learned(name: &str, seconds: u32) -> (Vector, Vector, f64) {
    let mut scenario = scenario(name, seconds);
    scenario.believed = Believed { mount_deg: MOUNT_DEG, ..Believed::TRUTH };
    scenario.orbit_filter = OrbitFilterModel {
        misalignment_sigma_deg: Some(SIGMA_ARCSEC / 3600.0),
        start: Some(GROUND),
        ..scenario.orbit_filter
    };
    let told = scenario.believed.star_to_earth(&scenario.mount);
    let mount = scenario.mount.star_to_earth().map(|part| part as f32);
    let sure = attitude_error(mount, told).map(arcsec);
    let wide = |rad: [f32; 3]| rad.map(|angle| arcsec(angle.into()));
    let (mut last, mut farthest_km) = (None, 0.0f64);
    flights::fly(&scenario, |second| {
        if let (Some(orbit), Some(judged)) = (&second.report.orbit, &second.judged.orbit) {
            farthest_km = farthest_km.max(length(judged.position_km.axes.error));
            last = Some((wide(orbit.misalignment_rad), wide(orbit.misalignment_sigma_rad)));
        }
    });
    let (learned, sigma) = last.expect("an orbit");
    (minus(learned, sure), sigma, farthest_km)
}

#[test]
fn a_mount_a_tenth_of_a_degree_off_is_learned_from_geo_where_the_ground_gives_the_orbit() {
    // Two hours before the eclipse. The limb's uneven height, 2 km, is 10 arcsec.
    let seconds = 7200;
    let (error, sigma, farthest_km) = learned("geo-eclipse", seconds);
    println!(
        "GEO, {seconds} s: misalignment of 0.1 deg learned to {error:.1?} arcsec about x, y, z, sigma {sigma:.1?}; \
         position off by {farthest_km:.2} km at most"
    );
    for axis in 0..2 {
        assert!(sigma[axis] < 15.0 && error[axis].abs() < 3.0 * sigma[axis]);
    }
    // A circle does not show a turn about its middle.
    assert!((0.9..=1.001).contains(&(sigma[2] / SIGMA_ARCSEC)) && error[2].abs() < 3.0 * sigma[2]);
    assert!(farthest_km < 0.3);
}
