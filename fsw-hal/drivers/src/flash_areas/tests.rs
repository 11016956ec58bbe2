use super::*;
use crate::mock::flash::{Flash, SECTOR, WORD};
use fsw_hal::Error as _;
use proptest::prelude::*;
use std::vec::Vec;

const SLOTS: AreaSlots = AreaSlots {
    catalogue: Slots { offset: SECTOR, slot_bytes: 8 * SECTOR },
    calibration: Slots { offset: 17 * SECTOR, slot_bytes: 2 * SECTOR },
    bad_pixels: Slots { offset: 21 * SECTOR, slot_bytes: SECTOR },
};
const SIZE: usize = 24 * SECTOR;
const ROOM: usize = 8 * SECTOR - HEADER_BYTES;
const AREAS: [Area; 3] = [Area::Catalogue, Area::Calibration, Area::BadPixels];
/// Bytes of a part.
const PART: usize = 200;

fn store(flash: Flash) -> FlashAreas<Flash> {
    FlashAreas::new(flash, SLOTS).unwrap()
}

fn serving(store: &FlashAreas<Flash>, area: Area) -> Option<Vec<u8>> {
    Some(store.flash.bytes[store.serving(area)?].to_vec())
}

/// Files that differ in length and in every byte.
fn file(number: u8) -> Vec<u8> {
    (0..150 + u16::from(number)).map(|byte| byte as u8 ^ number.wrapping_mul(59)).collect()
}

fn long_file(number: u8) -> Vec<u8> {
    (0..ROOM as u32).map(|byte| (byte * byte / 97) as u8 ^ number).collect()
}

/// Writes a file in parts and marks it, as the link does after its check.
fn upload(store: &mut FlashAreas<Flash>, area: Area, file: &[u8]) -> Result<(), FlashAreasErrorKind> {
    for (number, part) in file.chunks(PART).enumerate() {
        store.write(area, number * PART, part)?;
    }
    store.mark_whole(area, file.len(), crc32(file))
}

type FlashAreasErrorKind = FlashAreasError<embedded_storage::nor_flash::NorFlashErrorKind>;

#[test]
fn a_file_serves_from_the_next_start_on_and_the_one_that_serves_is_never_written() {
    let mut store = store(Flash::new(SIZE));
    assert_eq!(AREAS.map(|area| store.serving(area)), [None, None, None]);
    let mut last = [None, None, None];
    for number in 0..6 {
        for area in AREAS {
            upload(&mut store, area, &file(number)).unwrap();
            assert_eq!(store.written(area, file(number).len()).unwrap(), file(number));
        }
        // Another one before the restart takes the place of the first, not of the one that serves.
        upload(&mut store, Area::Calibration, &file(number + 50)).unwrap();
        assert_eq!(AREAS.map(|area| serving(&store, area)), last);
        store = FlashAreas::new(store.release(), SLOTS).unwrap();
        last = [file(number), file(number + 50), file(number)].map(Some);
        assert_eq!(AREAS.map(|area| serving(&store, area)), last);
    }
    let outside = |at: &usize| !(SECTOR..SIZE - SECTOR).contains(at);
    assert!((0..SIZE).filter(outside).all(|at| store.flash.bytes[at] == 0x5A));
}

#[test]
fn files_of_every_length_come_out_as_they_went_in() {
    let mut store = store(Flash::new(SIZE));
    for length in (1..2 * WORD).chain([PART - 1, PART, 192, 193, 256, 1000, ROOM - 1, ROOM]) {
        let file = &long_file(length as u8)[..length];
        upload(&mut store, Area::Catalogue, file).unwrap();
        store = FlashAreas::new(store.release(), SLOTS).unwrap();
        assert_eq!(serving(&store, Area::Catalogue).unwrap(), file);
    }
}

#[test]
fn a_loss_of_power_at_any_byte_leaves_the_file_that_serves() {
    let mut before = store(Flash::new(SIZE));
    upload(&mut before, Area::Calibration, &file(1)).unwrap();
    let before = store(before.release());
    let (old, new) = (file(1), long_file(2)[..400].to_vec());
    let bytes = 2 * SECTOR + new.len() + HEADER_BYTES;
    for spoilt in [0x00, 0xFF, 0xA5] {
        for power in 0..=bytes {
            let mut interrupted = store(Flash { power, spoilt, ..before.flash.clone() });
            let marked = upload(&mut interrupted, Area::Calibration, &new);
            assert_eq!(serving(&interrupted, Area::Calibration).as_ref(), Some(&old));
            let mut after = store(interrupted.release().again());
            let found = serving(&after, Area::Calibration).unwrap();
            // Of the last bytes only the mark counts; the one at which power goes may be right by chance.
            let mark_end = bytes - HEADER_BYTES + MARK_BYTES;
            assert!(found == new || (found == old && power <= mark_end), "{power}");
            assert!(found == old || (found == new && power >= mark_end), "{power}");
            assert!(marked.is_err() || found == new, "{power}");
            // The store goes on.
            upload(&mut after, Area::Calibration, &file(3)).unwrap();
            assert_eq!(serving(&store(after.release()), Area::Calibration), Some(file(3)));
        }
    }
}

#[test]
fn a_turned_bit_costs_the_newest_file_alone() {
    let mut written = store(Flash::new(SIZE));
    for number in 0..2 {
        upload(&mut written, Area::BadPixels, &file(number)).unwrap();
        written = store(written.release());
    }
    let newest = SLOTS.bad_pixels.offset + SECTOR;
    let counted = (0..MARK_BYTES).chain(HEADER_BYTES..HEADER_BYTES + file(1).len());
    for (byte, bit) in counted.flat_map(|byte| (0..8).map(move |bit| (byte, bit))) {
        let mut flash = written.flash.clone();
        flash.bytes[newest + byte] ^= 1 << bit;
        assert_eq!(serving(&store(flash), Area::BadPixels), Some(file(0)), "byte {byte} bit {bit}");
    }
}

