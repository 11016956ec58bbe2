//! Tests: durations by hand, laws by their angles, steps against every second. The flown scenarios are held
//! against it second by second in the system tests.

use super::*;
use crate::camera::Camera;
use crate::oracle;
use crate::orbit::body::EARTH;

const GEO_KM: f64 = 42_164.17;
/// 2026-09-23 18:00 UTC, hours from the equinox: the Sun lies in the plane of the equator.
const EQUINOX_US: i64 = 843_458_469_184_000;

/// A circular orbit in the equator's plane that begins so many degrees west of the line from the Sun through
/// the Earth.
fn equatorial(radius_km: f64, before_deg: f64) -> OrbitState {
    let sun = Bodies::at(CentralBody::Earth, EQUINOX_US).sun_km;
    let angle = libm::atan2(-sun.y, -sun.x) - before_deg.to_radians();
    let speed = libm::sqrt(EARTH.mu_km3_s2 / radius_km);
    OrbitState {
        time_us: EQUINOX_US,
        position_km: Vector3::new(libm::cos(angle), libm::sin(angle), 0.0) * radius_km,
        velocity_km_s: Vector3::new(-libm::sin(angle), libm::cos(angle), 0.0) * speed,
    }
}

fn camera() -> Camera {
    Camera::new(oracle::reference_camera()).unwrap()
}

/// The star path along flight when the Earth path looks down.
fn along_flight() -> Rotation<StarPath, EarthPath> {
    Rotation::from_orthogonal(Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0))
}

fn forecast<'a>(camera: &'a Camera, earth: &'a EarthParameters, pointing: PointingLaw) -> Forecast<'a> {
    Forecast { camera, star_to_earth: along_flight(), pointing, earth, forces: Forces::KEPLER }
}

fn down() -> PointingLaw {
    PointingLaw::nadir(0.0, 0.0)
}

/// States and their seconds, in their order, over a span.
fn intervals(forecast: &Forecast<'_>, first: OrbitState, seconds: i64) -> std::vec::Vec<(SensorState, i64)> {
    let mut orbit = first;
    let mut state = forecast.state(&orbit).unwrap();
    let mut found = std::vec![(state, 0)];
    while orbit.time_us < first.time_us + seconds * 1_000_000 {
        let (later, next) = forecast.step(&orbit, state).unwrap();
        found.last_mut().unwrap().1 += (later.time_us - orbit.time_us) / 1_000_000;
        if next != state {
            found.push((next, 0));
        }
        (orbit, state) = (later, next);
    }
    found
}

#[test]
fn a_geostationary_midnight_lasts_as_long_as_the_angles_say() {
    let (camera, earth) = (camera(), EarthParameters::default());
    let found = intervals(&forecast(&camera, &earth, down()), equatorial(GEO_KM, 15.0), 7_200);
    let states: std::vec::Vec<u8> = found.iter().map(|(state, _)| *state as u8).collect();
    // The Sun enters the field, sets behind the Earth, rises, leaves.
    assert_eq!(states, [0, 1, 2, 1, 0], "{found:?}");
    // By hand: the Sun moves 360 deg in a revolution of 86,164 s, less what the Earth goes on in a year.
    let s_per_deg = 86_400.0 / 360.0;
    let disc_deg = 2.0 * f64::from(SUN_RADIUS_RAD).to_degrees();
    let earth_deg = 2.0 * libm::asin(EARTH.radius_km / GEO_KM).to_degrees();
    // Flight is along x, of 1280 px.
    let field_deg = 2.0 * libm::atan(640.0 / 3000.0).to_degrees();
    let hidden_s = (earth_deg - disc_deg) * s_per_deg;
    let beside_s = 0.5 * (field_deg + disc_deg) * s_per_deg - 0.5 * hidden_s;
    for ((_, seconds), expected) in found[1..4].iter().zip([beside_s, hidden_s, beside_s]) {
        std::println!("{seconds} s, by hand {expected:.0} s");
        // The Sun stands 0.1 deg off the plane, and the distance to it is not 1 au: 4 s.
        assert!((*seconds as f64 - expected).abs() < 4.0, "{seconds} {expected}");
    }
}

