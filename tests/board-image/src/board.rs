//! The board of the example: an FPGA on the processor's memory bus, which receives the detector's LVDS lines
//! into its frame memory and has engines for SPI, I2C and the downlink. Replace this file with your board's.
//!
//! | offset | register, 32 bits |
//! |---|---|
//! | 0x00 | pins: bit 0 SYS_RES_N, bit 1 FRAME_REQ |
//! | 0x04 | SPI: bits 0 to 7 a byte to send, then the byte that came; bit 8 select; bit 31 busy |
//! | 0x08 | I2C: bits 0 to 7 a byte; 8 start, 9 stop, 10 read, 11 acknowledge; then 30 refused, 31 busy |
//! | 0x0C | pixel port: pixels to wait for, starts the receiver |
//! | 0x10 | pixels that came; bit 31 the frame has ended |
//! | 0x14, 0x18 | counter, us since power-on, low and high; reading the low half latches the high one |
//! | 0x1C, 0x20 | Terrestrial Time less the counter, us; 0: not known |
//! | 0x24 | downlink: a byte to send; bit 31 full |
//! | 0x28 to 0x34 | housekeeping: field along x, y, z and temperature, as f32 |
//! | 0x38 | uplink: bytes left of the packet that came, 0: none |
//! | 0x3C | uplink: its next byte |
//! | 0x40 | watchdog: a write serves it; 2 s after the last one the board is reset |
//!
//! Frame memory and 1 MiB of MRAM are mapped behind them.

use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::i2c::{self, I2c, NoAcknowledgeSource};
use embedded_hal::spi::{self, SpiDevice};
use embedded_storage::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};
use fsw_drivers::{MappedFlash, PixelPort};
use fsw_hal::{Clock, ClockError, ErrorType, LocalTime, Stage, StageMeter};

/// Clock of the processor, Hz.
pub const CORE_HZ: u32 = 168_000_000;
/// Pixels in the frame memory: 2048 rows of 2048.
pub const FRAME_MEMORY_PX: usize = 2048 * 2048;

const REGISTERS: usize = 0x6000_0000;
const FRAME_MEMORY: usize = 0x6100_0000;
const MRAM: usize = 0x6200_0000;
const MRAM_BYTES: usize = 1024 * 1024;

const BUSY: u32 = 1 << 31;
/// An engine is looked at so often: longer than any byte takes.
const LOOKS: u32 = 100_000;

fn read(offset: usize) -> u32 {
    // SAFETY: the FPGA's registers are mapped here, aligned, and nothing else is.
    unsafe { ((REGISTERS + offset) as *const u32).read_volatile() }
}

fn write(offset: usize, value: u32) {
    // SAFETY: as above.
    unsafe { ((REGISTERS + offset) as *mut u32).write_volatile(value) }
}

/// Gives a word to an engine and waits for its answer.
fn engine(offset: usize, word: u32) -> Option<u32> {
    write(offset, word);
    (0..LOOKS).map(|_| read(offset)).find(|answer| answer & BUSY == 0)
}

/// Hands a byte to the downlink; whether it had room.
pub fn send(byte: u8) -> bool {
    let room = read(0x24) & BUSY == 0;
    if room {
        write(0x24, byte.into());
    }
    room
}

/// The packet that came up since the last call, in `buffer`; `None` where none came, or one that is longer.
pub fn receive(buffer: &mut [u8]) -> Option<&[u8]> {
    let length = read(0x38) as usize;
    // What is not taken is not to stand before the next one.
    let taken = buffer.len();
    for at in 0..length {
        let byte = read(0x3C) as u8;
        buffer.get_mut(at).into_iter().for_each(|place| *place = byte);
    }
    (1..=taken).contains(&length).then_some(())?;
    buffer.get(..length)
}

/// The MRAM as it is now.
pub fn memory() -> &'static [u8] {
    // SAFETY: the MRAM is mapped here. What is lent for longer than a call are files that serve, and nothing
    // writes to these (`FlashAreas`).
    unsafe { core::slice::from_raw_parts(MRAM as *const u8, MRAM_BYTES) }
}

/// Shows the magnetometer's temperature, deg C; not a number where it gave none.
pub fn housekeeping(temperature_c: Option<f32>) {
    write(0x34, temperature_c.unwrap_or(f32::NAN).to_bits());
}

