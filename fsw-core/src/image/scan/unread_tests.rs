//! Tiles and windows that the detector does not deliver.

use super::tests::{at, places, scanned, with_stars};
use super::*;
use crate::image::DetectionParameters;
use crate::image::test_sky::{Chance, Frame, Sky};
use fsw_hal::LocalTime;

/// Of the windows that are lost.
const SEED: u64 = 1 << 40;

/// A detector that loses windows by their place, so many in a thousand.
struct Losing {
    frame: Frame,
    per_mille: u64,
    error: DetectorError,
    lost: std::vec::Vec<Window>,
}

impl fsw_hal::ErrorType for Losing {
    type Error = DetectorError;
}

impl Detector for Losing {
    fn geometry(&self) -> DetectorGeometry {
        self.frame.geometry
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        let place = u64::from(window.y) << 16 | u64::from(window.x);
        if Chance(place + SEED).bits() % 1000 < self.per_mille {
            self.lost.push(window);
            return Err(self.error);
        }
        self.frame.read(window, pixels)
    }
}

/// The reference detector with 90 stars.
fn sky() -> (Frame, std::vec::Vec<[f64; 2]>) {
    let mut stars = places(1280, 1024, 70, 5);
    stars.truncate(90);
    (with_stars(Sky::new(1280, 1024, 60.0), &stars, 0.9, 1500.0).noise(2.0, 6).expose(12), stars)
}

fn scan_losing(per_mille: u64, error: DetectorError) -> (Result<(), DetectorError>, Detections, Losing) {
    let mut detector = Losing { frame: sky().0, per_mille, error, lost: std::vec::Vec::new() };
    let mut detections = Detections::new();
    let parameters = DetectionParameters::default();
    let result = scan(&mut detector, &mut [0; TILE_PIXELS], &parameters, &mut detections);
    (result, detections, detector)
}

#[test]
fn the_stars_of_the_tiles_that_can_be_read_are_found_without_the_others() {
    let (mut frame, stars) = sky();
    let whole = scanned(&mut frame);
    let (result, found, detector) = scan_losing(30, DetectorError::Bus);
    assert_eq!(result, Ok(()));
    assert_eq!(found.unread() as usize, detector.lost.len(), "every window that was lost is counted");
    let tile = |window: &Window| usize::from(window.width) > usize::from(TEXTURED_SIDES[0]);
    let missing: std::vec::Vec<_> = stars.iter().filter(|star| at(&found, **star).is_none()).collect();
    // Each star that is missing stands in a window that was lost; every other is where it is without losses.
    let within = |star: &[f64; 2], window: &Window| {
        let inside = |at: f64, start: u16, side: u16| {
            (f64::from(start)..f64::from(start + side)).contains(&(at + 0.5))
        };
        inside(star[0], window.x, window.width) && inside(star[1], window.y, window.height)
    };
    assert!(missing.iter().all(|star| detector.lost.iter().any(|window| within(star, window))));
    assert!(stars.len() - missing.len() > 80 && !missing.is_empty(), "{} are missing", missing.len());
    for spot in found.spots() {
        let there = |other: &crate::image::Detection| {
            spot.x_q16.abs_diff(other.x_q16) < 1 << 14 && spot.y_q16.abs_diff(other.y_q16) < 1 << 14
        };
        assert!(whole.spots().iter().any(there), "a star where none is without losses");
    }
    // What was not searched is the cores of the tiles, and no more than 9 px of a candidate's window.
    let tiles = detector.lost.iter().filter(|window| tile(window)).count();
    let (core, others) = ((TILE_WIDTH - 2 * EDGE) * (TILE_HEIGHT - 2 * EDGE), detector.lost.len() - tiles);
    let unread_px = found.unread_px() as usize;
    assert!(tiles > 5 && unread_px <= tiles * core + 9 * others, "{tiles} tiles, {unread_px} px");
    assert!(unread_px > tiles * core * 8 / 10, "{tiles} tiles, {unread_px} px");
}

#[test]
fn a_detector_that_loses_most_of_its_tiles_ends_the_scan_early() {
    let most = tiles(&sky().0.geometry) / UNREAD_SHARE;
    for error in [DetectorError::Bus, DetectorError::Timeout] {
        for per_mille in [250, 600, 1000] {
            let (result, found, detector) = scan_losing(per_mille, error);
            assert_eq!(result, Err(error));
            assert_eq!((found.unread() as usize, detector.lost.len()), (most + 1, most + 1));
        }
    }
}

#[test]
fn a_refused_request_ends_the_scan_at_once() {
    for error in [
        DetectorError::OutsideDetector,
        DetectorError::BufferLength,
        DetectorError::NotExposed,
        DetectorError::Exposure,
    ] {
        let (result, found, _) = scan_losing(20, error);
        assert_eq!((result, found.unread()), (Err(error), 1));
    }
}
