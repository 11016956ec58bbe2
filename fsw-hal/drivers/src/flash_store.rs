//! A [`StateStore`] in NOR flash, on the traits of `embedded-storage`: two slots, written in turn.
//!
//! | bytes of a slot | content, little-endian |
//! |---|---|
//! | 4 | `SXST` |
//! | 4 | sequence number: one more than that of the other slot, modulo 2^32 |
//! | 4 | length of the record |
//! | 8 | instant, microseconds of Terrestrial Time since J2000.0 |
//! | length | record |
//! | 4 | CRC-32 of all before |
//!
//! A record goes into the slot that does not hold the newest one: erased, written, read back. So the newest
//! whole record is never touched, and a loss of power anywhere leaves it; what was half written has a wrong
//! CRC, which one in 2^32 would not have. Nothing is remembered between two calls: both slots are looked at
//! each time.
//!
//! Wear: every second record erases a slot. A flash of 100,000 erasures with a record every 10 minutes lasts
//! 200,000 records, 3.8 years; who keeps more often gives it memory without wear (FRAM, MRAM) behind the same
//! trait.

use crate::slots::{self, divides};
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checksum::Crc32;
use fsw_hal::{ErrorType, StateStore, StoreError};

const MAGIC: [u8; 4] = *b"SXST";
const HEADER_BYTES: usize = 20;
const CRC_BYTES: usize = 4;
/// Bytes beside the record.
const OVERHEAD_BYTES: usize = HEADER_BYTES + CRC_BYTES;
/// Bytes written or read at a time: a multiple of the flash's words.
const CHUNK: usize = 64;

/// Why a record was not kept or not given. `E` is the flash's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashStoreError<E> {
    /// The flash failed.
    Flash(E),
    /// The record is longer than a slot has room for, or than the buffer.
    Length,
    /// The record was kept too long ago, or at an instant that is still to come.
    Stale,
    /// What was written is not what is read.
    Verify,
}

impl<E: core::fmt::Debug> fsw_hal::Error<StoreError> for FlashStoreError<E> {
    fn kind(&self) -> StoreError {
        match self {
            Self::Flash(_) | Self::Verify => StoreError::Bus,
            Self::Length => StoreError::Length,
            Self::Stale => StoreError::Stale,
        }
    }
}

/// What stands before a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Header {
    sequence: u32,
    length: usize,
    instant_us: i64,
}

impl Header {
    fn bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        let fields = MAGIC
            .into_iter()
            .chain(self.sequence.to_le_bytes())
            .chain((self.length as u32).to_le_bytes())
            .chain(self.instant_us.to_le_bytes());
        bytes.iter_mut().zip(fields).for_each(|(byte, field)| *byte = field);
        bytes
    }

    fn read(bytes: &[u8; CHUNK]) -> Option<Self> {
        let (magic, rest) = bytes.split_first_chunk()?;
        let (sequence, rest) = rest.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let (instant_us, _) = rest.split_first_chunk()?;
        (*magic == MAGIC).then_some(Self {
            sequence: u32::from_le_bytes(*sequence),
            length: u32::from_le_bytes(*length) as usize,
            instant_us: i64::from_le_bytes(*instant_us),
        })
    }
}

/// The store.
#[derive(Debug)]
pub struct FlashStore<F> {
    flash: F,
    offset: u32,
    slot_bytes: usize,
}

impl<F: NorFlash> FlashStore<F> {
    /// In the `2 * slot_bytes` bytes of the flash from `offset` on. `None` where the slots are not whole
    /// sectors of the flash, have no room for a record or the flash has no room for them, or where its words
    /// do not divide 64 bytes.
    pub fn new(flash: F, offset: u32, slot_bytes: usize) -> Option<Self> {
        let first = usize::try_from(offset).ok()?;
        let end = first.checked_add(slot_bytes.checked_mul(2)?)?;
        let sectors = divides(F::ERASE_SIZE, first) && divides(F::ERASE_SIZE, slot_bytes);
        let words = divides(F::WRITE_SIZE, CHUNK) && divides(F::READ_SIZE, CHUNK);
        let room = end <= flash.capacity() && u32::try_from(end).is_ok() && slot_bytes >= CHUNK;
        let whole = divides(CHUNK, slot_bytes);
        (sectors && words && room && whole).then_some(Self { flash, offset, slot_bytes })
    }

    /// The longest record, bytes.
    pub fn room(&self) -> usize {
        self.slot_bytes - OVERHEAD_BYTES
    }

    /// The flash.
    pub fn release(self) -> F {
        self.flash
    }

