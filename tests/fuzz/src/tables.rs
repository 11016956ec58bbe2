//! Catalogue, lens calibration and table of bad pixels, their checksums right: what opens can be used.

use fsw_core::catalog::Catalogue;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::defects::Defects;

/// Tries the bytes.
pub fn try_bytes(bytes: &[u8]) {
    let table = crate::sealed_table(bytes);
    if let Ok(catalogue) = Catalogue::open(&table) {
        for star in catalogue.stars().take(100) {
            let direction = catalogue.apparent_direction(&star);
            assert!((direction.vector().norm() - 1.0).abs() < 1e-3);
        }
        let most = catalogue.max_chord();
        for part in 0..8 {
            let low = most * part as f32 / 8.0;
            let pairs = catalogue.pairs_between(low, low + most / 8.0).take(100);
            for pair in pairs {
                let _ = [pair.first, pair.second].map(|star| catalogue.unit(star));
            }
        }
    }
    if let Ok(calibration) = Calibration::open(&table) {
        let [width, height] = calibration.size_px().map(f32::from);
        for (x, y) in [(0.0, 0.0), (width, 0.0), (width / 2.0, height / 3.0), (-1e6, 1e6)] {
            assert!(calibration.correction_px([x, y]).iter().all(|px| px.is_finite()));
            assert!(calibration.colour_shift_px([x, y], 1.4).iter().all(|px| px.is_finite()));
            if let Some(profile) = calibration.profile(x.abs()) {
                let mut lights = [[0.0; 3]; 12];
                profile.light_of_line([-6.0, 0.3], [1.0, 0.1], &mut lights);
                assert!(lights.as_flattened().iter().all(|light| light.is_finite()));
            }
        }
    }
    if let Ok(defects) = Defects::open(&table) {
        let [width, height] = defects.size_px();
        for y in [0, height / 2, height - 1] {
            for x in defects.row(y) {
                assert!(x < width && defects.is_bad(x, y));
            }
        }
        assert!(defects.offsets().all(|(x, _)| x < width));
    }
}
