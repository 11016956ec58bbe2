//! The sensor with its instruments and its command link: one call a second, what outlives a restart, and
//! files that were sent up, which serve from the start after.
//!
//! Kept every [`KEEP_EVERY_S`] seconds, and when safe is commanded or ended, is the telemetry frame itself: it
//! has the orbit with its sigmas, the mode, and a CRC of its own. The parameter table is kept whenever a
//! command has changed it. After a restart the sensor goes on with both; the attitude is found in the sky
//! within seconds anyway.

use crate::board::{self, Bridge, FRAME_MEMORY_PX, Pin, Pixels, Spi, Watch};
use crate::instrument::{CATALOGUE, ROWS, parameters};
use fsw_core::catalog::Catalogue;
use fsw_core::command::{CommandLink, CommandOutcome, MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES};
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::defects::Defects;
use fsw_core::modes::Mode;
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::sensor::{Instruments, Sensor, Workspace};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES, Report};
use fsw_drivers::cmv4000::{Outputs, Parts, SIZE_PX, Settings};
use fsw_drivers::lis2mdl_rs::blocking::{I2CAddress as MagnetometerAddress, Lis2mdl};
use fsw_drivers::lsm6dsv16x_rs::blocking::{I2CAddress as GyroAddress, Lsm6dsv16x};
use fsw_drivers::st_mems_bus::blocking::i2c::I2cBus;
use fsw_drivers::{
    AreaSlots, Cmv4000, FlashAreas, FlashStore, Lis2mdlMagnetometer, Lsm6dsv16xGyro, Mounting, Slots,
};
use fsw_hal::{Area, LocalTime, StateStore};
use static_cell::{ConstStaticCell, StaticCell};

static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static SENSOR: StaticCell<Sensor<'static>> = StaticCell::new();
static LINK: StaticCell<Link> = StaticCell::new();
static SPARE: ConstStaticCell<[u8; MAX_FRAME_BYTES]> = ConstStaticCell::new([0; MAX_FRAME_BYTES]);

const _: () = assert!(SIZE_PX as usize * ROWS.1 as usize <= FRAME_MEMORY_PX);
/// APID of the sensor. A spacecraft that is commanded through more hands than its own has a key as well, and
/// stores the link's counter.
const APID: u16 = 0x2A5;
/// Two slots of so many bytes for the frame at the begin of the non-volatile memory, two for the parameter
/// table, then those of the files.
const SLOT_BYTES: usize = 4096;
const TABLE_OFFSET: u32 = 2 * SLOT_BYTES as u32;
const AREAS: AreaSlots = AreaSlots {
    catalogue: Slots { offset: 0x1_0000, slot_bytes: 0x3_0000 },
    calibration: Slots { offset: 0x8_0000, slot_bytes: 0x1_0000 },
    bad_pixels: Slots { offset: 0xC_0000, slot_bytes: 0x1_0000 },
};
const _: () =
    assert!(MAX_FRAME_BYTES + 24 <= SLOT_BYTES && TABLE_OFFSET as usize + 2 * SLOT_BYTES <= 0x1_0000);
/// Between two records, s.
const KEEP_EVERY_S: u32 = 600;

type DetectorDriver = Cmv4000<'static, Spi, Pin, Pin, Bridge, Bridge, Pixels>;
type Link = CommandLink<FlashAreas<Bridge>>;
type Gyro = Lsm6dsv16xGyro<I2cBus<Bridge>, Bridge, Bridge>;
type Magnetometer = Lis2mdlMagnetometer<I2cBus<Bridge>, Bridge, Bridge>;

