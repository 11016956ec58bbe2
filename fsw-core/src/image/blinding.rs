//! Is the detector blinded? (thesis §8, sensor states 1, 3 and 4: the Sun in either path)
//!
//! In: the raw pixels of a window, any resolution. Out: whether most of them stand at full scale. Only
//! `SAMPLES` of them are looked at, spread over the window, so a probe window and a whole tile cost about the
//! same.
//!
//! Error: where a share `p` of a large window is at full scale the sampled share is within 0.13 of `p` (3
//! sigma of `SAMPLES` draws), so the answer may be either only for `p` from 0.37 to 0.63. Cost: 2,000 cycles
//! (Cortex-M4 model, zero wait states).

pub use fsw_pixels::window::saturation;

/// Pixels looked at; those of smaller windows more than once.
const SAMPLES: u32 = 128;
/// The golden section of 2^16: its multiples modulo 2^16 are spread evenly however many there are.
const GOLDEN_SECTION: u32 = 40_503;
/// Whether more than half of the window stands at full scale: the Sun, or an exposure far too long. No pixels
/// are not blinded.
#[inline(never)]
pub fn blinded(pixels: &[u16], bits: u8) -> bool {
    let saturation = saturation(bits);
    let length = pixels.len().min(1 << 16) as u32;
    let (mut full, mut not) = (0, 0);
    for sample in 0..SAMPLES {
        // Multiples of the golden section, not of a step that might share a factor with the window's width.
        let place = sample.wrapping_mul(GOLDEN_SECTION) % (1 << 16);
        let raw = pixels.get(((place * length) >> 16) as usize);
        if raw.is_some_and(|raw| *raw >= saturation) {
            full += 1
        } else {
            not += 1
        }
        // Nothing can change it any more.
        if 2 * not >= SAMPLES {
            return false;
        }
    }
    2 * full > SAMPLES
}

/// A window whose mean is above full scale over this shows the Earth, the Moon or stray light, and hardly a
/// star.
const WASHED_DIVISOR: u32 = 4;
/// Of its pixels one in so many tells.
const WASHED_STEP: usize = 7;

/// Whether the mean of raw pixels exceeds a quarter of full scale: nothing as faint as a star is seen there.
/// Of one pixel in seven.
pub fn is_washed(pixels: &[u16], bits: u8) -> bool {
    let full_scale = (1u32 << bits.clamp(1, 16)) - 1;
    let some = pixels.iter().step_by(WASHED_STEP);
    let limit = full_scale / WASHED_DIVISOR * some.len() as u32;
    some.fold(0u32, |sum, pixel| sum + u32::from(*pixel)) > limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::test_sky::{Chance, Sky};
    use std::{vec, vec::Vec};

    #[test]
    fn saturation_is_95_percent_of_full_scale_at_every_resolution() {
        for bits in 2u8..=16 {
            let full_scale = 2f64.powi(i32::from(bits)) - 1.0;
            let share = f64::from(saturation(bits)) / full_scale;
            assert!(
                (0.95..0.95 + 1.0 / full_scale).contains(&share) || saturation(bits) as f64 == full_scale
            );
        }
        assert_eq!((saturation(0), saturation(1), saturation(255)), (1, 1, saturation(16)));
    }

    #[test]
    fn a_window_of_which_most_is_at_full_scale_is_blinded_whatever_its_size() {
        let mut chance = Chance(3);
        for (width, height) in [(16, 16), (21, 21), (64, 64), (119, 62), (120, 62), (128, 64), (3, 1)] {
            for bits in [8u8, 10, 12, 16] {
                let full = ((1u32 << bits) - 1) as u16;
                let drawn = |chance: &mut Chance, share: f64| -> Vec<u16> {
                    (0..width * height).map(|_| if chance.even() < share { full } else { full / 2 }).collect()
                };
                assert!(blinded(&vec![full; width * height], bits));
                assert!(!blinded(&vec![full / 20 * 18; width * height], bits));
                if width * height > 200 {
                    assert!(blinded(&drawn(&mut chance, 0.7), bits), "{width} x {height}");
                    assert!(!blinded(&drawn(&mut chance, 0.3), bits), "{width} x {height}");
                }
            }
        }
        assert!(!blinded(&[], 10));
    }

    #[test]
    fn a_side_of_the_window_counts_for_its_area_whichever_side_it_is() {
        for width in 100usize..=128 {
            let height = 62;
            let side = |bright: &dyn Fn(usize, usize) -> bool| -> Vec<u16> {
                let at = |index: usize| bright(index % width, index / width);
                (0..width * height).map(|index| if at(index) { 1023 } else { 40 }).collect()
            };
            for (eighths, expected) in [(3, false), (5, true)] {
                assert_eq!(blinded(&side(&|x, _| x * 8 < width * eighths), 10), expected, "left, {width}");
                assert_eq!(blinded(&side(&|x, _| (width - 1 - x) * 8 < width * eighths), 10), expected);
                assert_eq!(blinded(&side(&|_, y| y * 8 < height * eighths), 10), expected);
                assert_eq!(blinded(&side(&|_, y| (height - 1 - y) * 8 < height * eighths), 10), expected);
            }
        }
    }

    #[test]
    fn a_saturated_star_does_not_blind_its_window() {
        let mut frame = Sky::new(27, 27, 60.0).star([13.0, 13.0], 1.6, 400_000.0).expose(10);
        assert!(frame.pixels.contains(&1023));
        assert!(!blinded(&frame.pixels, 10));
        frame.pixels.fill(1000);
        assert!(blinded(&frame.pixels, 10));
    }

    #[test]
    fn five_washed_windows_of_five_are_told_by_the_reading_of_their_stars_at_8_to_16_bits() {
        use crate::image::DetectionParameters;
        use crate::image::scan::{Detections, TILE_PIXELS, read_stars};
        use fsw_hal::Window;
        let parameters = DetectionParameters::default();
        for bits in 8u8..=16 {
            let full_scale = f64::from((1u32 << bits) - 1);
            let washed = |level: f64, seed| {
                let sky = Sky::new(27, 27, level * full_scale).noise(0.02 * full_scale, seed);
                let window = Window { x: 0, y: 0, width: 27, height: 27 };
                let mut buffer = [0; TILE_PIXELS];
                read_stars(&mut sky.expose(bits), window, &mut buffer, &parameters, &mut Detections::new())
                    .unwrap()
            };
            assert!((1..=5).all(|seed| washed(0.3, seed)), "{bits} bits");
            assert!((1..=5).all(|seed| !washed(0.2, seed)), "{bits} bits");
        }
    }
}
