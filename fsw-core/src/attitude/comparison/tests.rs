//! Every method on the one interface: against an f64 oracle of its own, against the SVD, and against the
//! truth.

use super::*;
use crate::attitude::{ExtendedPair, VectorPair};
use crate::frames::Direction;
use crate::oracle::{self, ARCSEC, Generator, skewness, small_turn, turn, wide, wide_matrix};
use core::f64::consts::PI;
use nalgebra::{Matrix3, Matrix3 as M3};
use nalgebra::{Vector3, Vector3 as V3};
use proptest::prelude::*;
use std::vec::Vec;

/// Those that solve Wahba's problem itself.
const OPTIMAL: [WahbaMethod; 7] = [
    WahbaMethod::Svd,
    WahbaMethod::Davenport,
    WahbaMethod::Quest,
    WahbaMethod::Foam,
    WahbaMethod::Esoq,
    WahbaMethod::Esoq2,
    WahbaMethod::Anisotropic,
];
const SIGMA_RAD: f32 = 1e-4;

pub(in crate::attitude) fn pair(measured: &V3<f64>, reference: &V3<f64>, sigma_rad: f32) -> VectorPair {
    VectorPair {
        measured: Direction::new(measured.map(|x| x as f32)).unwrap(),
        reference: Direction::new(reference.map(|x| x as f32)).unwrap(),
        sigma_rad,
    }
}

/// Stars at these places in the star path, each off by a gaussian of `noise_rad` per axis.
pub(in crate::attitude) fn sky(
    generator: &mut Generator,
    attitude: &M3<f64>,
    stars: &[V3<f64>],
    noise_rad: f64,
) -> Vec<VectorPair> {
    let see = |star: &V3<f64>| {
        let off = (star + generator.gaussian_vector() * noise_rad).normalize();
        pair(&off, &(attitude.transpose() * star), SIGMA_RAD)
    };
    stars.iter().map(see).collect()
}

pub(in crate::attitude) fn field(generator: &mut Generator, count: usize, radius_deg: f64) -> Vec<V3<f64>> {
    (0..count).map(|_| generator.unit_in_cap(radius_deg.to_radians())).collect()
}

/// Optimum in f64 for exactly the values that the flight code was given.
pub(in crate::attitude) fn optimum(pairs: &[VectorPair]) -> M3<f64> {
    let items: Vec<_> = pairs
        .iter()
        .map(|pair| {
            let sigma = f64::from(pair.sigma_rad);
            (wide(pair.measured.vector()), wide(pair.reference.vector()), 1e-8 / (sigma * sigma))
        })
        .collect();
    oracle::wahba(&items)
}

/// Angle, arcsec, across the line of sight and about it, by which a method misses an attitude.
fn miss_arcsec(method: WahbaMethod, pairs: &[VectorPair], attitude: &M3<f64>) -> (f64, f64) {
    let found =
        solve(method, pairs).unwrap_or_else(|error| panic!("{method:?}: {error:?} {pairs:?}")).attitude;
    assert!(skewness(found.matrix()) < 2e-6, "{method:?}: {:e}", skewness(found.matrix()));
    assert!((wide_matrix(found.matrix()).determinant() - 1.0).abs() < 2e-6);
    let off = small_turn(attitude, &wide_matrix(found.matrix())) * ARCSEC;
    (off.x.hypot(off.y), off.z.abs())
}

/// Greatest separation of two of the stars, rad.
fn spread_rad(stars: &[V3<f64>]) -> f64 {
    let chord = |one: &V3<f64>| stars.iter().map(|other| (one - other).norm()).fold(0.0, f64::max);
    stars.iter().map(chord).fold(0.0, f64::max)
}

/// Rounding against that of the optimal methods: least squares magnify it, up to a hundredfold for three
/// stars close to a great circle.
fn rounding_of(method: WahbaMethod) -> f64 {
    if method == WahbaMethod::LeastSquares { 100.0 } else { 1.0 }
}

