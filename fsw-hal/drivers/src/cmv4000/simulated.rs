//! A CMV4000 behind its bus, for the ground: no flight program links it.
//!
//! In: what the optics throw on the detector (any [`Detector`] of the detector's size), the frequency of its
//! clock. Out: the handles that a board would give to the driver: bus, pins, pixel port. It decodes the words
//! on the bus into registers that begin with the data sheet's defaults, and takes a frame at the rising edge
//! of FRAME_REQ, of the rows and with the exposure that the registers hold then.
//!
//! What it does not know: the analogue settings' effect, and the time that anything takes.

use super::SIZE_PX;
use crate::pixel_port::PixelPort;
use core::cell::RefCell;
use core::convert::Infallible;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use fsw_hal::{Detector, Window};

/// Registers that are not 0 after a reset, of those that the driver knows.
const DEFAULTS: [(usize, u8); 7] = [(2, 8), (39, 1), (43, 8), (70, 1), (73, 10), (111, 1), (115, 1)];

/// What cannot happen to the real part, or is not simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A word was not 16 bits, or its operation is not one of the driver's.
    Word,
    /// The frame is larger than the memory, or none was asked for.
    Frame,
    /// The window of rows leaves the detector.
    Rows,
    /// What the optics throw on the detector could not be had.
    Source,
}

impl spi::Error for Fault {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

#[derive(Debug)]
struct Chip<D> {
    source: D,
    clock_hz: u32,
    registers: [u8; 128],
    running: bool,
    requested: bool,
    /// Pixels that the port waits for.
    armed: Option<usize>,
    /// The frame that was taken.
    frame: Option<Result<Window, Fault>>,
}

impl<D: Detector> Chip<D> {
    fn reset(&mut self) {
        self.registers = [0; 128];
        for (address, value) in DEFAULTS {
            if let Some(register) = self.registers.get_mut(address) {
                *register = value;
            }
        }
    }

    fn number<const N: usize>(&self, address: usize) -> u32 {
        let bytes = self.registers.iter().skip(address).take(N);
        bytes.rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
    }

    /// One word; the value that the part answers with.
    fn word(&mut self, command: u8, value: u8) -> u8 {
        let register = self.registers.get_mut(usize::from(command & 0x7F));
        match register {
            Some(register) if self.running => {
                if command & 0x80 != 0 {
                    *register = value;
                }
                *register
            }
            _ => 0,
        }
    }

    /// Length of the exposure that the registers hold, us.
    fn exposure_us(&self) -> u32 {
        let hundredths = 43 * u64::from(self.number::<1>(73)) + 100 * u64::from(self.number::<3>(42));
        (129 * hundredths * 10_000 / u64::from(self.clock_hz).max(1)) as u32
    }

    fn expose(&mut self) {
        let (first, count) = (self.number::<2>(3) as u16, self.number::<2>(1) as u16);
        let rows = Window { x: 0, y: first, width: SIZE_PX, height: count };
        let exposure_us = self.exposure_us();
        self.frame = Some(match rows.fits(&self.source.geometry()) {
            false => Err(Fault::Rows),
            true => self.source.expose(exposure_us).map(|_| rows).map_err(|_| Fault::Source),
        });
    }
}

/// The part.
#[derive(Debug)]
pub struct Simulated<D>(RefCell<Chip<D>>);

impl<D: Detector> Simulated<D> {
    /// A part without power.
    pub fn new(source: D, clock_hz: u32) -> Self {
        Self(RefCell::new(Chip {
            source,
            clock_hz,
            registers: [0; 128],
            running: false,
            requested: false,
            armed: None,
            frame: None,
        }))
    }

    /// Its bus.
    pub fn spi(&self) -> Spi<'_, D> {
        Spi(self)
    }

