//! The other side of the flight software's door: pictures, the synthetic world and the command line.
//!
//! | room | what it is |
//! |---|---|
//! | [`error`], [`output`] | what a user reads when something is wrong; files that are whole or marked as partial |
//! | [`cli`] | the words of the command line |
//! | [`world`] | truth, apart from the flight code: sky, optics, noise, frames |
//! | `drawing` | shapes and letters over pictures |
//! | [`formats`] | files: pictures, FITS, cameras, recorded frames, a row a second |
//! | [`calibration`], [`flight`] | calibrations, cameras and catalogues for the flight code; it with the host's memory |
//! | [`scenario`] | scenario files (TOML), and those that come with the program |
//! | [`harness`] | the flight code flown in the world, second by second, and its faults |
//! | [`judge`], [`bound`] | estimate against truth, and against the physical limit |
//! | [`report`] | a run on one page |
//! | [`serve`] | a page on which a run is flown live, or looked at |
//! | [`campaign`] | many seeded runs of one thing |
//! | [`gallery`] | the thesis's figures, ours beside the thesis's |
//! | [`commands`], [`program`] | what the commands do, a file each; the program around them |
//!
//! Pixels count x right and y down, the centre of the first pixel read is (0, 0). The sensor frame is x
//! along +x px, y along +y px, z out along the line of sight. A quaternion is `[x, y, z, w]`, scalar last,
//! and maps ICRS to sensor.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout))]

/// A line on stdout.
macro_rules! print_line {
    ($($words:tt)*) => { $crate::output::print_line(format_args!($($words)*)) };
}

pub mod bound;
pub mod calibration;
pub mod campaign;
pub mod cli;
pub mod commands;
mod drawing;
pub mod error;
pub mod flight;
pub mod formats;
pub mod gallery;
pub mod harness;
pub mod judge;
pub mod output;
pub mod program;
pub mod report;
pub mod scenario;
pub mod serve;
pub mod version;
mod words;
pub mod world;
