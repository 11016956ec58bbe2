use super::*;
use fsw_core::orbit::body::EARTH;
use fsw_core::orbit::constants::MICROSECONDS;
use std::f64::consts::TAU;

/// A circle inclined by 98 deg.
fn circle(radius_km: f64) -> (OrbitState, f64) {
    let motion_rad_s = (EARTH.mu_km3_s2 / radius_km.powi(3)).sqrt();
    let (sine, cosine) = 98f64.to_radians().sin_cos();
    let position_km = Vector3::new(radius_km, 0.0, 0.0);
    let velocity_km_s = Vector3::new(0.0, cosine, sine) * (radius_km * motion_rad_s);
    (OrbitState { time_us: 0, position_km, velocity_km_s }, motion_rad_s)
}

/// 60 times over a revolution.
fn times_us(motion_rad_s: f64) -> Vec<i64> {
    (1..=60).map(|k| (f64::from(k) / 60.0 * TAU / motion_rad_s * MICROSECONDS).round() as i64).collect()
}

/// Hill's transition (eq. 5.32) to the position, radial, along, cross, from position and velocity in turning
/// axes, at `angle` = motion times time, in units of radius and speed.
fn hills_transition(angle: f64) -> Sensitivity {
    let (s, c) = angle.sin_cos();
    let mut rows = Sensitivity::zeros();
    for (row, column, value) in [
        (0, 0, 4.0 - 3.0 * c),
        (0, 3, s),
        (0, 4, 2.0 * (1.0 - c)),
        (1, 0, 6.0 * (s - angle)),
        (1, 1, 1.0),
        (1, 3, -2.0 * (1.0 - c)),
        (1, 4, 4.0 * s - 3.0 * angle),
        (2, 2, c),
        (2, 5, s),
    ] {
        rows[(row, column)] = value;
    }
    rows
}

#[test]
fn the_derivatives_on_a_circle_are_hills_transition() {
    let (first, motion) = circle(7_176.0);
    let times_us = times_us(motion);
    let found = sensitivities(&first, &Forces::KEPLER, &times_us).unwrap();
    // Velocities against resting axes to those against turning ones: less the turn of the axes, 1 in these
    // units, about cross.
    let mut turning = SMatrix::<f64, 6, 6>::identity();
    turning[(3, 1)] = 1.0;
    turning[(4, 0)] = -1.0;
    for (found, time_us) in found.iter().zip(times_us) {
        let expected = hills_transition(motion * time_us as f64 / MICROSECONDS) * turning;
        let off = (found - expected).amax();
        assert!(off < 1e-6, "{off:.1e} after {time_us} us");
    }
}

/// Rank of `C, C A, ... C A^(n-1)` (eq. 5.36) of the system of eq. 5.28 with the angles λ and β measured;
/// `augmented` with a constant misalignment of each (eq. 5.37). States β', β, λ', λ, ζ', ζ, Δλ, Δβ.
fn rank_of_the_thesis(augmented: bool) -> usize {
    let states = if augmented { 8 } else { 6 };
    let mut a = DMatrix::<f64>::zeros(states, states);
    // Time in units of one over the motion.
    for (row, column, value) in
        [(0, 1, -1.0), (1, 0, 1.0), (2, 4, -2.0), (3, 2, 1.0), (4, 2, 2.0), (4, 5, 3.0), (5, 4, 1.0)]
    {
        a[(row, column)] = value;
    }
    let mut c = DMatrix::<f64>::zeros(2, states);
    (c[(0, 3)], c[(1, 1)]) = (1.0, 1.0);
    if augmented {
        (c[(0, 6)], c[(1, 7)]) = (1.0, 1.0);
    }
    let mut rows = Vec::new();
    for _ in 0..states {
        rows.extend(c.row_iter().map(|row| row.into_owned()));
        c *= &a;
    }
    DMatrix::from_rows(&rows).rank(1e-9)
}

#[test]
fn ranks_are_those_of_the_thesis() {
    assert_eq!((rank_of_the_thesis(false), rank_of_the_thesis(true)), (6, 7));
    for radius_km in [6_828.0, 7_176.0, 42_164.0] {
        let (first, motion) = circle(radius_km);
        let table = table(&first, &Forces::KEPLER, &times_us(motion)).unwrap();
        println!("{radius_km} km");
        table.iter().for_each(|form| form.print(false));
        for form in &table {
            // The thesis has two angles; the third, about the vertical, changes no direction.
            assert_eq!(form.rank, rank_of_the_thesis(form.misalignment), "{form:?}");
            assert_eq!(form.angles_observable, form.misalignment.then_some([false, true, false]));
            let Some([along, radial]) = form.unobservable.first_chunk() else {
                assert!(form.unobservable.is_empty());
                continue;
            };
            // A turn about the orbit's normal is a place farther back on the same orbit.
            let expected = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
            let off = along.iter().zip(expected).map(|(found, part)| (found - part).abs());
            assert!(off.fold(0.0, f64::max) < 1e-5, "{along:?}");
            assert!(radial.iter().enumerate().all(|(k, part)| (part - f64::from(k == 6)).abs() < 1e-5));
        }
    }
}

#[test]
fn one_direction_leaves_four_states_unknown_and_an_eccentric_orbit_has_the_same_ranks() {
    let (first, motion) = circle(7_176.0);
    assert!(table(&first, &Forces::KEPLER, &times_us(motion)[..2]).is_none());
    let at_once = sensitivities(&first, &Forces::KEPLER, &[0, 0, 0]).unwrap();
    let rank = |form| observability(&at_once, form, false).unwrap().rank;
    assert_eq!((rank(Form::Unit), rank(Form::Position)), (2, 3));
    let eccentric = OrbitState { velocity_km_s: first.velocity_km_s * 1.2, ..first };
    let ranks = table(&eccentric, &Forces::KEPLER, &times_us(0.5 * motion)).unwrap();
    assert_eq!(ranks.iter().map(|form| form.rank).collect::<Vec<_>>(), [6, 6, 6, 7, 7, 7]);
}
