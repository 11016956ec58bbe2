use super::*;
use crate::frames::Direction;
use crate::oracle::{self, ARCSEC, Generator, skewness, small_turn, turn, wide, wide_matrix};
use core::f64::consts::PI;
use nalgebra::Matrix3 as M3;
use nalgebra::Vector3 as V3;
use proptest::prelude::*;
use std::vec::Vec;

const SIGMA_RAD: f32 = 1e-4;

fn pair(measured: &V3<f64>, reference: &V3<f64>, sigma_rad: f32) -> VectorPair {
    VectorPair {
        measured: Direction::new(measured.map(|x| x as f32)).unwrap(),
        reference: Direction::new(reference.map(|x| x as f32)).unwrap(),
        sigma_rad,
    }
}

/// Stars at these places in the star path, each off by a gaussian of `noise_rad` per axis.
fn sky(generator: &mut Generator, attitude: &M3<f64>, stars: &[V3<f64>], noise_rad: f64) -> Vec<VectorPair> {
    let see = |star: &V3<f64>| {
        let off = (star + generator.gaussian_vector() * noise_rad).normalize();
        pair(&off, &(attitude.transpose() * star), SIGMA_RAD)
    };
    stars.iter().map(see).collect()
}

fn field(generator: &mut Generator, count: usize, radius_deg: f64) -> Vec<V3<f64>> {
    (0..count).map(|_| generator.unit_in_cap(radius_deg.to_radians())).collect()
}

/// Optimum in f64 for exactly the values that the flight code was given.
fn optimum(pairs: &[VectorPair]) -> M3<f64> {
    let items: Vec<_> = pairs
        .iter()
        .map(|pair| {
            let sigma = f64::from(pair.sigma_rad);
            (wide(pair.measured.vector()), wide(pair.reference.vector()), 1e-8 / (sigma * sigma))
        })
        .collect();
    oracle::wahba(&items)
}

/// Angle, arcsec, across the line of sight and about it, by which the flight code misses the optimum.
fn miss_arcsec(pairs: &[VectorPair]) -> (f64, f64) {
    let found = solve(pairs).unwrap();
    assert!(skewness(found.matrix()) < 2e-6, "{:e}", skewness(found.matrix()));
    assert!((wide_matrix(found.matrix()).determinant() - 1.0).abs() < 2e-6);
    let off = small_turn(&optimum(pairs), &wide_matrix(found.matrix())) * ARCSEC;
    (off.x.hypot(off.y), off.z.abs())
}

/// Greatest and root-mean-square miss across and in roll over many fields.
struct Misses {
    greatest: (f64, f64),
    rms: (f64, f64),
}

fn misses(seed: u64, radius_deg: f64, noise_rad: f64, cases: usize) -> Misses {
    let mut generator = Generator::new(seed);
    let (mut greatest, mut square) = ((0.0f64, 0.0f64), (0.0, 0.0));
    for case in 0..cases {
        let attitude = generator.rotation();
        let stars = field(&mut generator, 3 + case % 10, radius_deg);
        let (across, roll) = miss_arcsec(&sky(&mut generator, &attitude, &stars, noise_rad));
        greatest = (greatest.0.max(across), greatest.1.max(roll));
        square = (square.0 + across * across, square.1 + roll * roll);
    }
    let mean = |sum: f64| (sum / cases as f64).sqrt();
    Misses { greatest, rms: (mean(square.0), mean(square.1)) }
}

#[test]
fn agrees_with_an_f64_oracle() {
    // Name, seed, field radius, noise, greatest error across and in roll, arcsec.
    for (name, seed, radius_deg, noise_rad, across, roll) in [
        ("6 deg field", 1, 3.0, 0.0, 0.05, 0.7),
        ("6 deg field, 20 arcsec", 2, 3.0, 1e-4, 0.05, 0.7),
        ("reference field", 3, 11.0, 0.0, 0.05, 0.2),
        ("reference field, 200 arcsec", 4, 11.0, 1e-3, 0.06, 0.2),
    ] {
        let Misses { greatest, rms } = misses(seed, radius_deg, noise_rad, 20_000);
        std::println!(
            "{name}: greatest {:.3} across, {:.3} roll; rms {:.3}, {:.3} arcsec",
            greatest.0,
            greatest.1,
            rms.0,
            rms.1
        );
        assert!(greatest.0 < across && greatest.1 < roll, "{name}: {greatest:?} arcsec");
    }
}

