//! Behaviour at the doors here; accuracy and consistency in `campaign`.

use super::*;
use crate::body::{CentralBody, EARTH};
use crate::factor::STATES;
use crate::parameters::Misalignment;
use crate::reference::circular;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::println;
use std::vec::Vec;

fn position_sigma_km(filter: &OrbitFilter) -> [f32; 3] {
    filter.motion_covariance().unwrap().position_sigma_km()
}

fn fix_at(position_km: Vector3<f64>) -> PositionFix {
    PositionFix {
        position_km,
        covariance_km2: Matrix3::identity() * 25.0,
        shared_km2: Matrix3::zeros(),
        linearisation_km: position_km,
    }
}

fn good_fix(state: &OrbitState) -> PositionFix {
    fix_at(state.position_km)
}

/// Positions.
fn positions() -> OrbitParameters {
    OrbitParameters { observation: Observation::Position, ..OrbitParameters::default() }
}

/// A filter that has followed a low orbit for ten minutes without noise, and the true state.
fn running(parameters: &OrbitParameters) -> (OrbitFilter, OrbitState) {
    let mut filter = OrbitFilter::new();
    let mut truth = circular(7_000.0, 51.0);
    let mut started = 0;
    for _ in 0..600 {
        let update = filter.update(truth.time_us, &good_fix(&truth), &Matrix3::identity(), parameters);
        started += u32::from(update == Update::Started);
        let expected = matches!(update, Update::Accepted(_)) == (started > 0 && update != Update::Started);
        assert!(expected, "{update:?}");
        truth = parameters.forces().propagate(&truth, 1_000_000).unwrap();
    }
    assert_eq!(started, 1);
    filter.advance(truth.time_us, parameters).unwrap();
    (filter, truth)
}

#[test]
fn a_fix_far_off_contradicts_the_orbit_and_many_are_a_divergence() {
    let parameters = OrbitParameters { patience: 4, ..positions() };
    let (mut filter, truth) = running(&parameters);
    let mut wrong = good_fix(&truth);
    wrong.position_km.y += 500.0;
    for second in 1..=4 {
        let time = truth.time_us + second * 1_000_000;
        let update = filter.update(time, &wrong, &Matrix3::identity(), &parameters);
        if second < 4 {
            assert!(matches!(update, Update::Downweighted(nis) if nis.square > 30.0), "{update:?}");
            assert!(filter.is_contradicted());
        } else {
            assert!(matches!(update, Update::Diverged(_)), "{update:?}");
            assert!(filter.state().is_none());
        }
    }
    // Ever the same place is no orbit: nothing is told of it.
    for second in 5..300 {
        let time = truth.time_us + second * 1_000_000;
        let update = filter.update(time, &wrong, &Matrix3::identity(), &parameters);
        assert_eq!(update, Update::Collected);
    }
}

#[test]
fn nothing_is_told_before_the_first_orbit_is_tested() {
    let parameters = positions();
    let mut truth = circular(7_000.0, 51.0);
    let mut filter = OrbitFilter::new();
    for second in 0..600 {
        // One in fifteen is false.
        let fix = if second % 15 == 4 { fix_at(Vector3::new(0.0, 9_000.0, 100.0)) } else { good_fix(&truth) };
        let update = filter.update(truth.time_us, &fix, &Matrix3::identity(), &parameters);
        if update == Update::Started {
            let error = (filter.state().unwrap().position_km - truth.position_km).norm();
            let sigma = position_sigma_km(&filter).iter().map(|x| x * x).sum::<f32>().sqrt();
            // Not before eight fixes that are five seconds apart.
            assert!(second >= 35 && error < 3.0 * f64::from(sigma), "{second}: {error} of {sigma}");
            return;
        }
        assert_eq!(update, Update::Collected);
        assert!(filter.state().is_none() && filter.factor().is_none() && !filter.settled());
        truth = parameters.forces().propagate(&truth, 1_000_000).unwrap();
    }
    panic!("never started");
}

