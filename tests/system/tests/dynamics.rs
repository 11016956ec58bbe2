//! The forces that fly beside the world's own, term by term, and the process noise beside what they leave
//! out.
//!
//! The world's gravity, atmosphere, light, ephemerides and integrator are written apart from the flight
//! code's.

use fsw_core::orbit::OrbitState;
use fsw_core::orbit::body::{CentralBody, EARTH};
use fsw_core::orbit::dynamics::Transition;
use fsw_core::orbit::forces::{Dynamics, Forces};
use fsw_core::orbit::parameters::OrbitParameters;
use sil_host::commands::propagate::carried;
use sil_host::world::attitude::Vector;
use sil_host::world::orbit::{self, TruthOrbit, state_of_elements};
use sil_host::world::vector::{length, minus};
use std::f64::consts::TAU;

/// 2026-09-22 23:18:20 UTC.
const START_US: i64 = 843_393_969_184_000;
const DAY_S: f64 = 86_400.0;
const MU_KM3_S2: f64 = 398_600.441_5;

/// The forces of both, each written down twice.
#[derive(Clone)]
struct Both {
    flight: Forces,
    world: orbit::Forces,
}

impl Both {
    /// The field to a degree and order, and nothing else.
    fn field(degree: u8, order: u8) -> Self {
        Self {
            flight: Forces { degree, order, ..Forces::KEPLER },
            world: orbit::Forces {
                gravity_degree: degree.into(),
                gravity_order: order.into(),
                sun: false,
                moon: false,
                drag: false,
                radiation_pressure: false,
                ..orbit::Forces::default()
            },
        }
    }
}

/// Start and duration of a revolution.
struct Start {
    position_km: Vector,
    velocity_km_s: Vector,
    period_s: f64,
}

impl Start {
    fn new(
        a_km: f64,
        e: f64,
        inclination_deg: f64,
        node_deg: f64,
        perigee_deg: f64,
        anomaly_deg: f64,
    ) -> Self {
        let (position_km, velocity_km_s) = state_of_elements(
            CentralBody::Earth,
            [a_km, e, inclination_deg, node_deg, perigee_deg, anomaly_deg],
        )
        .unwrap();
        Self { position_km, velocity_km_s, period_s: TAU * (a_km.powi(3) / MU_KM3_S2).sqrt() }
    }

    /// Places by the flight code at these times, km.
    fn flown(&self, forces: &Forces, times_s: &[f64]) -> Vec<Vector> {
        let mut state = OrbitState {
            time_us: START_US,
            position_km: self.position_km.into(),
            velocity_km_s: self.velocity_km_s.into(),
        };
        let place = |time_s: &f64| {
            state = carried(&state, START_US + (time_s * 1e6).round() as i64, forces).unwrap();
            state.position_km.into()
        };
        times_s.iter().map(place).collect()
    }

    /// The same by the world.
    fn true_km(&self, forces: &orbit::Forces, times_s: &[f64]) -> Vec<Vector> {
        let seconds = times_s.last().unwrap().ceil() as u32 + 1;
        let orbit =
            TruthOrbit::with_forces(START_US, self.position_km, self.velocity_km_s, seconds, forces).unwrap();
        // The flight code's times are whole microseconds.
        times_s.iter().map(|time_s| orbit.at((time_s * 1e6).round() * 1e-6).0).collect()
    }
}

/// Greatest distance of two lists of places, m.
fn worst_m(one: &[Vector], other: &[Vector]) -> f64 {
    1e3 * one.iter().zip(other).map(|(a, b)| length(minus(*a, *b))).fold(0.0, f64::max)
}

