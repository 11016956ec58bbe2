//! Drivers of real parts, on the traits of `embedded-hal` 1.0: between the buses of a board and the traits of
//! `fsw-hal`.
//!
//! | module | part | trait of `fsw-hal` |
//! |---|---|---|
//! | [`cmv4000`] | detector CMV4000 of ams OSRAM | [`Detector`](fsw_hal::Detector) |
//! | [`lsm6dsv16x`] | gyro LSM6DSV16X of STMicroelectronics | [`RateSensor`](fsw_hal::RateSensor) |
//! | [`lis2mdl`] | magnetometer LIS2MDL of STMicroelectronics | [`Magnetometer`](fsw_hal::Magnetometer) |
//! | [`flash_store`] | any NOR flash on `embedded-storage` | [`StateStore`](fsw_hal::StateStore) |
//! | [`flash_areas`] | NOR flash that is mapped into the address space | [`AreaStore`](fsw_hal::AreaStore) |
//! | [`mounting`] | the rotation from a part's axes to the body's | - |
//! | [`part`] | the errors of gyro and magnetometer | - |
//! | [`pixel_port`] | what takes a detector's pixels in: a receiver with DMA, a frame memory | - |
//!
//! A driver owns its bus handle, its pins, a delay and a handle of the board's clock; who shares a bus or a
//! clock among several gives each a handle (`embedded-hal-bus`, a reference to a cell). No driver retries: a
//! failure is told at once with its kind, and the next call starts the part anew with all its registers. So a
//! part that lost them by an upset or a brown-out comes back by itself.
//!
//! All calls block, with bounded loops and without a heap, an interrupt or a panic.
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(test)]
extern crate std;

pub mod cmv4000;
pub mod flash_areas;
pub mod flash_store;
pub mod lis2mdl;
pub mod lsm6dsv16x;
#[cfg(test)]
mod mock;
pub mod mounting;
pub mod part;
pub mod pixel_port;
mod slots;

pub use cmv4000::Cmv4000;
pub use flash_areas::{AreaSlots, FlashAreas, FlashAreasError, MappedFlash, Slots};
pub use flash_store::{FlashStore, FlashStoreError};
pub use lis2mdl::Lis2mdlMagnetometer;
pub use lsm6dsv16x::Lsm6dsv16xGyro;
pub use mounting::Mounting;
pub use part::PartError;
pub use pixel_port::PixelPort;
// The drivers beneath, of the versions that are used here.
pub use {lis2mdl_rs, lsm6dsv16x_rs, st_mems_bus};
