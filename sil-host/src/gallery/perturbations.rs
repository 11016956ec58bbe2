//! What perturbs an orbit, by its radius (thesis fig. A.7): the flight code's forces and the world's.
//!
//! An acceleration is the difference of two flights over a short time, with the force and without.

use super::orbit::{GEO_KM, START_US};
use super::{Figure, Made, Row};
use crate::error::HostError;
use crate::report::chart::{Axis, Chart, Series};
use crate::world::orbit::TruthOrbit;
use crate::world::orbit::forces::Forces as WorldForces;
use crate::world::vector::{length, minus};
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::body::EARTH;
use fsw_core::orbit::forces::Forces;
use nalgebra::Vector3;

/// The figure.
pub const FIGURES: &[Figure] = &[Figure {
    name: "fig-A.7",
    title: "perturbing accelerations by the orbit's radius",
    place: "\u{a7}A.4.2",
    thesis: &[],
    make: perturbations,
}];

/// Acceleration by the difference of two flights, km/s², over this time, s.
const SPAN_S: u32 = 100;

/// Acceleration on a circular orbit of a radius by forces of the flight code beside others.
fn flown_km_s2(radius_km: f64, forces: Forces, without: Forces) -> f64 {
    let speed = (EARTH.mu_km3_s2 / radius_km).sqrt();
    let (sine, cosine) = libm::sincos(50f64.to_radians());
    let start = OrbitState {
        time_us: START_US,
        position_km: Vector3::new(0.0, radius_km, 0.0),
        velocity_km_s: Vector3::new(-speed * cosine, 0.0, speed * sine),
    };
    let span_us = i64::from(SPAN_S) * 1_000_000;
    match (forces.propagate(&start, span_us), without.propagate(&start, span_us)) {
        (Ok(with), Ok(without)) => (with.velocity_km_s - without.velocity_km_s).norm() / f64::from(SPAN_S),
        _ => f64::NAN,
    }
}

/// The same by the world.
fn true_km_s2(radius_km: f64, forces: &WorldForces, without: &WorldForces) -> f64 {
    let speed = (EARTH.mu_km3_s2 / radius_km).sqrt();
    let (sine, cosine) = libm::sincos(50f64.to_radians());
    let at = |forces: &WorldForces| {
        let velocity = [-speed * cosine, 0.0, speed * sine];
        TruthOrbit::with_forces(START_US, [0.0, radius_km, 0.0], velocity, SPAN_S, forces)
            .ok()
            .map(|orbit| orbit.at(SPAN_S.into()).1)
    };
    at(forces)
        .zip(at(without))
        .map_or(f64::NAN, |(with, without)| length(minus(with, without)) / f64::from(SPAN_S))
}

/// A force's name, and its acceleration by radius as flown and as the world has it.
type Perturbed = (&'static str, Vec<[f64; 2]>, Vec<[f64; 2]>);

/// What perturbs, as flown and as the world has it.
fn curves(radii: &[f64]) -> Vec<Perturbed> {
    let none = WorldForces {
        gravity_degree: 0,
        gravity_order: 0,
        sun: false,
        moon: false,
        drag: false,
        radiation_pressure: false,
        ..WorldForces::default()
    };
    let of = |name, with: Option<(Forces, Forces)>, world: WorldForces, without: &WorldForces| {
        let flown = radii
            .iter()
            .filter_map(|r| Some([*r, with.map(|(with, without)| flown_km_s2(*r, with, without))?]))
            .collect();
        (name, flown, radii.iter().map(|r| [*r, true_km_s2(*r, &world, without)]).collect())
    };
    let bulge = Forces { degree: 2, order: 0, ..Forces::KEPLER };
    let whole = Forces { degree: 8, order: 8, ..Forces::KEPLER };
    let true_bulge = WorldForces { gravity_degree: 2, gravity_order: 0, ..none.clone() };
    vec![
        ("J2", Some((bulge, Forces::KEPLER)), true_bulge.clone(), none.clone()),
        (
            "field beyond J2",
            Some((whole, bulge)),
            WorldForces { gravity_degree: 8, gravity_order: 8, ..none.clone() },
            true_bulge,
        ),
        (
            "Sun and Moon",
            Some((Forces { sun_and_moon: true, ..Forces::KEPLER }, Forces::KEPLER)),
            WorldForces { sun: true, moon: true, ..none.clone() },
            none.clone(),
        ),
        ("Sun", None, WorldForces { sun: true, ..none.clone() }, none.clone()),
        ("Moon", None, WorldForces { moon: true, ..none.clone() }, none.clone()),
        (
            "drag, 0.022 m2/kg",
            Some((Forces { drag_m2_kg: 0.022, ..Forces::KEPLER }, Forces::KEPLER)),
            WorldForces { drag: true, ..none.clone() },
            none.clone(),
        ),
        (
            "sunlight, 0.013 m2/kg",
            Some((Forces { radiation_m2_kg: 0.013, ..Forces::KEPLER }, Forces::KEPLER)),
            WorldForces { radiation_pressure: true, ..none.clone() },
            none.clone(),
        ),
    ]
    .into_iter()
    .map(|(name, with, world, without)| of(name, with, world, &without))
    .collect()
}

fn perturbations(_: &Figure) -> Result<Made, HostError> {
    let radii: Vec<f64> =
        (0..=40).map(|step| 6_600.0 * libm::pow(50_000.0 / 6_600.0, f64::from(step) / 40.0)).collect();
    let all = curves(&radii);
    let at_geo = curves(&[6_828.0, GEO_KM]);
    let positive = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().map(|[r, a]| [*r, if *a > 1e-16 { *a } else { f64::NAN }]).collect()
    };
    let mut series = Vec::new();
    let mut rows = Vec::new();
    for ((name, flown, world), (_, at_flown, at_world)) in all.iter().zip(&at_geo) {
        if !flown.is_empty() {
            series.push(Series::ours(format!("flown: {name}"), positive(flown)));
        }
        series.push(Series::thesis("", positive(world)));
        let words = |points: &[[f64; 2]]| match points {
            [low, high] => format!("{:.1e} and {:.1e}", low[1], high[1]),
            _ => "not apart".into(),
        };
        rows.push(Row::alone(
            format!("{name}, 450 km high and GEO, km/s\u{b2}: flown; world"),
            format!("{}; {}", words(at_flown), words(at_world)),
        ));
    }
    if let Some(world) = series.iter_mut().find(|series| series.of_thesis) {
        world.name = "the world, written apart (also Sun and Moon alone)".into();
    }
    let chart = Chart {
        title: "Perturbing accelerations by the orbit's radius".into(),
        x: Axis::logarithmic("radius of the orbit, km"),
        y: Axis::logarithmic("acceleration, km/s\u{b2}").between([1e-14, 1e-4]),
        series,
    };
    let verdict = "The thesis takes its figure from Montenbruck and Gill, and the scan does not hold it, so that no number of it stands here; the dashed \
        lines are the world's own, apart from the flight code's. Over each other they show that flight code and world agree from low orbits to GEO; drag ends where the \
        density's table does, 1,000 km. One place, date and inclination: of the field beyond J2 and of Sun and Moon the direction matters by a factor of two.";
    Ok(Made::new(&[chart], rows, verdict))
}
