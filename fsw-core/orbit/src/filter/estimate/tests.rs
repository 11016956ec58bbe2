use super::*;
use crate::reference::circular;
use nalgebra::{Matrix6, Matrix6x3, Vector6};

/// A state of a low orbit, known to 1 km and 1 m/s.
fn known(parameters: &OrbitParameters) -> Estimate {
    let root = Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3));
    let first = FirstOrbit { state: circular(7_000.0, 50.0), root, misaligned: Matrix6x3::zeros() };
    let mut estimate = Estimate::new();
    assert!(estimate.begin(&first, parameters));
    estimate
}

/// Heights above the satellite, across and along, of sigma 0.5, 1 and 2 km: a fourth row does not test the
/// state.
fn rows(innovations: [f32; 4]) -> Rows {
    let mut rows = Rows { least_test: LEAST_TEST, ..Rows::of_fix() };
    for (axis, (sigma_km, innovation)) in [0.5, 1.0, 2.0, 1e3].into_iter().zip(innovations).enumerate() {
        rows.sensitivities[axis][POSITION + axis % 3] = 1.0 / sigma_km;
        rows.sensitivities[axis][POSITION + (axis + 1) % 3] = 0.3 / sigma_km;
        rows.innovations[axis] = innovation;
    }
    rows
}

#[test]
fn an_observation_beyond_the_gate_is_brought_to_it() {
    let parameters = OrbitParameters::default();
    let estimate = known(&parameters);
    for innovations in [[9.0, -5.0, 2.0, 40.0], [0.0, 14.0, 0.0, 0.0], [-300.0, 20.0, 70.0, 5.0]] {
        let mut rows = rows(innovations);
        let (nis, tests) = estimate.nis(&rows);
        let gate = nis.gate(parameters.gate_sigma);
        assert!(nis.freedom == 3 && !tests[3] && nis.square > gate, "{nis:?}");
        rows.widen(&tests, 1.0 / gate - 1.0 / nis.square);
        rows.least_test = NOT_EMPTY;
        let (widened, tests) = estimate.nis(&rows);
        assert!((widened.square / gate - 1.0).abs() < 1e-3, "{widened:?} {gate}");
        assert_eq!((widened.freedom, tests[3]), (3, false));
    }
}

#[test]
fn the_further_off_an_observation_is_the_less_it_moves_the_state() {
    let parameters = OrbitParameters::default();
    for (far, counted) in [(12.0, 0.3), (24.0, 1.0), (200.0, 1.0), (f32::NAN, 1.0)] {
        let mut estimate = known(&parameters);
        let before = estimate;
        let (nis, within) = estimate.update(rows([far, 0.0, 0.0, 0.0]), &parameters);
        assert!(!within, "{nis:?}");
        let moved = estimate.state.position_km - before.state.position_km;
        // In sigmas of the state, 1 km: the gate's square over the root of its own.
        let most_km = f64::from(nis.gate(parameters.gate_sigma) / nis.square.sqrt());
        assert!(moved.norm() < 1.1 * most_km || (far.is_nan() && moved.norm() == 0.0), "{far}: {moved:?}");
        assert!(estimate.is_valid() && (estimate.contradicted - counted).abs() < 0.1, "{far}");
        // One within the gate takes all contradiction back.
        let (_, within) = estimate.update(rows([0.5, 0.0, 0.0, 0.0]), &parameters);
        assert!(within && estimate.contradicted == 0.0);
    }
}
