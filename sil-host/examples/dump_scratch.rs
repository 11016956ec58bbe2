//! scratch
use fsw_hal::Window;
use sil_host::camera_file::CameraFile;
use sil_host::world::{colour, imaging::ImagingModel, optics::Optics, pixel::PixelResponse, spots::{Brush, Spot}};
use std::io::Write;
fn main() {
    let camera = CameraFile::reference();
    let optics = Optics::new(&camera).unwrap();
    let psf = ImagingModel::REFERENCE.psf(&optics).unwrap();
    eprintln!("rms {} reach {}", psf.rms_px(), psf.reach_px());
    let mut out = std::fs::File::create("/tmp/t-centroid/dump.bin").unwrap();
    let mut brush = Brush::default();
    // quadrant signs, radii, phases, colours
    for (response, b_v) in [(PixelResponse::LShape, 0.6), (PixelResponse::Full, 0.6), (PixelResponse::LShape, 0.0), (PixelResponse::LShape, 1.5)] {
        for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            for r in 0..9 {
                let (ox, oy) = (75.0 * r as f64 * sx, 60.0 * r as f64 * sy);
                let (bx, by) = ((640.0 + ox).round(), (512.0 + oy).round());
                for j in 0..10 { for i in 0..10 {
                    let (x_px, y_px) = (bx + i as f64 * 0.1 - 0.45, by + j as f64 * 0.1 - 0.45);
                    let mut light = vec![0.0; 441];
                    let window = Window { x: bx as u16 - 10, y: by as u16 - 10, width: 21, height: 21 };
                    let s = colour::shares(b_v); let t: f64 = s.iter().sum();
                    brush.draw(&psf, response, &Spot { x_px, y_px, electrons: s.map(|v| v / t) }, window, &mut light);
                    for v in light { out.write_all(&v.to_le_bytes()).unwrap(); }
                }}
            }
        }
    }
}
