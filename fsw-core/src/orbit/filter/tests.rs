//! Behaviour at the doors here; accuracy and consistency in `campaign`.

use super::*;
use crate::orbit::constants::EARTH_RADIUS_KM;
use crate::orbit::covariance::STATES;
use crate::orbit::observation::Innovation;
use crate::orbit::reference::circular;
use nalgebra::Vector3;
use proptest::prelude::*;

fn good_fix(state: &OrbitState) -> PositionFix {
    let position_km = state.position_km;
    PositionFix { position_km, covariance_km2: Matrix3::identity() * 25.0, linearisation_km: position_km }
}

/// A filter that has followed a low orbit for ten minutes without noise, and the true state.
fn running(parameters: &OrbitParameters) -> (OrbitFilter, OrbitState) {
    let mut filter = OrbitFilter::new();
    let mut truth = circular(7_000.0, 51.0);
    assert_eq!(
        filter.update(truth.time_us, &good_fix(&truth), &Matrix3::identity(), parameters),
        Update::Begun
    );
    for second in 0..600 {
        truth = parameters.dynamics.propagate(&truth, 1_000_000).unwrap();
        let update = filter.update(truth.time_us, &good_fix(&truth), &Matrix3::identity(), parameters);
        let expected =
            if second == 0 { update == Update::Started } else { matches!(update, Update::Accepted { .. }) };
        assert!(expected, "{second}: {update:?}");
    }
    (filter, truth)
}

#[test]
fn a_fix_far_off_is_rejected_and_many_start_the_filter_anew() {
    let parameters = OrbitParameters { patience: 4, ..OrbitParameters::default() };
    let (mut filter, truth) = running(&parameters);
    let mut wrong = good_fix(&truth);
    wrong.position_km.y += 500.0;
    for second in 1..=4 {
        let time = truth.time_us + second * 1_000_000;
        let update = filter.update(time, &wrong, &Matrix3::identity(), &parameters);
        if second < 4 {
            assert!(matches!(update, Update::Rejected { nis } if nis > 30.0), "{update:?}");
            assert_eq!(i64::from(filter.rejections()), second);
        } else {
            assert_eq!(update, Update::Restarted);
            assert!(filter.state().is_none());
        }
    }
    let again = filter.update(truth.time_us + 5_000_000, &wrong, &Matrix3::identity(), &parameters);
    assert_eq!(again, Update::Started);
    assert!((filter.state().unwrap().position_km - wrong.position_km).norm() < 10.0);
}

#[test]
fn one_fix_alone_tells_nothing_and_one_that_disagrees_takes_its_place() {
    let parameters = OrbitParameters::default();
    let truth = circular(7_000.0, 51.0);
    let mut wrong = good_fix(&truth);
    wrong.position_km.y += 1_300.0;
    let seconds = |seconds: i64| truth.time_us + seconds * 1_000_000;
    let begun = || {
        let mut filter = OrbitFilter::new();
        let update = filter.update(truth.time_us, &wrong, &Matrix3::identity(), &parameters);
        assert_eq!(update, Update::Begun);
        assert!(filter.state().is_none() && filter.covariance().is_none() && !filter.settled());
        filter
    };
    let take = |filter: &mut OrbitFilter, second, fix: &PositionFix| {
        filter.update(seconds(second), fix, &Matrix3::identity(), &parameters)
    };
    let mut filter = begun();
    assert_eq!(take(&mut filter, 2, &good_fix(&truth)), Update::Begun);
    assert_eq!(take(&mut filter, 3, &good_fix(&truth)), Update::Started);
    assert!((filter.state().unwrap().position_km - truth.position_km).norm() < 10.0);
    // A minute later a body at any speed would be anywhere: the two say nothing about each other.
    for (second, update) in [(60, Update::Started), (61, Update::Begun)] {
        assert_eq!(take(&mut begun(), second, &wrong), update, "{second}");
    }
    let mut filter = begun();
    assert_eq!(filter.advance(seconds(61), &parameters), Ok(()));
    assert!(filter.estimate.is_none());
}

