use super::*;
use crate::mock::flash::{Flash, SECTOR};
use fsw_hal::Error as _;
use proptest::prelude::*;
use std::vec::Vec;

const OFFSET: u32 = 256;
const SLOT: usize = 2 * SECTOR;
const NOW_US: i64 = 800_000_000_000_000;
const HOUR_US: i64 = 3_600_000_000;

fn flash() -> Flash {
    Flash::new(2 * SLOT + 2 * SECTOR)
}

fn store(flash: Flash) -> FlashStore<Flash> {
    FlashStore::new(flash, OFFSET, SLOT).unwrap()
}

fn read(store: &mut FlashStore<Flash>) -> Option<Vec<u8>> {
    let mut buffer = [0; SLOT];
    store.kept(&mut buffer, NOW_US, HOUR_US).unwrap().map(<[u8]>::to_vec)
}

/// Records that differ in length and in every byte.
fn record(number: u8) -> Vec<u8> {
    (0..100 + 3 * number).map(|byte| byte ^ number.wrapping_mul(59)).collect()
}

#[test]
fn the_newest_record_is_given_and_nothing_where_none_was_kept() {
    let mut store = store(flash());
    assert_eq!(read(&mut store), None);
    for number in 0..10 {
        store.keep(&record(number), NOW_US).unwrap();
        assert_eq!(read(&mut store), Some(record(number)));
    }
    for length in [0, 1, 43, 44, 45, store.room() - 1, store.room()] {
        let record = std::vec![7; length];
        store.keep(&record, NOW_US).unwrap();
        assert_eq!(read(&mut store), Some(record));
    }
}

#[test]
fn a_loss_of_power_at_any_byte_leaves_the_record_before() {
    let mut before = store(flash());
    (0..3).for_each(|number| before.keep(&record(number), NOW_US).unwrap());
    let whole = SLOT + (record(3).len() + OVERHEAD_BYTES).next_multiple_of(CHUNK);
    let (mut old, mut new) = (0, 0);
    for spoilt in [0x00, 0xFF, 0xA5] {
        for power in 0..=whole {
            let flash = Flash { power, spoilt, ..before.flash.clone() };
            let mut interrupted = store(flash);
            let kept = interrupted.keep(&record(3), NOW_US);
            assert_eq!(kept.is_ok(), power == whole && read(&mut interrupted) == Some(record(3)));
            let mut after = store(interrupted.release().again());
            match read(&mut after) {
                Some(found) if found == record(2) => old += 1,
                Some(found) if found == record(3) => {
                    // Only the padding was still to come.
                    assert!(power >= SLOT + record(3).len() + OVERHEAD_BYTES, "{power}");
                    new += 1;
                }
                found => panic!("after {power} bytes: {found:?}"),
            }
            // The store goes on.
            after.keep(&record(4), NOW_US).unwrap();
            assert_eq!(read(&mut after), Some(record(4)));
        }
    }
    assert_eq!(old + new, 3 * (whole + 1));
    assert!(old >= 3 * (SLOT + record(3).len() + OVERHEAD_BYTES - 1));
}

#[test]
fn a_turned_bit_costs_the_newest_record_alone() {
    let mut kept = store(flash());
    (0..2).for_each(|number| kept.keep(&record(number), NOW_US).unwrap());
    let first = OFFSET as usize + SLOT;
    for bit in 0..8 * (record(1).len() + OVERHEAD_BYTES) {
        let mut flash = kept.flash.clone();
        flash.bytes[first + bit / 8] ^= 1 << (bit % 8);
        assert_eq!(read(&mut store(flash)), Some(record(0)), "bit {bit}");
    }
}

#[test]
fn a_record_that_is_too_old_or_of_the_future_is_refused() {
    let mut store = store(flash());
    let mut buffer = [0; SLOT];
    store.keep(&record(0), NOW_US).unwrap();
    let mut at = |now_us| store.kept(&mut buffer, now_us, HOUR_US).map(|record| record.is_some());
    assert_eq!(at(NOW_US), Ok(true));
    assert_eq!(at(NOW_US + HOUR_US), Ok(true));
    for now_us in [NOW_US + HOUR_US + 1, NOW_US - 1, i64::MAX, i64::MIN] {
        let error = at(now_us).unwrap_err();
        assert_eq!((error, error.kind()), (FlashStoreError::Stale, StoreError::Stale));
    }
}

#[test]
fn lengths_that_do_not_fit_are_refused_and_change_nothing() {
    let mut store = store(flash());
    store.keep(&record(0), NOW_US).unwrap();
    let before = store.flash.bytes.clone();
    let error = store.keep(&std::vec![0; store.room() + 1], NOW_US).unwrap_err();
    assert_eq!((error, error.kind()), (FlashStoreError::Length, StoreError::Length));
    assert_eq!(store.flash.bytes, before);
    let mut short = std::vec![0; record(0).len() - 1];
    assert_eq!(store.kept(&mut short, NOW_US, HOUR_US), Err(FlashStoreError::Length));
}

#[test]
fn the_sequence_number_goes_round() {
    let mut store = store(flash());
    for (slot, sequence) in [(0, u32::MAX - 1), (1, u32::MAX)] {
        let header = Header { sequence, length: 1, instant_us: NOW_US };
        let (from, to) = (store.address(slot, 0), store.address(slot, SLOT));
        store.flash.erase(from, to).unwrap();
        store.write(slot, &header, &[slot as u8]).unwrap();
    }
    assert_eq!(read(&mut store), Some([1].to_vec()));
    for number in 2..6 {
        store.keep(&[number], NOW_US).unwrap();
        assert_eq!(read(&mut store), Some([number].to_vec()));
    }
}

#[test]
fn places_that_the_flash_has_not_are_refused() {
    let fits = |offset, slot| FlashStore::new(flash(), offset, slot).is_some();
    assert!(fits(OFFSET, SLOT) && fits(0, SECTOR));
    assert!(!fits(1, SLOT) && !fits(OFFSET, SLOT + 8) && !fits(OFFSET, 0));
    assert!(!fits(3 * SECTOR as u32, SLOT) && !fits(u32::MAX - 255, SLOT) && !fits(0, usize::MAX));
}

proptest! {
    #[test]
    fn whatever_stands_in_the_flash_nothing_is_taken_for_a_record(
        mut bytes in prop::collection::vec(any::<u8>(), 2 * SLOT + 2 * SECTOR),
        length in any::<u32>().prop_map(|length| length >> (length % 32)),
    ) {
        let mut flash = flash();
        for slot in [OFFSET as usize, OFFSET as usize + SLOT] {
            bytes[slot..slot + 4].copy_from_slice(&MAGIC);
            bytes[slot + 8..slot + 12].copy_from_slice(&length.to_le_bytes());
        }
        flash.bytes = bytes;
        prop_assert_eq!(read(&mut store(flash)), None);
    }

    #[test]
    fn whatever_is_interrupted_the_last_whole_record_is_found(
        losses in prop::collection::vec((0..900usize, any::<u8>()), 1..20),
    ) {
        let mut store = store(flash());
        let (mut last, mut number) = (None, 0);
        for (power, spoilt) in losses {
            number += 1;
            store.flash.power = power;
            store.flash.spoilt = spoilt;
            let kept = store.keep(&record(number), NOW_US);
            store.flash.power = usize::MAX;
            let found = read(&mut store);
            let is_new = found == Some(record(number));
            prop_assert!(is_new || (found == last && kept.is_err()));
            last = found;
        }
    }
}