#[test]
fn what_was_begun_and_not_marked_does_not_serve_nor_what_it_was_begun_over() {
    let mut store = store(Flash::new(SIZE));
    upload(&mut store, Area::Catalogue, &file(1)).unwrap();
    store.write(Area::Catalogue, 0, &[1; PART]).unwrap();
    let store = FlashAreas::new(store.release(), SLOTS).unwrap();
    assert_eq!(store.serving(Area::Catalogue), None);
}

#[test]
fn parts_that_do_not_fit_are_refused_and_change_nothing() {
    let mut store = store(Flash::new(SIZE));
    store.write(Area::Catalogue, 0, &[1; PART]).unwrap();
    let before = store.flash.bytes.clone();
    for (offset, bytes, how, kind) in [
        (1, 1, FlashAreasError::Alignment, AreaError::Alignment),
        (WORD / 2, 8, FlashAreasError::Alignment, AreaError::Alignment),
        (0, ROOM + 1, FlashAreasError::Length, AreaError::Length),
        (ROOM, 1, FlashAreasError::Length, AreaError::Length),
        (usize::MAX - WORD + 1, 8, FlashAreasError::Length, AreaError::Length),
    ] {
        let refused = store.write(Area::Catalogue, offset, &std::vec![0; bytes]).unwrap_err();
        assert_eq!((refused, refused.kind()), (how, kind));
    }
    assert_eq!(store.written(Area::Catalogue, ROOM + 1), Err(FlashAreasError::Length));
    assert_eq!(store.mark_whole(Area::Catalogue, ROOM + 1, 0), Err(FlashAreasError::Length));
    assert_eq!(store.flash.bytes, before);
    assert_eq!(AREAS.map(|area| store.room(area)), [ROOM, 2 * SECTOR - 64, SECTOR - 64]);
}

#[test]
fn the_sequence_number_goes_round() {
    let mut flash = store(Flash::new(SIZE)).release();
    for (slot, sequence) in [(0, u32::MAX - 1), (1, u32::MAX)] {
        let (from, crc) = (SECTOR + slot * 8 * SECTOR, crc32(&[slot as u8]));
        flash.bytes[from..from + HEADER_BYTES].copy_from_slice(&Mark { sequence, length: 1, crc }.bytes());
        flash.bytes[from + HEADER_BYTES] = slot as u8;
    }
    let mut store = store(flash);
    assert_eq!(serving(&store, Area::Catalogue), Some([1].to_vec()));
    for number in 2..6 {
        upload(&mut store, Area::Catalogue, &[number]).unwrap();
        store = FlashAreas::new(store.release(), SLOTS).unwrap();
        assert_eq!(serving(&store, Area::Catalogue), Some([number].to_vec()));
    }
}

#[test]
fn slots_that_the_flash_has_not_or_that_overlap_are_refused() {
    let fits =
        |catalogue: Slots| FlashAreas::new(Flash::new(SIZE), AreaSlots { catalogue, ..SLOTS }).is_some();
    let slots = |offset, slot_bytes| Slots { offset, slot_bytes };
    assert!(fits(slots(0, SECTOR)) && fits(slots(SECTOR, 8 * SECTOR)));
    assert!(!fits(slots(1, SECTOR)) && !fits(slots(0, SECTOR + WORD)) && !fits(slots(0, 0)));
    // Over the next one's begin, over the last one's end, in the midst, beyond the flash.
    assert!(!fits(slots(16 * SECTOR, SECTOR)) && !fits(slots(22 * SECTOR, SECTOR)));
    assert!(!fits(slots(0, 12 * SECTOR)) && !fits(slots(18 * SECTOR, SECTOR)));
    assert!(!fits(slots(23 * SECTOR, SECTOR)) && !fits(slots(0, usize::MAX)));
}

proptest! {
    #[test]
    fn whatever_stands_in_the_flash_serves_only_where_both_checksums_are_right(
        mut bytes in prop::collection::vec(any::<u8>(), SIZE),
        length in any::<u32>().prop_map(|length| length >> (length % 32)),
    ) {
        for slot in [SECTOR, 9 * SECTOR] {
            bytes[slot..slot + 4].copy_from_slice(&MAGIC);
            bytes[slot + 8..slot + 12].copy_from_slice(&length.to_le_bytes());
            let crc = crc32(&bytes[slot..slot + MARKED_BYTES]).to_le_bytes();
            bytes[slot + MARKED_BYTES..slot + MARK_BYTES].copy_from_slice(&crc);
        }
        let flash = Flash { bytes, ..Flash::new(SIZE) };
        prop_assert_eq!(store(flash).serving(Area::Catalogue), None);
    }

    #[test]
    fn whatever_is_interrupted_the_last_whole_file_serves(
        losses in prop::collection::vec((0..1200usize, any::<u8>()), 1..20),
    ) {
        let (mut store, mut last, mut number) = (store(Flash::new(SIZE)), None, 0);
        for (power, spoilt) in losses {
            number += 1;
            store.flash.power = power;
            store.flash.spoilt = spoilt;
            let marked = upload(&mut store, Area::Calibration, &file(number));
            store = FlashAreas::new(store.release().again(), SLOTS).unwrap();
            let found = serving(&store, Area::Calibration);
            let is_new = found == Some(file(number));
            prop_assert!(is_new || (found == last && marked.is_err()));
            last = found;
        }
    }
}