#[test]
fn the_star_path_along_flight_meets_the_sun_a_quarter_of_a_revolution_after_the_earth_path() {
    let (camera, earth) = (camera(), EarthParameters::default());
    // Flight towards the Sun: a quarter after midnight.
    let found = intervals(&forecast(&camera, &earth, down()), equatorial(GEO_KM, -74.0), 9_000);
    let states: std::vec::Vec<u8> = found.iter().map(|(state, _)| *state as u8).collect();
    assert_eq!(states, [0, 3, 4, 3, 0], "{found:?}");
    // Its image crosses that of the Earth, 17.4 deg wide.
    let over_s = 2.0 * libm::asin(EARTH.radius_km / GEO_KM).to_degrees() * 240.0;
    assert!((found[2].1 as f64 - over_s).abs() < 6.0, "{found:?} {over_s}");
}

#[test]
fn steps_find_the_seconds_that_looking_at_every_second_finds() {
    let (camera, earth) = (camera(), EarthParameters::default());
    let law = PointingLaw::Horizon { below_rad: 0.0, roll_rad: 1.0 };
    let forecast = forecast(&camera, &earth, law);
    let first = equatorial(7_176.0, 100.0);
    let mut state = forecast.state(&first).unwrap();
    let mut slowly = std::vec![(state, 0)];
    let mut orbit = first;
    for _ in 0..6_000 {
        orbit = forecast.forces.propagate(&orbit, 1_000_000).unwrap();
        let next = forecast.state(&orbit).unwrap();
        slowly.last_mut().unwrap().1 += 1;
        if next != state {
            slowly.push((next, 0));
        }
        state = next;
    }
    let mut quickly = intervals(&forecast, first, 6_000);
    assert!(slowly.len() > 2, "{slowly:?}");
    // The last one is cut off where the walk ends.
    for list in [&mut slowly, &mut quickly] {
        list.last_mut().unwrap().1 = 0;
    }
    assert_eq!(slowly, quickly);
}

#[test]
fn an_outlook_finds_the_next_two_changes_to_the_second() {
    let (camera, earth) = (camera(), EarthParameters::default());
    for (radius_km, before_deg, law) in [
        (7_176.0, 100.0, PointingLaw::Horizon { below_rad: 0.0, roll_rad: 1.0 }),
        (GEO_KM, 15.0, down()),
        (GEO_KM, 4.0, down()),
    ] {
        let forecast = forecast(&camera, &earth, law);
        let first = equatorial(radius_km, before_deg);
        let mut outlook = Outlook::new(&forecast, &first).unwrap();
        let mut steps = 0;
        while !outlook.is_over() {
            outlook.step(&forecast).unwrap();
            steps += 1;
        }
        let slowly = intervals(&forecast, first, 10_000);
        let at = |count: usize| slowly[..count].iter().map(|(_, seconds)| seconds).sum::<i64>();
        let found = outlook.found().map(|change| change.unwrap());
        for (change, count) in found.iter().zip([1, 2]) {
            // The Sun's coming and going has none.
            let limb = |state: SensorState| state.rests_on_limb();
            assert_eq!(change.pace_rad_s.is_some(), limb(slowly[count].0) && limb(slowly[count - 1].0));
            assert_eq!(change.time_us, first.time_us + at(count) * 1_000_000, "{slowly:?}");
            assert_eq!(change.state, slowly[count].0);
        }
        std::println!("{radius_km} km: {steps} steps for {} s", at(2));
        assert!(steps < 1_300);
    }
}

#[test]
fn the_pace_of_the_limb_bounds_by_how_much_a_lower_sun_shifts_an_eclipse() {
    let camera = camera();
    let sun = Bodies::at(CentralBody::Earth, EQUINOX_US).sun_km.normalize();
    let up = Vector3::new(0.0, 0.0, 1.0);
    let radius_km = 7_176.0;
    // The angle between the Sun and the normal of the orbit: nearly above the terminator, and nearly not.
    for (normal_deg, least, most) in [(8.5f64, 0.05, 0.3), (45.0, 0.4, 1.0), (80.0, 0.7, 1.2)] {
        let normal = sun * normal_deg.to_radians().cos() + up * normal_deg.to_radians().sin();
        let begin = normal.cross(&up).normalize();
        let first = OrbitState {
            time_us: EQUINOX_US,
            position_km: begin * radius_km,
            velocity_km_s: normal.cross(&begin) * libm::sqrt(EARTH.mu_km3_s2 / radius_km),
        };
        // Lit from two elevations of the Sun.
        let [(low, pace), (high, _)] = [3.0, 3.5].map(|lit_deg| {
            let mut earth = EarthParameters::default();
            earth.light.lit_deg = lit_deg;
            let law = PointingLaw::Horizon { below_rad: 0.0, roll_rad: core::f32::consts::FRAC_PI_2 };
            let forecast = forecast(&camera, &earth, law);
            let mut outlook = Outlook::new(&forecast, &first).unwrap();
            while !outlook.is_over() {
                outlook.step(&forecast).unwrap();
            }
            let mut changes = outlook.found().map(|change| change.unwrap()).into_iter();
            let eclipse = changes.find(|change| change.state == SensorState::Eclipse).unwrap();
            (eclipse.time_us, f64::from(eclipse.pace_rad_s.unwrap()))
        });
        let sooner_s = (low - high) as f64 * 1e-6;
        let expected_s = (3.5f64.to_radians().sin() - 3.0f64.to_radians().sin()) / pace;
        let circling_rad_s = libm::sqrt(EARTH.mu_km3_s2 / (radius_km * radius_km * radius_km));
        std::println!(
            "{normal_deg} deg: pace {:.2} of the satellite's, {sooner_s} s sooner, {expected_s:.1} at most",
            pace / circling_rad_s,
        );
        assert!((least..most).contains(&(pace / circling_rad_s)));
        // A part of the angle goes into the limb beside the field where both bound it: at most half.
        assert!((0.5 * expected_s - 1.0..expected_s + 1.0).contains(&sooner_s));
    }
}

