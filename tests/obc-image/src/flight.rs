//! The flight: one cycle a frame, each between the marks of the meter, its telemetry to the file.
//!
//! In: the instruments, the number of seconds and the telemetry file. Out: how many seconds were flown and failed.
//!
//! PLUG THE SENSOR IN HERE. Until `fsw_core::sensor::Sensor` is there, [`second`] stands in for `Sensor::cycle`: it
//! reads the whole frame strip by strip through the trait and reports the CRC-32 of its pixels, and [`encode`] stands in
//! for `telemetry::encode`. What is around them stays.

use crate::{host::File, marks};
use fsw_core::catalog::{Catalogue, format::CRC32};
use fsw_hal::{Detector, DetectorError, Window};

/// The onboard catalogue, built and checked by `catalog-gen`.
static CATALOGUE: &[u8] = include_bytes!("../../../catalog-gen/data/reference.cat");

/// Longest exposure the stand-in asks for; a recorded frame ignores it.
const EXPOSURE_US: u32 = 100_000;
/// Pixels of the strip that is held in RAM: 8 rows of the reference detector.
const STRIP_PIXELS: usize = 8 * 1280;
/// Stage numbers of the stand-in.
const STAGE_READ: u32 = 0;
const STAGE_CHECKSUM: u32 = 1;

/// What a flight came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flight {
    /// Cycles run.
    pub seconds: u32,
    /// Cycles that gave no report or whose telemetry could not be written.
    pub failed: u32,
}

/// What the stand-in reports of a second.
struct Report {
    second: u32,
    crc: u32,
}

/// Flies `seconds` seconds.
pub fn fly(detector: &mut impl Detector, seconds: u32, telemetry: &mut File) -> Flight {
    let mut flight = Flight::default();
    let Some(strip) = cortex_m::singleton!(: [u16; STRIP_PIXELS] = [0; STRIP_PIXELS]) else {
        return Flight { seconds: 0, failed: seconds };
    };
    match Catalogue::open(CATALOGUE) {
        Ok(catalogue) => defmt::info!("catalogue: {} stars", catalogue.star_count()),
        Err(_) => {
            defmt::error!("catalogue refused");
            return Flight { seconds: 0, failed: seconds };
        }
    }
    for index in 0..seconds {
        flight.seconds += 1;
        let sent = match marks::cycle(|| second(detector, index, strip)) {
            Ok(report) => {
                defmt::info!("second {}: crc {=u32:#x}", report.second, report.crc);
                telemetry.write(&encode(&report)).is_ok()
            }
            Err(_) => {
                defmt::warn!("second {}: no report", index);
                false
            }
        };
        flight.failed += u32::from(!sent);
    }
    flight
}

/// Stand-in for `Sensor::cycle`.
fn second(detector: &mut impl Detector, second: u32, strip: &mut [u16]) -> Result<Report, DetectorError> {
    let whole = detector.geometry().whole();
    let rows_at_once =
        u16::try_from(strip.len() / usize::from(whole.width).max(1)).unwrap_or(u16::MAX).max(1);
    detector.expose(EXPOSURE_US)?;
    let mut digest = CRC32.digest();
    for y in (0..whole.height).step_by(usize::from(rows_at_once)) {
        let window = Window { y, height: rows_at_once.min(whole.height - y), ..whole };
        let pixels = strip.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
        marks::stage_begin(STAGE_READ);
        detector.read(window, pixels)?;
        marks::stage_end(STAGE_READ);
        marks::stage_begin(STAGE_CHECKSUM);
        pixels.iter().for_each(|pixel| digest.update(&pixel.to_le_bytes()));
        marks::stage_end(STAGE_CHECKSUM);
    }
    Ok(Report { second, crc: digest.finalize() })
}

/// Stand-in for `telemetry::encode`: second and CRC, little-endian.
fn encode(report: &Report) -> [u8; 8] {
    let [s0, s1, s2, s3] = report.second.to_le_bytes();
    let [c0, c1, c2, c3] = report.crc.to_le_bytes();
    [s0, s1, s2, s3, c0, c1, c2, c3]
}