/// The watchdog, served as each stage of a second begins, and how long the second before took.
#[derive(Default)]
pub struct Watch {
    /// When the second that runs or ran last began, us of the counter.
    begun_us: i64,
    overran: bool,
}

impl Watch {
    /// Longest second, us: the next one begins after 1 s.
    const LONGEST_US: i64 = 950_000;

    /// A second begins.
    pub fn second_begins(&mut self) {
        write(0x40, 1);
        self.begun_us = two_words(0x14);
    }

    /// It has ended.
    pub fn second_ends(&mut self) {
        self.overran = two_words(0x14) - self.begun_us > Self::LONGEST_US;
    }
}

impl StageMeter for Watch {
    fn begin(&mut self, _: Stage) {
        write(0x40, 1);
    }

    fn end(&mut self, _: Stage) {}

    fn overran(&mut self) -> bool {
        self.overran
    }
}

/// Nothing can be flown: the watchdog, which nobody serves now, restarts the board.
pub fn give_up() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

/// An engine did not answer.
#[derive(Clone, Copy, Debug)]
pub struct Silent;

impl spi::Error for Silent {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

/// The detector's bus.
pub struct Spi;

impl Spi {
    fn byte(byte: u8) -> Result<u8, Silent> {
        engine(0x04, 1 << 8 | u32::from(byte)).map(|answer| answer as u8).ok_or(Silent)
    }
}

impl spi::ErrorType for Spi {
    type Error = Silent;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Silent> {
        let done = operations.iter_mut().try_for_each(|operation| match operation {
            spi::Operation::Read(bytes) => bytes.iter_mut().try_for_each(|byte| {
                *byte = Self::byte(0)?;
                Ok(())
            }),
            spi::Operation::Write(bytes) => bytes.iter().try_for_each(|byte| Self::byte(*byte).map(drop)),
            spi::Operation::Transfer(read, written) => {
                for at in 0..read.len().max(written.len()) {
                    let came = Self::byte(written.get(at).copied().unwrap_or(0))?;
                    read.get_mut(at).into_iter().for_each(|byte| *byte = came);
                }
                Ok(())
            }
            spi::Operation::TransferInPlace(bytes) => bytes.iter_mut().try_for_each(|byte| {
                *byte = Self::byte(*byte)?;
                Ok(())
            }),
            spi::Operation::DelayNs(ns) => {
                Bridge.delay_ns(*ns);
                Ok(())
            }
        });
        write(0x04, 0);
        done
    }
}

/// A pin of the detector, by its bit.
pub struct Pin(u32);

impl Pin {
    /// SYS_RES_N.
    pub const RESET_N: Self = Self(1);
    /// FRAME_REQ.
    pub const FRAME_REQUEST: Self = Self(2);
}

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        write(0x00, read(0x00) & !self.0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        write(0x00, read(0x00) | self.0);
        Ok(())
    }
}

/// The receiver of the detector's lines with its frame memory.
pub struct Pixels;

impl PixelPort for Pixels {
    type Error = Silent;

    fn start(&mut self, pixels: usize) -> Result<(), Silent> {
        if pixels > FRAME_MEMORY_PX {
            return Err(Silent);
        }
        write(0x0C, pixels as u32);
        Ok(())
    }

    fn wait(&mut self, timeout_us: u32) -> Result<Option<usize>, Silent> {
        let mut bridge = Bridge;
        let ended = (0..timeout_us / 10 + 1).find_map(|_| {
            let came = read(0x10);
            bridge.delay_us(10);
            (came & BUSY != 0).then_some((came & !BUSY) as usize)
        });
        if ended.is_none() {
            write(0x0C, 0);
        }
        Ok(ended)
    }

    fn lend(&mut self, first: usize, count: usize) -> Result<&[u16], Silent> {
        if first.checked_add(count).is_none_or(|end| end > FRAME_MEMORY_PX) {
            return Err(Silent);
        }
        let start = (FRAME_MEMORY as *const u16).wrapping_add(first);
        // SAFETY: the frame memory is mapped here, and the range lies in it. The receiver writes into it
        // between `start` and the end of `wait` alone, while nothing is lent: both need `&mut self`.
        Ok(unsafe { core::slice::from_raw_parts(start, count) })
    }
}