    /// Its pin SYS_RES_N.
    pub fn reset_n(&self) -> ResetN<'_, D> {
        ResetN(self)
    }

    /// Its pin FRAME_REQ.
    pub fn frame_request(&self) -> FrameRequest<'_, D> {
        FrameRequest(self)
    }

    /// What takes its pixels in, with a memory for them.
    pub fn port<'s>(&'s self, memory: &'s mut [u16]) -> Port<'s, D> {
        Port { part: self, memory }
    }

    /// What a register holds; `None` beyond the last.
    pub fn register(&self, address: u8) -> Option<u8> {
        self.0.borrow().registers.get(usize::from(address)).copied()
    }

    /// Turns bits of a register, as an upset does.
    pub fn upset(&self, address: u8, bits: u8) {
        if let Some(register) = self.0.borrow_mut().registers.get_mut(usize::from(address)) {
            *register ^= bits;
        }
    }

    /// Looks at what throws the light.
    pub fn with_source<T>(&self, look: impl FnOnce(&mut D) -> T) -> T {
        look(&mut self.0.borrow_mut().source)
    }
}

/// The bus of a [`Simulated`] part.
#[derive(Debug)]
pub struct Spi<'s, D>(&'s Simulated<D>);

impl<D> spi::ErrorType for Spi<'_, D> {
    type Error = Fault;
}

impl<D: Detector> SpiDevice for Spi<'_, D> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Fault> {
        let mut chip = self.0.0.borrow_mut();
        for operation in operations {
            match operation {
                Operation::Write([command, value]) => {
                    chip.word(*command, *value);
                }
                Operation::TransferInPlace([command, value]) => *value = chip.word(*command, *value),
                _ => return Err(Fault::Word),
            }
        }
        Ok(())
    }
}

/// The pin SYS_RES_N of a [`Simulated`] part.
#[derive(Debug)]
pub struct ResetN<'s, D>(&'s Simulated<D>);

impl<D> digital::ErrorType for ResetN<'_, D> {
    type Error = Infallible;
}

impl<D: Detector> OutputPin for ResetN<'_, D> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        let mut chip = self.0.0.borrow_mut();
        chip.reset();
        (chip.running, chip.frame) = (false, None);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.0.borrow_mut().running = true;
        Ok(())
    }
}

/// The pin FRAME_REQ of a [`Simulated`] part.
#[derive(Debug)]
pub struct FrameRequest<'s, D>(&'s Simulated<D>);

impl<D> digital::ErrorType for FrameRequest<'_, D> {
    type Error = Infallible;
}

impl<D: Detector> OutputPin for FrameRequest<'_, D> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.0.borrow_mut().requested = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        let mut chip = self.0.0.borrow_mut();
        if chip.running && !chip.requested {
            chip.expose();
        }
        chip.requested = true;
        Ok(())
    }
}

/// The pixel port of a [`Simulated`] part.
#[derive(Debug)]
pub struct Port<'s, D> {
    part: &'s Simulated<D>,
    memory: &'s mut [u16],
}

impl<D: Detector> PixelPort for Port<'_, D> {
    type Error = Fault;

    fn start(&mut self, pixels: usize) -> Result<(), Fault> {
        let fits = pixels <= self.memory.len();
        self.part.0.borrow_mut().armed = fits.then_some(pixels);
        if fits { Ok(()) } else { Err(Fault::Frame) }
    }

    fn wait(&mut self, _: u32) -> Result<Option<usize>, Fault> {
        let mut chip = self.part.0.borrow_mut();
        let armed = chip.armed.take().ok_or(Fault::Frame)?;
        let Some(frame) = chip.frame.take() else { return Ok(None) };
        let rows = frame?;
        // The receiver's DMA ends with its last pixel, whatever else comes.
        let lines = self.memory.get_mut(..armed).unwrap_or(&mut []).chunks_exact_mut(usize::from(SIZE_PX));
        let mut came = 0;
        for (row, line) in (rows.y..rows.y + rows.height).zip(lines) {
            let read = chip.source.read(Window { y: row, height: 1, ..rows }, line);
            read.map_err(|_| Fault::Source)?;
            came += line.len();
        }
        Ok(Some(came))
    }

    fn lend(&mut self, first: usize, count: usize) -> Result<&[u16], Fault> {
        self.memory.get(first..).and_then(|rest| rest.get(..count)).ok_or(Fault::Frame)
    }
}