/// What a term moves an orbit in a revolution, and by how much the flight code has that wrong: the
/// difference of its move and the world's.
#[test]
fn each_force_moves_an_orbit_as_the_worlds_does() {
    let orbits = [
        ("LEO 450 km", Start::new(6_828.0, 0.001, 51.6, 120.0, 30.0, 15.0)),
        ("SSO 800 km", Start::new(7_178.0, 0.001, 98.6, 40.0, 90.0, 0.0)),
        ("GTO", Start::new(24_400.0, 0.73, 7.0, 20.0, 178.0, 90.0)),
        ("GEO", Start::new(42_164.17, 0.0002, 0.05, 40.0, 10.0, 75.0)),
    ];
    let base = Both::field(2, 0);
    let changed = |flight: &dyn Fn(&mut Forces), world: &dyn Fn(&mut orbit::Forces)| {
        let mut both = base.clone();
        flight(&mut both.flight);
        world(&mut both.world);
        both
    };
    let usual = orbit::Forces::default();
    let all = OrbitParameters::default().forces();
    let terms = [
        ("tesserals of degree 2", base.clone(), Both::field(2, 2), 0.002),
        ("degrees 3 to 8", Both::field(2, 2), Both::field(8, 8), 0.01),
        (
            "Sun and Moon",
            base.clone(),
            changed(&|forces| forces.sun_and_moon = true, &|forces| (forces.sun, forces.moon) = (true, true)),
            0.01,
        ),
        (
            "drag",
            base.clone(),
            changed(&|forces| forces.drag_m2_kg = all.drag_m2_kg, &|forces| forces.drag = true),
            0.06,
        ),
        (
            "the Sun's light",
            base.clone(),
            changed(&|forces| forces.radiation_m2_kg = all.radiation_m2_kg, &|forces| {
                forces.radiation_pressure = true
            }),
            0.02,
        ),
    ];
    println!("| m in a revolution | {} |", orbits.each_ref().map(|(name, _)| *name).join(" | "));
    let row = |name: &str, cells: &[String]| println!("| {name} | {} |", cells.join(" | "));
    let times =
        |start: &Start| -> Vec<f64> { (1..=40).map(|k| start.period_s * f64::from(k) / 40.0).collect() };
    for (name, without, with, share) in terms {
        let cells = orbits.each_ref().map(|(orbit, start)| {
            let times = times(start);
            let moved = |with: Vec<Vector>, without: Vec<Vector>| -> Vec<Vector> {
                with.iter().zip(&without).map(|(with, without)| minus(*with, *without)).collect()
            };
            let ours = moved(start.flown(&with.flight, &times), start.flown(&without.flight, &times));
            let theirs = moved(start.true_km(&with.world, &times), start.true_km(&without.world, &times));
            let moves_m = worst_m(&theirs, &vec![[0.0; 3]; times.len()]);
            let wrong_m = worst_m(&ours, &theirs);
            assert!(wrong_m < share * moves_m + 0.1, "{name}, {orbit}: {wrong_m} of {moves_m} m");
            format!("{moves_m:.2}, {wrong_m:.2} off")
        });
        row(name, &cells);
    }
    let cells = orbits.each_ref().map(|(_, start)| {
        let field = |degree| {
            let forces = orbit::Forces { gravity_degree: degree, gravity_order: degree, ..usual.clone() };
            start.true_km(&forces, &times(start))
        };
        format!("{:.2}", worst_m(&field(36), &field(8)))
    });
    row("left out: degrees 9 to 36", &cells);
    for (name, forces) in
        [("all that flies, to the world", all), ("J2 and tesserals, Sun, Moon alone", Forces::J2)]
    {
        let cells = orbits.each_ref().map(|(_, start)| {
            let times = times(start);
            format!("{:.2}", worst_m(&start.flown(&forces, &times), &start.true_km(&usual, &times)))
        });
        row(name, &cells);
    }
}

/// Variance of the position after each of these times by white acceleration of density 1 along an orbit, in
/// steps of a minute; as sigmas, km of km/s^1.5.
fn sigmas_of_noise(start: &Start, times_s: &[f64]) -> Vec<f64> {
    const STEP_S: f64 = 60.0;
    let forces = Forces { degree: 2, ..Forces::KEPLER };
    let mut state = OrbitState {
        time_us: START_US,
        position_km: start.position_km.into(),
        velocity_km_s: start.velocity_km_s.into(),
    };
    let mut covariance = [[0.0; 6]; 6];
    let (mut at_s, mut sigmas) = (0.0, Vec::new());
    for time_s in times_s {
        while at_s < *time_s {
            let after = carried(&state, state.time_us + (STEP_S * 1e6) as i64, &forces).unwrap();
            covariance = with_noise(&forces.transition(&state, &after), &covariance, STEP_S);
            state = after;
            at_s += STEP_S;
        }
        sigmas.push((0..3).map(|axis| covariance[axis][axis]).sum::<f64>().sqrt());
    }
    sigmas
}

