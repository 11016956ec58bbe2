//! The sensor and the command link in memory of the caller.
//!
//! [`SensorMemory`] is laid into the memory that C owns: a head that says whether and where a sensor was
//! made, its workspace, and the sensor, which refers to that workspace. So it must not be copied: the head
//! holds its own address. A cycle holds the sensor by the head's state: a second call in the meantime, from
//! a callback or from another task, is refused. [`LinkMemory`] is a link behind such a head.

use crate::areas::CAreas;
use crate::status::Status;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use fsw_core::catalog::Catalogue;
use fsw_core::command::CommandLink;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::defects::Defects;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Sensor, SensorError, Workspace, calibration_fits};

/// State of a head: the sensor behind it waits for its next call ("SXTR").
const SENSOR_READY: u32 = 0x5258_5453;
/// The same of a link ("SXTL").
const LINK_READY: u32 = 0x4C58_5453;
/// It is in a call, or is being made ("SXTB").
const BUSY: u32 = 0x4258_5453;
/// Nothing was made.
const NONE: u32 = 0;

/// Says whether and where something was made, and whether a call holds it.
struct Head {
    state: AtomicU32,
    address: AtomicUsize,
}

impl Head {
    /// Holds the memory of this head while something is made in it.
    fn begin(&self) -> Result<Held<'_>, Status> {
        let found = self.state.load(Ordering::Relaxed);
        if found == BUSY && self.address.load(Ordering::Relaxed) == (&raw const *self).addr() {
            return Err(Status::Busy);
        }
        let taken = self.state.compare_exchange(found, BUSY, Ordering::Acquire, Ordering::Relaxed);
        taken.map_err(|_| Status::Busy)?;
        self.address.store((&raw const *self).addr(), Ordering::Relaxed);
        Ok(Held { state: &self.state, then: NONE })
    }

    /// Holds what was made, for a call; `ready` is its state.
    fn hold(&self, ready: u32) -> Result<Held<'_>, Status> {
        if self.address.load(Ordering::Relaxed) != (&raw const *self).addr() {
            return Err(Status::NotASensor);
        }
        match self.state.compare_exchange(ready, BUSY, Ordering::Acquire, Ordering::Relaxed) {
            Ok(_) => Ok(Held { state: &self.state, then: ready }),
            Err(BUSY) => Err(Status::Busy),
            Err(_) => Err(Status::NotASensor),
        }
    }
}

/// The right to use what is behind a head, for one call.
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

/// The sensor, opaque. It lies in the memory that was given to `sextant_init`, at its beginning; it must
/// not be copied or moved.
pub struct SensorMemory {
    head: Head,
    sensor: MaybeUninit<Sensor<'static>>,
    bad_pixels: MaybeUninit<Option<Defects<'static>>>,
    workspace: MaybeUninit<Workspace>,
}

/// The command link, opaque. It lies in the memory that was given to `sextant_link_init`, at its beginning;
/// it must not be copied or moved.
pub struct LinkMemory {
    head: Head,
    link: MaybeUninit<CommandLink<CAreas>>,
}

/// What a sensor is made of.
pub(crate) struct Tables {
    /// Decoded.
    pub(crate) parameters: Parameters,
    /// Opened.
    pub(crate) catalogue: Catalogue<'static>,
    /// Opened; none where the parameters name none.
    pub(crate) calibration: Option<Calibration<'static>>,
    /// Opened; none where there is none.
    pub(crate) bad_pixels: Option<Defects<'static>>,
}