/// The rest of the board: I2C, delay, clock, MRAM. A handle; each call is whole, so many may exist.
#[derive(Clone, Copy)]
pub struct Bridge;

impl DelayNs for Bridge {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay(((u64::from(ns) * u64::from(CORE_HZ)).div_ceil(1_000_000_000)) as u32);
    }
}

impl ErrorType for Bridge {
    type Error = ClockError;
}

fn two_words(offset: usize) -> i64 {
    let low = read(offset);
    (u64::from(read(offset + 4)) << 32 | u64::from(low)) as i64
}

impl Clock for Bridge {
    fn local_time(&mut self) -> Result<LocalTime, ClockError> {
        Ok(LocalTime::from_us(two_words(0x14)))
    }

    fn terrestrial_us(&mut self, at: LocalTime) -> Result<i64, ClockError> {
        match two_words(0x1C) {
            0 => Err(ClockError::NotSynchronised),
            offset_us => Ok(at.as_us().saturating_add(offset_us)),
        }
    }
}

impl i2c::ErrorType for Bridge {
    type Error = i2c::ErrorKind;
}

const START: u32 = 1 << 8;
const STOP: u32 = 1 << 9;
const READ: u32 = 1 << 10;
const ACKNOWLEDGE: u32 = 1 << 11;
const REFUSED: u32 = 1 << 30;

fn i2c_byte(word: u32) -> Result<u8, i2c::ErrorKind> {
    match engine(0x08, word) {
        Some(answer) if answer & REFUSED != 0 => {
            Err(i2c::ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown))
        }
        Some(answer) => Ok(answer as u8),
        None => Err(i2c::ErrorKind::Bus),
    }
}

impl I2c for Bridge {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [i2c::Operation<'_>],
    ) -> Result<(), i2c::ErrorKind> {
        let done = operations.iter_mut().try_for_each(|operation| match operation {
            i2c::Operation::Write(bytes) => {
                i2c_byte(START | u32::from(address) << 1)?;
                bytes.iter().try_for_each(|byte| i2c_byte(u32::from(*byte)).map(drop))
            }
            i2c::Operation::Read(bytes) => {
                i2c_byte(START | u32::from(address) << 1 | 1)?;
                let last = bytes.len().saturating_sub(1);
                for (at, byte) in bytes.iter_mut().enumerate() {
                    *byte = i2c_byte(READ | if at < last { ACKNOWLEDGE } else { 0 })?;
                }
                Ok(())
            }
        });
        let stopped = i2c_byte(STOP).map(drop);
        done.and(stopped)
    }
}

impl nor_flash::ErrorType for Bridge {
    type Error = NorFlashErrorKind;
}

/// The bytes of a range of the MRAM.
fn mram(offset: u32, length: usize) -> Result<*mut u8, NorFlashErrorKind> {
    let end = (offset as usize).checked_add(length);
    match end.is_some_and(|end| end <= MRAM_BYTES) {
        true => Ok((MRAM as *mut u8).wrapping_add(offset as usize)),
        false => Err(NorFlashErrorKind::OutOfBounds),
    }
}

impl ReadNorFlash for Bridge {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let start = mram(offset, bytes.len())?;
        for (at, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: the MRAM is mapped here and the range lies in it.
            *byte = unsafe { start.wrapping_add(at).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        MRAM_BYTES
    }
}

impl MappedFlash for Bridge {
    fn mapped(&self) -> &[u8] {
        memory()
    }
}

/// MRAM needs no erasing; it is written with ones, so that it reads as a flash would.
impl NorFlash for Bridge {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = 64;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let length = to.checked_sub(from).ok_or(NorFlashErrorKind::OutOfBounds)?;
        let start = mram(from, length as usize)?;
        for at in 0..length as usize {
            // SAFETY: as above.
            unsafe { start.wrapping_add(at).write_volatile(0xFF) };
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let start = mram(offset, bytes.len())?;
        for (at, byte) in bytes.iter().enumerate() {
            // SAFETY: as above.
            unsafe { start.wrapping_add(at).write_volatile(*byte) };
        }
        Ok(())
    }
}