#[test]
fn two_stars_are_enough() {
    let mut generator = Generator::new(5);
    let mut worst = (0.0f64, 0.0f64);
    for _ in 0..5000 {
        let attitude = generator.rotation();
        let first = generator.unit_in_cap(0.15);
        // 2 to 10 degrees apart: the error in roll is the rounding over the separation.
        let apart = generator.between(2.0, 10.0).to_radians();
        let axis = first.cross(&generator.unit()).normalize();
        let second = turn(&(axis * apart)) * first;
        let (across, roll) = miss_arcsec(&sky(&mut generator, &attitude, &[first, second], 1e-4));
        worst = (worst.0.max(across), worst.1.max(roll * apart));
    }
    std::println!("two stars: {:.3} across, {:.4} roll x rad", worst.0, worst.1);
    assert!(worst.0 < 0.08 && worst.1 < 0.03, "{worst:?} arcsec");
}

#[test]
fn nearly_parallel_stars_keep_the_roll_to_rounding_over_separation() {
    let mut generator = Generator::new(6);
    let mut worst = 0.0f64;
    for _ in 0..3000 {
        let attitude = generator.rotation();
        let centre = generator.unit_in_cap(0.15);
        let axis = centre.cross(&generator.unit()).normalize();
        let apart = generator.between(0.3, 1.0).to_radians();
        let stars = [-0.5, 0.0, 0.5].map(|share| turn(&(axis * (apart * share))) * centre);
        let (_, roll) = miss_arcsec(&sky(&mut generator, &attitude, &stars, 0.0));
        worst = worst.max(roll * apart);
    }
    std::println!("nearly parallel: {worst:.4} roll x rad");
    assert!(worst < 0.03, "{worst} arcsec rad");
}

#[test]
fn half_turns_are_found() {
    let mut generator = Generator::new(7);
    for index in 0..2000 {
        let axis = match index % 4 {
            0 => V3::x(),
            1 => V3::y(),
            2 => V3::z(),
            _ => generator.unit(),
        };
        let attitude = turn(&(axis * if index % 8 < 4 { PI } else { PI - 1e-4 }));
        let count = 2 + index % 5;
        let stars = field(&mut generator, count, 10.0);
        if spread_rad(&stars) < 0.03 {
            continue;
        }
        let found = solve(&sky(&mut generator, &attitude, &stars, 0.0)).unwrap();
        let off = small_turn(&attitude, &wide_matrix(found.matrix()));
        assert!(off.norm() * ARCSEC < 10.0, "{} arcsec", off.norm() * ARCSEC);
    }
}

/// Greatest separation of two of the stars, rad.
fn spread_rad(stars: &[V3<f64>]) -> f64 {
    let chord = |one: &V3<f64>| stars.iter().map(|other| (one - other).norm()).fold(0.0, f64::max);
    stars.iter().map(chord).fold(0.0, f64::max)
}

#[test]
fn noise_far_beyond_its_sigma_still_gives_the_optimum() {
    // A degree of noise on few stars is where QUEST implementations fail.
    let mut generator = Generator::new(8);
    for case in 0..3000 {
        let attitude = generator.rotation();
        let stars = field(&mut generator, 2 + case % 4, 11.0);
        let pairs = sky(&mut generator, &attitude, &stars, 0.017);
        if spread_rad(&stars) < 0.15 {
            continue;
        }
        let cost = |a: &M3<f64>| {
            pairs.iter().fold(0.0, |sum, pair| {
                sum + (wide(pair.measured.vector()) - a * wide(pair.reference.vector())).norm_squared()
            })
        };
        let (found, best) = (cost(&wide_matrix(solve(&pairs).unwrap().matrix())), cost(&optimum(&pairs)));
        assert!(found <= best * 1.001 + 1e-9, "{found} against {best}");
    }
}

#[test]
fn a_star_counts_by_the_inverse_square_of_its_sigma() {
    let mut generator = Generator::new(9);
    let mut worst = (0.0f64, 0.0f64);
    for case in 0..3000 {
        let attitude = generator.rotation();
        let stars = field(&mut generator, 4 + case % 6, 11.0);
        let mut pairs = sky(&mut generator, &attitude, &stars, 1e-4);
        for pair in &mut pairs {
            pair.sigma_rad = 10f64.powf(generator.between(-5.0, -3.5)) as f32;
        }
        let (across, roll) = miss_arcsec(&pairs);
        worst = (worst.0.max(across), worst.1.max(roll));
    }
    std::println!("weighted: {:.3} across, {:.3} roll", worst.0, worst.1);
    assert!(worst.0 < 0.05 && worst.1 < 0.3, "{worst:?} arcsec");
}

