//! An [`AreaStore`] in NOR flash that is mapped into the address space, on the traits of `embedded-storage`:
//! two slots an area, one that serves and a spare one.
//!
//! | bytes of a slot | content, little-endian |
//! |---|---|
//! | 4 | `SXAR` |
//! | 4 | sequence number: one more than that of the other slot, modulo 2^32 |
//! | 4 | length of the file |
//! | 4 | CRC-32 of the file |
//! | 4 | CRC-32 of the 16 bytes before |
//! | 44 | not written |
//! | length | file |
//!
//! Which slot serves is found once, when the store is made: the whole one that was marked last. The other
//! one takes parts: a sector is erased when a part reaches it, the first one with the mark on it; the mark is
//! written last. So nothing writes to the slot that serves, whose bytes the sensor borrows, and a loss of
//! power anywhere leaves it: what was half written has no mark, or one with a wrong CRC.
//!
//! A part begins where a word of the flash begins: parts of 64, 128 or 192 bytes fit any flash. One part
//! erases the sectors that it reaches: of 4 KiB at most one, for 45 to 400 ms.

use crate::slots::{self, divides};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checksum::crc32;
use fsw_hal::{Area, AreaError, AreaStore, ErrorType};

const MAGIC: [u8; 4] = *b"SXAR";
/// Bytes before the file.
const HEADER_BYTES: usize = 64;
/// Bytes of the mark within them, and of those under its CRC.
const MARK_BYTES: usize = 20;
const MARKED_BYTES: usize = 16;

/// Flash that can be read as a slice.
pub trait MappedFlash: NorFlash {
    /// All its bytes, from its address 0 on, as they are now: a cache between is emptied of what was erased
    /// or written.
    fn mapped(&self) -> &[u8];
}

/// Why an area was not written or read. `E` is the flash's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashAreasError<E> {
    /// The flash failed.
    Flash(E),
    /// The part begins where no word of the flash begins.
    Alignment,
    /// It goes beyond the slot.
    Length,
    /// What was written is not what is read.
    Verify,
}

impl<E: core::fmt::Debug> fsw_hal::Error<AreaError> for FlashAreasError<E> {
    fn kind(&self) -> AreaError {
        match self {
            Self::Flash(_) | Self::Verify => AreaError::Bus,
            Self::Alignment => AreaError::Alignment,
            Self::Length => AreaError::Length,
        }
    }
}

/// Where the two slots of an area lie, one behind the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slots {
    /// Address of the first, bytes from the begin of the flash.
    pub offset: usize,
    /// Bytes of each: 64 more than the longest file.
    pub slot_bytes: usize,
}

impl Slots {
    /// Address of a slot.
    fn at(&self, slot: usize) -> usize {
        self.offset + slot * self.slot_bytes
    }
}

/// Where the areas lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AreaSlots {
    /// The star catalogue's.
    pub catalogue: Slots,
    /// The lens calibration's.
    pub calibration: Slots,
    /// The bad pixels'.
    pub bad_pixels: Slots,
}

/// What stands before a whole file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mark {
    sequence: u32,
    length: usize,
    crc: u32,
}

impl Mark {
    /// As it is written; what follows it stays as an erased flash reads.
    fn bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0xFF; HEADER_BYTES];
        let words = [self.sequence, self.length as u32, self.crc].map(u32::to_le_bytes);
        let marked = MAGIC.iter().chain(words.as_flattened());
        bytes.iter_mut().zip(marked).for_each(|(byte, marked)| *byte = *marked);
        let crc = crc32(bytes.get(..MARKED_BYTES).unwrap_or_default()).to_le_bytes();
        bytes.iter_mut().skip(MARKED_BYTES).zip(crc).for_each(|(byte, crc)| *byte = crc);
        bytes
    }

    /// That of a slot, where it has one.
    fn read(slot: &[u8]) -> Option<Self> {
        let word = |at: usize| slot.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word));
        let mark = Self { sequence: word(4)?, length: word(8)? as usize, crc: word(12)? };
        (slot.get(..MARK_BYTES)? == mark.bytes().get(..MARK_BYTES)?).then_some(mark)
    }

    /// That of a slot which holds a whole file.
    fn of_whole(slot: &[u8]) -> Option<Self> {
        let mark = Self::read(slot)?;
        let file = slot.get(HEADER_BYTES..)?.get(..mark.length)?;
        (crc32(file) == mark.crc).then_some(mark)
    }
}

/// The slots of an area and which of them serves.
#[derive(Clone, Copy, Debug)]
struct Place {
    slots: Slots,
    serving: Option<(usize, Mark)>,
}

impl Place {
    /// Looks at both slots.
    fn find(slots: Slots, mapped: &[u8]) -> Self {
        let marks =
            [0, 1].map(|slot| mapped.get(slots.at(slot)..slots.at(slot + 1)).and_then(Mark::of_whole));
        Self { slots, serving: slots::newer(marks, |mark| mark.sequence) }
    }

    /// Address of the spare slot, and the sequence number that it takes.
    fn spare(&self) -> (usize, u32) {
        let (slot, sequence) = slots::next(self.serving.map(|(slot, mark)| (slot, mark.sequence)));
        (self.slots.at(slot), sequence)
    }

    fn room(&self) -> usize {
        self.slots.slot_bytes - HEADER_BYTES
    }
}

/// The store.
#[derive(Debug)]
pub struct FlashAreas<F> {
    flash: F,
    catalogue: Place,
    calibration: Place,
    bad_pixels: Place,
}