/// `Φ P Φᵀ` and the noise of a step.
fn with_noise(transition: &Transition, covariance: &Transition, step_s: f64) -> Transition {
    let cell = |row: usize, column: usize| {
        let of = |(j, k): (usize, usize)| transition[row][j] * covariance[j][k] * transition[column][k];
        let carried: f64 = (0..6).flat_map(|j| (0..6).map(move |k| (j, k))).map(of).sum();
        let noise = match (row / 3, column / 3) {
            _ if row % 3 != column % 3 => 0.0,
            (0, 0) => step_s.powi(3) / 3.0,
            (1, 1) => step_s,
            _ => step_s.powi(2) / 2.0,
        };
        carried + noise
    };
    std::array::from_fn(|row| std::array::from_fn(|column| cell(row, column)))
}

/// Errors by the degrees that are left out, and by nothing else, over random places of the node and
/// inclinations, after a quarter of a revolution to a day, over the sigma of the filter's white
/// acceleration. A revolution is the shortest arc from which all elements are known; over less of it the
/// errors are below 30 m.
#[test]
fn the_process_noise_covers_the_gravity_that_is_left_out() {
    let flown = OrbitParameters::default();
    let forces = Dynamics::Full.forces(0.0, 0.0);
    let world = orbit::Forces {
        gravity_degree: 36,
        gravity_order: 36,
        drag: false,
        radiation_pressure: false,
        ..orbit::Forces::default()
    };
    println!("| height km | rms error m after 1/4, 1, 3 revolutions, a day | of the filter's sigma |");
    for height_km in [300.0, 450.0, 800.0, 1_350.0] {
        let radius_km = EARTH.radius_km + height_km;
        let noise = f64::from(flown.gravity_noise_km_s15) * (EARTH.radius_km / radius_km).powi(12);
        let noise = noise.hypot(f64::from(flown.force_noise_km_s15));
        let (mut squares, mut sigmas) = ([0.0; 4], Vec::new());
        let (inclinations, nodes) = ([30.0, 52.0, 75.0, 98.0], [0.0, 100.0, 200.0, 300.0]);
        for inclination_deg in inclinations {
            for node_deg in nodes {
                let start = Start::new(radius_km, 1e-3, inclination_deg, node_deg, 0.0, node_deg);
                let times = [0.25 * start.period_s, start.period_s, 3.0 * start.period_s, DAY_S];
                let errors = start.flown(&forces, &times).into_iter().zip(start.true_km(&world, &times));
                for (sum, (ours, theirs)) in squares.iter_mut().zip(errors) {
                    *sum += length(minus(ours, theirs)).powi(2);
                }
                if sigmas.is_empty() {
                    sigmas = sigmas_of_noise(&start, &times);
                }
            }
        }
        let count = (inclinations.len() * nodes.len()) as f64;
        let rms_km = squares.map(|sum: f64| (sum / count).sqrt());
        let shares: Vec<f64> = rms_km.iter().zip(&sigmas).map(|(rms, sigma)| rms / (noise * sigma)).collect();
        println!(
            "| {height_km} | {} | {} |",
            rms_km.map(|km| format!("{:.0}", 1e3 * km)).join(", "),
            shares.iter().map(|share| format!("{share:.2}")).collect::<Vec<_>>().join(", ")
        );
        let [_, revolution, later @ ..] = &shares[..] else { unreachable!() };
        assert!((0.5..1.0).contains(revolution), "{height_km} km: {revolution}");
        assert!(later.iter().all(|share| *share < 1.0), "{height_km} km: {later:?}");
    }
}
