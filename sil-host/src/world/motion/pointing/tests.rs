//! Tests of the laws, and of attitude and rate under all of them at once.

use super::super::jitter::{JitterModel, Line};
use super::super::moving_frame::{rate_error, turned_about};
use super::*;
use crate::world::attitude::matrix;
use crate::world::earth::EQUATOR_KM;
use crate::world::orbit::state_of_elements;
use crate::world::vector::angle;
use fsw_core::orbit::body::CentralBody;
use proptest::prelude::*;

fn close(a: Vector, b: Vector) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

/// A transfer orbit about its perigee, where the rate changes fastest.
fn orbit() -> TruthOrbit {
    let (r, v) = state_of_elements(CentralBody::Earth, [24_478.0, 0.731, 27.0, 40.0, 178.0, -20.0]).unwrap();
    TruthOrbit::new(843_393_969_184_000, r, v, 900).unwrap()
}

fn shaken() -> Jitter {
    let line = Line { frequency_hz: 3.0, amplitude_arcsec: [5.0, 4.0, 9.0] };
    let model = JitterModel { random_arcsec: [20.0; 3], correlation_s: 20.0, lines: vec![line] };
    Jitter::new(&model, 7)
}

fn slews() -> Vec<Slew> {
    let slew = |start_s, axis, angle_rad| Slew { start_s, duration_s: 60.0, axis, angle_rad };
    vec![slew(30.0, [0.0, 0.6, 0.8], 1.0), slew(100.0, [1.0, 0.0, 0.0], -0.7)]
}

fn aim() -> Aim {
    Aim { ra_deg: 83.8, dec_deg: -5.4, roll_deg: 30.0 }
}

fn laws() -> [Law; 4] {
    let tumble = Tumble::new(quaternion(&aim().matrix()), [0.1, 0.2, -0.1], [1.0, 1.4, 2.0], 900);
    [
        Law::Nadir { off_nadir_deg: 71.0, roll_deg: 90.0 },
        Law::Horizon { below_deg: 3.0, roll_deg: -40.0 },
        Law::Inertial(aim()),
        Law::Spin(tumble),
    ]
}

#[test]
fn without_angles_the_earth_path_looks_down_with_x_along_flight() {
    let orbit = orbit();
    let (position, velocity) = orbit.at(10.0);
    let [x, y, z] = Pointing::default().earth_path(10.0, &orbit).matrix;
    let normal = unit(cross(position, velocity));
    assert!(close(z, times(-1.0, unit(position))) && close(y, times(-1.0, normal)));
    assert!(dot(x, velocity) > 7.0 && dot(x, position).abs() < 1e-9 && close(cross(x, y), z));
}

#[test]
fn off_nadir_raises_the_line_of_sight_towards_flight() {
    let orbit = orbit();
    let at =
        |off_nadir_deg, roll_deg| Pointing::nadir(off_nadir_deg, roll_deg).earth_path(0.0, &orbit).matrix;
    let (down, raised, rolled) = (at(0.0, 0.0), at(60.0, 0.0), at(60.0, 90.0));
    let expected = plus(times(0.5, down[2]), 0.75f64.sqrt(), down[0]);
    assert!(close(raised[2], expected) && close(raised[1], down[1]));
    assert!(close(rolled[2], expected) && close(rolled[0], raised[1]));
}

#[test]
fn the_horizon_stays_as_far_above_the_line_of_sight_from_perigee_outwards() {
    let orbit = orbit();
    let pointing = Pointing::from(Law::Horizon { below_deg: 2.0, roll_deg: 90.0 });
    for t in [0.0, 300.0, 900.0] {
        let (position, velocity) = orbit.at(t);
        let [.., sight] = pointing.earth_path(t, &orbit).matrix;
        let horizon = libm::asin(EQUATOR_KM / length(position)).to_degrees();
        assert!((angle(sight, times(-1.0, position)).to_degrees() - (horizon - 2.0)).abs() < 1e-9);
        let normal = unit(cross(position, velocity));
        assert!(dot(sight, velocity) > 0.0 && dot(sight, normal).abs() < 1e-12);
    }
}

#[test]
fn an_inertial_line_of_sight_stays_at_its_place_with_x_east_and_y_north() {
    let orbit = orbit();
    let pointing = Pointing::from(Law::Inertial(Aim { roll_deg: 0.0, ..aim() }));
    let frame = pointing.earth_path(0.0, &orbit);
    assert_eq!(frame, pointing.earth_path(777.7, &orbit));
    assert_eq!(frame.rate_rad_s, [0.0; 3]);
    let [x, y, z] = frame.matrix;
    assert!((libm::atan2(z[1], z[0]).to_degrees() - 83.8).abs() < 1e-12);
    assert!((libm::asin(z[2]).to_degrees() + 5.4).abs() < 1e-12);
    assert!(x[2].abs() < 1e-15 && y[2] > 0.9 && close(cross(x, y), z));
    let [rolled, _, same] = aim().matrix();
    assert!(close(same, z) && close(rolled, plus(times(0.75f64.sqrt(), x), 0.5, y)));
}

#[test]
fn slews_turn_the_body_one_after_the_other_about_its_own_axes() {
    let pointing = Pointing { slews: slews(), ..Law::Inertial(aim()).into() };
    let end = pointing.earth_path(500.0, &orbit()).matrix;
    let first = product(&turned_about([0.0, 0.6, 0.8], 1.0), &aim().matrix());
    let both = product(&turned_about([1.0, 0.0, 0.0], -0.7), &first);
    assert!(end.iter().zip(both).all(|(a, b)| close(*a, b)));
    let between = pointing.earth_path(95.0, &orbit()).matrix;
    assert!(between.iter().zip(first).all(|(a, b)| close(*a, b)));
}

#[test]
fn the_rate_is_the_derivative_of_the_attitude_under_every_law_with_slews_and_jitter() {
    let orbit = orbit();
    for law in laws() {
        for (slews, jitter) in [(Vec::new(), Jitter::default()), (slews(), shaken())] {
            let pointing = Pointing { law: law.clone(), slews, jitter };
            for t in [0.1, 47.0, 91.0, 131.3, 402.2, 899.0] {
                let error = rate_error(|t| pointing.earth_path(t, &orbit), t, 2e-3);
                assert!(error < 2e-9, "{law:?} at {t}: {error}");
            }
        }
    }
}

#[test]
fn any_instant_alone_is_the_same_to_the_bit() {
    let orbit = orbit();
    for law in laws() {
        let pointing = Pointing { law, slews: slews(), jitter: shaken() };
        let forward: Vec<_> = (0..300).map(|k| pointing.earth_path(1.3 * f64::from(k), &orbit)).collect();
        for k in (0..300).rev() {
            assert_eq!(pointing.clone().earth_path(1.3 * f64::from(k), &orbit), forward[k as usize]);
        }
    }
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
