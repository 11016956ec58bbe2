//! A parameter table, or the file of an area, on its way up: parts are collected until it is whole.
//!
//! In: parts, each where the last one ended. A table's are kept here, a file's go into the area's memory.
//! Out: whether length and CRC-32 are those that the command to load names; of a file the length alone, as
//! its CRC is that of what the memory holds ([`super::area_check`]).

use super::refusal::Refusal;
use crate::checksum::crc32;
use crate::parameters::MAX_TABLE_BYTES;
use fsw_hal::{Area, AreaError, AreaStore, Error};

/// The parts so far.
#[derive(Clone, Debug)]
pub(super) struct Upload {
    /// Those of a table.
    buffer: [u8; MAX_TABLE_BYTES],
    /// What they are of; `None`: a table.
    area: Option<Area>,
    length: usize,
}

impl Upload {
    pub(super) const fn new() -> Self {
        Self { buffer: [0; MAX_TABLE_BYTES], area: None, length: 0 }
    }

    /// Takes a part.
    ///
    /// # Errors
    /// [`Refusal::Area`], [`Refusal::Part`]: the parts so far stay. [`Refusal::Memory`]: they are forgotten.
    pub(super) fn add(
        &mut self,
        (area, offset): (Option<Area>, u32),
        bytes: &[u8],
        store: &mut impl AreaStore,
    ) -> Result<(), Refusal> {
        let room = room(area, store)?;
        let offset = offset as usize;
        let continues = area == self.area && offset == self.length;
        let end = offset.checked_add(bytes.len()).filter(|end| *end <= room).ok_or(Refusal::Part)?;
        if bytes.is_empty() || !(offset == 0 || continues) {
            return Err(Refusal::Part);
        }
        match area {
            None => {
                let place = self.buffer.get_mut(offset..).and_then(|rest| rest.get_mut(..bytes.len()));
                place.ok_or(Refusal::Part)?.copy_from_slice(bytes);
            }
            Some(area) => store.write(area, offset, bytes).map_err(|error| match error.kind() {
                AreaError::Alignment | AreaError::Length => Refusal::Part,
                _ => {
                    self.forget();
                    Refusal::Memory
                }
            })?,
        }
        (self.area, self.length) = (area, end);
        Ok(())
    }

    /// Checks that the parts are the whole table or file.
    ///
    /// # Errors
    /// [`Refusal::Area`], [`Refusal::Incomplete`], [`Refusal::TableChecksum`].
    pub(super) fn check(
        &self,
        area: Option<Area>,
        (length, crc): (u32, u32),
        store: &impl AreaStore,
    ) -> Result<(), Refusal> {
        room(area, store)?;
        if area != self.area || self.length != length as usize {
            return Err(Refusal::Incomplete);
        }
        if area.is_none() && crc32(self.table()) != crc {
            return Err(Refusal::TableChecksum);
        }
        Ok(())
    }

    /// The parts of a table so far.
    pub(super) fn table(&self) -> &[u8] {
        self.buffer.get(..self.length).unwrap_or(&[])
    }

    /// The next part begins anew.
    pub(super) fn forget(&mut self) {
        self.length = 0;
    }
}

/// Room for a table or the file of an area, bytes.
fn room(area: Option<Area>, store: &impl AreaStore) -> Result<usize, Refusal> {
    let room = area.map_or(MAX_TABLE_BYTES, |area| store.room(area));
    if room == 0 { Err(Refusal::Area) } else { Ok(room) }
}