#[test]
fn every_optimal_method_finds_the_optimum() {
    // Name, seed, field radius, noise, greatest error across and in roll, arcsec.
    for (name, seed, radius_deg, noise_rad, across, roll) in [
        ("6 deg field", 1, 3.0, 0.0, 0.06, 0.8),
        ("6 deg field, 20 arcsec", 2, 3.0, 1e-4, 0.06, 0.8),
        ("reference field", 3, 11.0, 0.0, 0.06, 0.25),
        ("reference field, 200 arcsec", 4, 11.0, 1e-3, 0.07, 0.25),
    ] {
        let mut generator = Generator::new(seed);
        let mut greatest = [(0.0f64, 0.0f64); OPTIMAL.len()];
        for case in 0..20_000 {
            let attitude = generator.rotation();
            let stars = field(&mut generator, 3 + case % 10, radius_deg);
            let pairs = sky(&mut generator, &attitude, &stars, noise_rad);
            let optimum = optimum(&pairs);
            for (method, greatest) in OPTIMAL.iter().zip(&mut greatest) {
                let off = miss_arcsec(*method, &pairs, &optimum);
                *greatest = (greatest.0.max(off.0), greatest.1.max(off.1));
            }
        }
        for (method, greatest) in OPTIMAL.iter().zip(greatest) {
            std::println!("{name}, {method:?}: {:.3} across, {:.3} roll", greatest.0, greatest.1);
            assert!(greatest.0 < across && greatest.1 < roll, "{name}, {method:?}: {greatest:?} arcsec");
        }
    }
}

#[test]
fn two_stars_are_enough_for_every_method() {
    for method in WahbaMethod::ALL {
        let mut generator = Generator::new(5);
        let mut worst = (0.0f64, 0.0f64);
        for _ in 0..5000 {
            let attitude = generator.rotation();
            let first = generator.unit_in_cap(0.15);
            let axis = first.cross(&generator.unit()).normalize();
            let apart = generator.between(2.0, 10.0).to_radians();
            let stars = [first, turn(&(axis * apart)) * first];
            // Without noise, so that what is no optimum has nothing to be wrong about.
            let noise = if method == WahbaMethod::LeastSquares { 0.0 } else { 1e-4 };
            let pairs = sky(&mut generator, &attitude, &stars, noise);
            let (across, roll) = miss_arcsec(method, &pairs, &optimum(&pairs));
            worst = (worst.0.max(across), worst.1.max(roll * apart));
        }
        std::println!("two stars, {method:?}: {:.3} across, {:.4} roll x rad", worst.0, worst.1);
        let limit = rounding_of(method);
        assert!(worst.0 < 0.09 * limit && worst.1 < 0.03 * limit, "{method:?}: {worst:?} arcsec");
    }
}

#[test]
fn nearly_parallel_stars_keep_the_roll_to_rounding_over_separation() {
    for method in OPTIMAL {
        let mut generator = Generator::new(6);
        let mut worst = 0.0f64;
        for case in 0..3000 {
            let attitude = generator.rotation();
            let centre = generator.unit_in_cap(0.15);
            let axis = centre.cross(&generator.unit()).normalize();
            let apart = generator.between(0.3, 1.0).to_radians();
            let places: &[f64] = if case % 2 == 0 { &[-0.5, 0.5] } else { &[-0.5, 0.0, 0.5] };
            let stars: Vec<_> = places.iter().map(|share| turn(&(axis * (apart * share))) * centre).collect();
            let pairs = sky(&mut generator, &attitude, &stars, 0.0);
            worst = worst.max(miss_arcsec(method, &pairs, &optimum(&pairs)).1 * apart);
        }
        std::println!("nearly parallel, {method:?}: {worst:.4} roll x rad");
        assert!(worst < 0.04, "{method:?}: {worst} arcsec rad");
    }
}

#[test]
fn half_turns_are_found_by_every_method() {
    for method in WahbaMethod::ALL {
        let mut generator = Generator::new(7);
        for index in 0..2000 {
            let axis = match index % 4 {
                0 => V3::x(),
                1 => V3::y(),
                2 => V3::z(),
                _ => generator.unit(),
            };
            let attitude = turn(&(axis * if index % 8 < 4 { PI } else { PI - 1e-4 }));
            let stars = field(&mut generator, 2 + index % 5, 10.0);
            if spread_rad(&stars) < 0.03 {
                continue;
            }
            let pairs = sky(&mut generator, &attitude, &stars, 0.0);
            if method == WahbaMethod::LeastSquares
                && solve(method, &pairs).map(|_| ()) == Err(WahbaError::Collinear)
            {
                continue;
            }
            let (across, roll) = miss_arcsec(method, &pairs, &attitude);
            let limit = rounding_of(method);
            assert!(across < limit && roll < 10.0 * limit, "{method:?}: {across} {roll} arcsec");
        }
    }
}

fn cost(pairs: &[VectorPair], attitude: &M3<f64>) -> f64 {
    pairs.iter().fold(0.0, |sum, pair| {
        sum + (wide(pair.measured.vector()) - attitude * wide(pair.reference.vector())).norm_squared()
    })
}