#[test]
fn what_is_no_fix_is_refused_and_changes_nothing() {
    let parameters = OrbitParameters::default();
    let (mut filter, truth) = running(&parameters);
    let before = *filter.state().unwrap();
    let good = good_fix(&truth);
    let mut refuse = |fix: PositionFix, rotation: Matrix3<f64>, why| {
        assert_eq!(filter.update(truth.time_us, &fix, &rotation, &parameters), Update::Refused(why));
        assert_eq!(*filter.state().unwrap(), before);
    };
    let identity = Matrix3::identity();
    for x in [f64::NAN, f64::INFINITY, 1e7] {
        refuse(
            PositionFix { position_km: Vector3::new(x, 0.0, 0.0), ..good },
            identity,
            FixError::Impossible,
        );
    }
    refuse(PositionFix { position_km: Vector3::zeros(), ..good }, identity, FixError::Impossible);
    refuse(good, identity * f64::NAN, FixError::Impossible);
    for covariance in [identity * f64::NAN, Matrix3::zeros(), -identity, Matrix3::from_element(1.0)] {
        refuse(PositionFix { covariance_km2: covariance, ..good }, identity, FixError::Covariance);
    }
}

#[test]
fn an_outage_of_two_hours_is_crossed_and_more_is_not() {
    let parameters = OrbitParameters::default();
    let (mut filter, truth) = running(&parameters);
    let before = filter.position_sigma_km().unwrap();
    let mut jumped = filter;
    jumped.advance(truth.time_us + MAX_GAP_US, &parameters).unwrap();
    for second in (0..7_200).map(|second| second + 1) {
        filter.advance(truth.time_us + second * 1_000_000, &parameters).unwrap();
    }
    // In one jump or second by second: the same orbit and nearly the same doubt.
    let apart = (filter.state().unwrap().position_km - jumped.state().unwrap().position_km).norm();
    assert!(apart < 0.05, "{apart}");
    for ((slow, fast), before) in
        filter.position_sigma_km().unwrap().iter().zip(jumped.position_sigma_km().unwrap()).zip(before)
    {
        assert!((slow / fast - 1.0).abs() < 0.1, "{slow} {fast}");
        assert!(*slow > before);
    }
    assert_eq!(jumped.advance(truth.time_us + 2 * MAX_GAP_US + 1, &parameters), Err(ResetReason::TooLong));
    assert!(jumped.state().is_none() && !jumped.settled());
    assert_eq!(filter.advance(truth.time_us, &parameters), Err(ResetReason::Backwards));
    assert!(filter.state().is_none());
    let (mut filter, _) = running(&parameters);
    assert_eq!(filter.advance(i64::MIN, &parameters), Err(ResetReason::TooLong));
}

#[test]
fn an_orbit_into_the_earth_is_forgotten() {
    let parameters = OrbitParameters::default();
    let mut filter = OrbitFilter::new();
    assert_eq!(filter.advance(5, &parameters), Ok(()));
    let falling = OrbitState { velocity_km_s: Vector3::zeros(), ..circular(7_000.0, 0.0) };
    assert!(filter.initialise(falling, 1.0, 1.0, &parameters));
    assert_eq!(filter.advance(falling.time_us + MAX_GAP_US, &parameters), Err(ResetReason::Diverged));
    assert!(!filter.initialise(falling, f64::NAN, 1.0, &parameters));
    assert!(!filter.initialise(
        OrbitState { position_km: Vector3::zeros(), ..falling },
        1.0,
        1.0,
        &parameters
    ));
}

#[test]
fn an_orbit_that_never_settled_is_stale_after_a_turn_without_a_fix() {
    let parameters = OrbitParameters::default();
    let state = circular(7_000.0, 51.0);
    // Kepler's third law: 5,829 s.
    let period_us = 5_829_000_000;
    for (position_sigma_km, stale) in [(100.0, true), (1.0, false)] {
        let mut filter = OrbitFilter::new();
        assert!(!filter.is_stale(0));
        assert!(filter.initialise(state, position_sigma_km, 1e-3, &parameters));
        assert_eq!(filter.settled(), !stale);
        filter.advance(state.time_us + period_us - 60_000_000, &parameters).unwrap();
        assert!(!filter.is_stale(period_us - 60_000_000));
        filter.advance(state.time_us + period_us + 60_000_000, &parameters).unwrap();
        assert_eq!(filter.is_stale(period_us + 60_000_000), stale);
        assert!(!filter.is_stale(60_000_000));
    }
}

