//! A second that takes up what a sensor knew before a restart.
//!
//! In: the telemetry of a second of before, kept by the caller where a restart leaves it. Out: that second's
//! orbit and how the paths were mounted, in the sensor.

use crate::calls::{Outputs, fly, whole};
use crate::doors::{Bytes, Extent, check};
use crate::instruments::Instruments;
use crate::memory::{self, SensorMemory};
use crate::results::CycleResult;
use crate::status::Status;
use fsw_core::command::GroundOrbit;
use fsw_core::sensor;
use fsw_core::telemetry;

/// Flies one second as `sextant_cycle` that begins with orbit and mounting of before a restart, where no
/// orbit is known yet. Call it once, after the first second whose `result->terrestrial_us` is not 0.
///
/// - `kept`: what a cycle before the restart wrote as telemetry, its length before it. Keep one that has an
///   orbit every few minutes, in memory that a restart leaves; frames of another version are refused.
///
/// Returns what `sextant_cycle` returns, but not `COMMAND`; `KEPT` where `kept` is no whole frame with an
/// orbit. Unless `OK` nothing was flown. `result->command` says whether the orbit was taken: one that is
/// older than 100 minutes is not, and begins anew; the mounting stays.
///
/// # Safety
/// As `sextant_cycle`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sextant_cycle_resumed(
    sensor: *mut SensorMemory,
    kept: Bytes,
    instruments: *const Instruments,
    telemetry: *mut u8,
    telemetry_bytes: usize,
    telemetry_length: *mut usize,
    result: *mut CycleResult,
) -> Status {
    let outputs = Outputs { telemetry, telemetry_bytes, telemetry_length, result };
    let resumed = || {
        check(sensor)?;
        outputs.check(Extent::of(sensor))?;
        // SAFETY: the caller promises the bytes.
        let Before { orbit, misalignment_rad, sigma_rad } = before(unsafe { kept.slice() }?)?;
        // Before the mounting is taken: a call that is refused changes nothing.
        // SAFETY: the caller's promises are the same.
        let lent = unsafe { whole(instruments) }?;
        let take = |sensor: &mut sensor::Sensor, bad_pixels| {
            lent.check_size(bad_pixels)?;
            sensor.initialise_mounting(misalignment_rad, sigma_rad);
            Ok(())
        };
        // SAFETY: the handle is aligned; that a sensor's memory stands behind it is the caller's promise.
        unsafe { memory::with(sensor, take) }??;
        // SAFETY: the caller's promises are the same; handle and outputs were checked.
        unsafe { fly(sensor, instruments, sensor::Command::Orbit(orbit), &outputs, |_| ()) }
    };
    Status::of(resumed())
}

/// What a frame tells of before.
struct Before {
    orbit: GroundOrbit,
    misalignment_rad: [f32; 3],
    sigma_rad: [f32; 3],
}

/// Reads a frame that is led by its length. (Not inlined: the report is not to lie under the second on the
/// stack.)
#[inline(never)]
fn before(kept: &[u8]) -> Result<Before, Status> {
    let (frame, _) = telemetry::split_first(kept).ok_or(Status::Kept)?;
    let report = telemetry::decode(frame).map_err(|_| Status::Kept)?;
    let (told, orbit) = report.orbit.as_ref().zip(report.ground_orbit()).ok_or(Status::Kept)?;
    let (misalignment_rad, sigma_rad) = (told.misalignment_rad, told.misalignment_sigma_rad);
    Ok(Before { orbit, misalignment_rad, sigma_rad })
}
