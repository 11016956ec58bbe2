use super::*;
use crate::catalog::sample::{self, SampleStar};
use crate::oracle::{Generator, wide};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::vec::Vec as List;

type Wide = Vector3<f64>;
/// Catalogue stars (p, q, r).
type Found = BTreeSet<(u16, u16, u16)>;

/// A small dense catalogue: so wide a tolerance finds tens of triangles beside the true one.
const TOLERANCE: f64 = 4e-3;

struct Scene {
    bytes: List<u8>,
    units: List<Wide>,
    /// The measured stars i, j, k, which are catalogue stars seen from an attitude with errors.
    seen: [Vector3<f32>; 3],
    names: [u16; 3],
}

impl Scene {
    fn new(seed: u64) -> Self {
        let mut generator = Generator::new(seed);
        let middle = generator.rotation();
        let stars: List<SampleStar> =
            (1..=70).map(|hip| sample::star(&(middle * generator.unit_in_cap(0.12)), hip)).collect();
        let unit =
            |star: &SampleStar| Wide::from(star.unit_q30.map(|x| f64::from(x) / f64::from(1u32 << 30)));
        let units: List<Wide> = stars.iter().map(unit).collect();
        let look = generator.rotation();
        let first = generator.bits() as u16 % 70;
        let names = [first, (first + 1 + generator.bits() as u16 % 34) % 70, (first + 40) % 70];
        let seen = names.map(|name| {
            let noise = generator.gaussian_vector() * (0.2 * TOLERANCE);
            (look * units[usize::from(name)] + noise).normalize().map(|x| x as f32)
        });
        Self { bytes: sample::bytes(&stars, 17, 1 << 30), units, seen, names }
    }

    fn catalogue(&self) -> Catalogue<'_> {
        Catalogue::open(&self.bytes).unwrap()
    }

    fn side(&self, one: usize, other: usize) -> Side {
        Side::new((self.seen[one] - self.seen[other]).norm(), TOLERANCE as f32)
    }

    fn corner(&self, k: u8, sense: f32) -> Corner {
        // Either way of looking up must find the same.
        Corner {
            k,
            to_i: self.side(0, 2),
            to_j: self.side(1, 2),
            by_j: self.names[0].is_multiple_of(2),
            sense,
        }
    }

    fn sense(&self) -> f32 {
        let [a, b, c] = &self.seen;
        triple_product(a, b, c)
    }

    /// All ordered triples of catalogue stars that fit, and those too near a limit to tell, by trying each.
    fn brute_force(&self, sense: f64) -> (Found, Found) {
        let chord = |one: &Wide, other: &Wide| (one - other).norm();
        let seen = self.seen.each_ref().map(wide);
        let measured = [(0, 1), (0, 2), (1, 2)].map(|(one, other)| chord(&seen[one], &seen[other]));
        let (mut clear, mut doubtful) = (Found::new(), Found::new());
        let stars = || (0u16..).zip(&self.units);
        for (p, a) in stars() {
            for (q, b) in stars().filter(|(q, _)| *q != p) {
                let base = (chord(a, b) - measured[0]) / TOLERANCE;
                if base.abs() > 1.01 {
                    continue;
                }
                for (r, c) in stars().filter(|(r, _)| *r != p && *r != q) {
                    let errors = [
                        base,
                        (chord(a, c) - measured[1]) / TOLERANCE,
                        (chord(b, c) - measured[2]) / TOLERANCE,
                    ];
                    let worst = errors.iter().fold(0.0, |worst: f64, error| worst.max(error.abs()));
                    let volume = a.cross(b).dot(c);
                    let near_a_limit = (worst - 1.0).abs() < 1e-3 || (sense != 0.0 && volume.abs() < 1e-8);
                    if worst < 1.001 && near_a_limit {
                        doubtful.insert((p, q, r));
                    } else if worst < 1.0 && volume * sense >= 0.0 {
                        clear.insert((p, q, r));
                    }
                }
            }
        }
        (clear, doubtful)
    }
}

/// The hits as catalogue triples; each may be there once only.
fn hits<const CHAINS: usize, const SIDES: usize, const HITS: usize>(
    triangles: &Triangles<CHAINS, SIDES, HITS>,
) -> BTreeSet<(u16, u16, u16)> {
    let mut found = BTreeSet::new();
    for hit in &triangles.hits {
        let (p, q) = triangles.stars_of(hit.side).unwrap();
        assert!(found.insert((p, q, hit.r)), "a triangle was hit twice");
    }
    found
}