/// The end of an area's slots; `None` where they are not whole sectors within the flash, or without room.
fn end_of<F: MappedFlash>(slots: &Slots, flash: &F) -> Option<usize> {
    let end = slots.slot_bytes.checked_mul(2)?.checked_add(slots.offset)?;
    let sectors = divides(F::ERASE_SIZE, slots.offset) && divides(F::ERASE_SIZE, slots.slot_bytes);
    let words = divides(F::WRITE_SIZE, HEADER_BYTES) && divides(F::WRITE_SIZE, slots.slot_bytes);
    let inside = end <= flash.capacity().min(flash.mapped().len()) && u32::try_from(end).is_ok();
    (sectors && words && inside && slots.slot_bytes > HEADER_BYTES).then_some(end)
}

impl<F: MappedFlash> FlashAreas<F> {
    /// In these slots of the flash. `None` where they are not whole sectors of it, overlap, have no room for
    /// a file or the flash has no room for them, or where its words do not divide 64 bytes.
    ///
    /// Cost: the CRC of every whole file, both slots, 8 cycles a byte.
    pub fn new(flash: F, slots: AreaSlots) -> Option<Self> {
        let AreaSlots { catalogue, calibration, bad_pixels } = slots;
        let all = [&catalogue, &calibration, &bad_pixels];
        for (place, one) in all.iter().enumerate() {
            let end = end_of(one, &flash)?;
            let apart = |other: &&Slots| {
                end_of(other, &flash).is_some_and(|ends| other.offset >= end || ends <= one.offset)
            };
            if !all.iter().skip(place + 1).all(apart) {
                return None;
            }
        }
        let [catalogue, calibration, bad_pixels] =
            [catalogue, calibration, bad_pixels].map(|slots| Place::find(slots, flash.mapped()));
        Some(Self { flash, catalogue, calibration, bad_pixels })
    }

    /// Where in the flash the file lies that serves; `None` where there is none. It stays there, unchanged,
    /// until the store is made anew, so that a board may lend these bytes to the sensor.
    pub fn serving(&self, area: Area) -> Option<Range<usize>> {
        let place = self.place(area);
        let (slot, mark) = place.serving?;
        let from = place.slots.at(slot) + HEADER_BYTES;
        Some(from..from + mark.length)
    }

    /// The flash.
    pub fn release(self) -> F {
        self.flash
    }

    fn place(&self, area: Area) -> &Place {
        match area {
            Area::Catalogue => &self.catalogue,
            Area::Calibration => &self.calibration,
            Area::BadPixels => &self.bad_pixels,
        }
    }
}

impl<F: MappedFlash> ErrorType for FlashAreas<F> {
    type Error = FlashAreasError<F::Error>;
}

impl<F: MappedFlash> AreaStore for FlashAreas<F> {
    fn room(&self, area: Area) -> usize {
        self.place(area).room()
    }

    fn write(&mut self, area: Area, offset: usize, part: &[u8]) -> Result<(), Self::Error> {
        let place = *self.place(area);
        if offset.checked_rem(F::WRITE_SIZE) != Some(0) {
            return Err(FlashAreasError::Alignment);
        }
        let room = place.room();
        let end = offset.checked_add(part.len()).filter(|end| *end <= room).ok_or(FlashAreasError::Length)?;
        let (spare, _) = place.spare();
        let file = spare + HEADER_BYTES;
        let (from, to) = (file + offset, file + end);
        // A sector that begins before this part was erased for one before, or here with the mark.
        let unerased = if offset == 0 { spare } else { from }.next_multiple_of(F::ERASE_SIZE);
        let erased_to = to.next_multiple_of(F::ERASE_SIZE);
        if unerased < erased_to {
            self.flash.erase(unerased as u32, erased_to as u32).map_err(FlashAreasError::Flash)?;
        }
        let (words, rest) = part.split_at(part.len() - part.len() % F::WRITE_SIZE);
        self.flash.write(from as u32, words).map_err(FlashAreasError::Flash)?;
        if rest.is_empty() {
            return Ok(());
        }
        // What is left of the last word stays as an erased flash reads.
        let mut word = [0xFF; HEADER_BYTES];
        word.iter_mut().zip(rest).for_each(|(target, byte)| *target = *byte);
        let word = word.get(..F::WRITE_SIZE).unwrap_or_default();
        self.flash.write((from + words.len()) as u32, word).map_err(FlashAreasError::Flash)
    }

    fn written(&self, area: Area, length: usize) -> Result<&[u8], Self::Error> {
        let place = self.place(area);
        let file = place.spare().0 + HEADER_BYTES;
        let end = (length <= place.room()).then_some(file + length).ok_or(FlashAreasError::Length)?;
        self.flash.mapped().get(file..end).ok_or(FlashAreasError::Length)
    }

    fn mark_whole(&mut self, area: Area, length: usize, crc: u32) -> Result<(), Self::Error> {
        let place = *self.place(area);
        if length > place.room() {
            return Err(FlashAreasError::Length);
        }
        let (spare, sequence) = place.spare();
        let mark = Mark { sequence, length, crc };
        self.flash.write(spare as u32, &mark.bytes()).map_err(FlashAreasError::Flash)?;
        let slot = self.flash.mapped().get(spare..);
        if slot.and_then(Mark::read) == Some(mark) { Ok(()) } else { Err(FlashAreasError::Verify) }
    }
}

#[cfg(test)]
mod tests;
