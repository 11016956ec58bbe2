//! Detector CMV4000 of ams OSRAM (CMOSIS): 2048 x 2048 px of 5.5 um, global shutter, 10 bits.
//!
//! In: a window of rows, the clock, the board's analogue settings. Out: the [`Detector`] of `fsw-hal`.
//!
//! Data sheet: "CMV4000, Global Shutter CMOS Image Sensor for Machine Vision", ams OSRAM DS000728, v6-00,
//! 2023-08-04 (before: CMOSIS, CMV4000-datasheet-v2.13, 2014): start-up, frame request, readout and exposure
//! in section 6, "Functional description"; addresses in its register description. The addresses, the word on
//! the bus and the formulas below were compared with three public programs for the same register map (CMV2000
//! and CMV4000), not with the sheet's own tables: the camera of the ufo-kit (addresses), `pyspex` for SPEXone
//! in orbit (exposure, readout, outputs, PLL), the payload of EagleSat-2 (bus, start-up, readout). Compare
//! them with the sheet of your part before it has power.
//!
//! | address | register | written here |
//! |---|---|---|
//! | 1, 2 | `number_lines`, rows of a frame | the window |
//! | 3, 4 | `start1`, first row | the window |
//! | 40 | `image_flipping` | 0: none |
//! | 41 | `inte_sync`, `exp_dual`, `exp_ext` | 0: exposure by its own sequencer |
//! | 42 to 44 | `exp_time`, row times | each exposure |
//! | 70, 71 | `number_frames` a request | 1 |
//! | 72 | `output_mode` | 16, 8, 4 or 2 LVDS outputs |
//! | 73 | `fot_length` | read only: it is part of the exposure |
//! | 111, 112 | `bit_mode`, `adc_resolution` | 1, 0: 10 bits |
//!
//! Numbers of several bytes begin with the lowest. Bias currents, voltages, gain, offset and the PLL depend
//! on the clock, the version of the part and its calibration: they are the board's table
//! [`Settings::analogue`], after the data sheet's recommended values; none is built in.
//!
//! - **SPI**: mode 0, SPI_EN active high (give the chip select an inverting pin), 16 bits a register: 1 for a
//!   write, 7 of address, 8 of value. Before each frame all registers that were written are read back and
//!   compared.
//! - **Exposure** lasts `129 (0.43 fot_length + exp_time)` clocks, a row time being 129 clocks with 16
//!   outputs; set to the nearest `exp_time`, so within 65 clocks (6.5 us at 10 MHz) of what was asked. Its
//!   middle is half of it after the request's rising edge; what the sequencer itself waits before it begins
//!   is not known and not corrected.
//! - **Windows**: the detector reads rows whole, a window of them once. The windows that the flight code
//!   reads of an image are not known when it is taken, so the frame goes to a frame memory ([`PixelPort`]),
//!   and they are read there. [`Settings::rows`] keeps out the rows that the optics do not light: they cost no
//!   transfer and no memory, and row 0 of the geometry is the first of the window.
//! - **Failures**: an image that failed is gone; the next exposure begins with a reset and all registers.

mod error;
mod registers;
#[cfg(test)]
mod tests;
mod timing;

pub mod simulated;

pub use error::{Error, SettingsError};
pub use timing::{EXPOSURE_MAX, Outputs};

use crate::pixel_port::PixelPort;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use fsw_hal::{Clock, Detector, DetectorGeometry, Error as _, ErrorType, LocalTime, Window};
use timing::Timing;

/// Rows and columns of the pixel array.
pub const SIZE_PX: u16 = 2048;
/// Range of the input clock, Hz.
pub const CLOCK_HZ: core::ops::RangeInclusive<u32> = 5_000_000..=48_000_000;

/// SYS_RES_N is held low so long, and the registers are left alone so long after it: at least 1 us each.
const RESET_US: u32 = 10;
/// From an upload of registers to the first frame: 7 to 20 ms where it changes the gain of the converters.
const SETTLE_MS: u32 = 20;
/// Length of FRAME_REQ: at least a clock, 0.2 us at 5 MHz.
const REQUEST_US: u32 = 1;
/// Waited for a frame at most, over its expected end, in percent of exposure and readout.
const PATIENCE_PERCENT: u64 = 25;

