//! A part with registers on an I2C bus, for tests: what was on the bus is remembered, a transaction can fail.

pub(crate) mod flash;

use core::cell::{Cell, RefCell};
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use fsw_hal::{Clock, ClockError, LocalTime};
use std::collections::VecDeque;
use std::vec::Vec;

/// What was on the bus: bytes written, and those read after them.
pub(crate) type Transfer = (Vec<u8>, Vec<u8>);

/// The part and its board.
pub(crate) struct Board {
    address: u8,
    registers: RefCell<[u8; 256]>,
    /// What the part does to its registers after one was written, or before one is read.
    reaction: fn(&Board, &mut [u8; 256], u8, Access),
    /// Samples that wait in the part, where it has a queue.
    pub(crate) queue: RefCell<VecDeque<[i16; 3]>>,
    pub(crate) transfers: RefCell<Vec<Transfer>>,
    /// Number of the transaction that fails.
    pub(crate) failing: Cell<Option<usize>>,
    pub(crate) now_us: Cell<i64>,
    pub(crate) clock_fails: Cell<bool>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    Written,
    Read,
}

impl Board {
    pub(crate) fn new(address: u8, reaction: fn(&Board, &mut [u8; 256], u8, Access)) -> Self {
        Self {
            address,
            registers: RefCell::new([0; 256]),
            reaction,
            queue: RefCell::default(),
            transfers: RefCell::default(),
            failing: Cell::default(),
            now_us: Cell::default(),
            clock_fails: Cell::default(),
        }
    }

    pub(crate) fn set(&self, register: u8, values: &[u8]) {
        let first = usize::from(register);
        self.registers.borrow_mut()[first..first + values.len()].copy_from_slice(values);
    }

    pub(crate) fn get(&self, register: u8) -> u8 {
        self.registers.borrow()[usize::from(register)]
    }

    /// Three axes, lowest byte first.
    pub(crate) fn set_axes(&self, register: u8, axes: [i16; 3]) {
        let bytes: Vec<u8> = axes.iter().flat_map(|axis| axis.to_le_bytes()).collect();
        self.set(register, &bytes);
    }

    pub(crate) fn written(&self) -> Vec<Vec<u8>> {
        let transfers = self.transfers.borrow();
        transfers.iter().filter(|(_, read)| read.is_empty()).map(|(written, _)| written.clone()).collect()
    }
}

impl ErrorType for &Board {
    type Error = ErrorKind;
}

impl I2c for &Board {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let number = self.transfers.borrow().len();
        let (mut written, mut all_read) = (Vec::new(), Vec::new());
        if address != self.address || self.failing.get() == Some(number) {
            self.transfers.borrow_mut().push((written, all_read));
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        }
        let mut registers = self.registers.borrow_mut();
        for operation in operations {
            match operation {
                Operation::Write(bytes) => {
                    written = bytes.to_vec();
                    for (register, value) in (bytes[0]..).zip(&bytes[1..]) {
                        registers[usize::from(register)] = *value;
                        (self.reaction)(self, &mut registers, register, Access::Written);
                    }
                }
                Operation::Read(bytes) => {
                    for (register, value) in (written[0]..).zip(bytes.iter_mut()) {
                        (self.reaction)(self, &mut registers, register, Access::Read);
                        *value = registers[usize::from(register)];
                    }
                    all_read.extend_from_slice(bytes);
                }
            }
        }
        self.transfers.borrow_mut().push((written, all_read));
        Ok(())
    }
}

impl DelayNs for &Board {
    fn delay_ns(&mut self, ns: u32) {
        self.now_us.set(self.now_us.get() + i64::from(ns) / 1_000);
    }
}

/// The board's clock.
pub(crate) struct Counter<'b>(pub(crate) &'b Board);

impl fsw_hal::ErrorType for Counter<'_> {
    type Error = ClockError;
}

impl Clock for Counter<'_> {
    fn local_time(&mut self) -> Result<LocalTime, ClockError> {
        match self.0.clock_fails.get() {
            true => Err(ClockError::Timeout),
            false => Ok(LocalTime::from_us(self.0.now_us.get())),
        }
    }

    fn terrestrial_us(&mut self, _: LocalTime) -> Result<i64, ClockError> {
        Err(ClockError::NotSynchronised)
    }
}