#[test]
fn what_is_no_fix_is_refused_and_changes_nothing() {
    let parameters = positions();
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
    let parameters = positions();
    let (mut filter, truth) = running(&parameters);
    let before = position_sigma_km(&filter);
    let mut jumped = filter.clone();
    jumped.advance(truth.time_us + MAX_GAP_US, &parameters).unwrap();
    for second in (0..7_200).map(|second| second + 1) {
        filter.advance(truth.time_us + second * 1_000_000, &parameters).unwrap();
    }
    // In one jump or second by second: the same orbit and nearly the same doubt.
    let apart = (filter.state().unwrap().position_km - jumped.state().unwrap().position_km).norm();
    assert!(apart < 0.05, "{apart}");
    for ((slow, fast), before) in
        position_sigma_km(&filter).iter().zip(position_sigma_km(&jumped)).zip(before)
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
fn a_mounting_that_stars_show_takes_its_error_out_of_the_place() {
    let parameters = positions();
    assert_eq!(parameters.misalignment, Misalignment::Considered);
    // Two sigma about the axes across the Earth's direction.
    let misalignment = Vector3::new(0.0, 1e-4, -1e-4);
    let mut filter = OrbitFilter::new();
    let mut truth = circular(42_164.0, 1.0);
    assert!(filter.initialise(truth, 10.0, 1e-3, &parameters));
    for _ in 0..300 {
        // A path that is turned sees the Earth elsewhere.
        let seen_km = truth.position_km + truth.position_km.cross(&misalignment);
        filter.update(truth.time_us, &fix_at(seen_km), &Matrix3::identity(), &parameters);
        truth = parameters.forces().propagate(&truth, 1_000_000).unwrap();
        filter.advance(truth.time_us, &parameters).unwrap();
    }
    let off_km = |filter: &OrbitFilter| (filter.state().unwrap().position_km - truth.position_km).norm();
    let (before_km, before_sigma_km) = (off_km(&filter), position_sigma_km(&filter));
    assert!(before_km > 4.0 && filter.misalignment_rad() == Vector3::zeros(), "{before_km}");
    let sigma_rad = 2e-6;
    let turn_rad = -misalignment.map(|angle| angle as f32);
    let seen = |turn_rad: Vector3<f32>| SeenTurn {
        sensitivity: Matrix3::identity() / sigma_rad,
        measured: turn_rad / sigma_rad,
    };
    filter.observe_mounting(&seen(turn_rad), true, &parameters);
    let (after_km, after_sigma_km) = (off_km(&filter), position_sigma_km(&filter));
    println!("{before_km:.2} km off of {before_sigma_km:?}, then {after_km:.2} of {after_sigma_km:?}");
    assert!(after_km < 0.2 * before_km);
    assert!(after_sigma_km.iter().zip(before_sigma_km).all(|(after, before)| *after <= before));
    assert!((filter.misalignment_rad() - turn_rad).norm() < 2.0 * sigma_rad);
    assert!(
        filter.misalignment_sigma_rad().unwrap().iter().all(|sigma| (*sigma / sigma_rad - 1.0).abs() < 0.1)
    );
    // Looks at the limb leave the misalignment as it is known, and its sigma.
    filter.update_by_fix(&good_fix(&truth), &Matrix3::identity(), &parameters);
    assert!((filter.misalignment_rad() - turn_rad).norm() < 2.0 * sigma_rad);
    // What is no number says nothing.
    let known = filter.clone();
    filter.observe_mounting(&seen(Vector3::repeat(f32::NAN)), true, &parameters);
    assert_eq!((filter.state(), filter.misalignment_rad()), (known.state(), known.misalignment_rad()));
}

#[test]
fn a_turn_that_is_not_sure_waits_for_another_that_agrees() {
    let parameters = positions();
    let mut filter = OrbitFilter::new();
    assert!(filter.initialise(circular(42_164.0, 1.0), 10.0, 1e-3, &parameters));
    // Stars of 4e-6 rad that do not see a turn about the line of sight, the path being turned by `turn_rad`.
    let sigma_rad = 4e-6;
    let sensitivity = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)) / sigma_rad;
    let true_rad = Vector3::new(3e-5, -6e-5, 0.0);
    let mut look = |turn_rad: Vector3<f32>| {
        let measured = sensitivity * (turn_rad - filter.misalignment_rad());
        filter.observe_mounting(&SeenTurn { sensitivity, measured }, false, &parameters);
        (filter.misalignment_rad(), filter.misalignment_sigma_rad().unwrap())
    };
    // What is seen in one image alone is not believed, nor two that contradict each other, nor what is far
    // from what was known and comes again.
    let (stray_rad, far_rad) = (Vector3::new(-2e-5, 6e-5, 0.0), Vector3::new(1e-3, 0.0, 0.0));
    for turn_rad in [far_rad, far_rad, stray_rad, true_rad] {
        assert_eq!(look(turn_rad).0, Vector3::zeros());
    }
    let (found_rad, [x, y, z]) = look(true_rad);
    assert!((found_rad - true_rad).norm() < sigma_rad, "{found_rad}");
    for sigma in [x, y] {
        assert!((sigma / sigma_rad * 2f32.sqrt() - 1.0).abs() < 0.1, "{sigma}");
    }
    assert!(z == parameters.misalignment_sigma_rad);
    // Both are used up.
    assert_eq!(look(true_rad).1, [x, y, z]);
    assert!(look(true_rad).1[0] < 0.8 * x);
}

