//! What a scan may spend, whatever the tiles ask for.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn no_scan_spends_more_than_its_bound_and_no_tile_gets_less_than_its_income(
        wishes in prop::collection::vec((0u32..400, 1u32..40_000), 1..300),
    ) {
        let mut savings = Savings::new();
        let mut spent = 0u64;
        for (steps, price) in &wishes {
            let mut allowance = savings.next_tile();
            let mut in_tile = 0u64;
            for _ in 0..*steps {
                if !allowance.spend(*price) {
                    // What is left would not have paid for the step.
                    prop_assert!(in_tile + u64::from(*price) > u64::from(TILE_CYCLES));
                    break;
                }
                in_tile += u64::from(*price);
            }
            savings.put_back(allowance);
            spent += in_tile;
        }
        let tiles = wishes.len() as u64;
        prop_assert!(spent <= tiles * u64::from(TILE_CYCLES) + u64::from(RESERVE_CYCLES));
        prop_assert!(spent + tiles * u64::from(TILE_FIXED_CYCLES) <= bound_cycles(tiles as u32));
    }
}

#[test]
fn a_dense_tile_among_sparse_ones_gets_many_times_its_income() {
    let mut savings = Savings::new();
    for _ in 0..50 {
        let sparse = savings.next_tile();
        savings.put_back(sparse);
    }
    let mut dense = savings.next_tile();
    let stars = (0..1000).take_while(|_| dense.spend(CANDIDATE_CYCLES + 10 * LOOK_CYCLES)).count();
    assert!(stars > 40, "{stars}");
}

#[test]
fn a_refused_step_costs_nothing() {
    let mut allowance = Allowance::of_a_window();
    assert!(!allowance.spend(WINDOW_CYCLES + 1));
    assert!(allowance.spend(WINDOW_CYCLES) && !allowance.spend(1) && allowance.spend(0));
}
