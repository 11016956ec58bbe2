//! Memory of the areas on the host: files that were sent up serve from the next start on.

use fsw_hal::{Area, AreaError, AreaStore};

/// The longest file, bytes: more than the reference catalogue has.
pub const ROOM_BYTES: usize = 1 << 18;

/// The two copies of an area.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Copies {
    serving: Option<Vec<u8>>,
    spare: Vec<u8>,
    /// Length of the spare one, where it is whole.
    whole: Option<usize>,
}

/// The memory, empty at first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RamAreas {
    /// Of each area in the order of [`Area`].
    copies: [Copies; 3],
}

impl RamAreas {
    /// The file that serves; `None` where there is none.
    pub fn serving(&self, area: Area) -> Option<&[u8]> {
        self.copies[area as usize].serving.as_deref()
    }

    /// The next start: what was marked as whole serves.
    pub fn restart(&mut self) {
        for copies in &mut self.copies {
            if let Some(length) = copies.whole.take() {
                let mut file = std::mem::take(&mut copies.spare);
                file.truncate(length);
                copies.serving = Some(file);
            }
        }
    }
}

impl fsw_hal::ErrorType for RamAreas {
    type Error = AreaError;
}

impl AreaStore for RamAreas {
    fn room(&self, _: Area) -> usize {
        ROOM_BYTES
    }

    fn write(&mut self, area: Area, offset: usize, part: &[u8]) -> Result<(), AreaError> {
        if offset.saturating_add(part.len()) > ROOM_BYTES {
            return Err(AreaError::Length);
        }
        let copies = &mut self.copies[area as usize];
        copies.whole = None;
        copies.spare.resize(offset, 0);
        copies.spare.extend_from_slice(part);
        Ok(())
    }

    fn written(&self, area: Area, length: usize) -> Result<&[u8], AreaError> {
        self.copies[area as usize].spare.get(..length).ok_or(AreaError::Length)
    }

    fn mark_whole(&mut self, area: Area, length: usize, _: u32) -> Result<(), AreaError> {
        self.written(area, length)?;
        self.copies[area as usize].whole = Some(length);
        Ok(())
    }
}
