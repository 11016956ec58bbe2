//! The flight: one cycle a frame, each between the marks of the meter, its telemetry to the file.
//!
//! In: the detector, the parameter table, the number of seconds, the telemetry file and the command link.
//! Out: how many seconds were flown and failed. Catalogue and calibration are part of the image.

use crate::commands::Commands;
use crate::host::File;
use crate::recorded::{Recorded, RecordedDetector};
use crate::{marks, memory};
use fsw_core::catalog::Catalogue;
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::defects::{Defects, LENGTH_FROM, MAGIC};
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Instruments, Sensor, SensorError, Workspace};
use fsw_core::telemetry;
use fsw_hal::{Detector, DetectorGeometry, Instant, LocalTime, Stage, StageMeter};
use static_cell::{ConstStaticCell, StaticCell};

/// The onboard catalogue, built and checked by `catalog-gen`.
static CATALOGUE: &[u8] = include_bytes!("../../../catalog-gen/data/reference.cat");

/// The reference camera's profiles and corrections, made by `sil-host calibrate`.
static CALIBRATION: &[u8] = include_bytes!("../../../sil-host/cameras/reference-calibrated.corr");

// What lasts as long as the flight is static, and what is large is so from the start: the stack is left to
// the second.
static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static FRAME: ConstStaticCell<[u8; telemetry::MAX_FRAME_BYTES]> =
    ConstStaticCell::new([0; telemetry::MAX_FRAME_BYTES]);
static SENSOR: StaticCell<Sensor<'static>> = StaticCell::new();

/// What a flight came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flight {
    /// Cycles run.
    pub seconds: u32,
    /// Cycles whose telemetry or reports could not be written.
    pub failed: u32,
}

/// Why no second was flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum StartError {
    /// The onboard catalogue is damaged.
    Catalogue,
    /// A value of the parameter table is out of its range.
    Parameters,
    /// The calibration is damaged, or not the one that the parameter table names.
    Calibration,
    /// An image flies once.
    FlownBefore,
    /// The table of bad pixels is damaged.
    BadPixels,
    /// The table of bad pixels is another detector's.
    OtherDetector,
}

/// Stage marks as the outside meter sees them.
struct Marks;

impl StageMeter for Marks {
    fn begin(&mut self, stage: Stage) {
        marks::stage_begin(stage as u32);
    }
    fn end(&mut self, stage: Stage) {
        marks::stage_end(stage as u32);
    }
}

/// The sensor, in its place. (Not inlined: what it is put together from is not to lie under the seconds on
/// the stack.)
///
/// # Errors
/// What cannot be used of what it is made from.
#[inline(never)]
pub fn sensor(parameters: Parameters) -> Result<&'static mut Sensor<'static>, StartError> {
    let workspace = WORKSPACE.try_take().ok_or(StartError::FlownBefore)?;
    let catalogue = Catalogue::open(CATALOGUE).map_err(|_| StartError::Catalogue)?;
    defmt::info!("catalogue: {} stars", catalogue.star_count());
    let calibration = match parameters.imaging.calibration_crc {
        0 => None,
        _ => Some(Calibration::open(CALIBRATION).map_err(|_| StartError::Calibration)?),
    };
    let place = SENSOR.try_uninit().ok_or(StartError::FlownBefore)?;
    let sensor = Sensor::new_in(place, catalogue, parameters, calibration, workspace);
    sensor.map_err(|error| match error {
        SensorError::Parameters(_) => StartError::Parameters,
        SensorError::Calibration => StartError::Calibration,
    })
}

/// The detector's defects as they are known on board: those of the store, where it has a table.
///
/// # Errors
/// When the table is damaged, or of another detector.
fn known_defects(geometry: &DetectorGeometry) -> Result<Defects<'static>, StartError> {
    let (size_px, stored) = ([geometry.width_px, geometry.height_px], memory::store());
    if !stored.starts_with(&MAGIC) {
        return Ok(Defects::none(size_px));
    }
    let length = stored.get(LENGTH_FROM..).and_then(|rest| rest.first_chunk());
    let table = length.and_then(|length| stored.get(..u32::from_le_bytes(*length) as usize));
    let defects = table.and_then(|table| Defects::open(table).ok()).ok_or(StartError::BadPixels)?;
    if defects.size_px() == size_px { Ok(defects) } else { Err(StartError::OtherDetector) }
}

/// Flies `seconds` seconds. (Not inlined: its report is not to lie under the making of the sensor.)
///
/// # Errors
/// When an image has flown before, or the store has a table that is not this detector's.
#[inline(never)]
pub fn fly(
    sensor: &mut Sensor<'static>,
    detector: &mut RecordedDetector,
    seconds: u32,
    output: &mut File,
    commands: &mut Option<Commands>,
) -> Result<Flight, StartError> {
    let frame = FRAME.try_take().ok_or(StartError::FlownBefore)?;
    let defects = known_defects(&detector.geometry())?;
    let mut flight = Flight::default();
    for second in 0..seconds {
        // A file that breaks off gives an instant before all others, which the sensor reports.
        let broken = Instant { local: LocalTime::from_us(i64::MIN), terrestrial_us: None };
        let (mut clock, mut rate_sensor, mut magnetometer) =
            detector.turn_to(second).unwrap_or((broken, Recorded(None), Recorded(None)));
        // Of this detector.
        let Ok(mut detector) = BadPixelDetector::new(&mut *detector, defects) else { break };
        let mut instruments = Instruments {
            detector: &mut detector,
            clock: &mut clock,
            meter: &mut Marks,
            rate_sensor: &mut rate_sensor,
            magnetometer: &mut magnetometer,
            shutter: &mut (),
        };
        if let Some(commands) = commands {
            commands.receive(second);
        }
        let command = commands.as_ref().map_or(Command::Continue, Commands::command);
        let report = marks::cycle(|| sensor.cycle(&mut instruments, command));
        flight.seconds += 1;
        defmt::info!(
            "second {}: {} spots, {} stars named",
            report.cycle,
            report.detections,
            report.stars.len()
        );
        let sent = telemetry::encode_next(&report, frame).is_ok_and(|bytes| output.write(bytes).is_ok());
        let reported =
            commands.as_mut().is_none_or(|commands| commands.conclude(&report, &sensor.downlink()));
        flight.failed += u32::from(!sent || !reported);
    }
    Ok(flight)
}