#[test]
fn what_was_learned_of_the_mounting_goes_on_into_another_orbit() {
    let parameters = positions();
    let mut filter = OrbitFilter::new();
    let truth = circular(42_164.0, 1.0);
    let begin = |filter: &mut OrbitFilter| assert!(filter.initialise(truth, 10.0, 1e-3, &parameters));
    let mounting = |filter: &OrbitFilter| (filter.misalignment_rad(), filter.misalignment_sigma_rad());
    begin(&mut filter);
    let prior = mounting(&filter);
    let sensitivity = Matrix3::identity() / 4e-6;
    let seen = SeenTurn { sensitivity, measured: Vector3::new(10.0, 0.0, -5.0) };
    filter.observe_mounting(&seen, true, &parameters);
    let (learned_rad, sigma_rad) = mounting(&filter);
    let sigma_rad = sigma_rad.unwrap();
    assert!(learned_rad.norm() > 4e-5 && sigma_rad[0] < 5e-6);
    let kept = |filter: &OrbitFilter| {
        let (now_rad, sigma) = mounting(filter);
        let same = sigma.unwrap().iter().zip(&sigma_rad).all(|(one, other)| (one / other - 1.0).abs() < 1e-5);
        same && now_rad == learned_rad
    };
    // By another orbit of the ground, and over a gap; its upsets are found in the meantime.
    begin(&mut filter);
    assert!(kept(&filter));
    assert_eq!(filter.advance(truth.time_us - 1, &parameters), Err(ResetReason::Backwards));
    assert!(filter.state().is_none() && filter.misalignment_rad() == learned_rad && filter.word_sum() != 0);
    begin(&mut filter);
    assert!(kept(&filter));
    // Over a restart by what was told; an orbit that is known keeps its own, and what is out of bounds is
    // none.
    let mut restarted = OrbitFilter::new();
    for (turn_rad, sigma) in [(f32::NAN, 1e-6), (0.0, 0.0), (0.0, f32::INFINITY), (0.2, 1e-6)] {
        assert!(!restarted.initialise_mounting([turn_rad; 3], [sigma; 3]));
    }
    assert!(restarted.misalignment_rad() == Vector3::zeros() && restarted.word_sum() == 0);
    assert!(restarted.initialise_mounting(learned_rad.into(), sigma_rad) && restarted.word_sum() != 0);
    begin(&mut restarted);
    assert!(kept(&restarted) && !restarted.initialise_mounting([0.0; 3], sigma_rad));
    // Not over a reset.
    filter.reset();
    assert!(filter.misalignment_rad() == Vector3::zeros() && filter.word_sum() == 0);
    begin(&mut filter);
    assert_eq!(mounting(&filter), prior);
}

#[test]
fn an_orbit_into_the_earth_is_refused() {
    let parameters = positions();
    let mut filter = OrbitFilter::new();
    assert_eq!(filter.advance(5, &parameters), Ok(()));
    let falling = OrbitState { velocity_km_s: Vector3::zeros(), ..circular(7_000.0, 0.0) };
    assert!(!filter.initialise(falling, 1.0, 1.0, &parameters));
    let sound = circular(7_000.0, 0.0);
    assert!(!filter.initialise(sound, f64::NAN, 1.0, &parameters));
    assert!(!filter.initialise(sound, 1.0, 1e9, &parameters));
    assert!(!filter.initialise(
        OrbitState { position_km: Vector3::zeros(), ..falling },
        1.0,
        1.0,
        &parameters
    ));
}

