use super::super::defects::sample::bytes;
use super::*;
use fsw_hal::DetectorError;
use proptest::prelude::*;
use std::vec::Vec;

/// A frame that counts how often it is read.
#[derive(Clone)]
struct Frame {
    geometry: DetectorGeometry,
    pixels: Vec<u16>,
    reads: usize,
}

impl Frame {
    fn new([width_px, height_px]: [u16; 2], value: impl Fn(u16, u16) -> u16) -> Self {
        let pixels = (0..height_px).flat_map(|y| (0..width_px).map(move |x| (x, y)));
        let pixels = pixels.map(|(x, y)| value(x, y)).collect();
        Self { geometry: DetectorGeometry { width_px, height_px, bits: 10 }, pixels, reads: 0 }
    }

    fn at(&self, x: u16, y: u16) -> u16 {
        self.pixels[usize::from(y) * usize::from(self.geometry.width_px) + usize::from(x)]
    }
}

impl fsw_hal::ErrorType for Frame {
    type Error = DetectorError;
}

impl Detector for Frame {
    fn geometry(&self) -> DetectorGeometry {
        self.geometry
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        Err(DetectorError::Exposure)
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.reads += 1;
        if !window.fits(&self.geometry) {
            return Err(DetectorError::OutsideDetector);
        }
        if pixels.len() != window.area() {
            return Err(DetectorError::BufferLength);
        }
        let all = (0..window.height).flat_map(|y| (0..window.width).map(move |x| (x, y)));
        for ((x, y), pixel) in all.zip(pixels) {
            *pixel = self.at(window.x + x, window.y + y);
        }
        Ok(())
    }
}

fn read(frame: &Frame, table: &[u8], window: Window) -> Vec<u16> {
    let mut frame = frame.clone();
    let mut mended = BadPixelDetector::new(&mut frame, Defects::open(table).unwrap()).unwrap();
    let mut pixels = std::vec![0; window.area()];
    mended.read(window, &mut pixels).unwrap();
    pixels
}

/// A frame of 9 x 7 px, mended whole: the value at a pixel.
fn mended_at(
    value: impl Fn(u16, u16) -> u16,
    bad: &[[u16; 2]],
    offsets: &[(u16, i16)],
    [x, y]: [u16; 2],
) -> u16 {
    let frame = Frame::new([9, 7], value);
    read(&frame, &bytes([9, 7], bad, offsets), frame.geometry.whole())[usize::from(y) * 9 + usize::from(x)]
}

/// No two neighbours are alike.
fn uneven(x: u16, y: u16) -> u16 {
    10 + 3 * x + 40 * y + x * x
}

#[test]
fn a_bad_pixel_gets_the_mean_of_left_and_right_or_the_one_there_is() {
    let mean = |a: u16, b: u16| (a + b).div_ceil(2);
    assert_eq!(mended_at(uneven, &[[4, 3]], &[], [4, 3]), mean(uneven(3, 3), uneven(5, 3)));
    assert_eq!(mended_at(uneven, &[[0, 3]], &[], [0, 3]), uneven(1, 3));
    assert_eq!(mended_at(uneven, &[[8, 6]], &[], [8, 6]), uneven(7, 6));
    // Of a pair each has one side.
    let pair = [[4, 3], [5, 3]];
    assert_eq!(mended_at(uneven, &pair, &[], [4, 3]), uneven(3, 3));
    assert_eq!(mended_at(uneven, &pair, &[], [5, 3]), uneven(6, 3));
    // Of three the middle one has those above and below.
    let three = [[4, 3], [5, 3], [6, 3]];
    assert_eq!(mended_at(uneven, &three, &[], [5, 3]), mean(uneven(5, 2), uneven(5, 4)));
    // A bad row at the edge has what is below, a bad cross the next ones in the row.
    let row: Vec<_> = (0..9).map(|x| [x, 0]).collect();
    assert_eq!(mended_at(uneven, &row, &[], [4, 0]), uneven(4, 1));
    let cross = [[4, 3], [3, 3], [5, 3], [4, 2], [4, 4]];
    assert_eq!(mended_at(uneven, &cross, &[], [4, 3]), mean(uneven(2, 3), uneven(6, 3)));
}

#[test]
fn a_pixel_far_from_all_good_ones_is_left_and_the_largest_block_is_mended() {
    let block = |side: u16| (0..side * side).map(move |k| [20 + k % side, 20 + k / side]).collect::<Vec<_>>();
    let frame = Frame::new([60, 60], |x, y| if x.min(y) < 20 || x.max(y) > 36 { 7 } else { 900 });
    let whole = frame.geometry.whole();
    let table = bytes([60, 60], &block(17), &[]);
    let values = read(&frame, &table, whole);
    let left: Vec<_> = values.iter().enumerate().filter(|(_, value)| **value != 7).collect();
    assert_eq!(left, [(28 * 60 + 28, &900)], "the middle of 17 x 17");
    let defects = Defects::open(&table).unwrap();
    assert!(!is_replaceable(&defects, 28, 28) && is_replaceable(&defects, 28, 27));
}

