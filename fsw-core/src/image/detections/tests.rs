use super::*;

/// A bright round spot in the open sky.
pub const SPOT: Detection = Detection {
    x_q16: 0,
    y_q16: 0,
    flux: 20_000,
    core_flux: 10_000,
    sigma_q16: 3000,
    saturated: false,
    extended: false,
    drawn_px: 0,
    blended: false,
    repeated: false,
    number: 0,
    backdrop: 0,
};

/// A spot at a column, of a sigma of 0.03 px.
fn spot(x: i32, backdrop: u16) -> Detection {
    Detection { x_q16: x << 16, flux: 8000, sigma_q16: 1966, backdrop, ..SPOT }
}

#[test]
fn an_uneven_image_before_ground_is_doubted_once() {
    let mut detections = Detections::new();
    for (x, backdrop, background) in [(100, 0, 600), (200, 620, 620), (300, 1700, 1700), (400, 0, 1700)] {
        let spot = spot(x, backdrop);
        assert!(detections.insert(spot));
        detections.evidence().note_spot(&spot, background, true, false);
    }
    detections.settle();
    let mut sigma_px = |x: i32| {
        detections.mark_repeated(|_| None);
        detections.spots().iter().find(|spot| spot.x_q16 == x << 16).unwrap().sigma_px()
    };
    // The sky, sky as dark as that but for a sixty-fourth of full scale, ground under a star alone.
    for x in [100, 200, 400] {
        assert!((sigma_px(x) - 0.03).abs() < 1e-4);
    }
    let drawn_px = 1.5 * (1700.0 - 600.0 - 256.0) / 8000.0;
    assert!((sigma_px(300) - 0.03f32.hypot(drawn_px)).abs() < 1e-3);
}