/// What a board decides.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'s> {
    /// Frequency of CLK_IN, Hz, in [`CLOCK_HZ`].
    pub clock_hz: u32,
    /// LVDS outputs that the receiver reads.
    pub outputs: Outputs,
    /// First row that is read and number of rows.
    pub rows: (u16, u16),
    /// Addresses and values written after each reset, in this order: bias, gain, offset, PLL. None of those
    /// that the driver writes itself.
    pub analogue: &'s [(u8, u8)],
}

/// What a board gives to the driver.
#[derive(Debug)]
pub struct Parts<S, R, F, D, C, P> {
    /// The registers' bus.
    pub spi: S,
    /// SYS_RES_N.
    pub reset_n: R,
    /// FRAME_REQ.
    pub frame_request: F,
    /// A delay.
    pub delay: D,
    /// A handle of the board's clock.
    pub clock: C,
    /// What takes the pixels in.
    pub port: P,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Image {
    None,
    /// Middle of its exposure, and how long to wait for it, us.
    Begun(LocalTime, u32),
    /// Middle of its exposure.
    Taken(LocalTime),
}

/// The detector.
#[derive(Debug)]
pub struct Cmv4000<'s, S, R, F, D, C, P> {
    parts: Parts<S, R, F, D, C, P>,
    settings: Settings<'s>,
    /// `None`: not started since power-on or since a failure.
    timing: Option<Timing>,
    image: Image,
}

type Failure<S, R, P> = Error<
    <S as embedded_hal::spi::ErrorType>::Error,
    <R as embedded_hal::digital::ErrorType>::Error,
    <P as PixelPort>::Error,
>;