#[test]
fn an_outlook_without_a_change_ends_after_a_revolution() {
    let (camera, earth) = (camera(), EarthParameters::default());
    let forecast = forecast(&camera, &earth, PointingLaw::nadir(0.0, 0.0));
    // Over the poles at the equinox, the Sun aside: neither eclipse nor Sun.
    let sun = Bodies::at(CentralBody::Earth, EQUINOX_US).sun_km.normalize();
    let speed = libm::sqrt(EARTH.mu_km3_s2 / GEO_KM);
    let up = Vector3::new(0.0, 0.0, 1.0);
    let first = OrbitState {
        time_us: EQUINOX_US,
        position_km: up * GEO_KM,
        velocity_km_s: up.cross(&sun).normalize() * speed,
    };
    let mut outlook = Outlook::new(&forecast, &first).unwrap();
    let mut steps = 0;
    while !outlook.is_over() {
        outlook.step(&forecast).unwrap();
        steps += 1;
    }
    assert!(outlook.found() == [None; 2] && (1_200..1_250).contains(&steps), "{steps} {:?}", outlook.found());
}

#[test]
fn laws_point_where_they_say() {
    let orbit = equatorial(8_000.0, 20.0);
    let nadir = -orbit.position_km.normalize().map(|axis| axis as f32);
    let flight = orbit.velocity_km_s.normalize().map(|axis| axis as f32);
    let sight =
        |law: PointingLaw| law.earth_path(CentralBody::Earth, &orbit).unwrap().matrix().row(2).transpose();
    let close = |a: Vector3<f32>, b: Vector3<f32>| (a - b).norm() < 1e-6;
    assert!(close(sight(down()), nadir));
    let raised = sight(PointingLaw::nadir(0.5, 2.0));
    assert!(close(raised, nadir * 0.5f32.cos() + flight * 0.5f32.sin()));
    // The line of sight to the horizon is tangent to the sphere.
    let horizon = sight(PointingLaw::Horizon { below_rad: 0.0, roll_rad: 0.0 });
    assert!((horizon.dot(&nadir) - (1.0 - (6_378.137f32 / 8_000.0).powi(2)).sqrt()).abs() < 1e-6);
    let below = sight(PointingLaw::Horizon { below_rad: 0.1, roll_rad: 0.0 });
    assert!((below.dot(&horizon) - 0.1f32.cos()).abs() < 1e-6 && below.dot(&nadir) > horizon.dot(&nadir));
    let still = Rotation::from_quaternion([0.1, 0.2, 0.3, 0.9]).unwrap();
    assert_eq!(
        PointingLaw::Inertial(still).earth_path(CentralBody::Earth, &orbit).unwrap().matrix(),
        still.matrix()
    );
}

#[test]
fn what_is_no_orbit_has_no_state() {
    let (camera, earth) = (camera(), EarthParameters::default());
    let forecast = forecast(&camera, &earth, down());
    let orbit = equatorial(8_000.0, 0.0);
    let straight_up = OrbitState { velocity_km_s: orbit.position_km * 1e-3, ..orbit };
    let inside = OrbitState { position_km: orbit.position_km * 0.7, ..orbit };
    for wrong in [straight_up, inside, OrbitState { position_km: Vector3::repeat(f64::NAN), ..orbit }] {
        assert_eq!(forecast.state(&wrong), None);
        assert!(forecast.step(&wrong, SensorState::Full).is_err());
    }
}
