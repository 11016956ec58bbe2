//! The sensor in memory of the caller.
//!
//! [`SensorMemory`] is laid into the memory that C owns: a head that says whether and where a sensor was
//! made, its workspace, and the sensor, which refers to that workspace. So it must not be copied: the head
//! holds its own address. A cycle holds the sensor by the head's state: a second call in the meantime, from
//! a callback or from another task, is refused.

use crate::status::Status;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use fsw_core::catalog::Catalogue;
use fsw_core::image::calibration::Calibration;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Sensor, SensorError, Workspace, calibration_fits};

/// State of the head: a sensor that waits for its next cycle ("SXTR").
const READY: u32 = 0x5258_5453;
/// A sensor that is in a cycle, or is being made ("SXTB").
const BUSY: u32 = 0x4258_5453;
/// No sensor.
const NONE: u32 = 0;

/// The sensor, opaque. It lies in the memory that was given to `sextant_init`, at its beginning; it must
/// not be copied or moved.
pub struct SensorMemory {
    state: AtomicU32,
    address: AtomicUsize,
    sensor: MaybeUninit<Sensor<'static>>,
    workspace: MaybeUninit<Workspace>,
}

/// What a sensor is made of.
pub(crate) struct Tables {
    /// Decoded.
    pub(crate) parameters: Parameters,
    /// Opened.
    pub(crate) catalogue: Catalogue<'static>,
    /// Opened; none where the parameters name none.
    pub(crate) calibration: Option<Calibration<'static>>,
}

impl Tables {
    /// Refuses what [`Tables::sensor`] would refuse, before any memory is touched.
    fn check(&self) -> Result<(), Status> {
        self.parameters.check().map_err(|_| Status::ParametersRange)?;
        let (camera, crc) = (&self.parameters.camera, self.parameters.imaging.calibration_crc);
        match &self.calibration {
            Some(calibration) if !calibration_fits(camera, crc, calibration) => {
                Err(Status::CalibrationMismatch)
            }
            _ => Ok(()),
        }
    }

    /// Writes the sensor to its place. (Not inlined: what it is put together from is not to lie under the
    /// decoded tables on the stack.)
    #[inline(never)]
    fn write_sensor(
        self,
        workspace: &'static mut Workspace,
        place: &mut MaybeUninit<Sensor<'static>>,
    ) -> Result<(), Status> {
        let Self { parameters, catalogue, calibration } = self;
        let made = Sensor::new_in(place, catalogue, parameters, calibration, workspace);
        made.map(|_| ()).map_err(|error| match error {
            SensorError::Parameters(_) => Status::ParametersRange,
            SensorError::Calibration => Status::CalibrationMismatch,
        })
    }
}

/// The right to use the sensor of a memory, for one call.
struct Held<'m> {
    state: &'m AtomicU32,
    /// The state that is left behind.
    then: u32,
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.state.store(self.then, Ordering::Release);
    }
}

/// The head: state, and the address at which it was written.
///
/// # Safety
/// `memory` is aligned and memory that lives for `'m`; its head is used by this module alone.
unsafe fn head<'m>(memory: *mut SensorMemory) -> (&'m AtomicU32, &'m AtomicUsize) {
    // SAFETY: the caller's promise; any bits are a number, and they are read and written as atomics only.
    unsafe { (&(*memory).state, &(*memory).address) }
}

/// Makes a sensor that knows nothing yet; one that was there is forgotten.
///
/// # Errors
/// [`Status::Busy`], and what is wrong with the tables: [`Status::ParametersRange`],
/// [`Status::CalibrationMismatch`]. The memory then holds what it held.
///
/// # Safety
/// `memory` is aligned and memory of a [`SensorMemory`] that is used through this module alone from now on.
pub(crate) unsafe fn make(memory: *mut SensorMemory, tables: Tables) -> Result<(), Status> {
    tables.check()?;
    // SAFETY: the caller's promise.
    let (state, address) = unsafe { head(memory) };
    let found = state.load(Ordering::Relaxed);
    if found == BUSY && address.load(Ordering::Relaxed) == memory.addr() {
        return Err(Status::Busy);
    }
    state.compare_exchange(found, BUSY, Ordering::Acquire, Ordering::Relaxed).map_err(|_| Status::Busy)?;
    let mut held = Held { state, then: NONE };
    address.store(memory.addr(), Ordering::Relaxed);
    // SAFETY: the state gives this call the memory. All zero is an empty workspace (a test compares them), and
    // the one reference to it is the sensor's.
    unsafe {
        let workspace = (&raw mut (*memory).workspace).cast::<Workspace>();
        workspace.write_bytes(0, 1);
        tables.write_sensor(&mut *workspace, &mut (*memory).sensor)?;
    }
    held.then = READY;
    Ok(())
}

/// Lends the sensor of a memory for one call.
///
/// # Errors
/// [`Status::NotASensor`], [`Status::Busy`].
///
/// # Safety
/// `memory` is aligned and memory of a [`SensorMemory`], of which nothing else is used meanwhile.
pub(crate) unsafe fn with<T>(
    memory: *mut SensorMemory,
    call: impl FnOnce(&mut Sensor<'static>) -> T,
) -> Result<T, Status> {
    // SAFETY: the caller's promise.
    let (state, address) = unsafe { head(memory) };
    if address.load(Ordering::Relaxed) != memory.addr() {
        return Err(Status::NotASensor);
    }
    match state.compare_exchange(READY, BUSY, Ordering::Acquire, Ordering::Relaxed) {
        Ok(_) => {}
        Err(BUSY) => return Err(Status::Busy),
        Err(_) => return Err(Status::NotASensor),
    }
    let _held = Held { state, then: READY };
    // SAFETY: a sensor was written before the state became READY, and the state gives it to this call
    // alone.
    Ok(call(unsafe { (*memory).sensor.assume_init_mut() }))
}
