//! Seconds of the whole sensor on arbitrary pixels, clocks and commands: it ends, and what it reports is a
//! number.

use fsw_core::camera::{CameraParameters, Distortion, Projection};
use fsw_core::catalog::Catalogue;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Sensor, Workspace};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES};
use fsw_hal::{DetectorGeometry, Instant, LocalTime};
use sil_host::flight;

/// The camera that sees them.
pub const CAMERA: CameraParameters = CameraParameters {
    width_px: SIDE_PX,
    height_px: SIDE_PX,
    focal_length_px: 400.0,
    optical_centre_px: [80.0, 80.0],
    projection: Projection::Rectilinear,
    distortion: Distortion { k1: 0.0, k2: 0.0, k3: 0.0, p1: 0.0, p2: 0.0 },
    corner_loss: 0.0,
    mirrored: false,
};
/// Side of the detector, px: wide enough for limb and stars, small enough for many seconds in one.
pub const SIDE_PX: u16 = 160;
/// Bytes that a second has before its pixels: clock, command, counter and image.
pub const HEAD: usize = 5;

/// Tries the bytes: how many seconds, and what is seen in each. Gives the number of seconds with an attitude.
pub fn try_bytes(bytes: &[u8]) -> usize {
    let [seconds, bytes @ ..] = bytes else { return 0 };
    let seconds = 1 + usize::from(seconds % 8);
    let catalogue = Catalogue::open(catalog_gen::REFERENCE).expect("the catalogue is sound");
    let mut workspace = Box::new(Workspace::new());
    let mut sensor = Sensor::new(catalogue, Parameters::for_camera(CAMERA), &mut workspace)
        .expect("the defaults are sound");
    let geometry = DetectorGeometry { width_px: SIDE_PX, height_px: SIDE_PX, bits: 10 };
    let mut attitudes = 0;
    let mut time_us = 1_800_000_000_000_000_i64;
    let mut local_us = 0_i64;
    for bytes in bytes.chunks(bytes.len().div_ceil(seconds).max(1)) {
        let (head, pixels) = bytes.split_at(HEAD.min(bytes.len()));
        let [step, scale, command, counter, image] =
            [0, 1, 2, 3, 4].map(|k| head.get(k).copied().unwrap_or(0));
        // Mostly a second; sometimes hours, backwards too.
        let off = |byte: u8| if byte < 200 { 1_000_000 } else { i64::from(byte as i8) << (scale % 40) };
        time_us += off(step);
        local_us = local_us.saturating_add(off(counter));
        let terrestrial_us = (scale % 7 != 6).then_some(time_us);
        let command = match command {
            250 => Command::Reacquire,
            251 => Command::Restart,
            252 => Command::Safe,
            _ => Command::Continue,
        };
        let instant = LocalTime::from_us(local_us.saturating_add(off(image) - 1_000_000));
        let mut detector = crate::Bytes { geometry, pixels, instant };
        let mut clock = Instant { local: LocalTime::from_us(local_us), terrestrial_us };
        let report = flight::second(&mut sensor, &mut detector, &mut clock, command);
        if let Some(attitude) = &report.attitude {
            attitudes += 1;
            let norm = attitude.quaternion.iter().map(|q| q * q).sum::<f32>();
            assert!((norm - 1.0).abs() < 1e-3, "{attitude:?}");
            assert!(attitude.sigma_rad.iter().all(|sigma| *sigma > 0.0 && sigma.is_finite()), "{attitude:?}");
        }
        assert!(telemetry::encode(&report, &mut [0; MAX_FRAME_BYTES]).is_ok());
    }
    attitudes
}