/// QUEST in f32 as it is usually written: B summed in the frames given, Newton on lambda from one, no guard.
fn usual_quest(pairs: &[VectorPair]) -> M3<f64> {
    let total: f32 = pairs.iter().map(VectorPair::weight).sum();
    let b = pairs.iter().fold(Matrix3::zeros(), |sum, pair| {
        sum + pair.measured.vector() * pair.reference.vector().transpose() * (pair.weight() / total)
    });
    let s = b + b.transpose();
    let z = Vector3::new(b.m23 - b.m32, b.m31 - b.m13, b.m12 - b.m21);
    let (sigma, kappa, delta) = (b.trace(), profile::cofactors(&s).trace(), s.determinant());
    let (a, c) = (sigma * sigma - kappa, delta + z.dot(&(s * z)));
    let (e, d) = (sigma * sigma + z.dot(&z), z.dot(&(s * s * z)));
    let mut lambda = 1.0;
    for _ in 0..10 {
        let value = (lambda * lambda - a) * (lambda * lambda - e) - c * lambda + (c * sigma - d);
        lambda -= value / (2.0 * lambda * (2.0 * lambda * lambda - a - e) - c);
    }
    let m = Matrix3::identity() * (lambda + sigma) - s;
    let v = profile::cofactors(&m) * z;
    let q = [v.x, v.y, v.z, m.determinant()].map(f64::from);
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    oracle::rotation_of(q.map(|x| x / norm))
}

#[test]
fn without_axis_frames_f32_is_not_enough_for_the_characteristic_polynomial() {
    // Field radius and the error beyond which half of the fields lie, and one in a hundred, arcsec, at least.
    for (radius_deg, half, hundredth) in [(3.0, 10.0, 100.0), (11.0, 0.5, 10.0)] {
        let mut generator = Generator::new(15);
        let mut misses: Vec<f64> = (0..5000)
            .map(|case| {
                let attitude = generator.rotation();
                let stars = field(&mut generator, 3 + case % 10, radius_deg);
                let pairs = sky(&mut generator, &attitude, &stars, 1e-4);
                small_turn(&optimum(&pairs), &usual_quest(&pairs)).norm() * ARCSEC
            })
            .collect();
        misses.sort_by(f64::total_cmp);
        let (median, percentile) = (misses[2500], misses[4950]);
        std::println!(
            "QUEST without axis frames, {radius_deg} deg: median {median:.2}, 99 % {percentile:.1} arcsec"
        );
        assert!(median > half && percentile > hundredth, "{median} {percentile}");
    }
}

#[test]
fn few_stars_with_a_degree_of_noise_still_give_the_optimum() {
    // Where QUEST implementations of others are known to fail.
    for method in OPTIMAL {
        let mut generator = Generator::new(8);
        for case in 0..5000 {
            let attitude = generator.rotation();
            let stars = field(&mut generator, 2 + case % 4, 11.0);
            let pairs = sky(&mut generator, &attitude, &stars, 0.017);
            if spread_rad(&stars) < 0.15 {
                continue;
            }
            let found = wide_matrix(solve(method, &pairs).unwrap().attitude.matrix());
            let (found, best) = (cost(&pairs, &found), cost(&pairs, &optimum(&pairs)));
            assert!(found <= best * 1.001 + 1e-9, "{method:?}: {found} against {best}");
        }
    }
}

#[test]
fn directions_all_over_the_sky_are_as_good() {
    // Two heads back to back among them: the mean direction says nothing.
    for method in WahbaMethod::ALL {
        let mut generator = Generator::new(9);
        let mut worst = 0.0f64;
        for case in 0..5000 {
            let attitude = generator.rotation();
            let mut stars: Vec<_> = (0..4 + case % 6).map(|_| generator.unit()).collect();
            if case % 2 == 0 {
                stars = field(&mut generator, 6, 10.0);
                stars.iter_mut().step_by(2).for_each(|star| *star = -*star);
            }
            let pairs = sky(&mut generator, &attitude, &stars, 0.0);
            let (across, roll) = miss_arcsec(method, &pairs, &attitude);
            worst = worst.max(across.max(roll));
        }
        std::println!("all over the sky, {method:?}: {worst:.3} arcsec");
        assert!(worst < 0.2 * rounding_of(method), "{method:?}: {worst} arcsec");
    }
}

