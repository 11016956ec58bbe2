//! Flights about Moon and Mars from pixels: the scenarios' first half hour, by an orbit of the ground and the
//! limb. The table's facts are held against others in the tests of `fsw_core::orbit::body`, the world's here.

use crate::flights::{self, scenario};
use fsw_core::orbit::body::CentralBody;
use sil_host::bound::position::PositionBound;
use sil_host::harness::truth_of;
use sil_host::world::body;
use sil_host::world::orbit::TruthOrbit;
use sil_host::world::vector::{angle, length, minus, product, transposed};

const DAY_US: i64 = 86_400_000_000;

/// What a flight came to.
#[derive(Default)]
struct Flown {
    /// Seconds with an attitude, and the largest error of one over its sigma.
    attitudes: u32,
    worst_sigma: f64,
    /// Seconds with a lit limb, those of them whose image gave the body's centre or heights of its limb.
    lit: u32,
    /// Seconds since the start when an orbit was first told.
    first_orbit_s: Option<u32>,
    /// Error of the last position, km, and that over its sigma, the worst of three axes.
    last_km: f64,
    last_sigma: f64,
}

fn fly(name: &str, seconds: u32) -> Flown {
    let scenario = scenario(name, seconds);
    let mut flown = Flown::default();
    flights::fly(&scenario, |second| {
        assert_eq!(second.truth.ellipsoid.body(), scenario.forces.body);
        if let Some(attitude) = &second.judged.attitude_rad {
            flown.attitudes += 1;
            flown.worst_sigma = flown.worst_sigma.max(attitude.worst_sigma());
        }
        flown.lit += u32::from(second.truth.lit_limb_deg > 0.0);
        if let Some(orbit) = &second.judged.orbit {
            flown.first_orbit_s.get_or_insert(second.cycle);
            flown.last_km = orbit.position_km.axes.length();
            flown.last_sigma = orbit.position_km.axes.worst_sigma();
        }
    });
    let Flown { attitudes, worst_sigma, lit, first_orbit_s, last_km, last_sigma } = &flown;
    println!(
        "{name}, {seconds} s: {attitudes} s with an attitude, at most {worst_sigma:.1} sigma; {lit} s with a lit limb; \
         orbit after {first_orbit_s:?} s; at the end {last_km:.1} km, {last_sigma:.1} sigma"
    );
    flown
}

/// Over half an hour, of which all has a lit limb in the field: attitude as about the Earth, and an orbit
/// whose error is at the end within 4.5 sigma on every axis (probability of more, of a right sigma: 2e-5).
fn an_orbit_is_kept(name: &str) {
    let flown = fly(name, 1800);
    assert!(flown.attitudes >= 1790 && flown.worst_sigma < 6.0);
    assert!(flown.lit > 1500);
    assert!(flown.first_orbit_s.is_some_and(|second| second < 60));
    assert!(flown.last_sigma < 4.5 && flown.last_km < 100.0);
}

#[test]
fn an_orbit_about_the_moon_is_kept_by_its_airless_limb() {
    an_orbit_is_kept("moon-orbit");
}

#[test]
fn an_orbit_about_mars_is_kept_by_its_dusty_limb() {
    an_orbit_is_kept("mars-orbit");
}

/// Of 40 flights that only carry the ground's orbit on, by all forces of the world, those that miss the limit
/// of the position over the flight's second half.
fn missed_without_the_limb(name: &str) -> usize {
    let scenario = scenario(name, 4800);
    let scene = scenario.scene().unwrap();
    let start = scenario.orbit_filter.start.expect("a state from the ground");
    let mut bound =
        PositionBound::new(&scenario.earth).knowing(start.position_sigma_km, start.velocity_sigma_m_s);
    let (mut square_km2, mut places) = (0.0, Vec::new());
    for second in (0..4800).step_by(30) {
        let truth = truth_of(&scene, second).unwrap();
        let sigmas_km = bound.add(&truth, scene.optics()).expect("the start is known");
        if second >= 2400 {
            square_km2 += sigmas_km.iter().map(|sigma| sigma * sigma).sum::<f64>();
            places.push((f64::from(second), truth.position_km));
        }
    }
    let limit = scenario.limits.iter().find(|limit| limit.of.key == "last_orbit_position_bounds");
    let limit_km = limit.expect("a limit").value * (square_km2 / places.len() as f64).sqrt();
    let misses = |seed: &u64| {
        let told = scenario.clone().with_seed(Some(*seed)).ground_state().unwrap();
        let (r, v) = (told.position_km.into(), told.velocity_km_s.into());
        // One that reaches the ground is no orbit.
        let Ok(carried) = TruthOrbit::with_forces(scenario.start_us, r, v, 4800, &scenario.forces) else {
            return true;
        };
        let off_km2 = places.iter().map(|(t_s, truth)| length(minus(carried.at(*t_s).0, *truth)).powi(2));
        (off_km2.sum::<f64>() / places.len() as f64).sqrt() > limit_km
    };
    let missed = (0..40).filter(misses).count();
    println!("{name}: limit {limit_km:.1} km, missed by {missed} of 40 orbits of the ground");
    missed
}

#[test]
fn the_grounds_orbit_alone_does_not_keep_the_limit_of_the_position() {
    for name in ["moon-orbit", "mars-orbit"] {
        assert!(missed_without_the_limb(name) >= 32, "{name}");
    }
}

/// Flight and world have written ephemerides and axes apart, but for Mars's mean elements.
#[test]
fn world_and_flight_agree_where_sun_and_pole_stand() {
    use fsw_core::orbit::ephemeris::{Bodies, equator_axes, rotation_rad, velocity_km_s};
    for about in CentralBody::ALL {
        let (mut sun_deg, mut fixed_deg, mut speed_km_s) = (0.0_f64, 0.0_f64, 0.0_f64);
        for time_us in (0..60).map(|step| step * 160 * DAY_US) {
            let bodies = Bodies::at(about, time_us);
            let sun_km = body::sun_km(about, time_us);
            sun_deg = sun_deg.max(angle(sun_km, bodies.sun_km.into()).to_degrees());
            let velocity: [f64; 3] = velocity_km_s(about, time_us).into();
            speed_km_s = speed_km_s.max(length(minus(body::velocity_km_s(about, time_us), velocity)));
            // Axes that turn with the body, of both.
            let equator = equator_axes(&bodies.pole).map(f64::from);
            let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|column| equator[(row, column)]));
            let turned =
                product(&sil_host::world::attitude::rotation(2, rotation_rad(about, time_us).into()), &rows);
            let ours = product(
                &sil_host::world::attitude::rotation(2, body::meridian_rad(about, time_us)),
                &body::icrs_to_equator(about, time_us),
            );
            let apart = product(&turned, &transposed(&ours));
            let off = (0..3).map(|axis| angle(apart[axis], unit_axis(axis))).fold(0.0, f64::max);
            fixed_deg = fixed_deg.max(off.to_degrees());
        }
        println!("{about:?}: Sun {sun_deg:.4} deg, axes {fixed_deg:.4} deg, velocity {speed_km_s:.4} km/s");
        assert!(sun_deg < 0.007 && fixed_deg < 0.03 && speed_km_s < 0.04);
    }
}

fn unit_axis(axis: usize) -> [f64; 3] {
    let mut unit = [0.0; 3];
    unit[axis] = 1.0;
    unit
}