#[test]
fn exactly_the_triangles_that_fit_with_the_right_sense_are_hit() {
    let mut triangles = Triangles::<32, 4830, 65_000>::new();
    let (mut total, mut reversed_bases) = (0, 0);
    for seed in 0..60 {
        let scene = Scene::new(seed);
        let catalogue = scene.catalogue();
        triangles.begin(&catalogue, &scene.side(0, 1));
        triangles.add(&catalogue, &scene.corner(2, scene.sense()));
        let (clear, doubtful) = scene.brute_force(f64::from(scene.sense()));
        let hit = hits(&triangles);
        for triple in &clear {
            assert!(hit.contains(triple), "{triple:?} of {seed} is missing");
            reversed_bases += usize::from(triple.0 > triple.1);
        }
        for triple in &hit {
            assert!(clear.contains(triple) || doubtful.contains(triple), "{triple:?} of {seed} is no fit");
        }
        total += clear.len();
    }
    std::println!("{total} triangles, {reversed_bases} with the base side the other way round");
    assert!(total > 1000 && reversed_bases * 3 > total && reversed_bases * 3 < 2 * total);
}

#[test]
fn the_true_triangle_is_hit_and_its_mirror_image_is_not() {
    let mut triangles = Triangles::<32, 4830, 65_000>::new();
    let mut tried = 0;
    for seed in 100..300 {
        let scene = Scene::new(seed);
        let [p, q, r] = scene.names;
        // Flat triangles and errors beyond the tolerance are another test's.
        if scene.sense().abs() < 2.0 * scene.side(0, 1).chord * TOLERANCE as f32
            || !scene.brute_force(0.0).0.contains(&(p, q, r))
        {
            continue;
        }
        tried += 1;
        let catalogue = scene.catalogue();
        for (sense, expected) in [(scene.sense(), true), (-scene.sense(), false), (0.0, true)] {
            triangles.begin(&catalogue, &scene.side(0, 1));
            triangles.add(&catalogue, &scene.corner(2, sense));
            assert_eq!(hits(&triangles).contains(&(p, q, r)), expected, "sense {sense} of {seed}");
        }
    }
    assert!(tried > 100, "{tried}");
}

#[test]
fn a_triangle_too_flat_for_its_sense_is_hit_either_way_round() {
    let mut triangles = Triangles::<32, 4830, 65_000>::new();
    for seed in 300..320 {
        let scene = Scene::new(seed);
        let catalogue = scene.catalogue();
        triangles.begin(&catalogue, &scene.side(0, 1));
        triangles.add(&catalogue, &scene.corner(2, 0.0));
        let (clear, doubtful) = scene.brute_force(0.0);
        let hit = hits(&triangles);
        assert!(clear.iter().all(|triple| hit.contains(triple)));
        assert!(hit.iter().all(|triple| clear.contains(triple) || doubtful.contains(triple)));
    }
}

#[test]
fn a_base_side_counts_each_measured_star_once_and_the_fullest_is_best() {
    let mut triangles = Triangles::<32, 4830, 65_000>::new();
    for seed in 400..420 {
        let scene = Scene::new(seed);
        let catalogue = scene.catalogue();
        triangles.begin(&catalogue, &scene.side(0, 1));
        let mut most = 0;
        // The same sides under another number stand for further measured stars.
        for (k, sense) in [(2, scene.sense()), (3, 0.0), (9, -scene.sense())] {
            most = most.max(triangles.add(&catalogue, &scene.corner(k, sense)));
        }
        let corners: List<u8> = (0u16..)
            .zip(&triangles.sides)
            .map(|(side, base)| {
                let stars =
                    [2, 3, 9].map(|k| triangles.hits.iter().any(|hit| hit.side == side && hit.k == k));
                assert_eq!(base.corners, stars.iter().filter(|seen| **seen).count() as u8);
                base.corners
            })
            .collect();
        let fullest = corners.iter().copied().max().unwrap_or(0);
        assert_eq!(most, fullest);
        let first = corners.iter().position(|corners| *corners == fullest).map(|side| side as u16);
        assert_eq!(triangles.best(1), first.filter(|_| fullest >= 1));
        assert_eq!(triangles.best(fullest + 1), None);
    }
}