#[test]
fn a_direction_alone_says_nothing_of_the_distance_however_far_off_that_is() {
    let expected = Vector3::new(7_000.0, 0.0, 0.0);
    let (sine, cosine) = libm::sincos(0.1);
    for ratio in [0.2, 0.6, 1.0, 1.7, 5.0, 40.0] {
        let position_km = Vector3::new(cosine, sine, 0.0) * (7_000.0 * ratio);
        let covariance_km2 = Matrix3::identity() * (70.0 * ratio) * (70.0 * ratio);
        let fix = PositionFix { position_km, covariance_km2, linearisation_km: position_km };
        let innovation = Innovation::of(&fix, &expected, 0.0, &Matrix3::identity(), true);
        // An arc of 0.1 rad, or its sine, and a hundredth of the distance across.
        assert!((innovation.innovation_km - Vector3::new(0.0, 700.0, 0.0)).norm() < 2.0, "{innovation:?}");
        assert!((innovation.noise_km2[(1, 1)] / 4_900.0 - 1.0).abs() < 1e-9, "{innovation:?}");
        assert_eq!(innovation.sensitivity.column(LIMB_HEIGHT), Vector3::zeros());
    }
}

/// Thesis §5.2: a geostationary radius wrong by 1 to some tens of Earth radii at the start.
#[test]
fn a_start_many_earth_radii_off_converges() {
    for observation in [Observation::Position, Observation::Combined, Observation::UnitVector] {
        // Neither noise nor bias: convergence alone is at stake.
        let parameters = OrbitParameters {
            observation,
            misalignment_sigma_rad: 0.0,
            bias_over_noise: 0.0,
            ..OrbitParameters::default()
        };
        // Without any distance the linearised filter converges from three radii; ten leave 50 km after 18
        // hours.
        let directions = observation == Observation::UnitVector;
        let radii: &[f64] = if directions { &[1.0, 3.0] } else { &[1.0, 3.0, 10.0, 50.0] };
        for radii in radii {
            let mut truth = circular(42_164.0, 0.1);
            let mut filter = OrbitFilter::new();
            let off = radii * EARTH_RADIUS_KM;
            let wrong = OrbitState { position_km: truth.position_km * (1.0 + off / 42_164.0), ..truth };
            assert!(filter.initialise(wrong, off, 3.0, &parameters));
            // 0.02 deg across, 100 km along, a fix in 20 s, for 18 hours.
            let mut restarted = 0;
            for _ in 0..3_240 {
                truth = parameters.dynamics.propagate(&truth, 20_000_000).unwrap();
                let along =
                    truth.position_km * truth.position_km.transpose() / truth.position_km.norm_squared();
                let covariance_km2 = Matrix3::identity() * 216.0 + along * 1e4;
                let position_km = truth.position_km;
                let fix = PositionFix { position_km, covariance_km2, linearisation_km: position_km };
                let update = filter.update(truth.time_us, &fix, &Matrix3::identity(), &parameters);
                restarted += u32::from(matches!(update, Update::Restarted | Update::Begun));
            }
            let apart = (filter.state().unwrap().position_km - truth.position_km).norm();
            std::println!(
                "{observation:?} from {radii} radii off: {apart:.2} km after 18 h, {restarted} restarts"
            );
            assert!(apart < 5.0, "{observation:?} {radii}: {apart}");
        }
    }
}

/// Numbers as they come from a broken computer: mostly of a fix's size, else anything.
fn number(size: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -size..size,
        1 => any::<f64>(),
        1 => prop::sample::select(
            &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, f64::MAX, f64::MIN_POSITIVE]
        ),
    ]
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(number(size)).prop_map(Vector3::from)
}

