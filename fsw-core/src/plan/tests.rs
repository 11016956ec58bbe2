use super::*;
use proptest::prelude::*;
use std::vec::Vec as List;

const REFERENCE: DetectorGeometry = DetectorGeometry { width_px: 1280, height_px: 1024, bits: 10 };

fn star(index: u16, centre_px: [f32; 2]) -> Predicted {
    Predicted { star: index, centre_px }
}

fn windows(centres: &[[f32; 2]], gate_px: u16) -> List<Window> {
    let stars: List<_> = (0..).zip(centres).map(|(index, centre)| star(index, *centre)).collect();
    star_windows(&stars, &REFERENCE, gate_px, |_| false).to_vec()
}

#[test]
fn a_window_is_the_gate_and_the_margin_about_the_star() {
    let side = 2 * (5 + MARGIN as u16) + 1;
    let [window] = windows(&[[640.4, 99.6]], 5)[..] else { panic!("one window") };
    assert_eq!((window.width, window.height), (side, side));
    assert_eq!((window.x + side / 2, window.y + side / 2), (640, 100));
}

#[test]
fn a_window_that_would_leave_the_detector_is_dropped() {
    let reach = f32::from(5 + MARGIN as u16);
    let kept = [[reach, reach], [1279.0 - reach, 1023.0 - reach]];
    assert_eq!(windows(&kept, 5).len(), 2);
    let dropped = [
        [reach - 1.0, 500.0],
        [500.0, reach - 1.0],
        [1280.0 - reach, 500.0],
        [500.0, 1024.0 - reach],
        [-3.0, 2000.0],
    ];
    assert_eq!(windows(&dropped, 5), []);
    // A detector smaller than a window has none.
    let small = DetectorGeometry { width_px: 20, height_px: 20, bits: 10 };
    assert!(star_windows(&[star(0, [10.0, 10.0])], &small, 5, |_| false).is_empty());
}

#[test]
fn the_first_stars_have_the_windows_and_there_are_never_more_than_the_cap() {
    let centres: List<_> = (0..64).map(|index| [100.0 + 15.0 * index as f32, 500.0]).collect();
    let planned = windows(&centres, 5);
    assert_eq!(planned.len(), MAX_STAR_WINDOWS);
    for (window, centre) in planned.iter().zip(&centres) {
        assert_eq!(f32::from(window.x + window.width / 2), centre[0]);
    }
}

#[test]
fn the_widest_window_fits_the_readout_buffer() {
    let [window] = windows(&[[640.0, 512.0]], u16::MAX)[..] else { panic!("one window") };
    assert_eq!(window.width, 2 * (MAX_GATE_PX + MARGIN as u16) + 1);
    assert!(window.height <= 64);
    assert!(window.area() <= crate::image::scan::TILE_PIXELS);
}

#[test]
fn the_area_searched_is_that_of_the_gates() {
    let planned = windows(&[[100.0, 100.0], [300.0, 300.0], [500.0, 500.0]], 5);
    assert_eq!(searched_px(&planned), 3.0 * 11.0 * 11.0);
    assert_eq!(searched_px(&[]), 0.0);
    assert_eq!(searched_px(&[Window { x: 0, y: 0, width: 3, height: 3 }]), 0.0);
}

fn position() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -50.0f32..1400.0,
        1 => any::<f32>(),
        1 => prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -2.147_483_6e9]),
    ]
}

proptest! {
    #[test]
    fn windows_fit_the_detector_and_stand_within_half_a_pixel_of_their_stars(
        centres in prop::collection::vec(prop::array::uniform2(position()), 0..64),
        gate_px in any::<u16>(),
        width_px in any::<u16>(),
        height_px in any::<u16>(),
    ) {
        let geometry = DetectorGeometry { width_px, height_px, bits: 10 };
        let stars: List<_> = (0..).zip(&centres).map(|(index, centre)| star(index, *centre)).collect();
        let planned = star_windows(&stars, &geometry, gate_px, |_| false);
        prop_assert!(planned.len() <= MAX_STAR_WINDOWS);
        let mut stars = centres.iter();
        for window in &planned {
            prop_assert!(window.fits(&geometry));
            let middle = [window.x + window.width / 2, window.y + window.height / 2].map(f32::from);
            // In the order of the stars; those without a window are passed over.
            prop_assert!(stars.any(|star| (0..2).all(|axis| (star[axis] - middle[axis]).abs() <= 0.5001)));
        }
    }
}

#[test]
fn a_hidden_star_has_no_window_and_leaves_its_place_to_the_next() {
    let stars: List<_> = (0..40).map(|index| star(index, [100.0 + 25.0 * f32::from(index), 500.0])).collect();
    let planned = star_windows(&stars, &REFERENCE, 5, |[x, _]| x < 300.0);
    assert_eq!(planned.len(), MAX_STAR_WINDOWS);
    assert!(planned.iter().all(|window| window.x + window.width / 2 >= 300));
}

#[test]
fn probes_stand_apart_and_lie_on_every_detector() {
    for (width_px, height_px) in [(1280, 1024), (386, 290), (32, 32), (7, 3)] {
        let geometry = DetectorGeometry { width_px, height_px, bits: 10 };
        let probes = probes(&geometry);
        assert!(probes.iter().all(|probe| probe.fits(&geometry) && probe.area() > 0));
    }
    let [first, .., last] = probes(&REFERENCE);
    assert_eq!((first.x, first.y, last.x + last.width, last.y + last.height), (0, 0, 1280, 1024));
}