    fn address(&self, slot: usize, byte: usize) -> u32 {
        self.offset.wrapping_add((slot * self.slot_bytes + byte) as u32)
    }

    /// Passes a slot: its header where it holds a whole record, which is copied into `buffer` as far as it
    /// goes.
    fn pass(&mut self, slot: usize, buffer: &mut [u8]) -> Result<Option<Header>, F::Error> {
        let mut chunk = [0; CHUNK];
        self.flash.read(self.address(slot, 0), &mut chunk)?;
        let Some(header) = Header::read(&chunk).filter(|header| header.length <= self.room()) else {
            return Ok(None);
        };
        let (mut crc, mut told) = (Crc32::default(), [0; CRC_BYTES]);
        let end = HEADER_BYTES + header.length;
        for at in (0..end + CRC_BYTES).step_by(CHUNK) {
            if at > 0 {
                self.flash.read(self.address(slot, at), &mut chunk)?;
            }
            let (covered, rest) = chunk.split_at(end.saturating_sub(at).min(CHUNK));
            crc.add(covered);
            for (place, byte) in (at..).zip(covered) {
                let target = place.checked_sub(HEADER_BYTES).and_then(|place| buffer.get_mut(place));
                target.into_iter().for_each(|target| *target = *byte);
            }
            for (place, byte) in (at + covered.len()..).zip(rest) {
                let target = place.checked_sub(end).and_then(|place| told.get_mut(place));
                target.into_iter().for_each(|target| *target = *byte);
            }
        }
        Ok((crc.value() == u32::from_le_bytes(told)).then_some(header))
    }

    /// The slot with the newest whole record, and its header.
    fn newest(&mut self) -> Result<Option<(usize, Header)>, F::Error> {
        Ok(slots::newer([self.pass(0, &mut [])?, self.pass(1, &mut [])?], |header| header.sequence))
    }

    /// Writes header, record and CRC into an erased slot.
    fn write(&mut self, slot: usize, header: &Header, record: &[u8]) -> Result<(), F::Error> {
        let mut crc = Crc32::default();
        crc.add(&header.bytes());
        crc.add(record);
        let crc = crc.value().to_le_bytes();
        let mut bytes = header.bytes().into_iter().chain(record.iter().copied()).chain(crc);
        for at in (0..record.len() + OVERHEAD_BYTES).step_by(CHUNK) {
            // What is left of the last chunk stays as an erased flash reads.
            let mut chunk = [0xFF; CHUNK];
            chunk.iter_mut().zip(bytes.by_ref()).for_each(|(target, byte)| *target = byte);
            self.flash.write(self.address(slot, at), &chunk)?;
        }
        Ok(())
    }
}

impl<F: NorFlash> ErrorType for FlashStore<F> {
    type Error = FlashStoreError<F::Error>;
}

impl<F: NorFlash> StateStore for FlashStore<F> {
    fn keep(&mut self, record: &[u8], instant_us: i64) -> Result<(), Self::Error> {
        if record.len() > self.room() {
            return Err(FlashStoreError::Length);
        }
        let newest = self.newest().map_err(FlashStoreError::Flash)?;
        let (slot, sequence) = slots::next(newest.map(|(slot, header)| (slot, header.sequence)));
        let header = Header { sequence, length: record.len(), instant_us };
        let (from, to) = (self.address(slot, 0), self.address(slot, self.slot_bytes));
        self.flash.erase(from, to).map_err(FlashStoreError::Flash)?;
        self.write(slot, &header, record).map_err(FlashStoreError::Flash)?;
        let written = self.pass(slot, &mut []).map_err(FlashStoreError::Flash)?;
        if written == Some(header) { Ok(()) } else { Err(FlashStoreError::Verify) }
    }

    fn kept<'b>(
        &mut self,
        buffer: &'b mut [u8],
        now_us: i64,
        max_age_us: i64,
    ) -> Result<Option<&'b [u8]>, Self::Error> {
        let Some((slot, header)) = self.newest().map_err(FlashStoreError::Flash)? else { return Ok(None) };
        if !(0..=max_age_us).contains(&now_us.saturating_sub(header.instant_us)) {
            return Err(FlashStoreError::Stale);
        }
        let record = buffer.get_mut(..header.length).ok_or(FlashStoreError::Length)?;
        let read = self.pass(slot, record).map_err(FlashStoreError::Flash)?;
        if read == Some(header) { Ok(Some(record)) } else { Err(FlashStoreError::Verify) }
    }
}

#[cfg(test)]
mod tests;
