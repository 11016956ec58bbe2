//! Ways whose speed changes, against images of even times.

use super::*;
use crate::world::detector::pixel::PixelResponse;
use fsw_hal::Window;
use std::sync::Arc;

const WINDOW: Window = Window { x: 0, y: 0, width: 96, height: 24 };
const ELECTRONS: f64 = 8000.0;

/// The pixels of lines and images.
fn pixels(light: PointLight, psf: &Arc<Psf>) -> Vec<f64> {
    let mut pixels = vec![0.0; WINDOW.area()];
    light.streaks.add_to(WINDOW, &mut pixels);
    Spots::new(psf.clone(), PixelResponse::Full, light.spots).add_to(WINDOW, &mut pixels);
    pixels
}

/// A way, its place at a part of the exposure given, in so many chords.
fn chords(place: impl Fn(f64) -> f64, count: usize) -> Vec<[f64; 2]> {
    (0..=count).map(|chord| [place(chord as f64 / count as f64), 11.3]).collect()
}

#[test]
fn a_star_that_begins_to_move_or_comes_to_rest_keeps_its_light_where_it_is() {
    let psf = Arc::new(Psf::gaussian(0.9));
    let none = || PointLight { spots: Vec::new(), streaks: Streaks::new(psf.clone(), PixelResponse::Full) };
    let mut colour = [0.0; BANDS];
    colour[0] = ELECTRONS;
    // From rest all along; at rest for two thirds; to rest; at an even speed; slower and faster.
    let ways: [fn(f64) -> f64; 5] = [
        |t| 12.2 + 15.0 * t * t,
        |t| 12.2 + 500.0 * (t - 0.66).max(0.0).powi(2),
        |t| 12.2 + 60.0 * (1.0 - (1.0 - t).powi(3)),
        |t| 12.2 + 60.0 * t,
        |t| 12.2 + 60.0 * (t + 0.1 * (std::f64::consts::TAU * t).sin()),
    ];
    for (number, way) in ways.into_iter().enumerate() {
        let mut drawn = none();
        drawn.lay_way(&chords(way, 32), colour.map(|e| e / 32.0), &psf);
        let mut oracle = none();
        let places = chords(way, 4096);
        oracle.spots.extend(images(&places, colour.map(|e| e / 4096.0), 0.02));
        let (drawn, oracle) = (pixels(drawn, &psf), pixels(oracle, &psf));
        let (all, brightest) = (drawn.iter().sum::<f64>(), oracle.iter().copied().fold(0.0, f64::max));
        let worst = drawn.iter().zip(&oracle).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        println!("way {number}: light {:.4}, worst pixel {:.4}", all / ELECTRONS, worst / brightest);
        // A pixel by less than its noise, two of a hundred.
        assert!((all / ELECTRONS - 1.0).abs() < 0.003 && worst < 0.02 * brightest, "way {number}");
    }
}
