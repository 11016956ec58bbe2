//! What is the SVD's own; what every method must do is tested in `comparison/tests.rs`.

use super::*;
use crate::attitude::VectorPair;
use crate::attitude::comparison::tests::{field, optimum, pair, sky};
use crate::oracle::{ARCSEC, Generator, skewness, small_turn, wide, wide_matrix};
use std::vec::Vec;

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
                ..pair(&wide(seen.measured.vector()), &(by * wide(seen.reference.vector())), seen.sigma_rad)
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
