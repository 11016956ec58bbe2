//! What a call came to: a code, and the same in words.

use core::ffi::{CStr, c_char};

/// What a call came to. Every call that is not `OK` has changed nothing, except that a cycle refused with
/// `TELEMETRY` has been flown.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A pointer that is needed is null.
    Null = 1,
    /// A buffer is shorter than needed, or longer than any object can be.
    Size = 2,
    /// A pointer is not aligned for what it points to.
    Alignment = 3,
    /// An output, or a table that is to last, lies in the sensor's memory.
    Overlap = 4,
    /// No sensor was initialised at this address, or it was copied or moved since.
    NotASensor = 5,
    /// The sensor is in a cycle: a call from one of its own callbacks, or from another task.
    Busy = 6,
    /// The command is none of `sextant_command`.
    Command = 7,
    /// A callback that is needed is null, or the detector's geometry is impossible or not that of its bad
    /// pixels.
    Instruments = 8,
    /// The parameter table was cut or damaged, or is none.
    ParametersDamaged = 9,
    /// The parameter table is of another version than `SEXTANT_PARAMETERS_VERSION`.
    ParametersVersion = 10,
    /// A value of the parameter table is outside its range, or values contradict each other.
    ParametersRange = 11,
    /// The catalogue was cut or damaged, or is none.
    CatalogueDamaged = 12,
    /// The catalogue has a layout that this library does not read.
    CatalogueVersion = 13,
    /// The calibration was cut or damaged, or is none.
    CalibrationDamaged = 14,
    /// The calibration has a layout that this library does not read.
    CalibrationVersion = 15,
    /// The parameter table names a calibration, and the one given is another, of another lens, or missing.
    CalibrationMismatch = 16,
    /// The telemetry frame could not be written.
    Telemetry = 17,
    /// What was kept of before a restart is no whole telemetry frame of this version with an orbit or a
    /// commanded safe, or comes after the first second.
    Kept = 18,
    /// The bad pixels' file was cut or damaged, or is none.
    BadPixelsDamaged = 19,
    /// The bad pixels' file has a layout that this library does not read.
    BadPixelsVersion = 20,
    /// The bad pixels are those of a detector of another size than the parameter table's.
    BadPixelsMismatch = 21,
}

/// All of them, in the order of their numbers.
const ALL: [Status; 22] = [
    Status::Ok,
    Status::Null,
    Status::Size,
    Status::Alignment,
    Status::Overlap,
    Status::NotASensor,
    Status::Busy,
    Status::Command,
    Status::Instruments,
    Status::ParametersDamaged,
    Status::ParametersVersion,
    Status::ParametersRange,
    Status::CatalogueDamaged,
    Status::CatalogueVersion,
    Status::CalibrationDamaged,
    Status::CalibrationVersion,
    Status::CalibrationMismatch,
    Status::Telemetry,
    Status::Kept,
    Status::BadPixelsDamaged,
    Status::BadPixelsVersion,
    Status::BadPixelsMismatch,
];

impl Status {
    /// What a call that may fail returns.
    pub(crate) fn of(result: Result<(), Self>) -> Self {
        result.err().unwrap_or(Self::Ok)
    }

    /// The status in words.
    pub const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Null => c"a pointer that is needed is null",
            Self::Size => c"a buffer is shorter than needed, or longer than any object can be",
            Self::Alignment => c"a pointer is not aligned for what it points to",
            Self::Overlap => c"an output or a table lies in the memory of the sensor or the link",
            Self::NotASensor => c"no sensor or link was initialised at this address, or it was moved since",
            Self::Busy => c"the sensor or the link is in a call already",
            Self::Command => c"the command is none of sextant_command",
            Self::Instruments => c"a callback is missing, or the detector's geometry cannot be used",
            Self::ParametersDamaged => c"the parameter table is damaged, or is none",
            Self::ParametersVersion => c"the parameter table is of another version",
            Self::ParametersRange => c"a value of the parameter table is outside its range",
            Self::CatalogueDamaged => c"the catalogue is damaged, or is none",
            Self::CatalogueVersion => c"the catalogue has a layout that this library does not read",
            Self::CalibrationDamaged => c"the calibration is damaged, or is none",
            Self::CalibrationVersion => c"the calibration has a layout that this library does not read",
            Self::CalibrationMismatch => c"the calibration is not the one that the parameter table names",
            Self::Telemetry => c"the telemetry frame could not be written",
            Self::Kept => c"what was kept is no whole telemetry frame of this version with an orbit",
            Self::BadPixelsDamaged => c"the bad pixels' file is damaged, or is none",
            Self::BadPixelsVersion => c"the bad pixels' file has a layout that this library does not read",
            Self::BadPixelsMismatch => c"the bad pixels are those of a detector of another size",
        }
    }
}

/// Says a status in words: a static string in English, one line without its end. Never null; for a number
/// that is no status it says so.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_status_text(status: u32) -> *const c_char {
    let known = ALL.into_iter().find(|known| *known as u32 == status);
    known.map_or(c"unknown status", Status::text).as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_words_of_its_own_and_any_other_number_says_so() {
        let mut texts = std::collections::BTreeSet::new();
        for (number, status) in ALL.into_iter().enumerate() {
            assert_eq!(number, status as usize);
            assert_eq!(sextant_status_text(status as u32), status.text().as_ptr());
            assert!(texts.insert(status.text()), "{status:?}");
        }
        for number in [22, 23, u32::MAX] {
            // SAFETY: the function gives static strings only.
            assert_eq!(unsafe { CStr::from_ptr(sextant_status_text(number)) }, c"unknown status");
        }
    }
}
