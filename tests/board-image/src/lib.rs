//! Sextant on a board of one's own: an example of the whole flight software, from the drivers to a warm
//! restart, that compiles in the gate for a bare Cortex-M4F.
//!
//! | file | content |
//! |---|---|
//! | `instrument.rs` | lens, detector, gyro: its parameter table |
//! | `board.rs` | the board: replace it with yours |
//! | `flight.rs` | the sensor with its instruments, one call a second; the orbit over a restart |
//! | `bin/bare.rs` | a program without an executor, linked with `panic-never` |
//! | `bin/embassy.rs` | the flight as a task of Embassy, beside housekeeping and downlink |
//!
//! Where there is an operating system the instrument alone is there, so that the workspace builds everywhere.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
pub mod board;
#[cfg(target_os = "none")]
pub mod flight;
pub mod instrument;
