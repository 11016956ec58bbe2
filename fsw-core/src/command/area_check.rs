//! The check of an area's file before it is marked as whole.
//!
//! In: the file as the memory holds it, [`SLICE_BYTES`] of it a second; length and CRC-32 that the command to
//! load named; the camera of the parameters in force. Out: what came of the command. A file is accepted only
//! where its CRC is right, its own door opens it, and it is of that camera; until then nothing is marked.
//!
//! Cost on the target: a slice 33,000 cycles; in the last second the door, 8 cycles a byte for the checksum
//! within the file and a pass over its tables: 1.5 million for the reference catalogue, as at every start,
//! which takes 2.4 million in all (`cargo budget`).

use super::CommandOutcome;
use super::refusal::Refusal;
use crate::camera::CameraParameters;
use crate::catalog::Catalogue;
use crate::checksum::SlicedCrc32;
use crate::image::calibration::Calibration;
use crate::image::defects::Defects;
use fsw_hal::{Area, AreaStore};

/// Bytes that are passed in a second.
pub(super) const SLICE_BYTES: usize = 4096;

/// How far the check is.
#[derive(Clone, Debug)]
pub(super) struct AreaCheck {
    area: Area,
    length: usize,
    crc: u32,
    passed: SlicedCrc32,
}

impl AreaCheck {
    /// Of the first `length` bytes of an area's memory, which are to have this CRC.
    pub(super) fn new(area: Area, length: u32, crc: u32) -> Self {
        Self { area, length: length as usize, crc, passed: SlicedCrc32::default() }
    }

    /// Passes the next slice, or does the rest where none is left; what came of it then.
    pub(super) fn step(
        &mut self,
        store: &mut impl AreaStore,
        camera: &CameraParameters,
    ) -> Option<CommandOutcome> {
        let Ok(bytes) = store.written(self.area, self.length) else {
            return Some(CommandOutcome::Refused(Refusal::Memory));
        };
        let Some(crc) = self.passed.of_all(bytes) else {
            self.passed.pass(bytes, SLICE_BYTES);
            return None;
        };
        if crc != self.crc {
            return Some(CommandOutcome::Refused(Refusal::AreaChecksum));
        }
        let marked = check_content(self.area, bytes, camera)
            .and_then(|()| store.mark_whole(self.area, self.length, self.crc).map_err(|_| Refusal::Memory));
        Some(marked.map_or_else(CommandOutcome::Refused, |()| CommandOutcome::Done))
    }
}

/// Opens a file as what its area holds, for this camera.
#[inline(never)]
fn check_content(area: Area, bytes: &[u8], camera: &CameraParameters) -> Result<(), Refusal> {
    let size_px = [camera.width_px, camera.height_px];
    let fits = match area {
        Area::Catalogue => Catalogue::open(bytes).ok().map(|_| true),
        Area::Calibration => {
            Calibration::open(bytes).ok().map(|opened| opened.is_of(size_px, camera.optical_centre_px))
        }
        Area::BadPixels => Defects::open(bytes).ok().map(|opened| opened.size_px() == size_px),
    };
    match fits {
        None => Err(Refusal::AreaContent),
        Some(false) => Err(Refusal::AreaDetector),
        Some(true) => Ok(()),
    }
}
