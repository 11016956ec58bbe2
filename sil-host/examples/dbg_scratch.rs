//! scratch
use sil_host::calibration::*; use sil_host::camera_file::CameraFile; use sil_host::world::{imaging::ImagingModel, stars::DetectorModel};
fn main() {
    let lens = Lens::new(&CameraFile::reference(), &ImagingModel::REFERENCE, &DetectorModel::reference()).unwrap();
    for r in [0.0, 100.0, 300.0, 600.0] { println!("{r} {:?}", lens.measured([639.5+r, 511.5], 0.6, None)); 
    println!("{r} {:?}", lens.measured([639.2+r, 511.4], 0.6, None)); }
    println!("{:?}", build(&lens, Grid { step_px: 300, mirrored: true }).map(|b| b.len()));
}
