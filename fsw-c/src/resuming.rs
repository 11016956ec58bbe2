//! What a sensor takes up of before a restart.
//!
//! In: the telemetry of a second of before, kept by the caller where a restart leaves it. Out: that second's
//! orbit, how the paths were mounted and a commanded safe, in the sensor.

use crate::doors::{Bytes, check};
use crate::memory::{self, SensorMemory};
use crate::status::Status;
use fsw_core::telemetry;

/// Goes on from before a restart: with the orbit and the mounting of the paths, and in safe where that was
/// commanded. Call it after `sextant_init`, before the first cycle.
///
/// - `kept`: what a cycle before the restart wrote as telemetry, its length before it. Keep one that has an
///   orbit every few minutes, and one whenever the mode becomes or was `COMMANDED_SAFE`, in memory that a
///   restart leaves; frames of another version are refused.
///
/// The orbit is told once Terrestrial Time is known and the gap is crossed. One that is older than two hours
/// then is forgotten with an event, and begins anew; the mounting stays.
///
/// Returns `OK`; `KEPT` where `kept` is no whole frame with an orbit or a commanded safe, or a second was
/// flown already; `NULL`, `SIZE`, `ALIGNMENT`, `NOT_A_SENSOR`, `BUSY`. Unless `OK` nothing has changed.
///
/// # Safety
/// `sensor` is a handle of `sextant_init`, or is refused; `kept` are bytes that stay as they are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_resume(sensor: *mut SensorMemory, kept: Bytes) -> Status {
    let resume = || {
        check(sensor)?;
        // SAFETY: the caller promises the bytes.
        let (frame, _) = telemetry::split_first(unsafe { kept.slice() }?).ok_or(Status::Kept)?;
        let before = telemetry::decode(frame).map_err(|_| Status::Kept)?;
        // SAFETY: the handle is aligned; that a sensor's memory stands behind it is the caller's promise.
        let goes_on = unsafe { memory::with(sensor, |sensor, _| sensor.resume(&before)) }?;
        goes_on.then_some(()).ok_or(Status::Kept)
    };
    Status::of(resume())
}