#[test]
fn offsets_are_taken_off_and_stop_at_the_range() {
    let even = |value: u16| move |_: u16, _: u16| value;
    assert_eq!(mended_at(even(100), &[], &[(2, 30), (3, -30)], [2, 6]), 70);
    assert_eq!(mended_at(even(100), &[], &[(2, 30), (3, -30)], [3, 0]), 130);
    assert_eq!(mended_at(even(100), &[], &[(2, 30), (3, -30)], [4, 0]), 100);
    assert_eq!(mended_at(even(20), &[], &[(2, 30)], [2, 2]), 0);
    assert_eq!(mended_at(even(1000), &[], &[(2, -30)], [2, 2]), 1023);
    // What is saturated stays so.
    assert_eq!(mended_at(even(1023), &[], &[(2, 30)], [2, 2]), 1023);
    // A bad pixel's neighbours come without theirs.
    assert_eq!(mended_at(even(100), &[[4, 3]], &[(3, 40), (4, 99), (5, -20)], [4, 3]), 90);
}

#[test]
fn only_the_windows_border_columns_read_more_and_one_pixel_each() {
    let bad = [[10, 5], [19, 6], [14, 7], [14, 8]];
    let table = bytes([40, 30], &bad, &[]);
    let mut frame = Frame::new([40, 30], uneven);
    let mut pixels = [0; 100];
    let window = Window { x: 10, y: 0, width: 10, height: 10 };
    let mut mended = BadPixelDetector::new(&mut frame, Defects::open(&table).unwrap()).unwrap();
    mended.read(window, &mut pixels).unwrap();
    assert_eq!(frame.reads, 3);
}

#[test]
fn errors_and_the_exposure_are_the_detectors() {
    let table = bytes([9, 7], &[[0, 0]], &[(0, 1)]);
    let mut frame = Frame::new([9, 7], uneven);
    let geometry = frame.geometry;
    let mut mended = BadPixelDetector::new(&mut frame, Defects::open(&table).unwrap()).unwrap();
    assert_eq!(mended.geometry(), geometry);
    assert_eq!(mended.expose(1), Err(DetectorError::Exposure));
    let whole = geometry.whole();
    assert_eq!(mended.read(Window { x: 1, ..whole }, &mut [0; 63]), Err(DetectorError::OutsideDetector));
    assert_eq!(mended.read(whole, &mut [0; 62]), Err(DetectorError::BufferLength));
    assert_eq!(mended.read(Window { width: 0, ..whole }, &mut []), Ok(()));
}

#[test]
fn a_table_of_another_detector_is_refused() {
    let table = bytes([9, 8], &[], &[]);
    let mut frame = Frame::new([9, 7], uneven);
    let refused = BadPixelDetector::new(&mut frame, Defects::open(&table).unwrap()).map(|_| ());
    assert_eq!(refused, Err(DefectsError::OtherDetector));
}

/// Bad pixels and offsets of a detector of 24 x 18 px, thinly or thickly strewn.
fn table() -> impl Strategy<Value = Vec<u8>> {
    let bad = prop::collection::vec((0u16..24, 0u16..18).prop_map(|(x, y)| [x, y]), 0..200);
    let offsets = prop::collection::btree_map(0u16..24, -200i16..200, 0..10);
    (bad, offsets).prop_map(|(bad, offsets)| bytes([24, 18], &bad, &offsets.into_iter().collect::<Vec<_>>()))
}

proptest! {
    #[test]
    fn any_window_alone_is_the_same_window_of_the_whole(
        table in table(), seed: u64, x in 0u16..24, y in 0u16..18, width in 0u16..=24, height in 0u16..=18,
    ) {
        let pixel = |x: u16, y: u16| (seed.wrapping_mul(u64::from(x) * 77 + u64::from(y) * 991 + 1) >> 40) as u16 % 1024;
        let frame = Frame::new([24, 18], pixel);
        let whole = read(&frame, &table, frame.geometry.whole());
        let window = Window { x, y, width: width.min(24 - x), height: height.min(18 - y) };
        let alone = read(&frame, &table, window);
        for (k, value) in alone.iter().enumerate() {
            let (dx, dy) = (k % usize::from(window.width), k / usize::from(window.width));
            prop_assert_eq!(*value, whole[(usize::from(y) + dy) * 24 + usize::from(x) + dx]);
        }
    }

    #[test]
    fn good_pixels_without_offset_are_untouched_and_bad_ones_do_not_matter(table in table(), hot in 0u16..1024) {
        let defects = Defects::open(&table).unwrap();
        let listed: Vec<u16> = defects.offsets().map(|(x, _)| x).collect();
        let (quiet, loud) = (Frame::new([24, 18], uneven), Frame::new([24, 18], |x, y| {
            if defects.is_bad(x, y) { hot } else { uneven(x, y) }
        }));
        let whole = quiet.geometry.whole();
        let (one, other) = (read(&quiet, &table, whole), read(&loud, &table, whole));
        for k in 0..24 * 18u16 {
            let (x, y, k) = (k % 24, k / 24, usize::from(k));
            if !defects.is_bad(x, y) && !listed.contains(&x) {
                prop_assert_eq!(one[k], quiet.at(x, y));
            }
            if !defects.is_bad(x, y) || is_replaceable(&defects, x, y) {
                prop_assert_eq!(one[k], other[k]);
            }
        }
    }
}