#[test]
fn a_star_counts_by_the_inverse_square_of_its_sigma() {
    for method in OPTIMAL {
        let mut generator = Generator::new(10);
        let mut worst = (0.0f64, 0.0f64);
        for case in 0..3000 {
            let attitude = generator.rotation();
            let stars = field(&mut generator, 4 + case % 6, 11.0);
            let mut pairs = sky(&mut generator, &attitude, &stars, 1e-4);
            for pair in &mut pairs {
                pair.sigma_rad = 10f64.powf(generator.between(-5.0, -3.5)) as f32;
            }
            let (across, roll) = miss_arcsec(method, &pairs, &optimum(&pairs));
            worst = (worst.0.max(across), worst.1.max(roll));
        }
        std::println!("weighted, {method:?}: {:.3} across, {:.3} roll", worst.0, worst.1);
        assert!(worst.0 < 0.08 && worst.1 < 0.5, "{method:?}: {worst:?} arcsec");
    }
}

#[test]
fn the_loss_is_half_a_chi_square() {
    for method in OPTIMAL {
        let mut generator = Generator::new(11);
        let (mut sum, mut freedom) = (0.0, 0.0);
        for case in 0..4000 {
            let attitude = generator.rotation();
            let stars = field(&mut generator, 3 + case % 8, 11.0);
            let pairs = sky(&mut generator, &attitude, &stars, f64::from(SIGMA_RAD));
            sum += 2.0 * f64::from(solve(method, &pairs).unwrap().loss);
            freedom += 2.0 * stars.len() as f64 - 3.0;
        }
        // Four sigmas of a chi-square.
        let ratio: f64 = sum / freedom;
        assert!((ratio - 1.0).abs() < 4.0 * (2.0 / freedom).sqrt(), "{method:?}: {ratio}");
    }
}

#[test]
fn directions_that_fix_no_attitude_are_refused_with_the_reason() {
    for method in WahbaMethod::ALL {
        let mut generator = Generator::new(12);
        let refused = |pairs: &[VectorPair]| match solve(method, pairs) {
            Err(reason) => reason,
            Ok(found) => panic!("{method:?} {pairs:?}: {found:?}"),
        };
        assert_eq!(refused(&[]), WahbaError::TooFew);
        for _ in 0..1000 {
            let (star, reference) = (generator.unit_in_cap(0.3), generator.unit());
            let same = pair(&star, &reference, SIGMA_RAD);
            let beside = |v: &V3<f64>| (v + v.cross(&V3::new(0.3, 0.4, 0.5)) * 5e-5).normalize();
            let near = pair(&beside(&star), &beside(&reference), SIGMA_RAD);
            let opposite = pair(&-star, &-reference, SIGMA_RAD);
            assert_eq!(refused(&[same]), WahbaError::TooFew, "{method:?}");
            for pairs in [&[same; 2][..], &[same; 7], &[same, opposite], &[same, near], &[same, near, same]] {
                assert_eq!(refused(pairs), WahbaError::Parallel, "{method:?} {pairs:?}");
            }
            // Two measured directions that belong to one reference.
            let other = pair(&generator.unit_in_cap(0.3), &reference, SIGMA_RAD);
            assert_eq!(refused(&[same, other]), WahbaError::Parallel, "{method:?}");
        }
    }
}

#[test]
fn weights_that_are_none_are_refused_with_the_reason() {
    for method in WahbaMethod::ALL {
        for (bad, reason) in [
            (f32::NAN, WahbaError::NotFinite),
            (f32::INFINITY, WahbaError::NotFinite),
            (0.0, WahbaError::Weight),
            (-1e-4, WahbaError::Weight),
            (1.0, WahbaError::Weight),
        ] {
            let place = V3::new(0.1, 0.0, 1.0);
            let pairs = [pair(&V3::z(), &V3::z(), SIGMA_RAD), pair(&place, &place, bad)];
            assert_eq!(solve(method, &pairs).map(|_| ()).unwrap_err(), reason, "{method:?} {bad}");
        }
    }
    let pair = pair(&V3::z(), &V3::z(), SIGMA_RAD);
    for (covariance, reason) in [
        ([f32::NAN, 0.0, 1e-8], WahbaError::NotFinite),
        ([1e-8, 0.0, f32::INFINITY], WahbaError::NotFinite),
        ([0.0, 0.0, 1e-8], WahbaError::Weight),
        ([1e-8, 0.0, -1e-8], WahbaError::Weight),
        ([1e-8, 1e-8, 1e-8], WahbaError::Weight),
    ] {
        assert_eq!(ExtendedPair::new(pair, covariance).map(|_| ()).unwrap_err(), reason, "{covariance:?}");
    }
    let beside = VectorPair { measured: Direction::new(Vector3::x()).unwrap(), ..pair };
    assert_eq!(ExtendedPair::new(beside, [1e-8, 0.0, 1e-8]).map(|_| ()).unwrap_err(), WahbaError::Weight);
}