#[test]
fn directions_that_fix_no_attitude_are_refused() {
    let mut generator = Generator::new(10);
    let refused = |pairs: &[VectorPair]| solve(pairs).map(|_| ()).unwrap_err();
    assert_eq!(refused(&[]), WahbaError::TooFew);
    for _ in 0..2000 {
        let (star, reference) = (generator.unit(), generator.unit());
        let same = pair(&star, &reference, SIGMA_RAD);
        assert_eq!(refused(&[same]), WahbaError::TooFew);
        assert_eq!(refused(&[same; 2]), WahbaError::Degenerate);
        assert_eq!(refused(&[same; 7]), WahbaError::Degenerate);
        // A star and the point opposite fix no more.
        assert_eq!(refused(&[same, pair(&-star, &-reference, SIGMA_RAD)]), WahbaError::Degenerate);
        // Five arcseconds apart is the same star for a field that is degrees wide.
        let beside = |v: &V3<f64>| (v + v.cross(&V3::new(0.3, 0.4, 0.5)) * 5e-5).normalize();
        assert_eq!(
            refused(&[same, pair(&beside(&star), &beside(&reference), SIGMA_RAD)]),
            WahbaError::Degenerate
        );
    }
}

#[test]
fn a_sigma_that_is_no_sigma_is_refused() {
    for bad in [f32::NAN, f32::INFINITY, 0.0, -1e-4, 1.0] {
        let good = pair(&V3::z(), &V3::z(), SIGMA_RAD);
        let pairs = [good, pair(&V3::new(0.1, 0.0, 1.0), &V3::new(0.1, 0.0, 1.0), bad)];
        assert_eq!(solve(&pairs).map(|_| ()).unwrap_err(), WahbaError::NotFinite, "{bad}");
    }
}

#[test]
fn turning_all_references_turns_the_answer() {
    let mut generator = Generator::new(11);
    let mut worst = (0.0f64, 0.0f64);
    for _ in 0..2000 {
        let (attitude, by) = (generator.rotation(), generator.rotation());
        let stars = field(&mut generator, 6, 11.0);
        let pairs = sky(&mut generator, &attitude, &stars, 1e-3);
        let turned: Vec<_> = pairs
            .iter()
            .map(|seen| VectorPair {
                reference: Direction::new((by * wide(seen.reference.vector())).map(|x| x as f32)).unwrap(),
                ..*seen
            })
            .collect();
        let [one, other] = [&pairs, &turned].map(|pairs| wide_matrix(solve(pairs).unwrap().matrix()));
        let off = small_turn(&one, &(other * by)) * ARCSEC;
        worst = (worst.0.max(off.x.hypot(off.y)), worst.1.max(off.z.abs()));
    }
    std::println!("references turned: {:.3} across, {:.3} roll", worst.0, worst.1);
    assert!(worst.0 < 0.06 && worst.1 < 0.2, "{worst:?} arcsec");
}

#[test]
fn the_order_of_the_pairs_matters_to_rounding_only() {
    let mut generator = Generator::new(12);
    let mut worst = (0.0f64, 0.0f64);
    for _ in 0..2000 {
        let attitude = generator.rotation();
        let stars = field(&mut generator, 8, 11.0);
        let mut pairs = sky(&mut generator, &attitude, &stars, 1e-3);
        let one = wide_matrix(solve(&pairs).unwrap().matrix());
        let place = generator.bits() as usize % pairs.len();
        pairs.rotate_left(place);
        pairs.reverse();
        let off = small_turn(&one, &wide_matrix(solve(&pairs).unwrap().matrix())) * ARCSEC;
        worst = (worst.0.max(off.x.hypot(off.y)), worst.1.max(off.z.abs()));
    }
    std::println!("order: {:.3} across, {:.3} roll", worst.0, worst.1);
    assert!(worst.0 < 0.05 && worst.1 < 0.1, "{worst:?} arcsec");
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
    /// Pairs that agree in nothing, with weights that differ by many powers of ten.
    #[test]
    fn any_pairs_give_a_rotation_or_a_refusal(pairs in prop::collection::vec(any_pair(), 0..12)) {
        if let Ok(found) = solve(&pairs) {
            prop_assert!(skewness(found.matrix()) < 1e-5, "{:?}", found.matrix());
            prop_assert!((wide_matrix(found.matrix()).determinant() - 1.0).abs() < 1e-5);
        }
        let good: Vec<_> = pairs.into_iter().filter(|pair| pair.sigma_rad > 1e-9 && pair.sigma_rad < 1.0).collect();
        if let Ok(found) = solve(&good) {
            prop_assert!(skewness(found.matrix()) < 1e-5, "{:?}", found.matrix());
            prop_assert!((wide_matrix(found.matrix()).determinant() - 1.0).abs() < 1e-5);
        }
    }
}
