use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::vec::Vec as List;

/// A polygon that gives measured stars the names next to their numbers plus `name`.
fn polygon(stars: &[u8], name: u16, mean_square_error: f32) -> Polygon {
    let corners = stars.iter().map(|star| (*star, u16::from(*star) + name)).collect();
    Polygon { corners, mean_square_error }
}

fn kept(candidates: &Candidates) -> List<(usize, f32)> {
    candidates.polygons().iter().map(|polygon| (polygon.corners.len(), polygon.mean_square_error)).collect()
}

#[test]
fn more_corners_rank_first_and_then_less_error() {
    let mut candidates = Candidates::new();
    candidates.keep(polygon(&[0, 1, 2], 100, 0.1));
    candidates.keep(polygon(&[0, 1, 2, 3], 200, 0.9));
    candidates.keep(polygon(&[0, 1, 2], 300, 0.05));
    candidates.keep(polygon(&[0, 1, 2, 3, 4], 400, 1.0));
    candidates.keep(polygon(&[0, 1, 2, 3], 500, 0.2));
    assert_eq!(kept(&candidates), [(5, 1.0), (4, 0.2), (4, 0.9), (3, 0.05), (3, 0.1)]);
}

#[test]
fn fewer_than_three_stars_are_no_polygon() {
    let mut candidates = Candidates::new();
    candidates.keep(polygon(&[], 0, 0.0));
    candidates.keep(polygon(&[1, 2], 0, 0.0));
    assert!(candidates.polygons().is_empty());
}

#[test]
fn a_part_of_a_known_polygon_is_not_kept_twice_and_the_whole_takes_the_place_of_its_parts() {
    let mut candidates = Candidates::new();
    candidates.keep(polygon(&[4, 1, 2], 10, 0.1));
    candidates.keep(polygon(&[1, 2, 7], 10, 0.2));
    candidates.keep(polygon(&[1, 2, 7], 11, 0.3));
    candidates.keep(polygon(&[7, 4, 2, 1], 10, 0.9));
    assert_eq!(kept(&candidates), [(4, 0.9), (3, 0.3)]);
    candidates.keep(polygon(&[1, 2, 4], 10, 0.0));
    candidates.keep(polygon(&[1, 2, 4, 7], 10, 0.0));
    assert_eq!(kept(&candidates), [(4, 0.9), (3, 0.3)]);
}

#[test]
fn of_more_than_eight_the_worst_are_given_up() {
    let mut candidates = Candidates::new();
    for step in 0..20u8 {
        // 0.0, 0.7, 1.4, 0.1, ...: neither rising nor falling.
        let error = f32::from(step * 7 % 20) * 0.1;
        candidates.keep(polygon(&[0, 1, 2], 100 * u16::from(step), error));
    }
    let errors: List<f32> = candidates.polygons().iter().map(|polygon| polygon.mean_square_error).collect();
    let expected: List<f32> = (0..8u8).map(|rank| f32::from(rank) * 0.1).collect();
    assert_eq!(errors, expected);
}

/// Few stars and few names, so that polygons often hold one another.
fn some_polygon() -> impl Strategy<Value = Polygon> {
    (prop::collection::btree_map(0u8..6, 0u16..2, 0..6), 0u8..5).prop_map(|(corners, error)| Polygon {
        corners: corners.into_iter().collect(),
        mean_square_error: f32::from(error) * 0.25,
    })
}

fn set(polygon: &Polygon) -> BTreeSet<(u8, u16)> {
    polygon.corners.iter().copied().collect()
}

proptest! {
    #[test]
    fn at_most_eight_are_kept_in_order_none_holds_another_and_the_largest_is_never_lost(
        polygons in prop::collection::vec(some_polygon(), 0..60)
    ) {
        let mut candidates = Candidates::new();
        for (given, polygon) in polygons.iter().enumerate() {
            candidates.keep(polygon.clone());
            let kept = candidates.polygons();
            prop_assert!(kept.len() <= 8);
            for (at, one) in kept.iter().enumerate() {
                for other in &kept[at + 1..] {
                    let (ours, theirs) = (one.corners.len(), other.corners.len());
                    prop_assert!(ours > theirs || one.mean_square_error <= other.mean_square_error && ours == theirs);
                    prop_assert!(!set(one).is_superset(&set(other)) && !set(other).is_superset(&set(one)));
                }
            }
            let largest = polygons[..=given].iter().map(|polygon| polygon.corners.len()).max();
            let largest = largest.filter(|corners| *corners >= 3);
            prop_assert_eq!(kept.first().map(|best| best.corners.len()), largest);
        }
    }
}