impl<'s, S, R, F, D, C, P> Cmv4000<'s, S, R, F, D, C, P>
where
    S: SpiDevice,
    R: OutputPin,
    F: OutputPin<Error = R::Error>,
    D: DelayNs,
    C: Clock,
    P: PixelPort,
{
    /// A detector that is started with its first exposure.
    ///
    /// # Errors
    /// Settings that the detector cannot do.
    pub fn new(parts: Parts<S, R, F, D, C, P>, settings: Settings<'s>) -> Result<Self, SettingsError> {
        let (first, count) = settings.rows;
        if !CLOCK_HZ.contains(&settings.clock_hz) {
            return Err(SettingsError::Clock);
        }
        if count == 0 || u32::from(first) + u32::from(count) > u32::from(SIZE_PX) {
            return Err(SettingsError::Rows);
        }
        if settings.analogue.iter().any(|(address, _)| !registers::is_analogue(*address)) {
            return Err(SettingsError::Analogue);
        }
        Ok(Self { parts, settings, timing: None, image: Image::None })
    }

    /// What the board gave.
    pub fn release(self) -> Parts<S, R, F, D, C, P> {
        self.parts
    }

    fn write(&mut self, registers: impl Iterator<Item = (u8, u8)>) -> Result<(), Failure<S, R, P>> {
        for (address, value) in registers {
            self.parts.spi.write(&registers::write(address, value)).map_err(Error::Spi)?;
        }
        Ok(())
    }

    fn register(&mut self, address: u8) -> Result<u8, Failure<S, R, P>> {
        let mut bytes = registers::read(address);
        self.parts.spi.transfer_in_place(&mut bytes).map_err(Error::Spi)?;
        let [_, value] = bytes;
        Ok(value)
    }

    /// Reads back what was written.
    fn compare(&mut self, registers: impl Iterator<Item = (u8, u8)>) -> Result<(), Failure<S, R, P>> {
        for (address, wrote) in registers {
            let read = self.register(address)?;
            if read != wrote {
                return Err(Error::Readback { address, wrote, read });
            }
        }
        Ok(())
    }

    /// All registers but the exposure's.
    fn fixed_registers(&self) -> impl Iterator<Item = (u8, u8)> + use<'s, S, R, F, D, C, P> {
        let Settings { outputs, rows, analogue, .. } = self.settings;
        analogue.iter().copied().chain(registers::of_frame(rows, outputs.mode()))
    }

    /// Reset, and all registers but the exposure's.
    fn start(&mut self) -> Result<Timing, Failure<S, R, P>> {
        self.parts.reset_n.set_low().map_err(Error::Pin)?;
        self.parts.frame_request.set_low().map_err(Error::Pin)?;
        self.parts.delay.delay_us(RESET_US);
        self.parts.reset_n.set_high().map_err(Error::Pin)?;
        self.parts.delay.delay_us(RESET_US);
        self.write(self.fixed_registers())?;
        let fot_length = self.register(registers::FOT_LENGTH)?;
        self.parts.delay.delay_ms(SETTLE_MS);
        let Settings { clock_hz, outputs, rows: (_, rows), .. } = self.settings;
        Ok(Timing { clock_hz, outputs, rows, fot_length })
    }

    fn pixels(&self) -> usize {
        self.geometry().whole().area()
    }

    fn request(&mut self, exposure_us: u32) -> Result<Image, Failure<S, R, P>> {
        let timing = match self.timing {
            Some(timing) => timing,
            None => self.start()?,
        };
        self.timing = Some(timing);
        let units = timing.exposure_units(exposure_us).ok_or(Error::Exposure)?;
        self.write(registers::of_exposure(units))?;
        self.compare(self.fixed_registers().chain(registers::of_exposure(units)))?;
        self.parts.port.start(self.pixels()).map_err(Error::Port)?;
        let clock = self.parts.clock.local_time();
        let requested = clock.map_err(|error| Error::Clock(error.kind()))?;
        self.parts.frame_request.set_high().map_err(Error::Pin)?;
        self.parts.delay.delay_us(REQUEST_US);
        self.parts.frame_request.set_low().map_err(Error::Pin)?;
        let exposure_us = timing.exposure_us(units);
        let expected_us = exposure_us.saturating_add(timing.readout_us());
        let patience_us = expected_us.saturating_mul(100 + PATIENCE_PERCENT) / 100;
        let middle = requested.plus_us((exposure_us / 2) as i64);
        Ok(Image::Begun(middle, u32::try_from(patience_us).unwrap_or(u32::MAX)))
    }

    fn receive(&mut self) -> Result<LocalTime, Failure<S, R, P>> {
        let (middle, patience_us) = match self.image {
            Image::None => return Err(Error::NotExposed),
            Image::Taken(middle) => return Ok(middle),
            Image::Begun(middle, patience_us) => (middle, patience_us),
        };
        match self.parts.port.wait(patience_us).map_err(Error::Port)? {
            None => Err(Error::NoFrame),
            Some(came) if came == self.pixels() => Ok(middle),
            Some(came) => Err(Error::Short { came, expected: self.pixels() }),
        }
    }

    fn copy(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), Failure<S, R, P>> {
        let (width, columns) = (usize::from(SIZE_PX), usize::from(window.width));
        let expected = columns;
        for (row, line) in (usize::from(window.y)..).zip(pixels.chunks_exact_mut(columns.max(1))) {
            let lent = self.parts.port.lend(row * width + usize::from(window.x), columns);
            let lent = lent.map_err(Error::Port)?;
            if lent.len() != expected {
                return Err(Error::Short { came: lent.len(), expected });
            }
            line.iter_mut().zip(lent).for_each(|(pixel, came)| *pixel = *came);
        }
        Ok(())
    }

    /// After a failure of the hardware nothing of the image is left, and the detector is to be started anew.
    fn concluded<T>(&mut self, result: Result<T, Failure<S, R, P>>) -> Result<T, Failure<S, R, P>> {
        if result.as_ref().is_err_and(Error::is_of_hardware) {
            self.timing = None;
            self.image = Image::None;
        }
        result
    }
}

impl<S, R, F, D, C, P> ErrorType for Cmv4000<'_, S, R, F, D, C, P>
where
    S: SpiDevice,
    R: OutputPin,
    P: PixelPort,
{
    type Error = Failure<S, R, P>;
}

impl<S, R, F, D, C, P> Detector for Cmv4000<'_, S, R, F, D, C, P>
where
    S: SpiDevice,
    R: OutputPin,
    F: OutputPin<Error = R::Error>,
    D: DelayNs,
    C: Clock,
    P: PixelPort,
{
    fn geometry(&self) -> DetectorGeometry {
        DetectorGeometry { width_px: SIZE_PX, height_px: self.settings.rows.1, bits: 10 }
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), Self::Error> {
        let begun = self.request(exposure_us);
        self.image = self.concluded(begun)?;
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, Self::Error> {
        let received = self.receive();
        let middle = self.concluded(received)?;
        self.image = Image::Taken(middle);
        Ok(middle)
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), Self::Error> {
        if !window.fits(&self.geometry()) {
            return Err(Error::OutsideDetector);
        }
        if pixels.len() != window.area() {
            return Err(Error::BufferLength);
        }
        if !matches!(self.image, Image::Taken(_)) {
            return Err(Error::NotExposed);
        }
        let copied = self.copy(window, pixels);
        self.concluded(copied)
    }
}