#[test]
fn an_orbit_that_is_no_longer_known_is_stale() {
    let parameters = OrbitParameters::default();
    let state = circular(7_000.0, 51.0);
    // Kepler's third law: 5,829 s.
    let period_us = 5_829_000_000;
    for (position_sigma_km, stale) in [(10.0, true), (1.0, false)] {
        let mut filter = OrbitFilter::new();
        assert!(!filter.is_stale(0));
        assert!(filter.initialise(state, position_sigma_km, 1e-3, &parameters));
        assert_eq!(filter.settled(), !stale);
        filter.advance(state.time_us + period_us + 60_000_000, &parameters).unwrap();
        assert!(!filter.is_stale(period_us - 60_000_000));
        assert_eq!(filter.is_stale(period_us + 60_000_000), stale);
        assert!(!filter.is_stale(60_000_000));
    }
    // Worse than a tenth of the radius.
    let mut filter = OrbitFilter::new();
    assert!(filter.initialise(state, 1_000.0, 1.0, &parameters));
    assert!(filter.is_stale(0));
}

/// Rows of a fix in the direction of `x` from a state there.
fn rows(fix: &PositionFix, unit: bool) -> [(crate::factor::Row, f32); 3] {
    let state = OrbitState { time_us: 0, ..circular(7_000.0, 90.0) };
    rows_of(CentralBody::Earth, fix, &state, &Matrix3::identity(), (unit, 1.0, 0.0)).unwrap()
}

