//! scratch
use sil_host::calibration::*; use sil_host::camera_file::CameraFile; use sil_host::world::{imaging::ImagingModel, stars::DetectorModel};
use fsw_core::image::calibration::Calibration;
fn main() {
    let lens = Lens::new(&CameraFile::reference(), &ImagingModel::REFERENCE, &DetectorModel::reference()).unwrap();
    for (step_px, mirrored) in [(50,true),(50,false),(100,false),(130,false),(150,false),(200,false)] {
        let bytes = build(&lens, Grid { step_px, mirrored }).unwrap();
        let c = Calibration::open(&bytes).unwrap();
        let [cx, cy] = lens.centre_px();
            let (mut b, mut m, mut n, mut me, mut be, mut ne) = (0.0, 0.0f64, 0.0, 0.0f64, 0.0, 0.0);
            for k in 0..4000u32 {
                let p = [cx + (f64::from(k % 50) - 24.5) * 25.1 + 0.137 * f64::from(k % 7), cy + (f64::from(k / 50) - 39.5) * 12.3 + 0.219 * f64::from(k % 5)];
                let Some(after) = lens.measured(p, 0.6, Some(&c)) else { continue };
                let edge = p[0] < 40.0 || p[1] < 40.0 || p[0] > 1240.0 || p[1] > 984.0;
                for i in 0..2 { let e = (after[i]-p[i]).powi(2); if edge { be += e; ne += 1.0; me = me.max(e.sqrt()); } else { b += e; m = m.max(e.sqrt()); n += 1.0; } }
            }
        println!("{step_px} {mirrored}: {} bytes residual {:.4} rms {:.4} worst {:.4} edge {:.4} {:.4}", bytes.len(), c.residual_px(), f64::sqrt(b/n), m, f64::sqrt(be/ne), me);
    }
}