/// A covariance more often than not.
fn covariance() -> impl Strategy<Value = Matrix3<f64>> {
    let any_matrix =
        || prop::array::uniform9(number(100.0)).prop_map(|parts| Matrix3::from_row_slice(&parts));
    prop_oneof![
        3 => any_matrix().prop_map(|root| root * root.transpose() + Matrix3::identity() * 1e-3),
        1 => any_matrix(),
    ]
}

fn step_us() -> impl Strategy<Value = i64> {
    prop_oneof![6 => 0i64..2_000_000, 2 => 0i64..8_000_000_000, 1 => any::<i64>()]
}

fn elements(covariance: &Covariance) -> impl Iterator<Item = f64> {
    (0..STATES).flat_map(move |row| (0..=row).map(move |column| covariance.at(row, column)))
}

fn assert_finite(filter: &OrbitFilter) {
    let Some(state) = filter.state() else { return };
    let covariance = filter.covariance().unwrap();
    let vectors = state.position_km.iter().chain(state.velocity_km_s.iter());
    assert!(vectors.copied().chain(elements(covariance)).all(f64::is_finite), "{state:?} {covariance:?}");
    assert!(filter.limb_height_km().unwrap().is_finite());
    let sigmas = filter.position_sigma_km().unwrap().into_iter().chain(filter.velocity_sigma_km_s().unwrap());
    assert!(sigmas.chain(filter.limb_height_sigma_km()).all(|sigma| sigma.is_finite() && sigma >= 0.0));
}

proptest! {
    #[test]
    fn whatever_is_put_in_what_comes_out_is_finite(
        begin in prop::option::of((vector(2e4), vector(8.0), number(1e4), number(5.0))),
        fixes in prop::collection::vec(
            (step_us(), vector(3e4), vector(100.0), covariance(), vector(0.1)),
            1..25
        ),
        observation in prop::sample::select(
            &[Observation::Position, Observation::UnitVector, Observation::Combined]
        ),
        // The extremes of the table's ranges too.
        gate_nis in prop::sample::select(&[10.0f32, 30.0, 1000.0]),
        bias_over_noise in prop::sample::select(&[0.0f32, 3.0, 30.0]),
    ) {
        let parameters =
            OrbitParameters { observation, gate_nis, bias_over_noise, ..OrbitParameters::default() };
        let mut filter = OrbitFilter::new();
        let mut time_us = 760_000_000_000_000i64;
        if let Some((position_km, velocity_km_s, position_sigma, velocity_sigma)) = begin {
            let state = OrbitState { time_us, position_km, velocity_km_s };
            let taken = filter.initialise(state, position_sigma, velocity_sigma, &parameters);
            assert_eq!(taken, filter.state().is_some());
            assert_finite(&filter);
        }
        for (span_us, position_km, aside, covariance_km2, tilt) in fixes {
            time_us = time_us.saturating_add(span_us);
            let fix = PositionFix { position_km, covariance_km2, linearisation_km: position_km + aside };
            let to_icrs = Matrix3::identity() + crate::matrix::cross_matrix(&tilt);
            match filter.update(time_us, &fix, &to_icrs, &parameters) {
                Update::Accepted { nis } => assert!(nis <= gate_nis && nis >= 0.0),
                // A fix that is so far off that its square overflows is rejected too.
                Update::Rejected { nis } => assert!(!nis.is_nan()),
                Update::Begun | Update::Restarted => assert!(filter.state().is_none()),
                Update::Started => assert!(filter.state().is_some()),
                Update::Refused(_) => {}
            }
            assert_finite(&filter);
        }
    }
}

#[test]
fn a_step_of_the_clock_moves_the_epoch_and_not_the_satellite() {
    let parameters = OrbitParameters::default();
    let mut filter = OrbitFilter::new();
    assert!(filter.initialise(circular(7_000.0, 51.0), 1.0, 1e-3, &parameters));
    let before = *filter.state().unwrap();
    for step_us in [3_600_000_000, -600_000_000] {
        filter.shift_epoch(step_us);
    }
    let after = *filter.state().unwrap();
    assert_eq!(after.time_us, before.time_us + 3_000_000_000);
    assert_eq!((after.position_km, after.velocity_km_s), (before.position_km, before.velocity_km_s));
    assert!(filter.advance(after.time_us + 1_000_000, &parameters).is_ok());
}
