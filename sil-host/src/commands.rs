//! What the commands do: one file a command, each with a `run` that takes its arguments and gives the exit
//! status.
//!
//! The campaigns have a room of their own, [`crate::campaign`].

pub mod attitude;
pub mod budget;
pub mod calibrate;
pub mod centroids;
pub mod columns;
pub mod defects;
pub mod earth;
pub mod identify;
pub mod parameters;
pub mod record;
pub mod render;
pub mod run;
pub mod solve;
