//! scratch
use sil_host::calibration::*; use sil_host::camera_file::CameraFile; use sil_host::world::{imaging::ImagingModel, stars::DetectorModel, pixel::PixelResponse};
use fsw_core::image::calibration::Calibration;
fn main() {
    for response in [PixelResponse::LShape, PixelResponse::Full] {
    let lens = Lens::new(&CameraFile::reference(), &ImagingModel::REFERENCE, &DetectorModel{ response, ..DetectorModel::reference() }).unwrap();
    for (step_px, mirrored) in [(1200,false),(50,false)] {
        let bytes = build(&lens, Grid { step_px, mirrored }).unwrap();
        let c = Calibration::open(&bytes).unwrap();
        println!("{response:?} {step_px} {mirrored}: {} bytes residual {}", bytes.len(), c.residual_px());
        let [cx, cy] = lens.centre_px();
        for (lo, hi) in [(0.0, 100.0), (100.0, 250.0), (250.0, 400.0), (400.0, 550.0), (550.0, 900.0)] {
            let (mut a, mut b, mut m, mut n) = (0.0, 0.0, 0.0f64, 0.0);
            for k in 0..2000u32 {
                let p = [cx + (f64::from(k % 40) - 19.5) * 29.0 + 0.137 * f64::from(k % 7), cy + (f64::from(k / 40) - 24.5) * 17.9 + 0.219 * f64::from(k % 5)];
                let r = (p[0]-cx).hypot(p[1]-cy); if r < lo || r >= hi { continue }
                let (Some(before), Some(after)) = (lens.measured(p, 0.6, None), lens.measured(p, 0.6, Some(&c))) else { continue };
                for i in 0..2 { a += (before[i]-p[i]).powi(2); let e = (after[i]-p[i]).powi(2); b += e; m = m.max(e.sqrt()); n += 1.0; }
            }
            println!("   r {lo}-{hi}: CoI {:.4} calibrated {:.4} worst {:.4}", f64::sqrt(a/n), f64::sqrt(b/n), m);
        }
    } }
}