impl Tables {
    /// Refuses what [`Tables::sensor`] would refuse, before any memory is touched.
    fn check(&self) -> Result<(), Status> {
        self.parameters.check().map_err(|_| Status::ParametersRange)?;
        let camera = &self.parameters.camera;
        let size_px = [camera.width_px, camera.height_px];
        if self.bad_pixels.is_some_and(|defects| defects.size_px() != size_px) {
            return Err(Status::BadPixelsMismatch);
        }
        match &self.calibration {
            Some(calibration) if !calibration_fits(&self.parameters, calibration) => {
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
        let Self { parameters, catalogue, calibration, .. } = self;
        let made = Sensor::new_in(place, catalogue, parameters, calibration, workspace);
        made.map(|_| ()).map_err(|error| match error {
            SensorError::Parameters(_) => Status::ParametersRange,
            SensorError::Calibration => Status::CalibrationMismatch,
        })
    }
}

/// Makes a sensor that knows nothing yet; one that was there is forgotten.
///
/// # Errors
/// [`Status::Busy`], and what is wrong with the tables: [`Status::ParametersRange`],
/// [`Status::CalibrationMismatch`], [`Status::BadPixelsMismatch`]. The memory then holds what it held.
///
/// # Safety
/// `memory` is aligned and memory of a [`SensorMemory`] that is used through this module alone from now on.
pub(crate) unsafe fn make(memory: *mut SensorMemory, tables: Tables) -> Result<(), Status> {
    tables.check()?;
    // SAFETY: the caller's promise; any bits are a number, and they are read and written as atomics only.
    let head = unsafe { &(*memory).head };
    let mut held = head.begin()?;
    // SAFETY: the state gives this call the memory. All zero is an empty workspace (a test compares them),
    // and the one reference to it is the sensor's.
    unsafe {
        let workspace = (&raw mut (*memory).workspace).cast::<Workspace>();
        workspace.write_bytes(0, 1);
        (*memory).bad_pixels.write(tables.bad_pixels);
        tables.write_sensor(&mut *workspace, &mut (*memory).sensor)?;
    }
    held.then = SENSOR_READY;
    Ok(())
}

/// Lends the sensor of a memory and its bad pixels for one call.
///
/// # Errors
/// [`Status::NotASensor`], [`Status::Busy`].
///
/// # Safety
/// `memory` is aligned and memory of a [`SensorMemory`], of which nothing else is used meanwhile.
pub(crate) unsafe fn with<T>(
    memory: *mut SensorMemory,
    call: impl FnOnce(&mut Sensor<'static>, Option<Defects<'static>>) -> T,
) -> Result<T, Status> {
    // SAFETY: as in `make`.
    let _held = unsafe { &(*memory).head }.hold(SENSOR_READY)?;
    // SAFETY: both were written before the state became its own, and the state gives them to this call
    // alone.
    let (sensor, bad_pixels) =
        unsafe { ((*memory).sensor.assume_init_mut(), (*memory).bad_pixels.assume_init_read()) };
    Ok(call(sensor, bad_pixels))
}

/// Makes a link; one that was there is forgotten.
///
/// # Errors
/// [`Status::Busy`]. The memory then holds what it held.
///
/// # Safety
/// `memory` is aligned and memory of a [`LinkMemory`] that is used through this module alone from now on.
pub(crate) unsafe fn make_link(memory: *mut LinkMemory, link: CommandLink<CAreas>) -> Result<(), Status> {
    // SAFETY: as in `make`.
    let mut held = unsafe { &(*memory).head }.begin()?;
    // SAFETY: the state gives this call the memory.
    unsafe { (&raw mut (*memory).link).cast::<CommandLink<CAreas>>().write(link) };
    held.then = LINK_READY;
    Ok(())
}

/// Lends the link of a memory for one call.
///
/// # Errors
/// [`Status::NotASensor`], [`Status::Busy`].
///
/// # Safety
/// `memory` is aligned and memory of a [`LinkMemory`], of which nothing else is used meanwhile.
pub(crate) unsafe fn with_link<T>(
    memory: *mut LinkMemory,
    call: impl FnOnce(&mut CommandLink<CAreas>) -> T,
) -> Result<T, Status> {
    // SAFETY: as in `make`.
    let _held = unsafe { &(*memory).head }.hold(LINK_READY)?;
    // SAFETY: a link was written before the state became its own, and the state gives it to this call alone.
    Ok(call(unsafe { (*memory).link.assume_init_mut() }))
}
