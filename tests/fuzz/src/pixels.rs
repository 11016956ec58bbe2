//! Arbitrary pixels: whatever is found stands on the detector and has a sigma.

use fsw_core::image::DetectionParameters;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_core::image::streaks::search::{Pieces, search};
use fsw_hal::{DetectorGeometry, LocalTime};

/// Tries the bytes.
pub fn try_bytes(bytes: &[u8]) {
    let [width, height, bits, pixels @ ..] = bytes else { return };
    let (width, height) = (32 + u16::from(*width), 32 + u16::from(*height));
    let geometry = DetectorGeometry { width_px: width, height_px: height, bits: 8 + bits % 9 };
    let mut detector = crate::Bytes { geometry, pixels, instant: LocalTime::default() };
    let mut buffer = Box::new([0; TILE_PIXELS]);
    let mut detections = Detections::new();
    if scan(&mut detector, &mut buffer, &DetectionParameters::default(), &mut detections).is_ok() {
        for spot in detections.spots() {
            let [x, y] = spot.centre_px();
            assert!(x >= 0.0 && x < f32::from(width) && y >= 0.0 && y < f32::from(height), "{spot:?}");
            assert!(spot.sigma_q16 > 0 && spot.flux > 0, "{spot:?}");
        }
    }
    let mut pieces = Pieces::new();
    if search(&mut detector, &mut buffer, &mut pieces).is_ok() {
        assert!(
            pieces.iter().all(|piece| piece.at_px.iter().chain(&piece.along).all(|part| part.is_finite()))
        );
    }
}