/// What a second needs.
pub struct Flight {
    sensor: &'static mut Sensor<'static>,
    detector: DetectorDriver,
    gyro: Gyro,
    magnetometer: Magnetometer,
    clock: Bridge,
    watch: Watch,
    bad_pixels: Defects<'static>,
    link: &'static mut Link,
    frames: FlashStore<Bridge>,
    tables: FlashStore<Bridge>,
    /// Seconds since a frame was kept.
    since_kept_s: u32,
    /// The mode of the last second.
    mode: Option<Mode>,
    /// The counter of the last second.
    local: LocalTime,
    /// Where a frame is made that nobody sends, and where what was kept is read.
    spare: &'static mut [u8; MAX_FRAME_BYTES],
}

/// What serves: files that were sent up, else those of the program.
struct Files {
    catalogue: Catalogue<'static>,
    calibration: Option<Calibration<'static>>,
    bad_pixels: Defects<'static>,
    /// The table that goes with them.
    parameters: Parameters,
}

impl Files {
    /// Those of the memory that open, and are of this detector.
    #[inline(never)]
    fn find(areas: &FlashAreas<Bridge>, kept: Option<Parameters>) -> Option<Self> {
        let sent_up = |area| board::memory().get(areas.serving(area)?);
        let mut parameters = kept.unwrap_or_else(parameters);
        let camera = parameters.camera;
        let size_px = [camera.width_px, camera.height_px];
        let catalogue = sent_up(Area::Catalogue).and_then(|bytes| Catalogue::open(bytes).ok());
        let calibration = sent_up(Area::Calibration).and_then(|bytes| Calibration::open(bytes).ok());
        let calibration = calibration.filter(|opened| opened.is_of(size_px, camera.optical_centre_px));
        let bad_pixels = sent_up(Area::BadPixels).and_then(|bytes| Defects::open(bytes).ok());
        parameters.imaging.calibration_crc = calibration.as_ref().map_or(0, Calibration::crc);
        Some(Self {
            catalogue: catalogue.or_else(|| Catalogue::open(CATALOGUE).ok())?,
            calibration,
            bad_pixels: bad_pixels
                .filter(|opened| opened.size_px() == size_px)
                .unwrap_or(Defects::none(size_px)),
            parameters,
        })
    }
}

/// What a store holds, of whatever age.
fn kept<'b>(store: &mut FlashStore<Bridge>, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    store.kept(buffer, i64::MAX, i64::MAX).ok()?
}

/// Goes on from a frame of before the restart, where there is one.
#[inline(never)]
fn resume(sensor: &mut Sensor, frame: Option<&[u8]>) {
    if let Some(before) = frame.and_then(|frame| telemetry::decode(frame).ok()) {
        sensor.resume(&before);
    }
}

impl Flight {
    /// All of it, once; `None` where something refuses.
    #[inline(never)]
    pub fn new(bridge: Bridge) -> Option<Self> {
        let areas = FlashAreas::new(bridge, AREAS)?;
        let mut frames = FlashStore::new(bridge, 0, SLOT_BYTES)?;
        let mut tables = FlashStore::new(bridge, TABLE_OFFSET, SLOT_BYTES)?;
        let spare = SPARE.try_take()?;
        let table = kept(&mut tables, spare).and_then(|table| Parameters::decode(table).ok());
        let table = table.filter(|table| table.check().is_ok());
        let Files { catalogue, calibration, bad_pixels, parameters } = Files::find(&areas, table)?;
        let (place, workspace) = (SENSOR.try_uninit()?, WORKSPACE.try_take()?);
        let sensor = Sensor::new_in(place, catalogue, parameters, calibration, workspace).ok()?;
        resume(sensor, kept(&mut frames, spare));
        let parts = Parts {
            spi: Spi,
            reset_n: Pin::RESET_N,
            frame_request: Pin::FRAME_REQUEST,
            delay: bridge,
            clock: bridge,
            port: Pixels,
        };
        // Bias, gain and PLL are those after reset; a board has the values of its detector's data sheet here.
        let settings = Settings { clock_hz: 10_000_000, outputs: Outputs::Four, rows: ROWS, analogue: &[] };
        let gyro = Lsm6dsv16x::new_i2c(bridge, GyroAddress::I2cAddL, bridge);
        let magnetometer = Lis2mdl::new_i2c(bridge, MagnetometerAddress::I2cAdd, bridge);
        Some(Self {
            sensor,
            detector: Cmv4000::new(parts, settings).ok()?,
            gyro: Lsm6dsv16xGyro::new(gyro, bridge, Mounting::ALIGNED),
            magnetometer: Lis2mdlMagnetometer::new(magnetometer, bridge, Mounting::ALIGNED),
            clock: bridge,
            watch: Watch::default(),
            bad_pixels,
            link: LINK.try_init(CommandLink::with_areas(APID, None, 0, areas))?,
            frames,
            tables,
            since_kept_s: 0,
            mode: None,
            local: LocalTime::default(),
            spare,
        })
    }