#[test]
fn a_direction_alone_says_nothing_of_the_distance_however_far_off_that_is() {
    let (sine, cosine) = libm::sincos(0.1);
    for ratio in [0.2, 0.6, 1.0, 1.7, 5.0, 40.0] {
        let position_km = Vector3::new(cosine, 0.0, sine) * (7_000.0 * ratio);
        let covariance_km2 = Matrix3::identity() * (70.0 * ratio) * (70.0 * ratio);
        let fix = PositionFix { position_km, covariance_km2, ..fix_at(position_km) };
        let rows = rows(&fix, true);
        // The sine of 0.1 rad over a hundredth, whatever the distance.
        let square: f32 = rows.iter().map(|(_, value)| value * value).sum();
        assert!((square.sqrt() - 9.98).abs() < 0.02, "{ratio}: {}", square.sqrt());
        assert!(rows.iter().all(|(row, _)| row[HEIGHT].abs() < 1e-6 && row[POSITION].abs() < 1e-6));
        let sensitivity: f32 = rows.iter().map(|(row, _)| row[POSITION + 2] * row[POSITION + 2]).sum();
        assert!((sensitivity.sqrt() * 70.0 - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_direction_the_other_way_is_the_farthest_off() {
    let across = |angle: f64| {
        let (sine, cosine) = libm::sincos(angle);
        let position_km = Vector3::new(cosine, 0.0, sine) * 7_000.0;
        let covariance_km2 = Matrix3::identity() * 70.0 * 70.0;
        let fix = PositionFix { position_km, covariance_km2, ..fix_at(position_km) };
        let squares = rows(&fix, true).map(|(_, value)| value * value);
        squares.iter().sum::<f32>().sqrt()
    };
    // A distance over its hundredth.
    for angle in [1.58, 2.0, 3.0, core::f64::consts::PI] {
        assert!((across(angle) - 100.0).abs() < 0.1, "{angle}: {}", across(angle));
    }
    assert!(across(0.5) < across(1.5));
}

/// Thesis §5.2: a radius wrong at the start. It is followed back, or refused as no orbit, or told as a
/// divergence, after which the orbit begins anew.
#[test]
fn a_start_many_earth_radii_off_converges() {
    for observation in [Observation::Position, Observation::Combined, Observation::UnitVector] {
        let parameters =
            OrbitParameters { observation, misalignment_sigma_rad: 0.0, ..OrbitParameters::default() };
        for radii in [0.5, 1.0, 3.0, 10.0, 100.0] {
            let mut truth = circular(42_164.0, 0.1);
            let mut filter = OrbitFilter::new();
            let off = radii * EARTH.radius_km;
            let wrong = OrbitState { position_km: truth.position_km * (1.0 + off / 42_164.0), ..truth };
            let taken = filter.initialise(wrong, off, 1.0, &parameters);
            // 0.02 deg across, 100 km along, a fix in 20 s, for 18 hours.
            let mut diverged = 0;
            for _ in 0..3_240 {
                truth = parameters.forces().propagate(&truth, 20_000_000).unwrap();
                let along =
                    truth.position_km * truth.position_km.transpose() / truth.position_km.norm_squared();
                let covariance_km2 = Matrix3::identity() * 216.0 + along * 1e4;
                let fix = PositionFix { covariance_km2, ..good_fix(&truth) };
                let update = filter.update(truth.time_us, &fix, &Matrix3::identity(), &parameters);
                diverged += u32::from(matches!(update, Update::Diverged(_)));
            }
            let apart = (filter.state().unwrap().position_km - truth.position_km).norm();
            std::println!(
                "{observation:?} from {radii} radii off, taken {taken}: {apart:.2} km after 18 h, {diverged} divergences"
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

fn assert_finite(filter: &OrbitFilter) {
    let Some(state) = filter.state() else { return };
    let factor = filter.factor().unwrap();
    let vectors = state.position_km.iter().chain(state.velocity_km_s.iter());
    let elements = (0..STATES).flat_map(|row| (0..=row).map(move |column| (row, column)));
    assert!(vectors.copied().all(f64::is_finite), "{state:?}");
    assert!(elements.map(|(row, column)| factor.covariance(row, column)).all(f32::is_finite));
    let sigmas = position_sigma_km(filter)
        .into_iter()
        .chain(filter.motion_covariance().unwrap().velocity_sigma_km_s());
    let [height, sigma] = filter.limb_height_km().unwrap();
    assert!(height.is_finite());
    assert!(sigmas.chain([sigma]).all(|sigma| sigma.is_finite() && sigma >= 0.0));
}

/// Heights of a limb, mostly possible.
fn heights() -> impl Strategy<Value = Vec<LimbHeight>> {
    let height = (prop::array::uniform3(number(1.0)), number(30.0), number(3.0)).prop_map(
        |(radial, height_km, sigma_km)| LimbHeight {
            radial: Vector3::from(radial).map(|x| x as f32),
            height_km: height_km as f32,
            sigma_km: sigma_km as f32,
        },
    );
    prop::collection::vec(height, 0..24)
}

#[test]
fn a_gap_is_crossed_over_several_seconds_in_which_nothing_is_told() {
    let parameters = OrbitParameters::default();
    let start = circular(7_000.0, 1.0);
    let mut at_once = OrbitFilter::new();
    assert!(at_once.initialise(start, 1.0, 0.001, &parameters));
    let mut slowly = at_once.clone();
    let to_us = start.time_us + MAX_GAP_US;
    at_once.advance(to_us, &parameters).unwrap();
    for call in 1..=MAX_SPANS / SPANS_A_SECOND {
        slowly.approach(to_us, &parameters).unwrap();
        assert_eq!(slowly.state().is_some(), call == MAX_SPANS / SPANS_A_SECOND);
    }
    assert_eq!(slowly.state(), at_once.state());
    assert_eq!(slowly.motion_covariance(), at_once.motion_covariance());
    assert!(slowly.approach(to_us + 2 * MAX_GAP_US, &parameters).is_err() && slowly.state().is_none());
}

#[test]
fn looks_of_a_limb_where_it_is_predicted_leave_the_state_where_it_is() {
    // From the true state, by heights that are those of the aberration alone: in GEO looks of 300 s.
    let parameters = OrbitParameters { tropics_km: 0.0, ..OrbitParameters::default() };
    for (radius_km, seconds) in [(42_164.0, 4_000), (7_000.0, 600)] {
        let mut truth = circular(radius_km, 51.0);
        let mut filter = OrbitFilter::new();
        assert!(filter.initialise(truth, 5.0, 1e-3, &parameters));
        let (limb_km, sine) = ((radius_km * radius_km - 6378.0 * 6378.0_f64).sqrt(), 6378.0 / radius_km);
        let mut taken = 0;
        for _ in 0..seconds {
            truth = parameters.forces().propagate(&truth, 1_000_000).unwrap();
            filter.advance(truth.time_us, &parameters).unwrap();
            taken += u32::from(matches!(filter.proceed(&parameters), Update::Accepted(_)));
            let axes = crate::lvlh::lvlh(&truth.position_km, &truth.velocity_km_s).unwrap();
            let speed = (axes * truth.velocity_km_s).x;
            let heights: Vec<_> = (0..24)
                .map(|k| {
                    let (y, x) = (f64::from(k) * 0.25).sin_cos();
                    let lifted = limb_km * (1.0 - sine * sine).sqrt() * x * speed / 299_792.458;
                    let radial = axes.transpose() * Vector3::new(x, y, 0.0);
                    let radial = radial.map(|axis| axis as f32);
                    LimbHeight { radial, height_km: lifted as f32, sigma_km: 1.0 }
                })
                .collect();
            let attitude = Matrix3::identity() * 1e-12;
            filter.observe_limb(&heights, 6_378.137, &Matrix3::identity(), &attitude, &parameters);
        }
        assert!(taken >= 3, "{taken}");
        let error_km = (filter.state().unwrap().position_km - truth.position_km).norm();
        assert!(error_km < 0.02, "{radius_km} km: {error_km} km after {taken} looks");
    }
}

proptest! {
    #[test]
    fn whatever_is_put_in_what_comes_out_is_finite(
        begin in prop::option::of((vector(2e4), vector(8.0), number(1e4), number(5.0))),
        fixes in prop::collection::vec(
            (step_us(), vector(3e4), vector(100.0), covariance(), vector(0.1), heights()),
            1..25
        ),
        observation in prop::sample::select(
            &[Observation::LimbHeights, Observation::Position, Observation::UnitVector, Observation::Combined]
        ),
        // The extremes of the table's ranges too.
        gate_sigma in prop::sample::select(&[3.0f32, 8.0, 100.0]),
        look_s in prop::sample::select(&[1.0f32, 300.0]),
        misalignment in prop::sample::select(&[Misalignment::Considered, Misalignment::Estimated]),
    ) {
        let parameters =
            OrbitParameters { observation, gate_sigma, look_s, misalignment, ..OrbitParameters::default() };
        let mut filter = OrbitFilter::new();
        let mut time_us = 760_000_000_000_000i64;
        if let Some((position_km, velocity_km_s, position_sigma, velocity_sigma)) = begin {
            let state = OrbitState { time_us, position_km, velocity_km_s };
            let taken = filter.initialise(state, position_sigma, velocity_sigma, &parameters);
            assert_eq!(taken, filter.state().is_some());
            assert_finite(&filter);
        } else {
            assert!(filter.initialise(circular(7_000.0, 51.0), 5.0, 0.01, &parameters));
        }
        for (span_us, position_km, aside, covariance_km2, tilt, heights) in fixes {
            time_us = time_us.saturating_add(span_us);
            let fix = PositionFix {
                position_km,
                covariance_km2,
                shared_km2: Matrix3::zeros(),
                linearisation_km: position_km + aside,
            };
            let to_icrs = Matrix3::identity() + fsw_ground::matrix::cross_matrix(&tilt);
            if observation == Observation::LimbHeights {
                let _ = filter.advance(time_us, &parameters);
                filter.proceed(&parameters);
                let attitude = Matrix3::identity() * 1e-9;
                filter.observe_limb(&heights, 6_378.137, &to_icrs, &attitude, &parameters);
            } else {
                match filter.update(time_us, &fix, &to_icrs, &parameters) {
                    Update::Accepted(nis) => assert!(nis.square >= 0.0),
                    Update::Collected | Update::Diverged(_) => assert!(filter.state().is_none()),
                    Update::Started => assert!(filter.state().is_some()),
                    Update::Gathered | Update::Downweighted(_) | Update::Refused(_) => {}
                }
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