#[test]
fn pairs_that_contradict_each_other_are_ambiguous() {
    // A triangle seen in a mirror: the attitude may be turned about the line of sight at will.
    let star = |x: f64, y: f64| pair(&V3::new(-x, y, 5.0), &V3::new(x, y, 5.0), SIGMA_RAD);
    let pairs = [star(0.0, 1.0), star(-0.75f64.sqrt(), -0.5), star(0.75f64.sqrt(), -0.5)];
    for method in
        [WahbaMethod::Davenport, WahbaMethod::Quest, WahbaMethod::Foam, WahbaMethod::Esoq, WahbaMethod::Esoq2]
    {
        assert_eq!(solve(method, &pairs).map(|_| ()).unwrap_err(), WahbaError::Ambiguous, "{method:?}");
    }
}

#[test]
fn stars_on_a_great_circle_are_refused_by_least_squares_alone() {
    let mut generator = Generator::new(13);
    for _ in 0..500 {
        let attitude = generator.rotation();
        let centre = generator.unit_in_cap(0.1);
        let axis = centre.cross(&generator.unit()).normalize();
        let stars = [-0.08, 0.01, 0.05].map(|angle| turn(&(axis * angle)) * centre);
        let pairs = sky(&mut generator, &attitude, &stars, 1e-5);
        assert_eq!(solve(WahbaMethod::LeastSquares, &pairs).map(|_| ()).unwrap_err(), WahbaError::Collinear);
        OPTIMAL.iter().for_each(|method| assert!(solve(*method, &pairs).is_ok(), "{method:?}"));
    }
}

fn any_pair() -> impl Strategy<Value = VectorPair> {
    let sigma = prop_oneof![any::<f32>(), (-9.0f32..0.0).prop_map(|power| 10f32.powf(power))];
    let vector = || prop::array::uniform3(-1.0f32..1.0).prop_map(Vector3::from);
    (vector(), vector(), sigma).prop_map(|(measured, reference, sigma_rad)| VectorPair {
        measured: Direction::new(measured).unwrap_or(Direction::z()),
        reference: Direction::new(reference).unwrap_or(Direction::z()),
        sigma_rad,
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: prop::test_runner::RngSeed::Fixed(14),
        cases: 2000,
        ..ProptestConfig::default()
    })]

    /// Pairs that agree in nothing, with weights that differ by many powers of ten.
    #[test]
    fn any_pairs_give_a_rotation_or_a_refusal(pairs in prop::collection::vec(any_pair(), 0..12)) {
        let usable = |pair: &VectorPair| pair.sigma_rad > 1e-9 && pair.sigma_rad < 1.0;
        let good: Vec<_> = pairs.iter().copied().filter(usable).collect();
        let both = |method| [(method, &pairs), (method, &good)];
        for (method, pairs) in WahbaMethod::ALL.into_iter().flat_map(both) {
            if let Ok(found) = solve(method, pairs) {
                let matrix = found.attitude.matrix();
                prop_assert!(skewness(matrix) < 1e-5, "{method:?} {matrix:?}");
                prop_assert!((wide_matrix(matrix).determinant() - 1.0).abs() < 1e-5);
                prop_assert!(found.loss >= 0.0 && found.covariance_rad2.iter().all(|x| x.is_finite()));
            }
        }
    }

    /// Whatever the noise, from none to degrees.
    #[test]
    fn every_method_agrees_with_the_svd(
        seed in any::<u64>(),
        count in 2usize..10,
        noise_power in -6.0f64..-1.5,
    ) {
        let mut generator = Generator::new(seed);
        let attitude = generator.rotation();
        let stars = field(&mut generator, count, 11.0);
        prop_assume!(spread_rad(&stars) > 0.1);
        let noise = 10f64.powf(noise_power);
        let pairs = sky(&mut generator, &attitude, &stars, noise);
        let svd = wide_matrix(solve(WahbaMethod::Svd, &pairs).unwrap().attitude.matrix());
        for method in OPTIMAL {
            let (across, roll) = miss_arcsec(method, &pairs, &svd);
            // Rounding, and what Gauss-Newton leaves of errors of degrees.
            let limit = 0.1 + noise * noise * 1e3;
            prop_assert!(across < limit && roll < 10.0 * limit, "{method:?}: {across} {roll}");
        }
    }
}

mod honesty;