    /// Keeps what is to outlive a restart: the frame where it has an orbit and the last one is old, or where
    /// commanded safe begins or has ended; the table where a command may have changed it.
    #[inline(never)]
    fn keep(&mut self, report: &Report) {
        let instant_us = report.instant_us.unwrap_or_default();
        self.since_kept_s = self.since_kept_s.saturating_add(1);
        let old = self.since_kept_s >= KEEP_EVERY_S && report.orbit.is_some();
        let was_safe = self.mode.replace(report.mode).map(|mode| mode == Mode::CommandedSafe);
        let changed = was_safe.is_some_and(|safe| safe != (report.mode == Mode::CommandedSafe));
        if (old || changed)
            && let Ok(frame) = telemetry::encode(report, self.spare)
            && self.frames.keep(frame, instant_us).is_ok()
        {
            self.since_kept_s = 0;
        }
        let mut buffer = [0; MAX_TABLE_BYTES];
        if report.command == Some(CommandOutcome::Done)
            && let Ok(table) = self.sensor.parameters().encode(&mut buffer)
            && kept(&mut self.tables, self.spare).is_none_or(|before| before != table)
        {
            // What cannot be kept is as before after a restart.
            let _ = self.tables.keep(table, instant_us);
        }
    }

    /// Temperature of the magnetometer, deg C.
    pub fn temperature_c(&mut self) -> Option<f32> {
        self.magnetometer.temperature_c()
    }

    /// Hands the packet that came up to the link.
    #[inline(never)]
    fn receive(&mut self) {
        let mut buffer = [0; MAX_TELECOMMAND_BYTES];
        if let Some(packet) = board::receive(&mut buffer) {
            // What was refused the link reports itself.
            let _ = self.link.receive(packet);
        }
    }

    /// Writes the link's next report, as of the last second, into `buffer`; its bytes, 0 where none waits.
    #[inline(never)]
    pub fn report(&mut self, buffer: &mut [u8; MAX_REPORT_BYTES]) -> usize {
        self.link.next_report(self.local, &self.sensor.downlink(), buffer).map_or(0, <[u8]>::len)
    }

    /// One second; its frame goes into `buffer`, whose used bytes are given.
    #[inline(never)]
    pub fn second(&mut self, buffer: &mut [u8]) -> usize {
        self.watch.second_begins();
        self.receive();
        let Ok(mut detector) = BadPixelDetector::new(&mut self.detector, self.bad_pixels) else { return 0 };
        let mut instruments = Instruments {
            detector: &mut detector,
            clock: &mut self.clock,
            meter: &mut self.watch,
            rate_sensor: &mut self.gyro,
            magnetometer: &mut self.magnetometer,
            shutter: &mut (),
        };
        let report = self.sensor.cycle(&mut instruments, self.link.command());
        self.link.conclude(report.command);
        self.link.log(report.cycle, &report.events);
        self.link.check_area(self.sensor.parameters());
        self.local = LocalTime::from_us(report.local_us);
        self.keep(&report);
        self.watch.second_ends();
        telemetry::encode(&report, buffer).map_or(0, <[u8]>::len)
    }
}
