//! The sensor with its instruments: one call a second, and an orbit that outlives a warm restart.
//!
//! Kept every [`KEEP_EVERY_S`] seconds is the telemetry frame itself: it has the orbit with its sigmas and a
//! CRC of its own. After a restart the frame that was kept last gives the orbit, if it is young enough, in
//! the second after the first one that knew Terrestrial Time; the attitude is found in the sky within
//! seconds anyway.

use crate::board::{Bridge, FRAME_MEMORY_PX, Pin, Pixels, Spi};
use crate::instrument::{CATALOGUE, ROWS, parameters};
use fsw_core::catalog::Catalogue;
use fsw_core::command::GroundOrbit;
use fsw_core::sensor::{Command, Instruments, Sensor, Workspace};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES};
use fsw_drivers::cmv4000::{Outputs, Parts, SIZE_PX, Settings};
use fsw_drivers::lis2mdl_rs::blocking::{I2CAddress as MagnetometerAddress, Lis2mdl};
use fsw_drivers::lsm6dsv16x_rs::blocking::{I2CAddress as GyroAddress, Lsm6dsv16x};
use fsw_drivers::st_mems_bus::blocking::i2c::I2cBus;
use fsw_drivers::{Cmv4000, FlashStore, Lis2mdlMagnetometer, Lsm6dsv16xGyro, Mounting};
use fsw_hal::StateStore;
use static_cell::{ConstStaticCell, StaticCell};

static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static SENSOR: StaticCell<Sensor<'static>> = StaticCell::new();
static SPARE: ConstStaticCell<[u8; MAX_FRAME_BYTES]> = ConstStaticCell::new([0; MAX_FRAME_BYTES]);

const _: () = assert!(SIZE_PX as usize * ROWS.1 as usize <= FRAME_MEMORY_PX);
/// Two slots of so many bytes at the begin of the non-volatile memory.
const SLOT_BYTES: usize = 4096;
const _: () = assert!(MAX_FRAME_BYTES + 24 <= SLOT_BYTES);
/// Between two records, s.
const KEEP_EVERY_S: u32 = 600;
/// Oldest orbit that is begun with, us: what the flight code takes from the ground, 100 minutes.
const MAX_AGE_US: i64 = 100 * 60 * 1_000_000;

type DetectorDriver = Cmv4000<'static, Spi, Pin, Pin, Bridge, Bridge, Pixels>;
type Gyro = Lsm6dsv16xGyro<I2cBus<Bridge>, Bridge, Bridge>;
type Magnetometer = Lis2mdlMagnetometer<I2cBus<Bridge>, Bridge, Bridge>;

/// What a second needs.
pub struct Flight {
    sensor: &'static mut Sensor<'static>,
    detector: DetectorDriver,
    gyro: Gyro,
    magnetometer: Magnetometer,
    clock: Bridge,
    store: FlashStore<Bridge>,
    /// Seconds since a record was kept.
    since_kept_s: u32,
    /// Whether the orbit of before the restart is still to be asked for.
    restarted: bool,
    /// Terrestrial Time of the last second, us, where it was known.
    instant_us: Option<i64>,
    /// Where a frame is made that nobody sends, and where the record of before the restart is read.
    spare: &'static mut [u8; MAX_FRAME_BYTES],
}

impl Flight {
    /// All of it, once; `None` where something refuses.
    #[inline(never)]
    pub fn new(bridge: Bridge) -> Option<Self> {
        let catalogue = Catalogue::open(CATALOGUE).ok()?;
        let (place, workspace) = (SENSOR.try_uninit()?, WORKSPACE.try_take()?);
        let sensor = Sensor::new_in(place, catalogue, parameters(), None, workspace).ok()?;
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
            store: FlashStore::new(bridge, 0, SLOT_BYTES)?,
            since_kept_s: 0,
            restarted: true,
            instant_us: None,
            spare: SPARE.try_take()?,
        })
    }

    /// The orbit of before the restart, once, as soon as the sensor knows Terrestrial Time.
    #[inline(never)]
    fn orbit_of_before(&mut self) -> Option<GroundOrbit> {
        let now_us = self.instant_us.filter(|_| self.restarted)?;
        self.restarted = false;
        let record = self.store.kept(self.spare, now_us, MAX_AGE_US).ok()??;
        telemetry::decode(record).ok()?.ground_orbit()
    }

    /// Temperature of the magnetometer, deg C.
    pub fn temperature_c(&mut self) -> Option<f32> {
        self.magnetometer.temperature_c()
    }

    /// One second; its frame goes into `buffer`, whose used bytes are given.
    #[inline(never)]
    pub fn second(&mut self, buffer: &mut [u8]) -> usize {
        let command = self.orbit_of_before().map_or(Command::Continue, Command::Orbit);
        let mut instruments = Instruments {
            detector: &mut self.detector,
            clock: &mut self.clock,
            meter: &mut (),
            rate_sensor: &mut self.gyro,
            magnetometer: &mut self.magnetometer,
            shutter: &mut (),
        };
        let report = self.sensor.cycle(&mut instruments, command);
        self.instant_us = report.instant_us;
        self.since_kept_s = self.since_kept_s.saturating_add(1);
        if let (Some(instant_us), Some(_), KEEP_EVERY_S..) =
            (report.instant_us, report.orbit, self.since_kept_s)
            && let Ok(record) = telemetry::encode(&report, self.spare)
            && self.store.keep(record, instant_us).is_ok()
        {
            self.since_kept_s = 0;
        }
        telemetry::encode(&report, buffer).map_or(0, <[u8]>::len)
    }
}
