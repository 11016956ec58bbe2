//! Scratch.
use fsw_core::image::DetectionParameters;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_hal::Detector;
use sil_host::scenario::Scenario;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let scenario = Scenario::parse(std::path::Path::new(&args[1]), &text).unwrap();
    let mut scene = scenario.scene().unwrap();
    for cycle in &args[3..] {
        let cycle: u64 = cycle.parse().unwrap();
        scene.expose_cycle(cycle, scenario.exposure_us).unwrap();
        let geometry = scene.geometry();
        let mut found = Detections::new();
        scan(&mut scene, &mut [0; TILE_PIXELS], &DetectionParameters::default(), &mut found).unwrap();
        let mut pixels = vec![0u16; geometry.whole().area()];
        scene.read(geometry.whole(), &mut pixels).unwrap();
        let bytes: Vec<u8> = pixels.iter().flat_map(|p| p.to_le_bytes()).collect();
        std::fs::write(format!("{}-{cycle}.raw", args[2]), bytes).unwrap();
        let mut out = String::new();
        for s in scene.visible_stars() {
            out += &format!("T {} {} {}\n", s.x_px, s.y_px, s.v);
        }
        for d in found.spots() {
            let [x, y] = d.centre_px();
            out += &format!("D {x} {y} {} {} {} {} {}\n", d.core_flux, d.flux, d.sigma_px(), d.extended as u8, (d.drawn_px > 0) as u8 + 2 * d.blended as u8);
        }
        std::fs::write(format!("{}-{cycle}.txt", args[2]), out).unwrap();
        let near = |d: &fsw_core::image::Detection, v: f64| {
            let [x, y] = d.centre_px().map(f64::from);
            scene.visible_stars().iter().any(|s| s.v < v && (s.x_px - x).abs() < 1.5 && (s.y_px - y).abs() < 1.5)
        };
        let seen = |v: f64| {
            let stars: Vec<_> = scene.visible_stars().iter().filter(|s| s.v < v).collect();
            let hit = stars.iter().filter(|s| found.spots().iter().any(|d| {
                let [x, y] = d.centre_px().map(f64::from);
                (s.x_px - x).abs() < 1.5 && (s.y_px - y).abs() < 1.5
            })).count();
            (hit, stars.len())
        };
        println!("streaks {} drawn {}", found.streaks(), found.spots().iter().filter(|d| d.drawn_px > 0).map(|d| d.drawn_px.to_string() + ",").collect::<String>());
        println!("{} {cycle}: found {} kept {} crowded {}; true {} (V<7.5); in first 64: {}; first 20: {}; stars V<5 {:?} V<6 {:?}",
            args[2], found.found(), found.spots().len(), found.crowded_tiles(),
            found.spots().iter().filter(|d| near(d, 7.5)).count(),
            found.spots().iter().take(64).filter(|d| near(d, 7.5)).count(),
            found.spots().iter().take(20).filter(|d| near(d, 7.5)).count(),
            seen(5.0), seen(6.0));
    }
}
