//! The coarse look against the sky that was drawn.

use super::*;
use crate::test_sky::{Chance, Sky};
use proptest::prelude::*;

const PLACES: usize = 32;
/// More than any search here spends.
const ENOUGH: u32 = 100_000_000;

/// The peaks above `sigmas` times the noise that the tile tells of its cells.
fn peaks(tile: &CoarseTile, sigmas: i32, cycles: u32) -> (Search, [Peak; PLACES]) {
    let mut found = [Peak::default(); PLACES];
    let thresholds = tile.noise.map(|cells| cells.map(|noise| sigmas * noise));
    (tile.peaks(&thresholds, cycles, &mut found), found)
}

fn tile(pixels: &mut [u16], width: usize, bits: u8) -> Option<CoarseTile<'_>> {
    let mut tile = CoarseTile::none();
    tile.look_at(pixels, width, bits).then_some(tile)
}

fn beside(peak: &Peak, [x, y]: [f64; 2]) -> bool {
    let [column, row] = peak.at.map(f64::from);
    (column - x).abs() <= 1.0 && (row - y).abs() <= 1.0
}

#[test]
fn only_whole_segments_and_bands_are_a_tile() {
    let mut pixels = [0u16; (TILE_WIDTH + SEGMENT) * (TILE_HEIGHT + BAND)];
    for width in 0..=TILE_WIDTH + SEGMENT {
        for height in 0..=TILE_HEIGHT + BAND {
            let is_tile = width > 0 && width % SEGMENT == 0 && width <= TILE_WIDTH;
            let is_tile = is_tile && height > 0 && height % BAND == 0 && height <= TILE_HEIGHT;
            let made = tile(&mut pixels[..width * height], width, 12).is_some();
            assert_eq!(made, is_tile, "{width} x {height}");
        }
    }
}

#[test]
fn the_noise_is_that_of_the_sky() {
    for (bits, sigma) in [(10u8, 1.5), (12, 5.0), (16, 100.0)] {
        let (mut pixel, mut sum, tiles) = (0.0, 0.0, 60);
        for seed in 0..tiles {
            let mut pixels =
                Sky::new(TILE_WIDTH, TILE_HEIGHT, 20.0 * sigma).noise(sigma, seed).expose(bits).pixels;
            let tile = tile(&mut pixels, TILE_WIDTH, bits).unwrap();
            let truth =
                (sigma * sigma + 1.0 / 12.0).sqrt() * f64::from(1u32 << KEPT_BITS) / f64::from(1u32 << bits);
            pixel += f64::from(tile.sigma) / truth / tiles as f64;
            let cells = tile.noise.as_flattened();
            sum += cells.iter().map(|noise| f64::from(*noise)).sum::<f64>()
                / cells.len() as f64
                / (3.0 * truth)
                / tiles as f64;
        }
        std::println!("{bits} bits, sigma {sigma}: pixels {pixel:.3}, 3 x 3 sums {sum:.3} of the truth");
        assert!((0.94..1.06).contains(&pixel) && (0.94..1.1).contains(&sum));
    }
}

#[test]
fn every_bright_star_is_found_and_little_else() {
    let (sigma, stars, tiles) = (8.0, 6, 100);
    let (mut found, mut others) = (0, 0);
    for seed in 0..tiles {
        let mut chance = Chance(7_000 + seed);
        let mut sky = Sky::new(TILE_WIDTH, TILE_HEIGHT, 200.0).noise(sigma, seed);
        let places: std::vec::Vec<_> = (0..stars)
            .map(|_| [TILE_WIDTH, TILE_HEIGHT].map(|length| 4.0 + chance.even() * (length as f64 - 9.0)))
            .collect();
        for place in &places {
            // Ten sigmas of a 3 x 3 sum and more, which holds 0.75 of the light at least.
            sky = sky.star(*place, 0.5 + 0.5 * chance.even(), 3.0 * sigma * (14.0 + 60.0 * chance.even()));
        }
        let mut pixels = sky.expose(12).pixels;
        let (search, peaks) = peaks(&tile(&mut pixels, TILE_WIDTH, 12).unwrap(), 6, ENOUGH);
        let peaks = &peaks[..search.count];
        assert!(search.all);
        // Of two within five pixels the fainter one is no maximum.
        let alone = |place: &&[f64; 2]| {
            places.iter().filter(|[x, y]| (x - place[0]).abs().max((y - place[1]).abs()) < 6.0).count() == 1
        };
        for place in places.iter().filter(alone) {
            assert!(peaks.iter().any(|peak| beside(peak, *place)), "tile {seed}: {place:?}");
            found += 1;
        }
        others += peaks.iter().filter(|peak| !places.iter().any(|place| beside(peak, *place))).count();
    }
    std::println!("{found} stars found, {others} other peaks");
    assert!(found > 400 && others <= 2);
}

#[test]
fn of_more_than_there_is_room_for_the_brightest_are_kept_and_that_is_told() {
    let mut sky = Sky::new(TILE_WIDTH, TILE_HEIGHT, 200.0).noise(4.0, 3);
    let place = |index: usize| [8.0 + (index % 8) as f64 * 12.0, 8.0 + (index / 8) as f64 * 12.0];
    for index in 0..PLACES + 8 {
        sky = sky.star(place(index), 0.8, 600.0 + 20.0 * index as f64);
    }
    let mut pixels = sky.expose(12).pixels;
    let (search, peaks) = peaks(&tile(&mut pixels, TILE_WIDTH, 12).unwrap(), 6, ENOUGH);
    assert!(!search.all && search.count == PLACES);
    assert!((16..PLACES + 8).all(|index| peaks.iter().any(|peak| beside(peak, place(index)))));
}

proptest! {
    #[test]
    fn a_search_spends_what_it_is_given_at_most_and_says_when_that_is_too_little(
        cycles in 0u32..60_000,
        level in 0.0..4_000.0,
        seed: u64,
    ) {
        let mut sky = Sky::new(64, 2 * BAND, level).noise(5.0, seed);
        for index in 0..6 {
            sky = sky.star([9.0 + 9.0 * f64::from(index), 14.0], 0.7, 2_000.0);
        }
        let mut pixels = sky.expose(12).pixels;
        let tile = tile(&mut pixels, 64, 12).unwrap();
        let ((search, few), (whole, all)) = (peaks(&tile, 6, cycles), peaks(&tile, 6, ENOUGH));
        prop_assert!(search.cycles <= cycles && whole.all);
        prop_assert!(!search.all || search.count == whole.count);
        // Nothing is told that a search without a limit does not tell.
        let of_all = &all[..whole.count];
        prop_assert!(few[..search.count].iter().all(|peak| of_all.iter().any(|other| other.at == peak.at)));
    }

    #[test]
    fn no_pixels_make_it_panic(
        pixels in proptest::collection::vec(any::<u16>(), 48 * BAND),
        bits in 8u8..=16,
    ) {
        let mut pixels: std::vec::Vec<_> = pixels.iter().map(|raw| raw >> (16 - bits)).collect();
        if let Some(tile) = tile(&mut pixels, 48, bits) {
            let (search, found) = peaks(&tile, 1, ENOUGH);
            let edge = EDGE as u16;
            for Peak { at: [x, y], .. } in &found[..search.count] {
                prop_assert!((edge..48 - edge).contains(x) && (edge..BAND as u16 - edge).contains(y));
            }
        }
    }
}