#[test]
fn a_base_side_taken_out_of_the_ranking_does_not_come_back() {
    let mut triangles = Triangles::<32, 4830, 65_000>::new();
    let scene = Scene::new(500);
    let catalogue = scene.catalogue();
    triangles.begin(&catalogue, &scene.side(0, 1));
    triangles.add(&catalogue, &scene.corner(2, 0.0));
    let mut rejected = List::new();
    while let Some(side) = triangles.best(1) {
        triangles.reject(side);
        rejected.push(side);
    }
    assert!(rejected.len() > 3);
    assert_eq!(triangles.add(&catalogue, &scene.corner(5, 0.0)), 0);
    assert_eq!(triangles.best(1), None);
    // Out of range: nothing happens.
    triangles.reject(u16::MAX);
    // A new base side starts afresh.
    triangles.begin(&catalogue, &scene.side(0, 1));
    assert!(triangles.hits.is_empty());
    assert!(triangles.add(&catalogue, &scene.corner(2, 0.0)) > 0);
}

/// Runs two measured stars through a workspace too small for them.
fn overflow<const CHAINS: usize, const SIDES: usize, const HITS: usize>(
    scene: &Scene,
) -> Result<(), TestCaseError> {
    let catalogue = scene.catalogue();
    let mut triangles = Triangles::<CHAINS, SIDES, HITS>::new();
    let (clear, doubtful) = scene.brute_force(0.0);
    for _ in 0..2 {
        triangles.begin(&catalogue, &scene.side(0, 1));
        triangles.add(&catalogue, &scene.corner(2, 0.0));
        prop_assert!(triangles.sides.len() <= SIDES && triangles.hits.len() <= HITS);
        for triple in &hits(&triangles) {
            prop_assert!(clear.contains(triple) || doubtful.contains(triple), "{:?} is no fit", triple);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn a_workspace_too_small_loses_triangles_and_invents_none(seed in any::<u64>()) {
        let scene = Scene::new(seed);
        overflow::<64, 4830, 2>(&scene)?;
        overflow::<64, 2, 100>(&scene)?;
        overflow::<64, 8, 3>(&scene)?;
        overflow::<8, 4830, 1000>(&scene)?;
        overflow::<1, 2, 1>(&scene)?;
    }
}

#[test]
fn two_stars_are_no_triangle_where_a_side_is_shorter_than_the_tolerance() {
    let scene = Scene::new(3_633_968_332_949_620_775);
    assert!(f64::from(scene.side(0, 2).chord) < TOLERANCE);
    overflow::<64, 4830, 1000>(&scene).unwrap();
}

#[test]
fn the_triple_product_of_a_small_triangle_keeps_its_digits() {
    let mut generator = Generator::new(60);
    for _ in 0..10_000 {
        let middle = generator.unit();
        let [a, b, c] =
            [(); 3].map(|()| (middle + generator.gaussian_vector() * 3e-3).normalize().map(|x| x as f32));
        let (wide_a, wide_b, wide_c) = (wide(&a), wide(&b), wide(&c));
        let (u, v) = (wide_b - wide_a, wide_c - wide_a);
        let error = f64::from(triple_product(&a, &b, &c)) - wide_a.dot(&wide_b.cross(&wide_c));
        assert!(error.abs() < 1e-6 * u.norm() * v.norm(), "{error:e}");
    }
}

#[test]
fn what_fits_exactly_is_never_refused_by_the_coarse_look() {
    let mut generator = Generator::new(77);
    for seed in 0..8 {
        let scene = Scene::new(seed);
        let mut catalogue = scene.catalogue();
        catalogue.set_observer_velocity(generator.unit().map(|axis| 9.9e-4 * axis as f32));
        let mut fitting = 0;
        for (a, b) in (0..70).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let chord = (catalogue.unit(a).unwrap() - catalogue.unit(b).unwrap()).norm();
            // From no tolerance to a wide one, the chord at its very edge now and then.
            let tolerance = 10f64.powf(generator.between(-7.0, -2.0)) as f32;
            let side = Side::new(chord + tolerance * generator.between(-1.05, 1.05) as f32, tolerance);
            if side.fit_between(&catalogue, a, b).is_some() {
                fitting += 1;
                assert!(side.may_fit(&catalogue, a, b), "{chord} for {side:?}");
            }
        }
        assert!(fitting > 2000);
    }
}
